// Cut-outs: triangles whose surface exists only where a mask says so.
//
// A hit on such a triangle is deferred like an uncertain one. The second look, one ray at a time, reads the mask. So
// the first test costs no more than without masks, and masks are read for hits only. Every ray of either eye gets the
// same answer, since one function decides.

//! use fetch, lane, primitive, rays, textures, triangle

//! if cutouts is some
// Returns a triangle test's result, where a hit on a cut-out triangle is uncertain.
fn at_first_look(primitive: Primitive, found: Found) -> Found {
    let cut_out = B(is_cut_out(primitive));
    return Found(found.hit & !cut_out, found.t, found.doubtful | (found.hit & cut_out));
}

// Returns one ray's t on the second look, or -1 where the primitive is cut out.
fn at_second_look(primitive: Primitive, slot: u32, origin: vec3f, direction: vec3f, t: f32) -> f32 {
    if is_cut_out(primitive) && !has_surface(slot, origin, direction) { return -1.0; }
    return t;
}

//! if cutouts is none
fn at_first_look(primitive: Primitive, found: Found) -> Found { return found; }

fn at_second_look(primitive: Primitive, slot: u32, origin: vec3f, direction: vec3f, t: f32) -> f32 { return t; }

//! end
// Highest bit of a component, set for cut-out triangles. It keeps them apart from whole neighbours.
const IS_CUT_OUT: u32 = 0x80000000u;

fn is_cut_out(primitive: Primitive) -> bool {
    return (primitive.component & IS_CUT_OUT) != 0u;
}

// Pixels of a mask per texel, one bit each.
const MASK_PIXELS: u32 = 128u;

// Returns whether a triangle has a surface where a ray meets it, by the mask's nearest pixel. A mask's head holds its
// first texel, counted from the first head, then width, height and wrap. Rows count from below, like v.
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
