//! `sequence`: renders many pairs in one process, along a path or around an object. Existing pictures are kept.

use std::{
    error::Error,
    fmt::Write as _,
    fs,
    ops::{Range, RangeInclusive},
    path::{Path, PathBuf},
    time::Instant,
};

use clap::Args;
use serde_json::json;
use stereotrace::{
    GBuffer, Lighting, MAX_PATHS, Moment, MotionBlur, Options, Scene, StereoCamera, StereoPair, Update, UploadedScene,
    blocking::Wait,
    message::counted,
    output::{Batch, Picture, quilt},
};

use super::{
    ffmpeg,
    motion::{MOST, Motion, MotionArguments},
    names::{Content, Names, Rendered, is_recorded, keep},
    quilt::{Fan, QuiltArguments},
};
use crate::{
    arguments::{Global, Purpose, ShutterArgument, Stage, Subject, above_zero, frames, shutter},
    progress::Progress,
    record, shown,
    stop::{Interrupted, Stop},
    summary::Summary,
    target::{EyesArguments, check_one_picture, is_open_exr, make_folder},
    truth::{add_flow, add_truth_of},
    usage::Usage,
};

/// A file of each picture's ground truth.
const TRUTH_IS_THERE: &str = "camera.json";
/// Number of pictures of the default motion, an orbit.
const ORBIT: u32 = 72;
/// Number of consecutive pictures that a history spans. Then it begins anew. A run that goes on in the middle of a film
/// renders few pictures again, and several machines can share a film by blocks.
const BLOCK: u32 = 16;
/// The first picture of a block follows this many times as many paths as the others. It recalls no light, and would
/// have more noise than they have.
const FIRST_PATHS: u32 = 2;
/// Memory for samples of earlier pictures in MiB, unless `--history` is given.
const HISTORY: u32 = 1024;
/// Pictures per second that a film may have.
const FILM_FPS: RangeInclusive<f32> = 0.01..=1000.0;

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// Render only these pictures of the sequence, such as 0..24 for the first 24
    #[arg(long, value_name = "FROM..TO", value_parser = frames)]
    frames: Option<Range<u32>>,
    /// Film to write, .mp4 or .mkv, which FFmpeg makes; or a folder for numbered pictures
    ///
    /// A film's pictures are kept in a folder beside it, such as film.mp4.frames. A folder gets left_0000.png,
    /// right_0000.png and anaglyph_0000.png (or the --packing) of each pair, or quilt_0000.png. A name with a number,
    /// such as film/frame_%04d.png, gives one picture of each. - writes raw RGB pictures to standard output.
    ///
    /// An existing film is replaced only with --overwrite, or by the whole sequence if its folder has the same
    /// settings.
    #[arg(long, short, value_name = "DIR|NAMES|FILM|-", default_value = "out")]
    out: PathBuf,
    /// Replace existing pictures and films, also those of other settings
    #[arg(long)]
    overwrite: bool,
    /// Pictures per second of the film, and of the scene file's animation. Without --orbit or --path, the animation's
    /// duration gives the number of pictures
    #[arg(long, value_name = "N", default_value_t = 24.0, value_parser = above_zero, allow_hyphen_values = true)]
    fps: f32,
    /// Blur what moves: the share of the time between pictures for which the shutter is open, such as 0.5 for half of
    /// it, and the number of times within it that are averaged, 2 to 256 [default: 16]. It excludes --history
    #[arg(long, value_name = "SHARE[:TIMES]", value_parser = shutter, allow_hyphen_values = true)]
    shutter: Option<ShutterArgument>,
    /// Write ground truth of each pair into a folder, truth_0000 for picture 0. It has the files of `render`, and the
    /// optical flow, change of disparity and scene flow to both neighbouring pictures. --out must be a folder
    #[arg(long)]
    ground_truth: bool,
    #[command(flatten)]
    pub(crate) subject: Subject,
    #[command(flatten)]
    quilt: QuiltArguments,
    #[command(flatten)]
    eyes: EyesArguments,
    #[command(flatten)]
    motion: MotionArguments,
}

