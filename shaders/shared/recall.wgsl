// Visibility bits and shares of soft light that a traced view recalls from an earlier frame (docs/BRACKET.md, "Earlier
// frames"). A bit is known if the four samples around a point show its surface, all know the bit, and agree. Some tiles
// recall nothing in turn, so that each bit is traced anew after a while.

//! use aims, bits, dice, earlier_quad, fetch, frame, history, lane, light, pixels, table, tiles

// One of this number of tiles recalls nothing in each frame.
const ASKED_ANEW: u32 = 64u;

fn recalled_bits(pixels: Pixels, surfaces: Surfaces, busy: U) -> Taken {
    var result = Taken(U(0u), U(0u), U(MISS), U(MISS), U(MISS), U(MISS), F(0.0), busy);
    let eye = earlier_eye();
    var ray = 0u;
    loop {
        if KEEP_SHARES { surroundings[ray] = nothing_around(); }
        if of_ray_b(surfaces.there, ray) && !recalls_nothing(pixel_of_ray(pixels, ray)) {
            let normal = of_ray3(surfaces.geometric_normal, ray);
            let point = of_ray3(surfaces.point, ray);
            let around = bits_around(eye, point, normal, of_ray_u(surfaces.component, ray));
            if around.component != MISS {
                let dropped = ~holding(eye, point, around.apart) & 0xffffu;
                result.busy = with_ray_u(result.busy, ray, of_ray_u(busy, ray) | dropped);
            }
            result.known = with_ray_u(result.known, ray, (around.bits >> 16u) & ~of_ray_u(result.busy, ray));
            result.lit = with_ray_u(result.lit, ray, around.bits & 0xffffu);
            if KEEP_OCCLUDERS {
                result.occluders_a = with_ray_u(result.occluders_a, ray, around.others.x);
                result.occluders_b = with_ray_u(result.occluders_b, ray, around.others.w);
            }
            if KEEP_SHARES { surroundings[ray] = around; }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return result;
}

// Boxes around moved objects are widened by this number of pixels, measured at the point's distance from the old eye,
// and by the samples' distance from the point along the view.
const WIDENED: f32 = 2.0;

// Returns the lights whose bits hold: nothing that moved can have hidden the point from them, or hides it now. The
// points that a box hides from a point light are convex. So if the box hides all samples around the point, it hides the
// point.
fn holding(eye: EarlierEye, point: vec3f, apart: f32) -> u32 {
    var hold = eye_tag(1u);
    let boxes = eye_tag(2u);
    var left = select(0u, hold, boxes > 0u);
    let margin = WIDENED * length(eye.step_x) * length(point - eye.place) + apart;
    loop {
        if left == 0u { break; }
        let light = firstTrailingBit(left);
        left &= left - 1u;
        if meets_moved(point, light, margin, boxes) { hold &= ~(1u << light); }
    }
    return hold;
}

// Returns whether rays from a light to a point meet one of the boxes around moved objects.
fn meets_moved(point: vec3f, light: u32, margin: f32, boxes: u32) -> bool {
    let first = LIGHTS + LIGHT_TEXELS * light;
    let kind = table_texel(first).w;
    let place = shading_vector(first);
    let straight = select(place - point, place, kind == SUN);
    let way = select(straight, vec3f(1e-30), abs(straight) < vec3f(1e-30));
    let end = select(1.0, FAR, kind == SUN);
    let size = bitcast<f32>(table_texel(first + 1u).w);
    var index = 0u;
    loop {
        let low = moved_corner(2u * index);
        let high = moved_corner(2u * index + 1u);
        // Rays to an extended light are at most this far from the ray to its centre.
        var spread = 0.0;
        if kind == SPHERE { spread = disc_of(light, kind, size, straight); }
        if kind == RECTANGLE { spread = length(shading_vector(first + 2u)) + length(shading_vector(first + 3u)); }
        if kind == SUN { spread = size * (length(0.5 * (low + high) - point) + 0.5 * length(high - low)); }
        let a = (low - point - (margin + spread)) / way;
        let b = (high - point + (margin + spread)) / way;
        let nearer = min(a, b);
        let farther = max(a, b);
        let enters = max(max(nearer.x, nearer.y), max(nearer.z, 0.0));
        if enters <= min(min(farther.x, farther.y), min(farther.z, end)) { return true; }
        index += 1u;
        if index >= boxes { break; }
    }
    return false;
}

// Returns a corner of a box; a box has two.
fn moved_corner(index: u32) -> vec3f { return eye_word(4u + index); }

fn recalls_nothing(pixel: vec2u) -> bool {
    let tile = vec2u(pixel.x, pixel.y + frame.band.first_row) / TILE;
    return (tile.x * 11u + tile.y * 29u + earlier_frame()) % ASKED_ANEW == 0u;
}

// The bits on which the four samples around a point agree.
struct Around {
    bits: u32,
    others: vec4u,    // of each sample its occluder, or its shares; or MISS
    way: vec3f,       // position of the point in the upper row, in the lower row, and from row to row, 0 to 1
    upper: vec2u,     // the sample on the left in the upper row
    lower: vec2u,     // the sample on the left in the lower row
    component: u32,   // MISS if the samples show other surfaces
    apart: f32,       // the samples' largest distance from the point along the view, world units
}

fn nothing_around() -> Around { return Around(0u, vec4u(MISS), vec3f(0.0), vec2u(0u), vec2u(0u), MISS, 0.0); }

fn bits_around(eye: EarlierEye, point: vec3f, normal: vec3f, component: u32) -> Around {
    let quad = quad_around(eye, point, normal, component);
    if !quad.shown { return nothing_around(); }
    let a = quad.a;
    let b = quad.b;
    let c = quad.c;
    let d = quad.d;
    let known = ((a.w & b.w & c.w & d.w) >> 16u) & ~((a.w ^ b.w) | (a.w ^ c.w) | (a.w ^ d.w)) & 0xffffu;
    let bits = (known << 16u) | (a.w & known);
    let sure = select(bits, bits & ~(bits << 16u), is_in_groove(quad));
    let offsets = abs(depths_of(quad) - quad.depth);
    let farthest = max(max(offsets.x, offsets.y), max(offsets.z, offsets.w)) * length(point - eye.place) / quad.depth;
    return Around(sure, vec4u(a.y, b.y, c.y, d.y), quad.way, quad.upper, quad.lower, component, farthest);
}

// What surrounds the points of a lane's rays, if shares are reused.
var<private> surroundings: array<Around, RAYS>;

// Returns the interpolated share of a source's rays that arrive at a point, or -1 if chance does not explain the
// differences of the samples, or if the penumbra is narrow.
fn share_around(slot: u32, count: u32, ray: u32) -> f32 {
    let around = surroundings[ray];
    let four = (around.others >> vec4u(SHARE_BITS * slot)) & vec4u(UNASKED);
    if any(four == vec4u(UNASKED)) { return -1.0; }
    // If the samples see all or nothing and yet the bit is unknown, the point lies in a groove.
    if all(four == vec4u(0u)) || all(four == vec4u(ALL_OPEN)) { return -1.0; }
    let shares = vec4f(four) / f32(ALL_OPEN);
    let lowest = min(min(shares.x, shares.y), min(shares.z, shares.w));
    let highest = max(max(shares.x, shares.y), max(shares.z, shares.w));
    let tolerance = frame.lighting.share_tolerance;
    if !is_chance(lowest, highest, NARROW * tolerance, count) { return -1.0; }
    // The samples beyond, on the diagonals, show how steep the penumbra is.
    let upper = vec2i(around.upper);
    let lower = vec2i(around.lower);
    let beyond = vec4u(
        share_there(upper + vec2i(-1, -1), slot, around.component),
        share_there(upper + vec2i(2, -1), slot, around.component),
        share_there(lower + vec2i(-1, 1), slot, around.component),
        share_there(lower + vec2i(2, 1), slot, around.component),
    );
    let is_whole = all(beyond != vec4u(UNASKED));
    let all_shares = select(shares, 0.5 * (shares + vec4f(beyond) / f32(ALL_OPEN)), is_whole);
    let rays = select(2u, 4u, is_whole) * count;
    let left = 0.5 * (all_shares.x + all_shares.z);
    let right = 0.5 * (all_shares.y + all_shares.w);
    let above = 0.5 * (all_shares.x + all_shares.y);
    let below = 0.5 * (all_shares.z + all_shares.w);
    if !is_chance(left, right, tolerance, rays) || !is_chance(above, below, tolerance, rays) { return -1.0; }
    return between_four(shares, around.way);
}

// Returns the share of the sample at a place, or UNASKED if it shows another component.
fn share_there(place: vec2i, slot: u32, component: u32) -> u32 {
    if any(place < vec2i(0)) || any(vec2u(place) >= history_size()) { return UNASKED; }
    let sample = textureLoad(history, place, 0);
    return select(UNASKED, (sample.y >> (SHARE_BITS * slot)) & UNASKED, sample.z == component);
}

// Returns a share that can be stored, as a number of ALL_OPEN parts. It is rounded up or down by chance, so that sums
// over many pixels and frames are not biased.
fn storable_share(share: f32, slot: u32, pixel: vec2u) -> f32 {
    let random = scrambled(vec3u(pixel.x, pixel.y + frame.band.first_row, slot + SHARES * earlier_frame())).x;
    return min(floor(share * f32(ALL_OPEN) + f32(random >> 8u) / 16777216.0), f32(ALL_OPEN));
}
