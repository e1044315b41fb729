//! Device, buffers, dispatches, read-back and timestamps. Knows nothing of stereo.

use std::{
    collections::HashMap,
    future::Future,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    task::{Poll, Waker},
};

use crate::{
    Error, ShadowReuse,
    bvh::Texel,
    kernels::{self, Access, Kept, Kernel, SAMPLES_BINDING, STEPS_BINDING, Shadows, SkyKind, Specialisation, Touches},
    method::Verify,
    traversal::Fetch,
};

/// The variable that chooses the adapter: `software`, or a part of its name. wgpu's own `WGPU_BACKEND` chooses the backend
/// besides: `vulkan`, `gl`, `dx12` or `metal`.
pub const ADAPTER_VARIABLE: &str = "STEREOTRACE_ADAPTER";

/// Width of the textures that hold a scene (`shaders/shared/fetch_texture.wgsl`).
pub(crate) const TEXTURE_WIDTH: u32 = 8192;

/// Texels that are handed to the driver at a time: whole rows of those textures, 16 MiB.
const PIECE: usize = 1 << 20;

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

    fn loss_or(&self, otherwise: String) -> String {
        lock(&self.lost).clone().unwrap_or(otherwise)
    }

    pub(crate) fn storage_buffer(&self, label: &str, bytes: u64) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.max(16),
            usage,
            mapped_at_creation: false,
        })
    }

    /// Not mapped at creation: on a lost device that panics.
    pub(crate) fn uniform_buffer(&self, label: &str, contents: &[u8]) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: contents.len() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    /// How many texels fit one texture or one binding.
    pub(crate) fn texel_capacity(&self, fetch: Fetch) -> u64 {
        match fetch {
            Fetch::Texture => match self.limits.max_texture_dimension_2d {
                side if side < TEXTURE_WIDTH => 0,
                side => u64::from(TEXTURE_WIDTH) * u64::from(side),
            },
            Fetch::Buffer => self.binding_limit() / size_of::<Texel>() as u64,
        }
    }

    /// How many texels a scene's shading table may have, read either way.
    #[cfg(any(feature = "obj", feature = "sky", feature = "json"))]
    pub(crate) fn largest_table(&self) -> u64 {
        self.texel_capacity(Fetch::Texture).max(self.texel_capacity(Fetch::Buffer))
    }

    /// Uploads texels as a texture or a storage buffer.
    ///
    /// # Errors
    /// [`Error::Limit`] if they don't fit one texture or binding, and [`Error::DeviceLost`].
    pub(crate) fn upload(&self, label: &'static str, texels: &[Texel], fetch: Fetch) -> Result<Texels, Error> {
        self.upload_each(label, texels.len(), texels.iter().copied(), fetch)
    }

    /// Uploads so many texels as they come, without having them all at once.
    ///
    /// # Errors
    /// As [`Gpu::upload`].
    pub(crate) fn upload_each(
        &self,
        label: &'static str,
        count: usize,
        texels: impl Iterator<Item = Texel>,
        fetch: Fetch,
    ) -> Result<Texels, Error> {
        match fetch {
            Fetch::Texture => {
                if count as u64 > self.texel_capacity(fetch) {
                    return Err(Error::Limit {
                        what: format!("the scene's {label} texture"),
                        needed: format!("{count} texels in rows of {TEXTURE_WIDTH}"),
                        limit: "max_texture_dimension_2d",
                        allowed: self.limits.max_texture_dimension_2d.to_string(),
                        remedy: "use fewer primitives",
                    });
                }
                let texture = self.texture(label, TEXTURE_WIDTH.min(count.max(1) as u32), count);
                self.in_pieces(texels, |first, texels| {
                    self.write_rows(&texture, first / TEXTURE_WIDTH as usize, texels);
                })?;
                Ok(Texels::Texture(texture.create_view(&wgpu::TextureViewDescriptor::default())))
            }
            Fetch::Buffer => {
                let (what, bytes) = (format!("the scene's {label} buffer"), (count * size_of::<Texel>()) as u64);
                check_bytes(&what, bytes, self.binding_limit(), "use fewer primitives")?;
                let buffer = self.storage_buffer(label, bytes);
                self.in_pieces(texels, |first, texels| {
                    let offset = (first * size_of::<Texel>()) as u64;
                    self.queue.write_buffer(&buffer, offset, bytemuck::cast_slice(texels));
                })?;
                Ok(Texels::Buffer(buffer))
            }
        }
    }

    /// Writes texels in pieces, from the index of a first one on. A driver holds a copy of what it is handed until it is done,
    /// so one piece is waited for before the next is made.
    fn in_pieces(&self, mut texels: impl Iterator<Item = Texel>, write: impl Fn(usize, &[Texel])) -> Result<(), Error> {
        let mut piece = Vec::new();
        for first in (0..).step_by(PIECE) {
            piece.clear();
            piece.extend(texels.by_ref().take(PIECE));
            if !piece.is_empty() {
                write(first, &piece);
            }
            if piece.len() < PIECE {
                break;
            }
            self.wait(Some(self.queue.submit([])))?;
        }
        Ok(())
    }

    /// A texture of texels in rows, the last of which may be short.
    pub(crate) fn filled_texture(&self, label: &str, width: u32, texels: &[Texel]) -> wgpu::TextureView {
        let texture = self.texture(label, width, texels.len());
        self.write_rows(&texture, 0, texels);
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    fn texture(&self, label: &str, width: u32, texels: usize) -> wgpu::Texture {
        let height = texels.div_ceil(width as usize).max(1) as u32;
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Uint,
            usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    }

    /// Writes texels from a row on. The last row may be short.
    fn write_rows(&self, texture: &wgpu::Texture, first_row: usize, texels: &[Texel]) {
        let write = |row: usize, texels: &[Texel], width: u32, rows: usize| {
            let target = wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y: row as u32, z: 0 },
                aspect: wgpu::TextureAspect::All,
            };
            let layout =
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 16), rows_per_image: None };
            let size = wgpu::Extent3d { width, height: rows as u32, depth_or_array_layers: 1 };
            self.queue.write_texture(target, bytemuck::cast_slice(texels), layout, size);
        };
        let width = texture.width();
        let full = texels.len() / width as usize;
        let (whole, rest) = texels.split_at(full * width as usize);
        if !whole.is_empty() {
            write(first_row, whole, width, full);
        }
        if !rest.is_empty() {
            write(first_row + full, rest, rest.len() as u32, 1);
        }
    }

    /// Copies a buffer back to the host.
    pub(crate) async fn read<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer, count: usize) -> Result<Vec<T>, Error> {
        let bytes = (count * size_of::<T>()) as u64;
        let (sender, receiver) = oneshot();
        let staging = self
            .checked(|| {
                let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("read-back"),
                    size: bytes.max(4),
                    usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                });
                let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes);
                self.queue.submit([encoder.finish()]);
                staging.map_async(wgpu::MapMode::Read, .., move |result| sender.send(result));
                Ok(staging)
            })
            .await?;
        self.wait(None)?;
        let lost = |error: &dyn std::fmt::Display| Error::DeviceLost(self.loss_or(error.to_string()));
        receiver.await.map_err(|error| lost(&error))?;
        let range = staging.get_mapped_range(..).map_err(|error| lost(&error))?;
        Ok(bytemuck::pod_collect_to_vec(&range[..bytes as usize]))
    }
}

