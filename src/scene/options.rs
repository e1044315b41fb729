//! How scene files are read.

use super::Origin;
use crate::Limits;

/// What becomes of a texture of a material that can't be read: its file is missing, broken, too large or none at all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MissingTextures {
    /// The scene is not read: the error names the MTL's line, or glTF's image.
    #[default]
    Error,
    /// The material is without it, and a warning names what the error would.
    Warn,
}

/// How [`SceneFile::open`](crate::SceneFile::open) and the constructors of [`Scene`](crate::Scene) read a file.
///
/// ```
/// use stereotrace::{Limits, MissingTextures, SceneOptions};
///
/// let options = SceneOptions::default()
///     .limits(Limits::default().texture_pixels(1 << 28))
///     .missing_textures(MissingTextures::Warn)
///     .crease_angle(Some(30.0));
/// # let _ = options;
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneOptions {
    pub(super) limits: Limits,
    pub(super) missing_textures: MissingTextures,
    pub(super) crease_angle: Option<f32>,
    pub(super) origin: Origin,
}

/// The options under the name that they have where OBJ files are read.
pub type ObjOptions = SceneOptions;

impl SceneOptions {
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

    /// Which world position the file's coordinates become relative to. [`Origin::Auto`] where nothing is said.
    pub fn origin(mut self, origin: Origin) -> Self {
        self.origin = origin;
        self
    }

    /// Smooth normals for objects without any: edges across which the normals of triangles are less than so many degrees
    /// apart are smooth, within an OBJ's smoothing groups (`s`) where it has them; faces under `s off` stay flat. See
    /// [`Mesh::smooth`](crate::Mesh::smooth). Modellers take 30. Without an angle, as where nothing is said, such objects are
    /// flat.
    pub fn crease_angle(mut self, degrees: Option<f32>) -> Self {
        self.crease_angle = degrees;
        self
    }
}
