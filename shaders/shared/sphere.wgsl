// Rays against a sphere, after Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection" (Ray Tracing
// Gems, chapter 7): the distance of the centre from the line is taken of the line's nearest point, so that small
// spheres far away lose no digits.

// The nearest t of at least t_min, or -1 where a ray misses.
fn intersect_sphere(rays: Rays, per_length_squared: F, center: vec3f, radius: f32, t_min: F) -> F {
    let to_center = center - rays.origin;
    let middle = along(rays.direction, to_center) * per_length_squared;
    let offset = minus3(all3(to_center), times3(rays.direction, middle));
    let inside = radius * radius - dot3(offset, offset);
    let half = sqrt(max(inside, F(0.0)) * per_length_squared);
    let near = middle - half;
    let t = select(middle + half, near, near >= t_min);
    return select(F(-1.0), t, inside >= F(0.0));
}

fn sphere_surface(rays: Rays, hits: Hits, ray: u32) -> Surface {
    let slot = of_ray_u(hits.slot, ray);
    let first = primitive_texel(slot * PRIMITIVE_TEXELS);
    let component = primitive_texel(slot * PRIMITIVE_TEXELS + 1u).w;
    let material = primitive_texel(slot * PRIMITIVE_TEXELS + 2u).w;
    let center = bitcast<vec3f>(first.xyz);
    let direction = of_ray3(rays.direction, ray);
    // From the eye, not from the world's origin, which may be far off.
    let from_center = direction * of_ray(hits.t, ray) - (center - rays.origin);
    let normal = towards_viewer(normalize(largest_one(from_center)), direction);
    return Surface(normal, normal, material, component);
}
