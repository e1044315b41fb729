//! Tests frames that find their hits by the samples of earlier frames: they show what frames without a history show.

use stereotrace::{
    Builtin, BvhBuild, Ellipsoid, Light, Lighting, Material, MaterialId, Mesh, Method, Options, Penumbra, Plane,
    Principled, Renderer, Scene, Sky, Sphere, StereoCamera, StereoPair, Update, UploadedScene,
    blocking::Wait,
    glam::{Affine3A, DQuat, DVec3, Mat3, Vec3},
    metrics,
    testing::suite::Trial,
};

use crate::common::{ball, is_exact, is_long, random::Random, renderer};

/// Memory of a history in MiB, more than these pictures need.
const ROOM: u32 = 64;

/// Returns a camera that is turned to the left, in degrees, and moved along its right, upwards and view direction.
fn moved(camera: StereoCamera, degrees: f64, [right, up, ahead]: [f64; 3]) -> StereoCamera {
    let pose = camera.pose().unwrap();
    let [x, y, z] = [pose.right, pose.up, pose.forward].map(|axis| axis.as_dvec3());
    let step = x * right + y * up + z * ahead;
    let to_target = camera.target_position() - pose.eye;
    let turned = DQuat::from_axis_angle(camera.up_direction().as_dvec3(), degrees.to_radians()) * to_target;
    camera.eye(pose.eye + step).target(pose.eye + step + turned)
}

/// Returns small steps, a fast turn, a zoom, a cut to the other side and the way back, for a camera at this distance
/// from its target.
fn film(camera: StereoCamera) -> Vec<StereoCamera> {
    let far = camera.target_position().distance(camera.pose().unwrap().eye);
    let mut all = vec![camera];
    for (degrees, step) in [
        (0.5, [0.01, 0.0, 0.0]),
        (0.5, [0.01, 0.005, 0.0]),
        (0.0, [0.0, 0.0, 0.02]),
        (0.0, [0.0; 3]),
        (-25.0, [0.0; 3]),
    ] {
        let last = *all.last().unwrap();
        all.push(moved(last, degrees, step.map(|along| along * far)));
    }
    all.push(all[4].vertical_fov_degrees(20.0));
    all.push(moved(camera, 180.0, [0.0, 0.0, 2.0 * far]));
    all.push(camera);
    all
}

/// Compares both eyes of two pairs, exactly or, on adapters that contract operations, but for few pixels.
fn assert_same(what: &str, found: &StereoPair, expected: &StereoPair, exact: bool) {
    for (eye, found, expected) in [("left", &found.left, &expected.left), ("right", &found.right, &expected.right)] {
        let differing = (0..expected.rgba8.len())
            .filter(|&at| {
                let all = |view: &stereotrace::View| (view.rgba8[at], view.primitive[at], view.depth[at].to_bits());
                all(found) != all(expected)
            })
            .count();
        let most = if exact { 0 } else { expected.rgba8.len() / 500 };
        assert!(differing <= most, "{what}, {eye} view: {differing} pixels differ");
    }
}

/// Renders a film with a history, and compares each frame with `naive`. Returns the primary rays of both views.
fn compare(
    (renderer, scene): (&mut Renderer, &UploadedScene),
    what: &str,
    film: &[StereoCamera],
    options: &Options,
) -> Vec<[u64; 2]> {
    let exact = is_exact(renderer);
    let frames = film.iter().enumerate().map(|(frame, camera)| {
        let naive = options.clone().method(Method::Naive);
        let expected = renderer.pair(scene, camera).options(&naive).read().wait().unwrap();
        let found = renderer.pair(scene, camera).options(&options.clone().history(ROOM)).read().wait().unwrap();
        assert_same(&format!("{what}, frame {frame}"), &found, &expected, exact);
        let rays = [found.statistics.left.rays.primary, found.statistics.right.rays.primary];
        println!("{what}, frame {frame}: {rays:?} primary rays");
        rays
    });
    let rays = frames.collect();
    renderer.forget();
    rays
}

#[test]
fn films_show_what_naive_shows_with_few_rays() {
    let mut renderer = renderer();
    let film = film(Builtin::Hall.camera(160, 120));
    let uploaded = renderer.upload(&Builtin::Hall.scene()).wait().unwrap();
    let options = Options::new(Method::BRACKET_RAYS);
    let rays = compare((&mut renderer, &uploaded), "hall", &film, &options);
    assert_eq!(rays[0][0], 160 * 120, "the first frame has no history");
    // Lists of this many small triangles overflow in either view; the right views trace 20% of their pixels.
    for [left, right] in &rays[1..=4] {
        assert!(left.abs_diff(*right) < 160 * 120 / 50, "small steps: {left} and {right} rays");
    }
    assert!(rays[6][0] < 160 * 120 / 2, "a zoom: {}", rays[6][0]);
}

