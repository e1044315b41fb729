//! Tests `bracket`, `verified` and `auto` against `Naive` of the same run, and against separate code in plain Rust.

use crate::common;

use common::{
    ball, cases, gpu_with_limits, is_exact, random::Random, random_ellipsoid, random_foliage, random_stage, render,
    renderer,
};
use stereotrace::{
    Boxes, Fetch, Light, MISS, Material, Mesh, Method, Options, PixelSource, Pose, RaysPerLane, Renderer, Rig, Scene,
    ShadowReuse, ShadowSource, StereoCamera, StereoPair, Traversal,
    blocking::Wait,
    glam::Vec3,
    metrics::compare,
    scene::builtin::Builtin,
    testing::cpu::{Eye, Frame, bracket, trace_left::trace_left},
    testing::suite::Trial,
    wgpu,
};

const BITS: [(ShadowReuse, Method); 3] = [
    (ShadowReuse::Rays, Method::BRACKET_RAYS),
    (ShadowReuse::Two, Method::BRACKET),
    (ShadowReuse::Block, Method::VERIFIED),
];

/// Returns every built-in scene and trial, at a size that is no multiple of a tile.
fn scenes() -> impl Iterator<Item = (String, Scene, StereoCamera)> {
    let builtins = [Builtin::Spheres, Builtin::Hall].into_iter();
    let builtins = builtins.map(|builtin| (builtin.to_string(), builtin.scene(), builtin.camera(93, 62)));
    builtins.chain(Trial::ALL.iter().map(|trial| (trial.to_string(), trial.scene(), trial.camera(93, 62))))
}

fn hits(pair: &StereoPair) -> (&[f32], &[u32], &[u32]) {
    (&pair.right.depth, &pair.right.primitive, &pair.right.object)
}

#[test]
fn primary_visibility_is_naive_s_on_every_scene_and_without_shadow_bits_so_is_the_picture() {
    let mut renderer = renderer();
    let exact = is_exact(&renderer);
    for (name, scene, camera) in scenes() {
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let mut render =
            |method| renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap();
        let naive = render(Method::Naive);
        for (_, method) in BITS {
            let pair = render(method);
            assert_eq!(pair.left, naive.left, "{name} {method}");
            let difference = compare(&pair.right, &naive.right, &naive.pose).unwrap();
            assert_eq!(difference.wrong_surface_percent, 0.0, "{name} {method}");
            assert!(!exact || hits(&pair) == hits(&naive), "{name} {method}");
            assert!(!exact || method != Method::BRACKET_RAYS || pair.right == naive.right, "{name}");
        }
    }
}

/// Returns the least identical pixels in percent, for `bracket` and `verified`. A bound is the measured percentage,
/// minus half of the differing pixels and minus 0.1. Wires, hair and grains are thinner than the distance between left
/// samples, and so are their shadows. At this size the hall's shadows are thin too.
fn least_identical(name: &str) -> [f64; 2] {
    match name {
        "wires" => [91.9, 94.4],
        "hair" => [92.1, 99.1],
        "mixed-sizes" => [98.6, 99.7],
        "hall" => [99.1, 99.7],
        _ => [99.3, 99.5],
    }
}

#[test]
fn only_shadows_of_what_is_thinner_than_the_left_samples_differ() {
    let mut renderer = renderer();
    for (name, scene, camera) in cases(scenes(), 2) {
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let mut render =
            |method| renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap();
        let naive = render(Method::Naive);
        for (method, least) in [Method::BRACKET, Method::VERIFIED].into_iter().zip(least_identical(&name)) {
            let difference = compare(&render(method).right, &naive.right, &naive.pose).unwrap();
            let identical = difference.identical_percent;
            println!("{name} {method}: {identical:.3}");
            assert!(identical >= least, "{name} {method}: {identical}");
        }
    }
}

