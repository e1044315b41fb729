//! Methods that make the right view, and their variants (DESIGN, section 4).

use std::{fmt, num::NonZeroU32, str::FromStr};

use crate::Error;

/// How the right view is made from the left view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// [`Method::BRACKET`] or [`Method::Naive`], whichever a cost model predicts to be cheaper once the left view is
    /// traced; see [`Statistics::choice`](crate::Statistics).
    #[default]
    Auto,
    /// Traces both views: the baseline and the ground truth.
    Naive,
    /// Copies the left view. Its time is a bound on the savings of reuse. The picture is wrong where there is parallax.
    Ideal,
    /// A right pixel reuses the nearest left sample that lands in it, selected by atomicMax (thesis, 3.1.2.2).
    Atomic(Check),
    /// [`Method::Atomic`], but with all samples kept in a 3D buffer that is searched for the nearest (thesis, 3.1.2.1).
    Buffer(BufferDepth, Check),
    /// A right pixel reuses the last sample of Adelson & Hodges' left-to-right sweep. The sweep also clears gaps, which
    /// are traced. All other pixels are reused without a check.
    Sweep(Sweep),
    /// The samples that land in a tile of right pixels bound the depth of the tile's BVH query. Each pixel's own ray is
    /// then intersected with the primitives found, so primary visibility is exact. Only visibility bits of lights are
    /// reused (docs/BRACKET.md).
    Bracket(ShadowReuse),
}

/// Which of the pixels reused by [`Method::Atomic`] and [`Method::Buffer`] are checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Check {
    /// Checks all reused pixels by length-limited any-hit rays (thesis, 3.1.3).
    All,
    /// Checks no pixel by a ray. A pixel is traced if a neighbour of its left sample shows another object, or differs
    /// by over 1 px of parallax. Other pixels are trusted (thesis, future work).
    Edges,
    /// Checks no pixel: every reused sample is trusted.
    None,
}

/// Number of slots per right pixel in the 3D buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BufferDepth {
    /// A fixed number of slots.
    Fixed(NonZeroU32),
    /// `2 e_px`, rounded up, as Al-Hagri 2012 chooses. For parallel cameras, twice the disparity at the target. It is
    /// one slot too few if the nearest depth is d/2 or less (DESIGN, section 2).
    TwiceInteraxial,
    /// Lemma 1's bound, computed from the depth range of the left view. No candidate is lost.
    Adaptive,
}

/// Where Adelson & Hodges' sweep runs. Both variants make the same picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Sweep {
    /// On the device, one thread per row (Es & Isler 2007).
    Scanline,
    /// On one host thread, row after row (Adelson & Hodges 1993).
    Sequential,
}

/// Which visibility bits of the left view right pixels reuse ([`Method::Bracket`]). A bit says whether a light is
/// visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ShadowReuse {
    /// Reuses no bits: every shadow ray is traced, and the picture is identical to the picture of [`Method::Naive`].
    Rays,
    /// Reuses a bit if the two left samples next to the point agree on it.
    Two,
    /// Reuses a bit if all 2x3 left samples around the point agree on it and their normals are similar.
    Block,
}

