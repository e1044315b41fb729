//! Tests the sky as a light. It is compared with closed forms and with sums over its pixels in double precision, and
//! methods are compared with each other.

use crate::common;

use common::{
    floor::{errors, floor, light_on_floor, naive},
    gpu, is_exact,
    random::Random,
    renderer,
    shown_sky::{Shown, noisy},
};
use stereotrace::{
    AmbientOcclusion, Error, Fetch, Finish, Light, Material, Mesh, Method, Options, Penumbra, Renderer, Scene, Sky,
    SkyMap, Sphere, StereoCamera, StereoPair, Traversal, Update,
    blocking::Wait,
    glam::{DVec3, Vec3},
    scene::builtin::Builtin,
};

const PI: f64 = std::f64::consts::PI;

fn lit(rays: u32) -> Options {
    naive().sky_rays(rays)
}

#[test]
fn a_surface_shows_its_albedo_under_a_sky_of_one() {
    let mut renderer = renderer();
    let sky = Vec3::new(1.0, 0.5, 2.0);
    let albedo = Vec3::new(0.25, 1.0, 0.75);
    let mut ball = Scene::new();
    let painted = ball.add_material(Material::new(albedo));
    ball.add_sphere(Sphere::new(Vec3::ZERO, 1.0, painted)).unwrap();
    let at_ball = StereoCamera::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO).size(33, 33);
    let at_floor = StereoCamera::look_at(Vec3::new(10.0, 3.0, 0.0), Vec3::X * 12.0).size(33, 33);
    for (mut scene, camera, albedo) in [(ball, at_ball, albedo), (floor(), at_floor, Vec3::ONE)] {
        scene.sky = Sky::Constant(sky);
        // Ambient light would be added to the sky's light if it were not replaced.
        scene.ambient = Some(Vec3::splat(0.4));
        let uploaded = renderer.upload(&scene).wait().unwrap();
        for rays in [1, 3, 4, 16, 31, 32] {
            let pair = renderer.pair(&uploaded, &camera).options(&lit(rays).linear(true)).read().wait().unwrap();
            let surfaces = pair.left.linear.iter().zip(&pair.left.primitive);
            let mut count = 0;
            for (color, _) in surfaces.filter(|(_, primitive)| **primitive != stereotrace::MISS) {
                let off = (Vec3::new(color[0], color[1], color[2]) - albedo * sky).abs().max_element();
                assert!(off < 1e-5, "{rays}: {color:?} {}", albedo * sky);
                count += 1;
            }
            assert!(count > 300, "{rays}: {count}");
        }
    }
    let mut scene = floor();
    // The floor receives nothing from the sky below the horizon.
    scene.sky = Sky::Gradient { nadir: Vec3::splat(9.0), zenith: Vec3::ZERO };
    let flat = light_on_floor(&scene, &lit(32), 2.0, 32);
    let (largest, rms) = errors(&flat, |_, _| 9.0 * (0.5 - 1.0 / 3.0));
    println!("gradient on a floor: largest {largest:.4}, rms {rms:.5}");
    assert!(largest < 0.04 && rms < 0.01, "{largest} {rms}");
}