#[test]
fn shadows_of_wires_hair_leaves_cables_and_strips_are_not_lost() {
    let mut renderer = renderer();
    for trial in [Trial::Wires, Trial::Hair, Trial::Foliage, Trial::Cables, Trial::Strips] {
        let (uploaded, camera) = (renderer.upload(&trial.scene()).wait().unwrap(), trial.camera(240, 240));
        let mut render =
            |method| renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap();
        let naive = render(Method::Naive);
        let difference = compare(&render(Method::BRACKET).right, &naive.right, &naive.pose).unwrap();
        let wrong = 100.0 - difference.identical_percent;
        println!("{trial}: {wrong:.3}");
        // At 300x300, 0.093% of the pixels differ under leaves, and at most 0.071% in the other trials. Without the
        // test for busy lights, which have shadow edges close to a sample, it would be 0.6% to 6.4%.
        assert!(wrong <= 0.15, "{trial}: {wrong}");
    }
}

#[test]
fn at_webgpu_s_default_limits_visibility_is_naive_s_by_both_fetches() {
    let gpu = gpu_with_limits(wgpu::Limits::default());
    let spheres_and_triangles = Builtin::Near;
    let (scene, camera) = (spheres_and_triangles.scene(), spheres_and_triangles.camera(93, 62));
    let traversals =
        [(Fetch::Texture, Boxes::F32, RaysPerLane::Four), (Fetch::Buffer, Boxes::Grid16, RaysPerLane::One)];
    for (fetch, boxes, rays) in traversals {
        let mut renderer =
            Renderer::with_traversal(gpu.clone(), Traversal::of(&gpu).fetch(fetch).boxes(boxes).rays(rays));
        let exact = is_exact(&renderer);
        let uploaded = renderer.upload(&scene).wait().unwrap();
        assert_eq!(uploaded.traversal().fetch, fetch, "it fits both ways");
        let mut render =
            |method| renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap();
        let naive = render(Method::Naive);
        for (_, method) in BITS {
            let pair = render(method);
            let difference = compare(&pair.right, &naive.right, &naive.pose).unwrap();
            assert_eq!(difference.wrong_surface_percent, 0.0, "{fetch:?} {method}");
            assert!(!exact || hits(&pair) == hits(&naive), "{fetch:?} {method}");
            assert!(pair.source.contains(&PixelSource::Reused), "{fetch:?} {method}");
        }
    }
}

#[test]
fn auto_never_costs_more_than_naive_whatever_the_interaxial_and_says_what_it_chose() {
    let mut renderer = renderer();
    let mut chosen = std::collections::BTreeSet::new();
    for (name, scene, camera) in cases(scenes(), 2) {
        let uploaded = renderer.upload(&scene).wait().unwrap();
        for e_px in [2.3, 46.0] {
            let camera = camera.interaxial_pixels(e_px);
            let mut render = |options| renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
            // The choice is tested without counters. With counters a lane traces one ray, and the choice may differ.
            let auto = render(Options::default());
            let choice = auto.statistics.choice.expect("auto says why");
            assert_eq!(choice.method, auto.statistics.method);
            // The device has chosen the method. The host's cost model must choose the same method from the counters.
            assert_eq!(choice.method == Method::BRACKET, choice.bracket < choice.naive, "{name} e = {e_px}: {choice}");
            assert!(choice.to_string().starts_with(&choice.method.to_string()));
            assert!(auto.right == render(Options::new(choice.method)).right, "{name} e = {e_px}");
            let cost = |pair: &StereoPair| (pair.statistics.left.cost() + pair.statistics.right.cost()) as f64;
            let naive = cost(&render(Options::new(Method::Naive).count(true)));
            let counted = render(Options::default().count(true));
            let as_shipped = if counted.statistics.method == choice.method {
                cost(&counted)
            } else {
                cost(&render(Options::new(choice.method).count(true)))
            };
            let ratio = cost(&counted).max(as_shipped) / naive;
            assert!(ratio <= 1.02, "{name} e = {e_px}: {ratio}");
            chosen.insert(choice.method.to_string());
        }
    }
    assert!(chosen.contains("bracket") && chosen.contains("naive"), "{chosen:?}");
}

#[test]
fn auto_is_naive_from_the_start_where_there_are_no_shadows_to_take_over() {
    let mut scene = Builtin::Hall.scene();
    scene.shadows = false;
    let pair = render(&scene, &Builtin::Hall.camera(61, 45), Method::Auto);
    let on_a_cpu = renderer().gpu().adapter_info().device_type == wgpu::DeviceType::Cpu;
    assert_eq!(pair.statistics.method == Method::Naive, on_a_cpu);
    assert!(pair.statistics.choice.is_some());
}

fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.0, 0.5, 5.0), Vec3::ZERO).screen_distance(5.0).size(70, 53).interaxial_pixels(6.0)
}

/// Returns the hit of each right pixel's ray, from a rendered pair.
fn right_hits(pair: &StereoPair) -> Vec<(f32, u32)> {
    let far = |depth: f32| if depth.is_finite() { depth } else { stereotrace::FAR };
    pair.right.depth.iter().zip(&pair.right.primitive).map(|(depth, id)| (far(*depth), *id)).collect()
}

#[test]
fn tiles_are_bounded_and_pixels_finished_as_in_plain_rust() {
    let exact = is_exact(&renderer());
    let (mut finished, mut traced) = (0, 0);
    for seed in 0..6 {
        let scene = random_stage(seed);
        for e_px in [1.5, 6.0, 30.0] {
            let camera = camera().interaxial_pixels(e_px);
            let pose: Pose = camera.pose().unwrap();
            let frame = Frame::new(&pose);
            let depths: Vec<f32> = trace_left(&scene, &frame, Eye::Left).iter().map(|hit| hit.0).collect();
            let pair = render(&scene, &camera, Method::BRACKET);
            let sources = bracket::sources(&frame, &bracket::tile_bounds(&frame, &depths), &right_hits(&pair));
            let differing = sources.iter().zip(&pair.source).filter(|(twin, pixel)| twin != pixel).count();
            assert!(differing <= if exact { 0 } else { 20 }, "seed {seed}, e = {e_px}: {differing}");
            finished += sources.iter().filter(|source| **source == PixelSource::Reused).count();
            traced += sources.iter().filter(|source| **source == PixelSource::Bad).count();
        }
    }
    assert!(finished > 20 * traced && traced > 50, "{finished} {traced}");
}

#[test]
fn shadow_bits_are_taken_where_plain_rust_takes_them() {
    let exact = is_exact(&renderer());
    for (seed, e_px, ellipsoids) in [(0, 6.0, 0), (1, 6.0, 0), (2, 25.0, 0), (3, 25.0, 0), (4, 6.0, 12)] {
        let (mut scene, camera) = (random_stage(seed), camera().interaxial_pixels(e_px));
        let mut random = Random::new(seed);
        for index in 0..ellipsoids {
            scene.add_ellipsoid(random_ellipsoid(&mut random, index % 2 == 1, 0.6)).unwrap();
        }
        let frame = Frame::new(&camera.pose().unwrap());
        let left = trace_left(&scene, &frame, Eye::Left);
        for (reuse, method) in BITS {
            let pair = render(&scene, &camera, method);
            let twin = bracket::shadow_sources(&scene, &[(&frame, &left)], &right_hits(&pair), reuse);
            let differing = twin.iter().zip(&pair.shadow_source).filter(|(twin, pixel)| twin != pixel).count();
            // A cosine that consists of rounding errors alone may have either sign.
            assert!(differing <= if exact { 2 } else { 40 }, "seed {seed} {method}: {differing}");
            let traced = twin.iter().filter(|source| **source == ShadowSource::Traced).count();
            let few = reuse == ShadowReuse::Rays || 10 * traced < 8 * twin.len();
            println!("seed {seed} {method}: {traced} of {}", twin.len());
            assert!(traced > 100 && few, "seed {seed} {method}: {traced} of {}", twin.len());
        }
    }
}

#[test]
fn among_cut_outs_pixels_are_finished_and_bits_taken_as_in_plain_rust() {
    let exact = is_exact(&renderer());
    for (seed, spheres) in [(1, false), (2, true)] {
        let (scene, camera) = (random_foliage(seed, spheres), camera());
        let frame = Frame::new(&camera.pose().unwrap());
        let left = trace_left(&scene, &frame, Eye::Left);
        let depths: Vec<f32> = left.iter().map(|hit| hit.0).collect();
        for (reuse, method) in BITS {
            let pair = render(&scene, &camera, method);
            let fates = bracket::sources(&frame, &bracket::tile_bounds(&frame, &depths), &right_hits(&pair));
            let fates = fates.iter().zip(&pair.source).filter(|(twin, pixel)| twin != pixel).count();
            let twin = bracket::shadow_sources(&scene, &[(&frame, &left)], &right_hits(&pair), reuse);
            let bits = twin.iter().zip(&pair.shadow_source).filter(|(twin, pixel)| twin != pixel).count();
            // A cosine that consists of rounding errors alone may have either sign.
            let allowed = if exact { [0, 2] } else { [20, 40] };
            assert!(fates <= allowed[0] && bits <= allowed[1], "seed {seed} {method}: {fates} fates, {bits} bits");
            let traced = twin.iter().filter(|source| **source == ShadowSource::Traced).count();
            assert!(traced > 100 && traced < twin.len(), "seed {seed} {method}: {traced} of {}", twin.len());
        }
    }
}

