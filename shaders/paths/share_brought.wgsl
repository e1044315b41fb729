// Reuses the light of diffuse reflection of a source view, where the two source samples beside a pixel's point
// show its surface and chance explains their difference. Lists the pixels that need paths of their own.
//
// launch  one thread per pixel of the current rows
// reads   view            [height * width]
// reads   source          [height * width]   slots of the source's hits
// reads   source_brought  [height * width]
// writes  brought         [height * width]
// appends lists           TO_TRACE

//! use bits, camera, display, fetch, frame, lane, lists, materials, paths, pixels, primitive, source_samples, wanted

var<storage, read> view: array<Pixel>;
var<storage, read> source: array<Pixel>;
var<storage, read> source_brought: array<Brought>;
var<storage, read_write> brought: array<Brought>;
var<storage, read_write> lists: Lists;

// Minimum cosine between the normals of primitives whose samples share light.
const LIKE_NORMAL: f32 = 0.95;
// Share of their mean by which two samples may always differ.
const NEARLY_EQUAL: f32 = 0.02;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn share_brought(@builtin(global_invocation_id) id: vec3u) {
    let pixels = block_pixels(id);
    if !all_rays(inside_rows(pixels)) { return; }
    let pixel = pixel_of_ray(pixels, 0u);
    let index = pixel_index(pixel);
    let seen = view[index];
    if seen.slot == MISS { return; }
    let material = primitive_texel(seen.slot, 2u).w & MATERIAL;
    let is_shared = !is_bumpy(material) && take_light(pixel, index, seen, material);
    if !is_shared || is_glossy(material) { append(TO_TRACE, reserve(TO_TRACE, 1u), index); }
}

fn take_light(pixel: vec2u, index: u32, seen: Pixel, material: u32) -> bool {
    let at = place_between(nearest_source(), pixel, seen.depth);
    if !at.usable { return false; }
    let component = primitive_texel(seen.slot, 1u).w;
    let first = pixel_index(at.first);
    if !vouches(at, source_sample(at.first), component) { return false; }
    if !vouches(at, source_sample(at.first + vec2u(1u, 0u)), component) { return false; }
    if !is_alike(seen.slot, material, source[first].slot) { return false; }
    if !is_alike(seen.slot, material, source[first + 1u].slot) { return false; }
    let before = source_brought[first];
    let after = source_brought[first + 1u];
    if before.paths < 2u || after.paths < 2u { return false; }
    let means = array(mean_diffuse(before), mean_diffuse(after));
    let a = luminance(means[0]);
    let b = luminance(means[1]);
    let variances = vec2f(mean_variances(before).x, mean_variances(after).x);
    let chance = frame.paths.tolerance * sqrt(variances.x + variances.y);
    if abs(a - b) > max(chance, NEARLY_EQUAL * 0.5 * (a + b)) { return false; }
    brought[index].diffuse = mix(means[0], means[1], at.way);
    brought[index].newest.x = mix(variances.x, variances.y, at.way);
    brought[index].is_known = 1u;
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
