//! Measures the cost of a rig of many views: `cargo bench --bench views` prints a table.
//!
//! Methods take turns in one run. Times are medians of the rounds by the host's clock, including read-back. `cargo
//! bench --bench views -- NAME…` selects other scenes: built-in ones, or folders of OBJ files.

#[path = "common/mod.rs"]
mod common;

use std::{collections::BTreeMap, error::Error, time::Instant};

use stereotrace::{Gpu, Method, Options, Renderer, Rig, blocking::Wait, metrics::compare};

use crate::common::{
    options::{is_quick, scenes_named},
    provenance::Provenance,
    rounds::{Spread, order},
    scenes::{self, BenchScene},
};

/// Parallax at infinity between neighbouring views, in pixels.
const NEIGHBOURS: f32 = 2.0;
/// Methods, with the ground truth first.
const METHODS: [Method; 4] = [Method::Naive, Method::BRACKET, Method::VERIFIED, Method::Auto];

fn main() -> Result<(), Box<dyn Error>> {
    let quick = is_quick();
    let (size, eyes, rounds) = if quick { ([64, 64], 5, 1) } else { ([512, 512], 45, 5) };
    let names = scenes_named(&["hall", "dragon"]);
    let gpu = Gpu::new().wait()?;
    let provenance = Provenance::of(&gpu);
    println!("{provenance}\n");
    let mut renderer = Renderer::new(gpu);
    for name in &names {
        match scenes::load(name, size, NEIGHBOURS, None)? {
            Some(scene) => measure(&mut renderer, &scene, eyes, rounds)?,
            None => println!("{}\n", scenes::skipped(name)),
        }
    }
    Ok(())
}

/// Prints a scene's table, and the time of each pass of each method.
fn measure(renderer: &mut Renderer, bench: &BenchScene, eyes: usize, rounds: usize) -> Result<(), Box<dyn Error>> {
    let BenchScene { name, scene, camera } = bench;
    let rig = Rig::row(*camera, eyes);
    let uploaded = renderer.upload(scene).wait()?;
    let mut walls = vec![Vec::new(); METHODS.len()];
    let mut passes = vec![BTreeMap::<&str, Vec<f64>>::new(); METHODS.len()];
    for round in 0..=rounds {
        for index in order(round, METHODS.len()) {
            let start = Instant::now();
            let views = renderer.views(&uploaded, &rig).options(&Options::new(METHODS[index])).read().wait()?;
            let wall = 1e3 * start.elapsed().as_secs_f64();
            if round == 0 {
                continue;
            }
            walls[index].push(wall);
            let mut sums = BTreeMap::<&str, f64>::new();
            for (pass, time) in views.times.iter().flat_map(|times| &times.passes) {
                *sums.entry(pass).or_default() += 1e3 * time.as_secs_f64();
            }
            sums.into_iter().for_each(|(pass, sum)| passes[index].entry(pass).or_default().push(sum));
        }
    }
    let median = |times: &Vec<f64>| Spread::of(times.iter().copied()).median;
    let naive = renderer.views(&uploaded, &rig).options(&Options::new(Method::Naive).count(true)).read().wait()?;
    let cost = |views: &stereotrace::Views| views.views.iter().map(|view| view.work.cost() as f64).sum::<f64>();
    println!("{}, {eyes} views, {NEIGHBOURS} px between neighbours\n", scenes::title(name));
    println!(
        "| method | ms | of naive, by time | of naive, by counters | identical % | in the worst view | wrong surface % \
        |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (index, &method) in METHODS.iter().enumerate() {
        let views = renderer.views(&uploaded, &rig).options(&Options::new(method).count(true)).read().wait()?;
        let (mut sum, mut least, mut wrong) = (0.0, 100.0_f64, 0.0_f64);
        for (view, truth) in views.views.iter().zip(&naive.views) {
            let difference = compare(&view.view, &truth.view, &views.pose)?;
            sum += difference.identical_percent;
            least = least.min(difference.identical_percent);
            wrong = wrong.max(difference.wrong_surface_percent);
        }
        println!(
            "| {method} | {:.0} | {:.2} | {:.3} | {:.3} | {least:.3} | {wrong:.3} |",
            median(&walls[index]),
            median(&walls[index]) / median(&walls[0]),
            cost(&views) / cost(&naive),
            sum / eyes as f64,
        );
    }
    println!();
    for (method, passes) in METHODS.iter().zip(&passes) {
        let passes: Vec<String> = passes.iter().map(|(pass, times)| format!("{pass} {:.0}", median(times))).collect();
        println!("{method}, ms: {}\n", passes.join(", "));
    }
    Ok(())
}
