//! What a render returns: two views, where each right pixel came from, and what it cost.

use std::{sync::LazyLock, time::Duration};

use crate::{Choice, Method, Pose, ShadowBufferWork};

/// Primitive or object id where nothing was hit.
pub const MISS: u32 = u32::MAX;

/// What one eye sees. All lists are row-major, `[height][width]`, top row first.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct View {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The picture, sRGB-encoded, alpha 255.
    pub rgba8: Vec<[u8; 4]>,
    /// Light as it comes, linear RGB, before [`Options::exposure`](crate::Options::exposure) and as bright as it is,
    /// alpha 1; empty unless [`Options::linear`](crate::Options::linear) asked for it.
    pub linear: Vec<[f32; 4]>,
    /// Depth `Z` along the view direction (not along the ray) in world units, `f32::INFINITY` where nothing was hit.
    pub depth: Vec<f32>,
    /// Id of the primitive that was hit, or [`MISS`].
    pub primitive: Vec<u32>,
    /// Id of the object it belongs to, or [`MISS`].
    pub object: Vec<u32>,
    /// BVH nodes visited and primitives tested for this pixel, all its rays (the query of a tile, by `bracket`, counts
    /// for the tile's first pixel; what a T-buffer projects counts for none); empty unless
    /// [`Options::cost_map`](crate::Options) asked for it.
    pub cost: Vec<u32>,
}

/// Where a right pixel's colour came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u8)]
pub enum PixelSource {
    /// Taken over from the left view; by `bracket` found no deeper than the left samples that land in its tile.
    Reused = 0,
    /// A left sample landed here, but something was found before it; by `bracket` the hit lies deeper: traced.
    Bad = 1,
    /// No left sample landed here; by `bracket` a list was too short, too: traced.
    Missed = 2,
    /// Traced, or found by a [T-buffer](crate::Visibility::TBuffer), without looking at the left view (`Naive`).
    Traced = 3,
}

/// How it is known which lights a right pixel sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u8)]
pub enum ShadowSource {
    /// As the left samples beside it say; or no light is in front of the surface, or there is none.
    Taken = 0,
    /// By shadow rays, at least one.
    Traced = 1,
}

/// Rays of one view by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Rays {
    /// Closest-hit rays through pixels; of a view whose first hits come from a [T-buffer](crate::Visibility::TBuffer)
    /// those that were traced after all.
    pub primary: u64,
    /// Length-limited any-hit rays that check reused pixels.
    pub verification: u64,
    /// Any-hit rays towards lights.
    pub shadow: u64,
    /// Closest-hit rays that mirrors, glass and veils send on.
    pub secondary: u64,
}

impl Rays {
    /// All kinds together.
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

/// What one view cost, in counts that no machine changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Work {
    /// Rays by kind.
    pub rays: Rays,
    /// BVH nodes visited (a node holds the boxes of two children), and primitives that were projected for a
    /// [T-buffer](crate::Visibility::TBuffer); 0 unless counting was asked for.
    pub nodes: u64,
    /// Primitives tested; 0 unless counting was asked for.
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
    /// Box tests (two a node) plus primitive tests.
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
    /// All passes together.
    pub fn total(&self) -> Duration {
        self.passes.iter().map(|(_, time)| *time).sum()
    }
}

/// What a frame cost.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Statistics {
    /// The method that made the pair: the one asked for, [`Method::Ideal`] without interaxial, what [`Method::Auto`]
    /// chose, [`Method::Naive`] [in steps](Self::in_steps).
    pub method: Method,
    /// Why [`Method::Auto`] chose it; `None` by other methods.
    pub choice: Option<Choice>,
    /// Whether threads left work to further dispatches: where an adapter ends their loops before that is done, a frame
    /// is rendered again, by [`Method::Naive`] in steps. It takes longer and shows the same.
    pub in_steps: bool,
    /// The left view's work.
    pub left: Work,
    /// The right view's work.
    pub right: Work,
    /// Right pixels taken over from the left view.
    pub reused: u64,
    /// Right pixels whose left sample was rejected; traced.
    pub bad: u64,
    /// Right pixels without a left sample; traced.
    pub missed: u64,
    /// `Buffer` only: candidates that met a taken slot, so that one of the two is lost (DESIGN, section 2).
    pub lost_candidates: u64,
    /// `Buffer` only: slots a right pixel.
    pub buffer_depth: u32,
    /// Time of each pass in order; `None` where the adapter has no timestamps. Drivers may compile a kernel when it
    /// first runs: time the second frame, not the first.
    pub times: Option<PassTimes>,
    /// Device memory of the buffers between the passes in bytes, without the pair's own pictures.
    pub intermediate_bytes: u64,
    /// What filling shadow-buffers cost, all zeros where none are asked
    /// ([`Options::shadow_buffer`](crate::Options::shadow_buffer)). It is in no view's work, and its time in none
    /// of the passes'.
    pub shadow_buffer: ShadowBufferWork,
}

