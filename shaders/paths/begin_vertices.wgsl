// Begins a path in each pixel that shows a surface, for kernels that trace and shade apart.
//
// launch  one thread per pixel of the current rows
// reads   view       [height * width]
// updates brought    [height * width]
// appends paths      list 0
// adds    counters   [height * COUNTERS]

//! use first_vertex, lane, paths, pixels, wanted

var<storage, read> view: array<Pixel>;
var<storage, read_write> brought: array<Brought>;
var<storage, read_write> paths: Paths;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn begin_vertices(@builtin(global_invocation_id) id: vec3u) {
    let pixels = block_pixels(id);
    if all_rays(inside_rows(pixels)) { begin_vertex(pixels); }
}
