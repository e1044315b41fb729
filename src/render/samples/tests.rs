//! Compares unfiltered samples with the CPU reference and with `Naive`.

use crate::blocking::Wait;
use glam::Vec3;

use super::*;
use crate::{
    FAR, Gpu, Material, Mesh, Method, PixelSource, Scene, ShadowReuse, Sphere, StereoCamera, ViewRows,
    random::Random,
    testing::cpu::{self, Eye, bracket, reproject::reproject, resolve_right::resolve_right, trace_left::trace_left},
    testing::suite::Trial,
    view::rig::Eyes,
};

fn renderer() -> Renderer {
    let mut renderer = Renderer::new(Gpu::under_test());
    // Even small pictures have several bands.
    renderer.band_pixels = 64 * 64;
    renderer
}

/// Returns triangles and spheres in the unit cube, each with its own colour and unlit, so that a colour identifies the
/// hit.
fn colored(seed: u32, triangles: usize, balls: usize) -> Scene {
    let mut random = Random::new(seed);
    let mut scene = Scene::new();
    for index in 0..triangles + balls {
        let albedo = 0.5 + 0.4 * random.point(1.0);
        let material = scene.add_material(Material::new(albedo));
        let middle = random.point(1.0);
        if index < triangles {
            let corners = vec![middle, middle + random.point(0.5), middle + random.point(0.5)];
            scene.add_mesh(&Mesh::new(corners, vec![[0, 1, 2]]).materials(vec![material])).unwrap();
        } else {
            scene.add_sphere(Sphere::new(middle, random.between(0.02, 0.3), material)).unwrap();
        }
    }
    scene
}

fn camera(width: u32, height: u32) -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.3, 0.4, 3.0), Vec3::ZERO)
        .size(width, height)
        .vertical_fov_degrees(50.0)
        .screen_distance(3.0)
        .interaxial_pixels(width as f32 / 12.0)
}

/// Returns the jittered samples of all views, `side` per side of a pixel, whether traced or reused.
fn samples(renderer: &mut Renderer, scene: &Scene, eyes: &Eyes, side: u32, options: &Options) -> Vec<ViewRows> {
    let uploaded = renderer.upload(scene).wait().unwrap();
    let finer = eyes.with_samples(side).unwrap();
    let options = Options { samples: side * side, jitter: true, linear: true, ..options.clone() };
    let mut views = vec![ViewRows::new(finer.pose.size[0]); eyes.sources.len()];
    let mut keep = |rows: Rows| {
        views.iter_mut().zip(rows.views).for_each(|(view, rows)| view.append(rows));
        Ok(())
    };
    let mut go_on = |_| ControlFlow::Continue(());
    pollster::block_on(renderer.frame(&uploaded, &finer, &options, Wanted::all(true), &mut go_on, &mut keep)).unwrap();
    views
}

/// Returns the hits of samples, in the form of the CPU reference.
fn hits(rows: &ViewRows) -> Vec<(f32, u32)> {
    rows.view.depth.iter().map(|depth| depth.min(FAR)).zip(rows.view.primitive.iter().copied()).collect()
}

#[test]
fn jittered_samples_hit_what_plain_rust_hits_and_land_where_a_sequential_sweep_puts_them() {
    let mut renderer = renderer();
    let exact = renderer.gpu.is_exact();
    let scenes = [colored(1, 120, 0), colored(2, 0, 40), colored(3, 60, 20)];
    for (scene, (side, seed)) in scenes.iter().zip([(2, 0), (3, 5), (4, 77)]) {
        // Tests both directions: an eye on the right, and an eye on the left.
        for offsets in [[-0.5, 0.5], [0.5, -0.5]] {
            let pose = camera(33, 25).pose().unwrap();
            let eyes = Eyes { offsets: offsets.to_vec(), ..Eyes::pair(&pose) };
            let options = |method| Options::new(method).seed(seed);
            let frame = eyes.with_samples(side).unwrap().cpu_frame(1).jittered(side, seed);
            let twins = [Eye::Left, Eye::Right].map(|eye| trace_left(scene, &frame, eye));
            let naive = samples(&mut renderer, scene, &eyes, side, &options(Method::Naive));
            let allowed = if exact { 0 } else { twins[0].len() / 500 };
            let differing = |found: &[(f32, u32)], twin: &[(f32, u32)]| {
                let differs = |(a, b): &(&(f32, u32), &(f32, u32))| (exact && a != b) || (a.0 - b.0).abs() > 1e-5 * b.0;
                found.iter().zip(twin).filter(differs).count()
            };
            for (view, twin) in naive.iter().zip(&twins) {
                assert!(differing(&hits(view), twin) <= allowed, "{side} {offsets:?}");
            }
            // Without jitter the picture differs.
            let still = trace_left(scene, &eyes.with_samples(side).unwrap().cpu_frame(1), Eye::Left);
            assert!(differing(&still, &twins[0]) > still.len() / 20);

            let depths = Vec::from_iter(twins[0].iter().map(|(depth, _)| *depth));
            let keys = reproject(&frame, &depths);
            let fates = resolve_right(scene, &frame, &twins[0], &keys);
            let atomic = samples(&mut renderer, scene, &eyes, side, &options(Method::ATOMIC));
            assert_fates(&atomic[1].source, &fates, allowed, "atomic");
            let bounds = bracket::wide_bounds(&frame, &bracket::tile_bounds(&frame, &depths));
            let fates = bracket::sources(&frame, &bounds, &twins[1]);
            let resolved = samples(&mut renderer, scene, &eyes, side, &options(Method::BRACKET));
            assert_fates(&resolved[1].source, &fates, allowed, "bracket");
            assert!(differing(&hits(&resolved[1]), &twins[1]) <= allowed);
        }
    }
}

