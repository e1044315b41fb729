//! The device: which adapter it is of, its limits, its errors and its loss.

use std::{
    future::Future,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use crate::{Error, kernels};

/// The variable that chooses the adapter: `software`, or a part of its name. wgpu's own `WGPU_BACKEND` chooses the backend
/// besides: `vulkan`, `gl`, `dx12` or `metal`.
pub const ADAPTER_VARIABLE: &str = "STEREOTRACE_ADAPTER";
/// A graphics device and what is known of it. Cloning is cheap and shares the device.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    pub(crate) limits: wgpu::Limits,
    pub(crate) timestamps: bool,
    lost: Arc<Mutex<Option<String>>>,
}

/// A lock that another thread's panic poisoned still guards whole values here.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Gpu {
    /// Opens a device, blocking. See [`Gpu::new_async`].
    ///
    /// # Errors
    /// [`Error::NoAdapter`] if there is none, or none that `STEREOTRACE_ADAPTER` asks for.
    pub fn new() -> Result<Self, Error> {
        pollster::block_on(Self::new_async())
    }

    /// Opens a device of its own: the one that the environment variable `STEREOTRACE_ADAPTER` chooses (`software`, or
    /// a part of an adapter's name), else the fastest kind there is: discrete, integrated, virtual, software.
    /// `WGPU_BACKEND` narrows the choice to a backend (`vulkan`, `gl`, …).
    ///
    /// # Errors
    /// [`Error::NoAdapter`], saying what there is, or [`Error::Gpu`] if the driver refuses to open it.
    pub async fn new_async() -> Result<Self, Error> {
        Self::choose(std::env::var(ADAPTER_VARIABLE).ok().as_deref()).await
    }

    /// Opens an adapter by name, blocking: `software`, or a part of its name.
    ///
    /// # Errors
    /// As [`Gpu::new_async`].
    pub fn open(adapter: &str) -> Result<Self, Error> {
        pollster::block_on(Self::choose(Some(adapter)))
    }

    async fn choose(wanted: Option<&str>) -> Result<Self, Error> {
        // OpenGL last, and only if nothing else fits: the same hardware shows up there a second time, with fewer
        // features, and looking for it can make the driver print to the terminal.
        let chosen = wgpu::Backends::from_env();
        let tries = chosen.map_or_else(|| vec![wgpu::Backends::PRIMARY, wgpu::Backends::GL], |backends| vec![backends]);
        let mut names = Vec::new();
        for backends in tries {
            let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
            descriptor.backends = backends;
            let mut adapters = wgpu::Instance::new(descriptor).enumerate_adapters(backends).await;
            // Stable: among equals the driver's own order stands.
            adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
            names.extend(adapters.iter().map(|adapter| describe(&adapter.get_info())));
            if let Some(adapter) = adapters.into_iter().find(|adapter| is_wanted(&adapter.get_info(), wanted)) {
                return Self::request(&adapter).await;
            }
        }
        Err(Error::NoAdapter {
            wanted: asked(wanted, std::env::var("WGPU_BACKEND").ok().as_deref()),
            reason: match names.as_slice() {
                [] => "no Vulkan, Metal, DirectX 12 or OpenGL driver offers one".into(),
                names => format!("there are: {}", names.join(", ")),
            },
        })
    }

    async fn request(adapter: &wgpu::Adapter) -> Result<Self, Error> {
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("stereotrace"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: adapter.limits(),
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

    /// The features that a device must have: none. Frames are timed where it has `TIMESTAMP_QUERY`.
    pub fn required_features() -> wgpu::Features {
        wgpu::Features::empty()
    }

    /// The limits that a device must have at least, none of them over WebGPU's defaults. A device with more of
    /// `max_storage_buffer_binding_size`, `max_buffer_size` and `max_texture_dimension_2d` takes larger scenes and
    /// pictures: each is checked when it comes.
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
        kernels::limits_over(wgpu::Limits::downlevel_defaults())
    }

    /// Uses a device of the caller's. It keeps its own handlers for errors and loss.
    ///
    /// # Errors
    /// [`Error::Limit`], naming the first limit below [`Gpu::required_limits`] that kernels need.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Result<Self, Error> {
        let limits = device.limits();
        let mut short = None;
        kernels::limits_over(limits.clone()).check_limits_with_fail_fn(&limits, true, |limit, needed, allowed| {
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
            lost: Arc::default(),
            device,
            queue,
        })
    }

    /// The same Gpu, or a clone of it. (Devices of different instances can compare equal.)
    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.lost, &other.lost)
    }

    /// The adapter's name, kind and backend.
    pub fn adapter_name(&self) -> String {
        describe(&self.info)
    }

    /// The driver's name and version.
    pub fn driver(&self) -> String {
        format!("{} {}", self.info.driver, self.info.driver_info).trim().to_owned()
    }

    /// What wgpu knows of the adapter.
    pub fn adapter_info(&self) -> &wgpu::AdapterInfo {
        &self.info
    }

    /// The device, shared.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue, shared.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Largest storage buffer that a kernel can bind, in bytes.
    pub(crate) fn binding_limit(&self) -> u64 {
        self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size)
    }

    /// Runs `work` and returns its result once the driver has said whether something in it failed. `work` must not await:
    /// the driver's errors are collected by thread.
    pub(crate) fn checked<T>(&self, work: impl FnOnce() -> Result<T, Error>) -> impl Future<Output = Result<T, Error>> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let scopes = [OutOfMemory, Internal, Validation].map(|filter| self.device.push_error_scope(filter));
        let result = work();
        // Scopes are a stack.
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

    /// Blocks until all submitted work is done, or until a submission is. In a browser it returns at once.
    pub(crate) fn wait(&self, submission: Option<wgpu::SubmissionIndex>) -> Result<(), Error> {
        let wait = wgpu::PollType::Wait { submission_index: submission, timeout: None };
        match self.device.poll(wait) {
            Ok(_) => Ok(()),
            Err(error) => Err(Error::DeviceLost(self.loss_or(error.to_string()))),
        }
    }

    /// Threads of the host that run kernels, each of them one contiguous part of a dispatch: of software adapters; else 1.
    pub(crate) fn threads(&self) -> u32 {
        match self.adapter_info().device_type {
            wgpu::DeviceType::Cpu => {
                std::thread::available_parallelism().map_or(1, |threads| threads.get().min(32) as u32)
            }
            _ => 1,
        }
    }

    pub(super) fn loss_or(&self, otherwise: String) -> String {
        lock(&self.lost).clone().unwrap_or(otherwise)
    }
}

