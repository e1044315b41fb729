//! The renderer: the passes of one frame, in order.

mod in_steps;

use std::{
    ops::ControlFlow,
    sync::{Arc, OnceLock},
    time::{Duration, Instant},
};

use glam::{DVec3, Vec3};

use crate::{
    BvhBuild, Choice, Error, Method, PixelSource, Pose, Rays, Scene, ShadowReuse, ShadowSource, Sky, Statistics,
    StereoCamera, StereoPair, View, Work,
    auto::CostModel,
    bvh,
    camera::least_pixel_angle,
    gpu::{self, Gpu, Pipelines, Timestamps, bind_group, bind_group_at, check_bytes},
    kernels::{self, Kept, Kernel, RightView, SAMPLES_BINDING, STEPS_BINDING, Shadows, Specialisation, Touches},
    large::LargePrimitives,
    layout::{self, WORKGROUP},
    method::{BufferDepth, Overlap, Verify},
    steps::Steps,
    traversal::{Fetch, Traversal},
};

/// Pixels of one dispatch, in whole workgroups of rows: with 5 lights some 1.5 million rays, a tenth of a second on a slow
/// GPU, so that no watchdog trips whatever the picture's size. More lights make it less.
const BAND_PIXELS: u32 = 1 << 18;
/// Bands of a picture at most: eight dispatches each, the most that a method has, fit one query set.
const MAX_BANDS: u32 = 256;
/// Of an ordinary picture, whose pixels span 2e-5 radians and more: far more than the rounding of a projection.
const WIDER: f32 = 0.05;

/// What to render with.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Options {
    /// How the right view is made.
    pub method: Method,
    /// Count BVH nodes and primitive tests (slower).
    pub count: bool,
    /// Keep what each pixel cost, as [`View::cost`]; counts too.
    pub cost_map: bool,
    /// What is kept of each pixel besides its colour.
    pub g_buffer: GBuffer,
}

/// What is kept of each pixel besides its colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum GBuffer {
    /// Depth and the ids of primitive and object.
    #[default]
    Ids,
    /// Depth alone: [`View::primitive`] and [`View::object`] stay empty.
    Depth,
    /// Nothing: [`View::depth`] stays empty too. The reuse methods keep depth on the device all the same.
    None,
}

impl Options {
    /// The given method, nothing counted.
    pub fn new(method: Method) -> Self {
        Self { method, count: false, cost_map: false, g_buffer: GBuffer::Ids }
    }

    /// Keeps no more of each pixel than said.
    pub fn keeping(mut self, g_buffer: GBuffer) -> Self {
        self.g_buffer = g_buffer;
        self
    }

    /// Keeps what each pixel cost.
    pub fn mapping_costs(mut self) -> Self {
        self.cost_map = true;
        self
    }

    /// Counts BVH nodes and primitive tests too.
    pub fn counting(mut self) -> Self {
        self.count = true;
        self
    }
}

impl Default for Options {
    /// [`Method::Auto`], nothing counted.
    fn default() -> Self {
        Self::new(Method::Auto)
    }
}

/// How far a frame is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// The pass at work.
    pub pass: &'static str,
    /// Share of the frame's rows done, all passes together, 0 to 1. It begins anew where a frame is rendered again
    /// ([`Statistics::in_steps`]).
    pub done: f32,
}

/// A scene on a device, to be rendered from any number of cameras.
#[derive(Debug)]
pub struct UploadedScene {
    pub(crate) geometry: wgpu::BindGroup,
    shading: wgpu::BindGroup,
    /// Made when edges are first asked for.
    object_table: OnceLock<wgpu::BindGroup>,
    pub(crate) specialisation: Specialisation,
    objects: Vec<u32>,
    /// The scene's id of each primitive, in the BVH's order.
    ids: Vec<u32>,
    lights: Vec<Vec3>,
    pub(crate) large: LargePrimitives,
    gpu: Gpu,
    info: UploadInfo,
}

/// How a scene was brought to a device.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct UploadInfo {
    /// How its rays are traced. It is read in the other way than the renderer's where it does not fit that one.
    pub traversal: Traversal,
    /// Time to build and pack the BVH.
    pub build: Duration,
    /// Time to hand it to the driver.
    pub upload: Duration,
    /// Bytes of the BVH's nodes.
    pub node_bytes: u64,
    /// Bytes of the primitives.
    pub primitive_bytes: u64,
    /// Triangles without area ([`Scene::degenerate_count`]): they are not in the BVH.
    pub dropped_triangles: usize,
}

impl UploadedScene {
    /// How it was brought to the device.
    pub fn info(&self) -> UploadInfo {
        self.info
    }

    /// Whether rays from these points, or from the lights, need t of large primitives more exactly.
    pub(crate) fn close_to(&self, eyes: &[Vec3]) -> bool {
        let shadows = if self.specialisation.shadows == Shadows::None { &[] } else { self.lights.as_slice() };
        let close = self.large.any_close_to(eyes) || self.large.any_close_to(shadows);
        log::debug!("close to a large primitive: {close}");
        close
    }

    /// The primitives' objects, for the pass that tells edges by them.
    async fn upload_object_table(&self, gpu: &Gpu, pipelines: &Pipelines) -> Result<(), Error> {
        if self.object_table.get().is_some() {
            return Ok(());
        }
        let fetch = self.specialisation.traversal.fetch;
        let upload = || {
            let table = gpu.upload("object_table", &object_texels(&self.objects), fetch)?;
            let layout = &pipelines.layouts(fetch).table;
            Ok(bind_group(gpu, "object_table", layout, std::iter::once(table.binding())))
        };
        let table = gpu.checked(upload).await?;
        let _ = self.object_table.set(table); // another frame's is as good
        Ok(())
    }

    /// What `Auto` chooses where even a left view without gaps, with a shadow ray for every light and pixel, could only end in `Naive`.
    fn choose_early(&self, gpu: &Gpu, pose: &Pose) -> Option<Choice> {
        let lights = if self.specialisation.shadows == Shadows::None { 0 } else { self.lights.len() };
        let pixels = u64::from(pose.size[0]) * u64::from(pose.size[1]);
        let best = CostModel::of(gpu).choose(pose, (lights as u64).saturating_mul(pixels), 0);
        (best.method == Method::Naive).then_some(best)
    }

    /// # Errors
    /// [`Error::Scene`] if another [`Gpu`] holds it.
    pub(crate) fn belongs_to(&self, gpu: &Gpu) -> Result<(), Error> {
        if self.gpu.is(gpu) {
            return Ok(());
        }
        let reason = "it was uploaded by another Gpu; upload it with this renderer".into();
        Err(Error::Scene { element: "uploaded scene".into(), reason })
    }
}

/// Renders stereo pairs; keeps pipelines and buffers from frame to frame.
///
/// ```no_run
/// use stereotrace::{Gpu, Method, Options, Renderer, Scene, StereoCamera};
///
/// let scene = Scene::from_obj("bunny.obj")?;
/// let camera = StereoCamera::fitting(scene.bounds().expect("the file has triangles"), 800, 600);
/// let mut renderer = Renderer::new(Gpu::new()?);
/// let uploaded = renderer.upload(&scene)?;
/// for method in [Method::Naive, Method::ATOMIC] {
///     let pair = renderer.render(&uploaded, &camera, &Options::new(method).counting())?;
///     println!("{method}: second eye {:.2} of the first", pair.statistics.second_eye());
/// }
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Debug)]
pub struct Renderer {
    pub(crate) gpu: Gpu,
    traversal: Traversal,
    pub(crate) pipelines: Pipelines,
    picture: Option<Arc<Picture>>,
    slots: Option<Arc<wgpu::Buffer>>,
    timestamps: Option<Timestamps>,
    band_pixels: u32,
    pub(crate) steps: Steps,
}

/// What a frame needs of its picture.
#[derive(Clone, Copy)]
struct Need {
    size: [u32; 2],
    kept: Kept,
    reuse: bool,
    cost_map: bool,
}

