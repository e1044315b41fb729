// A sky that blends along the world's y axis.
fn sky(direction: vec3f) -> vec3f {
    let height = 0.5 + 0.5 * direction.y / length(direction);
    return shading.sky_nadir * (1.0 - height) + shading.sky_zenith * height;
}
