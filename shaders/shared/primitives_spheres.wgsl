// A scene of spheres only: centre and id, then the radius, in texels like a triangle's.

const PRIMITIVE_TEXELS: u32 = 3u;

fn intersect_primitive(slot: u32, rays: Rays, per_length_squared: F, t_min: F) -> Candidate {
    let first = primitive_texel(slot * PRIMITIVE_TEXELS);
    let radius = bitcast<f32>(primitive_texel(slot * PRIMITIVE_TEXELS + 1u).x);
    let center = bitcast<vec3f>(first.xyz);
    return Candidate(intersect_sphere(rays, per_length_squared, center, radius, t_min), first.w);
}

fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return sphere_surface(rays, hits, ray);
}
