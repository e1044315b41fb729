//! The cost of a frame's views, band by band, and how they were made.

use crate::{
    Choice, Method, Pose, Rays, ShadowReuse, Work,
    frame::{plan::Made, read::Counts},
    methods::auto::{CostModel, Seen},
};

/// The tally of one view.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) work: Work,
    /// Pixels reused from the view's source.
    pub(crate) reused: u64,
    pub(crate) bad: u64,
    pub(crate) missed: u64,
    pub(crate) lost_candidates: u64,
    /// Shadow rays from mirrored surfaces.
    own_shadow_rays: u64,
    /// Pixels in gaps, if they were counted.
    gaps: u64,
    /// Pixels rendered by `bracket`.
    bracketed: u64,
    pixels: u64,
}

impl Tally {
    /// Adds a band of this many pixels, given how it was made.
    pub(crate) fn add(&mut self, counts: &Counts, pixels: u64, made: Made) {
        let landed = pixels - counts.missed;
        let (primary, verification, reused) = match made {
            Made::Traced | Made::Chosen => (pixels, 0, 0),
            // In a band drawn by T-buffer, `missed` counts the pixels that were traced nevertheless.
            Made::Drawn => (counts.missed, 0, 0),
            Made::Copied => (0, 0, pixels),
            Made::Marked { checked } => {
                (counts.bad + counts.missed, if checked { landed } else { 0 }, landed - counts.bad)
            }
            Made::Recalled => (counts.bad + counts.missed, 0, 0),
            Made::Bracketed => (counts.bad + counts.missed, 0, landed - counts.bad),
        };
        let rays = Rays { primary, verification, shadow: counts.shadow_rays, secondary: counts.sent_rays };
        self.work += Work { rays, nodes: counts.nodes, primitive_tests: counts.primitive_tests };
        self.reused += reused;
        let is_target = !matches!(made, Made::Drawn | Made::Recalled);
        self.bad += if is_target { counts.bad } else { 0 };
        self.missed += if is_target { counts.missed } else { 0 };
        self.lost_candidates += counts.lost_candidates;
        self.own_shadow_rays += counts.own_shadow_rays;
        self.gaps += counts.gaps;
        self.bracketed += if made == Made::Bracketed { pixels } else { 0 };
        self.pixels += pixels;
    }

    /// Returns the number of shadow rays per pixel that a traced view asked for, including recalled ones.
    pub(crate) fn asked(&self, model: CostModel) -> f32 {
        let own = self.own_shadow_rays.min(self.work.rays.shadow);
        model.asked.max((self.work.rays.shadow - own) as f32 / self.pixels.max(1) as f32)
    }

    /// Returns what the source view asked for, and the gaps of this view.
    pub(crate) fn seen(&self, source: &Self) -> Seen {
        let Rays { shadow: shadow_rays, secondary: secondary_rays, .. } = source.work.rays;
        let (own_shadow_rays, gap_pixels) = (source.own_shadow_rays, self.gaps);
        Seen { shadow_rays, own_shadow_rays, secondary_rays, gap_pixels }
    }

    /// Returns the choice of `Auto` that applied to most pixels of a view. The model's prediction in the result is for
    /// the whole view.
    pub(crate) fn choice(&self, source: &Self, model: CostModel, pose: &Pose) -> Choice {
        let predicted = model.choose(pose.size, self.seen(source));
        let mostly = 2 * self.bracketed >= self.pixels;
        let method = if mostly { Method::Bracket(ShadowReuse::Two) } else { Method::Naive };
        let by_bracket = self.bracketed as f32 / self.pixels.max(1) as f32;
        Choice { method, by_bracket, ..predicted }
    }
}
