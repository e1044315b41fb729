//! Makes anaglyphs: one picture of both eyes, which coloured glasses separate.

use std::fmt;
use std::str::FromStr;

use super::{Picture, rows};
use crate::srgb::{encode, to_byte};
use crate::{Error, View};

/// Matrix whose rows are the output's R, G, B and whose columns are an eye's R, G, B.
type Matrix = [[f32; 3]; 3];

const ZERO: [f32; 3] = [0.0; 3];
const RED: [f32; 3] = [1.0, 0.0, 0.0];
const GREEN: [f32; 3] = [0.0, 1.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];

/// Luma of linear light (ITU-R BT.709).
const LUMA_LINEAR: [f32; 3] = [0.2126, 0.7152, 0.0722];
/// Luma of encoded values (ITU-R BT.601).
const LUMA_ENCODED: [f32; 3] = [0.299, 0.587, 0.114];

/// Anaglyph methods and their glasses.
///
/// ```
/// use stereotrace::output::Anaglyph;
///
/// assert_eq!(Anaglyph::default().to_string(), "dubois");
/// assert_eq!("half-color".parse::<_>().ok(), Some(Anaglyph::HalfColour));
/// assert_eq!(Anaglyph::GreenMagenta.glasses(), "green (left), magenta (right)");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Anaglyph {
    /// Red/cyan by Dubois 2001, fitted to the filters and a cathode-ray display. It keeps colours and has little
    /// ghosting.
    #[default]
    Dubois,
    /// Red/cyan by Dubois 2009, fitted to an LCD.
    DuboisLcd,
    /// Red/cyan without colour, from the luma of each eye.
    Grey,
    /// Red/cyan with unchanged channels. It keeps the most colour, but saturated colours cause retinal rivalry.
    Colour,
    /// Red/cyan with unchanged green and blue, and the left eye's luma as red, which causes less rivalry.
    HalfColour,
    /// Green/magenta by Dubois 2009.
    GreenMagenta,
    /// Amber/blue by Dubois 2009.
    AmberBlue,
}

impl Anaglyph {
    /// All methods, starting with the default.
    pub const ALL: &'static [Self] = &[
        Self::Dubois,
        Self::DuboisLcd,
        Self::Grey,
        Self::Colour,
        Self::HalfColour,
        Self::GreenMagenta,
        Self::AmberBlue,
    ];

    /// Returns the name that [`FromStr`] parses and [`Display`](fmt::Display) writes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dubois => "dubois",
            Self::DuboisLcd => "dubois-lcd",
            Self::Grey => "grey",
            Self::Colour => "colour",
            Self::HalfColour => "half-colour",
            Self::GreenMagenta => "green-magenta",
            Self::AmberBlue => "amber-blue",
        }
    }

    /// Returns the glasses of the method, as `red (left), cyan (right)`.
    pub fn glasses(self) -> &'static str {
        match self {
            Self::GreenMagenta => "green (left), magenta (right)",
            Self::AmberBlue => "amber (left), blue (right)",
            Self::Dubois | Self::DuboisLcd | Self::Grey | Self::Colour | Self::HalfColour => "red (left), cyan (right)",
        }
    }

    /// Returns `(M_L, M_R)` of `out = M_L left + M_R right` on linear RGB; rows are the output's R, G, B. In each row,
    /// the entries of both matrices sum to 1 within 0.002, so white stays white.
    pub fn matrices(self) -> (Matrix, Matrix) {
        self.matrices_with_luma(LUMA_LINEAR)
    }

    /// Returns the matrices for encoded values. `Grey` and `HalfColour` then use luma weights of 0.299, 0.587, 0.114.
    pub fn matrices_encoded(self) -> (Matrix, Matrix) {
        self.matrices_with_luma(LUMA_ENCODED)
    }

    fn matrices_with_luma(self, luma: [f32; 3]) -> (Matrix, Matrix) {
        match self {
            Self::Dubois => (
                [
                    [0.4561, 0.500484, 0.176381],
                    [-0.0400822, -0.0378246, -0.0157589],
                    [-0.0152161, -0.0205971, -0.00546856],
                ],
                [
                    [-0.0434706, -0.0879388, -0.00155529],
                    [0.378476, 0.73364, -0.0184503],
                    [-0.0721527, -0.112961, 1.2264],
                ],
            ),
            Self::DuboisLcd => (
                [[0.437, 0.449, 0.164], [-0.062, -0.062, -0.024], [-0.048, -0.050, -0.017]],
                [[-0.011, -0.032, -0.007], [0.377, 0.761, 0.009], [-0.026, -0.093, 1.234]],
            ),
            Self::Grey => ([luma, ZERO, ZERO], [ZERO, luma, luma]),
            Self::Colour => ([RED, ZERO, ZERO], [ZERO, GREEN, BLUE]),
            Self::HalfColour => ([luma, ZERO, ZERO], [ZERO, GREEN, BLUE]),
            Self::GreenMagenta => (
                [[-0.062, -0.158, -0.039], [0.284, 0.668, 0.143], [-0.015, -0.027, 0.021]],
                [[0.529, 0.705, 0.024], [-0.016, -0.015, -0.065], [0.009, 0.075, 0.937]],
            ),
            Self::AmberBlue => (
                [[1.062, -0.205, 0.299], [-0.026, 0.908, 0.068], [-0.038, -0.173, 0.022]],
                [[-0.016, -0.123, -0.017], [0.006, 0.062, -0.017], [0.094, 0.185, 0.911]],
            ),
        }
    }
}

