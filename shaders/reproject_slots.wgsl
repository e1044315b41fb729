// Pass 2 of 4 of `Buffer`, first half: store each left column at the right pixel it lands on, in slot i mod depth of
// the 3D buffer (thesis, 3.1.2.1). Slots are written by atomicMax, so that a collision has one outcome: the nearest.
//
// launch  one thread per left pixel of a band of rows
// reads   hits      [2 * height * width]     left half
// writes  slots     [rows * width * depth]   left column + 1, or EMPTY; cleared by the host
// adds    counters  [height * COUNTERS]      one for each candidate that met a taken slot: of the two one is lost

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read> hits: array<PixelHit>;
@group(1) @binding(2) var<storage, read_write> slots: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn reproject_slots(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let column = right_column(pixel.x, hits[pixel_index(pixel)].depth);
    if column < 0 { return; }
    let cell = (pixel.y - frame.row_begin) * frame.image_size.x + u32(column);
    let before = atomicMax(&slots[cell * frame.buffer_depth + pixel.x % frame.buffer_depth], pixel.x + 1u);
    if before != 0u {
        atomicAdd(&counters[pixel.y * COUNTERS + LOST_CANDIDATES], 1u);
    }
}
