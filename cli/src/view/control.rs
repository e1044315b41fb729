//! Stores the pose of the eyes and moves it by mouse and keys.

use std::{error::Error, f64::consts::PI};

use stereotrace::{
    Pose, Projection, StereoCamera,
    glam::{DQuat, DVec3},
};

/// Minimum angle between the view and the up direction, in radians. The picture's right direction is undefined if the
/// view and up directions are parallel.
const LEAST_SLANT: f64 = 0.03;
/// Factor of the screen distance for one step of the wheel.
const ZOOM: f64 = 0.9;

/// Pose of the eyes in world coordinates. The values are in f64, so that many small moves do not add up rounding
/// errors. The eyes look at the middle of the screen, where parallax is zero, and orbit around it. Equirectangular eyes
/// look straight ahead; the window's head turns instead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    eye: DVec3,
    /// View direction, of unit length.
    forward: DVec3,
    /// Up direction of the world, of unit length.
    axis: DVec3,
    /// Distance to the orbit's centre in world units: the middle of the screen, or the target of parallel cameras.
    reach: f64,
    /// Screen distance in world units, infinite for parallel cameras. With equirectangular eyes only the window has
    /// one.
    screen_distance: f64,
    interaxial: f64,
    /// Vertical field of view in degrees; `None` for equirectangular eyes.
    fov: Option<f32>,
}

impl Place {
    /// Returns the pose of a camera's eyes.
    ///
    /// # Errors
    /// Fails if pixels are not square or the principal point is not the picture's centre, since a move would lose the
    /// calibration.
    pub(super) fn of(camera: &StereoCamera) -> Result<Self, Box<dyn Error>> {
        let pose = camera.pose()?;
        let Pose { eye, forward, screen_distance, subject_distance, interaxial, size, .. } = pose;
        let fov = match (pose.focal_px(), pose.principal_px(0.0)) {
            (Some([fx, fy]), Some([x, y])) => {
                let middle = size.map(|side| 0.5 * f64::from(side));
                let most = 1e-3 * middle[0].max(middle[1]);
                if (x - middle[0]).abs().max((y - middle[1]).abs()) > most || (fx / fy - 1.0).abs() > 1e-3 {
                    return Err(
                        "a calibrated camera with pixels that are not square, or a principal point off the picture's \
                         middle, can't be moved: use `stereotrace render`"
                            .into(),
                    );
                }
                Some((2.0 * (middle[1] / fy).atan()).to_degrees() as f32)
            }
            _ => None,
        };
        Ok(Self {
            eye,
            forward: forward.as_dvec3().normalize(),
            axis: camera.up_direction().as_dvec3().normalize(),
            reach: subject_distance.into(),
            screen_distance: screen_distance.into(),
            interaxial: interaxial.into(),
            fov,
        })
    }

    /// Returns the camera moved to this pose. Its size and up direction do not change.
    pub(super) fn camera(&self, camera: StereoCamera) -> StereoCamera {
        let camera = camera.eye(self.eye()).target(self.target()).interaxial(self.interaxial());
        match (camera.projection_kind(), self.fov) {
            (Projection::OffAxis | Projection::ToeIn, Some(fov)) => {
                camera.vertical_fov_degrees(fov).screen_distance(self.screen_distance())
            }
            _ => camera,
        }
    }

    /// Returns whether the cameras of two places differ.
    pub(super) fn is_elsewhere(&self, other: &Self) -> bool {
        match self.fov {
            Some(_) => self != other,
            None => Self { screen_distance: other.screen_distance, ..*self } != *other,
        }
    }

    pub(super) fn eye(&self) -> DVec3 {
        self.eye
    }

    /// Returns the middle of the screen.
    pub(super) fn target(&self) -> DVec3 {
        self.middle()
    }

    pub(super) fn screen_distance(&self) -> f32 {
        self.screen_distance as f32
    }

    pub(super) fn interaxial(&self) -> f32 {
        self.interaxial as f32
    }

    /// Returns the vertical field of view in degrees; `None` for equirectangular eyes.
    pub(super) fn fov(&self) -> Option<f32> {
        self.fov
    }

    fn middle(&self) -> DVec3 {
        self.eye + self.forward * self.reach
    }

    fn right(&self) -> DVec3 {
        self.forward.cross(self.axis).normalize()
    }