#[test]
fn a_view_between_two_sources_takes_bits_where_plain_rust_takes_them_of_either() {
    let mut renderer = renderer();
    let exact = is_exact(&renderer);
    for (seed, e_px) in [(0, 6.0), (2, 25.0)] {
        let (scene, camera) = (random_stage(seed), camera().interaxial_pixels(e_px));
        let pose = camera.pose().unwrap();
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let offsets = [-0.5, 0.2, 0.6];
        let rig = Rig::at(camera, offsets.to_vec()).traced(vec![0, 2]);
        // The third view is the nearer source of the second view, and lies to its right.
        let frames = [2, 0].map(|source| Frame::between(&pose, offsets[source], offsets[1]));
        let hits = frames.map(|frame| trace_left(&scene, &frame, Eye::Left));
        let sources = [(&frames[0], hits[0].as_slice()), (&frames[1], hits[1].as_slice())];
        for (reuse, method) in BITS {
            let views = renderer.views(&uploaded, &rig).options(&Options::new(method)).read().wait().unwrap();
            let view = &views.views[1];
            assert_eq!(view.made_from, 2);
            let right: Vec<_> = view.view.depth.iter().copied().zip(view.view.primitive.iter().copied()).collect();
            let traced = |sources| {
                let twin = bracket::shadow_sources(&scene, sources, &right, reuse);
                let differing = twin.iter().zip(&view.shadow_source).filter(|(twin, pixel)| twin != pixel).count();
                (differing, twin.iter().filter(|source| **source == ShadowSource::Traced).count())
            };
            let ((differing, both), (_, one)) = (traced(&sources), traced(&sources[..1]));
            // A cosine that consists of rounding errors alone may have either sign.
            assert!(differing <= if exact { 2 } else { 40 }, "seed {seed} {method}: {differing}");
            println!("seed {seed} {method}: {one} by one source, {both} by two");
            // `ShadowReuse::Rays` reuses no bits, so a second source does not change its count.
            assert!(reuse == ShadowReuse::Rays || both < one, "seed {seed} {method}: {both} of {one}");
        }
    }
}

#[test]
fn more_lights_than_bits_are_kept_for_are_traced() {
    let (mut scene, camera) = (random_stage(1), camera());
    scene.lights = (0..20)
        .map(|index| {
            let around = 0.3 * index as f32;
            let position = Vec3::new(4.0 * around.cos(), 3.0, 4.0 * around.sin());
            Light::point(position, Vec3::splat(0.05))
        })
        .collect();
    let naive = render(&scene, &camera, Method::Naive);
    let pair = render(&scene, &camera, Method::BRACKET);
    let lit = |pair: &StereoPair| pair.statistics.right.rays.shadow;
    assert!(lit(&pair) > lit(&naive) / 10 && lit(&pair) < 3 * lit(&naive) / 4, "{} {}", lit(&pair), lit(&naive));
    assert!(compare(&pair.right, &naive.right, &naive.pose).unwrap().identical_percent > 97.0);
}

