//! Runs the rendering thread. The thread has its own device, so the window responds during long frames.
//!
//! During motion the thread renders drafts with one sample per pixel, few rays to soft lights, and a size that takes
//! about [`DRAFT`]. A large draft recalls the one before it ([`Options::history`]). After [`STILL`] without changes,
//! the thread renders the whole picture, which recalls nothing. Light by paths is then refined pass by pass. The next
//! change cancels this picture.

use std::{
    ops::ControlFlow,
    panic::{self, AssertUnwindSafe},
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use stereotrace::{
    Error, GBuffer, LightShape, Lighting, Options, Passes, Renderer, Scene, StereoCamera, StereoPair, UploadedScene,
    blocking::Wait, wgpu,
};

use crate::arguments::Global;

/// Target time of a draft.
const DRAFT: Duration = Duration::from_millis(80);
/// Time without changes after which the whole picture is rendered.
const STILL: Duration = Duration::from_millis(150);
/// A draft grows only if it then takes at most the first share of [`DRAFT`]. It shrinks only if it takes more than the
/// second. Otherwise its size would alternate, and a draft of another size has no history.
const SHARES: [f64; 2] = [0.8, 1.25];
/// Memory for the samples of earlier drafts in MiB.
const HISTORY: u32 = 1024;
/// Least number of pixels of a draft that recalls the one before it. Smaller ones take as long without. With 1280x800
/// pixels the built-in scenes take a tenth less time (llvmpipe, 2026-11-27).
const RECALLING: u32 = 1 << 18;
/// Divisors of a draft's sides.
const DIVISORS: [u32; 6] = [1, 2, 3, 4, 6, 8];
/// Maximum number of rays to each soft light in a draft.
const DRAFT_RAYS: u32 = 4;
/// Number of paths per pixel in a draft, the fewest that can be denoised.
const DRAFT_PATHS: u32 = 2;
/// Number of paths per pixel after which a picture is not refined any more.
const MOST_PATHS: u32 = 1024;

/// A requested frame.
#[derive(Clone, Debug)]
pub(super) struct Wanted {
    /// Number of the request, which increases with each change.
    pub(super) version: u64,
    /// Camera of the whole picture.
    pub(super) camera: StereoCamera,
    /// Camera of drafts, whose size is set when they are rendered.
    pub(super) draft: StereoCamera,
    pub(super) size: [u32; 2],
    pub(super) options: Options,
}

/// A finished frame.
pub(super) struct Frame {
    pub(super) version: u64,
    /// Whether it is the whole picture, and not a draft.
    pub(super) whole: bool,
    pub(super) pair: StereoPair,
    /// Number of paths per pixel of a whole picture; 0 without paths.
    pub(super) paths: u32,
    pub(super) time: Duration,
}

/// Message of the thread to the window.
pub(super) enum Said {
    /// The scene is uploaded to the adapter of this name.
    Ready(String),
    Frame(Box<Frame>),
    /// The request with this number can't be rendered, for this reason.
    Failed(u64, String),
    /// The thread has ended because of this error.
    Ended(String),
}

#[derive(Default)]
struct State {
    wanted: Option<Wanted>,
    since: Option<Instant>,
    quit: bool,
    lose_device: bool,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns whether rendering of this version should stop.
    fn is_over(&self, version: u64) -> bool {
        let state = self.lock();
        state.quit || state.wanted.as_ref().is_some_and(|wanted| wanted.version != version)
    }
}

/// Handle of the thread, which ends when it is dropped.
pub(super) struct Worker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts a thread that renders a scene. The thread first uses the given renderer, to which the scene is uploaded.
    pub(super) fn new(
        (renderer, uploaded): (Renderer, UploadedScene),
        scene: Scene,
        global: Global,
        say: impl Fn(Said) + Send + 'static,
    ) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let soft = scene.lights.iter().any(|light| light.shape != LightShape::Point);
        let work = Work {
            shared: shared.clone(),
            renderer,
            scene,
            global,
            soft,
            costs: Vec::new(),
            divisor: None,
            passes: Passes::new(),
        };
        let run = move || {
            // Without this message the window would wait for the thread for ever.
            if panic::catch_unwind(AssertUnwindSafe(|| work.run(uploaded, &say))).is_err() {
                say(Said::Ended("the render thread has panicked".into()));
            }
        };
        let thread = thread::Builder::new().name("render".into()).spawn(run)?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Requests a frame, which replaces the previous request.
    pub(super) fn want(&self, wanted: Wanted) {
        let mut state = self.shared.lock();
        state.wanted = Some(wanted);
        state.since = Some(Instant::now());
        self.shared.changed.notify_all();
    }

    /// Destroys the device before the next frame, for tests.
    pub(super) fn lose_device(&self) {
        self.shared.lock().lose_device = true;
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.lock().quit = true;
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join(); // a panic was reported by `Said::Ended`
        }
    }
}

