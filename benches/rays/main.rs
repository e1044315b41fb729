//! Measures millions of rays per second, by scene and kind of ray: `cargo bench --bench rays`.
//!
//! The library's traversal on the adapter is compared with obvhs's traversal on all cores. They take turns in
//! interleaved rounds whose order rotates, and their hits are compared too. Times cover the traversal alone, without
//! the transfer of rays and hits. `--variants` includes every variant of the traversal. `--dump DIR` writes geometry
//! and rays for scripts/embree.py.

#[path = "../common/mod.rs"]
mod common;
mod dump;
mod lists;
mod obvhs_tracer;

use std::{error::Error, path::PathBuf, process::ExitCode, time::Instant};

use clap::Parser;
use stereotrace::{Gpu, Renderer, Traversal, UploadedScene, blocking::Wait};

use crate::{
    common::{
        provenance::Provenance,
        rounds::{Spread, order},
        scenes::{self, BenchScene},
    },
    lists::{Kind, Query},
    obvhs_tracer::ObvhsTracer,
};

/// Measures millions of rays per second, by scene and kind of ray.
#[derive(Parser, Debug)]
#[command(name = "cargo bench --bench rays --")]
struct Arguments {
    /// Smoke run with meaningless figures: 64x64, one round, the hall
    #[arg(long)]
    smoke: bool,
    /// Width and height of the picture in pixels [default: 1024]
    #[arg(long)]
    size: Option<u32>,
    /// Number of timed rounds, after one warm-up round [default: 7]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,
    /// Built-in scenes, or folders of OBJ files [default: hall, `sponza_4x`, dragon]
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<String>,
    /// Measure every variant of the traversal, not only the adapter's own
    #[arg(long)]
    variants: bool,
    /// Write each scene's geometry and rays into this folder, for scripts/embree.py
    #[arg(long, value_name = "DIR")]
    dump: Option<PathBuf>,
    /// Passed by cargo when it benchmarks; without it this is a smoke run
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> ExitCode {
    common::exit::status(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let quick = arguments.smoke || !arguments.bench;
    let size = arguments.size.unwrap_or(if quick { 64 } else { 1024 });
    let rounds = arguments.rounds.map_or(if quick { 1 } else { 7 }, |rounds| rounds as usize);
    let names = match arguments.scenes.as_slice() {
        [] if quick => vec!["hall".to_owned()],
        [] => ["hall", "sponza_4x", "dragon"].map(str::to_owned).to_vec(),
        named => named.to_vec(),
    };
    let gpu = Gpu::new().wait()?;
    let provenance = Provenance::of(&gpu);
    let own = Traversal::of(&gpu);
    let others = Traversal::ALL.iter().copied().filter(|traversal| arguments.variants && *traversal != own);
    let devices: Vec<Device> = std::iter::once(own).chain(others).map(|with| Device::new(&gpu, with)).collect();
    println!("{provenance}");
    println!(
        "{size}x{size}, {rounds} rounds after one to warm up, obvhs on {} threads\n",
        rayon::current_num_threads()
    );
    println!(
        "| scene | rays | millions | variant | Mrays/s | min..max | obvhs Mrays/s | min..max | ratio | same hits % |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let mut skipped = Vec::new();
    for name in &names {
        match scenes::load(name, [size, size], 15.0 * size as f32 / 600.0, None)? {
            Some(scene) => measure(&scene, &devices, rounds, arguments.dump.as_deref())?,
            None => skipped.push(scenes::skipped(name)),
        }
    }
    for line in &skipped {
        println!("\n{line}");
    }
    if skipped.len() == names.len() { Err("no scene was measured".into()) } else { Ok(()) }
}

/// A variant of the traversal, with its renderer.
struct Device {
    traversal: Traversal,
    renderer: Renderer,
}

impl Device {
    fn new(gpu: &Gpu, traversal: Traversal) -> Self {
        Self { traversal, renderer: Renderer::with_traversal(gpu.clone(), traversal) }
    }
}

/// Prints one line for each kind of ray and each variant.
fn measure(
    bench: &BenchScene,
    devices: &[Device],
    rounds: usize,
    dump: Option<&std::path::Path>,
) -> Result<(), Box<dyn Error>> {
    let BenchScene { name, scene, camera } = bench;
    let obvhs = ObvhsTracer::new(scene);
    let kinds = lists::kinds(scene, &camera.pose()?, &|rays| obvhs.closest_hits(rays));
    if let Some(folder) = dump {
        dump::write(&folder.join(name), scene, &kinds)?;
    }
    let uploaded = devices.iter().map(|device| device.renderer.upload(scene).wait()).collect::<Result<Vec<_>, _>>()?;
    for kind in kinds.iter().filter(|kind| kind.rays() > 0) {
        // Obvhs traces shadow rays in both directions, and the faster result counts.
        let yardsticks = if kind.name == "shadow" { 2 } else { 1 };
        let mut times: Vec<Vec<f64>> = vec![Vec::new(); devices.len() + yardsticks];
        for round in 0..=rounds {
            for turn in order(round, times.len()) {
                let seconds = match turn.checked_sub(devices.len()) {
                    None => on_device(&devices[turn].renderer, &uploaded[turn], kind)?.0,
                    Some(yardstick) => on_host(&obvhs, kind, yardstick == 1).0,
                };
                times[turn].extend((round > 0).then_some(seconds));
            }
        }
        let millions = kind.rays() as f64 * 1e-6;
        let rates: Vec<Spread> =
            times.iter().map(|times| Spread::of(times.iter().map(|seconds| millions / seconds))).collect();
        let host = rates[devices.len()..].iter().max_by(|a, b| a.median.total_cmp(&b.median)).copied();
        let host = host.ok_or("obvhs was not timed")?;
        let expected = on_host(&obvhs, kind, false).1;
        for (index, device) in devices.iter().enumerate() {
            let rate = rates[index];
            let found = on_device(&device.renderer, &uploaded[index], kind)?.1;
            println!(
                "| {} | {} | {millions:.2} | {} | {:.2} | {:.2}..{:.2} | {:.2} | {:.2}..{:.2} | {:.2} | {:.3} |",
                scenes::title(name),
                kind.name,
                device.traversal,
                rate.median,
                rate.min,
                rate.max,
                host.median,
                host.min,
                host.max,
                rate.median / host.median,
                same(&found, &expected),
            );
        }
    }
    Ok(())
}

/// Hits as t of each ray. Any-hit queries give 1 for a hit and infinity for a miss.
type Found = Vec<f32>;

fn as_t(occluded: Vec<bool>) -> Found {
    occluded.into_iter().map(|occluded| if occluded { 1.0 } else { f32::INFINITY }).collect()
}

/// Traces the rays on the adapter. Returns the time in seconds and the hits. Without timestamps the host's clock is
/// used, and the time includes the transfer of rays and hits.
fn on_device(renderer: &Renderer, scene: &UploadedScene, kind: &Kind) -> Result<(f64, Found), stereotrace::Error> {
    let (mut seconds, mut found) = (0.0, Vec::new());
    for rays in &kind.lists {
        let start = Instant::now();
        let (time, hits) = match kind.query {
            Query::Closest => {
                let cast = renderer.closest_hits(scene, rays).wait()?;
                (cast.time, cast.hits.iter().map(|hit| hit.t).collect())
            }
            Query::Any => {
                let cast = renderer.any_hits(scene, rays).wait()?;
                (cast.time, as_t(cast.hits))
            }
        };
        seconds += time.unwrap_or_else(|| start.elapsed()).as_secs_f64();
        found.extend(hits);
    }
    Ok((seconds, found))
}

fn on_host(obvhs: &ObvhsTracer, kind: &Kind, reversed: bool) -> (f64, Found) {
    let start = Instant::now();
    let found: Vec<Found> = kind
        .lists
        .iter()
        .map(|rays| match kind.query {
            Query::Closest => obvhs.closest_hits(rays),
            Query::Any if reversed => as_t(obvhs.any_hits_reversed(rays)),
            Query::Any => as_t(obvhs.any_hits(rays)),
        })
        .collect();
    (start.elapsed().as_secs_f64(), found.concat())
}

/// Returns the percentage of rays whose t agrees to one part in a thousand.
fn same(found: &[f32], expected: &[f32]) -> f64 {
    let close = |(a, b): &(&f32, &f32)| a == b || (*a - *b).abs() < 1e-3 * *a;
    100.0 * found.iter().zip(expected).filter(close).count() as f64 / found.len() as f64
}
