//! Measures the cost of several samples per pixel, and the second eye's savings: `cargo bench -p stereotrace-studies
//! --bench samples` prints tables.
//!
//! Naive and bracket take turns at every number of samples in one run. Depths and ids are off, so all rays are samples.
//! Times are medians of the rounds. They cover the passes, without the filter on the host. Counts and pictures are
//! taken from one frame each. The error is the right view's root mean square distance from naive's with 64 samples, in
//! linear light.

#[path = "../../benches/common/mod.rs"]
mod common;

use std::error::Error;

use clap::Parser;
use stereotrace::{Filter, GBuffer, Gpu, Method, Options, Renderer, Statistics, StereoPair, blocking::Wait};

use crate::common::{
    options::size,
    provenance::Provenance,
    rounds::{Spread, order},
    scenes::{self, BenchScene},
};

/// Compares naive and bracket at several samples per pixel.
#[derive(Parser, Debug)]
#[command(name = "cargo bench -p stereotrace-studies --bench samples --")]
struct Arguments {
    /// Built-in scenes, or folders of OBJ files [default: hall, spheres, `sponza_4x` and dragon]
    scenes: Vec<String>,
    /// Picture size in pixels; the interaxial is proportional to its width [default: 400x400]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Numbers of samples per pixel
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_value = "1,4,9,16")]
    samples: Vec<u32>,
    /// Number of point lights
    #[arg(long, value_name = "N", default_value_t = 5)]
    lights: usize,
    /// Filter of the samples: box, tent or gauss
    #[arg(long, value_name = "KIND", default_value_t)]
    filter: Filter,
    /// Place samples at the centres of their cells, without jitter
    #[arg(long)]
    grid: bool,
    /// Number of timed rounds; 0 for counts alone [default: 7]
    #[arg(long, value_name = "N")]
    rounds: Option<usize>,
    /// Smoke run with meaningless figures: 48x48, the hall, one round
    #[arg(long)]
    smoke: bool,
    /// Passed by cargo when it benchmarks; without it this is a smoke run
    #[arg(long, hide = true)]
    bench: bool,
}

/// Parallax at infinity in pixels, for a picture 600 pixels wide.
const E_PX: f32 = 15.0;
/// Compared methods, with the ground truth first.
const METHODS: [Method; 2] = [Method::Naive, Method::BRACKET];
/// Number of samples per pixel in the reference picture of the errors.
const REFERENCE: u32 = 64;

/// Groups of passes, by prefixes of their names.
const GROUPS: [(&str, &[&str]); 7] = [
    ("left", &["trace_left"]),
    ("right traced", &["trace_right"]),
    ("bound", &["bound_tiles"]),
    ("search", &["search_"]),
    ("resolve", &["resolve_tiles", "trace_bounded"]),
    ("shade", &["shade_sky", "shade_tiles"]),
    ("shadow rays", &["shade_listed"]),
];

/// Times of one method at one number of samples.
#[derive(Default)]
struct Turn {
    /// Total time of the passes in each round, in milliseconds.
    times: Vec<f64>,
    groups: [Vec<f64>; GROUPS.len()],
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let quick = arguments.smoke || !arguments.bench;
    let size = arguments.size.unwrap_or(if quick { [48; 2] } else { [400; 2] });
    let usual = if quick { vec!["hall"] } else { vec!["hall", "spheres", "sponza_4x", "dragon"] };
    let usual = Vec::from_iter(usual.into_iter().map(String::from));
    let names = if arguments.scenes.is_empty() { &usual } else { &arguments.scenes };
    let rounds = arguments.rounds.unwrap_or(if quick { 1 } else { 7 });
    let gpu = Gpu::new().wait()?;
    println!("{}\n", Provenance::of(&gpu));
    let jitter = if arguments.grid { ", without jitter" } else { "" };
    println!(
        "{}x{}, {} lights, {} filter{jitter}, {rounds} rounds\n",
        size[0], size[1], arguments.lights, arguments.filter
    );
    let mut renderer = Renderer::new(gpu);
    for name in names {
        match scenes::load(name, size, E_PX * size[0] as f32 / 600.0, Some(arguments.lights))? {
            Some(scene) => measure(&mut renderer, &scene, &arguments, rounds)?,
            None => println!("{}\n", scenes::skipped(name)),
        }
    }
    Ok(())
}

