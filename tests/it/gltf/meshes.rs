//! Tests primitives of all kinds.

use serde_json::json;
use stereotrace::{
    SceneOptions,
    glam::{Vec2, Vec3},
};

use super::{assert_near, corners, gltf::Builder, open, open_with, scene};

const HEXAGON: [[f32; 3]; 6] =
    [[2.0, 0.0, 0.0], [1.0, 2.0, 0.0], [-1.0, 2.0, 0.0], [-2.0, 0.0, 0.0], [-1.0, -2.0, 0.0], [1.0, -2.0, 0.0]];

/// Returns the corners of the triangles as indices of the hexagon's vertices.
fn numbers(builder: &Builder) -> Vec<[usize; 3]> {
    let scene = scene(builder.text());
    let number = |corner: Vec3| HEXAGON.iter().position(|vertex| Vec3::from_array(*vertex) == corner).unwrap();
    corners(&scene).into_iter().map(|corners| corners.map(number)).collect()
}

#[test]
fn lists_strips_and_fans_are_triangles_with_indices_and_without() {
    let list = vec![[0, 1, 2], [3, 4, 5]];
    let strip = vec![[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]];
    let fan = vec![[1, 2, 0], [2, 3, 0], [3, 4, 0], [4, 5, 0]];
    for (mode, expected) in [(4, list), (5, strip), (6, fan)] {
        for component in [None, Some(5121), Some(5123), Some(5125)] {
            let mut builder = Builder::new();
            let size = component.map_or(0, |component| [1, 0, 2, 0, 4][component as usize - 5121]);
            let bytes: Vec<u8> = (0..6u32).flat_map(|index| index.to_le_bytes()[..size].to_vec()).collect();
            let indices = component.map(|component| builder.accessor(&bytes, component, "SCALAR", 6));
            let mesh = builder.mesh(&HEXAGON, json!({ "mode": mode, "indices": indices }));
            builder.node(json!({ "mesh": mesh }));
            assert_eq!(numbers(&builder), expected, "mode {mode}, indices of {component:?}");
        }
    }
}

#[test]
fn interleaved_normalised_and_sparse_numbers_are_read() {
    let mut builder = Builder::new();
    // Positions are normalised 16-bit integers and colours are bytes. A vertex takes 12 bytes.
    let vertices =
        [([0i16, 0, 0], [255u8, 0, 0, 255]), ([32767, 0, -32768], [0, 51, 0, 255]), ([0, 32767, 0], [0, 0, 255, 9])];
    let bytes: Vec<u8> = vertices
        .iter()
        .flat_map(|(position, color)| {
            position.iter().flat_map(|value| value.to_le_bytes()).chain([0; 2]).chain(*color).collect::<Vec<_>>()
        })
        .collect();
    let view = builder.view(&bytes);
    builder.json["bufferViews"][view]["byteStride"] = json!(12);
    let mut accessor = |offset: usize, component: u32, kind: &str| {
        let count = 3;
        builder.push(
            "accessors",
            json!({ "bufferView": view, "byteOffset": offset, "componentType": component, "type": kind,
            "count": count, "normalized": true }),
        )
    };
    let (positions, colors) = (accessor(0, 5122, "VEC3"), accessor(8, 5121, "VEC4"));
    let mesh = builder
        .push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions, "COLOR_0": colors } }] }));
    builder.node(json!({ "mesh": mesh }));
    builder.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let read = scene(builder.binary());
    assert_eq!(corners(&read), [[Vec3::ZERO, Vec3::new(1.0, 0.0, -1.0), Vec3::Y]]);
    // Colours are linear and stay unchanged.
    assert_eq!(read.colors(), [[Vec3::X, Vec3::new(0.0, 0.2, 0.0), Vec3::Z]]);

    let mut builder = Builder::triangle(json!({}));
    let values = builder.floats(&[[5.0f32, 6.0, 7.0]]);
    let at = builder.view(&[2]);
    let values = builder.json["accessors"][values]["bufferView"].clone();
    let position = builder.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap() as usize;
    builder.json["accessors"][position]["sparse"] = json!({
        "count": 1, "indices": { "bufferView": at, "componentType": 5121 }, "values": { "bufferView": values }
    });
    assert_eq!(corners(&scene(builder.text()))[0], [Vec3::ZERO, Vec3::X, Vec3::new(5.0, 6.0, 7.0)]);
    // Without a buffer view the other elements are zeros. There may be as many elements as the file has bytes.
    builder.json["accessors"][position].as_object_mut().unwrap().remove("bufferView");
    let read = scene(builder.text());
    assert_eq!((corners(&read)[0], read.degenerate_count()), ([Vec3::ZERO, Vec3::ZERO, Vec3::new(5.0, 6.0, 7.0)], 1));
}

