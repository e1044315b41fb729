// `two`: the left samples on both sides of the point. In a groove between them, deeper than the line from one to the other, a light that both
// see may be hidden.

// Depth of a groove, of what one surface's parallaxes may differ by: 1/128 pixel where that is 0.75.
const GROOVE: f32 = 1.0 / 96.0;

// `way` is the point's place between the two, 0 to 1.
fn agreed_bits(first: vec2u, way: f32, point_parallax: f32, component: u32, normal: vec3f, slot: u32) -> u32 {
    let before = source_sample(first);
    let after = source_sample(first + vec2u(1u, 0u));
    let bits = agreeing(vouched_bits(before, point_parallax, component), vouched_bits(after, point_parallax, component));
    let deeper = point_parallax - mix(parallax(before.depth), parallax(after.depth), way);
    let in_groove = select(deeper, -deeper, frame.parallax_px < 0.0) > GROOVE * frame.same_parallax;
    return select(bits, bits & ~(bits << 16u), in_groove);
}