#[test]
fn lights_samples_and_paths_are_as_without_a_history() {
    let mut renderer = renderer();
    let mut scene = Scene::new();
    let white = scene.add_material(Material::new(Vec3::splat(0.7)));
    let mirror = scene.add_material(
        Material::new(Vec3::ZERO).specular(Vec3::splat(0.9)).finish(stereotrace::Finish::Mirror { fresnel: false }),
    );
    for (at, material) in [(Vec3::new(-0.6, 0.0, 0.0), white), (Vec3::new(0.6, 0.0, 0.2), mirror)] {
        scene.add_mesh(&ball(at, 0.5, 8).materials(vec![material])).unwrap();
    }
    let floor = [(-3.0, -3.0), (-3.0, 3.0), (3.0, 3.0), (3.0, -3.0)].map(|(x, z)| Vec3::new(x, -0.5, z)).to_vec();
    scene.add_mesh(&Mesh::new(floor, vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    scene.lights = vec![
        Light::point(Vec3::new(1.0, 3.0, 2.0), Vec3::splat(0.5)),
        Light::sphere(Vec3::new(-2.0, 3.0, 1.0), 0.3, Vec3::splat(0.4)),
    ];
    let camera = StereoCamera::look_at(Vec3::new(0.0, 0.7, 3.0), Vec3::ZERO).size(60, 44).interaxial_pixels(3.0);
    let film = &film(camera)[..4];
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let plain = Options::new(Method::BRACKET_RAYS);
    for (what, options) in [
        ("soft light", plain.clone().shadow_rays(4)),
        ("four samples", plain.clone().samples(4)),
        ("sky light", plain.clone().sky_rays(4)),
        ("paths", plain.lighting(Lighting::Paths { bounces: 2, samples: 2 }).penumbra(stereotrace::Penumbra::Exact)),
    ] {
        let rays = compare((&mut renderer, &uploaded), what, film, &options);
        assert!(rays[1][0] < rays[0][0] / 4, "{what}: {rays:?}");
    }
}

/// Returns the percentages of both views that differ from `naive`'s.
fn differing(pair: &StereoPair, naive: &StereoPair) -> [f64; 2] {
    [(&pair.left, &naive.left), (&pair.right, &naive.right)].map(|(view, naive)| {
        let difference = metrics::compare(view, naive, &pair.pose).unwrap();
        assert_eq!(difference.wrong_surface_percent, 0.0);
        100.0 - difference.identical_percent
    })
}

/// Visibility bits are recalled from frame to frame. Their errors neither grow nor spread.
#[test]
fn recalled_visibility_does_not_drift() {
    let mut renderer = renderer();
    let frames = if is_long() { 100 } else { 40 };
    // The largest measured shares of shadow rays, in small pictures full of edges, with a margin of a tenth.
    for (builtin, most) in [(Builtin::Hall, 0.73), (Builtin::Spheres, 0.43)] {
        let uploaded = renderer.upload(&builtin.scene()).wait().unwrap();
        let camera = builtin.camera(160, 120);
        let mut wrong = Vec::new();
        let mut shares = Vec::new();
        for frame in 0..frames {
            let camera = camera.orbited((0.5 * frame as f32).to_radians());
            let mut pair =
                |options: Options| renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
            let naive = pair(Options::new(Method::Naive));
            let recalled = pair(Options::new(Method::BRACKET).history(ROOM));
            let [all, asked] = [&naive, &recalled].map(|pair| pair.statistics.left.rays.shadow as f64);
            shares.push(asked / all);
            wrong.push(differing(&recalled, &naive));
        }
        // Without a history, the left view would not differ.
        let mean = |frames: &[[f64; 2]]| frames.iter().map(|[left, _]| left).sum::<f64>() / frames.len() as f64;
        let [early, late] = [mean(&wrong[1..11]), mean(&wrong[wrong.len() - 10..])];
        let asked = shares[1..].iter().sum::<f64>() / (shares.len() - 1) as f64;
        println!("{builtin:?}: shadow rays {asked:.3}, differing {early:.4}% early, {late:.4}% late");
        assert!(asked < most, "{builtin:?}: {asked}");
        // Measured: 0.092%. Steps of one level of a colour count.
        assert!(early < 0.12 && late < 0.12, "{builtin:?}: {early}% differ early, {late}% late");
        renderer.forget();
    }
}

/// Bits of an earlier frame count only if what they depend on is as it was.
#[test]
fn changes_forget_visibility() {
    let mut renderer = renderer();
    let mut scene = Scene::new();
    scene.add_mesh(&ball(Vec3::new(0.0, 0.5, 0.0), 0.5, 8)).unwrap();
    scene.add_mesh(&ball(Vec3::new(-1.2, 0.0, 0.0), 0.1, 8)).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(1.2, 0.0, 0.0), 0.1, MaterialId(0))).unwrap();
    let floor = [(-3.0, -3.0), (-3.0, 3.0), (3.0, 3.0), (3.0, -3.0)].map(|(x, z)| Vec3::new(x, -0.5, z)).to_vec();
    scene.add_mesh(&Mesh::new(floor, vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    scene.lights = [1.0, -1.0].map(|x| Light::point(Vec3::new(x, 3.0, 2.0), Vec3::splat(0.5))).to_vec();
    let camera = StereoCamera::look_at(Vec3::new(0.0, 0.9, 3.0), Vec3::ZERO).size(240, 180).interaxial_pixels(3.0);
    let mut uploaded = renderer.upload(&scene).wait().unwrap();
    let options = Options::new(Method::BRACKET);
    let exact = is_exact(&renderer);
    // Updates the scene, renders a frame, and returns its share of shadow rays.
    let mut asked = |scene: &Scene, how: Update, options: &Options| {
        renderer.update(&mut uploaded, scene, how).wait().unwrap();
        let [first, second] = [options.clone().history(ROOM), options.clone()].map(|options| {
            let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
            (pair.left.rgba8, pair.right.rgba8, pair.statistics.left.rays.shadow)
        });
        let share = first.2 as f64 / second.2 as f64;
        assert!(share < 1.0 || !exact || (first.0, first.1) == (second.0, second.1), "no bit is recalled");
        println!("{share:.3} of the shadow rays");
        share
    };
    let refit = Update::Refit;
    assert_eq!(asked(&scene, refit, &options), 1.0, "the first frame");
    let unchanged = asked(&scene, refit, &options);
    assert!(unchanged < 0.25, "nothing changed: {unchanged}");
    scene.lights[0].intensity *= 0.5;
    let share = asked(&scene, refit, &options);
    assert!(share < 0.25, "a light became dimmer: {share}");
    scene.lights[0].position += DVec3::new(0.5, 0.0, 0.0);
    let share = asked(&scene, refit, &options);
    assert!(share > 0.5 && share < 0.7, "one light of two moved: {share}");
    scene.lights[1].position += DVec3::new(0.5, 0.0, 0.0);
    scene.lights[0].position += DVec3::new(0.5, 0.0, 0.0);
    assert_eq!(asked(&scene, refit, &options), 1.0, "both lights moved");
    let step = Affine3A::from_translation(Vec3::new(0.02, 0.0, 0.0));
    for (what, object) in [("a small mesh", 1), ("a sphere", 3)] {
        scene.transform_object(object, &step).unwrap();
        let share = asked(&scene, refit, &options);
        assert!(share > unchanged && share < 0.35, "{what} moved: {share}");
    }
    scene.transform_object(0, &step).unwrap();
    let rebuild = Update::Rebuild(BvhBuild::Fast);
    let share = asked(&scene, rebuild, &options);
    assert!(share > 0.35 && share < 0.9, "a large mesh moved: {share}");
    scene.transform_object(2, &Affine3A::from_translation(Vec3::new(0.0, 0.01, 0.0))).unwrap();
    let share = asked(&scene, rebuild, &options);
    assert!(share > 0.7, "the floor moved: {share}");
    let red = scene.add_material(Material::new(Vec3::X));
    assert_eq!(asked(&scene, refit, &options), 1.0, "a new material");
    let Sphere { center, radius, .. } = scene.spheres()[0];
    scene.set_sphere(3, Sphere::new(center, radius, red)).unwrap();
    let share = asked(&scene, refit, &options);
    assert!(share < 0.35, "another material: {share}");
    scene.lights.push(Light::sphere(Vec3::new(0.0, 3.0, 0.0), 0.5, Vec3::splat(0.5)));
    assert_eq!(asked(&scene, refit, &options), 1.0, "a soft light more");
    scene.lights.pop();
    assert_eq!(asked(&scene, refit, &options), 1.0, "no soft light any more");
    scene.add_sphere(Sphere::new(Vec3::new(1.2, 1.0, 0.0), 0.1, MaterialId(0))).unwrap();
    assert_eq!(asked(&scene, rebuild, &options), 1.0, "a new sphere");
    scene.add_plane(Plane::new(Vec3::new(0.0, -0.7, 0.0), Vec3::Y, red)).unwrap();
    assert_eq!(asked(&scene, rebuild, &options), 1.0, "a new plane");
    assert_eq!(asked(&scene, refit, &Options::new(Method::BRACKET_RAYS)), 1.0, "another method");
    asked(&scene, refit, &options.clone().samples(4));
    assert_eq!(asked(&scene, refit, &options.samples(4).jitter(false)), 1.0, "samples at other places");
}

/// Returns the percentage of the left view that differs from `naive`'s, by more than two levels of a colour.
fn differing_clearly(found: &StereoPair, naive: &StereoPair) -> f64 {
    let pixels = found.left.rgba8.iter().zip(&naive.left.rgba8);
    let clear = pixels.filter(|(a, b)| (0..3).any(|channel| a[channel].abs_diff(b[channel]) > 2)).count();
    100.0 * clear as f64 / found.left.rgba8.len() as f64
}

/// Shadows of objects that move are where they belong: of thin poles, of a fast ball, of one that jumps, under points
/// and extended lights. Without the test of boxes, 0.9% of the pixels are wrong.
#[test]
fn shadows_move_with_their_objects() {
    let mut renderer = renderer();
    let mut scene = Scene::new();
    let floor = [(-4.0, -4.0), (-4.0, 4.0), (4.0, 4.0), (4.0, -4.0)].map(|(x, z)| Vec3::new(x, -0.5, z)).to_vec();
    scene.add_mesh(&Mesh::new(floor, vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    for x in [-1.0, 0.0, 1.0] {
        scene.add_mesh(&ball(Vec3::new(x, 0.0, -1.0), 0.4, 8)).unwrap();
    }
    scene.add_sphere(Sphere::new(Vec3::new(-1.5, 0.6, 0.5), 0.3, MaterialId(0))).unwrap();
    scene
        .add_ellipsoid(Ellipsoid::new(
            Vec3::new(1.0, 0.5, 0.8),
            Mat3::from_diagonal(Vec3::new(0.05, 0.9, 0.05)),
            MaterialId(0),
        ))
        .unwrap();
    let point = Light::point(Vec3::new(1.0, 3.0, 2.0), Vec3::splat(0.3));
    let camera = StereoCamera::look_at(Vec3::new(0.0, 1.5, 5.0), Vec3::ZERO).size(160, 120).interaxial_pixels(3.0);
    for (what, lights) in [
        ("points", vec![point, Light::point(Vec3::new(-3.0, 2.0, 1.0), Vec3::splat(0.3))]),
        ("the sun", vec![point, Light::directional(Vec3::new(-1.0, 2.0, 0.7), 0.0, Vec3::splat(0.3))]),
        ("a sphere", vec![point, Light::sphere(Vec3::new(-3.0, 2.0, 1.0), 0.2, Vec3::splat(0.3))]),
    ] {
        scene.lights = lights;
        let mut uploaded = renderer.upload(&scene).wait().unwrap();
        let options = Options::new(Method::BRACKET).penumbra(Penumbra::Exact);
        let (mut wrong, mut plain, mut shares) = (0.0, 0.0, Vec::new());
        for frame in 0..8 {
            let mut pair =
                |options: &Options| renderer.pair(&uploaded, &camera).options(options).read().wait().unwrap();
            let naive = pair(&options.clone().method(Method::Naive));
            let found = pair(&options.clone().history(ROOM));
            let [all, asked] = [&naive, &found].map(|pair| pair.statistics.left.rays.shadow as f64);
            if frame > 0 {
                shares.push(asked / all);
            }
            wrong += differing_clearly(&found, &naive) / 8.0;
            plain += differing_clearly(&pair(&options), &naive) / 8.0;
            scene.transform_object(1, &Affine3A::from_translation(Vec3::new(0.0, 0.0, 0.03))).unwrap();
            scene.transform_object(4, &Affine3A::from_translation(Vec3::new(0.2, 0.0, 0.0))).unwrap();
            scene
                .transform_object(
                    5,
                    &Affine3A::from_translation(Vec3::new(if frame % 2 == 0 { -1.0 } else { 1.0 }, 0.0, 0.0)),
                )
                .unwrap();
            renderer.update(&mut uploaded, &scene, Update::Refit).wait().unwrap();
        }
        println!("{what}: {wrong:.4}% wrong, {plain:.4}% without a history; shares of shadow rays {shares:.3?}");
        // Bits of extended lights are recalled in every second frame.
        assert!(shares.iter().sum::<f64>() / 7.0 < 0.7, "{what}: {shares:?}");
        // Measured: 0, with and without a history.
        assert!(wrong < 0.01, "{what}: {wrong}%");
        renderer.forget();
    }
}

/// Returns the linear light of a pair's left view.
fn left_light(pair: &StereoPair) -> impl Iterator<Item = f64> + '_ {
    pair.left.linear.iter().flat_map(|[r, g, b, _]| [r, g, b]).map(|&light| f64::from(light))
}

/// Returns the mean difference of a left view's light from a converged one, and the root of the mean square.
fn error(found: &StereoPair, converged: &[f64]) -> [f64; 2] {
    let differences: Vec<f64> = left_light(found).zip(converged).map(|(found, truth)| found - truth).collect();
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / differences.len() as f64;
    [mean(&mut differences.iter().copied()), mean(&mut differences.iter().map(|d| d * d)).sqrt()]
}

/// Shares of soft light are recalled and interpolated. Films become quieter in wide penumbrae, their mean stays, and no
/// shadow lags behind its object.
#[test]
fn soft_light_becomes_quieter_and_is_not_biased() {
    let mut renderer = renderer();
    let mut scene = Scene::new();
    let floor = [(-4.0, -4.0), (-4.0, 4.0), (4.0, 4.0), (4.0, -4.0)].map(|(x, z)| Vec3::new(x, -0.5, z)).to_vec();
    scene.add_mesh(&Mesh::new(floor, vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    for x in [-1.5, 0.0, 1.5] {
        scene.add_mesh(&ball(Vec3::new(x, 0.1, 0.0), 0.5, 12)).unwrap();
    }
    scene.sky = Sky::Gradient { nadir: Vec3::splat(0.1), zenith: Vec3::splat(0.3) };
    let camera = StereoCamera::look_at(Vec3::new(0.0, 1.5, 5.0), Vec3::ZERO).size(120, 90).interaxial_pixels(3.0);
    let lights = Options::new(Method::BRACKET).shadow_rays(8).linear(true);
    let frames = if is_long() { 70 } else { 12 };
    // Measured shares of rays and of noise: 0.148 and 0.927, 0.109 and 1.008, 0.334 and 1.004, 0.127 and 0.718.
    for (what, radius, options, step, most) in [
        ("large lights", 1.5, lights.clone(), Vec3::ZERO, [0.2, 1.0]),
        ("small lights", 0.3, lights.clone(), Vec3::ZERO, [0.2, 1.05]),
        ("small lights and a ball that moves", 0.3, lights.clone(), Vec3::new(0.05, 0.0, 0.05), [0.5, 1.05]),
        ("the sky", 1.5, lights.sky_rays(8), Vec3::ZERO, [0.2, 0.85]),
    ] {
        let light = |x: f32| Light::sphere(Vec3::new(x, 3.0, 2.0), radius, Vec3::splat(0.4));
        scene.lights = [-2.0, 2.0].map(light).to_vec();
        let mut uploaded = renderer.upload(&scene).wait().unwrap();
        let mut moving = scene.clone();
        for frame in 0..frames {
            let camera = camera.orbited((0.5 * frame as f32).to_radians());
            let mut pair =
                |options: &Options| renderer.pair(&uploaded, &camera).options(options).read().wait().unwrap();
            let found = pair(&options.clone().history(ROOM));
            if frame + 1 == frames {
                let naive = pair(&options.clone().method(Method::Naive));
                let many = options.clone().method(Method::Naive).shadow_rays(32);
                let many = if options.sky_rays.is_some() { many.sky_rays(32) } else { many };
                let converged = mean_light((0..8).map(|seed| pair(&many.clone().seed(100 + seed))));
                let [found_error, naive_error] = [&found, &naive].map(|pair| error(pair, &converged));
                let [asked, all] = [&found, &naive].map(|pair| pair.statistics.left.rays.shadow as f64);
                let [noise, share] = [found_error[1] / naive_error[1], asked / all];
                println!("{what}: {share:.3} of the rays, {noise:.3} of naive's noise, bias {:.6}", found_error[0]);
                assert!(share < most[0], "{what}: {share} of the rays");
                assert!(noise < most[1], "{what}: {noise} of naive's noise");
                assert!(found_error[0].abs() < 5e-4, "{what}: bias {}", found_error[0]);
            }
            if step != Vec3::ZERO {
                moving.transform_object(1, &Affine3A::from_translation(step)).unwrap();
                renderer.update(&mut uploaded, &moving, Update::Refit).wait().unwrap();
            }
        }
        renderer.forget();
    }
}

/// Returns the mean of pairs' linear light in the left view.
fn mean_light(pairs: impl ExactSizeIterator<Item = StereoPair>) -> Vec<f64> {
    let share = 1.0 / pairs.len() as f64;
    let mut mean = Vec::new();
    for pair in pairs {
        mean.resize(3 * pair.left.linear.len(), 0.0);
        mean.iter_mut().zip(left_light(&pair)).for_each(|(sum, light)| *sum += share * light);
    }
    mean
}

fn room_camera() -> StereoCamera {
    let camera = StereoCamera::look_at(Vec3::new(0.5, 1.3, 4.0), Vec3::new(0.0, 0.7, 0.0));
    camera.size(120, 90).interaxial_pixels(3.0)
}

/// Returns a room without a ceiling that holds balls of several materials.
fn open_room() -> Scene {
    let mut scene = Scene::new();
    let corners = |points: [[f32; 3]; 4]| points.map(Vec3::from).to_vec();
    for (wall, albedo) in [
        ([[-2.0, 0.0, -2.0], [-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0]], Vec3::splat(0.7)),
        ([[-2.0, 0.0, -2.0], [2.0, 0.0, -2.0], [2.0, 3.0, -2.0], [-2.0, 3.0, -2.0]], Vec3::splat(0.7)),
        ([[-2.0, 0.0, 2.0], [-2.0, 0.0, -2.0], [-2.0, 3.0, -2.0], [-2.0, 3.0, 2.0]], Vec3::new(0.7, 0.2, 0.2)),
    ] {
        let material = scene.add_material(Material::new(albedo));
        scene.add_mesh(&Mesh::new(corners(wall), vec![[0, 1, 2], [0, 2, 3]]).materials(vec![material])).unwrap();
    }
    for (x, metallic, roughness) in [(-1.1, 0.0, 0.6), (0.0, 1.0, 0.5), (1.1, 0.0, 1.0)] {
        let surface = Principled::new(Vec3::new(0.8, 0.6, 0.3), metallic, roughness);
        let material = scene.add_material(Material::new(Vec3::ZERO).principled(surface));
        scene.add_mesh(&ball(Vec3::new(x, 0.5, 0.0), 0.5, 16).materials(vec![material])).unwrap();
    }
    scene.sky = Sky::Gradient { nadir: Vec3::splat(0.2), zenith: Vec3::new(0.8, 0.9, 1.2) };
    scene.lights = vec![Light::point(Vec3::new(1.0, 2.5, 1.5), Vec3::splat(0.3))];
    scene
}

/// The light of paths is recalled and averaged from frame to frame. Films become quieter, and their mean stays.
#[test]
fn light_of_paths_becomes_quieter_and_is_not_biased() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&open_room()).wait().unwrap();
    let frames = if is_long() { 70 } else { 16 };
    let mut converged = None;
    // Measured shares of rays and of noise: 0.247 and 0.663, 0.279 and 0.501, 0.304 and 0.393, 0.405 and 0.682.
    for (what, samples, degrees, most) in [
        ("still", 8, 0.0, [0.28, 0.74]),
        ("orbit", 8, 0.5, [0.31, 0.55]),
        ("orbit with one path", 1, 0.5, [0.34, 0.43]),
        // Glossy light of the view before a cut would be wrong.
        ("cut", 8, 0.0, [0.5, 0.74]),
    ] {
        let lighting = |samples| Lighting::Paths { bounces: 2, samples };
        let options = Options::new(Method::BRACKET).lighting(lighting(samples)).linear(true);
        // The last frame of all films is the same.
        let mut pair = |frame: u32, options: &Options| {
            let left = frames - 1 - frame;
            let degrees = if what == "cut" && left > 0 { 40.0 } else { -degrees * left as f32 };
            let camera = room_camera().orbited(degrees.to_radians());
            renderer.pair(&uploaded, &camera).options(options).read().wait().unwrap()
        };
        let found = (0..frames).map(|frame| pair(frame, &options.clone().history(ROOM))).last().unwrap();
        let naive = options.method(Method::Naive);
        let many = naive.clone().lighting(lighting(64));
        let converged = converged
            .get_or_insert_with(|| mean_light((0..8).map(|seed| pair(frames - 1, &many.clone().seed(100 + seed)))));
        let naive = pair(frames - 1, &naive);
        let errors = [&found, &naive].map(|pair| error(pair, converged));
        let [sent, all] = [&found, &naive].map(|pair| pair.statistics.left.rays.secondary as f64);
        let (share, noise) = (sent / all, errors[0][1] / errors[1][1]);
        println!("{what}: {share:.3} of the rays, {noise:.3} of naive's noise, bias {:.6}", errors[0][0]);
        assert!(share < most[0], "{what}: {share} of the rays");
        assert!(noise < most[1], "{what}: {noise} of naive's noise");
        assert!(errors[0][0].abs() < 2e-3, "{what}: bias {}", errors[0][0]);
        renderer.forget();
    }
}

/// A history without room for the light of paths still finds first hits.
#[test]
fn light_without_room_is_followed_anew() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&open_room()).wait().unwrap();
    let options = Options::new(Method::BRACKET).lighting(Lighting::Paths { bounces: 1, samples: 1 }).history(1);
    // Samples of 135x135 pixels take 0.6 MiB, and as much for light.
    let camera = room_camera().size(135, 135);
    let mut rays = || renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap().statistics.left.rays;
    let [first, second] = [rays(), rays()];
    assert!(second.primary < first.primary / 4, "{first:?}, {second:?}");
    assert!(second.secondary as f64 > 0.99 * first.secondary as f64, "{first:?}, {second:?}");
}

/// `auto` expects as many shadow rays in a view that recalls their results as in one that traces them.
#[test]
fn auto_predicts_what_it_predicts_without_a_history() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Hall.scene()).wait().unwrap();
    let camera = Builtin::Hall.camera(160, 120);
    let options = Options::default().history(ROOM);
    let mut render = || renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap().statistics;
    let all = [(); 3].map(|()| render());
    let [traced, recalled, again] = all.map(|statistics| (statistics.left.rays.shadow, statistics.choice.unwrap()));
    assert!([recalled.0, again.0].iter().all(|rays| 10 * rays < 7 * traced.0), "{traced:?}, {recalled:?}, {again:?}");
    assert_eq!([recalled.1, again.1], [traced.1; 2]);
}

