//! Structs and numbers shared with WGSL, under the same names. A test compares them by reflection.

use bytemuck::{Pod, Zeroable};

use crate::{MAX_BOUNCES, MAX_PATH_BOUNCES};

/// `Eyes` of shaders/shared/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Eyes {
    pub(crate) source_eye: [f32; 3],
    pub(crate) parallax_px: f32,
    pub(crate) target_eye: [f32; 3],
    pub(crate) parallax_distance: f32,
    pub(crate) source_corner: [f32; 3],
    pub(crate) shift: f32,
    pub(crate) target_corner: [f32; 3],
    pub(crate) same_parallax: f32,
    pub(crate) step_x: [f32; 3],
    pub(crate) longest: f32,
    pub(crate) step_y: [f32; 3],
    pub(crate) wider: f32,
    pub(crate) right_axis: [f32; 3],
    pub(crate) at_infinity: f32,
    pub(crate) forward: [f32; 3],
    pub(crate) pixel_side: f32,
    pub(crate) second_parallax_px: f32,
    pub(crate) second_same_parallax: f32,
    pub(crate) _pad: [u32; 2],
}

/// `Eyes` of shaders/shared/frame.wgsl for cameras with a viewing circle.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct CircleEyes {
    pub(crate) centre: [f32; 3],
    pub(crate) target_radius: f32,
    pub(crate) right_axis: [f32; 3],
    pub(crate) most_elevation: f32,
    pub(crate) up_axis: [f32; 3],
    pub(crate) column_step: f32,
    pub(crate) forward: [f32; 3],
    pub(crate) row_step: f32,
    pub(crate) middle: [f32; 2],
    pub(crate) merge: [f32; 2],
    pub(crate) wider: f32,
    pub(crate) turn: u32,
    pub(crate) wraps: u32,
    pub(crate) spare: u32,
    pub(crate) _pad: [u32; 12],
}

/// `Eyes` of shaders/shared/frame.wgsl for an eye with a lens.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct LensEyes {
    pub(crate) target_eye: [f32; 3],
    pub(crate) focal_x: f32,
    pub(crate) target_corner: [f32; 3],
    pub(crate) focal_y: f32,
    pub(crate) step_x: [f32; 3],
    pub(crate) principal_x: f32,
    pub(crate) step_y: [f32; 3],
    pub(crate) principal_y: f32,
    pub(crate) radial: [f32; 4],
    pub(crate) divisor: [f32; 4],
    pub(crate) tangential: [f32; 2],
    pub(crate) spare: [f32; 2],
    pub(crate) _pad: [f32; 8],
}

/// `Band` of shaders/shared/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Band {
    pub(crate) size: [u32; 2],
    pub(crate) row_begin: u32,
    pub(crate) row_end: u32,
    pub(crate) first_row: u32,
    pub(crate) runs: u32,
    pub(crate) buffer_depth: u32,
    pub(crate) jitter_seed: u32,
}

/// `Lighting` of shaders/shared/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Lighting {
    pub(crate) light: u32,
    pub(crate) slot: u32,
    pub(crate) first_ray: u32,
    pub(crate) sources: u32,
    pub(crate) seed: u32,
    pub(crate) occlusion_radius: f32,
    pub(crate) share_tolerance: f32,
    pub(crate) bounces: u32,
}

/// `Display` of shaders/shared/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Display {
    pub(crate) exposure: f32,
    pub(crate) filmic: u32,
    pub(crate) words_read: u32,
    pub(crate) filter_kind: u32,
}

/// `Costs` of shaders/shared/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Costs {
    pub(crate) least_spared: f32,
    pub(crate) listed: f32,
    pub(crate) disagreed: f32,
    pub(crate) asked: f32,
}

/// `PathRay` of shaders/shared/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct PathRay {
    pub(crate) ray: u32,
    pub(crate) bounces: u32,
    pub(crate) first: u32,
    pub(crate) tolerance: f32,
}

/// `Frame` of shaders/shared/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Frame {
    pub(crate) eyes: Eyes,
    pub(crate) band: Band,
    pub(crate) lighting: Lighting,
    pub(crate) display: Display,
    pub(crate) costs: Costs,
    pub(crate) paths: PathRay,
}

/// `Frame` of shaders/shared/frame.wgsl for a light's shadow-buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct TableFrame {
    pub(crate) mapping: Mapping,
    pub(crate) band: Band,
}

/// `Bvh` of shaders/shared/fetch.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Bvh {
    pub(crate) grid_origin: [f32; 3],
    pub(crate) extent: f32,
    pub(crate) grid_cell: [f32; 3],
    pub(crate) zero: u32,
    pub(crate) cutouts: u32,
    pub(crate) parents: u32,
    pub(crate) _pad: [u32; 2],
}

/// `Pixel` of shaders/shared/pixels.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Pixel {
    pub(crate) depth: f32,
    pub(crate) slot: u32,
    pub(crate) marks: u32,
    pub(crate) color: u32,
}

