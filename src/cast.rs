//! Rays of the caller's own through an uploaded scene: lists that start at one point.

use std::time::Duration;

use glam::Vec3;

use crate::{
    Error, MISS, Renderer, UploadedScene,
    bvh::Texel,
    gpu::{Timestamps, bind_group},
    kernels::{ANY_HITS, CLOSEST_HITS, Kernel},
    layout::{self, LIST_WORKGROUP},
};

/// Rays of one dispatch: two texels each stay far below every limit of textures and bindings.
pub(crate) const BATCH: usize = 1 << 20;

/// A ray from the point that its list belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Direction in the world, of any length but 0: t counts in it.
    pub direction: Vec3,
    /// The least t that counts as a hit, at least 0.
    pub t_min: f32,
    /// The largest one; `f32::INFINITY` for no limit.
    pub t_max: f32,
}

impl Ray {
    /// A ray without limits.
    pub fn new(direction: Vec3) -> Self {
        Self { direction, t_min: 0.0, t_max: f32::INFINITY }
    }
}

/// What a ray hits first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The point is `origin + t * direction`; `f32::INFINITY` where nothing is hit.
    pub t: f32,
    /// Id of the primitive in the scene's order, or [`MISS`].
    pub primitive: u32,
}

/// The answers to a list of rays, in its order, and what they cost.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Cast<T> {
    /// One a ray.
    pub hits: Vec<T>,
    /// Time of the tracing alone; `None` where the adapter has no timestamps.
    pub time: Option<Duration>,
}