    /// Turns the view by angles to the left and upwards, in radians. The midpoint between the eyes does not move.
    pub(super) fn look(&mut self, left: f64, up: f64) {
        let slant = self.forward.angle_between(self.axis);
        let (lowest, highest) = (slant + LEAST_SLANT - PI, slant - LEAST_SLANT);
        let up = up.clamp(lowest.min(0.0), highest.max(0.0));
        let raised = DQuat::from_axis_angle(self.right(), up) * self.forward;
        self.forward = (DQuat::from_axis_angle(self.axis, left) * raised).normalize();
    }

    /// Turns the view as [`Place::look`] does, and moves the eyes so that the middle of the screen does not move.
    pub(super) fn orbit(&mut self, left: f64, up: f64) {
        let middle = self.middle();
        self.look(left, up);
        self.eye = middle - self.forward * self.reach;
    }

    /// Moves the eyes so that points on the screen plane move right and down by these pixels, in a picture of this
    /// height.
    pub(super) fn pan(&mut self, right: f64, down: f64, height: u32) {
        let Some(fov) = self.fov else { return };
        let pixel = 2.0 * self.reach * (0.5 * f64::from(fov)).to_radians().tan() / f64::from(height.max(1));
        let up = self.right().cross(self.forward);
        self.eye += pixel * (up * down - self.right() * right);
    }

    /// Moves towards the middle of the screen by steps of the wheel. The interaxial scales with the distance, so that
    /// an object at the screen keeps its apparent depth.
    pub(super) fn zoom(&mut self, steps: f64) {
        let (middle, factor) = (self.middle(), ZOOM.powf(steps));
        self.reach *= factor;
        self.screen_distance *= factor;
        self.interaxial *= factor;
        self.eye = middle - self.forward * self.reach;
    }

    /// Moves the eyes right, up and ahead, in units of the distance to the orbit's centre.
    pub(super) fn fly(&mut self, [right, up, ahead]: [f64; 3]) {
        self.eye += self.reach * (self.right() * right + self.axis * up + self.forward * ahead);
    }

    /// Moves the eyes as [`Place::fly`] does, where ahead is turned by angles to the right and upwards, in radians.
    pub(super) fn fly_turned(&mut self, by: [f64; 3], [right, up]: [f64; 2]) {
        let mut turned = *self;
        turned.look(-right, up);
        turned.fly(by);
        self.eye = turned.eye;
    }

    /// Multiplies the interaxial by a factor.
    pub(super) fn spread(&mut self, factor: f64) {
        self.interaxial *= factor;
    }

    /// Multiplies the screen distance by a factor. A screen at infinity moves to the orbit's centre if `factor` is
    /// below 1.
    pub(super) fn move_screen(&mut self, factor: f64) {
        if self.screen_distance.is_finite() {
            self.screen_distance *= factor;
            if self.fov.is_some() {
                self.reach = self.screen_distance;
            }
        } else if factor < 1.0 {
            self.screen_distance = self.reach;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, TAU};

    use stereotrace::camera::Intrinsics;

    use super::*;

    fn camera() -> StereoCamera {
        StereoCamera::look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO).size(200, 100).vertical_fov_degrees(90.0)
    }

    fn place() -> Place {
        Place::of(&camera()).unwrap()
    }

    fn near(a: DVec3, b: DVec3) -> bool {
        a.distance(b) < 1e-5
    }

    #[test]
    fn a_place_is_where_its_camera_is() {
        let (before, after) = (camera().pose().unwrap(), place().camera(camera()).pose().unwrap());
        assert_eq!((before.eye, before.forward, before.size), (after.eye, after.forward, after.size));
        assert_eq!((before.screen_distance, before.interaxial), (after.screen_distance, after.interaxial));
        assert!((before.screen_size[1] - after.screen_size[1]).abs() < 1e-5);
    }

    #[test]
    fn an_orbit_keeps_the_middle_of_the_screen_and_comes_round() {
        let mut place = place();
        place.orbit(FRAC_PI_2, 0.0);
        // The view turns left, from -z to -x, so the eyes go to +x.
        assert!(near(place.eye(), DVec3::new(5.0, 0.0, 0.0)) && near(place.target(), DVec3::ZERO), "{place:?}");
        for _ in 0..300 {
            place.orbit(TAU / 400.0, 0.0);
        }
        assert!(near(place.eye(), DVec3::new(0.0, 0.0, 5.0)) && near(place.target(), DVec3::ZERO), "{place:?}");
        assert_eq!((place.screen_distance(), place.interaxial()), (5.0, camera().pose().unwrap().interaxial));
    }

