//! Tests the limits of f32: cameras, scales of scenes, and the camera that fits any scene.

use crate::common;

use common::{RandomScene, ball, is_exact, random::Random, renderer};
use stereotrace::{
    Error, Light, MISS, MaterialId, Mesh, Method, Options, Projection, Renderer, Scene, Sphere, StereoCamera,
    StereoPair,
    blocking::Wait,
    camera::{Intrinsics, MIN_PIXEL_ANGLE, SCREEN_DISTANCES},
    glam::Vec3,
    scene::{MAX_COORDINATE, MIN_EXTENT},
};

/// Returns ten to a random power.
fn power(random: &mut Random, low: f32, high: f32) -> f32 {
    10_f32.powf(random.between(low, high))
}

fn camera() -> StereoCamera {
    StereoCamera::look_at(4.0 * Vec3::Z, Vec3::ZERO).size(100, 80)
}

#[test]
fn cameras_beyond_the_ranges_are_refused_by_field_value_and_range() {
    let far_off = StereoCamera::look_at(Vec3::splat(1e7), Vec3::splat(1e7) - 9.0 * Vec3::Z);
    let at_the_limit = StereoCamera::look_at(2e8 * Vec3::X + 1e5 * Vec3::Z, 2e8 * Vec3::X).interaxial(1000.0);
    let tiny = StereoCamera::look_at(1e-30 * Vec3::Z, Vec3::ZERO);
    let mut renderer = renderer();
    let uploaded = renderer.upload(&triangle([Vec3::ZERO, Vec3::X, Vec3::Y])).wait().unwrap();
    let refused = [
        (tiny, "screen_distance is 1e-30; it must lie between 1e-6 and 1e9"),
        (camera().screen_distance(1e-20), "screen_distance is 1e-20; it must lie between"),
        (camera().screen_distance(2e9), "screen_distance is 2000000000.0; it must lie between"),
        (
            camera().eye(3e8 * Vec3::Z),
            "eye is [0.0, 0.0, 300000000.0]; its coordinates must lie within ±2e8 of the scene's origin",
        ),
        (camera().eye(1e14 * Vec3::Z), "its coordinates must be numbers within ±1e13"),
        (camera().interaxial(1e6), "interaxial is 1000000.0, and pixels span"),
        (camera().interaxial_pixels(1e6), "interaxial is 1000000.0 px, and pixels span"),
        (camera().interaxial(-1.0), "interaxial is -1; it must be a number of at least 0"),
        (at_the_limit, "interaxial is 1000.0; it moves an eye's coordinates beyond"),
        (far_off, "interaxial is 0.3; so far from the scene's origin"),
        (
            camera().vertical_fov_degrees(0.01),
            "vertical_fov is 0.01, so a pixel of the 100x80 picture spans 2.2e-6 radians; pixels must",
        ),
        (camera().vertical_fov_degrees(179.99), "vertical_fov is 179.99, so a pixel of the 100x80 picture spans"),
        (camera().screen_width(1e-3), "screen_width is 0.001, so a pixel of the 100x80 picture spans 2.5e-6 radians"),
        (camera().size(1 << 18, 1), "size is 262144x1; width and height must be at most 131072"),
        (
            camera().screen_distance(f32::NEG_INFINITY),
            "screen_distance is -inf; it must lie between 1e-6 and 1e9, or be infinite",
        ),
        (parallel().interaxial_pixels(4.0), "interaxial is 4.0 px; in pixels it is the parallax at infinity"),
        (parallel().interaxial_pixels(0.0), "interaxial is 0.0 px; in pixels it is the parallax at infinity"),
        (parallel().interaxial(f32::NAN), "interaxial is NaN; it must be a number of at least 0"),
        (parallel().screen_width(2.0), "screen_width is 2; give a finite screen distance"),
        (
            parallel().vertical_fov_degrees(0.01),
            "vertical_fov is 0.01, so a pixel of the 100x80 picture spans 2.2e-6 radians",
        ),
        (
            parallel().eye(Vec3::splat(1e7)).target(Vec3::ZERO).interaxial(0.3),
            "interaxial is 0.3; so far from the scene's origin",
        ),
        (parallel().interaxial(1e9), "interaxial is 1000000000.0; it moves an eye's coordinates beyond"),
        (lenses(0.0, 90.0), "fx is 0; a focal length must be"),
        (lenses(f64::NAN, 90.0), "fx is NaN; a focal length must be"),
        (calibrated(Intrinsics::new([90.0, f64::INFINITY], [50.0, 40.0])), "fy is inf; a focal length must be"),
        (calibrated(Intrinsics::new([90.0; 2], [50.0, f64::NAN])), "cy is NaN; a principal point must be"),
        (calibrated(Intrinsics::new([90.0; 2], [f64::INFINITY, 40.0])), "cx is inf; a principal point must be"),
        (
            calibrated(Intrinsics::new([90.0; 2], [1e6, 40.0])),
            "intrinsics is fx 90, fy 90, cx 1000000, cy 40, so a pixel of the 100x80 picture spans",
        ),
        (
            calibrated(Intrinsics::new([90.0; 2], [50.0, -1e6])),
            "intrinsics is fx 90, fy 90, cx 50, cy -1000000, so a pixel",
        ),
        (lenses(1e9, 1e9), "intrinsics is fx 1000000000"),
        (lenses(1e-9, 1e-9), "intrinsics is fx 0.000000001"),
        (lenses(1e300, 90.0), "intrinsics is fx 1"),
        (lenses(90.0, 1e-300), "intrinsics is fx 90, fy 0.0"),
        (doffs(-0.5), "doffs is -0.5; cx1 must be at least cx0"),
        (doffs(5.0).interaxial(0.0), "screen_distance is 0.0, from principal points 5 px apart"),
        (doffs(1e-12), "screen_distance is 11977658000000.0, from principal points"),
        (doffs(5.0).interaxial_pixels(5.0), "interaxial is 5.0 px; in pixels it is the parallax at infinity"),
        (doffs(5.0).projection(Projection::ToeIn), "doffs is 5; toed-in eyes have"),
        (doffs(5.0).screen_width(3.0), "screen_width is 3; give a finite screen distance"),
        (
            calibrated(Intrinsics::new([90.0; 2], [-1e6, 40.0]).right_cx(1e6)).interaxial(1e4),
            "interaxial is 10000.0, and pixels span",
        ),
        (camera().projection(Projection::ToeIn).interaxial(5e8), "interaxial is 500000000.0; it moves an eye"),
    ];
    for (camera, expected) in refused {
        // The eyes are checked against the scene's origin when a frame is rendered.
        let rendered = renderer.pair(&uploaded, &camera).read().wait();
        let message = camera.pose().err().or(rendered.err()).map(|error| error.to_string()).unwrap_or_default();
        assert!(message.contains(expected), "{message} should say: {expected}");
    }
    for distance in [*SCREEN_DISTANCES.start(), *SCREEN_DISTANCES.end()] {
        camera().screen_distance(distance).interaxial(0.0).pose().unwrap();
    }
    parallel().interaxial(0.0).pose().unwrap();
    // A setting that contradicts a screen at infinity does not contradict a screen that is set later.
    doffs(5.0).screen_distance(3.0).interaxial_pixels(5.0).pose().unwrap();
    doffs(5.0).screen_distance(3.0).projection(Projection::ToeIn).pose().unwrap();
    let later = doffs(5.0).vertical_fov_degrees(45.0).screen_distance(4.0).pose().unwrap();
    let plain = camera().interaxial(0.13).vertical_fov_degrees(45.0).screen_distance(4.0).pose().unwrap();
    assert_eq!(later, plain);
}