pub(crate) fn run(arguments: &Arguments, global: &Global) -> Result<Summary, Box<dyn Error>> {
    let grid = arguments.quilt.grid();
    arguments.check(grid.is_some())?;
    let names = Names::of(&arguments.out)?;
    if arguments.ground_truth && !matches!(names, Names::Folder(_)) {
        return Err(Usage(format!("--ground-truth: {} is not a folder", shown(&arguments.out))).into());
    }
    match &names {
        Names::Numbered { .. } if grid.is_some() => check_one_picture(&arguments.out)?,
        Names::Film(_) if !FILM_FPS.contains(&arguments.fps) => {
            let (least, most) = (FILM_FPS.start(), FILM_FPS.end());
            let reason = format!("a film has {least} to {most} pictures per second");
            return Err(Usage(format!("--fps {}: {reason}", arguments.fps)).into());
        }
        Names::Film(paths) => ffmpeg::check(&paths.film)?,
        _ => {}
    }
    let subject = arguments.quilt.sized(&arguments.subject);
    let mut stage = subject.open(Purpose::Pictures, global)?;
    let content = match grid {
        None => Content::Eyes(arguments.eyes.suiting(&stage.camera.pose()?)),
        Some([columns, rows]) => {
            let has_path = arguments.motion.path.is_some();
            let fan = arguments.quilt.fan(columns * rows, &subject, &mut stage, has_path)?;
            Content::Quilt([columns, rows], fan, arguments.eyes.quality)
        }
    };
    let film = Film::of(arguments, &stage)?;
    let all = 0..film.frames();
    let range = arguments.frames.clone().unwrap_or(all.clone());
    if range.end > all.end {
        return Err(arguments.beyond(all.end).into());
    }
    let stop = Stop::on_signals()?;
    let pending = match names.folder() {
        Some(folder) => {
            // Without an animation, pictures are the same at all speeds of the film.
            let fps = stage.playing.is_some().then_some(film.fps.to_bits());
            let settings = (&content, &film.motion, film.begin.to_bits(), fps, arguments.ground_truth, film.shutter);
            let mut record = record::of(&arguments.subject, &stage.scene, &settings)?;
            if let Some(playing) = &stage.playing {
                record["animation_sha256"] = record::of_animation(&playing.animation).into();
            }
            if let Names::Film(paths) = &names {
                let is_own = range == all && is_recorded(&record, folder);
                if paths.film.exists() && !is_own && !arguments.overwrite {
                    let reason = "it exists, and is not the whole film of these settings";
                    return Err(format!("{}: {reason}; use another name, or --overwrite", shown(&paths.film)).into());
                }
                make_folder(folder)?;
            }
            let there = |frame: &u32| names.files(*frame, &content).iter().any(|file| file.exists());
            keep(&record, folder, arguments.overwrite, || {
                let of_truth = |frame: u32| fs::read_dir(truth_folder(folder, frame)).into_iter().flatten().flatten();
                let files = |frame: u32| {
                    names.files(frame, &content).into_iter().chain(of_truth(frame).map(|entry| entry.path()))
                };
                all.clone().filter(there).flat_map(files).collect()
            })?;
            let has_truth = |frame: u32| truth_folder(folder, frame).join(TRUTH_IS_THERE).exists();
            let is_there =
                |frame: u32| names.are_there(frame, &content) && (!arguments.ground_truth || has_truth(frame));
            range.clone().filter(|frame| !is_there(*frame)).collect::<Vec<_>>()
        }
        None => range.clone().collect(),
    };

    stage.options = stage.options.linear(is_open_exr(&arguments.out) || film.shutter.is_some());
    if !arguments.subject.picture.gives("history") && film.shutter.is_none() && grid.is_none() {
        stage.options = stage.options.history(HISTORY);
    }
    if arguments.ground_truth {
        stage.options = stage.options.g_buffer(GBuffer::Ids);
    }
    let mut truth = arguments.ground_truth.then(Truth::default);
    let begin = Instant::now();
    let mut progress = Progress::new(global, pending.len() as u32);
    let mut size = [0, 0];
    let mut last = None;
    for (done, &frame) in pending.iter().enumerate() {
        let interrupted = || match (&names, grid) {
            (Names::Stdout, _) => Interrupted::AtAll,
            (_, None) => Interrupted::After { done, of: pending.len(), many: "pairs" },
            (_, Some(_)) => Interrupted::After { done, of: pending.len(), many: "pictures" },
        };
        if stop.is_asked_for() {
            return Err(interrupted().into());
        }
        for earlier in earlier_in_block(&stage.options, frame, last) {
            if stop.is_asked_for() {
                return Err(interrupted().into());
            }
            picture(&mut stage, &film, earlier, &mut progress)?;
        }
        let files = names.files(frame, &content);
        let mut batch = Batch::new();
        let written = match &content {
            Content::Quilt(grid, fan, quality) => {
                let quilt = film.quilt(&mut stage, frame, *grid, fan, &mut progress)?;
                Rendered::Quilt(quilt, *quality).write(batch, &files)
            }
            Content::Eyes(eyes) => {
                let pair = picture(&mut stage, &film, frame, &mut progress)?;
                last = Some(frame);
                if let (Some(truth), Names::Folder(folder)) = (&mut truth, &names) {
                    truth.add(&mut batch, &stage, &film, frame, &pair, &truth_folder(folder, frame))?;
                }
                Rendered::Pair(&pair, eyes).write(batch, &files)
            }
        };
        size = match written {
            // The signal may also have ended the program that reads the pipe.
            Err(_) if names == Names::Stdout && stop.is_asked_for() => return Err(interrupted().into()),
            written => written?,
        };
        progress.next();
    }
    progress.clear();
    let seconds = begin.elapsed().as_secs_f64();
    if let Names::Film(paths) = &names {
        ffmpeg::make(paths, &range, film.fps, &content, &stop)?;
    }

    let (made, kept) = (pending.len(), range.len() - pending.len());
    let place = names.folder().map_or("standard output".into(), shown);
    let (one, many) = if grid.is_some() { ("quilt", "quilts") } else { ("pair", "pairs") };
    let mut text = format!("{} in {place}: {seconds:.1} s", counted(made, one, many));
    if made > 0 {
        write!(text, ", {:.0} ms each", 1e3 * seconds / made as f64)?;
    }
    text += &if kept > 0 { format!("; {kept} already existed\n") } else { "\n".into() };
    if names == Names::Stdout {
        let [width, height] = size;
        writeln!(text, "ffmpeg reads them with -f rawvideo -pixel_format rgb24 -video_size {width}x{height} -i -")?;
    }
    let film_path = if let Names::Film(paths) = &names { Some(&paths.film) } else { None };
    if let Some(film) = film_path {
        let pictures = counted(range.len(), "picture", "pictures");
        writeln!(text, "{} has {pictures}; its folder of pictures may be removed", shown(film))?;
        let has_layout = film.file_stem().is_some_and(|stem| stem.to_string_lossy().contains("_qs"));
        if let Some([columns, rows]) = grid.filter(|_| !has_layout) {
            writeln!(text, "players of quilts read the layout from a name that ends in _qs{columns}x{rows}aASPECT")?;
        }
    }
    let json = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "adapter": stage.renderer.gpu().adapter_name(),
        "scene": stage.name,
        "film": film_path.map(|film| film.to_string_lossy()),
        "frames": [range.start, range.end],
        "rendered": made,
        "kept": kept,
        "seconds": seconds,
        "size": size,
    });
    Ok(Summary { text, json, to_stderr: names == Names::Stdout, ..Summary::default() })
}

