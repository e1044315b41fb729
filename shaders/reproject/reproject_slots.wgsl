// Pass 2 of 3 of `Buffer`, first half: stores the key of sample i in slot i mod depth of the 3D buffer, at the target
// pixel where it lands (thesis, 3.1.2.1). Slots are written by atomicMax, so a collision always keeps the nearest
// sample.
//
// launch  one thread per pixel of the source in a band of rows
// reads   source    [height * width]
// writes  slots     [rows * width * depth]   keys, or EMPTY; cleared by the host
// adds    counters  [height * COUNTERS]      LOST_CANDIDATES: collisions, each of which loses one candidate

//! use camera, counters, frame, pixels

var<storage, read> source: array<Pixel>;
var<storage, read_write> slots: array<atomic<u32>>;
var<storage, read_write> counters: array<atomic<u32>>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn reproject_slots(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let column = target_column(pixel, source[pixel_index(pixel)].depth);
    if column < 0 { return; }
    let cell = (pixel.y - frame.band.row_begin) * frame.band.size.x + u32(column);
    let place = cell * frame.band.buffer_depth + pixel.x % frame.band.buffer_depth;
    let before = atomicMax(&slots[place], key_of(pixel.x, u32(column)));
    if before != 0u {
        atomicAdd(&counters[pixel.y * COUNTERS + LOST_CANDIDATES], 1u);
    }
}
