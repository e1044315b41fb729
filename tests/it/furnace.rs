//! Tests white furnaces, in which the same light comes from everywhere. No surface sends back more light than it
//! receives. A surface that loses none looks like its surroundings.

use crate::common;

use common::{floor::floor, renderer};
use stereotrace::{
    Finish, Light, Material, Method, Options, Renderer, Scene, Sky, Sphere, StereoCamera, View,
    blocking::Wait,
    glam::{DVec3, Vec3},
    testing::cpu::{Eye, Frame},
};

const PI: f64 = std::f64::consts::PI;

/// Returns a ball in a white sky.
fn ball(material: Material) -> Scene {
    let mut scene = Scene::new();
    let material = scene.add_material(material);
    scene.add_sphere(Sphere::new(Vec3::ZERO, 1.0, material)).unwrap();
    scene.sky = Sky::Constant(Vec3::ONE);
    scene.ambient = Some(Vec3::ZERO);
    scene
}

fn seen(renderer: &mut Renderer, scene: &Scene, options: &Options) -> View {
    let camera = StereoCamera::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO).size(49, 49).interaxial(0.0);
    let uploaded = renderer.upload(scene).wait().unwrap();
    renderer.pair(&uploaded, &camera).options(&options.clone().linear(true)).read().wait().unwrap().left
}

#[test]
fn a_white_sky_comes_back_from_what_loses_none_and_never_more_of_it() {
    let mut renderer = renderer();
    let naive = Options::new(Method::Naive).sky_rays(32).bounces(8);
    let mirror = |fresnel| Finish::Mirror { fresnel };
    let glass = |index, fresnel| Finish::Glass { index, transmission: Vec3::ONE, fresnel };
    let plain = |albedo: f32, specular: f32| Material::new(Vec3::splat(albedo)).specular(Vec3::splat(specular));
    // If a ray enters a glass ball at a grazing angle, some light is still inside after the last bounce.
    for (name, material, least, most) in [
        ("diffuse", plain(1.0, 0.0), 1.0, 1.0),
        ("grey", plain(0.25, 0.0), 0.25, 0.25),
        ("mirror", plain(0.0, 1.0).finish(mirror(false)), 1.0, 1.0),
        ("half a mirror", plain(0.5, 0.5).finish(mirror(false)), 1.0, 1.0),
        ("mirror by Fresnel", plain(0.0, 0.25).finish(mirror(true)), 0.25, 1.0),
        ("glass by Fresnel", plain(0.0, 1.0).finish(glass(1.5, true)), 0.95, 1.0),
        ("half reflecting glass", plain(0.0, 0.5).finish(glass(1.5, false)), 0.9, 1.0),
        ("bubble", plain(0.0, 1.0).finish(glass(0.75, true)), 0.95, 1.0),
        ("glossy", plain(0.5, 0.5).normalised(true), 0.5, 0.5),
        ("veil", plain(1.0, 0.0).opacity(0.5), 0.5, 1.0),
    ] {
        let view = seen(&mut renderer, &ball(material), &naive);
        let there = view.linear.iter().zip(&view.depth).filter(|(_, depth)| depth.is_finite());
        let shades: Vec<f32> = there.map(|(color, _)| color[1]).collect();
        let (darkest, brightest) =
            shades.iter().fold((f32::INFINITY, 0.0_f32), |(low, high), shade| (low.min(*shade), high.max(*shade)));
        println!("{name}: {darkest:.5} to {brightest:.5} of {} pixels", shades.len());
        assert!(
            shades.len() > 500 && darkest >= least - 1e-5 && brightest <= most + 1e-5,
            "{name}: {darkest} {brightest}"
        );
    }
}

/// Returns the light from `to_light` that a surface with only a normalised lobe sends towards `to_eye`, times the
/// cosine.
fn lobe(exponent: f64, to_light: DVec3, to_eye: DVec3) -> f64 {
    let mirrored = DVec3::new(-to_light.x, to_light.y, -to_light.z);
    let cosine = mirrored.dot(to_eye);
    if cosine <= 0.0 { 0.0 } else { (exponent + 2.0) / 2.0 * cosine.powf(exponent) * to_light.y }
}

/// Returns points of a hemisphere that stand for equal solid angles (a Fibonacci lattice).
fn hemisphere(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |index| {
        let y = (f64::from(index) + 0.5) / f64::from(count);
        let around = f64::from(index) * PI * (3.0 - 5.0_f64.sqrt());
        let across = (1.0 - y * y).sqrt();
        DVec3::new(across * around.cos(), y, across * around.sin())
    })
}

fn towards(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(sin, cos, 0.0)
}

#[test]
fn a_normalised_lobe_is_all_of_the_light_straight_above_and_less_aside() {
    let count = 400_000;
    for exponent in [0.0, 1.0, 7.5, 30.0, 300.0] {
        let share = |degrees: f64| {
            let to_eye = towards(degrees);
            hemisphere(count).map(|to_light| lobe(exponent, to_light, to_eye)).sum::<f64>() * 2.0 / f64::from(count)
        };
        let shares = [0.0, 30.0, 60.0, 89.0].map(share);
        println!("exponent {exponent}: {shares:.4?}");
        assert!((shares[0] - 1.0).abs() < 2e-3, "{exponent}: {shares:?}");
        assert!(shares.iter().all(|share| *share < 1.002) && shares.is_sorted_by(|a, b| *a > b - 2e-3), "{shares:?}");
    }
}

