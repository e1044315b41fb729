//! `views`: renders any number of views from left to right, as files or as a quilt for a light-field display.

use std::{error::Error, fmt::Write, path::PathBuf, time::Instant};

use clap::Args;
use serde_json::json;
use stereotrace::{
    Method, Rig, Views,
    blocking::Wait,
    message::counted,
    metrics::compare,
    output::{Batch, quilt, quilt_name},
};

use crate::{
    arguments::{Global, Purpose, Subject, size},
    progress::Progress,
    shown,
    summary::Summary,
    target::{Target, add_picture},
};

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// Number of views. Neighbours are one interaxial apart [default: the number that fills the quilt, or 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    views: Option<u32>,
    /// Write a quilt for light-field displays: one picture of C columns and R rows, with the first view at the bottom
    /// left
    #[arg(long, value_name = "CxR", value_parser = size, allow_hyphen_values = true)]
    quilt: Option<[u32; 2]>,
    /// A folder, where a quilt gets the name that displays expect (NAME_qsCxRaASPECT.png); or the quilt's file
    #[arg(long, short, value_name = "FILE|DIR", default_value = "out")]
    out: PathBuf,
    /// Quality of JPEG files, 1 to 100
    #[arg(long, value_name = "Q", default_value_t = 92, value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: u8,
    /// Also render by naive, and report the views' errors relative to naive
    #[arg(long)]
    compare: bool,
    #[command(flatten)]
    subject: Subject,
}

/// Default number of views.
const VIEWS: u32 = 8;

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let count = count(arguments)?;
    let target = Target::of(&arguments.out)?;
    let mut stage = arguments.subject.open(Purpose::Pictures, global)?;
    let rig = Rig::row(stage.camera, count as usize);
    let begin = Instant::now();
    let mut progress = Progress::new(global, 1);
    let mut show = |now| progress.show(now);
    let views = stage.renderer.views(&stage.uploaded, &rig).options(&stage.options).progress(&mut show).read().wait();
    progress.clear();
    let views = views?;
    let ms = begin.elapsed().as_secs_f64() * 1e3;

    let mut batch = Batch::new();
    match (arguments.quilt, &target) {
        (Some([columns, rows]), Target::Folder(folder)) => {
            let name = quilt_name(&stage.name, &views, columns, rows);
            batch.add_png(folder.join(name), &quilt(&views, columns, rows)?)?;
        }
        (Some([columns, rows]), Target::File(file)) => {
            add_picture(&mut batch, file, &quilt(&views, columns, rows)?, arguments.quality)?
        }
        (None, Target::Folder(folder)) => {
            for (index, view) in views.views.iter().enumerate() {
                batch.add_png(folder.join(format!("view_{index:04}.png")), &view.view.picture())?;
            }
        }
        (None, Target::File(file)) => match &*views.views {
            [only] => add_picture(&mut batch, file, &only.view.picture(), arguments.quality)?,
            _ => {
                return Err(format!("{}: a file holds only one view; use a folder, or --quilt CxR", shown(file)).into());
            }
        },
    }
    let files = batch.commit()?;

    let traced = views.views.iter().enumerate().filter(|(index, view)| view.made_from == *index).count();
    let written = match &*files {
        [file] => shown(file),
        _ => format!("{} of {}", counted(files.len(), "file", "files"), shown(&arguments.out)),
    };
    let mut text = format!("{} of which {traced} traced, in {written}: {ms:.1} ms\n", counted(count, "view", "views"));
    let others = (stage.options.count && traced < views.views.len()).then(|| views.other_views());
    if let Some(others) = others {
        writeln!(text, "each other view costs {others:.3} of a traced view, by counters")?;
    }
    let mut difference = None;
    if arguments.compare {
        let truth = stage.options.clone().method(Method::Naive).count(false);
        let found = Compared::of(&views, &stage.renderer.views(&stage.uploaded, &rig).options(&truth).read().wait()?)?;
        let Compared { mean, least, wrong } = found;
        writeln!(
            text,
            "against naive: {mean:.3}% identical, {least:.3}% in the worst view; wrong surface at most {wrong:.3}%"
        )?;
        difference = Some(json!({
            "identical_percent": mean, "identical_percent_of_worst": least, "wrong_surface_percent_of_worst": wrong
        }));
    }
    let json = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "adapter": stage.renderer.gpu().adapter_name(),
        "scene": stage.name,
        "views": count,
        "traced": traced,
        "ms": ms,
        "other_views": others,
        "to_naive": difference,
        "files": Vec::from_iter(files.iter().map(|file| file.to_string_lossy())),
    });
    Ok(Summary { text, json, ..Summary::default() })
}

/// Returns the number of views.
///
/// # Errors
/// Fails if the number does not fill the quilt, or a quilt has more than 1024 views.
fn count(arguments: &Arguments) -> Result<u32, String> {
    let Some([columns, rows]) = arguments.quilt else { return Ok(arguments.views.unwrap_or(VIEWS)) };
    let places = columns.checked_mul(rows).filter(|places| (1..=1024).contains(places));
    let places = places.ok_or(format!("a quilt of {columns}x{rows}: it must have 1 to 1024 views"))?;
    match arguments.views {
        Some(count) if count != places => {
            Err(format!("a quilt of {columns}x{rows} is not filled by {}", counted(count, "view", "views")))
        }
        _ => Ok(places),
    }
}

/// Difference between the views and the views of `naive`.
struct Compared {
    /// Mean percentage of pixels with the same colour, over all views; `least` is the percentage of the worst view.
    mean: f64,
    least: f64,
    /// Percentage of pixels that show another surface, in the worst view.
    wrong: f64,
}

impl Compared {
    fn of(views: &Views, naive: &Views) -> Result<Self, stereotrace::Error> {
        let mut all = Self { mean: 0.0, least: 100.0, wrong: 0.0 };
        for (view, truth) in views.views.iter().zip(&naive.views) {
            let difference = compare(&view.view, &truth.view, &views.pose)?;
            all.mean += difference.identical_percent / views.views.len() as f64;
            all.least = all.least.min(difference.identical_percent);
            all.wrong = all.wrong.max(difference.wrong_surface_percent);
        }
        Ok(all)
    }
}
