// What right pixels ask of the left view's samples. It is kept in a texture, since software adapters read those faster
// than buffers.

// What a sample saw.
struct SourceSample {
    depth: f32,       // along the view axis (FAR: nothing hit)
    other: u32,       // with KEEP_SHARES shares of soft light (visibility.wgsl); else a place among the primitives: with KEEP_OCCLUDERS of what
                      // hides some light, MISS where nothing does; else its own
    component: u32,   // of connected primitives
    bits: u32,        // of the first 16 lights: it is seen, from bit 0; a shadow ray asked, from bit 16
}

//! if samples is written
@group(1) @binding(15) var source_samples: texture_storage_2d<rgba32uint, write>;

fn keep_sample(pixel: vec2u, samples: Samples, ray: u32) {
    let depth = bitcast<u32>(of_ray(samples.depth, ray));
    var other = samples.slot;
    if KEEP_OCCLUDERS { other = found_occluders; }
    if KEEP_SHARES { other = found_shares; }
    textureStore(source_samples, pixel, vec4u(depth, of_ray_u(other, ray), of_ray_u(samples.component, ray), of_ray_u(samples.bits, ray)));
}

// Nor is there one of a pixel that was not wanted: it vouches for nothing.
fn keep_no_sample(pixel: vec2u) {
    textureStore(source_samples, pixel, vec4u(0u, MISS, MISS, 0u));
}

//! if samples is read
@group(1) @binding(15) var source_samples: texture_storage_2d<rgba32uint, read>;

fn source_sample(pixel: vec2u) -> SourceSample {
    let texel = textureLoad(source_samples, pixel);
    return SourceSample(bitcast<f32>(texel.x), texel.y, texel.z, texel.w);
}

//! if sources is two
// Of the source on the target's other side, for reading what it has as the first one's is read.
@group(1) @binding(10) var second_samples: texture_2d<u32>;

fn second_sample(pixel: vec2u) -> SourceSample {
    let texel = textureLoad(second_samples, pixel, 0);
    return SourceSample(bitcast<f32>(texel.x), texel.y, texel.z, texel.w);
}

//! if samples is none
// No method takes shadow bits over.
fn keep_sample(pixel: vec2u, samples: Samples, ray: u32) {}

fn keep_no_sample(pixel: vec2u) {}
