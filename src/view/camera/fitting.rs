//! A camera for an object of unknown size.

use glam::DVec3;

use super::StereoCamera;
use crate::view::camera::{MAX_COORDINATE, MIN_EXTENT};

/// Largest tangent of half the horizontal field of view, in a camera fitted to an object.
const WIDEST_FIT: f64 = 3.0;
/// Largest offset of an eye from the midpoint, as a share of the screen distance, in a camera fitted to an object.
const EYES_ASIDE: f64 = 1.0 / 60.0;
/// Largest coordinate of the midpoint between the eyes, in a camera fitted to an object. It keeps the eyes within
/// `MAX_EYE_COORDINATE`.
const FARTHEST_FIT: f64 = 1.95e8;

impl StereoCamera {
    /// Makes a camera for an object of unknown size. It looks from the front (+z), a little from the right and above.
    /// Both eyes' pictures contain the sphere around `bounds` (low and high corner, world coordinates). The screen
    /// passes through the sphere's centre, and the interaxial is a thirtieth of the nearest distance.
    ///
    /// The vertical field of view is 35 degrees. It is less for pictures at least ten times as wide as high. It is
    /// greater where the eyes would leave [`MAX_EYE_COORDINATE`](super::MAX_EYE_COORDINATE) of an origin at 0. A sphere
    /// too small for f32 is seen as if its radius were [`MIN_EXTENT`].
    ///
    /// [`Scene::bounds`](crate::Scene::bounds) returns the bounds of a scene. The camera is valid for every box within
    /// a scene's coordinates and for pictures with aspects up to 16. A render rejects a small scene far from its own
    /// origin, since f32 can't represent its eyes.
    pub fn fitting(bounds: (DVec3, DVec3), width: u32, height: u32) -> Self {
        let (low, high) = bounds;
        let center = low.midpoint(high);
        let radius = match 0.5 * low.distance(high) {
            radius if radius > 0.0 => radius,
            _ => 1.0,
        };
        let radius = radius.max(f64::from(MIN_EXTENT));
        let ratio = f64::from(width) / f64::from(height.max(1));
        let half_height = 17.5_f64.to_radians().tan();
        let mut half_height = half_height.min(WIDEST_FIT / ratio);
        let narrower = half_height.min(half_height * ratio);
        let mut distance = radius * (1.0 + (narrower + EYES_ASIDE).powi(2)).sqrt() / narrower;
        let mut direction = DVec3::new(0.35, 0.25, 1.0).normalize();
        let farthest =
            |direction: DVec3| ((FARTHEST_FIT - direction.signum() * center) / direction.abs()).min_element();
        let is_near_origin = center.abs().max_element() <= f64::from(MAX_COORDINATE);
        if is_near_origin && distance > farthest(direction) {
            // The side towards the origin has the most room.
            direction *= DVec3::select(center.cmpgt(DVec3::ZERO), DVec3::NEG_ONE, DVec3::ONE);
            distance = distance.min(farthest(direction));
            let sine = radius / distance;
            half_height *= (1.05 * sine / (1.0 - sine * sine).sqrt() / narrower).max(1.0);
        }
        let eye = center + direction * distance;
        Self::look_at(eye, center)
            .size(width, height)
            .vertical_fov_degrees((2.0 * half_height.atan()).to_degrees() as f32)
            .screen_distance(distance as f32)
            .interaxial(((distance - radius).max(0.1 * distance) / 30.0) as f32)
    }
}
