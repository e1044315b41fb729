//! Measures several rays per pixel: n x n samples, as in a picture n times as wide and high.

use stereotrace::{Error, Method, Renderer, Scene};

use crate::{
    counts::clear,
    groups::{SEED, lit},
    measure::Subject,
    options::Plan,
    rows::{Claim, Row, Setting, Values},
};
use stereotrace::scene::builtin::{Builtin, RandomObjects};

const METHODS: [Method; 3] = [Method::ADELSON_HODGES, Method::BRACKET, Method::BRACKET_RAYS];
/// Figures in the order of rows.
const FIGURES: [&str; 6] = [
    "samples traced again, %",
    "saved by rays, %",
    "primary rays a pixel and view, of n²",
    "differing pixels, %",
    "mean RGB distance of differing pixels",
    "mean RGB distance of all pixels",
];

pub(crate) fn rows(renderer: &mut Renderer, plan: &Plan) -> Result<Vec<Row>, Error> {
    let twenty = Builtin::Random20.scene();
    let mut rows = of_scene(renderer, plan, "20 objects, the first", &twenty, &plan.grids, true)?;
    if !plan.smoke {
        let both = clear(&RandomObjects::new(125, SEED).shares(0.1, 0.1).scene());
        rows.extend(of_scene(renderer, plan, "125, 10% each, clear", &both, &plan.grids[..2], false)?);
    }
    Ok(rows)
}

/// Measures a scene with one light. The paper's figures are for 20 diffuse objects and 9 rays per pixel, of which
/// neighbouring pixels share five.
fn of_scene(
    renderer: &mut Renderer,
    plan: &Plan,
    name: &str,
    scene: &Scene,
    grids: &[u32],
    diffuse: bool,
) -> Result<Vec<Row>, Error> {
    let scene = lit(scene, 1);
    let mut rows = Vec::new();
    for (e_px, side) in plan.e_px.into_iter().flat_map(|e_px| grids.iter().map(move |&side| (e_px, side))) {
        let samples = side * side;
        eprintln!("{name}: e = {e_px} px, {samples} samples a pixel");
        let camera = Builtin::Random20.camera(plan.side, plan.side).interaxial_pixels(e_px);
        let subject = Subject::new(renderer, &scene, camera, samples)?;
        for method in METHODS {
            let found = subject.figures(renderer, method)?;
            let values = [
                found.traced,
                found.rays,
                0.5 * (1.0 + found.traced / 100.0),
                found.difference.differing_percent,
                found.difference.mean_difference,
                found.distance_of_all(),
            ];
            rows.extend(FIGURES.into_iter().zip(values).enumerate().map(|(index, (figure, value))| Row {
                claim: Claim { place: "multiple rays", figure, paper: paper(index, samples, diffuse) },
                setting: Setting { scene: name.into(), e_px, lights: 1, samples, method: method.to_string() },
                values: Values::of(&[value]),
            }));
        }
    }
    rows.sort_by_key(|row| (FIGURES.iter().position(|figure| *figure == row.claim.figure), row.setting.samples));
    Ok(rows)
}

fn paper(figure: usize, samples: u32, diffuse: bool) -> &'static str {
    match (figure, samples, diffuse) {
        (0, 9, true) => "7.84",
        (1, 9, true) => "almost 80, by time",
        (2, ..) => "about 0.55",
        (3, 9, true) => "15.6",
        (4, 9, true) => "3.18",
        (5, 9, true) => "0.496 by these two",
        _ => "",
    }
}
