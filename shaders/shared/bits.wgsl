// Shadow bits that right pixels take over from the left view (docs/BRACKET.md). Any bit is an inference: what falls between the
// samples throws no shadow here.

// Of the first 16 lights: it is known whether they are seen, and they are.
struct Taken {
    known: U,
    lit: U,
    occluders_a: U,   // places among the primitives of what hides some light from the samples on both sides of the point, or MISS
    occluders_b: U,
}

fn light_mask(light: u32) -> u32 {
    return select(0u, 1u << (light & 15u), light < 16u);
}

fn is_known(taken: Taken, light: u32) -> B { return (taken.known & U(light_mask(light))) != U(0u); }
fn is_lit(taken: Taken, light: u32) -> B { return (taken.lit & U(light_mask(light))) != U(0u); }

// Bits of one hit point at a right pixel, and which of them count, as in SourceSample.bits.
fn taken_bits(pixels: Pixels, hits_there: Hits, surfaces: Surfaces) -> Taken {
    var result = Taken(U(0u), U(0u), U(MISS), U(MISS));
    var ray = 0u;
    loop {
        let pixel = pixel_of_ray(pixels, ray);
        let point_parallax = parallax(of_ray(hits_there.t, ray));
        let position = f32(pixel.x) + 0.5 - point_parallax;
        let column = floor(position - 0.5);
        let usable = of_ray_b(surfaces.there, ray) & (column >= 0.0) & (column + 1.0 < f32(frame.image_size.x));
        let first = vec2u(u32(select(0.0, column, usable)), pixel.y);
        let agreed = agreed_bits(
            first,
            position - 0.5 - column,
            point_parallax,
            of_ray_u(surfaces.component, ray),
            of_ray3(surfaces.geometric_normal, ray),
            of_ray_u(hits_there.slot, ray),
        );
        result.known = with_ray_u(result.known, ray, select(0u, agreed >> 16u, usable));
        result.lit = with_ray_u(result.lit, ray, agreed & 0xffffu);
        if KEEP_OCCLUDERS && usable {
            result.occluders_a = with_ray_u(result.occluders_a, ray, source_sample(first).other);
            result.occluders_b = with_ray_u(result.occluders_b, ray, source_sample(first + vec2u(1u, 0u)).other);
        }
        ray += 1u;
        if ray >= RAYS { break; }
    }
    return result;
}

// The bits of a left sample as far as it vouches for a point of that parallax and component.
fn vouched_bits(sample: SourceSample, point_parallax: f32, component: u32) -> u32 {
    let same = sample.component == component && abs(parallax(sample.depth) - point_parallax) <= frame.same_parallax;
    return select(0u, sample.bits, same);
}

// Bits that two samples agree in.
fn agreeing(a: u32, b: u32) -> u32 {
    let known = ((a & b) >> 16u) & ~(a ^ b) & 0xffffu;
    return (known << 16u) | (a & known);
}

//! if bits is none
// `rays`: nothing is taken over.
fn agreed_bits(first: vec2u, way: f32, point_parallax: f32, component: u32, normal: vec3f, slot: u32) -> u32 {
    return 0u;
}

//! if bits is two
// `two`: the left samples on both sides of the point. In a groove between them, deeper than the line from one to the other, a light that both
// see may be hidden.

// Depth of a groove, of what one surface's parallaxes may differ by: 1/128 pixel where that is 0.75.
const GROOVE: f32 = 1.0 / 96.0;

// `way` is the point's place between the two, 0 to 1.
fn agreed_bits(first: vec2u, way: f32, point_parallax: f32, component: u32, normal: vec3f, slot: u32) -> u32 {
    let before = source_sample(first);
    let after = source_sample(first + vec2u(1u, 0u));
    let bits = agreeing(vouched_bits(before, point_parallax, component), vouched_bits(after, point_parallax, component));
    let deeper = point_parallax - mix(parallax(before.depth), parallax(after.depth), way);
    let in_groove = select(deeper, -deeper, frame.parallax_px < 0.0) > GROOVE * frame.same_parallax;
    return select(bits, bits & ~(bits << 16u), in_groove);
}

//! if bits is block
// `block`: the left samples on both sides of the point, in its row and in those above and below. One of another primitive whose
// normal has turned away vouches for nothing.

// Least cosine between the normals of primitives that may share a shadow.
const SAME_NORMAL: f32 = 0.9;

fn agreed_bits(first: vec2u, way: f32, point_parallax: f32, component: u32, normal: vec3f, slot: u32) -> u32 {
    if first.y == 0u || first.y + 1u >= frame.image_size.y { return 0u; }
    var row = first.y - 1u;
    var bits: u32;
    loop {
        let before = smooth_bits(source_sample(vec2u(first.x, row)), point_parallax, component, normal, slot);
        let after = smooth_bits(source_sample(vec2u(first.x + 1u, row)), point_parallax, component, normal, slot);
        let pair = agreeing(before, after);
        bits = select(agreeing(bits, pair), pair, row + 1u == first.y);
        row += 1u;
        if row > first.y + 1u { break; }
    }
    return bits;
}

fn smooth_bits(sample: SourceSample, point_parallax: f32, component: u32, normal: vec3f, slot: u32) -> u32 {
    let bits = vouched_bits(sample, point_parallax, component);
    let other = primitive_at(select(sample.other, slot, bits == 0u));
    // The side does not matter: beside each other and both seen, they are seen from the same.
    let its_normal = normalize(largest_one(cross(largest_one(other.b - other.a), largest_one(other.c - other.a))));
    // A component that is a sphere's has no other primitive.
    let same = sample.other == slot || (component & IS_SPHERE) != 0u || abs(dot(its_normal, normal)) >= SAME_NORMAL;
    return select(0u, bits, same);
}