fn parallel() -> StereoCamera {
    camera().screen_distance(f32::INFINITY).interaxial(0.13)
}

fn calibrated(intrinsics: Intrinsics) -> StereoCamera {
    camera().interaxial(0.13).intrinsics(intrinsics)
}

fn lenses(fx: f64, fy: f64) -> StereoCamera {
    calibrated(Intrinsics::new([fx, fy], [50.0, 40.0]))
}

fn doffs(doffs: f64) -> StereoCamera {
    calibrated(Intrinsics::new([92.307_692_307_692_3; 2], [50.0, 40.0]).right_cx(50.0 + doffs))
}

/// Returns the number of pixels of the right view that differ in depth, primitive or colour.
fn differing(a: &StereoPair, b: &StereoPair) -> usize {
    let pixel = |pair: &StereoPair, index: usize| {
        (pair.right.depth[index], pair.right.primitive[index], pair.right.linear[index])
    };
    (0..a.right.depth.len()).filter(|&index| pixel(a, index) != pixel(b, index)).count()
}

/// Returns a camera whose corner pixels span about `angle`. Its field of view is narrow or wide, or its eyes are far
/// apart.
fn at_the_edge(
    random: &mut Random,
    scene: &Scene,
    place: impl Fn(Vec3) -> Vec3,
    scale: f32,
    angle: f32,
) -> StereoCamera {
    let far = power(random, -1.0, 3.0);
    let eye = place(random.point(1.0).normalize() * far);
    let [a, b, _] = scene.triangles()[random.below(60)].corners;
    let size = match random.below(5) {
        0 => [2000, 1],
        1 => [1, 2000],
        _ => [1 + random.below(60) as u32, 1 + random.below(60) as u32],
    };
    let [width, height] = size.map(|side| side as f32);
    let distance = scale * if random.unit() < 0.5 { far } else { power(random, -3.0, 3.0) };
    let slope = match random.below(3) {
        0 => 0.5 * height * angle,
        1 => 2.0 / (angle * width.max(height)) * (height / width.max(height)),
        _ => 0.4,
    };
    let camera = StereoCamera::look_at(eye, a.midpoint(b))
        .size(size[0], size[1])
        .vertical_fov_degrees(2.0 * slope.atan().to_degrees())
        .screen_distance(distance);
    match random.below(3) {
        0 => camera.interaxial_pixels(power(random, -2.0, 1.0)),
        _ => camera.interaxial(distance * 2.0 * (2.0 * slope / height / angle).sqrt()),
    }
}

