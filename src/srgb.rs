//! The sRGB curve, and the brightness of its primaries.

use std::sync::LazyLock;

use glam::DVec3;

/// Rec. 709 luminance weights of linear colours.
pub(crate) const BRIGHTNESS: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// Linear values of the 256 sRGB bytes.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let encoded = byte as f64 / 255.0;
        let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
});

/// Returns the linear value, 0 to 1, of an 8-bit sRGB channel.
pub(crate) fn linear_of(byte: u8) -> f32 {
    LINEAR[usize::from(byte)]
}

/// Encodes a linear value, clamped to 0 to 1, as an sRGB byte (IEC 61966-2-1).
pub(crate) fn encode(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    to_byte(encoded)
}

/// Returns the nearest byte of an encoded value, clamped to 0 to 1.
pub(crate) fn to_byte(encoded: f32) -> u8 {
    (encoded.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}