    #[test]
    fn no_turn_goes_over_the_pole() {
        for up in [9.0, -9.0] {
            let mut place = place();
            for _ in 0..3 {
                place.orbit(0.0, up);
                assert!(place.camera(camera()).pose().is_ok(), "{place:?}");
            }
            let slant = place.forward.angle_between(place.axis);
            let pole = if up > 0.0 { 0.0 } else { PI };
            assert!(((slant - pole).abs() - LEAST_SLANT).abs() < 1e-6, "{slant}");
            assert!(place.eye().z > 0.0, "{place:?}");
            place.orbit(0.0, -0.5 * up.signum());
            assert!(((place.forward.angle_between(place.axis) - pole).abs() - LEAST_SLANT - 0.5).abs() < 1e-6);
        }
    }

    #[test]
    fn what_is_on_the_screen_follows_the_mouse() {
        let (mut place, point) = (place(), DVec3::new(1.0, 0.5, 0.0));
        let at = |place: &Place| place.camera(camera()).pose().unwrap().project(point, 0.0);
        let before = at(&place);
        place.pan(12.0, -7.0, 100);
        let after = at(&place);
        assert!((after[0] - before[0] - 12.0).abs() < 1e-3 && (after[1] - before[1] + 7.0).abs() < 1e-3);
        assert_eq!(place.screen_distance(), 5.0);
    }

    #[test]
    fn zoom_keeps_the_middle_and_the_parallax_there() {
        let mut place = place();
        let before = place.interaxial() / place.screen_distance();
        place.zoom(3.0);
        assert!(near(place.target(), DVec3::ZERO) && near(place.eye(), DVec3::Z * (5.0 * 0.729)), "{place:?}");
        assert!((place.interaxial() / place.screen_distance() - before).abs() < 1e-6);
        place.zoom(-3.0);
        assert!(near(place.eye(), DVec3::Z * 5.0));
    }

    #[test]
    fn flight_goes_where_the_eyes_look() {
        let mut place = place();
        place.look(FRAC_PI_2, 0.0);
        assert!(near(place.eye(), DVec3::Z * 5.0) && near(place.target(), DVec3::new(-5.0, 0.0, 5.0)), "{place:?}");
        place.fly([0.0, 0.0, 1.0]);
        assert!(near(place.eye(), DVec3::new(-5.0, 0.0, 5.0)), "{place:?}");
        place.fly([1.0, 0.2, 0.0]);
        assert!(near(place.eye(), DVec3::new(-5.0, 1.0, 0.0)), "{place:?}");
    }

    #[test]
    fn parallel_cameras_stay_parallel_until_their_screen_is_asked_for() {
        let camera = camera().screen_distance(f32::INFINITY).interaxial(0.1);
        let mut place = Place::of(&camera).unwrap();
        place.orbit(FRAC_PI_2, 0.0);
        place.zoom(1.0);
        assert!(near(place.eye(), DVec3::X * 4.5) && near(place.target(), DVec3::ZERO), "{place:?}");
        let pose = place.camera(camera).pose().unwrap();
        assert!(pose.screen_distance == f32::INFINITY && (pose.interaxial - 0.09).abs() < 1e-6, "{pose:?}");
        place.move_screen(1.1);
        assert_eq!(place.screen_distance(), f32::INFINITY);
        place.move_screen(0.9);
        assert!((place.screen_distance() - 4.5).abs() < 1e-5);
    }

    #[test]
    fn calibrated_cameras_are_refused_unless_they_are_centred() {
        let centred = Intrinsics::new([90.0; 2], [100.0, 50.0]);
        let place = Place::of(&camera().intrinsics(centred)).unwrap();
        assert!(
            (f64::from(place.fov().unwrap()) - 2.0 * (50.0_f64 / 90.0).atan().to_degrees()).abs() < 1e-4,
            "{place:?}"
        );
        for other in [Intrinsics::new([90.0, 80.0], [100.0, 50.0]), Intrinsics::new([90.0; 2], [104.0, 50.0])] {
            assert!(Place::of(&camera().intrinsics(other)).unwrap_err().to_string().contains("can't be moved"));
        }
    }

    #[test]
    fn eyes_and_screen_move_alone() {
        let (mut place, before) = (place(), place());
        place.spread(2.0);
        place.move_screen(0.5);
        assert_eq!((place.interaxial, place.screen_distance), (2.0 * before.interaxial, 2.5));
        assert_eq!((place.eye, place.forward), (before.eye, before.forward));
    }
}
