//! The part of a picture that a frame renders: all rows, some rows, or some pixels of these rows.

use std::ops::Range;

use crate::gpu::Texel;

/// The requested part of a frame.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    /// Whether pictures are requested, or only their cost.
    pub(crate) pictures: bool,
    /// Requested rows and pixels; `None` for all rows.
    pub(crate) part: Option<Part<'a>>,
}

/// Some rows of a picture, or some pixels of these rows.
#[derive(Clone, Copy)]
pub(crate) struct Part<'a> {
    pub(crate) rows: (u32, u32),
    /// Mask of the wanted pixels of each view; `None` if all pixels are wanted. Other pixels are undefined.
    pub(crate) masks: Option<&'a [Mask]>,
}

impl Wanted<'_> {
    /// Requests all rows.
    pub(crate) fn all(pictures: bool) -> Self {
        Self { pictures, part: None }
    }

    pub(crate) fn rows(&self, [_, height]: [u32; 2]) -> Range<u32> {
        self.part.map_or(0..height, |part| part.rows.0..part.rows.1)
    }

    pub(crate) fn masks(&self) -> Option<&[Mask]> {
        self.part.and_then(|part| part.masks)
    }
}

/// Mask with a bit for each pixel of some rows of a view.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mask {
    /// Number of texels per row. Each texel has the bits of 128 pixels, with the first pixel in the lowest bit
    /// (`shaders/shared/wanted.wgsl`).
    texels_across: u32,
    /// Rows of the picture that the mask covers.
    rows: Range<u32>,
    texels: Vec<Texel>,
}

impl Mask {
    /// Creates a mask of these rows of a picture of this width, without wanted pixels.
    pub(crate) fn new(width: u32, rows: Range<u32>) -> Self {
        let texels_across = width.div_ceil(128);
        let texels = vec![[0; 4]; texels_across as usize * rows.len()];
        Self { texels_across, rows, texels }
    }

    /// Returns the index of a pixel's texel, the index of the word in the texel, and the bit in the word.
    fn place(&self, column: u32, row: u32) -> (usize, usize, u32) {
        let texel = (row - self.rows.start) * self.texels_across + column / 128;
        (texel as usize, (column / 32 % 4) as usize, 1 << (column % 32))
    }

    /// Marks a pixel of the picture as wanted.
    pub(crate) fn want(&mut self, column: u32, row: u32) {
        let (texel, word, bit) = self.place(column, row);
        self.texels[texel][word] |= bit;
    }

    #[cfg(test)]
    pub(crate) fn wants(&self, column: u32, row: u32) -> bool {
        let (texel, word, bit) = self.place(column, row);
        self.texels[texel][word] & bit != 0
    }

    /// Counts the wanted pixels in these rows.
    pub(crate) fn count(&self, rows: Range<u32>) -> u64 {
        self.texels_of(rows).iter().flatten().map(|word| u64::from(word.count_ones())).sum()
    }

    /// Returns the number of texels per row, and the texels of these rows.
    pub(crate) fn rows(&self, rows: Range<u32>) -> (u32, &[Texel]) {
        (self.texels_across, self.texels_of(rows))
    }

    fn texels_of(&self, rows: Range<u32>) -> &[Texel] {
        let place = |row: u32| ((row - self.rows.start) * self.texels_across) as usize;
        &self.texels[place(rows.start)..place(rows.end)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wanted_is_counted_by_rows() {
        let mut mask = Mask::new(300, 70..75);
        for (column, row) in [(0, 70), (127, 71), (128, 71), (299, 74), (299, 74)] {
            mask.want(column, row);
            assert!(mask.wants(column, row) && !mask.wants(column, 73));
        }
        assert_eq!([70..75, 70..71, 71..72, 72..74, 74..75].map(|rows| mask.count(rows)), [4, 1, 2, 0, 1]);
        assert_eq!(mask.rows(71..72), (3, &[[0, 0, 0, 1 << 31], [1, 0, 0, 0], [0; 4]][..]));
    }
}
