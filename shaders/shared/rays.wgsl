// The rays of a lane and their hits.

//! use lane

// The rays of a lane. t counts in lengths of the direction, which need not be a unit vector.
struct Rays {
    origin: vec3f,
    direction: F3,
}

// Values of a lane's rays that intersection tests share.
struct Scales {
    length: F,               // length of the direction
    per_length_squared: F,
}

// The hits of a lane's rays.
struct Hits {
    t: F,                 // t_max for a miss; undefined by any_slot
    primitive: U,         // id in the scene's order, MISS for a miss; undefined by any_slot
    slot: U,              // index in the tree's order
}

// The result of intersecting a lane's rays with one primitive.
struct Found {
    hit: B,
    t: F,          // t of the hit
    doubtful: B,   // uncertain: the second test (look_again) decides
}

// Up to two primitives deferred to a second test. An entry is slot << RAY_BITS with a bit for each uncertain ray, or 0
// for none. There are two entries, since a ray that is uncertain for a triangle is usually uncertain for a neighbour
// too.
struct PutOff {
    last: u32,
    before: u32,
}

// t_max of a ray that is not traced, and t of a ray that any_hit has finished. It is smaller than the entry of every
// box.
const NEVER: f32 = -3.402e38;

// Returns the dot product of each direction with a vector.
fn along(direction: F3, v: vec3f) -> F {
    return direction.x * v.x + direction.y * v.y + direction.z * v.z;
}

fn scales_of(rays: Rays) -> Scales {
    let squared = dot3(rays.direction, rays.direction);
    return Scales(sqrt(squared), 1.0 / squared);
}

// Returns the reciprocal, limited to ±1e30, since WGSL does not define division by zero.
fn reciprocal(v: F) -> F {
    return 1.0 / select(v, F(1e-30), abs(v) < F(1e-30));
}

// The surface at one ray's hit.
struct Surface {
    geometric_normal: vec3f,   // unit, towards the viewer
    shading_normal: vec3f,     // unit, on the geometric normal's side
    material: u32,
    component: u32,            // connected component
    reach: f32,                // for triangles: at least the longest edge; otherwise 0
    outward: vec3f,            // for spheres and ellipsoids: unit, from the centre, in the sphere's space
    radius: f32,               // of a sphere; for ellipsoids see radius_there
    // Whether the ray comes from the side on which a triangle's corners run counterclockwise. For other primitives,
    // whether it comes from outside.
    from_outside: bool,
}

fn towards_viewer(normal: vec3f, direction: vec3f) -> vec3f {
    return select(normal, -normal, dot(normal, direction) > 0.0);
}

// Returns whether a hit is nearer than the stored one. At equal t the smallest id wins, in any order of tests.
fn is_nearer(hits: Hits, t: F, t_min: F, id: u32) -> B {
    return (t >= t_min) & ((t < hits.t) | ((t == hits.t) & (U(id) < hits.primitive)));
}

// Returns whether no entry is free for a deferred primitive, so that the deferred primitives must be tested first.
fn is_too_many(put_off: PutOff, doubted: u32) -> bool {
    return doubted != 0u && put_off.before != 0u;
}

// Defers a primitive for the rays of the mask `doubted`; returns `put_off` unchanged if the mask is 0.
fn put_off_also(put_off: PutOff, slot: u32, doubted: u32) -> PutOff {
    let is_more = doubted != 0u;
    return PutOff(
        select(put_off.last, (slot << RAY_BITS) | doubted, is_more),
        select(put_off.before, put_off.last, is_more),
    );
}