#[test]
fn a_gradient_lights_a_ball_by_its_closed_form() {
    let mut scene = Scene::new();
    let white = scene.add_material(Material::new(Vec3::ONE));
    scene.add_sphere(Sphere::new(Vec3::ZERO, 1.0, white)).unwrap();
    let (nadir, zenith) = (Vec3::new(0.2, 0.1, 0.9), Vec3::new(0.5, 1.5, 0.3));
    scene.sky = Sky::Gradient { nadir, zenith };
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let camera = StereoCamera::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO).size(40, 40).interaxial(0.0);
    let frame = stereotrace::testing::cpu::Frame::new(&camera.pose().unwrap());
    let seeds = 32;
    let mut sums = vec![DVec3::ZERO; 1600];
    let (mut first_squares, mut squares, mut count) = (0.0, 0.0, 0);
    for seed in 0..seeds {
        let pair = renderer.pair(&uploaded, &camera).options(&lit(16).seed(seed).linear(true)).read().wait().unwrap();
        for (index, (sum, color)) in sums.iter_mut().zip(&pair.left.linear).enumerate() {
            *sum += DVec3::new(color[0].into(), color[1].into(), color[2].into()) / f64::from(seeds);
            let depth = pair.left.depth[index];
            if !depth.is_finite() || seed + 1 < seeds && seed > 0 {
                continue;
            }
            let d = frame.direction(stereotrace::testing::cpu::Eye::Left, index % 40, index / 40);
            let normal = camera.pose().unwrap().eye + d.as_dvec3() * f64::from(depth);
            // The closed form is the integral of (1 + y) / 2 times the cosine, over pi. The mean of y is 2/3 of the
            // normal's y.
            let form = nadir.as_dvec3().lerp(zenith.as_dvec3(), 0.5 + normal.y / 3.0);
            let mean = if seed == 0 { *sum * f64::from(seeds) } else { *sum };
            if seed == 0 {
                first_squares += (mean - form).length_squared();
                count += 1;
            } else {
                squares += (mean - form).length_squared();
            }
        }
    }
    let [first, many] = [first_squares, squares].map(|squares| (squares / f64::from(count)).sqrt());
    println!("gradient: rms {first:.5} of 16 rays, {many:.5} of 512, {count} pixels");
    assert!(count > 400 && first < 0.03 && many < 0.005, "{first} {many} {count}");
}

/// Tests a wall without end beside a floor. It hides half of the sky from every point of the floor.
#[test]
fn a_wall_without_end_keeps_half_of_the_sky_off() {
    let mut scene = floor();
    let black = scene.add_material(Material::new(Vec3::ZERO));
    let far = 2e4;
    let corners = vec![
        Vec3::new(-0.5, -1.0, -far),
        Vec3::new(-0.5, far, -far),
        Vec3::new(-0.5, far, far),
        Vec3::new(-0.5, -1.0, far),
    ];
    scene.add_mesh(&Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).materials(vec![black; 2])).unwrap();
    let half_of = |scene: &Scene, whole: f64, seeds, most: [f64; 2]| {
        let mut pixels = light_on_floor(scene, &lit(32), 3.0, seeds);
        pixels.retain(|&[x, ..]| x > -0.4);
        let mean = pixels.iter().map(|[.., light]| light).sum::<f64>() / pixels.len() as f64;
        let (largest, rms) = errors(&pixels, |_, _| 0.5 * whole);
        println!("wall: mean {mean:.5} of {whole}, largest {largest:.4}, rms {rms:.4}");
        assert!((mean - 0.5 * whole).abs() < most[0] && rms < most[1], "{mean} {rms}");
    };
    scene.sky = Sky::Constant(Vec3::ONE);
    half_of(&scene, 1.0, 1, [0.004, 0.05]);
    scene.sky = Sky::Gradient { nadir: Vec3::ZERO, zenith: Vec3::ONE };
    half_of(&scene, 5.0 / 6.0, 1, [0.004, 0.05]);
    scene.sky = Sky::Map(SkyMap::new(64, 32, vec![Vec3::ONE; 2048]).unwrap());
    half_of(&scene, 1.0, 8, [0.004, 0.05]);
}

/// Returns the root mean square error of 16 rays with a cosine distribution, over random shifts. Rays are spread as in
/// the kernels.
fn noise_by_cosine(sky: &Shown, light: f64) -> f64 {
    let mut random = Random(3);
    let shifts = 4096;
    let squares = (0..shifts).map(|_| {
        let spin = [random.unit(), random.unit()].map(f64::from);
        let ray = |index: u32| {
            let u = ((f64::from(index) + 0.5) / 16.0 + spin[0]).fract();
            let turn = (f64::from(index.reverse_bits() >> 8) / 16_777_216.0 + spin[1]).fract() * 2.0 * PI;
            let d = DVec3::new(u.sqrt() * turn.cos(), (1.0 - u).sqrt(), u.sqrt() * turn.sin());
            let place = (d.x.atan2(-d.z) / (2.0 * PI) + 0.5, d.y.acos() / PI);
            sky.at(place.0 * sky.width as f64, place.1 * sky.height as f64).x
        };
        let mean = (0..16).map(ray).sum::<f64>() / 16.0;
        (mean - light).powi(2)
    });
    (squares.sum::<f64>() / f64::from(shifts)).sqrt()
}

