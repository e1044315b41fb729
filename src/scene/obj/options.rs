//! How an OBJ is read.

use crate::Limits;

/// What becomes of a texture of an MTL that can't be read: its file is missing, broken, too large or none at all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MissingTextures {
    /// The scene is not read: the error names the MTL's line.
    #[default]
    Error,
    /// The material is without it, and a warning names the MTL's line.
    Warn,
}

/// How [`Scene::from_obj_with`](crate::Scene::from_obj_with) reads a file.
///
/// ```
/// use stereotrace::{Limits, MissingTextures, ObjOptions};
///
/// let options = ObjOptions::default()
///     .limits(Limits::default().texture_pixels(1 << 28))
///     .missing_textures(MissingTextures::Warn)
///     .crease_angle(Some(30.0));
/// # let _ = options;
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjOptions {
    pub(super) limits: Limits,
    pub(super) missing_textures: MissingTextures,
    pub(super) crease_angle: Option<f32>,
}

impl ObjOptions {
    /// How large the files may be, and the pictures of textures. [`Limits::default`] where nothing is said.
    pub fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// What becomes of textures that can't be read. An error where nothing is said.
    pub fn missing_textures(mut self, missing: MissingTextures) -> Self {
        self.missing_textures = missing;
        self
    }

    /// Smooth normals for objects without any (`vn`): edges across which the normals of triangles are less than so many degrees
    /// apart are smooth, within smoothing groups (`s`) where a file has them; faces under `s off` stay flat. See
    /// [`Mesh::smooth`](crate::Mesh::smooth). Modellers take 30. Without an angle, as where nothing is said, such objects are
    /// flat.
    pub fn crease_angle(mut self, degrees: Option<f32>) -> Self {
        self.crease_angle = degrees;
        self
    }
}
