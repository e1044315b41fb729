// `two`: the left samples on both sides of the point. In a groove between them, deeper than the line from one to the other, a light that both
// see may be hidden.

// Depth of a groove, pixels of parallax.
const GROOVE: f32 = 1.0 / 128.0;

// `way` is the point's place between the two, 0 to 1.
fn agreed_bits(first: vec2u, way: f32, point_parallax: f32, component: u32, normal: vec3f, slot: u32) -> u32 {
    let before = source_sample(first);
    let after = source_sample(first + vec2u(1u, 0u));
    let bits = agreeing(vouched_bits(before, point_parallax, component), vouched_bits(after, point_parallax, component));
    let deeper = point_parallax - mix(parallax(before.depth), parallax(after.depth), way);
    let in_groove = select(deeper, -deeper, frame.parallax_px < 0.0) > GROOVE;
    return select(bits, bits & ~(bits << 16u), in_groove);
}
