// Light that paths brought to an earlier frame's view, one texel per pixel of the picture (docs/BRACKET.md, "Earlier
// frames").

//! use facets, octahedral

// Number of paths that a texel counts, at most. The paths of more frames weigh as many as these.
const MOST_KEPT: u32 = 63u;
// Largest light that a texel holds.
const BRIGHTEST: f32 = 60000.0;
// Least reflectance by which light is divided.
const LEAST_TINT: f32 = 0.01;

//! if light is paths
struct EarlierLight {
    diffuse: vec3f,      // mean of what paths brought for diffuse reflection
    glossy: vec3f,       // mean of the light of highlights, divided by the surface's tint
    deviations: vec2f,   // standard deviations of the means, as shares of their brightness
    counts: vec2u,       // number of paths in either mean; 0: no light is known
    width: f32,          // of the surface's lobes
    normal: vec3f,       // for shading
}

// Returns what the glossy light of a surface is divided by, so that textures do not blur from frame to frame.
fn tint_of(lobes: Lobes) -> vec3f {
    return max(lobes.reflectance + lobes.coat * COAT_REFLECTANCE, vec3f(LEAST_TINT));
}

// Returns a texel. Its colours are rounded up or down by chance, by three words for each.
fn packed_light(light: EarlierLight, chance: array<vec3u, 2>) -> vec4u {
    if any(max(light.diffuse, light.glossy) > vec3f(BRIGHTEST)) { return vec4u(0u); }
    let counts = min(light.counts, vec2u(MOST_KEPT));
    let width = u32(light.width * 63.0 + 0.5);
    let flat = vec2u((unpack2x16snorm(octahedral(light.normal)) * 0.5 + 0.5) * 127.0 + 0.5);
    let rest = counts.x | (counts.y << 6u) | (width << 12u) | (flat.x << 18u) | (flat.y << 25u);
    return vec4u(
        shared_exponent(light.diffuse, chance[0]),
        shared_exponent(light.glossy, chance[1]),
        pack2x16float(min(light.deviations, vec2f(BRIGHTEST))),
        rest,
    );
}

fn unpacked_light(texel: vec4u) -> EarlierLight {
    let flat = vec2f(vec2u(texel.w >> 18u, texel.w >> 25u) & vec2u(127u)) / 127.0 * 2.0 - 1.0;
    return EarlierLight(
        from_shared_exponent(texel.x),
        from_shared_exponent(texel.y),
        unpack2x16float(texel.z),
        vec2u(texel.w, texel.w >> 6u) & vec2u(MOST_KEPT),
        f32((texel.w >> 12u) & 63u) / 63.0,
        from_octahedron(flat),
    );
}

// Three numbers of 9 bits with a common exponent. Steps are 2^(exponent - 24).
fn shared_exponent(light: vec3f, chance: vec3u) -> u32 {
    // Also a number that is rounded up has 9 bits.
    let largest = max(max(light.x, light.y), light.z) * (1.0 + 1.0 / 256.0);
    let exponent = u32(clamp(i32(bitcast<u32>(largest) >> 23u) - 127 + 16, 0, 31));
    let step = step_of(exponent);
    let words = min(vec3u(light / step + vec3f(chance >> vec3u(8u)) / 16777216.0), vec3u(511u));
    return words.x | (words.y << 9u) | (words.z << 18u) | (exponent << 27u);
}

fn from_shared_exponent(word: u32) -> vec3f {
    return vec3f(vec3u(word, word >> 9u, word >> 18u) & vec3u(511u)) * step_of(word >> 27u);
}

fn step_of(exponent: u32) -> f32 { return bitcast<f32>((exponent + 127u - 24u) << 23u); }
