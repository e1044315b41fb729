//! `dataset`: renders pairs with ground truth for stereo vision, in the folders and formats that loaders expect.

use std::{
    collections::BTreeSet,
    error::Error,
    fmt::Display,
    fs::{self, File, OpenOptions},
    io::{Read as _, Seek as _, SeekFrom, Write as _},
    ops::Range,
    path::{Path, PathBuf},
    time::Instant,
};

use clap::Args;
use serde_json::{Value, json};
use stereotrace::{
    GroundTruth, Occlusion, StereoCamera, StereoPair,
    blocking::Wait,
    dataset::{FreePoses, Layout},
    message::counted,
    output::{Batch, ExrColor},
};

use super::motion::{Motion, MotionArguments};
use crate::{
    arguments::{Global, Stage, Subject, above_zero, frames},
    progress::Progress,
    record, shown,
    stop::{Interrupted, Stop},
    summary::Summary,
    target::Target,
};

const MANIFEST: &str = "manifest.jsonl";
/// Default limit of disparities, as a share of the width. Stereo matchers rarely search farther.
const MOST_DISPARITY: f32 = 0.2;
/// Default number of pairs.
const PAIRS: u32 = 20;

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// Layout of the files: middlebury (2014), kitti (2015) or sceneflow. Cameras are parallel unless --screen,
    /// --cameras or --calib is given. Only middlebury accepts a finite screen, with all disparities 0 or more
    #[arg(long, default_value_t)]
    layout: Layout,
    /// Number of pairs, from random cameras in the scene's free space. --seed selects the cameras [default: 20]
    #[arg(
        long,
        value_name = "N",
        conflicts_with_all = ["orbit", "path"],
        value_parser = clap::value_parser!(u32).range(1..=1_000_000)
    )]
    pairs: Option<u32>,
    /// Reject cameras with a disparity of PX pixels or more, before or behind the screen [default: a fifth of the
    /// width; at most 256 for kitti]
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
    subject: Subject,
    #[command(flatten)]
    motion: MotionArguments,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let Target::Folder(folder) = Target::of(&arguments.out)? else {
        return Err(format!("{}: a data set needs a folder", shown(&arguments.out)).into());
    };
    let mut stage = arguments.subject.open(global)?;
    if !arguments.subject.screen_is_said() {
        stage.camera = stage.camera.parallel()?;
    }
    stage.options = stage.options.linear(arguments.exr);
    let motion = arguments.motion.motion(&arguments.subject, stage.camera)?;
    let count = motion.as_ref().map_or(arguments.pairs.unwrap_or(PAIRS), Motion::frames);
    let range = arguments.items.clone().unwrap_or(0..count);
    if range.end > count {
        return Err(format!("--items {}..{}: the data set has {count}", range.start, range.end).into());
    }
    let settings = (arguments.layout, count, &motion, arguments.max_disparity, arguments.clearance, arguments.exr);
    let stop = Stop::on_signals()?;
    let mut manifest = Manifest::open(&folder, &record::of(&arguments.subject, &stage.scene, &settings)?)?;
    let pending = Vec::from_iter(range.clone().filter(|item| !manifest.done.contains(item)));

    let begin = Instant::now();
    let mut progress = Progress::new(global, pending.len() as u32);
    let mut failed = Vec::new();
    let mut made = 0;
    for &item in &pending {
        if stop.is_asked_for() {
            return Err(Interrupted { done: made, of: pending.len(), can_go_on: true }.into());
        }
        // Another command may have rendered this pair already.
        if !manifest.has(item)? {
            match make(arguments, &mut stage, motion.as_ref(), item, &folder, &mut progress) {
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
        arguments.layout
    );
    let json = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "adapter": stage.renderer.gpu().adapter_name(),
        "layout": arguments.layout.name(),
        "rendered": made,
        "kept": kept,
        "seconds": seconds,
        "manifest": folder.join(MANIFEST).to_string_lossy(),
    });
    Ok(Summary { text, json, to_stderr: false })
}

