//! Differences between two views, as defined in DESIGN, section 7, and between disparities.

mod disparity;

pub use disparity::{BAD_PX, DisparityError, compare_disparity};

use crate::{Error, MISS, Pose, View, message::counted};

/// Parallaxes of one surface differ by at most this, in pixels.
const SAME_SURFACE_PX: f64 = 1.0;

/// Difference of a view from the true view. Colours are 8-bit sRGB; their distances are Euclidean, in steps of 1/255.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Difference {
    /// Percentage of pixels with the same colour.
    pub identical_percent: f64,
    /// Percentage of pixels with another colour.
    pub differing_percent: f64,
    /// Mean distance in RGB of the differing pixels, 0 if there are none (the measure of Adelson & Hodges 1993).
    pub mean_difference: f64,
    /// Mean squared error `Σ|c - c'|² / (3 w h)` (Es & İşler 2007).
    pub mse: f64,
    /// Peak signal-to-noise ratio `10 log10(255² / mse)` in dB, infinite for identical pictures.
    pub psnr: f64,
    /// 99.9th percentile of the distance in RGB: at least 99.9% of all pixels have no larger distance. Unlike PSNR, it
    /// shows a few wrong silhouettes.
    pub p999: f64,
    /// Percentage of pixels with the wrong surface: the objects differ (sky counts as an object), or parallax differs
    /// by over 1 px.
    pub wrong_surface_percent: f64,
    /// Largest difference in parallax of any pixel, in pixels.
    pub largest_parallax_error_px: f64,
    /// Percentage of pixels in which either view shows a surface. All other pixels show sky in both views, which is
    /// easy to get right.
    pub surface_percent: f64,
    /// Percentage of these surface pixels with the same colour; 100 if there are none.
    pub identical_of_surfaces_percent: f64,
    /// Percentage of these surface pixels that count for [`Self::wrong_surface_percent`]; 0 if there are none.
    pub wrong_of_surfaces_percent: f64,
}

/// Compares a view with the true view, both seen from `pose`.
///
/// # Errors
/// [`Error::Sizes`] if the views and the pose differ in size, or the size is zero.
pub fn compare(view: &View, truth: &View, pose: &Pose) -> Result<Difference, Error> {
    let pixels = checked_pixels(view, truth, pose)?;

    let squares: Vec<u32> = view.rgba8.iter().zip(&truth.rgba8).map(|(a, b)| squared_distance(*a, *b)).collect();
    let differing = squares.iter().filter(|&&square| square > 0).count();
    let distance_sum: f64 = squares.iter().map(|&square| f64::from(square).sqrt()).sum();
    let square_sum: u64 = squares.iter().map(|&square| u64::from(square)).sum();
    let mse = square_sum as f64 / (3 * pixels) as f64;

    let parallax = |z: f32| f64::from(pose.parallax_px(z));
    let errors = view.depth.iter().zip(&truth.depth).map(|(&a, &b)| (parallax(a) - parallax(b)).abs());
    let objects = view.object.iter().zip(&truth.object);
    let (mut wrong_surface, mut largest_parallax_error_px) = (0, 0.0_f64);
    let (mut surfaces, mut differing_surfaces, mut wrong_of_surfaces) = (0, 0, 0);
    for ((error, (object, true_object)), &square) in errors.zip(objects).zip(&squares) {
        // A NaN depth must count as wrong.
        let error = if error.is_nan() { f64::INFINITY } else { error };
        let wrong = object != true_object || error > SAME_SURFACE_PX;
        let surface = *object != MISS || *true_object != MISS;
        wrong_surface += usize::from(wrong);
        surfaces += usize::from(surface);
        differing_surfaces += usize::from(surface && square > 0);
        wrong_of_surfaces += usize::from(surface && wrong);
        largest_parallax_error_px = largest_parallax_error_px.max(error);
    }

    let percent = |count: usize| 100.0 * count as f64 / pixels as f64;
    let of_surfaces = |count: usize| 100.0 * count as f64 / surfaces.max(1) as f64;
    Ok(Difference {
        identical_percent: percent(pixels - differing),
        differing_percent: percent(differing),
        mean_difference: distance_sum / differing.max(1) as f64,
        mse,
        psnr: if square_sum == 0 { f64::INFINITY } else { 10.0 * (255.0 * 255.0 / mse).log10() },
        p999: f64::from(permille_999(squares)).sqrt(),
        wrong_surface_percent: percent(wrong_surface),
        largest_parallax_error_px,
        surface_percent: percent(surfaces),
        identical_of_surfaces_percent: 100.0 - of_surfaces(differing_surfaces),
        wrong_of_surfaces_percent: of_surfaces(wrong_of_surfaces),
    })
}

