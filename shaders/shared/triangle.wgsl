// Watertight triangle intersection, by the signs of the rays' Plücker products with the edges (Amanatides & Choi 1997;
// Kensler & Shirley 2006), as in Embree.
//
// An edge has ends p and q relative to the rays' origin. Its normal is cross(p + q, q - p), which is twice cross(p, q).
// The neighbour across the edge swaps p and q. The sum stays the same, and the difference and every product only change
// sign, so rounding opens no gap. Using the difference makes the error relative to the edge's length instead of its
// distance. Normals depend on the origin only, so a lane's rays share them.

// A triangle's three texels hold the corners in xyz; the edge from a to b is the shortest. Their w hold id, component
// and material. If the scene has vertex normals, they are in a fourth texel (below).

//! use double_float, fetch, lane, primitive, rays

fn edge_normal(p: vec3f, q: vec3f) -> vec3f {
    return cross(p + q, q - p);
}

// Returns the corners' barycentric weights, not normalised; at a hit all have the same sign. Corners are relative to
// the rays' origin.
fn triangle_weights(direction: F3, a: vec3f, b: vec3f, c: vec3f) -> F3 {
    return F3(
        along(direction, edge_normal(b, c)),
        along(direction, edge_normal(c, a)),
        along(direction, edge_normal(a, b)),
    );
}

// The error of an edge product is below this fraction of the direction's length times the corners' distance times the
// edge's length. It covers at most 18 roundings of f32, including the projections of look_again. See DESIGN, section 9.
const DOUBT: f32 = 22.0 / 16777216.0;

// Intersects rays with a triangle. The result is uncertain if rounding might decide on which side of an edge a ray
// passes. It is also uncertain if the triangle is so large that t would be wrong.
fn intersect_triangle(rays: Rays, scales: Scales, primitive: Primitive) -> Found {
    let direction = rays.direction;
    let a = primitive.a - rays.origin;
    let b = primitive.b - rays.origin;
    let c = primitive.c - rays.origin;
    let weights = triangle_weights(direction, a, b, c);
    let least = smaller(weights.x, smaller(weights.y, weights.z));
    let most = larger(weights.x, larger(weights.y, weights.z));
    // The value is positive on the inner side of all edges, for either winding.
    let inside = larger(least, -most);
    let bound = scales.length * ((sqrt(dot(a, a)) + primitive.reach) * primitive.reach * DOUBT);
    // t is the intersection with the triangle's plane. The edge from a to b is the shortest, so the normal of a long
    // thin triangle is exact too. At a hit all weights exceed their bound. So the plane cannot be so nearly parallel to
    // the ray that t leaves the triangle.
    let normal = cross(b - a, c - a);
    let t = F(dot(normal, a)) / along(direction, normal);
    let hit = inside > bound;
    let doubtful = abs(inside) <= bound;
    if CLOSE {
        let close = B(is_close(a, b, c, primitive.reach));
        return Found(hit & !close, t, doubtful | (hit & close));
    }
    return Found(hit, t, doubtful);
}

// Returns one ray's t after an uncertain test, or -1 for a miss (Woop, Benthin & Wald 2013). Each corner is projected
// along the ray independently, so all triangles that share the corner agree on its position. An edge product is then a
// difference of two exact products, so its sign is exact. If the products are equal, the ray is inside for both
// triangles of the edge. So rays through an edge or a vertex are not lost. A triangle whose projected corners are
// collinear is missed, and a neighbour is hit.
fn look_again_triangle(origin: vec3f, direction: vec3f, primitive: Primitive) -> f32 {
    let a = primitive.a - origin;
    let b = primitive.b - origin;
    let c = primitive.c - origin;
    let p = projected(direction, a);
    let q = projected(direction, b);
    let r = projected(direction, c);
    let forth = exact_product3(vec3f(q.x, r.x, p.x), vec3f(r.y, p.y, q.y));
    let back = exact_product3(vec3f(q.y, r.y, p.y), vec3f(r.x, p.x, q.x));
    let same = forth.hi == back.hi;
    let more = (forth.hi > back.hi) | (same & (forth.lo > back.lo));
    let less = (forth.hi < back.hi) | (same & (forth.lo < back.lo));
    let hit = any(more) != any(less);
    let normal = cross(b - a, c - a);
    let across = dot(normal, direction);
    var t = dot(normal, a) / select(across, 1.0, across == 0.0);
    if CLOSE && is_close(a, b, c, primitive.reach) {
        t = plane_t(origin, direction, primitive.a, primitive.b, primitive.c);
    }
    // For a ray along the triangle's plane, t is inexact, so it is clamped to the range of the corners' t.
    let t_corner = vec3f(dot(direction, a), dot(direction, b), dot(direction, c)) / dot(direction, direction);
    let near = min(t_corner.x, min(t_corner.y, t_corner.z));
    let far = max(t_corner.x, max(t_corner.y, t_corner.z));
    return select(-1.0, clamp(t, near, far), hit);
}

