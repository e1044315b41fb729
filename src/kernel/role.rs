//! Roles of kernels. A role determines a kernel's text and the part of the variant that matters to it. The code matches
//! on roles, so the compiler demands every choice for a new role.

use crate::kernel::variant::SoftRole;

/// Role of a kernel in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Role {
    /// Processes pixels and lists without reading the scene.
    Pixels,
    /// Processes pixels and their linear colour without reading the scene.
    LinearPixels,
    /// Marks busy lights: lights whose visibility at a point is not determined by the source samples beside it.
    MarkBusy,
    /// Reads the objects that primitives belong to.
    Objects,
    /// Finds hits without shading them.
    Hits(Hits),
    /// Draws primitives onto a canvas.
    Draw(Canvas),
    /// Traces the caller's rays.
    RayList(Dispatches),
    /// Shades hits, or prepares their shading.
    Shade(Shading),
    /// Follows paths of light from hits, or adds the light that they brought.
    Paths,
    /// Reuses the light that the paths of a source view brought.
    SharePaths,
}

/// The pixels whose hits a kernel finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Hits {
    /// All pixels of a view.
    View,
    /// Pixels of the tiles that `bracket` searches.
    Tiles,
    /// Reprojected pixels, each of which is verified by a ray.
    Checked,
    /// Reprojected pixels, which are used without verification.
    Trusted,
    /// Listed pixels.
    Listed,
    /// Pixels whose hits a T-buffer holds.
    Drawn,
    /// Listed pixels that show mirrors, glass or veils. The hits are those of the rays that these surfaces send on.
    Bounced,
}

/// The canvas onto which primitives are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Canvas {
    /// A view's pixels.
    Picture,
    /// Centres of a shadow-buffer's texels.
    Middles,
    /// Whole texels of a shadow-buffer.
    Texels,
}

/// Number of dispatches in which a thread completes its work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Dispatches {
    One,
    /// Several dispatches, each with a limited number of loop rounds (`src/frame/lanes.rs`).
    Many,
}

/// The hits that a kernel shades, and how it determines the lights that are visible from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Shading {
    /// Hits of the kernel's own primary rays. It traces shadow rays.
    Traced(Dispatches),
    /// Known hits of a whole view, whose samples may be kept for other views. The kernel traces shadow rays.
    Source,
    /// Misses only, which show the sky.
    Sky,
    /// Hits in tiles. The kernel reuses visibility bits and lists the pixels for which some bit is unknown.
    Reused,
    /// Hits for which some visibility bit is unknown. The kernel reuses known bits and traces shadow rays for the
    /// others.
    Unknown,
    /// Listed hits. The kernel traces shadow rays.
    Listed,
    /// No hits. The kernel samples the soft lights for the hits of a view.
    Soft,
    /// No hits. The kernel samples the soft lights for listed hits.
    SoftListed,
    /// No hits. The kernel samples the soft lights for hits for which the visible share of a soft light is unknown.
    SoftUnknown,
    /// Like [`Sky`](Self::Sky), for a traced view that recalls bits from an earlier frame. Its samples are kept.
    RecalledSky,
    /// Like [`Reused`](Self::Reused), for such a view.
    Recalled,
    /// Like [`Unknown`](Self::Unknown), for such a view.
    RecalledUnknown,
    /// Like [`SoftUnknown`](Self::SoftUnknown), for such a view.
    RecalledSoft,
    /// No hits. The kernel lists hits on surfaces that reflect or transmit rays.
    ListMirrors,
    /// Hits of secondary rays, which surfaces reflect or transmit.
    Mirrored,
    /// Like [`Mirrored`](Self::Mirrored), with known light. The kernel sends on rays.
    MirroredLit,
}

/// How a kernel uses samples of source views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SampleUse {
    None,
    /// Writes samples, if the frame keeps any.
    Written,
    Read,
}

/// How a kernel determines visibility bits: by shadow rays, by reuse, or by shadow rays for bits that cannot be reused.
/// Bits are taken from a source view of the same frame, or recalled from an earlier frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Visible {
    Traced,
    Taken,
    TakenOrTraced,
    Recalled,
    RecalledOrTraced,
}

/// Properties of a kernel's text that follow from its role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Does {
    pub(crate) samples: SampleUse,
    /// Role of the kernel in soft light.
    pub(crate) soft: SoftRole,
    pub(crate) visibility: Visible,
    /// Whether shaded points query shadow-buffers before shadow rays are traced.
    pub(crate) queries_shadow_buffers: bool,
    /// Whether the kernel traces secondary rays, which surfaces reflect or transmit.
    pub(crate) follows: bool,
    pub(crate) dispatches: Dispatches,
    pub(crate) canvas: Canvas,
    /// Whether rays verify reused pixels.
    pub(crate) checks: bool,
    /// Whether the kernel depends on the mask of wanted pixels.
    pub(crate) minds_mask: bool,
}

