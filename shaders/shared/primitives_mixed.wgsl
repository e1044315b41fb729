// A scene of triangles and spheres; the second texel's w says which.

fn intersect_primitive(slot: u32, ray: ShearedRay, t_min: f32) -> Candidate {
    let first = primitive_texel(slot * PRIMITIVE_TEXELS);
    let second = primitive_texel(slot * PRIMITIVE_TEXELS + 1u);
    let a = bitcast<vec3f>(first.xyz);
    let b = bitcast<vec3f>(second.xyz);
    if second.w == KIND_SPHERE {
        return Candidate(intersect_sphere(ray, a, b.x, t_min), first.w);
    }
    return Candidate(intersect_triangle(ray, a, b, triangle_corner(slot, 2u)), first.w);
}

fn surface_at(ray: ShearedRay, hit: Hit) -> Surface {
    if primitive_texel(hit.slot * PRIMITIVE_TEXELS + 1u).w == KIND_SPHERE {
        return sphere_surface(ray, hit);
    }
    return triangle_surface(ray, hit);
}
