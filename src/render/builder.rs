//! Builder for a frame: its cameras, its options, and the destination of its pictures.

use std::ops::ControlFlow;

use super::{encode::Encoded, frame::Done, passes::Passes, renderer::Renderer};
use crate::{
    Error, Method, OnProgress, Options, Progress, Rig, Statistics, StereoCamera, StereoPair, UploadedScene, Views,
    frame::{OnRows, Rows, ViewRows},
    view::rig::Eyes,
};

/// A frame that is not rendered yet ([`Renderer::pair`], [`Renderer::views`]). `C` is the type of its cameras: a
/// [`StereoCamera`] for a pair, a [`Rig`] for any number of views. One of its last methods renders it:
/// [`FrameBuilder::read`] returns the pictures, [`FrameBuilder::rows`] streams them, [`FrameBuilder::encode`] leaves
/// them on the device.
///
/// ```
/// use std::ops::ControlFlow;
/// use stereotrace::{Builtin, Gpu, Method, Options, Renderer, blocking::Wait};
///
/// let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(96, 64));
/// let mut renderer = Renderer::new(Gpu::new().wait()?);
/// let uploaded = renderer.upload(&scene).wait()?;
/// let options = Options::new(Method::BRACKET).samples(4);
/// let mut show = |progress: stereotrace::Progress| {
///     println!("{:.0} %", 100.0 * progress.done);
///     ControlFlow::Continue(())
/// };
/// let pair = renderer.pair(&uploaded, &camera).options(&options).progress(&mut show).read().wait()?;
/// assert_eq!((pair.left.width, pair.left.height), (96, 64));
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[must_use = "a frame is rendered by `read`, `rows`, `encode`, `encode_bands` or `trace`"]
pub struct FrameBuilder<'a, C> {
    renderer: &'a mut Renderer,
    scene: &'a UploadedScene,
    cameras: &'a C,
    options: Options,
    progress: Box<OnProgress<'a>>,
}

impl<C: std::fmt::Debug> std::fmt::Debug for FrameBuilder<'_, C> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { cameras, options, .. } = self;
        formatter
            .debug_struct("FrameBuilder")
            .field("cameras", cameras)
            .field("options", options)
            .finish_non_exhaustive()
    }
}

impl Renderer {
    /// Starts a stereo pair. [`FrameBuilder::read`] and [`FrameBuilder::trace`] trace toed-in eyes
    /// ([`Projection::ToeIn`](crate::Projection::ToeIn)) and eyes with lenses
    /// ([`Projection::Lenses`](crate::Projection::Lenses)) one after the other by [`Method::Naive`], for any method. A
    /// warning says so once per renderer. The other methods refuse such eyes.
    pub fn pair<'a>(
        &'a mut self,
        scene: &'a UploadedScene,
        camera: &'a StereoCamera,
    ) -> FrameBuilder<'a, StereoCamera> {
        self.cache.keep(1); // an adaptive frame that was dropped left more
        FrameBuilder { renderer: self, scene, cameras: camera, options: Options::default(), progress: Box::new(go_on) }
    }

    /// Starts a frame of a rig's views.
    pub fn views<'a>(&'a mut self, scene: &'a UploadedScene, rig: &'a Rig) -> FrameBuilder<'a, Rig> {
        self.cache.keep(1);
        FrameBuilder { renderer: self, scene, cameras: rig, options: Options::default(), progress: Box::new(go_on) }
    }
}

impl<'a, C> FrameBuilder<'a, C> {
    /// Sets the options. Without them the frame is rendered by [`Method::Auto`], with one sample per pixel.
    pub fn options(mut self, options: &Options) -> Self {
        self.options = options.clone();
        self
    }

    /// Sets a callback for the progress. It is called after every band of rows, and before rows are denoised, and may
    /// stop the frame. Frames that are encoded do not call it.
    pub fn progress(mut self, progress: &'a mut OnProgress<'a>) -> Self {
        self.progress = Box::new(progress);
        self
    }
}