/// [`Error::Limit`] if a binding of `bytes` is more than `allowed`.
pub(crate) fn check_bytes(what: &str, bytes: u64, allowed: u64, remedy: &'static str) -> Result<(), Error> {
    if bytes <= allowed {
        return Ok(());
    }
    let mib = |bytes: u64| format!("{} MiB", bytes.div_ceil(1 << 20));
    Err(Error::Limit {
        what: what.into(),
        needed: mib(bytes),
        limit: "max_storage_buffer_binding_size",
        allowed: mib(allowed),
        remedy,
    })
}

/// A part of a scene on the device.
#[derive(Debug)]
pub(crate) enum Texels {
    Texture(wgpu::TextureView),
    Buffer(wgpu::Buffer),
}

impl Texels {
    pub(crate) fn binding(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Texture(view) => wgpu::BindingResource::TextureView(view),
            Self::Buffer(buffer) => buffer.as_entire_binding(),
        }
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

/// A compute pipeline and the layout of its own bindings.
#[derive(Debug)]
pub(crate) struct Pipeline {
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) own: wgpu::BindGroupLayout,
}

/// Layouts of a scene's two bind groups, for one way to read it.
#[derive(Debug)]
pub(crate) struct SceneLayouts {
    /// The BVH's uniform, nodes, primitives.
    pub(crate) geometry: wgpu::BindGroupLayout,
    /// The table that a kernel looks up by index.
    pub(crate) table: wgpu::BindGroupLayout,
}