#[test]
fn a_block_that_more_primitives_touch_than_its_list_holds_is_traced() {
    // A hundred walls stand behind each other, at almost equal depths.
    let mut scene = Scene::new();
    scene.add_material(Material::new(Vec3::splat(0.5)));
    for layer in 0..100 {
        let z = -1e-4 * layer as f32;
        let corners = [[-0.5, -0.5, z], [0.5, -0.5, z], [0.5, 0.5, z], [-0.5, 0.5, z]].map(Vec3::from_array);
        scene.add_mesh(&Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    }
    let camera = camera();
    let (naive, pair) = (render(&scene, &camera, Method::Naive), render(&scene, &camera, Method::BRACKET_RAYS));
    assert!(pair.source.contains(&PixelSource::Missed) && pair.source.contains(&PixelSource::Reused));
    assert_eq!(hits(&pair), hits(&naive));
}

/// Renders a ball of some 440 pixels by every kind of `bracket`. Returns the number of the ball's pixels, and how many
/// of them are traced.
fn dense_ball(rings: u32) -> (usize, usize) {
    let mut scene = Scene::new();
    scene.add_mesh(&ball(Vec3::ZERO, 1.0, rings)).unwrap();
    scene.lights.push(Light::point(Vec3::new(3.0, 4.0, 2.0), Vec3::ONE));
    let camera = camera().size(64, 48);
    let mut renderer = renderer();
    let exact = is_exact(&renderer);
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let mut render = |method| renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap();
    let naive = render(Method::Naive);
    let counts = BITS.map(|(_, method)| {
        let pair = render(method);
        assert!(!exact || hits(&pair) == hits(&naive), "{method}");
        assert!(!exact || method != Method::BRACKET_RAYS || pair.right == naive.right);
        let pixels = pair.source.iter().zip(&pair.right.object).filter(|(_, object)| **object != MISS);
        let traced = pixels.clone().filter(|(source, _)| **source == PixelSource::Missed).count();
        (pixels.count(), traced)
    });
    assert!(counts.iter().all(|&count| count == counts[0]), "{counts:?}");
    counts[0]
}

#[test]
fn meshes_of_many_triangles_a_pixel_show_what_naive_shows() {
    // With 2 triangles per pixel, the lists of nearly all tiles are long enough. They are too short for 4 pixels near
    // the poles, where triangles are denser. With 13 per pixel, they are too short for half of the pixels. With 148 per
    // pixel, the search gives up whole tiles.
    let [fitting, overflowing, given_up] = [20, 53, 180].map(dense_ball);
    println!("{fitting:?} {overflowing:?} {given_up:?}");
    assert!(fitting.1 <= 12, "{fitting:?}");
    assert!(100 < overflowing.1 && overflowing.1 < 330, "{overflowing:?}");
    assert_eq!(given_up.0, given_up.1);
}

#[test]
fn a_ray_meets_only_what_its_pixel_s_centre_lies_in_the_bounds_of() {
    // The wall on the screen has a square of two triangles for each pixel.
    let camera = camera().size(64, 48);
    let frame = Frame::new(&camera.pose().unwrap());
    let center = |x, y| frame.eye(Eye::Right) + 5.0 * frame.direction(Eye::Right, x, y);
    let (right, down) = (center(1, 0) - center(0, 0), center(0, 1) - center(0, 0));
    let mut scene = Scene::new();
    scene.add_material(Material::new(Vec3::splat(0.5)));
    let around = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
    for pixel in 0..64 * 48 {
        let at = center(pixel % 64, pixel / 64);
        let corners = around.map(|(x, y): (f32, f32)| at + x * right + y * down);
        scene.add_mesh(&Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    }
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let pair =
        renderer.pair(&uploaded, &camera).options(&Options::new(Method::BRACKET).count(true)).read().wait().unwrap();
    // There are 4.0 tests per pixel, two of them by the pixel's ray and two by its tile. There would be ten if each ray
    // tested all primitives of its block.
    let tests = pair.statistics.right.primitive_tests as f64 / f64::from(64 * 48);
    assert!(tests < 4.5, "{tests}");
}

#[test]
fn ten_runs_give_the_same_pair() {
    let mut renderer = renderer();
    for builtin in [Builtin::Fence, Builtin::Spheres] {
        let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
        let camera = builtin.camera(150, 97);
        for method in [Method::BRACKET, Method::VERIFIED, Method::Auto] {
            let mut render = || {
                // Counters are off in these runs. With counters a lane would trace one ray.
                let mut pair = renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap();
                pair.statistics.times = None;
                pair
            };
            let first = render();
            for run in 1..10 {
                assert!(render() == first, "{builtin} {method} run {run}");
            }
        }
    }
}