impl<C: Clone + Into<Rig>> FrameBuilder<'_, C> {
    /// Renders the frame, and returns its results with views without rows.
    async fn in_rows(self, on_rows: &mut OnRows<'_>) -> Result<(Done, Vec<ViewRows>), Error> {
        let Self { renderer, scene, cameras, options, mut progress } = self;
        options.check_parts(false)?;
        let eyes = cameras.clone().into().eyes(scene.origin)?;
        let done = renderer.sampled(scene, &eyes, &options, true, &mut *progress, on_rows).await?;
        let nothing = (0..eyes.sources.len()).map(|_| ViewRows::new(eyes.pose.size[0])).collect();
        Ok((done, nothing))
    }

    /// Encodes the frame into the caller's encoder. Its views stay on the device, and nothing is read back. The call
    /// only waits for the driver's checks of new buffers and kernels. The commands are fixed: a thread ends early
    /// if its rays take more rounds than the adapter grants. [`Encoded::unfinished`] counts such threads.
    ///
    /// Several samples per pixel ([`Options::samples`]) are filtered on the device. Their bytes may differ by 1 from
    /// those that are read back, since samples are kept as f16, in 8 bytes each. Depth is not available then.
    ///
    /// # Errors
    /// Those of [`FrameBuilder::read`]; [`Error::Encoding`] for a method with a stage on the host, and for options that
    /// need reading back; [`Error::Limit`] for a picture larger than the adapter's textures.
    pub async fn encode(self, encoder: &mut wgpu::CommandEncoder) -> Result<Encoded, Error> {
        let rig = self.cameras.clone().into();
        let encoded = self.renderer.encode_each(self.scene, &rig, &self.options, Some(encoder)).await;
        encoded.map(|(encoded, _)| encoded)
    }

    /// Encodes the frame as one command buffer per band of rows, from the top down. This suits frames so heavy that a
    /// watchdog would end one submission, or that must leave the device to others in between. Submit the buffers in
    /// order, with nothing else of this renderer between them.
    ///
    /// # Errors
    /// Those of [`FrameBuilder::encode`].
    pub async fn encode_bands(self) -> Result<(Encoded, Vec<wgpu::CommandBuffer>), Error> {
        let rig = self.cameras.clone().into();
        self.renderer.encode_each(self.scene, &rig, &self.options, None).await
    }
}

impl FrameBuilder<'_, Rig> {
    /// Renders the frame and returns its views.
    ///
    /// ```
    /// use stereotrace::{Builtin, Gpu, Renderer, Rig, blocking::Wait, output::quilt};
    ///
    /// let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(96, 64).interaxial_pixels(2.0));
    /// let mut renderer = Renderer::new(Gpu::new().wait()?);
    /// let uploaded = renderer.upload(&scene).wait()?;
    /// let views = renderer.views(&uploaded, &Rig::row(camera, 6)).read().wait()?;
    /// assert_eq!(quilt(&views, 3, 2)?.width, 3 * 96);
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Camera`] for an invalid camera; [`Error::Rig`] for a rig that can't be rendered; [`Error::Samples`] for
    /// an unsupported number of samples; [`Error::Limit`] for a picture that the adapter can't bind;
    /// [`Error::Cancelled`] if the progress callback breaks; [`Error::ForeignScene`] for a scene on another
    /// [`Gpu`](crate::Gpu); [`Error::DeviceLost`] and [`Error::OutOfMemory`].
    pub async fn read(self) -> Result<Views, Error> {
        self.views(None).await
    }

    /// Renders the frame in parts, as [`FrameBuilder::<StereoCamera>::rows`] does. The returned views have no rows, but
    /// all other results.
    ///
    /// # Errors
    /// As [`FrameBuilder::<StereoCamera>::rows`].
    pub async fn rows(self, on_rows: &mut OnRows<'_>) -> Result<Views, Error> {
        self.in_rows(on_rows).await.map(|(done, nothing)| Views::of(done, nothing))
    }

    /// Renders one more pass, and returns the mean of all passes.
    ///
    /// # Errors
    /// As [`FrameBuilder::<Rig>::read`], and [`Error::Options`] if cameras, scene or options differ from those of the
    /// earlier passes.
    pub async fn add_to(self, passes: &mut Passes) -> Result<Views, Error> {
        self.views(Some(passes)).await
    }

    async fn views(self, passes: Option<&mut Passes>) -> Result<Views, Error> {
        let Self { renderer, scene, cameras: rig, options, mut progress } = self;
        let eyes = rig.eyes(scene.origin)?;
        let of_pass = options_of(&passes, scene, rig, &options)?;
        let frame = renderer.whole_frame(scene, &eyes, &of_pass, &mut *progress).await?;
        let (mut done, mut views) = mean_of(passes, (scene, rig), &options, frame)?;
        renderer.use_parts((&mut done, &mut views), &options, &mut *progress).await?;
        Ok(Views::of(done, views))
    }
}

impl FrameBuilder<'_, StereoCamera> {
    /// Renders the frame and returns the pair.
    ///
    /// # Errors
    /// As [`FrameBuilder::<Rig>::read`], without [`Error::Rig`].
    pub async fn read(self) -> Result<StereoPair, Error> {
        self.both(None).await
    }

    /// Renders the frame and passes the rows of its views to `on_rows` as they are done, from the top down, some dozens
    /// at a time. Neither device nor host holds more than a band of rows, so pictures may have any height. The returned
    /// pair has no rows, but all other results.
    ///
    /// ```
    /// use stereotrace::{Builtin, Gpu, Renderer, blocking::Wait};
    ///
    /// let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(96, 200));
    /// let mut renderer = Renderer::new(Gpu::new().wait()?);
    /// let uploaded = renderer.upload(&scene).wait()?;
    /// let mut rows = 0;
    /// let mut count = |band: stereotrace::Rows| {
    ///     assert_eq!(band.first, rows);
    ///     rows += band.views[0].view.height;
    ///     Ok(())
    /// };
    /// renderer.pair(&uploaded, &camera).rows(&mut count).wait()?;
    /// assert_eq!(rows, 200);
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`FrameBuilder::<Rig>::read`], [`Error::Rig`] for toed-in eyes and lenses, [`Error::Options`] for
    /// options that need whole pictures, and any error of `on_rows`, which ends the frame.
    pub async fn rows(self, on_rows: &mut OnRows<'_>) -> Result<StereoPair, Error> {
        self.in_rows(on_rows).await.map(|(done, nothing)| StereoPair::of(done, nothing))
    }

    /// Renders one more pass, and returns the mean of all passes ([`Passes`]).
    ///
    /// # Errors
    /// As [`FrameBuilder::<Rig>::add_to`], without [`Error::Rig`].
    pub async fn add_to(self, passes: &mut Passes) -> Result<StereoPair, Error> {
        self.both(Some(passes)).await
    }

    async fn both(self, passes: Option<&mut Passes>) -> Result<StereoPair, Error> {
        let Self { renderer, scene, cameras: camera, options, mut progress } = self;
        let (rig, pose) = (Rig::from(*camera), camera.pose_in(scene.origin)?);
        let of_pass = options_of(&passes, scene, &rig, &options)?;
        let frame = match renderer.apart(&pose, &options) {
            None => renderer.whole_frame(scene, &Eyes::pair(&pose), &of_pass, &mut *progress).await?,
            Some([first, second]) => {
                let options = Options { method: Method::Naive, ..of_pass };
                let left = renderer.whole_frame(scene, &first, &options, &mut half_of(&mut *progress, 0.0)).await?;
                let right = renderer.whole_frame(scene, &second, &options, &mut half_of(&mut *progress, 0.5)).await?;
                (left.0.beside(right.0), [left.1, right.1].concat())
            }
        };
        let (mut done, mut views) = mean_of(passes, (scene, &rig), &options, frame)?;
        renderer.use_parts((&mut done, &mut views), &options, &mut *progress).await?;
        Ok(StereoPair { pose, ..StereoPair::of(done, views) })
    }

    /// Runs the passes of the frame without reading the pictures back; for benchmarks.
    ///
    /// # Errors
    /// As [`FrameBuilder::read`].
    pub async fn trace(self) -> Result<Statistics, Error> {
        let Self { renderer, scene, cameras: camera, options, mut progress } = self;
        options.check_parts(true)?;
        let pose = camera.pose_in(scene.origin)?;
        let Some([first, second]) = renderer.apart(&pose, &options) else {
            let done =
                renderer.sampled(scene, &Eyes::pair(&pose), &options, false, &mut *progress, &mut |_| Ok(())).await?;
            return Ok(done.pair_statistics());
        };
        let options = Options { method: Method::Naive, ..options };
        let left = renderer
            .sampled(scene, &first, &options, false, &mut half_of(&mut *progress, 0.0), &mut |_| Ok(()))
            .await?;
        let mut half = half_of(&mut *progress, 0.5);
        let right = renderer.sampled(scene, &second, &options, false, &mut half, &mut |_| Ok(())).await?;
        Ok(left.beside(right).pair_statistics())
    }
}

