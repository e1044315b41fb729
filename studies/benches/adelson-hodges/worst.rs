//! Renders the paper's worst cases and scenes in which its method fails, and calculates its table 4.

use stereotrace::{Error, Method, Renderer, testing::suite::Trial};

use crate::{
    closed::{Levels, Surfaces},
    counts::LEVELS,
    measure::Subject,
    options::Plan,
    panes,
    quanta::quanta,
    rows::{Claim, Row, Setting, Values},
};

/// Number of lights on either side of the panes.
const LIGHTS: usize = 2;

pub(crate) fn rows(renderer: &mut Renderer, plan: &Plan) -> Result<Vec<Row>, Error> {
    let mut rows = cases(renderer, plan)?;
    rows.extend(failures(renderer, plan)?);
    rows.extend(table_4(plan));
    Ok(rows)
}

/// Measures saved rays, in percent of 1 - M, in scenes where each ray follows the worst case down to the last level.
fn cases(renderer: &mut Renderer, plan: &Plan) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    let levels = Levels { hit: LEVELS, most: LEVELS };
    for (surfaces, e_px) in Surfaces::ALL.into_iter().flat_map(|surfaces| plan.e_px.map(|e_px| (surfaces, e_px))) {
        let scene = panes::scene(surfaces, LIGHTS);
        let camera = panes::camera(plan.side, e_px);
        let subject = Subject::new(renderer, &scene, camera, 1)?;
        let found = subject.figures(renderer, Method::ADELSON_HODGES)?;
        let of_kept = 1.0 - found.traced / 100.0;
        let closed = 100.0 * surfaces.saved_in_closed_form(levels, LIGHTS as u64);
        let row = |figure, method: &str, value: f64| Row {
            claim: Claim { place: "worst cases, L = 5", figure, paper: surfaces.paper() },
            setting: Setting {
                scene: format!("panes: {}", surfaces.name()),
                e_px,
                lights: if surfaces.is_diffuse() { LIGHTS } else { 0 },
                samples: 1,
                method: method.into(),
            },
            values: Values::of(&[value]),
        };
        let of_rays = "saved by rays, as the paper counts them, % of 1 - M";
        rows.push(row(of_rays, "counted level by level", 100.0 * surfaces.saved(levels, LIGHTS as u64)));
        rows.push(row(of_rays, "closed form", closed));
        rows.push(row(of_rays, "adelson-hodges", found.rays_as_in_the_paper / of_kept));
        rows.push(row("saved by rays, % of 1 - M", "adelson-hodges", found.rays / of_kept));
    }
    rows.sort_by_key(|row| row.claim.figure);
    Ok(rows)
}

/// Measures the scene of the paper's figure 14, and a scene with a wall between the eyes.
fn failures(renderer: &mut Renderer, plan: &Plan) -> Result<Vec<Row>, Error> {
    let wings = Claim {
        place: "figure 14",
        figure: "pixels that show what is behind, or beside, %",
        paper: "\"the case where the algorithm fails\"",
    };
    let saved = |figure| Claim { place: "worst cases", figure, paper: "at least 0: never dearer than two passes" };
    let mut rows = Vec::new();
    for (trial, e_px) in [Trial::Wings, Trial::Septum].into_iter().flat_map(|trial| plan.e_px.map(|e_px| (trial, e_px)))
    {
        let scene = trial.scene();
        let camera = trial.camera(plan.side, plan.side).interaxial_pixels(e_px);
        let subject = Subject::new(renderer, &scene, camera, 1)?;
        for method in [Method::ADELSON_HODGES, Method::ATOMIC, Method::BRACKET] {
            let found = subject.figures(renderer, method)?;
            let figures = match trial {
                Trial::Wings => vec![(wings, found.difference.wrong_surface_percent)],
                _ => vec![
                    (saved("saved by rays, %"), found.rays),
                    (saved("saved by nodes and primitive tests, %"), found.counters),
                ],
            };
            rows.extend(figures.into_iter().map(|(claim, value)| Row {
                claim,
                setting: Setting {
                    scene: trial.to_string(),
                    e_px,
                    lights: scene.lights.len(),
                    samples: 1,
                    method: method.to_string(),
                },
                values: Values::of(&[value]),
            }));
        }
    }
    rows.sort_by_key(|row| row.claim.figure);
    Ok(rows)
}

/// Returns depths behind the screen, in screen distances. Each is the depth from which on points move by a number of
/// pixels.
fn table_4(plan: &Plan) -> Vec<Row> {
    let of = |e_px: f32| {
        let behind = quanta(f64::from(e_px)).into_iter().filter(|quantum| quantum.to > 0.0);
        behind.map(move |quantum| Row {
            claim: Claim {
                place: "table 4",
                figure: "depth z / d from which on pixels move so far",
                paper: "not in the text",
            },
            setting: Setting {
                scene: format!("{} px", quantum.pixels),
                e_px,
                lights: 0,
                samples: 1,
                method: "equation 7".into(),
            },
            values: Values::of(&[quantum.from]),
        })
    };
    plan.e_px.into_iter().flat_map(of).collect()
}
