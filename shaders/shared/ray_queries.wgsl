// Traversal by the device's ray queries, instead of bvh.wgsl.
//
// The device names primitives, and the test of bvh.wgsl decides on each. In scenes of triangles only, the device knows
// triangles that are slightly larger, so rounding on the device loses no ray between two of them. In other scenes it
// knows a box around each primitive (src/accel/outlines.rs).

//! use counters, cutouts, fetch, lane, pixels, primitive, primitives, rays

//! if tracing is ray_queries
// The scene's primitives but its planes, in the tree's order: triangles, or boxes if BY_BOXES is set.
var acceleration: acceleration_structure;

// Flags of a query. The first makes the device choose the nearest triangle, the second passes every triangle to the
// kernel.
const FORCE_OPAQUE: u32 = 1u;
const FORCE_NO_OPAQUE: u32 = 2u;
const NOTHING_MET: u32 = 0u;

// What a query asks for. One variable serves all queries of a ray, since drivers keep a stack in memory for each
// variable.
const ASK_NEAREST: u32 = 0u;   // the nearest triangle, which the device chooses
const ASK_ALL: u32 = 1u;       // all primitives in the range, until a hit ends it
const ASK_NEAR: u32 = 2u;      // all triangles at almost the t of the hit

// Largest difference between the device's t of a triangle and the kernels': a share of t, and a share of the
// coordinates.
const T_SLACK: f32 = 1.0 / 16384.0;
const PLACE_SLACK: f32 = 1.0 / 1048576.0;

fn traverse(rays: Rays, t_min: F, t_max: F, any_is_enough: bool) -> Hits {
    var hits = Hits(t_max, MISS, select(0u, MISS, any_is_enough));
    if t_max < t_min { return hits; }
    let direction = of_ray3(rays.direction, 0u);
    let names_all = any_is_enough || BY_BOXES;
    var ask = select(ASK_NEAREST, ASK_ALL, names_all || CUTOUTS);
    let places = largest_of(abs(rays.origin)) + largest_of(abs(bvh.grid_origin)) + bvh.extent;
    let slack = places * PLACE_SLACK * inverseSqrt(dot(direction, direction));
    // The kernels' test limits t to the exact range.
    var near = max(t_min * (1.0 - T_SLACK) - slack, 0.0);
    var far = min(t_max * (1.0 + T_SLACK) + slack, FAR);
    var query: ray_query;
    var ended = false;
    loop {
        let flag = select(FORCE_NO_OPAQUE, FORCE_OPAQUE, ask == ASK_NEAREST);
        rayQueryInitialize(&query, acceleration, RayDesc(flag, 255u, near, far, rays.origin, direction));
        ended = false;
        loop {
            if !rayQueryProceed(&query) {
                ended = true;
                break;
            }
            let named = rayQueryGetCandidateIntersection(&query);
            let earlier = hits.primitive;
            hits = hits_with(hits, FIRST_QUERIED + named.primitive_index, rays, t_min);
            if hits.primitive == earlier { continue; }
            if any_is_enough {
                ended = true;
                break;
            }
            let nearest = hits.t;
            if ask != ASK_ALL { continue; }
            if BY_BOXES { rayQueryGenerateIntersection(&query, nearest); } else { rayQueryConfirmIntersection(&query); }
        }
        if ask == ASK_NEAREST {
            let named = rayQueryGetCommittedIntersection(&query);
            if named.kind == NOTHING_MET { break; }
            hits = hits_with(hits, FIRST_QUERIED + named.primitive_index, rays, t_min);
        }
        if names_all || ask == ASK_NEAR { break; }
        if hits.primitive == MISS {
            // If the ray only passes the margin of the nearest triangle, all others are asked.
            if ask == ASK_ALL { break; }
            ask = ASK_ALL;
        } else {
            // The device's t decided so far. Triangles at almost the same t are compared by the kernels' t.
            ask = ASK_NEAR;
            near = max(hits.t * (1.0 - T_SLACK) - slack, 0.0);
            far = min(hits.t * (1.0 + T_SLACK) + slack, FAR);
        }
    }
    cut_short |= !ended;
    return hits;
}

fn largest_of(v: vec3f) -> f32 { return max(max(v.x, v.y), v.z); }

// Returns the hits after the test of a primitive, which is that of bvh.wgsl.
fn hits_with(before: Hits, slot: u32, rays: Rays, t_min: f32) -> Hits {
    let primitive = primitive_at(slot);
    let found = intersect(primitive, rays, scales_of(rays), t_min);
    var t = select(-1.0, found.t, found.hit);
    if found.doubtful {
        let direction = of_ray3(rays.direction, 0u);
        let again = look_again(primitive, rays.origin, direction, t_min);
        t = at_second_look(primitive, slot, rays.origin, direction, again);
    }
    if !is_nearer(before, t, t_min, primitive.id) { return before; }
    return Hits(t, primitive.id, slot);
}