/// Renders one pair and writes its files. Returns its line of the manifest.
fn make(
    arguments: &Arguments,
    stage: &mut Stage,
    motion: Option<&Motion>,
    item: u32,
    folder: &Path,
    progress: &mut Progress,
) -> Result<Value, Box<dyn Error>> {
    let (camera, tries) = match motion {
        Some(motion) => (motion.at(item), None),
        None => {
            let (camera, tries) = random_camera(arguments, stage, item)?;
            (camera, Some(tries))
        }
    };
    let pair = stage.render(camera, stage.options.clone(), progress)?;
    let truth = stage.renderer.ground_truth(&stage.uploaded, &stage.scene, &pair).wait()?;
    let mut batch = Batch::new();
    arguments.layout.add(&mut batch, folder, item, &pair, &truth)?;
    let more = |kind: &str| -> Result<PathBuf, Box<dyn Error>> {
        fs::create_dir_all(folder.join(kind)).map_err(|error| format!("{}: {error}", shown(&folder.join(kind))))?;
        Ok(folder.join(kind).join(format!("{item:06}.{}", if kind == "exr" { "exr" } else { "json" })))
    };
    batch.add_camera_json(more("cameras")?, &pair.pose)?;
    if arguments.exr {
        batch.add_exr(more("exr")?, &pair, Some(&truth), ExrColor::Half)?;
    }
    let files = batch.commit()?;
    let files = files.iter().map(|file| file.strip_prefix(folder).unwrap_or(file).to_string_lossy());
    let files = Vec::from_iter(files);
    Ok(json!({
        "item": item,
        "files": files,
        "tries": tries,
        "eye": pair.pose.eye.to_array(),
        "forward": pair.pose.forward.to_array(),
        "up": pair.pose.up.to_array(),
        "interaxial": pair.pose.interaxial,
        "method": pair.statistics.method.to_string(),
        "retraced_share": pair.statistics.retraced_share(),
        "left": figures(&truth, &pair),
    }))
}

fn random_camera(arguments: &Arguments, stage: &Stage, item: u32) -> Result<(StereoCamera, u32), Box<dyn Error>> {
    let limit = arguments.max_disparity.unwrap_or(MOST_DISPARITY * stage.camera.pose()?.size[0] as f32);
    let mut poses = FreePoses::new(&stage.scene, stage.camera, stage.options.seed)?;
    poses = poses.disparity(limit.min(arguments.layout.disparity_limit()));
    if let Some(distance) = arguments.clearance {
        poses = poses.clearance(distance);
    }
    let found = poses.find(&stage.renderer, &stage.uploaded, item).wait()?;
    Ok((found.camera, found.tries))
}

/// Returns figures of a left view for the manifest: shares of hidden, out-of-frame and sky pixels in percent, the
/// range of disparities in pixels, and the nearest depth in world units.
fn figures(truth: &GroundTruth, pair: &StereoPair) -> Value {
    let left = &truth.left;
    let percent = |count: usize| 100.0 * count as f64 / left.depth.len() as f64;
    let of = |kind: Occlusion| percent(left.occlusion.iter().filter(|found| **found == kind).count());
    let surfaces = left.disparity.iter().zip(left.surfaces()).filter(|(_, is_surface)| *is_surface);
    let range = surfaces.fold(None, |range: Option<(f32, f32)>, (&disparity, _)| {
        let (low, high) = range.unwrap_or((disparity, disparity));
        Some((low.min(disparity), high.max(disparity)))
    });
    let nearest = pair.left.depth_range().0;
    json!({
        "hidden_percent": of(Occlusion::Hidden),
        "out_of_frame_percent": of(Occlusion::OutOfFrame),
        "sky_percent": percent(left.sky().iter().filter(|is_sky| **is_sky).count()),
        "disparity": range.map(|(low, high)| [low, high]),
        "nearest_depth": Some(nearest).filter(|depth| depth.is_finite()),
    })
}

/// The manifest has one line with settings and input hashes, then one line for each pair. Several commands may write it
/// at the same time. Each command locks the file, reads the lines that others have added, and then adds its own lines.
struct Manifest {
    folder: PathBuf,
    path: PathBuf,
    /// Pairs whose files exist.
    done: BTreeSet<u32>,
    /// Number of bytes and lines read so far.
    read: u64,
    lines: usize,
}

