//! Results of a render: two views, the source of each right pixel, and the cost.

use crate::{Choice, Method, PassTimes, PixelSource, Pose, ShadowBufferWork, ShadowSource, View, Work};

/// Cost of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Statistics {
    /// The method that made the pair: the requested method, or its replacement. [`Method::Ideal`] replaces it if the
    /// interaxial is 0 and views share their noise. [`Method::Auto`] is replaced by its choice. A pair rendered [in
    /// steps](Self::in_steps) has [`Method::Naive`].
    pub method: Method,
    /// Reason for the choice of [`Method::Auto`]; `None` with other methods.
    pub choice: Option<Choice>,
    /// Whether threads spread their work over several dispatches. If an adapter ends a kernel's loops early, the frame
    /// is rendered again in this way, by [`Method::Naive`]. It takes longer but gives the same pictures as
    /// [`Method::Naive`] in one dispatch.
    pub in_steps: bool,
    /// Work of the left view.
    pub left: Work,
    /// Work of the right view.
    pub right: Work,
    /// Right pixels reused from the left view.
    pub reused: u64,
    /// Right pixels that were traced because their left sample was rejected.
    pub bad: u64,
    /// Right pixels that were traced because no left sample landed there.
    pub missed: u64,
    /// `Buffer` only: number of collisions in a slot, each of which loses one candidate (DESIGN, section 2).
    pub lost_candidates: u64,
    /// `Buffer` only: slots per right pixel.
    pub buffer_depth: u32,
    /// Time of each pass in order; `None` if the adapter has no timestamps. Drivers may compile a kernel when it first
    /// runs, so time the second frame, not the first.
    pub times: Option<PassTimes>,
    /// Device memory of the buffers between the passes in bytes, without the pair's pictures.
    pub intermediate_bytes: u64,
    /// Cost of filling shadow-buffers; all zero without [`Options::shadow_buffer`](crate::Options::shadow_buffer).
    /// Neither the views' work nor the passes' times include it.
    pub shadow_buffer: ShadowBufferWork,
}

impl Statistics {
    /// Returns the share of right pixels that were traced, 0 to 1. With `Naive` it is 1, less the pixels found by a
    /// [T-buffer](crate::Visibility::TBuffer).
    pub fn retraced_share(&self) -> f64 {
        let traced = self.right.rays.primary;
        traced as f64 / (traced + self.reused).max(1) as f64
    }

    /// Returns `m`, the right view's cost relative to the left view's, by counters (DESIGN, section 7). NaN unless
    /// counting is on.
    pub fn second_eye(&self) -> f64 {
        self.right.cost() as f64 / self.left.cost() as f64
    }
}

/// A rendered stereo pair.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StereoPair {
    /// View of the left eye.
    pub left: View,
    /// View of the right eye.
    pub right: View,
    /// Source of each right pixel, row-major.
    pub source: Vec<PixelSource>,
    /// Source of each right pixel's visibility bits, row-major; empty unless made by `bracket`.
    pub shadow_source: Vec<ShadowSource>,
    /// Cost of the frame.
    pub statistics: Statistics,
    /// Camera of the frame.
    pub pose: Pose,
}

impl StereoPair {
    /// Appends the rows of another pair below these, and adds its work.
    #[cfg(feature = "dataset")]
    pub(crate) fn append(&mut self, mut below: Self) {
        self.left.append(below.left);
        self.right.append(below.right);
        self.source.append(&mut below.source);
        self.shadow_source.append(&mut below.shadow_source);
        self.statistics.left += below.statistics.left;
        self.statistics.right += below.statistics.right;
        self.statistics.reused += below.statistics.reused;
    }

    /// Returns the re-trace map as a picture, as in Adelson & Hodges 1993: green = reused, red = bad and traced again,
    /// grey = traced without reuse, blue = filled. Missed pixels are yellow; the paper shows them in red too. The
    /// result is sRGB, row-major.
    pub fn retrace_map(&self) -> Vec<[u8; 4]> {
        let color = |source: &PixelSource| match source {
            PixelSource::Reused => [0, 128, 0, 255],
            PixelSource::Bad => [224, 0, 0, 255],
            PixelSource::Missed => [240, 200, 0, 255],
            PixelSource::Traced => [128, 128, 128, 255],
            PixelSource::Filled => [0, 96, 224, 255],
        };
        self.source.iter().map(color).collect()
    }

    /// Returns a picture of the source of shadows in `bracket`: green = reused from the left view, red = traced. The
    /// result is sRGB, row-major; it is empty with other methods.
    pub fn shadow_map(&self) -> Vec<[u8; 4]> {
        let color = |source: &ShadowSource| match source {
            ShadowSource::Taken => [0, 128, 0, 255],
            ShadowSource::Traced => [224, 0, 0, 255],
        };
        self.shadow_source.iter().map(color).collect()
    }
}
