//! Pictures in passes: the mean of several frames of the same views, each with random numbers of its own.

use super::frame::Done;
use crate::{
    Error, GBuffer, Lighting, Options, Rig, Tone, UploadedScene,
    ask::options::Pass,
    frame::{
        ViewRows,
        targets::{MOST_BYTES, too_large},
    },
    sampling::PartSums,
};

/// The passes of a picture so far. [`FrameBuilder::add_to`](crate::FrameBuilder::add_to) renders one more pass, and
/// returns the mean of all passes. So a picture can be shown early, and refined for as long as its noise matters. A
/// pass that is stopped while it is traced leaves the earlier ones as they are. If denoising is stopped, the pass
/// counts, and only its picture is lost.
///
/// Passes by paths continue the pixels' sequences of random numbers. Their number of paths may differ from pass to
/// pass, and counts as their weight. If a pixel has several samples, jitter moves them from pass to pass.
///
/// ```
/// use stereotrace::{Builtin, Gpu, Lighting, Method, Options, Passes, Renderer, blocking::Wait};
///
/// let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(64, 48));
/// let mut renderer = Renderer::new(Gpu::new().wait()?);
/// let uploaded = renderer.upload(&scene).wait()?;
/// let options = Options::new(Method::BRACKET).lighting(Lighting::paths(8));
/// let mut passes = Passes::new();
/// while passes.paths() < 32 {
///     let pair = renderer.pair(&uploaded, &camera).options(&options).add_to(&mut passes).wait()?;
///     println!("{} paths, {:?}", passes.paths(), pair.left.rgba8[0]);
/// }
/// assert_eq!(passes.count(), 4);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct Passes {
    begun: Option<Begun>,
    count: u32,
    /// Number of paths per sample.
    paths: u32,
}

/// Passes that have begun.
#[derive(Debug)]
struct Begun {
    common: Common,
    /// Cost of all passes, without denoising.
    done: Done,
    /// Data of the first pass that do not depend on its random numbers, without colours.
    rows: Vec<ViewRows>,
    /// Sums of each view.
    sums: Vec<Sums>,
    weight: f32,
}

/// What all passes of a picture have in common.
#[derive(Debug, PartialEq)]
struct Common {
    rig: Rig,
    options: Options,
    /// State of the scene ([`UploadedScene::state`]).
    scene: u64,
}

#[derive(Debug)]
struct Sums {
    colors: Vec<[f64; 3]>,
    /// Light in parts; empty unless it is kept.
    parts: Vec<PartSums>,
}

impl Passes {
    /// Creates a picture without passes.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the number of passes.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Returns the number of paths per pixel of all passes; 0 without paths ([`Lighting::Paths`]).
    pub fn paths(&self) -> u32 {
        let samples = self.begun.as_ref().map_or(1, |begun| begun.common.options.samples);
        self.paths.saturating_mul(samples)
    }

    /// Returns the options of the next pass.
    ///
    /// # Errors
    /// [`Error::Options`] if cameras, scene or options differ from the earlier passes' or cannot have passes.
    pub(super) fn next(&self, scene: &UploadedScene, rig: &Rig, options: &Options) -> Result<Options, Error> {
        let fault = |reason: &str| Err(Error::Options { option: "passes", reason: reason.into() });
        if options.adaptive.is_some() {
            return fault("pictures with adaptive samples have no passes");
        }
        let common = Common::of(scene, rig, options);
        let earlier = self.begun.as_ref().map_or(&common, |begun| &begun.common);
        if earlier.scene != common.scene {
            return fault("the scene was changed or uploaded anew since the passes before");
        }
        if earlier.rig != common.rig {
            return fault("the cameras are not those of the passes before");
        }
        if earlier.options != common.options {
            return fault("the options are not those of the passes before");
        }
        let pass = Pass { number: self.count, first_path: self.paths };
        let g_buffer = if self.count == 0 { options.g_buffer } else { GBuffer::None };
        // The sequences of pixels continue from pass to pass, not from frame to frame.
        Ok(Options { pass, g_buffer, linear: true, history: None, ..options.clone() })
    }

