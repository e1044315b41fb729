//! Measures random scenes with one ray per pixel.

use stereotrace::{Error, Method, Renderer};

use crate::{
    groups::{self, Group, lit},
    measure::{Figures, Subject},
    options::Plan,
    rows::{Claim, Row, Setting, Values},
};

pub(crate) const TRACED: &str = "right pixels traced again, %";
pub(crate) const LEFT_EDGE: &str = "of these at the left edge, % of the picture";
pub(crate) const PAPER_RAYS: &str = "saved by rays, as the paper counts them, %";
pub(crate) const DIFFERING: &str = "differing pixels, %";
pub(crate) const DISTANCE: &str = "mean RGB distance of differing pixels";
pub(crate) const DISTANCE_OF_ALL: &str = "mean RGB distance of all pixels";
pub(crate) const WRONG: &str = "bad pixels: another surface, %";

const SAVING: &[Method] = &[Method::ADELSON_HODGES, Method::ATOMIC, Method::BRACKET];
const EXACT: &[Method] = &[Method::ADELSON_HODGES, Method::BRACKET, Method::BRACKET_RAYS];
const ITS_OWN: &[Method] = &[Method::ADELSON_HODGES];
const ALL: [Method; 4] = [Method::ADELSON_HODGES, Method::ATOMIC, Method::BRACKET, Method::BRACKET_RAYS];

/// A figure, the methods it is shown for, and the function that returns its value.
type Line = (&'static str, &'static [Method], fn(&Figures) -> f64);
const LINES: [Line; 11] = [
    (TRACED, SAVING, |found| found.traced),
    (LEFT_EDGE, ITS_OWN, |found| found.left_edge),
    (PAPER_RAYS, ITS_OWN, |found| found.rays_as_in_the_paper),
    ("saved by rays, %", SAVING, |found| found.rays),
    ("saved by nodes and primitive tests, %", SAVING, |found| found.counters),
    (DIFFERING, EXACT, |found| found.difference.differing_percent),
    (DISTANCE, EXACT, |found| found.difference.mean_difference),
    (DISTANCE_OF_ALL, EXACT, Figures::distance_of_all),
    ("share of all distances that lies on glass, %", ITS_OWN, |found| found.on_glass),
    ("share of all distances on another object's pixels, %", ITS_OWN, |found| found.on_others),
    (WRONG, EXACT, |found| found.difference.wrong_surface_percent),
];

pub(crate) fn rows(renderer: &mut Renderer, plan: &Plan) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for group in groups::of(plan) {
        let mut of_group = Vec::new();
        for (e_px, &lights) in plan.e_px.iter().flat_map(|e_px| plan.lights.iter().map(move |count| (*e_px, count))) {
            eprintln!("{}: e = {e_px} px, {lights} of its lights", group.name);
            of_group.extend(measure(renderer, &group, plan.side, e_px, lights)?);
        }
        // Rows of one figure are adjacent.
        of_group.sort_by_key(|row: &Row| LINES.iter().position(|(figure, ..)| *figure == row.claim.figure));
        rows.extend(of_group);
    }
    Ok(rows)
}

fn measure(renderer: &mut Renderer, group: &Group, side: u32, e_px: f32, lights: usize) -> Result<Vec<Row>, Error> {
    let camera = group.camera.size(side, side).interaxial_pixels(e_px);
    let mut figures: Vec<Vec<Figures>> = vec![Vec::new(); ALL.len()];
    for scene in &group.scenes {
        let scene = lit(scene, lights);
        let subject = Subject::new(renderer, &scene, camera, 1)?;
        for (&method, figures) in ALL.iter().zip(&mut figures) {
            figures.push(subject.figures(renderer, method)?);
        }
    }
    let row = |(figure, methods, value): Line| {
        let paper = group.paper.iter().find(|(of, _)| *of == figure).map_or("", |(_, says)| *says);
        let claim = Claim { place: group.place, figure, paper };
        let shown = ALL.iter().zip(&figures).filter(move |(method, _)| methods.contains(method));
        shown.map(move |(method, figures)| {
            let values = Values::of(&figures.iter().map(value).collect::<Vec<_>>());
            let method = method.to_string();
            Row { claim, setting: Setting { scene: group.name.into(), e_px, lights, samples: 1, method }, values }
        })
    };
    Ok(LINES.into_iter().flat_map(row).collect())
}