impl Arguments {
    /// Checks the options that exclude each other.
    fn check(&self, is_quilt: bool) -> Result<(), Usage> {
        let has_history = self.subject.picture.gives("history");
        if self.shutter.is_some() && has_history {
            let reason = "--shutter and --history exclude each other: a blurred picture has no single time";
            return Err(Usage(reason.into()));
        }
        let of_pairs = [
            ("--ground-truth", self.ground_truth),
            ("--shutter", self.shutter.is_some()),
            ("--history", has_history),
            ("--packing", self.eyes.packing.is_some()),
            ("--swap", self.eyes.swap),
        ];
        self.quilt.check(&self.subject)?;
        if let Some((name, _)) = of_pairs.into_iter().find(|(_, given)| is_quilt && *given) {
            return Err(Usage(format!("{name} is for pairs, not for quilts")));
        }
        match (&self.frames, self.motion.orbit) {
            (Some(range), Some(orbit)) if range.end > orbit => Err(self.beyond(orbit)),
            _ => Ok(()),
        }
    }

    /// Returns the error of --frames beyond the end of the sequence.
    fn beyond(&self, end: u32) -> Usage {
        let Range { start, end: asked } = self.frames.clone().unwrap_or_default();
        Usage(format!("--frames {start}..{asked}: the sequence has {end}"))
    }
}

