//! Measures the cost of soft light and the second eye's accuracy: `cargo bench -p stereotrace-studies --bench soft`
//! prints a table.
//!
//! Naive and bracket by both rules of `Penumbra` take turns in one run. Times are medians of the rounds and cover the
//! passes alone. Errors are the right view's mean and root mean square distance from a converged picture, in linear
//! light. The converged picture is the mean of naive's pictures for many seeds, with 32 rays each. So naive's own error
//! is noise. Counts and errors are measured at half the width and height. `cargo bench -p stereotrace-studies --bench
//! soft -- NAME…` selects other scenes: built-in scenes, trials of the stability suite (cables, foliage, …), or folders
//! of OBJ files. `--counts` leaves out the times, and `--times` leaves out everything else.

#[path = "../../benches/common/mod.rs"]
mod common;

use std::error::Error;

use stereotrace::{
    AmbientOcclusion, Gpu, Light, MAX_SOFT_RAYS, Method, Options, Penumbra, Renderer, Scene, Sky, SkyMap, StereoPair,
    blocking::Wait, glam::Vec3, metrics::compare,
};

use crate::common::{
    options::{is_quick, scenes_named},
    provenance::Provenance,
    rounds::{Spread, order},
    scenes::{self, BenchScene},
};

/// Parallax at infinity in pixels, for a picture 600 pixels wide.
const E_PX: f32 = 15.0;
/// Number of lights in each scene.
const LIGHTS: usize = 2;

/// Source of soft light. Lengths are shares of the scene's diagonal.
#[derive(Clone, Copy)]
enum Softness {
    /// Spherical lights of this radius.
    Lights(f32),
    /// Ambient occlusion with this reach.
    Occlusion(f32),
    /// Light from the sky, in place of ambient light.
    SkyGradient,
    SkyMap,
}

const ALL: [(&str, Softness); 8] = [
    ("2 lights, radius 0.0005", Softness::Lights(0.0005)),
    ("2 lights, radius 0.002", Softness::Lights(0.002)),
    ("2 lights, radius 0.005", Softness::Lights(0.005)),
    ("2 lights, radius 0.01", Softness::Lights(0.01)),
    ("2 lights, radius 0.05", Softness::Lights(0.05)),
    ("occlusion to 0.1, 2 points", Softness::Occlusion(0.1)),
    ("sky of a gradient, 2 points", Softness::SkyGradient),
    ("sky with a sun, 2 points", Softness::SkyMap),
];

/// Width of the sky map in pixels.
const SKY_WIDTH: u32 = 1024;

