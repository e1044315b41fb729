//! The device, its limits, errors and loss.

use std::{
    future::Future,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use super::{
    acceleration::RAY_QUERIES,
    adapter::{Adapter, describe},
    pipelines::Held,
    work::{Counted, GpuWork},
};
use crate::Error;

/// A graphics device and its properties. Cloning is cheap and shares the device.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    pub(crate) limits: wgpu::Limits,
    pub(crate) timestamps: bool,
    ray_queries: bool,
    lost: Arc<Mutex<Option<String>>>,
    pub(super) pipelines: Arc<Held>,
    pub(crate) counted: Arc<Counted>,
    /// Held while a thread polls the device.
    #[cfg(not(target_arch = "wasm32"))]
    pub(super) polling: Arc<Mutex<()>>,
}

/// Locks a mutex. If another thread's panic poisoned it, its value is still consistent here.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Maximum number of workgroups of a dispatch per dimension.
pub(crate) const MAX_WORKGROUPS: u32 = 1 << 14;

/// Returns the limits that kernels need of a device; all other limits are taken from `others`. A test compares them
/// with the needs of all kernels.
pub(crate) fn limits_over(others: wgpu::Limits) -> wgpu::Limits {
    wgpu::Limits {
        max_bind_groups: 1,
        max_bindings_per_bind_group: 11,
        max_storage_buffers_per_shader_stage: 7,
        max_storage_textures_per_shader_stage: 3,
        max_uniform_buffers_per_shader_stage: 2,
        max_buffers_and_acceleration_structures_per_shader_stage: 9,
        max_compute_invocations_per_workgroup: 64,
        max_compute_workgroup_storage_size: 4864,
        max_compute_workgroup_size_x: 64,
        max_compute_workgroup_size_y: 8,
        max_compute_workgroup_size_z: 1,
        max_compute_workgroups_per_dimension: MAX_WORKGROUPS,
        ..others
    }
}

impl Gpu {
    /// Opens a new device on [`Adapter::FromEnv`].
    ///
    /// # Errors
    /// See [`Gpu::open`].
    pub async fn new() -> Result<Self, Error> {
        Self::open(Adapter::FromEnv).await
    }

    /// Opens a device on an adapter, given as an [`Adapter`] or as a text: `software`, or a part of its name. If
    /// several adapters match, one of the fastest kind is used. The environment variable `WGPU_BACKEND` restricts the
    /// choice to a backend (`vulkan`, `gl`, …).
    ///
    /// # Errors
    /// [`Error::NoAdapter`] if none matches, with the request and the available adapters; [`Error::Gpu`] if the driver
    /// refuses to open it.
    pub async fn open(adapter: impl Into<Adapter>) -> Result<Self, Error> {
        let adapter = adapter.into().find().await?;
        let wanted = std::env::var_os(RAY_QUERIES_VARIABLE).is_some_and(|value| value == "1");
        match wanted && adapter.features().contains(RAY_QUERIES) {
            true => Self::request(&adapter, true).await?.with_ray_queries(),
            false => Self::request(&adapter, false).await,
        }
    }

    /// Opens a device as [`Gpu::open`] does. Renderers on it trace rays by ray queries, in hardware where there is
    /// some ([`Gpu::with_ray_queries`]). wgpu calls its ray queries experimental: they may have faults that safe code
    /// can meet. The environment variable `STEREOTRACE_RAY_QUERIES=1` makes [`Gpu::open`] use them on adapters that
    /// have them.
    ///
    /// # Errors
    /// The errors of [`Gpu::open`]; [`Error::NoAdapter`] if the adapter has no ray queries.
    pub async fn open_with_ray_queries(adapter: impl Into<Adapter>) -> Result<Self, Error> {
        let adapter = adapter.into().find().await?;
        if !adapter.features().contains(RAY_QUERIES) {
            let reason = format!("{} has none", describe(&adapter.get_info()));
            return Err(Error::NoAdapter { wanted: " with ray queries".into(), reason });
        }
        Self::request(&adapter, true).await?.with_ray_queries()
    }

    async fn request(adapter: &wgpu::Adapter, ray_queries: bool) -> Result<Self, Error> {
        let timestamps = adapter.features() & wgpu::Features::TIMESTAMP_QUERY;
        let (more, experimental_features) = match ray_queries {
            true => (RAY_QUERIES, experimental_features()),
            false => (wgpu::Features::empty(), wgpu::ExperimentalFeatures::disabled()),
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("stereotrace"),
            required_features: timestamps | more,
            required_limits: adapter.limits(),
            experimental_features,
            ..Default::default()
        };
        let (device, queue) =
            adapter.request_device(&descriptor).await.map_err(|error| Error::Gpu(error.to_string()))?;
        let gpu = Self::from_device(device, queue)?;
        let lost = gpu.lost.clone();
        gpu.device.set_device_lost_callback(move |reason, message| {
            log::warn!("device lost ({reason:?}): {message}");
            *lock(&lost) = Some(format!("{reason:?} {message}").trim().to_owned());
        });
        let name = gpu.adapter_name();
        gpu.device.on_uncaptured_error(Arc::new(move |error| log::error!("{name}: {error}")));
        log::info!("adapter: {}", gpu.adapter_name());
        Ok(gpu)
    }

