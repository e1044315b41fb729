// A sky that blends along the world's y axis.
fn sky(direction: F3) -> F3 {
    let height = 0.5 + 0.5 * direction.y / sqrt(dot3(direction, direction));
    return add3(times3(all3(shading_vector(SKY_NADIR)), 1.0 - height), times3(all3(shading_vector(SKY_ZENITH)), height));
}
