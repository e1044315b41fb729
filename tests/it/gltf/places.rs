//! Tests the positions of nodes, cameras and lights against glam in double precision.

use serde_json::{Value, json};
use stereotrace::{
    Falloff, LightShape, SceneFile,
    glam::{DMat4, DQuat, DVec3, EulerRot, Vec3},
};

use super::{
    assert_near,
    common::{folder::Folder, random::Random, warnings},
    corners,
    gltf::Builder,
    open, scene,
};

/// Returns a random transform as a node and as a matrix. The matrix is made from the file's f32 values.
fn random_node(random: &mut Random) -> (Value, DMat4) {
    let mut three = |half: f32| [(); 3].map(|()| random.between(-half, half));
    let (translation, scale, angles) = (three(5.0), three(2.0), three(3.0));
    let [x, y, z] = angles.map(f64::from);
    let rotation = DQuat::from_euler(EulerRot::XYZ, x, y, z).as_quat();
    // The quaternion is not of unit length, as some programs write it.
    let rotation = rotation.to_array().map(|value| value * 1.001);
    let unit = DQuat::from_array(rotation.map(f64::from)).normalize();
    let [scale_f64, translation_f64] = [scale, translation].map(|vector| Vec3::from_array(vector).as_dvec3());
    let matrix = DMat4::from_translation(translation_f64) * DMat4::from_quat(unit) * DMat4::from_scale(scale_f64);
    if random.unit() < 0.5 {
        return (json!({ "translation": translation, "rotation": rotation, "scale": scale }), matrix);
    }
    let written = matrix.to_cols_array().map(|value| value as f32);
    (json!({ "matrix": written }), DMat4::from_cols_array(&written.map(f64::from)))
}

#[test]
fn chains_of_nodes_place_meshes_as_double_precision_does() {
    let mut random = Random(7);
    for _ in 0..50 {
        let mut builder = Builder::triangle(json!({}));
        let normal = [[0.6f32, 0.0, 0.8]; 3];
        builder.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(builder.floats(&normal));
        let (mut node, mut matrix) = random_node(&mut random);
        node["mesh"] = json!(0);
        builder.json["nodes"] = json!([node]);
        for index in 0..4 {
            let (mut parent, above) = random_node(&mut random);
            parent["children"] = json!([index]);
            builder.push("nodes", parent);
            matrix = above * matrix;
        }
        builder.json["scenes"][0]["nodes"] = json!([4]);
        let scene = scene(builder.binary());
        let mirrored = matrix.determinant() < 0.0;
        let order = if mirrored { [0, 2, 1] } else { [0, 1, 2] };
        let local = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for (found, corner) in corners(&scene)[0].iter().zip(order) {
            let expected = matrix.transform_point3(local[corner]);
            let error = (scene.origin() + found.as_dvec3() - expected).abs();
            assert!(error.max_element() <= 1e-7 * expected.abs().max_element().max(1e-3), "{found} {expected}");
        }
        let upright = |normal: DVec3| matrix.inverse().transpose().transform_vector3(normal).normalize().as_vec3();
        assert_near(scene.triangles()[0].normals[2], upright(DVec3::new(0.6, 0.0, 0.8)));
        // The front side, from which corners run counterclockwise, stays the front side.
        let [a, b, c] = corners(&scene)[0];
        assert!((b - a).cross(c - a).dot(upright(DVec3::Z)) > 0.0);
    }
}

#[test]
fn the_default_scene_the_first_one_or_all_nodes_are_shown() {
    let mut builder = Builder::triangle(json!({}));
    builder.push("nodes", json!({ "mesh": 0, "translation": [0, 0, 1] }));
    builder.push("nodes", json!({ "children": [1], "translation": [0, 0, 2] }));
    builder.push("scenes", json!({ "nodes": [2] }));
    let heights =
        |builder: &Builder| -> Vec<f32> { corners(&scene(builder.text())).iter().map(|one| one[0].z).collect() };
    assert_eq!(heights(&builder), [0.0]);
    builder.json["scene"] = json!(1);
    assert_eq!(heights(&builder), [3.0]);
    builder.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(heights(&builder), [0.0]);
    builder.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(heights(&builder), [0.0, 3.0]);
}

