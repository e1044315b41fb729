// A scene of triangles and spheres; the second texel's w says which, in its lowest bit.

fn primitive_at(slot: u32) -> Primitive {
    let first = primitive_texel(slot * PRIMITIVE_TEXELS);
    let second = primitive_texel(slot * PRIMITIVE_TEXELS + 1u);
    let third = primitive_texel(slot * PRIMITIVE_TEXELS + 2u);
    return Primitive(bitcast<vec3f>(first.xyz), bitcast<vec3f>(second.xyz), bitcast<vec3f>(third.xyz), first.w, second.w);
}

fn is_sphere(primitive: Primitive) -> bool {
    return (primitive.component & IS_SPHERE) != 0u;
}

fn intersect(primitive: Primitive, rays: Rays, per_length_squared: F, t_min: F) -> F {
    if is_sphere(primitive) { return intersect_sphere(rays, per_length_squared, primitive.a, primitive.b.x, t_min); }
    return intersect_triangle(rays, per_length_squared, primitive.a, primitive.b, primitive.c);
}

fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    if (primitive_texel(of_ray_u(hits.slot, ray) * PRIMITIVE_TEXELS + 1u).w & IS_SPHERE) != 0u {
        return sphere_surface(rays, hits, ray);
    }
    return triangle_surface(rays, hits, ray);
}
