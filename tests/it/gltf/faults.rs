//! Tests files with errors, and files that take too much memory or time.

use serde_json::{Value, json};
use stereotrace::{Error, Limits, Scene, SceneOptions};

use super::{
    common::{folder::Folder, warnings},
    gltf::{Builder, binary, data_uri},
    open_with,
};

/// Returns the reason of the error that `content` gives.
#[track_caller]
fn error(content: impl AsRef<[u8]>) -> String {
    match open_with(content, &SceneOptions::default()) {
        Err(Error::Parse { reason, .. }) => reason,
        other => panic!("not a file error: {:?}", other.map(|_| ())),
    }
}

#[track_caller]
fn says(expected: &str, change: impl FnOnce(&mut Value)) {
    let mut builder = Builder::triangle(json!({}));
    let indices = builder.indices(&[0, 1, 2]);
    builder.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    change(&mut builder.json);
    let reason = error(builder.text());
    assert!(reason.contains(expected), "{expected}: {reason}");
}

#[test]
fn indices_and_lengths_out_of_range_are_named_with_what_names_them() {
    // The accessors are texture coordinates (0), positions (1) and indices (2).
    says("scene: there is no scenes[3]; the list has length 1", |json| json["scene"] = json!(3));
    says("the scene: there is no nodes[9]; the list has length 1", |json| json["scenes"][0]["nodes"] = json!([9]));
    says("nodes[0]: there is no nodes[7]; the list has length 1", |json| json["nodes"][0]["children"] = json!([7]));
    says("nodes[0]: there is no meshes[1]; the list has length 1", |json| json["nodes"][0]["mesh"] = json!(1));
    says("nodes[0]: there is no cameras[0]; the list has length 0", |json| json["nodes"][0]["camera"] = json!(0));
    says("meshes[0].primitives[0]: there is no materials[4]; the list has length 1", |json| {
        json["meshes"][0]["primitives"][0]["material"] = json!(4);
    });
    says("meshes[0].primitives[0], POSITION: there is no accessors[8]; the list has length 3", |json| {
        json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(8);
    });
    says("meshes[0].primitives[0], indices: there is no accessors[8]; the list has length 3", |json| {
        json["meshes"][0]["primitives"][0]["indices"] = json!(8);
    });
    says("accessors[1]: there is no bufferViews[5]; the list has length 3", |json| {
        json["accessors"][1]["bufferView"] = json!(5)
    });
    says("accessors[1]: it has no bufferView", |json| {
        drop(json["accessors"][1].as_object_mut().unwrap().remove("bufferView"))
    });
    says("accessors[1]: it is Scalar, but meshes[0].primitives[0], POSITION needs [Vec3]", |json| {
        json["accessors"][1]["type"] = json!("SCALAR");
    });
    says("accessors[1]: its type or componentType is unknown", |json| {
        json["accessors"][1]["componentType"] = json!(5124)
    });
    says("accessors[1]: bufferViews[1] of 36 bytes is too small for 4 elements of 12 bytes from byte 0 on", |json| {
        json["accessors"][1]["count"] = json!(4);
    });
    says("is too small for 3 elements of 12 bytes from byte 18446744073709551615 on", |json| {
        json["accessors"][1]["byteOffset"] = json!(u64::MAX);
    });
    says("accessors[1]: a byteStride of 4 is too small for elements of 12 bytes", |json| {
        json["bufferViews"][1]["byteStride"] = json!(4)
    });
    says("accessors[1]: bufferViews[1] of 36 bytes is too small for 3 elements of 12 bytes from byte 0 on", |json| {
        json["bufferViews"][1]["byteStride"] = json!(u64::MAX);
    });
    says("bufferViews[1]: 18446744073709551615 bytes from byte 24 on exceed its buffer of 72 bytes", |json| {
        json["bufferViews"][1]["byteLength"] = json!(u64::MAX);
    });
    says("bufferViews[1]: there is no buffers[2]; the list has length 1", |json| {
        json["bufferViews"][1]["buffer"] = json!(2)
    });
    says("meshes[0].primitives[0]: TEXCOORD has length 2 for 3 vertices", |json| {
        json["accessors"][0]["count"] = json!(2)
    });
    says("meshes[0].primitives[0]: index 2 is 2, out of range for 2 vertices", |json| {
        json["accessors"][1]["count"] = json!(2);
        json["accessors"][0]["count"] = json!(2);
    });
    says("meshes[0].primitives[0]: 2 corners are not a multiple of 3", |json| json["accessors"][2]["count"] = json!(2));
    says("accessors[2]: indices of type F32; they must be unsigned integers", |json| {
        json["accessors"][2]["componentType"] = json!(5126)
    });
    says("meshes[0].primitives[0]: its mode is unknown", |json| json["meshes"][0]["primitives"][0]["mode"] = json!(7));
    says("accessors[1]: there is no bufferViews[9]; the list has length 3", |json| {
        json["accessors"][1]["bufferView"] = json!(9)
    });
    // From the second byte of index 1 on, the bytes are 0, 0, 0, 2, which is 33,554,432.
    says("accessors[1], sparse.indices: 33554432 is out of range for 3 elements", |json| {
        json["accessors"][1]["sparse"] = json!({ "count": 1, "values": { "bufferView": 1 },
            "indices": { "bufferView": 2, "byteOffset": 5, "componentType": 5125 } });
    });
}

