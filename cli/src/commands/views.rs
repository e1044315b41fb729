//! `views`: renders any number of views from left to right, or on a grid, as files or as a quilt for a light-field
//! display.

use std::{
    error::Error,
    fmt, fs,
    path::{Path, PathBuf},
    time::Instant,
};

use clap::Args;
use serde_json::{Value, json};
use stereotrace::{
    GBuffer, Method, Pose, Rig, Views,
    blocking::Wait,
    message::counted,
    metrics::compare,
    output::{Batch, quilt, quilt_name},
};

use super::{
    quilt::{Fan, QuiltArguments, count_of},
    report::{line, scene_line},
};
use crate::{
    arguments::{Global, Purpose, Stage, Subject},
    progress::Progress,
    shown,
    summary::Summary,
    target::{Target, add_picture, check_one_picture},
    truth::add_truth_of,
    usage::Usage,
};

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// Number of views. Without --cone or a quilt, neighbours are one interaxial apart [default: the number that fills
    /// the quilt, or 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    views: Option<u32>,
    /// Number of rows of views, one interaxial apart, for a grid of cameras. --views is then the number of a row's
    /// views. They are numbered from the top left
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        conflicts_with_all = ["quilt", "display", "compare"],
        value_parser = clap::value_parser!(u32).range(1..=64)
    )]
    rows: u32,
    /// Also write the ground truth of each view and the next one in its row, and the one below it, into folders such as
    /// pair_0000_0001. Pairs of an upper and a lower view are turned counterclockwise, as their pictures there are
    #[arg(long, conflicts_with_all = ["quilt", "display"])]
    ground_truth: bool,
    /// A folder, where a quilt gets the name that displays expect (NAME_qsCxRaASPECT.png); or the quilt's file
    #[arg(long, short, value_name = "FILE|DIR", default_value = "out")]
    out: PathBuf,
    /// Quality of JPEG files, 1 to 100
    #[arg(long, value_name = "Q", default_value_t = 92, value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: u8,
    /// Also render by naive, and report the views' errors relative to naive
    #[arg(long)]
    compare: bool,
    /// Films of quilts are made by `sequence`
    #[arg(long = "orbit", hide = true, value_parser = no_orbit)]
    _orbit: Option<u32>,
    #[command(flatten)]
    pub(crate) subject: Subject,
    #[command(flatten)]
    quilt: QuiltArguments,
}

fn no_orbit(count: &str) -> Result<u32, String> {
    Err(format!("use `stereotrace sequence --quilt CxR --orbit {count}`, which makes a quilt for each place"))
}

/// Default number of views.
const VIEWS: u32 = 8;

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let quilt_grid = arguments.quilt.grid();
    arguments.quilt.check(&arguments.subject)?;
    let count = count_of(quilt_grid, arguments.views, VIEWS)?;
    let target = Target::of(&arguments.out)?;
    match &target {
        Target::File(file) if arguments.ground_truth => {
            return Err(Usage(format!("{}: --ground-truth writes many files; use a folder", shown(file))).into());
        }
        Target::File(file) if quilt_grid.is_none() && count * arguments.rows > 1 => {
            return Err(Usage(format!("{}: a file holds only one view; use a folder, or a quilt", shown(file))).into());
        }
        Target::File(file) => check_one_picture(file)?,
        Target::Folder(_) => {}
    }
    let subject = arguments.quilt.sized(&arguments.subject);
    let mut stage = subject.open(Purpose::Pictures, global)?;
    let needs_ids = arguments.ground_truth || arguments.compare;
    stage.options.g_buffer = if needs_ids { GBuffer::Ids } else { GBuffer::Depth };
    let fan = arguments.quilt.fan(count, &subject, &mut stage, false)?;
    let rigs = rigs(&stage, &fan, arguments.rows)?;
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
    match (quilt_grid, &target) {
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
        (None, Target::File(file)) => {
            for view in &views.views {
                add_picture(&mut batch, file, &view.view.picture(), arguments.quality)?;
            }
        }
    }
    let files = batch.commit()?;

    let traced = |row: &Views| row.views.iter().enumerate().filter(|(index, view)| view.made_from == *index).count();
    let traced = grid.iter().map(traced).sum::<usize>();
    let count = count * arguments.rows;
    let seen = Seen::of(&grid);
    let mut text = String::new();
    line(&mut text, "adapter", stage.renderer.gpu().adapter_name())?;
    line(&mut text, "scene", scene_line(&stage))?;
    let made = format!("{}, {traced} of them traced, in {:.1} s", counted(count, "view", "views"), ms / 1e3);
    line(&mut text, "views", made)?;
    let pose = views.pose;
    seen.write(&mut text, &pose, &fan)?;
    let others = (stage.options.count && traced < count as usize).then(|| views.other_views());
    if let Some(others) = others {
        line(&mut text, "work", format!("each other view costs {others:.3} of a traced view, by counters"))?;
    }
    let mut difference = None;
    if arguments.compare {
        let truth = stage.options.clone().method(Method::Naive).count(false);
        let found =
            Compared::of(views, &stage.renderer.views(&stage.uploaded, &rigs[0]).options(&truth).read().wait()?)?;
        let Compared { mean, least, wrong } = found;
        let figures = format!("{mean:.3}% identical, {least:.3}% in the worst view; wrong surface at most {wrong:.3}%");
        line(&mut text, "to naive", figures)?;
        difference = Some(json!({
            "identical_percent": mean, "identical_percent_of_worst": least, "wrong_surface_percent_of_worst": wrong
        }));
    }
    match &*files {
        [file] => line(&mut text, "wrote", file.display())?,
        _ => line(
            &mut text,
            "wrote",
            format!("{} into {}", counted(files.len(), "file", "files"), shown(&arguments.out)),
        )?,
    }
    let json = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "adapter": stage.renderer.gpu().adapter_name(),
        "scene": stage.name,
        "views": count,
        "traced": traced,
        "ms": ms,
        "camera": {
            "size": pose.size,
            "cone_degrees": fan.cone,
            "screen_distance": pose.screen_distance,
            "interaxial": pose.interaxial,
            "interaxial_px": pose.interaxial_px,
        },
        "depth": seen.json(),
        "comfort": { "parallax_px": seen.parallax(&pose), "warnings": seen.warnings(&pose) },
        "other_views": others,
        "to_naive": difference,
        "files": Vec::from_iter(files.iter().map(|file| file.to_string_lossy())),
    });
    Ok(Summary { text, json, ..Summary::default() })
}

