// Traversal: every ray goes through closest_hit or any_hit, and both through one loop.
//
// A node is a pair of child boxes, two texels of four words: 16-bit corners on a grid over the whole scene (rounded
// outwards) in x, y, z and the child's link in w. A link with LEAF set is a run of 1 to 8 primitives: (count - 1) in bits
// 28 to 30, the first slot below; other links are indices of pairs. The root is pair 0.

struct Bvh {
    grid_origin: vec3f,   // world position of grid point 0
    extent: f32,          // largest side of the scene's box, world units
    grid_cell: vec3f,     // world size of a grid step
    _pad: u32,
}

struct Ray {
    origin: vec3f,
    direction: vec3f,     // any length; t counts in it
}

// A ray with what the triangle test precomputes (triangle.wgsl).
struct ShearedRay {
    origin: vec3f,
    direction: vec3f,
    shear_x: vec3f,
    shear_y: vec3f,
    shear_z: vec3f,
}

struct Hit {
    t: f32,               // t_max where nothing was hit
    primitive: u32,       // id in the scene's order, MISS where nothing was hit
    slot: u32,            // place in `primitives`
}

// What a primitive's test found; t = -1 where it was missed.
struct Candidate {
    t: f32,
    primitive: u32,
}

struct Surface {
    point: vec3f,
    geometric_normal: vec3f,   // unit, towards the viewer
    shading_normal: vec3f,     // unit, on the geometric normal's side
    material: u32,
}

const LEAF: u32 = 0x80000000u;
const FIRST_SLOT: u32 = 0x0fffffffu;
const DONE: u32 = 0xffffffffu;
// Box tests are conservative (DESIGN, section 2): rounding must hide neither a tie nor a flat leaf.
const BOX_MARGIN: f32 = 1.0 + 1.0 / 262144.0;
const NO_ENTRY: f32 = 3.402e38;

override COUNT: bool = false;
var<private> nodes_visited: u32;
var<private> primitives_tested: u32;
// A loop ended before its work did. llvmpipe ends all loops of a thread after 65,535 rounds together, without a word.
var<private> cut_short: bool;

fn largest_one(v: vec3f) -> vec3f {
    return v / max(max(abs(v.x), abs(v.y)), abs(v.z));
}

fn towards_viewer(normal: vec3f, direction: vec3f) -> vec3f {
    return select(normal, -normal, dot(normal, direction) > 0.0);
}

fn shear(ray: Ray) -> ShearedRay {
    let d = ray.direction;
    let size = abs(d);
    // The largest component's axis, and the two after it.
    var axis_x = vec3f(1.0, 0.0, 0.0);
    var axis_y = vec3f(0.0, 1.0, 0.0);
    var axis_z = vec3f(0.0, 0.0, 1.0);
    if size.x >= size.y && size.x >= size.z {
        axis_x = vec3f(0.0, 1.0, 0.0);
        axis_y = vec3f(0.0, 0.0, 1.0);
        axis_z = vec3f(1.0, 0.0, 0.0);
    } else if size.y >= size.z {
        axis_x = vec3f(0.0, 0.0, 1.0);
        axis_y = vec3f(1.0, 0.0, 0.0);
        axis_z = vec3f(0.0, 1.0, 0.0);
    }
    let dz = dot(d, axis_z);
    return ShearedRay(
        ray.origin,
        d,
        axis_x - axis_z * (dot(d, axis_x) / dz),
        axis_y - axis_z * (dot(d, axis_y) / dz),
        axis_z * (1.0 / dz),
    );
}