impl Renderer {
    /// The nearest hit of each ray within its limits; of equal t the smallest primitive id. Rays that are neighbours in
    /// the list are traced together: the more alike they are, the faster.
    ///
    /// ```
    /// use stereotrace::{Gpu, Ray, Renderer, Scene, Sphere, glam::Vec3};
    ///
    /// let mut scene = Scene::new();
    /// let grey = scene.add_material("grey", Vec3::splat(0.5));
    /// scene.add_sphere(Sphere { center: Vec3::ZERO, radius: 1.0, material: grey })?;
    /// let mut renderer = Renderer::new(Gpu::new()?);
    /// let uploaded = renderer.upload(&scene)?;
    /// let cast = renderer.closest_hits(&uploaded, 4.0 * Vec3::Z, &[Ray::new(-Vec3::Z), Ray::new(Vec3::Z)])?;
    /// assert_eq!([cast.hits[0].t, cast.hits[1].t], [3.0, f32::INFINITY]);
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Ray`] for one without direction or with limits that are no numbers, [`Error::Scene`] for a scene that
    /// another [`Gpu`](crate::Gpu) holds, [`Error::DeviceLost`] and [`Error::OutOfMemory`].
    pub fn closest_hits(&mut self, scene: &UploadedScene, origin: Vec3, rays: &[Ray]) -> Result<Cast<RayHit>, Error> {
        let cast = pollster::block_on(self.cast::<[u32; 2]>(scene, origin, rays, &CLOSEST_HITS))?;
        let hit = |&[t, primitive]: &[u32; 2]| match primitive {
            MISS => RayHit { t: f32::INFINITY, primitive },
            _ => RayHit { t: f32::from_bits(t), primitive },
        };
        Ok(Cast { hits: cast.hits.iter().map(hit).collect(), time: cast.time })
    }

    /// Whether each ray hits anything within its limits: for shadows and visibility, faster than
    /// [`Renderer::closest_hits`].
    ///
    /// # Errors
    /// As [`Renderer::closest_hits`].
    pub fn any_hits(&mut self, scene: &UploadedScene, origin: Vec3, rays: &[Ray]) -> Result<Cast<bool>, Error> {
        let cast = pollster::block_on(self.cast::<u32>(scene, origin, rays, &ANY_HITS))?;
        Ok(Cast { hits: cast.hits.iter().map(|&found| found == 1).collect(), time: cast.time })
    }

    async fn cast<T: bytemuck::Pod>(
        &mut self,
        scene: &UploadedScene,
        origin: Vec3,
        rays: &[Ray],
        kernel: &Kernel,
    ) -> Result<Cast<T>, Error> {
        scene.belongs_to(&self.gpu)?;
        check(origin, rays)?;
        let mut cast = Cast { hits: Vec::with_capacity(rays.len()), time: Some(Duration::ZERO) };
        for batch in rays.chunks(BATCH) {
            let (hits, time) = self.cast_batch::<T>(scene, origin, batch, kernel).await?;
            cast.hits.extend(hits);
            cast.time = cast.time.zip(time).map(|(sum, time)| sum + time);
        }
        Ok(cast)
    }

    async fn cast_batch<T: bytemuck::Pod>(
        &mut self,
        scene: &UploadedScene,
        origin: Vec3,
        rays: &[Ray],
        kernel: &Kernel,
    ) -> Result<(Vec<T>, Option<Duration>), Error> {
        let gpu = &self.gpu;
        let with =
            crate::kernels::Specialisation { close: scene.large.any_close_to(&[origin]), ..scene.specialisation };
        let frame =
            layout::Frame { left_eye: origin.to_array(), image_size: [rays.len() as u32, 1], ..Default::default() };
        let mut timestamps = Timestamps::new(gpu);
        let launch = || {
            let pipeline = self.pipelines.get(gpu, kernel, with);
            let layouts = self.pipelines.layouts(with.traversal.fetch);
            let table = gpu.upload("rays", &texels(rays), with.traversal.fetch)?;
            let frame = gpu.uniform_buffer("frame", bytemuck::bytes_of(&frame));
            let found = gpu.storage_buffer("found", (size_of::<T>() * rays.len()) as u64);
            let counters = gpu.storage_buffer("counters", layout::COUNTERS as u64 * 4);
            let own = [&frame, &found, &counters].map(wgpu::Buffer::as_entire_binding);
            let own = bind_group(gpu, kernel.name, &pipeline.own, own.into_iter());
            let table = bind_group(gpu, "rays", &layouts.table, std::iter::once(table.binding()));
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let timestamp_writes = timestamps.as_mut().and_then(|timestamps| timestamps.next(kernel.name));
            let descriptor = wgpu::ComputePassDescriptor { label: Some(kernel.name), timestamp_writes };
            let mut pass = encoder.begin_compute_pass(&descriptor);
            pass.set_pipeline(&pipeline.pipeline);
            pass.set_bind_group(0, &scene.geometry, &[]);
            pass.set_bind_group(1, &own, &[]);
            pass.set_bind_group(2, &table, &[]);
            let side = kernel.block(&with);
            pass.dispatch_workgroups((rays.len() as u32).div_ceil(LIST_WORKGROUP * side * side), 1, 1);
            drop(pass);
            if let Some(timestamps) = &timestamps {
                timestamps.resolve(&mut encoder);
            }
            gpu.queue.submit([encoder.finish()]);
            Ok((found, counters))
        };
        let (found, counters) = gpu.checked(launch).await?;
        let words: Vec<u32> = gpu.read(&counters, layout::COUNTERS).await?;
        if words[layout::CUT_SHORT] > 0 {
            return Err(Error::cut_short(u64::from(words[layout::CUT_SHORT]), "threads"));
        }
        let time = match &timestamps {
            Some(timestamps) => timestamps.read(gpu).await?.map(|times| times.total()),
            None => None,
        };
        Ok((gpu.read(&found, rays.len()).await?, time))
    }
}

fn check(origin: Vec3, rays: &[Ray]) -> Result<(), Error> {
    if !origin.is_finite() {
        return Err(Error::Ray { index: 0, reason: format!("its origin is {origin}") });
    }
    for (index, ray) in rays.iter().enumerate() {
        let fault = |reason| Err(Error::Ray { index, reason });
        if !ray.direction.is_finite() || ray.direction.length_squared() < f32::MIN_POSITIVE {
            return fault(format!("its direction is {}", ray.direction));
        }
        if ray.t_min.is_nan() || ray.t_min < 0.0 || ray.t_max.is_nan() {
            return fault(format!("its limits are {} and {}; t_min is at least 0", ray.t_min, ray.t_max));
        }
    }
    Ok(())
}

/// As `shaders/shared/ray_list.wgsl` reads them.
fn texels(rays: &[Ray]) -> Vec<Texel> {
    let texels = rays.iter().flat_map(|ray| {
        let [x, y, z] = ray.direction.to_array().map(f32::to_bits);
        let t_max = ray.t_max.clamp(-crate::FAR, crate::FAR);
        [[x, y, z, ray.t_min.min(crate::FAR).to_bits()], [t_max.to_bits(), 0, 0, 0]]
    });
    texels.collect()
}