#[test]
fn a_sun_of_one_pixel_lights_by_its_angle_and_makes_little_noise() {
    let (width, height) = (128, 64);
    let mut sun = Shown { width, height, pixels: vec![Vec3::ZERO; width * height] };
    let (row, column) = (20, 50);
    sun.pixels[row * width + column] = Vec3::splat(1000.0);
    let mut scene = floor();
    scene.sky = Sky::Map(sun.map());
    let brute = sun.light(DVec3::Y, 16, |_| true).x;
    // The closed form is the pixel's radiance times its solid angle and cosine. Bilinear interpolation keeps the sum.
    let down = (row as f64 + 0.5) / height as f64 * PI;
    let form = 1000.0 * (2.0 * PI * PI / (width * height) as f64 * down.sin()) * down.cos() / PI;
    assert!((brute / form - 1.0).abs() < 0.002, "{brute} {form}");
    let noise = |rays: u32, seeds: u32| errors(&light_on_floor(&scene, &lit(rays), 2.0, seeds), |_, _| brute).1 / brute;
    let (once, often) = (noise(16, 1), noise(16, 32));
    let by_cosine = noise_by_cosine(&sun, brute) / brute;
    println!("sun: {brute:.5} by pixels, {form:.5} by form; rms {once:.5}, {often:.5} of 32; by cosine {by_cosine:.3}");
    assert!(once < 0.05 && often < 0.01 && by_cosine > 40.0 * once, "{once} {often} {by_cosine}");
}

#[test]
fn a_map_lights_a_floor_beside_a_ball_as_the_sum_over_its_pixels() {
    let sky = noisy(48, 24);
    let mut scene = floor();
    let black = scene.add_material(Material::new(Vec3::ZERO));
    scene.add_sphere(Sphere::new(Vec3::Y, 1.0, black)).unwrap();
    scene.sky = Sky::Map(sky.map());
    let mut pixels = light_on_floor(&scene, &lit(32), 4.0, 64);
    pixels.retain(|&[x, z, _]| x * x + z * z > 1.3);
    let open_from = |x: f64, z: f64| {
        move |d: DVec3| {
            let to_ball = DVec3::new(-x, 1.0, -z);
            let along = to_ball.dot(d);
            along < 0.0 || to_ball.length_squared() - along * along > 1.0
        }
    };
    let (mut sum, mut squares, mut count, mut mean) = (0.0, 0.0, 0.0, 0.0);
    for &[x, z, light] in pixels.iter().step_by(7) {
        let expected = sky.light(DVec3::Y, 8, open_from(x, z)).x;
        sum += light - expected;
        squares += (light - expected).powi(2);
        mean += expected;
        count += 1.0;
    }
    let (bias, rms) = (sum / mean, (squares / count).sqrt() / (mean / count));
    println!("noisy map beside a ball: bias {bias:.5}, rms {rms:.4}, {count} points");
    assert!(bias.abs() < 0.002 && rms < 0.02, "{bias} {rms}");
}

