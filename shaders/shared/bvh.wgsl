// Traversal: closest_hit and any_hit share one loop, which every ray goes through.
//
// The rays of a lane start at one point and share a stack: all of them test each node that one must visit. A node is a
// pair of child boxes, each with a link. A link with LEAF set is a run of 1 to 8 primitives: (count - 1) in bits 28 to
// 30, the first slot below. Other links are indices of pairs. The root is pair 0.
//! if cutouts is none
struct Bvh {
    grid_origin: vec3f,   // grid point 0, scene coordinates
    extent: f32,          // largest side of the scene's box, world units
    grid_cell: vec3f,     // world size of a grid step
    zero: u32,            // 0, unknown to compilers
}
//! end
// The rays of a lane. t counts in lengths of the direction, which need not be a unit vector.
struct Rays {
    origin: vec3f,
    direction: F3,
}

// Links that a traversal has yet to follow, above DONE.
alias Stack = array<u32, STACK_SIZE>;

// Values of a lane's rays that intersection tests share.
struct Scales {
    length: F,               // of the direction
    per_length_squared: F,
}

// The hits of a lane's rays.
struct Hits {
    t: F,                 // t_max for a miss; undefined by any_slot
    primitive: U,         // id in the scene's order, MISS for a miss; undefined by any_slot
    slot: U,              // index in the tree's order
}

// A child's widened box, relative to the rays' origin.
struct Child {
    low: vec3f,
    high: vec3f,
    link: u32,
}

//! if texels is corners or spheres
// A primitive, as intersection needs it. A sphere has its centre in a and its radius in b.x. ellipsoid.wgsl has the
// version for scenes with ellipsoids.
struct Primitive {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    id: u32,          // in the scene's order
    component: u32,   // connected component, from bit 1 on; IS_SPHERE
    reach: f32,       // of a triangle: at least its longest edge
}
//! end

// The result of intersecting a lane's rays with one primitive.
struct Found {
    hit: B,
    t: F,          // at the hit
    doubtful: B,   // uncertain: look_again decides
}

// Uncertain primitives, deferred to their second look, as slot << RAY_BITS with a bit for each uncertain ray; 0 for
// none. There are two, since a ray that is uncertain at a triangle mostly is at a neighbour too.
struct PutOff {
    last: u32,
    before: u32,
}

// The surface at one ray's hit.
struct Surface {
    geometric_normal: vec3f,   // unit, towards the viewer
    shading_normal: vec3f,     // unit, on the geometric normal's side
    material: u32,
    component: u32,            // connected component
    reach: f32,                // of a triangle: at least its longest edge; of a ball: 0
    outward: vec3f,            // of a ball: unit, from its centre, as if it were a sphere
    radius: f32,               // of a ball
    // Whether the ray comes from the side on which the corners run counterclockwise, or from outside a ball.
    from_outside: bool,
}

// Lowest bit of a component: set for spheres, ellipsoids and planes, which are no triangles.
const IS_SPHERE: u32 = 1u;
const LEAF: u32 = 0x80000000u;
const FIRST_SLOT: u32 = 0x0fffffffu;
const DONE: u32 = 0xffffffffu;
// The material, in w of a primitive's third texel. Above it are the upper 16 bits of a triangle's reach.
const MATERIAL: u32 = 0x0000ffffu;
const NO_ENTRY: f32 = 3.402e38;
// t_max of a ray that is not traced, and t of a ray that any_hit has finished. It lies before every box.
const NEVER: f32 = -3.402e38;

override COUNT: bool = false;
// Whether a loop ended before its work did. llvmpipe silently ends a thread's loops after 65,535 rounds in total.
var<private> cut_short: bool;

// Written out, since the built-in functions also order NaN, which costs two more instructions each.
fn smaller(a: F, b: F) -> F { return select(b, a, a < b); }
fn larger(a: F, b: F) -> F { return select(b, a, a > b); }

fn largest_one(v: vec3f) -> vec3f {
    return v / max(max(abs(v.x), abs(v.y)), abs(v.z));
}

fn towards_viewer(normal: vec3f, direction: vec3f) -> vec3f {
    return select(normal, -normal, dot(normal, direction) > 0.0);
}

fn reach_of(word: u32) -> f32 {
    return bitcast<f32>(word & 0xffff0000u);
}

// Returns the dot product of each direction with a vector.
fn along(direction: F3, v: vec3f) -> F {
    return direction.x * v.x + direction.y * v.y + direction.z * v.z;
}

fn scales_of(rays: Rays) -> Scales {
    let squared = dot3(rays.direction, rays.direction);
    return Scales(sqrt(squared), 1.0 / squared);
}