impl Statistics {
    /// Share of the right pixels that were traced, 0 to 1; all of them by `Naive`, but for those that a
    /// [T-buffer](crate::Visibility::TBuffer) found.
    pub fn retraced_share(&self) -> f64 {
        let traced = self.right.rays.primary;
        traced as f64 / (traced + self.reused).max(1) as f64
    }

    /// `m`, the right view's cost relative to the left view's, by counters (DESIGN, section 7). NaN unless counting was
    /// asked for.
    pub fn second_eye(&self) -> f64 {
        self.right.cost() as f64 / self.left.cost() as f64
    }
}

/// A rendered stereo pair.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StereoPair {
    /// What the left eye sees.
    pub left: View,
    /// What the right eye sees.
    pub right: View,
    /// Where each right pixel came from, row-major.
    pub source: Vec<PixelSource>,
    /// How it is known which lights each right pixel sees, row-major; by `bracket` only, else empty.
    pub shadow_source: Vec<ShadowSource>,
    /// What it cost.
    pub statistics: Statistics,
    /// The camera it was rendered with.
    pub pose: Pose,
}

/// Linear values of 8-bit sRGB ones.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let encoded = byte as f64 / 255.0;
        let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
});

/// Linear light of a channel of an 8-bit sRGB picture, 0 to 1.
pub(crate) fn linear_of(byte: u8) -> f32 {
    LINEAR[usize::from(byte)]
}

impl View {
    /// The picture as it is shown, as linear RGB and alpha, 0 to 1: decoded from [`View::rgba8`].
    pub fn light(&self) -> Vec<[f32; 4]> {
        let decoded = |&[red, green, blue, alpha]: &[u8; 4]| {
            let [red, green, blue] = [red, green, blue].map(linear_of);
            [red, green, blue, f32::from(alpha) / 255.0]
        };
        self.rgba8.iter().map(decoded).collect()
    }

    /// Nearest and farthest depth; the farthest is infinite where there is sky, both where there is nothing else.
    pub fn depth_range(&self) -> (f32, f32) {
        let fold = |(near, far): (f32, f32), &z: &f32| (near.min(z), far.max(z));
        self.depth.iter().fold((f32::INFINITY, 0.0), fold)
    }
}

impl StereoPair {
    /// The re-trace map as a picture, as Adelson & Hodges 1993 show it: green = reused, red = bad, traced again;
    /// missed pixels, which they leave red too, are yellow; grey = traced without reuse. sRGB, row-major.
    pub fn retrace_map(&self) -> Vec<[u8; 4]> {
        let color = |source: &PixelSource| match source {
            PixelSource::Reused => [0, 128, 0, 255],
            PixelSource::Bad => [224, 0, 0, 255],
            PixelSource::Missed => [240, 200, 0, 255],
            PixelSource::Traced => [128, 128, 128, 255],
        };
        self.source.iter().map(color).collect()
    }

    /// Where `bracket` got right pixels' shadows as a picture: green = taken over from the left view, red = traced.
    /// sRGB, row-major; empty by other methods.
    pub fn shadow_map(&self) -> Vec<[u8; 4]> {
        let color = |source: &ShadowSource| match source {
            ShadowSource::Taken => [0, 128, 0, 255],
            ShadowSource::Traced => [224, 0, 0, 255],
        };
        self.shadow_source.iter().map(color).collect()
    }
}
