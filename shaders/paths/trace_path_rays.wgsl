// Finds the hit of one ray of each path that is followed.
//
// launch  one thread per list entry, dispatched indirectly
// reads   paths      list of this ray
// updates paths      the ray's hit
// adds    counters   [height * COUNTERS]

//! use bvh, counters, frame, lane, paths, pixels, planes, rays, stack

var<storage, read_write> paths: Paths;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_path_rays(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let ray = frame.paths.ray;
    let place = listed_thread(id);
    if place >= atomicLoad(&paths.heads[ray].count) { return; }
    let index = paths.each[place].entries[ray & 1u];
    let hits = closest_hit(Rays(paths.each[index].origin, all3(paths.each[index].direction)), 0.0, FAR);
    paths.each[index].t = hits.t;
    paths.each[index].slot = select(hits.slot, MISS, hits.primitive == MISS);
    let row = index / frame.band.size.x;
    count_pixel(vec2u(index % frame.band.size.x, row));
    count_view(row, 0u, nodes_visited, primitives_tested);
    atomicAdd(&counters[row * COUNTERS + SENT_RAYS], 1u);
}
