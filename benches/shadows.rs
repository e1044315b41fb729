//! Shadow-buffers against shadow rays: `cargo bench --bench shadows` prints tables and writes them as CSV to target/bench/shadows.csv.
//!
//! Of each scene, method, rule and number of rows: how many pixels of both views are not those of the same method by shadow rays, and how many of
//! its shadow rays are saved over a pair, over a rig of 16 views, and over 16 pairs of a camera that moves aside, the rays that fill tables counted.
//! Times are those of passes; that of filling is the host's. Names of scenes choose others than the usual ones; `--rows 100,400`,
//! `--rules object,depth,0.1,0.5` (numbers are margins of hybrid ones), `--methods naive,bracket`, `--size 600x600` and `--rounds 5` do what they say.

#[path = "common/mod.rs"]
mod common;

use std::{error::Error, fmt::Write, fs, time::Instant};

use stereotrace::{
    Gpu, Method, Options, Renderer, Rig, ShadowBuffer, ShadowRule, Statistics, StereoCamera, StereoPair, UploadedScene,
    View,
};

use crate::common::{
    options::{is_quick, size},
    provenance::Provenance,
    rounds::Spread,
    scenes::{self, BenchScene},
};

/// Views of the rig, pairs of the moving camera.
const VIEWS: usize = 16;
/// Parallax at infinity between the rig's neighbours, in pixels, and between those of the moving camera's pairs.
const NEIGHBOURS: f32 = 2.0;
const E_PX: f32 = 15.0;

/// What the command line asks for.
struct Asked {
    scenes: Vec<String>,
    size: [u32; 2],
    rows: Vec<u32>,
    rules: Vec<ShadowRule>,
    methods: Vec<Method>,
    rounds: usize,
}

impl Asked {
    fn read() -> Result<Self, Box<dyn Error>> {
        let quick = is_quick();
        let mut asked = Self {
            scenes: Vec::new(),
            size: if quick { [64, 64] } else { [600, 600] },
            rows: if quick { vec![40] } else { vec![100, 200, 400, 800] },
            rules: [0.03, 0.1, 0.3].map(|margin| ShadowRule::Hybrid { margin }).to_vec(),
            methods: vec![Method::Naive, Method::BRACKET],
            rounds: if quick { 0 } else { 5 },
        };
        asked.rules.extend([ShadowRule::DEPTH, ShadowRule::Object]);
        let mut arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} takes a value"));
            match argument.as_str() {
                "--rows" => asked.rows = value()?.split(',').map(str::parse).collect::<Result<_, _>>()?,
                "--rules" => asked.rules = value()?.split(',').map(rule).collect::<Result<_, _>>()?,
                "--methods" => asked.methods = value()?.split(',').map(str::parse).collect::<Result<_, _>>()?,
                "--size" => asked.size = size(&value()?)?,
                "--rounds" => asked.rounds = value()?.parse()?,
                name if !name.starts_with("--") => asked.scenes.push(name.into()),
                unknown => return Err(format!("{unknown}: no such option").into()),
            }
        }
        if asked.scenes.is_empty() {
            let usual = if quick { &["hall"][..] } else { &["spheres", "hall", "sponza_4x", "dragon"] };
            asked.scenes = usual.iter().map(|&name| name.to_owned()).collect();
        }
        Ok(asked)
    }
}

fn rule(text: &str) -> Result<ShadowRule, String> {
    match text {
        "object" => Ok(ShadowRule::Object),
        "depth" => Ok(ShadowRule::DEPTH),
        margin => Ok(ShadowRule::Hybrid { margin: margin.parse().map_err(|_| format!("{margin}: no rule"))? }),
    }
}