fn describe(info: &wgpu::AdapterInfo) -> String {
    format!("{} ({:?}, {:?})", info.name, info.device_type, info.backend)
}

/// What was asked for, as messages say it.
fn asked(adapter: Option<&str>, backend: Option<&str>) -> String {
    let rules = [(ADAPTER_VARIABLE, adapter), ("WGPU_BACKEND", backend)];
    let rules: Vec<_> = rules.iter().filter_map(|(name, value)| Some(format!("{name}={}", (*value)?))).collect();
    if rules.is_empty() { String::new() } else { format!(" for {}", rules.join(", ")) }
}

fn is_wanted(info: &wgpu::AdapterInfo, wanted: Option<&str>) -> bool {
    match wanted {
        None => true,
        Some("software") => info.device_type == wgpu::DeviceType::Cpu,
        Some(name) => info.name.to_lowercase().contains(&name.to_lowercase()),
    }
}

fn rank(info: &wgpu::AdapterInfo) -> u32 {
    match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

fn classify(error: &wgpu::Error) -> Error {
    match error {
        wgpu::Error::OutOfMemory { .. } => Error::OutOfMemory(error.to_string()),
        // A lost device makes invalid objects without a word, and wgpu reports their use as a validation error. Any
        // other failure to make an object has been reported itself, and stands first.
        other => match other.to_string() {
            message if ["lost", "destroyed", "label is invalid"].iter().any(|sign| message.contains(sign)) => {
                Error::DeviceLost(message)
            }
            message => Error::Gpu(message),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_adapter_that_is_not_there_is_an_error_that_names_those_that_are() {
        let error = pollster::block_on(Gpu::choose(Some("no such adapter"))).unwrap_err();
        let message = error.to_string();
        assert!(matches!(error, Error::NoAdapter { .. }), "{message}");
        assert!(
            message.contains("STEREOTRACE_ADAPTER=no such adapter") && message.contains("there are: "),
            "{message}"
        );
    }

    #[test]
    fn messages_say_which_rules_left_no_adapter() {
        assert_eq!(asked(None, None), "");
        assert_eq!(asked(None, Some("gl")), " for WGPU_BACKEND=gl");
        assert_eq!(asked(Some("x"), Some("gl")), " for STEREOTRACE_ADAPTER=x, WGPU_BACKEND=gl");
    }
}
