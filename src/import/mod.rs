//! Reads files of scenes, cameras and pictures.

#[cfg(feature = "json")]
pub(crate) mod camera_file;
#[cfg(feature = "json")]
mod camera_json;
#[cfg(any(feature = "obj", feature = "ply"))]
mod ears;
#[cfg(feature = "scene-files")]
mod file;
#[cfg(feature = "gltf")]
mod gltf;
#[cfg(any(feature = "scene-files", feature = "sky", feature = "textures", feature = "json"))]
pub(crate) mod input;
#[cfg(feature = "obj")]
mod obj;
#[cfg(feature = "scene-files")]
mod options;
#[cfg(feature = "scene-files")]
mod origin;
#[cfg(feature = "ply")]
mod ply;
#[cfg(any(feature = "obj", feature = "ply"))]
mod polygon;
#[cfg(any(feature = "obj", feature = "gltf", feature = "ply"))]
mod scene;
#[cfg(feature = "sky")]
mod sky;
#[cfg(feature = "textures")]
mod texture;
#[cfg(feature = "scene-files")]
mod warnings;

#[cfg(feature = "scene-files")]
pub use file::SceneFile;
#[cfg(feature = "scene-files")]
pub use options::{MissingTextures, OutsideFiles, SceneOptions};
#[cfg(feature = "scene-files")]
pub use origin::Origin;
