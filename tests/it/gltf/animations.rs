//! Tests animations, skins and morph targets against the specification's formulas.

use serde_json::json;
use stereotrace::{
    Animation, SceneOptions, TextureId,
    glam::{Affine3A, DMat4, DQuat, DVec3, Mat4, Quat, Vec3},
};

use super::{assert_near, corners, gltf::Builder, open, open_with};

const TRIANGLE: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Adds an animation of one channel.
fn animate(builder: &mut Builder, node: usize, path: &str, interpolation: &str, times: &[f32], output: usize) -> usize {
    let input = builder.floats(&times.iter().map(|time| [*time]).collect::<Vec<_>>());
    builder.push(
        "animations",
        json!({
            "name": path,
            "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
            "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
        }),
    )
}

/// Returns a file of one triangle at a node, animated by these values.
fn animated<const N: usize>(path: &str, interpolation: &str, times: &[f32], values: &[[f32; N]]) -> Builder {
    let mut builder = Builder::new();
    let mesh = builder.mesh(&TRIANGLE, json!({}));
    let node = builder.node(json!({ "mesh": mesh, "translation": [0.0, 0.0, 1.0] }));
    let output = builder.floats(values);
    animate(&mut builder, node, path, interpolation, times, output);
    builder
}

/// Returns the corners of the first triangle at a time.
fn at(builder: &Builder, seconds: f64) -> [Vec3; 3] {
    let mut file = open(builder.text());
    file.animations[0].pose(&mut file.scene, seconds).unwrap();
    corners(&file.scene)[0]
}

#[test]
fn key_frames_are_interpolated_as_they_say_and_hold_at_both_ends() {
    let moved = [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 4.0, 0.0]];
    let times = [0.5, 1.0, 3.0];
    let linear = animated("translation", "LINEAR", &times, &moved);
    let step = animated("translation", "STEP", &times, &moved);
    for (seconds, by_line, by_step) in [
        (-1.0, [0.0, 0.0], [0.0, 0.0]),
        (0.5, [0.0, 0.0], [0.0, 0.0]),
        (0.75, [1.0, 0.0], [0.0, 0.0]),
        (1.0, [2.0, 0.0], [2.0, 0.0]),
        (2.5, [2.0, 3.0], [2.0, 0.0]),
        (9.0, [2.0, 4.0], [2.0, 4.0]),
    ] {
        for (builder, [x, y]) in [(&linear, by_line), (&step, by_step)] {
            let moved = TRIANGLE.map(|corner| Vec3::from_array(corner) + Vec3::new(x, y, 0.0));
            at(builder, seconds).into_iter().zip(moved).for_each(|(found, expected)| assert_near(found, expected));
        }
    }
    // A cubic with outgoing tangent 3 and incoming tangent -1 over 2 seconds.
    let spline = [[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0; 3]];
    let spline = animated("translation", "CUBICSPLINE", &[1.0, 3.0], &spline);
    let t = 0.3_f32;
    let x = (2.0 * t.powi(3) - 3.0 * t * t + 1.0) * 1.0
        + (t.powi(3) - 2.0 * t * t + t) * 2.0 * 3.0
        + (3.0 * t * t - 2.0 * t.powi(3)) * 2.0
        - (t.powi(3) - t * t) * 2.0;
    assert_near(at(&spline, 1.6)[0], x * Vec3::X);
    assert_near(at(&spline, 0.0)[0], Vec3::X);
    assert_near(at(&spline, 4.0)[0], 2.0 * Vec3::X);
    assert_eq!(open(spline.text()).animations[0].duration(), 3.0);
}

#[test]
fn rotations_turn_evenly_along_the_shorter_way() {
    let turned = |degrees: f32| Quat::from_rotation_z(degrees.to_radians()).to_array();
    let negated = |degrees: f32| turned(degrees).map(|value| -value);
    for quaternions in [[turned(0.0), turned(120.0)], [turned(0.0), negated(120.0)]] {
        let builder = animated("rotation", "LINEAR", &[0.0, 1.0], &quaternions);
        for seconds in [0.0, 0.25, 0.7] {
            let angle = 120.0_f32.to_radians() * seconds;
            let expected = Vec3::new(angle.cos(), angle.sin(), 1.0);
            assert_near(at(&builder, seconds.into())[1], expected);
        }
    }
    let builder = animated("scale", "LINEAR", &[0.0, 1.0], &[[1.0; 3], [3.0, 1.0, 1.0]]);
    assert_near(at(&builder, 0.5)[1], Vec3::new(2.0, 0.0, 1.0));
}

