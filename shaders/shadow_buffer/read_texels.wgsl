// Finishes a light's shadow-buffer for the hybrid rule after all primitives are drawn. It keeps the plane of the
// nearest hit among these primitives and the infinite planes, which are not drawn. The slot is marked if another
// infinite plane lies in front of that plane (docs/SHADOW-BUFFER.md).
//
// launch  one thread per texel of the current rows
// reads   t_buffer  [current rows][image_size.x][2]    complement of the nearest t, and slot + 1
// writes  texels    [current rows][image_size.x]       xyz: plane q, with q.x = 1 for points x from the light;
//                                                      w: slot, SOMETHING_BEFORE with slot, MISS for a miss,
//                                                      or UNFILLED if unknown
// adds    counters  [COUNTERS]

//! use counters, frame, lane, pixels, planes, shadow_buffer, shadow_canvas, t_buffer

var<storage, read> t_buffer: array<u32>;
var<storage, read_write> texels: array<vec4u>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn read_texels(@builtin(global_invocation_id) id: vec3u) {
    let lane = block_texels(id);
    if !any_ray(inside_table(lane)) { return; }
    let nearest = nearest_plane(rays_from(lane), F(0.0), F(FAR));
    let texel = pixel_of_ray(lane, 0u);
    let index = pixel_index(texel);
    let slot = shown_at(vec2u(t_buffer[2u * index], t_buffer[2u * index + 1u]), nearest, 0u).slot;
    var plane: vec3f;
    var mark = 0u;
    if slot < UNFILLED {
        plane = shown_plane(slot);
        let at = vec2f(f32(texel.y + frame.band.first_row), f32(texel.x));
        mark = select(0u, SOMETHING_BEFORE, plane_stands_before(slot, plane, at));
    }
    texels[index] = vec4u(bitcast<vec3u>(plane), slot | mark);
    count_view(counted_row(), 0u, 0u, primitives_tested);
}