#[test]
fn maps_are_weighed_wherever_their_pixels_stand() {
    // The larger map is uploaded in pieces, which begin and end within rows of the texture.
    for sky in [noisy(64, 32), noisy(2050, 1025)] {
        let expected = sky.light(DVec3::Y, 1, |_| true).x;
        let mut scene = floor();
        scene.sky = Sky::Map(sky.map());
        let mut seen = Vec::new();
        for fetch in [Fetch::Texture, Fetch::Buffer] {
            let gpu = gpu();
            let mut renderer = Renderer::with_traversal(gpu.clone(), Traversal::of(&gpu).fetch(fetch));
            let camera = StereoCamera::look_at(Vec3::new(0.0, 2.0, 0.1), Vec3::ZERO).size(24, 24);
            let mut uploaded = renderer.upload(&scene).wait().unwrap();
            let options = lit(32).linear(true);
            // A frame by ambient light comes first. Later frames must not change it.
            let plain = renderer.pair(&uploaded, &camera).options(&naive().linear(true)).read().wait().unwrap();
            let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
            assert!(
                plain
                    == without_times(
                        renderer.pair(&uploaded, &camera).options(&naive().linear(true)).read().wait().unwrap(),
                        &plain
                    )
            );
            // The refit leaves the table of the sky in place. A further light moves the table.
            renderer.update(&mut uploaded, &scene, Update::Refit).wait().unwrap();
            assert!(pair.left == renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap().left);
            let mut with_light = scene.clone();
            with_light.lights.push(Light::point(Vec3::Y * 1e3, Vec3::splat(0.25)));
            renderer.update(&mut uploaded, &with_light, Update::Refit).wait().unwrap();
            let brighter = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
            let anew = renderer.upload(&with_light).wait().unwrap();
            assert!(brighter.left == renderer.pair(&anew, &camera).options(&options).read().wait().unwrap().left);
            let mean = pair.left.linear.iter().map(|color| f64::from(color[0])).sum::<f64>() / 576.0;
            println!("{:?}: {fetch:?}: {mean:.5} for {expected:.5}", scene.sky);
            assert!((mean / expected - 1.0).abs() < 0.01, "{mean} {expected}");
            seen.push((pair.left, is_exact(&renderer)));
        }
        assert!(!seen[0].1 || seen[0].0 == seen[1].0);
    }
}

/// Returns the pair with the times of another pair, since times differ.
fn without_times(pair: StereoPair, other: &StereoPair) -> StereoPair {
    let mut pair = pair;
    pair.statistics.times.clone_from(&other.statistics.times);
    pair
}

#[test]
fn black_skies_light_nothing_and_mirrors_show_what_the_sky_lights() {
    let mut scene = floor();
    for sky in [
        Sky::Constant(Vec3::ZERO),
        Sky::Gradient { nadir: Vec3::ZERO, zenith: Vec3::ZERO },
        Sky::Map(SkyMap::new(2, 1, vec![Vec3::ZERO; 2]).unwrap()),
        Sky::Map(SkyMap::new(16, 8, vec![Vec3::ZERO; 128]).unwrap()),
    ] {
        scene.sky = sky;
        for rays in [1, 2, 7, 32] {
            assert!(light_on_floor(&scene, &lit(rays), 2.0, 1).iter().all(|[.., light]| *light == 0.0));
        }
    }
    // The map is black except for a row, so all rays drawn by brightness come from there. The row is as bright as f32
    // allows.
    for bright in [1.0, 1e-30, 1e30] {
        let row = |index: usize| Vec3::splat(if (32..48).contains(&index) { bright } else { 0.0 });
        let banded = Shown { width: 16, height: 8, pixels: (0..128).map(row).collect() };
        scene.sky = Sky::Map(banded.map());
        let expected = banded.light(DVec3::Y, 32, |_| true).x;
        let pixels = light_on_floor(&scene, &lit(32), 2.0, 16);
        let mean = pixels.iter().map(|[.., light]| light).sum::<f64>() / pixels.len() as f64;
        assert!((mean / expected - 1.0).abs() < 0.01, "{bright}: {mean} {expected}");
    }
    scene.sky = Sky::Constant(Vec3::splat(0.5));
    let finish = Finish::Mirror { fresnel: false };
    let mirror = scene.add_material(Material::new(Vec3::ZERO).specular(Vec3::ONE).finish(finish));
    let corners = [[-3.0, 0.0], [3.0, 0.0], [3.0, 6.0], [-3.0, 6.0]].map(|[x, y]| Vec3::new(x, y, -3e4));
    scene.add_mesh(&Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).materials(vec![mirror; 2])).unwrap();
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    // The camera looks straight at the mirror, which shows the sky. The floor is too far away to hide any sky.
    let camera = StereoCamera::look_at(Vec3::new(0.0, 3.0, -3e4 + 8.0), Vec3::new(0.0, 3.0, -3e4)).size(9, 9);
    let pair = renderer.pair(&uploaded, &camera).options(&lit(32).linear(true)).read().wait().unwrap();
    assert!(pair.left.linear.iter().all(|color| (color[0] - 0.5).abs() < 1e-5), "{:?}", pair.left.linear);
}

