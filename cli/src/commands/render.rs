//! `render`: a stereo pair.

use std::{
    error::Error,
    path::PathBuf,
    thread,
    time::{Duration, Instant, SystemTime},
};

use clap::Args;
use stereotrace::{Method, StereoPair, metrics::compare, output::Batch};

use super::report::{Report, WallTimes};
use crate::{
    arguments::{Global, Subject, above_zero},
    progress::Progress,
    summary::Summary,
    target::{EyesArguments, Target, add_picture},
};

/// Between two looks at the files that are watched.
const GLANCE: Duration = Duration::from_millis(250);

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(super) subject: Subject,
    #[command(flatten)]
    pub(super) eyes: EyesArguments,
    /// File to write, as .png: the anaglyph, or the packing that is asked for. Or a folder, for left, right, anaglyph and what else is asked for
    #[arg(long, short, value_name = "FILE|DIR", default_value = "out")]
    out: PathBuf,
    /// Render by naive too, and say how exact the right eye is
    #[arg(long)]
    compare: bool,
    /// Write depths and primitive ids of both eyes (PFM), the right eye's re-trace map, its shadow map where a bracket
    /// method made it, and both eyes' time views (PNG); into a folder
    #[arg(long)]
    dump: bool,
    /// Render again whenever a file that is read changes, until you stop it
    #[arg(long)]
    watch: bool,
    /// Width in metres of the display for which comfort is judged
    #[arg(long, value_name = "METRES", default_value_t = 0.6, value_parser = above_zero, allow_hyphen_values = true)]
    pub(super) display_width: f32,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let target = Target::of(&arguments.out)?;
    if let (Target::File(_), true) = (&target, arguments.dump) {
        return Err("--dump writes many files; give --out a folder".into());
    }
    if arguments.watch {
        return watch(arguments, &target, global);
    }
    once(arguments, &target, global)
}

/// Renders now and after each change, until the program is stopped. What fails is said, and the next change is waited for.
fn watch(arguments: &Arguments, target: &Target, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let files = arguments.subject.files();
    if files.is_empty() {
        return Err("--watch: no file is read of which one could wait for a change".into());
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
    let mut stage = arguments.subject.open(global)?;
    let begin = Instant::now();
    let uploaded = stage.renderer.upload(&stage.scene)?;
    let build = begin.elapsed();

    let begin = Instant::now();
    let options = stage.options.clone().cost_map(arguments.dump);
    let mut progress = Progress::new(global, 1);
    let pair = stage.renderer.render_with(&uploaded, &stage.camera, &options, &mut |now| progress.show(now));
    progress.clear();
    let pair = pair?;
    let wall = WallTimes { read: stage.read, build, render: begin.elapsed() };

    let difference = match arguments.compare {
        true => {
            let truth = stage.options.clone().method(Method::Naive).count(false).shadow_buffer(None);
            let naive = stage.renderer.render(&uploaded, &stage.camera, &truth)?;
            Some(compare(&pair.right, &naive.right, &pair.pose)?)
        }
        false => None,
    };
    let mut batch = Batch::new();
    match target {
        Target::File(file) => {
            add_picture(&mut batch, file, &arguments.eyes.picture(&pair.left, &pair.right))?;
        }
        Target::Folder(folder) => {
            add_pictures(&mut batch, arguments, &pair, folder)?;
        }
    }
    let files = batch.commit()?;
    let report = Report { arguments, stage: &stage, pair: &pair, wall, difference, files: &files };
    Ok(report.summary())
}

/// Adds all that a folder gets.
fn add_pictures(
    batch: &mut Batch,
    arguments: &Arguments,
    pair: &StereoPair,
    folder: &std::path::Path,
) -> Result<(), Box<dyn Error>> {
    let eyes = &arguments.eyes;
    let (left, right) = eyes.ordered(&pair.left, &pair.right);
    batch.add_png(folder.join("left.png"), &left.picture())?;
    batch.add_png(folder.join("right.png"), &right.picture())?;
    let anaglyph = EyesArguments { packing: None, ..eyes.clone() };
    batch.add_png(folder.join("anaglyph.png"), &anaglyph.picture(&pair.left, &pair.right))?;
    if let Some(packing) = eyes.packing {
        batch.add_png(folder.join(format!("{packing}.png")), &eyes.picture(&pair.left, &pair.right))?;
    }
    if arguments.dump {
        add_maps(batch, pair, [("left", left), ("right", right)], folder)?;
    }
    Ok(())
}

/// Adds what shows how the pair came about.
fn add_maps(
    batch: &mut Batch,
    pair: &StereoPair,
    eyes: [(&str, &stereotrace::View); 2],
    folder: &std::path::Path,
) -> Result<(), Box<dyn Error>> {
    batch.add_png(folder.join("retrace.png"), &pair.retrace_picture())?;
    if let Some(picture) = pair.shadow_picture() {
        batch.add_png(folder.join("shadows.png"), &picture)?;
    }
    // One scale for both eyes: white is what all but a thousandth of the left pixels stay below.
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
