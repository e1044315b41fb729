//! One scene: rounds in which every method is timed, then a counting render of each for work and accuracy.

use std::{error::Error, time::Instant};

use stereotrace::{
    Method, Options, Renderer, Statistics, StereoCamera, UploadedScene,
    metrics::{self, Difference},
};

use crate::{obvhs_tracer::ObvhsTracer, options::Plan, scenes::BenchScene};

/// Where naive and ideal stand among the methods.
const NAIVE: usize = 0;
const IDEAL: usize = 1;

/// All figures of a scene.
pub(crate) struct Measured {
    pub(crate) scene: String,
    pub(crate) triangles: usize,
    pub(crate) spheres: usize,
    pub(crate) lights: usize,
    /// Naive first, ideal second.
    pub(crate) methods: Vec<MethodFigures>,
    pub(crate) primary: PrimaryRate,
}

/// What a method costs and how exact it is.
pub(crate) struct MethodFigures {
    pub(crate) method: Method,
    /// All passes of a pair, milliseconds.
    pub(crate) pair_ms: Spread,
    /// The same by the host's clock, which also sees clears, submissions and waits.
    pub(crate) wall_ms: f64,
    /// The left view's pass; without timestamps it is all of `Ideal`'s of the same round.
    pub(crate) left_ms: f64,
    /// (pair - left) / left, median of the rounds.
    pub(crate) second_eye: f64,
    /// Naive pair / pair - 1, of the medians.
    pub(crate) speed_up: f64,
    pub(crate) ratio_to_naive: f64,
    /// Counted, see `Options::counting`.
    pub(crate) statistics: Statistics,
    /// The right view against naive's.
    pub(crate) difference: Difference,
}

/// Primary rays of the left eye, without shading by lights, in millions a second.
pub(crate) struct PrimaryRate {
    pub(crate) device: f64,
    /// obvhs's own traversal of its own tree on all cores.
    pub(crate) obvhs: f64,
    pub(crate) obvhs_threads: usize,
    /// Pixels in which both find the same depth (to 1e-3 of it), percent.
    pub(crate) same_depth_percent: f64,
}

/// Median, least and largest of some repeats.
#[derive(Clone, Copy)]
pub(crate) struct Spread {
    pub(crate) median: f64,
    pub(crate) min: f64,
    pub(crate) max: f64,
}

/// Times of one frame in milliseconds.
#[derive(Clone, Copy)]
struct Sample {
    pair: f64,
    /// `None` where the adapter has no timestamps.
    left: Option<f64>,
    wall: f64,
}

/// A turn in a round.
enum Turn {
    Method(usize),
    DevicePrimary,
    ObvhsPrimary,
}

impl MethodFigures {
    /// The second eye's cost relative to the first's, as counters have it.
    pub(crate) fn second_eye_counters(&self) -> f64 {
        self.statistics.second_eye()
    }

    /// What the counters promise: naive traces two eyes, this method 1 + m (DESIGN, section 7).
    pub(crate) fn speed_up_predicted(&self) -> f64 {
        2.0 / (1.0 + self.second_eye_counters()) - 1.0
    }
}