impl Manifest {
    /// Begins a manifest, or continues one whose first line is `record`.
    ///
    /// # Errors
    /// Fails if the folder's manifest has another first line.
    fn open(folder: &Path, record: &Value) -> Result<Self, Box<dyn Error>> {
        let path = folder.join(MANIFEST);
        let mut manifest = Self { folder: folder.to_owned(), path, done: BTreeSet::new(), read: 0, lines: 0 };
        let mut file = manifest.locked()?;
        manifest.catch_up(&mut file, Some(record))?;
        if manifest.lines == 0 {
            manifest.write(&mut file, record)?;
        }
        Ok(manifest)
    }

    /// Returns whether any command has finished this pair.
    fn has(&mut self, item: u32) -> Result<bool, Box<dyn Error>> {
        let mut file = self.locked()?;
        self.catch_up(&mut file, None)?;
        Ok(self.done.contains(&item))
    }

    /// Adds a pair's line and syncs it to disk. Returns false if another command has meanwhile rendered the pair and
    /// added its line.
    fn add(&mut self, item: u32, line: &Value) -> Result<bool, Box<dyn Error>> {
        let mut file = self.locked()?;
        self.catch_up(&mut file, None)?;
        if self.done.contains(&item) {
            return Ok(false);
        }
        self.write(&mut file, line)?;
        if line.get("files").is_some() {
            self.done.insert(item);
        }
        Ok(true)
    }

    /// Opens and locks the file. Dropping the returned file releases the lock.
    fn locked(&self) -> Result<File, Box<dyn Error>> {
        let opened = OpenOptions::new().create(true).read(true).write(true).truncate(false).open(&self.path);
        let file = opened.map_err(|error| self.fault(&error))?;
        if let Err(error) = fs4::FileExt::lock(&file) {
            // Some network file systems do not support locks. A single command does not need one.
            log::warn!("{}: it can't be locked ({error}); do not let another command write there", shown(&self.path));
        }
        Ok(file)
    }

    fn fault(&self, error: &impl Display) -> Box<dyn Error> {
        format!("{}: {error}", shown(&self.path)).into()
    }

    /// Reads the lines added since the last call. If `head` is given, it must be the file's first line.
    fn catch_up(&mut self, file: &mut File, head: Option<&Value>) -> Result<(), Box<dyn Error>> {
        let mut bytes = Vec::new();
        let found = file.seek(SeekFrom::Start(self.read)).and_then(|_| file.read_to_end(&mut bytes));
        found.map_err(|error| self.fault(&error))?;
        // A killed process may leave an incomplete line, which is removed.
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
        if whole < bytes.len() {
            file.set_len(self.read + whole as u64).map_err(|error| self.fault(&error))?;
        }
        for line in bytes[..whole].split(|&byte| byte == b'\n').filter(|line| !line.is_empty()) {
            let line: Result<Value, _> = serde_json::from_slice(line);
            if let (0, Some(head)) = (self.lines, head)
                && !line.as_ref().is_ok_and(|line| line == head)
            {
                let advice = "was made with different files, settings or version; use another folder";
                return Err(format!("{}: the data set there {advice}", shown(&self.path)).into());
            }
            self.lines += 1;
            let line = line.map_err(|error| format!("{}:{}: {error}", shown(&self.path), self.lines))?;
            let files = line["files"].as_array().map(Vec::as_slice).unwrap_or_default();
            let is_there = |file: &Value| file.as_str().is_some_and(|name| self.folder.join(name).is_file());
            if let Some(item) = line["item"].as_u64()
                && !files.is_empty()
                && files.iter().all(is_there)
            {
                self.done.insert(item as u32);
            }
        }
        self.read += whole as u64;
        Ok(())
    }

    /// Writes a line after those that were read.
    fn write(&mut self, file: &mut File, line: &Value) -> Result<(), Box<dyn Error>> {
        let text = format!("{line}\n");
        let written = file.seek(SeekFrom::Start(self.read)).and_then(|_| {
            file.write_all(text.as_bytes())?;
            file.sync_all()
        });
        written.map_err(|error| self.fault(&error))?;
        self.read += text.len() as u64;
        self.lines += 1;
        Ok(())
    }
}
