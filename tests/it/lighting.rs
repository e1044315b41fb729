//! Tests lights, ambient light and the placement of lights, with invalid values and with default values.

use crate::common;

use common::renderer;
use stereotrace::{
    Ellipsoid, Error, Falloff, Light, Material, MaterialId, Mesh, Method, Options, Scene, Sky, Sphere, StereoCamera,
    Tone, blocking::Wait, glam::Vec3, scene::builtin::Builtin, testing::cpu::intersect::closest_hit,
};

#[test]
fn negative_light_and_reflectance_are_refused_by_name() {
    let negative = Vec3::new(0.5, -0.1, 0.5);
    let refused = |element: &str, reason: &str, spoil: &dyn Fn(&mut Scene)| {
        let mut scene = Scene::new();
        spoil(&mut scene);
        let Err(error @ Error::Scene { .. }) = renderer().upload(&scene).wait() else {
            panic!("{element} is not refused")
        };
        let expected =
            format!("invalid scene: {element}: {reason} is [0.5, -0.1, 0.5]; it must be finite and not negative");
        assert_eq!(error.to_string(), expected);
    };
    let light = Light::point(Vec3::splat(-1.0), negative);
    refused("ambient", "it", &|scene| scene.ambient = Some(negative));
    refused("light 0", "intensity", &|scene| scene.lights.push(light));
    refused("material 1 'tar'", "albedo", &|scene| {
        assert_eq!(scene.add_material(Material::new(negative).name("tar")).0, 1)
    });
    refused("sky", "it", &|scene| scene.sky = Sky::Constant(negative));
    refused("sky", "nadir", &|scene| scene.sky = Sky::Gradient { nadir: negative, zenith: Vec3::ONE });
    refused("sky", "zenith", &|scene| scene.sky = Sky::Gradient { nadir: Vec3::ONE, zenith: negative });
    let mut scene = Scene::new();
    scene.ambient = Some(Vec3::NEG_ONE * 0.0); // a negative zero is not negative
    scene.lights.push(Light::point(light.position, Vec3::ONE));
    assert!(renderer().upload(&scene).wait().is_ok());
}

#[test]
fn falloffs_and_cones_out_of_range_are_refused_by_name() {
    let point = Light::point(Vec3::Y, Vec3::ONE);
    let sun = Light::directional(Vec3::Y, 0.0, Vec3::ONE);
    let window = Light::rectangle(Vec3::Y, Vec3::X, Vec3::Z, Vec3::ONE);
    let ranged = |range: f32| {
        let mut light = point;
        light.falloff = Falloff::Quadratic { range: Some(range) };
        light
    };
    let down = Vec3::NEG_Y;
    for (light, reason) in [
        (ranged(0.0), "range is 0; it must be finite and above 0"),
        (ranged(f32::NAN), "range is NaN; it must be finite and above 0"),
        (sun.with_quadratic_falloff(), "a directional light has no falloff"),
        (sun.with_cone(down, 0.1, 0.2), "only points and spheres have a cone"),
        (window.with_cone(down, 0.1, 0.2), "only points and spheres have a cone"),
        (
            point.with_cone(Vec3::ZERO, 0.1, 0.2),
            "the length of the cone's direction is 0; it must be finite and above 0",
        ),
        (point.with_cone(down, 0.2, 0.2), "the cone's angles are 0.2 and 0.2; inner must be"),
        (point.with_cone(down, -0.1, 0.2), "the cone's angles are -0.1 and 0.2; inner must be"),
        (point.with_cone(down, 0.1, 1.6), "the cone's angles are 0.1 and 1.6; inner must be"),
        (point.with_cone(down, f32::NAN, 1.0), "the cone's angles are NaN and 1; inner must be"),
    ] {
        let mut scene = Scene::new();
        scene.lights.push(light);
        let Err(error @ Error::Scene { .. }) = renderer().upload(&scene).wait() else {
            panic!("{light:?} is not refused")
        };
        let expected = format!("invalid scene: light 0: {reason}");
        assert!(error.to_string().starts_with(&expected), "{error} is not {expected}");
    }
}

