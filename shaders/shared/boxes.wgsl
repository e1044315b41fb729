// Boxes of a pair of nodes, as they are stored.

//! if boxes is grid
// Boxes of 16-bit corners on a grid over the whole scene, rounded outwards: a child is one texel, half of what f32
// takes.

const CHILD_TEXELS: u32 = 1u;
// Share of the scene's size and distance that boxes are widened by.
const SCENE_SLACK: f32 = 1.0 / 1048576.0;

// One of a pair's children: its box from a ray's origin, widened, and its link.
fn child_at(place: Place, child: u32, offsets: Offsets) -> Child {
    let texel = node_texel(place, child);
    let low = vec3f(f32(texel.x & 0xffffu), f32(texel.x >> 16u), f32(texel.y & 0xffffu));
    let high = vec3f(f32(texel.y >> 16u), f32(texel.z & 0xffffu), f32(texel.z >> 16u));
    return Child(low * bvh.grid_cell + offsets.low, high * bvh.grid_cell + offsets.high, texel.w);
}

//! if boxes is f32
// Boxes of f32 corners, from the grid's origin: a child is two texels.

const CHILD_TEXELS: u32 = 2u;
const SCENE_SLACK: f32 = 1.0 / 1048576.0;

fn child_at(place: Place, child: u32, offsets: Offsets) -> Child {
    let low = node_texel(place, 2u * child);
    let high = node_texel(place, 2u * child + 1u);
    return Child(bitcast<vec3f>(low.xyz) + offsets.low, bitcast<vec3f>(high.xyz) + offsets.high, low.w);
}

//! if boxes is world
// Boxes of f32 corners in world coordinates, for scenes far larger than their detail: each is widened by a share of its
// own distance from the ray's origin, where the others are widened all alike. (That is cheaper, and does no harm where
// boxes are not so small.)

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
