// How the boxes of a pair of nodes are stored.

//! if boxes is grid
// 16-bit corners on a grid over the whole scene, rounded outwards. A child takes one texel, half as much as with f32
// corners.

const CHILD_TEXELS: u32 = 1u;
// Boxes are widened by this share of the scene's size and distance.
const SCENE_SLACK: f32 = 1.0 / 1048576.0;

// Returns one child of a pair: its link, and its widened box relative to the ray's origin.
fn child_at(place: Place, child: u32, offsets: Offsets) -> Child {
    let texel = node_texel(place, child);
    let low = vec3f(f32(texel.x & 0xffffu), f32(texel.x >> 16u), f32(texel.y & 0xffffu));
    let high = vec3f(f32(texel.y >> 16u), f32(texel.z & 0xffffu), f32(texel.z >> 16u));
    return Child(low * bvh.grid_cell + offsets.low, high * bvh.grid_cell + offsets.high, texel.w);
}

//! if boxes is f32
// f32 corners relative to the grid's origin. A child takes two texels.

const CHILD_TEXELS: u32 = 2u;
const SCENE_SLACK: f32 = 1.0 / 1048576.0;

fn child_at(place: Place, child: u32, offsets: Offsets) -> Child {
    let low = node_texel(place, 2u * child);
    let high = node_texel(place, 2u * child + 1u);
    return Child(bitcast<vec3f>(low.xyz) + offsets.low, bitcast<vec3f>(high.xyz) + offsets.high, low.w);
}

//! if boxes is world
// f32 corners in scene coordinates, for scenes far larger than their detail. Each box is widened by a share of its own
// distance from the ray's origin. The other layouts widen all boxes alike, which is cheaper and harmless for larger
// boxes.

const CHILD_TEXELS: u32 = 2u;
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
