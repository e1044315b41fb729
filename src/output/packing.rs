//! Packings put both eyes into one picture, side by side, top and bottom or interlaced, for 3D displays or free
//! viewing.

use super::{Picture, rows};
use crate::srgb::encode;
use crate::{View, error::by_name};

/// Arrangement of the eyes in one picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Packing {
    /// Left eye on the left, right eye on the right, for parallel viewing. The picture is twice as wide as a view.
    #[default]
    SideBySide,
    /// [`Packing::SideBySide`], squeezed to the width of one view.
    HalfSideBySide,
    /// Right eye on the left, left eye on the right, for cross-eyed viewing. The picture is twice as wide as a view.
    CrossEyed,
    /// Left eye above the right eye. The picture is twice as high as a view.
    TopBottom,
    /// [`Packing::TopBottom`], squeezed to the height of one view.
    HalfTopBottom,
    /// Alternating rows for polarised displays, with the left eye's row first. The picture has the size of a view.
    RowInterlaced,
    /// Alternating columns, with the left eye's column first. The picture has the size of a view.
    ColumnInterlaced,
    /// Alternating pixels along rows and columns, with the left eye's pixel first. The picture has the size of a view.
    Checkerboard,
}

impl Packing {
    /// Every packing, the default first.
    pub const ALL: &'static [Self] = &[
        Self::SideBySide,
        Self::HalfSideBySide,
        Self::CrossEyed,
        Self::TopBottom,
        Self::HalfTopBottom,
        Self::RowInterlaced,
        Self::ColumnInterlaced,
        Self::Checkerboard,
    ];

    /// Returns the name that [`FromStr`](std::str::FromStr) parses and [`Display`](std::fmt::Display) writes.
    pub fn name(self) -> &'static str {
        match self {
            Self::SideBySide => "side-by-side",
            Self::HalfSideBySide => "half-side-by-side",
            Self::CrossEyed => "cross-eyed",
            Self::TopBottom => "top-bottom",
            Self::HalfTopBottom => "half-top-bottom",
            Self::RowInterlaced => "row-interlaced",
            Self::ColumnInterlaced => "column-interlaced",
            Self::Checkerboard => "checkerboard",
        }
    }

    /// Returns the size of the picture of two views of `width` by `height` pixels.
    pub fn size(self, [width, height]: [u32; 2]) -> [u32; 2] {
        match self {
            Self::SideBySide | Self::CrossEyed => [2 * width, height],
            Self::HalfSideBySide => [2 * width.div_ceil(2), height],
            Self::TopBottom => [width, 2 * height],
            Self::HalfTopBottom => [width, 2 * height.div_ceil(2)],
            Self::RowInterlaced | Self::ColumnInterlaced | Self::Checkerboard => [width, height],
        }
    }
}

by_name!(Packing, "packing");

/// Packs two views into one picture. The half packings average two pixels in linear light. With an odd number of
/// columns or rows, the last one is copied, and the picture is one pixel larger than a view.
///
/// The interlaced packings copy each pixel from the same column and row of one view, without averaging. Means of two
/// rows would be half a row off, in opposite directions for the two eyes. Exchange the views for displays whose first
/// row, column or pixel is the right eye's. Views of different sizes are cut to the rows, or the columns, that both
/// have.
///
/// `FFmpeg`'s `stereo3d` has these packings as sbsl, sbs2l, sbsr, abl and ab2l. Its interlaced packings are irl, icl
/// and chl, or irr, icr and chr with the right eye first. They need input halved by dropping every other row, column or
/// pixel.
pub fn packed(left: &View, right: &View, packing: Packing) -> Picture {
    match packing {
        Packing::SideBySide => beside(&left.picture(), &right.picture()),
        Packing::CrossEyed => beside(&right.picture(), &left.picture()),
        Packing::HalfSideBySide => beside(&half_width(left), &half_width(right)),
        Packing::TopBottom => stacked(&left.picture(), &right.picture()),
        Packing::HalfTopBottom => stacked(&half_height(left), &half_height(right)),
        Packing::RowInterlaced => interlaced(left, right, |_, row| row % 2 == 0),
        Packing::ColumnInterlaced => interlaced(left, right, |column, _| column % 2 == 0),
        Packing::Checkerboard => interlaced(left, right, |column, row| (column + row) % 2 == 0),
    }
}

