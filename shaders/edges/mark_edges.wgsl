// Verification `edges` (thesis, 6.2): marks target pixels as BAD if their sample lies at an edge in the source view.
// resolve_right lists the marked pixels and trusts all others.
//
// launch  one thread per pixel of the target in the current rows
// reads   source        [height * width]
// reads   object_table  objects of the primitives in BVH order, four per texel
// updates view          [height * width]  marks: key, or EMPTY; BAD is added

//! use camera, frame, marks, objects, pixels

var<storage, read> source: array<Pixel>;
var<storage, read_write> view: array<Pixel>;

// Neighbours whose parallax differs by more pixels than this lie on different surfaces.
const EDGE_PX: f32 = 1.0;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn mark_edges(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let key = view[pixel_index(pixel)].marks;
    if key == EMPTY { return; }
    let at = vec2i(i32(column_of(key, pixel.x)), i32(pixel.y));
    let hit = source[pixel_index(vec2u(at))];
    if differs(hit, at + vec2i(1, 0)) || differs(hit, at - vec2i(1, 0)) || differs(hit, at + vec2i(0, 1))
        || differs(hit, at - vec2i(0, 1)) {
        view[pixel_index(pixel)].marks = key | BAD;
    }
}

// Returns whether a neighbour shows another surface. Beyond the picture's edge the result is false.
fn differs(hit: Pixel, at: vec2i) -> bool {
    if any(at < vec2i(0)) || any(at >= vec2i(frame.band.size)) { return false; }
    let other = source[pixel_index(vec2u(at))];
    let row = u32(at.y);
    return object_of(hit.slot) != object_of(other.slot)
        || abs(parallax(row, hit.depth) - parallax(row, other.depth)) > EDGE_PX;
}

fn object_of(slot: u32) -> u32 {
    if slot == MISS { return MISS; }
    return object_texel(slot / 4u)[slot % 4u];
}
