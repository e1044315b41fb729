//! The thesis's benchmarks (Al-Hagri 2012, chapter 5) and their report in one program: `cargo bench -p
//! stereotrace-studies --bench thesis`.
//!
//! Picture size, interaxial and number of lights are varied, and accuracy is measured in each case. The quick profile
//! takes some minutes on two cores; `--full` measures all of the thesis's steps. Results are saved after every
//! configuration, and an interrupted run continues from there. The output is results.json, results.csv, one SVG per
//! plot and report.html.

#[path = "../../../benches/common/mod.rs"]
mod common;
mod pictures;
mod record;
mod report;

use std::{
    error::Error,
    fs,
    num::NonZeroU32,
    path::{Path, PathBuf},
    process::ExitCode,
};

use clap::Parser;
use stereotrace::{BufferDepth, Check, Gpu, Method, Renderer, blocking::Wait};

use crate::{
    common::{
        files::save,
        measure::{self, Measured, MethodFigures, Plan},
        provenance::Provenance,
        sampled::Sampled,
        scenes,
    },
    record::Record,
    report::{Content, Stability},
};

/// The thesis's scenes, or the available substitutes. scenes/README.md and studies/THESIS.md compare them with the
/// thesis's own.
const SCENES: [&str; 5] = ["spheres", "spheres-turned", "sponza_4x", "buddha_1m2", "dragon"];
/// Built-in scenes that show the sources of right pixels, with the size and interaxial of their pictures.
const SHOWN: [&str; 2] = ["spheres", "hall"];
const SHOWN_SIZE: [u32; 2] = [480, 300];
const SHOWN_E_PX: f32 = 12.0;
/// Scene of the sweeps over interaxial and lights.
const SWEPT: &str = "dragon";
/// Picture size, interaxial in pixels and number of lights, where they are not swept.
const SIZE: u32 = 600;
const E_PX: f32 = 15.0;
const LIGHTS: usize = 5;
/// File from which an interrupted run continues.
const RESULTS: &str = "results.json";

/// Runs the thesis's benchmarks and writes their report.
#[derive(Parser, Debug)]
#[command(name = "cargo bench -p stereotrace-studies --bench thesis --")]
struct Arguments {
    /// All of the thesis's steps, which take hours on a CPU
    #[arg(long, conflicts_with = "smoke")]
    full: bool,
    /// Smoke run with meaningless figures: 64x64, the spheres
    #[arg(long)]
    smoke: bool,
    /// Start anew and discard earlier results
    #[arg(long)]
    fresh: bool,
    /// Folder for the results [default: target/bench/thesis, target/bench/thesis-full or target/bench-smoke/thesis]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Passed by cargo when it benchmarks; without it this is a smoke run
    #[arg(long, hide = true)]
    bench: bool,
}

/// One step of a sweep.
struct Step {
    suite: &'static str,
    scene: &'static str,
    width: u32,
    e_px: f32,
    /// Number of lights; `None` for the scene's own five.
    lights: Option<usize>,
    methods: Vec<Method>,
}

