// Visibility bits that target pixels reuse from a source view (docs/BRACKET.md). Every reused bit is inferred: a shadow
// that falls between the samples is lost.

//! use camera, frame, lane, light, lists, pixels, primitive, rays, source_samples

// Visibility of the lights at a point, inferred from the source samples on both sides of the point. `known` and `lit`
// have one bit for each of the first 16 lights.
struct Taken {
    known: U,
    lit: U,
    // Slot of an occluder of the sample before the point, and slot of an occluder of the sample after it. MISS means
    // that there is none.
    occluders_a: U,
    occluders_b: U,
    // Light shares of the two samples, packed like found_shares of visibility.wgsl. If a sample is rejected, all its
    // shares are UNASKED.
    shares_before: U,
    shares_after: U,
    way: F,             // position of the point from the first sample to the next, 0 to 1
    busy: U,            // one bit, from bit 16 on, for each source whose share is not reused
}

// Number of sources whose shares fit in a word. A share is 0 if no ray arrives and ALL_OPEN if all rays arrive.
const SHARES: u32 = 6u;
const SHARE_BITS: u32 = 5u;
const ALL_OPEN: u32 = 30u;
const UNASKED: u32 = 31u;

fn light_mask(light: u32) -> u32 {
    return select(0u, 1u << (light & 15u), light < 16u);
}

fn is_known(taken: Taken, light: u32) -> B { return (taken.known & U(light_mask(light))) != U(0u); }
fn is_lit(taken: Taken, light: u32) -> B { return (taken.lit & U(light_mask(light))) != U(0u); }