/// The number of paths may change from frame to frame. A film that begins with more of them goes on with less noise.
#[test]
fn a_film_begins_with_more_paths_and_goes_on_with_fewer() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&open_room()).wait().unwrap();
    let mut pair = |seed, samples, method, history: Option<u32>| {
        let options = Options::new(method).lighting(Lighting::Paths { bounces: 1, samples }).linear(true);
        let options = options.seed(seed).history(history);
        renderer.pair(&uploaded, &room_camera()).options(&options).read().wait().unwrap()
    };
    let converged = mean_light((0..8).map(|seed| pair(100 + seed, 64, Method::Naive, None)));
    let noise = |pair: &StereoPair| error(pair, &converged)[1];
    let naive = pair(0, 4, Method::Naive, None);
    let first = noise(&pair(0, 8, Method::BRACKET, Some(ROOM)));
    let second = pair(0, 4, Method::BRACKET, Some(ROOM));
    let [first, then] = [first, noise(&second)].map(|noise_now| noise_now / noise(&naive));
    let [sent, all] = [&second, &naive].map(|pair| pair.statistics.left.rays.secondary as f64);
    println!("noise over naive's: {first:.3}, then {then:.3}, by {:.3} of the rays", sent / all);
    // Measured: 0.601, 0.640 and 0.252.
    assert!(first < 0.65 && then < 0.7, "{first}, then {then}");
    assert!(sent < 0.28 * all, "{sent} of {all} rays");
}