/// `Path` of shaders/shared/paths.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Path {
    pub(crate) origin: [f32; 3],
    pub(crate) travelled: f32,
    pub(crate) direction: [f32; 3],
    pub(crate) density: f32,
    pub(crate) weight: [f32; 3],
    pub(crate) is_diffuse: u32,
    pub(crate) entries: [u32; 2],
    pub(crate) t: f32,
    pub(crate) slot: u32,
}

/// `LightRay` of shaders/shared/emitters.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct LightRay {
    pub(crate) direction: [f32; 3],
    pub(crate) far: f32,
    pub(crate) scale: [f32; 3],
    pub(crate) diffuse: f32,
    pub(crate) glossy: [f32; 3],
    pub(crate) _pad: u32,
}

/// `Proposed` of shaders/shared/proposed.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Proposed {
    pub(crate) start: [f32; 3],
    pub(crate) is_open: u32,
    pub(crate) emitted: [f32; 3],
    pub(crate) travelled: f32,
    pub(crate) weight: [f32; 3],
    pub(crate) is_diffuse: u32,
    pub(crate) albedo: [f32; 3],
    pub(crate) _pad: u32,
    pub(crate) rays: [LightRay; 3],
}

/// `Brought` of shaders/shared/paths.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Brought {
    pub(crate) diffuse: [f32; 3],
    pub(crate) paths: u32,
    pub(crate) glossy: [f32; 3],
    pub(crate) marks: u32,
    pub(crate) squares: [f32; 2],
    pub(crate) newest: [f32; 2],
}

/// `SentRay` of shaders/shared/bounced.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct SentRay {
    pub(crate) origin: [f32; 3],
    pub(crate) travelled: f32,
    pub(crate) direction: [f32; 3],
    pub(crate) depth: u32,
    pub(crate) weight: [f32; 3],
    pub(crate) t: f32,
}

/// `BouncedPixel` of shaders/shared/bounced.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct BouncedPixel {
    pub(crate) color: [f32; 3],
    pub(crate) waiting: u32,
    pub(crate) diffuse: [f32; 3],
    pub(crate) slot: u32,
    pub(crate) shine: [f32; 3],
    pub(crate) sent: u32,
    pub(crate) entries: [u32; 2],
    pub(crate) _pad: [u32; 2],
    pub(crate) rays: [SentRay; MAX_BOUNCES as usize + 1],
}

/// `LightParts` of `shaders/shared/light_parts.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct LightParts {
    pub(crate) diffuse: [f32; 3],
    pub(crate) diffuse_variance: f32,
    pub(crate) glossy: [f32; 3],
    pub(crate) glossy_variance: f32,
    pub(crate) albedo: [f32; 3],
    pub(crate) normal: u32,
    pub(crate) rest: [f32; 3],
    pub(crate) point_x: f32,
    pub(crate) point_y: f32,
    pub(crate) point_z: f32,
    pub(crate) coverage: f32,
    pub(crate) lobe_width: f32,
    pub(crate) reflectance: [f32; 3],
    pub(crate) _pad: u32,
}

/// Octahedral normal of a pixel that shows no surface.
pub(crate) const NO_NORMAL: u32 = 0x8000_8000;
/// Variance of light of a kind that a surface does not reflect.
pub(crate) const NO_LIGHT: f32 = -1.0;

/// `Noisy` of shaders/shared/noisy.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Noisy {
    pub(crate) diffuse: [f32; 3],
    pub(crate) diffuse_variance: f32,
    pub(crate) glossy: [f32; 3],
    pub(crate) glossy_variance: f32,
}

/// `Guide` of shaders/shared/noisy.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Guide {
    pub(crate) point: [f32; 3],
    pub(crate) normal: u32,
    pub(crate) lobe_width: f32,
    pub(crate) _pad: [u32; 3],
}

/// `Mapping` of shaders/shared/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Mapping {
    pub(crate) light: [f32; 3],
    pub(crate) theta_begin: f32,
    pub(crate) axis_x: [f32; 3],
    pub(crate) theta_step: f32,
    pub(crate) axis_y: [f32; 3],
    pub(crate) phi_begin: f32,
    pub(crate) axis_z: [f32; 3],
    pub(crate) phi_step: f32,
    pub(crate) columns: u32,
    pub(crate) margin: f32,
    pub(crate) _pad: [u32; 2],
}

/// Head of an empty list (`shaders/shared/lists.wgsl`): arguments of an indirect dispatch of no workgroups, and a count
/// of 0.
pub(crate) const EMPTY_LIST: [u32; 4] = [0, 1, 1, 0];
/// Number of lists in `Lists`, and their indices.
pub(crate) const LISTS: usize = 4;
pub(crate) const TO_TRACE: u32 = 0;
pub(crate) const TO_LIGHT: u32 = 1;
pub(crate) const TO_RESOLVE: u32 = 2;
pub(crate) const SKY: u32 = 3;
/// Number of heads. Two of them belong to dispatches that the kernel `choose` enables or disables as a whole.
pub(crate) const HEADS: usize = LISTS + 2;
pub(crate) const TO_SEARCH: u32 = 4;
pub(crate) const ALL_TRACED: u32 = 5;
/// Offset of the entries in `Lists`, in bytes.
pub(crate) const LISTS_HEADS: u64 = (HEADS * size_of::<[u32; 4]>()) as u64;

