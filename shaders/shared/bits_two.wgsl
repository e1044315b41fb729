// `two`: the left samples on both sides of the point.

fn agreed_bits(first: vec2u, depth: f32, component: u32, normal: vec3f, slot: u32) -> u32 {
    let before = vouched_bits(left_sample(first), depth, component);
    let after = vouched_bits(left_sample(first + vec2u(1u, 0u)), depth, component);
    return agreeing(before, after);
}
