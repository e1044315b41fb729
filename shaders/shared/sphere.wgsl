// Intersection with spheres, after Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection" (Ray
// Tracing Gems, chapter 7). The distance of the centre from the line is computed from the line's nearest point. So
// small distant spheres are intersected without loss of precision.

//! use double_float, fetch, lane, primitive, rays

// Returns the nearest t, at least t_min, at which a line meets a sphere, or -1. The function solves the quadratic
// equation in sums of two f32. The smaller root is a quotient, which avoids cancellation.
fn sphere_root(to_center: Two3, way: Two3, radius: Two, t_min: f32) -> f32 {
    let squared = product_two(radius, radius);
    let outside = sum_two(dot_two3(to_center, to_center), Two(-squared.hi, -squared.lo));
    let middle = dot_two3(to_center, way);
    let length_squared = dot_two3(way, way);
    let less = product_two(length_squared, outside);
    let root = sum_two(product_two(middle, middle), Two(-less.hi, -less.lo)).hi;
    let both = middle.hi + select(-1.0, 1.0, middle.hi >= 0.0) * sqrt(max(root, 0.0));
    let larger_root = both / length_squared.hi;
    let other_root = select(outside.hi / both, 0.0, both == 0.0);
    let near = min(larger_root, other_root);
    let t = select(max(larger_root, other_root), near, near >= t_min);
    return select(-1.0, t, root >= 0.0);
}

//! if texels is corners or spheres
// Finds the nearest t that is at least t_min. The result is uncertain close to the surface of a large sphere, where f32
// is too coarse.
fn intersect_sphere(rays: Rays, scales: Scales, primitive: Primitive, t_min: F) -> Found {
    let radius = primitive.b.x;
    let to_center = primitive.a - rays.origin;
    let middle = along(rays.direction, to_center) * scales.per_length_squared;
    let offset = minus3(all3(to_center), times3(rays.direction, middle));
    let inside = radius * radius - dot3(offset, offset);
    let half = sqrt(max(inside, F(0.0)) * scales.per_length_squared);
    let near = middle - half;
    let t = select(middle + half, near, near >= t_min);
    let close = B(CLOSE && abs(dot(to_center, to_center) - radius * radius) < 0.5 * radius * radius);
    return Found((inside >= F(0.0)) & !close, t, close);
}

// Returns one ray's t after an uncertain test, or -1 for a miss.
fn look_again_sphere(origin: vec3f, direction: vec3f, primitive: Primitive, t_min: f32) -> f32 {
    let to_center = difference3(primitive.a, origin);
    let way = Two3(direction, vec3f(0.0));
    return sphere_root(to_center, way, Two(primitive.b.x, 0.0), t_min);
}

fn sphere_surface(rays: Rays, hits: Hits, ray: u32) -> Surface {
    let slot = of_ray_u(hits.slot, ray);
    let first = primitive_texel(slot, 0u);
    let component = primitive_texel(slot, 1u).w;
    let material = primitive_texel(slot, 2u).w;
    let center = bitcast<vec3f>(first.xyz);
    let direction = of_ray3(rays.direction, ray);
    // Coordinates are relative to the eye, since the world's origin may be far away.
    let from_center = direction * of_ray(hits.t, ray) - (center - rays.origin);
    let outward = normalize(largest_one(from_center));
    let normal = towards_viewer(outward, direction);
    return Surface(
        normal,
        normal,
        material,
        component,
        0.0,
        outward,
        bitcast<f32>(primitive_texel(slot, 1u).x),
        dot(outward, direction) < 0.0,
    );
}
