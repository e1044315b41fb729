// A scene of triangles only.

fn intersect_primitive(slot: u32, ray: ShearedRay, t_min: f32) -> Candidate {
    let first = primitive_texel(slot * PRIMITIVE_TEXELS);
    let t = intersect_triangle(ray, bitcast<vec3f>(first.xyz), triangle_corner(slot, 1u), triangle_corner(slot, 2u));
    return Candidate(t, first.w);
}

fn surface_at(ray: ShearedRay, hit: Hit) -> Surface {
    return triangle_surface(ray, hit);
}
