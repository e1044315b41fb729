// Storage of the boxes of a pair of nodes.

//! use fetch, lane

const LEAF: u32 = 0x80000000u;
const FIRST_SLOT: u32 = 0x0fffffffu;
const DONE: u32 = 0xffffffffu;
const NO_ENTRY: f32 = 3.402e38;

// A child's widened box, relative to the rays' origin.
struct Child {
    low: vec3f,
    high: vec3f,
    link: u32,
}

// Offsets to add to a box's corners. They make the corners relative to a point and widen the box.
struct Offsets {
    low: vec3f,
    high: vec3f,
}

// Boxes are widened by more than the rounding of slab and primitive tests. So no tie and no flat leaf is missed
// (DESIGN, section 2). The margin is small: a shadow ray begins close to its surface and would test the surface's boxes
// in vain.
fn offsets_from(origin: vec3f) -> Offsets {
    let to_grid = bvh.grid_origin - origin;
    let slack = (bvh.extent + max(max(abs(to_grid.x), abs(to_grid.y)), abs(to_grid.z))) * SCENE_SLACK;
    return Offsets(to_grid - slack, to_grid + slack);
}

// Returns the smallest t at which one of the rays enters a child's box within [t_min, t_best], or NO_ENTRY.
fn box_entry(child: Child, inverse: F3, t_min: F, t_best: F) -> f32 {
    let low_x = child.low.x * inverse.x;
    let low_y = child.low.y * inverse.y;
    let low_z = child.low.z * inverse.z;
    let high_x = child.high.x * inverse.x;
    let high_y = child.high.y * inverse.y;
    let high_z = child.high.z * inverse.z;
    let entry_xy = larger(smaller(low_x, high_x), smaller(low_y, high_y));
    let exit_xy = smaller(larger(low_x, high_x), larger(low_y, high_y));
    let entry = larger(entry_xy, larger(smaller(low_z, high_z), t_min));
    let exit = smaller(exit_xy, smaller(larger(low_z, high_z), t_best));
    return smallest(select(F(NO_ENTRY), entry, entry <= exit));
}

//! if boxes is grid
// Corners are 16-bit coordinates on a grid over the whole scene, rounded outwards. A child takes one texel, half as
// much as with f32 corners.

// Margin of all boxes, as a share of the scene's size and distance.
const SCENE_SLACK: f32 = 1.0 / 1048576.0;

// Returns one child of a pair: its link, and its widened box relative to the ray's origin.
fn child_at(place: Place, child: u32, offsets: Offsets) -> Child {
    let texel = node_texel(place, child);
    let low = vec3f(f32(texel.x & 0xffffu), f32(texel.x >> 16u), f32(texel.y & 0xffffu));
    let high = vec3f(f32(texel.y >> 16u), f32(texel.z & 0xffffu), f32(texel.z >> 16u));
    return Child(low * bvh.grid_cell + offsets.low, high * bvh.grid_cell + offsets.high, texel.w);
}

//! if boxes is f32
// Corners are f32 coordinates relative to the grid's origin. A child takes two texels.

const SCENE_SLACK: f32 = 1.0 / 1048576.0;

fn child_at(place: Place, child: u32, offsets: Offsets) -> Child {
    let low = node_texel(place, 2u * child);
    let high = node_texel(place, 2u * child + 1u);
    return Child(bitcast<vec3f>(low.xyz) + offsets.low, bitcast<vec3f>(high.xyz) + offsets.high, low.w);
}

//! if boxes is world
// Corners are f32 scene coordinates, for scenes far larger than their detail. Each box is widened in proportion to its
// own distance from the ray's origin. The other layouts widen all boxes by the same amount, which is cheaper and
// harmless for larger boxes.

const SCENE_SLACK: f32 = 0.0;
const BOX_SLACK: f32 = 1.0 / 1048576.0;

fn child_at(place: Place, child: u32, offsets: Offsets) -> Child {
    let low_texel = node_texel(place, 2u * child);
    let low = bitcast<vec3f>(low_texel.xyz) + offsets.low;
    let high = bitcast<vec3f>(node_texel(place, 2u * child + 1u).xyz) + offsets.high;
    let far = max(abs(low), abs(high));
    let slack = max(far.x, max(far.y, far.z)) * BOX_SLACK;
    return Child(low - slack, high + slack, low_texel.w);
}