/// A child moves with its parent, a light and a camera move with theirs, and what is beside them stays.
#[test]
fn children_lights_and_cameras_move_with_their_nodes() {
    let mut builder = Builder::new();
    let mesh = builder.mesh(&TRIANGLE, json!({}));
    let still = builder.node(json!({ "mesh": mesh, "translation": [0.0, 7.0, 0.0] }));
    let camera = json!({ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } });
    let camera = builder.push("cameras", camera);
    let spot = json!({ "type": "spot", "intensity": 0.5, "spot": {} });
    builder.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [spot] } });
    let child = builder.push(
        "nodes",
        json!({
            "mesh": mesh, "translation": [1.0, 0.0, 0.0], "camera": camera,
            "extensions": { "KHR_lights_punctual": { "light": 0 } },
        }),
    );
    let parent = builder.node(json!({ "children": [child], "name": "arm" }));
    let values = builder.floats(&[[0.0, 0.0, 0.0, 1.0], Quat::from_rotation_y(1.0).to_array()]);
    animate(&mut builder, parent, "rotation", "LINEAR", &[0.0, 2.0], values);
    let mut file = open(builder.text());
    let before = corners(&file.scene);
    let animation = file.animations[0].clone();
    assert_eq!((animation.name(), still), ("rotation", 0));
    file.scene.lights[0] = file.scene.lights[0].with_projector(TextureId(0), Vec3::X, Vec3::Z, 1.0);
    animation.pose(&mut file.scene, 2.0).unwrap();
    let turn = Quat::from_rotation_y(1.0);
    let after = corners(&file.scene);
    assert_eq!(after[0], before[0]);
    for corner in 0..3 {
        assert_near(after[1][corner], turn * before[1][corner]);
    }
    let light = &file.scene.lights[0];
    assert_near(light.position.as_vec3(), turn * Vec3::X);
    assert_near(light.cone.unwrap().direction, turn * -Vec3::Z);
    let projector = light.projector.unwrap();
    assert_near(projector.direction, turn * -Vec3::Z);
    assert_near(projector.up, Vec3::Y);
    let rest = file.cameras[0].1;
    let camera = animation.cameras(2.0).unwrap()[0];
    assert_eq!(animation.cameras(0.0).unwrap(), [rest]);
    let (pose, own) = (camera.pose().unwrap(), rest.pose().unwrap());
    assert_near(pose.eye.as_vec3(), turn * Vec3::X);
    assert_near(pose.forward, turn * -Vec3::Z);
    assert_eq!((pose.screen_distance, pose.interaxial), (own.screen_distance, own.interaxial));
    // A light of the user's does not move.
    file.scene.lights[0].intensity *= 2.0;
    animation.pose(&mut file.scene, 0.0).unwrap();
    assert_near(file.scene.lights[0].position.as_vec3(), turn * Vec3::X);
}

/// A strip of five quads along y, whose vertices follow two joints by their height. The node's own transform does not
/// count.
fn skinned() -> (Builder, [usize; 2]) {
    let mut builder = Builder::new();
    let positions: Vec<[f32; 3]> = (0..12).map(|vertex| [(vertex % 2) as f32, (vertex / 2) as f32, 0.5]).collect();
    let indices = (0..5).flat_map(|row| [0, 1, 2, 1, 3, 2].map(|corner| 2 * row + corner));
    let indices = builder.indices(&indices.collect::<Vec<u32>>());
    let joints = builder.accessor(&[[0, 1, 0, 0]; 12].concat(), 5121, "VEC4", 12);
    // Weights that do not sum to 1 are scaled.
    let weights: Vec<[f32; 4]> = positions.iter().map(|[_, y, _]| [2.0 * (5.0 - y), 2.0 * y, 0.0, 0.0]).collect();
    let weights = builder.floats(&weights);
    let normals = builder.floats(&[[0.0, 0.0, 1.0]; 12]);
    let more = json!({
        "indices": indices,
        "attributes": { "JOINTS_0": joints, "WEIGHTS_0": weights, "NORMAL": normals },
    });
    let mesh = builder.mesh(&positions, more);
    let binds = [Mat4::from_translation(Vec3::new(0.0, -1.0, 0.0)), Mat4::from_translation(Vec3::new(0.0, -4.0, 0.0))];
    let bytes: Vec<u8> = binds.iter().flat_map(|bind| bind.to_cols_array()).flat_map(f32::to_le_bytes).collect();
    let binds = builder.accessor(&bytes, 5126, "MAT4", 2);
    let tip = builder.push("nodes", json!({ "translation": [0.0, 3.0, 0.0] }));
    let root = builder.node(json!({ "translation": [0.0, 1.0, 0.0], "children": [tip] }));
    let skin = builder.push("skins", json!({ "joints": [root, tip], "inverseBindMatrices": binds }));
    builder.node(json!({ "mesh": mesh, "skin": skin, "translation": [100.0, 0.0, 0.0] }));
    (builder, [root, tip])
}

