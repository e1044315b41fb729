// Visibility of lights from the points that a lane's rays hit.

//! use bits, camera, dice, frame, lane, light, lists, pixels, rays, recall, shadow_buffer, shadows, source_samples

//! if visibility is traced
// Visibility is always computed by a shadow-buffer or a shadow ray. It is stored for the other eye if the method reuses
// it.

// The list of pixels that shade_listed shades.
const TO_SHADE: u32 = TO_TRACE;

fn ask_source(pixels: Pixels, hits: Hits, surfaces: Surfaces) {}

fn lit_by(light: u32, wanted: B, ray: ShadowRay) -> B {
    let occluders = hidden_from(light, ray, wanted);
    let lit = wanted & (occluders == U(MISS));
    record(light, wanted, lit, occluders);
    return lit;
}

// Returns the weighted share of a source's rays that arrive, or -1 if they must be traced.
fn known_share(light: u32, slot: u32, count: u32, ray: u32) -> f32 {
    return -1.0;
}

fn keep_share(light: u32, slot: u32, ray: u32, open: f32, all: f32) { record_share(light, slot, ray, open, all); }

//! if visibility is traced or recalled or recalled_or_traced
// Visibility is kept for views that reuse it.

var<private> found_bits: U;
// Slot of the occluder of the last hidden light, or MISS if none was found.
var<private> found_occluders: U = U(MISS);
// Shares of the first six sources that are not point lights, packed as in bits.wgsl.
var<private> found_shares: U = U(0xffffffffu);

fn light_bits() -> U {
    return found_bits;
}

fn record(light: u32, known: B, lit: B, occluders: U) {
    if !KEEP_BITS || light >= 16u { return; }
    found_bits |= select(U(0u), U(1u << (light + 16u)), known) | select(U(0u), U(1u << light), lit);
    found_occluders = select(found_occluders, occluders, occluders != U(MISS));
}

fn record_share(light: u32, slot: u32, ray: u32, open: f32, all: f32) {
    if !KEEP_BITS || all <= 0.0 { return; }
    if light < 16u && (open == 0.0 || open == all) {
        let bits = (1u << (light + 16u)) | select(0u, 1u << light, open == all);
        found_bits = with_ray_u(found_bits, ray, of_ray_u(found_bits, ray) | bits);
    }
    if KEEP_SHARES && slot < SHARES {
        let partly = clamp(u32(open / all * f32(ALL_OPEN) + 0.5), 1u, ALL_OPEN - 1u);
        let share = select(select(partly, ALL_OPEN, open == all), 0u, open == 0.0);
        let before = of_ray_u(found_shares, ray) & ~(UNASKED << (SHARE_BITS * slot));
        found_shares = with_ray_u(found_shares, ray, before | (share << (SHARE_BITS * slot)));
    }
}

//! if visibility is taken or taken_or_traced
fn record(light: u32, known: B, lit: B, occluders: U) {}

fn record_share(light: u32, slot: u32, ray: u32, open: f32, all: f32) {}

fn light_bits() -> U {
    return U(0u);
}

//! if visibility is taken or recalled
// Known bits are reused. A pixel with an unknown bit is deferred to shade_listed.

var<private> put_off: B;

fn lit_by(light: u32, wanted: B, ray: ShadowRay) -> B {
    let known = is_known(taken, light);
    let lit = wanted & known & is_lit(taken, light);
    record(light, wanted & known, lit, U(MISS));
    put_off |= wanted & !known;
    return lit;
}

fn keep_share(light: u32, slot: u32, ray: u32, open: f32, all: f32) {
    if all > 0.0 { put_off |= RAY_INDEX == U(ray); }
}

//! if visibility is taken_or_traced or recalled_or_traced
// Known bits are reused. For an unknown bit, the samples' occluders are tested before a shadow ray is traced: a hit
// proves the shadow.

const TO_SHADE: u32 = TO_LIGHT;

fn lit_by(light: u32, wanted: B, ray: ShadowRay) -> B {
    let known = is_known(taken, light);
    let unknown = wanted & !known;
    var lit = wanted & known & is_lit(taken, light);
    var occluders = U(MISS);
    if any_ray(unknown) {
        var open = unknown;
        if KEEP_OCCLUDERS { open &= !hidden_likewise(unknown, ray); }
        if any_ray(open) {
            occluders = hidden_from(light, ray, open);
            lit |= open & (occluders == U(MISS));
        }
    }
    record(light, wanted, lit, occluders);
    return lit;
}

fn keep_share(light: u32, slot: u32, ray: u32, open: f32, all: f32) { record_share(light, slot, ray, open, all); }

// Returns which rays hit an occluder of one of the source samples beside their points.
fn hidden_likewise(unknown: B, ray: ShadowRay) -> B {
    var hidden: U;
    var index = 0u;
    loop {
        let a = of_ray_u(taken.occluders_a, index);
        let b = of_ray_u(taken.occluders_b, index);
        if of_ray_b(unknown, index) {
            if a < UNFILLED && is_occluded_by(a, ray, index) { hidden = with_ray_u(hidden, index, 1u); }
            if b < UNFILLED && b != a && is_occluded_by(b, ray, index) { hidden = with_ray_u(hidden, index, 1u); }
        }
        index += 1u;
        if index >= RAYS { break; }
    }
    return hidden == U(1u);
}

