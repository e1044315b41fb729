//! Measures the first eye's cost with each feature that improves pictures, and the second eye's cost then: `cargo bench
//! --bench finish`.
//!
//! Naive, ideal (whose time is the first eye's) and bracket take turns in one run. Times are medians of the rounds and
//! cover the passes alone. Counts and colours are taken from one frame each. A table is printed. `finish.csv`,
//! `finish.json` and `finish.svg` are either all written, or none. The chart shows the second eye's accuracy and the
//! first eye's cost against the second eye's cost. `cargo bench -p stereotrace-studies --bench finish -- NAME…` selects
//! other scenes: built-in ones, folders of OBJ files, or paths of .obj, .gltf, .glb or .ply files.

mod chart;
#[path = "../../../benches/common/mod.rs"]
mod common;
mod finishes;

use std::error::Error;

use serde_json::json;
use stereotrace::{Gpu, Method, Renderer, blocking::Wait, metrics::compare};

use crate::{
    common::{
        files::save,
        options::{is_quick, scenes_named},
        provenance::Provenance,
        records::{self, Record},
        rounds::{Spread, order},
        scenes::{self, BenchScene},
    },
    finishes::{Finished, finishes},
};

/// Parallax at infinity in pixels, for a picture 600 pixels wide.
const E_PX: f32 = 15.0;
/// Compared methods. The first is the ground truth. The second renders the first eye and copies its picture.
const METHODS: [Method; 3] = [Method::Naive, Method::Ideal, Method::BRACKET];

/// Figures of one variant of a scene.
struct Figures {
    scene: String,
    finish: &'static str,
    /// Time of the first eye in milliseconds, and its ratio to the time of the same scene without lights.
    first_ms: f64,
    first: Spread,
    naive_ms: f64,
    pair_ms: f64,
    /// Cost of the second eye relative to the first, from times and from counted box and primitive tests.
    second: Spread,
    second_counters: f64,
    /// Difference of the right view from naive's: percentage of differing pixels, and mean RGB distance of all pixels.
    differing: f64,
    distance: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let quick = is_quick();
    let (side, rounds) = if quick { (40, 1) } else { (400, 3) };
    let names = scenes_named(&["hall", "sponza_4x"]);
    let gpu = Gpu::new().wait()?;
    let provenance = Provenance::of(&gpu);
    println!("{provenance}\n");
    println!("{side}x{side}, {rounds} rounds\n");
    println!(
        "| scene | picture | first eye ms | of it without lights | naive pair ms | bracket pair ms | ratio | second \
        eye by time | by counters | \
         pixels that differ % | mean distance in RGB |\n|---|---|---|---|---|---|---|---|---|---|---|"
    );
    let mut renderer = Renderer::new(gpu);
    let mut all = Vec::new();
    for name in &names {
        let Some(scene) = scenes::load(name, [side; 2], E_PX * side as f32 / 600.0, None)? else {
            println!("{}", scenes::skipped(name));
            continue;
        };
        let mut plain_ms = 0.0;
        for finished in finishes(&scene)? {
            let figures = measure(&mut renderer, &scene, &finished, rounds, plain_ms)?;
            if plain_ms == 0.0 {
                plain_ms = figures.first_ms;
            }
            println!("{}", row(&figures));
            all.push(figures);
        }
    }
    let target = common::files::root().join("target");
    let folder = target.join(if quick { "bench-smoke/finish" } else { "bench/finish" });
    let records: Vec<Record> = all.iter().map(|figures| record(figures, &provenance)).collect();
    let files = [
        ("finish.csv", records::csv(&records)),
        ("finish.json", records::json(&records)),
        ("finish.svg", chart::svg(&all, side, &provenance)?),
    ];
    println!();
    for path in save(&files.map(|(name, text)| (name.to_owned(), text)), &folder)? {
        println!("wrote {}", path.display());
    }
    Ok(())
}

/// Measures a variant. `plain_ms` is the first eye's time without lights, or 0 if this is the variant without lights.
fn measure(
    renderer: &mut Renderer,
    bench: &BenchScene,
    finished: &Finished,
    rounds: usize,
    plain_ms: f64,
) -> Result<Figures, Box<dyn Error>> {
    let BenchScene { name, camera, .. } = bench;
    let uploaded = renderer.upload(&finished.scene).wait()?;
    let options = |method| finished.options.clone().method(method);
    let mut times = METHODS.map(|_| Vec::new());
    // The first round compiles kernels.
    for round in 0..=rounds {
        for index in order(round, METHODS.len()) {
            let statistics = renderer.pair(&uploaded, camera).options(&options(METHODS[index])).trace().wait()?;
            let total = statistics.times.ok_or("this adapter has no timestamps")?.total().as_secs_f64();
            times[index].extend((round > 0).then_some(1e3 * total));
        }
    }
    // The second eye's cost is computed in each round.
    let second = Spread::of(times[1].iter().zip(&times[2]).map(|(first, pair)| (pair - first) / first));
    let [naive_ms, first, pair_ms] = times.map(Spread::of);
    let [naive_ms, first_ms, pair_ms] = [naive_ms, first, pair_ms].map(|spread| spread.median);
    let mut counted = |method| renderer.pair(&uploaded, camera).options(&options(method).count(true)).read().wait();
    let (naive, pair) = (counted(Method::Naive)?, counted(Method::BRACKET)?);
    let difference = compare(&pair.right, &naive.right, &pair.pose)?;
    Ok(Figures {
        scene: name.clone(),
        finish: finished.name,
        first_ms,
        first: first.over(if plain_ms > 0.0 { plain_ms } else { first_ms }),
        naive_ms,
        pair_ms,
        second,
        second_counters: pair.statistics.second_eye(),
        differing: difference.differing_percent,
        distance: difference.mean_difference * difference.differing_percent / 100.0,
    })
}

fn row(figures: &Figures) -> String {
    let Figures { scene, finish, first_ms, first, naive_ms, pair_ms, second, second_counters, differing, distance } =
        figures;
    format!(
        "| {} | {finish} | {first_ms:.1} | {:.1} | {naive_ms:.1} | {pair_ms:.1} | {:.2} | {:.2} | {second_counters:.3} \
         | {differing:.3} | {distance:.4} |",
        scenes::title(scene),
        first.median,
        naive_ms / pair_ms,
        second.median,
    )
}

fn record(figures: &Figures, provenance: &Provenance) -> Record {
    vec![
        ("scene", json!(figures.scene)),
        ("picture", json!(figures.finish)),
        ("first_ms", json!(figures.first_ms)),
        ("first_of_plain", json!(figures.first.median)),
        ("naive_ms", json!(figures.naive_ms)),
        ("pair_ms", json!(figures.pair_ms)),
        ("second_eye", json!(figures.second.median)),
        ("second_eye_min", json!(figures.second.min)),
        ("second_eye_max", json!(figures.second.max)),
        ("second_eye_counters", json!(figures.second_counters)),
        ("differing", json!(figures.differing)),
        ("mean_distance", json!(figures.distance)),
        ("adapter", json!(provenance.adapter)),
        ("driver", json!(provenance.driver)),
        ("commit", json!(provenance.commit)),
        ("date", json!(provenance.date)),
    ]
}
