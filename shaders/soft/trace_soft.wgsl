// Traces rays from each pixel's hit to points on one extended light, or to the surroundings.
//
// launch  one thread per block of 1x1 or 2x2 pixels of the current rows
// reads   view      [height * width]
// adds    counters  [height * COUNTERS], and the masks after them

//! use lane, pixels, soft, stack, wanted

var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn trace_soft(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let pixels = block_pixels(id);
    let wanted = inside_rows(pixels);
    if !any_ray(wanted) { return; }
    ask_light(pixels, wanted);
}
