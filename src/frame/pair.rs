//! Results of a render: two views, the source of each right pixel, and the cost.

use std::{sync::LazyLock, time::Duration};

use crate::{Choice, Method, Pose, ShadowBufferWork};

/// Primitive or object id where nothing was hit.
pub const MISS: u32 = u32::MAX;

/// View of one eye. All lists are row-major, `[height][width]`, top row first.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct View {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Picture, sRGB-encoded, alpha 255.
    pub rgba8: Vec<[u8; 4]>,
    /// Linear RGB radiance before [`Options::exposure`](crate::Options::exposure), unclamped, alpha 1. Empty unless
    /// [`Options::linear`](crate::Options::linear) is set.
    pub linear: Vec<[f32; 4]>,
    /// Depth `Z` along the view direction (not along the ray) in world units, `f32::INFINITY` for misses.
    pub depth: Vec<f32>,
    /// Id of the primitive that was hit, or [`MISS`].
    pub primitive: Vec<u32>,
    /// Id of the object that the primitive belongs to, or [`MISS`].
    pub object: Vec<u32>,
    /// BVH nodes visited and primitives tested by all rays of the pixel. With `bracket`, a tile's query counts for the
    /// tile's first pixel. Primitives projected into a T-buffer are not counted. Empty unless
    /// [`Options::cost_map`](crate::Options) is set.
    pub cost: Vec<u32>,
}

/// Source of a right pixel's colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u8)]
pub enum PixelSource {
    /// Reused from the left view. With `bracket`: found within the tile's bound.
    Reused = 0,
    /// Traced: a left sample landed here, but its check failed. With `bracket`: the hit lies beyond the tile's bound.
    Bad = 1,
    /// Traced: no left sample landed here. With `bracket`: or the list overflowed.
    Missed = 2,
    /// Traced, or found by a [T-buffer](crate::Visibility::TBuffer), independently of the left view (`Naive`).
    Traced = 3,
}

/// Source of a right pixel's visibility bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u8)]
pub enum ShadowSource {
    /// Reused from the left samples beside it. Also where no light is in front of the surface, or the scene has none.
    Taken = 0,
    /// At least one shadow ray.
    Traced = 1,
}

/// Rays of one view by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Rays {
    /// Closest-hit rays through pixels. With a [T-buffer](crate::Visibility::TBuffer), only the rays still traced.
    pub primary: u64,
    /// Length-limited any-hit rays that check reused pixels.
    pub verification: u64,
    /// Any-hit rays towards lights.
    pub shadow: u64,
    /// Closest-hit rays reflected, refracted or passed on by mirrors, glass and transparent surfaces.
    pub secondary: u64,
}

impl Rays {
    /// Returns the sum of all kinds.
    pub fn total(&self) -> u64 {
        self.primary + self.verification + self.shadow + self.secondary
    }
}

impl std::ops::AddAssign for Rays {
    fn add_assign(&mut self, other: Self) {
        let Self { primary, verification, shadow, secondary } = other;
        self.primary += primary;
        self.verification += verification;
        self.shadow += shadow;
        self.secondary += secondary;
    }
}

/// Work of one view, in counts that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Work {
    /// Rays by kind.
    pub rays: Rays,
    /// BVH nodes visited (a node holds the boxes of two children), and primitives projected into a
    /// [T-buffer](crate::Visibility::TBuffer). 0 unless counting is on.
    pub nodes: u64,
    /// Primitives tested; 0 unless counting is on.
    pub primitive_tests: u64,
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        let Self { rays, nodes, primitive_tests } = other;
        self.rays += rays;
        self.nodes += nodes;
        self.primitive_tests += primitive_tests;
    }
}

impl Work {
    /// Returns box tests (two per node) plus primitive tests.
    pub fn cost(&self) -> u64 {
        2 * self.nodes + self.primitive_tests
    }
}

/// Time of each pass on the device, from timestamp queries.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PassTimes {
    /// Name and time of each pass, in order.
    pub passes: Vec<(&'static str, Duration)>,
}

impl PassTimes {
    /// Returns the sum of all passes.
    pub fn total(&self) -> Duration {
        self.passes.iter().map(|(_, time)| *time).sum()
    }
}

/// Cost of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Statistics {
    /// The method that made the pair: the requested one, [`Method::Ideal`] if the interaxial is 0 and views share their
    /// noise, the choice of [`Method::Auto`], or [`Method::Naive`] if rendered [in steps](Self::in_steps).
    pub method: Method,
    /// Reason for the choice of [`Method::Auto`]; `None` with other methods.
    pub choice: Option<Choice>,
    /// Whether threads spread their work over several dispatches. If an adapter ends a kernel's loops early, the frame
    /// is rendered again in this way, by [`Method::Naive`]. It takes longer and shows the same.
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
    /// `Buffer` only: candidates that met a taken slot, each of which loses one candidate (DESIGN, section 2).
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
    /// Returns the share of right pixels that were traced, 0 to 1. With `Naive` that is 1, less the pixels found by a
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

/// Linear values of the 256 sRGB bytes.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let encoded = byte as f64 / 255.0;
        let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
});

/// Returns the linear value, 0 to 1, of an 8-bit sRGB channel.
pub(crate) fn linear_of(byte: u8) -> f32 {
    LINEAR[usize::from(byte)]
}

impl View {
    /// Returns the displayed picture as linear RGB and alpha, 0 to 1, decoded from [`View::rgba8`].
    pub fn light(&self) -> Vec<[f32; 4]> {
        let decoded = |&[red, green, blue, alpha]: &[u8; 4]| {
            let [red, green, blue] = [red, green, blue].map(linear_of);
            [red, green, blue, f32::from(alpha) / 255.0]
        };
        self.rgba8.iter().map(decoded).collect()
    }

    /// Returns the nearest and the farthest depth. The farthest is infinite if any ray missed, both if all did.
    pub fn depth_range(&self) -> (f32, f32) {
        let fold = |(near, far): (f32, f32), &z: &f32| (near.min(z), far.max(z));
        self.depth.iter().fold((f32::INFINITY, 0.0), fold)
    }
}

impl StereoPair {
    /// Returns the re-trace map as a picture, as in Adelson & Hodges 1993: green = reused, red = bad, traced again,
    /// grey = traced without reuse. Missed pixels are yellow; the paper leaves them red too. sRGB, row-major.
    pub fn retrace_map(&self) -> Vec<[u8; 4]> {
        let color = |source: &PixelSource| match source {
            PixelSource::Reused => [0, 128, 0, 255],
            PixelSource::Bad => [224, 0, 0, 255],
            PixelSource::Missed => [240, 200, 0, 255],
            PixelSource::Traced => [128, 128, 128, 255],
        };
        self.source.iter().map(color).collect()
    }

    /// Returns a picture of how `bracket` got shadows: green = reused from the left view, red = traced. sRGB,
    /// row-major; empty by other methods.
    pub fn shadow_map(&self) -> Vec<[u8; 4]> {
        let color = |source: &ShadowSource| match source {
            ShadowSource::Taken => [0, 128, 0, 255],
            ShadowSource::Traced => [224, 0, 0, 255],
        };
        self.shadow_source.iter().map(color).collect()
    }
}
