//! Tests unusual scenes: empty ones, without shadows, with many lights, with triangles that no ray can hit.

use stereotrace::{
    BvhBuild, Light, MISS, Material, Mesh, Method, Options, Scene, StereoCamera, blocking::Wait, glam::Vec3,
    scene::builtin::Builtin,
};

use super::common::{self, render, renderer};

#[test]
fn an_empty_scene_and_one_without_lights_render() {
    let mut scene = Scene::new();
    scene.sky = stereotrace::Sky::Constant(Vec3::new(0.5, 0.25, 0.0));
    let camera = StereoCamera::look_at(Vec3::Z, Vec3::ZERO).size(17, 9);
    for &method in Method::ALL {
        let pair = render(&scene, &camera, method);
        assert!(
            pair.right.rgba8.iter().all(|pixel| *pixel == [188, 137, 0, 255]),
            "{method} {:?}",
            pair.right.rgba8[0]
        );
    }
    let mut dark = Builtin::Hall.scene();
    dark.lights.clear();
    let pair = render(&dark, &Builtin::Hall.camera(40, 30), Method::ATOMIC);
    assert_eq!(pair.statistics.left.rays.shadow + pair.statistics.right.rays.shadow, 0);
    assert!(pair.left.rgba8.iter().any(|pixel| pixel[..3] != [0; 3]), "ambient light");
}

#[test]
fn an_eye_in_the_plane_of_a_wall_is_no_fault() {
    // Every hit has depth 0, or there is none, so Lemma 1's bound is NaN.
    let mut scene = Scene::new();
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec();
    scene.add_mesh(&Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    let camera = StereoCamera::look_at(Vec3::ZERO, -Vec3::Z).size(16, 16).interaxial(0.1);
    for &method in Method::ALL {
        let pair = render(&scene, &camera, method);
        assert_eq!(pair.left.depth.len(), 256, "{method}");
    }
}

#[test]
fn many_lights_add_up_to_one() {
    let camera = Builtin::Hall.camera(40, 30);
    let mut scene = Builtin::Hall.scene();
    scene.lights.truncate(1);
    let one = render(&scene, &camera, Method::Naive);
    let light = scene.lights[0];
    for count in [100, 1000] {
        scene.lights = vec![Light::point(light.position, light.intensity / count as f32); count];
        let mut renderer = renderer();
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let many =
            renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive).linear(true)).read().wait().unwrap();
        assert_eq!(many.statistics.left.rays.shadow, count as u64 * one.statistics.left.rays.shadow);
        for (many, one) in many.left.linear.iter().zip(&one.left.linear) {
            // The bound allows for the rounding errors of a sum below 2.
            assert!((0..3).all(|c| (many[c] - one[c]).abs() < 1e-4), "{many:?} {one:?}");
        }
    }
}

#[test]
fn degenerate_triangles_are_counted_and_not_traced_and_ids_keep_their_numbers() {
    let point = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let positions = vec![point(-1.0, -1.0), point(1.0, -1.0), point(0.0, 1.0)];
    let mut scene = Scene::new();
    scene.add_mesh(&Mesh::new(positions, vec![[0, 0, 1], [0, 1, 1], [0, 1, 2]])).unwrap();
    assert_eq!((scene.degenerate_count(), scene.primitive_count()), (2, 3));
    let camera = StereoCamera::look_at(3.0 * Vec3::Z, Vec3::ZERO).size(21, 21);
    let pair = render(&scene, &camera, Method::Naive);
    assert!(pair.left.primitive.iter().all(|&id| id == 2 || id == MISS));
    assert_eq!(pair.left.primitive[10 * 21 + 10], 2);
    assert_eq!(renderer().upload(&scene).wait().unwrap().info().dropped_triangles, 2);
}

#[test]
fn without_shadows_every_light_in_front_of_a_surface_reaches_it() {
    let camera = Builtin::Hall.camera(80, 60);
    let mut scene = Builtin::Hall.scene();
    let with = render(&scene, &camera, Method::Naive);
    scene.shadows = false;
    let without = render(&scene, &camera, Method::Naive);
    assert!(with.statistics.left.rays.shadow > 0);
    assert_eq!(without.statistics.left.rays.shadow + without.statistics.right.rays.shadow, 0);
    let pairs = || with.left.linear.iter().zip(&without.left.linear);
    assert!(pairs().all(|(with, without)| (0..3).all(|c| without[c] >= with[c])));
    assert!(pairs().filter(|(with, without)| with != without).count() > 500);
    assert_eq!(with.left.depth, without.left.depth);
    // A surface without occluders looks the same: a lone sphere lit from the eye.
    let mut lone = Scene::new();
    let grey = lone.add_material(Material::new(Vec3::splat(0.5)));
    lone.add_sphere(stereotrace::Sphere::new(Vec3::ZERO, 1.0, grey)).unwrap();
    lone.lights = vec![Light::point(5.0 * Vec3::Z, Vec3::ONE)];
    let camera = StereoCamera::look_at(5.0 * Vec3::Z, Vec3::ZERO).size(48, 48);
    let with = render(&lone, &camera, Method::Naive);
    lone.shadows = false;
    assert_eq!(render(&lone, &camera, Method::Naive).left.linear, with.left.linear);
}

#[test]
fn every_effort_at_the_tree_gives_the_same_picture() {
    let camera = Builtin::Hall.camera(64, 48);
    let mut renderer = renderer();
    let exact = common::is_exact(&renderer);
    let pairs = Vec::from_iter(BvhBuild::ALL.iter().map(|&build| {
        let uploaded = renderer.upload_with(&Builtin::Hall.scene(), build).wait().unwrap();
        let info = uploaded.info();
        assert!(info.node_bytes > 0 && info.primitive_bytes > 0 && !info.build.is_zero() && !info.upload.is_zero());
        let pair = renderer
            .pair(&uploaded, &camera)
            .options(&Options::new(Method::Naive).linear(true).count(true))
            .read()
            .wait()
            .unwrap();
        (pair.left.linear, pair.right.primitive, pair.statistics.left.nodes)
    }));
    for (build, pair) in BvhBuild::ALL.iter().zip(&pairs) {
        assert!(!exact || (&pair.0, &pair.1) == (&pairs[0].0, &pairs[0].1), "{build:?}");
    }
    assert!(pairs[2].2 < pairs[0].2, "more effort, fewer nodes: {} {}", pairs[2].2, pairs[0].2);
}