/// Returns the number of pixels if all lists have that many entries and it is not 0.
fn checked_pixels(view: &View, truth: &View, pose: &Pose) -> Result<usize, Error> {
    let fault = |sizes, reason| Err(Error::Sizes { sizes, reason });
    let [width, height] = pose.size;
    let by = |width: u32, height: u32| format!("{width}x{height}");
    for [other_width, other_height] in [[view.width, view.height], [truth.width, truth.height]] {
        if [other_width, other_height] != pose.size {
            let sizes = format!("{} and {}", by(other_width, other_height), by(width, height));
            return fault(sizes, "both views and the camera must have the same size");
        }
    }
    let pixels = width as usize * height as usize;
    if pixels == 0 {
        return fault(by(width, height), "width and height must be at least 1");
    }
    for one in [view, truth] {
        for count in [one.rgba8.len(), one.depth.len(), one.object.len()] {
            if count != pixels {
                let value = format!("{} with {}", by(width, height), counted(count, "pixel", "pixels"));
                return fault(value, "every list of a view must have width * height entries");
            }
        }
    }
    Ok(pixels)
}

/// Returns the squared distance of two colours without alpha; at most 3 * 255².
fn squared_distance([r, g, b, _]: [u8; 4], [true_r, true_g, true_b, _]: [u8; 4]) -> u32 {
    let square = |a: u8, b: u8| u32::from(a.abs_diff(b)).pow(2);
    square(r, true_r) + square(g, true_g) + square(b, true_b)
}

