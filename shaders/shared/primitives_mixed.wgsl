// A scene of triangles and spheres; the second texel's w says which.

fn intersect_primitive(slot: u32, rays: Rays, per_length_squared: F, t_min: F) -> Candidate {
    let first = primitive_texel(slot * PRIMITIVE_TEXELS);
    let second = primitive_texel(slot * PRIMITIVE_TEXELS + 1u);
    let a = bitcast<vec3f>(first.xyz);
    let b = bitcast<vec3f>(second.xyz);
    if second.w == KIND_SPHERE {
        return Candidate(intersect_sphere(rays, per_length_squared, a, b.x, t_min), first.w);
    }
    return Candidate(intersect_triangle(rays, per_length_squared, a, b, triangle_corner(slot, 2u)), first.w);
}

fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    if primitive_texel(of_ray_u(hits.slot, ray) * PRIMITIVE_TEXELS + 1u).w == KIND_SPHERE {
        return sphere_surface(rays, hits, ray);
    }
    return triangle_surface(rays, hits, ray);
}