/// Returns the same eyes with a principal point so far from the centre that corner pixels span about `angle`. Some
/// cameras have a very large or very small interaxial, or a picture of one pixel. The cameras are parallel or have a
/// screen.
fn calibrated_at_the_edge(random: &mut Random, camera: StereoCamera, angle: f32) -> StereoCamera {
    let Ok(pose) = camera.interaxial(0.0).pose() else { return camera };
    let size = if random.below(6) == 0 { [1, 1] } else { pose.size };
    let [w, h] = size.map(f64::from);
    let focal = 10_f64.powf(random.between(-0.5, 3.0).into());
    // At a distance of c focal lengths from the centre, a pixel spans s / (1 + c²) = angle, where s = 1 / focal.
    let aside = (1.0 / (focal * f64::from(angle)) - 1.0).max(0.0).sqrt() * focal;
    let turn = f64::from(random.between(0.0, 6.3));
    let off = if random.below(3) == 0 { [0.0; 2] } else { [aside * turn.cos(), aside * turn.sin()] };
    let squash = if random.below(2) == 0 { 1.0 } else { f64::from(random.between(0.3, 3.0)) };
    let intrinsics = Intrinsics::new([focal, squash * focal], [0.5 * w + off[0], 0.5 * h + off[1]]);
    let distance = f64::from(pose.subject_distance);
    let e = (distance * 10_f64.powf(random.between(-6.0, 2.0).into())) as f32;
    let camera = camera.size(size[0], size[1]).interaxial(e);
    match random.below(4) {
        0 | 1 => camera.intrinsics(intrinsics),
        2 => camera.intrinsics(intrinsics).screen_distance(pose.screen_distance),
        _ => camera.intrinsics(intrinsics.right_cx(intrinsics.cx0 + focal * f64::from(e) / distance)),
    }
}

