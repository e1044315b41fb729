//! `render`: renders one stereo pair.

use std::{
    error::Error,
    ops::ControlFlow,
    path::{Path, PathBuf},
    thread,
    time::{Duration, Instant, SystemTime},
};

use clap::Args;
use stereotrace::{
    GBuffer, Layering, Lighting, Method, Options, Projection, StereoPair,
    blocking::Wait,
    metrics::{Difference, compare},
    output::Batch,
};

use super::report::{Report, WallTimes};
use crate::{
    arguments::{Global, Purpose, Stage, Subject, above_zero},
    pictures::Pictures,
    progress::Progress,
    stop::{Interrupted, Stop},
    summary::Summary,
    target::{EyesArguments, Target, add_pair, is_open_exr, is_single_picture},
    truth::{add_layers, add_truth_of, layering},
    usage::Usage,
};

/// Interval at which --watch checks the files.
const GLANCE: Duration = Duration::from_millis(250);

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// Picture to write, .png or .jpg, or a folder for the left view, the right view and all other files
    ///
    /// A .png or .jpg file holds the anaglyph or the --packing. A .jps, .mpo or .exr file holds both views, and so does
    /// a .vr.jpg file with --projection 360 or 180.
    #[arg(long, short, value_name = "FILE|DIR", default_value = "out")]
    out: PathBuf,
    /// Also render by naive, and report the right eye's errors relative to naive
    #[arg(long)]
    compare: bool,
    /// Also print how the right eye was made, and the time and rays that this took
    #[arg(long)]
    pub(super) stats: bool,
    /// Write depths and primitive ids of both eyes (PFM), the right eye's re-trace map, its shadow map if a bracket
    /// method made it, and the cost of each pixel (PNG). --out must be a folder
    #[arg(long)]
    dump: bool,
    /// Write ground truth for stereo vision: disparity, occlusion, depth, distance, normals, ids and calibration. --out
    /// must be a folder
    #[arg(long)]
    ground_truth: bool,
    /// Write ground truth of all surfaces along each pixel's line of sight, through glass, veils and holes: at most
    /// SURFACES, 1 to 32. With :refracted glass bends the lines, with :mirrored mirrors reflect them. --out must be a
    /// folder
    #[arg(long, value_name = "SURFACES[:refracted][:mirrored]", value_parser = layering)]
    layers: Option<Layering>,
    /// Render again whenever an input file changes, until interrupted
    #[arg(long)]
    watch: bool,
    /// Width in metres of the display that comfort is computed for
    #[arg(long, value_name = "METRES", default_value_t = 0.6, value_parser = above_zero, allow_hyphen_values = true)]
    pub(super) display_width: f32,
    #[command(flatten)]
    pub(crate) subject: Subject,
    #[command(flatten)]
    pub(super) eyes: EyesArguments,
}

impl Arguments {
    /// Returns the name of a given option that needs a folder.
    fn folder_option(&self) -> Option<&'static str> {
        let options =
            [(self.dump, "--dump"), (self.ground_truth, "--ground-truth"), (self.layers.is_some(), "--layers")];
        options.into_iter().find(|(given, _)| *given).map(|(_, name)| name)
    }
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let target = Target::of(&arguments.out)?;
    if let (Target::File(_), Some(option)) = (&target, arguments.folder_option()) {
        return Err(Usage(format!("{option} writes many files; --out must be a folder")).into());
    }
    let job = Job { arguments, target, stop: Stop::on_signals()? };
    if arguments.watch { job.watch(global) } else { job.once(global) }
}

/// What to render, and where to.
struct Job<'a> {
    arguments: &'a Arguments,
    target: Target,
    stop: Stop,
}

