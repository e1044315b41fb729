//! Tests T-buffers with every kind of frame.

use stereotrace::{
    Adaptive, AmbientOcclusion, Error, Finish, GBuffer, Light, Material, MaterialId, Method, Options, Plane, Rig,
    Scene, Sky, SkyMap, Sphere, StereoCamera, Texture, Update, Visibility,
    blocking::Wait,
    glam::{Affine3A, Vec3},
};

use super::{
    both,
    common::{random_foliage, random_stage, renderer, renderer_by, traversals},
    pair,
};

fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.2, 0.6, 4.5), Vec3::new(0.0, -0.1, 0.0))
        .screen_distance(4.0)
        .size(67, 50)
        .interaxial_pixels(5.0)
}

/// Returns leaves, spheres and a floor, on planes that mirror them, with glass, and lights of two kinds.
fn everything() -> Scene {
    let mut scene = random_foliage(8, true);
    let board = scene.add_texture(Texture::checkerboard(Vec3::ONE, Vec3::splat(0.2), 2).unwrap());
    let paved = scene.add_material(Material::new(Vec3::splat(0.8)).texture(board));
    let mirror = Material::new(Vec3::splat(0.1)).specular(Vec3::splat(0.8)).finish(Finish::Mirror { fresnel: false });
    let mirror = scene.add_material(mirror);
    let glass = Finish::Glass { index: 1.5, transmission: Vec3::ONE, fresnel: true };
    let glass = scene.add_material(Material::new(Vec3::ZERO).specular(Vec3::ONE).finish(glass));
    scene.add_plane(Plane::new(Vec3::new(0.0, -1.1, 0.0), Vec3::new(0.05, 1.0, 0.0), paved)).unwrap();
    scene.add_plane(Plane::new(Vec3::new(0.0, 0.0, -4.0), Vec3::new(0.2, 0.0, 1.0), mirror)).unwrap();
    scene.add_sphere(Sphere::new(Vec3::new(0.6, 0.2, 1.2), 0.4, glass)).unwrap();
    scene.lights.push(Light::sphere(Vec3::new(1.0, 4.0, 2.0), 0.5, Vec3::splat(0.3)));
    scene
}

#[test]
fn soft_light_mirrors_planes_and_cut_outs_together_are_those_of_rays() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&everything()).wait().unwrap();
    for method in [Method::Naive, Method::ATOMIC, Method::BRACKET, Method::BRACKET_RAYS, Method::Auto] {
        let options = Options::new(method).linear(true).shadow_rays(8).ambient_occlusion(AmbientOcclusion::new(8, 2.0));
        pair("everything", &mut renderer, &uploaded, &camera(), &options);
    }
    let mut under_a_sky = everything();
    under_a_sky.sky = Sky::Map(SkyMap::procedural(64).unwrap());
    let uploaded = renderer.upload(&under_a_sky).wait().unwrap();
    let options = Options::new(Method::Naive).shadow_rays(4).sky_rays(5);
    pair("under a sky", &mut renderer, &uploaded, &camera(), &options);
}

/// Tests every traversal: four rays per lane or one, both kinds of boxes, textures and buffers.
#[test]
fn every_traversal_draws_the_hits_of_rays() {
    for traversal in traversals() {
        let mut renderer = renderer_by(traversal);
        let uploaded = renderer.upload(&everything()).wait().unwrap();
        let options = Options::new(Method::Naive).shadow_rays(2);
        pair(&traversal.to_string(), &mut renderer, &uploaded, &camera().size(41, 35), &options);
    }
}

#[test]
fn samples_with_and_without_jitter_are_those_of_rays() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(3)).wait().unwrap();
    let small = camera().size(33, 21);
    for (samples, jitter, method) in [
        (4, true, Method::Naive),
        (9, true, Method::BRACKET),
        (9, false, Method::ATOMIC),
        (16, true, Method::BRACKET_RAYS),
        (64, true, Method::Naive),
    ] {
        let options = Options::new(method).samples(samples).jitter(jitter).linear(true).seed(7);
        pair(&format!("{samples} samples"), &mut renderer, &uploaded, &small, &options);
        let kept = options.g_buffer(GBuffer::None);
        pair(&format!("{samples} samples alone"), &mut renderer, &uploaded, &small, &kept);
    }
}

