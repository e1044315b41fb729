//! Makes anaglyphs, packings of both eyes into one picture, and files.
//!
//! [`anaglyph()`] and [`packed()`] take the left view, then the right view; exchanging the arguments exchanges the
//! eyes. [`StereoPair`] has methods that pass its own views in this order. [`PngRows`] and [`PairRows`] write pictures
//! whose rows arrive in parts ([`FrameBuilder::rows`](crate::FrameBuilder::rows)).

mod anaglyph;
mod batch;
mod calibration;
#[cfg(feature = "exr")]
mod exr;
mod file;
mod flow;
#[cfg(feature = "jpeg")]
mod jpeg;
#[cfg(feature = "png")]
mod layers;
pub(crate) mod on_device;
mod packing;
mod pair_rows;
#[cfg(any(feature = "jpeg", feature = "png"))]
mod panorama;
#[cfg(feature = "png")]
mod png_rows;
#[cfg(feature = "json")]
mod pose_json;
mod quilt;
mod remap;
mod stale;
#[cfg(feature = "png")]
mod truth_png;

#[cfg(feature = "exr")]
pub use self::exr::ExrColor;
pub use anaglyph::{Anaglyph, anaglyph, anaglyph_encoded};
pub use batch::{Batch, write_whole};
pub use calibration::calib_txt;
pub use file::{save_ids_pfm, save_pfm};
pub use packing::{Packing, packed};
pub use pair_rows::{Combination, PairRows};
#[cfg(feature = "png")]
pub use png_rows::PngRows;
pub use quilt::{quilt, quilt_name};
pub use remap::Remap;
#[cfg(feature = "png")]
pub(crate) use truth_png::SINTEL_DISPARITIES;

use crate::{StereoPair, View};

/// Finished picture in sRGB with alpha, row-major, `[height][width]`, top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Pixels, sRGB-encoded; alpha is 255 in every picture that this library makes.
    pub rgba8: Vec<[u8; 4]>,
}

impl Picture {
    /// Creates a picture of `width * height` pixels, row-major, top row first. Writing the picture fails for any other
    /// number of pixels.
    pub fn new(width: u32, height: u32, rgba8: Vec<[u8; 4]>) -> Self {
        Self { width, height, rgba8 }
    }
}

impl View {
    /// Returns the view as a picture.
    pub fn picture(&self) -> Picture {
        Picture { width: self.width, height: self.height, rgba8: self.rgba8.clone() }
    }
}

impl View {
    /// Returns the time view (thesis, figure 38): [`View::cost`] as grey values. Pixels with at least `white` visited
    /// nodes and primitive tests are white. `None` if the view was rendered without costs.
    pub fn cost_picture(&self, white: u32) -> Option<Picture> {
        let grey = |&cost: &u32| {
            let level = (255 * u64::from(cost.min(white)) / u64::from(white.max(1))) as u8;
            [level, level, level, 255]
        };
        (!self.cost.is_empty()).then(|| Picture {
            width: self.width,
            height: self.height,
            rgba8: self.cost.iter().map(grey).collect(),
        })
    }
}

impl StereoPair {
    /// Returns [`StereoPair::retrace_map`] as a picture of the right view's size.
    pub fn retrace_picture(&self) -> Picture {
        Picture { width: self.right.width, height: self.right.height, rgba8: self.retrace_map() }
    }

    /// Returns [`StereoPair::shadow_map`] as a picture of the right view's size, or `None` if there is no such map.
    pub fn shadow_picture(&self) -> Option<Picture> {
        (!self.shadow_source.is_empty()).then(|| Picture {
            width: self.right.width,
            height: self.right.height,
            rgba8: self.shadow_map(),
        })
    }

    /// Mixes both eyes in linear light into one picture for coloured glasses ([`anaglyph()`]).
    pub fn anaglyph(&self, kind: Anaglyph) -> Picture {
        anaglyph(&self.left, &self.right, kind)
    }

    /// Mixes both eyes as encoded values, as other programs do, into one picture for coloured glasses
    /// ([`anaglyph_encoded()`]).
    pub fn anaglyph_encoded(&self, kind: Anaglyph) -> Picture {
        anaglyph_encoded(&self.left, &self.right, kind)
    }

