//! `render`: renders one stereo pair.

use std::{
    error::Error,
    path::{Path, PathBuf},
    thread,
    time::{Duration, Instant, SystemTime},
};

use clap::Args;
use stereotrace::{GroundTruth, Lighting, Method, StereoPair, blocking::Wait, metrics::compare, output::Batch};

use super::report::{Report, WallTimes};
use crate::{
    arguments::{Global, Purpose, Subject, above_zero},
    progress::Progress,
    summary::Summary,
    target::{EyesArguments, Target, add_pair, add_view, is_open_exr},
};

/// Interval at which --watch checks the files.
const GLANCE: Duration = Duration::from_millis(250);

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// File or folder to write. A .png or .jpg file holds the anaglyph or the --packing; a .jps, .mpo or .exr file
    /// holds both views, and so does a .vr.jpg file with --projection 360 or 180. A folder gets the left view, right
    /// view, anaglyph and all other requested files
    #[arg(long, short, value_name = "FILE|DIR", default_value = "out")]
    out: PathBuf,
    /// Also render by naive, and report the right eye's errors relative to naive
    #[arg(long)]
    compare: bool,
    /// Write depths and primitive ids of both eyes (PFM), the right eye's re-trace map, its shadow map if a bracket
    /// method made it, and the cost of each pixel (PNG). --out must be a folder
    #[arg(long)]
    dump: bool,
    /// Write ground truth for stereo vision: disparity, occlusion, depth, distance, normals, ids and calibration. --out
    /// must be a folder
    #[arg(long)]
    ground_truth: bool,
    /// Render again whenever an input file changes, until interrupted
    #[arg(long)]
    watch: bool,
    /// Width in metres of the display that comfort is computed for
    #[arg(long, value_name = "METRES", default_value_t = 0.6, value_parser = above_zero, allow_hyphen_values = true)]
    pub(super) display_width: f32,
    #[command(flatten)]
    pub(super) subject: Subject,
    #[command(flatten)]
    pub(super) eyes: EyesArguments,
}

impl Arguments {
    /// Returns the name of a given option that needs a folder.
    fn folder_option(&self) -> Option<&'static str> {
        let options = [(self.dump, "--dump"), (self.ground_truth, "--ground-truth")];
        options.into_iter().find(|(given, _)| *given).map(|(_, name)| name)
    }
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let target = Target::of(&arguments.out)?;
    if let (Target::File(_), Some(option)) = (&target, arguments.folder_option()) {
        return Err(format!("{option} writes many files; --out must be a folder").into());
    }
    if arguments.watch {
        return watch(arguments, &target, global);
    }
    once(arguments, &target, global)
}

/// Renders now and after each change of an input file, until the program is stopped. Errors are printed, and the loop
/// waits for the next change.
fn watch(arguments: &Arguments, target: &Target, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let files = arguments.subject.files();
    if files.is_empty() {
        return Err("--watch: no input file is read, so there is nothing to watch".into());
    }
    let changed = || -> Vec<Option<SystemTime>> {
        files.iter().map(|file| file.metadata().and_then(|data| data.modified()).ok()).collect()
    };
    loop {
        let before = changed();
        match once(arguments, target, global) {
            Ok(summary) => summary.print(global)?,
            Err(error) => crate::complain(&error.to_string()),
        }
        while changed() == before {
            thread::sleep(GLANCE);
        }
    }
}

