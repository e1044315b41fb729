// Boxes of f32 corners, from the grid's origin: a child is two texels. Twin of boxes_16bit.wgsl.

const CHILD_TEXELS: u32 = 2u;
const SCENE_SLACK: f32 = 1.0 / 1048576.0;

fn child_at(place: Place, child: u32, offsets: Offsets) -> Child {
    let low = node_texel(place, 2u * child);
    let high = node_texel(place, 2u * child + 1u);
    return Child(bitcast<vec3f>(low.xyz) + offsets.low, bitcast<vec3f>(high.xyz) + offsets.high, low.w);
}