/// A frame after a change shows what it shows without a history, but for other random numbers.
#[test]
fn changes_forget_the_light_of_paths() {
    let mut renderer = renderer();
    let paths = Lighting::Paths { bounces: 1, samples: 4 };
    let options = Options::new(Method::BRACKET).lighting(paths).linear(true);
    type Change = fn(&mut Scene);
    let changes: [(&str, Change); 3] = [
        ("sky", |scene| scene.sky = Sky::Constant(Vec3::new(0.1, 0.2, 0.1))),
        ("intensity", |scene| scene.lights[0].intensity *= 0.2),
        ("object", |scene| {
            scene.transform_object(4, &Affine3A::from_translation(Vec3::new(0.0, 0.0, 0.3))).unwrap();
        }),
    ];
    for (what, change) in changes {
        let mut scene = open_room();
        let mut uploaded = renderer.upload(&scene).wait().unwrap();
        let mut sent = Vec::new();
        for frame in 0..3 {
            if frame == 2 {
                change(&mut scene);
                renderer.update(&mut uploaded, &scene, Update::Refit).wait().unwrap();
            }
            let recalling = options.clone().history(ROOM);
            let pair = renderer.pair(&uploaded, &room_camera()).options(&recalling).read().wait().unwrap();
            sent.push(pair.statistics.left.rays.secondary as f64);
        }
        assert!(sent[1] < 0.5 * sent[0], "{what}: {sent:?}");
        let without = renderer.pair(&uploaded, &room_camera()).options(&options).read().wait().unwrap();
        let all = without.statistics.left.rays.secondary as f64;
        assert!((sent[2] / all - 1.0).abs() < 0.01, "{what}: {sent:?} of {all}");
        renderer.forget();
    }
}