impl fmt::Display for Anaglyph {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Anaglyph {
    type Err = Error;

    /// Parses a [`name`](Self::name); also accepts `color` and `gray`.
    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let british = name.replace("color", "colour").replace("gray", "grey");
        let found = Self::ALL.iter().copied().find(|kind| kind.name() == british);
        found.ok_or_else(|| Error::unknown_name("anaglyph", name, Self::ALL))
    }
}

/// Mixes two views in linear light, as Dubois's matrices require, then clamps and encodes the result. Views of
/// different sizes are mixed where both have pixels, from the top left corner.
pub fn anaglyph(left: &View, right: &View, kind: Anaglyph) -> Picture {
    let matrices = kind.matrices();
    mix([left, right], [&left.light(), &right.light()], |l, r| product(&matrices, rgb(l), rgb(r)).map(encode))
}

/// Mixes the sRGB-encoded values, as `FFmpeg`'s filter `stereo3d` and other programs do, instead of light. Their
/// coefficients and rounding are coarser, so some bytes differ by 1.
pub fn anaglyph_encoded(left: &View, right: &View, kind: Anaglyph) -> Picture {
    let matrices = kind.matrices_encoded();
    let value = |pixel: &[u8; 4]| rgb(pixel).map(|byte| f32::from(byte) / 255.0);
    mix([left, right], [&left.rgba8, &right.rgba8], |l, r| product(&matrices, value(l), value(r)).map(to_byte))
}

/// Applies `mixed` to the `channels` of both views, pixel by pixel.
fn mix<T>([left, right]: [&View; 2], channels: [&[T]; 2], mixed: impl Fn(&T, &T) -> [u8; 3]) -> Picture {
    let (left_rows, right_rows) = (rows(channels[0], left.width), rows(channels[1], right.width));
    let pixels = left_rows.zip(right_rows).flat_map(|(l, r)| l.iter().zip(r));
    let rgba8 = pixels.map(|(l, r)| mixed(l, r)).map(|[r, g, b]| [r, g, b, 255]).collect();
    Picture { width: left.width.min(right.width), height: left.height.min(right.height), rgba8 }
}

fn rgb<T: Copy>(&[r, g, b, _]: &[T; 4]) -> [T; 3] {
    [r, g, b]
}

