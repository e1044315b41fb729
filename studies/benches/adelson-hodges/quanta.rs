//! Which depths the second eye sees equally far aside: the paper's table 4, by its equation 7.

/// Depths behind the screen, in its distances from the eyes, that land a whole number of pixels aside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quantum {
    pub(crate) pixels: i32,
    pub(crate) from: f64,
    /// Infinite in the last one.
    pub(crate) to: f64,
}

/// How far to the right the right eye sees what the left one sees at a depth behind the screen, pixels: e z / (z + d).
fn shift(e_px: f64, z: f64) -> f64 {
    e_px * z / (z + 1.0)
}

/// Where it is that far.
fn depth(e_px: f64, shift: f64) -> f64 {
    if shift < e_px { shift / (e_px - shift) } else { f64::INFINITY }
}

/// From half the screen's distance, before which the paper has nothing, to infinity; pixels are rounded.
pub(crate) fn quanta(e_px: f64) -> Vec<Quantum> {
    const NEAREST: f64 = -0.5;
    let first = (shift(e_px, NEAREST) + 0.5).floor() as i32;
    let mut quanta = Vec::new();
    let mut from = NEAREST;
    for pixels in first.. {
        let to = depth(e_px, f64::from(pixels) + 0.5);
        quanta.push(Quantum { pixels, from, to });
        if to.is_infinite() {
            break;
        }
        from = to;
    }
    quanta
}
