// Cut-out triangles. A mask defines where their surface exists.
//
// A hit on a cut-out triangle is deferred like an uncertain hit. The second test, one ray at a time, reads the mask. So
// the first test costs no more than without masks, and masks are read for hits only. Both eyes get consistent results,
// since one function decides for every ray.

//! use fetch, lane, primitive, rays, textures, triangle

//! if cutouts is some
// Returns the result of a triangle test. A hit on a cut-out triangle becomes uncertain.
fn at_first_look(primitive: Primitive, found: Found) -> Found {
    let cut_out = B(is_cut_out(primitive));
    return Found(found.hit & !cut_out, found.t, found.doubtful | (found.hit & cut_out));
}

// Returns the t of one ray's second test, or -1 if the triangle is cut out at the hit.
fn at_second_look(primitive: Primitive, slot: u32, origin: vec3f, direction: vec3f, t: f32) -> f32 {
    if is_cut_out(primitive) && !has_surface(slot, origin, direction) { return -1.0; }
    return t;
}

//! if cutouts is none
fn at_first_look(primitive: Primitive, found: Found) -> Found { return found; }

fn at_second_look(primitive: Primitive, slot: u32, origin: vec3f, direction: vec3f, t: f32) -> f32 { return t; }

//! end
// Highest bit of a component, set for cut-out triangles. The bit separates their component from the component of
// neighbours without a mask.
const IS_CUT_OUT: u32 = 0x80000000u;

fn is_cut_out(primitive: Primitive) -> bool {
    return (primitive.component & IS_CUT_OUT) != 0u;
}

// Number of mask pixels per texel, one bit each.
const MASK_PIXELS: u32 = 128u;

// Returns whether a triangle has a surface at a ray's hit, according to the nearest pixel of its mask. The head of a
// mask holds the index of its first texel, relative to the first head, then width, height and wrap mode. Rows count
// from the bottom, like v.
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
