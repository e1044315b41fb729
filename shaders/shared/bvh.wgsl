// Traversal: every ray goes through closest_hit or any_hit, and both through one loop.
//
// A lane's rays start at one point and share a stack: what one of them must visit, all test. A node is a pair of child
// boxes, each with a link. A link with LEAF set is a run of 1 to 8 primitives: (count - 1) in bits 28 to 30, the first
// slot below; other links are indices of pairs. The root is pair 0.
//! if cutouts is none
struct Bvh {
    grid_origin: vec3f,   // world position of grid point 0
    extent: f32,          // largest side of the scene's box, world units
    grid_cell: vec3f,     // world size of a grid step
    zero: u32,            // 0, which compilers do not know
}
//! end
// A lane's rays. t counts in lengths of the direction, which may be any.
struct Rays {
    origin: vec3f,
    direction: F3,
}

// Links that a traversal has yet to follow, above DONE.
alias Stack = array<u32, STACK_SIZE>;

// What tests of primitives ask of a lane's rays besides.
struct Scales {
    length: F,               // of the direction
    per_length_squared: F,
}

// What a lane's rays hit.
struct Hits {
    t: F,                 // t_max where nothing was hit; any_slot leaves it open
    primitive: U,         // id in the scene's order, MISS where nothing was hit; any_slot leaves it open
    slot: U,              // place among the primitives
}

// A child's box from the rays' origin, widened by the slack.
struct Child {
    low: vec3f,
    high: vec3f,
    link: u32,
}

//! if texels is corners or spheres
// What an intersection needs of a primitive. A sphere has its centre in a and its radius in b.x.
// Where there are ellipsoids: ellipsoid.wgsl.
struct Primitive {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    id: u32,          // in the scene's order
    component: u32,   // of connected primitives, from bit 1 on; IS_SPHERE
    reach: f32,       // of a triangle: at least the length of its longest edge
}
//! end

// What a lane's rays find of one primitive.
struct Found {
    hit: B,
    t: F,          // where it is hit
    doubtful: B,   // not told by this test, which is quick, but by look_again
}

// Doubtful primitives that wait for their second look, each as slot << RAY_BITS with a bit for each ray that doubts it;
// 0: none. Two, since a ray that doubts a triangle mostly doubts a neighbour.
struct PutOff {
    last: u32,
    before: u32,
}

// Where one ray hit.
struct Surface {
    geometric_normal: vec3f,   // unit, towards the viewer
    shading_normal: vec3f,     // unit, on the geometric normal's side
    material: u32,
    component: u32,            // of connected primitives
    reach: f32,                // of a triangle: at least the length of its longest edge; 0 of a ball
    outward: vec3f,            // of a ball: unit, from its centre, as if it were a sphere
    radius: f32,               // of a ball
    from_outside: bool,        // the ray comes from the side on which its corners run counterclockwise, or from outside a ball
}

// Lowest bit of a component: of a sphere or an ellipsoid; and of a plane, which has as little to do with triangles.
const IS_SPHERE: u32 = 1u;
const LEAF: u32 = 0x80000000u;
const FIRST_SLOT: u32 = 0x0fffffffu;
const DONE: u32 = 0xffffffffu;
// Of a primitive's third texel's w: the material. Above it stand the upper 16 bits of a triangle's reach.
const MATERIAL: u32 = 0x0000ffffu;
const NO_ENTRY: f32 = 3.402e38;
// The t_max of a ray that is not to be traced, and the t of one that any_hit is finished with: before every box.
const NEVER: f32 = -3.402e38;

override COUNT: bool = false;
// A loop ended before its work did. llvmpipe ends all loops of a thread after 65,535 rounds together, without a word.
var<private> cut_short: bool;

// Written out: the built-in functions also order NaN, which costs two instructions more for each.
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

// Directions along a vector from the rays' origin.
fn along(direction: F3, v: vec3f) -> F {
    return direction.x * v.x + direction.y * v.y + direction.z * v.z;
}