pub(crate) fn measure(renderer: &mut Renderer, bench: &BenchScene, plan: &Plan) -> Result<Measured, Box<dyn Error>> {
    let BenchScene { name, scene, camera } = bench;
    eprintln!("{name}: {} primitives, {} + {} rounds", scene.primitive_count(), plan.warm_ups, plan.rounds);
    let pose = camera.pose()?;
    let lit = renderer.upload(scene)?;
    let unlit = {
        let mut scene = scene.clone();
        scene.lights.clear();
        renderer.upload(&scene)?
    };
    let obvhs = ObvhsTracer::new(scene);

    let turns: Vec<Turn> =
        (0..plan.methods.len()).map(Turn::Method).chain([Turn::DevicePrimary, Turn::ObvhsPrimary]).collect();
    let mut samples: Vec<Vec<Sample>> = vec![Vec::new(); plan.methods.len()];
    let (mut device_ms, mut obvhs_ms) = (Vec::new(), Vec::new());
    for round in 0..plan.warm_ups + plan.rounds {
        let timed = round >= plan.warm_ups;
        for turn in order(round, turns.len()) {
            match turns[turn] {
                Turn::Method(index) => {
                    let sample = time(renderer, &lit, camera, plan.methods[index])?;
                    samples[index].extend(timed.then_some(sample));
                }
                Turn::DevicePrimary => {
                    let sample = time(renderer, &unlit, camera, Method::Ideal)?;
                    device_ms.extend(timed.then_some(sample.left.unwrap_or(sample.pair)));
                }
                Turn::ObvhsPrimary => {
                    let start = Instant::now();
                    std::hint::black_box(obvhs.depths(&pose));
                    obvhs_ms.extend(timed.then_some(milliseconds(start)));
                }
            }
        }
    }

    let counting = |renderer: &mut Renderer, method| renderer.render(&lit, camera, &Options::new(method).counting());
    let naive = counting(renderer, Method::Naive)?;
    let same = naive.left.depth.iter().zip(obvhs.depths(&pose)).filter(|&(&a, b)| a == b || (a - b).abs() < 1e-3 * a);
    let same_depth_percent = 100.0 * same.count() as f64 / naive.left.depth.len() as f64;
    let mut methods = Vec::new();
    for (index, &method) in plan.methods.iter().enumerate() {
        let pair = counting(renderer, method)?;
        let left = left_times(&samples, index);
        let second_eye = samples[index].iter().zip(&left).map(|(sample, left)| (sample.pair - left) / left);
        let pair_ms = Spread::of(samples[index].iter().map(|sample| sample.pair));
        let naive_ms = Spread::of(samples[NAIVE].iter().map(|sample| sample.pair)).median;
        methods.push(MethodFigures {
            method,
            pair_ms,
            wall_ms: Spread::of(samples[index].iter().map(|sample| sample.wall)).median,
            left_ms: Spread::of(left.iter().copied()).median,
            second_eye: Spread::of(second_eye).median,
            speed_up: naive_ms / pair_ms.median - 1.0,
            ratio_to_naive: pair_ms.median / naive_ms,
            difference: metrics::compare(&pair.right, &naive.right, &pose)?,
            statistics: pair.statistics,
        });
    }
    let rays = naive.left.depth.len() as f64;
    let million_a_second = |times: Vec<f64>| rays / Spread::of(times).median / 1e3;
    Ok(Measured {
        scene: name.clone(),
        triangles: scene.triangles().len(),
        spheres: scene.spheres().len(),
        lights: scene.lights.len(),
        methods,
        primary: PrimaryRate {
            device: million_a_second(device_ms),
            obvhs: million_a_second(obvhs_ms),
            obvhs_threads: rayon::current_num_threads(),
            same_depth_percent,
        },
    })
}

/// The order of a round's turns. The first one rotates, and so does who comes after whom: steps of a number that has
/// no factor in common with `count` visit all of them.
fn order(round: usize, count: usize) -> impl Iterator<Item = usize> {
    let coprime =
        |&step: &usize| (2..=step).all(|factor| !step.is_multiple_of(factor) || !count.is_multiple_of(factor));
    let steps: Vec<usize> = (1..count).filter(coprime).collect();
    let step = steps[round % steps.len()];
    (0..count).map(move |turn| (round + turn * step) % count)
}

/// Renders a frame without reading it back.
fn time(
    renderer: &mut Renderer,
    scene: &UploadedScene,
    camera: &StereoCamera,
    method: Method,
) -> Result<Sample, stereotrace::Error> {
    let start = Instant::now();
    let statistics = renderer.trace(scene, camera, &Options::new(method))?;
    let wall = milliseconds(start);
    let Some(times) = statistics.times else { return Ok(Sample { pair: wall, left: None, wall }) };
    let left = times.0.iter().find(|(pass, _)| *pass == "trace_left").map(|(_, time)| time.as_secs_f64() * 1e3);
    Ok(Sample { pair: times.total().as_secs_f64() * 1e3, left, wall })
}

/// The left view's time in each round: the method's own, or `Ideal`'s where there are no timestamps.
fn left_times(samples: &[Vec<Sample>], index: usize) -> Vec<f64> {
    let ideal = &samples[IDEAL];
    let own = samples[index].iter().zip(ideal).map(|(sample, ideal)| sample.left.unwrap_or(ideal.pair));
    own.collect()
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

impl Spread {
    /// Of at least one value.
    fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let middle = values.len() / 2;
        let median = if values.len() % 2 == 1 { values[middle] } else { values[middle - 1].midpoint(values[middle]) };
        Self { median, min: values[0], max: values[values.len() - 1] }
    }
}