/// Whatever moves between frames, hits are found by each pixel's own ray.
#[test]
fn moving_objects_are_seen_where_they_are() {
    let mut renderer = renderer();
    let mut random = Random::new(7);
    let mut number = |reach: f32| reach * (2.0 * random.unit() - 1.0);
    let mut scene = Scene::new();
    for _ in 0..20 {
        let at = Vec3::new(number(1.5), number(1.0), number(1.5));
        scene.add_mesh(&ball(at, 0.1 + number(0.05), 5)).unwrap();
    }
    let camera = StereoCamera::look_at(Vec3::new(0.0, 0.5, 5.0), Vec3::ZERO).size(90, 70).interaxial_pixels(5.0);
    scene.place_lights(2, &camera).unwrap();
    let mut uploaded = renderer.upload(&scene).wait().unwrap();
    let exact = is_exact(&renderer);
    let options = Options::new(Method::BRACKET_RAYS).history(ROOM);
    for frame in 0..6 {
        let found = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
        let naive = Options::new(Method::Naive);
        let expected = renderer.pair(&uploaded, &camera).options(&naive).read().wait().unwrap();
        assert_same(&format!("frame {frame}"), &found, &expected, exact);
        let rays = [&found, &expected].map(|pair| pair.statistics.left.rays.primary);
        assert!(frame == 0 || rays[0] < rays[1], "{rays:?}");
        for object in 0..20 {
            let step = Vec3::new(number(0.8), number(0.5), number(0.8));
            scene.transform_object(object, &Affine3A::from_translation(step)).unwrap();
        }
        renderer.update(&mut uploaded, &scene, Update::Refit).wait().unwrap();
    }
}

