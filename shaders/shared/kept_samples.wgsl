// Samples of a source view, stored for the target views that reuse them.

//! use lane, light, pixels, visibility

//! if samples is written
var kept_samples: texture_storage_2d<rgba32uint, write>;

fn keep_sample(pixel: vec2u, samples: Samples, ray: u32) {
    let depth = bitcast<u32>(of_ray(samples.depth, ray));
    var other = samples.slot;
    if KEEP_OCCLUDERS { other = found_occluders; }
    if KEEP_SHARES { other = found_shares; }
    textureStore(
        kept_samples,
        pixel,
        vec4u(depth, of_ray_u(other, ray), of_ray_u(samples.component, ray), of_ray_u(samples.bits, ray)),
    );
}

fn keep_samples(pixels: Pixels, wanted: B, samples: Samples) {
    var ray = 0u;
    loop {
        if of_ray_b(wanted, ray) { keep_sample(pixel_of_ray(pixels, ray), samples, ray); }
        ray += 1u;
        if ray >= RAYS { break; }
    }
}

// Marks a pixel that was not wanted as a pixel without a sample. No target pixel reuses it.
fn keep_no_sample(pixel: vec2u) {
    textureStore(kept_samples, pixel, vec4u(0u, MISS, MISS, 0u));
}

//! if samples is none or read
// No samples are stored.
fn keep_sample(pixel: vec2u, samples: Samples, ray: u32) {}

fn keep_samples(pixels: Pixels, wanted: B, samples: Samples) {}

fn keep_no_sample(pixel: vec2u) {}
