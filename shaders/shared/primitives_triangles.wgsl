// A scene of triangles only.

fn primitive_at(slot: u32) -> Primitive {
    let first = primitive_texel(slot * PRIMITIVE_TEXELS);
    let second = primitive_texel(slot * PRIMITIVE_TEXELS + 1u);
    let third = primitive_texel(slot * PRIMITIVE_TEXELS + 2u);
    return Primitive(bitcast<vec3f>(first.xyz), bitcast<vec3f>(second.xyz), bitcast<vec3f>(third.xyz), first.w, second.w);
}

fn intersect(primitive: Primitive, rays: Rays, per_length_squared: F, t_min: F) -> F {
    return intersect_triangle(rays, per_length_squared, primitive.a, primitive.b, primitive.c);
}

fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return triangle_surface(rays, hits, ray);
}