#[test]
fn nodes_in_circles_or_with_two_parents_are_refused() {
    says("nodes[0]: its child nodes[0] has another parent, or is its ancestor", |json| {
        json["nodes"][0]["children"] = json!([0])
    });
    says("nodes[1]: its child nodes[0] has another parent, or is its ancestor", |json| {
        json["nodes"] = json!([{ "children": [1] }, { "children": [0] }]);
    });
    says("nodes[2]: its child nodes[3] has another parent, or is its ancestor", |json| {
        json["nodes"] = json!([{ "children": [1, 2] }, { "children": [3] }, { "children": [3] }, { "mesh": 0 }]);
    });
    says("the scene: its child nodes[0] has another parent", |json| json["scenes"][0]["nodes"] = json!([0, 0]));
    // A chain of all nodes is valid, however deep it is.
    let mut builder = Builder::triangle(json!({}));
    for index in 0..20_000 {
        builder.push("nodes", json!({ "children": [index], "translation": [0, 0, 1] }));
    }
    builder.json["scenes"][0]["nodes"] = json!([20_000]);
    let scene = open_with(builder.text(), &SceneOptions::default()).unwrap().scene;
    assert_eq!(scene.bounds().unwrap().0.z, 20_000.0);
}

#[test]
fn numbers_that_are_none_are_named() {
    says("nodes[0]: its rotation [0, 0, 0, 0] must be finite and not 0", |json| {
        json["nodes"][0]["rotation"] = json!([0, 0, 0, 0])
    });
    says("nodes[0]: the last row of its matrix is [0, 0, 0, 2]; it must be 0, 0, 0, 1", |json| {
        json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2]);
    });
    says("vertex 2: coordinate 1000000000 is beyond", |json| json["nodes"][0]["scale"] = json!([1, 1e9, 1]));
    says("origin: it is [0, 1000000000000000, 0]; its coordinates must be numbers within ±1e13", |json| {
        json["nodes"][0]["translation"] = json!([0, 1e15, 0]);
    });
    says("invalid glTF JSON: ", |json| json["nodes"][0]["translation"] = json!([0, null, 0]));
    let mut builder = Builder::triangle(json!({}));
    let nan = builder.floats(&[[0.0f32; 3], [0.0, f32::NAN, 0.0], [1.0; 3]]);
    for name in ["POSITION", "NORMAL"] {
        let mut broken = builder.clone();
        broken.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(nan);
        let reason = error(broken.text());
        assert!(reason.contains("accessors[2]: element 1 is [0.0, NaN, 0.0]; its numbers must be finite"), "{reason}");
    }
    let camera = |perspective: Value| {
        move |json: &mut Value| {
            json["cameras"] = json!([{ "type": "perspective", "perspective": perspective }]);
            json["nodes"][0]["camera"] = json!(0);
        }
    };
    says("cameras[0]: at nodes[0]: invalid camera: vertical_fov is ", camera(json!({ "yfov": 3.2, "znear": 1 })));
    says("cameras[0]: its aspectRatio is 0", camera(json!({ "yfov": 1, "znear": 1, "aspectRatio": 0 })));
    says("cameras[0]: it has no perspective", |json| {
        json["cameras"] =
            json!([{ "type": "perspective", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 1, "znear": 0 } }]);
        json["nodes"][0]["camera"] = json!(0);
    });
    let lamp = |light: Value| {
        move |json: &mut Value| {
            json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
            json["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
        }
    };
    says(
        "lights[0]: its intensity is -1 times [1, 1, 1]; it must be finite and not negative",
        lamp(json!({ "type": "point", "intensity": -1 })),
    );
    says("lights[0]: its type is unknown", lamp(json!({ "type": "area" })));
    says("nodes[0]: there is no lights[0]; the list has length 0", |json| {
        json["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    });
}

#[test]
fn versions_and_extensions_that_are_not_known_are_refused_by_name() {
    says("it is glTF 1.0; only version 2 is supported", |json| json["asset"]["version"] = json!("1.0"));
    // Version 1 has objects in place of lists.
    says("it is glTF 1.0; only version 2 is supported", |json| {
        json["asset"]["version"] = json!("1.0");
        json["nodes"] = json!({ "node": {} });
    });
    says(
        "it requires KHR_draco_mesh_compression, KHR_texture_basisu; the supported extensions are KHR_lights_punctual, \
         ",
        |json| {
            json["extensionsRequired"] =
                json!(["KHR_draco_mesh_compression", "KHR_materials_unlit", "KHR_texture_basisu"]);
        },
    );
    says("no triangles in its scene and 1 node; a scene needs meshes of triangles", |json| {
        json["meshes"][0]["primitives"] = json!([])
    });
    says("no triangles in its scene", |json| json["meshes"][0]["primitives"][0]["mode"] = json!(0));
}

#[test]
fn buffers_are_what_they_say_or_named() {
    let mut builder = Builder::triangle(json!({}));
    let bytes = builder.bytes.clone();
    let mut with = |buffer: Value| {
        builder.json["buffers"] = json!([buffer]);
        serde_json::to_vec(&builder.json).unwrap()
    };
    let uri = data_uri(&bytes);
    for (buffer, expected) in [
        (json!({ "byteLength": 60 }), "buffers[0]: it has no URI and no binary chunk"),
        (json!({ "byteLength": 61, "uri": uri }), "buffers[0]: its byteLength is 61, but it has 60 bytes"),
        (json!({ "byteLength": 60, "uri": uri.replace(";base64", "") }), "buffers[0]: its data URI is not base64"),
        (
            json!({ "byteLength": 60, "uri": uri.replace("AAAA", "A*AA") }),
            "buffers[0]: its data URI is not valid base64: ",
        ),
        (json!({ "byteLength": 60, "uri": "http://localhost/a.bin" }), "buffers[0]: 'http:' URIs are not supported"),
        (json!({ "byteLength": 60, "uri": "file:///etc/passwd" }), "buffers[0]: 'file:' URIs are not supported"),
    ] {
        let reason = error(with(buffer));
        assert!(reason.contains(expected), "{expected}: {reason}");
    }
    let folder = Folder::new("gltf_buffers");
    let said = |content: &[u8], options: &SceneOptions| {
        Scene::from_gltf_with(folder.write("scene.gltf", content), options).unwrap_err().to_string()
    };
    let beside = with(json!({ "byteLength": 60, "uri": "a.bin" }));
    let plain = SceneOptions::default();
    assert!(said(&beside, &plain).contains("a.bin: "));
    std::fs::create_dir(folder.file("a.bin")).unwrap();
    assert!(said(&beside, &plain).contains("a.bin: it is a folder; only regular files are read"));
    std::fs::remove_dir(folder.file("a.bin")).unwrap();
    folder.write("a.bin", [&bytes[..], &[0; 10_000]].concat());
    let limits = Limits::default().file_bytes(5000).option_names("--max-file", "");
    let message = said(&beside, &plain.limits(limits));
    assert!(
        message.contains("a.bin: the file has 10060 bytes, over the limit of 5000; raise it with --max-file"),
        "{message}"
    );
    // All buffers share one limit.
    let mut two: Value = serde_json::from_slice(&beside).unwrap();
    let mut with_second = |uri: &str| {
        two["buffers"] = json!([{ "byteLength": 60, "uri": "a.bin" }, { "byteLength": 60, "uri": uri }]);
        two["bufferViews"][0]["buffer"] = json!(1);
        serde_json::to_vec(&two).unwrap()
    };
    std::fs::copy(folder.file("a.bin"), folder.file("b.bin")).unwrap();
    let limited = plain.limits(Limits::default().file_bytes(15_000));
    let other = with_second("b.bin");
    assert!(said(&other, &limited).contains("over the limit of 4940"));
    assert!(Scene::from_gltf(folder.write("scene.gltf", &other)).is_ok());
    // A file that several buffers name is read once.
    assert!(Scene::from_gltf_with(folder.write("scene.gltf", with_second("./a.bin")), &limited).is_ok());
}

#[test]
fn binary_files_that_are_cut_or_lie_are_refused() {
    let whole = Builder::triangle(json!({})).binary();
    assert!(open_with(&whole, &SceneOptions::default()).is_ok());
    // A file that is cut anywhere is an error.
    for length in 0..whole.len() {
        assert!(open_with(&whole[..length], &SceneOptions::default()).is_err(), "{length} of {} bytes", whole.len());
    }
    let with = |at: usize, word: u32| {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        error(bytes)
    };
    assert!(with(4, 1).contains("it is binary glTF 1; only version 2 is supported"));
    assert!(with(8, u32::MAX).contains("bytes, but its header states 4294967295"));
    assert!(with(8, 12).contains("the chunk at byte 12 has "));
    assert!(with(12, u32::MAX).contains("the chunk at byte 12 has 4294967295 bytes and exceeds the file"));
    assert!(with(16, 7).contains("it has no JSON chunk"));
    assert!(error(binary(b"[1, 2".to_vec(), &[])).contains("invalid glTF JSON: "));
    let deep = format!("{{\"extras\":{}", "[".repeat(100_000));
    assert!(error(deep).contains("invalid glTF JSON: "));
}

#[test]
fn a_line_of_broken_json_is_named() {
    match open_with("{\n\"asset\": {\n\"version\" \"2.0\"}}", &SceneOptions::default()) {
        Err(Error::Parse { line, reason, .. }) => {
            assert!(line == Some(3) && reason.contains("expected `:`"), "{line:?} {reason}")
        }
        other => panic!("{:?}", other.map(|_| ())),
    }
}

/// Tests small files that declare large content.
#[test]
fn bombs_are_refused_with_what_raises_their_limit() {
    let start = std::time::Instant::now();
    let said = |builder: &Builder, limits: Limits| {
        let limits = limits.triangle_option_name("--max-triangles");
        open_with(builder.binary(), &SceneOptions::default().limits(limits)).unwrap_err().to_string()
    };
    // There are a thousand instances of a thousand triangles.
    let mut instances = Builder::new();
    let mesh = instances.mesh(&vec![[0.5; 3]; 3000], json!({}));
    for _ in 0..1000 {
        instances.node(json!({ "mesh": mesh }));
    }
    let message = said(&instances, Limits::default().triangles(999_999));
    assert!(
        message.contains("its scene has 1000000 triangles, over the limit of 999999; raise it with --max-triangles"),
        "{message}"
    );
    // A mesh has a thousand primitives with the same vertices, and each shows one triangle.
    let mut shared = Builder::new();
    let indices = shared.indices(&[0, 1, 2]);
    let mesh = shared.mesh(&vec![[0.5; 3]; 300_000], json!({ "indices": indices }));
    let primitive = shared.json["meshes"][mesh]["primitives"][0].clone();
    shared.json["meshes"][mesh]["primitives"] = json!(vec![primitive; 1000]);
    shared.node(json!({ "mesh": mesh }));
    let message = said(&shared, Limits::default().triangles(1_000_000));
    assert!(message.contains("meshes[0] has 3300000 vertices, over the limit of 3000000"), "{message}");
    // An accessor has only a count and no bytes.
    let mut sparse = Builder::triangle(json!({}));
    let position = sparse.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap() as usize;
    let accessor = &mut sparse.json["accessors"][position];
    accessor["count"] = json!(u64::MAX);
    accessor["sparse"] =
        json!({ "count": 0, "indices": { "bufferView": 0, "componentType": 5121 }, "values": { "bufferView": 0 } });
    accessor.as_object_mut().unwrap().remove("bufferView");
    let message = said(&sparse, Limits::default());
    assert!(
        message.contains("accessors[1] has 18446744073709551615 elements, over the limit of 100663296"),
        "{message}"
    );
    // The count is within that limit, but larger than the file's size in bytes.
    sparse.json["accessors"][position]["count"] = json!(2000);
    let message = said(&sparse, Limits::default());
    let bytes = sparse.binary().len();
    let expected =
        format!("accessors[1]: 2000 elements without a bufferView; the maximum is the files' size in bytes, {bytes}");
    assert!(message.contains(&expected), "{message}");
    // The objects have fewer bytes than the limit, but count as more.
    let objects = format!(r#"{{"asset":{{"version":"2.0"}},"materials":[{}{{}}]}}"#, "{},".repeat(998));
    let said_of = |bytes: u64| {
        let limits = Limits::default().json_bytes(bytes).option_names("--max-file", "");
        open_with(&objects, &SceneOptions::default().limits(limits)).unwrap_err().to_string()
    };
    let message = said_of(32_031);
    let expected = "its JSON has 1001 objects, which count as 32 bytes each, 32032 in all, over the limit of 32031; \
                    raise it with --max-file";
    assert!(message.contains(expected), "{message}");
    assert!(said_of(32_032).contains("no triangles in its scene"), "{}", said_of(32_032));
    // These braces become nodes of hundreds of bytes each.
    let braces = format!(r#"{{"asset":{{"version":"2.0"}},"nodes":[{}{{}}]}}"#, "{},".repeat(10_000));
    let limits = Limits::default().json_bytes(20_000).option_names("--max-file", "");
    let message = open_with(&braces, &SceneOptions::default().limits(limits)).unwrap_err().to_string();
    assert!(
        message.contains("its JSON has 30")
            && message.contains("outside strings, over the limit of 20000; raise it with --max-file"),
        "{message}"
    );
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn what_pictures_do_not_show_is_named_once() {
    let folder = Folder::new("gltf_left_out");
    warnings::collect();
    let mut builder = Builder::triangle(json!({ "occlusionTexture": { "index": 0 } }));
    builder.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing", "KHR_materials_sheen", "KHR_materials_unlit"]);
    let points = builder.mesh(&[[0.0; 3]], json!({ "mode": 0 }));
    builder.node(json!({ "mesh": points }));
    builder.push("meshes", json!({ "primitives": [{ "attributes": { "_ID": 0 } }] }));
    builder.node(json!({ "mesh": 2 }));
    let sampler = json!({ "input": 0, "output": 0 });
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "pointer" } });
    builder.push("animations", json!({ "channels": [channel], "samplers": [sampler] }));
    builder.push("scenes", json!({ "nodes": [] }));
    let camera = builder.push(
        "cameras",
        json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 9, "znear": 0 } }),
    );
    builder.node(json!({ "camera": camera }));
    Scene::from_gltf(folder.write("scene.gltf", builder.text())).unwrap();
    let expected = [
        "scene.gltf: ignored extensions: EXT_mesh_gpu_instancing, KHR_materials_sheen",
        "scene.gltf: ignored: animations of other properties than nodes have in animations[0]; occlusion textures in \
         materials[0]; orthographic cameras in cameras[0]; points and lines in meshes[1]; primitives \
         without positions in meshes[2]; scenes other than the default or the first one",
    ];
    assert_eq!(warnings::of(&folder), expected);
}
