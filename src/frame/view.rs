//! Pictures of eyes, and how their pixels were made.

#[allow(unused_imports, reason = "documentation links to it")]
use crate::MISS;
use crate::{Options, srgb::linear_of};

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
    /// Share of light that surfaces reflect, linear RGB, averaged over the pixel's samples: diffuse reflection and
    /// highlights; 1 for glass, 0 for sky. Empty unless [`Options::albedo`](crate::Options::albedo) is set
    /// and light follows paths.
    pub albedo: Vec<[f32; 3]>,
    /// Depth `Z` along the view direction (not along the ray) in world units, `f32::INFINITY` for misses.
    pub depth: Vec<f32>,
    /// Id of the primitive that was hit, or [`MISS`].
    pub primitive: Vec<u32>,
    /// Id of the object that the primitive belongs to, or [`MISS`].
    pub object: Vec<u32>,
    /// Number of BVH nodes visited and primitives tested by all rays of the pixel. With `bracket`, a tile's query is
    /// counted at the tile's first pixel. Primitives projected into a T-buffer are not counted. Empty unless
    /// [`Options::cost_map`](crate::Options) is set.
    pub cost: Vec<u32>,
}

/// Source of a right pixel's colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u8)]
pub enum PixelSource {
    /// Reused from the left view. With `bracket`, the hit was found within the tile's bound.
    Reused = 0,
    /// Traced, since a left sample landed here but its check failed. With `bracket`, the hit lies beyond the tile's
    /// bound.
    Bad = 1,
    /// Traced, since no left sample landed here. With `bracket`, the tile has no bound, or a list overflowed.
    Missed = 2,
    /// Traced, or found by a [T-buffer](crate::Visibility::TBuffer) or by the samples of an earlier frame,
    /// independently of the left view (`Naive`).
    Traced = 3,
    /// Filled from neighbouring pixels without a ray. No method of the library does so; `examples/own_method.rs` does.
    Filled = 4,
}

/// Source of a right pixel's visibility bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u8)]
pub enum ShadowSource {
    /// Reused from the neighbouring left samples. Also used where no light is in front of the surface, or the scene has
    /// none.
    Taken = 0,
    /// At least one shadow ray was traced.
    Traced = 1,
}

impl View {
    /// Returns a view of these pixels, row-major, and nothing else.
    pub(crate) fn of_pixels(width: u32, rgba8: Vec<[u8; 4]>) -> Self {
        Self {
            width,
            height: (rgba8.len() / width.max(1) as usize) as u32,
            rgba8,
            linear: Vec::new(),
            albedo: Vec::new(),
            depth: Vec::new(),
            primitive: Vec::new(),
            object: Vec::new(),
            cost: Vec::new(),
        }
    }

    /// Appends the rows of another view below these.
    pub(crate) fn append(&mut self, mut below: Self) {
        self.height += below.height;
        self.rgba8.append(&mut below.rgba8);
        self.linear.append(&mut below.linear);
        self.albedo.append(&mut below.albedo);
        self.depth.append(&mut below.depth);
        self.primitive.append(&mut below.primitive);
        self.object.append(&mut below.object);
        self.cost.append(&mut below.cost);
    }

    /// Replaces the colours by linear light before exposure, row-major. The alpha is 1.
    pub(crate) fn show_linear(&mut self, colors: impl Iterator<Item = [f32; 3]>, options: &Options) {
        let exposure = options.exposure.exp2();
        self.linear = colors.map(|[red, green, blue]| [red, green, blue, 1.0]).collect();
        let shown = |&[red, green, blue, _]: &[f32; 4]| options.tone.rgba8([red, green, blue], exposure);
        self.rgba8 = self.linear.iter().map(shown).collect();
    }

    /// Returns the displayed picture as linear RGB and alpha, 0 to 1, decoded from [`View::rgba8`].
    pub fn light(&self) -> Vec<[f32; 4]> {
        let decoded = |&[red, green, blue, alpha]: &[u8; 4]| {
            let [red, green, blue] = [red, green, blue].map(linear_of);
            [red, green, blue, f32::from(alpha) / 255.0]
        };
        self.rgba8.iter().map(decoded).collect()
    }

    /// Returns the nearest and the farthest depth. The farthest depth is infinite if any ray missed. Both are infinite
    /// if all rays missed.
    pub fn depth_range(&self) -> (f32, f32) {
        let fold = |(near, far): (f32, f32), &z: &f32| (near.min(z), far.max(z));
        self.depth.iter().fold((f32::INFINITY, 0.0), fold)
    }
}