    /// Adds a pass. Returns the cost and the mean of all passes.
    ///
    /// # Errors
    /// [`Error::Limit`] if the sums do not fit into memory.
    pub(super) fn add(
        &mut self,
        (scene, rig): (&UploadedScene, &Rig),
        options: &Options,
        (done, views): (Done, Vec<ViewRows>),
    ) -> Result<(Done, Vec<ViewRows>), Error> {
        let paths = match options.lighting {
            Lighting::Direct => 0,
            Lighting::Paths { samples, .. } => samples.div_ceil(options.samples),
        };
        let begun = match self.begun.take() {
            Some(begun) => Begun { done: begun.done.with(done), ..begun },
            None => Begun::new(Common::of(scene, rig, options), done, &views)?,
        };
        let begun = self.begun.insert(begun);
        begun.add(&views, paths.max(1) as f32);
        self.count += 1;
        self.paths += paths;
        let shown = begun.rows.iter().zip(&begun.sums).map(|(rows, sums)| sums.shown(rows, options, begun.weight));
        Ok((begun.done.clone(), shown.collect()))
    }
}

impl Begun {
    fn new(common: Common, done: Done, views: &[ViewRows]) -> Result<Self, Error> {
        let pixels: usize = views.iter().map(|rows| rows.view.linear.len()).sum();
        let parts: usize = views.iter().map(|rows| rows.parts.len()).sum();
        let needed = pixels * size_of::<[f64; 3]>() + parts * size_of::<PartSums>();
        if needed as u64 > MOST_BYTES {
            let what = "the sums of a picture in passes".into();
            return Err(too_large(what, needed as u64, "render a smaller picture, or all paths in one pass"));
        }
        let rows = |rows: &ViewRows| {
            let mut rows = rows.clone();
            (rows.view.rgba8, rows.view.linear, rows.parts) = Default::default();
            rows
        };
        let sums = |rows: &ViewRows| Sums {
            colors: vec![[0.0; 3]; rows.view.linear.len()],
            parts: vec![PartSums::default(); rows.parts.len()],
        };
        let (rows, sums) = (views.iter().map(rows).collect(), views.iter().map(sums).collect());
        Ok(Self { common, done, rows, sums, weight: 0.0 })
    }

    fn add(&mut self, views: &[ViewRows], weight: f32) {
        self.weight += weight;
        for (sums, rows) in self.sums.iter_mut().zip(views) {
            for (sum, color) in sums.colors.iter_mut().zip(&rows.view.linear) {
                (0..3).for_each(|channel| sum[channel] += f64::from(weight * color[channel]));
            }
            sums.parts.iter_mut().zip(&rows.parts).for_each(|(sum, parts)| sum.add(parts, weight));
        }
    }
}

impl Sums {
    /// Returns a view of the mean colours, given its other data.
    fn shown(&self, rows: &ViewRows, options: &Options, weight: f32) -> ViewRows {
        let mean = |sum: &[f64; 3]| sum.map(|value| (value / f64::from(weight)) as f32);
        let mut rows = rows.clone();
        rows.view.show_linear(self.colors.iter().map(mean), options);
        if !options.linear {
            rows.view.linear = Vec::new();
        }
        rows.parts = self.parts.iter().map(|sums| sums.weighted(1.0 / weight).means()).collect();
        rows
    }
}

impl Common {
    fn of(scene: &UploadedScene, rig: &Rig, options: &Options) -> Self {
        let mut options = Options { exposure: 0.0, tone: Tone::Clamp, linear: false, history: None, ..options.clone() };
        if let Lighting::Paths { samples, .. } = &mut options.lighting {
            *samples = 1;
        }
        Self { rig: rig.clone(), options, scene: scene.state }
    }
}
