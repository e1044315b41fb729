// Intersection with ellipsoids. A matrix maps the ellipsoid to a sphere and transforms the ray too, which preserves t.
// The rest of the test is the same as in sphere.wgsl.

// In a scene with ellipsoids, spheres are stored as ellipsoids with the identity matrix. So these functions replace the
// sphere functions of sphere.wgsl and projection.wgsl.

//! use double_float, fetch, lane, primitive, rays, sphere

//! if texels is ellipsoids
fn to_sphere(primitive: Primitive, v: vec3f) -> vec3f {
    return vec3f(dot(primitive.b, v), dot(primitive.c, v), dot(primitive.d, v));
}

// Finds the nearest t that is at least t_min.
fn intersect_sphere(rays: Rays, scales: Scales, primitive: Primitive, t_min: F) -> Found {
    let radius = primitive.reach;
    let from_origin = primitive.a - rays.origin;
    let to_center = to_sphere(primitive, from_origin);
    let direction = F3(
        along(rays.direction, primitive.b),
        along(rays.direction, primitive.c),
        along(rays.direction, primitive.d),
    );
    let per_length_squared = 1.0 / dot3(direction, direction);
    let middle = along(direction, to_center) * per_length_squared;
    let offset = minus3(all3(to_center), times3(direction, middle));
    let inside = radius * radius - dot3(offset, offset);
    let half = sqrt(max(inside, F(0.0)) * per_length_squared);
    let near = middle - half;
    let t = select(middle + half, near, near >= t_min);
    let close = B(CLOSE && is_close_ellipsoid(primitive, from_origin, to_center));
    return Found((inside >= F(0.0)) & !close, t, close);
}

// Share of the cancellation in the matrix products that defines a distance from the sphere. If the rays' origin is
// nearer than that distance, rounding affects t.
const CANCELLED: f32 = 0.25;

// Returns whether the rays' origin is so close to the surface that f32 is too coarse for t. Either the sphere is large,
// as in sphere.wgsl, or terms cancel in the matrix products. Cancellation is large beside a tilted flat ellipsoid with
// a distant centre. If the centre is more than two radii away, t is so large that the error does not matter.
fn is_close_ellipsoid(primitive: Primitive, from_origin: vec3f, to_center: vec3f) -> bool {
    let radius = primitive.reach;
    let distance = abs(dot(to_center, to_center) - radius * radius);
    let way = abs(from_origin);
    let products = vec3f(dot(abs(primitive.b), way), dot(abs(primitive.c), way), dot(abs(primitive.d), way));
    let cancelled = products - abs(to_center);
    let far = max(cancelled.x, max(cancelled.y, cancelled.z)) * CANCELLED;
    let beside = dot(from_origin, from_origin) < 4.0 * radius * radius;
    return distance < 0.5 * radius * radius || (distance < (2.0 * radius + far) * far && beside);
}

fn to_sphere_two(primitive: Primitive, v: Two3) -> Two3 {
    let x = dot_two3(Two3(primitive.b, vec3f(0.0)), v);
    let y = dot_two3(Two3(primitive.c, vec3f(0.0)), v);
    let z = dot_two3(Two3(primitive.d, vec3f(0.0)), v);
    return Two3(vec3f(x.hi, y.hi, z.hi), vec3f(x.lo, y.lo, z.lo));
}

// Returns one ray's t after an uncertain test, or -1 for a miss, as in sphere.wgsl.
fn look_again_sphere(origin: vec3f, direction: vec3f, primitive: Primitive, t_min: f32) -> f32 {
    let to_center = to_sphere_two(primitive, difference3(primitive.a, origin));
    let way = to_sphere_two(primitive, Two3(direction, vec3f(0.0)));
    return sphere_root(to_center, way, Two(primitive.reach, 0.0), t_min);
}

fn sphere_surface(rays: Rays, hits: Hits, ray: u32) -> Surface {
    let slot = of_ray_u(hits.slot, ray);
    let primitive = primitive_at(slot);
    let material = primitive_texel(slot, 2u).w;
    let direction = of_ray3(rays.direction, ray);
    // Coordinates are relative to the eye, since the world's origin may be far away.
    let from_center = direction * of_ray(hits.t, ray) - (primitive.a - rays.origin);
    // Normals are mapped back by the transposed matrix.
    let outwards = to_sphere(primitive, largest_one(from_center));
    let across = primitive.b * outwards.x + primitive.c * outwards.y + primitive.d * outwards.z;
    let outside = dot(across, direction) < 0.0;
    let normal = towards_viewer(normalize(largest_one(across)), direction);
    return Surface(
        normal,
        normal,
        material,
        primitive.component,
        0.0,
        normalize(outwards),
        radius_there(primitive, normal),
        outside,
    );
}

// Returns the radius of a sphere on which a texture has the same local scale by area as on the ellipsoid at this
// normal. The map to the sphere multiplies an area by its determinant times the length of the normal under its inverse
// transpose.
fn radius_there(primitive: Primitive, normal: vec3f) -> f32 {
    let lengths = vec3f(length(primitive.b), length(primitive.c), length(primitive.d));
    let grown = lengths.x * lengths.y * lengths.z * length(to_sphere(primitive, normal) / (lengths * lengths));
    return primitive.reach * inverseSqrt(grown);
}

// Returns an axis's components along the ellipsoid's semi-axes, each multiplied by the semi-axis's length.
fn half_widths(primitive: Primitive, axis: vec3f) -> vec3f {
    let squared = vec3f(dot(primitive.b, primitive.b), dot(primitive.c, primitive.c), dot(primitive.d, primitive.d));
    return to_sphere(primitive, axis) * (primitive.reach / squared);
}

// Returns the smallest and largest slope s of the tangent planes `across = s z`. The slopes satisfy (across - s z)² =
// |a - s b|², where a and b are the half widths of the two axes. The discriminant is written as two products, so that
// the rounding of a distant centre does not swamp it.
fn touching(across: f32, z: f32, a: vec3f, b: vec3f, depth: f32) -> vec2f {
    let seen = z * a - across * b;
    let hidden = cross(a, b);
    let root = sqrt(max(dot(seen, seen) - dot(hidden, hidden), 0.0));
    let middle = across * z - dot(a, b);
    return vec2f(middle - root, middle + root) / ((z - depth) * (z + depth));
}