/// Returns the smallest value that at least 999 of 1000 do not exceed (nearest rank); `values` must not be empty.
fn permille_999(mut values: Vec<u32>) -> u32 {
    let rank = (999 * values.len()).div_ceil(1000);
    *values.select_nth_unstable(rank - 1).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::StereoCamera;
    use crate::glam::Vec3;

    /// `e_px` = 10 and `d` = 5: parallax 10 (1 - 5/Z).
    fn pose(width: u32, height: u32) -> Pose {
        let camera = StereoCamera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO).size(width, height);
        camera.interaxial_pixels(10.0).pose().unwrap()
    }

    /// A grey wall on the screen, object 0, with sky in its last pixel.
    fn wall(width: u32, height: u32) -> View {
        let pixels = (width * height) as usize;
        let mut view = View {
            width,
            height,
            rgba8: vec![[100, 100, 100, 255]; pixels],
            linear: vec![[0.127, 0.127, 0.127, 1.0]; pixels],
            depth: vec![5.0; pixels],
            primitive: vec![0; pixels],
            albedo: Vec::new(),
            cost: Vec::new(),
            object: vec![0; pixels],
        };
        view.depth[pixels - 1] = f32::INFINITY;
        view.object[pixels - 1] = MISS;
        view
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-5 * b.abs().max(1.0)
    }

    #[test]
    fn identical_views_do_not_differ() {
        // The last pixel is sky, so a view of one pixel shows no surface.
        for (width, height, surface_percent) in [(1, 1, 0.0), (50, 40, 99.95)] {
            let expected = Difference {
                identical_percent: 100.0,
                differing_percent: 0.0,
                mean_difference: 0.0,
                mse: 0.0,
                psnr: f64::INFINITY,
                p999: 0.0,
                wrong_surface_percent: 0.0,
                largest_parallax_error_px: 0.0,
                surface_percent,
                identical_of_surfaces_percent: 100.0,
                wrong_of_surfaces_percent: 0.0,
            };
            let view = wall(width, height);
            assert_eq!(compare(&view, &view, &pose(width, height)).unwrap(), expected);
        }
    }

    #[test]
    fn one_changed_pixel_changes_each_figure_as_computed_by_hand() {
        let truth = wall(20, 10);
        let mut view = truth.clone();
        view.rgba8[7] = [103, 96, 112, 255]; // (3, -4, 12): distance 13
        view.depth[7] = 10.0; // parallax 5 in place of 0
        let difference = compare(&view, &truth, &pose(20, 10)).unwrap();
        assert_eq!(difference.identical_percent, 99.5);
        assert_eq!(difference.differing_percent, 0.5);
        assert_eq!(difference.mean_difference, 13.0);
        assert!(close(difference.mse, 169.0 / 600.0));
        // 255² * 600 / 169 = 230857.99; its decimal logarithm is 5.363345
        assert!(close(difference.psnr, 53.63345), "{}", difference.psnr);
        assert_eq!(difference.p999, 13.0); // one of 200 is more than a thousandth
        assert_eq!(difference.wrong_surface_percent, 0.5);
        assert!(close(difference.largest_parallax_error_px, 5.0));
        // Differences are symmetric.
        assert_eq!(compare(&truth, &view, &pose(20, 10)).unwrap(), difference);
    }

    #[test]
    fn sky_in_both_views_counts_for_all_pixels_and_not_for_surfaces() {
        // The pixels show a correct surface, a surface of another colour and depth, and sky twice.
        let mut truth = wall(4, 1);
        (truth.depth[2], truth.object[2]) = (f32::INFINITY, MISS);
        let mut view = truth.clone();
        view.rgba8[1] = [0, 0, 0, 255];
        view.depth[1] = 10.0;
        let figures = |view: &View, truth: &View| {
            let found = compare(view, truth, &pose(4, 1)).unwrap();
            let of_all = [found.identical_percent, found.wrong_surface_percent];
            (of_all, found.surface_percent, [found.identical_of_surfaces_percent, found.wrong_of_surfaces_percent])
        };
        assert_eq!(figures(&view, &truth), ([75.0, 25.0], 50.0, [50.0, 50.0]));
        // Different sky colours do not count for surfaces.
        view.rgba8[2] = [0, 0, 0, 255];
        assert_eq!(figures(&view, &truth), ([50.0, 25.0], 50.0, [50.0, 50.0]));
        // With sky in one view only, a third pixel shows a surface, which is wrong and has another colour.
        (view.depth[2], view.object[2]) = (5.0, 0);
        let of_three = [100.0 - 200.0 / 3.0, 200.0 / 3.0];
        for (view, truth) in [(&view, &truth), (&truth, &view)] {
            assert_eq!(figures(view, truth), ([50.0, 50.0], 75.0, of_three));
        }
    }

    #[test]
    fn the_mean_difference_is_of_differing_pixels_only() {
        let truth = wall(10, 10);
        let mut view = truth.clone();
        view.rgba8[0] = [101, 100, 100, 255];
        view.rgba8[1] = [100, 100, 97, 255];
        view.rgba8[2] = [100, 100, 100, 0]; // alpha is ignored
        let difference = compare(&view, &truth, &pose(10, 10)).unwrap();
        assert_eq!((difference.differing_percent, difference.mean_difference), (2.0, 2.0));
        assert!(close(difference.mse, 10.0 / 300.0));
    }

    #[test]
    fn a_thousandth_of_the_pixels_stays_below_the_percentile() {
        let truth = wall(50, 40);
        let mut view = truth.clone();
        for (count, expected) in [(1, 0.0), (2, 0.0), (3, 20.0), (4, 20.0)] {
            view.rgba8[count] = [120, 100, 100, 255];
            assert_eq!(compare(&view, &truth, &pose(50, 40)).unwrap().p999, expected, "{count}");
        }
    }

    #[test]
    fn a_surface_is_wrong_by_object_or_by_more_than_a_pixel() {
        let truth = wall(10, 10);
        let wrong = |depth: f32, object: u32| {
            let mut view = truth.clone();
            (view.depth[3], view.object[3]) = (depth, object);
            compare(&view, &truth, &pose(10, 10)).unwrap().wrong_surface_percent
        };
        assert_eq!(wrong(5.0, 0), 0.0);
        assert_eq!(wrong(5.0, 1), 1.0);
        assert_eq!(wrong(5.0, MISS), 1.0);
        assert_eq!(wrong(5.5, 0), 0.0); // 10 (1 - 5/5.5) = 0.91 px
        assert_eq!(wrong(5.6, 0), 1.0); // 1.07 px
        assert_eq!(wrong(4.5, 0), 1.0); // -1.11 px
        assert_eq!(wrong(4.6, 0), 0.0); // -0.87 px
        assert_eq!(wrong(f32::NAN, 0), 1.0);
    }

    #[test]
    fn sky_in_place_of_a_surface_is_wrong_by_the_parallax_at_infinity() {
        let truth = wall(2, 1);
        let mut view = truth.clone();
        (view.depth[0], view.object[0]) = (f32::INFINITY, MISS);
        let difference = compare(&view, &truth, &pose(2, 1)).unwrap();
        assert_eq!(difference.wrong_surface_percent, 50.0);
        assert!(close(difference.largest_parallax_error_px, 10.0));
    }

    #[test]
    fn sizes_that_do_not_match_are_an_error() {
        let (small, large) = (wall(2, 2), wall(2, 3));
        let message = compare(&large, &small, &pose(2, 2)).unwrap_err().to_string();
        assert!(message.starts_with("sizes do not match: 2x3 and 2x2; "), "{message}");
        assert!(compare(&small, &large, &pose(2, 2)).is_err());
        assert!(compare(&small, &small, &pose(4, 1)).is_err());
        let mut short = wall(2, 2);
        short.depth.pop();
        let message = compare(&small, &short, &pose(2, 2)).unwrap_err().to_string();
        assert!(message.contains("2x2 with 3 pixels"), "{message}");
        let (mut empty, mut nowhere) = (wall(1, 1), pose(1, 1));
        (empty.width, nowhere.size) = (0, [0, 1]);
        assert!(compare(&empty, &empty, &nowhere).is_err());
    }
}