#[test]
fn trials_show_what_naive_shows() {
    let mut renderer = renderer();
    for &trial in Trial::ALL.iter().step_by(if is_long() { 1 } else { 3 }) {
        let camera = trial.camera(80, 60);
        let uploaded = renderer.upload(&trial.scene()).wait().unwrap();
        let options = Options::new(Method::BRACKET_RAYS);
        let film = film(camera);
        let film = if is_long() { &film } else { &film[..4] };
        let rays = compare((&mut renderer, &uploaded), trial.name(), film, &options);
        // Where nearly every pixel is an edge, the left view may trace as many rays as the right one, and a tenth more.
        assert!(rays[1][0] < rays[0][0] / 10 + rays[0][1], "{trial}: {rays:?}");
    }
}

#[test]
fn a_history_is_of_one_scene_and_size_and_fits_its_memory() {
    let mut renderer = renderer();
    let camera = Builtin::Spheres.camera(96, 64);
    let [first, second] = [Builtin::Spheres, Builtin::Hall].map(|builtin| {
        let scene = builtin.scene();
        renderer.upload(&scene).wait().unwrap()
    });
    let mut primary = |scene: &UploadedScene, camera: &StereoCamera, options: &Options| {
        let pair = renderer.pair(scene, camera).options(options).read().wait().unwrap();
        pair.statistics.left.rays.primary
    };
    let options = Options::new(Method::BRACKET).history(ROOM);
    let all = |camera: &StereoCamera| u64::from(camera.pose().unwrap().size.iter().product::<u32>());
    assert_eq!(primary(&first, &camera, &options), all(&camera));
    assert!(primary(&first, &camera, &options) < all(&camera) / 2);
    assert_eq!(primary(&second, &camera, &options), all(&camera), "of another scene");
    assert_eq!(primary(&first, &camera, &options), all(&camera), "only the last scene's is kept");
    let larger = camera.size(128, 64);
    assert_eq!(primary(&first, &larger, &options), all(&larger), "of another size");
    assert!(primary(&first, &larger, &options) < all(&larger) / 2);
    // 600x600 samples take 11 MiB.
    let large = camera.size(600, 600);
    let small = Options::new(Method::BRACKET).history(8);
    assert_eq!((0..2).map(|_| primary(&first, &large, &small)).collect::<Vec<_>>(), [all(&large); 2]);
    let refused = Options::new(Method::BRACKET).history(0);
    let error = renderer.pair(&first, &camera).options(&refused).read().wait().unwrap_err().to_string();
    assert!(error.contains("history: 0"), "{error}");
}
