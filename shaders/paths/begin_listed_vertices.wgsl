// Begins a path in each listed pixel of a view that reuses light of another, for kernels that trace and shade apart.
//
// launch  one thread per list entry, dispatched indirectly
// reads   view       [height * width]
// reads   lists      TO_TRACE
// updates brought    [height * width]
// appends paths      list 0
// adds    counters   [height * COUNTERS]

//! use first_vertex, lane, lists, paths, pixels

var<storage, read> view: array<Pixel>;
var<storage, read_write> brought: array<Brought>;
var<storage, read_write> paths: Paths;
var<storage, read_write> lists: Lists;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(LIST_WORKGROUP)
fn begin_listed_vertices(@builtin(global_invocation_id) id: vec3u) {
    let listed = listed_pixels(TO_TRACE, listed_thread(id));
    if all_rays(listed.wanted) { begin_vertex(listed.pixels); }
}
