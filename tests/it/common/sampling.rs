//! Shared parts of the tests with several samples per pixel.

use stereotrace::{Filter, StereoCamera, glam::Vec3};

/// Returns a camera with a screen whose width is a power of two. So a camera with more pixels has the same parameters
/// except for the size.
pub(crate) fn camera(width: u32, height: u32) -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.0, 0.5, 5.0), Vec3::ZERO)
        .screen_distance(5.0)
        .screen_width(4.0)
        .interaxial(0.25)
        .size(width, height)
}

/// Returns the weight `w(x)` of a filter, as its documentation defines it.
pub(crate) fn weight(filter: Filter, x: f64) -> f64 {
    let x = x.abs();
    match filter {
        Filter::Box => f64::from(u8::from(x < 0.5)),
        Filter::Tent => (1.0 - x).max(0.0),
        Filter::Gauss => ((-x * x / 0.5).exp() - (-1.5_f64 * 1.5 / 0.5).exp()).max(0.0),
        filter => panic!("{filter}"),
    }
}
