// A scene of spheres only: centre and id, then radius and component, in texels like a triangle's.

const PRIMITIVE_TEXELS: u32 = 3u;

fn primitive_at(slot: u32) -> Primitive {
    let first = primitive_texel(slot, 0u);
    let second = primitive_texel(slot, 1u);
    return Primitive(bitcast<vec3f>(first.xyz), bitcast<vec3f>(second.xyz), vec3f(0.0), first.w, second.w, 0.0);
}

fn intersect(primitive: Primitive, rays: Rays, scales: Scales, t_min: F) -> Found {
    return intersect_sphere(rays, scales, primitive, t_min);
}

fn look_again(primitive: Primitive, origin: vec3f, direction: vec3f, t_min: f32) -> f32 {
    if CLOSE { return look_again_sphere(origin, direction, primitive, t_min); }
    return -1.0;
}

fn surface_at(rays: Rays, hits: Hits, ray: u32) -> Surface {
    return sphere_surface(rays, hits, ray);
}