fn main() -> ExitCode {
    common::exit::status(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let smoke = arguments.smoke || !arguments.bench;
    let target = common::files::root().join("target");
    let standard = match (smoke, arguments.full) {
        (true, _) => "bench-smoke/thesis",
        (_, true) => "bench/thesis-full",
        _ => "bench/thesis",
    };
    let folder = arguments.out.clone().unwrap_or_else(|| target.join(standard));
    let stability = Stability::read(&target.join("bench/stability"))?;
    let mut renderer = Renderer::new(Gpu::new().wait()?);
    let provenance = Provenance::of(renderer.gpu());
    let results = folder.join(RESULTS);
    let mut records = if arguments.fresh || smoke { Vec::new() } else { earlier(&results, &provenance)? };
    let (steps, rounds) = match (smoke, arguments.full) {
        (true, _) => (smoke_steps(), 1),
        (_, true) => (steps(true), 7),
        _ => (steps(false), 5),
    };
    measure_steps(&mut renderer, &steps, rounds, &provenance, &mut records, &folder)?;
    save(&[("results.csv".into(), csv(&records)?)], &folder)?;
    let side = if smoke { 64 } else { 400 };
    let names: Vec<&str> =
        SCENES.into_iter().filter(|name| records.iter().any(|record| record.scene == *name)).collect();
    let pictures = pictures::of(&mut renderer, &names, side, E_PX * side as f32 / SIZE as f32)?;
    let shrink = if smoke { 5 } else { 1 };
    let size = SHOWN_SIZE.map(|side| side / shrink);
    let sources = pictures::sources(&mut renderer, &SHOWN, size, SHOWN_E_PX / shrink as f32)?;
    println!("wrote {}", results.display());
    records.extend(errors(&records));
    for path in report::write(&Content { records, pictures, sources, stability, smoke }, &folder)? {
        println!("wrote {}", path.display());
    }
    Ok(())
}

/// Measures the steps that have no records yet, and saves all records after each step.
fn measure_steps(
    renderer: &mut Renderer,
    steps: &[Step],
    rounds: usize,
    provenance: &Provenance,
    records: &mut Vec<Record>,
    folder: &Path,
) -> Result<(), Box<dyn Error>> {
    let mut missing = Vec::new();
    for (index, step) in steps.iter().enumerate() {
        let done = |method: &Method| records.iter().any(|record| is_of(record, step, *method));
        if missing.contains(&step.scene) || step.methods.iter().all(done) {
            continue;
        }
        let Some(scene) = scenes::load_thesis(step.scene, [step.width; 2], step.e_px, step.lights)? else {
            println!("{}", scenes::skipped(step.scene));
            missing.push(step.scene);
            continue;
        };
        println!(
            "{}/{}: {} of {}, {}x{}, e = {} px",
            index + 1,
            steps.len(),
            step.suite,
            step.scene,
            step.width,
            step.width,
            step.e_px
        );
        let plan = Plan {
            size: [step.width; 2],
            around: false,
            e_px: step.e_px,
            lights: step.lights,
            sampled: Sampled::default(),
            methods: step.methods.clone(),
            warm_ups: 1,
            rounds,
        };
        let measured = measure::measure(renderer, &scene, &plan)?;
        records.retain(|record| !step.methods.iter().any(|method| is_of(record, step, *method)));
        records.extend(measured.methods.iter().map(|figures| record(step, &measured, figures, &plan, provenance)));
        save(&[(RESULTS.into(), serde_json::to_string_pretty(&records)?)], folder)?;
    }
    Ok(())
}

fn buffer(slots: u32) -> Method {
    let slots = NonZeroU32::new(slots).expect("a buffer has slots");
    Method::Buffer(BufferDepth::Fixed(slots), Check::All)
}

/// Returns the methods of every step: the thesis's, and this project's own.
fn main_methods() -> Vec<Method> {
    let thesis = [Method::Naive, Method::Ideal, Method::ATOMIC, Method::BUFFER, Method::ES_ISLER];
    thesis.into_iter().chain([Method::BRACKET, Method::VERIFIED]).collect()
}

/// Returns the main methods and their variants.
fn all_methods() -> Vec<Method> {
    let edges = Method::Atomic(Check::Edges);
    let twice = Method::Buffer(BufferDepth::TwiceInteraxial, Check::All);
    let mut methods = main_methods();
    methods.extend([buffer(2), buffer(4), buffer(8), twice, Method::ADELSON_HODGES, edges]);
    methods
}

fn steps(full: bool) -> Vec<Step> {
    let sizes: Vec<u32> = if full { (200..=1600).step_by(50).collect() } else { vec![200, 400, 600, 1000] };
    let distances: Vec<f32> =
        if full { (1..=10).map(|e| 10.0 * e as f32).collect() } else { vec![10.0, 15.0, 30.0, 60.0, 100.0] };
    let lights: Vec<usize> = if full { (1..=10).collect() } else { vec![1, 5, 10] };
    let step = |suite, scene, width, e_px, lights, methods| Step { suite, scene, width, e_px, lights, methods };
    let by_size = SCENES.into_iter().flat_map(|scene| sizes.iter().map(move |&width| (scene, width)));
    let dimensions = by_size.map(|(scene, width)| {
        step("dimensions", scene, width, E_PX, None, if width == SIZE { all_methods() } else { main_methods() })
    });
    let interaxial = distances.iter().map(|&e_px| step("interaxial", SWEPT, SIZE, e_px, None, all_methods()));
    let lights = lights.iter().map(|&count| step("lights", SWEPT, SIZE, E_PX, Some(count), main_methods()));
    dimensions.chain(interaxial).chain(lights).collect()
}

fn smoke_steps() -> Vec<Step> {
    let step = |suite| Step { suite, scene: SCENES[0], width: 64, e_px: 2.0, lights: None, methods: all_methods() };
    ["dimensions", "interaxial", "lights"].map(step).into()
}

/// Returns the records of the thesis's error benchmarks. They repeat the other records of the scene that the thesis
/// shows.
fn errors(records: &[Record]) -> Vec<Record> {
    let suites = [("dimensions", "mse-dimensions"), ("interaxial", "mse-interaxial")];
    let of = |(from, to): (&'static str, &str)| {
        let to = to.to_owned();
        let found = records.iter().filter(move |record| record.suite == from && record.scene == SWEPT);
        found.map(move |record| Record { suite: to.clone(), ..record.clone() })
    };
    suites.into_iter().flat_map(of).collect()
}

fn is_of(record: &Record, step: &Step, method: Method) -> bool {
    (record.suite.as_str(), record.scene.as_str(), record.width, record.e_px, record.lights, &record.method)
        == (step.suite, step.scene, step.width, step.e_px, step.lights.unwrap_or(LIGHTS), &method.to_string())
}

/// Returns the records of an interrupted run.
fn earlier(path: &Path, provenance: &Provenance) -> Result<Vec<Record>, Box<dyn Error>> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(format!("{}: {error}", path.display()).into()),
    };
    let records: Vec<Record> = serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    let other =
        records.iter().find(|record| (&record.adapter, &record.commit) != (&provenance.adapter, &provenance.commit));
    match other {
        Some(record) => Err(format!(
            "{} has results of {} at commit {}; give another --out, or --fresh to replace them",
            path.display(),
            record.adapter,
            record.commit
        )
        .into()),
        None => Ok(records),
    }
}

