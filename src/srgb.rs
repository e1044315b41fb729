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

/// Number of equal steps of linear light for which [`Bytes`] has a byte. No step has more than two bytes.
const STEPS: usize = 4096;

/// Where the bytes of the curve begin.
struct Bytes {
    /// The least linear value of each byte.
    least: [f32; 256],
    /// The byte of the least value in each step.
    first: [u8; STEPS + 1],
}

static BYTES: LazyLock<Bytes> = LazyLock::new(|| Bytes {
    least: std::array::from_fn(|byte| {
        // Values from 0 to 1 have the order of their bits.
        let (mut below, mut least) = (0, 1.0_f32.to_bits());
        while below < least {
            let middle = below + (least - below) / 2;
            if usize::from(curve(f32::from_bits(middle))) < byte { below = middle + 1 } else { least = middle }
        }
        f32::from_bits(least)
    }),
    first: std::array::from_fn(|step| curve(step as f32 / STEPS as f32)),
});

/// Encodes a linear value, clamped to 0 to 1, as an sRGB byte (IEC 61966-2-1). Its table gives the bytes of the formula
/// without a power per value.
pub(crate) fn encode(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let Bytes { least, first } = &*BYTES;
    let mut byte = first[(linear * STEPS as f32) as usize];
    while byte < 255 && linear >= least[usize::from(byte) + 1] {
        byte += 1;
    }
    byte
}

/// Returns the byte of a linear value by the formula.
fn curve(linear: f32) -> u8 {
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    to_byte(encoded)
}

/// Returns the nearest byte of an encoded value, clamped to 0 to 1.
pub(crate) fn to_byte(encoded: f32) -> u8 {
    (encoded.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_the_bytes_of_the_formula() {
        let same = |linear: f32| assert_eq!(encode(linear), curve(linear.clamp(0.0, 1.0)), "{linear}");
        for place in 0..=1_000_000 {
            same(place as f32 / 1e6);
        }
        // Beside the least value of each byte.
        for least in BYTES.least {
            let bits = least.to_bits();
            (bits.saturating_sub(300)..=(bits + 300).min(1.0_f32.to_bits()))
                .for_each(|bits| same(f32::from_bits(bits)));
        }
        for other in
            [-1.0, -0.0, 1.0 + f32::EPSILON, 7.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, f32::MIN_POSITIVE]
        {
            same(other);
        }
        for byte in 0..=255 {
            assert_eq!(encode(linear_of(byte)), byte);
        }
    }
}