/// The buffers of one picture size.
#[derive(Debug)]
struct Picture {
    size: [u32; 2],
    kept: Kept,
    /// Whether it has what the reuse methods need besides.
    reuse: bool,
    /// Whether it has a map of costs.
    cost_map: bool,
    frame: wgpu::Buffer,
    left_color: wgpu::Buffer,
    right_color: wgpu::Buffer,
    hits: wgpu::Buffer,
    right_source: wgpu::Buffer,
    lists: wgpu::Buffer,
    /// What `search_tiles` finds in a band.
    found: wgpu::Buffer,
    /// What `bracket` asks of the left view's samples.
    samples: Option<wgpu::TextureView>,
    indirect: wgpu::Buffer,
    counters: wgpu::Buffer,
    pictures: wgpu::Buffer,
}

impl Picture {
    fn new(gpu: &Gpu, need: Need, band_pixels: u32) -> Result<Self, Error> {
        let Need { size, kept, reuse, cost_map } = need;
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let allowed = gpu.binding_limit();
        let what = format!("a {}x{} picture", size[0], size[1]);
        let counters = 4 * (u64::from(size[1]) * layout::COUNTERS as u64 + if cost_map { 2 * pixels } else { 0 });
        let hits = pixels.saturating_mul(2 * kept.bytes());
        let band = u64::from(size[0]) * u64::from(band_rows(size, band_pixels));
        let found = if kept == Kept::Samples { found_bytes(size[0], band_rows(size, band_pixels)) } else { 0 };
        let lists = if reuse { layout::LISTS_HEADS + layout::LISTS as u64 * band * 4 } else { 0 };
        let largest = pixels.saturating_mul(16).max(counters).max(hits).max(found).max(lists);
        check_bytes(&what, largest, allowed, "render a smaller one")?;
        let side = gpu.limits.max_texture_dimension_2d;
        if kept == Kept::Samples && size[0].max(size[1]) > side {
            return Err(Error::Limit {
                what: format!("{what} by bracket"),
                needed: format!("a texture of {}x{}", size[0], size[1]),
                limit: "max_texture_dimension_2d",
                allowed: side.to_string(),
                remedy: "render a smaller one, or by another method",
            });
        }
        // Those of a band, and by some reuse methods those of a launch with a thread a row.
        let rows = if reuse { size[1].div_ceil(WORKGROUP * WORKGROUP) } else { 0 };
        let workgroups = size[0].max(band_rows(size, band_pixels)).div_ceil(WORKGROUP).max(rows);
        let allowed = gpu.limits.max_compute_workgroups_per_dimension;
        if workgroups > allowed {
            return Err(Error::Limit {
                what,
                needed: format!("{workgroups} workgroups in a row or column"),
                limit: "max_compute_workgroups_per_dimension",
                allowed: allowed.to_string(),
                remedy: "render a smaller one",
            });
        }
        let storage = |label, bytes| gpu.storage_buffer(label, bytes);
        Ok(Self {
            size,
            kept,
            reuse,
            cost_map,
            frame: gpu.uniform_buffer("frame", bytemuck::bytes_of(&layout::Frame::default())),
            left_color: storage("left_color", pixels * 16),
            right_color: storage("right_color", pixels * 16),
            hits: storage("hits", 2 * pixels * kept.bytes()),
            right_source: storage("right_source", if reuse { pixels * 4 } else { 0 }),
            lists: storage("lists", lists),
            samples: (kept == Kept::Samples).then(|| samples_texture(gpu, size)),
            found: storage("found", found),
            indirect: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("indirect"),
                size: 12,
                usage: wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            counters: storage("counters", counters),
            pictures: storage("pictures", pixels * 8),
        })
    }

    /// Bytes between the passes of a method, without the pair's own pictures.
    fn intermediate_bytes(&self, method: Method) -> u64 {
        let buffers: &[&wgpu::Buffer] = match method {
            Method::Reuse { overlap: Overlap::Bracket(_), .. } => {
                &[&self.hits, &self.counters, &self.right_source, &self.lists, &self.found]
            }
            Method::Reuse { .. } => &[&self.hits, &self.counters, &self.right_source, &self.lists],
            _ => &[&self.hits, &self.counters],
        };
        let samples = if self.samples.is_some() { 16 * u64::from(self.size[0]) * u64::from(self.size[1]) } else { 0 };
        buffers.iter().map(|buffer| buffer.size()).sum::<u64>() + samples
    }
}

fn samples_texture(gpu: &Gpu, [width, height]: [u32; 2]) -> wgpu::TextureView {
    // Not left to wgpu, which clears it at its first use: after a clear Mesa's software driver takes every timestamp too early.
    gpu.filled_texture("left_samples", width, &vec![[0; 4]; width as usize * height as usize])
}

/// The way to read a scene: the wanted one, or the other one where only that can hold it.
fn fetch_that_fits(gpu: &Gpu, wanted: Fetch, scene: &Scene, packed: &bvh::PackedBvh) -> Result<Fetch, Error> {
    let other = match wanted {
        Fetch::Texture => Fetch::Buffer,
        Fetch::Buffer => Fetch::Texture,
    };
    let geometry = packed.nodes.len().max(packed.primitives.len()) as u64;
    let needed = geometry.max((texels_before_sky(scene) + sky_pixels(scene).len()) as u64);
    if let Some(fetch) = [wanted, other].into_iter().find(|&fetch| gpu.texel_capacity(fetch) >= needed) {
        if fetch != wanted {
            log::info!("the scene is too large to be read by {wanted:?}: {fetch:?} it is");
        }
        return Ok(fetch);
    }
    let (buffer, texture) = (gpu.texel_capacity(Fetch::Buffer), gpu.texel_capacity(Fetch::Texture));
    let (limit, capacity) = match buffer > texture {
        true => ("max_storage_buffer_binding_size", buffer),
        false => ("max_texture_dimension_2d", texture),
    };
    let primitives = scene.primitive_count() as u64;
    if needed > geometry {
        return Err(Error::Limit {
            what: "the scene's table of lights, materials and sky".into(),
            needed: format!("{needed} texels of 16 bytes"),
            limit,
            allowed: format!("enough for {capacity}"),
            remedy: "use a smaller sky",
        });
    }
    Err(Error::Limit {
        what: format!("a scene of {primitives} primitives"),
        needed: format!("{needed} texels of 16 bytes"),
        limit,
        allowed: format!("enough for {capacity}, about {} primitives", capacity * primitives / needed),
        remedy: "use fewer primitives",
    })
}

/// Bytes of the lists that `search_tiles` makes of so many rows.
fn found_bytes(width: u32, rows: u32) -> u64 {
    let tiles = u64::from(width.div_ceil(layout::TILE)) * u64::from(rows.div_ceil(layout::TILE));
    4 * tiles * u64::from(layout::TILE_BLOCKS * layout::LIST_WORDS)
}

/// Rows of a dispatch: whole workgroups of them.
fn band_rows([width, height]: [u32; 2], band_pixels: u32) -> u32 {
    let rows = (band_pixels / width).max(height.div_ceil(MAX_BANDS));
    rows.next_multiple_of(WORKGROUP).min(height.next_multiple_of(WORKGROUP))
}

impl Renderer {
    /// A renderer on a device.
    pub fn new(gpu: Gpu) -> Self {
        let traversal = Traversal::of(&gpu);
        Self::with_traversal(gpu, traversal)
    }