fn once(arguments: &Arguments, target: &Target, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let purpose = if arguments.compare { Purpose::Data } else { Purpose::Pictures };
    let mut stage = arguments.subject.open(purpose, global)?;
    let begin = Instant::now();
    let is_open_exr = matches!(target, Target::File(file) if is_open_exr(file));
    let has_albedo = is_open_exr && stage.options.lighting != Lighting::Direct && stage.options.adaptive.is_none();
    let options = stage.options.clone().cost_map(arguments.dump).linear(is_open_exr).albedo(has_albedo);
    let mut progress = Progress::new(global, 1);
    let pair = stage.render(stage.camera, options, &mut progress);
    progress.clear();
    let pair = pair?;
    let wall = WallTimes { read: stage.read, build: stage.build, render: begin.elapsed() };

    let difference = match arguments.compare {
        true => {
            let truth = stage.options.clone().method(Method::Naive).count(false).shadow_buffer(None);
            let naive = stage.renderer.pair(&stage.uploaded, &stage.camera).options(&truth).read().wait()?;
            Some(compare(&pair.right, &naive.right, &pair.pose)?)
        }
        false => None,
    };
    let mut batch = Batch::new();
    let eyes = arguments.eyes.suiting(&pair.pose);
    match target {
        Target::File(file) => {
            // Ground truth describes the surfaces at pixel centres. Not all methods show these surfaces.
            let is_exact = matches!(pair.statistics.method, Method::Naive | Method::Bracket(_));
            let truth = (is_open_exr && is_exact)
                .then(|| stage.renderer.ground_truth(&stage.uploaded, &stage.scene, &pair).wait());
            add_pair(&mut batch, file, &pair, truth.transpose()?.as_ref(), &eyes)?;
        }
        Target::Folder(folder) => {
            add_pictures(&mut batch, (&eyes, arguments.dump), (&pair, &stage.name), folder)?;
            if arguments.ground_truth {
                add_truth(
                    &mut batch,
                    &stage.renderer.ground_truth(&stage.uploaded, &stage.scene, &pair).wait()?,
                    folder,
                )?;
            }
        }
    }
    let files = batch.commit()?;
    let report = Report { arguments, stage: &stage, pair: &pair, wall, difference, files: &files };
    Ok(report.summary())
}

/// Adds the pictures of a folder: both views, the anaglyph, the packing and the maps of --dump.
fn add_pictures(
    batch: &mut Batch,
    (eyes, dump): (&EyesArguments, bool),
    (pair, scene): (&StereoPair, &str),
    folder: &Path,
) -> Result<(), Box<dyn Error>> {
    let (left, right) = eyes.ordered(&pair.left, &pair.right);
    add_view(batch, &folder.join("left.png"), left, &pair.pose)?;
    add_view(batch, &folder.join("right.png"), right, &pair.pose)?;
    let anaglyph = EyesArguments { packing: None, ..eyes.clone() };
    batch.add_png(folder.join("anaglyph.png"), &anaglyph.picture(&pair.left, &pair.right))?;
    if let Some(packing) = eyes.packing {
        let name = EyesArguments::packed_name(packing, &pair.pose, scene);
        batch.add_png(folder.join(name + ".png"), &eyes.picture(&pair.left, &pair.right))?;
    }
    if dump {
        add_maps(batch, pair, [("left", left), ("right", right)], folder)?;
    }
    Ok(())
}

/// Adds the ground truth of both views. KITTI's disparities are added for parallel cameras only: with a finite screen
/// they are negative behind it, which these files can't hold.
fn add_truth(batch: &mut Batch, truth: &GroundTruth, folder: &Path) -> Result<(), Box<dyn Error>> {
    for (n, eye) in [&truth.left, &truth.right].into_iter().enumerate() {
        let (width, height) = (eye.width, eye.height);
        let file = |name: &str, ending: &str| folder.join(format!("{name}{n}.{ending}"));
        batch.add_pfm(file("disp", "pfm"), width, height, &eye.disparity)?;
        batch.add_nocc_mask(folder.join(format!("mask{n}nocc.png")), eye)?;
        batch.add_occlusion(file("occlusion", "png"), eye)?;
        batch.add_sky_mask(file("sky", "png"), eye)?;
        batch.add_pfm(file("depth_z", "pfm"), width, height, &eye.depth)?;
        batch.add_pfm(file("distance", "pfm"), width, height, &eye.distance)?;
        batch.add_pfm_color(file("normals", "pfm"), width, height, &eye.shading_normal)?;
        batch.add_ids_png(file("objects", "png"), width, height, &eye.object)?;
        batch.add_ids_png(file("materials", "png"), width, height, &eye.material)?;
        if truth.pose.intrinsics().is_some_and(|intrinsics| intrinsics.doffs() == 0.0) {
            let (all, of_both) = (eye.surfaces(), eye.surfaces_of_both());
            batch.add_kitti_disparity(file("disp_occ_", "png"), width, height, &eye.disparity, &all)?;
            batch.add_kitti_disparity(file("disp_noc_", "png"), width, height, &eye.disparity, &of_both)?;
        }
    }
    if truth.pose.intrinsics().is_some() {
        batch.add_calib(folder.join("calib.txt"), truth)?;
    }
    Ok(batch.add_camera_json(folder.join("camera.json"), &truth.pose)?)
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
