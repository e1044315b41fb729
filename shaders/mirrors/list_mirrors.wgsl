// Runs after a view's last step in scenes with mirrors or glass. Lists the pixels that show such surfaces, for
// trace_mirrored.
//
// launch  one thread per pixel of the current rows
// reads   view       [height * width]
// appends mirrors    TO_TRACE

//! use fetch, lane, lists, materials, pixels, primitive, wanted

var<storage, read> view: array<Pixel>;
var<storage, read_write> lists: Lists;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn list_mirrors(@builtin(global_invocation_id) id: vec3u) {
    let pixels = block_pixels(id);
    if !all_rays(inside_rows(pixels)) { return; }
    let index = pixel_index(pixel_of_ray(pixels, 0u));
    let slot = view[index].slot;
    if slot == MISS || !sends_rays(primitive_texel(slot, 2u).w & MATERIAL) { return; }
    append(TO_TRACE, reserve(TO_TRACE, 1u), index);
}
