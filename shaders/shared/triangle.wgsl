// Rays against a triangle: watertight, by the signs of the rays' Plücker products with its edges (Amanatides & Choi
// 1997; Kensler & Shirley 2006), as Embree does it.
//
// An edge's normal is cross(p + q, q - p), twice cross(p, q), of its ends from the rays' origin. The neighbour across
// the edge sees p and q the other way round: the sum is the same, the difference and with it every product changes only
// its sign, so no rounding can open a gap. Written with the difference the error is relative to the edge's length, not
// to its distance. Normals belong to the origin, so that a lane's rays share them.

// A primitive's texels: corners (xyz), the shortest edge from a to b, with id, component and material in w; normals, if
// the scene has any, are a fourth (below).

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

// Sums of two products of an edge's ends are off by less than this share of the direction's length, the corners'
// distance and the edge's length: 18 roundings of f32 at most, the rounding of look_again's projections among them.
// DESIGN, section 9.
const DOUBT: f32 = 22.0 / 16777216.0;

// Rays against a triangle. Where rounding might decide on which side of an edge a ray passes, and where the triangle is
// so large that t would be off, the result is doubtful.
fn intersect_triangle(rays: Rays, scales: Scales, primitive: Primitive) -> Found {
    let direction = rays.direction;
    let a = primitive.a - rays.origin;
    let b = primitive.b - rays.origin;
    let c = primitive.c - rays.origin;
    let weights = triangle_weights(direction, a, b, c);
    let least = smaller(weights.x, smaller(weights.y, weights.z));
    let most = larger(weights.x, larger(weights.y, weights.z));
    // Above 0 on the inner side of all edges, whichever way the triangle is wound.
    let inside = larger(least, -most);
    let bound = scales.length * ((sqrt(dot(a, a)) + primitive.reach) * primitive.reach * DOUBT);
    // On the triangle's plane. The edge from a to b is the shortest, so that the normal of a long thin triangle is
    // exact too. All weights are over their bound: the plane is not so nearly along the ray that t could leave the
    // triangle.
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

// One ray's t at a triangle that was doubtful, or -1 where it misses (Woop, Benthin & Wald 2013). Corners are projected
// along the ray, each by itself, so that all its triangles see it at one place. An edge's product is then a difference
// of two products: these are exact, hence its sign is. Where they are equal the ray is inside for both triangles of the
// edge, so rays through an edge or a vertex are not lost. A triangle whose corners fall on one line is missed: a
// neighbour is hit.
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
    // Of a triangle that the ray runs along, the plane says little.
    let t_corner = vec3f(dot(direction, a), dot(direction, b), dot(direction, c)) / dot(direction, direction);
    let near = min(t_corner.x, min(t_corner.y, t_corner.z));
    let far = max(t_corner.x, max(t_corner.y, t_corner.z));
    return select(-1.0, clamp(t, near, far), hit);
}

// Whether the rays' origin is so close to a triangle's plane, for the triangle's size, that f32 is too coarse for t on
// it.
fn is_close(a: vec3f, b: vec3f, c: vec3f, reach: f32) -> bool {
    let normal = cross(b - a, c - a);
    let beside = dot(a, a) < 4.0 * reach * reach;
    return abs(dot(normal, a)) * LARGE < sqrt(dot(normal, normal)) * reach && beside;
}

// Two components of cross(corner, direction), those across the direction's largest one.
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
    // Scaled to its largest component first: the squares of a tiny triangle's normal would vanish in f32.
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

// Of the corners where a ray hits, none below 0 and together 1.
fn corner_weights(rays: Rays, corners: array<vec3f, 3>, ray: u32) -> vec3f {
    let origin = rays.origin;
    let weights = triangle_weights(rays.direction, corners[0] - origin, corners[1] - origin, corners[2] - origin);
    let any_sign = of_ray3(weights, ray);
    // Of a triangle that is tiny for its distance they are all rounding.
    let one = max(select(any_sign, -any_sign, any_sign.x + any_sign.y + any_sign.z < 0.0), vec3f(0.0));
    let sum = one.x + one.y + one.z;
    return select(one / sum, vec3f(1.0, 0.0, 0.0), sum == 0.0);
}

//! if normals is flat
// No triangle of the scene has vertex normals: the triangle's own.

fn shading_normal(slot: u32, weights: vec3f, geometric: vec3f) -> vec3f {
    return geometric;
}

//! if normals is smooth
// Vertex normals: a fourth texel a primitive holds three of them, each two 16-bit snorms (octahedral mapping; Cigolle
// et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors"), and 1 if they are to be used.

fn unpack_normal(word: u32) -> vec3f {
    let e = unpack2x16snorm(word);
    let z = 1.0 - abs(e.x) - abs(e.y);
    let fold = max(-z, 0.0);
    let xy = e + select(vec2f(fold), vec2f(-fold), e >= vec2f(0.0));
    return normalize(vec3f(xy, z));
}

// On the side of the geometric normal. Turned towards the viewer by itself, a normal that points away at a silhouette
// would be mirrored, and a lit rim go dark.
fn shading_normal(slot: u32, weights: vec3f, geometric: vec3f) -> vec3f {
    let packed = primitive_texel(slot, 3u);
    let sum = weights.x + weights.y + weights.z;
    let w = weights / sum;
    let blend = unpack_normal(packed.x) * w.x + unpack_normal(packed.y) * w.y + unpack_normal(packed.z) * w.z;
    let usable = packed.w == 1u && dot(blend, blend) > 1e-6;
    let normal = normalize(blend);
    return select(geometric, select(normal, -normal, dot(normal, geometric) < 0.0), usable);
}
