// Boxes of 16-bit corners on a grid over the whole scene, rounded outwards: a child is one texel, half of what f32 takes.

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