/// Number of lists of paths, one for each vertex or ray of a path (`shaders/shared/paths.wgsl`).
pub(crate) const PATH_HEADS: usize = MAX_PATH_BOUNCES as usize + 2;
/// Offset of the paths in `Paths`, in bytes.
pub(crate) const PATHS_HEADS: u64 = (PATH_HEADS * size_of::<[u32; 4]>()) as u64;

/// Maximum number of rounds of secondary rays after the one that shades first hits, and of lists of their pixels
/// (`shaders/shared/bounced.wgsl`).
pub(crate) const BOUNCED_ROUNDS: u32 = 2 * MAX_BOUNCES;
pub(crate) const BOUNCED_LISTS: usize = BOUNCED_ROUNDS as usize + 2;
/// Offset of the pixels in `Bounced`, in bytes.
pub(crate) const BOUNCED_HEADS: u64 = (BOUNCED_LISTS * size_of::<[u32; 4]>()) as u64;

/// Number of threads of a workgroup in x and in y (`shaders/shared/pixels.wgsl`).
pub(crate) const WORKGROUP: u32 = 8;
/// Number of threads of a workgroup in a dispatch over a list (`shaders/shared/pixels.wgsl`).
pub(crate) const LIST_WORKGROUP: u32 = 64;

/// Side of a tile, in pixels (`shaders/shared/tiles.wgsl`).
pub(crate) const TILE: u32 = 8;
/// Side, in samples, of the square that `search_wide_tiles` searches at once, if there are several samples per pixel
/// (`shaders/shared/search.wgsl`).
pub(crate) const WIDE_TILE: u32 = 16;
/// Number of pixels of a row that a thread of `mark_busy` tests (`shaders/shared/tiles.wgsl`).
pub(crate) const BUSY_RUN: u32 = 16;
/// Distance between the samples of a quad in pixels, and the number of quads per thread of `bound_by_history`.
pub(crate) const QUAD: u32 = 2;
pub(crate) const QUAD_RUN: u32 = 4;
/// Number of pixels of a tile.
pub(crate) const TILE_PIXELS: u32 = TILE * TILE;
/// Number of words per tile for its bound and its busy lights (`shaders/shared/tiles.wgsl`).
pub(crate) const BOUND_WORDS: u32 = 2;
/// Number of words per tile for its search results (`shaders/shared/lists.wgsl`).
pub(crate) const TILE_WORDS: u32 = 642;

/// Number of counters per picture row of a view, and their indices (shaders/shared/counters.wgsl).
pub(crate) const COUNTERS: usize = 13;
pub(crate) const SHADOW_RAYS: usize = 0;
pub(crate) const NODES_VISITED: usize = 1;
pub(crate) const PRIMITIVES_TESTED: usize = 2;
pub(crate) const BAD_PIXELS: usize = 3;
pub(crate) const MISSED_PIXELS: usize = 4;
pub(crate) const LOST_CANDIDATES: usize = 5;
pub(crate) const NEAREST_DEPTH: usize = 6;
pub(crate) const FARTHEST_DEPTH: usize = 7;
pub(crate) const CUT_SHORT: usize = 8;
pub(crate) const GAP_PIXELS: usize = 9;
pub(crate) const CHOSEN: usize = 10;
pub(crate) const SENT_RAYS: usize = 11;
pub(crate) const OWN_SHADOW_RAYS: usize = 12;
/// Value of `CHOSEN` in a band's first row if `choose` predicts that `bracket` is cheaper.
pub(crate) const BRACKET_CHOSEN: u32 = 1;

/// Marks of pixels (`shaders/shared/marks.wgsl`).
pub(crate) const BAD: u32 = 0x4000_0000;
pub(crate) const MISSED: u32 = 0x8000_0000;
pub(crate) const ASKED: u32 = 0x2000_0000;
/// Bits of the colour in a packed pixel. Marks replace the alpha (`shaders/show/pack.wgsl`).
pub(crate) const PACKED_COLOR: u32 = 0x00ff_ffff;

/// A triangle counts as large for a point if the point's distance to its plane is less than its longest edge divided by
/// `LARGE`. The kernels have the same constant.
pub(crate) const LARGE: f32 = 64.0;

/// Maximum slope of a surface for a sample and a neighbouring point to count as connected. The slope is depth per
/// width, in pixels of their size on the screen. It corresponds to an angle of 88.4 degrees at the screen, a larger
/// angle in front of it, and a smaller one beyond it.
pub(crate) const STEEPEST: f32 = 36.0;

/// Largest difference of parallaxes between a sample and a point of its surface, in pixels.
pub(crate) const MOST_PARALLAX: f32 = 0.75;

/// Minimum depth of a groove, as a share of the tolerated difference of parallax or depth. It is 1/128 pixel for a
/// tolerance of 0.75 pixels.
pub(crate) const GROOVE: f32 = 1.0 / 96.0;
