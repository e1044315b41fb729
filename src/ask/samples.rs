//! The number of samples per pixel, and their filter (docs/DESIGN.md, section 3).

use crate::{Error, error::by_name};

/// Maximum number of rows and columns of a pixel's sample grid.
pub(crate) const MAX_SIDE: u32 = 8;

/// Reconstruction filter of a pixel's samples. A sample at distance (x, y) from the pixel's centre, in pixels, has the
/// weight `w(x) w(y)`, divided by the sum of the pixel's weights. Filtering is in linear light. Samples beyond the
/// picture's borders are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Filter {
    /// `w(x) = 1` where `|x| < 0.5`: the mean of the pixel's own samples.
    #[default]
    Box,
    /// `w(x) = 1 - |x|` where `|x| < 1`.
    Tent,
    /// `w(x) = exp(-x² / 2σ²) - exp(-1.5² / 2σ²)` where `|x| < 1.5`, with `σ = 0.5`: a bell that ends without a step.
    Gauss,
}

impl Filter {
    /// Every filter, the default first.
    pub const ALL: &'static [Self] = &[Self::Box, Self::Tent, Self::Gauss];

    /// Returns the name that [`FromStr`](std::str::FromStr) parses and [`Display`](std::fmt::Display) writes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Tent => "tent",
            Self::Gauss => "gauss",
        }
    }

    /// Returns the filter's radius in pixels.
    pub fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gauss => 1.5,
        }
    }

    /// Returns `w(x)` for a distance within the radius.
    pub(crate) fn weight(self, x: f64) -> f64 {
        match self {
            Self::Box => 1.0,
            Self::Tent => 1.0 - x.abs(),
            Self::Gauss => (-2.0 * x * x).exp() - (-2.0 * self.radius() * self.radius()).exp(),
        }
    }
}

by_name!(Filter, "filter");

/// Returns the side of the grid of a pixel's samples.
///
/// # Errors
/// [`Error::Samples`] for a number that is not the square of 1 to 8.
pub(crate) fn side_of(samples: u32) -> Result<u32, Error> {
    let side = (1..=MAX_SIDE).find(|side| side * side == samples);
    side.ok_or_else(|| Error::Samples { samples, reason: "use 1, 4, 9, 16, 25, 36, 49 or 64".into() })
}
