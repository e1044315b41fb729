// Samples of a view, kept for the views that are made from it.

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

// Stores that a pixel which was not wanted has no sample. It vouches for nothing.
fn keep_no_sample(pixel: vec2u) {
    textureStore(kept_samples, pixel, vec4u(0u, MISS, MISS, 0u));
}

//! if samples is none
// No method reuses visibility bits.
fn keep_sample(pixel: vec2u, samples: Samples, ray: u32) {}

fn keep_no_sample(pixel: vec2u) {}