/// Returns `M_L left + M_R right`.
fn product((of_left, of_right): &(Matrix, Matrix), left: [f32; 3], right: [f32; 3]) -> [f32; 3] {
    let dot = |row: [f32; 3], eye: [f32; 3]| row[0] * eye[0] + row[1] * eye[1] + row[2] * eye[2];
    std::array::from_fn(|channel| dot(of_left[channel], left) + dot(of_right[channel], right))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{decode, pair, view};
    use super::*;

    const BLACK: [u8; 3] = [0; 3];
    const WHITE: [u8; 3] = [255; 3];

    /// Mixes one pixel in linear light and in encoded values.
    fn mixed(left: [u8; 3], right: [u8; 3], kind: Anaglyph) -> [[u8; 3]; 2] {
        let pair = pair(view(1, &[left]), view(1, &[right]));
        [pair.anaglyph(kind), pair.anaglyph_encoded(kind)].map(|picture| rgb(&picture.rgba8[0]))
    }

    /// Channels that the left glass transmits.
    fn left_channels(kind: Anaglyph) -> &'static [usize] {
        match kind {
            Anaglyph::GreenMagenta => &[1],
            Anaglyph::AmberBlue => &[0, 1],
            _ => &[0],
        }
    }

    fn rows_sum_to_one((left, right): (Matrix, Matrix)) -> bool {
        left.iter().zip(right).all(|(l, r)| (l.iter().chain(&r).sum::<f32>() - 1.0).abs() <= 0.002)
    }

    #[test]
    fn rows_of_both_matrices_sum_to_one() {
        for &kind in Anaglyph::ALL {
            assert!(rows_sum_to_one(kind.matrices()) && rows_sum_to_one(kind.matrices_encoded()), "{kind}");
        }
    }

    #[test]
    fn the_two_misprints_that_are_common_cannot_pass() {
        let (mut left, right) = Anaglyph::Dubois.matrices();
        assert_eq!(left[1][0], -0.0400822);
        left[1][0] = -0.400822;
        assert!(!rows_sum_to_one((left, right)));

        let (left, mut right) = Anaglyph::GreenMagenta.matrices();
        assert_eq!(right[1][2], -0.065);
        right[1][2] = 0.065;
        assert!(!rows_sum_to_one((left, right)));
    }

    #[test]
    fn white_stays_white_and_black_stays_black() {
        for &kind in Anaglyph::ALL {
            assert_eq!(mixed(WHITE, WHITE, kind), [WHITE; 2], "{kind}");
            assert_eq!(mixed(BLACK, BLACK, kind), [BLACK; 2], "{kind}");
        }
    }

    #[test]
    fn each_eye_ends_behind_its_own_glass() {
        for &kind in Anaglyph::ALL {
            for channel in 0..3 {
                let is_left = left_channels(kind).contains(&channel);
                for (left, right) in [(WHITE, BLACK), (BLACK, WHITE)] {
                    let shows = is_left == (left == WHITE);
                    for out in mixed(left, right, kind) {
                        // Leaks are at most 0.051 of the light, which encodes to 64 of 255.
                        assert!(if shows { out[channel] > 240 } else { out[channel] < 70 }, "{kind} {out:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_red_left_picture_ends_in_the_left_glass_s_channels() {
        let red = [255, 0, 0];
        for &kind in Anaglyph::ALL {
            // Red is faint through the green filter, but the left channel is the brightest one. A black right eye adds
            // nothing.
            let [out, _] = mixed(red, BLACK, kind);
            let brightest = (0..3).max_by_key(|&channel| out[channel]).unwrap();
            assert_eq!(brightest, left_channels(kind)[0], "{kind} {out:?}");
        }
        assert_eq!(mixed(red, BLACK, Anaglyph::Colour), [red; 2]);
        assert_eq!(mixed(BLACK, red, Anaglyph::Colour), [BLACK; 2]);
    }

    #[test]
    fn exchanging_the_arguments_exchanges_the_eyes() {
        let (left, right) = (view(1, &[[250, 120, 30]]), view(1, &[[10, 200, 90]]));
        for &kind in Anaglyph::ALL {
            let exchanged = anaglyph(&right, &left, kind);
            assert_eq!(exchanged, pair(right.clone(), left.clone()).anaglyph(kind));
            assert_ne!(exchanged, anaglyph(&left, &right, kind), "{kind}");
        }
    }

    #[test]
    fn light_is_mixed_linearly_and_encoded_values_only_when_asked() {
        let (left, right) = ([200, 100, 50], [40, 160, 240]);
        let [linear, encoded] = mixed(left, right, Anaglyph::HalfColour);
        let light = 0.2126 * decode(200) + 0.7152 * decode(100) + 0.0722 * decode(50);
        assert!((decode(linear[0]) - light).abs() < 0.004, "{linear:?}");
        // .299 * 200 + .587 * 100 + .114 * 50 = 124.2
        assert_eq!(encoded, [124, 160, 240]);
        assert_eq!(linear[1..], [160, 240]);
    }

    #[test]
    fn a_dubois_pixel_is_as_computed_by_hand() {
        // Encoded: R = .4561 * 100 + .500484 * 50 + .176381 * 25 - .0434706 * 10 - .0879388 * 20 - .00155529 * 200
        //            = 45.61 + 25.02 + 4.41 - .43 - 1.76 - .31 = 72.54
        //          G = -4.01 - 1.89 - .39 + 3.78 + 14.67 - 3.69 = 8.47
        //          B = -1.52 - 1.03 - .14 - .72 - 2.26 + 245.28 = 239.61
        assert_eq!(mixed([100, 50, 25], [10, 20, 200], Anaglyph::Dubois)[1], [73, 8, 240]);
    }

    #[test]
    fn pixels_keep_their_places_and_different_sizes_meet_in_the_corner() {
        let left = view(3, &[[10; 3], [20; 3], [30; 3], [40; 3], [50; 3], [60; 3]]);
        let right = view(2, &[[110; 3], [120; 3], [130; 3], [140; 3], [150; 3], [160; 3]]);
        for picture in [anaglyph(&left, &right, Anaglyph::Colour), anaglyph_encoded(&left, &right, Anaglyph::Colour)] {
            assert_eq!((picture.width, picture.height), (2, 2));
            let expected = [[10, 110, 110], [20, 120, 120], [40, 130, 130], [50, 140, 140]];
            assert_eq!(picture.rgba8, expected.map(|[r, g, b]| [r, g, b, 255]));
        }
    }

    #[test]
    fn names_are_read_as_they_are_written() {
        for &kind in Anaglyph::ALL {
            assert_eq!(kind.to_string().parse::<_>().ok(), Some(kind));
        }
        assert_eq!("color".parse::<_>().ok(), Some(Anaglyph::Colour));
        assert_eq!("half-color".parse::<_>().ok(), Some(Anaglyph::HalfColour));
        assert_eq!("gray".parse::<_>().ok(), Some(Anaglyph::Grey));
        assert!("".parse::<Anaglyph>().is_err());
    }
}
