// Pass 2 of 3: moves each source hit to the target pixel that sees the same point.
//
// launch  one thread per pixel of the source
// reads   source  [height * width]
// writes  view    [height * width]  marks: key of the sample, or EMPTY; cleared by the host

//! use camera, pixels

// A Pixel whose marks are written by several threads.
struct ContestedPixel {
    depth: f32,
    slot: u32,
    marks: atomic<u32>,
    color: u32,
}

var<storage, read> source: array<Pixel>;
var<storage, read_write> view: array<ContestedPixel>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn reproject(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let column = target_column(pixel, source[pixel_index(pixel)].depth);
    if column < 0 { return; }
    // Among the samples that land in one column, the last one in the sweep is the nearest (DESIGN, section 2; thesis,
    // 3.1.2.2). So its key serves as a depth key. The maximum is commutative, so the order of threads does not matter.
    atomicMax(&view[pixel_index(vec2u(u32(column), pixel.y))].marks, key_of(pixel.x, u32(column)));
}
