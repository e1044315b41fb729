// Writes the hit of each pixel of a view, as trace_hits does, from a T-buffer and the planes. Planes are not drawn,
// since their projections are unbounded. Each ray tests them here, as closest_hit does before traversal. A pixel with a
// t but no primitive is listed to be traced: on some adapters, two kernels with the same source may round differently.
//
// launch  one thread per block of 1x1 or 2x2 pixels of the current rows
// reads   t_buffer  [height * width * 2]
// writes  view      [height * width]      all fields except color; listed pixels get depth 0, where their ray begins
// adds    counters  [height * COUNTERS]
// appends lists     TO_TRACE

//! use camera, counters, lane, lists, pixels, planes, view, wanted

var<storage, read> t_buffer: array<u32>;
var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;
var<storage, read_write> lists: Lists;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn read_t_buffer(@builtin(global_invocation_id) id: vec3u) {
    let pixels = block_pixels(id);
    let wanted = inside_rows(pixels);
    if !any_ray(wanted) { return; }
    let rays = rays_of(pixels);
    var nearest = nearest_plane(rays, F(0.0), F(FAR));
    var nameless: U;
    var ray = 0u;
    loop {
        if of_ray_b(wanted, ray) {
            let place = 2u * pixel_index(pixel_of_ray(pixels, ray));
            let key = t_buffer[place];
            let t = bitcast<f32>(~key);
            // At equal t the primitive of the tree wins: its id is smaller than any plane's.
            if key != 0u && t <= of_ray(nearest.t, ray) {
                let named = t_buffer[place + 1u];
                nearest.t = with_ray(nearest.t, ray, select(t, 0.0, named == 0u));
                nearest.primitive = with_ray_u(nearest.primitive, ray, select(0u, MISS, named == 0u));
                nearest.slot = with_ray_u(nearest.slot, ray, named - 1u);
                nameless = with_ray_u(nameless, ray, select(0u, 1u, named == 0u));
            }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    keep_hits(pixels, wanted, nearest);
    let to_trace = nameless == U(1u);
    list_nameless(pixels, to_trace);
    let first = pixel_of_ray(pixels, 0u);
    if any_ray(to_trace) { atomicAdd(&counters[first.y * COUNTERS + MISSED_PIXELS], count_rays(to_trace)); }
    count_pixel(first);
    count_view(first.y, 0u, nodes_visited, primitives_tested);
}

fn list_nameless(pixels: Pixels, to_trace: B) {
    var place = reserve(TO_TRACE, count_rays(to_trace));
    var ray = 0u;
    loop {
        if of_ray_b(to_trace, ray) {
            append(TO_TRACE, place, pixel_index(pixel_of_ray(pixels, ray)));
            place += 1u;
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
}
