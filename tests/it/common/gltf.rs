//! glTF files for tests, built item by item.

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Value, json};

/// A glTF file, as JSON and one buffer.
#[derive(Clone)]
pub(crate) struct Builder {
    pub json: Value,
    pub bytes: Vec<u8>,
}

impl Builder {
    /// Makes a scene without nodes.
    pub(crate) fn new() -> Self {
        Self {
            json: json!({ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }] }),
            bytes: Vec::new(),
        }
    }

    /// Adds an item to a list and returns its number.
    pub(crate) fn push(&mut self, list: &str, item: Value) -> usize {
        let items = &mut self.json[list];
        if items.is_null() {
            *items = json!([]);
        }
        let items = items.as_array_mut().unwrap();
        items.push(item);
        items.len() - 1
    }

    /// Adds a node to the scene.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(index));
        index
    }

    /// Adds bytes to the buffer, with a buffer view of their own.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        self.bytes.extend(bytes);
        self.push("bufferViews", view)
    }

    pub(crate) fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }))
    }

    /// Adds an accessor of vectors of N numbers and returns its index.
    pub(crate) fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, kind, values.len())
    }

    pub(crate) fn indices(&mut self, indices: &[u32]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        self.accessor(&bytes, 5125, "SCALAR", indices.len())
    }

    /// Adds a mesh of one primitive with these positions and further fields.
    pub(crate) fn mesh(&mut self, positions: &[[f32; 3]], more: Value) -> usize {
        let mut primitive = json!({ "attributes": { "POSITION": self.floats(positions) } });
        for (key, value) in more.as_object().unwrap() {
            match value.as_object() {
                Some(attributes) if key == "attributes" => {
                    attributes.iter().for_each(|(key, value)| primitive["attributes"][key] = value.clone());
                }
                _ => primitive[key] = value.clone(),
            }
        }
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    /// Makes a scene with one triangle of this material, at a node.
    pub(crate) fn triangle(material: Value) -> Self {
        let mut builder = Self::new();
        let material = builder.push("materials", material);
        let uv = builder.floats(&[[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
        let more = json!({ "material": material, "attributes": { "TEXCOORD_0": uv } });
        let mesh = builder.mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], more);
        builder.node(json!({ "mesh": mesh }));
        builder
    }

    /// Adds a texture of these bytes.
    pub(crate) fn texture(&mut self, png: &[u8]) -> usize {
        let view = self.view(png);
        let image = self.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        self.push("textures", json!({ "source": image }))
    }

    /// Returns the file as text, with its buffer in a URI.
    pub(crate) fn text(&self) -> String {
        let mut json = self.json.clone();
        if !self.bytes.is_empty() {
            json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": data_uri(&self.bytes) }]);
        }
        serde_json::to_string_pretty(&json).unwrap()
    }

    /// Returns the file as a binary file.
    pub(crate) fn binary(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if !self.bytes.is_empty() {
            json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        }
        binary(serde_json::to_vec(&json).unwrap(), &self.bytes)
    }
}

pub(crate) fn data_uri(bytes: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes))
}

/// Returns a binary file of this JSON and this buffer.
pub(crate) fn binary(mut json: Vec<u8>, buffer: &[u8]) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let padding = buffer.len().next_multiple_of(4) - buffer.len();
    let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    let mut chunk = |kind: &[u8], parts: [&[u8]; 2]| {
        file.extend((parts.concat().len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(parts.concat());
    };
    chunk(b"JSON", [&json, &[]]);
    if !buffer.is_empty() {
        chunk(b"BIN\0", [buffer, &[0; 3][..padding]]);
    }
    let length = file.len() as u32;
    file[8..12].copy_from_slice(&length.to_le_bytes());
    file
}
