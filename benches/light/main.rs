//! Measures light by paths: error of the right view against cost, by region. `cargo bench --bench light` prints a
//! table.
//!
//! Naive and bracket by both rules of `Penumbra` take turns in one run. Errors are distances from a converged picture
//! of naive, in linear light, over several seeds. A surface of a region is matte, glossy or clear; `edges` are matte
//! pixels beside which the converged light changes by more than 5%. `between eyes` is the difference between both eyes'
//! errors at corresponding matte pixels, relative to naive's error at matte pixels. `--samples`, `--seeds`,
//! `--converged` and `--size` set the effort. Times cover the passes alone, so they do not include denoising. Names
//! select scenes: room, built-in ones, or folders of OBJ files. The chart is written to target/bench/light.

mod chart;
#[path = "../common/mod.rs"]
mod common;
mod room;
mod table;

use std::{error::Error, fs, process::ExitCode};

use clap::Parser;
use stereotrace::{
    Gpu, Lighting, Method, Options, Penumbra, Renderer, Scene, Sky, SkyMap, StereoCamera, UploadedScene,
    blocking::Wait, output::Batch,
};

use crate::{
    chart::Line,
    common::{
        options::size,
        provenance::Provenance,
        rounds::{Spread, order},
        scenes::{self, BenchScene},
    },
    table::{Corresponding, Errors, Regions},
};

/// Parallax at infinity in pixels, for a picture 400 pixels wide.
const E_PX: f32 = 10.0;
/// Number of surfaces that scatter a path's light after the first.
const BOUNCES: u32 = 4;
/// Width of the sky map in pixels.
const SKY_WIDTH: u32 = 256;

/// Measures light by paths: error of the right view against cost, by region.
#[derive(Parser, Debug)]
#[command(name = "cargo bench --bench light --")]
struct Arguments {
    /// Smoke run with meaningless figures
    #[arg(long)]
    smoke: bool,
    /// Picture size in pixels [default: 200x200]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Paths per pixel [default: 4,16,64]
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    samples: Vec<u32>,
    /// Number of pictures whose errors are measured [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    seeds: Option<u32>,
    /// Paths per pixel of the converged picture [default: 2048]
    #[arg(long, value_name = "N")]
    converged: Option<u32>,
    /// Number of timed rounds, after one warm-up round [default: 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,
    /// Scenes [default: room, cornell, sponza, dragon]
    scenes: Vec<String>,
    /// Passed by cargo when it benchmarks; without it this is a smoke run
    #[arg(long, hide = true)]
    bench: bool,
}

/// Settings of the measurement, the same for every scene.
struct Plan {
    size: [u32; 2],
    samples: Vec<u32>,
    seeds: u32,
    converged: u32,
    rounds: usize,
}

impl Arguments {
    fn plan(&self) -> Plan {
        let quick = self.quick();
        let usual = if quick { vec![2] } else { vec![4, 16, 64] };
        Plan {
            size: self.size.unwrap_or(if quick { [32; 2] } else { [200; 2] }),
            samples: if self.samples.is_empty() { usual } else { self.samples.clone() },
            seeds: self.seeds.unwrap_or(if quick { 2 } else { 8 }),
            converged: self.converged.unwrap_or(if quick { 8 } else { 2048 }),
            rounds: self.rounds.map_or(if quick { 1 } else { 3 }, |rounds| rounds as usize),
        }
    }

    fn scenes(&self) -> Vec<&str> {
        match self.scenes.as_slice() {
            [] if self.quick() => vec!["room"],
            [] => vec!["room", "cornell", "sponza", "dragon"],
            named => named.iter().map(String::as_str).collect(),
        }
    }

    fn quick(&self) -> bool {
        self.smoke || !self.bench
    }
}

