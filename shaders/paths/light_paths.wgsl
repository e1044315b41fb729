// Finds how much of the proposed light arrives at each path's vertex, and adds it.
//
// launch  one thread per list entry, dispatched indirectly
// updates brought    [height * width]
// reads   paths      list of this ray
// reads   proposed   [height * width]
// adds    counters   [height * COUNTERS]

//! use counters, emitters, first_vertex, frame, path_steps, paths, pixels, proposed, stack, textures

var<storage, read_write> brought: array<Brought>;
var<storage, read_write> paths: Paths;
var<storage, read_write> proposed: array<Proposed>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn light_paths(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let ray = frame.paths.ray;
    let place = listed_thread(id);
    if place >= atomicLoad(&paths.heads[ray].count) { return; }
    let index = paths.each[place].entries[ray & 1u];
    if proposed[index].is_open == 0u { return; }
    travelled_before = proposed[index].travelled;
    let start = proposed[index].start;
    let bright = plus(arrived(start, proposed[index].rays[1]), arrived(start, proposed[index].rays[2]));
    let sent = plus(passed(start, proposed[index].rays[0], ray == 0u), bright);
    if ray == 0u {
        add_first_light(index, sent);
    } else {
        let light = proposed[index].emitted + (proposed[index].albedo * sent.diffuse + sent.glossy);
        add_light(index, proposed[index].is_diffuse, light * proposed[index].weight);
    }
    let pixel = vec2u(index % frame.band.size.x, index / frame.band.size.x);
    count_pixel(pixel);
    count_view(pixel.y, light_rays, nodes_visited, primitives_tested);
    atomicAdd(&counters[pixel.y * COUNTERS + OWN_SHADOW_RAYS], light_rays);
}
