// Visibility bits that a traced view recalls from an earlier frame (docs/BRACKET.md, "Earlier frames"). A bit is known
// if the four samples around a point show its surface, all know the bit, and agree. Some tiles recall nothing in turn,
// so that each bit is traced anew after a while.

//! use bits, dice, frame, history, jitter, lane, light, pixels, tiles

// One of this number of tiles recalls nothing in each frame.
const ASKED_ANEW: u32 = 32u;

fn recalled_bits(pixels: Pixels, surfaces: Surfaces, busy: U) -> Taken {
    var result = Taken(U(0u), U(0u), U(MISS), U(MISS), U(MISS), U(MISS), F(0.0), busy);
    let eye = earlier_eye();
    var ray = 0u;
    loop {
        if of_ray_b(surfaces.there, ray) && !recalls_nothing(pixel_of_ray(pixels, ray)) {
            let normal = of_ray3(surfaces.geometric_normal, ray);
            let around = bits_around(eye, of_ray3(surfaces.point, ray), normal, of_ray_u(surfaces.component, ray));
            result.known = with_ray_u(result.known, ray, (around.bits >> 16u) & ~of_ray_u(busy, ray));
            result.lit = with_ray_u(result.lit, ray, around.bits & 0xffffu);
            if KEEP_OCCLUDERS {
                result.occluders_a = with_ray_u(result.occluders_a, ray, around.occluders.x);
                result.occluders_b = with_ray_u(result.occluders_b, ray, around.occluders.y);
            }
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return result;
}

fn recalls_nothing(pixel: vec2u) -> bool {
    let tile = vec2u(pixel.x, pixel.y + frame.band.first_row) / TILE;
    return (scrambled(vec3u(tile, 0u)).x + earlier_frame()) % ASKED_ANEW == 0u;
}

// The bits on which the four samples around a point agree, and occluders of two of the samples, or MISS.
struct Around {
    bits: u32,
    occluders: vec2u,
}

fn bits_around(eye: EarlierEye, point: vec3f, normal: vec3f, component: u32) -> Around {
    let nothing = Around(0u, vec2u(MISS));
    let there = point - eye.place;
    // The earlier eye must have seen the same side of the surface.
    if dot(there, normal) >= 0.0 { return nothing; }
    // The vector whose product with all directions to pixels is 1.
    let across = cross(eye.step_x, eye.step_y);
    let forward = across / dot(across, eye.corner);
    let depth = dot(there, forward);
    if !(depth > 0.0) { return nothing; }
    let aside = there / depth - eye.corner;
    let place = in_steps_of(aside, eye.step_x, eye.step_y) - 0.5;
    let size = vec2f(history_size());
    if !(place.y >= 0.0 && place.y + 1.0 < size.y) { return nothing; }
    let row = u32(place.y);
    // Samples of a row are offset from the centres of their pixels.
    let columns = vec2f(place.x) - vec2f(row_offset(row), row_offset(row + 1u));
    if !(all(columns >= vec2f(0.0)) && all(columns + 1.0 < vec2f(size.x))) { return nothing; }
    let upper = vec2u(u32(columns.x), row);
    let lower = vec2u(u32(columns.y), row + 1u);
    let way = vec3f(fract(columns), fract(place.y));
    let a = textureLoad(history, upper, 0);
    let b = textureLoad(history, upper + vec2u(1u, 0u), 0);
    let c = textureLoad(history, lower, 0);
    let d = textureLoad(history, lower + vec2u(1u, 0u), 0);
    let depths = bitcast<vec4f>(vec4u(a.x, b.x, c.x, d.x));
    let differ = vec4u(a.z, b.z, c.z, d.z) != vec4u(component);
    // Largest difference of a sample's depth from the point's, as a share of the depth.
    let steepest = STEEPEST * length(eye.step_x);
    let apart = abs(depth / depths - 1.0);
    if any(differ) || !all(apart <= vec4f(steepest)) { return nothing; }
    let known = ((a.w & b.w & c.w & d.w) >> 16u) & ~((a.w ^ b.w) | (a.w ^ c.w) | (a.w ^ d.w)) & 0xffffu;
    let bits = (known << 16u) | (a.w & known);
    // Reciprocals of depths are linear on a plane.
    let nearness = mix(mix(1.0 / depths.x, 1.0 / depths.y, way.x), mix(1.0 / depths.z, 1.0 / depths.w, way.y), way.z);
    let in_groove = depth * nearness - 1.0 > GROOVE * steepest;
    return Around(select(bits, bits & ~(bits << 16u), in_groove), vec2u(a.y, d.y));
}

//! if jitter is none
fn row_offset(row: u32) -> f32 { return 0.0; }

//! if jitter is rows
// Returns the offset of a row's samples. It is the same in both frames, since bits are recalled for one seed only.
fn row_offset(row: u32) -> f32 { return of_ray(sample_aside(U(row)), 0u); }