fn record(step: &Step, measured: &Measured, figures: &MethodFigures, plan: &Plan, provenance: &Provenance) -> Record {
    let (statistics, difference) = (&figures.statistics, &figures.difference);
    let pixels = f64::from(plan.size[0]) * f64::from(plan.size[1]);
    let pass = |name: &str| figures.passes.iter().find(|(pass, _)| *pass == name).map(|(_, ms)| *ms);
    let both = |count: fn(&stereotrace::Work) -> u64| count(&statistics.left) + count(&statistics.right);
    let slots_ms = pass("reproject_slots").zip(pass("gather_slots")).map(|(store, search)| store + search);
    Record {
        suite: step.suite.into(),
        scene: measured.scene.clone(),
        triangles: measured.triangles,
        spheres: measured.spheres,
        method: figures.method.to_string(),
        width: plan.size[0],
        height: plan.size[1],
        e_px: plan.e_px,
        lights: measured.lights,
        rounds: plan.rounds,
        left_ms: figures.left_ms,
        pair_ms: figures.pair_ms.median,
        pair_ms_min: figures.pair_ms.min,
        pair_ms_max: figures.pair_ms.max,
        fps: 1e3 / figures.pair_ms.median,
        second_eye: figures.second_eye.median,
        second_eye_counters: figures.second_eye_counters(),
        speed_up: figures.speed_up,
        speed_up_counters: figures.speed_up_predicted(),
        identical: difference.identical_percent,
        differing: difference.differing_percent,
        wrong_surface: difference.wrong_surface_percent,
        identical_of_surfaces: difference.identical_of_surfaces_percent,
        wrong_of_surfaces: difference.wrong_of_surfaces_percent,
        mean_difference: difference.mean_difference,
        mse: difference.mse,
        psnr: difference.psnr.is_finite().then_some(difference.psnr),
        rays_primary: both(|work| work.rays.primary),
        rays_verification: both(|work| work.rays.verification),
        rays_shadow: both(|work| work.rays.shadow),
        nodes: both(|work| work.nodes),
        primitive_tests: both(|work| work.primitive_tests),
        retraced: statistics.retraced_share(),
        bad: statistics.bad,
        missed: statistics.missed,
        lost_candidates: statistics.lost_candidates,
        buffer_depth: statistics.buffer_depth,
        slot_ns: slots_ms.map(|ms| ms * 1e6 / pixels / f64::from(statistics.buffer_depth.max(1))),
        intermediate_bytes_per_pixel: statistics.intermediate_bytes as f64 / pixels,
        passes_ms: figures.passes.iter().map(|(name, ms)| ((*name).to_owned(), *ms)).collect(),
        adapter: provenance.adapter.clone(),
        driver: provenance.driver.clone(),
        commit: provenance.commit.clone(),
        date: provenance.date.clone(),
    }
}

/// Formats records as CSV, one per line. Passes are only in results.json.
fn csv(records: &[Record]) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    for (index, record) in records.iter().enumerate() {
        let serde_json::Value::Object(mut fields) = serde_json::to_value(record)? else { continue };
        fields.remove("passes_ms");
        if index == 0 {
            text += &(fields.keys().cloned().collect::<Vec<_>>().join(",") + "\n");
        }
        let cells = fields.values().map(|value| if value.is_null() { String::new() } else { value.to_string() });
        text += &(cells.collect::<Vec<_>>().join(",") + "\n");
    }
    Ok(text)
}
