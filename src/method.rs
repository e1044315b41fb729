//! How the right view is made: the named methods and the choices they are made of (DESIGN, section 4).

use std::{fmt, str::FromStr};

use crate::{Error, Pose};

/// How the right view is made of the left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// [`Method::BRACKET`] or [`Method::Naive`], whichever a cost model predicts to be cheaper once the left view is there; see
    /// [`Statistics::choice`](crate::Statistics).
    #[default]
    Auto,
    /// Both views are traced: the baseline and the ground truth.
    Naive,
    /// The left view is copied: the bound on what reuse can save, and wrong wherever there is parallax.
    Ideal,
    /// Left pixels are carried over where they are found to fit, the rest is traced.
    Reuse {
        /// Which left samples a right pixel looks at.
        overlap: Overlap,
        /// Which reused pixels are checked by a ray.
        verify: Verify,
    },
}

/// Which left samples a right pixel looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Overlap {
    /// The nearest one, kept by atomicMax (thesis, 3.1.2.2).
    Atomic,
    /// All of them in a 3D buffer, which is then searched for the nearest (thesis, 3.1.2.1).
    Buffer(BufferDepth),
    /// The last one of Adelson & Hodges' sweep from left to right, which also clears what no left sample vouches for; a
    /// thread a row (Es & Isler 2007).
    Scanline,
    /// The same by one thread of the host, row after row (Adelson & Hodges 1993).
    Sequential,
    /// Those that land in its tile say how deep the BVH must be searched there; what is found, the pixel's own ray meets. Nothing is
    /// copied but shadow bits (docs/BRACKET.md). Primary visibility is exact.
    Bracket(ShadowReuse),
}

/// Which shadow bits right pixels take over from the left view (`Overlap::Bracket`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ShadowReuse {
    /// None: every shadow ray is traced, and the picture is `Naive`'s.
    Rays,
    /// Those that the two left samples beside the point agree in.
    Two,
    /// Those that the block of 2x3 left samples around the point agrees in, where normals are alike.
    Block,
}

/// Slots a right pixel of the 3D buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BufferDepth {
    /// As many as said, at least 1.
    Fixed(u32),
    /// `2 e_px`, rounded up: the thesis's choice. One slot short from nearest depth d/2 on (DESIGN, section 2).
    TwiceInteraxial,
    /// Lemma 1's bound from the depths that the left view met: no candidate is ever lost.
    Adaptive,
}

/// Which reused pixels are checked by a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Verify {
    /// All of them, by length-limited any-hit rays (thesis, 3.1.3).
    All,
    /// None by a ray: what lies in a gap between left samples was cleared by the sweep and is traced, the rest is trusted.
    Gaps,
    /// None by a ray: those whose left sample has a neighbour of another object, or over 1 px of parallax away, are traced,
    /// the rest is trusted (thesis, future work).
    Edges,
    /// None: what landed is trusted.
    None,
}