#[test]
fn skins_follow_their_joints() {
    let (mut builder, [root, tip]) = skinned();
    let at_rest = open(builder.text()).scene;
    // At rest the joints are where they were bound.
    assert_near(corners(&at_rest)[0][0], Vec3::new(0.0, 0.0, 0.5));
    let values = builder.floats(&[[0.0, 0.0, 0.0, 1.0], Quat::from_rotation_x(1.2).to_array()]);
    animate(&mut builder, tip, "rotation", "LINEAR", &[0.0, 1.0], values);
    let values = builder.floats(&[[0.0, 1.0, 0.0], [0.5, 1.0, 0.0]]);
    let input = builder.floats(&[[0.0], [1.0]]);
    builder.json["animations"][0]["samplers"].as_array_mut().unwrap().push(json!({ "input": input, "output": values }));
    let channel = json!({ "sampler": 1, "target": { "node": root, "path": "translation" } });
    builder.json["animations"][0]["channels"].as_array_mut().unwrap().push(channel);
    let mut file = open(builder.text());
    file.animations[0].pose(&mut file.scene, 0.5).unwrap();
    let root = DMat4::from_translation(DVec3::new(0.25, 1.0, 0.0));
    let tip = root * DMat4::from_translation(DVec3::new(0.0, 3.0, 0.0)) * DMat4::from_quat(DQuat::from_rotation_x(0.6));
    let moves = [
        root * DMat4::from_translation(DVec3::new(0.0, -1.0, 0.0)),
        tip * DMat4::from_translation(DVec3::new(0.0, -4.0, 0.0)),
    ];
    let rest = corners(&at_rest);
    for (triangle, found) in corners(&file.scene).into_iter().enumerate() {
        for corner in 0..3 {
            let from = rest[triangle][corner];
            let share = f64::from(from.y) / 5.0;
            let blend = moves[0] * (1.0 - share) + moves[1] * share;
            assert_near(found[corner], blend.transform_point3(from.as_dvec3()).as_vec3());
            // Smooth normals are those of the blended matrix, like three.js's and Blender's.
            let normal = blend.inverse().transpose().transform_vector3(DVec3::Z).normalize().as_vec3();
            assert_near(file.scene.triangles()[triangle].normals[corner], normal);
        }
    }
}

#[test]
fn morph_targets_add_to_the_mesh_by_their_weights() {
    let mut builder = Builder::new();
    let up = builder.floats(&[[0.0; 3], [0.0; 3], [0.0, 0.0, 2.0]]);
    let right = builder.floats(&[[4.0, 0.0, 0.0]; 3]);
    let mesh = builder.mesh(&TRIANGLE, json!({ "targets": [{ "POSITION": up }, { "POSITION": right }] }));
    builder.json["meshes"][mesh]["weights"] = json!([0.5, 0.0]);
    let first = builder.node(json!({ "mesh": mesh }));
    builder.node(json!({ "mesh": mesh, "weights": [0.0, 1.0] }));
    let values = builder.floats(&[[0.5], [0.0], [1.0], [0.25]]);
    animate(&mut builder, first, "weights", "LINEAR", &[0.0, 2.0], values);
    let mut file = open(builder.text());
    let rest = corners(&file.scene);
    assert_near(rest[0][2], Vec3::new(0.0, 1.0, 1.0));
    assert_near(rest[1][0], 4.0 * Vec3::X);
    file.animations[0].pose(&mut file.scene, 2.0).unwrap();
    let posed = corners(&file.scene);
    assert_near(posed[0][2], Vec3::new(1.0, 1.0, 2.0));
    assert_eq!(posed[1], rest[1]);
}