/// Copies each pixel from the left view if `is_left` is true for its column and row, else from the right view.
fn interlaced(left: &View, right: &View, is_left: impl Fn(usize, usize) -> bool) -> Picture {
    let both = rows(&left.rgba8, left.width).zip(rows(&right.rgba8, right.width));
    let rgba8 = both.enumerate().flat_map(|(row, (left, right))| {
        let is_left = &is_left;
        let pixels = left.iter().zip(right).enumerate();
        pixels.map(move |(column, (left, right))| if is_left(column, row) { *left } else { *right })
    });
    let rgba8: Vec<_> = rgba8.collect();
    Picture { width: left.width.min(right.width), height: left.height.min(right.height), rgba8 }
}

fn beside(first: &Picture, second: &Picture) -> Picture {
    let both = rows(&first.rgba8, first.width).zip(rows(&second.rgba8, second.width));
    Picture {
        width: first.width + second.width,
        height: first.height.min(second.height),
        rgba8: both.flat_map(|(a, b)| a.iter().chain(b)).copied().collect(),
    }
}

fn stacked(first: &Picture, second: &Picture) -> Picture {
    let width = first.width.min(second.width);
    let both = rows(&first.rgba8, first.width).chain(rows(&second.rgba8, second.width));
    Picture {
        width,
        height: first.height + second.height,
        rgba8: both.flat_map(|row| row.iter().take(width as usize)).copied().collect(),
    }
}

fn half_width(view: &View) -> Picture {
    let light = view.light();
    let halved = |row: &[[f32; 4]]| {
        let pairs = row.chunks(2).map(|two| average(&two[0], two.last().unwrap_or(&two[0])));
        pairs.collect::<Vec<_>>()
    };
    Picture {
        width: view.width.div_ceil(2),
        height: view.height,
        rgba8: rows(&light, view.width).flat_map(halved).collect(),
    }
}

fn half_height(view: &View) -> Picture {
    let width = (view.width as usize).max(1);
    let halved = |two: &[[f32; 4]]| {
        // If only one row is left, both slices are that row.
        let (upper, lower) = (&two[..width.min(two.len())], &two[two.len().saturating_sub(width)..]);
        upper.iter().zip(lower).map(|(a, b)| average(a, b)).collect::<Vec<_>>()
    };
    Picture {
        width: view.width,
        height: view.height.div_ceil(2),
        rgba8: view.light().chunks(2 * width).flat_map(halved).collect(),
    }
}

/// Returns the encoded mean of two linear pixels.
fn average(a: &[f32; 4], b: &[f32; 4]) -> [u8; 4] {
    let [red, green, blue] = [0, 1, 2].map(|channel| encode(0.5 * (a[channel] + b[channel])));
    [red, green, blue, 255]
}

#[cfg(test)]
mod tests {
    use super::super::tests::{pair, view};
    use super::*;

    /// Creates a view of one grey value per pixel, row by row.
    fn grey(width: u32, values: &[u8]) -> View {
        view(width, &values.iter().map(|&value| [value; 3]).collect::<Vec<_>>())
    }

    fn assert_shows(picture: &Picture, size: (u32, u32), values: &[u8]) {
        assert_eq!((picture.width, picture.height), size);
        assert_eq!(picture.rgba8, values.iter().map(|&value| [value, value, value, 255]).collect::<Vec<_>>());
    }

    #[test]
    fn full_packings_keep_every_pixel() {
        let pair = pair(grey(2, &[1, 2, 3, 4]), grey(2, &[11, 12, 13, 14]));
        assert_shows(&pair.packed(Packing::SideBySide), (4, 2), &[1, 2, 11, 12, 3, 4, 13, 14]);
        assert_shows(&pair.packed(Packing::CrossEyed), (4, 2), &[11, 12, 1, 2, 13, 14, 3, 4]);
        assert_shows(&pair.packed(Packing::TopBottom), (2, 4), &[1, 2, 3, 4, 11, 12, 13, 14]);
        let crossed = packed(&pair.right, &pair.left, Packing::SideBySide);
        assert_eq!(crossed, pair.packed(Packing::CrossEyed));
    }

