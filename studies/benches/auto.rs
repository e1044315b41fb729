//! Measures how well `auto` chooses: `cargo bench -p stereotrace-studies --bench auto` prints a table.
//!
//! Naive, bracket and auto by the constants, by a calibration of the adapter and by a calibration on the scene take
//! turns in one run, with 1 and 5 lights by the library's rule, and with 5 spherical ones. Times are medians of the
//! rounds and cover the passes alone. A loss is the time of auto divided by the time of the faster method, less one.
//! Without names of scenes, all trials of the stability suite and all built-in scenes are measured. `--size=WxH` sets
//! the size of a view, 320x240 by default, and `--point` leaves out the spherical lights.

#[path = "../../benches/common/mod.rs"]
mod common;

use std::{error::Error, time::Instant};

use stereotrace::{
    Builtin, Calibration, Gpu, Light, Method, Options, Renderer, Scene, StereoCamera, UploadedScene, blocking::Wait,
    testing::suite::Trial,
};

use crate::common::{
    options::{is_quick, scenes_named, size},
    provenance::Provenance,
    rounds::{Spread, order},
    scenes::{self, BenchScene},
};

/// Parallax at infinity in pixels, for a picture 600 pixels wide.
const E_PX: f32 = 15.0;

/// Radius of a spherical light, as a share of its distance from the camera.
const RADIUS: f32 = 0.05;

/// How a scene is lit.
#[derive(Clone, Copy, Debug)]
enum Lit {
    Points(usize),
    Spheres(usize),
}

/// What auto chooses by.
const WAYS: [&str; 3] = ["constants", "adapter", "scene"];

fn main() -> Result<(), Box<dyn Error>> {
    let quick = is_quick();
    let rounds = if quick { 1 } else { 3 };
    let argument = |start: &str| std::env::args().find_map(|argument| Some(argument.strip_prefix(start)?.to_owned()));
    let size = argument("--size=").map_or(Ok(if quick { [64, 48] } else { [320, 240] }), |text| size(&text))?;
    let points_alone = std::env::args().any(|argument| argument == "--point");
    let names = Trial::ALL.iter().map(|trial| trial.name()).chain(Builtin::ALL.iter().map(|builtin| builtin.name()));
    let mut names = Vec::from_iter(names);
    names.sort_unstable();
    names.dedup();

    let mut renderer = Renderer::new(Gpu::new().wait()?);
    println!("{}\n", Provenance::of(renderer.gpu()));
    let constants = renderer.calibration();
    let adapter = renderer.calibrate().wait()?;
    let begin = Instant::now();
    let again = renderer.calibrate().wait()?;
    println!("calibration: {adapter:?}, again {again:?} in {:.0} ms\n", 1e3 * begin.elapsed().as_secs_f64());
    println!("{:<24} {:<10} {:>9} {:>9}  loss by {}", "scene", "lights", "naive ms", "of it", WAYS.join(", "));

    let mut losses = [const { Vec::new() }; 3];
    for name in scenes_named(&names) {
        let e_px = E_PX / 600.0 * size[0] as f32;
        let Some(BenchScene { scene, camera, .. }) = scenes::load(&name, size, e_px, None)? else {
            println!("{name}: skipped: scene not found");
            continue;
        };
        for lit in [Lit::Points(1), Lit::Points(5), Lit::Spheres(5)] {
            if points_alone && matches!(lit, Lit::Spheres(_)) {
                continue;
            }
            let [naive, bracket, chosen @ ..] =
                match lit.times(&mut renderer, &scene, &camera, [constants, adapter], rounds) {
                    Ok(times) => times,
                    Err(error) => {
                        println!("{name:<24} {lit:?}: skipped: {error}");
                        continue;
                    }
                };
            let loss = chosen.map(|time| time / naive.min(bracket) - 1.0);
            losses.iter_mut().zip(loss).for_each(|(all, loss)| all.push((loss, format!("{name}, {lit:?}"))));
            let [by_constants, by_adapter, by_scene] = loss.map(|loss| 100.0 * loss);
            let lit = format!("{lit:?}");
            println!(
                "{name:<24} {lit:<10} {naive:>9.2} {:>9.3}  {by_constants:>6.1}% {by_adapter:>6.1}% {by_scene:>6.1}%",
                bracket / naive
            );
        }
    }
    for (way, mut losses) in WAYS.into_iter().zip(losses) {
        losses.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mean = losses.iter().map(|(loss, _)| loss).sum::<f64>() / losses.len().max(1) as f64;
        let above = losses.iter().filter(|(loss, _)| *loss > 0.05).count();
        let worst = losses.iter().take(3).map(|(loss, of)| format!("{of}: {:.1}%", 100.0 * loss));
        let worst = Vec::from_iter(worst).join("; ");
        println!("{way}: mean loss {:.2}%, over 5% in {above} of {}; {worst}", 100.0 * mean, losses.len());
    }
    Ok(())
}

impl Lit {
    /// Returns the scene with these lights.
    fn scene(self, scene: &Scene, camera: &StereoCamera) -> Result<Scene, stereotrace::Error> {
        let (Self::Points(count) | Self::Spheres(count)) = self;
        let mut scene = scene.clone();
        scene.place_lights(count, camera)?;
        if let Self::Spheres(_) = self {
            let eye = camera.pose()?.eye;
            for light in &mut scene.lights {
                let radius = RADIUS * (light.position - eye).length() as f32;
                *light = Light::sphere(light.position, radius, light.intensity);
            }
        }
        Ok(scene)
    }

    /// Returns the times of a pair in milliseconds: by naive, by bracket, and by auto with both calibrations and one on
    /// the scene.
    fn times(
        self,
        renderer: &mut Renderer,
        scene: &Scene,
        camera: &StereoCamera,
        [constants, adapter]: [Calibration; 2],
        rounds: usize,
    ) -> Result<[f64; 5], stereotrace::Error> {
        let uploaded = renderer.upload(&self.scene(scene, camera)?).wait()?;
        renderer.set_calibration(adapter);
        let on_scene = renderer.calibrate_on(&uploaded, camera, &Options::default()).wait()?;
        times(renderer, &uploaded, camera, [constants, adapter, on_scene], rounds)
    }
}

/// Returns the times of a pair in milliseconds: by naive, by bracket, and by auto with each calibration.
fn times(
    renderer: &mut Renderer,
    scene: &UploadedScene,
    camera: &StereoCamera,
    calibrations: [Calibration; 3],
    rounds: usize,
) -> Result<[f64; 5], stereotrace::Error> {
    let [a, b, c] = calibrations.map(Some);
    let turns =
        [(Method::Naive, None), (Method::BRACKET, None), (Method::Auto, a), (Method::Auto, b), (Method::Auto, c)];
    let mut times: [Vec<f64>; 5] = Default::default();
    for round in 0..=rounds {
        for index in order(round, turns.len()) {
            let (method, calibration) = turns[index];
            if let Some(calibration) = calibration {
                renderer.set_calibration(calibration);
            }
            let begin = Instant::now();
            let statistics = renderer.pair(scene, camera).options(&Options::new(method)).trace().wait()?;
            let time = statistics.times.map_or(begin.elapsed(), |times| times.total());
            if round > 0 {
                times[index].push(1e3 * time.as_secs_f64());
            }
        }
    }
    Ok(times.map(|times| Spread::of(times).median))
}
