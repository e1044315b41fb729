//! How the first hits of traced views are found.

use std::{fmt, str::FromStr};

use crate::{Error, Options};

/// How the first hits of views that are traced are found: by both ways the same hits. Views that a method makes from
/// another one are made as ever.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Visibility {
    /// Each pixel's ray goes through the tree. The default, since nothing that was measured was faster without:
    /// docs/T-BUFFER.md has the figures.
    #[default]
    Rays,
    /// Each primitive is drawn over the pixels that its projection may reach, by the tests of their own rays; the
    /// nearest t of each pixel is kept (Raghuvanshi & Dhande, "Raytraced rendering using t-buffer and
    /// shadow-buffer", section II; docs/T-BUFFER.md). Then no primary rays
    /// are shot ([`Rays::primary`](crate::Rays::primary)): each primitive is projected once a view and band of rows
    /// instead ([`Work::nodes`](crate::Work::nodes)). On software adapters the picture is that of rays to the bit.
    ///
    /// Rays are traced all the same where pixels are masked ([`Options::adaptive`](crate::Options::adaptive), but for
    /// the first level and pixels' centres), in frames [in steps](crate::Statistics::in_steps), in bands of which
    /// [`Method::Auto`](crate::Method::Auto) finds out on the device that both views are traced, in scenes without
    /// anything but planes, and where a scene has more primitives than a list of 12 bytes each in one storage
    /// buffer holds: 11.1 million at WebGPU's default of 128 MiB.
    TBuffer,
}

impl Visibility {
    /// Both, the default first.
    pub const ALL: &'static [Self] = &[Self::Rays, Self::TBuffer];

    /// The name that [`FromStr`] reads and [`Display`](fmt::Display) writes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rays => "rays",
            Self::TBuffer => "t-buffer",
        }
    }
}

impl Options {
    /// How the first hits of views that are traced are found: [`Visibility::Rays`] unless something else is asked for.
    pub fn visibility(mut self, visibility: Visibility) -> Self {
        self.visibility = visibility;
        self
    }
}

impl fmt::Display for Visibility {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Visibility {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let found = Self::ALL.iter().copied().find(|way| way.name() == name);
        found.ok_or_else(|| Error::unknown_name("visibility", name, Self::ALL))
    }
}