//! if visibility is taken_or_traced
// Queries the source's samples beside these points.
fn ask_source(pixels: Pixels, hits: Hits, surfaces: Surfaces) {
    taken = taken_bits(pixels, hits, surfaces, busy_at(pixels));
}

//! if visibility is recalled_or_traced
// Queries an earlier frame's samples around these points.
fn ask_source(pixels: Pixels, hits: Hits, surfaces: Surfaces) {
    recall(pixels, surfaces, busy_at(pixels));
}

//! if visibility is taken
// Queries the samples like ask_source, for a lane whose pixels are all in one tile. The tile's busy lights are read
// only once.
fn ask_source_in_tile(pixels: Pixels, hits: Hits, surfaces: Surfaces) {
    taken = taken_bits(pixels, hits, surfaces, U(busy_near(pixel_of_ray(pixels, 0u))));
}

//! if visibility is recalled
fn ask_source_in_tile(pixels: Pixels, hits: Hits, surfaces: Surfaces) {
    recall(pixels, surfaces, U(busy_near(pixel_of_ray(pixels, 0u))));
}

//! if visibility is taken or taken_or_traced or recalled or recalled_or_traced
var<private> taken: Taken;

//! if visibility is recalled or recalled_or_traced
fn recall(pixels: Pixels, surfaces: Surfaces, busy: U) {
    taken = recalled_bits(pixels, surfaces, busy);
    if KEEP_BITS { found_occluders = taken.occluders_a; }
}

// Returns the share of a source's rays that arrive, or -1 if unknown. If the four samples around the point agree, it is
// theirs, otherwise it is interpolated.
fn known_share(light: u32, slot: u32, count: u32, ray: u32) -> f32 {
    if KEEP_SHARES && slot < SHARES && (of_ray_u(taken.busy, ray) & (1u << (16u + slot))) != 0u { return -1.0; }
    let bit = light_mask(light);
    let known = (of_ray_u(taken.known, ray) & bit) != 0u;
    if known {
        let open = select(0.0, 1.0, (of_ray_u(taken.lit, ray) & bit) != 0u);
        // If no partial shares are kept, one that several rays sample is recalled once. If it were recalled again, all
        // would become 0 or 1 in time.
        if (KEEP_SHARES && slot < SHARES) || count == 1u { record_share(light, slot, ray, open, 1.0); }
        return open;
    }
    if !KEEP_SHARES || slot >= SHARES || (bit & ~of_ray_u(taken.busy, ray)) == 0u { return -1.0; }
    let share = share_around(slot, count, ray);
    if share >= 0.0 {
        record_share(light, slot, ray, storable_share(share, slot, pixel_of_ray(dice, ray)), f32(ALL_OPEN));
    }
    return share;
}

//! if visibility is taken or taken_or_traced
// Returns the share of a source's rays that arrive, or -1 if unknown. If both samples see all of the source, or both
// see none of it, their share is reused. Otherwise the share is interpolated, if chance explains the samples'
// difference and the penumbra is not narrow.
fn known_share(light: u32, slot: u32, count: u32, ray: u32) -> f32 {
    let bit = light_mask(light);
    if KEEP_SHARES && slot < SHARES && (of_ray_u(taken.busy, ray) & (1u << (16u + slot))) != 0u { return -1.0; }
    if (of_ray_u(taken.known, ray) & bit) != 0u { return select(0.0, 1.0, (of_ray_u(taken.lit, ray) & bit) != 0u); }
    if !KEEP_SHARES || slot >= SHARES { return -1.0; }
    let a = (of_ray_u(taken.shares_before, ray) >> (SHARE_BITS * slot)) & UNASKED;
    let b = (of_ray_u(taken.shares_after, ray) >> (SHARE_BITS * slot)) & UNASKED;
    if a == UNASKED || b == UNASKED { return -1.0; }
    // If both samples see all or nothing and yet the bit is unknown, the point lies in a groove between them
    // (bits.wgsl).
    if bit != 0u && a == b && (a == 0u || a == ALL_OPEN) { return -1.0; }
    let before = f32(a) / f32(ALL_OPEN);
    let after = f32(b) / f32(ALL_OPEN);
    if !is_chance(before, after, frame.lighting.share_tolerance, count) || is_narrow(slot, before, after, count, ray) {
        return -1.0;
    }
    return mix(before, after, of_ray(taken.way, ray));
}

// Returns whether a penumbra is narrow. Each of the two samples beside the point is compared with its neighbour on the
// far side.
fn is_narrow(slot: u32, before: f32, after: f32, count: u32, ray: u32) -> bool {
    let pixel = pixel_of_ray(dice, ray);
    let first = place_between(nearest_source(), pixel, view[pixel_index(pixel)].depth).first;
    let component = source_sample(first).component;
    var narrow = false;
    if first.x > 0u { narrow = is_unlike(vec2u(first.x - 1u, first.y), component, slot, before, count); }
    if first.x + 2u < frame.band.size.x {
        narrow |= is_unlike(vec2u(first.x + 2u, first.y), component, slot, after, count);
    }
    return narrow;
}

fn is_unlike(pixel: vec2u, component: u32, slot: u32, share: f32, count: u32) -> bool {
    let sample = source_sample(pixel);
    let other = (sample.other >> (SHARE_BITS * slot)) & UNASKED;
    let asked = sample.component == component && other != UNASKED;
    return asked && !is_chance(f32(other) / f32(ALL_OPEN), share, NARROW * frame.lighting.share_tolerance, count);
}
