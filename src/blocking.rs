//! Waits for operations on the calling thread. The feature `blocking` enables this module, except on wasm32, where
//! blocking stops the browser from finishing the work.

use crate::{Error, Gpu, Renderer, Scene, StereoCamera, StereoPair};

/// Waits for a future of this crate.
///
/// ```
/// use stereotrace::{Builtin, Gpu, Renderer, Update, blocking::Wait, glam::{Affine3A, Vec3}};
///
/// let (mut scene, camera) = (Builtin::Spheres.scene(), Builtin::Spheres.camera(64, 48));
/// let mut renderer = Renderer::new(Gpu::open("software").wait()?);
/// let mut uploaded = renderer.upload(&scene).wait()?;
/// for _ in 0..3 {
///     scene.transform_object(0, &Affine3A::from_translation(0.1 * Vec3::Y))?;
///     renderer.update(&mut uploaded, &scene, Update::Refit).wait()?;
///     renderer.pair(&uploaded, &camera).read().wait()?;
/// }
/// # Ok::<(), stereotrace::Error>(())
/// ```
pub trait Wait: IntoFuture + Sized {
    /// Runs the future to its end on the calling thread and returns its result.
    fn wait(self) -> Self::Output {
        pollster::block_on(self.into_future())
    }
}

impl<F: IntoFuture> Wait for F {}

/// Opens a device, uploads the scene and renders a stereo pair by [`Method::Auto`](crate::Method::Auto). For more than
/// one picture, keep a [`Renderer`]. This function blocks the calling thread.
///
/// # Errors
/// As [`Gpu::new`], [`Renderer::upload`] and [`FrameBuilder::read`](crate::FrameBuilder::read).
pub fn render_stereo(scene: &Scene, camera: &StereoCamera) -> Result<StereoPair, Error> {
    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let uploaded = renderer.upload(scene).wait()?;
    renderer.pair(&uploaded, camera).read().wait()
}
