//! Measures the cost of each feature when it is off, compiled in but unused, and on. A second table shows the cost and
//! benefit of each BVH build quality.
//!
//! `cargo bench --bench features` prints both tables. For the compile times of Mesa's software driver, set
//! `MESA_SHADER_CACHE_DISABLE=true`; otherwise it caches compiled kernels on disk. The variants of a feature take turns
//! in interleaved rounds.

#[path = "../common/mod.rs"]
mod common;
mod states;

use std::{error::Error, time::Instant};

use stereotrace::{BvhBuild, Gpu, Method, Options, Renderer, UploadedScene, blocking::Wait};

use crate::common::{
    options::is_quick,
    provenance::Provenance,
    rounds::{Spread, order},
    scenes::{self, BenchScene},
};
use crate::states::{Variant, states, terrain};

fn main() -> Result<(), Box<dyn Error>> {
    let quick = is_quick();
    let (size, rounds) = if quick { ([64, 64], 1) } else { ([600, 600], 7) };
    let gpu = Gpu::new().wait()?;
    let provenance = Provenance::of(&gpu);
    println!("{provenance}");
    features(&gpu, size, rounds)?;
    let names: &[&str] = if quick { &["hall"] } else { &["hall", "sponza_4x", "dragon", "buddha_1m2"] };
    let size = if quick { size } else { [1280, 720] };
    builds(&gpu, names, size, rounds)
}

fn features(gpu: &Gpu, size: [u32; 2], rounds: usize) -> Result<(), Box<dyn Error>> {
    let [width, height] = size;
    println!("\n{width}x{height}, a terrain of {} triangles, {rounds} rounds\n", terrain(0).primitive_count());
    println!("| feature | state | view ms | min..max | of off | scene MiB | bytes a pixel | compile ms |");
    println!("|---|---|---|---|---|---|---|---|");
    for (feature, variants) in &states(size) {
        let figures = measure(gpu, variants, rounds)?;
        let off = figures[0].time.median;
        for (Figures { first_ms, least_ms, time, scene_bytes, pixel_bytes }, variant) in figures.iter().zip(variants) {
            println!(
                "| {feature} | {} | {:.1} | {:.1}..{:.1} | {:.2} | {:.1} | {:.1} | {:.0} |",
                variant.name,
                time.median,
                time.min,
                time.max,
                time.median / off,
                *scene_bytes as f64 / f64::from(1 << 20),
                *pixel_bytes as f64 / f64::from(width * height),
                first_ms - least_ms,
            );
        }
    }
    Ok(())
}

/// Figures of a variant.
struct Figures {
    /// Host time of the first frame, which includes kernel compilation, and of the fastest later frame, in
    /// milliseconds.
    first_ms: f64,
    least_ms: f64,
    /// Time per view in milliseconds.
    time: Spread,
    scene_bytes: u64,
    /// Size of all intermediate buffers.
    pixel_bytes: u64,
}

fn measure(gpu: &Gpu, variants: &[Variant], rounds: usize) -> Result<Vec<Figures>, Box<dyn Error>> {
    let mut measured = Vec::new();
    for variant in variants {
        let mut renderer = Renderer::new(gpu.clone());
        let scene = renderer.upload(&variant.scene).wait()?;
        let first_ms = wall_ms(&mut renderer, &scene, variant)?;
        measured.push((renderer, scene, first_ms, f64::INFINITY, Vec::new(), 0));
    }
    for round in 0..rounds {
        for turn in order(round, variants.len()) {
            let (renderer, scene, _, least_ms, times, bytes) = &mut measured[turn];
            let start = Instant::now();
            let statistics =
                renderer.pair(scene, &variants[turn].camera).options(&variants[turn].options).trace().wait()?;
            let elapsed = start.elapsed().as_secs_f64() * 1e3;
            *least_ms = least_ms.min(elapsed);
            // Naive traces both eyes in the same way, so one view takes half of the pair's time.
            let passes = statistics.times.map(|times| times.total().as_secs_f64() * 1e3);
            times.push(0.5 * passes.unwrap_or(elapsed));
            *bytes = statistics.intermediate_bytes;
        }
    }
    let figures = measured.into_iter().map(|(_, scene, first_ms, least_ms, times, pixel_bytes)| {
        let info = scene.info();
        let scene_bytes = info.node_bytes + info.primitive_bytes;
        Figures { first_ms, least_ms, time: Spread::of(times), scene_bytes, pixel_bytes }
    });
    Ok(figures.collect())
}

/// Returns the host time of a frame without read-back, in milliseconds.
fn wall_ms(renderer: &mut Renderer, scene: &UploadedScene, variant: &Variant) -> Result<f64, stereotrace::Error> {
    let start = Instant::now();
    renderer.pair(scene, &variant.camera).options(&variant.options).trace().wait()?;
    Ok(start.elapsed().as_secs_f64() * 1e3)
}

fn builds(gpu: &Gpu, names: &[&str], [width, height]: [u32; 2], rounds: usize) -> Result<(), Box<dyn Error>> {
    println!(
        "\n{width}x{height}, naive pairs with 5 lights, {rounds} rounds; seconds for one picture and for a hundred\n"
    );
    println!("| scene | build | build ms | upload ms | MiB | pair ms | min..max | 1 picture s | 100 pictures s |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for name in names {
        let Some(BenchScene { scene, camera, .. }) = scenes::load(name, [width, height], 15.0, None)? else {
            println!("{}", scenes::skipped(name));
            continue;
        };
        let mut renderer = Renderer::new(gpu.clone());
        // The first build also warms up the host's threads and memory.
        renderer.upload(&scene).wait()?;
        let uploaded = BvhBuild::ALL.iter().map(|&build| renderer.upload_with(&scene, build).wait());
        let uploaded = uploaded.collect::<Result<Vec<_>, _>>()?;
        let mut times = vec![Vec::new(); uploaded.len()];
        for round in 0..=rounds {
            for turn in order(round, uploaded.len()) {
                let start = Instant::now();
                renderer.pair(&uploaded[turn], &camera).options(&Options::new(Method::Naive)).trace().wait()?;
                times[turn].extend((round > 0).then(|| start.elapsed().as_secs_f64() * 1e3));
            }
        }
        for ((build, uploaded), times) in BvhBuild::ALL.iter().zip(&uploaded).zip(times) {
            let (info, pair) = (uploaded.info(), Spread::of(times));
            let once = info.build.as_secs_f64() + info.upload.as_secs_f64();
            println!(
                "| {} | {build:?} | {:.0} | {:.0} | {:.1} | {:.1} | {:.1}..{:.1} | {:.2} | {:.1} |",
                scenes::title(name),
                info.build.as_secs_f64() * 1e3,
                info.upload.as_secs_f64() * 1e3,
                (info.node_bytes + info.primitive_bytes) as f64 / f64::from(1 << 20),
                pair.median,
                pair.min,
                pair.max,
                once + pair.median * 1e-3,
                once + pair.median * 0.1,
            );
        }
    }
    Ok(())
}
