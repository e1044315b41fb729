//! The renderer: renders stereo pairs and views from scenes and cameras.

use std::{ops::ControlFlow, sync::Once};

use super::frame::Done;
use crate::{
    BvhBuild, Convergence, Error, Gpu, Method, OnProgress, Options, Pose, Progress, Rig, Scene, Statistics,
    StereoCamera, StereoPair, UploadedScene, Views,
    frame::{self, OnRows, Rows, ViewRows, lanes::Steps},
    gpu::Timestamps,
    kernel::Kernels,
    kernel::traversal::Traversal,
    view::rig::Eyes,
};

/// Renders stereo pairs, and keeps kernels and buffers between frames.
///
/// ```no_run
/// use stereotrace::{Builtin, Gpu, Method, Options, Renderer};
///
/// let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(800, 600));
/// let mut renderer = Renderer::new(Gpu::new()?);
/// let uploaded = renderer.upload(&scene)?;
/// for method in [Method::Naive, Method::ATOMIC] {
///     let pair = renderer.render(&uploaded, &camera, &Options::new(method).count(true))?;
///     println!("{method}: second eye {:.2} of the first", pair.statistics.second_eye());
/// }
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Debug)]
pub struct Renderer {
    pub(crate) gpu: Gpu,
    pub(crate) traversal: Traversal,
    pub(crate) kernels: Kernels,
    /// Buffers of the last frame, reused by the next.
    pub(crate) cache: frame::Cache,
    pub(crate) timestamps: Option<Timestamps>,
    pub(crate) band_pixels: u32,
    /// Number of runs that rows of workgroups are divided into (`launched_row` of shaders/shared/pixels.wgsl).
    pub(crate) runs: u32,
    pub(crate) steps: Steps,
    /// Completed once the warning about a scene far from its origin was logged.
    pub(crate) rounding_warned: Once,
    /// Completed once the warning about toed-in pairs was logged.
    toe_in_warned: Once,
}

impl Renderer {
    /// Creates a renderer on a device.
    pub fn new(gpu: Gpu) -> Self {
        let traversal = Traversal::of(&gpu);
        Self::with_traversal(gpu, traversal)
    }

    /// Creates a renderer with a given traversal: for measurements, or where [`Traversal::of`] chose badly.
    pub fn with_traversal(gpu: Gpu, traversal: Traversal) -> Self {
        Self {
            traversal,
            kernels: Kernels::default(),
            cache: frame::Cache::default(),
            timestamps: Timestamps::new(&gpu),
            band_pixels: frame::band_pixels(&gpu),
            runs: gpu.threads(),
            steps: Steps::default(),
            rounding_warned: Once::new(),
            toe_in_warned: Once::new(),
            gpu,
        }
    }

    /// Returns the device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Renders a pair. `progress` is called after every band of rows and may stop the frame. Toed-in eyes
    /// ([`Convergence::ToeIn`]) are traced one after the other by [`Method::Naive`], whatever the method. A warning
    /// says so once per renderer.
    ///
    /// # Errors
    /// [`Error::Camera`] for an invalid camera, [`Error::Samples`] for an unsupported number of samples,
    /// [`Error::Limit`] for a picture that the adapter can't bind, [`Error::Cancelled`] if `progress` breaks,
    /// [`Error::ForeignScene`] for a scene on another [`Gpu`], [`Error::DeviceLost`] and [`Error::OutOfMemory`].
    pub async fn render_async(
        &mut self,
        scene: &UploadedScene,
        camera: &StereoCamera,
        options: &Options,
        progress: &mut OnProgress<'_>,
    ) -> Result<StereoPair, Error> {
        let pose = camera.pose_in(scene.origin)?;
        let Some([first, second]) = self.toed_in(&pose, options) else {
            let (done, views) = self.whole_frame(scene, &Eyes::pair(&pose), options, progress).await?;
            return Ok(StereoPair::of(done, views));
        };
        let options = &Options { method: Method::Naive, ..options.clone() };
        let left = self.whole_frame(scene, &first, options, &mut half_of(progress, 0.0)).await?;
        let right = self.whole_frame(scene, &second, options, &mut half_of(progress, 0.5)).await?;
        Ok(StereoPair::of_two(pose, left, right))
    }

    /// Runs the passes of a frame without reading the pictures back; for benchmarks.
    ///
    /// # Errors
    /// As [`Renderer::render_async`].
    pub async fn trace_async(
        &mut self,
        scene: &UploadedScene,
        camera: &StereoCamera,
        options: &Options,
    ) -> Result<Statistics, Error> {
        let mut go_on = |_| ControlFlow::Continue(());
        let pose = camera.pose_in(scene.origin)?;
        let Some([first, second]) = self.toed_in(&pose, options) else {
            let eyes = Eyes::pair(&pose);
            let done = self.sampled(scene, &eyes, options, false, &mut go_on, &mut |_| Ok(())).await?;
            return Ok(done.pair_statistics());
        };
        let options = &Options { method: Method::Naive, ..options.clone() };
        let left = self.sampled(scene, &first, options, false, &mut go_on, &mut |_| Ok(())).await?;
        let right = self.sampled(scene, &second, options, false, &mut go_on, &mut |_| Ok(())).await?;
        Ok(left.beside(right).pair_statistics())
    }

