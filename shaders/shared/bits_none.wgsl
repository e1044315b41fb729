// `rays`: nothing is taken over.

fn agreed_bits(first: vec2u, way: f32, point_parallax: f32, component: u32, normal: vec3f, slot: u32) -> u32 {
    return 0u;
}
