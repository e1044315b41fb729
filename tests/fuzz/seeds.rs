//! Small files that together use every feature of their format.

use serde_json::json;

use crate::{
    Files,
    gltf::{Builder, data_uri},
};

fn png() -> Vec<u8> {
    let pixels = [[255u8, 0, 0, 255], [0, 255, 0, 100], [0, 0, 255, 255], [9, 9, 9, 0]];
    let mut bytes = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    let pixels = pixels.as_flattened();
    image::ImageEncoder::write_image(encoder, pixels, 2, 2, image::ExtendedColorType::Rgba8).unwrap();
    bytes
}

pub(crate) fn obj() -> Vec<Files> {
    let obj = "mtllib scene.mtl\no first\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.2 0.1\nv 0 0 1\nvt 0 0\nvt 1 \
        0\nvt 1 1\nvn 0 0 \
               1\nvn 0 1 0\nusemtl skin\ns 1\nf 1/1/1 2/2/1 3/3/1\nf 1 2 3 4\ng wing\nf 1/1 2/2 5/3 4/1\nusemtl \
                   glass\ns \
               off\nf -1 -2 -3 -4 \\\n-5\no second\nf 1//1 3//2 6//2\nl 1 2\np 3\n";
    let colored = "v 0 0 0 1 0 0\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 0 0 2\nf 1 2 3\n";
    let mtl = "newmtl skin\nKd 0.5 0.4 0.3\nKs 0.1 0.1 0.1\nNs 20\nKe 0 0 0\nmap_Kd -s 2 2 -o 0.5 0 skin.png\nmap_d \
        skin.png\nillum \
               2\nnewmtl glass\nTf 0.9 0.9 0.9\nNi 1.5\nd 0.5\nillum 7\n";
    vec![
        vec![("scene.obj".into(), obj.into()), ("scene.mtl".into(), mtl.into()), ("skin.png".into(), png())],
        vec![("scene.obj".into(), colored.into())],
    ]
}

pub(crate) fn ply() -> Vec<Files> {
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment a square\nelement vertex 5\nproperty float x\nproperty double \
            y\nproperty float \
             z\nproperty short nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar \
                 green\nproperty uchar \
             blue\nproperty float s\nproperty float t\nelement note 1\nproperty list uchar float values\nelement face \
                 2\nproperty \
             list uchar int vertex_indices\nproperty uchar flags\nend_header\n"
        )
    };
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.2], [0.0, 1.0, 0.0], [0.4, 0.5, 0.1]];
    let mut text = header("ascii");
    for [x, y, z] in corners {
        text += &format!("{x} {y} {z} 0 0 1 255 128 0 {x} {y}\n");
    }
    text += "2 1.5 2.5\n4 0 1 2 3 7\n3 0 1 4 7\n";
    let binary = |name: &str, is_big: bool| {
        let mut bytes = header(name).into_bytes();
        let mut put = |mut number: Vec<u8>| {
            if !is_big {
                number.reverse();
            }
            bytes.extend(number);
        };
        for [x, y, z] in corners {
            put(x.to_be_bytes().into());
            put(f64::from(y).to_be_bytes().into());
            put(z.to_be_bytes().into());
            put(0i16.to_be_bytes().into());
            put(0f32.to_be_bytes().into());
            put(1f32.to_be_bytes().into());
            [255, 128, 0].into_iter().for_each(|color| put(vec![color]));
            put(x.to_be_bytes().into());
            put(y.to_be_bytes().into());
        }
        put(vec![2]);
        put(1.5f32.to_be_bytes().into());
        put(2.5f32.to_be_bytes().into());
        for face in [&[0, 1, 2, 3][..], &[0, 1, 4]] {
            put(vec![face.len() as u8]);
            face.iter().for_each(|corner: &i32| put(corner.to_be_bytes().into()));
            put(vec![7]);
        }
        bytes
    };
    let contents = [text.into_bytes(), binary("binary_little_endian", false), binary("binary_big_endian", true)];
    contents.map(|content| vec![("scene.ply".into(), content)]).into()
}

