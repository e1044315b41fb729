//! Writes the result files: results.csv, results.json and chart.svg.

use std::{
    error::Error,
    path::{Path, PathBuf},
};

use serde_json::json;

use crate::{
    chart,
    common::{
        files::save,
        measure::{Measured, MethodFigures, Plan},
        provenance::Provenance,
        records::{self, Record},
    },
};

/// Writes the three files and returns their paths. All contents are made before the first file is written.
pub(crate) fn write_all(
    folder: &Path,
    measured: &[Measured],
    plan: &Plan,
    provenance: &Provenance,
) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let records: Vec<Record> = measured
        .iter()
        .flat_map(|scene| scene.methods.iter().map(|figures| record(scene, figures, plan, provenance)))
        .collect();
    let files = [
        ("results.csv", records::csv(&records)),
        ("results.json", records::json(&records)),
        ("chart.svg", chart::svg(measured, plan, provenance)?),
    ];
    save(&files.map(|(name, text)| (name.to_owned(), text)), folder)
}

/// Returns the record of one method on one scene. Counts and rays are summed over both eyes.
fn record(scene: &Measured, figures: &MethodFigures, plan: &Plan, provenance: &Provenance) -> Record {
    let (statistics, difference) = (&figures.statistics, &figures.difference);
    let (left, right) = (&statistics.left, &statistics.right);
    let pixels = f64::from(plan.size[0]) * f64::from(plan.size[1]);
    vec![
        ("scene", json!(scene.scene)),
        ("method", json!(figures.method.to_string())),
        ("width", json!(plan.size[0])),
        ("height", json!(plan.size[1])),
        ("e_px", json!((!plan.around).then_some(plan.e_px))),
        ("lights", json!(scene.lights)),
        ("rays_to_a_light", json!(plan.sampled.soft)),
        ("paths", json!(plan.sampled.paths)),
        ("triangles", json!(scene.triangles)),
        ("spheres", json!(scene.spheres)),
        ("rounds", json!(plan.rounds)),
        ("left_ms", json!(figures.left_ms)),
        ("pair_ms", json!(figures.pair_ms.median)),
        ("pair_ms_min", json!(figures.pair_ms.min)),
        ("pair_ms_max", json!(figures.pair_ms.max)),
        ("pair_wall_ms", json!(figures.wall_ms)),
        ("passes_ms", json!(passes(figures))),
        ("second_eye", json!(figures.second_eye.median)),
        ("second_eye_min", json!(figures.second_eye.min)),
        ("second_eye_max", json!(figures.second_eye.max)),
        ("second_eye_counters", json!(figures.second_eye_counters())),
        ("speed_up", json!(figures.speed_up)),
        ("speed_up_predicted", json!(figures.speed_up_predicted())),
        ("identical", json!(difference.identical_percent)),
        ("differing", json!(difference.differing_percent)),
        ("wrong_surface", json!(difference.wrong_surface_percent)),
        ("surface", json!(difference.surface_percent)),
        ("identical_of_surfaces", json!(difference.identical_of_surfaces_percent)),
        ("wrong_of_surfaces", json!(difference.wrong_of_surfaces_percent)),
        ("mean_difference", json!(difference.mean_difference)),
        ("mse", json!(difference.mse)),
        ("psnr", json!(difference.psnr)), // null if infinite: the pictures are equal
        ("rays_primary", json!(left.rays.primary + right.rays.primary)),
        ("rays_verification", json!(left.rays.verification + right.rays.verification)),
        ("rays_shadow", json!(left.rays.shadow + right.rays.shadow)),
        ("nodes", json!(left.nodes + right.nodes)),
        ("primitive_tests", json!(left.primitive_tests + right.primitive_tests)),
        ("retraced", json!(statistics.retraced_share())),
        ("bad", json!(statistics.bad)),
        ("missed", json!(statistics.missed)),
        ("lost_candidates", json!(statistics.lost_candidates)),
        ("buffer_depth", json!(statistics.buffer_depth)),
        ("intermediate_bytes_per_pixel", json!(statistics.intermediate_bytes as f64 / pixels)),
        ("adapter", json!(provenance.adapter)),
        ("driver", json!(provenance.driver)),
        ("commit", json!(provenance.commit)),
        ("date", json!(provenance.date)),
    ]
}

/// Formats the passes as `trace_left 12.3; reproject 0.4`.
fn passes(figures: &MethodFigures) -> String {
    figures.passes.iter().map(|(name, ms)| format!("{name} {ms:.3}")).collect::<Vec<_>>().join("; ")
}