    /// A renderer whose rays go through scenes in a given way: for measurements, or where [`Traversal::of`] chose badly.
    pub fn with_traversal(gpu: Gpu, traversal: Traversal) -> Self {
        let pipelines = Pipelines::new(&gpu);
        let timestamps = Timestamps::new(&gpu);
        let steps = Steps::default();
        Self { gpu, traversal, pipelines, picture: None, slots: None, timestamps, band_pixels: BAND_PIXELS, steps }
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Builds a scene's BVH, as one would for a few pictures, and uploads it, blocking.
    ///
    /// # Errors
    /// As [`Renderer::upload_async`].
    pub fn upload(&self, scene: &Scene) -> Result<UploadedScene, Error> {
        self.upload_with(scene, BvhBuild::Balanced)
    }

    /// Builds a scene's BVH with a given effort and uploads it, blocking.
    ///
    /// # Errors
    /// As [`Renderer::upload_async`].
    pub fn upload_with(&self, scene: &Scene, build: BvhBuild) -> Result<UploadedScene, Error> {
        pollster::block_on(self.upload_async(scene, build))
    }

    /// Builds a scene's BVH with a given effort and uploads it. What does not fit the adapter's storage bindings goes to
    /// textures, and the other way round.
    ///
    /// # Errors
    /// [`Error::Scene`] for a value that can't be rendered, [`Error::Limit`] for a scene larger than the adapter
    /// takes, saying how many primitives fit, [`Error::OutOfMemory`] and [`Error::DeviceLost`].
    pub async fn upload_async(&self, scene: &Scene, build: BvhBuild) -> Result<UploadedScene, Error> {
        scene.check()?;
        let started = Instant::now();
        let packed = bvh::build(scene, build, self.traversal.boxes)?;
        let built = started.elapsed();
        let fetch = fetch_that_fits(&self.gpu, self.traversal.fetch, scene, &packed)?;
        let traversal = Traversal { fetch, ..self.traversal };
        let layouts = self.pipelines.layouts(fetch);
        let gpu = &self.gpu;
        let upload = || {
            let nodes = gpu.upload("nodes", &packed.nodes, fetch)?;
            let primitives = match fetch {
                Fetch::Texture => gpu.upload("primitives", &bvh::in_rows(&packed, gpu::TEXTURE_WIDTH), fetch)?,
                Fetch::Buffer => gpu.upload("primitives", &packed.primitives, fetch)?,
            };
            let texels = texels_before_sky(scene) + sky_pixels(scene).len();
            let table = gpu.upload_each("shading_table", texels, shading_table(scene), fetch)?;
            let objects: Vec<u32> = (0..scene.primitive_count() as u32).map(|id| scene.object_of(id)).collect();
            let bvh = gpu.uniform_buffer("bvh", bytemuck::bytes_of(&packed.uniform));
            let geometry = [bvh.as_entire_binding(), nodes.binding(), primitives.binding()];
            Ok(UploadedScene {
                geometry: bind_group(gpu, "geometry", &layouts.geometry, geometry.into_iter()),
                object_table: OnceLock::new(),
                shading: bind_group(gpu, "shading_table", &layouts.table, std::iter::once(table.binding())),
                specialisation: Specialisation::of(scene, traversal, &packed),
                lights: scene.lights.iter().map(|light| light.position).collect(),
                large: LargePrimitives::of(scene),
                gpu: gpu.clone(),
                info: UploadInfo {
                    traversal,
                    build: built,
                    upload: Duration::ZERO,
                    node_bytes: size_of_val(packed.nodes.as_slice()) as u64,
                    primitive_bytes: size_of_val(packed.primitives.as_slice()) as u64,
                    dropped_triangles: scene.degenerate_count(),
                },
                objects,
                ids: packed.ids,
            })
        };
        let mut uploaded = gpu.checked(upload).await?;
        uploaded.info.upload = started.elapsed() - built;
        Ok(uploaded)
    }

    /// Renders a pair, blocking.
    ///
    /// # Errors
    /// As [`Renderer::render_async`].
    pub fn render(
        &mut self,
        scene: &UploadedScene,
        camera: &StereoCamera,
        options: &Options,
    ) -> Result<StereoPair, Error> {
        self.render_with(scene, camera, options, &mut |_| ControlFlow::Continue(()))
    }

    /// Renders a pair, blocking, with a callback for progress.
    ///
    /// # Errors
    /// As [`Renderer::render_async`].
    pub fn render_with(
        &mut self,
        scene: &UploadedScene,
        camera: &StereoCamera,
        options: &Options,
        progress: &mut (dyn FnMut(Progress) -> ControlFlow<()> + Send),
    ) -> Result<StereoPair, Error> {
        pollster::block_on(self.render_async(scene, camera, options, progress))
    }

    /// Renders a pair; `progress` is called after every band of rows of every pass, and may stop the frame.
    ///
    /// # Errors
    /// [`Error::Camera`] for an invalid camera, [`Error::Limit`] for a picture that the adapter can't bind,
    /// [`Error::Cancelled`] if `progress` breaks, [`Error::Scene`] for a scene that another
    /// [`Gpu`] holds, [`Error::DeviceLost`] and [`Error::OutOfMemory`].
    pub async fn render_async(
        &mut self,
        scene: &UploadedScene,
        camera: &StereoCamera,
        options: &Options,
        progress: &mut (dyn FnMut(Progress) -> ControlFlow<()> + Send),
    ) -> Result<StereoPair, Error> {
        let pose = camera.pose()?;
        let (statistics, picture) = self.trace_async(scene, &pose, options, progress).await?;
        self.read_pair(scene, pose, options, &picture, statistics).await
    }

    /// Runs the passes of a frame without reading the pictures back: for benchmarks.
    ///
    /// # Errors
    /// As [`Renderer::render_async`].
    pub fn trace(
        &mut self,
        scene: &UploadedScene,
        camera: &StereoCamera,
        options: &Options,
    ) -> Result<Statistics, Error> {
        let pose = camera.pose()?;
        let mut go_on = |_| ControlFlow::Continue(());
        let traced = self.trace_async(scene, &pose, options, &mut go_on);
        pollster::block_on(traced).map(|(statistics, _)| statistics)
    }

    /// The passes of a frame; the picture's buffers then hold the pair.
    async fn trace_async(
        &mut self,
        scene: &UploadedScene,
        pose: &Pose,
        options: &Options,
        progress: &mut (dyn FnMut(Progress) -> ControlFlow<()> + Send),
    ) -> Result<(Statistics, Arc<Picture>), Error> {
        scene.belongs_to(&self.gpu)?;
        let method = effective(options.method, pose, scene);
        method.check()?;
        if !self.steps.always
            && let Some(traced) = self.trace_at_once(scene, pose, options, method, progress).await?
        {
            return Ok(traced);
        }
        self.trace_in_steps(scene, pose, options, progress).await
    }

    /// The passes of a frame, unless the adapter cuts a thread's work short: then `None`.
    async fn trace_at_once(
        &mut self,
        scene: &UploadedScene,
        pose: &Pose,
        options: &Options,
        method: Method,
        progress: &mut (dyn FnMut(Progress) -> ControlFlow<()> + Send),
    ) -> Result<Option<(Statistics, Arc<Picture>)>, Error> {
        let early = if method == Method::Auto { scene.choose_early(&self.gpu, pose) } else { None };
        let method = early.map_or(method, |choice| choice.method);
        let kept = Kept::of(options.g_buffer, method);
        let reuse = !matches!(method, Method::Naive | Method::Ideal);
        let picture = self.picture_of(Need { size: pose.size, kept, reuse, cost_map: options.cost_map }).await?;
        let mut passes = self.passes(scene, pose, options, &picture, progress);
        passes.rows_total = pose.size[1] * passes_of(method);
        let buffer_depth = passes.frame(pose, method).await?;
        passes.finish().await?;
        let (slot_bytes, host, choice) = (passes.slot_bytes, passes.host, passes.choice);
        let method = choice.map_or(method, |choice| choice.method);
        let mut statistics = match self.statistics(&picture, method).await? {
            Ok(statistics) => statistics,
            Err(threads) => {
                log::warn!(
                    "{method}: the adapter ended the loops of {threads} threads before their work was done; naive goes on in steps"
                );
                return Ok(None);
            }
        };
        statistics.choice = choice.or(early);
        statistics.buffer_depth = buffer_depth;
        statistics.intermediate_bytes += slot_bytes;
        if let Some(timestamps) = &self.timestamps {
            statistics.times = timestamps.read(&self.gpu).await?;
        }
        if let Some(times) = statistics.times.as_mut().filter(|_| !host.is_zero()) {
            times.0.insert(1, ("reproject_on_the_host", host));
        }
        Ok(Some((statistics, picture)))
    }

    /// A frame's passes, none of them run.
    fn passes<'a>(
        &'a mut self,
        scene: &'a UploadedScene,
        pose: &Pose,
        options: &Options,
        picture: &'a Picture,
        progress: &'a mut (dyn FnMut(Progress) -> ControlFlow<()> + Send),
    ) -> Passes<'a> {
        if let Some(timestamps) = &mut self.timestamps {
            timestamps.restart();
        }
        let counting = scene.specialisation.counting(options.count, options.cost_map);
        let close = scene.close_to(&[pose.eye_position(-1.0), pose.eye_position(1.0)]);
        Passes {
            gpu: &self.gpu,
            pipelines: &self.pipelines,
            scene,
            specialisation: Specialisation { hits: picture.kept, close, ..counting },
            picture,
            slots: &mut self.slots,
            slot_bytes: 0,
            rows: band_rows(pose.size, self.band_pixels / (1 + scene.lights.len() as u32).div_ceil(6)),
            frame: frame_uniform(pose),
            timestamps: self.timestamps.as_mut(),
            lanes: None,
            host: Duration::ZERO,
            choice: None,
            rows_done: 0,
            rows_total: pose.size[1],
            progress,
        }
    }

    async fn picture_of(&mut self, need: Need) -> Result<Arc<Picture>, Error> {
        let fits = |picture: &&Arc<Picture>| {
            let same = (picture.size, picture.kept, picture.cost_map) == (need.size, need.kept, need.cost_map);
            same && picture.reuse >= need.reuse
        };
        if let Some(picture) = self.picture.as_ref().filter(fits) {
            return Ok(picture.clone());
        }
        self.picture = None; // the old one's memory first
        let picture = Arc::new(self.gpu.checked(|| Picture::new(&self.gpu, need, self.band_pixels)).await?);
        self.picture = Some(picture.clone());
        Ok(picture)
    }

    /// What a frame cost, or in how many threads an adapter cut it short.
    async fn statistics(&self, picture: &Picture, method: Method) -> Result<Result<Statistics, u64>, Error> {
        let [width, height] = picture.size;
        let words: Vec<u32> = self.gpu.read(&picture.counters, height as usize * layout::COUNTERS).await?;
        let sum = |word| sum_of(&words, word);
        let pixels = u64::from(width) * u64::from(height);
        let cut_short = sum(layout::CUT_SHORT);
        if cut_short > 0 {
            return Ok(Err(cut_short));
        }
        let work = |eye: usize, primary, verification| Work {
            rays: Rays { primary, verification, shadow: sum(eye * layout::VIEW_WORDS + layout::SHADOW_RAYS) },
            nodes: sum(eye * layout::VIEW_WORDS + layout::NODES_VISITED),
            primitive_tests: sum(eye * layout::VIEW_WORDS + layout::PRIMITIVES_TESTED),
        };
        let (bad, missed) = (sum(layout::BAD_PIXELS), sum(layout::MISSED_PIXELS));
        let (primary, verification, reused) = match method {
            Method::Naive | Method::Auto => (pixels, 0, 0),
            Method::Ideal => (0, 0, pixels),
            Method::Reuse { overlap, verify } => {
                let landed = pixels - missed;
                let checked = verify == Verify::All && !matches!(overlap, Overlap::Bracket(_));
                (bad + missed, if checked { landed } else { 0 }, landed - bad)
            }
        };
        Ok(Ok(Statistics {
            method,
            left: work(0, pixels, 0),
            right: work(1, primary, verification),
            reused,
            bad,
            missed,
            lost_candidates: sum(layout::LOST_CANDIDATES),
            intermediate_bytes: picture.intermediate_bytes(method),
            ..Statistics::default()
        }))
    }

    async fn read_pair(
        &self,
        scene: &UploadedScene,
        pose: Pose,
        options: &Options,
        picture: &Picture,
        statistics: Statistics,
    ) -> Result<StereoPair, Error> {
        let pixels = picture.size[0] as usize * picture.size[1] as usize;
        // What bracket keeps has marks besides, so it is read whatever the user wants of it.
        let samples: Vec<layout::PixelHit> = match picture.kept {
            Kept::Samples => self.gpu.read(&picture.hits, 2 * pixels).await?,
            _ => Vec::new(),
        };
        let hits: Vec<layout::PixelHit> = match (options.g_buffer, picture.kept) {
            (GBuffer::None, _) | (_, Kept::None) => Vec::new(),
            (_, Kept::Samples) => {
                let id = |word: u32| scene.ids.get((word & layout::NO_SLOT) as usize).copied().unwrap_or(crate::MISS);
                samples.iter().map(|hit| layout::PixelHit { primitive: id(hit.primitive), ..*hit }).collect()
            }
            (_, Kept::Ids) => self.gpu.read(&picture.hits, 2 * pixels).await?,
            (_, Kept::Depth) => {
                let depths: Vec<f32> = self.gpu.read(&picture.hits, 2 * pixels).await?;
                depths.into_iter().map(|depth| layout::PixelHit { depth, primitive: crate::MISS }).collect()
            }
        };
        let rgba8: Vec<[u8; 4]> = self.gpu.read(&picture.pictures, 2 * pixels).await?;
        let counters = picture.size[1] as usize * layout::COUNTERS;
        let costs: Vec<u32> = match options.cost_map {
            true => self.gpu.read(&picture.counters, counters + 2 * pixels).await?.split_off(counters),
            false => Vec::new(),
        };
        let view = |eye: usize, linear, hits: &[layout::PixelHit]| {
            let with_ids = if options.g_buffer == GBuffer::Ids { hits } else { &[] };
            let depth = |hit: &layout::PixelHit| if hit.depth < crate::FAR { hit.depth } else { f32::INFINITY };
            let object = |hit: &layout::PixelHit| scene.objects.get(hit.primitive as usize).copied();
            View {
                width: picture.size[0],
                height: picture.size[1],
                rgba8: rgba8[eye * pixels..(eye + 1) * pixels].to_vec(),
                linear,
                depth: hits.iter().map(depth).collect(),
                primitive: with_ids.iter().map(|hit| hit.primitive).collect(),
                cost: costs.get(eye * pixels..(eye + 1) * pixels).unwrap_or_default().to_vec(),
                object: with_ids.iter().map(|hit| object(hit).unwrap_or(crate::MISS)).collect(),
            }
        };
        let left_linear: Vec<[f32; 4]> = self.gpu.read(&picture.left_color, pixels).await?;
        let (left_hits, right_hits) = hits.split_at(hits.len() / 2);
        // Reused pixels are the left ones that right_source names.
        let mut right_hits = right_hits.to_vec();
        let mut shadow_source = Vec::new();
        let (source, right_linear) = match statistics.method {
            Method::Naive | Method::Auto => {
                (vec![PixelSource::Traced; pixels], self.gpu.read(&picture.right_color, pixels).await?)
            }
            Method::Ideal => {
                right_hits.copy_from_slice(left_hits);
                (vec![PixelSource::Reused; pixels], left_linear.clone())
            }
            Method::Reuse { overlap: Overlap::Bracket(_), .. } => {
                let marks = || samples[pixels..].iter().map(|hit| hit.primitive);
                let source = marks().map(pixel_source).collect();
                shadow_source = marks().map(shadow_source_of).collect();
                (source, self.gpu.read(&picture.right_color, pixels).await?)
            }
            Method::Reuse { .. } => {
                let marks: Vec<u32> = self.gpu.read(&picture.right_source, pixels).await?;
                let mut linear: Vec<[f32; 4]> = self.gpu.read(&picture.right_color, pixels).await?;
                let source: Vec<_> = marks.iter().copied().map(pixel_source).collect();
                for (index, mark) in marks.iter().enumerate().filter(|(index, _)| source[*index] == PixelSource::Reused)
                {
                    let taken = index - index % picture.size[0] as usize + *mark as usize - 1;
                    linear[index] = left_linear[taken];
                    if let Some(hit) = right_hits.get_mut(index) {
                        *hit = left_hits[taken];
                    }
                }
                (source, linear)
            }
        };
        let left = view(0, left_linear, left_hits);
        let right = view(1, right_linear, &right_hits);
        Ok(StereoPair { left, right, source, shadow_source, statistics, pose })
    }
}

