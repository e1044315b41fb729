//! Measures films, frame by frame: `cargo bench --bench frames` prints a table, and writes `results.json` and a chart
//! to target/bench/frames.
//!
//! Each film moves the camera on a path. Naive, bracket, and both forms of bracket with a history take turns at every
//! frame. Figures are those of all frames but the first. `speed` is naive's time over the method's. Costs by counters
//! are relative to naive's left view. `flicker` is the share of pixels whose colour is naive's in exactly one of two
//! successive frames. Options are `--size`, `--frames` and `--e`, the parallax at infinity in pixels of a picture 600
//! pixels wide. `--soft RAYS` makes all lights spheres. `--paths PATHS` follows paths of two bounces. Both add the
//! error of the last frame: the root mean square of its light's difference from a converged picture, relative to
//! naive's. Names select scenes: built-in ones, or folders of OBJ files.

mod chart;
#[path = "../common/mod.rs"]
mod common;

use std::{error::Error, fs, process::ExitCode};

use clap::Parser;
use serde_json::json;
use stereotrace::{
    Gpu, Method, Options, Renderer, ShadowReuse, StereoCamera, StereoPair, UploadedScene,
    blocking::Wait,
    glam::{DQuat, DVec3},
    metrics::compare,
    output::Batch,
};

use crate::common::{
    flicker::Flicker,
    options::size,
    provenance::Provenance,
    records::{self, Record},
    rounds::{Spread, order},
    sampled::{self, Sampled},
    scenes::{self, BenchScene},
};

/// Memory of a history in MiB, enough for any picture here.
const HISTORY: u32 = 4096;

/// Measures films, frame by frame.
#[derive(Parser, Debug)]
#[command(name = "cargo bench --bench frames --")]
struct Arguments {
    /// Smoke run with meaningless figures
    #[arg(long)]
    smoke: bool,
    /// Picture size in pixels [default: 600x600]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Number of frames after the first [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Parallax at infinity in pixels of a picture 600 pixels wide
    #[arg(long, value_name = "PX", default_value_t = 15.0)]
    e: f32,
    /// Makes all lights spheres, with a radius of a twentieth of the camera's distance, sampled by so many rays
    #[arg(long, value_name = "RAYS", value_parser = clap::value_parser!(u32).range(1..=32))]
    soft: Option<u32>,
    /// Follows so many paths of light per pixel, with two bounces
    #[arg(long, value_name = "PATHS", value_parser = clap::value_parser!(u32).range(1..=1024))]
    paths: Option<u32>,
    /// Scenes [default: spheres, hall, sponza, dragon]
    scenes: Vec<String>,
    /// Passed by cargo when it benchmarks; without it this is a smoke run
    #[arg(long, hide = true)]
    bench: bool,
}

/// The path of a camera.
#[derive(Clone, Copy)]
enum Path {
    /// Half a degree around the target a frame.
    Orbit,
    /// Forward, by a fiftieth of the first distance to the target.
    Walk,
    /// Two degrees to the side.
    Turn,
    /// The field of view narrows by 2%.
    Zoom,
    /// Every fourth frame is a cut to another side, 40 degrees around the target.
    Cut,
}

