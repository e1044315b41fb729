//! Combines both views into one picture as their rows arrive.

use super::{Anaglyph, Packing, Picture, anaglyph, packed};
use crate::View;

/// How one picture shows both views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Combination {
    /// For coloured glasses ([`anaglyph()`]).
    Anaglyph(Anaglyph),
    /// Beside, below or between each other ([`packed()`]).
    Packed(Packing),
}

impl Combination {
    /// Returns the size of the picture of two views of `width` by `height` pixels.
    pub fn size(self, [width, height]: [u32; 2]) -> [u32; 2] {
        match self {
            Self::Anaglyph(_) => [width, height],
            Self::Packed(packing) => packing.size([width, height]),
        }
    }

    /// Returns the picture of both views.
    pub fn picture(self, left: &View, right: &View) -> Picture {
        match self {
            Self::Anaglyph(kind) => anaglyph(left, right, kind),
            Self::Packed(packing) => packed(left, right, packing),
        }
    }

    /// Returns whether the right view is below the left one.
    fn is_stacked(self) -> bool {
        matches!(self, Self::Packed(Packing::TopBottom | Packing::HalfTopBottom))
    }
}

/// Makes one picture of both views while their rows arrive ([`FrameBuilder::rows`](crate::FrameBuilder::rows)). It
/// keeps at most one row of each view, and for [`Packing::TopBottom`] and [`Packing::HalfTopBottom`] the lower half of
/// the picture.
///
/// ```
/// use stereotrace::{Builtin, Gpu, Renderer, blocking::Wait};
/// use stereotrace::output::{Combination, Packing, PairRows};
///
/// let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(64, 48));
/// let mut renderer = Renderer::new(Gpu::new().wait()?);
/// let uploaded = renderer.upload(&scene).wait()?;
/// let mut pair = PairRows::new(Combination::Packed(Packing::TopBottom), [64, 48]);
/// let mut picture = Vec::new();
/// let mut add = |band: stereotrace::Rows| {
///     picture.extend(pair.next(&band.views[0].view, &band.views[1].view));
///     Ok(())
/// };
/// renderer.pair(&uploaded, &camera).rows(&mut add).wait()?;
/// picture.extend(pair.rest());
/// assert_eq!(picture.len(), 64 * 96);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct PairRows {
    combination: Combination,
    /// Width of a view in pixels.
    width: u32,
    /// Pixels of both views that are not in the picture yet, at most one row of each.
    waiting: [Vec<[u8; 4]>; 2],
    /// Lower half of the picture.
    below: Vec<[u8; 4]>,
}

impl PairRows {
    /// Creates a picture without rows, of two views of this size in pixels.
    pub fn new(combination: Combination, [width, height]: [u32; 2]) -> Self {
        let below = if combination.is_stacked() { width as usize * height as usize } else { 0 };
        Self { combination, width, waiting: Default::default(), below: Vec::with_capacity(below) }
    }

    /// Takes the next rows of both views, and returns the next pixels of the picture, row-major.
    pub fn next(&mut self, left: &View, right: &View) -> Vec<[u8; 4]> {
        // Interlaced and halved packings repeat after two rows.
        let two_rows = 2 * self.width.max(1) as usize;
        let rows = |waiting: &mut Vec<_>, view: &View| {
            waiting.extend(&view.rgba8);
            let odd = waiting.split_off(waiting.len() - waiting.len() % two_rows);
            std::mem::replace(waiting, odd)
        };
        let [of_left, of_right] = &mut self.waiting;
        let both = [rows(of_left, left), rows(of_right, right)];
        self.combined(both)
    }

    /// Returns the last pixels of the picture, when all rows have been taken.
    pub fn rest(mut self) -> Vec<[u8; 4]> {
        let waiting = std::mem::take(&mut self.waiting);
        let last = self.combined(waiting);
        self.below.splice(0..0, last); // a copy of the lower half would take as much memory again
        self.below
    }

    /// Combines rows of both views. Of stacked views, the right one is kept for the end.
    fn combined(&mut self, both: [Vec<[u8; 4]>; 2]) -> Vec<[u8; 4]> {
        let [left, right] = both.map(|pixels| View::of_pixels(self.width, pixels));
        let mut pixels = self.combination.picture(&left, &right).rgba8;
        if self.combination.is_stacked() {
            self.below.extend(pixels.split_off(pixels.len() / 2));
        }
        pixels
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::view;
    use super::*;
    use crate::random::Random;

    fn part_of(view: &View, first: u32, rows: u32) -> View {
        let pixels = (first * view.width) as usize..((first + rows) * view.width) as usize;
        View::of_pixels(view.width, view.rgba8[pixels].to_vec())
    }

    #[test]
    fn rows_that_arrive_in_parts_make_the_picture_of_whole_views() {
        let all = Anaglyph::ALL.iter().map(|&kind| Combination::Anaglyph(kind));
        let all = all.chain(Packing::ALL.iter().map(|&packing| Combination::Packed(packing)));
        let mut random = Random::new(1);
        for (combination, height) in all.flat_map(|combination| [(combination, 12_u32), (combination, 13)]) {
            for width in [1_u32, 4, 5] {
                let mut noise = || {
                    let pixels = (0..width * height).map(|_| [0; 3].map(|_: u8| (256.0 * random.unit()) as u8));
                    view(width, &Vec::from_iter(pixels))
                };
                let (left, right) = (noise(), noise());
                let whole = combination.picture(&left, &right);
                assert_eq!([whole.width, whole.height], combination.size([width, height]), "{combination:?}");
                for parts in [vec![height], vec![1; height as usize], vec![3, 4, 1, height - 8]] {
                    let (mut rows, mut pixels, mut row) = (PairRows::new(combination, [width, height]), Vec::new(), 0);
                    for part in parts {
                        pixels.extend(rows.next(&part_of(&left, row, part), &part_of(&right, row, part)));
                        row += part;
                    }
                    pixels.extend(rows.rest());
                    assert!(pixels == whole.rgba8, "{combination:?} of {width}x{height}");
                }
            }
        }
    }
}
