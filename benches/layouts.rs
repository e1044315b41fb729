//! Which of obvhs's layouts an adapter traces fastest: `Bvh2` or `CwBvh`, from textures or from storage buffers.
//!
//! `cargo bench --bench layouts [-- SCENE...]` traces the left view's primary rays of each scene with every layout, in
//! interleaved rounds, and prints a Markdown table; docs/TRAVERSAL.md says what follows from it. Every layout's hits are
//! compared with the library's own. Scenes other than the built-in hall are looked for in `$STEREOTRACE_SCENES`, else in
//! target/scenes.

use std::{
    error::Error,
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use bytemuck::{Pod, Zeroable, cast_slice};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    cwbvh::{CwBvh, builder::build_cwbvh},
};
use stereotrace::{
    FAR, Gpu, Method, Options, Pose, Renderer, Scene, StereoCamera, Triangle, View,
    glam::{DVec3, Vec3},
    scene::builtin::Builtin,
    wgpu::{self, util::DeviceExt},
};

const SIZE: u32 = 512;
const WARM_UPS: usize = 2;
const ROUNDS: usize = 7;
const TEXTURE_WIDTH: usize = 8192;
const SCENES: [&str; 3] = ["hall", "sponza_4x", "dragon"];

type Texel = [u32; 4];

/// Words of `BenchHit` in layouts/primary.wgsl.
const DEPTH: usize = 0;
const PRIMITIVE: usize = 1;
const NODES_VISITED: usize = 2;
const PRIMITIVES_TESTED: usize = 3;

/// What the scene is read from.
const TEXTURES: &str = "textures";
const BUFFERS: &str = "storage buffers";

/// A scene's tree in one layout, ready to upload.
struct Packed {
    name: &'static str,
    traversal: &'static str,
    nodes: Vec<Texel>,
    primitives: Vec<Texel>,
    stack_size: usize,
}

/// A layout on the device, and how it is read.
struct Variant<'a> {
    layout: &'a Packed,
    fetch: &'static str,
    kernel: Kernel,
    counting: Kernel,
    times: Vec<Duration>,
}

struct Kernel {
    pipeline: wgpu::ComputePipeline,
    groups: [wgpu::BindGroup; 2],
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut wanted: Vec<String> = std::env::args().skip(1).collect();
    if !wanted.iter().any(|argument| argument == "--bench") {
        println!("layouts: nothing measured; run it with cargo bench --bench layouts");
        return Ok(());
    }
    wanted.retain(|argument| !argument.starts_with('-'));
    let gpu = Gpu::new()?;
    // The library's handler only logs: after a kernel that doesn't build, the last one's times would be read again.
    gpu.device().on_uncaptured_error(Arc::new(|error| panic!("{error}")));
    let bench = Bench::new(&gpu);
    println!("Adapter: {}, {}", gpu.adapter_name(), gpu.driver());
    let clock = if bench.timestamps.is_some() { "timestamps" } else { "wall clock" };
    println!("{SIZE}x{SIZE} primary rays, {WARM_UPS} warm-ups, {ROUNDS} interleaved rounds, {clock}");
    for name in SCENES {
        if wanted.is_empty() || wanted.iter().any(|argument| argument == name) {
            match load(name)? {
                Some((scene, camera)) => bench.scene(name, scene, &camera)?,
                None => println!("\nskipped: scene not found: {name} (STEREOTRACE_SCENES names the folder of scenes)"),
            }
        }
    }
    Ok(())
}

fn load(name: &str) -> Result<Option<(Scene, StereoCamera)>, stereotrace::Error> {
    if let Ok(builtin) = name.parse::<Builtin>() {
        return Ok(Some((builtin.scene(), builtin.camera(SIZE, SIZE))));
    }
    let folder = std::env::var_os("STEREOTRACE_SCENES").map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/target/scenes").into());
    let file = folder.join(name).join(format!("{name}.obj"));
    if !file.exists() {
        return Ok(None);
    }
    let camera = StereoCamera::from_json(folder.join("cameras.json"), name, SIZE, SIZE)?;
    Ok(Some((Scene::from_obj(file)?, camera)))
}

