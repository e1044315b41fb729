//! The renderer: renders stereo pairs and views from scenes and cameras.

use std::sync::Once;

use crate::{
    Calibration, Gpu, Method, Options, Pose,
    frame::{self, lanes::Steps},
    gpu::Timestamps,
    kernel::Kernels,
    kernel::traversal::Traversal,
    view::rig::Eyes,
};

/// Renders stereo pairs, and keeps kernels and buffers between frames.
///
/// ```no_run
/// use stereotrace::{Builtin, Gpu, Method, Options, Renderer, blocking::Wait};
///
/// let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(800, 600));
/// let mut renderer = Renderer::new(Gpu::new().wait()?);
/// let uploaded = renderer.upload(&scene).wait()?;
/// for method in [Method::Naive, Method::ATOMIC] {
///     let options = Options::new(method).count(true);
///     let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait()?;
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
    /// Maximum size of the buffers in which bands in flight wait to be read.
    pub(crate) read_back_bytes: u64,
    /// Number of runs that rows of workgroups are divided into (`launched_row` of shaders/shared/pixels.wgsl).
    pub(crate) runs: u32,
    /// Whether `bracket` searches each tile by a workgroup. A thread per tile would leave most of a GPU idle.
    pub(crate) searches_together: bool,
    /// Whether kernels that trace secondary rays or paths do not shade their hits.
    pub(crate) shades_apart: bool,
    pub(crate) steps: Steps,
    /// What `Auto` chooses by.
    pub(crate) calibration: Calibration,
    /// Completed once the warning about a scene far from its origin was logged.
    pub(crate) rounding_warned: Once,
    /// Completed once the warning about pairs without common rows was logged.
    apart_warned: Once,
}

impl Renderer {
    /// Creates a renderer on a device.
    pub fn new(gpu: Gpu) -> Self {
        let traversal = Traversal::of(&gpu);
        Self::by(gpu, traversal)
    }

    /// Creates a renderer with a given traversal: for measurements, or where [`Traversal::of`] chose badly.
    #[cfg(any(test, feature = "testing"))]
    pub fn with_traversal(gpu: Gpu, traversal: Traversal) -> Self {
        Self::by(gpu, traversal)
    }

    fn by(gpu: Gpu, traversal: Traversal) -> Self {
        let calibration = Calibration::of(&gpu);
        let has_many_threads = gpu.adapter_info().device_type != wgpu::DeviceType::Cpu;
        Self {
            traversal,
            kernels: Kernels::default(),
            cache: frame::Cache::default(),
            timestamps: Timestamps::new(&gpu),
            band_pixels: frame::band_pixels(&gpu, calibration.ray_seconds),
            read_back_bytes: frame::read_back_bytes(&gpu),
            runs: gpu.threads(),
            searches_together: has_many_threads,
            shades_apart: has_many_threads,
            steps: Steps::default(),
            calibration,
            rounding_warned: Once::new(),
            apart_warned: Once::new(),
            gpu,
        }
    }

    /// Forgets the samples of earlier frames ([`Options::history`]). The next frame depends on no other.
    pub fn forget(&mut self) {
        self.cache.history = None;
    }

    /// Returns the device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Returns the eyes of a pair whose rows are not epipolar lines, each with a frame of its own, or `None` for other
    /// pairs.
    pub(super) fn apart(&self, pose: &Pose, options: &Options) -> Option<[Eyes; 2]> {
        let name = pose.projection.without_rows()?;
        if options.method != Method::Naive {
            let method = options.method;
            self.apart_warned.call_once(|| {
                log::warn!(
                    "{name} share no rows, so nothing can be reused: tracing both eyes (naive) instead of {method}"
                );
            });
        }
        Some([-1.0, 1.0].map(|side| Eyes::mono(pose.of_eye(side))))
    }
}