/// A counter of all rows.
fn sum_of(counters: &[u32], word: usize) -> u64 {
    counters.iter().skip(word).step_by(layout::COUNTERS).map(|&n| u64::from(n)).sum()
}

fn pixel_source(mark: u32) -> PixelSource {
    match mark {
        mark if mark & layout::MISSED != 0 => PixelSource::Missed,
        mark if mark & layout::BAD != 0 => PixelSource::Bad,
        _ => PixelSource::Reused,
    }
}

fn shadow_source_of(mark: u32) -> ShadowSource {
    if mark & layout::ASKED != 0 { ShadowSource::Traced } else { ShadowSource::Taken }
}

/// The method that a pair is made by: without interaxial right equals left, and where there is nothing to hit there is nothing to
/// bracket.
fn effective(method: Method, pose: &Pose, scene: &UploadedScene) -> Method {
    match method {
        Method::Naive => Method::Naive,
        _ if pose.interaxial == 0.0 => Method::Ideal,
        Method::Auto | Method::Reuse { overlap: Overlap::Bracket(_), .. } if scene.ids.is_empty() => Method::Naive,
        method => method,
    }
}

/// Passes over the picture that a method's frame has, for progress.
fn passes_of(method: Method) -> u32 {
    match method {
        Method::Auto => 4,
        Method::Naive => 3,
        Method::Ideal => 2,
        Method::Reuse { overlap: Overlap::Buffer(BufferDepth::Adaptive), verify: Verify::Edges } => 6,
        Method::Reuse { overlap: Overlap::Buffer(BufferDepth::Adaptive), .. } => 5,
        Method::Reuse { verify: Verify::Edges, .. } => 5,
        Method::Reuse { .. } => 4,
    }
}