fn traverse(ray: Ray, t_min: f32, t_max: f32, any: bool) -> Hit {
    let sheared = shear(ray);
    // Reciprocals stay within ±1e30: WGSL promises nothing for a division by zero.
    let inverse = 1.0 / select(ray.direction, vec3f(1e-30), abs(ray.direction) < vec3f(1e-30));
    // Boxes are moved outwards by more than all absolute rounding in the slab and triangle tests can amount to;
    // rounding relative to t is BOX_MARGIN's.
    let to_grid = bvh.grid_origin - ray.origin;
    let slack = (bvh.extent + max(max(abs(to_grid.x), abs(to_grid.y)), abs(to_grid.z))) * (1.0 / 1048576.0);
    let per_cell = bvh.grid_cell * inverse;
    let from_low = (to_grid - slack) * inverse;
    let from_high = (to_grid + slack) * inverse;

    var hit = Hit(t_max, MISS, 0u);
    var stack: array<u32, STACK_SIZE>;
    stack[0] = DONE;
    var top = 0;
    var link = 0u;
    // Both inner loops run their body before they test: software adapters run a body of no trips once anyhow.
    loop {
        // Down: into the nearer child, the farther one on the stack; up where both boxes are missed.
        loop {
            if COUNT { nodes_visited += 1u; }
            let a = node_texel(2u * link);
            let b = node_texel(2u * link + 1u);
            let entry_a = box_entry(a, per_cell, from_low, from_high, t_min, hit.t);
            let entry_b = box_entry(b, per_cell, from_low, from_high, t_min, hit.t);
            let a_first = entry_a <= entry_b;
            if max(entry_a, entry_b) < NO_ENTRY {
                top += 1;
                stack[top] = select(a.w, b.w, a_first);
            }
            if min(entry_a, entry_b) < NO_ENTRY {
                link = select(b.w, a.w, a_first);
            } else {
                link = stack[top];
                top -= 1;
            }
            if (link & LEAF) != 0u { break; }
        }
        if link == DONE { break; }
        // Across: this leaf's primitives, and those of the leaves on top of the stack.
        var slot = link & FIRST_SLOT;
        var last = slot + ((link >> 28u) & 7u);
        loop {
            if COUNT { primitives_tested += 1u; }
            let candidate = intersect_primitive(slot, sheared, t_min);
            let nearer = candidate.t < hit.t || (candidate.t == hit.t && candidate.primitive < hit.primitive);
            if candidate.t >= t_min && nearer {
                hit = Hit(candidate.t, candidate.primitive, slot);
            }
            slot += 1u;
            if slot > last {
                link = stack[top];
                top -= 1;
                slot = link & FIRST_SLOT;
                last = slot + ((link >> 28u) & 7u);
            }
            if any && hit.primitive != MISS { link = DONE; }
            if (link & LEAF) == 0u || link == DONE { break; }
        }
        if link == DONE { break; }
    }
    cut_short |= link != DONE;
    return hit;
}

// Where the ray enters a child's box within [t_min, t_best], or NO_ENTRY.
fn box_entry(node: vec4u, per_cell: vec3f, from_low: vec3f, from_high: vec3f, t_min: f32, t_best: f32) -> f32 {
    let low = vec3f(f32(node.x & 0xffffu), f32(node.x >> 16u), f32(node.y & 0xffffu));
    let high = vec3f(f32(node.y >> 16u), f32(node.z & 0xffffu), f32(node.z >> 16u));
    let t_low = low * per_cell + from_low;
    let t_high = high * per_cell + from_high;
    let near = min(t_low, t_high);
    let far = max(t_low, t_high);
    let entry = max(max(near.x, near.y), max(near.z, t_min));
    let exit = min(min(far.x, far.y), min(far.z, t_best));
    return select(NO_ENTRY, entry, entry <= exit * BOX_MARGIN);
}

// The nearest hit with t in [t_min, t_max]; of equal t the smallest primitive id.
fn closest_hit(ray: Ray, t_min: f32, t_max: f32) -> Hit {
    return traverse(ray, t_min, t_max, false);
}

// Is anything hit with t in [t_min, t_max]?
fn any_hit(ray: Ray, t_min: f32, t_max: f32) -> bool {
    return traverse(ray, t_min, t_max, true).primitive != MISS;
}
