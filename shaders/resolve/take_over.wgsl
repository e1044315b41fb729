// Pass 3 of 3 of the thesis's methods, last part: each reused pixel copies the source pixel that its key identifies. It
// runs after the checks. Bad pixels have been traced by then and are not copied.
//
// launch  one thread per pixel of the target in the current rows
// reads   source  [height * width]
// updates view    [height * width]  all fields except marks

//! use camera, linear, marks, pixels

var<storage, read> source: array<Pixel>;
var<storage, read_write> view: array<Pixel>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn take_over(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let index = pixel_index(pixel);
    let marks = view[index].marks;
    if (marks & (BAD | MISSED)) != 0u { return; }
    let place = pixel_index(vec2u(column_of(marks & KEY, pixel.x), pixel.y));
    let taken = source[place];
    view[index] = Pixel(taken.depth, taken.slot, marks, taken.color);
    take_linear(index, place);
}
