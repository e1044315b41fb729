// A scene of spheres only: centre and id, then the radius, in texels like a triangle's.

const PRIMITIVE_TEXELS: u32 = 3u;

fn intersect_primitive(slot: u32, ray: ShearedRay, t_min: f32) -> Candidate {
    let first = primitive_texel(slot * PRIMITIVE_TEXELS);
    let radius = bitcast<f32>(primitive_texel(slot * PRIMITIVE_TEXELS + 1u).x);
    return Candidate(intersect_sphere(ray, bitcast<vec3f>(first.xyz), radius, t_min), first.w);
}

fn surface_at(ray: ShearedRay, hit: Hit) -> Surface {
    return sphere_surface(ray, hit);
}
