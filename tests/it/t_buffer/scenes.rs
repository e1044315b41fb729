//! Tests T-buffers with every scene.

use stereotrace::{
    Method, Options, Scene, StereoCamera,
    blocking::Wait,
    glam::Vec3,
    scene::builtin::Builtin,
    testing::cpu::{Eye, Frame, trace_left::trace_left},
    testing::suite::Trial,
};

use super::{
    common::{RandomScene, cases, compares_bits, random_foliage, random_stage, renderer, scenes_with},
    pair,
};

const METHODS: [Method; 4] = [Method::Naive, Method::ATOMIC, Method::BRACKET, Method::BRACKET_RAYS];

fn by_all_methods(name: &str, scene: &Scene, camera: &StereoCamera) {
    let mut renderer = renderer();
    let uploaded = renderer.upload(scene).wait().unwrap();
    for method in METHODS {
        pair(name, &mut renderer, &uploaded, camera, &Options::new(method).linear(true));
    }
}

#[test]
fn every_built_in_scene_is_that_of_rays() {
    for &builtin in cases(Builtin::ALL, 3) {
        by_all_methods(builtin.name(), &builtin.scene(), &builtin.camera(83, 61));
    }
}

#[test]
fn every_trial_is_that_of_rays() {
    for &trial in cases(Trial::ALL, 5) {
        by_all_methods(trial.name(), &trial.scene(), &trial.camera(79, 54));
    }
}

/// Tests cut-out foliage, spheres and many lights together.
#[test]
fn random_stages_and_foliage_are_those_of_rays() {
    let camera = StereoCamera::look_at(Vec3::new(0.3, 0.4, 4.0), Vec3::ZERO).size(71, 64).interaxial_pixels(6.0);
    for (name, scene) in [
        ("stage", random_stage(3)),
        ("foliage", random_foliage(5, false)),
        ("foliage with spheres", random_foliage(6, true)),
    ] {
        by_all_methods(name, &scene, &camera);
    }
}

/// The reference is independent code in plain Rust, which tests every primitive for every pixel.
#[test]
fn hits_are_those_of_a_loop_over_all_primitives() {
    let camera = StereoCamera::look_at(Vec3::new(0.3, 0.4, 3.0), Vec3::ZERO)
        .size(65, 63)
        .vertical_fov_degrees(50.0)
        .screen_distance(3.0)
        .interaxial_pixels(5.0);
    let of = |seed, triangles, spheres, ellipsoids| {
        RandomScene { seed, triangles, spheres, ellipsoids, smooth: seed % 2 == 0, ..RandomScene::default() }.build()
    };
    // In this case the camera is among the primitives. They cross the plane of the eyes or are behind it.
    let inside = camera.eye(Vec3::new(0.2, 0.1, 0.3)).target(Vec3::new(-1.0, 0.0, -1.0)).screen_distance(0.7);
    let all = [of(1, 300, 0, 0), of(3, 0, 60, 0), of(4, 150, 40, 0), of(6, 0, 0, 40), of(7, 100, 10, 30)];
    let mut renderer = renderer();
    if !compares_bits(&renderer) {
        return;
    }
    for (index, scene) in all.into_iter().chain([random_foliage(3, true)]).enumerate() {
        let uploaded = renderer.upload(&scene).wait().unwrap();
        for (place, camera) in [("before", camera), ("inside", inside)] {
            let what = format!("{place} scene {index}");
            let pair = pair(&what, &mut renderer, &uploaded, &camera, &Options::new(Method::Naive));
            let frame = Frame::new(&camera.pose().unwrap());
            for (view, eye) in pair.views.iter().zip([Eye::Left, Eye::Right]) {
                let twin = trace_left(&scene, &frame, eye);
                // For any triangle close to the eye, the reference computes t in sums of two f32. Kernels do so only if
                // the perpendicular from the eye to the triangle's plane meets the triangle.
                let is_other = |((depth, id), twin): &((f32, u32), &(f32, u32))| {
                    *id != twin.1 || (depth.min(stereotrace::FAR) - twin.0).abs() > 1e-6 * twin.0
                };
                let found = view.view.depth.iter().copied().zip(view.view.primitive.iter().copied());
                let others = Vec::from_iter(found.zip(&twin).filter(is_other));
                assert!(others.is_empty(), "{what} {eye:?}: {} others, {:?}", others.len(), others[0]);
                assert!(view.view.primitive.iter().any(|&id| id != stereotrace::MISS), "{what} sees something");
            }
        }
    }
}

/// Tests real meshes, if they are unpacked.
#[cfg(all(feature = "obj", feature = "json"))]
#[test]
fn real_meshes_are_those_of_rays() {
    for name in cases(["sponza_4x", "dragon", "teapot", "buddha"], 2) {
        let file = format!("{name}/{name}.obj");
        let Some(folder) = scenes_with(&file) else { continue };
        let file = folder.join(file);
        let mut scene = Scene::from_obj(&file).unwrap();
        let camera = StereoCamera::from_json(folder.join("cameras.json"), name, 201, 151).unwrap();
        scene.place_lights(2, &camera).unwrap();
        let mut renderer = renderer();
        let uploaded = renderer.upload(&scene).wait().unwrap();
        for method in [Method::Naive, Method::BRACKET] {
            pair(name, &mut renderer, &uploaded, &camera, &Options::new(method));
        }
        let rig = stereotrace::Rig::at(camera, vec![-1.5, 0.0, 1.5]).traced(vec![0, 2]);
        super::both(name, &mut renderer, &uploaded, &rig, &Options::new(Method::ATOMIC), &[0, 2]);
    }
}