fn name_of(rule: ShadowRule) -> String {
    match rule {
        ShadowRule::Object => "object".into(),
        ShadowRule::Depth { bias } => format!("depth {bias}"),
        ShadowRule::Hybrid { margin } => format!("hybrid {margin}"),
        _ => "unknown".into(),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let asked = Asked::read()?;
    let gpu = Gpu::new()?;
    let provenance = Provenance::of(&gpu);
    println!("adapter: {}\ndriver:  {}\n", provenance.adapter, provenance.driver);
    let mut renderer = Renderer::new(gpu);
    let mut csv = String::from(
        "scene,method,rule,rows,wrong_percent,pair_saved,rig_saved,film_saved,pair_rays,filled,bytes,ms,ms_rays,fill_ms\n",
    );
    for name in &asked.scenes {
        let Some(bench) = scenes::load(name, asked.size, E_PX, None)? else {
            println!("{}\n", scenes::skipped(name));
            continue;
        };
        measure(&mut renderer, &bench, &asked, &mut csv)?;
    }
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/target/bench");
    fs::create_dir_all(folder)?;
    fs::write(format!("{folder}/shadows.csv"), csv)?;
    Ok(())
}

/// Prints a scene's table.
fn measure(renderer: &mut Renderer, bench: &BenchScene, asked: &Asked, csv: &mut String) -> Result<(), Box<dyn Error>> {
    let BenchScene { name, scene, camera } = bench;
    println!("{}, {} lights, {}x{}\n", scenes::title(name), scene.lights.len(), asked.size[0], asked.size[1]);
    println!(
        "| method | rule | rows | wrong % | saved by a pair % | a rig of {VIEWS} % | {VIEWS} pairs % | shadow rays of a pair | filled | MiB | passes ms | by rays | fill ms |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for &method in &asked.methods {
        let uploaded = renderer.upload(scene)?;
        let plain = Options::new(method);
        let truth = renderer.render(&uploaded, camera, &plain)?;
        let by_rays = Cost::of(renderer, &uploaded, camera, &plain, asked.rounds)?;
        for &rule in &asked.rules {
            for &rows in &asked.rows {
                let options = plain.clone().shadow_buffer(ShadowBuffer::new(rows).rule(rule));
                // A scene of its own, in which nothing is filled yet.
                let uploaded = renderer.upload(scene)?;
                let begin = Instant::now();
                let pair = renderer.render(&uploaded, camera, &options)?;
                let first = 1e3 * begin.elapsed().as_secs_f64();
                let begin = Instant::now();
                renderer.render(&uploaded, camera, &options)?;
                let fill_ms = first - 1e3 * begin.elapsed().as_secs_f64();
                let cost = Cost::of(renderer, &uploaded, camera, &options, asked.rounds)?;
                let filled = pair.statistics.shadow_buffer.filled;
                let saved = |with: u64, without: u64| 100.0 * (1.0 - (filled + with) as f64 / without as f64);
                let savings =
                    [saved(cost.pair, by_rays.pair), saved(cost.rig, by_rays.rig), saved(cost.film, by_rays.film)];
                let wrong = wrong_percent(&pair, &truth);
                let mib = pair.statistics.shadow_buffer.bytes as f64 / f64::from(1 << 20);
                println!(
                    "| `{method}` | {} | {rows} | {wrong:.4} | {:.1} | {:.1} | {:.1} | {} | {filled} | {mib:.1} | {:.0} | {:.0} | {fill_ms:.0} |",
                    name_of(rule),
                    savings[0],
                    savings[1],
                    savings[2],
                    cost.pair,
                    cost.ms,
                    by_rays.ms
                );
                writeln!(
                    csv,
                    "{name},{method},{},{rows},{wrong:.5},{:.2},{:.2},{:.2},{},{filled},{},{:.1},{:.1},{fill_ms:.1}",
                    name_of(rule),
                    savings[0],
                    savings[1],
                    savings[2],
                    cost.pair,
                    pair.statistics.shadow_buffer.bytes,
                    cost.ms,
                    by_rays.ms
                )?;
            }
        }
    }
    println!();
    Ok(())
}

/// Shadow rays, and time of a pair's passes.
struct Cost {
    pair: u64,
    rig: u64,
    film: u64,
    ms: f64,
}

impl Cost {
    fn of(
        renderer: &mut Renderer,
        uploaded: &UploadedScene,
        camera: &StereoCamera,
        options: &Options,
        rounds: usize,
    ) -> Result<Self, Box<dyn Error>> {
        let of_pair = |statistics: &Statistics| statistics.left.rays.shadow + statistics.right.rays.shadow;
        let pair = of_pair(&renderer.trace(uploaded, camera, options)?);
        let rig = renderer.render_views(uploaded, &Rig::row(camera.interaxial_pixels(NEIGHBOURS), VIEWS), options)?;
        let mut film = 0;
        let pose = camera.pose()?;
        for frame in 0..VIEWS {
            // A step of an interaxial each.
            let aside = pose.right * (pose.interaxial * (frame as f32 - 0.5 * VIEWS as f32));
            let eye = pose.eye + aside;
            let moved = camera.eye(eye).target(eye + pose.screen_distance * pose.forward);
            film += of_pair(&renderer.trace(uploaded, &moved, options)?);
        }
        let mut times = Vec::new();
        for _ in 0..rounds {
            let statistics = renderer.trace(uploaded, camera, options)?;
            times.extend(statistics.times.map(|times| 1e3 * times.total().as_secs_f64()));
        }
        let ms = if times.is_empty() { f64::NAN } else { Spread::of(times).median };
        Ok(Self { pair, rig: rig.views.iter().map(|view| view.work.rays.shadow).sum(), film, ms })
    }
}

/// Share of the pixels of both views whose colours differ, percent.
fn wrong_percent(pair: &StereoPair, truth: &StereoPair) -> f64 {
    let differing = |a: &View, b: &View| a.rgba8.iter().zip(&b.rgba8).filter(|(a, b)| a != b).count();
    let wrong = differing(&pair.left, &truth.left) + differing(&pair.right, &truth.right);
    100.0 * wrong as f64 / (2 * truth.left.rgba8.len()) as f64
}