// Returns whether the rays' origin is so close to a triangle's plane, relative to its size, that f32 is too coarse for
// t.
fn is_close(a: vec3f, b: vec3f, c: vec3f, reach: f32) -> bool {
    let normal = cross(b - a, c - a);
    let beside = dot(a, a) < 4.0 * reach * reach;
    return abs(dot(normal, a)) * LARGE < sqrt(dot(normal, normal)) * reach && beside;
}

// Returns two components of cross(corner, direction): those across the direction's largest component.
fn projected(direction: vec3f, corner: vec3f) -> vec2f {
    let m = cross(corner, direction);
    let size = abs(direction);
    let along_x = size.x >= size.y && size.x >= size.z;
    let along_z = size.z > size.y;
    return select(select(m.zx, m.xy, along_z), m.yz, along_x);
}

fn triangle_surface(rays: Rays, hits: Hits, ray: u32) -> Surface {
    let slot = of_ray_u(hits.slot, ray);
    let a = bitcast<vec3f>(primitive_texel(slot, 0u).xyz);
    let second = primitive_texel(slot, 1u);
    let b = bitcast<vec3f>(second.xyz);
    let last = primitive_texel(slot, 2u);
    let c = bitcast<vec3f>(last.xyz);
    // The vector is scaled to its largest component first, since the squares of a tiny triangle's normal would
    // underflow.
    let scaled = largest_one(cross(largest_one(b - a), largest_one(c - a)));
    let geometric = towards_viewer(normalize(scaled), of_ray3(rays.direction, ray));
    let weights = triangle_weights(rays.direction, a - rays.origin, b - rays.origin, c - rays.origin);
    let shading = shading_normal(slot, of_ray3(weights, ray), geometric);
    let outside = dot(scaled, of_ray3(rays.direction, ray)) < 0.0;
    return Surface(geometric, shading, last.w & MATERIAL, second.w, reach_of(last.w), vec3f(0.0), 0.0, outside);
}

fn triangle_corners(slot: u32) -> array<vec3f, 3> {
    return array<vec3f, 3>(
        bitcast<vec3f>(primitive_texel(slot, 0u).xyz),
        bitcast<vec3f>(primitive_texel(slot, 1u).xyz),
        bitcast<vec3f>(primitive_texel(slot, 2u).xyz),
    );
}

// Returns the corners' weights at a hit: none is negative, and their sum is 1.
fn corner_weights(rays: Rays, corners: array<vec3f, 3>, ray: u32) -> vec3f {
    let origin = rays.origin;
    let weights = triangle_weights(rays.direction, corners[0] - origin, corners[1] - origin, corners[2] - origin);
    let any_sign = of_ray3(weights, ray);
    // If the triangle is tiny for its distance, the weights are mostly rounding.
    let one = max(select(any_sign, -any_sign, any_sign.x + any_sign.y + any_sign.z < 0.0), vec3f(0.0));
    let sum = one.x + one.y + one.z;
    return select(one / sum, vec3f(1.0, 0.0, 0.0), sum == 0.0);
}

//! if normals is flat
// No triangle of the scene has vertex normals, so the shading normal is the geometric normal.

fn shading_normal(slot: u32, weights: vec3f, geometric: vec3f) -> vec3f {
    return geometric;
}

//! if normals is smooth
// Vertex normals: the fourth texel of a primitive holds three of them, each as two 16-bit snorms (octahedral mapping;
// Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors"). Its w is 1 if they are
// used.

fn unpack_normal(word: u32) -> vec3f {
    let e = unpack2x16snorm(word);
    let z = 1.0 - abs(e.x) - abs(e.y);
    let fold = max(-z, 0.0);
    let xy = e + select(vec2f(fold), vec2f(-fold), e >= vec2f(0.0));
    return normalize(vec3f(xy, z));
}

// Returns the shading normal, on the side of the geometric normal. At a silhouette it may point away from the viewer.
// If it were turned towards the viewer, it would be mirrored, and a lit rim would be dark.
fn shading_normal(slot: u32, weights: vec3f, geometric: vec3f) -> vec3f {
    let packed = primitive_texel(slot, 3u);
    let sum = weights.x + weights.y + weights.z;
    let w = weights / sum;
    let blend = unpack_normal(packed.x) * w.x + unpack_normal(packed.y) * w.y + unpack_normal(packed.z) * w.z;
    let usable = packed.w == 1u && dot(blend, blend) > 1e-6;
    let normal = normalize(blend);
    return select(geometric, select(normal, -normal, dot(normal, geometric) < 0.0), usable);
}
