//! Measures one scene. Every method is timed in each round, and a separate render with counters gives its work and
//! accuracy.

use std::{error::Error, time::Instant};

use stereotrace::{
    Method, Options, Renderer, Statistics, StereoCamera, UploadedScene,
    blocking::Wait,
    camera::HUMAN_INTERAXIAL,
    metrics::{self, Difference},
};

use super::{
    rounds::{Spread, order},
    sampled::Sampled,
    scenes::BenchScene,
};

/// Indices of naive and ideal in the list of methods.
const NAIVE: usize = 0;
const IDEAL: usize = 1;

/// Settings of the measurement, the same for every scene.
#[derive(Debug)]
pub struct Plan {
    pub size: [u32; 2],
    pub e_px: f32,
    /// Whether pairs are equirectangular, with an interaxial in world units instead.
    pub around: bool,
    /// Number of lights to place. With `None`, built-in scenes keep their own lights.
    pub lights: Option<usize>,
    pub sampled: Sampled,
    /// Compared methods. Naive is the first and ideal the second, since the others are compared with them.
    pub methods: Vec<Method>,
    pub warm_ups: usize,
    pub rounds: usize,
}

/// All figures of a scene.
pub struct Measured {
    pub scene: String,
    pub triangles: usize,
    pub spheres: usize,
    pub lights: usize,
    /// Figures of each method; naive is the first and ideal the second.
    pub methods: Vec<MethodFigures>,
}

/// Cost and accuracy of a method.
pub struct MethodFigures {
    pub method: Method,
    /// Total time of a pair's passes in milliseconds.
    pub pair_ms: Spread,
    /// Time of a pair by the host's clock in milliseconds. It includes clears, submissions and waits.
    pub wall_ms: f64,
    /// Time of the left view's pass. Without timestamps, the time of `Ideal`'s pair in the same round is used.
    pub left_ms: f64,
    /// Median time of each pass in milliseconds, in their order; empty without timestamps.
    pub passes: Vec<(&'static str, f64)>,
    /// Cost of the second eye, from times: (pair - left) / left.
    pub second_eye: Spread,
    /// Speed-up over naive: naive's pair time / this pair time - 1, from the medians.
    pub speed_up: f64,
    pub ratio_to_naive: f64,
    /// Counters of the method's work, see `Options::count`.
    pub statistics: Statistics,
    /// Difference of the right view from naive's.
    pub difference: Difference,
}

/// Times of one frame in milliseconds.
#[derive(Clone)]
struct Sample {
    pair: f64,
    /// Time of the left view's pass, or `None` if the adapter has no timestamps.
    left: Option<f64>,
    passes: Vec<(&'static str, f64)>,
    wall: f64,
}

impl MethodFigures {
    /// Returns the second eye's cost relative to the first eye's, in counted box and primitive tests.
    pub fn second_eye_counters(&self) -> f64 {
        self.statistics.second_eye()
    }

    /// Returns the speed-up that the counters predict. Naive costs two eyes, and this method 1 + m eyes (DESIGN,
    /// section 7).
    pub fn speed_up_predicted(&self) -> f64 {
        2.0 / (1.0 + self.second_eye_counters()) - 1.0
    }
}

impl Plan {
    /// Returns the eyes' distance as text.
    pub fn eyes(&self) -> String {
        if self.around { format!("all around, e = {HUMAN_INTERAXIAL}") } else { format!("e = {} px", self.e_px) }
    }
}

pub fn measure(renderer: &mut Renderer, bench: &BenchScene, plan: &Plan) -> Result<Measured, Box<dyn Error>> {
    let BenchScene { name, scene, camera } = bench;
    eprintln!("{name}: {} primitives, {} + {} rounds", scene.primitive_count(), plan.warm_ups, plan.rounds);
    let pose = camera.pose()?;
    let lit = renderer.upload(scene).wait()?;
    let mut samples: Vec<Vec<Sample>> = vec![Vec::new(); plan.methods.len()];
    for round in 0..plan.warm_ups + plan.rounds {
        let timed = round >= plan.warm_ups;
        for index in order(round, plan.methods.len()) {
            let options = plan.sampled.options(plan.methods[index]);
            let sample = time(renderer, &lit, camera, &options)?;
            samples[index].extend(timed.then_some(sample));
        }
    }

    let counting = |renderer: &mut Renderer, method| {
        renderer.pair(&lit, camera).options(&plan.sampled.options(method).count(true)).read().wait()
    };
    let naive = counting(renderer, Method::Naive)?;
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
            passes: pass_medians(&samples[index]),
            left_ms: Spread::of(left.iter().copied()).median,
            second_eye: Spread::of(second_eye),
            speed_up: naive_ms / pair_ms.median - 1.0,
            ratio_to_naive: pair_ms.median / naive_ms,
            difference: metrics::compare(&pair.right, &naive.right, &pose)?,
            statistics: pair.statistics,
        });
    }
    Ok(Measured {
        scene: name.clone(),
        triangles: scene.triangles().len(),
        spheres: scene.spheres().len(),
        lights: scene.lights.len(),
        methods,
    })
}

/// Renders a frame without reading it back, and returns its times.
fn time(
    renderer: &mut Renderer,
    scene: &UploadedScene,
    camera: &StereoCamera,
    options: &Options,
) -> Result<Sample, stereotrace::Error> {
    let start = Instant::now();
    let statistics = renderer.pair(scene, camera).options(options).trace().wait()?;
    let wall = milliseconds(start);
    let Some(times) = statistics.times else { return Ok(Sample { pair: wall, left: None, passes: Vec::new(), wall }) };
    let passes: Vec<_> = times.passes.iter().map(|(pass, time)| (*pass, time.as_secs_f64() * 1e3)).collect();
    let left = passes.iter().find(|(pass, _)| *pass == "trace_left").map(|(_, time)| *time);
    Ok(Sample { pair: times.total().as_secs_f64() * 1e3, left, passes, wall })
}

/// Returns the median time of each pass over the rounds.
fn pass_medians(samples: &[Sample]) -> Vec<(&'static str, f64)> {
    let names = samples[0].passes.iter().map(|(name, _)| *name);
    let of = |name| samples.iter().flat_map(move |sample| &sample.passes).filter(move |(pass, _)| *pass == name);
    names.map(|name| (name, Spread::of(of(name).map(|(_, time)| *time)).median)).collect()
}

/// Returns the left view's time in each round. Without timestamps, the time of `Ideal`'s pair is used.
fn left_times(samples: &[Vec<Sample>], index: usize) -> Vec<f64> {
    let ideal = &samples[IDEAL];
    let own = samples[index].iter().zip(ideal).map(|(sample, ideal)| sample.left.unwrap_or(ideal.pair));
    own.collect()
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
