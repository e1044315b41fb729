//! Computes depth intervals whose points have equal parallax in whole pixels: the paper's table 4, by its equation 7.

/// An interval of depths behind the screen, in screen distances, whose parallax rounds to the same number of pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quantum {
    pub(crate) pixels: i32,
    pub(crate) from: f64,
    /// End of the interval, infinite for the last one.
    pub(crate) to: f64,
}

/// Returns the parallax of a point at depth z behind the screen, in pixels: e z / (z + d).
fn shift(e_px: f64, z: f64) -> f64 {
    e_px * z / (z + 1.0)
}

/// Returns the depth that has this parallax.
fn depth(e_px: f64, shift: f64) -> f64 {
    if shift < e_px { shift / (e_px - shift) } else { f64::INFINITY }
}

/// Returns all intervals from half the screen's distance, the paper's nearest depth, to infinity. Parallax is rounded
/// to pixels.
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