// --- Packing ---

fn pack(scene: &Scene) -> (Bounds, [Packed; 3]) {
    // Those with an area, as in the library.
    let traced = scene.triangles().iter().enumerate().filter(|(_, triangle)| !triangle.is_degenerate());
    let of_id = |(id, triangle): (usize, &Triangle)| (id as u32, Aabb::from_points(&triangle.corners.map(Into::into)));
    let (ids, boxes): (Vec<u32>, Vec<Aabb>) = traced.map(of_id).unzip();
    let params = BvhBuildParams { max_prims_per_leaf: 8, ..BvhBuildParams::medium_build() };
    let bvh2 = build_bvh2(&boxes, params, &mut Duration::default());
    let cwbvh = build_cwbvh(&boxes, params, &mut Duration::default());
    assert!(!bvh2.nodes[0].is_leaf(), "scenes to measure have more than a leaf of triangles");
    let bounds = Bounds::of(&bvh2);
    let primitives = |order: &[u32]| order.iter().flat_map(|&index| corners(scene, ids[index as usize])).collect();
    let (grid_nodes, grid_order, depth) = pack_grid(&bvh2, &bounds);
    let layout = |name, traversal, nodes: &[Texel], order, depth: usize| Packed {
        name,
        traversal,
        nodes: nodes.to_vec(),
        primitives: primitives(order),
        stack_size: depth + 1,
    };
    let (grid, exact) = (include_str!("layouts/bvh2_grid.wgsl"), include_str!("layouts/bvh2_f32.wgsl"));
    let wide = include_str!("layouts/cwbvh.wgsl");
    let packed = [
        layout("Bvh2, 16-bit boxes", grid, &grid_nodes, &grid_order, depth),
        layout("Bvh2, f32 boxes", exact, cast_slice(&bvh2.nodes), &bvh2.primitive_indices, depth),
        layout("CwBvh", wide, cast_slice(&cwbvh.nodes), &cwbvh.primitive_indices, cwbvh_depth(&cwbvh)),
    ];
    (bounds, packed)
}

/// Three texels a triangle, as in shaders/shared/triangle.wgsl.
fn corners(scene: &Scene, id: u32) -> [Texel; 3] {
    let [a, b, c] = scene.triangles()[id as usize].corners.map(|v| v.to_array().map(f32::to_bits));
    [[a[0], a[1], a[2], id], [b[0], b[1], b[2], 0], [c[0], c[1], c[2], 0]]
}

/// `Bvh` of shaders/shared/bvh.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Bounds {
    grid_origin: Vec3,
    extent: f32,
    grid_cell: Vec3,
    _pad: u32,
}

impl Bounds {
    fn of(bvh2: &Bvh2) -> Self {
        let (low, high) = (bvh2.nodes[0].min.as_dvec3(), bvh2.nodes[0].max.as_dvec3());
        let sides = high - low;
        let extent = sides.max_element();
        let cell = (sides / 65535.0).max(DVec3::splat(extent * 1e-9)).as_vec3().to_array();
        let grid_cell = Vec3::from_array(cell.map(|side| side.next_up().next_up()));
        Self { grid_origin: low.as_vec3(), extent: extent as f32, grid_cell, _pad: 0 }
    }

    fn quantise(&self, low: Vec3, high: Vec3) -> [u32; 3] {
        let steps = |v: Vec3| (v.as_dvec3() - self.grid_origin.as_dvec3()) / self.grid_cell.as_dvec3();
        let whole = |v: DVec3| v.clamp(DVec3::ZERO, DVec3::splat(65535.0)).as_uvec3();
        let (low, high) = (whole(steps(low).floor()), whole(steps(high).ceil()));
        [low.x | low.y << 16, low.z | high.x << 16, high.y | high.z << 16]
    }
}