impl Method {
    /// The thesis's atomic-based method: overlap atomic, all reused pixels checked.
    pub const ATOMIC: Self = Self::Reuse { overlap: Overlap::Atomic, verify: Verify::All };
    /// The thesis's buffer-based method with a 3D buffer that loses nothing.
    pub const BUFFER: Self = Self::Reuse { overlap: Overlap::Buffer(BufferDepth::Adaptive), verify: Verify::All };
    /// Es & Isler's method: Adelson & Hodges' sweep with a thread a row, gaps traced.
    pub const ES_ISLER: Self = Self::Reuse { overlap: Overlap::Scanline, verify: Verify::Gaps };
    /// Adelson & Hodges' method: the sweep on the host. The same picture as [`Method::ES_ISLER`].
    pub const ADELSON_HODGES: Self = Self::Reuse { overlap: Overlap::Sequential, verify: Verify::Gaps };
    /// One query of the BVH a tile of right pixels, as deep as the left samples that land there; shadow bits of the two left samples
    /// beside each point.
    pub const BRACKET: Self = Self::Reuse { overlap: Overlap::Bracket(ShadowReuse::Two), verify: Verify::All };
    /// The same with shadow bits of 2x3 samples.
    pub const VERIFIED: Self = Self::Reuse { overlap: Overlap::Bracket(ShadowReuse::Block), verify: Verify::All };
    /// The same without shadow bits: as exact as [`Method::Naive`].
    pub const BRACKET_RAYS: Self = Self::Reuse { overlap: Overlap::Bracket(ShadowReuse::Rays), verify: Verify::All };
    /// The methods by name, in the order in which tables show them.
    pub const ALL: [(&'static str, Self); 12] = [
        ("naive", Self::Naive),
        ("ideal", Self::Ideal),
        ("atomic", Self::ATOMIC),
        ("buffer", Self::BUFFER),
        ("buffer-2e", Self::Reuse { overlap: Overlap::Buffer(BufferDepth::TwiceInteraxial), verify: Verify::All }),
        ("es-isler", Self::ES_ISLER),
        ("adelson-hodges", Self::ADELSON_HODGES),
        ("atomic-edges", Self::Reuse { overlap: Overlap::Atomic, verify: Verify::Edges }),
        ("bracket", Self::BRACKET),
        ("verified", Self::VERIFIED),
        ("bracket-rays", Self::BRACKET_RAYS),
        ("auto", Self::Auto),
    ];

    /// Whether its choices go together (DESIGN, section 4).
    ///
    /// # Errors
    /// [`Error::Choices`], naming both.
    pub(crate) fn check(self) -> Result<(), Error> {
        let Self::Reuse { overlap, verify } = self else { return Ok(()) };
        let (fits, fitting) = match overlap {
            Overlap::Scanline | Overlap::Sequential => (verify == Verify::Gaps, "gaps"),
            Overlap::Bracket(_) => (verify == Verify::All, "all"),
            Overlap::Atomic | Overlap::Buffer(_) => (verify != Verify::Gaps, "all, edges or none"),
        };
        if fits {
            return Ok(());
        }
        Err(Error::Choices { overlap: format!("{overlap:?}"), verify: format!("{verify:?}"), fitting })
    }
}

/// End the names of methods that trust what they reuse ([`Verify::None`]), all of it or away from edges.
const UNCHECKED: &str = "-unchecked";
const EDGES: &str = "-edges";

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (overlap, verify) = match *self {
            Self::Auto => return f.write_str("auto"),
            Self::Naive => return f.write_str("naive"),
            Self::Ideal => return f.write_str("ideal"),
            Self::Reuse { overlap, verify } => (overlap, verify),
        };
        match overlap {
            Overlap::Atomic => f.write_str("atomic")?,
            Overlap::Buffer(BufferDepth::Adaptive) => f.write_str("buffer")?,
            Overlap::Buffer(BufferDepth::TwiceInteraxial) => f.write_str("buffer-2e")?,
            Overlap::Buffer(BufferDepth::Fixed(depth)) => write!(f, "buffer-{depth}")?,
            Overlap::Scanline => f.write_str("es-isler")?,
            Overlap::Sequential => f.write_str("adelson-hodges")?,
            Overlap::Bracket(ShadowReuse::Rays) => f.write_str("bracket-rays")?,
            Overlap::Bracket(ShadowReuse::Two) => f.write_str("bracket")?,
            Overlap::Bracket(ShadowReuse::Block) => f.write_str("verified")?,
        }
        f.write_str(match verify {
            Verify::All | Verify::Gaps => "",
            Verify::Edges => EDGES,
            Verify::None => UNCHECKED,
        })
    }
}

impl FromStr for Method {
    type Err = Error;