/// Prints a scene's tables.
fn measure(
    renderer: &mut Renderer,
    bench: &BenchScene,
    arguments: &Arguments,
    rounds: usize,
) -> Result<(), Box<dyn Error>> {
    let BenchScene { name, scene, camera } = bench;
    let uploaded = renderer.upload(scene).wait()?;
    let options = |method, samples| {
        let options = Options::new(method).samples(samples).filter(arguments.filter).g_buffer(GBuffer::None);
        options.jitter(!arguments.grid)
    };
    let turns = Vec::from_iter(arguments.samples.iter().flat_map(|&samples| METHODS.map(|method| (method, samples))));
    let mut taken = Vec::from_iter(turns.iter().map(|_| Turn::default()));
    // The first round compiles kernels.
    for round in 0..if rounds > 0 { rounds + 1 } else { 0 } {
        for index in order(round, turns.len()) {
            let (method, samples) = turns[index];
            let statistics = renderer.pair(&uploaded, camera).options(&options(method, samples)).trace().wait()?;
            if round > 0 {
                taken[index].add(&statistics);
            }
        }
    }
    let mut render = |method, samples, count| -> Result<StereoPair, stereotrace::Error> {
        renderer.pair(&uploaded, camera).options(&options(method, samples).linear(true).count(count)).read().wait()
    };
    let reference = render(Method::Naive, REFERENCE, false)?;
    println!("{}\n", scenes::title(name));
    println!(
        "| samples | naive pair ms | bracket pair ms | ratio by time | m by counters | right's nodes and tests a \
        sample, naive | bracket | \
         identical % | error of naive's | of bracket's |\n|---|---|---|---|---|---|---|---|---|---|"
    );
    for (index, &samples) in arguments.samples.iter().enumerate() {
        let [naive, bracket] = METHODS.map(|method| render(method, samples, false));
        let (naive, bracket) = (naive?, bracket?);
        let [naive_work, work] = METHODS.map(|method| render(method, samples, true).map(|pair| pair.statistics));
        let (naive_work, work) = (naive_work?, work?);
        let all = naive.right.rgba8.len();
        let same = naive.right.rgba8.iter().zip(&bracket.right.rgba8).filter(|(a, b)| a == b).count();
        let a_sample = |work: &Statistics| work.right.cost() as f64 / (all as f64 * f64::from(samples));
        let [naive_ms, bracket_ms] = [2 * index, 2 * index + 1].map(|turn| median(&taken[turn].times));
        println!(
            "| {samples} | {naive_ms:.1} | {bracket_ms:.1} | {:.3} | {:.3} | {:.2} | {:.2} | {:.3} | {:.5} | {:.5} |",
            naive_ms / bracket_ms,
            work.second_eye(),
            a_sample(&naive_work),
            a_sample(&work),
            100.0 * same as f64 / all as f64,
            error(&naive, &reference),
            error(&bracket, &reference),
        );
    }
    println!();
    if rounds > 0 {
        let [width, height] = camera.pose()?.size.map(f64::from);
        print_groups(&turns, &taken, width * height);
    }
    Ok(())
}

/// Prints nanoseconds per sample for each group of passes.
fn print_groups(turns: &[(Method, u32)], taken: &[Turn], pixels: f64) {
    let names = Vec::from_iter(GROUPS.iter().map(|(name, _)| *name));
    println!("| ns a sample | samples | {} | all |\n|---|---|{}---|", names.join(" | "), "---|".repeat(names.len()));
    for ((method, samples), turn) in turns.iter().zip(taken) {
        let nanoseconds = |times: &Vec<f64>| format!("{:.1}", 1e6 * median(times) / (pixels * f64::from(*samples)));
        let groups = Vec::from_iter(turn.groups.iter().map(nanoseconds));
        println!("| {method} | {samples} | {} | {} |", groups.join(" | "), nanoseconds(&turn.times));
    }
    println!();
}

impl Turn {
    fn add(&mut self, statistics: &Statistics) {
        let Some(times) = &statistics.times else { return };
        self.times.push(1e3 * times.total().as_secs_f64());
        for ((_, passes), sums) in GROUPS.iter().zip(&mut self.groups) {
            let own = times.passes.iter().filter(|(pass, _)| passes.iter().any(|name| pass.starts_with(name)));
            sums.push(own.fold(0.0, |sum, (_, time)| sum + 1e3 * time.as_secs_f64()));
        }
    }
}

/// Returns the median, or NaN without times: on an adapter without timestamps, or if only counts were requested.
fn median(times: &[f64]) -> f64 {
    if times.is_empty() { f64::NAN } else { Spread::of(times.iter().copied()).median }
}

/// Returns the root mean square distance of the right views, in linear light.
fn error(pair: &StereoPair, reference: &StereoPair) -> f64 {
    let colors = pair.right.linear.iter().zip(&reference.right.linear);
    let squares = colors.flat_map(|(a, b)| (0..3).map(|channel| f64::from(a[channel] - b[channel]).powi(2)));
    (squares.sum::<f64>() / (3 * pair.right.linear.len()) as f64).sqrt()
}