/// The pipelines built so far, each when it is first used, and the layouts that they share.
#[derive(Debug)]
pub(crate) struct Pipelines {
    textures: SceneLayouts,
    buffers: SceneLayouts,
    built: Mutex<HashMap<(&'static str, Specialisation), Arc<Pipeline>>>,
}

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None }
}

fn buffer_type(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

fn texture_type(access: wgpu::StorageTextureAccess) -> wgpu::BindingType {
    let (format, view_dimension) = (wgpu::TextureFormat::Rgba32Uint, wgpu::TextureViewDimension::D2);
    wgpu::BindingType::StorageTexture { access, format, view_dimension }
}

impl Pipelines {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let texture = texture_type(wgpu::StorageTextureAccess::ReadOnly);
        let buffer = buffer_type(wgpu::BufferBindingType::Storage { read_only: true });
        let layout = |label, types: &[wgpu::BindingType]| {
            let entries: Vec<_> = types.iter().zip(0..).map(|(ty, binding)| entry(binding, *ty)).collect();
            gpu.device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
        };
        let layouts = |texels| SceneLayouts {
            geometry: layout("geometry", &[buffer_type(wgpu::BufferBindingType::Uniform), texels, texels]),
            table: layout("table", &[texels]),
        };
        Self { textures: layouts(texture), buffers: layouts(buffer), built: Mutex::default() }
    }

    /// The layouts of a scene that is read this way.
    pub(crate) fn layouts(&self, fetch: Fetch) -> &SceneLayouts {
        match fetch {
            Fetch::Texture => &self.textures,
            Fetch::Buffer => &self.buffers,
        }
    }

    /// The pipeline of a kernel, built if this is its first use.
    pub(crate) fn get(&self, gpu: &Gpu, kernel: &Kernel, with: Specialisation) -> Arc<Pipeline> {
        // A kernel that doesn't touch the scene is the same for every scene.
        let with = match kernel.touches {
            Touches::Pixels => Specialisation { hits: with.hits, right: with.right, ..Specialisation::PIXELS },
            Touches::Objects => Specialisation { hits: with.hits, traversal: with.traversal, ..Specialisation::PIXELS },
            Touches::Geometry => Specialisation {
                lights: false,
                shadows: Shadows::None,
                sky: SkyKind::Constant,
                bits: ShadowReuse::Rays,
                ..with
            },
            Touches::Shading => Specialisation { verify: Verify::All, ..with },
            Touches::RayList => Specialisation {
                lights: false,
                shadows: Shadows::None,
                sky: SkyKind::Constant,
                hits: Kept::None,
                verify: Verify::All,
                ..with
            },
        };
        lock(&self.built).entry((kernel.name, with)).or_insert_with(|| Arc::new(self.build(gpu, kernel, with))).clone()
    }

    fn build(&self, gpu: &Gpu, kernel: &Kernel, with: Specialisation) -> Pipeline {
        let device = &gpu.device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(kernel.name),
            source: wgpu::ShaderSource::Wgsl(kernel.text(&with).into()),
        });
        let mut entries = vec![entry(0, buffer_type(wgpu::BufferBindingType::Uniform))];
        for (index, access) in kernel.storage.iter().enumerate() {
            let read_only = *access == Access::Read;
            entries.push(entry(index as u32 + 1, buffer_type(wgpu::BufferBindingType::Storage { read_only })));
        }
        if kernel.in_steps() {
            entries.push(entry(STEPS_BINDING, buffer_type(wgpu::BufferBindingType::Storage { read_only: false })));
        }
        if let Some(access) = kernel.samples(&with) {
            let access = match access {
                Access::Read => wgpu::StorageTextureAccess::ReadOnly,
                Access::Write => wgpu::StorageTextureAccess::WriteOnly,
            };
            entries.push(entry(SAMPLES_BINDING, texture_type(access)));
        }
        let own = device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(kernel.name), entries: &entries });
        let scene = self.layouts(with.traversal.fetch);
        let geometry = kernel.touches.geometry().then_some(&scene.geometry);
        let table = kernel.touches.table().then_some(&scene.table);
        let groups = [geometry, Some(&own), table];
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(kernel.name),
            bind_group_layouts: &groups[..if table.is_some() { 3 } else { 2 }],
            immediate_size: 0,
        });
        let counting = [("COUNT", with.count), ("COST_MAP", with.cost_map)];
        let counting = counting.map(|(name, on)| (name, f64::from(u8::from(on))));
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(kernel.name),
            layout: Some(&layout),
            module: &module,
            entry_point: None, // the only one
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: if kernel.touches.geometry() { &counting } else { &[] },
                ..Default::default()
            },
            cache: None,
        });
        Pipeline { pipeline, own }
    }
}