    /// Returns the features that a device must have: none. With `TIMESTAMP_QUERY`, frames can be timed.
    pub fn required_features() -> wgpu::Features {
        wgpu::Features::empty()
    }

    /// Returns the minimum limits of a device. None exceeds WebGPU's defaults. A device with larger
    /// `max_storage_buffer_binding_size`, `max_buffer_size` and `max_texture_dimension_2d` accepts larger scenes and
    /// pictures. Each scene and each picture is checked against them.
    ///
    /// ```no_run
    /// # async fn open(adapter: stereotrace::wgpu::Adapter) -> Result<(), Box<dyn std::error::Error>> {
    /// use stereotrace::{Gpu, Renderer, wgpu};
    ///
    /// let descriptor = wgpu::DeviceDescriptor {
    ///     required_features: Gpu::required_features() | (adapter.features() & wgpu::Features::TIMESTAMP_QUERY),
    ///     required_limits: Gpu::required_limits().or_better_values_from(&adapter.limits()),
    ///     ..Default::default()
    /// };
    /// let (device, queue) = adapter.request_device(&descriptor).await?;
    /// let renderer = Renderer::new(Gpu::from_device(device, queue)?);
    /// # Ok(())
    /// # }
    /// ```
    pub fn required_limits() -> wgpu::Limits {
        limits_over(wgpu::Limits::downlevel_defaults())
    }

    /// Uses the caller's device, which keeps its own handlers for errors and loss.
    ///
    /// # Errors
    /// [`Error::Limit`] naming the first limit below [`Gpu::required_limits`].
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Result<Self, Error> {
        let limits = device.limits();
        let mut short = None;
        limits_over(limits.clone()).check_limits_with_fail_fn(&limits, true, |limit, needed, allowed| {
            short = Some(Error::Limit {
                what: "rendering".into(),
                needed: needed.to_string(),
                limit,
                allowed: allowed.to_string(),
                remedy: "open the device with Gpu::required_limits(), or use another adapter",
            });
        });
        if let Some(error) = short {
            return Err(error);
        }
        Ok(Self {
            info: device.adapter_info(),
            limits,
            timestamps: device.features().contains(wgpu::Features::TIMESTAMP_QUERY),
            ray_queries: false,
            lost: Arc::default(),
            pipelines: Arc::default(),
            counted: Arc::default(),
            #[cfg(not(target_arch = "wasm32"))]
            polling: Arc::default(),
            device,
            queue,
        })
    }

    /// Returns whether both are clones of the same `Gpu`. (Devices of different instances can compare equal.)
    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.lost, &other.lost)
    }

    /// Returns the adapter's name, kind and backend.
    pub fn adapter_name(&self) -> String {
        describe(&self.info)
    }

    /// Returns the driver's name and version.
    pub fn driver(&self) -> String {
        format!("{} {}", self.info.driver, self.info.driver_info).trim().to_owned()
    }

    /// Returns wgpu's information on the adapter.
    pub fn adapter_info(&self) -> &wgpu::AdapterInfo {
        &self.info
    }

    /// Returns the device, which is shared.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// Returns the queue, which is shared.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Returns the same device, for renderers that share no pipelines with others.
    pub(crate) fn without_pipelines(&self) -> Self {
        Self { pipelines: Arc::default(), ..self.clone() }
    }

    /// Returns the work that this `Gpu` and its clones have given to the device so far.
    pub fn work(&self) -> GpuWork {
        self.counted.so_far()
    }

    /// Lets renderers on this device trace rays by ray queries. A caller's device must have been created with the
    /// feature `EXPERIMENTAL_RAY_QUERY`, with limits for acceleration structures, such as those of
    /// `wgpu::Limits::using_minimum_supported_acceleration_structure_values`, and with one more binding per bind group
    /// than [`Gpu::required_limits`].
    ///
    /// Hits are those of the kernels' own traversal, but a ray may miss a triangle that it sees edge-on. Kernels that
    /// count or run in several dispatches, and those that draw primitives, use no queries.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] if the device lacks the feature or a limit.
    pub fn with_ray_queries(mut self) -> Result<Self, Error> {
        if let Some(lacking) = lacking_for_ray_queries(&self.device) {
            let reason = format!("the device of {} lacks {lacking}", self.adapter_name());
            return Err(Error::NoAdapter { wanted: " with ray queries".into(), reason });
        }
        self.ray_queries = true;
        Ok(self)
    }

    /// Returns whether renderers on this device trace rays by ray queries ([`Gpu::with_ray_queries`]).
    pub fn has_ray_queries(&self) -> bool {
        self.ray_queries
    }

    /// Returns the size of the largest storage buffer that a kernel can bind, in bytes.
    pub(crate) fn binding_limit(&self) -> u64 {
        self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size)
    }

    /// Runs `work`, and returns its result once the driver has reported any errors. `work` must not await, since the
    /// driver's errors are collected per thread.
    pub(crate) fn checked<T>(&self, work: impl FnOnce() -> Result<T, Error>) -> impl Future<Output = Result<T, Error>> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let scopes = [OutOfMemory, Internal, Validation].map(|filter| self.device.push_error_scope(filter));
        let result = work();
        // Error scopes form a stack.
        let [memory, internal, validation] = scopes;
        let validation = validation.pop();
        let internal = internal.pop();
        let memory = memory.pop();
        let lost = self.lost.clone();
        async move {
            let errors = [memory.await, internal.await, validation.await];
            if let Some(reason) = lock(&lost).clone() {
                return Err(Error::DeviceLost(reason));
            }
            match errors.into_iter().flatten().next() {
                Some(error) => Err(classify(&error)),
                None => result,
            }
        }
    }

    /// Returns the number of host threads on which a software adapter runs kernels; 1 for other adapters. Each of them
    /// runs one contiguous part of a dispatch.
    pub(crate) fn threads(&self) -> u32 {
        match self.adapter_info().device_type {
            wgpu::DeviceType::Cpu => {
                std::thread::available_parallelism().map_or(1, |threads| threads.get().min(32) as u32)
            }
            _ => 1,
        }
    }

    /// Returns why the device was lost, if it was.
    pub(super) fn loss(&self) -> Option<String> {
        lock(&self.lost).clone()
    }
}

