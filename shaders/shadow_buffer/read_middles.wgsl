// Finishes a light's shadow-buffer after all primitives are drawn. It keeps the nearest hit among these primitives and
// the planes, which are not drawn (docs/SHADOW-BUFFER.md).
//
// launch  one thread per block of 1x1 or 2x2 texels of the current rows
// updates t_buffer  [current rows][image_size.x][2]    from the complement of the nearest t and slot + 1 to t and slot;
//                                                      slot is MISS for a miss and UNFILLED if unknown
// adds    counters  [COUNTERS]

//! use counters, lane, pixels, planes, shadow_canvas, t_buffer

var<storage, read_write> t_buffer: array<u32>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn read_middles(@builtin(global_invocation_id) id: vec3u) {
    let texels = block_texels(id);
    let wanted = inside_table(texels);
    if !any_ray(wanted) { return; }
    let nearest = nearest_plane(rays_from(texels), F(0.0), F(FAR));
    var ray = 0u;
    loop {
        if of_ray_b(wanted, ray) {
            let place = 2u * pixel_index(pixel_of_ray(texels, ray));
            let shown = shown_at(vec2u(t_buffer[place], t_buffer[place + 1u]), nearest, ray);
            t_buffer[place] = bitcast<u32>(shown.t);
            t_buffer[place + 1u] = shown.slot;
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    count_view(counted_row(), 0u, 0u, primitives_tested);
}
