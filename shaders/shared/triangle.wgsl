// Rays against a triangle: watertight, by the signs of the rays' Plücker products with its edges (Amanatides & Choi 1997;
// Kensler & Shirley 2006), as Embree does it.
//
// An edge's normal is cross(p + q, q - p), twice cross(p, q), of its ends from the rays' origin. The neighbour across the
// edge sees p and q the other way round: the sum is the same, the difference and with it every product changes only its
// sign, so no rounding can open a gap. Written with the difference the error is relative to the edge's length, not to
// its distance. Normals belong to the origin, so that a lane's rays share them.

// A primitive's place in `primitives` in texels: corners (xyz) with id, component and material in w; normals, if the
// scene has any, are a fourth (normal_smooth.wgsl).

fn edge_normal(p: vec3f, q: vec3f) -> vec3f {
    return cross(p + q, q - p);
}

// Weights of the corners, of any common sign where a ray hits and in any scale. Corners from the rays' origin.
fn triangle_weights(direction: F3, a: vec3f, b: vec3f, c: vec3f) -> F3 {
    return F3(
        along(direction, edge_normal(b, c)),
        along(direction, edge_normal(c, a)),
        along(direction, edge_normal(a, b)),
    );
}

// The rays' t at the triangle, or -1 where they miss. Edges and corners belong to every triangle they bound.
fn intersect_triangle(rays: Rays, per_length_squared: F, corner_a: vec3f, corner_b: vec3f, corner_c: vec3f) -> F {
    let a = corner_a - rays.origin;
    let b = corner_b - rays.origin;
    let c = corner_c - rays.origin;
    let weights = triangle_weights(rays.direction, a, b, c);
    let least = smaller(weights.x, smaller(weights.y, weights.z));
    let most = larger(weights.x, larger(weights.y, weights.z));
    let determinant = weights.x + weights.y + weights.z;
    // A mean of the corners' t: seen edge-on, where the weights are mostly rounding, it still lies between them.
    let t_a = along(rays.direction, a) * per_length_squared;
    let t_b = along(rays.direction, b) * per_length_squared;
    let t_c = along(rays.direction, c) * per_length_squared;
    let t = (weights.x * t_a + weights.y * t_b + weights.z * t_c) / determinant;
    let hit = ((least >= F(0.0)) | (most <= F(0.0))) & (determinant != F(0.0));
    return select(F(-1.0), t, hit);
}

fn triangle_surface(rays: Rays, hits: Hits, ray: u32) -> Surface {
    let slot = of_ray_u(hits.slot, ray);
    let a = bitcast<vec3f>(primitive_texel(slot * PRIMITIVE_TEXELS).xyz);
    let second = primitive_texel(slot * PRIMITIVE_TEXELS + 1u);
    let b = bitcast<vec3f>(second.xyz);
    let last = primitive_texel(slot * PRIMITIVE_TEXELS + 2u);
    let c = bitcast<vec3f>(last.xyz);
    // Scaled to its largest component first: the squares of a tiny triangle's normal would vanish in f32.
    let scaled = largest_one(cross(largest_one(b - a), largest_one(c - a)));
    let geometric = towards_viewer(normalize(scaled), of_ray3(rays.direction, ray));
    let weights = triangle_weights(rays.direction, a - rays.origin, b - rays.origin, c - rays.origin);
    return Surface(geometric, shading_normal(slot, of_ray3(weights, ray), geometric), last.w, second.w);
}
