// A scene of triangles only.

fn intersect_primitive(slot: u32, rays: Rays, per_length_squared: F, t_min: F) -> Candidate {
    let first = primitive_texel(slot * PRIMITIVE_TEXELS);
    let a = bitcast<vec3f>(first.xyz);
    let t = intersect_triangle(rays, per_length_squared, a, triangle_corner(slot, 1u), triangle_corner(slot, 2u));
    return Candidate(t, first.w);
}

fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return triangle_surface(rays, hits, ray);
}
