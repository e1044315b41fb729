//! What the integration tests share: the device, its name in the output, scenes and comparisons.
#![allow(dead_code, unreachable_pub, unused_imports, reason = "each test file uses its own part of this")]

pub mod floor;
pub mod folder;
pub mod nearest;
#[path = "../../src/random.rs"]
pub mod random;
mod random_scene;
pub mod sampling;
pub mod shown_sky;
pub mod warnings;

use std::{
    io::Write,
    sync::{Mutex, MutexGuard, OnceLock, PoisonError},
};

use stereotrace::{
    Gpu, MaterialId, Mesh, Method, Options, Renderer, Scene, StereoCamera, StereoPair, glam::Vec3, wgpu,
};

pub use self::random_scene::{RandomScene, random_ellipsoid, random_foliage, random_mask, random_stage};

/// Opens the adapter that tests run on: `software` unless `STEREOTRACE_ADAPTER` says otherwise. A missing one is a
/// failure with a remedy, not a skip.
pub fn gpu() -> Gpu {
    let wanted = std::env::var("STEREOTRACE_ADAPTER").unwrap_or_else(|_| "software".into());
    Gpu::open(wanted).unwrap_or_else(|error| panic!("{error}; or run `sh scripts/test.sh`, which installs one"))
}

/// A device of the tests' adapter with limits of the caller's choice.
pub fn device(limits: wgpu::Limits) -> (wgpu::Device, wgpu::Queue) {
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

/// A [`Gpu`] of the caller's own on the tests' adapter, with these limits.
pub fn gpu_with_limits(limits: wgpu::Limits) -> Gpu {
    let (device, queue) = device(limits);
    Gpu::from_device(device, queue).unwrap()
}

/// One renderer for all tests of a file: its pipelines are compiled once.
pub fn renderer() -> MutexGuard<'static, Renderer> {
    static RENDERER: OnceLock<Mutex<Renderer>> = OnceLock::new();
    let renderer = RENDERER.get_or_init(|| {
        let gpu = gpu();
        // Not through eprintln: the test harness would keep it to itself.
        let _ = writeln!(std::io::stderr(), "adapter: {}, driver {}", gpu.adapter_name(), gpu.driver());
        Mutex::new(Renderer::new(gpu))
    });
    renderer.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Software Vulkan neither contracts nor reorders f32: there results must agree bit for bit.
pub fn is_exact(renderer: &Renderer) -> bool {
    let info = renderer.gpu().adapter_info();
    info.device_type == wgpu::DeviceType::Cpu && info.backend == wgpu::Backend::Vulkan
}

pub fn render(scene: &Scene, camera: &StereoCamera, method: Method) -> StereoPair {
    let mut renderer = renderer();
    let uploaded = renderer.upload(scene).unwrap();
    renderer.render(&uploaded, camera, &Options::new(method).linear(true)).unwrap()
}

/// A closed sphere of triangles: `rings` from pole to pole, twice as many segments.
pub fn ball(center: Vec3, radius: f32, rings: u32) -> Mesh {
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