impl Does {
    /// Properties of a kernel that shades nothing.
    const PLAIN: Self = Self {
        samples: SampleUse::None,
        soft: SoftRole::None,
        visibility: Visible::Traced,
        queries_shadow_buffers: false,
        follows: false,
        dispatches: Dispatches::One,
        canvas: Canvas::Picture,
        checks: true,
        minds_mask: false,
    };
}

impl Role {
    pub(crate) fn does(self) -> Does {
        match self {
            Self::LinearPixels | Self::Objects => Does::PLAIN,
            Self::Pixels => Does { minds_mask: true, ..Does::PLAIN },
            Self::MarkBusy => Does { samples: SampleUse::Read, ..Does::PLAIN },
            Self::Hits(hits) => hits.does(),
            Self::Draw(canvas) => Does { canvas, ..Does::PLAIN },
            Self::RayList(dispatches) => Does { dispatches, ..Does::PLAIN },
            Self::Shade(shading) => shading.does(),
            Self::SharePaths => Does { samples: SampleUse::Read, follows: true, minds_mask: true, ..Does::PLAIN },
            Self::Paths => Does { follows: true, minds_mask: true, ..Does::PLAIN },
        }
    }

    /// Returns whether kernels of this role read the scene's tree.
    pub(crate) fn reads_tree(self) -> bool {
        match self {
            Self::Pixels | Self::LinearPixels | Self::MarkBusy | Self::Objects => false,
            Self::Hits(_) | Self::Draw(_) | Self::RayList(_) | Self::Shade(_) | Self::Paths | Self::SharePaths => true,
        }
    }
}

impl Hits {
    fn does(self) -> Does {
        match self {
            Self::View | Self::Tiles => Does { minds_mask: true, ..Does::PLAIN },
            Self::Trusted => Does { checks: false, ..Does::PLAIN },
            Self::Checked | Self::Listed | Self::Drawn | Self::Bounced => Does::PLAIN,
        }
    }
}

impl Shading {
    fn does(self) -> Does {
        let plain = Does::PLAIN;
        match self {
            Self::Traced(Dispatches::One) => {
                let (samples, soft) = (SampleUse::Written, SoftRole::Skipped);
                Does { samples, soft, queries_shadow_buffers: true, minds_mask: true, ..plain }
            }
            Self::Traced(Dispatches::Many) => Does { soft: SoftRole::Skipped, dispatches: Dispatches::Many, ..plain },
            Self::Source => {
                let (samples, soft) = (SampleUse::Written, SoftRole::Masked);
                Does { samples, soft, queries_shadow_buffers: true, minds_mask: true, ..plain }
            }
            Self::Sky | Self::ListMirrors => Does { minds_mask: true, ..plain },
            Self::Reused => {
                let (samples, soft, visibility) = (SampleUse::Read, SoftRole::Masked, Visible::Taken);
                Does { samples, soft, visibility, minds_mask: true, ..plain }
            }
            Self::Unknown => {
                let (samples, soft, visibility) = (SampleUse::Read, SoftRole::Masked, Visible::TakenOrTraced);
                Does { samples, soft, visibility, queries_shadow_buffers: true, ..plain }
            }
            Self::Listed => Does { soft: SoftRole::Masked, queries_shadow_buffers: true, ..plain },
            Self::Soft => Does { soft: SoftRole::Asked, minds_mask: true, ..plain },
            Self::RecalledSky => Does { samples: SampleUse::Written, ..Self::Sky.does() },
            Self::Recalled => {
                Does { samples: SampleUse::Written, visibility: Visible::Recalled, ..Self::Reused.does() }
            }
            Self::RecalledUnknown => {
                Does { samples: SampleUse::Written, visibility: Visible::RecalledOrTraced, ..Self::Unknown.does() }
            }
            Self::RecalledSoft => {
                Does { samples: SampleUse::None, visibility: Visible::RecalledOrTraced, ..Self::SoftUnknown.does() }
            }
            Self::SoftListed => Does { soft: SoftRole::Asked, ..plain },
            Self::SoftUnknown => {
                let (samples, soft, visibility) = (SampleUse::Read, SoftRole::Asked, Visible::TakenOrTraced);
                Does { samples, soft, visibility, ..plain }
            }
            Self::Mirrored => Does { queries_shadow_buffers: true, ..Self::MirroredLit.does() },
            Self::MirroredLit => Does { soft: SoftRole::Followed, follows: true, ..plain },
        }
    }
}
