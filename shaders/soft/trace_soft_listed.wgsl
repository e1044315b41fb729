// Traces soft light like trace_soft.wgsl, for listed pixels of the target. Sources whose share is known from the
// source's samples are skipped.
//
// launch  one thread per list entry, or per four entries, dispatched indirectly
// reads   lists     TO_SHADE
// reads   view      [height * width]
// adds    counters  [height * COUNTERS], and the masks after them

//! use lane, lists, pixels, soft, stack, visibility

var<storage, read_write> lists: Lists;
var<storage, read_write> view: array<Pixel>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn trace_soft_listed(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) thread: u32) {
    begin_stack(thread);
    let listed = listed_pixels(TO_SHADE, listed_thread(id));
    if !any_ray(listed.wanted) { return; }
    ask_light(listed.pixels, listed.wanted);
}
