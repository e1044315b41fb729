//! The head that turns inside an equirectangular pair. The window shows what it sees, as a planar picture.

use std::f64::consts::{FRAC_PI_2, PI};

use stereotrace::{Span, glam::DMat3};

/// Vertical field of view of the window in degrees: at the beginning, and its limits.
const FOV: f64 = 70.0;
const FOVS: [f64; 2] = [20.0, 120.0];
/// Factor of the field of view for one step of the wheel.
const ZOOM: f64 = 0.9;

/// Direction and field of view of the head, relative to the pair's middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Head {
    /// Azimuths that the pair shows.
    span: Span,
    /// Angles to the right and upwards in radians.
    azimuth: f64,
    elevation: f64,
    /// Vertical field of view in degrees.
    fov: f64,
}

/// Planar pictures cut from an equirectangular pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cut {
    pub(super) span: Span,
    /// For each eye, the matrix from a window's coordinates (right, up, ahead) to the pair's.
    pub(super) to_pair: [DMat3; 2],
    /// Tangent of half the vertical field of view.
    pub(super) tangent: f64,
}

impl Head {
    /// Returns a head that looks at the middle of a pair.
    pub(super) fn new(span: Span) -> Self {
        Self { span, azimuth: 0.0, elevation: 0.0, fov: FOV }
    }

    /// Returns the head as it was at the beginning.
    pub(super) fn reset(&self) -> Self {
        Self::new(self.span)
    }

    /// Turns the head by angles to the right and upwards, in radians. In half a turn it stays within the pair.
    pub(super) fn turn(&mut self, right: f64, up: f64) {
        let azimuth = self.azimuth + right;
        self.azimuth = match self.span {
            Span::Full => (azimuth + PI).rem_euclid(2.0 * PI) - PI,
            Span::Half => azimuth.clamp(-FRAC_PI_2, FRAC_PI_2),
        };
        self.elevation = (self.elevation + up).clamp(-FRAC_PI_2, FRAC_PI_2);
    }

    /// Narrows the field of view by steps of the wheel.
    pub(super) fn zoom(&mut self, steps: f64) {
        self.fov = (self.fov * ZOOM.powf(steps)).clamp(FOVS[0], FOVS[1]);
    }

    /// Returns the head's angles to the right and upwards in radians.
    pub(super) fn angles(&self) -> [f64; 2] {
        [self.azimuth, self.elevation]
    }

    /// Returns the vertical field of view in degrees.
    pub(super) fn fov(&self) -> f64 {
        self.fov
    }

    /// Returns the tangent of half the vertical field of view.
    fn tangent(&self) -> f64 {
        (0.5 * self.fov).to_radians().tan()
    }

    /// Returns the angle of a pixel in the middle of a window of this height, in radians.
    pub(super) fn pixel(&self, height: u32) -> f64 {
        2.0 * self.tangent() / f64::from(height)
    }

    /// Returns the pictures for both eyes. A point at the horizontal distance `screen` from the eyes has no parallax.
    pub(super) fn cut(&self, interaxial: f64, screen: f64) -> Cut {
        // The left eye sees such a point to the right of its azimuth, by the angle at the viewing circle.
        let inwards = (0.5 * interaxial / screen).atan();
        let to_pair = [inwards, -inwards]
            .map(|inwards| DMat3::from_rotation_y(self.azimuth + inwards) * DMat3::from_rotation_x(-self.elevation));
        Cut { span: self.span, to_pair, tangent: self.tangent() }
    }
}

#[cfg(test)]
mod tests {
    use stereotrace::glam::DVec3;

    use super::*;

    #[test]
    fn a_head_turns_to_the_right_and_upwards() {
        let ahead = |head: &Head| head.cut(0.0, 1.0).to_pair[0] * DVec3::Z;
        let mut head = Head::new(Span::Full);
        assert_eq!(ahead(&head), DVec3::Z);
        head.turn(0.1, 0.0);
        assert!(ahead(&head).distance(DVec3::new(0.1_f64.sin(), 0.0, 0.1_f64.cos())) < 1e-12);
        head.turn(-0.1, 0.2);
        assert!(ahead(&head).distance(DVec3::new(0.0, 0.2_f64.sin(), 0.2_f64.cos())) < 1e-12);
        head.turn(4.0, 9.0);
        assert!((head.angles()[0] - (4.0 - 2.0 * PI)).abs() < 1e-12 && head.angles()[1] == FRAC_PI_2);
        let mut half = Head::new(Span::Half);
        half.turn(4.0, 0.0);
        assert_eq!(half.angles(), [FRAC_PI_2, 0.0]);
        half.zoom(-99.0);
        assert_eq!(half.fov(), FOVS[1]);
    }

    #[test]
    fn a_point_at_the_screen_is_in_the_middle_for_both_eyes() {
        let (interaxial, screen) = (0.2, 1.5);
        let cut = Head::new(Span::Full).cut(interaxial, screen);
        for (side, to_pair) in [-1.0, 1.0].into_iter().zip(cut.to_pair) {
            // The eye is on the circle, at a right angle to its ray, whose horizontal length is `screen`.
            let ray = to_pair * DVec3::Z;
            let eye = DVec3::new(ray.z, 0.0, -ray.x) * (side * 0.5 * interaxial);
            let point = eye + ray * screen;
            assert!(point.distance(DVec3::Z * screen.hypot(0.5 * interaxial)) < 1e-12, "{point}");
        }
    }
}
