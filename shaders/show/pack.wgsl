// Copies the requested parts of a view's pixels for the host. This saves a quarter to three quarters of the bytes to
// read back.
//
// launch  one thread per pixel of the current rows
// reads   view    [rows * width]
// writes  packed  [words_read][rows * width]  colour with marks in place of alpha, which is 255; then depth; then slot

//! use frame, marks, pixels

var<storage, read> view: array<Pixel>;
var<storage, read_write> packed: array<u32>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn pack(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let index = pixel_index(pixel);
    let pixels = frame.band.size.x * frame.band.size.y;
    let record = view[index];
    packed[index] = (record.color & 0xffffffu) | (record.marks & (BAD | MISSED | ASKED));
    if frame.display.words_read > 1u { packed[pixels + index] = bitcast<u32>(record.depth); }
    if frame.display.words_read > 2u { packed[2u * pixels + index] = record.slot; }
}
