// Conversion of linear colour to displayed colour.

//! use frame, lane

// Maps a channel of linear colour to 0..1, by exposure and then by clamping or tone mapping.
fn shown(linear: F) -> F {
    let x = linear * frame.display.exposure;
    if frame.display.filmic == 0u { return clamp(x, F(0.0), F(1.0)); }
    // Narkowicz 2015, "ACES Filmic Tone Mapping Curve". Values above 64 are white.
    let y = min(x, F(64.0));
    return clamp((y * (2.51 * y + 0.03)) / (y * (2.43 * y + 0.59) + 0.14), F(0.0), F(1.0));
}

fn srgb(linear: F) -> F {
    let high = 1.055 * pow(linear, F(1.0 / 2.4)) - 0.055;
    return select(high, 12.92 * linear, linear <= F(0.0031308));
}

// Returns linear colour as exposed 8-bit sRGB.
fn packed_srgb(color: F3) -> U {
    let x = U(floor(srgb(shown(color.x)) * 255.0 + 0.5));
    let y = U(floor(srgb(shown(color.y)) * 255.0 + 0.5));
    let z = U(floor(srgb(shown(color.z)) * 255.0 + 0.5));
    return x | (y << U(8u)) | (z << U(16u)) | U(0xff000000u);
}

// Returns the luminance of a linear colour (Rec. 709).
fn luminance(color: vec3f) -> f32 { return dot(color, vec3f(0.2126, 0.7152, 0.0722)); }
