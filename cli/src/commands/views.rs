//! `views`: renders any number of views from left to right, or on a grid, as files or as a quilt for a light-field
//! display.

use std::{
    error::Error,
    fmt::Write,
    fs,
    path::{Path, PathBuf},
    time::Instant,
};

use clap::Args;
use serde_json::json;
use stereotrace::{
    GBuffer, Method, Rig, Views,
    blocking::Wait,
    message::counted,
    metrics::compare,
    output::{Batch, quilt, quilt_name},
};

use crate::{
    arguments::{Global, Purpose, Stage, Subject, size},
    progress::Progress,
    shown,
    summary::Summary,
    target::{Target, add_picture},
    truth::add_truth_of,
};

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// Number of views. Neighbours are one interaxial apart [default: the number that fills the quilt, or 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    views: Option<u32>,
    /// Number of rows of views, one interaxial apart, for a grid of cameras. --views is then the number of a row's
    /// views. They are numbered from the top left
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        conflicts_with_all = ["quilt", "compare"],
        value_parser = clap::value_parser!(u32).range(1..=64)
    )]
    rows: u32,
    /// Also write the ground truth of each view and the next one in its row, and the one below it, into folders such as
    /// pair_0000_0001. Pairs of an upper and a lower view are turned counterclockwise, as their pictures there are
    #[arg(long, conflicts_with = "quilt")]
    ground_truth: bool,
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
    if arguments.ground_truth {
        if let Target::File(file) = &target {
            return Err(format!("{}: --ground-truth writes many files; use a folder", shown(file)).into());
        }
        stage.options.g_buffer = GBuffer::Ids;
    }
    let rigs = rigs(&stage, (count, arguments.rows))?;
    let begin = Instant::now();
    let mut progress = Progress::new(global, arguments.rows);
    let mut grid = Vec::new();
    for rig in &rigs {
        let mut show = |now| progress.show(now);
        let row = stage.renderer.views(&stage.uploaded, rig).options(&stage.options).progress(&mut show).read().wait();
        grid.push(row.inspect_err(|_| progress.clear())?);
        progress.next();
    }
    progress.clear();
    let ms = begin.elapsed().as_secs_f64() * 1e3;
    let Some(views) = grid.first() else { unreachable!("there is a row") };

    let mut batch = Batch::new();
    if let (true, Target::Folder(folder)) = (arguments.ground_truth, &target) {
        add_pairs(&mut batch, &stage, &grid, folder)?;
    }
    match (arguments.quilt, &target) {
        (Some([columns, rows]), Target::Folder(folder)) => {
            let name = quilt_name(&stage.name, views, columns, rows);
            batch.add_png(folder.join(name), &quilt(views, columns, rows)?)?;
        }
        (Some([columns, rows]), Target::File(file)) => {
            add_picture(&mut batch, file, &quilt(views, columns, rows)?, arguments.quality)?
        }
        (None, Target::Folder(folder)) => {
            for (index, view) in grid.iter().flat_map(|row| &row.views).enumerate() {
                batch.add_png(folder.join(format!("view_{index:04}.png")), &view.view.picture())?;
            }
        }
        (None, Target::File(file)) => match &*views.views {
            [only] if grid.len() == 1 => add_picture(&mut batch, file, &only.view.picture(), arguments.quality)?,
            _ => {
                return Err(format!("{}: a file holds only one view; use a folder, or --quilt CxR", shown(file)).into());
            }
        },
    }
    let files = batch.commit()?;

    let traced = |row: &Views| row.views.iter().enumerate().filter(|(index, view)| view.made_from == *index).count();
    let traced = grid.iter().map(traced).sum::<usize>();
    let count = count * arguments.rows;
    let written = match &*files {
        [file] => shown(file),
        _ => format!("{} of {}", counted(files.len(), "file", "files"), shown(&arguments.out)),
    };
    let mut text = format!("{} of which {traced} traced, in {written}: {ms:.1} ms\n", counted(count, "view", "views"));
    let others = (stage.options.count && traced < count as usize).then(|| views.other_views());
    if let Some(others) = others {
        writeln!(text, "each other view costs {others:.3} of a traced view, by counters")?;
    }
    let mut difference = None;
    if arguments.compare {
        let truth = stage.options.clone().method(Method::Naive).count(false);
        let found =
            Compared::of(views, &stage.renderer.views(&stage.uploaded, &rigs[0]).options(&truth).read().wait()?)?;
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

/// Returns the rigs of the rows, from the top down.
fn rigs(stage: &Stage, (count, rows): (u32, u32)) -> Result<Vec<Rig>, stereotrace::Error> {
    if rows == 1 {
        return Ok(vec![Rig::row(stage.camera, count as usize)]);
    }
    let interaxial = f64::from(stage.camera.pose()?.interaxial);
    let height = |row: u32| (0.5 * f64::from(rows - 1) - f64::from(row)) * interaxial;
    (0..rows).map(|row| Ok(Rig::row(stage.camera.raised(height(row))?, count as usize))).collect()
}

/// Adds the ground truth of neighbours, with their pictures.
fn add_pairs(batch: &mut Batch, stage: &Stage, grid: &[Views], folder: &Path) -> Result<(), Box<dyn Error>> {
    let columns = grid.first().map_or(0, |row| row.views.len());
    for (row, views) in grid.iter().enumerate() {
        for column in 0..columns {
            let number = row * columns + column;
            let beside = (column + 1 < columns).then(|| (number + 1, views.pair(column, column + 1)));
            let below = grid.get(row + 1).map(|lower| (number + columns, views.pair_below(column, (lower, column))));
            for (other, pair) in beside.into_iter().chain(below) {
                let (pair, folder) = (pair?, folder.join(format!("pair_{number:04}_{other:04}")));
                fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", shown(&folder)))?;
                for (eye, view) in [&pair.left, &pair.right].into_iter().enumerate() {
                    batch.add_png(folder.join(format!("im{eye}.png")), &view.picture())?;
                }
                add_truth_of(batch, stage, &pair, &folder)?;
            }
        }
    }
    Ok(())
}

/// Returns the number of views of a row.
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