#[test]
fn at_the_edges_of_the_ranges_parallel_and_calibrated_eyes_see_what_naive_shows() {
    let mut random = Random::new(16);
    let mut renderer = renderer();
    let (mut rendered, mut surfaces, mut moved, mut single) = (0, 0, 0, 0);
    for number in 0..1000 {
        let scale = if number % 2 == 0 { 1.0 } else { power(&mut random, -3.0, 4.0) };
        let offset = if number % 3 == 0 { scale * power(&mut random, -1.0, 2.0) } else { 0.0 };
        let seed = random.below(1000) as u32;
        let scene = RandomScene { seed, triangles: 60, spheres: 10, scale, offset, ..RandomScene::default() }.build();
        let place = |point: Vec3| point * scale + Vec3::splat(offset);
        let angle = MIN_PIXEL_ANGLE * 2_f32.powf(random.between(-0.2, 2.0));
        let camera = at_the_edge(&mut random, &scene, place, scale, angle);
        let camera = calibrated_at_the_edge(&mut random, camera, angle);
        let Ok(pose) = camera.pose() else { continue };
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let all = [Method::Naive, Method::BRACKET_RAYS, Method::ATOMIC]
            .map(|method| renderer.pair(&uploaded, &camera).options(&Options::new(method).linear(true)).read().wait());
        // Cameras whose eyes f32 can't represent are refused.
        if let [Err(Error::Camera { .. }), ..] = all {
            continue;
        }
        let [naive, bracket, atomic] = all.map(Result::unwrap);
        rendered += 1;
        single += usize::from(pose.size == [1, 1]);
        surfaces += naive.right.primitive.iter().filter(|&&primitive| primitive != MISS).count();
        moved += usize::from(naive.left.depth != naive.right.depth);
        assert!(atomic.left == naive.left || !is_exact(&renderer), "{number}: {camera:?}");
        if is_exact(&renderer) {
            assert_eq!(differing(&naive, &bracket), 0, "{number}: {camera:?}");
        }
        let finite = |values: &[f32]| values.iter().all(|value| !value.is_nan());
        assert!(finite(&naive.disparity()) && finite(&naive.right_disparity()), "{number}: {camera:?}");
    }
    println!("{rendered} rendered, {single} of one pixel, {moved} with parallax, {surfaces} pixels show a surface");
    assert!(
        rendered > 300 && moved > 150 && single > 30 && surfaces > 20_000,
        "{rendered} {moved} {single} {surfaces}"
    );
}

#[test]
fn at_the_edges_of_the_ranges_bracket_rays_shows_what_naive_does() {
    let mut random = Random::new(6);
    let mut renderer = renderer();
    let (mut rendered, mut surfaces) = (0, 0);
    for number in 0..1500 {
        let scale = if number % 2 == 0 { 1.0 } else { power(&mut random, -3.0, 4.0) };
        let offset = if number % 3 == 0 { scale * power(&mut random, -1.0, 2.0) } else { 0.0 };
        let seed = random.below(1000) as u32;
        let scene = RandomScene { seed, triangles: 60, spheres: 10, scale, offset, ..RandomScene::default() }.build();
        let place = |point: Vec3| point * scale + Vec3::splat(offset);
        // The angles range from just below the limit to four times the limit.
        let angle = MIN_PIXEL_ANGLE * 2_f32.powf(random.between(-0.2, 2.0));
        let camera = at_the_edge(&mut random, &scene, place, scale, angle);
        if camera.pose().is_err() {
            continue;
        }
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let all = [Method::Naive, Method::BRACKET_RAYS]
            .map(|method| renderer.pair(&uploaded, &camera).options(&Options::new(method).linear(true)).read().wait());
        if let [Err(Error::Camera { .. }), _] = all {
            continue;
        }
        let [naive, bracket] = all.map(Result::unwrap);
        rendered += 1;
        surfaces += naive.right.primitive.iter().filter(|&&primitive| primitive != MISS).count();
        if is_exact(&renderer) {
            assert_eq!(differing(&naive, &bracket), 0, "{number}: {camera:?}");
        }
    }
    assert!(rendered > 500 && surfaces > 50_000, "{rendered} {surfaces}");
}

