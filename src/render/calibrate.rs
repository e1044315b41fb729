//! Measures what `auto` chooses by: the costs of the methods on an adapter, or on one scene.

use std::{ops::ControlFlow, time::Duration};

use web_time::Instant;

use super::frame::Done;
use crate::{
    Builtin, Calibration, Error, Method, Options, PassTimes, Renderer, StereoCamera, Update, UploadedScene,
    frame::{
        band_pixels,
        wanted::{Part, Wanted},
    },
    methods::auto::{Seen, Trial},
    view::rig::Eyes,
};

/// Scenes that an adapter is measured on: much and little to traverse, triangles, spheres and ellipsoids, wide gaps and
/// narrow ones.
const SCENES: [Builtin; 4] = [Builtin::Hall, Builtin::Spheres, Builtin::Near, Builtin::Random1000];

/// Numbers of lights that an adapter is measured with.
const LIGHTS: [usize; 2] = [1, 5];

/// Size of the pictures that an adapter is measured with. Tiles of smaller pictures show too much of a scene each.
const SIZE: [u32; 2] = [640, 480];

/// Smallest number of rows that are measured, in the middle of the picture.
const ROWS: u32 = 64;

/// Shortest time of a frame whose measurement means something. A faster adapter measures more rows.
const SHORTEST: Duration = Duration::from_millis(10);

/// Number of frames of which the fastest counts. The first one compiles kernels.
const ROUNDS: u32 = 5;

/// Time of a pair, and what its left view asked for.
#[derive(Clone, Copy)]
struct Measured {
    time: Duration,
    seen: Seen,
}

impl Renderer {
    /// Returns what [`Method::Auto`] chooses by.
    pub fn calibration(&self) -> Calibration {
        self.calibration
    }

    /// Sets what [`Method::Auto`] chooses by, such as the result of an earlier [`Renderer::calibrate`] on the same
    /// adapter and driver.
    pub fn set_calibration(&mut self, calibration: Calibration) {
        self.calibration = calibration;
        self.band_pixels = band_pixels(&self.gpu, calibration.ray_seconds);
    }

    /// Measures the adapter with small pictures of built-in scenes. Sets what [`Method::Auto`] chooses by, and returns
    /// it. The choice of one and the same frame may differ afterwards. This takes some seconds on software adapters.
    /// The first call of a process also compiles kernels.
    ///
    /// # Errors
    /// The errors of [`Renderer::upload`] and [`FrameBuilder::trace`](crate::FrameBuilder::trace).
    pub async fn calibrate(&mut self) -> Result<Calibration, Error> {
        let mut trials = Vec::new();
        let mut rows = ROWS;
        for builtin in SCENES {
            let (mut scene, camera) = (builtin.scene(), builtin.camera(SIZE[0], SIZE[1]));
            scene.lights.clear();
            let mut uploaded = self.upload(&scene).await?;
            let eyes = Eyes::pair(&camera.pose_in(scene.origin())?);
            let (options, middle) =
                (Options::default(), |rows: u32| Some(((SIZE[1] - rows) / 2, (SIZE[1] + rows) / 2)));
            let mut dark = self.fastest(&uploaded, &eyes, &options, [Method::Naive], middle(rows)).await?;
            while dark[0].time < SHORTEST && rows < SIZE[1] {
                rows = (2 * rows).min(SIZE[1]);
                dark = self.fastest(&uploaded, &eyes, &options, [Method::Naive], middle(rows)).await?;
            }
            for lights in LIGHTS {
                scene.place_lights(lights, &camera)?;
                self.update(&mut uploaded, &scene, Update::Refit).await?;
                let both = [Method::Naive, Method::BRACKET];
                let both = self.fastest(&uploaded, &eyes, &options, both, middle(rows)).await?;
                let primary = 0.5 * dark[0].time.as_secs_f64();
                if both.iter().chain(&dark).all(Measured::is_known) {
                    trials.push(Trial::of(both, [SIZE[0], rows], primary));
                }
            }
        }
        self.set_calibration(self.calibration.fitted(&self.gpu, &trials));
        Ok(self.calibration)
    }

    /// Renders a pair of this scene by `naive` and by `bracket`, five times each. Sets what [`Method::Auto`] chooses by
    /// so that it takes the faster one for such frames, and returns it. This pays if many frames follow. Other scenes
    /// need their own ([`Renderer::set_calibration`]).
    ///
    /// # Errors
    /// The errors of [`FrameBuilder::trace`](crate::FrameBuilder::trace).
    pub async fn calibrate_on(
        &mut self,
        scene: &UploadedScene,
        camera: &StereoCamera,
        options: &Options,
    ) -> Result<Calibration, Error> {
        let model = scene.cost_model(&self.gpu, self.calibration, options);
        let pose = camera.pose_in(scene.origin)?;
        let eyes = Eyes::pair(&pose);
        // Other frames have one method, whatever they cost.
        let chooses = self.effective(&options.clone().method(Method::Auto), &eyes, scene) == Method::Auto;
        if chooses && self.apart(&pose, options).is_none() {
            let both = self.fastest(scene, &eyes, options, [Method::Naive, Method::BRACKET], None).await?;
            let size = pose.size.map(|side| side * options.samples.isqrt());
            let primary = 0.5 * both[0].time.as_secs_f64() / f64::from(model.choose(size, both[0].seen).naive);
            let trial = Trial::of(both, size, primary);
            if both.iter().all(Measured::is_known) {
                self.set_calibration(trial.settled(model, scene.rays_per_point(options)));
            }
        }
        Ok(self.calibration)
    }

    /// Renders a pair, or some rows of it, by each method in turn, and returns the fastest frames.
    async fn fastest<const METHODS: usize>(
        &mut self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        methods: [Method; METHODS],
        rows: Option<(u32, u32)>,
    ) -> Result<[Measured; METHODS], Error> {
        let mut fastest = [Measured::NONE; METHODS];
        for _ in 0..ROUNDS {
            for (method, best) in methods.into_iter().zip(&mut fastest) {
                let options = Options { method, history: None, ..options.clone() };
                let (mut go_on, mut drop_rows) = (|_| ControlFlow::Continue(()), |_| Ok(()));
                let begin = Instant::now();
                let done = match rows {
                    Some(rows) => {
                        let wanted = Wanted { pictures: false, part: Some(Part { rows, masks: None }) };
                        self.frame(scene, eyes, &options, wanted, &mut go_on, &mut drop_rows).await?
                    }
                    None => self.sampled(scene, eyes, &options, false, &mut go_on, &mut drop_rows).await?,
                };
                best.take(&done, begin.elapsed());
            }
        }
        Ok(fastest)
    }
}

impl Measured {
    const NONE: Self = Self { time: Duration::MAX, seen: Seen::NOTHING };

    /// Returns whether some frame was measured.
    fn is_known(&self) -> bool {
        self.time < Duration::MAX
    }

    /// Replaces this frame by a faster one. The time of a frame that was rendered again in steps means nothing.
    fn take(&mut self, done: &Done, wall: Duration) {
        let time = done.times.as_ref().map_or(wall, PassTimes::total);
        if time < self.time && !done.in_steps {
            *self = Self { time, seen: done.tallies[1].seen(&done.tallies[0]) };
        }
    }
}

impl Trial {
    fn of([naive, bracket]: [Measured; 2], [width, height]: [u32; 2], primary: f64) -> Self {
        Self {
            primary,
            times: [naive.time, bracket.time].map(|time| time.as_secs_f64()),
            pixels: f64::from(width) * f64::from(height),
            seen: bracket.seen,
        }
    }
}
