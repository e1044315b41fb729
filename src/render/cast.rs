//! Traces the caller's rays through an uploaded scene.

use std::time::Duration;

use glam::{DVec3, Vec3};
#[cfg(not(target_arch = "wasm32"))]
use rayon::prelude::*;

use crate::{
    Error, MISS, RaysPerLane, Renderer, UploadedScene,
    frame::executor::{Executor, Resources, Workgroups},
    frame::lanes::{DISPATCHES, Lanes},
    gpu::Texel,
    gpu::{MAX_WORKGROUPS, Texels, Timestamps},
    kernel::layout::{self, LIST_WORKGROUP},
    kernel::variant::Variant,
    kernel::{Dispatches, Kernel, Resource, Role, kernel},
};

pub(crate) const CLOSEST_HITS: Kernel = kernel!("rays", "closest_hits", Role::RayList(Dispatches::One));
pub(crate) const ANY_HITS: Kernel = kernel!("rays", "any_hits", Role::RayList(Dispatches::One));
/// Kernel variants that trace in steps: an unfinished ray continues in the next dispatch.
pub(crate) const CLOSEST_HITS_IN_STEPS: Kernel =
    Kernel { name: "closest_hits_in_steps", role: Role::RayList(Dispatches::Many), ..CLOSEST_HITS };
pub(crate) const ANY_HITS_IN_STEPS: Kernel =
    Kernel { name: "any_hits_in_steps", role: Role::RayList(Dispatches::Many), ..ANY_HITS };

/// Maximum number of rays per dispatch. At two texels per ray, a batch stays far below all texture and binding limits.
pub(crate) const BATCH: usize = (MAX_WORKGROUPS * LIST_WORKGROUP) as usize;
/// Maximum number of distinct ray origins that are tested against large primitives. A batch with more origins is
/// assumed to be close to one.
const MANY_ORIGINS: usize = 64;

/// A ray given by the caller: the points `origin + t * direction` with `t_min <= t <= t_max`.
///
/// ```
/// use stereotrace::{Ray, glam::Vec3};
///
/// let to_the_light = Ray::new(Vec3::ZERO, Vec3::new(0.0, 5.0, 0.0)).t_min(1e-4).t_max(1.0);
/// assert_eq!(to_the_light.t_max, 1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ray {
    /// Origin in world coordinates. The ray starts at the nearest f32 position relative to
    /// [`Scene::origin`](crate::Scene::origin).
    pub origin: DVec3,
    /// Direction in world coordinates, of any length but 0; t is in units of this length.
    pub direction: Vec3,
    /// Smallest t of a hit, at least 0. Rays that start on a surface need a value above 0 to avoid hitting it.
    pub t_min: f32,
    /// Largest t of a hit; `f32::INFINITY` for no limit.
    pub t_max: f32,
}

impl Ray {
    /// Creates a ray without limits.
    pub fn new(origin: impl Into<DVec3>, direction: Vec3) -> Self {
        Self { origin: origin.into(), direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// Sets the smallest t of a hit, at least 0.
    pub fn t_min(mut self, t_min: f32) -> Self {
        self.t_min = t_min;
        self
    }

    /// Sets the largest t of a hit.
    pub fn t_max(mut self, t_max: f32) -> Self {
        self.t_max = t_max;
        self
    }
}

/// Closest hit of a ray. [`Scene::surface`](crate::Scene::surface) returns its normals, barycentric and texture
/// coordinates, object and material.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RayHit {
    /// Parameter of the hit point `origin + t * direction`; `f32::INFINITY` for a miss.
    pub t: f32,
    /// Id of the primitive in the scene's order, or [`MISS`].
    pub primitive: u32,
}

/// Results for a list of rays, in the order of the rays, and the time of tracing.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Cast<T> {
    /// One result per ray.
    pub hits: Vec<T>,
    /// GPU time of the tracing. It is `None` if the adapter has no timestamps, or if there were too many dispatches to
    /// time.
    pub time: Option<Duration>,
}