/// A bind group of resources in the order of their bindings.
pub(crate) fn bind_group<'a>(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: impl Iterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    bind_group_at(gpu, label, layout, (0..).zip(resources))
}

/// A bind group of bindings and resources.
pub(crate) fn bind_group_at<'a>(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: impl Iterator<Item = (u32, wgpu::BindingResource<'a>)>,
) -> wgpu::BindGroup {
    let entries: Vec<_> = resources.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}

/// Timestamps of the compute passes of one frame, a pair each.
#[derive(Debug)]
pub(crate) struct Timestamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// The name of each pair's pass.
    names: Vec<&'static str>,
    /// There were more passes than pairs.
    full: bool,
}

/// WebGPU's own bound on a query set.
const MAX_QUERIES: u32 = wgpu::QUERY_SET_MAX_QUERIES;

impl Timestamps {
    /// `None` where the adapter has no timestamps.
    pub(crate) fn new(gpu: &Gpu) -> Option<Self> {
        gpu.timestamps.then(|| Self {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: MAX_QUERIES,
            }),
            resolved: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: u64::from(MAX_QUERIES) * 8,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            names: Vec::new(),
            full: false,
        })
    }

    /// Forgets the last frame's.
    pub(crate) fn restart(&mut self) {
        self.names.clear();
        self.full = false;
    }

    /// The next pair, for a pass of this name; `None` when all are used up.
    pub(crate) fn next(&mut self, name: &'static str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let first = 2 * self.names.len() as u32;
        if first + 2 > MAX_QUERIES {
            self.full = true;
            return None;
        }
        self.names.push(name);
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2 * self.names.len() as u32, &self.resolved, 0);
    }

    /// Sums by name, in order of first use; `None` if there were more passes than could be timed.
    pub(crate) async fn read(&self, gpu: &Gpu) -> Result<Option<crate::PassTimes>, Error> {
        if self.full {
            return Ok(None);
        }
        let ticks: Vec<u64> = gpu.read(&self.resolved, 2 * self.names.len()).await?;
        let period = f64::from(gpu.queue.get_timestamp_period());
        let mut times = crate::PassTimes::default();
        for (name, pair) in self.names.iter().zip(ticks.chunks_exact(2)) {
            let nanoseconds = pair[1].saturating_sub(pair[0]) as f64 * period;
            let time = std::time::Duration::from_nanos(nanoseconds as u64);
            match times.0.iter_mut().find(|(known, _)| known == name) {
                Some((_, sum)) => *sum += time,
                None => times.0.push((name, time)),
            }
        }
        Ok(Some(times))
    }
}

/// One value that a callback hands to a future.
#[derive(Debug)]
struct Slot<T> {
    value: Option<T>,
    waker: Option<Waker>,
}

struct Sender<T>(Arc<Mutex<Slot<T>>>);

impl<T> Sender<T> {
    fn send(self, value: T) {
        let mut slot = lock(&self.0);
        slot.value = Some(value);
        if let Some(waker) = slot.waker.take() {
            waker.wake();
        }
    }
}

fn oneshot<T>() -> (Sender<T>, impl Future<Output = T>) {
    let slot = Arc::new(Mutex::new(Slot { value: None, waker: None }));
    let receiver = slot.clone();
    let future = std::future::poll_fn(move |context| {
        let mut slot = lock(&receiver);
        match slot.value.take() {
            Some(value) => Poll::Ready(value),
            None => {
                slot.waker = Some(context.waker().clone());
                Poll::Pending
            }
        }
    });
    (Sender(slot), future)
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

    #[test]
    fn a_binding_over_the_limit_names_sizes_and_limit() {
        assert!(check_bytes("the nodes", 128 << 20, 128 << 20, "shrink").is_ok());
        let message = check_bytes("the nodes", (190 << 20) + 1, 128 << 20, "shrink").unwrap_err().to_string();
        assert!(
            message.starts_with("the nodes needs 191 MiB but this adapter's max_storage_buffer_binding_size is 128")
        );
    }
}