/// The up direction of a glTF camera that looks down is not vertical. Orbits around that direction would not stay
/// level.
#[test]
fn cameras_that_stand_level_orbit_level_and_rolled_ones_stay_rolled() {
    for (roll, is_level) in [(0.0, true), (0.1, false), (3.1, false)] {
        let rotation = DQuat::from_euler(EulerRot::YXZ, 0.7, -0.4, roll).as_quat();
        let mut builder = Builder::triangle(json!({}));
        let camera = json!({ "type": "perspective", "perspective": { "yfov": 0.8, "aspectRatio": 1.5, "znear": 0.1 } });
        let camera = builder.push("cameras", camera);
        builder.node(json!({ "camera": camera, "translation": [3, 4, 5], "rotation": rotation.to_array() }));
        let camera = open(builder.text()).cameras[0].1;
        let pose = camera.pose().unwrap();
        assert!((pose.right - rotation * Vec3::X).length() < 1e-5 && (pose.up - rotation * Vec3::Y).length() < 1e-5);
        let turned = camera.orbited(2.0).pose().unwrap();
        assert_eq!((turned.eye.y - pose.eye.y).abs() < 1e-4 && turned.right.y.abs() < 1e-5, is_level, "roll {roll}");
    }
}

/// Tests a rotated and moved camera, with the parameters of OpenGL.
#[test]
fn cameras_see_points_where_the_specifications_matrix_does() {
    let mut random = Random(3);
    for index in 0..20 {
        let (yfov, aspect) = (random.between(0.3, 2.0), random.between(0.5, 2.0));
        let [x, y, z] = [(); 3].map(|()| random.between(-3.0, 3.0));
        let rotation = DQuat::from_euler(EulerRot::YXZ, x.into(), y.into(), z.into()).as_quat();
        let mut builder = Builder::triangle(json!({}));
        let perspective = json!({ "yfov": yfov, "aspectRatio": aspect, "znear": 0.1, "zfar": 50 });
        let camera = json!({ "type": "perspective", "perspective": perspective });
        let camera = builder.push("cameras", camera);
        // A scale does not change a camera.
        builder.node(json!({ "camera": camera, "name": format!("view \
            {index}"), "translation": [x, y, z], "rotation": rotation.to_array(), "scale": [2, 2, 2] }));
        let file = open(builder.text());
        let (name, camera) = &file.cameras[0];
        assert_eq!((file.cameras.len(), &**name), (1, &*format!("view {index}")));
        let pose = camera.pose().unwrap();
        let [width, height] = pose.size.map(f64::from);
        assert!(height == 480.0 && (width - 480.0 * f64::from(aspect)).abs() <= 0.5);

        let view =
            DMat4::from_rotation_translation(rotation.as_dquat().normalize(), DVec3::new(x.into(), y.into(), z.into()))
                .inverse();
        // This is the specification's matrix. Its third row is for depth buffers.
        let across = 1.0 / (0.5 * f64::from(yfov)).tan();
        let projection = DMat4::from_cols_array_2d(&[
            [across * height / width, 0.0, 0.0, 0.0],
            [0.0, across, 0.0, 0.0],
            [0.0, 0.0, 50.1 / -49.9, -1.0],
            [0.0, 0.0, 10.0 / -49.9, 0.0],
        ]);
        for _ in 0..20 {
            let point = Vec3::from_array([(); 3].map(|()| random.between(-9.0, 9.0)));
            let clip = projection * view * point.as_dvec3().extend(1.0);
            if clip.w < 0.5 {
                continue;
            }
            let expected = [0.5 * width * (1.0 + clip.x / clip.w), 0.5 * height * (1.0 - clip.y / clip.w), clip.w];
            let found = pose.project(point, 0.0).map(f64::from);
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-3 + 1e-5 * expected.abs(), "{found} {expected}");
            }
        }
        // The middle of the scene has no parallax, unless it is too close.
        let depth = pose.project(Vec3::new(0.5, 0.5, 0.0), 0.0)[2];
        let least = 0.25 * 2f32.sqrt();
        assert!((pose.screen_distance - depth.max(least)).abs() < 1e-4, "{} {depth}", pose.screen_distance);
        assert!((pose.interaxial - pose.screen_distance / 30.0).abs() < 1e-5);
    }
}

fn lit(lights: Value) -> Builder {
    let mut builder = Builder::triangle(json!({}));
    let count = lights.as_array().unwrap().len();
    builder.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    builder.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    for index in 0..count {
        // The node's +z is the world's +x.
        builder.node(json!({ "rotation": [0, 0.5f32.sqrt(), 0, 0.5f32.sqrt()], "translation": [0.5, 0.5, 2.0],
            "extensions": { "KHR_lights_punctual": { "light": index } } }));
    }
    builder
}

