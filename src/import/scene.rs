//! Readers of scenes, by format.

#[cfg(any(feature = "obj", feature = "gltf", feature = "ply"))]
use super::SceneOptions;
#[cfg(feature = "gltf")]
use super::gltf;
use super::input::Files;
#[cfg(feature = "obj")]
use super::obj;
#[cfg(feature = "ply")]
use super::ply;
#[cfg(feature = "obj")]
use crate::Limits;
use crate::{Error, Scene};

impl Scene {
    /// Reads a scene from an OBJ file and the MTL files that it names.
    ///
    /// - A face of n corners becomes n - 2 triangles. Convex faces become a fan from the first corner, concave ones are
    ///   cut by ear clipping. Faces that cross themselves or are far from flat become fans, with a warning.
    /// - Faces without normals are flat. A missing MTL is logged; its materials are grey.
    /// - Vertex colours (`v x y z r g b`) are sRGB.
    /// - Textures (`map_Kd`, `map_d`) of used materials are read with the feature `textures`.
    /// - A mirror or glass without a diffuse colour has its specular colour.
    /// - Unsupported features, such as highlights, lines and points, are logged once per file.
    ///
    /// DESIGN, section 8, lists the MTL fields. The scene has no lights: see [`Scene::place_lights`].
    ///
    /// # Errors
    /// - [`Error::Io`] if the file can't be read or is no regular file.
    /// - [`Error::TooLarge`] if the file exceeds its limit in [`Limits`].
    /// - [`Error::Parse`], with the line where it is known, if the file is UTF-16 or its content is wrong. Examples are
    ///   numbers that don't parse or are not finite, indices out of range, no faces, and unreadable textures.
    #[cfg(feature = "obj")]
    pub fn from_obj(path: impl AsRef<std::path::Path>) -> Result<Self, Error> {
        Self::from_obj_with(path, &SceneOptions::default())
    }

    /// Does the same as [`Scene::from_obj`], with the given limits.
    ///
    /// # Errors
    /// Returns the errors of [`Scene::from_obj`].
    #[cfg(feature = "obj")]
    pub fn from_obj_within(path: impl AsRef<std::path::Path>, limits: &Limits) -> Result<Self, Error> {
        Self::from_obj_with(path, &SceneOptions::default().limits(*limits))
    }

    /// Does the same as [`Scene::from_obj`]; `options` set limits, missing textures and missing normals.
    ///
    /// # Errors
    /// Returns the errors of [`Scene::from_obj`], and [`Error::Scene`] for a crease angle outside 0 to 180 degrees.
    #[cfg(feature = "obj")]
    pub fn from_obj_with(path: impl AsRef<std::path::Path>, options: &SceneOptions) -> Result<Self, Error> {
        obj::read(Files::Disk(&options.folder_of(path.as_ref())), path.as_ref(), options)
    }

    /// Reads a scene from a glTF 2.0 file (.gltf or .glb), with its lights. It reads the meshes of the default scene's
    /// nodes, with base colour, metal, roughness, emission, masks and transparency.
    ///
    /// `docs/FORMATS.md` has the rules. Unsupported features are logged once.
    /// [`SceneFile::open`](crate::SceneFile::open) also reads the cameras.
    ///
    /// # Errors
    /// - [`Error::Io`] if the file or one that it names can't be read or is no regular file.
    /// - [`Error::TooLarge`] if a file or the number of triangles exceeds its limit in [`Limits`].
    /// - [`Error::Parse`], naming the item, if the content is wrong. Examples are invalid JSON, indices out of range,
    ///   infinite numbers, nodes with two parents, unknown required extensions, no triangles, and unreadable textures.
    #[cfg(feature = "gltf")]
    pub fn from_gltf(path: impl AsRef<std::path::Path>) -> Result<Self, Error> {
        Self::from_gltf_with(path, &SceneOptions::default())
    }

    /// Does the same as [`Scene::from_gltf`]; `options` set limits, missing textures and missing normals.
    ///
    /// # Errors
    /// Returns the errors of [`Scene::from_gltf`], and [`Error::Scene`] for a crease angle outside 0 to 180 degrees.
    #[cfg(feature = "gltf")]
    pub fn from_gltf_with(path: impl AsRef<std::path::Path>, options: &SceneOptions) -> Result<Self, Error> {
        gltf::read(Files::Disk(&options.folder_of(path.as_ref())), path.as_ref(), options).map(|file| file.scene)
    }

    /// Reads a mesh from a PLY file, text or binary of either byte order. It reads positions, normals, sRGB colours and
    /// texture coordinates of vertices, and faces. Faces become triangles as in [`Scene::from_obj`]. Without vertex
    /// colours the mesh is grey.
    ///
    /// `docs/FORMATS.md` lists the properties; unsupported ones are logged once. The scene has no lights: see
    /// [`Scene::place_lights`].
    ///
    /// # Errors
    /// - [`Error::Io`] if the file can't be read or is no regular file.
    /// - [`Error::TooLarge`] if the file exceeds its limit in [`Limits`].
    /// - [`Error::Parse`], with element and line where they are known, if the content is wrong. Examples are an invalid
    ///   header, numbers that are missing or not finite, corners out of range, and no faces, as in point clouds.
    #[cfg(feature = "ply")]
    pub fn from_ply(path: impl AsRef<std::path::Path>) -> Result<Self, Error> {
        Self::from_ply_with(path, &SceneOptions::default())
    }

    /// Does the same as [`Scene::from_ply`]; `options` set limits and missing normals.
    ///
    /// # Errors
    /// Returns the errors of [`Scene::from_ply`], and [`Error::Scene`] for a crease angle outside 0 to 180 degrees.
    #[cfg(feature = "ply")]
    pub fn from_ply_with(path: impl AsRef<std::path::Path>, options: &SceneOptions) -> Result<Self, Error> {
        ply::read(Files::Disk(&options.folder_of(path.as_ref())), path.as_ref(), options)
    }
}