#[test]
fn content_changes_with_every_number_that_moves_something() {
    let content = |builder: &Builder| {
        let mut bytes = Vec::new();
        open(builder.text()).animations[0].content(|piece| bytes.extend_from_slice(piece));
        bytes
    };
    let moved = |values: &[[f32; 3]; 2], times: &[f32; 2]| animated("translation", "LINEAR", times, values);
    let first = content(&moved(&[[0.0; 3], [1.0; 3]], &[0.0, 1.0]));
    assert_eq!(first, content(&moved(&[[0.0; 3], [1.0; 3]], &[0.0, 1.0])));
    assert_ne!(first, content(&moved(&[[0.0; 3], [1.0, 1.0, 1.5]], &[0.0, 1.0])));
    assert_ne!(first, content(&moved(&[[0.0; 3], [1.0; 3]], &[0.0, 1.5])));
    assert_ne!(first, content(&animated("translation", "STEP", &[0.0, 1.0], &[[0.0; 3], [1.0; 3]])));
}

#[test]
fn animations_at_fault_are_refused_by_name() {
    let faulty = |change: &dyn Fn(&mut Builder)| {
        let mut builder = animated("translation", "LINEAR", &[0.0, 0.5, 0.4], &[[0.0; 3]; 3]);
        change(&mut builder);
        open_with(builder.text(), &SceneOptions::default()).unwrap_err().to_string()
    };
    let message = faulty(&|_| {});
    assert!(message.contains("animations[0].samplers[0], input: key frame 2 at 0.4"), "{message}");
    let message = faulty(&|builder| builder.json["animations"][0]["samplers"][0]["interpolation"] = json!("CUBIC"));
    assert!(message.contains("interpolation is unknown"), "{message}");
    type Change = (&'static str, fn(&mut Builder));
    let changes: [Change; 4] = [
        ("channels[0]: there is no nodes[9]", |builder| {
            builder.json["animations"][0]["channels"][0]["target"]["node"] = json!(9);
        }),
        ("channels[0]: there is no samplers[3]", |builder| {
            builder.json["animations"][0]["channels"][0]["sampler"] = json!(3);
        }),
        ("channels[1]: another channel has the same node and path", |builder| {
            let channel = builder.json["animations"][0]["channels"][0].clone();
            builder.json["animations"][0]["channels"].as_array_mut().unwrap().push(channel);
        }),
        ("output: it has 9 numbers for 2 key frames of 3 each", |builder| {
            let input = builder.floats(&[[0.0], [1.0]]);
            builder.json["animations"][0]["samplers"][0]["input"] = json!(input);
        }),
    ];
    for (expected, change) in changes {
        let message = faulty(&|builder| {
            let input = builder.floats(&[[0.0], [0.5], [0.6]]);
            builder.json["animations"][0]["samplers"][0]["input"] = json!(input);
            change(builder);
        });
        assert!(message.contains(expected), "{message}");
    }
    let (mut builder, _) = skinned();
    builder.json["skins"][0]["joints"] = json!([1]);
    let message = open_with(builder.text(), &SceneOptions::default()).unwrap_err().to_string();
    assert!(message.contains("nodes[2]: meshes[0] has joint 1, but skins[0] has 1 joint"), "{message}");
}

#[test]
fn a_pose_needs_the_file_s_scene_and_a_finite_time() {
    let file = open(animated("translation", "LINEAR", &[0.0, 1.0], &[[0.0; 3], [1.0; 3]]).text());
    let animation: &Animation = &file.animations[0];
    let refused = |scene: &mut stereotrace::Scene, seconds| animation.pose(scene, seconds).unwrap_err().to_string();
    assert!(refused(&mut file.scene.clone(), f64::NAN).contains("animation 'translation': its time is NaN"));
    let message = refused(&mut stereotrace::Builtin::Near.scene(), 0.0);
    assert!(message.contains("object 0: it is not an object of the animation's file"), "{message}");
    let mut moved = file.scene.clone();
    moved.transform_object(0, &Affine3A::from_translation(Vec3::X)).unwrap();
    animation.pose(&mut moved, 0.0).unwrap();
    assert_eq!(corners(&moved)[0][0], Vec3::ZERO);
}
