// Traces one ray of each path that is followed, adds the light that it finds, and lets the path go on: all in one
// kernel, for CPU adapters.
//
// launch  one thread per list entry, dispatched indirectly
// updates brought    [height * width]
// reads   paths      list of this ray
// appends paths      list of the next ray
// adds    counters   [height * COUNTERS]

//! use bvh, counters, emitters, frame, lane, path_steps, paths, pixels, planes, rays, scattering, sobol, stack
//! use textures

var<storage, read_write> brought: array<Brought>;
var<storage, read_write> paths: Paths;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_paths(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let ray = frame.paths.ray;
    let place = listed_thread(id);
    if place >= atomicLoad(&paths.heads[ray - 1u].count) { return; }
    let index = paths.each[place].entries[(ray - 1u) & 1u];
    var path = paths.each[index];
    let pixel = vec2u(index % frame.band.size.x, index / frame.band.size.x);
    begin_points(pixel, frame.paths.first + brought[index].paths - 1u);
    travelled_before = path.travelled;
    let rays = Rays(path.origin, all3(path.direction));
    let hits = closest_hit(rays, 0.0, FAR);
    var light = vec3f(0.0);
    if hits.primitive == MISS {
        light = sky_of_path(path.direction, path.density);
    } else {
        let vertex = vertex_at(rays, hits);
        path.weight *= pow(vertex.left, vec3f(hits.t));
        light = emission_of_path(vertex, path.density, hits.t);
        if ray <= frame.paths.bounces {
            let sent = sent_from_emitters(vertex, ray * PAIRS, false);
            light += vertex.lobes.diffuse * sent.diffuse + sent.glossy;
            if go_on(index, path, vertex, hits.t, ray) { follow(index, ray); }
        }
    }
    add_light(index, path.is_diffuse, light * path.weight);
    count_pixel(pixel);
    count_view(pixel.y, light_rays, nodes_visited, primitives_tested);
    atomicAdd(&counters[pixel.y * COUNTERS + SENT_RAYS], 1u);
    atomicAdd(&counters[pixel.y * COUNTERS + OWN_SHADOW_RAYS], light_rays);
}