impl Renderer {
    /// Renders a frame and keeps all rows of its views, with light in parts.
    async fn whole_frame(
        &mut self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        progress: &mut OnProgress<'_>,
    ) -> Result<(Done, Vec<ViewRows>), Error> {
        options.check_parts(true)?;
        let mut views = ViewRows::with_room(eyes, options)?;
        let mut keep = |rows: Rows| {
            views.iter_mut().zip(rows.views).for_each(|(view, rows)| view.append(rows));
            Ok(())
        };
        let done = self.sampled(scene, eyes, options, true, progress, &mut keep).await?;
        Ok((done, views))
    }
}

/// Returns the options of the next pass, or the options themselves for a frame without passes.
fn options_of(
    passes: &Option<&mut Passes>,
    scene: &UploadedScene,
    rig: &Rig,
    options: &Options,
) -> Result<Options, Error> {
    passes.as_ref().map_or_else(|| Ok(options.clone()), |passes| passes.next(scene, rig, options))
}

/// Adds a frame to the passes, and returns the mean of all.
fn mean_of(
    passes: Option<&mut Passes>,
    (scene, rig): (&UploadedScene, &Rig),
    options: &Options,
    frame: (Done, Vec<ViewRows>),
) -> Result<(Done, Vec<ViewRows>), Error> {
    match passes {
        None => Ok(frame),
        Some(passes) => passes.add((scene, rig), options, frame),
    }
}

/// Progress callback that never stops a frame.
fn go_on(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Maps the progress of half a frame, from `begin`, to the whole frame.
fn half_of(progress: &mut OnProgress<'_>, begin: f32) -> impl FnMut(Progress) -> ControlFlow<()> {
    move |Progress { pass, done }| progress(Progress { pass, done: begin + 0.5 * done })
}