/// Returns the rigs of the rows, from the top down.
fn rigs(stage: &Stage, fan: &Fan, rows: u32) -> Result<Vec<Rig>, stereotrace::Error> {
    let (camera, rig) = fan.rig(stage.camera)?;
    if rows == 1 {
        return Ok(vec![rig]);
    }
    let interaxial = f64::from(camera.pose()?.interaxial);
    let height = |row: u32| (0.5 * f64::from(rows - 1) - f64::from(row)) * interaxial;
    (0..rows).map(|row| Ok(Rig::at(camera.raised(height(row))?, rig.offsets().to_vec()))).collect()
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

/// Depths of the surfaces that the views show, in world units.
#[derive(Clone, Copy, Debug)]
struct Depths {
    nearest: f32,
    /// The view that has the nearest one.
    nearest_in: usize,
    farthest: f32,
}

/// What the views show; `None` if they show only sky.
#[derive(Clone, Copy, Debug)]
struct Seen(Option<Depths>);

impl Seen {
    fn of(grid: &[Views]) -> Self {
        let views = grid.iter().flat_map(|row| &row.views).enumerate();
        let depths = views.flat_map(|(view, rendered)| rendered.view.depth.iter().map(move |&depth| (view, depth)));
        let surfaces = depths.filter(|(_, depth)| depth.is_finite());
        Self(surfaces.fold(None, |seen, (view, depth)| {
            let mut seen = seen.unwrap_or(Depths { nearest: depth, nearest_in: view, farthest: depth });
            if depth < seen.nearest {
                (seen.nearest, seen.nearest_in) = (depth, view);
            }
            seen.farthest = seen.farthest.max(depth);
            Some(seen)
        }))
    }

    /// Returns the parallax between neighbours of the nearest and of the farthest surface, in pixels.
    fn parallax(self, pose: &Pose) -> Option<[f32; 2]> {
        self.0.map(|seen| [pose.parallax_px(seen.nearest), pose.parallax_px(seen.farthest)])
    }

    fn warnings(self, pose: &Pose) -> Vec<String> {
        match self.0 {
            None => vec!["all views show only sky: check --eye and --target".into()],
            Some(Depths { nearest, nearest_in, .. })
                if pose.screen_distance.is_finite() && nearest < 0.5 * pose.screen_distance =>
            {
                let what = format!("view {nearest_in} has a surface at {nearest:.4}, nearer than half the focus");
                vec![format!("{what}: use a smaller --cone, or another --eye or --screen")]
            }
            Some(_) => Vec::new(),
        }
    }

    fn json(self) -> Value {
        self.0.map_or(Value::Null, |seen| json!({ "nearest": seen.nearest, "farthest": seen.farthest }))
    }

    /// Writes the lines of camera, depth and comfort.
    fn write(self, text: &mut String, pose: &Pose, fan: &Fan) -> fmt::Result {
        let ([width, height], e, px) = (pose.size, pose.interaxial, pose.interaxial_px);
        let cone = fan.cone.map_or(String::new(), |degrees| format!(", {degrees} degrees from first to last"));
        line(text, "camera", format!("{width}x{height}, neighbours {e:.4} apart ({px:.2} px){cone}"))?;
        line(text, "focus", focus(pose))?;
        if let (Some(seen), Some([front, back])) = (self.0, self.parallax(pose)) {
            line(text, "depth", format!("surfaces from {:.4} to {:.4}", seen.nearest, seen.farthest))?;
            let percent = 100.0 / pose.size[0] as f32;
            let (front_percent, back_percent) = (front * percent, back * percent);
            let share = format!("{front_percent:.2}% to {back_percent:.2}% of the width");
            line(text, "comfort", format!("parallax of neighbours {front:.1} to {back:.1} px ({share})"))?;
        }
        self.warnings(pose).iter().try_for_each(|warning| line(text, "warning", warning))
    }
}

/// Returns the screen's distance, and the depths at which neighbours differ by at most a pixel, so that a display shows
/// no steps.
fn focus(pose: &Pose) -> String {
    let (px, d) = (pose.interaxial_px, pose.screen_distance);
    if d.is_infinite() {
        return "the views are parallel".into();
    }
    let near = format!("{d:.4} from the eyes; sharp from {:.4}", d / (1.0 + 1.0 / px));
    if px > 1.0 { format!("{near} to {:.4}", d / (1.0 - 1.0 / px)) } else { format!("{near} on") }
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
