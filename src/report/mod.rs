//! A report on an adapter: what it offers, how fast the methods are on it, and whether their pictures are right.

#[cfg(feature = "json")]
mod json;
mod measure;
mod page;

use std::{ops::ControlFlow, time::Duration};

use web_time::Instant;

use self::measure::{Staged, Test};
use crate::{Builtin, Calibration, Error, Gpu, GpuWork, Method, OnProgress, Progress, Rays, Renderer};

/// Scenes, sizes and methods of a report, and the time that it may take.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReportPlan {
    /// Scenes, in order.
    pub scenes: Vec<Builtin>,
    /// Sizes of a view in pixels, each larger than the one before.
    pub sizes: Vec<[u32; 2]>,
    /// Methods. [`Method::Naive`] and [`Method::Ideal`] are measured in any case, since others are compared with them.
    pub methods: Vec<Method>,
    /// Number of timed frames per method. Methods take turns.
    pub rounds: usize,
    /// Time that the report may take, about. A size of a scene that is expected to exceed it is left out. The first
    /// picture and the calibration are measured in any case.
    pub most: Duration,
}

impl Default for ReportPlan {
    /// Returns five scenes and all methods at 640x360, 1280x720 and 1920x1080, in at most a minute.
    fn default() -> Self {
        Self {
            scenes: vec![Builtin::Hall, Builtin::Spheres, Builtin::Near, Builtin::Random1000, Builtin::HallFinished],
            sizes: vec![[640, 360], [1280, 720], [1920, 1080]],
            methods: Method::ALL.to_vec(),
            rounds: 3,
            most: Duration::from_secs(60),
        }
    }
}

/// A report on an adapter ([`Report::measure`]).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// Version of this library.
    pub version: &'static str,
    /// Name, kind and backend of the adapter.
    pub adapter: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Whether rays are traced by ray queries ([`Gpu::has_ray_queries`]).
    pub ray_queries: bool,
    /// Limits of the device that scenes and pictures are checked against: name and value.
    pub limits: Vec<(&'static str, u64)>,
    /// Whether the device times passes. Without timestamps, times are those of the host's clock.
    pub timestamps: bool,
    /// Time from the first upload to the first pair, including the compilation of its kernels.
    pub first_picture: Duration,
    /// What `auto` chooses by, as measured for this report.
    pub calibration: Calibration,
    /// One entry per scene and size, in the order in which they were measured.
    pub entries: Vec<ReportEntry>,
    /// Scenes and sizes that were left out for lack of time.
    pub left_out: Vec<(Builtin, [u32; 2])>,
    /// Time that the report took.
    pub took: Duration,
}

/// Figures of a scene at one size.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReportEntry {
    /// The scene.
    pub scene: Builtin,
    /// Size of a view in pixels.
    pub size: [u32; 2],
    /// Number of primitives.
    pub primitives: usize,
    /// Size of the BVH and of the primitives on the device in bytes.
    pub scene_bytes: u64,
    /// Time to build and pack the BVH on the host.
    pub build: Duration,
    /// FNV-1a hash of the ids of the primitives that both eyes see by `naive`.
    pub ids: u64,
    /// Whether [`Self::ids`] equals the hash of a software adapter, which rounds each operation. `None` if that hash is
    /// not known for this size. Adapters that contract operations differ in a few pixels.
    pub has_known_ids: Option<bool>,
    /// Figures of each method. `naive` is the first and `ideal` the second.
    pub methods: Vec<ReportMethod>,
}

/// Figures of a method.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReportMethod {
    /// The method.
    pub method: Method,
    /// Time of a pair: the median of the rounds.
    pub pair: Duration,
    /// Shortest and longest time of a pair.
    pub range: [Duration; 2],
    /// Time of a pair by the host's clock, including submissions and waits: the median of the rounds.
    pub wall: Duration,
    /// Time of the second eye divided by the time of the first eye, which is the time of a pair by `ideal`.
    pub second_eye: f64,
    /// Rays of both eyes, by kind.
    pub rays: [Rays; 2],
    /// Share of right pixels that were traced, 0 to 1.
    pub retraced: f64,
    /// Percentage of right pixels with the colour that they have by `naive`.
    pub identical_percent: f64,
    /// Percentage of right pixels that show another surface than by `naive`.
    pub wrong_surface_percent: f64,
    /// Size of the buffers between passes in bytes.
    pub intermediate_bytes: u64,
    /// The method that `auto` chose for most rows.
    pub chosen: Option<Method>,
    /// Submissions, waits and dispatches of one pair.
    pub work: GpuWork,
}