// Returns the visibility bits that source samples give for the hit points of target pixels. Bits of busy lights are
// unknown.
fn taken_bits(pixels: Pixels, hits_there: Hits, surfaces: Surfaces, busy: U) -> Taken {
    var result = Taken(U(0u), U(0u), U(MISS), U(MISS), U(MISS), U(MISS), F(0.0), busy);
    var ray = 0u;
    loop {
        if of_ray_b(surfaces.there, ray) {
            let near = place_between(nearest_source(), pixel_of_ray(pixels, ray), of_ray(hits_there.t, ray));
            let agreed = asked_also(bits_of_ray(near, hits_there, surfaces, ray), pixels, hits_there, surfaces, ray);
            result.known = with_ray_u(result.known, ray, (agreed >> 16u) & ~of_ray_u(busy, ray));
            result.lit = with_ray_u(result.lit, ray, agreed & 0xffffu);
            if KEEP_OCCLUDERS && near.usable {
                result.occluders_a = with_ray_u(result.occluders_a, ray, source_sample(near.first).other);
                result.occluders_b = with_ray_u(
                    result.occluders_b,
                    ray,
                    source_sample(vec2u(near.next, near.first.y)).other,
                );
            }
            if KEEP_SHARES && near.usable {
                let component = of_ray_u(surfaces.component, ray);
                result.shares_before = with_ray_u(result.shares_before, ray, vouched_shares(near, 0u, component));
                result.shares_after = with_ray_u(result.shares_after, ray, vouched_shares(near, 1u, component));
                result.way = with_ray(result.way, ray, near.way);
            }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return result;
}

// The position of a point, projected into a source view, between two neighbouring samples of a row.
struct Between {
    source: Asked,
    usable: bool,         // whether both samples are in the picture
    first: vec2u,
    next: u32,            // column of the second sample
    way: f32,             // position of the point from the first sample to the next, 0 to 1
    point_parallax: f32,
    same_parallax: f32,   // largest difference from the parallax of a sample of the point's surface, pixels
}

fn place_between(source: Asked, pixel: vec2u, z: f32) -> Between {
    let point_parallax = parallax_from(source, pixel.y, z);
    let position = f32(pixel.x) + 0.5 - point_parallax;
    let before = floor(position - 0.5);
    let column = in_turn(before);
    let inside = (column >= 0.0) & (column < f32(frame.band.size.x));
    let next = next_column(u32(select(0.0, column, inside)));
    let usable = inside & (next < frame.band.size.x);
    let first = vec2u(u32(select(0.0, column, usable)), pixel.y);
    let same_parallax = same_parallax_at(source, pixel.y, z);
    return Between(source, usable, first, next, position - 0.5 - before, point_parallax, same_parallax);
}

fn bits_of_ray(at: Between, hits_there: Hits, surfaces: Surfaces, ray: u32) -> u32 {
    let component = of_ray_u(surfaces.component, ray);
    let normal = of_ray3(surfaces.geometric_normal, ray);
    return select(0u, agreed_bits(at, component, normal, of_ray_u(hits_there.slot, ray)), at.usable);
}

//! if sources is one
fn asked_also(bits: u32, pixels: Pixels, hits_there: Hits, surfaces: Surfaces, ray: u32) -> u32 {
    return bits;
}

fn sample_of(source: Asked, pixel: vec2u) -> SourceSample {
    return source_sample(pixel);
}

//! if sources is two
// Queries the second source, on the target's other side, for bits that the nearest source leaves unknown. The second
// source sees surfaces that are hidden from the nearest one.
fn asked_also(bits: u32, pixels: Pixels, hits_there: Hits, surfaces: Surfaces, ray: u32) -> u32 {
    let second = second_source();
    let at = place_between(second, pixel_of_ray(pixels, ray), of_ray(hits_there.t, ray));
    let more = bits_of_ray(at, hits_there, surfaces, ray);
    let known = (more >> 16u) & ~(bits >> 16u);
    return bits | (known << 16u) | (more & known);
}

fn sample_of(source: Asked, pixel: vec2u) -> SourceSample {
    if source.second { return second_sample(pixel); }
    return source_sample(pixel);
}

//! end
// Returns whether a source sample shows the point's surface: it has the same component and a similar parallax.
fn vouches(at: Between, sample: SourceSample, component: u32) -> bool {
    let apart = abs(parallax_from(at.source, at.first.y, sample.depth) - at.point_parallax);
    return sample.component == component && apart <= at.same_parallax;
}

// Returns the sample's bits, or 0 if the sample shows another surface than the point's.
fn vouched_bits(at: Between, sample: SourceSample, component: u32) -> u32 {
    return select(0u, sample.bits, vouches(at, sample, component));
}

// Returns the shares of the sample before a point (next = 0) or after it (next = 1). If the sample shows another
// surface, the result is MISS, which has UNASKED in every share.
fn vouched_shares(at: Between, next: u32, component: u32) -> u32 {
    let sample = source_sample(vec2u(select(at.first.x, at.next, next == 1u), at.first.y));
    return select(MISS, sample.other, vouches(at, sample, component));
}

// Returns the visibility bits that both samples know and agree on.
fn agreeing(a: u32, b: u32) -> u32 {
    let known = ((a & b) >> 16u) & ~(a ^ b) & 0xffffu;
    return (known << 16u) | (a & known);
}

// Returns whether two shares differ by at most `deviations` standard deviations of the difference of two such binomial
// shares, or by one ray.
fn is_chance(a: f32, b: f32, deviations: f32, count: u32) -> bool {
    let mean = 0.5 * (a + b);
    let by_chance = deviations * sqrt(2.0 * mean * (1.0 - mean) / f32(count));
    return abs(a - b) <= max(by_chance, 1.0 / f32(count));
}

// Factor on the tolerated deviations between the shares of a sample and its neighbour. A penumbra with larger
// differences is at most about four samples wide. Then two samples say little about the points between them.
const NARROW: f32 = 2.0;

// Returns the busy lights of each pixel of a lane.
fn busy_at(pixels: Pixels) -> U {
    var busy = U(0u);
    var ray = 0u;
    loop {
        busy = with_ray_u(busy, ray, busy_near(pixel_of_ray(pixels, ray)));
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return busy;
}

//! if bits is none
// With `rays`, no visibility bit is reused.
fn busy_near(pixel: vec2u) -> u32 { return 0u; }

fn agreed_bits(at: Between, component: u32, normal: vec3f, slot: u32) -> u32 {
    return 0u;
}

//! if bits is two or block
// Returns the lights that are busy in a pixel's tile (mark_busy.wgsl).
fn busy_near(pixel: vec2u) -> u32 {
    return lists.entries[found_in_tile(pixel) + BUSY_WORD];
}

//! if bits is two
// With `two`, the source samples on both sides of the point must agree. If the point lies in a groove, below the line
// between the two samples, a light may be hidden although both samples see it. In grooves, the bits of visible lights
// therefore count as unknown.

fn agreed_bits(at: Between, component: u32, normal: vec3f, slot: u32) -> u32 {
    let before = sample_of(at.source, at.first);
    let after = sample_of(at.source, vec2u(at.next, at.first.y));
    let bits = agreeing(vouched_bits(at, before, component), vouched_bits(at, after, component));
    let row = at.first.y;
    let line = mix(parallax_from(at.source, row, before.depth), parallax_from(at.source, row, after.depth), at.way);
    let deeper = at.point_parallax - line;
    let in_groove = select(deeper, -deeper, is_left_of_source(at.source)) > GROOVE * at.same_parallax;
    return select(bits, bits & ~(bits << 16u), in_groove);
}

//! if bits is block
// With `block`, the source samples on both sides of the point must agree, in the point's row and in the rows above and
// below. A sample of another primitive is rejected if its normal differs too much.

// Minimum cosine between the normals of primitives whose samples may share visibility bits.
const SAME_NORMAL: f32 = 0.9;

fn agreed_bits(at: Between, component: u32, normal: vec3f, slot: u32) -> u32 {
    if at.first.y == 0u || at.first.y + 1u >= frame.band.size.y { return 0u; }
    var row = at.first.y - 1u;
    var bits: u32;
    loop {
        let before = smooth_bits(at, sample_of(at.source, vec2u(at.first.x, row)), component, normal, slot);
        let after = smooth_bits(at, sample_of(at.source, vec2u(at.next, row)), component, normal, slot);
        let pair = agreeing(before, after);
        bits = select(agreeing(bits, pair), pair, row + 1u == at.first.y);
        row += 1u;
        if row > at.first.y + 1u { break; }
    }
    return bits;
}

fn smooth_bits(at: Between, sample: SourceSample, component: u32, normal: vec3f, slot: u32) -> u32 {
    let bits = vouched_bits(at, sample, component);
    let other = primitive_at(select(sample.other, slot, bits == 0u));
    // The sign of the normals does not matter: two visible neighbours are seen from the same side.
    let its_normal = normalize(largest_one(cross(largest_one(other.b - other.a), largest_one(other.c - other.a))));
    // A sphere is the only primitive of its component.
    let same = sample.other == slot || (component & IS_SPHERE) != 0u || abs(dot(its_normal, normal)) >= SAME_NORMAL;
    return select(0u, bits, same);
}
