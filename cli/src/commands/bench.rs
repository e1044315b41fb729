//! `bench`: measures this machine's adapter with built-in scenes, and writes a report.

use std::{error::Error, fmt::Write, path::PathBuf, time::Duration};

use clap::Args;
use serde_json::{Value, json};
use stereotrace::{Report, ReportEntry, ReportPlan, blocking::Wait, message::escaped, output::Batch};

use crate::{arguments::Global, calibration, progress::Progress, shown, summary::Summary, target::make_folder};

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// Folder for bench.json and bench.html
    #[arg(long, value_name = "FOLDER", default_value = "out")]
    out: PathBuf,
    /// Time that the report may take; larger sizes are left out if they would exceed it
    #[arg(long, value_name = "SECONDS", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=86400))]
    seconds: u32,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let folder = &arguments.out;
    make_folder(folder)?;
    let gpu = global.gpu()?;
    let mut plan = ReportPlan::default();
    plan.most = Duration::from_secs(arguments.seconds.into());
    let mut progress = Progress::new(global, 1);
    let report = Report::measure(&gpu, &plan, &mut |done| progress.show(done)).wait()?;
    progress.clear();
    if global.calibrate {
        calibration::keep_for(&gpu, report.calibration);
    }

    let mut files = Batch::new();
    files.add(folder.join("bench.json"), report.to_json().as_bytes())?;
    files.add(folder.join("bench.html"), report.to_html().as_bytes())?;
    let written = files.commit()?;

    let faults = report.faults();
    let mut json: Value = serde_json::from_str(&report.to_json())?;
    json["files"] = json!(written);
    let text = table(&report, &written)?;
    Ok(Summary { text, json, has_failed: !faults.is_empty(), ..Summary::default() })
}

/// Returns the methods' figures for each scene at its largest size.
fn table(report: &Report, written: &[PathBuf]) -> Result<String, std::fmt::Error> {
    let mut text = format!("adapter    {}\ndriver     {}\n", escaped(&report.adapter), escaped(&report.driver));
    writeln!(text, "first      {:.0} ms to the first picture, with its kernels", ms(report.first_picture))?;
    let is_largest = |entry: &&ReportEntry| {
        let of_scene = report.entries.iter().filter(|other| other.scene == entry.scene);
        of_scene.map(|other| other.size).max() == Some(entry.size)
    };
    for entry in report.entries.iter().filter(is_largest) {
        let [width, height] = entry.size;
        let title = format!("{}, {width}x{height}", entry.scene);
        let [ms_head, eye, traced, identical, wrong] = ["pair, ms", "2nd eye", "traced", "identical", "wrong"];
        writeln!(text, "\n{title:<28}{ms_head:>10}{eye:>9}{traced:>9}{identical:>11}{wrong:>9}")?;
        for row in &entry.methods {
            let chosen = row.chosen.map_or(String::new(), |method| format!(" ({method})"));
            let name = format!("{}{chosen}", row.method);
            // The percentage is rounded down, so that 100.00% means that all pixels are identical.
            let identical = (100.0 * row.identical_percent).floor() / 100.0;
            writeln!(
                text,
                "{name:<28}{:>10.2}{:>9.3}{:>8.1}%{identical:>10.2}%{:>8.3}%",
                ms(row.pair),
                row.second_eye,
                100.0 * row.retraced,
                row.wrong_surface_percent
            )?;
        }
    }
    let left_out = report.left_out.iter().map(|(scene, [width, height])| format!("{scene} at {width}x{height}"));
    let left_out = Vec::from_iter(left_out);
    writeln!(text)?;
    if !left_out.is_empty() {
        writeln!(text, "left out   {} (see --seconds)", left_out.join(", "))?;
    }
    for fault in report.faults() {
        writeln!(text, "wrong      {fault}")?;
    }
    for path in written {
        writeln!(text, "wrote      {}", shown(path))?;
    }
    Ok(text)
}

fn ms(time: Duration) -> f64 {
    1e3 * time.as_secs_f64()
}