/// One frame at work.
struct Passes<'a> {
    gpu: &'a Gpu,
    pipelines: &'a Pipelines,
    scene: &'a UploadedScene,
    specialisation: Specialisation,
    picture: &'a Picture,
    slots: &'a mut Option<Arc<wgpu::Buffer>>,
    slot_bytes: u64,
    /// Rows of a band.
    rows: u32,
    frame: layout::Frame,
    timestamps: Option<&'a mut Timestamps>,
    /// What threads keep from step to step, for kernels in steps.
    lanes: Option<wgpu::Buffer>,
    /// Time of what the host did in place of a pass.
    host: Duration,
    /// What `Auto` chose.
    choice: Option<Choice>,
    rows_done: u32,
    rows_total: u32,
    progress: &'a mut (dyn FnMut(Progress) -> ControlFlow<()> + Send),
}

impl Passes<'_> {
    /// The four passes. Returns the slots a right pixel of the 3D buffer, 0 without one.
    async fn frame(&mut self, pose: &Pose, method: Method) -> Result<u32, Error> {
        let p = self.picture;
        let mut buffer_depth = 0;
        self.clear(&[&p.counters, &p.right_source]).await?;
        // What is kept of left samples depends on it.
        self.specialisation.bits = match method {
            Method::Auto => ShadowReuse::Two,
            Method::Reuse { overlap: Overlap::Bracket(shadows), .. } => shadows,
            _ => ShadowReuse::Rays,
        };
        self.pass("trace_left", &kernels::TRACE_LEFT, &[&p.left_color, &p.hits, &p.counters]).await?;
        match method {
            Method::Naive => self.trace_right().await?,
            Method::Auto => {
                self.bound_tiles().await?;
                let choice = self.choose(pose).await?;
                match choice.method {
                    Method::Naive => self.trace_right().await?,
                    _ => self.resolve_bracket().await?,
                }
                self.choice = Some(choice);
            }
            Method::Ideal => {
                // Nothing: compose takes the left view for the right one.
            }
            Method::Reuse { overlap, verify } => {
                self.specialisation.verify = verify;
                buffer_depth = self.reproject(pose, overlap).await?;
                if verify == Verify::Edges {
                    self.scene.upload_object_table(self.gpu, self.pipelines).await?;
                    self.pass("mark_edges", &kernels::MARK_EDGES, &[&p.hits, &p.right_source]).await?;
                }
                match overlap {
                    Overlap::Bracket(_) => self.resolve_bracket().await?,
                    _ => self.resolve_right().await?,
                }
            }
        }
        self.specialisation.right = RightView::of(method);
        let compose: &[_] = &[&p.left_color, &p.right_color, &p.right_source, &p.pictures];
        self.pass("compose", &kernels::COMPOSE, compose).await?;
        Ok(buffer_depth)
    }

    /// Pass 2: which left sample each right pixel gets. Returns the slots a right pixel of the 3D buffer.
    async fn reproject(&mut self, pose: &Pose, overlap: Overlap) -> Result<u32, Error> {
        let p = self.picture;
        match overlap {
            Overlap::Atomic => {
                self.pass("reproject", &kernels::REPROJECT, &[&p.hits, &p.right_source]).await?;
                Ok(0)
            }
            Overlap::Scanline => {
                self.rows_pass(kernels::REPROJECT.name, &kernels::REPROJECT_SCANLINE, &[&p.hits, &p.right_source])
                    .await?;
                Ok(0)
            }
            Overlap::Sequential => {
                self.reproject_on_the_host(pose).await?;
                Ok(0)
            }
            Overlap::Bracket(_) => {
                self.bound_tiles().await?;
                Ok(0)
            }
            Overlap::Buffer(depth) => {
                let range = match depth {
                    BufferDepth::Adaptive => self.depth_range().await?,
                    _ => (f32::INFINITY, f32::INFINITY),
                };
                let slots = depth.slots(pose, range);
                self.reproject_by_slots(slots).await?;
                Ok(slots)
            }
        }
    }

    /// Pass 2 of `AdelsonHodges`, row after row.
    async fn reproject_on_the_host(&mut self, pose: &Pose) -> Result<(), Error> {
        let p = self.picture;
        self.gpu.wait(None)?;
        let begin = Instant::now();
        let pixels = p.size[0] as usize * p.size[1] as usize;
        let stride = p.kept.bytes() as usize / 4;
        let words: Vec<f32> = self.gpu.read(&p.hits, pixels * stride).await?;
        let depths: Vec<f32> = words.iter().step_by(stride).copied().collect();
        let right_source = crate::cpu::adelson_hodges::sweep(&crate::cpu::Frame::new(pose), &depths);
        self.gpu.queue.write_buffer(&p.right_source, 0, bytemuck::cast_slice(&right_source));
        self.host += begin.elapsed();
        self.bands(p.size[1], kernels::REPROJECT.name, |_, _| {}).await
    }

    /// Pass 3: check and take over, then trace what is left, band by band.
    async fn resolve_right(&mut self) -> Result<(), Error> {
        let p = self.picture;
        let resolve: &[_] = &[&p.hits, &p.right_source, &p.counters, &p.lists];
        let trace: &[_] = &[&p.lists, &p.hits, &p.right_color, &p.counters];
        self.bands(self.rows, kernels::RESOLVE_RIGHT.name, |this, encoder| {
            this.empty_lists();
            this.dispatch(encoder, &kernels::RESOLVE_RIGHT, resolve, Launch::Pixels);
            this.dispatch_listed(encoder, layout::TO_TRACE, &kernels::TRACE_LISTED, trace);
        })
        .await
    }

    /// The right view of `Naive`, traced as the left one was.
    async fn trace_right(&mut self) -> Result<(), Error> {
        let p = self.picture;
        self.frame.eye = 1;
        self.pass("trace_right", &kernels::TRACE_LEFT, &[&p.right_color, &p.hits, &p.counters]).await
    }

    /// Pass 2 of `bracket`: how deep each tile must be searched.
    async fn bound_tiles(&mut self) -> Result<(), Error> {
        let p = self.picture;
        self.bands(self.rows, kernels::REPROJECT.name, |this, encoder| {
            this.dispatch(encoder, &kernels::BOUND_TILES, &[&p.hits, &p.right_source, &p.counters], Launch::Runs);
        })
        .await
    }

    /// What the left view says of the right one's cost.
    async fn choose(&self, pose: &Pose) -> Result<Choice, Error> {
        let words: Vec<u32> = self.gpu.read(&self.picture.counters, pose.size[1] as usize * layout::COUNTERS).await?;
        let (shadow_rays, gaps) = (sum_of(&words, layout::SHADOW_RAYS), sum_of(&words, layout::GAP_PIXELS));
        let choice = CostModel::of(self.gpu).choose(pose, shadow_rays, gaps);
        log::debug!("{choice}");
        Ok(choice)
    }

    /// Pass 3 of `bracket`: primary visibility by tiles, the rest by rays; then shading, shadow rays where bits don't agree.
    async fn resolve_bracket(&mut self) -> Result<(), Error> {
        let p = self.picture;
        let search: &[_] = &[&p.right_source, &p.found, &p.counters, &p.lists];
        let resolve: &[_] = &[&p.found, &p.hits, &p.right_color, &p.counters, &p.lists];
        let listed: &[_] = &[&p.lists, &p.hits, &p.right_color, &p.counters];
        self.bands(self.rows, kernels::RESOLVE_RIGHT.name, |this, encoder| {
            this.empty_lists();
            this.dispatch(encoder, &kernels::SEARCH_TILES, search, Launch::Tiles);
            for (list, kernel, buffers) in [
                (layout::TO_RESOLVE, &kernels::RESOLVE_TILES, resolve),
                (layout::SKY, &kernels::SHADE_SKY, listed),
                (layout::TO_TRACE, &kernels::TRACE_BOUNDED, listed),
                (layout::TO_LIGHT, &kernels::SHADE_LISTED, listed),
            ] {
                this.dispatch_listed(encoder, list, kernel, buffers);
            }
        })
        .await
    }

    fn empty_lists(&self) {
        self.gpu.queue.write_buffer(&self.picture.lists, 0, bytemuck::cast_slice(&[layout::EMPTY_LIST; layout::LISTS]));
    }

    /// One kernel over what stands in a list. Its head is copied: what dispatches may not be bound for writing.
    fn dispatch_listed(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        list: u32,
        kernel: &Kernel,
        buffers: &[&wgpu::Buffer],
    ) {
        let p = self.picture;
        let head = u64::from(list) * size_of_val(&layout::EMPTY_LIST) as u64;
        encoder.copy_buffer_to_buffer(&p.lists, head, &p.indirect, 0, Some(p.indirect.size()));
        self.dispatch(encoder, kernel, buffers, Launch::Indirect);
    }

    /// Pass 2 of `Buffer`, in bands of rows whose slots fit one binding.
    async fn reproject_by_slots(&mut self, depth: u32) -> Result<(), Error> {
        let p = self.picture;
        let [width, height] = p.size;
        let row_bytes = u64::from(width) * u64::from(depth) * 4;
        let allowed = self.gpu.binding_limit();
        check_bytes(&format!("one row of a 3D buffer {depth} deep"), row_bytes, allowed, "use a smaller depth")?;
        let rows = (allowed / row_bytes).min(u64::from(height.min(self.rows))) as u32;
        let bytes = u64::from(rows) * row_bytes;
        self.slot_bytes = bytes;
        // One that is too small goes before the new one comes.
        let slots = match self.slots.take().filter(|slots| slots.size() >= bytes) {
            Some(slots) => slots,
            None => self.gpu.checked(|| Ok(Arc::new(self.gpu.storage_buffer("slots", bytes)))).await?,
        };
        *self.slots = Some(slots.clone());
        self.frame.buffer_depth = depth;
        self.bands(rows, kernels::REPROJECT.name, |this, encoder| {
            encoder.clear_buffer(&slots, 0, Some(bytes));
            this.dispatch(encoder, &kernels::REPROJECT_SLOTS, &[&p.hits, &slots, &p.counters], Launch::Pixels);
            this.dispatch(encoder, &kernels::GATHER_SLOTS, &[&slots, &p.right_source], Launch::Pixels);
        })
        .await
    }

    /// Nearest and farthest depth of the left view; the farthest is infinite as soon as one pixel is sky.
    async fn depth_range(&mut self) -> Result<(f32, f32), Error> {
        let p = self.picture;
        let height = p.size[1];
        self.rows_pass(kernels::DEPTH_RANGE.name, &kernels::DEPTH_RANGE, &[&p.hits, &p.counters]).await?;
        let words: Vec<u32> = self.gpu.read(&p.counters, height as usize * layout::COUNTERS).await?;
        let rows = words.chunks_exact(layout::COUNTERS);
        Ok(rows.fold((f32::INFINITY, 0.0), |(nearest, farthest), row| {
            let far = match f32::from_bits(row[layout::FARTHEST_DEPTH]) {
                far if far >= crate::FAR => f32::INFINITY,
                far => far,
            };
            (nearest.min(f32::from_bits(row[layout::NEAREST_DEPTH])), farthest.max(far))
        }))
    }

    async fn clear(&self, buffers: &[&wgpu::Buffer]) -> Result<(), Error> {
        let clear = || {
            let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            for buffer in buffers {
                encoder.clear_buffer(buffer, 0, None);
            }
            self.gpu.queue.submit([encoder.finish()]);
            Ok(())
        };
        self.gpu.checked(clear).await
    }

    /// One kernel over all pixels.
    async fn pass(&mut self, name: &'static str, kernel: &Kernel, buffers: &[&wgpu::Buffer]) -> Result<(), Error> {
        self.bands(self.rows, name, |this, encoder| {
            this.dispatch_as(name, encoder, kernel, buffers, Launch::Pixels);
        })
        .await
    }

    /// One kernel over all rows, a thread each.
    async fn rows_pass(&mut self, name: &'static str, kernel: &Kernel, buffers: &[&wgpu::Buffer]) -> Result<(), Error> {
        let height = self.picture.size[1];
        self.bands(height, name, |this, encoder| {
            let workgroups = height.div_ceil(WORKGROUP * WORKGROUP);
            this.dispatch(encoder, kernel, buffers, Launch::Rows(workgroups));
        })
        .await
    }

    /// Encodes and submits a pass band by band. At most two bands are in flight, so that progress means something and
    /// a callback can stop the frame.
    async fn bands(
        &mut self,
        rows: u32,
        name: &'static str,
        mut encode: impl FnMut(&mut Self, &mut wgpu::CommandEncoder),
    ) -> Result<(), Error> {
        let gpu = self.gpu;
        let submit_all = || {
            let height = self.picture.size[1];
            let mut before = None;
            for begin in (0..height).step_by(rows as usize) {
                (self.frame.row_begin, self.frame.row_end) = (begin, height.min(begin + rows));
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                encode(self, &mut encoder);
                gpu.queue.write_buffer(&self.picture.frame, 0, bytemuck::bytes_of(&self.frame));
                let submission = gpu.queue.submit([encoder.finish()]);
                if let Some(before) = before.replace(submission) {
                    gpu.wait(Some(before))?;
                }
                self.rows_done += self.frame.row_end - begin;
                let done = (self.rows_done as f32 / self.rows_total as f32).min(1.0);
                if (self.progress)(Progress { pass: name, done }).is_break() {
                    return Err(Error::Cancelled);
                }
            }
            Ok(())
        };
        gpu.checked(submit_all).await
    }

    fn dispatch(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        kernel: &Kernel,
        buffers: &[&wgpu::Buffer],
        launch: Launch,
    ) {
        self.dispatch_as(kernel.name, encoder, kernel, buffers, launch);
    }

    fn dispatch_as(
        &mut self,
        name: &'static str,
        encoder: &mut wgpu::CommandEncoder,
        kernel: &Kernel,
        buffers: &[&wgpu::Buffer],
        launch: Launch,
    ) {
        let pipeline = self.pipelines.get(self.gpu, kernel, self.specialisation);
        let resources = std::iter::once(&self.picture.frame).chain(buffers.iter().copied());
        let samples = kernel.samples(&self.specialisation).and(self.picture.samples.as_ref());
        let samples = samples.map(|view| (SAMPLES_BINDING, wgpu::BindingResource::TextureView(view)));
        let lanes = self.lanes.as_ref().filter(|_| kernel.in_steps());
        let lanes = lanes.map(|buffer| (STEPS_BINDING, buffer.as_entire_binding()));
        let resources = (0..).zip(resources.map(wgpu::Buffer::as_entire_binding)).chain(samples).chain(lanes);
        let own = bind_group_at(self.gpu, kernel.name, &pipeline.own, resources);
        let timestamp_writes = self.timestamps.as_mut().and_then(|timestamps| timestamps.next(name));
        let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(&pipeline.pipeline);
        if kernel.touches.geometry() {
            pass.set_bind_group(0, &self.scene.geometry, &[]);
        }
        pass.set_bind_group(1, &own, &[]);
        if kernel.touches.table() {
            let table = match kernel.touches {
                Touches::Objects => self.scene.object_table.get().expect("uploaded before the pass that reads it"),
                _ => &self.scene.shading,
            };
            pass.set_bind_group(2, table, &[]);
        }
        let [width, rows] = [self.picture.size[0], self.frame.row_end - self.frame.row_begin];
        // Pixels of a thread in x and in y.
        let mut over = |x: u32, y: u32| {
            pass.dispatch_workgroups(width.div_ceil(WORKGROUP * x), rows.div_ceil(WORKGROUP * y), 1);
        };
        match launch {
            Launch::Pixels => over(kernel.block(&self.specialisation), kernel.block(&self.specialisation)),
            Launch::Runs => over(layout::TILE, 1),
            Launch::Tiles => over(layout::TILE, layout::TILE),
            Launch::Rows(workgroups) => pass.dispatch_workgroups(1, workgroups, 1),
            Launch::Indirect => pass.dispatch_workgroups_indirect(&self.picture.indirect, 0),
        }
    }

    /// Waits for the last band and lets the timestamps be read.
    async fn finish(&mut self) -> Result<(), Error> {
        let gpu = self.gpu;
        let resolve = || {
            if let Some(timestamps) = &self.timestamps {
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                timestamps.resolve(&mut encoder);
                gpu.queue.submit([encoder.finish()]);
            }
            gpu.wait(None)
        };
        gpu.checked(resolve).await
    }
}

