// Random numbers of a lane's pixels.

//! use lane, shadows

//! if soft is none
fn throw_dice(pixels: Pixels, salt: u32) {}

fn rays_asked() -> u32 { return shadow_rays; }

//! if soft is skipped or masked or asked or followed
// The pixels whose random numbers are drawn, in buffer coordinates.
var<private> dice: Pixels;
var<private> dice_salt: u32;
var<private> soft_rays: u32;

fn throw_dice(pixels: Pixels, salt: u32) {
    dice = pixels;
    dice_salt = salt;
}

fn rays_asked() -> u32 { return shadow_rays + soft_rays; }

//! end
// Hashes three words to three (Jarzynski & Olano 2020, "Hash Functions for GPU Rendering": pcg3d).
fn scrambled(words: vec3u) -> vec3u {
    var v = words * 1664525u + 1013904223u;
    v += v.yzx * v.zxy;
    v ^= v >> vec3u(16u);
    return v + v.yzx * v.zxy;
}
