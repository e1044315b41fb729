//! Textures: pictures and patterns on surfaces.

use std::sync::Arc;

use glam::{UVec2, Vec2, Vec3};

use super::{Scene, checks::check_color};
use crate::{
    Error,
    message::counted,
    random::{Random, pcg},
};

/// Largest side of a texture in pixels, and of a checkerboard in squares. Every WebGPU adapter supports it.
pub const MAX_TEXTURE_SIDE: u32 = 8192;

/// Radius of a dot of [`Texture::dots`], in pixels.
const DOT_RADIUS: f32 = 1.5;
/// Smallest distance of two dots, as a share of the side of a dot's square share of the picture.
const DOT_DISTANCE: f32 = 0.5;
/// Least number of a picture's pixels per dot. Dots then are at least 4 pixels apart.
const LEAST_PIXELS_PER_DOT: u64 = 64;

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

    /// Makes a picture of white dots at random places on black, for a [`Projector`](super::Projector) of active stereo.
    /// Dots are round, 3 pixels wide, and inside the picture. The distance of two dots' centres is at least half the
    /// root of `width * height / count` pixels. Equal numbers give the same picture on every machine.
    ///
    /// # Errors
    /// [`Error::Scene`] for a side of less than 5 or over [`MAX_TEXTURE_SIDE`] pixels, and for less than 64 pixels per
    /// dot.
    pub fn dots(width: u32, height: u32, count: u32, seed: u32) -> Result<Self, Error> {
        let area = u64::from(width) * u64::from(height);
        let check = || {
            check_size(width, height)?;
            if width.min(height) < 5 || u64::from(count) * LEAST_PIXELS_PER_DOT > area {
                return Err(format!(
                    "{} in {width}x{height} pixels; sides must be at least 5, and a dot needs {LEAST_PIXELS_PER_DOT}",
                    counted(count as usize, "dot", "dots")
                ));
            }
            Ok(())
        };
        check().map_err(|reason| Error::Scene { element: "dots".into(), reason })?;
        let size = UVec2::new(width, height);
        let mut pixels = vec![[0, 0, 0, 255]; area as usize];
        for center in scattered(size, count as usize, DOT_DISTANCE * (area as f32 / count as f32).sqrt(), seed) {
            let first = (center - DOT_RADIUS - 0.5).max(Vec2::ZERO).as_uvec2();
            let last = (center + DOT_RADIUS + 0.5).as_uvec2().min(size - 1);
            for (x, y) in (first.y..=last.y).flat_map(|y| (first.x..=last.x).map(move |x| (x, y))) {
                let distance = center.distance(UVec2::new(x, y).as_vec2() + 0.5);
                let value = (255.0 * (DOT_RADIUS + 0.5 - distance).clamp(0.0, 1.0)).round() as u8;
                let pixel: &mut [u8; 4] = &mut pixels[(y * width + x) as usize];
                let value = value.max(pixel[0]);
                *pixel = [value, value, value, 255];
            }
        }
        Ok(Self::of(TextureKind::Image { size: [width, height], pixels: Arc::new(pixels) }).data(true))
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

/// Returns random places in a picture, 2 pixels from its sides and at least a distance apart. The distance is small
/// enough that a place is found after few tries.
fn scattered(size: UVec2, count: usize, distance: f32, seed: u32) -> Vec<Vec2> {
    let cells = (size.as_vec2() / distance).as_uvec2() + 1;
    let mut by_cell: Vec<Vec<Vec2>> = vec![Vec::new(); (cells.x * cells.y) as usize];
    let mut random = Random(pcg(seed));
    let mut places = Vec::with_capacity(count);
    while places.len() < count {
        let unit = Vec2::new(random.unit(), random.unit());
        let place = 2.0 + unit * (size.as_vec2() - 4.0);
        let cell = (place / distance).as_uvec2();
        let (first, last) = (cell.saturating_sub(UVec2::ONE), (cell + 1).min(cells - 1));
        let mut near = (first.y..=last.y).flat_map(|y| (first.x..=last.x).map(move |x| y * cells.x + x));
        let is_near = |other: &Vec2| other.distance_squared(place) < distance * distance;
        if !near.any(|cell| by_cell[cell as usize].iter().any(is_near)) {
            by_cell[(cell.y * cells.x + cell.x) as usize].push(place);
            places.push(place);
        }
    }
    places
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
    fn dots_are_as_many_and_as_far_apart_as_they_say() {
        let dots = |width, height, count, seed| Texture::dots(width, height, count, seed);
        for (width, height, count) in
            [(64, 64, 64), (13, 5, 1), (9, 640, 90), (11, 5000, 859), (320, 240, 700), (16, 16, 0)]
        {
            let texture = dots(width, height, count, 3).unwrap();
            assert_eq!(texture, dots(width, height, count, 3).unwrap());
            assert!(count == 0 || texture != dots(width, height, count, 4).unwrap());
            let TextureKind::Image { pixels, .. } = texture.kind() else { panic!("{texture:?}") };
            let sum: u32 = pixels.iter().map(|pixel| u32::from(pixel[0])).sum();
            // A dot has the area of its circle, up to the rounding of its edge.
            let area = std::f32::consts::PI * DOT_RADIUS * DOT_RADIUS * count as f32 * 255.0;
            assert!((sum as f32 - area).abs() < 0.06 * area + 1.0, "{width}x{height}: {sum} {area}");
            let distance = DOT_DISTANCE * ((width * height) as f32 / count as f32).sqrt();
            let places = scattered(UVec2::new(width, height), count as usize, distance, 3);
            let apart = |(index, place): (usize, &Vec2)| {
                places[..index].iter().all(|other| other.distance(*place) > 0.999 * distance)
            };
            assert!(places.len() == count as usize && places.iter().enumerate().all(apart));
        }
        for (width, height, count) in [(64, 64, 65), (4, 100, 1), (9000, 9, 1), (0, 0, 0)] {
            assert!(dots(width, height, count, 0).unwrap_err().to_string().contains("dots: "), "{width}x{height}");
        }
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
