//! Tests frames that need more loop rounds per thread than an adapter allows. llvmpipe ends all loops of a thread after
//! 65,535 rounds. That costs time but must not change a picture.

use crate::common;

use common::{ball, is_exact, random::Random, renderer};
use stereotrace::{
    FAR, Light, MISS, Mesh, Method, Options, Ray, Scene, StereoCamera,
    blocking::Wait,
    glam::Vec3,
    testing::cpu::{Eye, Frame, intersect::closest_hit},
    wgpu,
};

/// Returns whether frames like these must take steps. Adapters without a bound on loops may render them at once.
fn has_a_bound(renderer: &stereotrace::Renderer) -> bool {
    renderer.gpu().adapter_info().device_type == wgpu::DeviceType::Cpu
}

/// Returns triangles that all cover the picture's middle, each tilted a little, so that every box contains all of them.
fn stack_of_triangles(count: u32) -> Scene {
    let mut random = Random::new(3);
    let positions = (0..count).flat_map(|_| {
        [(-3.0, -2.0), (3.0, -2.0), (0.0, 4.0)].map(|(x, y)| Vec3::new(x, y, 0.0) + 1e-3 * random.point(1.0))
    });
    let mut scene = Scene::new();
    scene
        .add_mesh(&Mesh::new(positions.collect(), (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()))
        .unwrap();
    scene
}

/// Returns the closest hit of each left pixel by a search through all primitives.
fn searched(scene: &Scene, frame: &Frame, eye: Eye) -> Vec<u32> {
    let [width, height] = frame.size();
    let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
    pixels.map(|(x, y)| closest_hit(scene, frame.eye(eye), frame.direction(eye, x, y), 0.0, FAR).1).collect()
}

#[test]
fn rays_that_meet_all_of_thirty_thousand_triangles_find_the_first() {
    let mut scene = stack_of_triangles(30_000);
    let camera = StereoCamera::look_at(5.0 * Vec3::Z, Vec3::ZERO).size(13, 9).interaxial_pixels(1.5);
    scene.place_lights(4, &camera).unwrap();
    let mut renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    for method in [Method::Naive, Method::Auto, Method::ATOMIC] {
        let pair = renderer.pair(&uploaded, &camera).options(&Options::new(method).linear(true)).read().wait().unwrap();
        if has_a_bound(&renderer) {
            assert!(pair.statistics.in_steps, "{method}");
            assert_eq!(pair.statistics.method, Method::Naive);
        }
        let frame = Frame::new(&pair.pose);
        for (view, eye) in [(&pair.left, Eye::Left), (&pair.right, Eye::Right)] {
            let expected = searched(&scene, &frame, eye);
            assert!(expected.iter().filter(|&&id| id != MISS).count() > 60);
            // Where adapters contract operations, of two triangles a few ulps apart either may be the first.
            let differing = view.primitive.iter().zip(&expected).filter(|(a, b)| a != b).count();
            let most = if is_exact(&renderer) { 0 } else { expected.len() / 20 };
            assert!(differing <= most, "{method} {eye:?}: {differing} of {}", expected.len());
        }
    }
}

#[test]
fn rays_of_a_list_meet_all_of_sixty_thousand_triangles() {
    let scene = stack_of_triangles(60_000);
    let renderer = renderer();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let mut random = Random::new(4);
    let origin = 5.0 * Vec3::Z;
    let rays: Vec<Ray> = (0..37).map(|_| Ray::new(origin, random.point(1.0) - 3.0 * Vec3::Z)).collect();
    let closest = renderer.closest_hits(&uploaded, &rays).wait().unwrap().hits;
    for (ray, hit) in rays.iter().zip(&closest) {
        let (t, primitive) = closest_hit(&scene, origin, ray.direction, 0.0, FAR);
        let is_near = !is_exact(&renderer) && (hit.t - t).abs() <= 1e-6 * t;
        assert!(hit.primitive == primitive || is_near, "{hit:?} for {primitive} at {t}");
    }
    let farthest = closest.iter().map(|hit| hit.t).filter(|t| t.is_finite()).fold(0.0, f32::max);
    let past: Vec<Ray> = rays.iter().map(|ray| ray.t_min(2.0 * farthest)).collect();
    assert!(renderer.any_hits(&uploaded, &rays).wait().unwrap().hits.iter().any(|&hit| hit));
    assert!(renderer.any_hits(&uploaded, &past).wait().unwrap().hits.iter().all(|&hit| !hit));
}

#[test]
fn lights_without_number_light_what_their_sum_does() {
    let mut scene = Scene::new();
    let floor = [(-4.0, -4.0), (-4.0, 4.0), (4.0, 4.0), (4.0, -4.0)].map(|(x, z)| Vec3::new(x, -0.5, z));
    scene.add_mesh(&Mesh::new(floor.to_vec(), vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    scene.add_mesh(&ball(Vec3::ZERO, 0.5, 12)).unwrap();
    scene.ambient = Some(Vec3::splat(0.1));
    let camera = StereoCamera::look_at(Vec3::new(0.5, 1.5, 4.0), Vec3::ZERO).size(31, 17).interaxial_pixels(3.0);
    let light = Light::point(Vec3::new(1.0, 4.0, 2.0), Vec3::splat(0.8));
    scene.lights = vec![light];
    let mut renderer = renderer();
    let mut render = |scene: &Scene, method| {
        let uploaded = renderer.upload(scene).wait().unwrap();
        (
            renderer.pair(&uploaded, &camera).options(&Options::new(method).linear(true)).read().wait().unwrap(),
            has_a_bound(&renderer),
        )
    };
    let (one, _) = render(&scene, Method::Naive);
    // There are so many lights that the loop over them alone is ended early.
    let count = 70_000;
    scene.lights = vec![Light::point(light.position, light.intensity / count as f32); count];
    let (many, bound) = render(&scene, Method::BRACKET_RAYS);
    assert!(many.statistics.in_steps || !bound);
    assert_eq!(many.statistics.left.rays.shadow, count as u64 * one.statistics.left.rays.shadow);
    assert_eq!(many.right.primitive, one.right.primitive);
    for (many, one) in many.right.linear.iter().zip(&one.right.linear) {
        // Each of these sums below 1 is rounded by up to 2^-25, at worst all in one direction.
        let bound = count as f32 * 3e-8 + 1e-6;
        assert!((0..3).all(|c| (many[c] - one[c]).abs() < bound), "{many:?} {one:?}");
    }
}