impl Renderer {
    /// Returns the nearest hit of each ray within its limits; at equal t, the smallest primitive id wins. Neighbouring
    /// rays of the list are traced together, so coherent neighbours are faster. With four rays per lane
    /// (docs/TRAVERSAL.md), each four consecutive rays must have one origin. Otherwise each lane traces one ray.
    ///
    /// # Errors
    /// [`Error::Ray`] for a ray without direction or with NaN limits, [`Error::ForeignScene`] for a scene on another
    /// [`Gpu`](crate::Gpu), [`Error::DeviceLost`] and [`Error::OutOfMemory`].
    pub async fn closest_hits(&self, scene: &UploadedScene, rays: &[Ray]) -> Result<Cast<RayHit>, Error> {
        let cast = self.cast::<[u32; 2]>(scene, rays, [&CLOSEST_HITS, &CLOSEST_HITS_IN_STEPS]).await?;
        let hit = |&[t, primitive]: &[u32; 2]| match primitive {
            MISS => RayHit { t: f32::INFINITY, primitive },
            _ => RayHit { t: f32::from_bits(t), primitive },
        };
        Ok(Cast { hits: cast.hits.iter().map(hit).collect(), time: cast.time })
    }

    /// Returns whether each ray hits anything within its limits. This suits shadow and visibility rays, and is faster
    /// than [`Renderer::closest_hits`].
    ///
    /// # Errors
    /// The errors of [`Renderer::closest_hits`].
    pub async fn any_hits(&self, scene: &UploadedScene, rays: &[Ray]) -> Result<Cast<bool>, Error> {
        let cast = self.cast::<u32>(scene, rays, [&ANY_HITS, &ANY_HITS_IN_STEPS]).await?;
        Ok(Cast { hits: cast.hits.iter().map(|&found| found == 1).collect(), time: cast.time })
    }

    /// Traces each batch with the first kernel. If the adapter ends its loops early, the second kernel traces the batch
    /// again in steps.
    async fn cast<T: bytemuck::Pod>(
        &self,
        scene: &UploadedScene,
        rays: &[Ray],
        [at_once, in_steps]: [&'static Kernel; 2],
    ) -> Result<Cast<T>, Error> {
        scene.belongs_to(&self.gpu)?;
        check(rays)?;
        let mut cast = Cast { hits: Vec::with_capacity(rays.len()), time: Some(Duration::ZERO) };
        for batch in rays.chunks(BATCH) {
            if !self.steps.always {
                let mut list = List::new(self, scene, batch, size_of::<T>()).await?;
                if list.dispatch(at_once, 1).await? == 0 {
                    list.read(&mut cast).await?;
                    continue;
                }
            }
            for part in batch.chunks(self.steps.threads as usize) {
                let mut list = List::new(self, scene, part, size_of::<T>()).await?;
                list.trace_in_steps(in_steps).await?;
                list.read(&mut cast).await?;
            }
        }
        Ok(cast)
    }
}

/// Buffers for tracing a list of rays on the device, and for its results.
struct List<'a> {
    renderer: &'a Renderer,
    variant: Variant,
    count: u32,
    frame: wgpu::Buffer,
    found: wgpu::Buffer,
    counters: wgpu::Buffer,
    /// Resources that the kernel binds: the buffers above, the rays, and the scene's resources.
    resources: Resources,
    /// The packed rays, in texels.
    _rays: Texels,
    timestamps: Option<Timestamps>,
}

impl<'a> List<'a> {
    async fn new(
        renderer: &'a Renderer,
        scene: &'a UploadedScene,
        rays: &[Ray],
        answer_bytes: usize,
    ) -> Result<Self, Error> {
        let gpu = &renderer.gpu;
        let fetch = scene.variant.traversal.fetch;
        let count = rays.len() as u32;
        let band = layout::Band { size: [count, 1], ..Default::default() };
        let frame = layout::Frame { band, ..Default::default() };
        let texels = gpu.upload("rays", &texels(rays, scene.origin), fetch).await?;
        let make = || {
            let frame = gpu.uniform_buffer("frame", bytemuck::bytes_of(&frame));
            let found = gpu.storage_buffer("found", (answer_bytes * rays.len()) as u64);
            let counters = gpu.storage_buffer("counters", layout::COUNTERS as u64 * 4);
            let mut resources = Resources::default()
                .with(Resource::Frame, &frame)
                .with(Resource::Found, &found)
                .with(Resource::Counters, &counters)
                .with(Resource::RayList, &texels);
            scene.resources(&mut resources);
            let timestamps = Timestamps::new(gpu);
            let variant = variant_for(scene, rays);
            Ok(Self { renderer, variant, count, frame, found, counters, resources, _rays: texels, timestamps })
        };
        gpu.checked(make).await
    }

    fn threads(&self) -> u32 {
        self.count.div_ceil(self.variant.traversal.rays.block().pow(2))
    }

