// Cut-outs: triangles whose surface is there only where a mask says so.
//
// What hits such a triangle is put off, as what is doubtful is, and the second look, one ray at a time, asks the mask.
// So the first test costs what it costs without masks, which are read for hits alone, and there is one place that says
// where a surface is: whatever ray asks for it, of either eye, gets one answer.

//! if cutouts is some
struct Bvh {
    grid_origin: vec3f,
    extent: f32,
    grid_cell: vec3f,
    zero: u32,
    cutouts: u32,         // texel of the first material's mask head: src/cutouts.rs
}

// What the test of a triangle found: where it is cut out a hit is doubtful.
fn at_first_look(primitive: Primitive, found: Found) -> Found {
    let cut_out = B(is_cut_out(primitive));
    return Found(found.hit & !cut_out, found.t, found.doubtful | (found.hit & cut_out));
}

// One ray's t at a primitive on its second look, or -1 where that is cut out.
fn at_second_look(primitive: Primitive, slot: u32, origin: vec3f, direction: vec3f, t: f32) -> f32 {
    if is_cut_out(primitive) && !has_surface(slot, origin, direction) { return -1.0; }
    return t;
}

//! if cutouts is none
fn at_first_look(primitive: Primitive, found: Found) -> Found { return found; }

fn at_second_look(primitive: Primitive, slot: u32, origin: vec3f, direction: vec3f, t: f32) -> f32 { return t; }

//! if fetch is buffer
fn geometry_texel(index: u32) -> vec4u {
    return geometry[index];
}

//! if fetch is texture
fn geometry_texel(index: u32) -> vec4u {
    return textureLoad(geometry, texel_position(index));
}

//! end
// Highest bit of a component: of a triangle that is cut out. So its component is not that of a neighbour that is whole.
const IS_CUT_OUT: u32 = 0x80000000u;

fn is_cut_out(primitive: Primitive) -> bool {
    return (primitive.component & IS_CUT_OUT) != 0u;
}

// Pixels of a mask that a texel holds, a bit each.
const MASK_PIXELS: u32 = 128u;

// Whether a triangle that a ray meets has a surface there: the pixel says in which it lies. A mask's head has its first
// texel, counted from the first head on, its width, height and wrap. Rows are counted from below, as v is.
fn has_surface(slot: u32, origin: vec3f, direction: vec3f) -> bool {
    let weights = corner_weights(Rays(origin, all3(direction)), triangle_corners(slot), 0u);
    let corners = triangle_uv(slot);
    let uv = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
    let head = geometry_texel(bvh.cutouts + (primitive_texel(slot, 2u).w & MATERIAL));
    let size = vec2i(head.yz);
    let place = vec2i(floor(vec2f(near_unit(uv.x, head.w), near_unit(uv.y, head.w)) * vec2f(size)));
    let pixel = u32(wrapped(place.y, size.y, head.w) * size.x + wrapped(place.x, size.x, head.w));
    let words = geometry_texel(bvh.cutouts + head.x + pixel / MASK_PIXELS);
    return (words[(pixel / 32u) % 4u] & (1u << (pixel % 32u))) != 0u;
}
