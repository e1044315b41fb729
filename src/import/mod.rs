//! Readers of files: scenes, cameras and pictures.

#[cfg(feature = "json")]
pub(crate) mod camera_file;
#[cfg(any(feature = "scene-files", feature = "sky", feature = "textures", feature = "json"))]
pub(crate) mod input;