impl Path {
    const ALL: [(&'static str, Self); 5] =
        [("orbit", Self::Orbit), ("walk", Self::Walk), ("turn", Self::Turn), ("zoom", Self::Zoom), ("cut", Self::Cut)];

    /// Returns the camera of a frame.
    fn at(self, camera: StereoCamera, frame: u32) -> Result<StereoCamera, stereotrace::Error> {
        let pose = camera.pose()?;
        let (eye, target, up) = (pose.eye, camera.target_position(), camera.up_direction().as_dvec3());
        let turned = |vector: DVec3, degrees: f64| DQuat::from_axis_angle(up, degrees.to_radians()) * vector;
        let frame = f64::from(frame);
        Ok(match self {
            Self::Orbit => camera.orbited((0.5 * frame).to_radians() as f32),
            Self::Cut => camera.orbited((0.5 * frame + 40.0 * (frame / 4.0).floor()).to_radians() as f32),
            Self::Walk => {
                let step = (target - eye) * (0.02 * frame);
                camera.eye(eye + step).target(target + step)
            }
            Self::Turn => camera.target(eye + turned(target - eye, 2.0 * frame)),
            Self::Zoom => {
                let half = f64::from(0.5 * pose.screen_size[1] / pose.screen_distance) * 0.98_f64.powf(frame);
                camera.vertical_fov_degrees(2.0 * half.atan().to_degrees() as f32)
            }
        })
    }
}

/// Number of pictures of a converged picture, each with [`MOST_RAYS`] rays to a light and [`MOST_PATHS`] paths.
const CONVERGED: u32 = 8;
const MOST_RAYS: u32 = 32;
const MOST_PATHS: u32 = 128;

/// Returns the most samples of the same light.
fn converged(sampled: Sampled) -> Sampled {
    Sampled { soft: sampled.soft.map(|_| MOST_RAYS), paths: sampled.paths.map(|_| MOST_PATHS) }
}

/// A method, with or without a history. Naive is the first.
fn methods(sampled: Sampled) -> [(&'static str, Options); 4] {
    let by = |method| sampled.options(method);
    [
        ("naive", by(Method::Naive)),
        ("bracket", by(Method::BRACKET)),
        ("bracket, history", by(Method::BRACKET).history(HISTORY)),
        ("bracket-rays, history", by(Method::Bracket(ShadowReuse::Rays)).history(HISTORY)),
    ]
}

/// Figures of a method over the frames of a film.
#[derive(Default)]
struct Figures {
    pair_ms: Vec<f64>,
    left: f64,
    right: f64,
    identical: f64,
    wrong_surface: f64,
    /// Flicker of both views.
    flicker: [Flicker; 2],
    /// Root mean square of the last frame's difference from a converged picture, relative to naive's.
    error: Option<f64>,
}

impl Figures {
    /// Returns the mean of both views' flicker in percent.
    fn flicker(&self) -> f64 {
        self.flicker.iter().map(|view| 0.5 * view.percent().unwrap_or_default()).sum()
    }
}

fn main() -> ExitCode {
    common::exit::status(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let quick = arguments.smoke || !arguments.bench;
    let size = arguments.size.unwrap_or(if quick { [64; 2] } else { [600; 2] });
    let frames = arguments.frames.unwrap_or(if quick { 2 } else { 8 });
    let usual: &[&str] = if quick { &["hall"] } else { &["spheres", "hall", "sponza", "dragon"] };
    let names: Vec<String> = match arguments.scenes.as_slice() {
        [] => usual.iter().map(|&name| name.to_owned()).collect(),
        named => named.to_vec(),
    };
    let sampled = Sampled { soft: arguments.soft, paths: arguments.paths };
    let gpu = Gpu::new().wait()?;
    let provenance = Provenance::of(&gpu);
    println!("{provenance}\n\n{}x{}, {frames} frames after the first\n", size[0], size[1]);
    println!(
        "| scene | path | method | pair ms | speed | left, by counters | right | identical % | wrong surface % | \
         flicker % | error |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let mut renderer = Renderer::new(gpu);
    let mut films = Vec::new();
    for name in &names {
        match scenes::load(name, size, arguments.e * size[0] as f32 / 600.0, None)? {
            Some(mut scene) => {
                if arguments.soft.is_some() {
                    sampled::soften(&mut scene)?;
                }
                films.extend(measure(&mut renderer, &scene, frames, sampled)?);
            }
            None => println!("{}\n", scenes::skipped(name)),
        }
    }
    if films.is_empty() {
        return Err("no scene was measured".into());
    }
    let folder = common::files::root().join("target").join(if quick { "bench-smoke" } else { "bench/frames" });
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut batch = Batch::new();
    let all: Vec<Record> = films.iter().flat_map(|film| film.records(size)).collect();
    batch.add(folder.join("results.json"), records::json(&all).as_bytes())?;
    batch.add(folder.join("frames.svg"), chart::svg(&films, size, &provenance)?.as_bytes())?;
    for file in batch.commit()? {
        println!("\nwrote {}", file.display());
    }
    Ok(())
}

/// Figures of all methods for one film.
struct Film {
    scene: String,
    path: &'static str,
    figures: Vec<Figures>,
}

impl Film {
    /// Returns the median times of the methods' pairs, in milliseconds.
    fn times(&self) -> Vec<f64> {
        self.figures.iter().map(|figures| Spread::of(figures.pair_ms.iter().copied()).median).collect()
    }

    fn records(&self, [width, height]: [u32; 2]) -> Vec<Record> {
        let times = self.times();
        let record = |((method, figures), ms): ((&'static str, &Figures), &f64)| {
            vec![
                ("scene", json!(self.scene)),
                ("path", json!(self.path)),
                ("method", json!(method)),
                ("width", json!(width)),
                ("height", json!(height)),
                ("pair_ms", json!(ms)),
                ("pair_over_naive", json!(ms / times[0])),
                ("m_left", json!(figures.left)),
                ("m_right", json!(figures.right)),
                ("identical", json!(figures.identical)),
                ("wrong_surface", json!(figures.wrong_surface)),
                ("flicker", json!(figures.flicker())),
                ("error_over_naive", json!(figures.error)),
            ]
        };
        let methods = methods(Sampled::default());
        methods.iter().map(|(method, _)| *method).zip(&self.figures).zip(&times).map(record).collect()
    }
}

/// Renders the films of a scene, and prints their rows.
fn measure(
    renderer: &mut Renderer,
    bench: &BenchScene,
    frames: u32,
    sampled: Sampled,
) -> Result<Vec<Film>, Box<dyn Error>> {
    let BenchScene { name, scene, camera } = bench;
    let uploaded = renderer.upload(scene).wait()?;
    let mut films = Vec::new();
    for (path_name, path) in Path::ALL {
        let cameras = (0..=frames).map(|frame| path.at(*camera, frame)).collect::<Result<Vec<_>, _>>()?;
        let figures = film_figures(renderer, &uploaded, &cameras, sampled)?;
        let film = Film { scene: name.clone(), path: path_name, figures };
        let times = film.times();
        for (((method, _), figures), ms) in methods(sampled).into_iter().zip(&film.figures).zip(&times) {
            let Figures { left, right, identical, wrong_surface, .. } = figures;
            println!(
                "| {} | {path_name} | {method} | {ms:.0} | {:.2} | {left:.3} | {right:.3} | {identical:.3} | \
                 {wrong_surface:.3} | {:.3} | {} |",
                scenes::title(name),
                times[0] / ms,
                figures.flicker(),
                figures.error.map_or("-".into(), |error| format!("{error:.2}")),
            );
        }
        films.push(film);
    }
    Ok(films)
}

/// Renders a film twice by all methods: for times, and with counters for work and accuracy.
fn film_figures(
    renderer: &mut Renderer,
    scene: &UploadedScene,
    film: &[StereoCamera],
    sampled: Sampled,
) -> Result<Vec<Figures>, Box<dyn Error>> {
    let methods = methods(sampled);
    let mut all: Vec<Figures> = methods.iter().map(|_| Figures::default()).collect();
    // A history is of one method's frames, so both forms of bracket with one have renderers of their own.
    let mut renderers: Vec<Renderer> = methods.iter().map(|_| Renderer::new(renderer.gpu().clone())).collect();
    for (frame, camera) in film.iter().enumerate() {
        for index in order(frame, methods.len()) {
            let statistics = renderers[index].pair(scene, camera).options(&methods[index].1).trace().wait()?;
            let total = statistics.times.map_or(f64::NAN, |times| times.total().as_secs_f64());
            all[index].pair_ms.extend((frame > 0).then_some(1e3 * total));
        }
    }
    renderers.iter_mut().for_each(Renderer::forget);
    let share = 1.0 / (film.len() - 1) as f64;
    for (frame, camera) in film.iter().enumerate() {
        let mut truth: Option<StereoPair> = None;
        let mut converged: Option<Vec<f64>> = None;
        for (index, (_, options)) in methods.iter().enumerate() {
            let options = options.clone().count(true);
            let pair = renderers[index].pair(scene, camera).options(&options).read().wait()?;
            let naive = truth.get_or_insert_with(|| pair.clone());
            if frame == 0 {
                continue;
            }
            let figures = &mut all[index];
            let pictures = [(&pair.left, &naive.left), (&pair.right, &naive.right)];
            for (flicker, (view, naive)) in figures.flicker.iter_mut().zip(pictures) {
                flicker.add(&view.rgba8, &naive.rgba8);
            }
            let eye = naive.statistics.left.cost() as f64;
            figures.left += share * pair.statistics.left.cost() as f64 / eye;
            figures.right += share * pair.statistics.right.cost() as f64 / eye;
            for (view, naive) in pictures {
                let difference = compare(view, naive, &pair.pose)?;
                figures.identical += 0.5 * share * difference.identical_percent;
                figures.wrong_surface += 0.5 * share * difference.wrong_surface_percent;
            }
            if sampled.is_any() && frame + 1 == film.len() {
                let truth = match &converged {
                    Some(truth) => truth,
                    None => converged.insert(converged_light(renderer, scene, camera, sampled)?),
                };
                figures.error = Some(distance(&light_of(&pair), truth));
            }
        }
    }
    let naive = all[0].error;
    for figures in &mut all {
        figures.error = figures.error.zip(naive).map(|(error, naive)| error / naive);
    }
    Ok(all)
}

/// Returns the linear light of both views.
fn light_of(pair: &StereoPair) -> Vec<f64> {
    let both = [&pair.left, &pair.right].map(|view| view.linear.iter().flat_map(|[r, g, b, _]| [r, g, b]));
    both.into_iter().flatten().map(|&light| f64::from(light)).collect()
}

/// Returns the light of a picture by many rays and paths.
fn converged_light(
    renderer: &mut Renderer,
    scene: &UploadedScene,
    camera: &StereoCamera,
    sampled: Sampled,
) -> Result<Vec<f64>, stereotrace::Error> {
    let mut sum = Vec::new();
    for seed in 1..=CONVERGED {
        let options = converged(sampled).options(Method::Naive).seed(seed);
        let light = light_of(&renderer.pair(scene, camera).options(&options).read().wait()?);
        sum.resize(light.len(), 0.0);
        sum.iter_mut().zip(light).for_each(|(sum, light)| *sum += light / f64::from(CONVERGED));
    }
    Ok(sum)
}

/// Returns the root mean square of the differences.
fn distance(light: &[f64], other: &[f64]) -> f64 {
    let squares = light.iter().zip(other).map(|(a, b)| (a - b).powi(2));
    (squares.sum::<f64>() / light.len() as f64).sqrt()
}
