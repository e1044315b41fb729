// What the left view's samples saw.
struct SourceSample {
    depth: f32,       // along the view axis (FAR: nothing hit)
    other: u32,       // a place among the primitives: with KEEP_OCCLUDERS of what hides some light, MISS where nothing does; else its own
    component: u32,   // of connected primitives
    bits: u32,        // of the first 16 lights: it is seen, from bit 0; a shadow ray asked, from bit 16
}

@group(1) @binding(15) var source_samples: texture_storage_2d<rgba32uint, read>;

fn source_sample(pixel: vec2u) -> SourceSample {
    let texel = textureLoad(source_samples, pixel);
    return SourceSample(bitcast<f32>(texel.x), texel.y, texel.z, texel.w);
}