/// Returns a grey ground, level at y = 0, under the camera.
fn ground(half: f32) -> Scene {
    let mut scene = Scene::new();
    let corner = |x: f32, z: f32| Vec3::new(x * half, 0.0, z * half);
    let corners = vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    scene.add_mesh(&Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    scene
}

#[test]
fn ambient_light_makes_room_for_lights_unless_it_was_given() {
    let camera = StereoCamera::look_at(Vec3::new(0.0, 3.0, 0.1), Vec3::ZERO).size(9, 9);
    let shade = |ambient: Option<f32>, light: Option<f32>| {
        let mut scene = ground(10.0);
        scene.ambient = ambient.map(Vec3::splat);
        let overhead = |light| Light::point(Vec3::Y * 1e6, Vec3::splat(light));
        scene.lights.extend(light.map(overhead));
        common::render(&scene, &camera, Method::Naive).left.linear[40][0]
    };
    let near = |found: f32, ambient: f32| assert!((found - 0.7 * ambient).abs() < 1e-3, "{found} {ambient}");
    near(shade(None, None), 1.0);
    near(shade(None, Some(0.5)), 0.15 + 0.5);
    near(shade(Some(0.3), Some(0.5)), 0.3 + 0.5);
    near(shade(Some(0.0), Some(0.5)), 0.5);
    near(shade(Some(0.2), None), 0.2);
    near(shade(Some(1.0), Some(0.0)), 1.0); // the given value applies, though it equals the default without lights
}

#[test]
fn lights_by_rule_keep_the_ambient_light_that_was_given() {
    let camera = StereoCamera::look_at(Vec3::new(0.0, 3.0, 0.1), Vec3::ZERO);
    for given in [None, Some(Vec3::ZERO), Some(Vec3::ONE)] {
        for count in [0, 3] {
            let mut scene = ground(10.0);
            scene.ambient = given;
            scene.place_lights(count, &camera).unwrap();
            assert_eq!(scene.rendered_ambient(), given.unwrap_or(Vec3::splat(0.15)), "{given:?} {count}");
            let sum: Vec3 = scene.lights.iter().map(|light| light.intensity).sum();
            assert!(count == 0 || (sum - 0.85).abs().max_element() < 1e-6, "{sum}");
        }
    }
}

/// Checks that nothing is between the eye and a light, and that no light is in a sphere or an ellipsoid.
fn assert_seen(scene: &Scene, camera: &StereoCamera, case: &str) {
    let eye = camera.pose().unwrap().eye;
    for (index, light) in scene.lights.iter().enumerate() {
        let at = light.position;
        let (way, _) = closest_hit(scene, eye.as_vec3(), (at - eye).as_vec3(), 0.0, 1.0);
        assert!(way == 1.0, "{case}: light {index} at {at} is {way} of its way behind something");
        let inside = |sphere: &Sphere| at.distance(sphere.center.as_dvec3()) < f64::from(sphere.radius);
        assert!(!scene.spheres().iter().any(inside), "{case}: light {index} at {at} is in a sphere");
        let within = |one: &Ellipsoid| (one.axes.inverse() * (at.as_vec3() - one.center)).length() < 1.0;
        assert!(!scene.ellipsoids().iter().any(within), "{case}: light {index} at {at} is in an ellipsoid");
        assert!(at.distance(eye) > 0.01, "{case}: light {index} is in the eye");
    }
}

#[test]
fn lights_stand_in_the_eyes_surroundings_and_not_in_the_ground() {
    let object = Sphere::new(Vec3::Y, 1.0, MaterialId(0));
    for eye in [Vec3::new(0.0, 1.0, 6.0), Vec3::new(2.0, 0.3, 5.0), Vec3::new(0.0, 1.9, 3.0), Vec3::new(0.0, 8.0, 6.0)]
    {
        let camera = StereoCamera::look_at(eye, Vec3::Y);
        for radius in [20.0, 100.0, 1000.0, 1e4, 1e6] {
            let mut scene = Scene::new();
            let center = Vec3::NEG_Y * radius;
            scene.add_sphere(Sphere::new(center, radius, MaterialId(0))).unwrap();
            scene.add_sphere(object).unwrap();
            scene.place_lights(7, &camera).unwrap();
            assert_seen(&scene, &camera, &format!("ground sphere of {radius} under {eye}"));
        }
        for [width, height] in [[100.0, 50.0], [1000.0, 20.0], [1e4, 1e3], [20.0, 1000.0]] {
            let mut scene = Scene::new();
            let radii = Vec3::new(width, height, width);
            scene.add_ellipsoid(Ellipsoid::aligned(Vec3::NEG_Y * height, radii, MaterialId(0))).unwrap();
            scene.add_sphere(object).unwrap();
            scene.place_lights(7, &camera).unwrap();
            assert_seen(&scene, &camera, &format!("ground ellipsoid of {radii} under {eye}"));
        }
        for half in [200.0, 1e4, 1e6] {
            let mut scene = ground(half);
            scene.add_sphere(object).unwrap();
            // A triangle extends as far below the ground as above it, so that the bounding box is as high as the ground
            // is wide.
            let tower = Vec3::new(0.5 * half, half, 0.0);
            let mast = vec![tower, Vec3::new(0.5 * half, -half, 0.0), tower + Vec3::X];
            scene.add_mesh(&Mesh::new(mast, vec![[0, 1, 2]])).unwrap();
            scene.place_lights(7, &camera).unwrap();
            assert_seen(&scene, &camera, &format!("ground of {half} under {eye}"));
            assert!(scene.lights.iter().all(|light| light.position.y > 0.0), "{half} {eye}");
        }
    }
}

/// Tests the documented rule without its second part.
#[test]
fn built_in_scenes_have_their_lights_in_their_boxes() {
    for &builtin in Builtin::ALL {
        let (mut scene, camera) = (builtin.scene(), builtin.camera(640, 480));
        scene.place_lights(5, &camera).unwrap();
        let pose = camera.pose().unwrap();
        let (low, high) = scene.bounds().unwrap();
        let inset = 0.05 * (high - low);
        let inside = pose.eye.cmpgt(low).all() && pose.eye.cmplt(high).all();
        for (k, light) in scene.lights.iter().enumerate() {
            let (sin, cos) = (k as f32 * 2.399_963_2).sin_cos();
            let reach = pose.screen_distance * (0.25 + 0.1 * (k as f32 + 0.5));
            let mut expected = pose.eye + ((pose.right * cos + pose.up * sin.abs()) * reach).as_dvec3();
            if inside {
                expected = expected.clamp(low + inset, high - inset);
            }
            assert!(light.position.distance(expected) < 1e-4, "{builtin} {k}: {} {expected}", light.position);
        }
    }
}

#[test]
fn pictures_show_linear_light_exposed_and_clamped_or_bent() {
    let (mut scene, camera) = (Builtin::Spheres.scene(), Builtin::Spheres.camera(64, 48));
    scene.lights.iter_mut().for_each(|light| light.intensity *= 3.0);
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let encoded = |linear: f64| {
        let srgb = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
        255.0 * srgb
    };
    let film = |x: f64| ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0);
    for (stops, tone, samples) in [
        (0.0, Tone::Clamp, 1),
        (-2.0, Tone::Clamp, 1),
        (0.0, Tone::Filmic, 1),
        (1.5, Tone::Filmic, 1),
        (-1.0, Tone::Filmic, 4),
    ] {
        for method in [Method::Naive, Method::BRACKET, Method::ATOMIC] {
            let options = Options::new(method).linear(true).exposure(stops).tone(tone).samples(samples);
            let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
            for view in [&pair.left, &pair.right] {
                assert!(view.linear.iter().any(|color| color[0] > 1.5), "light is as bright as it comes");
                for (color, shown) in view.linear.iter().zip(&view.rgba8) {
                    for (&linear, &byte) in color.iter().zip(shown).take(3) {
                        let exposed = f64::from(linear) * f64::from(stops).exp2();
                        let expected = encoded(if tone == Tone::Filmic { film(exposed) } else { exposed.min(1.0) });
                        assert!(
                            (expected - f64::from(byte)).abs() < 0.51,
                            "{linear} {byte} {expected} {tone:?} {stops}"
                        );
                    }
                }
            }
        }
    }
    for stops in [f32::NAN, 65.0, f32::INFINITY] {
        let error = renderer
            .pair(&uploaded, &camera)
            .options(&Options::default().exposure(stops))
            .read()
            .wait()
            .unwrap_err()
            .to_string();
        assert!(error.contains("exposure") && error.contains("it must be -64 to 64 stops"), "{error}");
    }
}
