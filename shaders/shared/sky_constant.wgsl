// A sky of one colour.
fn sky(direction: F3) -> F3 {
    return all3(shading_vector(SKY_ZENITH));
}
