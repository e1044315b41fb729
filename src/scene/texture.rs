//! Textures: pictures and patterns on surfaces.

use std::sync::Arc;

use glam::Vec3;

use super::{Scene, checks::check_color};
use crate::{Error, message::counted};

/// Largest side of a texture in pixels, and of a checkerboard in squares. Every WebGPU adapter supports it.
pub const MAX_TEXTURE_SIDE: u32 = 8192;

/// Index of a [`Texture`] in its [`Scene`].
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureId(pub u32);

/// Treatment of texture coordinates outside 0 to 1.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Wrap {
    /// The texture repeats.
    #[default]
    Repeat,
    /// The texture repeats, mirrored every other time.
    Mirror,
    /// The texture's edge continues: MTL's `-clamp on`.
    Clamp,
}

/// Content of a texture.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, PartialEq)]
#[non_exhaustive]
pub enum TextureKind {
    /// A picture.
    Image {
        /// Width and height in pixels, 1 to [`MAX_TEXTURE_SIDE`].
        size: [u32; 2],
        /// Pixels, row-major from the top left: red, green and blue in sRGB, and alpha.
        pixels: Arc<Vec<[u8; 4]>>,
    },
    /// A checkerboard of two colours.
    Checkerboard {
        /// Colour of the square at u = v = 0, and the other colour, linear RGB.
        colors: [Vec3; 2],
        /// Number of squares between 0 and 1, along u and along v.
        squares: u32,
    },
}

impl std::fmt::Debug for TextureKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Image { size: [width, height], .. } => write!(f, "Image {width}x{height}"),
            Self::Checkerboard { colors: [a, b], squares } => write!(f, "Checkerboard {a} {b} {squares}x{squares}"),
        }
    }
}

/// A picture or a pattern over texture coordinates. (0, 0) is the lower left corner and (1, 1) the upper right, as in
/// OBJ. The centre of a picture's first pixel is at u = 0.5 / width, v = 1 - 0.5 / height.
///
/// A texture wraps around spheres and ellipsoids and reads correctly from outside. Its middle is at +z, its right half
/// at +x and its top at +y. On an ellipsoid these are its semi-axes. If two semi-axes of a turned ellipsoid are equally
/// long, any perpendicular pair may be taken. Clones share the pixels.
///
/// ```
/// use stereotrace::{Material, Scene, Texture, Wrap, glam::Vec3};
///
/// let mut scene = Scene::new();
/// let picture = Texture::image(2, 1, vec![[255, 0, 0, 255], [0, 0, 255, 255]])?.wrap(Wrap::Clamp);
/// let texture = scene.add_texture(picture);
/// let material = scene.add_material(Material::new(Vec3::ONE).texture(texture));
/// # let _ = material;
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "super::serialised::GivenTexture")
)]
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Texture {
    kind: TextureKind,
    /// Treatment of texture coordinates outside 0 to 1.
    pub wrap: Wrap,
    /// Whether a picture's values are data, such as normals or roughness, rather than colours in sRGB.
    pub data: bool,
}

impl Texture {
    /// Makes a texture from a picture, row-major from the top left: red, green and blue in sRGB, and alpha. It repeats
    /// beyond its edges.
    ///
    /// # Errors
    /// [`Error::Scene`] for a side of 0 or over [`MAX_TEXTURE_SIDE`] pixels, and if the number of pixels is not
    /// `width * height`.
    pub fn image(width: u32, height: u32, pixels: Vec<[u8; 4]>) -> Result<Self, Error> {
        let check = || {
            check_size(width, height)?;
            match pixels.len() as u64 == u64::from(width) * u64::from(height) {
                true => Ok(()),
                false => {
                    let pixels = counted(pixels.len(), "pixel", "pixels");
                    Err(format!("a picture of {width}x{height} can't have {pixels}"))
                }
            }
        };
        check().map_err(|reason| Error::Scene { element: "texture".into(), reason })?;
        Ok(Self::of(TextureKind::Image { size: [width, height], pixels: Arc::new(pixels) }))
    }