/// Returns the JSON and the buffer of a binary file that a [`Builder`] made.
pub(crate) fn parts(file: &[u8]) -> (Vec<u8>, Vec<u8>) {
    let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    (file[20..20 + length].into(), file[20 + length + 8..].into())
}

/// Returns a file with a skin, morph targets, and an animation of each kind.
fn moving() -> Builder {
    let mut all = Builder::new();
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.2], [0.0, 1.0, 0.0]];
    let joints = all.accessor(&[0, 1, 0, 0].repeat(4), 5121, "VEC4", 4);
    let weights = all.floats(&[[0.5, 0.5, 0.0, 0.0]; 4]);
    let [raised, turned] = [[[0.0, 0.0, 1.0]; 4], [[0.1, 0.0, 0.0]; 4]].map(|values| all.floats(&values));
    let normals = all.floats(&[[0.0, 0.0, 1.0]; 4]);
    let mesh = all.mesh(
        &square,
        json!({
            "mode": 6, "targets": [{ "POSITION": raised, "NORMAL": turned }, { "POSITION": turned }],
            "attributes": { "JOINTS_0": joints, "WEIGHTS_0": weights, "NORMAL": normals }
        }),
    );
    all.json["meshes"][mesh]["weights"] = json!([0.5, 0.0]);
    let identity: Vec<u8> = (0..32).flat_map(|place| f32::from(place % 5 == 0).to_le_bytes()).collect();
    let binds = all.accessor(&identity, 5126, "MAT4", 2);
    let camera = all.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }));
    let tip = all.push("nodes", json!({ "translation": [0, 1, 0], "camera": camera }));
    let root = all.node(json!({ "children": [tip] }));
    let skin = all.push("skins", json!({ "joints": [root, tip], "inverseBindMatrices": binds }));
    let body = all.node(json!({ "mesh": mesh, "skin": skin }));
    let times = all.floats(&[[0.0], [0.5], [1.0]]);
    let places = all.floats(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let turns = all.floats(&[[0.0, 0.0, 0.0, 1.0]; 9]);
    let amounts = all.floats(&[[0.0], [1.0], [0.5], [0.5], [1.0], [0.0]]);
    let target = |node: usize, path: &str, sampler: usize| {
        let target = json!({ "node": node, "path": path });
        json!({ "sampler": sampler, "target": target })
    };
    all.push(
        "animations",
        json!({
            "name": "all",
            "channels": [
                target(root, "translation", 0), target(tip, "rotation", 1), target(body, "weights", 2),
                target(tip, "scale", 0)
            ],
            "samplers": [
                { "input": times, "output": places, "interpolation": "STEP" },
                { "input": times, "output": turns, "interpolation": "CUBICSPLINE" },
                { "input": times, "output": amounts }
            ]
        }),
    );
    all
}

