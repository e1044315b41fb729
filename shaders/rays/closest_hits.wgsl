// Finds the nearest hit of each ray of a list (shared/ray_list.wgsl), for users and tests. It runs in one dispatch or
// in several (shared/in_steps.wgsl).
//
// launch  one thread per ray, or per four rays; in steps, until all have finished
// updates steps     one lane per thread, in steps
// writes  found     [rays]      t as bits (t_max for a miss), primitive id
// adds    counters  [COUNTERS]  as for one row of a view

//! use bvh, counters, frame, in_steps, lane, pixels, planes, ray_list, stack

var<storage, read_write> found: array<vec2u>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn closest_hits(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let first = id.x * RAYS;
    if first >= frame.band.size.x || !begin_step(id.x) { return; }
    let listed = listed_rays(first);
    let hits = closest_hit(listed.rays, listed.t_min, listed.t_max);
    var ray = 0u;
    loop {
        if !paused && first + ray < frame.band.size.x {
            found[first + ray] = vec2u(bitcast<u32>(of_ray(hits.t, ray)), of_ray_u(hits.primitive, ray));
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    end_step();
    count_view(0u, 0u, nodes_visited, primitives_tested);
}
