//! The files that are written: results.csv, results.json and chart.svg.

use std::{
    error::Error,
    fs,
    path::{Path, PathBuf},
    process::Command,
    time::{SystemTime, UNIX_EPOCH},
};

use serde_json::{Value, json};
use stereotrace::Gpu;

use crate::{
    chart,
    measure::{Measured, MethodFigures},
    options::Plan,
};

/// Where and when figures were taken.
pub(crate) struct Provenance {
    pub(crate) adapter: String,
    pub(crate) driver: String,
    /// Of the source, or "unknown".
    commit: String,
    /// UTC, as 2012-06-30T23:59:59Z.
    date: String,
}

impl Provenance {
    pub(crate) fn of(gpu: &Gpu) -> Self {
        let git = Command::new("git").args(["rev-parse", "HEAD"]).current_dir(env!("CARGO_MANIFEST_DIR")).output();
        let commit = git.ok().filter(|output| output.status.success());
        let commit = commit.and_then(|output| String::from_utf8(output.stdout).ok());
        let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        Self {
            adapter: gpu.adapter_name(),
            driver: gpu.driver(),
            commit: commit.map_or("unknown".into(), |commit| commit.trim().to_owned()),
            date: utc(seconds),
        }
    }

    /// The date without the time.
    pub(crate) fn day(&self) -> &str {
        self.date.split('T').next().unwrap_or(&self.date)
    }
}

/// Writes the three files and returns their paths. All are made before the first is written.
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
        ("results.csv", csv(&records)),
        ("results.json", json(&records)),
        ("chart.svg", chart::svg(measured, plan, provenance)?),
    ];
    let at = |path: &Path, error: std::io::Error| format!("{}: {error}", path.display());
    fs::create_dir_all(folder).map_err(|error| at(folder, error))?;
    let paths = files.map(|(name, text)| {
        let path = folder.join(name);
        let partial = folder.join(format!(".{name}.partial"));
        let written = fs::write(&partial, text).and_then(|()| fs::rename(&partial, &path));
        written.map_err(|error| at(&path, error)).map(|()| path)
    });
    Ok(paths.into_iter().collect::<Result<_, _>>()?)
}

/// Names and values of one method on one scene. Counts and rays are of both eyes.
type Record = Vec<(&'static str, Value)>;

fn record(scene: &Measured, figures: &MethodFigures, plan: &Plan, provenance: &Provenance) -> Record {
    let (statistics, difference) = (&figures.statistics, &figures.difference);
    let (left, right) = (&statistics.left, &statistics.right);
    let pixels = f64::from(plan.size[0]) * f64::from(plan.size[1]);
    vec![
        ("scene", json!(scene.scene)),
        ("method", json!(figures.method.to_string())),
        ("width", json!(plan.size[0])),
        ("height", json!(plan.size[1])),
        ("e_px", json!(plan.e_px)),
        ("lights", json!(scene.lights)),
        ("triangles", json!(scene.triangles)),
        ("spheres", json!(scene.spheres)),
        ("rounds", json!(plan.rounds)),
        ("left_ms", json!(figures.left_ms)),
        ("pair_ms", json!(figures.pair_ms.median)),
        ("pair_ms_min", json!(figures.pair_ms.min)),
        ("pair_ms_max", json!(figures.pair_ms.max)),
        ("pair_wall_ms", json!(figures.wall_ms)),
        ("second_eye", json!(figures.second_eye)),
        ("second_eye_counters", json!(figures.second_eye_counters())),
        ("speed_up", json!(figures.speed_up)),
        ("speed_up_predicted", json!(figures.speed_up_predicted())),
        ("identical", json!(difference.identical_percent)),
        ("differing", json!(difference.differing_percent)),
        ("wrong_surface", json!(difference.wrong_surface_percent)),
        ("mean_difference", json!(difference.mean_difference)),
        ("mse", json!(difference.mse)),
        ("psnr", json!(difference.psnr)), // null where infinite: the pictures are the same
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
        ("primary_mrays_per_s", json!(scene.primary.device)),
        ("primary_mrays_per_s_obvhs", json!(scene.primary.obvhs)),
        ("adapter", json!(provenance.adapter)),
        ("driver", json!(provenance.driver)),
        ("commit", json!(provenance.commit)),
        ("date", json!(provenance.date)),
    ]
}

fn csv(records: &[Record]) -> String {
    let line = |cells: Vec<String>| cells.join(",") + "\n";
    let head = records.iter().take(1).map(|record| record.iter().map(|(name, _)| (*name).to_owned()).collect());
    let rows = records.iter().map(|record| {
        let cells = record.iter().map(|(_, value)| match value {
            Value::Null => String::new(),
            Value::String(text) => format!("\"{}\"", text.replace('"', "\"\"")),
            number => number.to_string(),
        });
        cells.collect()
    });
    head.chain(rows).map(line).collect()
}

/// A record a line, its fields in the order of `record`.
fn json(records: &[Record]) -> String {
    let object = |record: &Record| {
        let fields = record.iter().map(|(name, value)| format!("\"{name}\": {value}"));
        format!("  {{ {} }}", fields.collect::<Vec<_>>().join(", "))
    };
    format!("[\n{}\n]\n", records.iter().map(object).collect::<Vec<_>>().join(",\n"))
}

/// Seconds since 1970 as a date, after Hinnant's `civil_from_days`.
fn utc(seconds: u64) -> String {
    let (days, time) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    // Years begin in March here, so that the leap day is their last.
    let march_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * march_month + 2) / 5 + 1;
    let month = if march_month < 10 { march_month + 3 } else { march_month - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}Z", time / 3600, time / 60 % 60, time % 60)
}