// Clamps reciprocals to ±1e30: WGSL does not define division by zero.
fn reciprocal(v: F) -> F {
    return 1.0 / select(v, F(1e-30), abs(v) < F(1e-30));
}

// At equal t the smallest id wins, in any order of tests.
fn is_nearer(hits: Hits, t: F, t_min: F, id: u32) -> B {
    return (t >= t_min) & ((t < hits.t) | ((t == hits.t) & (U(id) < hits.primitive)));
}

// Offsets from the grid's origin to box corners relative to a point.
struct Offsets {
    low: vec3f,
    high: vec3f,
}

// Boxes are widened by more than the rounding of slab and primitive tests, so that no tie and no flat leaf is missed
// (DESIGN, section 2). The margin is small, since a shadow ray begins close to its surface and would test the surface's
// boxes in vain.
fn offsets_from(origin: vec3f) -> Offsets {
    let to_grid = bvh.grid_origin - origin;
    let slack = (bvh.extent + max(max(abs(to_grid.x), abs(to_grid.y)), abs(to_grid.z))) * SCENE_SLACK;
    return Offsets(to_grid - slack, to_grid + slack);
}

fn traverse(rays: Rays, t_min: F, t_max: F, any_is_enough: bool) -> Hits {
    let scales = scales_of(rays);
    let direction = rays.direction;
    let inverse = F3(reciprocal(direction.x), reciprocal(direction.y), reciprocal(direction.z));
    let offsets = offsets_from(rays.origin);

    var hits = Hits(t_max, U(MISS), select(U(0u), U(MISS), any_is_enough));
    var stack: Stack;
    stack[0] = DONE;
    var top = 0;
    var link = 0u;
    resume(&hits, &stack, &top, &link);
    var slot: u32;
    var last: u32;
    // The largest t at which a box may begin.
    var reach = hits.t;
    // Few primitives are deferred. Handling them in these loops would cost all rays of a software adapter's vector.
    var put_off = PutOff();
    loop {
        // Both inner loops run their body before the test: software adapters run the body once anyhow.
        loop {
            // Down: follows the nearer child and pushes the farther one. Pops if both boxes are missed.
            loop {
                if COUNT { nodes_visited += 1u; }
                let place = pair_place(link);
                let a = child_at(place, 0u, offsets);
                let b = child_at(place, 1u, offsets);
                let entry_a = box_entry(a, inverse, t_min, reach);
                let entry_b = box_entry(b, inverse, t_min, reach);
                let a_first = entry_a <= entry_b;
                if max(entry_a, entry_b) < NO_ENTRY {
                    top += 1;
                    stack[top] = select(a.link, b.link, a_first);
                }
                if min(entry_a, entry_b) < NO_ENTRY {
                    link = select(b.link, a.link, a_first);
                } else {
                    link = stack[top];
                    top -= 1;
                }
                spend_round();
                if (link & LEAF) != 0u || is_tired() { break; }
            }
            if link == DONE || is_step_over(link) { break; }
            // Across: tests the primitives of this leaf and of the leaves on top of the stack.
            slot = link & FIRST_SLOT;
            last = slot + ((link >> 28u) & 7u);
            loop {
                if COUNT { primitives_tested += 1u; }
                spend_round();
                let primitive = primitive_at(slot);
                let found = intersect(primitive, rays, scales, t_min);
                if any_is_enough {
                    let hit = found.hit & (found.t >= t_min) & (found.t <= hits.t);
                    hits.t = select(hits.t, F(NEVER), hit);
                    hits.slot = select(hits.slot, U(slot), hit);
                } else {
                    let hit = found.hit & is_nearer(hits, found.t, t_min, primitive.id);
                    hits.t = select(hits.t, found.t, hit);
                    hits.primitive = select(hits.primitive, U(primitive.id), hit);
                    hits.slot = select(hits.slot, U(slot), hit);
                }
                let doubted = bits_of(found.doubtful);
                if is_too_many(put_off, doubted) { break; }
                put_off = put_off_also(put_off, slot, doubted);
                slot += 1u;
                if slot > last {
                    link = stack[top];
                    top -= 1;
                    slot = link & FIRST_SLOT;
                    last = slot + ((link >> 28u) & 7u);
                }
                if any_is_enough && all_rays(hits.t == F(NEVER)) { link = DONE; }
                if (link & LEAF) == 0u || link == DONE { break; }
            }
            reach = hits.t;
            if (link & LEAF) != 0u || is_tired() { break; }
        }
        let waiting = (link & LEAF) != 0u && link != DONE;
        hits = settled(hits, rays, t_min, put_off, any_is_enough);
        put_off = PutOff();
        if !waiting { break; }
        // The rest of the leaf is pushed back. The root is visited without effect, to pop it again.
        top += 1;
        stack[top] = LEAF | ((last - slot) << 28u) | slot;
        link = 0u;
        reach = F(NEVER);
        // Neither that visit nor the repeated test is counted.
        if COUNT {
            nodes_visited -= 1u;
            primitives_tested -= 1u;
        }
    }
    let kept = keep_traversal(hits, &stack, top, link);
    cut_short |= (link != DONE) & !kept;
    return hits;
}