pub(crate) fn gltf() -> Vec<Files> {
    let mut all = Builder::new();
    let texture = all.texture(&png());
    let inline = all.push("images", json!({ "uri": data_uri(&png()) }));
    let sampler = all.push("samplers", json!({ "wrapS": 33071, "wrapT": 33648, "magFilter": 9728 }));
    let wrapped = all.push("textures", json!({ "source": inline, "sampler": sampler }));
    let skin = all.push(
        "materials",
        json!({
            "name": "skin", "alphaMode": "MASK", "alphaCutoff": 0.4, "emissiveFactor": [0.1, 0.2, 0.3],
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.4, 0.3, 0.9], "metallicFactor": 0.5, "roughnessFactor": 0.3,
                "baseColorTexture": { "index": texture, "extensions": { "KHR_texture_transform":
                    { "offset": [0.5, 0.25], "rotation": 0.3, "scale": [2, 3] } } },
                "metallicRoughnessTexture": { "index": wrapped, "texCoord": 0 }
            },
            "emissiveTexture": { "index": wrapped }, "normalTexture": { "index": texture },
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 2 } }
        }),
    );
    let glass = all.push(
        "materials",
        json!({
            "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorTexture": { "index": wrapped } },
            "extensions": {
                "KHR_materials_transmission": { "transmissionFactor": 0.5 },
                "KHR_materials_ior": { "ior": 1.4 }
            }
        }),
    );
    let unlit = all.push("materials", json!({ "extensions": { "KHR_materials_unlit": {} } }));
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.2], [0.0, 1.0, 0.0]];
    let uv = all.floats(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let normals = all.floats(&[[0.0, 0.0, 1.0]; 4]);
    let colors = all.accessor(&[255; 16], 5121, "VEC4", 4);
    all.json["accessors"][colors]["normalized"] = json!(true);
    let indices = all.indices(&[0, 1, 2, 0, 2, 3]);
    let bytes = all.accessor(&[0, 1, 2, 3], 5121, "SCALAR", 4);
    let first = all.mesh(
        &square,
        json!({
            "material": skin,
            "indices": indices,
            "attributes": { "TEXCOORD_0": uv, "NORMAL": normals, "COLOR_0": colors }
        }),
    );
    let strip = all
        .mesh(&square, json!({ "material": glass, "indices": bytes, "mode": 5, "attributes": { "TEXCOORD_0": uv } }));
    let fan = all.mesh(&square, json!({ "material": unlit, "mode": 6 }));
    let (at, values) = (all.accessor(&[1, 0], 5123, "SCALAR", 1), all.floats(&[[0.5f32, 0.5, 0.5]]));
    let [at, values] = [at, values].map(|accessor| all.json["accessors"][accessor]["bufferView"].clone());
    let sparse = all.json["meshes"][fan]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap() as usize;
    all.json["accessors"][sparse]["sparse"] = json!({
        "count": 1, "indices": { "bufferView": at, "componentType": 5123 }, "values": { "bufferView": values }
    });
    let camera = all.push(
        "cameras",
        json!({ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1, "aspectRatio": 1.5 } }),
    );
    all.json["extensionsUsed"] = json!(["KHR_lights_punctual", "EXT_other"]);
    all.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "point", "intensity": 30 }, { "type": "directional", "color": [1, 0.9, 0.8] },
        { "type": "spot", "range": 3, "spot": { "outerConeAngle": 0.5 } }
    ] } });
    let leaf = all.push("nodes", json!({ "mesh": strip, "name": "leaf", "scale": [1, -2, 1] }));
    all.node(json!({ "mesh": first, "translation": [1, 2, 3], "rotation": [0, 0.6, 0, 0.8], "children": [leaf] }));
    all.node(json!({ "mesh": fan, "matrix": [1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 3, 0, 4, 5, 6, 1] }));
    all.node(json!({ "camera": camera, "translation": [0, 0, 5] }));
    for light in 0..3 {
        all.node(json!({ "translation": [0, 3, 0], "extensions": { "KHR_lights_punctual": { "light": light } } }));
    }
    // This file refers to its buffer in a separate file.
    let mut beside = all.clone();
    beside.json["buffers"] = json!([{ "byteLength": all.bytes.len(), "uri": "the%20buffer.bin" }]);
    let mut small = Builder::triangle(json!({}));
    small.node(json!({ "mesh": 0, "translation": [1, 0, 0] }));
    let text = serde_json::to_vec(&beside.json).unwrap();
    let moving = moving();
    vec![
        vec![("scene.gltf".into(), moving.text().into())],
        vec![("scene.glb".into(), moving.binary())],
        vec![("scene.gltf".into(), all.text().into())],
        vec![("scene.glb".into(), all.binary())],
        vec![("scene.gltf".into(), text), ("the buffer.bin".into(), all.bytes)],
        vec![("scene.gltf".into(), small.text().into())],
        vec![("scene.glb".into(), small.binary())],
    ]
}