    /// Returns the eyes of a toed-in pair, each with a frame of its own, or `None` for other pairs.
    fn toed_in(&self, pose: &Pose, options: &Options) -> Option<[Eyes; 2]> {
        if pose.convergence == Convergence::OffAxis {
            return None;
        }
        if options.method != Method::Naive {
            let method = options.method;
            self.toe_in_warned.call_once(|| {
                log::warn!(
                    "toed-in eyes share no rows, so nothing can be reused: tracing both eyes (naive) instead of \
                     {method}"
                );
            });
        }
        Some([-1.0, 1.0].map(|side| Eyes::mono(pose.of_eye(side))))
    }

    /// Renders the views of a rig. `progress` is called after every band of rows and may stop the frame.
    ///
    /// # Errors
    /// As [`Renderer::render_async`]; [`Error::Rig`] for a rig that can't be rendered.
    pub async fn render_views_async(
        &mut self,
        scene: &UploadedScene,
        rig: &Rig,
        options: &Options,
        progress: &mut OnProgress<'_>,
    ) -> Result<Views, Error> {
        let eyes = rig.eyes(scene.origin)?;
        let (done, views) = self.whole_frame(scene, &eyes, options, progress).await?;
        Ok(Views::of(done, views))
    }

    /// Renders the views of a rig and passes their rows to `on_rows` as they are done, from the top down, some dozens
    /// at a time. Neither device nor host holds more than a band of rows, so pictures may have any height. Use
    /// [`Rig::pair`] for a stereo pair. The returned views have no rows, but all other results.
    ///
    /// # Errors
    /// As [`Renderer::render_views_async`], and any error of `on_rows`, which ends the frame.
    pub async fn render_rows_async(
        &mut self,
        scene: &UploadedScene,
        rig: &Rig,
        options: &Options,
        progress: &mut OnProgress<'_>,
        on_rows: &mut OnRows<'_>,
    ) -> Result<Views, Error> {
        let eyes = rig.eyes(scene.origin)?;
        let done = self.sampled(scene, &eyes, options, true, progress, on_rows).await?;
        let nothing = (0..eyes.sources.len()).map(|_| ViewRows::new(eyes.pose.size[0])).collect();
        Ok(Views::of(done, nothing))
    }

    /// Renders a frame and keeps all rows of its views.
    async fn whole_frame(
        &mut self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        progress: &mut OnProgress<'_>,
    ) -> Result<(Done, Vec<ViewRows>), Error> {
        let mut views = ViewRows::with_room(eyes, options)?;
        let mut keep = |rows: Rows| {
            views.iter_mut().zip(rows.views).for_each(|(view, rows)| view.append(rows));
            Ok(())
        };
        let done = self.sampled(scene, eyes, options, true, progress, &mut keep).await?;
        Ok((done, views))
    }
}

/// Maps the progress of half a frame, from `begin`, to the whole frame.
fn half_of(progress: &mut OnProgress<'_>, begin: f32) -> impl FnMut(Progress) -> ControlFlow<()> {
    move |Progress { pass, done }| progress(Progress { pass, done: begin + 0.5 * done })
}

/// Opens a device, uploads the scene and renders the views of a rig by [`Method::Auto`]. For more than one frame, keep
/// a [`Renderer`].
///
/// # Errors
/// As [`Gpu::new_async`], [`Renderer::upload_async`] and [`Renderer::render_views_async`].
pub async fn render_views_async(scene: &Scene, rig: &Rig) -> Result<Views, Error> {
    let mut renderer = Renderer::new(Gpu::new_async().await?);
    let uploaded = renderer.upload_async(scene, BvhBuild::Balanced).await?;
    let mut go_on = |_| ControlFlow::Continue(());
    renderer.render_views_async(&uploaded, rig, &Options::default(), &mut go_on).await
}

/// Opens a device, uploads the scene and renders a stereo pair by [`Method::Auto`]. For more than one picture, keep a
/// [`Renderer`].
///
/// # Errors
/// As [`Gpu::new_async`], [`Renderer::upload_async`] and [`Renderer::render_async`].
pub async fn render_stereo_async(scene: &Scene, camera: &StereoCamera) -> Result<StereoPair, Error> {
    let mut renderer = Renderer::new(Gpu::new_async().await?);
    let uploaded = renderer.upload_async(scene, BvhBuild::Balanced).await?;
    let mut go_on = |_| ControlFlow::Continue(());
    renderer.render_async(&uploaded, camera, &Options::default(), &mut go_on).await
}