fn assert_fates(found: &[PixelSource], expected: &[PixelSource], allowed: usize, what: &str) {
    assert_eq!(found.len(), expected.len());
    let wrong = found.iter().zip(expected).filter(|(found, expected)| found != expected).count();
    assert!(wrong <= allowed, "{what}: {wrong} of {} samples came about otherwise", found.len());
}

#[test]
fn jittered_shadow_bits_are_taken_over_as_plain_rust_does() {
    let mut renderer = renderer();
    if !renderer.gpu.is_exact() {
        return;
    }
    let (side, seed) = (3, 9);
    let mut scene = colored(4, 60, 10);
    scene.place_lights(3, &camera(33, 25)).unwrap();
    let eyes = Eyes::pair(&camera(33, 25).pose().unwrap());
    let frame = eyes.with_samples(side).unwrap().cpu_frame(1).jittered(side, seed);
    let [left, right] = [Eye::Left, Eye::Right].map(|eye| trace_left(&scene, &frame, eye));
    for (reuse, method) in [(ShadowReuse::Two, Method::BRACKET), (ShadowReuse::Block, Method::VERIFIED)] {
        let found = samples(&mut renderer, &scene, &eyes, side, &Options::new(method).seed(seed));
        let expected = bracket::shadow_sources(&scene, &[(&frame, &left)], &right, reuse);
        let wrong = found[1].shadow_source.iter().zip(&expected).filter(|(a, b)| a != b).count();
        assert_eq!(wrong, 0, "{method}: of {}", expected.len());
        let taken = expected.iter().filter(|source| **source == crate::ShadowSource::Taken).count();
        assert!(taken > expected.len() / 4 && taken < expected.len(), "{taken} of {}", expected.len());
    }
}

/// Tests scenes of triangles and spheres, some large and some smaller than a sample, and of wires and slats. Hits must
/// agree. If all shadow rays are traced, the picture must agree too.
#[test]
fn what_jittered_samples_see_by_bracket_is_naive_s_to_the_last_bit() {
    let mut renderer = renderer();
    let exact = renderer.gpu.is_exact();
    let random = (10..14).map(|seed| (format!("random {seed}"), colored(seed, 300, 60), camera(47, 35)));
    let dust = (20..22).map(|seed| (format!("dust {seed}"), dust(seed), camera(47, 35)));
    let trials = [Trial::Wires, Trial::Fence, Trial::Hair];
    let trials = trials.into_iter().map(|trial| (trial.to_string(), trial.scene(), trial.camera(53, 35)));
    for (name, scene, camera) in random.chain(dust).chain(trials) {
        let eyes = Eyes::pair(&camera.pose().unwrap());
        for side in [2, 5] {
            let mut of = |method, count| {
                samples(&mut renderer, &scene, &eyes, side, &Options::new(method).seed(side).count(count))
            };
            let naive = of(Method::Naive, false);
            // Counting kernels have one ray per lane, which tests only the primitives that may cover its own sample.
            let methods = [Method::BRACKET_RAYS, Method::BRACKET, Method::VERIFIED].map(|method| (method, false));
            for (method, count) in methods.into_iter().chain([(Method::BRACKET_RAYS, true)]) {
                let found = of(method, count);
                let wrong = hits(&found[1]).iter().zip(hits(&naive[1])).filter(|(a, b)| **a != *b).count();
                assert!(!exact || wrong == 0, "{name} {method} {side}: {wrong} of {}", hits(&naive[1]).len());
                let other = found[1].view.object.iter().zip(&naive[1].view.object).filter(|(a, b)| a != b).count();
                assert!(other <= naive[1].view.object.len() / if exact { 1 << 31 } else { 500 }, "{name} {method}");
                if exact && method == Method::BRACKET_RAYS {
                    assert!(found[1].view.linear == naive[1].view.linear, "{name} {side}");
                }
            }
        }
    }
}

/// Returns triangles smaller than a sample, dense enough that rays hit them.
fn dust(seed: u32) -> Scene {
    let mut random = Random::new(seed);
    let corners = (0..6000).flat_map(|_| {
        let middle = random.point(1.0);
        [middle, middle + random.point(0.02), middle + random.point(0.02)]
    });
    let corners = Vec::from_iter(corners);
    let triangles = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let mut scene = Scene::new();
    scene.add_mesh(&Mesh::new(corners, triangles)).unwrap();
    scene
}

/// Each view may have its own seed of noise, but not its own sample offsets.
#[test]
fn views_share_their_samples_offsets_whatever_their_noise() {
    let mut renderer = renderer();
    let scene = colored(5, 80, 20);
    let eyes = Eyes { offsets: vec![-0.5, 0.5], ..Eyes::pair(&camera(33, 25).pose().unwrap()) };
    for noise_by_view in [false, true] {
        let options = Options::new(Method::Naive).seed(3).noise_by_view(noise_by_view);
        let views = samples(&mut renderer, &scene, &eyes, 3, &options);
        let frame: cpu::Frame = eyes.with_samples(3).unwrap().cpu_frame(1).jittered(3, 3);
        for (view, eye) in views.iter().zip([Eye::Left, Eye::Right]) {
            let twin = trace_left(&scene, &frame, eye);
            let differing = hits(view).iter().zip(&twin).filter(|(a, b)| a.1 != b.1).count();
            assert!(differing <= if renderer.gpu.is_exact() { 0 } else { twin.len() / 500 }, "{eye:?} {noise_by_view}");
        }
    }
}