    /// Reads a name of [`Method::ALL`], or `buffer-N` for N slots; `-unchecked` or `-edges` behind `atomic` or a `buffer` makes
    /// it trust what it reuses, all of it or away from edges.
    fn from_str(name: &str) -> Result<Self, Error> {
        for (suffix, verify) in [(UNCHECKED, Verify::None), (EDGES, Verify::Edges)] {
            if let Some(Ok(Self::Reuse { overlap, verify: Verify::All })) = name.strip_suffix(suffix).map(str::parse) {
                return Ok(Self::Reuse { overlap, verify });
            }
        }
        if let Some((_, method)) = Self::ALL.iter().find(|(known, _)| *known == name) {
            return Ok(*method);
        }
        match name.strip_prefix("buffer-").and_then(|depth| depth.parse().ok()) {
            Some(depth) if depth > 0 => {
                Ok(Self::Reuse { overlap: Overlap::Buffer(BufferDepth::Fixed(depth)), verify: Verify::All })
            }
            _ => {
                let mut known: Vec<_> = Self::ALL.iter().map(|(name, _)| *name).collect();
                known.push("buffer-N for N slots");
                known.push("atomic and buffers with -unchecked or -edges behind");
                Err(Error::unknown_name("method", name, &known))
            }
        }
    }
}

impl BufferDepth {
    /// Slots a right pixel for a left view with depths in `[nearest, farthest]`, at least 1 and at most the width.
    pub(crate) fn slots(self, pose: &Pose, (nearest, farthest): (f32, f32)) -> u32 {
        let depth = match self {
            Self::Fixed(depth) => f64::from(depth),
            Self::TwiceInteraxial => f64::from(2.0 * pose.interaxial_px).ceil(),
            // X is rounded to f32, which can move two samples together by a thousandth of a pixel.
            Self::Adaptive => (lemma1(pose, nearest, farthest) + 1e-3).floor() + 2.0,
        };
        // Depths of 0 make the bound infinite or no number: max takes the 1.
        depth.min(f64::from(pose.size[0])).max(1.0) as u32
    }
}

/// `B = e_px d (1/Z_near - 1/Z_far)`: two left samples in one right column are fewer than `B + 1` columns apart
/// (thesis, Lemma 1, with rounding as in DESIGN, section 2). A farthest depth of infinity counts as 1/Z = 0.
pub fn lemma1(pose: &Pose, nearest: f32, farthest: f32) -> f64 {
    let reach = f64::from(pose.interaxial_px) * f64::from(pose.screen_distance);
    reach * (1.0 / f64::from(nearest) - 1.0 / f64::from(farthest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back_as_its_method() {
        for (name, method) in Method::ALL {
            assert_eq!(name.parse::<Method>().unwrap(), method);
            assert_eq!(method.to_string(), name);
        }
        for name in [
            "buffer-8",
            "atomic-unchecked",
            "buffer-unchecked",
            "buffer-2e-unchecked",
            "buffer-8-unchecked",
            "buffer-edges",
            "buffer-8-edges",
        ] {
            assert_eq!(name.parse::<Method>().unwrap().to_string(), name);
        }
        for wrong in [
            "",
            "Naive2",
            "buffer-0",
            "buffer-x",
            "naive-unchecked",
            "-unchecked",
            "x-unchecked",
            "es-isler-edges",
            "atomic-edges-unchecked",
        ] {
            let message = wrong.parse::<Method>().unwrap_err().to_string();
            assert!(message.contains("naive, ideal, atomic, buffer"), "{message}");
        }
    }

    #[test]
    fn choices_that_do_not_go_together_are_named() {
        for (_, method) in Method::ALL {
            method.check().unwrap();
        }
        for (overlap, verify, words) in [
            (Overlap::Scanline, Verify::All, ["Scanline", "All", "gaps"]),
            (Overlap::Sequential, Verify::None, ["Sequential", "None", "gaps"]),
            (Overlap::Atomic, Verify::Gaps, ["Atomic", "Gaps", "all, edges or none"]),
        ] {
            let message = Method::Reuse { overlap, verify }.check().unwrap_err().to_string();
            assert!(words.iter().all(|word| message.contains(word)), "{message}");
        }
    }
}
