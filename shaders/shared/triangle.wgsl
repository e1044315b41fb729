// Ray against triangle: watertight, after Woop, Benthin & Wald 2013, "Watertight Ray/Triangle Intersection".
//
// The ray is sheared onto an axis, so that each corner is projected by the same arithmetic whatever triangle it
// belongs to, and what is left is three signs in the plane. We take a sign by comparing the two products of the edge
// function instead of subtracting them: the neighbour across the edge compares the same two products, so no rounding
// and no fused multiply-add can open a gap, and the paper's fallback to doubles is not needed. The rows of the shear
// replace its permutation of axes: terms with 0 and 1 are exact.

// A primitive's place in `primitives` in texels: corners (xyz) with id, kind and material in w; normals, if the
// scene has any, are a fourth (normal_smooth.wgsl).
const KIND_SPHERE: u32 = 1u;

fn triangle_corner(slot: u32, corner: u32) -> vec3f {
    return bitcast<vec3f>(primitive_texel(slot * PRIMITIVE_TEXELS + corner).xyz);
}

struct Edges {
    weights: vec3f,   // of the three corners, sum = determinant
    along: vec3f,     // t of the three corners
    inside: bool,
}

fn triangle_edges(ray: ShearedRay, corner_a: vec3f, corner_b: vec3f, corner_c: vec3f) -> Edges {
    let a = corner_a - ray.origin;
    let b = corner_b - ray.origin;
    let c = corner_c - ray.origin;
    let x = vec3f(dot(ray.shear_x, a), dot(ray.shear_x, b), dot(ray.shear_x, c));
    let y = vec3f(dot(ray.shear_y, a), dot(ray.shear_y, b), dot(ray.shear_y, c));
    let along = vec3f(dot(ray.shear_z, a), dot(ray.shear_z, b), dot(ray.shear_z, c));
    let plus = x.zxy * y.yzx;
    let minus = y.zxy * x.yzx;
    return Edges(plus - minus, along, all(plus >= minus) || all(plus <= minus));
}

// The ray's t at the triangle, or -1 where it misses. Edges and corners belong to every triangle they bound.
fn intersect_triangle(ray: ShearedRay, a: vec3f, b: vec3f, c: vec3f) -> f32 {
    let edges = triangle_edges(ray, a, b, c);
    let determinant = edges.weights.x + edges.weights.y + edges.weights.z;
    let t = dot(edges.weights, edges.along) / determinant;
    // Seen edge-on the quotient is mostly rounding: it stays between the corners.
    let low = min(edges.along.x, min(edges.along.y, edges.along.z));
    let high = max(edges.along.x, max(edges.along.y, edges.along.z));
    return select(-1.0, clamp(t, low, high), edges.inside && determinant != 0.0);
}

fn triangle_surface(ray: ShearedRay, hit: Hit) -> Surface {
    let a = triangle_corner(hit.slot, 0u);
    let b = triangle_corner(hit.slot, 1u);
    let c = triangle_corner(hit.slot, 2u);
    let material = primitive_texel(hit.slot * PRIMITIVE_TEXELS + 2u).w;
    // Scaled to its largest component first: the squares of a tiny triangle's normal would vanish in f32.
    let scaled = largest_one(cross(largest_one(b - a), largest_one(c - a)));
    let geometric = towards_viewer(normalize(scaled), ray.direction);
    let weights = triangle_edges(ray, a, b, c).weights;
    let shading_normal = shading_normal(hit.slot, weights, geometric);
    return Surface(ray.origin + ray.direction * hit.t, geometric, shading_normal, material);
}