/// Tests a floor lit by points that stand for a white sky, seen from an angle.
#[test]
fn kernels_make_the_normalised_lobe_and_leave_mtls_as_it_is() {
    let count = 1500;
    let far = 1e4;
    let mut renderer = renderer();
    for (exponent, normalised) in [(0.0_f32, true), (1.0, true), (12.5, true), (40.0, true), (12.5, false)] {
        let (albedo, specular) = (0.4, 0.6);
        let glossy = Material::new(Vec3::splat(albedo)).specular(Vec3::splat(specular)).exponent(exponent);
        let mut scene = floor();
        scene.shadows = false;
        // A plate lies above the floor, which stays white. A ball with MTL's highlights is beside it, out of sight.
        let plate = scene.add_material(glossy.clone().normalised(normalised));
        let other = scene.add_material(glossy.normalised(false));
        let corners = [[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]].map(|[x, z]| Vec3::new(x, 1.0, z)).to_vec();
        let mesh = stereotrace::Mesh::new(corners, vec![[0, 2, 1], [0, 3, 2]]).materials(vec![plate; 2]);
        scene.add_mesh(&mesh).unwrap();
        scene.add_sphere(Sphere::new(Vec3::new(0.0, -30.0, 0.0), 1.0, other)).unwrap();
        let each = 2.0 / f64::from(count);
        let lights: Vec<DVec3> = hemisphere(count).collect();
        let point = |to: &DVec3| Light::point((to * far).as_vec3(), Vec3::splat(each as f32));
        scene.lights = lights.iter().map(point).collect();
        let uploaded = renderer.upload(&scene).wait().unwrap();
        for degrees in [0.0, 45.0, 80.0] {
            let to_eye = towards(degrees);
            let eye = to_eye.as_vec3() * 8.0 + Vec3::Y;
            let camera = StereoCamera::look_at(eye, Vec3::Y).up(Vec3::Z).size(9, 9).vertical_fov_degrees(2.0);
            let camera = camera.interaxial(0.0);
            let pair = renderer
                .pair(&uploaded, &camera)
                .options(&Options::new(Method::Naive).linear(true))
                .read()
                .wait()
                .unwrap();
            let frame = Frame::new(&camera.pose().unwrap());
            let mut most = 0.0_f64;
            for (index, color) in pair.left.linear.iter().enumerate() {
                let direction = frame.direction(Eye::Left, index % 9, index / 9).as_dvec3();
                let at = eye.as_dvec3() + direction * f64::from(pair.left.depth[index]);
                let to_eye = -direction.normalize();
                let from = |to: &DVec3| {
                    let to_light = (to * far - at).normalize();
                    let by_rule = lobe(f64::from(exponent), to_light, to_eye);
                    let plain = 2.0 / (f64::from(exponent) + 2.0) * by_rule / to_light.y;
                    let shine = if normalised { by_rule } else { plain };
                    each * (f64::from(albedo) * to_light.y.max(0.0) + f64::from(specular) * shine)
                };
                let expected: f64 = lights.iter().map(from).sum();
                let found = f64::from(color[0]);
                assert!((found - expected).abs() < 1e-4, "{exponent} {degrees} {index}: {found} for {expected}");
                most = most.max(found);
            }
            println!("exponent {exponent}, normalised {normalised}, {degrees} degrees: {most:.4}");
            // The bound allows for the deviation of 1500 points from a hemisphere.
            assert!(!normalised || most < 1.005 && (degrees > 0.0 || most > 0.995), "{exponent} {degrees}: {most}");
        }
    }
}

#[test]
fn a_ball_of_hardly_any_size_has_the_highlights_of_a_point() {
    let mut renderer = renderer();
    for normalised in [true, false] {
        let glossy = Material::new(Vec3::splat(0.3)).specular(Vec3::splat(0.5)).exponent(20.0);
        let lit_by = |light| {
            let mut scene = ball(glossy.clone().normalised(normalised));
            scene.lights.push(light);
            scene
        };
        let place = Vec3::new(1.0, 3.0, 4.0);
        let options = Options::new(Method::Naive).shadow_rays(7);
        let by_point = seen(&mut renderer, &lit_by(Light::point(place, Vec3::splat(0.7))), &options);
        let by_ball = seen(&mut renderer, &lit_by(Light::sphere(place, 1e-4, Vec3::splat(0.7))), &options);
        let brightest = by_point.linear.iter().map(|color| color[0]).fold(0.0, f32::max);
        println!("normalised {normalised}: brightest {brightest}");
        for (point, ball) in by_point.linear.iter().zip(&by_ball.linear) {
            assert!((point[0] - ball[0]).abs() < 2e-3, "{point:?} {ball:?}");
        }
    }
}