#[test]
fn normals_are_those_of_the_file_or_made_or_flat() {
    let mut builder = Builder::triangle(json!({}));
    assert!(!scene(builder.text()).has_normals());
    let normals = builder.floats(&[[0.0f32, 0.0, 2.0], [0.0, 3.0, 4.0], [0.0, 0.0, 1.0]]);
    builder.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    assert_eq!(scene(builder.text()).triangles()[0].normals, [Vec3::Z, Vec3::new(0.0, 0.6, 0.8), Vec3::Z]);
    // The two sides of this roof share no vertex.
    let roof =
        [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.1], [1.0, 0.0, 0.0], [1.0, 1.0, -0.1], [0.0, 1.0, 0.1]];
    let mut builder = Builder::new();
    let mesh = builder.mesh(&roof, json!({}));
    builder.node(json!({ "mesh": mesh }));
    let smooth = open_with(builder.text(), &SceneOptions::default().crease_angle(Some(40.0))).unwrap().scene;
    assert!(smooth.has_normals() && smooth.triangles()[0].normals[1] == smooth.triangles()[1].normals[0]);
}

#[test]
fn several_primitives_are_one_object_with_the_nodes_name_or_the_meshs() {
    let mut builder =
        Builder::triangle(json!({ "name": "red", "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 1] } }));
    let blue = builder.push("materials", json!({ "name": "blue" }));
    let more = builder.mesh(&HEXAGON, json!({ "material": blue }));
    let second = builder.json["meshes"][more]["primitives"][0].clone();
    builder.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(second);
    builder.json["meshes"][0]["name"] = json!("flag");
    builder.node(json!({ "mesh": 0, "name": "second flag" }));
    let scene = scene(builder.text());
    let names: Vec<_> =
        scene.triangles().iter().map(|one| scene.materials()[one.material.0 as usize].name.as_str()).collect();
    assert_eq!(names, ["red", "blue", "blue", "red", "blue", "blue"]);
    assert_eq!((scene.object_count(), scene.object_name(0), scene.object_name(1)), (2, "flag", "second flag"));
    // v points down in the file. Primitives without coordinates have zeros.
    assert_eq!(scene.uv()[0], [Vec2::ZERO, Vec2::X, Vec2::Y]);
    assert_eq!(scene.uv()[1], [Vec2::ZERO; 3]);
    assert_near(scene.materials()[1].albedo, Vec3::X);
}

/// A name may be a million bytes long, and thousands of nodes may share it.
#[test]
fn nodes_without_names_share_that_of_their_mesh_or_camera() {
    let mut builder = Builder::triangle(json!({}));
    builder.json["meshes"][0]["name"] = json!("roof");
    builder
        .push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 }, "name": "door" }));
    builder.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }));
    for node in [
        json!({ "mesh": 0 }),
        json!({ "mesh": 0, "name": "shed" }),
        json!({ "camera": 0 }),
        json!({ "camera": 0 }),
        json!({ "camera": 1 }),
        json!({ "camera": 0, "name": "yard" }),
    ] {
        builder.node(node);
    }
    let file = open(builder.text());
    let names = [0, 1, 2].map(|object| file.scene.object_name(object));
    assert_eq!(names, ["roof", "roof", "shed"]);
    assert!(std::ptr::eq(names[0], names[1]));
    let names: Vec<&str> = file.cameras.iter().map(|(name, _)| &**name).collect();
    assert_eq!(names, ["door", "door", "camera 1", "yard"]);
    assert!(std::ptr::eq(names[0], names[1]));
}