impl Method {
    /// The thesis's atomic-based method; all reused pixels are checked.
    pub const ATOMIC: Self = Self::Atomic(Check::All);
    /// The thesis's buffer-based method, with a 3D buffer that loses no candidate.
    pub const BUFFER: Self = Self::Buffer(BufferDepth::Adaptive, Check::All);
    /// Es & Isler's method: Adelson & Hodges' sweep with one thread per row; gaps are traced.
    pub const ES_ISLER: Self = Self::Sweep(Sweep::Scanline);
    /// Adelson & Hodges' method: the sweep on the host. Makes the same picture as [`Method::ES_ISLER`].
    pub const ADELSON_HODGES: Self = Self::Sweep(Sweep::Sequential);
    /// One BVH query per tile of right pixels, bounded by the left samples that land there. Reuses visibility bits of
    /// the two left samples next to each point.
    pub const BRACKET: Self = Self::Bracket(ShadowReuse::Two);
    /// [`Method::BRACKET`] with visibility bits of 2x3 left samples.
    pub const VERIFIED: Self = Self::Bracket(ShadowReuse::Block);
    /// [`Method::BRACKET`] without reuse of visibility bits. It is as exact as [`Method::Naive`].
    pub const BRACKET_RAYS: Self = Self::Bracket(ShadowReuse::Rays);
    /// All methods with a name, in the order of tables.
    pub const ALL: &'static [Self] = &[
        Self::Naive,
        Self::Ideal,
        Self::ATOMIC,
        Self::BUFFER,
        Self::Buffer(BufferDepth::TwiceInteraxial, Check::All),
        Self::ES_ISLER,
        Self::ADELSON_HODGES,
        Self::Atomic(Check::Edges),
        Self::BRACKET,
        Self::VERIFIED,
        Self::BRACKET_RAYS,
        Self::Auto,
    ];
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match *self {
            Self::Auto => "auto".into(),
            Self::Naive => "naive".into(),
            Self::Ideal => "ideal".into(),
            Self::Atomic(check) => format!("atomic{}", check.suffix()),
            Self::Buffer(depth, check) => match depth {
                BufferDepth::Adaptive => format!("buffer{}", check.suffix()),
                BufferDepth::TwiceInteraxial => format!("buffer-2e{}", check.suffix()),
                BufferDepth::Fixed(slots) => format!("buffer-{slots}{}", check.suffix()),
            },
            Self::Sweep(Sweep::Scanline) => "es-isler".into(),
            Self::Sweep(Sweep::Sequential) => "adelson-hodges".into(),
            Self::Bracket(ShadowReuse::Rays) => "bracket-rays".into(),
            Self::Bracket(ShadowReuse::Two) => "bracket".into(),
            Self::Bracket(ShadowReuse::Block) => "verified".into(),
        };
        f.pad(&name)
    }
}

impl FromStr for Method {
    type Err = Error;

    /// Parses a name of [`Method::ALL`], or `buffer-N` for N slots. `atomic` and the `buffer` names take a suffix:
    /// `-unchecked` trusts all reused pixels, and `-edges` trusts reused pixels away from edges.
    fn from_str(name: &str) -> Result<Self, Error> {
        if let Some(method) = Self::ALL.iter().find(|method| method.to_string() == name) {
            return Ok(*method);
        }
        let (family, check) = [Check::Edges, Check::None]
            .into_iter()
            .find_map(|check| Some((name.strip_suffix(check.suffix())?, check)))
            .unwrap_or((name, Check::All));
        let depth = match family {
            "atomic" => return Ok(Self::Atomic(check)),
            "buffer" => Some(BufferDepth::Adaptive),
            "buffer-2e" => Some(BufferDepth::TwiceInteraxial),
            _ => family.strip_prefix("buffer-").and_then(|slots| slots.parse().ok()).map(BufferDepth::Fixed),
        };
        depth.map(|depth| Self::Buffer(depth, check)).ok_or_else(|| {
            let mut known: Vec<_> = Self::ALL.iter().map(Self::to_string).collect();
            known.push("buffer-N for N slots".into());
            known.push("atomic or a buffer name with the suffix -unchecked or -edges".into());
            Error::unknown_name("method", name, &known)
        })
    }
}

impl Check {
    /// Returns the suffix of method names.
    fn suffix(self) -> &'static str {
        match self {
            Self::All => "",
            Self::Edges => "-edges",
            Self::None => "-unchecked",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back_as_its_method() {
        let mut methods = Method::ALL.to_vec();
        for check in [Check::All, Check::Edges, Check::None] {
            let depths = [BufferDepth::Fixed(NonZeroU32::MIN), BufferDepth::TwiceInteraxial, BufferDepth::Adaptive];
            methods.extend(depths.map(|depth| Method::Buffer(depth, check)));
            methods.push(Method::Atomic(check));
        }
        for method in methods {
            assert_eq!(method.to_string().parse::<Method>().unwrap(), method);
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
}