/// Quality of a frame, in increasing order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Stage {
    /// No frame yet.
    Nothing,
    Draft,
    /// A draft with all pixels.
    FullDraft,
    /// A whole picture that is refined by further passes.
    Whole,
    /// The last picture.
    Final,
}

struct Work {
    shared: Arc<Shared>,
    renderer: Renderer,
    scene: Scene,
    global: Global,
    /// Whether the scene has lights that are not points.
    soft: bool,
    /// Seconds per pixel of the last two drafts.
    costs: Vec<f64>,
    /// Divisor of the last draft's sides.
    divisor: Option<u32>,
    /// Passes of the current version's whole picture.
    passes: Passes,
}

impl Work {
    fn run(mut self, mut uploaded: UploadedScene, say: &impl Fn(Said)) {
        say(Said::Ready(self.renderer.gpu().adapter_name()));
        let (mut version, mut stage) = (0, Stage::Nothing);
        while let Some((wanted, next)) = self.next(version, stage) {
            if wanted.version != version {
                (version, stage) = (wanted.version, Stage::Nothing);
                self.passes = Passes::new();
            }
            match self.render(&mut uploaded, &wanted, next) {
                Ok(frame) => {
                    stage = match frame.whole {
                        true if has_passes(&wanted.options) && frame.paths < MOST_PATHS => Stage::Whole,
                        true => Stage::Final,
                        false => next,
                    };
                    say(Said::Frame(Box::new(frame)));
                }
                Err(Error::Cancelled) => {}
                Err(error) => {
                    stage = Stage::Final;
                    say(Said::Failed(version, error.to_string()));
                }
            }
        }
    }

    /// Waits for the next frame to render, given the stage that a version has reached. Returns `None` when the thread
    /// must end.
    fn next(&self, version: u64, stage: Stage) -> Option<(Wanted, Stage)> {
        let mut state = self.shared.lock();
        loop {
            if state.quit {
                return None;
            }
            let Some(wanted) = &state.wanted else {
                state = self.shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            let stage = if wanted.version == version { stage } else { Stage::Nothing };
            if let (Stage::Nothing, false) = (stage, self.is_quick(wanted)) {
                return Some((wanted.clone(), Stage::Draft));
            }
            let still = state.since.map_or(Duration::ZERO, |since| STILL.saturating_sub(since.elapsed()));
            let wait = match stage {
                Stage::Final => Duration::MAX,
                Stage::Whole => Duration::ZERO,
                Stage::Nothing => Duration::ZERO, // the whole picture is as quick as a draft
                Stage::Draft | Stage::FullDraft => still,
            };
            if wait.is_zero() {
                let next = match stage {
                    Stage::Draft if self.divisor(wanted) > 1 && wanted.options != self.drafted(wanted) => {
                        Stage::FullDraft
                    }
                    _ => Stage::Whole,
                };
                return Some((wanted.clone(), next));
            }
            state = match wait {
                Duration::MAX => self.shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner),
                wait => self.shared.changed.wait_timeout(state, wait).unwrap_or_else(PoisonError::into_inner).0,
            };
        }
    }

    /// Returns whether a draft would equal the whole picture.
    fn is_quick(&self, wanted: &Wanted) -> bool {
        self.divisor(wanted) == 1 && wanted.options == self.drafted(wanted) && !recalls(wanted.size, &wanted.options)
    }

    /// Returns the options of drafts.
    fn drafted(&self, wanted: &Wanted) -> Options {
        draft_options(&wanted.options, self.soft)
    }

    /// Returns the divisor of a draft's sides, so that the draft takes about [`DRAFT`], estimated from the last drafts'
    /// costs. The lesser cost counts, since the first draft of a size has no history.
    fn divisor(&self, wanted: &Wanted) -> u32 {
        let software = self.renderer.gpu().adapter_info().device_type == wgpu::DeviceType::Cpu;
        let Some(cost) = self.costs.iter().copied().reduce(f64::min) else { return if software { 4 } else { 1 } };
        let pixels = f64::from(wanted.size[0]) * f64::from(wanted.size[1]);
        let last = self.divisor.unwrap_or(1);
        let fits = |divisor: &&u32| {
            let share = SHARES[usize::from(**divisor >= last)];
            cost * pixels / f64::from(**divisor).powi(2) <= share * DRAFT.as_secs_f64()
        };
        DIVISORS.iter().find(fits).copied().unwrap_or(DIVISORS[DIVISORS.len() - 1])
    }