/// Returns a random scene with a fine ball and a light in it. Everything is scaled by `scale`, a power of two.
fn scaled(seed: u32, radius: f32, target: Vec3, scale: f32) -> Scene {
    let source = RandomScene { seed, triangles: 60, spheres: 10, ..RandomScene::default() }.build();
    let mut scene = Scene::new();
    for mut part in [ball(target, radius, 40), {
        let corners: Vec<Vec3> = source.triangles().iter().flat_map(|triangle| triangle.corners).collect();
        let faces = (0..corners.len() as u32 / 3).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
        Mesh::new(corners, faces)
    }] {
        part.positions.iter_mut().for_each(|position| *position *= scale);
        scene.add_mesh(&part).unwrap();
    }
    for sphere in source.spheres() {
        scene.add_sphere(Sphere::new(sphere.center * scale, sphere.radius * scale, sphere.material)).unwrap();
    }
    scene.lights.push(Light::point(Vec3::new(1.0, 3.0, 2.0) * scale, Vec3::splat(0.5)));
    scene
}

#[test]
fn scenes_of_the_least_and_the_largest_scale_look_as_at_scale_one() {
    let mut random = Random::new(5);
    let mut renderer = renderer();
    for (seed, (radius, degrees)) in (0..).zip([(0.3, 40.0), (1e-3, 0.05), (1e-4, 0.0106)]) {
        let (eye, target) = (4.0 * random.point(1.0).normalize(), random.point(0.3));
        let mut pairs = |scale: f32| {
            let uploaded = renderer.upload(&scaled(seed, radius, target, scale)).wait().unwrap();
            let camera = StereoCamera::look_at(eye * scale, target * scale)
                .size(64, 48)
                .vertical_fov_degrees(degrees)
                .screen_distance(4.0 * scale)
                .interaxial_pixels(3.0);
            [Method::Naive, Method::BRACKET_RAYS].map(|method| {
                renderer.pair(&uploaded, &camera).options(&Options::new(method).linear(true)).read().wait().unwrap()
            })
        };
        let [at_one, _] = pairs(1.0);
        assert!(at_one.right.primitive.iter().filter(|&&primitive| primitive != MISS).count() > 100);
        for scale in [-21, 24].map(|exponent| 2_f32.powi(exponent)) {
            for mut pair in pairs(scale) {
                pair.right.depth.iter_mut().for_each(|depth| *depth /= scale);
                assert_eq!(differing(&at_one, &pair), 0, "scale {scale:e}, {degrees} degrees");
            }
        }
    }
}

/// Returns the low and high corner of a random box of any allowed scale and position. The box may be flat, a line or a
/// point.
fn random_bounds(random: &mut Random) -> (Vec3, Vec3) {
    let size = power(random, -7.0, 8.5);
    let side = |random: &mut Random| match random.below(3) {
        0 => 0.0,
        1 => size * random.unit(),
        _ => size,
    };
    let sides = Vec3::new(side(random), side(random), side(random));
    let place = if random.unit() < 0.3 { Vec3::ZERO } else { random.point(1.0) * power(random, -6.0, 8.3) };
    let clamp = |corner: Vec3| corner.clamp(Vec3::splat(-MAX_COORDINATE), Vec3::splat(MAX_COORDINATE));
    (clamp(place - 0.5 * sides), clamp(place + 0.5 * sides))
}

#[test]
fn a_fitting_camera_shows_both_eyes_the_whole_of_any_box() {
    let mut random = Random::new(8);
    let sizes = [(64, 48), (48, 64), (1, 1), (300, 100), (1600, 100), (100, 1600), (3840, 2160), (5000, 5000)];
    let largest = (Vec3::splat(-MAX_COORDINATE), Vec3::splat(MAX_COORDINATE));
    for number in 0..40_000 {
        let bounds = if number == 0 { largest } else { random_bounds(&mut random) };
        for (width, height) in [sizes[number % sizes.len()], sizes[(number / sizes.len()) % sizes.len()]] {
            let camera = StereoCamera::fitting((bounds.0.as_dvec3(), bounds.1.as_dvec3()), width, height);
            let pose = camera.pose().unwrap_or_else(|error| panic!("{bounds:?} at {width}x{height}: {error}"));
            for corner in 0..8 {
                let pick = |axis: usize| if corner >> axis & 1 == 0 { bounds.0[axis] } else { bounds.1[axis] };
                for side in [-1.0, 1.0] {
                    let [x, y, z] = pose.project(Vec3::new(pick(0), pick(1), pick(2)), side);
                    let inside = (0.0..=width as f32).contains(&x) && (0.0..=height as f32).contains(&y);
                    assert!(z > 0.0 && inside, "{bounds:?} at {width}x{height}: {x} {y} {z}");
                }
            }
        }
    }
}