/// How a kernel is launched over a band.
enum Launch {
    /// A thread a pixel of the band, or a block of pixels where the kernel traces rays.
    Pixels,
    /// A thread a run of a tile's width in each row of the band.
    Runs,
    /// A thread a tile of the band.
    Tiles,
    /// A thread a row of the picture, in this many workgroups.
    Rows(u32),
    /// By a list that an earlier kernel filled.
    Indirect,
}

/// The camera as kernels read it. Directions have length 1 along the view axis: a ray's t is the depth Z.
pub(crate) fn frame_uniform(pose: &Pose) -> layout::Frame {
    let [w, h] = pose.size.map(f64::from);
    let [screen_width, screen_height] = pose.screen_size.map(f64::from);
    let (d, e) = (f64::from(pose.screen_distance), f64::from(pose.interaxial));
    let [forward, right, up] = [pose.forward, pose.right, pose.up].map(Vec3::as_dvec3);
    let corner = |side: f64| {
        let x = -0.5 * screen_width - 0.5 * side * e;
        (forward + right * (x / d) + up * (0.5 * screen_height / d)).as_vec3().to_array()
    };
    let array = |v: DVec3| v.as_vec3().to_array();
    // To the corner of the picture that lies farthest aside, of either eye.
    let aside = (0.5 * (screen_width + e) / d).hypot(0.5 * screen_height / d);
    let longest = (1.0_f64.hypot(aside) * 1.001) as f32;
    layout::Frame {
        left_eye: pose.eye_position(-1.0).to_array(),
        right_eye: pose.eye_position(1.0).to_array(),
        left_corner: corner(-1.0),
        right_corner: corner(1.0),
        step_x: array(right * (screen_width / w / d)),
        step_y: array(up * (-screen_height / h / d)),
        right_axis: pose.right.to_array(),
        forward: pose.forward.to_array(),
        longest,
        interaxial: pose.interaxial,
        interaxial_px: pose.interaxial_px,
        screen_distance: pose.screen_distance,
        image_size: pose.size,
        row_end: pose.size[1],
        wider: wider(pose),
        ..layout::Frame::default()
    }
}