/// With adaptive samples, all levels but the first use rays.
#[test]
fn adaptive_frames_are_those_of_rays() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    for method in [Method::Naive, Method::BRACKET] {
        let options = Options::new(method).adaptive(Adaptive::new(3, 8.0)).linear(true);
        both(&format!("adaptive {method}"), &mut renderer, &uploaded, &Rig::pair(camera()), &options, &[]);
    }
}

#[test]
fn rigs_are_those_of_rays() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&everything()).wait().unwrap();
    let rig = Rig::at(camera(), vec![-1.5, -0.5, 0.5, 1.5]).traced(vec![0, 3]);
    for method in [Method::Naive, Method::BRACKET, Method::ATOMIC, Method::ES_ISLER] {
        let traced: &[usize] = if method == Method::Naive { &[0, 1, 2, 3] } else { &[0, 3] };
        both(&format!("rig {method}"), &mut renderer, &uploaded, &rig, &Options::new(method).shadow_rays(2), traced);
    }
}

/// Tests bands of 64 rows, with the rows beside them that `atomic-edges` reads. The counters don't depend on the bands.
#[test]
fn bands_are_those_of_rays() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    let wide = camera().size(4096, 150).interaxial_pixels(60.0);
    for method in ["naive", "bracket", "verified", "atomic-edges", "adelson-hodges"] {
        let options = Options::new(method.parse().unwrap());
        pair("bands", &mut renderer, &uploaded, &wide, &options);
    }
}

#[test]
fn a_scene_that_moves_is_that_of_rays_after_each_change() {
    let mut renderer = renderer();
    let mut scene = random_stage(5);
    let mut uploaded = renderer.upload(&scene).wait().unwrap();
    for (turn, how) in [(0.3, Update::Refit), (0.9, Update::Refit), (1.4, Update::Rebuild(Default::default()))] {
        scene.transform_object(1, &Affine3A::from_rotation_y(turn)).unwrap();
        renderer.update(&mut uploaded, &scene, how).wait().unwrap();
        pair(&format!("turned by {turn}"), &mut renderer, &uploaded, &camera(), &Options::new(Method::Naive));
    }
    // With one more primitive, the list of the other scene is too short.
    scene.add_sphere(Sphere::new(Vec3::new(0.1, 0.3, 2.0), 0.3, MaterialId(0))).unwrap();
    renderer.update(&mut uploaded, &scene, Update::Rebuild(Default::default())).wait().unwrap();
    pair("with a sphere more", &mut renderer, &uploaded, &camera(), &Options::new(Method::Naive));
}

/// Tests scenes with nothing to draw: empty scenes, or planes, which are tested by rays.
#[test]
fn scenes_without_a_tree_are_those_of_rays() {
    let mut renderer = renderer();
    let mut planes = Scene::new();
    planes.add_plane(Plane::new(Vec3::NEG_Y, Vec3::Y, MaterialId(0))).unwrap();
    for scene in [Scene::new(), planes] {
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let options = Options::new(Method::Naive);
        both("no tree", &mut renderer, &uploaded, &Rig::pair(camera()), &options, &[]);
    }
}

#[test]
fn a_frame_may_be_stopped_and_the_next_one_is_whole() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    let options = Options::new(Method::Naive).visibility(Visibility::TBuffer);
    let wide = camera().size(4096, 150);
    let mut stop = |_| std::ops::ControlFlow::Break(());
    let stopped = renderer.pair(&uploaded, &wide).options(&options).progress(&mut stop).read().wait();
    assert!(matches!(stopped, Err(Error::Cancelled)), "{stopped:?}");
    pair("after one that was stopped", &mut renderer, &uploaded, &wide, &options);
}
