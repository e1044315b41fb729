// Verification `edges` (thesis, 6.2): right pixels whose left sample lies at an edge are marked BAD, for resolve_right to list;
// all others are trusted.
//
// launch  one thread per right pixel of the rows at work
// reads   hits          [2 * height * width]  left half
// updates right_source  [height * width]      left column + 1, or EMPTY; BAD is added
// table   objects of the primitives, four a texel

@group(1) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(1) var<storage, read> hits: array<PixelHit>;
@group(1) @binding(2) var<storage, read_write> right_source: array<u32>;

// Neighbours farther apart in parallax are no one surface, pixels.
const EDGE_PX: f32 = 1.0;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn mark_edges(@builtin(global_invocation_id) id: vec3u) {
    let pixel = thread_pixel(id);
    if outside(pixel) { return; }
    let source = right_source[pixel_index(pixel)];
    if source == EMPTY { return; }
    let left = vec2i(i32(source) - 1, i32(pixel.y));
    let hit = hits[pixel_index(vec2u(left))];
    if differs(hit, left + vec2i(1, 0)) || differs(hit, left - vec2i(1, 0)) || differs(hit, left + vec2i(0, 1))
        || differs(hit, left - vec2i(0, 1)) {
        right_source[pixel_index(pixel)] = source | BAD;
    }
}

// Beyond the picture's edge nothing differs.
fn differs(hit: PixelHit, at: vec2i) -> bool {
    if any(at < vec2i(0)) || any(at >= vec2i(frame.image_size)) { return false; }
    let other = hits[pixel_index(vec2u(at))];
    return object_of(primitive_of(hit)) != object_of(primitive_of(other))
        || abs(parallax(hit.depth) - parallax(other.depth)) > EDGE_PX;
}

fn object_of(primitive: u32) -> u32 {
    if primitive == MISS { return MISS; }
    return table_texel(primitive / 4u)[primitive % 4u];
}
