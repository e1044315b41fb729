//! Compares shadow-buffers with shadow rays: `cargo bench -p stereotrace-studies --bench shadows` prints tables. It
//! writes them as shadows.csv with a chart, shadows.svg, to target/bench.
//!
//! The tables have one row per scene, method, rule and number of rows. Wrong pixels of both views are pixels that
//! differ from the same method with shadow rays. Saved shadow rays are counted over a pair, a rig of 16 views, and 16
//! pairs of a camera that moves sideways. Further columns show the work of filling the shadow-buffers and their size.
//! The passes of a pair are timed with filled buffers and with rays, which take turns. Filling is timed by the host's
//! clock. Scene names select other scenes than the default ones. The options are `--rows 100,400`, `--rules
//! object,depth,0.1,0.5` (numbers are margins of hybrid rules), `--methods naive,bracket`, `--size 600x600` and
//! `--rounds 5`. `--rounds 0` measures no times.

mod chart;
#[path = "../../../benches/common/mod.rs"]
mod common;

use std::{error::Error, fmt::Write, time::Instant};

use stereotrace::{
    Gpu, Method, Options, Renderer, Rig, ShadowBuffer, ShadowBufferWork, ShadowRule, Statistics, StereoCamera,
    StereoPair, UploadedScene, View, blocking::Wait,
};

use crate::common::{
    files::save,
    options::{is_quick, size},
    provenance::Provenance,
    rounds::{Spread, order},
    scenes::{self, BenchScene},
};

/// Number of views of the rig, and of pairs of the moving camera.
const VIEWS: usize = 16;
/// Parallax at infinity between neighbouring views of the rig, in pixels.
const NEIGHBOURS: f32 = 2.0;
const E_PX: f32 = 15.0;

/// Options of the command line.
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
            rows: if quick { vec![40] } else { vec![200, 400, 800] },
            rules: [0.0, 0.1, 0.2].map(|margin| ShadowRule::Hybrid { margin }).to_vec(),
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
    let gpu = Gpu::new().wait()?;
    let provenance = Provenance::of(&gpu);
    println!("{provenance}\n");
    let mut renderer = Renderer::new(gpu);
    let mut all = Vec::new();
    for name in &asked.scenes {
        match scenes::load(name, asked.size, E_PX, None)? {
            Some(bench) => measure(&mut renderer, &bench, &asked, &mut all)?,
            None => println!("{}\n", scenes::skipped(name)),
        }
    }
    let mut csv = String::from(
        "scene,method,rule,rows,wrong_percent,pair_saved,rig_saved,film_saved,pair_rays,filled,fill_projections,\
         fill_tests,bytes,ms,ms_rays,fill_ms\n",
    );
    for figures in &all {
        let Figures { scene, method, rule, rows, wrong, saved: [pair, rig, film], rays, filled, bytes, .. } = figures;
        let [projections, tests] = figures.fill_counts;
        let [ms, by_rays, fill] = figures.ms;
        writeln!(
            csv,
            "{scene},{method},{},{rows},{wrong:.5},{pair:.2},{rig:.2},{film:.2},{rays},{filled},{projections},{tests},\
             {bytes},{ms:.1},{by_rays:.1},{fill:.1}",
            name_of(*rule),
        )?;
    }
    let target = common::files::root().join("target");
    let folder = target.join(if is_quick() { "bench-smoke/shadows" } else { "bench" });
    let files = [("shadows.csv", csv), ("shadows.svg", chart::svg(&all, asked.size, &provenance)?)];
    for path in save(&files.map(|(name, text)| (name.to_owned(), text)), &folder)? {
        println!("wrote {}", path.display());
    }
    Ok(())
}

/// Figures of a scene, method, rule and number of rows.
struct Figures {
    scene: String,
    method: Method,
    rule: ShadowRule,
    rows: u32,
    /// Percentage of wrong pixels.
    wrong: f64,
    /// Percentages of shadow rays saved over a pair, the rig, and the pairs of the moving camera.
    saved: [f64; 3],
    /// Number of shadow rays of a pair.
    rays: u64,
    filled: u64,
    /// Numbers of primitive projections and of tests that fill the buffers.
    fill_counts: [u64; 2],
    bytes: u64,
    /// Milliseconds of a pair's passes, of the same pair with shadow rays, and of filling.
    ms: [f64; 3],
}

/// One of the variants that take turns.
struct Case {
    options: Options,
    uploaded: UploadedScene,
    times: Vec<f64>,
}

impl Case {
    fn new(renderer: &mut Renderer, bench: &BenchScene, options: Options) -> Result<Self, Box<dyn Error>> {
        Ok(Self { options, uploaded: renderer.upload(&bench.scene).wait()?, times: Vec::new() })
    }

    fn median(&self) -> f64 {
        if self.times.is_empty() { f64::NAN } else { Spread::of(self.times.clone()).median }
    }
}

