// Pass 2 of 3 of `Buffer`, second half: finds the largest key, which belongs to the nearest sample, in the slots of
// each target pixel.
//
// launch  one thread per pixel of the target in a band of rows
// reads   slots  [rows * width * depth]  keys of samples, or EMPTY
// writes  view   [height * width]        marks: key, or EMPTY

//! use frame, pixels

var<storage, read> slots: array<u32>;
var<storage, read_write> view: array<Pixel>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn gather_slots(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let cell = (pixel.y - frame.band.row_begin) * frame.band.size.x + pixel.x;
    var nearest = 0u;
    // The loop's end must not be a uniform alone: Mesa's software driver would recompile the kernel for each depth.
    let end = (cell + 1u) * frame.band.buffer_depth;
    for (var slot = cell * frame.band.buffer_depth; slot < end; slot += 1u) {
        nearest = max(nearest, slots[slot]);
    }
    view[pixel_index(pixel)].marks = nearest;
}