// Returns whether a third primitive must wait until the deferred ones are settled.
fn is_too_many(put_off: PutOff, doubted: u32) -> bool {
    return doubted != 0u && put_off.before != 0u;
}

// Adds a deferred primitive for the given rays; returns the same if there are none.
fn put_off_also(put_off: PutOff, slot: u32, doubted: u32) -> PutOff {
    let is_more = doubted != 0u;
    return PutOff(select(put_off.last, (slot << RAY_BITS) | doubted, is_more), select(put_off.before, put_off.last, is_more));
}

// Returns the hits after the second look at the deferred primitives.
fn settled(before: Hits, rays: Rays, t_min: F, put_off: PutOff, any_is_enough: bool) -> Hits {
    var hits = before;
    var left = put_off;
    loop {
        hits = settled_by_one(hits, rays, t_min, left.last, any_is_enough);
        left = PutOff(left.before, 0u);
        if left.last == 0u { break; }
    }
    return hits;
}

// Takes one ray per round.
fn settled_by_one(before: Hits, rays: Rays, t_min: F, doubtful: u32, any_is_enough: bool) -> Hits {
    var hits = before;
    var left = with_bits(doubtful);
    let slot = doubtful >> RAY_BITS;
    let primitive = primitive_at(slot);
    loop {
        let ray = first_ray(left);
        let direction = of_ray3(rays.direction, ray);
        let seen = look_again(primitive, rays.origin, direction, of_ray(t_min, ray));
        let t = at_second_look(primitive, slot, rays.origin, direction, seen);
        let chosen = RAY_INDEX == U(ray);
        let hit = chosen & left & is_nearer(hits, F(t), t_min, primitive.id);
        hits.t = select(hits.t, select(F(t), F(NEVER), any_is_enough), hit);
        hits.primitive = select(hits.primitive, U(primitive.id), hit & B(!any_is_enough));
        hits.slot = select(hits.slot, U(slot), hit);
        left &= !chosen;
        if !any_ray(left) { break; }
    }
    return hits;
}

// Returns where the first of the rays enters a child's box within [t_min, t_best], or NO_ENTRY.
fn box_entry(child: Child, inverse: F3, t_min: F, t_best: F) -> f32 {
    let low_x = child.low.x * inverse.x;
    let low_y = child.low.y * inverse.y;
    let low_z = child.low.z * inverse.z;
    let high_x = child.high.x * inverse.x;
    let high_y = child.high.y * inverse.y;
    let high_z = child.high.z * inverse.z;
    let entry_xy = larger(smaller(low_x, high_x), smaller(low_y, high_y));
    let exit_xy = smaller(larger(low_x, high_x), larger(low_y, high_y));
    let entry = larger(entry_xy, larger(smaller(low_z, high_z), t_min));
    let exit = smaller(exit_xy, smaller(larger(low_z, high_z), t_best));
    return smallest(select(F(NO_ENTRY), entry, entry <= exit));
}

//! if planes is none
// Returns the slot of some primitive with a hit in [t_min, t_max], or MISS. planes.wgsl has the version for scenes with
// planes.
fn any_slot(rays: Rays, t_min: F, t_max: F) -> U {
    return traverse(rays, t_min, t_max, true).slot;
}

//! if primitives is triangles or spheres or mixed
var<private> nodes_visited: u32;
var<private> primitives_tested: u32;

//! if primitives is triangles or spheres or mixed and planes is none
// Returns the nearest hits with t in [t_min, t_max]; at equal t the smallest primitive id. t_min is at least 0. A ray
// with t_max NEVER is not traced.
fn closest_hit(rays: Rays, t_min: F, t_max: F) -> Hits {
    return traverse(rays, t_min, t_max, false);
}

// Returns whether anything is hit with t in [t_min, t_max], under the conditions of closest_hit.
fn any_hit(rays: Rays, t_min: F, t_max: F) -> B {
    return any_slot(rays, t_min, t_max) != U(MISS);
}

//! if primitives is none and planes is none
// The kernel has no traversal: nothing is ever hit.

const nodes_visited: u32 = 0u;
const primitives_tested: u32 = 0u;

fn closest_hit(rays: Rays, t_min: F, t_max: F) -> Hits {
    return Hits(t_max, U(MISS), U(0u));
}

fn any_hit(rays: Rays, t_min: F, t_max: F) -> B {
    return t_max < t_max;
}
