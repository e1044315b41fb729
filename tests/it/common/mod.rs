//! Shared parts of the integration tests: the device, its name in the output, scenes and comparisons.
pub(crate) mod floor;
pub(crate) mod folder;
pub(crate) mod gltf;
pub(crate) mod nearest;
pub(crate) use stereotrace::testing::random;
mod random_scene;
pub(crate) mod sampling;
pub(crate) mod shown_sky;
pub(crate) mod warnings;

use std::{
    fs,
    io::Write,
    ops::{Deref, DerefMut},
    panic::Location,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

use stereotrace::{
    Gpu, Mesh, Method, Options, Renderer, Scene, StereoCamera, StereoPair, Traversal, blocking::Wait, glam::Vec3, wgpu,
};

pub(crate) use self::random_scene::{RandomScene, random_ellipsoid, random_foliage, random_stage};

/// Returns the device of this test, on `software` unless `STEREOTRACE_ADAPTER` says otherwise. A missing adapter is a
/// failure with a remedy, not a skip. Each test that runs at the same time has its own device, since a software driver
/// compiles all kernels of a device in one thread.
pub(crate) fn gpu() -> Gpu {
    static DEVICES: Mutex<Vec<Gpu>> = Mutex::new(Vec::new());
    let mut devices = lock(&DEVICES);
    SEAT.with(|seat| {
        while devices.len() <= seat.0 {
            let gpu = own_gpu();
            // The test harness would hide output of eprintln.
            let _ = writeln!(std::io::stderr(), "adapter: {}, driver {}", gpu.adapter_name(), gpu.driver());
            devices.push(gpu);
        }
        devices[seat.0].clone()
    })
}

thread_local! {
    /// The seat of this thread, which is the number of its device. A thread runs one test.
    static SEAT: Seat = Seat::take();
}

/// Whether each device number is in use by a thread.
static TAKEN: Mutex<Vec<bool>> = Mutex::new(Vec::new());

/// The number of a device. It becomes free when its thread ends.
struct Seat(usize);

impl Seat {
    fn take() -> Self {
        let mut taken = lock(&TAKEN);
        if let Some(place) = taken.iter().position(|taken| !taken) {
            taken[place] = true;
            return Self(place);
        }
        taken.push(true);
        Self(taken.len() - 1)
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        lock(&TAKEN)[self.0] = false;
    }
}

/// Locks a mutex. Its value stays consistent if a test fails, so poisoning is ignored.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the cases of a test: all in the long form, else the first of every `every` cases.
pub(crate) fn cases<T>(all: impl IntoIterator<Item = T>, every: usize) -> Vec<T> {
    all.into_iter().step_by(if is_long() { 1 } else { every }).collect()
}

/// Returns the files with these extensions in a folder and below. Hidden folders and build outputs are left out.
pub(crate) fn files_below(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = entry.file_name().unwrap_or_default().to_string_lossy();
        if entry.is_dir() && !["target", "node_modules", "dist"].contains(&&*name) && !name.starts_with('.') {
            found.extend(files_below(&entry, endings));
        } else if entry.extension().is_some_and(|ending| endings.contains(&&*ending.to_string_lossy())) {
            found.push(entry);
        }
    }
    found
}

/// Says that a test, or a part of one, is not run. `scripts/test.sh` counts these lines.
pub(crate) fn skipped(what: &str) {
    // The test harness would hide output of println.
    let _ = writeln!(std::io::stderr(), "skipped: {what}");
}

/// Returns whether the device gives the bits of the twins. Says otherwise that a comparison is skipped.
pub(crate) fn compares_bits(renderer: &Renderer) -> bool {
    let exact = is_exact(renderer);
    if !exact {
        skipped("bit-exact comparison on an adapter that may contract f32");
    }
    exact
}

/// Returns the folder of unpacked scenes if it has this file. Says otherwise that the scene is skipped.
pub(crate) fn scenes_with(file: &str) -> Option<PathBuf> {
    let fallback = || concat!(env!("CARGO_MANIFEST_DIR"), "/target/scenes").into();
    let folder: PathBuf = std::env::var_os("STEREOTRACE_SCENES").map_or_else(fallback, PathBuf::from);
    if folder.join(file).is_file() {
        return Some(folder);
    }
    skipped(&format!("scene not found: {file} in {}", folder.display()));
    None
}

/// Opens a device for one test alone, on the same adapter.
pub(crate) fn own_gpu() -> Gpu {
    let wanted = std::env::var("STEREOTRACE_ADAPTER").unwrap_or_else(|_| "software".into());
    Gpu::open(wanted).wait().unwrap_or_else(|error| panic!("{error}; or run `sh scripts/test.sh`, which installs one"))
}

/// Opens a device of the tests' adapter with the given limits.
pub(crate) fn device(limits: wgpu::Limits) -> (wgpu::Device, wgpu::Queue) {
    let own = gpu();
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let same = |adapter: &wgpu::Adapter| {
        let info = adapter.get_info();
        (&info.name, info.backend) == (&own.adapter_info().name, own.adapter_info().backend)
    };
    let adapter = adapters.into_iter().find(same).expect("the adapter that was just opened");
    let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
    pollster::block_on(adapter.request_device(&descriptor)).unwrap()
}