fn framed(renderer: &mut Renderer, scene: &Scene) -> StereoPair {
    let uploaded = renderer.upload(scene).wait().unwrap();
    let camera = StereoCamera::fitting(scene.bounds().unwrap(), 48, 48);
    renderer.pair(&uploaded, &camera).options(&Options::default().linear(true)).read().wait().unwrap()
}

fn triangle(corners: [Vec3; 3]) -> Scene {
    let mut scene = Scene::new();
    scene.add_mesh(&Mesh::new(corners.to_vec(), vec![[0, 1, 2]])).unwrap();
    scene
}

#[test]
fn a_scene_that_is_taken_is_framed_and_what_is_too_small_is_refused_by_name() {
    let mut renderer = renderer();
    // The triangle lies in the xy plane, and the fitting camera sees its front.
    let shape = [Vec3::new(-0.5, -0.5, 0.0), Vec3::new(0.5, -0.5, 0.0), Vec3::new(0.0, 0.5, 0.0)];
    for scale in [1.1 * MIN_EXTENT, 1e-3, 1.0, 1e6, 1.9 * MAX_COORDINATE] {
        let scene = triangle(shape.map(|corner| corner * scale));
        let seen = framed(&mut renderer, &scene).left.primitive.iter().filter(|&&primitive| primitive == 0).count();
        assert!(seen > 200, "{scale:e}: {seen}");
    }
    // This triangle is a few steps of f32 wide. f32 can represent the eyes only relative to an origin that is nearer.
    let far = triangle(shape.map(|corner| 8.0 * corner + Vec3::splat(5e7)));
    let uploaded = renderer.upload(&far).wait().unwrap();
    let camera = StereoCamera::fitting(far.bounds().unwrap(), 48, 48);
    let message = renderer.pair(&uploaded, &camera).read().wait().unwrap_err().to_string();
    assert!(message.contains("a scene origin nearer to the camera"), "{message}");
    let mut far = triangle(shape.map(|corner| 8.0 * corner));
    far.set_origin(Vec3::splat(5e7)).unwrap();
    let seen = framed(&mut renderer, &far).left.primitive.iter().filter(|&&primitive| primitive == 0).count();
    assert!(seen > 200, "{seen}");

    let sphere = |center: Vec3, radius: f32| {
        let mut scene = Scene::new();
        scene.add_sphere(Sphere::new(center, radius, MaterialId(0))).unwrap();
        scene
    };
    for (small, side) in [
        (triangle(shape.map(|corner| corner * 1e-30)), "1e-30"),
        (triangle(shape.map(|corner| corner * 0.9 * MIN_EXTENT)), "9e-7"),
        (sphere(Vec3::X, 1e-9), "2e-9"),
    ] {
        let message = renderer.upload(&small).wait().unwrap_err().to_string();
        assert!(
            message.contains(&format!("geometry: its longest side is {side}; it must be at least 1e-6")),
            "{message}"
        );
    }
    // Far from the origin, the sphere's box is narrower than a step of f32, and the sphere is rendered like any other.
    renderer.upload(&sphere(Vec3::splat(1e6), 1e-3)).wait().unwrap();
    let mut mixed = triangle(shape.map(|corner| corner * 1e-30));
    mixed.add_sphere(Sphere::new(Vec3::X, 0.1, MaterialId(0))).unwrap();
    framed(&mut renderer, &mixed);
}