    /// Runs a kernel in `times` dispatches. Returns the number of threads whose loops the adapter ended early.
    async fn dispatch(&mut self, kernel: &Kernel, times: u32) -> Result<u32, Error> {
        let gpu = &self.renderer.gpu;
        let workgroups = Workgroups::Number([self.threads().div_ceil(LIST_WORKGROUP), 1, 1]);
        let launch = || {
            let mut executor = Executor::new(gpu, &self.renderer.kernels, None, self.timestamps.as_mut());
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            for _ in 0..times {
                executor.run(&mut encoder, kernel.name, (kernel, self.variant), &self.resources, workgroups);
            }
            gpu.submit([encoder.finish()]);
            Ok(())
        };
        gpu.checked(launch).await?;
        let words: Vec<u32> = gpu.read(&self.counters, layout::COUNTERS).await?;
        Ok(words[layout::CUT_SHORT])
    }

    async fn trace_in_steps(&mut self, kernel: &Kernel) -> Result<(), Error> {
        let gpu = &self.renderer.gpu;
        let lanes = Lanes::new(gpu, &self.variant, self.threads()).await?;
        lanes.begin(gpu, self.threads(), self.renderer.steps.rounds).await?;
        self.resources.set(Resource::Steps, &lanes.buffer);
        loop {
            match self.dispatch(kernel, DISPATCHES).await? {
                0 if lanes.unfinished(gpu).await? == 0 => return Ok(()),
                0 => {}
                threads => return Err(Error::cut_short(u64::from(threads))),
            }
        }
    }

    /// Reads the results and the GPU time back, and appends them to `cast`.
    async fn read<T: bytemuck::Pod>(&mut self, cast: &mut Cast<T>) -> Result<(), Error> {
        let gpu = &self.renderer.gpu;
        let time = match &mut self.timestamps {
            Some(timestamps) => timestamps.read(gpu).await?.map(|times| times.total()),
            None => None,
        };
        cast.hits.extend(gpu.read::<T>(&self.found, self.count as usize).await?);
        cast.time = cast.time.zip(time).map(|(sum, time)| sum + time);
        Ok(())
    }
}

impl Drop for List<'_> {
    fn drop(&mut self) {
        for buffer in [&self.frame, &self.found, &self.counters] {
            buffer.destroy(); // frees the memory at once, as for `Texels`
        }
    }
}

/// Returns the pipeline variant that suits these rays.
fn variant_for(scene: &UploadedScene, rays: &[Ray]) -> Variant {
    let mut with = scene.variant;
    let place = |ray: &Ray| (ray.origin - scene.origin).as_vec3();
    let alike = |lane: &[Ray]| lane.iter().all(|ray| place(ray) == place(&lane[0]));
    if !rays.chunks(with.traversal.rays.block().pow(2) as usize).all(alike) {
        with.traversal.rays = RaysPerLane::One;
    }
    let mut origins: Vec<Vec3> = Vec::new();
    for origin in rays.iter().map(place) {
        if origins.last() != Some(&origin) {
            origins.push(origin);
        }
        if origins.len() > MANY_ORIGINS {
            break;
        }
    }
    with.close = origins.len() > MANY_ORIGINS || scene.large.any_close_to(&origins);
    with
}

fn check(rays: &[Ray]) -> Result<(), Error> {
    for (index, ray) in rays.iter().enumerate() {
        let fault = |reason| Err(Error::Ray { index, reason });
        if !ray.origin.is_finite() {
            return fault(format!("its origin is {}; it must be finite", ray.origin));
        }
        if !ray.direction.is_finite() || ray.direction.length_squared() < f32::MIN_POSITIVE {
            return fault(format!("its direction is {}; it must be finite and not 0", ray.direction));
        }
        if ray.t_min.is_nan() || ray.t_min < 0.0 || ray.t_max.is_nan() {
            return fault(format!("its limits are {} and {}; t_min must be at least 0", ray.t_min, ray.t_max));
        }
    }
    Ok(())
}

/// Packs rays in the layout that `shaders/shared/ray_list.wgsl` reads.
fn texels(rays: &[Ray], scene_origin: DVec3) -> Vec<Texel> {
    let pair = |ray: &Ray| {
        let texel = |vector: Vec3, t: f32| {
            let [x, y, z] = vector.to_array();
            [x, y, z, t].map(f32::to_bits)
        };
        let t_max = ray.t_max.clamp(-crate::FAR, crate::FAR);
        [texel(ray.direction, ray.t_min.min(crate::FAR)), texel((ray.origin - scene_origin).as_vec3(), t_max)]
    };
    #[cfg(not(target_arch = "wasm32"))]
    return rays.par_iter().map(pair).collect::<Vec<[Texel; 2]>>().into_flattened();
    #[cfg(target_arch = "wasm32")]
    rays.iter().flat_map(pair).collect()
}
