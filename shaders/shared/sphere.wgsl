// Ray against sphere, after Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection" (Ray Tracing
// Gems, chapter 7): the distance of the centre from the line is taken of the line's nearest point, so that small
// spheres far away lose no digits.

// The nearest t of at least t_min, or -1 where the ray misses.
fn intersect_sphere(ray: ShearedRay, center: vec3f, radius: f32, t_min: f32) -> f32 {
    let to_center = center - ray.origin;
    let length_squared = dot(ray.direction, ray.direction);
    let middle = dot(to_center, ray.direction) / length_squared;
    let offset = to_center - ray.direction * middle;
    let inside = radius * radius - dot(offset, offset);
    let half = sqrt(max(inside, 0.0) / length_squared);
    let near = middle - half;
    let t = select(middle + half, near, near >= t_min);
    return select(-1.0, t, inside >= 0.0);
}

fn sphere_surface(ray: ShearedRay, hit: Hit) -> Surface {
    let first = primitive_texel(hit.slot * PRIMITIVE_TEXELS);
    let material = primitive_texel(hit.slot * PRIMITIVE_TEXELS + 2u).w;
    let center = bitcast<vec3f>(first.xyz);
    // From the eye, not from the world's origin, which may be far off.
    let from_center = ray.direction * hit.t - (center - ray.origin);
    let normal = towards_viewer(normalize(largest_one(from_center)), ray.direction);
    return Surface(ray.origin + ray.direction * hit.t, normal, normal, material);
}