/// Prints a scene's table.
fn measure(
    renderer: &mut Renderer,
    bench: &BenchScene,
    asked: &Asked,
    all: &mut Vec<Figures>,
) -> Result<(), Box<dyn Error>> {
    let BenchScene { name, scene, camera } = bench;
    println!("{}, {} lights, {}x{}\n", scenes::title(name), scene.lights.len(), asked.size[0], asked.size[1]);
    println!(
        "| method | rule | rows | wrong % | saved by a pair % | a rig of {VIEWS} % | {VIEWS} pairs % | shadow rays of \
        a pair | passes ms | of rays' | filled | projections and tests, millions | fill ms | MiB |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for &method in &asked.methods {
        let plain = Options::new(method);
        let mut cases = vec![Case::new(renderer, bench, plain.clone())?];
        let asks = asked.rules.iter().flat_map(|&rule| asked.rows.iter().map(move |&rows| (rule, rows)));
        let asks: Vec<_> = asks.collect();
        for &(rule, rows) in &asks {
            let options = plain.clone().shadow_buffer(ShadowBuffer::new(rows).rule(rule));
            cases.push(Case::new(renderer, bench, options)?);
        }
        // The first round compiles kernels and fills shadow-buffers.
        for round in 0..=asked.rounds {
            for index in order(round, cases.len()) {
                let Case { options, uploaded, times } = &mut cases[index];
                let statistics = renderer.pair(uploaded, camera).options(options).trace().wait()?;
                if round > 0 {
                    times.extend(statistics.times.map(|times| 1e3 * times.total().as_secs_f64()));
                }
            }
        }
        let by_rays = Rays::of(renderer, &cases[0], camera)?;
        let truth = renderer.pair(&cases[0].uploaded, camera).options(&plain).read().wait()?;
        let ms_by_rays = cases[0].median();
        for (case, (rule, rows)) in cases.iter().skip(1).zip(asks) {
            let rays = Rays::of(renderer, case, camera)?;
            let pair = renderer.pair(&case.uploaded, camera).options(&case.options).read().wait()?;
            let (work, fill_ms) = filling(renderer, bench, &case.options)?;
            let saved = |with: u64, without: u64| 100.0 * (1.0 - with as f64 / without as f64);
            let figures = Figures {
                scene: name.clone(),
                method,
                rule,
                rows,
                wrong: wrong_percent(&pair, &truth),
                saved: [saved(rays.pair, by_rays.pair), saved(rays.rig, by_rays.rig), saved(rays.film, by_rays.film)],
                rays: rays.pair,
                filled: work.filled,
                fill_counts: [work.nodes, work.primitive_tests],
                bytes: work.bytes,
                ms: [case.median(), ms_by_rays, fill_ms],
            };
            println!(
                "| `{method}` | {} | {rows} | {:.4} | {:.1} | {:.1} | {:.1} | {} | {:.0} | {:.2} | {} | {:.2} | \
                {fill_ms:.0} | {:.1} |",
                name_of(rule),
                figures.wrong,
                figures.saved[0],
                figures.saved[1],
                figures.saved[2],
                figures.rays,
                case.median(),
                case.median() / ms_by_rays,
                work.filled,
                (work.nodes + work.primitive_tests) as f64 / 1e6,
                work.bytes as f64 / f64::from(1 << 20),
            );
            all.push(figures);
        }
    }
    println!();
    Ok(())
}

/// Returns the counts of filling a scene's shadow-buffers, and the milliseconds. The time is the difference between a
/// first and a second small frame.
fn filling(
    renderer: &mut Renderer,
    bench: &BenchScene,
    options: &Options,
) -> Result<(ShadowBufferWork, f64), Box<dyn Error>> {
    let camera = bench.camera.size(16, 16);
    let counted = renderer.upload(&bench.scene).wait()?;
    let work = renderer.pair(&counted, &camera).options(&options.clone().count(true)).trace().wait()?.shadow_buffer;
    let mut least = f64::INFINITY;
    for _ in 0..3 {
        let uploaded = renderer.upload(&bench.scene).wait()?;
        let mut times = [0.0; 2];
        for ms in &mut times {
            let begin = Instant::now();
            renderer.pair(&uploaded, &camera).options(options).trace().wait()?;
            *ms = 1e3 * begin.elapsed().as_secs_f64();
        }
        least = least.min(times[0] - times[1]);
    }
    Ok((work, least))
}

/// Numbers of shadow rays over a pair, the rig, and the pairs of the moving camera.
struct Rays {
    pair: u64,
    rig: u64,
    film: u64,
}

impl Rays {
    fn of(
        renderer: &mut Renderer,
        Case { options, uploaded, .. }: &Case,
        camera: &StereoCamera,
    ) -> Result<Self, Box<dyn Error>> {
        let of_pair = |statistics: &Statistics| statistics.left.rays.shadow + statistics.right.rays.shadow;
        let pair = of_pair(&renderer.pair(uploaded, camera).options(options).trace().wait()?);
        let rig = renderer
            .views(uploaded, &Rig::row(camera.interaxial_pixels(NEIGHBOURS), VIEWS))
            .options(options)
            .read()
            .wait()?;
        let mut film = 0;
        let pose = camera.pose()?;
        for frame in 0..VIEWS {
            // Each step is one interaxial.
            let aside = pose.right * (pose.interaxial * (frame as f32 - 0.5 * VIEWS as f32));
            let eye = pose.eye + aside.as_dvec3();
            let moved = camera.eye(eye).target(eye + (pose.screen_distance * pose.forward).as_dvec3());
            film += of_pair(&renderer.pair(uploaded, &moved).options(options).trace().wait()?);
        }
        Ok(Self { pair, rig: rig.views.iter().map(|view| view.work.rays.shadow).sum(), film })
    }
}

/// Returns the percentage of the pixels of both views whose colours differ.
fn wrong_percent(pair: &StereoPair, truth: &StereoPair) -> f64 {
    let differing = |a: &View, b: &View| a.rgba8.iter().zip(&b.rgba8).filter(|(a, b)| a != b).count();
    let wrong = differing(&pair.left, &truth.left) + differing(&pair.right, &truth.right);
    100.0 * wrong as f64 / (2 * truth.left.rgba8.len()) as f64
}
