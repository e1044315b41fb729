//! Measures savings by time. Methods take turns in one run, and times cover the passes alone.

use std::time::Instant;

use stereotrace::{Error, Method, Options, Renderer, Scene, StereoCamera, blocking::Wait, scene::builtin::Builtin};

use crate::{
    common::rounds::{Spread, order},
    groups::lit,
    options::Plan,
    rows::{Claim, Row, Setting, Values},
};

/// Compared methods. Naive is the first, since savings are relative to it.
const METHODS: [Method; 5] = [Method::Naive, Method::ADELSON_HODGES, Method::ES_ISLER, Method::ATOMIC, Method::BRACKET];

/// Measures the first random scene of 20 objects. Rows contain the time saved on the second view, and the time of a
/// pair with nine samples per pixel relative to one sample.
pub(crate) fn rows(renderer: &mut Renderer, plan: &Plan) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for &lights in &plan.lights {
        let scene = lit(&Builtin::Random20.scene(), lights);
        for e_px in plan.e_px {
            eprintln!("times: e = {e_px} px, {lights} of its lights");
            let camera = Builtin::Random20.camera(plan.side, plan.side).interaxial_pixels(e_px);
            let one = of_samples(renderer, &scene, &camera, 1, plan.rounds)?;
            let nine = of_samples(renderer, &scene, &camera, 9, plan.rounds.div_ceil(2))?;
            let row = |figure, paper, samples, method: Method, value: f64| Row {
                claim: Claim { place: "by time", figure, paper },
                setting: Setting {
                    scene: "20 objects, the first".into(),
                    e_px,
                    lights,
                    samples,
                    method: method.to_string(),
                },
                values: Values::of(&[value]),
            };
            for (index, &method) in METHODS.iter().enumerate() {
                for (times, paper, samples) in [(&one, "84", 1), (&nine, "almost 80", 9)] {
                    // Times are relative to naive's pair of the same round, since the machine's other load changes
                    // between rounds.
                    let saved = Spread::of(times.iter().map(|round| 100.0 * (2.0 - 2.0 * round[index] / round[0])));
                    if method != Method::Naive {
                        rows.push(row("saved of the second view's time, %", paper, samples, method, saved.median));
                    }
                }
                let [one, nine] = [&one, &nine].map(|times| Spread::of(times.iter().map(|round| round[index])).median);
                rows.push(row("time of nine samples over that of one", "3.69", 9, method, nine / one));
            }
        }
    }
    rows.sort_by_key(|row| (row.claim.figure, row.setting.samples));
    Ok(rows)
}

/// Returns a pair's time by each method in each round, in milliseconds.
fn of_samples(
    renderer: &mut Renderer,
    scene: &Scene,
    camera: &StereoCamera,
    samples: u32,
    rounds: usize,
) -> Result<Vec<[f64; METHODS.len()]>, Error> {
    let uploaded = renderer.upload(scene).wait()?;
    let mut times = vec![[0.0; METHODS.len()]; rounds + 1];
    for (round, times) in times.iter_mut().enumerate() {
        for index in order(round, METHODS.len()) {
            let options = Options::new(METHODS[index]).samples(samples).jitter(false);
            let start = Instant::now();
            let passes = renderer.pair(&uploaded, camera).options(&options).trace().wait()?.times;
            // Without timestamps the host's clock is used.
            let total = passes.map_or_else(|| start.elapsed(), |passes| passes.total());
            times[index] = total.as_secs_f64() * 1e3;
        }
    }
    times.remove(0); // the first round warms up
    Ok(times)
}