/// Name of the environment variable with which [`Gpu::open`] uses ray queries: `1`, on adapters that have them.
const RAY_QUERIES_VARIABLE: &str = "STEREOTRACE_RAY_QUERIES";

/// Agrees to the use of wgpu's experimental features.
#[expect(unsafe_code, reason = "wgpu asks for this agreement; only a caller who wants ray queries gives it")]
fn experimental_features() -> wgpu::ExperimentalFeatures {
    // SAFETY: the function only asks to accept that experimental features may have faults. Callers accept that by
    // asking for ray queries, and kernels keep to the rules of wgpu's specification of them.
    unsafe { wgpu::ExperimentalFeatures::enabled() }
}

/// Returns the feature or limit that a device lacks for ray queries. Kernels bind an acceleration structure in addition
/// to their other resources.
fn lacking_for_ray_queries(device: &wgpu::Device) -> Option<&'static str> {
    let limits = device.limits();
    let others = limits_over(limits.clone());
    let needs = [
        (device.features().contains(RAY_QUERIES), "EXPERIMENTAL_RAY_QUERY"),
        (limits.max_bindings_per_bind_group > others.max_bindings_per_bind_group, "max_bindings_per_bind_group"),
        (
            limits.max_buffers_and_acceleration_structures_per_shader_stage
                > others.max_buffers_and_acceleration_structures_per_shader_stage,
            "max_buffers_and_acceleration_structures_per_shader_stage",
        ),
        (limits.max_acceleration_structures_per_shader_stage > 0, "max_acceleration_structures_per_shader_stage"),
        (limits.max_tlas_instance_count > 0, "max_tlas_instance_count"),
        (limits.max_blas_geometry_count > 0, "max_blas_geometry_count"),
    ];
    needs.into_iter().find(|(is_there, _)| !is_there).map(|(_, name)| name)
}

#[cfg(test)]
impl Gpu {
    /// Opens a device of the adapter under test: a software adapter, unless the environment names another.
    pub(crate) fn under_test() -> Self {
        let wanted = std::env::var(super::ADAPTER_VARIABLE).unwrap_or_else(|_| "software".into());
        pollster::block_on(Self::open(wanted)).unwrap()
    }

    /// Returns whether results must agree bit for bit. Software Vulkan neither contracts nor reorders operations in
    /// f32.
    pub(crate) fn is_exact(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu && self.info.backend == wgpu::Backend::Vulkan
    }
}

fn classify(error: &wgpu::Error) -> Error {
    match error {
        wgpu::Error::OutOfMemory { .. } => Error::OutOfMemory(error.to_string()),
        // A lost device silently creates invalid objects, and wgpu reports their use as a validation error. Any other
        // failure to create an object has been reported before and comes first.
        other => match other.to_string() {
            message if ["lost", "destroyed", "label is invalid"].iter().any(|sign| message.contains(sign)) => {
                Error::DeviceLost(message)
            }
            message => Error::Gpu(message),
        },
    }
}
