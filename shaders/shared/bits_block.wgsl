// `block`: the left samples on both sides of the point, in its row and in those above and below. One of another primitive whose
// normal has turned away vouches for nothing.

// Least cosine between the normals of primitives that may share a shadow.
const SAME_NORMAL: f32 = 0.9;

fn agreed_bits(first: vec2u, way: f32, point_parallax: f32, component: u32, normal: vec3f, slot: u32) -> u32 {
    if first.y == 0u || first.y + 1u >= frame.image_size.y { return 0u; }
    var row = first.y - 1u;
    var bits: u32;
    loop {
        let before = smooth_bits(source_sample(vec2u(first.x, row)), point_parallax, component, normal, slot);
        let after = smooth_bits(source_sample(vec2u(first.x + 1u, row)), point_parallax, component, normal, slot);
        let pair = agreeing(before, after);
        bits = select(agreeing(bits, pair), pair, row + 1u == first.y);
        row += 1u;
        if row > first.y + 1u { break; }
    }
    return bits;
}

fn smooth_bits(sample: SourceSample, point_parallax: f32, component: u32, normal: vec3f, slot: u32) -> u32 {
    let bits = vouched_bits(sample, point_parallax, component);
    let other = primitive_at(select(sample.other, slot, bits == 0u));
    // The side does not matter: beside each other and both seen, they are seen from the same.
    let its_normal = normalize(largest_one(cross(largest_one(other.b - other.a), largest_one(other.c - other.a))));
    // A component that is a sphere's has no other primitive.
    let same = sample.other == slot || (component & IS_SPHERE) != 0u || abs(dot(its_normal, normal)) >= SAME_NORMAL;
    return select(0u, bits, same);
}
