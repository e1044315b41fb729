//! Options for reading scene files.

use std::path::Path;

use super::Origin;
use crate::{Limits, import::input::SceneFolder};

/// Treatment of a texture that can't be read because its file is missing, broken, too large or not a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MissingTextures {
    /// Reading the scene fails. The error names the MTL's line or glTF's image.
    #[default]
    Error,
    /// The material has no texture. A warning has the text of the error.
    Warn,
}

/// Treatment of files outside the scene file's folder that the scene file or its MTL files name. Files in the folder
/// and below it are always read. A link counts as inside if its target is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum OutsideFiles {
    /// They are refused: [`Error::Io`](crate::Error::Io) or [`Error::Parse`](crate::Error::Parse) names the path.
    #[default]
    Refuse,
    /// They are read. Use this for trusted scene files only.
    Allow,
}

/// Options of [`SceneFile::open`](crate::SceneFile::open) and of the constructors of [`Scene`](crate::Scene).
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
    pub(crate) limits: Limits,
    pub(crate) missing_textures: MissingTextures,
    pub(crate) crease_angle: Option<f32>,
    pub(crate) origin: Origin,
    outside_files: OutsideFiles,
    outside_option_name: Option<&'static str>,
}

impl SceneOptions {
    /// Sets the largest sizes of files and texture pictures. The default is [`Limits::default`].
    pub fn limits(mut self, limits: Limits) -> Self {
        self.limits = limits;
        self
    }

    /// Sets the treatment of textures that can't be read. By default they are an error.
    pub fn missing_textures(mut self, missing: MissingTextures) -> Self {
        self.missing_textures = missing;
        self
    }

    /// Sets the world position that the file's coordinates become relative to. The default is [`Origin::Auto`].
    pub fn origin(mut self, origin: Origin) -> Self {
        self.origin = origin;
        self
    }

    /// Sets whether files may lie outside the scene file's folder, such as textures in `../textures`. By default they
    /// are refused. Scenes in memory ignore this option.
    pub fn outside_files(mut self, outside: OutsideFiles) -> Self {
        self.outside_files = outside;
        self
    }

    /// Sets the name of [`SceneOptions::outside_files`] in messages, for example a program's own option. The default is
    /// that method's name.
    pub fn outside_option_name(mut self, name: &'static str) -> Self {
        self.outside_option_name = Some(name);
        self
    }

    /// Returns the folder that names in a scene file on the disk must not leave.
    pub(crate) fn folder_of(&self, scene: &Path) -> SceneFolder {
        let option = self.outside_option_name.unwrap_or("SceneOptions::outside_files(OutsideFiles::Allow)");
        SceneFolder::of(scene, (self.outside_files == OutsideFiles::Refuse).then_some(option))
    }

    /// Sets the crease angle in degrees for smooth normals of objects without normals. An edge is smooth if its
    /// triangles' normals differ by less than this angle. Objects stay flat without an angle, the default. Modellers
    /// use 30.
    ///
    /// Smoothing stays within an OBJ's smoothing groups (`s`), and faces under `s off` stay flat. See
    /// [`Mesh::smooth`](crate::Mesh::smooth).
    pub fn crease_angle(mut self, degrees: Option<f32>) -> Self {
        self.crease_angle = degrees;
        self
    }
}
