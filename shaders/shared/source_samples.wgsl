// Samples of source views, in the form in which target pixels query them. They are in a texture, since software
// adapters read textures faster than buffers.

// One sample of a source view.
struct SourceSample {
    depth: f32,       // along the view axis (FAR: miss)
    // With KEEP_SHARES: the shares of soft light (visibility.wgsl). With KEEP_OCCLUDERS: the slot of a primitive that
    // hides some light, or MISS. Otherwise: the sample's own slot.
    other: u32,
    component: u32,   // connected component
    bits: u32,        // for the first 16 lights: visible, from bit 0 on; known, from bit 16 on
}

//! if samples is read
var source_samples: texture_storage_2d<rgba32uint, read>;

fn source_sample(pixel: vec2u) -> SourceSample {
    let texel = textureLoad(source_samples, pixel);
    return SourceSample(bitcast<f32>(texel.x), texel.y, texel.z, texel.w);
}

//! if sources is two
// Samples of the source on the target's other side.
var second_samples: texture_2d<u32>;

fn second_sample(pixel: vec2u) -> SourceSample {
    let texel = textureLoad(second_samples, pixel, 0);
    return SourceSample(bitcast<f32>(texel.x), texel.y, texel.z, texel.w);
}