/// Pixels by which the search of a tile widens projected bounds: four times what the directions of this picture's corners
/// may be rounded by, and never less than in an ordinary picture.
fn wider(pose: &Pose) -> f32 {
    let pixel_angle = least_pixel_angle(pose, f64::from(pose.interaxial));
    WIDER.max((f64::from(f32::EPSILON) * 8.0 / pixel_angle) as f32)
}

/// Texels of the shading table before its lights.
const TABLE_HEAD: usize = 3;

fn texels_before_sky(scene: &Scene) -> usize {
    TABLE_HEAD + 2 * scene.lights.len() + scene.materials().len()
}

/// The pixels of a sky that is a picture.
fn sky_pixels(scene: &Scene) -> &[Vec3] {
    if let Sky::Map(map) = &scene.sky { map.pixels() } else { &[] }
}

/// What shading reads of a scene, a texel each: see shaders/shared/shade.wgsl.
fn shading_table(scene: &Scene) -> impl Iterator<Item = bvh::Texel> {
    let texel = |vector: Vec3, word: u32| {
        let [x, y, z] = vector.to_array().map(f32::to_bits);
        [x, y, z, word]
    };
    let plain = move |vector| texel(vector, 0);
    let [nadir, zenith] = match &scene.sky {
        Sky::Constant(color) => [*color; 2].map(plain),
        Sky::Gradient { nadir, zenith } => [*nadir, *zenith].map(plain),
        Sky::Map(map) => [[texels_before_sky(scene) as u32, map.size()[0], map.size()[1], 0], [0; 4]],
    };
    let head: [_; TABLE_HEAD] = [texel(scene.rendered_ambient(), scene.lights.len() as u32), nadir, zenith];
    let lights = scene.lights.iter().flat_map(|light| [light.position, light.intensity]);
    let albedos = scene.materials().iter().map(|material| material.albedo);
    head.into_iter().chain(lights.chain(albedos).chain(sky_pixels(scene).iter().copied()).map(plain))
}

/// The object of each primitive, four a texel.
fn object_texels(objects: &[u32]) -> Vec<bvh::Texel> {
    let texel = |four: &[u32]| std::array::from_fn(|index| four.get(index).copied().unwrap_or(crate::MISS));
    if objects.is_empty() { vec![[crate::MISS; 4]] } else { objects.chunks(4).map(texel).collect() }
}

