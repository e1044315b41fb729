//! How scene files are read.

use std::path::Path;

use super::Origin;
use crate::{Limits, input::SceneFolder};

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

/// What becomes of files outside the scene file's folder that the scene file, or an MTL file of it, names. Files in the
/// folder and below it are always read. Links count by where they lead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum OutsideFiles {
    /// They are not read: [`Error::Io`](crate::Error::Io) or [`Error::Parse`](crate::Error::Parse) names the path.
    #[default]
    Refuse,
    /// They are read. For scene files that you trust.
    Allow,
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
    outside_files: OutsideFiles,
    outside_option_name: Option<&'static str>,
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

    /// Whether files may lie outside the scene file's folder, as textures in `../textures`. They are refused where
    /// nothing is said. Of scenes in memory it says nothing: these have only the files that they are given.
    pub fn outside_files(mut self, outside: OutsideFiles) -> Self {
        self.outside_files = outside;
        self
    }

    /// What messages say that [`SceneOptions::outside_files`] is set by: a program's own option. That method where
    /// nothing is said.
    pub fn outside_option_name(mut self, name: &'static str) -> Self {
        self.outside_option_name = Some(name);
        self
    }

    /// The folder that the names in a scene file on the disk may not leave.
    pub(super) fn folder_of(&self, scene: &Path) -> SceneFolder {
        let option = self.outside_option_name.unwrap_or("SceneOptions::outside_files(OutsideFiles::Allow)");
        SceneFolder::of(scene, (self.outside_files == OutsideFiles::Refuse).then_some(option))
    }

    /// Smooth normals for objects without any: edges across which the normals of triangles are less than so many
    /// degrees apart are smooth, within an OBJ's smoothing groups (`s`) where it has them; faces under `s off` stay
    /// flat. See [`Mesh::smooth`](crate::Mesh::smooth). Modellers take 30. Without an angle, as where nothing is
    /// said, such objects are flat.
    pub fn crease_angle(mut self, degrees: Option<f32>) -> Self {
        self.crease_angle = degrees;
        self
    }
}
