// Pass 2 of 4: carry each left-eye hit to the right-eye pixel that sees the same point.
//
// launch  one thread per left pixel
// reads   hits          [2 * height * width]  left half: depth, FAR = nothing hit
// writes  right_source  [height * width]      left column + 1, or EMPTY; cleared by the host

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read> hits: array<PixelHit>;
@group(1) @binding(2) var<storage, read_write> right_source: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn reproject(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let column = right_column(pixel.x, hits[pixel_index(pixel)].depth);
    if column < 0 { return; }
    // Among the left columns that land on one right column, the largest is the nearest surface (DESIGN, section 2;
    // thesis, 3.1.2.2): the column is the depth key, and max commutes, so the order of the threads does not matter.
    atomicMax(&right_source[pixel_index(vec2u(u32(column), pixel.y))], pixel.x + 1u);
}