/// The library's nodes: pairs of children in depth-first order, and the order of their primitives.
fn pack_grid(bvh2: &Bvh2, bounds: &Bounds) -> (Vec<Texel>, Vec<u32>, usize) {
    let (mut nodes, mut order, mut deepest): (Vec<Texel>, Vec<u32>, usize) = Default::default();
    let mut pending = vec![(bvh2.nodes[0].first_index as usize, None, 1)];
    while let Some((first, link, depth)) = pending.pop() {
        let texel = nodes.len();
        if let Some(link) = link {
            let link: &mut Texel = &mut nodes[link];
            link[3] = texel as u32 / 2;
        }
        deepest = deepest.max(depth);
        for node in &bvh2.nodes[first..first + 2] {
            let [x, y, z] = bounds.quantise(node.min, node.max);
            let leaf = 1 << 31 | node.prim_count.wrapping_sub(1) << 28 | order.len() as u32;
            nodes.push([x, y, z, if node.is_leaf() { leaf } else { 0 }]);
            if node.is_leaf() {
                let first = node.first_index as usize;
                order.extend(&bvh2.primitive_indices[first..first + node.prim_count as usize]);
            }
        }
        for child in [1, 0] {
            let node = &bvh2.nodes[first + child];
            if !node.is_leaf() {
                pending.push((node.first_index as usize, Some(texel + child), depth + 1));
            }
        }
    }
    (nodes, order, deepest)
}

/// Levels of nodes; children stand behind their parents.
fn cwbvh_depth(cwbvh: &CwBvh) -> usize {
    let mut depths = vec![1; cwbvh.nodes.len()];
    for (index, node) in cwbvh.nodes.iter().enumerate() {
        let first = node.child_base_idx as usize;
        let depth = depths[index] + 1;
        depths[first..first + node.imask.count_ones() as usize].fill(depth);
    }
    depths.into_iter().max().unwrap_or(0)
}

/// `Frame` of shaders/shared/types.wgsl; only what the left view's rays need is filled in.
fn frame(pose: &Pose) -> [Texel; 8] {
    let [width, height] = pose.screen_size.map(|side| f64::from(side) / f64::from(pose.screen_distance));
    let shift = 0.5 * f64::from(pose.interaxial) / f64::from(pose.screen_distance);
    let [forward, right, up] = [pose.forward, pose.right, pose.up].map(Vec3::as_dvec3);
    let size = f64::from(SIZE);
    let row = |v: DVec3, w: u32| v.as_vec3().extend(f32::from_bits(w)).to_array().map(f32::to_bits);
    let mut rows = [[0; 4]; 8];
    rows[0] = row(pose.eye_position(-1.0).as_dvec3(), 0);
    rows[2] = row(forward + right * (shift - 0.5 * width) + up * (0.5 * height), 0);
    rows[4] = row(right * (width / size), 0);
    rows[5] = row(up * (-height / size), 0);
    rows[6][3] = SIZE; // row_end
    rows[7] = [SIZE, SIZE, 0, 0];
    rows
}

// --- Device ---

struct Bench<'a> {
    gpu: &'a Gpu,
    device: &'a wgpu::Device,
    hits: wgpu::Buffer,
    timestamps: Option<(wgpu::QuerySet, wgpu::Buffer)>,
}