fn main() -> ExitCode {
    common::exit::status(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let plan = arguments.plan();
    let gpu = Gpu::new().wait()?;
    let provenance = Provenance::of(&gpu);
    println!("{provenance}\n");
    println!(
        "{}x{}, {BOUNCES} bounces, {} rounds, {} seeds, errors against {} paths a pixel\n",
        plan.size[0], plan.size[1], plan.rounds, plan.seeds, plan.converged
    );
    println!("{}", table::HEAD);
    let mut renderer = Renderer::new(gpu);
    let mut lines = Vec::new();
    for name in arguments.scenes() {
        match load(name, &plan)? {
            Some(scene) => lines.extend(measure(&mut renderer, &scene, &plan)?),
            None => println!("{}\n", scenes::skipped(name)),
        }
    }
    if lines.is_empty() {
        return Err("no scene was measured".into());
    }
    let names: Vec<&str> = methods(2).into_iter().map(|(name, _)| name).collect();
    let svg = chart::svg(&lines, &names, plan.size, &provenance)?;
    let name = if arguments.quick() { "bench-smoke" } else { "bench/light" };
    let folder = common::files::root().join("target").join(name);
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut batch = Batch::new();
    batch.add(folder.join("light.svg"), svg.as_bytes())?;
    let files = batch.commit()?;
    println!("\nwrote {}", files[0].display());
    Ok(())
}

/// Loads a scene. Scenes without emitting surfaces get the light of a sky with a sun, instead of their own lights.
fn load(name: &str, plan: &Plan) -> Result<Option<BenchScene>, Box<dyn Error>> {
    let e_px = E_PX * plan.size[0] as f32 / 400.0;
    if name == "room" {
        let (scene, camera) = room::room(plan.size, e_px)?;
        return Ok(Some(BenchScene { name: name.into(), scene, camera }));
    }
    let Some(mut found) = scenes::load(name, plan.size, e_px, Some(0))? else { return Ok(None) };
    found.scene.sky = match emits(&found.scene) {
        true => Sky::Constant(stereotrace::glam::Vec3::ZERO),
        false => Sky::Map(SkyMap::procedural(SKY_WIDTH)?),
    };
    Ok(Some(found))
}

fn emits(scene: &Scene) -> bool {
    scene.materials().iter().any(|material| material.emission.max_element() > 0.0)
}

/// Returns the compared methods, with the ground truth first. Single paths are not denoised.
fn methods(samples: u32) -> Vec<(&'static str, Options)> {
    let by = |method| Options::new(method).lighting(Lighting::Paths { bounces: BOUNCES, samples }).linear(true);
    let mut all = vec![
        ("naive", by(Method::Naive)),
        ("bracket, exact", by(Method::BRACKET).penumbra(Penumbra::Exact)),
        ("bracket, shared", by(Method::BRACKET)),
    ];
    all.extend((samples > 1).then(|| ("denoised", by(Method::BRACKET).denoise(true))));
    all
}

/// Prints the rows of a scene, and returns its lines of the chart.
fn measure(renderer: &mut Renderer, bench: &BenchScene, plan: &Plan) -> Result<Vec<Line>, Box<dyn Error>> {
    let BenchScene { name, scene, camera } = bench;
    let uploaded = renderer.upload(scene).wait()?;
    let limit = converged(renderer, &uploaded, camera, plan)?;
    let regions = Regions::of(scene, &limit);
    let places = Corresponding::of(&limit, &regions)?;
    let line = |(method, _)| Line { scene: name.clone(), method, points: Vec::new() };
    let mut lines: Vec<Line> = methods(2).into_iter().map(line).collect();
    for &samples in &plan.samples {
        let methods = methods(samples);
        let mut times = vec![Vec::new(); methods.len()];
        for round in 0..=plan.rounds {
            for index in order(round, methods.len()) {
                let statistics = renderer.pair(&uploaded, camera).options(&methods[index].1).trace().wait()?;
                let total = statistics.times.map_or(f64::NAN, |times| times.total().as_secs_f64());
                times[index].extend((round > 0).then_some(1e3 * total));
            }
        }
        let naive_ms = Spread::of(times[0].iter().copied()).median;
        let mut of_naive = None;
        for (index, (method, options)) in methods.iter().enumerate() {
            let mut errors = Errors::default();
            let mut rays = [0; 2];
            for seed in 0..plan.seeds {
                let options = options.clone().seed(seed + 1).count(true);
                let pair = renderer.pair(&uploaded, camera).options(&options).read().wait()?;
                errors.add(&pair.right, &limit.right, &regions);
                errors.add_between(&pair, &limit, &places);
                let work = [pair.statistics.left, pair.statistics.right];
                rays = work.map(|work| work.rays.secondary + work.rays.shadow);
            }
            let of_naive = of_naive.get_or_insert_with(|| errors.clone());
            let ms = Spread::of(times[index].iter().copied()).median;
            let cost = [ms, 2.0 * ms / naive_ms - 1.0, rays[1] as f64 / rays[0] as f64];
            println!("{}", table::row(scenes::title(name), samples, method, cost, &errors, of_naive));
            lines[index].points.push((ms, errors.whole()));
        }
    }
    Ok(lines)
}

/// Returns naive's picture with many paths.
fn converged(
    renderer: &mut Renderer,
    scene: &UploadedScene,
    camera: &StereoCamera,
    plan: &Plan,
) -> Result<stereotrace::StereoPair, stereotrace::Error> {
    let (_, options) = &methods(plan.converged)[0];
    renderer.pair(scene, camera).options(options).read().wait()
}
