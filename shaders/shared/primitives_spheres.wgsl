// A scene of spheres only: centre and id, then radius and component, in texels like a triangle's.

const PRIMITIVE_TEXELS: u32 = 3u;

fn primitive_at(slot: u32) -> Primitive {
    let first = primitive_texel(slot * PRIMITIVE_TEXELS);
    let second = primitive_texel(slot * PRIMITIVE_TEXELS + 1u);
    return Primitive(bitcast<vec3f>(first.xyz), bitcast<vec3f>(second.xyz), vec3f(0.0), first.w, second.w);
}

fn intersect(primitive: Primitive, rays: Rays, per_length_squared: F, t_min: F) -> F {
    return intersect_sphere(rays, per_length_squared, primitive.a, primitive.b.x, t_min);
}

fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return sphere_surface(rays, hits, ray);
}
