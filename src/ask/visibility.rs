//! How the first hits of traced views are found.

use crate::{Options, error::by_name};

/// How the first hits of traced views are found. Both ways find the same hits. Views that a method makes from another
/// view are not affected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Visibility {
    /// Traces each pixel's ray through the BVH. This is the default, since no measurement was faster with a T-buffer
    /// (docs/T-BUFFER.md).
    #[default]
    Rays,
    /// Projects each primitive onto the pixels, tests it against their rays, and keeps the nearest t of each pixel
    /// (docs/T-BUFFER.md). The method is from Raghuvanshi & Dhande, "Raytraced rendering using t-buffer and
    /// shadow-buffer", section II. This traces no primary rays ([`Rays::primary`](crate::Rays::primary)). Each
    /// primitive is projected once per view and band of rows ([`Work::nodes`](crate::Work::nodes)). On software
    /// adapters the picture is identical, to the bit.
    ///
    /// Rays are still traced
    ///
    /// - where pixels are masked ([`Options::adaptive`](crate::Options::adaptive), except the first level and pixel
    ///   centres),
    /// - in frames [in steps](crate::Statistics::in_steps),
    /// - in bands where [`Method::Auto`](crate::Method::Auto) decides on the device that both views are traced,
    /// - in scenes that have planes only,
    /// - in scenes with more primitives than one storage buffer holds at 12 bytes each: 11.1 million at WebGPU's
    ///   default of 128 MiB.
    TBuffer,
}

impl Visibility {
    /// Both variants, the default first.
    pub const ALL: &'static [Self] = &[Self::Rays, Self::TBuffer];

    /// Returns the name that [`FromStr`](std::str::FromStr) parses and [`Display`](std::fmt::Display) writes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rays => "rays",
            Self::TBuffer => "t-buffer",
        }
    }
}

impl Options {
    /// Sets how the first hits of traced views are found; [`Visibility::Rays`] by default.
    pub fn visibility(mut self, visibility: Visibility) -> Self {
        self.visibility = visibility;
        self
    }
}

by_name!(Visibility, "visibility");
