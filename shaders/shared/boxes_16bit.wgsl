// Boxes of 16-bit corners on a grid over the whole scene, rounded outwards: a child is one texel, half of what f32 takes.

const CHILD_TEXELS: u32 = 1u;

// A child's box from a ray's origin, moved outwards by the caller's slack, and its link.
fn child_at(index: u32, to_low: vec3f, to_high: vec3f) -> Child {
    let texel = node_texel(index);
    let low = vec3f(f32(texel.x & 0xffffu), f32(texel.x >> 16u), f32(texel.y & 0xffffu));
    let high = vec3f(f32(texel.y >> 16u), f32(texel.z & 0xffffu), f32(texel.z >> 16u));
    return Child(low * bvh.grid_cell + to_low, high * bvh.grid_cell + to_high, texel.w);
}
