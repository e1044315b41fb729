//! Errors of disparities, by the measures of the Middlebury and KITTI benchmarks.

use crate::{Error, message::counted};

/// Error thresholds of bad disparities, in pixels.
pub const BAD_PX: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// KITTI's outlier thresholds, both of which must be exceeded: pixels, and a share of the true disparity.
const OUTLIER: (f64, f64) = (3.0, 0.05);

/// Error of disparities, relative to the true disparities.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DisparityError {
    /// Number of counted pixels: pixels in the mask with a known true disparity.
    pub pixels: usize,
    /// Percentage of counted pixels for which a disparity was found.
    pub found_percent: f64,
    /// Percentage of counted pixels that are off by more than [`BAD_PX`], or not found (Middlebury's bad 0.5, 1, 2 and
    /// 4).
    pub bad_percent: [f64; 4],
    /// Percentage of counted pixels that are off by over 3 px and over 5% of the true disparity, or not found (KITTI's
    /// D1).
    pub d1_percent: f64,
    /// Mean error of the found disparities in pixels; 0 if there are none.
    pub mean_px: f64,
    /// Root mean square error of the found disparities in pixels; 0 if there are none.
    pub rms_px: f64,
}

/// Compares disparities with the true disparities in the pixels of `mask`
/// ([`EyeTruth::surfaces`](crate::EyeTruth::surfaces),
/// [`EyeTruth::surfaces_of_both`](crate::EyeTruth::surfaces_of_both)). Infinite and NaN values are unknown. Pixels with
/// unknown true disparities do not count. Disparities that were not found are bad by every measure.
///
/// D1 is relative to the true disparity of parallel cameras: for an off-axis pair, add
/// [`Pose::interaxial_px`](crate::Pose::interaxial_px) to both lists.
///
/// ```
/// use stereotrace::metrics::compare_disparity;
///
/// let found = [10.0, 21.5, f32::INFINITY, 0.0];
/// let error = compare_disparity(&found, &[10.25, 20.0, 5.0, 5.0], &[true, true, true, false])?;
/// assert_eq!((error.pixels, error.bad_percent[1].round()), (3, 67.0));
/// # Ok::<(), stereotrace::Error>(())
/// ```
///
/// # Errors
/// [`Error::Sizes`] if the lists differ in length, or no pixel counts.
pub fn compare_disparity(found: &[f32], truth: &[f32], mask: &[bool]) -> Result<DisparityError, Error> {
    let fault = |sizes, reason| Err(Error::Sizes { sizes, reason });
    if found.len() != truth.len() || found.len() != mask.len() {
        let counts = [found.len(), truth.len(), mask.len()].map(|count| counted(count, "pixel", "pixels"));
        return fault(counts.join(", "), "disparities, true disparities and mask must have the same length");
    }
    let known = found.iter().zip(truth).zip(mask).filter(|((_, truth), counts)| **counts && truth.is_finite());
    let (mut pixels, mut measured, mut outliers) = (0_usize, 0_usize, 0_usize);
    let (mut sum, mut squares, mut bad) = (0.0, 0.0, [0_usize; 4]);
    for ((&found, &truth), _) in known {
        pixels += 1;
        let is_found = found.is_finite();
        let error = if is_found { (f64::from(found) - f64::from(truth)).abs() } else { f64::INFINITY };
        bad.iter_mut().zip(BAD_PX).for_each(|(count, limit)| *count += usize::from(error > limit));
        outliers += usize::from(error > OUTLIER.0 && error > OUTLIER.1 * f64::from(truth).abs());
        if is_found {
            measured += 1;
            sum += error;
            squares += error * error;
        }
    }
    if pixels == 0 {
        return fault("0 pixels".into(), "no pixel of the mask has a known true disparity");
    }
    let percent = |count: usize| 100.0 * count as f64 / pixels as f64;
    let of_measured = |sum: f64| sum / measured.max(1) as f64;
    Ok(DisparityError {
        pixels,
        found_percent: percent(measured),
        bad_percent: bad.map(percent),
        d1_percent: percent(outliers),
        mean_px: of_measured(sum),
        rms_px: of_measured(squares).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_measure_counts_as_worked_out_by_hand() {
        // Errors: 0, 0.5 (not above the threshold), 0.75, 1.5, 3.5 (35% of 10), 3.5 (3.5% of 100), 6 (6% of 100), not
        // found, NaN.
        let truth = [10.0, 10.0, 10.0, 10.0, 10.0, 100.0, 100.0, 8.0, 8.0];
        let found = [10.0, 10.5, 9.25, 11.5, 13.5, 96.5, 106.0, f32::INFINITY, f32::NAN];
        let error = compare_disparity(&found, &truth, &[true; 9]).unwrap();
        let of_nine = |count: i32| 100.0 * f64::from(count) / 9.0;
        assert_eq!(error.pixels, 9);
        assert_eq!(error.found_percent, of_nine(7));
        assert_eq!(error.bad_percent, [7, 6, 5, 3].map(of_nine));
        assert_eq!(error.d1_percent, of_nine(4));
        assert_eq!(error.mean_px, 15.75 / 7.0);
        let squares = 0.25 + 0.5625 + 2.25 + 2.0 * 12.25 + 36.0;
        assert!((error.rms_px - (squares / 7.0_f64).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_mask_and_what_is_not_known_are_left_out() {
        let truth = [1.0, f32::INFINITY, 1.0, f32::NAN];
        let error = compare_disparity(&[1.0, 1.0, 9.0, 1.0], &truth, &[true, true, false, true]).unwrap();
        assert_eq!((error.pixels, error.bad_percent, error.d1_percent), (1, [0.0; 4], 0.0));
        for (found, truth, mask) in [
            (&[1.0][..], &[1.0, 2.0][..], &[true][..]),
            (&[1.0], &[1.0], &[true, true]),
            (&[1.0], &[1.0], &[false]),
            (&[1.0], &[f32::INFINITY], &[true]),
            (&[], &[], &[]),
        ] {
            let message = compare_disparity(found, truth, mask).unwrap_err().to_string();
            assert!(message.starts_with("sizes do not match: "), "{message}");
        }
        // A list in which no disparity was found is a valid, bad result.
        let none = compare_disparity(&[f32::INFINITY], &[1.0], &[true]).unwrap();
        assert_eq!((none.bad_percent, none.d1_percent, none.mean_px, none.rms_px), ([100.0; 4], 100.0, 0.0, 0.0));
    }
}
