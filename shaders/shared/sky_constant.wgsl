// A sky of one colour.
fn sky(direction: vec3f) -> vec3f {
    return shading.sky_zenith;
}