/// Renders a picture. The first one of a block depends on no other.
fn picture(
    stage: &mut Stage,
    film: &Film,
    frame: u32,
    progress: &mut Progress,
) -> Result<StereoPair, stereotrace::Error> {
    let mut options = stage.options.clone();
    if frame.is_multiple_of(BLOCK) {
        stage.renderer.forget();
        // A moving scene recalls no light, so its first picture is like the others.
        if let Lighting::Paths { bounces, samples } = options.lighting
            && options.has_history()
            && stage.playing.is_none()
        {
            let samples = samples.saturating_mul(FIRST_PATHS).min(MAX_PATHS);
            options = options.lighting(Lighting::Paths { bounces, samples });
        }
    }
    let blur = blur(stage, film, frame, &options, progress)?;
    let mut pair = film.at(stage, frame.into(), options.clone(), progress)?;
    blur.apply(&mut pair, &options)?;
    Ok(pair)
}

/// Renders a picture's times while the shutter is open. Without a shutter there are none.
fn blur(
    stage: &mut Stage,
    film: &Film,
    frame: u32,
    options: &Options,
    progress: &mut Progress,
) -> Result<MotionBlur, stereotrace::Error> {
    let mut blur = MotionBlur::new();
    let Some(shutter) = film.shutter else { return Ok(blur) };
    for (offset, options) in MotionBlur::instants(shutter.open, shutter.times, options) {
        blur.add(&film.at(stage, f64::from(frame) + offset, options, progress)?)?;
    }
    Ok(blur)
}

/// Motion of a film's camera and scene.
struct Film {
    /// Motion of the camera; `None` for a camera that stays or that the animation moves.
    motion: Option<Motion>,
    /// Duration of the animation in seconds.
    duration: f64,
    /// Time of picture 0 in seconds.
    begin: f64,
    fps: f32,
    shutter: Option<ShutterArgument>,
}

impl Film {
    fn of(arguments: &Arguments, stage: &Stage) -> Result<Self, Box<dyn Error>> {
        let motion = arguments.motion.motion(&arguments.subject, stage.camera)?;
        let orbit = || stage.playing.is_none().then_some(Motion::Orbit(stage.camera, ORBIT));
        Ok(Self {
            motion: motion.or_else(orbit),
            duration: stage.playing.as_ref().map_or(0.0, |playing| playing.animation.duration() - playing.begin),
            begin: stage.playing.as_ref().map_or(0.0, |playing| playing.begin),
            fps: arguments.fps,
            shutter: arguments.shutter,
        })
    }

    fn frames(&self) -> u32 {
        let by_time = || (self.duration.max(0.0) * f64::from(self.fps)).round().min(f64::from(MOST - 1)) as u32 + 1;
        self.motion.as_ref().map_or_else(by_time, Motion::frames)
    }