fn main() -> Result<(), Box<dyn Error>> {
    let quick = is_quick();
    let has = |wanted| std::env::args().any(|argument| argument == wanted);
    let (side, rounds, seeds) = match quick {
        true => (48, 1, 2),
        false => (600, if has("--counts") { 0 } else { 5 }, if has("--times") { 0 } else { 32 }),
    };
    let names = scenes_named(&["hall", "sponza_4x"]);
    let gpu = Gpu::new().wait()?;
    let provenance = Provenance::of(&gpu);
    println!("{provenance}\n");
    println!(
        "{side}x{side}, 16 rays a light or surroundings, {rounds} rounds, errors against {} rays\n",
        seeds * MAX_SOFT_RAYS
    );
    println!(
        "| scene | light | method | pair ms | pair of naive | speed-up | second eye by time | by counters | shadow \
        rays of naive's | identical % | error of naive's, mean | root mean square |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    let mut renderer = Renderer::new(gpu);
    for name in &names {
        match scenes::load(name, [side; 2], E_PX * side as f32 / 600.0, Some(LIGHTS))? {
            Some(scene) => {
                for (light, softness) in ALL {
                    measure(&mut renderer, &scene, light, softness, rounds, seeds)?;
                }
            }
            None => println!("{}\n", scenes::skipped(name)),
        }
    }
    Ok(())
}

/// Returns the compared methods, with the ground truth first.
fn methods(base: &Options) -> [(&'static str, Options); 3] {
    let with = |method, penumbra| base.clone().method(method).penumbra(penumbra);
    [
        ("naive", with(Method::Naive, Penumbra::Exact)),
        ("bracket, exact", with(Method::BRACKET, Penumbra::Exact)),
        ("bracket, shared", with(Method::BRACKET, Penumbra::default())),
    ]
}

/// Makes a scene's light soft, and returns the options to render it with.
fn soften(scene: &mut Scene, softness: Softness) -> Result<Options, Box<dyn Error>> {
    let diagonal = scene.bounds().map_or(1.0, |(low, high)| low.distance(high) as f32);
    let mut base = Options::new(Method::Naive);
    match softness {
        Softness::Lights(radius) => {
            for light in &mut scene.lights {
                *light = Light::sphere(light.position, radius * diagonal, light.intensity);
            }
        }
        Softness::Occlusion(reach) => base = base.ambient_occlusion(AmbientOcclusion::new(16, reach * diagonal)),
        Softness::SkyGradient => {
            scene.sky = Sky::Gradient { nadir: Vec3::splat(0.3), zenith: Vec3::new(0.5, 0.7, 1.0) };
            base = base.sky_rays(16);
        }
        Softness::SkyMap => {
            scene.sky = Sky::Map(SkyMap::procedural(SKY_WIDTH)?);
            base = base.sky_rays(16);
        }
    }
    Ok(base)
}

fn measure(
    renderer: &mut Renderer,
    bench: &BenchScene,
    light: &str,
    softness: Softness,
    rounds: usize,
    seeds: u32,
) -> Result<(), Box<dyn Error>> {
    let BenchScene { name, scene, camera } = bench;
    let mut scene = scene.clone();
    let base = soften(&mut scene, softness)?;
    let uploaded = renderer.upload(&scene).wait()?;
    let methods = methods(&base);
    let mut times = vec![if rounds > 0 { Vec::new() } else { vec![f64::NAN] }; methods.len()];
    for round in (0..=rounds).filter(|_| rounds > 0) {
        for index in order(round, methods.len()) {
            let statistics = renderer.pair(&uploaded, camera).options(&methods[index].1).trace().wait()?;
            let total = statistics.times.map_or(f64::NAN, |times| times.total().as_secs_f64());
            let left = statistics.left.rays.primary;
            assert!(left > 0 && !statistics.in_steps, "{name}: {light}");
            if round > 0 {
                times[index].push(1e3 * total);
            }
        }
    }
    let median = |index: usize| Spread::of(times[index].iter().copied()).median;
    let of_times = |index: usize| {
        let of_naive = median(index) / median(0);
        format!("{:.0} | {of_naive:.3} | {:.2} | {:.2}", median(index), 1.0 / of_naive, 2.0 * of_naive - 1.0)
    };
    if seeds == 0 {
        for (index, (method, _)) in methods.iter().enumerate() {
            println!("| {} | {light} | {method} | {} |", scenes::title(name), of_times(index));
        }
        return Ok(());
    }
    // A quarter of the pixels is enough. It is not an easier case, since penumbrae are half as many pixels wide.
    let [width, height] = camera.pose()?.size;
    let e_px = camera.pose()?.interaxial_px / 2.0;
    let camera = &camera.size(width / 2, height / 2).interaxial_pixels(e_px);
    let limit = converged(renderer, &uploaded, camera, &base, seeds)?;
    let render = |renderer: &mut Renderer, options: &Options| {
        renderer.pair(&uploaded, camera).options(&options.clone().linear(true).count(true)).read().wait()
    };
    let naive = render(renderer, &methods[0].1)?;
    for (index, (method, options)) in methods.iter().enumerate() {
        let pair = render(renderer, options)?;
        let ([mean_error, rms], [naive_mean, naive_rms]) = (errors(&pair, &limit), errors(&naive, &limit));
        println!(
            "| {} | {light} | {method} | {} | {:.3} | {:.3} | {:.2} | {} | {} |",
            scenes::title(name),
            of_times(index),
            pair.statistics.second_eye(),
            pair.statistics.right.rays.shadow as f64 / naive.statistics.right.rays.shadow as f64,
            compare(&pair.right, &naive.right, &pair.pose)?.identical_percent,
            of(mean_error, naive_mean),
            of(rms, naive_rms),
        );
    }
    Ok(())
}

/// Formats an error as a share of naive's. Naive has no error if all light comes from points. This occurs with the
/// sky's light in a hall without windows.
fn of(error: f64, of_naive: f64) -> String {
    if of_naive > 1e-4 { format!("{:.3}", error / of_naive) } else { "-".into() }
}

/// Returns the linear colours of the right view to which naive converges.
fn converged(
    renderer: &mut Renderer,
    scene: &stereotrace::UploadedScene,
    camera: &stereotrace::StereoCamera,
    base: &Options,
    seeds: u32,
) -> Result<Vec<[f64; 3]>, stereotrace::Error> {
    let mut base = base.clone().linear(true).shadow_rays(MAX_SOFT_RAYS);
    base.sky_rays = base.sky_rays.map(|_| MAX_SOFT_RAYS);
    base.ambient_occlusion =
        base.ambient_occlusion.map(|occlusion| AmbientOcclusion::new(MAX_SOFT_RAYS, occlusion.radius));
    let mut sum = Vec::new();
    for seed in 1..=seeds {
        let pair = renderer.pair(scene, camera).options(&base.clone().seed(seed)).read().wait()?;
        sum.resize(pair.right.linear.len(), [0.0; 3]);
        for (sum, color) in sum.iter_mut().zip(&pair.right.linear) {
            (0..3).for_each(|k| sum[k] += f64::from(color[k]) / f64::from(seeds));
        }
    }
    Ok(sum)
}

/// Returns the mean, and the root of the mean square.
fn errors(pair: &StereoPair, limit: &[[f64; 3]]) -> [f64; 2] {
    let off = |(color, limit): (&[f32; 4], &[f64; 3])| {
        (0..3).map(|k| (f64::from(color[k]) - limit[k]).powi(2)).sum::<f64>().sqrt()
    };
    let (mut sum, mut squares) = (0.0, 0.0);
    for off in pair.right.linear.iter().zip(limit).map(off) {
        sum += off;
        squares += off * off;
    }
    let count = limit.len() as f64;
    [sum / count, (squares / count).sqrt()]
}