    /// Makes a checkerboard of `squares` by `squares` over texture coordinates of 0 to 1, in linear RGB. Squares have
    /// the first colour if their column and row are both even or both odd. No pixels are stored.
    ///
    /// # Errors
    /// [`Error::Scene`] for a colour that is negative or not finite, and for 0 or over [`MAX_TEXTURE_SIDE`] squares.
    pub fn checkerboard(first: Vec3, second: Vec3, squares: u32) -> Result<Self, Error> {
        let check = || {
            check_color("the first colour", first)?;
            check_color("the second colour", second)?;
            match (1..=MAX_TEXTURE_SIDE).contains(&squares) {
                true => Ok(()),
                false => Err(format!("{squares} squares per side; it must be 1 to {MAX_TEXTURE_SIDE}")),
            }
        };
        check().map_err(|reason| Error::Scene { element: "checkerboard".into(), reason })?;
        Ok(Self::of(TextureKind::Checkerboard { colors: [first, second], squares }))
    }

    pub(crate) fn of(kind: TextureKind) -> Self {
        Self { kind, wrap: Wrap::default(), data: false }
    }

    /// Sets the treatment of texture coordinates outside 0 to 1.
    pub fn wrap(mut self, wrap: Wrap) -> Self {
        self.wrap = wrap;
        self
    }

    /// Sets whether a picture's values are data, such as normals or roughness, rather than colours in sRGB.
    pub fn data(mut self, data: bool) -> Self {
        self.data = data;
        self
    }

    /// Returns the content.
    pub fn kind(&self) -> &TextureKind {
        &self.kind
    }
}

impl Scene {
    /// Adds a texture and returns its id, for [`Material::texture`](super::Material::texture) and
    /// [`Material::cutout`](super::Material::cutout).
    pub fn add_texture(&mut self, texture: Texture) -> TextureId {
        self.textures.push(texture);
        TextureId(self.textures.len() as u32 - 1)
    }

    /// Returns all textures; the index is the [`TextureId`].
    pub fn textures(&self) -> &[Texture] {
        &self.textures
    }
}

pub(crate) fn check_size(width: u32, height: u32) -> Result<(), String> {
    match [width, height].iter().all(|side| (1..=MAX_TEXTURE_SIDE).contains(side)) {
        true => Ok(()),
        false => Err(format!("{width}x{height} pixels; each side can have 1 to {MAX_TEXTURE_SIDE}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_that_are_none_are_refused() {
        let said = |texture: Result<Texture, Error>| texture.unwrap_err().to_string();
        for (width, height, count) in [(0, 1, 0), (1, 0, 0), (8193, 1, 8193), (1, u32::MAX, 1)] {
            let message = said(Texture::image(width, height, vec![[0; 4]; count]));
            assert!(
                message.contains(&format!("texture: {width}x{height} pixels; each side can have 1 to")),
                "{message}"
            );
        }
        let message = said(Texture::image(2, 2, vec![[0; 4]; 3]));
        assert!(message.contains("a picture of 2x2 can't have 3 pixels"), "{message}");
        assert!(said(Texture::checkerboard(Vec3::ONE, Vec3::ZERO, 0)).contains("0 squares per side"));
        assert!(said(Texture::checkerboard(Vec3::ONE, Vec3::ZERO, 8193)).contains("8193 squares per side"));
        assert!(said(Texture::checkerboard(Vec3::NAN, Vec3::ZERO, 8)).contains("the first colour is [NaN"));
        assert!(said(Texture::checkerboard(Vec3::ONE, -Vec3::X, 8)).contains("the second colour is [-1"));
    }

    #[test]
    fn a_texture_is_found_by_its_id_and_clones_share_its_pixels() {
        let mut scene = Scene::new();
        let board = Texture::checkerboard(Vec3::ONE, Vec3::ZERO, 8).unwrap();
        let image = Texture::image(2, 1, vec![[1, 2, 3, 4], [5, 6, 7, 8]]).unwrap().wrap(Wrap::Mirror);
        assert_eq!([scene.add_texture(board.clone()), scene.add_texture(image.clone())], [TextureId(0), TextureId(1)]);
        assert_eq!(scene.textures(), [board, image]);
        let copy = scene.clone();
        let pixels = |scene: &Scene| match scene.textures()[1].kind() {
            TextureKind::Image { pixels, .. } => pixels.clone(),
            other => panic!("{other:?}"),
        };
        assert!(Arc::ptr_eq(&pixels(&scene), &pixels(&copy)));
    }
}