impl Job<'_> {
    /// Renders now and after each change of an input file, until the program is stopped. Errors are printed, and the
    /// loop waits for the next change.
    fn watch(&self, global: &Global) -> Result<Summary, Box<dyn Error>> {
        let files = self.arguments.subject.files();
        if files.is_empty() {
            return Err(Usage("--watch: no input file is read, so there is nothing to watch".into()).into());
        }
        let changed = || -> Vec<Option<SystemTime>> {
            files.iter().map(|file| file.metadata().and_then(|data| data.modified()).ok()).collect()
        };
        loop {
            let before = changed();
            match self.once(global) {
                Ok(summary) => summary.print(global)?,
                Err(error) if error.is::<Interrupted>() => return Err(error),
                Err(error) => crate::complain(&error.to_string()),
            }
            while changed() == before {
                if self.stop.is_asked_for() {
                    return Err(Interrupted::AtAll.into());
                }
                thread::sleep(GLANCE);
            }
        }
    }

    fn once(&self, global: &Global) -> Result<Summary, Box<dyn Error>> {
        let arguments = self.arguments;
        let purpose = if arguments.compare { Purpose::Data } else { Purpose::Pictures };
        let mut stage = arguments.subject.open(purpose, global)?;
        self.check_stop()?;
        let begin = Instant::now();
        let pose = stage.camera.pose()?;
        let eyes = arguments.eyes.suiting(&pose);
        let mut pictures = Pictures::new(&self.target, &eyes, &pose, &stage.name)?;
        let mut progress = Progress::new(global, 1);
        let mut show = |now| if self.stop.is_asked_for() { ControlFlow::Break(()) } else { progress.show(now) };
        let options = self.options(&stage);
        let needs_whole_pair = self.needs_whole_pair(&stage);
        let frame = stage.renderer.pair(&stage.uploaded, &stage.camera).options(&options).progress(&mut show);
        let pair = match needs_whole_pair {
            true => frame.read().wait(),
            false => frame.rows(&mut |rows| pictures.write(&rows.views[0].view, &rows.views[1].view)).wait(),
        };
        progress.clear();
        let pair = match pair {
            Err(stereotrace::Error::Cancelled) => return Err(Interrupted::AtAll.into()),
            other => other?,
        };
        let wall = WallTimes { read: stage.read, build: stage.build, render: begin.elapsed() };
        if needs_whole_pair {
            pictures.write(&pair.left, &pair.right)?;
        }
        let (seen, mut batch) = (pictures.seen, Batch::new());
        pictures.add_to(&mut batch)?;
        if needs_whole_pair {
            self.add_rest(&mut batch, &mut stage, &pair, &eyes)?;
        }
        let difference = arguments.compare.then(|| difference_to_naive(&mut stage, &pair)).transpose()?;
        self.check_stop()?;
        let files = batch.commit()?;
        let StereoPair { pose, statistics, .. } = &pair;
        Ok(Report { arguments, stage: &stage, pose, statistics, seen, wall, difference, files: &files }.summary())
    }

    /// # Errors
    /// Fails if a signal has asked the program to stop.
    fn check_stop(&self) -> Result<(), Interrupted> {
        if self.stop.is_asked_for() { Err(Interrupted::AtAll) } else { Ok(()) }
    }

    /// Returns the options of the frame.
    fn options(&self, stage: &Stage) -> Options {
        let options = stage.options.clone();
        let is_open_exr = matches!(&self.target, Target::File(file) if is_open_exr(file));
        let has_albedo = is_open_exr && options.lighting != Lighting::Direct && options.adaptive.is_none();
        let needs_ids = self.needs_whole_pair(stage);
        let g_buffer = if needs_ids { GBuffer::Ids } else { GBuffer::Depth };
        options.cost_map(self.arguments.dump).linear(is_open_exr).albedo(has_albedo).g_buffer(g_buffer)
    }

    /// Returns whether the files, or the options, need all rows at the same time.
    fn needs_whole_pair(&self, stage: &Stage) -> bool {
        let compare = self.arguments.compare;
        let has_pictures_only = match &self.target {
            Target::Folder(_) => self.arguments.folder_option().is_none(),
            Target::File(file) => is_single_picture(file),
        };
        let is_apart = matches!(stage.camera.projection_kind(), Projection::ToeIn | Projection::Lenses(_));
        !has_pictures_only || compare || stage.options.denoise || is_apart
    }

    /// Adds the files that need the whole pair.
    fn add_rest(
        &self,
        batch: &mut Batch,
        stage: &mut Stage,
        pair: &StereoPair,
        eyes: &EyesArguments,
    ) -> Result<(), Box<dyn Error>> {
        let mut truth = || stage.renderer.ground_truth(&stage.uploaded, &stage.scene, pair).wait();
        match &self.target {
            Target::File(file) if is_single_picture(file) => {}
            Target::File(file) => {
                // Ground truth describes the surfaces at pixel centres. Not all methods show these surfaces.
                let is_exact = matches!(pair.statistics.method, Method::Naive | Method::Bracket(_));
                let truth = (is_open_exr(file) && is_exact).then(&mut truth).transpose()?;
                add_pair(batch, file, pair, truth.as_ref(), eyes)?;
            }
            Target::Folder(folder) => {
                if self.arguments.dump {
                    let (left, right) = eyes.ordered(&pair.left, &pair.right);
                    add_maps(batch, pair, [("left", left), ("right", right)], folder)?;
                }
                if self.arguments.ground_truth {
                    add_truth_of(batch, stage, pair, folder)?;
                }
                if let Some(layering) = &self.arguments.layers {
                    let layers = stage.renderer.layers(&stage.uploaded, &stage.scene, pair, layering).wait()?;
                    add_layers(batch, &layers, folder)?;
                }
            }
        }
        Ok(())
    }
}

/// Compares the right view with the right view of `naive`.
fn difference_to_naive(stage: &mut Stage, pair: &StereoPair) -> Result<Difference, stereotrace::Error> {
    let truth = stage.options.clone().method(Method::Naive).count(false).shadow_buffer(None);
    let naive = stage.renderer.pair(&stage.uploaded, &stage.camera).options(&truth).read().wait()?;
    compare(&pair.right, &naive.right, &pair.pose)
}

/// Adds the maps of --dump: re-traced pixels, shadows, cost, depth and primitive ids.
fn add_maps(
    batch: &mut Batch,
    pair: &StereoPair,
    eyes: [(&str, &stereotrace::View); 2],
    folder: &Path,
) -> Result<(), Box<dyn Error>> {
    batch.add_png(folder.join("retrace.png"), &pair.retrace_picture())?;
    if let Some(picture) = pair.shadow_picture() {
        batch.add_png(folder.join("shadows.png"), &picture)?;
    }
    // Both eyes use one scale. White is the cost that 99.9% of the left pixels do not exceed.
    let mut costs = pair.left.cost.clone();
    costs.sort_unstable();
    let white = costs.get(costs.len() * 999 / 1000).copied().unwrap_or(1);
    for (eye, view) in eyes {
        if let Some(picture) = view.cost_picture(white) {
            batch.add_png(folder.join(format!("{eye}_time_white_{white}.png")), &picture)?;
        }
        batch.add_depth(folder.join(format!("{eye}_depth.pfm")), view)?;
        batch.add_primitive_ids(folder.join(format!("{eye}_id.pfm")), view)?;
    }
    Ok(())
}