    /// Renders a frame, on a new device if the old one was lost.
    fn render(&mut self, uploaded: &mut UploadedScene, wanted: &Wanted, stage: Stage) -> Result<Frame, Error> {
        if std::mem::take(&mut self.shared.lock().lose_device) {
            self.renderer.gpu().device().destroy();
        }
        match self.try_render(uploaded, wanted, stage) {
            Err(Error::DeviceLost(reason)) => {
                log::warn!("the device was lost ({reason}); opening another one");
                self.renderer = self.global.renderer(self.global.gpu()?)?;
                self.passes = Passes::new();
                *uploaded = self.renderer.upload(&self.scene).wait()?;
                self.try_render(uploaded, wanted, stage)
            }
            done => done,
        }
    }

    fn try_render(&mut self, uploaded: &UploadedScene, wanted: &Wanted, stage: Stage) -> Result<Frame, Error> {
        let [width, height] = wanted.size;
        let divisor = if stage == Stage::Draft { self.divisor(wanted) } else { 1 };
        let [w, h] = [width, height].map(|side| side.div_ceil(divisor));
        let drafted = self.drafted(wanted);
        let (camera, options) = match stage {
            Stage::Whole => (wanted.camera, wanted.options.clone()),
            Stage::Draft if recalls([w, h], &drafted) => (wanted.draft.size(w, h), recalling(&drafted)),
            _ => (wanted.draft.size(w, h), drafted.clone()),
        };
        let (version, shared) = (wanted.version, self.shared.clone());
        let mut go_on = |_| {
            // Motion does not cancel drafts. Otherwise continuous motion would let no draft finish.
            let over = if stage == Stage::Draft { shared.lock().quit } else { shared.is_over(version) };
            if over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let begin = Instant::now();
        let mut options = options.g_buffer(GBuffer::Depth);
        let in_passes = stage == Stage::Whole && has_passes(&wanted.options);
        if let (true, Lighting::Paths { samples, .. }) = (in_passes, &mut options.lighting) {
            // Later passes are longer, so that denoising takes a small share of the time.
            *samples = (*samples).max(self.passes.paths() / 4);
        }
        let frame = self.renderer.pair(uploaded, &camera).options(&options).progress(&mut go_on);
        let pair = if in_passes { frame.add_to(&mut self.passes).wait()? } else { frame.read().wait()? };
        let paths = if in_passes { self.passes.paths() } else { 0 };
        let time = begin.elapsed();
        if stage != Stage::Whole || (wanted.options == drafted && !in_passes) {
            if self.costs.len() == 2 {
                self.costs.remove(0);
            }
            self.costs.push(time.as_secs_f64() / (f64::from(w) * f64::from(h)));
            if stage != Stage::FullDraft {
                self.divisor = Some(divisor);
            }
        }
        Ok(Frame { version, whole: stage == Stage::Whole, pair, paths, time })
    }
}

/// Returns whether whole pictures are refined pass by pass.
fn has_passes(options: &Options) -> bool {
    options.lighting != Lighting::Direct && options.adaptive.is_none()
}

/// Returns whether a draft with this size in pixels recalls the draft before it.
fn recalls([width, height]: [u32; 2], options: &Options) -> bool {
    width * height >= RECALLING && recalling(options).has_history()
}

/// Returns the options of a draft that recalls the one before it.
fn recalling(options: &Options) -> Options {
    options.clone().history(options.history.unwrap_or(HISTORY))
}

/// Returns the options of drafts. `soft` says whether the scene has lights that are not points.
fn draft_options(options: &Options, soft: bool) -> Options {
    let few = |rays: u32| rays.min(DRAFT_RAYS);
    let mut draft = options.clone().samples(1).adaptive(None).count(false);
    if soft {
        draft.shadow_rays = few(draft.shadow_rays);
    }
    if let Some(occlusion) = &mut draft.ambient_occlusion {
        occlusion.rays = few(occlusion.rays);
    }
    draft.sky_rays = draft.sky_rays.map(few);
    if let Lighting::Paths { samples, .. } = &mut draft.lighting {
        *samples = (*samples).min(DRAFT_PATHS);
    }
    draft
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use clap::Parser;
    use stereotrace::{Builtin, Method};

    use super::*;
    use crate::arguments::Cli;

    const SIZE: [u32; 2] = [48, 32];

    fn wanted(version: u64, options: Options) -> Wanted {
        let camera = Builtin::Hall.camera(SIZE[0], SIZE[1]);
        Wanted { version, camera, draft: camera, size: SIZE, options }
    }

    fn worker() -> (Worker, mpsc::Receiver<Said>) {
        let global = Cli::parse_from(["stereotrace", "--adapter", "software", "info"]).global;
        let renderer = Renderer::new(global.gpu().unwrap());
        let uploaded = renderer.upload(&Builtin::Hall.scene()).wait().unwrap();
        let (say, said) = mpsc::channel();
        let worker =
            Worker::new((renderer, uploaded), Builtin::Hall.scene(), global, move |what| drop(say.send(what))).unwrap();
        (worker, said)
    }

    /// Returns the frames from now on, up to the whole picture of a version.
    fn until_whole(said: &mpsc::Receiver<Said>, version: u64) -> Vec<Frame> {
        let mut frames = Vec::new();
        loop {
            match said.recv_timeout(Duration::from_secs(300)).expect("a frame") {
                Said::Frame(frame) => frames.push(*frame),
                Said::Ready(name) => assert!(!name.is_empty()),
                Said::Failed(_, error) | Said::Ended(error) => panic!("{error}"),
            }
            if frames.last().is_some_and(|frame| frame.whole && frame.version == version) {
                return frames;
            }
        }
    }

    #[test]
    fn a_draft_comes_first_and_the_last_version_is_whole() {
        let (worker, said) = worker();
        let options = Options::new(Method::Naive).samples(4);
        worker.want(wanted(1, options.clone()));
        let frames = until_whole(&said, 1);
        let first = frames.first().unwrap();
        assert!(!first.whole && first.pair.left.width < SIZE[0], "{}", first.pair.left.width);
        let whole = frames.last().unwrap();
        assert_eq!([whole.pair.left.width, whole.pair.left.height], SIZE);
        assert!(whole.pair.statistics.left.rays.primary >= 4 * u64::from(SIZE[0] * SIZE[1]));
        for version in 2..9 {
            worker.want(wanted(version, options.clone()));
        }
        let frames = until_whole(&said, 8);
        assert!(frames.iter().all(|frame| !frame.whole || frame.version == 8));
    }

    #[test]
    fn a_lost_device_is_replaced_and_the_picture_is_the_same() {
        let (worker, said) = worker();
        worker.want(wanted(1, Options::new(Method::Naive)));
        let before = until_whole(&said, 1).pop().unwrap();
        worker.lose_device();
        worker.want(wanted(2, Options::new(Method::Naive)));
        let after = until_whole(&said, 2).pop().unwrap();
        assert_eq!(before.pair.left.rgba8, after.pair.left.rgba8);
    }

    #[test]
    fn light_by_paths_is_refined_until_something_changes() {
        let (worker, said) = worker();
        let options = Options::new(Method::BRACKET).lighting(Lighting::paths(4)).denoise(true);
        worker.want(wanted(1, options.clone()));
        let mut frames = until_whole(&said, 1);
        while frames.len() < 12 || frames[11].paths < 16 {
            frames.extend(until_whole(&said, 1));
        }
        let wholes: Vec<&Frame> = frames.iter().filter(|frame| frame.whole).collect();
        assert!(wholes.windows(2).all(|two| two[0].paths < two[1].paths), "passes of more and more paths");
        assert_eq!(wholes[0].paths, 4);
        let other = wanted(2, options.seed(1));
        worker.want(other);
        let begun_anew = until_whole(&said, 2).pop().unwrap();
        assert_eq!(begun_anew.paths, 4);
    }

    #[test]
    fn what_cant_be_rendered_is_said_and_the_next_frame_comes() {
        let (worker, said) = worker();
        worker.want(wanted(1, Options::new(Method::Naive).samples(5)));
        let fault = loop {
            match said.recv_timeout(Duration::from_secs(300)).unwrap() {
                Said::Failed(1, error) => break error,
                Said::Failed(..) | Said::Ended(_) => panic!("another fault"),
                Said::Ready(_) | Said::Frame(_) => {}
            }
        };
        assert!(fault.contains("samples: 5"), "{fault}");
        worker.want(wanted(2, Options::new(Method::Naive)));
        assert!(until_whole(&said, 2).pop().unwrap().whole);
    }

    #[test]
    fn drafts_are_cheaper_and_of_sharp_light_the_same() {
        let sharp = Options::new(Method::Naive);
        assert_eq!(draft_options(&sharp, false), sharp);
        let soft = draft_options(&sharp.clone().samples(9).sky_rays(16), true);
        assert_eq!((soft.samples, soft.shadow_rays, soft.sky_rays), (1, DRAFT_RAYS, Some(DRAFT_RAYS)));
    }

    #[test]
    fn large_drafts_recall_the_draft_before() {
        let [bracket, naive] = [Method::BRACKET, Method::Naive].map(Options::new);
        assert!(recalls([640, 410], &bracket));
        assert!(!recalls([640, 400], &bracket) && !recalls([640, 410], &naive));
    }
}