/// Returns balls, boxes or a hall under a sky with a sun, and a light with a penumbra.
fn stage(builtin: Builtin, sky: Sky) -> (Scene, StereoCamera) {
    let mut scene = builtin.scene();
    scene.lights.truncate(2);
    if let Some(light) = scene.lights.first_mut() {
        *light = Light::sphere(light.position, 0.1, light.intensity);
    }
    scene.sky = sky;
    (scene, builtin.camera(150, 101))
}

fn skies() -> [Sky; 3] {
    [
        Sky::Constant(Vec3::new(0.5, 0.6, 0.7)),
        Sky::Gradient { nadir: Vec3::splat(0.1), zenith: Vec3::new(0.5, 0.7, 0.9) },
        Sky::Map(noisy(64, 32).map()),
    ]
}

fn identical(a: &stereotrace::View, b: &stereotrace::View) -> f64 {
    let same = a.rgba8.iter().zip(&b.rgba8).filter(|(a, b)| a == b).count();
    100.0 * same as f64 / a.rgba8.len() as f64
}

#[test]
fn methods_are_naive_to_the_bit_or_as_near_as_they_say() {
    let mut renderer = renderer();
    let exact = is_exact(&renderer);
    for (builtin, sky) in [Builtin::Near, "random-20".parse().unwrap(), Builtin::Near].into_iter().zip(skies()) {
        let (scene, camera) = stage(builtin, sky);
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let mut render = |method: Method, penumbra: Penumbra| {
            let options = Options::new(method).sky_rays(12).shadow_rays(8).linear(true).penumbra(penumbra);
            let mut pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
            assert!(!pair.statistics.in_steps);
            pair.statistics.times = None;
            pair
        };
        let truth = render(Method::Naive, Penumbra::Exact);
        assert!(truth == render(Method::Naive, Penumbra::Exact), "{builtin:?}: a frame repeats");
        let own = render(Method::BRACKET_RAYS, Penumbra::Exact);
        assert!(!exact || (truth.left == own.left && truth.right == own.right), "{builtin:?} {:?}", scene.sky);
        for method in [Method::ATOMIC, Method::ES_ISLER, "buffer".parse().unwrap(), Method::VERIFIED] {
            let pair = render(method, Penumbra::Exact);
            assert!(!exact || pair.left == truth.left, "{builtin:?} {method}");
        }
        let of_naive =
            |pair: &StereoPair| pair.statistics.right.rays.shadow as f64 / truth.statistics.right.rays.shadow as f64;
        let exact_pair = render(Method::BRACKET, Penumbra::Exact);
        let share = identical(&exact_pair.right, &truth.right);
        let shared = render(Method::BRACKET, Penumbra::default());
        let off = shared.right.linear.iter().zip(&truth.right.linear);
        let mean = off.map(|(a, b)| f64::from((a[1] - b[1]).abs())).sum::<f64>() / truth.right.linear.len() as f64;
        let rays = [of_naive(&exact_pair), of_naive(&shared)];
        println!("{builtin:?} {:?}: exact {share:.2}% identical, rays {rays:.3?}; shared {mean:.4} off", scene.sky);
        assert!(share > 97.0 && rays[0] < 1.0 && rays[1] < 0.4 && mean < 0.02, "{builtin:?} {share} {rays:?} {mean}");
    }
}

#[test]
fn what_can_not_be_rendered_is_refused_by_name() {
    let (scene, camera) = stage(Builtin::Near, Sky::Constant(Vec3::ONE));
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    for (options, text) in [
        (lit(0), "sky_rays: 0; it must be 1 to 32"),
        (lit(33), "sky_rays: 33; it must be 1 to 32"),
        (lit(u32::MAX), "sky_rays: 4294967295"),
        (
            lit(4).ambient_occlusion(AmbientOcclusion::new(4, 1.0)),
            "occlusion: sky light (sky_rays) replaces ambient light",
        ),
    ] {
        let error = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap_err();
        assert!(matches!(error, Error::Options { .. }) && error.to_string().contains(text), "{error}");
    }
    assert!(renderer.pair(&uploaded, &camera).options(&lit(4).sky_rays(None)).read().wait().is_ok());
}
