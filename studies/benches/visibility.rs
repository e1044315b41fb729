//! Measures the cost of finding first hits, by rays and by a T-buffer: `cargo bench -p stereotrace-studies --bench
//! visibility` prints one table per scene.
//!
//! Both ways take turns in one run, at several sizes of one picture. One part of a T-buffer's cost is proportional to
//! primitives, and another part to pixels. By default scenes have no lights, so times mostly cover first hits. Times
//! are medians of the rounds, of the left view's passes. Counts are taken from one frame each. They are the tree nodes
//! that rays visit or the primitives that are projected, and the primitive tests. `--rounds 0` prints counts alone,
//! which are the same on every machine.

#[path = "../../benches/common/mod.rs"]
mod common;

use std::{collections::BTreeMap, error::Error};

use clap::Parser;
use stereotrace::{GBuffer, Gpu, Method, Options, Renderer, Rig, UploadedScene, Views, Visibility, blocking::Wait};

use crate::common::{
    options::size,
    provenance::Provenance,
    rounds::{Spread, order},
    scenes::{self, BenchScene},
};

/// Compares rays with a T-buffer.
#[derive(Parser, Debug)]
#[command(name = "cargo bench -p stereotrace-studies --bench visibility --")]
struct Arguments {
    /// Built-in scenes, or folders of OBJ files [default: hall, spheres, near, `sponza_4x`, dragon and `buddha_1m2`]
    scenes: Vec<String>,
    /// Picture sizes in pixels [default: 150x150, 300x300, 600x600 and 1200x1200]
    #[arg(long, value_name = "WxH,WxH", value_parser = size, value_delimiter = ',')]
    sizes: Vec<[u32; 2]>,
    /// Number of samples per pixel
    #[arg(long, value_name = "N", default_value_t = 1)]
    samples: u32,
    /// Number of point lights
    #[arg(long, value_name = "N", default_value_t = 0)]
    lights: usize,
    /// Number of timed rounds; 0 for counts alone [default: 7]
    #[arg(long, value_name = "N")]
    rounds: Option<usize>,
    /// Passed by cargo when it benchmarks; without it this is a smoke run
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let quick = !arguments.bench;
    let usual = if quick { vec!["hall"] } else { vec!["hall", "spheres", "near", "sponza_4x", "dragon", "buddha_1m2"] };
    let usual = Vec::from_iter(usual.into_iter().map(String::from));
    let names = if arguments.scenes.is_empty() { &usual } else { &arguments.scenes };
    let rounds = arguments.rounds.unwrap_or(if quick { 1 } else { 7 });
    let sizes = match arguments.sizes.as_slice() {
        [] if quick => vec![[48; 2]],
        [] => [150, 300, 600, 1200].map(|side| [side; 2]).to_vec(),
        sizes => sizes.to_vec(),
    };
    let gpu = Gpu::new().wait()?;
    println!("{}\n", Provenance::of(&gpu));
    println!("{} lights, {} samples a pixel, {rounds} rounds", arguments.lights, arguments.samples);
    let mut renderer = Renderer::new(gpu);
    for name in names {
        match scenes::load(name, sizes[0], 0.0, Some(arguments.lights))? {
            Some(scene) => measure(&mut renderer, &scene, &sizes, arguments.samples, rounds)?,
            None => println!("\n{}", scenes::skipped(name)),
        }
    }
    Ok(())
}

/// Prints a scene's table.
fn measure(
    renderer: &mut Renderer,
    bench: &BenchScene,
    sizes: &[[u32; 2]],
    samples: u32,
    rounds: usize,
) -> Result<(), Box<dyn Error>> {
    let uploaded = renderer.upload(&bench.scene).wait()?;
    println!("\n{}, {} primitives\n", scenes::title(&bench.name), bench.scene.primitive_count());
    println!(
        "| size | by | ms | min..max | of rays | nodes a pixel | tests a pixel | of rays, by counters | rays | passes, \
        ms |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for &[width, height] in sizes {
        let rig = Rig::at(bench.camera.size(width, height), vec![0.0]);
        let mut turns = [Turn::default(), Turn::default()];
        for round in 0..=rounds {
            for index in order(round, Visibility::ALL.len()) {
                let views = render(renderer, &uploaded, &rig, samples, (Visibility::ALL[index], false))?;
                // Drivers compile kernels in the first round.
                if round > 0 {
                    turns[index].add(&views);
                }
            }
        }
        let counted = |way| render(renderer, &uploaded, &rig, samples, (way, true));
        let works = Visibility::ALL.iter().copied().map(counted).collect::<Result<Vec<_>, _>>()?;
        for (index, way) in Visibility::ALL.iter().enumerate() {
            let work = works[index].views[0].work;
            let pixels = f64::from(width) * f64::from(height);
            let by_counters = work.cost() as f64 / works[0].views[0].work.cost() as f64;
            println!(
                "| {width}x{height} | {way} | {} | {:.1} | {:.1} | {by_counters:.2} | {} | {} |",
                turns[index].shown(&turns[0]),
                work.nodes as f64 / pixels,
                work.primitive_tests as f64 / pixels,
                work.rays.primary,
                turns[index].passes(),
            );
        }
    }
    Ok(())
}

fn render(
    renderer: &mut Renderer,
    scene: &UploadedScene,
    rig: &Rig,
    samples: u32,
    (way, count): (Visibility, bool),
) -> Result<Views, stereotrace::Error> {
    let options = Options::new(Method::Naive).visibility(way).samples(samples).count(count).g_buffer(GBuffer::None);
    renderer.views(scene, rig).options(&options).read().wait()
}

/// Times of one way, with one entry per round.
#[derive(Default)]
struct Turn {
    all: Vec<f64>,
    passes: BTreeMap<&'static str, Vec<f64>>,
}

impl Turn {
    fn add(&mut self, views: &Views) {
        let mut sums = BTreeMap::<&'static str, f64>::new();
        for &(pass, time) in views.times.iter().flat_map(|times| &times.passes) {
            *sums.entry(pass).or_default() += 1e3 * time.as_secs_f64();
        }
        self.all.push(sums.values().sum());
        sums.into_iter().for_each(|(pass, sum)| self.passes.entry(pass).or_default().push(sum));
    }

    /// Formats the time of all passes, and its ratio to another way's.
    fn shown(&self, other: &Self) -> String {
        if self.all.is_empty() {
            return "- | - | -".into();
        }
        let [own, other] = [self, other].map(|turn| Spread::of(turn.all.iter().copied()));
        format!("{:.1} | {:.1}..{:.1} | {:.2}", own.median, own.min, own.max, own.median / other.median)
    }

    fn passes(&self) -> String {
        let median = |times: &Vec<f64>| Spread::of(times.iter().copied()).median;
        let passes = self.passes.iter().filter(|(pass, _)| **pass != "pack");
        passes.map(|(pass, times)| format!("{pass} {:.1}", median(times))).collect::<Vec<_>>().join(", ")
    }
}
