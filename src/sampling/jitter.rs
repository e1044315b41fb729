//! Offsets of jittered samples from their cells' centres, one per row of samples (docs/DESIGN.md, section 3;
//! shaders/shared/jitter.wgsl).

use crate::{Options, random::pcg};

/// The offsets of a picture's rows of samples, the same in all views.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jitter {
    /// Side of a pixel's sample grid, in samples; 1 without jitter.
    side: u32,
    seed: u32,
}

impl Jitter {
    /// Creates the jitter for `side` x `side` samples per pixel, with a seed.
    pub(crate) fn new(side: u32, seed: u32) -> Self {
        Self { side, seed }
    }

    /// Returns the jitter that the options request. Invalid numbers of samples give no jitter; they are rejected
    /// elsewhere.
    pub(crate) fn of(options: &Options) -> Self {
        let side = if options.jitter { crate::ask::samples::side_of(options.samples).unwrap_or(1) } else { 1 };
        Self::new(side, options.jitter_seed())
    }

    /// Returns the side of the grid, or 1 without jitter.
    pub(crate) fn side(&self) -> u32 {
        self.side
    }

    /// Returns the seed of the rows' offsets.
    pub(crate) fn seed(&self) -> u32 {
        self.seed
    }

    /// Returns the largest offset of a sample from its cell's centre, in cell widths.
    pub(crate) fn reach(&self) -> f32 {
        0.5 - 0.5 / self.side as f32
    }

    /// Returns the stratum of a row's samples within their cells' width. It is the rank of the row's hash among the
    /// hashes of the pixel's rows.
    pub(crate) fn stratum(&self, row: u32) -> u32 {
        let (first, own) = (row / self.side * self.side, (self.hash(row), row));
        (first..first + self.side).filter(|&other| (self.hash(other), other) < own).count() as u32
    }

    /// Returns the offset of a stratum's samples to the right of their cells' centres, in cell widths.
    pub(crate) fn aside(&self, stratum: u32) -> f32 {
        (stratum as f32 + 0.5) / self.side as f32 - 0.5
    }

    fn hash(&self, row: u32) -> u32 {
        pcg(row ^ pcg(self.seed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_of_a_pixel_share_its_strata_out() {
        for (side, seed) in (1..=8).flat_map(|side| [0, 1, 77].map(|seed| (side, seed))) {
            let jitter = Jitter::new(side, seed);
            let mut orders = std::collections::BTreeSet::new();
            for pixel in 0..100 {
                let strata = Vec::from_iter((pixel * side..(pixel + 1) * side).map(|row| jitter.stratum(row)));
                let mut sorted = strata.clone();
                sorted.sort_unstable();
                assert_eq!(sorted, Vec::from_iter(0..side), "{side} {seed}");
                orders.insert(strata);
            }
            // Most of the possible orders occur, or nearly as many as there are pixels.
            assert!(orders.len() as u32 >= (3 * (1..=side).product::<u32>() / 4).min(60), "{side}: {}", orders.len());
        }
    }

    #[test]
    fn samples_stay_in_their_cells_and_within_reach() {
        for side in 1..=8 {
            let jitter = Jitter::new(side, 3);
            let asides = Vec::from_iter((0..side).map(|stratum| jitter.aside(stratum)));
            assert!(asides.iter().sum::<f32>().abs() < 1e-6, "{asides:?}");
            assert!(asides.iter().all(|aside| aside.abs() <= jitter.reach() + 1e-7) && jitter.reach() < 0.5, "{side}");
        }
    }
}