#[test]
fn lights_have_the_intensities_falloffs_and_cones_of_the_file() {
    let pi = std::f32::consts::PI;
    let scene = scene(
        lit(json!([
            { "type": "directional", "intensity": 0.5 * pi, "color": [1, 0.5, 0] },
            { "type": "point", "intensity": 0.4 * pi, "range": 7 },
            { "type": "point", "color": [0, 0.2, 0.4] },
            { "type": "spot", "intensity": 0.4 * pi },
            { "type": "spot", "intensity": 0.4 * pi, "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.5 } }
        ]))
        .text(),
    );
    let [sun, lamp, dim, wide, spot] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!((sun.shape, sun.falloff), (LightShape::Directional { radius: 0.0 }, Falloff::None));
    assert_near(sun.position.as_vec3(), Vec3::X);
    assert_near(sun.intensity, Vec3::new(0.5, 0.25, 0.0));
    assert_eq!((lamp.shape, lamp.position), (LightShape::Point, DVec3::new(0.5, 0.5, 2.0)));
    assert_eq!((lamp.falloff, lamp.cone), (Falloff::Quadratic { range: Some(7.0) }, None));
    assert_near(lamp.intensity, Vec3::splat(0.4));
    assert_near(dim.intensity, Vec3::new(0.0, 0.2, 0.4) / pi);
    assert_eq!((wide.falloff, spot.falloff), (Falloff::Quadratic { range: None }, Falloff::Quadratic { range: None }));
    let [wide, spot] = [wide, spot].map(|light| light.cone.unwrap());
    assert_eq!([wide.inner, wide.outer, spot.inner, spot.outer], [0.0, 0.25 * pi, 0.2, 0.5]);
    // Spot lights shine along the node's negative z axis.
    assert_near(spot.direction, Vec3::NEG_X);
    assert_eq!(scene.ambient, None);
}

#[test]
fn bright_lights_are_scaled_down_together_and_with_the_emission() {
    let folder = Folder::new("gltf_lights");
    warnings::collect();
    let lights = json!([
        { "type": "directional", "intensity": 100_000 }, { "type": "directional", "intensity": 300_000 },
        { "type": "spot", "range": 5, "intensity": 0, "spot": {} }
    ]);
    let mut builder = lit(lights);
    builder.json["materials"] = json!([{ "emissiveFactor": [1, 0.5, 0] }]);
    builder.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let read =
        |name: &str, builder: &Builder| stereotrace::Scene::from_gltf(folder.write(name, builder.text())).unwrap();
    let scene = read("sun.gltf", &builder);
    assert_near(scene.lights[0].intensity, Vec3::splat(0.25));
    assert_near(scene.lights[1].intensity, Vec3::splat(0.75));
    let scale = 400_000.0 / std::f32::consts::PI;
    let emissions = |scene: &stereotrace::Scene| {
        let glowing = scene.materials().iter().find(|material| material.principled.is_some()).unwrap();
        [glowing.emission, glowing.principled.unwrap().emission]
    };
    emissions(&scene).into_iter().for_each(|emission| assert_near(emission * scale, Vec3::new(1.0, 0.5, 0.0)));
    let warnings = warnings::of(&folder);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].starts_with("sun.gltf: its lights are 127323.9"), "{warnings:?}");

    // Blender writes lights in lumens, and emission as it is.
    builder.json["asset"]["generator"] = json!("Khronos glTF Blender I/O v4.3.47");
    let scene = read("blend.gltf", &builder);
    assert_near(scene.lights[1].intensity, Vec3::splat(0.75));
    emissions(&scene)
        .into_iter()
        .for_each(|emission| assert_near(emission * (scale / 683.0), Vec3::new(1.0, 0.5, 0.0)));
}

/// Tests a chain of nodes in UTM coordinates. f32 would round the sum of their translations to a quarter of a unit.
#[test]
fn nodes_far_from_the_origin_keep_their_places_and_what_stands_there() {
    let mut builder = Builder::triangle(json!({}));
    builder.json["nodes"] = json!([
        { "mesh": 0, "translation": [0.123_456, 0, 0.25] },
        { "camera": 0, "translation": [0.5, 0.25, 3.0625] },
        { "children": [0, 1], "translation": [500_000.123_4, 12.5, -5_400_000.432_1] },
    ]);
    builder.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }]);
    builder.json["scenes"][0]["nodes"] = json!([2]);
    let SceneFile { scene, cameras, .. } = open(builder.text());
    let place = DVec3::new(500_000.123_4, 12.5, -5_400_000.432_1);
    assert_eq!(scene.origin(), DVec3::new(500_001.0, 13.0, -5_400_000.0));
    let found = scene.origin() + corners(&scene)[0][1].as_dvec3();
    let expected = place + DVec3::new(1.123_456, 0.0, 0.25);
    assert!((found - expected).abs().max_element() < 1e-7, "{found} {expected}");
    let eye = cameras[0].1.pose().unwrap().eye;
    assert!((eye - place - DVec3::new(0.5, 0.25, 3.0625)).abs().max_element() < 1e-8, "{eye}");
}