    #[test]
    fn interlaced_packings_take_each_pixel_from_its_own_place_and_begin_with_the_left_eye() {
        let pair = pair(grey(3, &[1, 2, 3, 4, 5, 6, 7, 8, 9]), grey(3, &[11, 12, 13, 14, 15, 16, 17, 18, 19]));
        assert_shows(&pair.packed(Packing::RowInterlaced), (3, 3), &[1, 2, 3, 14, 15, 16, 7, 8, 9]);
        assert_shows(&pair.packed(Packing::ColumnInterlaced), (3, 3), &[1, 12, 3, 4, 15, 6, 7, 18, 9]);
        assert_shows(&pair.packed(Packing::Checkerboard), (3, 3), &[1, 12, 3, 14, 5, 16, 7, 18, 9]);
        let crossed = packed(&pair.right, &pair.left, Packing::RowInterlaced);
        assert_shows(&crossed, (3, 3), &[11, 12, 13, 4, 5, 6, 17, 18, 19]);
        let one = grey(1, &[77]);
        for packing in [Packing::RowInterlaced, Packing::ColumnInterlaced, Packing::Checkerboard] {
            assert_shows(&packed(&one, &grey(1, &[5]), packing), (1, 1), &[77]);
        }
    }

    #[test]
    fn half_packings_average_light_and_not_bytes() {
        // Half the light of white encodes to 188, not 128.
        let left = grey(4, &[0, 255, 7, 7, 0, 255, 9, 9]);
        let right = grey(4, &[255, 255, 0, 0, 255, 255, 0, 0]);
        let pair = pair(left, right);
        assert_shows(&pair.packed(Packing::HalfSideBySide), (4, 2), &[188, 7, 255, 0, 188, 9, 255, 0]);
        let below = pair.packed(Packing::HalfTopBottom);
        assert_shows(&below, (4, 2), &[0, 255, 7 + 1, 7 + 1, 255, 255, 0, 0]);
    }

    #[test]
    fn the_last_of_an_odd_number_stands_alone() {
        let odd = grey(3, &[5, 5, 80, 6, 6, 90, 255, 255, 100]);
        let squeezed = [5, 80, 5, 80, 6, 90, 6, 90, 255, 100, 255, 100];
        assert_shows(&packed(&odd, &odd, Packing::HalfSideBySide), (4, 3), &squeezed);
        let flat = grey(1, &[3, 3, 200]);
        assert_shows(&packed(&flat, &flat, Packing::HalfTopBottom), (1, 4), &[3, 200, 3, 200]);
        let one = grey(1, &[77]);
        assert_shows(&packed(&one, &one, Packing::HalfSideBySide), (2, 1), &[77, 77]);
        assert_shows(&packed(&one, &one, Packing::HalfTopBottom), (1, 2), &[77, 77]);
    }

    #[test]
    fn different_and_empty_sizes_pack_what_both_have() {
        let (large, small) = (grey(2, &[1, 2, 3, 4]), grey(1, &[9]));
        assert_shows(&packed(&large, &small, Packing::SideBySide), (3, 1), &[1, 2, 9]);
        assert_shows(&packed(&large, &small, Packing::TopBottom), (1, 3), &[1, 3, 9]);
        assert_shows(&packed(&large, &small, Packing::Checkerboard), (1, 1), &[1]);
        let mut empty = grey(1, &[]);
        for width in [0, 1] {
            empty.width = width;
            for &packing in Packing::ALL {
                assert!(packed(&empty, &empty, packing).rgba8.is_empty());
            }
        }
    }

    #[test]
    fn names_are_read_as_they_are_written() {
        for &packing in Packing::ALL {
            assert_eq!(packing.to_string().parse::<_>().ok(), Some(packing));
        }
    }
}
