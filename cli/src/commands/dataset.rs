//! `dataset`: renders pairs with ground truth for stereo vision, in the folders and formats that loaders expect.

use std::{
    error::Error,
    fs,
    ops::Range,
    path::{Path, PathBuf},
    time::Instant,
};

use clap::{Args, Subcommand};
use serde_json::{Map, Value, json};
use stereotrace::{
    Channel, Projection, Renderer, Setting,
    blocking::Wait,
    dataset::{Layout, PairMaker, Spec},
    message::counted,
    output::{Batch, ExrColor},
};

use super::{
    motion::{Motion, MotionArguments},
    verify,
};
use crate::{
    arguments::{Global, Purpose, Stage, Subject, above_zero, frames},
    manifest::{MANIFEST, Manifest},
    progress::Progress,
    record, shown,
    stop::{Interrupted, Stop},
    summary::Summary,
    target::Target,
    usage::Usage,
};

/// Default number of pairs.
const PAIRS: u32 = 20;

#[derive(Clone, Debug, Args)]
#[command(args_conflicts_with_subcommands = true, disable_help_subcommand = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    action: Option<Action>,
    /// Layout of the files: middlebury (2014), kitti (2015), sceneflow, sintel, or panorama for --projection 360 or 180
    /// [default: middlebury or panorama]
    ///
    /// Cameras are parallel unless --screen, --cameras or --calib is given. Only middlebury accepts a finite screen,
    /// with all disparities 0 or more. By default it is panorama for --projection 360 and 180, else middlebury.
    #[arg(long)]
    layout: Option<Layout>,
    /// Number of pairs, from random cameras in the scene's free space. --seed selects the cameras [default: 20]
    #[arg(
        long,
        value_name = "N",
        conflicts_with_all = ["orbit", "path"],
        value_parser = clap::value_parser!(u32).range(1..=1_000_000)
    )]
    pairs: Option<u32>,
    /// Reject cameras with a disparity of PX pixels or more, before or behind the screen [default: a fifth of the
    /// width; at most 256 for kitti; none for panorama]
    #[arg(long, value_name = "PX", value_parser = above_zero, allow_hyphen_values = true)]
    max_disparity: Option<f32>,
    /// Reject cameras with a surface nearer than this, in world units [default: twice the interaxial (baseline)]
    #[arg(long, value_name = "DISTANCE", value_parser = above_zero, allow_hyphen_values = true)]
    clearance: Option<f32>,
    /// Also write linear colour, depth, disparity, normals and ids of each pair as OpenEXR, into exr/
    #[arg(long)]
    exr: bool,
    /// Render only these pairs, such as 0..50 for the first 50. A pair does not depend on the others, so several runs
    /// may share the work
    #[arg(long, value_name = "FROM..TO", value_parser = frames)]
    items: Option<Range<u32>>,
    /// Folder of the data set. The same command resumes it
    #[arg(long, short, value_name = "DIR", default_value = "dataset")]
    out: PathBuf,
    #[command(flatten)]
    pub(crate) subject: Subject,
    #[command(flatten)]
    motion: MotionArguments,
}

#[derive(Clone, Debug, Subcommand)]
enum Action {
    /// Read a data set back, and print what is missing or changed
    ///
    /// It may be a data set of this command or of the Python package. The exit status is 1 if anything is missing or
    /// changed.
    Verify(verify::Arguments),
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Summary, Box<dyn Error>> {
    if let Some(Action::Verify(arguments)) = &arguments.action {
        return verify::run(arguments);
    }
    let Target::Folder(folder) = Target::of(&arguments.out)? else {
        return Err(Usage(format!("{}: a data set needs a folder", shown(&arguments.out))).into());
    };
    let mut stage = arguments.subject.open(Purpose::Data, global)?;
    if !arguments.subject.screen_is_said() {
        stage.camera = stage.camera.parallel()?;
    }
    if let Projection::Lenses(_) = stage.camera.projection_kind() {
        let reason = "the layouts are for rectified pairs; the Python package writes data sets of lenses";
        return Err(Usage(format!("--lens: {reason}")).into());
    }
    let around = stage.camera.projection_kind().equirectangular();
    let usual = if around.is_some() { Layout::Panorama } else { Layout::Middlebury };
    let layout = arguments.layout.unwrap_or(usual);
    if layout.is_equirectangular() != around.is_some() {
        let advice = if around.is_some() { "use --layout panorama" } else { "add --projection 360 or 180" };
        return Err(Usage(format!("--layout {layout}: its pictures have another projection; {advice}")).into());
    }
    let motion = arguments.motion.motion(&arguments.subject, stage.camera)?;
    let count = motion.as_ref().map_or(arguments.pairs.unwrap_or(PAIRS), Motion::frames);
    let range = arguments.items.clone().unwrap_or(0..count);
    if range.end > count {
        return Err(Usage(format!("--items {}..{}: the data set has {count}", range.start, range.end)).into());
    }
    let settings = (layout, count, &motion, arguments.max_disparity, arguments.clearance, arguments.exr);
    let stop = Stop::on_signals()?;
    let spec = spec(arguments, &stage, (layout, count), motion.is_some())?;
    let mut record = record::of(&arguments.subject, &stage.scene, &settings)?;
    record["pairs"] = count.into();
    let mut manifest = Manifest::open(&folder, &record)?;
    let pending = Vec::from_iter(range.clone().filter(|item| !manifest.done.contains(item)));

    let Stage { scene, uploaded, camera, mut renderer, .. } = stage;
    let mut maker = PairMaker::new(spec).with_scene(scene, uploaded, camera);
    if arguments.exr {
        maker = maker.also(&[Channel::Linear]);
    }

    let begin = Instant::now();
    let mut progress = Progress::new(global, pending.len() as u32);
    let mut failed = Vec::new();
    let mut made = 0;
    for &item in &pending {
        if stop.is_asked_for() {
            return Err(Interrupted::After { done: made, of: pending.len(), many: "pairs" }.into());
        }
        // Another command may have rendered this pair already.
        if !manifest.has(item)? {
            match make((arguments, layout), (&mut maker, &mut renderer), motion.as_ref(), item, &folder, &mut progress)
            {
                Ok(line) => made += usize::from(manifest.add(item, &line)?),
                Err(error) => {
                    // A failed pair does not stop the others. The next run tries it again.
                    if manifest.add(item, &json!({ "item": item, "error": error.to_string() }))? {
                        failed.push((item, error.to_string()));
                    }
                }
            }
        }
        progress.next();
    }
    progress.clear();
    let seconds = begin.elapsed().as_secs_f64();

    if let Some((item, error)) = failed.first() {
        let failures = counted(failed.len(), "pair", "pairs");
        return Err(format!("{failures} of {} failed, the first is item {item}: {error}", pending.len()).into());
    }
    let kept = range.len() - made;
    let each = if made > 0 { format!(", {:.2} s each", seconds / made as f64) } else { String::new() };
    let kept_too = if kept > 0 { format!("; {kept} already existed") } else { String::new() };
    let text = format!(
        "{} in {} as {}: {seconds:.1} s{each}{kept_too}\n",
        counted(made, "pair", "pairs"),
        shown(&folder),
        layout
    );
    let json = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "adapter": renderer.gpu().adapter_name(),
        "layout": layout.name(),
        "rendered": made,
        "kept": kept,
        "seconds": seconds,
        "manifest": folder.join(MANIFEST).to_string_lossy(),
    });
    Ok(Summary { text, json, ..Summary::default() })
}