fn scales_of(rays: Rays) -> Scales {
    let squared = dot3(rays.direction, rays.direction);
    return Scales(sqrt(squared), 1.0 / squared);
}

// Reciprocals stay within ±1e30: WGSL promises nothing for a division by zero.
fn reciprocal(v: F) -> F {
    return 1.0 / select(v, F(1e-30), abs(v) < F(1e-30));
}

// Of equal t the smallest id wins, whatever the order of the tests.
fn is_nearer(hits: Hits, t: F, t_min: F, id: u32) -> B {
    return (t >= t_min) & ((t < hits.t) | ((t == hits.t) & (U(id) < hits.primitive)));
}

// What brings boxes' corners from the grid's origin to theirs from a point.
struct Offsets {
    low: vec3f,
    high: vec3f,
}

// Boxes are widened by more than rounding can amount to in the slab and primitive tests, so that it hides neither a tie
// nor a flat leaf (DESIGN, section 2). By no more: a shadow ray begins so close to its surface that a box of it would
// be met in vain.
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
    // The t that boxes must begin before.
    var reach = hits.t;
    // Few are, and what is done for them in these loops every ray of a software adapter's vector pays for.
    var put_off = PutOff();
    loop {
        // Both inner loops run their body before they test: software adapters run a body of no trips once anyhow.
        loop {
            // Down: into the nearer child, the farther one on the stack; up where both boxes are missed.
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
            // Across: this leaf's primitives, and those of the leaves on top of the stack.
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
        // The rest of the leaf goes back on the stack, and the root is visited in vain, to take it from there.
        top += 1;
        stack[top] = LEAF | ((last - slot) << 28u) | slot;
        link = 0u;
        reach = F(NEVER);
        // Neither that visit nor the test that is made again counts.
        if COUNT {
            nodes_visited -= 1u;
            primitives_tested -= 1u;
        }
    }
    let kept = keep_traversal(hits, &stack, top, link);
    cut_short |= (link != DONE) & !kept;
    return hits;
}

// A third primitive must wait until those before it are settled.
fn is_too_many(put_off: PutOff, doubted: u32) -> bool {
    return doubted != 0u && put_off.before != 0u;
}

// With one more, for the rays whose bits are given: or the same, for none.
fn put_off_also(put_off: PutOff, slot: u32, doubted: u32) -> PutOff {
    let is_more = doubted != 0u;
    return PutOff(select(put_off.last, (slot << RAY_BITS) | doubted, is_more), select(put_off.before, put_off.last, is_more));
}

// The hits once more, after a second look at what was put off.
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

// One ray a round.
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

// Where the first of the rays enters a child's box within [t_min, t_best], or NO_ENTRY.
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
// The place among the primitives of something that is hit with t in [t_min, t_max], or MISS. Where there are planes:
// planes.wgsl.
fn any_slot(rays: Rays, t_min: F, t_max: F) -> U {
    return traverse(rays, t_min, t_max, true).slot;
}

//! if primitives is triangles or spheres or mixed
var<private> nodes_visited: u32;
var<private> primitives_tested: u32;

//! if primitives is triangles or spheres or mixed and planes is none
// The nearest hits with t in [t_min, t_max]; of equal t the smallest primitive id. t_min is at least 0; t_max NEVER
// leaves a ray out.
fn closest_hit(rays: Rays, t_min: F, t_max: F) -> Hits {
    return traverse(rays, t_min, t_max, false);
}

// Is anything hit with t in [t_min, t_max]? As closest_hit else.
fn any_hit(rays: Rays, t_min: F, t_max: F) -> B {
    return any_slot(rays, t_min, t_max) != U(MISS);
}

//! if primitives is none and planes is none
// No traversal in the kernel: nothing is ever hit.

const nodes_visited: u32 = 0u;
const primitives_tested: u32 = 0u;

fn closest_hit(rays: Rays, t_min: F, t_max: F) -> Hits {
    return Hits(t_max, U(MISS), U(0u));
}

fn any_hit(rays: Rays, t_min: F, t_max: F) -> B {
    return t_max < t_max;
}