    /// Returns the time of a picture in seconds. Between two pictures, the number has a fraction.
    fn seconds(&self, frame: f64) -> f64 {
        self.begin + frame / f64::from(self.fps)
    }

    /// Renders the scene at a picture's time.
    fn at(
        &self,
        stage: &mut Stage,
        frame: f64,
        options: Options,
        progress: &mut Progress,
    ) -> Result<StereoPair, stereotrace::Error> {
        stage.seek(self.seconds(frame))?;
        stage.render(self.camera(stage, frame)?, options, progress)
    }

    /// Renders the quilt of a picture.
    fn quilt(
        &self,
        stage: &mut Stage,
        frame: u32,
        [columns, rows]: [u32; 2],
        fan: &Fan,
        progress: &mut Progress,
    ) -> Result<Picture, stereotrace::Error> {
        stage.seek(self.seconds(frame.into()))?;
        let (_, rig) = fan.rig(self.camera(stage, frame.into())?)?;
        let mut show = |now| progress.show(now);
        let views = stage.renderer.views(&stage.uploaded, &rig).options(&stage.options).progress(&mut show);
        quilt(&views.read().wait()?, columns, rows)
    }

    /// Returns the camera of a picture.
    fn camera(&self, stage: &Stage, frame: f64) -> Result<StereoCamera, stereotrace::Error> {
        match (&self.motion, &stage.playing) {
            (Some(motion), _) => Ok(motion.at(frame)),
            (None, Some(playing)) => playing.camera(stage.camera, self.seconds(frame)),
            (None, None) => Ok(stage.camera),
        }
    }
}

/// Maker of the pictures' ground truth.
#[derive(Default)]
struct Truth {
    /// The scene at the time of another picture, if it moves.
    other: Option<(Scene, UploadedScene)>,
}

impl Truth {
    /// Adds the ground truth of a picture, and the flow to its neighbours.
    fn add(
        &mut self,
        batch: &mut Batch,
        stage: &Stage,
        film: &Film,
        frame: u32,
        pair: &StereoPair,
        folder: &Path,
    ) -> Result<(), Box<dyn Error>> {
        fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", shown(folder)))?;
        add_truth_of(batch, stage, pair, folder)?;
        let before = frame.checked_sub(1).map(|before| ("backward", before));
        let after = (frame + 1 < film.frames()).then_some(("forward", frame + 1));
        for (direction, other) in [after, before].into_iter().flatten() {
            let camera = film.camera(stage, other.into())?;
            let (scene, uploaded) = match &stage.playing {
                None => (&stage.scene, &stage.uploaded),
                Some(playing) => {
                    let (scene, uploaded) = match &mut self.other {
                        Some(other) => other,
                        none => none.insert((stage.scene.clone(), stage.renderer.upload(&stage.scene).wait()?)),
                    };
                    playing.animation.pose(scene, film.seconds(other.into()))?;
                    stage.renderer.update(uploaded, scene, Update::RefitOrRebuild).wait()?;
                    (&*scene, &*uploaded)
                }
            };
            let then = Moment { scene, uploaded, camera: &camera };
            add_flow(batch, &stage.renderer.flow(pair, &stage.scene, then).wait()?, direction, folder)?;
        }
        Ok(())
    }
}

/// Returns the folder of a picture's ground truth.
fn truth_folder(folder: &Path, frame: u32) -> PathBuf {
    folder.join(format!("truth_{frame:04}"))
}

/// Returns the pictures before `frame` in its block that the renderer needs for its history, after picture `last`.
/// They may exist already. So a picture has the same bytes whichever pictures of its block a run renders.
fn earlier_in_block(options: &Options, frame: u32, last: Option<u32>) -> Range<u32> {
    let begin = frame - frame % BLOCK;
    let first = last.filter(|last| *last >= begin).map_or(begin, |last| last + 1);
    if options.has_history() { first..frame } else { frame..frame }
}