/// Opens a separate [`Gpu`] on the tests' adapter, with these limits.
pub(crate) fn gpu_with_limits(limits: wgpu::Limits) -> Gpu {
    let (device, queue) = device(limits);
    Gpu::from_device(device, queue).unwrap()
}

/// Lends a renderer on this test's device. Tests of a file share renderers, so that pipelines are built once. Renderers
/// of other files are dropped, since thousands of pipelines take gigabytes.
#[track_caller]
pub(crate) fn renderer() -> Lent {
    renderer_by(Traversal::of(&gpu()))
}

/// Does the same as [`renderer`], with the given traversal.
#[track_caller]
pub(crate) fn renderer_by(traversal: Traversal) -> Lent {
    let key = (Location::caller().file(), traversal, SEAT.with(|seat| seat.0));
    let found = {
        let mut free = lock(&FREE);
        free.retain(|((file, ..), _)| *file == key.0);
        let place = free.iter().position(|(other, _)| *other == key);
        place.map(|place| free.swap_remove(place).1)
    };
    Lent { key, renderer: Some(found.unwrap_or_else(|| Renderer::with_traversal(gpu(), traversal))) }
}

/// The file that a renderer is lent to, its traversal, and the number of its device.
type Key = (&'static str, Traversal, usize);

static FREE: Mutex<Vec<(Key, Renderer)>> = Mutex::new(Vec::new());

/// A renderer that is given back when it is dropped.
pub(crate) struct Lent {
    key: Key,
    renderer: Option<Renderer>,
}

impl Deref for Lent {
    type Target = Renderer;

    fn deref(&self) -> &Renderer {
        self.renderer.as_ref().expect("lent until it is dropped")
    }
}

impl DerefMut for Lent {
    fn deref_mut(&mut self) -> &mut Renderer {
        self.renderer.as_mut().expect("lent until it is dropped")
    }
}

impl Drop for Lent {
    /// Gives the renderer back. The renderer of a failed test is dropped instead.
    fn drop(&mut self) {
        if let (Some(renderer), false) = (self.renderer.take(), std::thread::panicking()) {
            lock(&FREE).push((self.key, renderer));
        }
    }
}

/// Returns whether tests run in their long form: `STEREOTRACE_TESTS=long`.
pub(crate) fn is_long() -> bool {
    std::env::var_os("STEREOTRACE_TESTS").is_some_and(|form| form == "long")
}

/// Returns two traversals that differ in all three choices. In the long form, returns all eight. A driver compiles all
/// kernels of a test for each of them, which takes most of its time.
pub(crate) fn traversals() -> Vec<Traversal> {
    let opposite = [0, 5].map(|place| Traversal::ALL[place]);
    if is_long() { Traversal::ALL.into() } else { opposite.into() }
}

/// Returns whether results must agree bit for bit. Software Vulkan neither contracts nor reorders operations in f32.
pub(crate) fn is_exact(renderer: &Renderer) -> bool {
    let info = renderer.gpu().adapter_info();
    info.device_type == wgpu::DeviceType::Cpu && info.backend == wgpu::Backend::Vulkan
}

/// Returns whether frames have small bands, of 64 rows at these tests' widths. GPUs' bands hold these pictures whole.
pub(crate) fn has_small_bands(gpu: &Gpu) -> bool {
    gpu.adapter_info().device_type == wgpu::DeviceType::Cpu
}

#[track_caller]
pub(crate) fn render(scene: &Scene, camera: &StereoCamera, method: Method) -> StereoPair {
    let mut renderer = renderer();
    let uploaded = renderer.upload(scene).wait().unwrap();
    renderer.pair(&uploaded, camera).options(&Options::new(method).linear(true)).read().wait().unwrap()
}

/// Returns a closed sphere of triangles, with `rings` rings from pole to pole and twice as many segments.
pub(crate) fn ball(center: Vec3, radius: f32, rings: u32) -> Mesh {
    let segments = 2 * rings;
    let point = |ring: u32, segment: u32| {
        let polar = std::f32::consts::PI * ring as f32 / rings as f32;
        let around = std::f32::consts::TAU * (segment % segments) as f32 / segments as f32;
        center + radius * Vec3::new(polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin())
    };
    let mut positions = vec![center + radius * Vec3::Y, center - radius * Vec3::Y];
    for ring in 1..rings {
        positions.extend((0..segments).map(|segment| point(ring, segment)));
    }
    let at = |ring: u32, segment: u32| match ring {
        0 => 0,
        ring if ring == rings => 1,
        ring => 2 + (ring - 1) * segments + segment % segments,
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for segment in 0..segments {
            let corners = [at(ring, segment), at(ring + 1, segment), at(ring + 1, segment + 1), at(ring, segment + 1)];
            if ring + 1 < rings {
                triangles.push([corners[0], corners[1], corners[2]]);
            }
            if ring > 0 {
                triangles.push([corners[0], corners[2], corners[3]]);
            }
        }
    }
    Mesh::new(positions, triangles)
}
