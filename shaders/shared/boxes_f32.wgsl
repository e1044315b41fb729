// Boxes of f32 corners, from the grid's origin: a child is two texels. Twin of boxes_16bit.wgsl.

const CHILD_TEXELS: u32 = 2u;

fn child_at(index: u32, to_low: vec3f, to_high: vec3f) -> Child {
    let low = node_texel(index);
    let high = node_texel(index + 1u);
    return Child(bitcast<vec3f>(low.xyz) + to_low, bitcast<vec3f>(high.xyz) + to_high, low.w);
}
