//! Parts of materials that gltf-json offers only as maps, together with all other extensions.

use gltf_json::{extensions::texture::TextureTransform, texture::Info};
use serde::{Deserialize, de::IgnoredAny};

/// Extensions whose parts are read here.
const NAMES: [&str; 2] = ["KHR_materials_clearcoat", "KHR_texture_transform"];

/// Parts of a material.
#[derive(Default, Deserialize)]
pub(super) struct MoreOfMaterial {
    #[serde(rename = "normalTexture")]
    normal_texture: Option<NormalTexture>,
    extensions: Option<Extensions>,
}

#[derive(Deserialize)]
struct NormalTexture {
    extensions: Option<TextureExtensions>,
}

#[derive(Deserialize)]
struct TextureExtensions {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<TextureTransform>,
}

#[derive(Deserialize)]
struct Extensions {
    #[serde(rename = "KHR_materials_clearcoat")]
    clearcoat: Option<Clearcoat>,
}

/// The extension `KHR_materials_clearcoat`.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Clearcoat {
    #[serde(default)]
    pub(super) clearcoat_factor: f32,
    pub(super) clearcoat_texture: Option<Info>,
    #[serde(default)]
    pub(super) clearcoat_roughness_factor: f32,
    pub(super) clearcoat_roughness_texture: Option<Info>,
    pub(super) clearcoat_normal_texture: Option<IgnoredAny>,
}

impl MoreOfMaterial {
    pub(super) fn clearcoat(&self) -> Option<&Clearcoat> {
        self.extensions.as_ref()?.clearcoat.as_ref()
    }

    /// Returns the map of the normal texture's coordinates.
    pub(super) fn normal_transform(&self) -> Option<&TextureTransform> {
        self.normal_texture.as_ref()?.extensions.as_ref()?.transform.as_ref()
    }
}

/// Reads these parts of a file that gltf-json has already read. The list is empty if the file does not use them.
pub(super) fn materials(json: &[u8], used: &[String]) -> Result<Vec<MoreOfMaterial>, serde_json::Error> {
    #[derive(Deserialize)]
    struct File {
        #[serde(default)]
        materials: Vec<MoreOfMaterial>,
    }
    match used.iter().any(|name| NAMES.contains(&&**name)) {
        true => serde_json::from_slice::<File>(json).map(|file| file.materials),
        false => Ok(Vec::new()),
    }
}