    /// Packs both eyes into one picture, beside, below or between each other ([`packed()`]).
    pub fn packed(&self, packing: Packing) -> Picture {
        packed(&self.left, &self.right, packing)
    }
}

/// Returns the rows of a row-major list, top row first. A list without columns has no rows.
fn rows<T>(pixels: &[T], width: u32) -> impl Iterator<Item = &[T]> {
    pixels.chunks_exact((width as usize).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::srgb::encode;
    use crate::{MISS, PixelSource, ShadowSource, Statistics, StereoCamera, glam::Vec3};

    /// Inverts [`encode`], in f64 and with the standard's own constants.
    pub(super) fn decode(byte: u8) -> f64 {
        let encoded = f64::from(byte) / 255.0;
        if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
    }

    /// Creates a view with these colours, `width` per row. All other data is the data of sky pixels.
    pub(super) fn view(width: u32, colors: &[[u8; 3]]) -> View {
        View {
            width,
            height: colors.len() as u32 / width,
            rgba8: colors.iter().map(|&[r, g, b]| [r, g, b, 255]).collect(),
            linear: colors
                .iter()
                .map(|&[r, g, b]| [decode(r) as f32, decode(g) as f32, decode(b) as f32, 1.0])
                .collect(),
            depth: vec![f32::INFINITY; colors.len()],
            primitive: vec![MISS; colors.len()],
            albedo: Vec::new(),
            cost: Vec::new(),
            object: vec![MISS; colors.len()],
        }
    }

    pub(super) fn pair(left: View, right: View) -> StereoPair {
        let pose = StereoCamera::look_at(Vec3::Z, Vec3::ZERO).size(left.width, left.height).pose().unwrap();
        let source = vec![PixelSource::Bad; right.rgba8.len()];
        StereoPair { left, right, source, shadow_source: Vec::new(), statistics: Statistics::default(), pose }
    }

    #[test]
    fn encoding_meets_reference_values_and_undoes_decoding() {
        // Computed by hand from the standard's formula; values outside 0 to 1 are clamped.
        let references = [
            (-0.5, 0),
            (0.0, 0),
            (0.001, 3),
            (0.003_130_8, 10),
            (0.01, 25),
            (0.18, 118),
            (0.5, 188),
            (0.9, 243),
            (1.0, 255),
            (7.0, 255),
        ];
        for (linear, byte) in references {
            assert_eq!(encode(linear), byte, "{linear}");
        }
        for byte in 0..=255 {
            assert_eq!(encode(decode(byte) as f32), byte);
        }
    }

    #[test]
    fn a_view_and_its_maps_become_pictures_of_their_size() {
        let colors = [[1, 2, 3], [4, 5, 6], [7, 8, 9], [10, 11, 12], [13, 14, 15], [16, 17, 18]];
        let mut pair = pair(view(3, &colors), view(3, &colors));
        let picture = pair.left.picture();
        assert_eq!((picture.width, picture.height, picture.rgba8[5]), (3, 2, [16, 17, 18, 255]));
        let map = pair.retrace_picture();
        assert_eq!((map.width, map.height, &map.rgba8), (3, 2, &pair.retrace_map()));
        assert_eq!(pair.shadow_picture(), None);
        pair.shadow_source = vec![ShadowSource::Traced; colors.len()];
        let map = pair.shadow_picture().unwrap();
        assert_eq!((map.width, map.height, map.rgba8), (3, 2, pair.shadow_map()));
    }

    #[test]
    fn an_unknown_name_lists_the_known_ones() {
        let message = "sepia".parse::<Anaglyph>().unwrap_err().to_string();
        assert!(message.starts_with("unknown anaglyph 'sepia'; use one of dubois, dubois-lcd, "), "{message}");
        let message = "diagonal".parse::<Packing>().unwrap_err().to_string();
        assert!(message.starts_with("unknown packing 'diagonal'; use one of side-by-side, "), "{message}");
    }
}