/// Renders a stereo pair in one call: opens a device, uploads the scene and renders it by [`Method::Auto`]. For
/// more than one picture keep a [`Renderer`].
///
/// # Errors
/// As [`Gpu::new`], [`Renderer::upload`] and [`Renderer::render`].
pub fn render_stereo(scene: &Scene, camera: &StereoCamera) -> Result<StereoPair, Error> {
    let mut renderer = Renderer::new(Gpu::new()?);
    let uploaded = renderer.upload(scene)?;
    renderer.render(&uploaded, camera, &Options::default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn bands_are_whole_workgroups_and_few_enough_for_the_timestamps() {
        for size in [[1, 1], [63, 65], [1280, 720], [3840, 2160], [100_000, 7], [7, 100_000], [16384, 16384]] {
            let rows = band_rows(size, BAND_PIXELS);
            assert_eq!(rows % WORKGROUP, 0);
            assert!(2 * 8 * size[1].div_ceil(rows) <= wgpu::QUERY_SET_MAX_QUERIES, "{size:?} {rows}");
        }
        assert_eq!(band_rows([3840, 2160], BAND_PIXELS), 72);
    }

    fn renderer(band_pixels: u32) -> Renderer {
        let wanted = std::env::var(crate::gpu::ADAPTER_VARIABLE).unwrap_or_else(|_| "software".into());
        let mut renderer = Renderer::new(Gpu::open(&wanted).unwrap());
        renderer.band_pixels = band_pixels;
        renderer
    }

    #[test]
    fn bands_change_nothing_but_the_number_of_dispatches() {
        let builtin = crate::scene::builtin::Builtin::Hall;
        let camera = builtin.camera(130, 71);
        let mut renderer = renderer(BAND_PIXELS);
        let uploaded = renderer.upload(&builtin.scene()).unwrap();
        // Counting traces one ray a lane; those of the tiles' search are to be seen as they ship.
        let counted = [Method::Naive, Method::Ideal, Method::ATOMIC, Method::BUFFER, Method::BRACKET];
        let shipped = [Method::BRACKET, Method::VERIFIED, Method::BRACKET_RAYS];
        let counted = counted.map(|method| Options::new(method).counting());
        for options in counted.into_iter().chain(shipped.map(Options::new)) {
            let method = options.method;
            let [whole, banded] = [BAND_PIXELS, 130 * 16].map(|band_pixels| {
                renderer.band_pixels = band_pixels;
                renderer.picture = None; // its lists are as long as a band
                let mut calls = 0;
                let mut count = |_| {
                    calls += 1;
                    ControlFlow::Continue(())
                };
                let mut pair = renderer.render_with(&uploaded, &camera, &options, &mut count).unwrap();
                pair.statistics.times = None;
                pair.statistics.intermediate_bytes = 0;
                (pair, calls)
            });
            assert_eq!(whole.0, banded.0, "{method}");
            assert!(banded.1 >= 4 * whole.1 - 4, "{method}: {} {}", whole.1, banded.1);
        }
    }

    #[test]
    fn every_traversal_gives_the_same_pair() {
        use crate::scene::builtin::Builtin;
        let spheres_and_triangles = Builtin::Near;
        for builtin in [Builtin::Hall, Builtin::Spheres, spheres_and_triangles] {
            let camera = builtin.camera(65, 40);
            let pairs = Traversal::ALL.map(|traversal| {
                let mut renderer = Renderer::with_traversal(renderer(BAND_PIXELS).gpu, traversal);
                let uploaded = renderer.upload(&builtin.scene()).unwrap();
                let mut pair = renderer.render(&uploaded, &camera, &Options::default()).unwrap();
                // Which of several occluders is kept, and so how many rays it spares, is the traversal's.
                pair.statistics = Statistics::default();
                pair
            });
            for (traversal, pair) in Traversal::ALL.iter().zip(&pairs) {
                assert_eq!(*pair, pairs[0], "{builtin} {traversal:?}");
            }
        }
    }

    /// Runs reprojection alone on given left depths.
    fn reproject(pose: &Pose, depths: &[f32], overlap: Overlap) -> (Vec<u32>, u64) {
        let mut renderer = renderer(64 * 16);
        let scene = renderer.upload(&Scene::new()).unwrap();
        let run = async {
            let picture =
                renderer.picture_of(Need { size: pose.size, kept: Kept::Ids, reuse: true, cost_map: false }).await?;
            let hits: Vec<_> = depths.iter().map(|&depth| layout::PixelHit { depth, primitive: 0 }).collect();
            renderer.gpu.queue.write_buffer(&picture.hits, 0, bytemuck::cast_slice(&hits));
            let mut go_on = |_| ControlFlow::Continue(());
            let mut passes = renderer.passes(&scene, pose, &Options::default(), &picture, &mut go_on);
            passes.clear(&[&picture.counters, &picture.right_source]).await?;
            passes.reproject(pose, overlap).await?;
            let lost = renderer.statistics(&picture, Method::Naive).await?.unwrap().lost_candidates;
            Ok::<_, Error>((renderer.gpu.read(&picture.right_source, depths.len()).await?, lost))
        };
        pollster::block_on(run).unwrap()
    }

    fn pose(size: [u32; 2], interaxial_px: f32) -> Pose {
        let camera = StereoCamera::look_at(4.0 * Vec3::Z, Vec3::ZERO).screen_distance(4.0);
        camera.size(size[0], size[1]).interaxial_pixels(interaxial_px).pose().unwrap()
    }

    #[test]
    fn the_index_buffer_equals_a_sequential_computation() {
        let size = [131, 37];
        let mut random = Random::new(9);
        for interaxial_px in [0.5, 7.0, 40.0] {
            let pose = pose(size, interaxial_px);
            let depths: Vec<f32> = (0..size[0] * size[1])
                .map(|index| match index % 7 {
                    0 => crate::FAR,
                    1 => pose.screen_distance,
                    2 => 0.5 * pose.screen_distance,
                    3 => 1e-6 * random.unit(),
                    _ => random.between(1.0, 10.0),
                })
                .collect();
            let expected = crate::cpu::reproject::reproject(&crate::cpu::Frame::new(&pose), &depths);
            assert!(expected.contains(&0) && expected.iter().any(|&source| source > 0));
            for overlap in [Overlap::Atomic, Overlap::Buffer(BufferDepth::Adaptive)] {
                assert_eq!(reproject(&pose, &depths, overlap).0, expected, "{overlap:?} {interaxial_px}");
            }
        }
    }

    #[test]
    fn samples_land_where_the_closed_form_says_ties_included() {
        // e_px = 8 and d = 4: parallax 8 (1 - 4/z).
        let pose = pose([40, 1], 8.0);
        let land = |column: usize, z: f32| {
            let mut depths = vec![1e-9; 40]; // so near that all others leave the picture
            depths[column] = z;
            let source = reproject(&pose, &depths, Overlap::Atomic).0;
            source.iter().position(|&source| source == column as u32 + 1)
        };
        assert_eq!(land(20, 4.0), Some(20), "on the screen");
        assert_eq!(land(20, 2.0), Some(12), "at d/2: e to the left");
        assert_eq!(land(20, crate::FAR), Some(28), "sky: e to the right");
        assert_eq!(land(20, 8.0), Some(24), "at 2d: half of e");
        // 8 (1 - 4/z) = 0.5 exactly at z = 64/15, which f32 rounds up: X = 21.0 or just above lands in 21.
        assert_eq!(land(20, 64.0 / 15.0), Some(21), "a tie goes to the right");
        // Parallax -0.5 exactly: X = 20.0 stays in 20.
        assert_eq!(land(20, 64.0 / 17.0), Some(20));
        assert_eq!(land(35, crate::FAR), None, "past the right edge");
        assert_eq!(land(7, 2.0), None, "past the left edge");
        assert_eq!(land(8, 2.0), Some(0), "X = 0.5");
        assert_eq!(land(8, 32.0 / 16.5), Some(0), "X = 0 exactly is inside");
    }

    #[test]
    fn twice_e_is_one_slot_short_at_half_the_screen_s_distance() {
        // Lemma 1 with equality: B = e d (1/(d/2) - 0) = 2e; columns 2e apart meet, and slot i mod 2e is the same.
        let pose = pose([40, 1], 8.0);
        let mut depths = vec![1e-9; 40];
        (depths[10], depths[26]) = (crate::FAR, 2.0);
        let (source, lost) = reproject(&pose, &depths, Overlap::Buffer(BufferDepth::TwiceInteraxial));
        assert_eq!((source[18], lost), (27, 1), "the nearer one stands, the other is lost");
        // (The samples that leave the picture do not matter to Lemma 1; here they would make the buffer 40 deep.)
        let (source, lost) = reproject(&pose, &depths, Overlap::Buffer(BufferDepth::Fixed(18)));
        assert_eq!((source[18], lost), (27, 0), "floor(B) + 2 slots hold both");
    }

    #[test]
    fn renderer_and_scene_may_cross_threads() {
        fn check<T: Send + Sync>() {}
        check::<Renderer>();
        check::<UploadedScene>();
        check::<Gpu>();
        check::<Error>();
    }
}
