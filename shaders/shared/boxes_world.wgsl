// Boxes of f32 corners in world coordinates, for scenes far larger than their detail: each is widened by a share of its own distance
// from the ray's origin, where boxes_f32.wgsl widens all alike. (That is cheaper, and does no harm where boxes are not so small.)

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
