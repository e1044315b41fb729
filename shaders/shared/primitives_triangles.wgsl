// A scene of triangles only.

fn primitive_at(slot: u32) -> Primitive {
    let first = primitive_texel(slot, 0u);
    let second = primitive_texel(slot, 1u);
    let third = primitive_texel(slot, 2u);
    return Primitive(bitcast<vec3f>(first.xyz), bitcast<vec3f>(second.xyz), bitcast<vec3f>(third.xyz), first.w, second.w, reach_of(third.w));
}

fn intersect(primitive: Primitive, rays: Rays, scales: Scales, t_min: F) -> Found {
    return intersect_triangle(rays, scales, primitive);
}

fn look_again(primitive: Primitive, origin: vec3f, direction: vec3f, t_min: f32) -> f32 {
    return look_again_triangle(origin, direction, primitive);
}

fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return triangle_surface(rays, hits, ray);
}