/// Returns the spec of the arguments. Its only scene is the stage's scene.
fn spec(
    arguments: &Arguments,
    stage: &Stage,
    (layout, count): (Layout, u32),
    has_motion: bool,
) -> Result<Spec, Box<dyn Error>> {
    let options = &stage.options;
    let elsewhere = ["seed", "exposure", "count"];
    let settings = Setting::ALL.iter().filter(|setting| !elsewhere.contains(&setting.name));
    let render = settings.map(|setting| Ok((setting.name.to_owned(), options.get(setting.name)?.into())));
    let render = render.collect::<Result<Map<_, Value>, stereotrace::Error>>()?;
    let poses = match has_motion {
        true => json!({ "kind": "fixed" }),
        false => json!({ "clearance": arguments.clearance, "max_disparity": arguments.max_disparity }),
    };
    let mut scene = json!({ "file": arguments.subject.scene_name() });
    if stage.scene.lights.is_empty() {
        scene["lights"] = json!(0); // else a spec places lights
    }
    let rig = match stage.camera.projection_kind().equirectangular() {
        None => json!({}),
        Some(around) => json!({
            "projection": around.span.degrees(),
            "pole_merge": around.merge.map_or(json!(false), |merge| json!([merge.from, merge.to])),
        }),
    };
    let spec = json!({
        "seed": options.seed,
        "pairs": count,
        "format": layout.name(),
        "size": stage.camera.pose()?.size,
        "scenes": [scene],
        "poses": poses,
        "rig": rig,
        "randomise": { "exposure": options.exposure },
        "render": render,
    });
    Spec::from_json(&spec.to_string(), "").map_err(|error| match error {
        // Other keys have the names of the arguments.
        stereotrace::Error::Spec { key, reason, .. } if key == "render" => reason.into(),
        stereotrace::Error::Spec { key, reason, .. } => {
            format!("{}: {reason}", key.rsplit('.').next().unwrap_or_default()).into()
        }
        other => other.into(),
    })
}

/// Renders one pair and writes its files. Returns its line of the manifest.
fn make(
    (arguments, layout): (&Arguments, Layout),
    (maker, renderer): (&mut PairMaker, &mut Renderer),
    motion: Option<&Motion>,
    item: u32,
    folder: &Path,
    progress: &mut Progress,
) -> Result<Value, Box<dyn Error>> {
    let mut progress = |now| progress.show(now);
    let made = match motion {
        Some(motion) => maker.pair_from(renderer, item, motion.at(item.into()), &mut progress).wait()?,
        None => maker.pair(renderer, item, &mut progress).wait()?,
    };
    let truth = made.truth.as_ref().ok_or("a layout needs ground truth")?;
    let mut batch = Batch::new();
    layout.add(&mut batch, folder, item, &made.pair, truth)?;
    let more = |kind: &str| -> Result<PathBuf, Box<dyn Error>> {
        fs::create_dir_all(folder.join(kind)).map_err(|error| format!("{}: {error}", shown(&folder.join(kind))))?;
        Ok(folder.join(kind).join(format!("{item:06}.{}", if kind == "exr" { "exr" } else { "json" })))
    };
    batch.add_camera_json(more("cameras")?, &made.pair.pose)?;
    if arguments.exr {
        batch.add_exr(more("exr")?, &made.pair, Some(truth), ExrColor::Half)?;
    }
    let files = batch.commit()?;
    let hashes = files.iter().map(|file| {
        let hash = record::sha256_of(file).map_err(|error| format!("{}: {error}", shown(file)))?;
        Ok((file.strip_prefix(folder).unwrap_or(file).to_string_lossy().into_owned(), hash.into()))
    });
    let mut line = serde_json::to_value(&made.record)?;
    line["files"] = Value::Object(hashes.collect::<Result<Map<_, _>, String>>()?);
    Ok(line)
}