impl Report {
    /// Measures an adapter. Memory and kernels of other renderers are not shared. But drivers may keep what they
    /// compiled, so the first picture of a machine takes longer. `progress` gets the name of the scene that comes next
    /// and the share that is done, and may stop the report.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if `progress` breaks, and the errors of [`Renderer::upload`] and
    /// [`FrameBuilder::read`](crate::FrameBuilder::read).
    pub async fn measure(gpu: &Gpu, plan: &ReportPlan, progress: &mut OnProgress<'_>) -> Result<Self, Error> {
        let begin = Instant::now();
        let mut renderer = Renderer::new(gpu.without_pipelines());
        let methods = methods_of(plan);
        let limits = gpu.device().limits();
        let mut report = Self {
            version: env!("CARGO_PKG_VERSION"),
            adapter: gpu.adapter_name(),
            driver: gpu.driver(),
            ray_queries: gpu.has_ray_queries(),
            limits: vec![
                ("max_buffer_size", limits.max_buffer_size),
                ("max_storage_buffer_binding_size", limits.max_storage_buffer_binding_size),
                ("max_texture_dimension_2d", limits.max_texture_dimension_2d.into()),
                ("max_compute_workgroup_storage_size", limits.max_compute_workgroup_storage_size.into()),
                ("max_compute_invocations_per_workgroup", limits.max_compute_invocations_per_workgroup.into()),
            ],
            timestamps: gpu.timestamps,
            first_picture: Duration::ZERO,
            calibration: renderer.calibration(),
            entries: Vec::new(),
            left_out: Vec::new(),
            took: Duration::ZERO,
        };
        let mut staged: Vec<Option<Staged>> = plan.scenes.iter().map(|_| None).collect();
        if let (Some(&scene), Some(&size)) = (plan.scenes.first(), plan.sizes.first()) {
            tell(progress, scene, 0.0)?;
            let (first, time) = Staged::first(&mut renderer, scene, size).await?;
            (staged[0], report.first_picture) = (Some(first), time);
            tell(progress, scene, 0.0)?;
        }
        report.calibration = renderer.calibrate().await?;
        let all = plan.sizes.len() * plan.scenes.len();
        let mut lasted: Vec<Option<f64>> = vec![None; plan.scenes.len()];
        for (index, size) in plan.sizes.iter().enumerate() {
            for (place, &scene) in plan.scenes.iter().enumerate() {
                let done = (index * plan.scenes.len() + place) as f32 / all as f32;
                let mut tell = || tell(progress, scene, done);
                tell()?;
                if begin.elapsed() > plan.most {
                    report.left_out.push((scene, *size));
                    continue;
                }
                let staged = match &mut staged[place] {
                    Some(staged) => staged,
                    slot => slot.insert(Staged::new(&renderer, scene).await?),
                };
                let test = Test { scene: staged, size: *size, methods: &methods, rounds: plan.rounds.max(1) };
                let pixels = f64::from(size[0]) * f64::from(size[1]);
                let expected = match lasted[place] {
                    Some(per_pixel) => Duration::from_secs_f64(per_pixel * pixels),
                    None => test.expected(&mut renderer).await?,
                };
                if begin.elapsed() + expected > plan.most {
                    report.left_out.push((scene, *size));
                    continue;
                }
                let (entry, frames) = test.measured(&mut renderer, &mut tell).await?;
                lasted[place] = Some(frames.as_secs_f64() / pixels);
                report.entries.push(entry);
            }
        }
        report.took = begin.elapsed();
        Ok(report)
    }

    /// Returns faults of the pictures: methods that promise the surfaces of `naive` and show others.
    pub fn faults(&self) -> Vec<String> {
        let of_entry = |entry: &ReportEntry| {
            let wrong =
                entry.methods.iter().filter(|row| promises_surfaces(row.method) && row.wrong_surface_percent > 0.0);
            let [width, height] = entry.size;
            let fault = |row: &ReportMethod| {
                let (scene, percent) = (entry.scene, row.wrong_surface_percent);
                format!("{scene} at {width}x{height}: {} shows another surface in {percent:.4}% of pixels", row.method)
            };
            Vec::from_iter(wrong.map(fault))
        };
        self.entries.iter().flat_map(of_entry).collect()
    }
}

/// Reports progress before a scene.
///
/// # Errors
/// [`Error::Cancelled`] if the caller stops the report.
fn tell(progress: &mut OnProgress<'_>, scene: Builtin, done: f32) -> Result<(), Error> {
    match progress(Progress { pass: scene.name(), done }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Cancelled),
    }
}

/// Returns whether a method promises the surfaces that `naive` shows.
fn promises_surfaces(method: Method) -> bool {
    matches!(method, Method::Naive | Method::Bracket(_) | Method::Auto)
}

/// Returns the methods of a plan after `naive` and `ideal`, each once.
fn methods_of(plan: &ReportPlan) -> Vec<Method> {
    let mut methods = vec![Method::Naive, Method::Ideal];
    for &method in &plan.methods {
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    methods
}

#[cfg(test)]
mod tests;
