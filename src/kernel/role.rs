//! What kernels do. Their texts and variants are chosen by it, so a new role makes the compiler ask for every choice.

use crate::kernel::variant::SoftRole;

/// The part of a kernel in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Role {
    /// Works on pixels and lists, without the scene.
    Pixels,
    /// The same with linear colour.
    LinearPixels,
    /// Marks lights that source samples disagree about.
    MarkBusy,
    /// Reads the objects of primitives.
    Objects,
    /// Finds hits, and shades nothing.
    Hits(Hits),
    /// Draws primitives.
    Draw(Canvas),
    /// Traces the caller's rays.
    RayList(Dispatches),
    /// Shades hits.
    Shade(Shading),
}

/// Which pixels a kernel finds the hits of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Hits {
    /// All pixels of a view.
    View,
    /// Pixels of tiles.
    Tiles,
    /// Reprojected pixels, which rays check.
    Checked,
    /// Reprojected pixels, which are trusted.
    Trusted,
    /// Listed pixels.
    Listed,
    /// Pixels of a T-buffer.
    Drawn,
}

/// What primitives are drawn on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Canvas {
    /// A view's pixels.
    Picture,
    /// Centres of a shadow-buffer's texels.
    Middles,
    /// Whole texels of a shadow-buffer.
    Texels,
}

/// Dispatches in which a thread does its work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Dispatches {
    One,
    /// A limited number of loop rounds in each of several (`src/frame/lanes.rs`).
    Many,
}

/// Which hits a kernel shades, and how it finds which lights they see.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Shading {
    /// Hits of its own primary rays, by shadow rays.
    Traced(Dispatches),
    /// Known hits of a view that others are made from, by shadow rays.
    Source,
    /// Misses only.
    Sky,
    /// Hits whose visibility bits are reused.
    Reused,
    /// Hits whose visibility bits are reused where they are known.
    Unknown,
    /// Listed hits, by shadow rays.
    Listed,
    /// None: it samples the soft lights of a view's hits.
    Soft,
    /// None: it samples the soft lights of listed hits.
    SoftListed,
    /// None: it samples the soft lights of hits whose shares are unknown.
    SoftUnknown,
    /// None: it lists hits that send rays on.
    ListMirrors,
    /// Hits of rays that surfaces send on.
    Mirrored,
}

/// How a kernel uses samples of source views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SampleUse {
    None,
    /// Writes them, if the frame keeps any.
    Written,
    Read,
}

/// How shadow rays are answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Visible {
    Traced,
    Taken,
    TakenOrTraced,
}

/// Properties of a kernel's text that follow from its role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Does {
    pub(crate) samples: SampleUse,
    /// Its part in soft light, if there is any.
    pub(crate) soft: SoftRole,
    pub(crate) visibility: Visible,
    /// Whether points query shadow-buffers before they trace shadow rays.
    pub(crate) queries_shadow_buffers: bool,
    /// Whether it follows the rays that surfaces send on.
    pub(crate) follows: bool,
    pub(crate) dispatches: Dispatches,
    pub(crate) canvas: Canvas,
    /// Whether reused pixels are checked by rays.
    pub(crate) checks: bool,
    /// Whether it depends on the mask of wanted pixels.
    pub(crate) minds_mask: bool,
}

impl Does {
    /// A kernel that shades nothing.
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
        }
    }

    /// Returns whether it reads the scene's tree.
    pub(crate) fn reads_tree(self) -> bool {
        match self {
            Self::Pixels | Self::LinearPixels | Self::MarkBusy | Self::Objects => false,
            Self::Hits(_) | Self::Draw(_) | Self::RayList(_) | Self::Shade(_) => true,
        }
    }
}

impl Hits {
    fn does(self) -> Does {
        match self {
            Self::View | Self::Tiles => Does { minds_mask: true, ..Does::PLAIN },
            Self::Trusted => Does { checks: false, ..Does::PLAIN },
            Self::Checked | Self::Listed | Self::Drawn => Does::PLAIN,
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
            Self::SoftListed => Does { soft: SoftRole::Asked, ..plain },
            Self::SoftUnknown => {
                let (samples, soft, visibility) = (SampleUse::Read, SoftRole::Asked, Visible::TakenOrTraced);
                Does { samples, soft, visibility, ..plain }
            }
            Self::Mirrored => Does { soft: SoftRole::Followed, queries_shadow_buffers: true, follows: true, ..plain },
        }
    }
}