impl<'a> Bench<'a> {
    fn new(gpu: &'a Gpu) -> Self {
        let device = gpu.device();
        let buffer = |label, size, usage| {
            let usage = usage | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let queries = wgpu::QuerySetDescriptor { label: Some("times"), ty: wgpu::QueryType::Timestamp, count: 2 };
        let offered = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let resolved = || buffer("times", 16, wgpu::BufferUsages::QUERY_RESOLVE);
        let timestamps = offered.then(|| (device.create_query_set(&queries), resolved()));
        let hits = buffer("hits", u64::from(SIZE * SIZE) * 16, wgpu::BufferUsages::STORAGE);
        Self { gpu, device, hits, timestamps }
    }

    fn scene(&self, name: &str, mut scene: Scene, camera: &StereoCamera) -> Result<(), Box<dyn Error>> {
        scene.lights.clear(); // no shadow rays in the library's views
        let pose = camera.pose()?;
        let mut renderer = Renderer::new(self.gpu.clone());
        let uploaded = renderer.upload(&scene)?;
        let reference = renderer.render(&uploaded, camera, &Options::new(Method::Naive))?.left;
        let (bounds, layouts) = pack(&scene);
        let mut variants = Vec::new();
        for packed in &layouts {
            for fetch in [TEXTURES, BUFFERS] {
                variants.push(self.variant(packed, fetch, &bounds, &pose));
            }
        }
        for round in 0..WARM_UPS + ROUNDS {
            for turn in 0..variants.len() {
                let index = (round + turn) % variants.len();
                let time = self.run(&variants[index].kernel)?;
                if round >= WARM_UPS {
                    variants[index].times.push(time);
                }
            }
        }
        println!("\n{name}, {} triangles:\n", scene.triangles().len());
        println!(
            "| layout | read from | Mrays/s | median ms (least to most) | nodes a ray | triangles a ray | nodes MiB | \
             triangles MiB | differ + tie |\n|---|---|---|---|---|---|---|---|---|"
        );
        for mut variant in variants {
            self.run(&variant.kernel)?;
            let (differ, ties) = compare(&self.read(&self.hits)?, &reference);
            self.run(&variant.counting)?;
            let counts: Vec<Texel> = self.read(&self.hits)?;
            let mean = |word: usize| counts.iter().map(|hit| f64::from(hit[word])).sum::<f64>() / counts.len() as f64;
            variant.times.sort();
            let ms = |index: usize| variant.times[index].as_secs_f64() * 1e3;
            let mib = |texels: &[Texel]| size_of_val(texels) as f64 / (1 << 20) as f64;
            println!(
                "| {} | {} | {:.2} | {:.0} ({:.0} to {:.0}) | {:.1} | {:.1} | {:.1} | {:.1} | {differ} + {ties} |",
                variant.layout.name,
                variant.fetch,
                f64::from(SIZE * SIZE) / ms(ROUNDS / 2) / 1e3,
                ms(ROUNDS / 2),
                ms(0),
                ms(ROUNDS - 1),
                mean(NODES_VISITED),
                mean(PRIMITIVES_TESTED),
                mib(&variant.layout.nodes),
                mib(&variant.layout.primitives),
            );
        }
        Ok(())
    }

    fn variant<'b>(&self, packed: &'b Packed, fetch: &'static str, bounds: &Bounds, pose: &Pose) -> Variant<'b> {
        let parts = [
            include_str!("../shaders/shared/types.wgsl"),
            match fetch {
                TEXTURES => include_str!("../shaders/shared/fetch_texture.wgsl"),
                _ => include_str!("../shaders/shared/fetch_buffer.wgsl"),
            },
            include_str!("../shaders/shared/shade_types.wgsl"),
            include_str!("../shaders/shared/bvh.wgsl"),
            include_str!("../shaders/shared/triangle.wgsl"),
            include_str!("../shaders/shared/normal_flat.wgsl"),
            include_str!("../shaders/shared/primitives_triangles.wgsl"),
            packed.traversal,
            include_str!("layouts/primary.wgsl"),
        ];
        let text = format!("const STACK_SIZE: u32 = {}u;\n{}", packed.stack_size, parts.concat());
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(packed.name),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let geometry = [
            Resource::Buffer(self.buffer("bvh", bytemuck::bytes_of(bounds), wgpu::BufferUsages::UNIFORM)),
            self.upload("nodes", &packed.nodes, fetch),
            self.upload("primitives", &packed.primitives, fetch),
        ];
        let frame = self.buffer("frame", cast_slice(&frame(pose)), wgpu::BufferUsages::UNIFORM);
        let own = [Resource::Buffer(frame), Resource::Buffer(self.hits.clone())];
        let kernel = |count: f64| {
            let constants = [("COUNT", count)];
            let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(packed.name),
                layout: None,
                module: &module,
                entry_point: Some("primary"),
                compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
                cache: None,
            });
            let groups = [self.group(&pipeline, 0, &geometry), self.group(&pipeline, 1, &own)];
            Kernel { pipeline, groups }
        };
        Variant { layout: packed, fetch, kernel: kernel(0.0), counting: kernel(1.0), times: Vec::new() }
    }

    fn buffer(&self, label: &str, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
    }

    fn upload(&self, label: &str, texels: &[Texel], fetch: &str) -> Resource {
        if fetch == BUFFERS {
            return Resource::Buffer(self.buffer(label, cast_slice(texels), wgpu::BufferUsages::STORAGE));
        }
        let rows = texels.len().div_ceil(TEXTURE_WIDTH);
        let mut padded = texels.to_vec();
        padded.resize(rows * TEXTURE_WIDTH, [0; 4]);
        let size = wgpu::Extent3d { width: TEXTURE_WIDTH as u32, height: rows as u32, depth_or_array_layers: 1 };
        let descriptor = wgpu::TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Uint,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let order = wgpu::util::TextureDataOrder::default();
        let texture = self.device.create_texture_with_data(self.gpu.queue(), &descriptor, order, cast_slice(&padded));
        Resource::Texture(texture.create_view(&wgpu::TextureViewDescriptor::default()))
    }

    fn group(&self, pipeline: &wgpu::ComputePipeline, group: u32, resources: &[Resource]) -> wgpu::BindGroup {
        let resources = resources.iter().map(|resource| match resource {
            Resource::Buffer(buffer) => buffer.as_entire_binding(),
            Resource::Texture(view) => wgpu::BindingResource::TextureView(view),
        });
        let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
        let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
        let layout = &pipeline.get_bind_group_layout(group);
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("layouts"), layout, entries: &entries })
    }

    /// Traces the view once and says how long the device took, or how long we waited where it can't say.
    fn run(&self, kernel: &Kernel) -> Result<Duration, Box<dyn Error>> {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.clear_buffer(&self.hits, 0, None); // what isn't written differs
        let timestamp_writes = self.timestamps.as_ref().map(|(query_set, _)| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        });
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("primary"), timestamp_writes });
        pass.set_pipeline(&kernel.pipeline);
        for (index, group) in kernel.groups.iter().enumerate() {
            pass.set_bind_group(index as u32, group, &[]);
        }
        pass.dispatch_workgroups(SIZE.div_ceil(8), SIZE.div_ceil(8), 1);
        drop(pass);
        if let Some((query_set, resolved)) = &self.timestamps {
            encoder.resolve_query_set(query_set, 0..2, resolved, 0);
        }
        let start = Instant::now();
        self.gpu.queue().submit([encoder.finish()]);
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        let waited = start.elapsed();
        let Some((_, resolved)) = &self.timestamps else { return Ok(waited) };
        let ticks: Vec<u64> = self.read(resolved)?;
        let nanoseconds = ticks[1].saturating_sub(ticks[0]) as f64 * f64::from(self.gpu.queue().get_timestamp_period());
        Ok(Duration::from_nanos(nanoseconds as u64))
    }

    fn read<T: Pod>(&self, buffer: &wgpu::Buffer) -> Result<Vec<T>, Box<dyn Error>> {
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read-back"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, None);
        self.gpu.queue().submit([encoder.finish()]);
        staging.map_async(wgpu::MapMode::Read, .., |_| {}); // an error shows in the next call but one
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        let range = staging.get_mapped_range(..)?;
        Ok(bytemuck::pod_collect_to_vec(&range[..]))
    }
}

enum Resource {
    Buffer(wgpu::Buffer),
    Texture(wgpu::TextureView),
}

/// How many pixels differ from the library's left view, and how many see another primitive at the same depth.
fn compare(hits: &[Texel], reference: &View) -> (usize, usize) {
    let expected = reference.depth.iter().zip(&reference.primitive);
    let differs = hits.iter().zip(expected).map(|(hit, (depth, &primitive))| {
        let same_depth = f32::from_bits(hit[DEPTH]) == depth.min(FAR);
        (!same_depth, same_depth && hit[PRIMITIVE] != primitive)
    });
    differs.fold((0, 0), |(differ, ties), (other, tie)| (differ + usize::from(other), ties + usize::from(tie)))
}
