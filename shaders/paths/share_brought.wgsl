// Reuses the light that paths brought to a source view, where the two source samples beside a pixel's point show its
// surface and chance explains their difference. Lists the pixels that need paths of their own.
//
// launch  one thread per pixel of the current rows
// reads   view            [height * width]
// reads   source          [height * width]   slots of the source's hits
// reads   source_brought  [height * width]
// writes  brought         [height * width]
// appends lists           TO_TRACE

//! use bits, camera, display, fetch, frame, lane, lists, paths, pixels, primitive, source_samples, wanted

var<storage, read> view: array<Pixel>;
var<storage, read> source: array<Pixel>;
var<storage, read> source_brought: array<Brought>;
var<storage, read_write> brought: array<Brought>;
var<storage, read_write> lists: Lists;

// Minimum cosine between the normals of primitives whose samples share light.
const LIKE_NORMAL: f32 = 0.95;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn share_brought(@builtin(global_invocation_id) id: vec3u) {
    let pixels = block_pixels(id);
    if !all_rays(inside_rows(pixels)) { return; }
    let pixel = pixel_of_ray(pixels, 0u);
    let index = pixel_index(pixel);
    let seen = view[index];
    if seen.slot == MISS { return; }
    if !take_light(pixel, index, seen) { append(TO_TRACE, reserve(TO_TRACE, 1u), index); }
}

// Takes the light that is known, and returns whether all of it is.
fn take_light(pixel: vec2u, index: u32, seen: Pixel) -> bool {
    let at = place_between(nearest_source(), pixel, seen.depth);
    if !at.usable { return false; }
    let component = primitive_texel(seen.slot, 1u).w;
    let material = primitive_texel(seen.slot, 2u).w & MATERIAL;
    let first = pixel_index(at.first);
    let next = pixel_index(vec2u(at.next, at.first.y));
    if !vouches(at, source_sample(at.first), component) { return false; }
    if !vouches(at, source_sample(vec2u(at.next, at.first.y)), component) { return false; }
    if !is_alike(seen.slot, material, source[first].slot) { return false; }
    if !is_alike(seen.slot, material, source[next].slot) { return false; }
    let before = source_brought[first];
    let after = source_brought[next];
    let counts = array(path_counts(before), path_counts(after));
    if counts[0].x == 0u || counts[1].x == 0u { return false; }
    let variances = array(mean_variances(before), mean_variances(after));
    let diffuse = array(mean_diffuse(before), mean_diffuse(after));
    let glossy = array(mean_glossy(before), mean_glossy(after));
    let a = vec2f(luminance(diffuse[0]), luminance(glossy[0]));
    let b = vec2f(luminance(diffuse[1]), luminance(glossy[1]));
    let chance = frame.paths.tolerance * sqrt(variances[0] + variances[1]);
    // The variance of a single path is unknown, so chance explains any difference.
    let is_single = (counts[0] == vec2u(1u)) | (counts[1] == vec2u(1u));
    let are_equal = (abs(a - b) <= max(chance, NEARLY_EQUAL * 0.5 * (a + b))) | is_single;
    if !are_equal.x { return false; }
    brought[index].diffuse = mix(diffuse[0], diffuse[1], at.way);
    let variance = mix(variances[0], variances[1], at.way);
    brought[index].newest.x = variance.x;
    brought[index].marks = DIFFUSE_KNOWN;
    let width = f32(min(before.marks >> 16u, after.marks >> 16u)) / 65535.0;
    if !are_equal.y || width < max(LEAST_WIDTH, WIDTH_PER_TURN * view_turn(seen.depth)) { return false; }
    brought[index].glossy = mix(glossy[0], glossy[1], at.way);
    brought[index].newest.y = variance.y;
    brought[index].marks = DIFFUSE_KNOWN | GLOSSY_KNOWN;
    return true;
}

// Returns whether two primitives of a component have one material and nearly the same normal. The sign does not matter,
// since two visible neighbours are seen from the same side.
fn is_alike(slot: u32, material: u32, other: u32) -> bool {
    if slot == other { return true; }
    if other == MISS || (primitive_texel(other, 2u).w & MATERIAL) != material { return false; }
    return abs(dot(plain_normal(slot), plain_normal(other))) >= LIKE_NORMAL;
}

fn plain_normal(slot: u32) -> vec3f {
    let primitive = primitive_at(slot);
    let sides = cross(largest_one(primitive.b - primitive.a), largest_one(primitive.c - primitive.a));
    return normalize(largest_one(sides));
}
