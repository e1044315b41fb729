//! Tests planes in scenes that move, and lights that are placed near planes.

use stereotrace::{
    BvhBuild, MaterialId, Mesh, Method, Options, Plane, StereoCamera, Update,
    blocking::Wait,
    glam::{Affine3A, Quat, Vec3},
};

use super::{THINGS, Things, camera, common::renderer, stage, tilt};

#[test]
fn a_scene_that_moved_is_the_scene_uploaded_anew() {
    let mut renderer = renderer();
    let options = Options::new(Method::BRACKET).linear(true);
    for things in THINGS {
        for build in BvhBuild::ALL {
            let mut scene = stage(things, tilt());
            scene.add_plane(Plane::new(-7.0 * Vec3::Z, Vec3::Z, MaterialId(0))).unwrap();
            let mut uploaded = renderer.upload_with(&scene, *build).wait().unwrap();
            let last = scene.object_count() as u32 - 1;
            for step in 0..3 {
                let how = if step == 2 { Update::Rebuild(*build) } else { Update::Refit };
                let turn = Quat::from_rotation_x(0.1 * (step + 1) as f32);
                let transform = Affine3A::from_rotation_translation(turn, Vec3::new(0.0, -0.1, 0.2));
                scene.transform_object(last, &transform).unwrap();
                if step == 1 {
                    scene.transform_object(0, &transform).unwrap();
                }
                renderer.update(&mut uploaded, &scene, how).wait().unwrap();
                let found = renderer.pair(&uploaded, &camera(tilt())).options(&options).read().wait().unwrap();
                let anew = renderer.upload(&scene).wait().unwrap();
                let expected = renderer.pair(&anew, &camera(tilt())).options(&options).read().wait().unwrap();
                assert!(
                    (&found.left, &found.right) == (&expected.left, &expected.right),
                    "{things:?} {build:?} {step}"
                );
            }
        }
    }
}

#[test]
fn planes_come_and_go_by_a_new_tree_alone() {
    let mut renderer = renderer();
    let mut scene = stage(Things::Mesh, tilt());
    let mut uploaded = renderer.upload(&scene).wait().unwrap();
    scene.add_plane(Plane::new(-7.0 * Vec3::Z, Vec3::Z, MaterialId(0))).unwrap();
    let error = renderer.update(&mut uploaded, &scene, Update::Refit).wait().unwrap_err().to_string();
    assert!(
        error.contains("0 ellipsoids and 1 planes, but the scene now has") && error.contains("Update::Rebuild"),
        "{error}"
    );
    renderer.update(&mut uploaded, &scene, Update::Rebuild(BvhBuild::Fast)).wait().unwrap();
    // All triangles lose their area and get it back. In between, the scene has only planes.
    let object = Mesh::new(vec![Vec3::ZERO; 3], vec![[0, 1, 2]; scene.triangles().len()]);
    let whole = stage(Things::Mesh, tilt());
    let corners: Vec<Vec3> = whole.triangles().iter().flat_map(|triangle| triangle.corners).collect();
    let faces = (0..corners.len() as u32 / 3).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    for mesh in [object, Mesh::new(corners, faces)] {
        scene.set_mesh(0, &mesh).unwrap();
        renderer.update(&mut uploaded, &scene, Update::Refit).wait().unwrap();
        let anew = renderer.upload(&scene).wait().unwrap();
        let mut render = |uploaded| renderer.pair(uploaded, &camera(tilt())).read().wait().unwrap();
        let (found, expected) = (render(&uploaded), render(&anew));
        assert!((&found.left, &found.right) == (&expected.left, &expected.right), "{}", scene.degenerate_count());
        assert!(found.left.primitive.iter().filter(|&&id| id != stereotrace::MISS).count() > 2000);
    }
}

#[test]
fn lights_by_rule_stand_on_the_eyes_side_of_planes() {
    for eye in [Vec3::new(0.5, 0.3, 6.0), Vec3::new(0.5, 40.0, 6.0), Vec3::new(0.0, -2.0, 6.0)] {
        for things in THINGS {
            let mut scene = stage(things, Quat::IDENTITY);
            // A roof is close above the eye.
            scene.add_plane(Plane::new((eye.y + 0.2) * Vec3::Y, Vec3::NEG_Y, MaterialId(0))).unwrap();
            let camera = StereoCamera::look_at(eye, Vec3::new(0.0, 0.5, 0.0)).size(64, 48);
            scene.place_lights(7, &camera).unwrap();
            for light in &scene.lights {
                let y = light.position.y as f32;
                assert!(y * eye.y > 0.0 && y < eye.y + 0.2, "{eye} {things:?}: {}", light.position);
            }
        }
    }
    // Planes have no bounding box.
    assert_eq!(stage(Things::Nothing, Quat::IDENTITY).bounds(), None);
}
