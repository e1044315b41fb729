//! Moving cameras: orbits around the target, and paths through key frames.

use std::mem::discriminant;

use glam::{DQuat, DVec3};

use super::{Aperture, Interaxial, Projection, Screen, StereoCamera};
use crate::Error;

impl StereoCamera {
    /// Returns the camera turned about its target by an angle in radians, around its `up`. At positive angles the eye
    /// moves to its own right, so the object seems to turn to the left.
    pub fn orbited(mut self, angle: f32) -> Self {
        let axis = self.up.as_dvec3().normalize_or_zero();
        self.eye = self.target + DQuat::from_axis_angle(axis, f64::from(angle)) * (self.eye - self.target);
        self
    }
}

/// A camera path: cameras at key frames, with interpolation between them.
///
/// ```
/// use stereotrace::{CameraPath, StereoCamera, glam::Vec3};
///
/// let start = StereoCamera::look_at(4.0 * Vec3::Z, Vec3::ZERO);
/// let path = CameraPath::new(vec![(0.0, start), (24.0, start.eye(4.0 * Vec3::X))])?;
/// assert_eq!(path.frames(), 25);
/// assert_eq!(path.at(0.0), start);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    keys: Vec<(f32, StereoCamera)>,
}

impl CameraPath {
    /// Makes a path through these cameras, each at its frame. Frames need not be whole numbers.
    ///
    /// # Errors
    /// [`Error::Camera`] for:
    ///
    /// - no cameras, or an invalid camera,
    /// - frames below 0 or not in ascending order,
    /// - cameras given in different ways: field of view, screen width or intrinsics; interaxial in world units or
    ///   pixels; projection; picture size,
    /// - cameras with different intrinsics.
    pub fn new(keys: Vec<(f32, StereoCamera)>) -> Result<Self, Error> {
        let fault = |value: String, reason| Err(Error::Camera { field: "frame", value, reason });
        let mut last = None;
        for (frame, camera) in &keys {
            camera.pose()?;
            // f32 can't represent all whole numbers above this bound.
            if !(0.0..=16_777_216.0).contains(frame) || last.is_some_and(|(before, _)| *frame <= before) {
                return fault(frame.to_string(), "frames of a path must ascend from 0 or more to at most 2^24");
            }
            if last.is_some_and(|(_, before)| !alike(before, camera)) {
                let reason = "the cameras of a path must have the same picture size and projection, and give field of \
                              view and interaxial by the same options";
                return fault(frame.to_string(), reason);
            }
            last = Some((*frame, camera));
        }
        if last.is_none() {
            return fault("none".into(), "a path must have at least one camera");
        }
        Ok(Self { keys })
    }

    /// Sets the projection of all cameras, as [`StereoCamera::projection`] does.
    pub fn projection(mut self, projection: Projection) -> Self {
        self.keys.iter_mut().for_each(|(_, camera)| *camera = camera.projection(projection));
        self
    }

    /// Returns the number of frames from 0 to the last key frame.
    pub fn frames(&self) -> u32 {
        self.keys.last().map_or(0, |(frame, _)| *frame as u32 + 1)
    }

    /// Returns the camera at a frame. It does not move before the first key frame and after the last key frame.
    ///
    /// Eye, target and up follow a Catmull-Rom spline through the key frames, whose distances may differ. Field of
    /// view, interaxial and the reciprocal of the screen's distance are interpolated linearly, so parallax changes
    /// linearly too.
    pub fn at(&self, frame: f32) -> StereoCamera {
        let next = self.keys.partition_point(|(at, _)| *at <= frame);
        if next == 0 || next == self.keys.len() {
            return self.keys[next.saturating_sub(1)].1;
        }
        let ((from, a), (to, b)) = (self.keys[next - 1], self.keys[next]);
        let t = f64::from(frame - from) / f64::from(to - from);
        if t == 0.0 {
            return a;
        }
        let smooth = |part: fn(&StereoCamera) -> DVec3| self.smooth(next - 1, t, part);
        let linear = |a: f32, b: f32| (f64::from(a) + t * (f64::from(b) - f64::from(a))) as f32;
        let aperture = match (a.aperture, b.aperture) {
            (Aperture::VerticalFov(a), Aperture::VerticalFov(b)) => Aperture::VerticalFov(linear(a, b)),
            (Aperture::ScreenWidth(a), Aperture::ScreenWidth(b)) => Aperture::ScreenWidth(linear(a, b)),
            (a, _) => a, // `new` refuses other pairs
        };
        let interaxial = match (a.interaxial, b.interaxial) {
            (Interaxial::World(a), Interaxial::World(b)) => Interaxial::World(linear(a, b)),
            (Interaxial::Pixels(a), Interaxial::Pixels(b)) => Interaxial::Pixels(linear(a, b)),
            (a, _) => a,
        };
        let screen = match (a.screen, b.screen) {
            (Screen::Distance(a), Screen::Distance(b)) => Screen::Distance(1.0 / linear(1.0 / a, 1.0 / b)),
            (a, _) => a,
        };
        StereoCamera {
            eye: smooth(|camera| camera.eye),
            target: smooth(|camera| camera.target),
            up: smooth(|camera| camera.up.as_dvec3()).as_vec3(),
            aperture,
            interaxial,
            screen,
            ..a
        }
    }

    /// Returns a vector of the camera at `t`, 0 to 1, between the key frames `first` and `first + 1`, by a cubic
    /// Hermite curve.
    fn smooth(&self, first: usize, t: f64, part: fn(&StereoCamera) -> DVec3) -> DVec3 {
        let at = |key: usize| (f64::from(self.keys[key].0), part(&self.keys[key].1));
        let tangent = |key: usize| -> DVec3 {
            let (before, after) = (at(key.saturating_sub(1)), at((key + 1).min(self.keys.len() - 1)));
            (after.1 - before.1) / (after.0 - before.0)
        };
        let ((from, a), (to, b)) = (at(first), at(first + 1));
        let (in_a, in_b) = (tangent(first) * (to - from), tangent(first + 1) * (to - from));
        let (t2, t3) = (t * t, t * t * t);
        let sum = a * (2.0 * t3 - 3.0 * t2 + 1.0) + in_a * (t3 - 2.0 * t2 + t) + b * (3.0 * t2 - 2.0 * t3);
        sum + in_b * (t3 - t2)
    }
}

fn alike(a: &StereoCamera, b: &StereoCamera) -> bool {
    let apertures = match (a.aperture, b.aperture) {
        // Intrinsics can't change along a path.
        (Aperture::Lenses(a), Aperture::Lenses(b)) => a == b,
        (a, b) => discriminant(&a) == discriminant(&b),
    };
    let screens = match (a.screen, b.screen) {
        (Screen::Offset(a), Screen::Offset(b)) => a == b,
        (a, b) => discriminant(&a) == discriminant(&b),
    };
    let rest =
        |camera: &StereoCamera| (discriminant(&camera.interaxial), camera.projection, camera.width, camera.height);
    apertures && screens && rest(a) == rest(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(x: f64) -> StereoCamera {
        StereoCamera::look_at(DVec3::new(x, 1.0, 5.0), DVec3::new(x, 0.0, 0.0))
    }

    #[test]
    fn an_orbit_keeps_its_distance_and_comes_back() {
        let start = camera(2.0);
        let quarter = start.orbited(std::f32::consts::FRAC_PI_2);
        // The eye looks along -z, so +x is to its right.
        assert!(quarter.eye.distance(DVec3::new(7.0, 1.0, 0.0)) < 1e-6, "{}", quarter.eye);
        assert_eq!(quarter.target, start.target);
        assert!(start.orbited(std::f32::consts::TAU).eye.distance(start.eye) < 1e-6);
    }

    #[test]
    fn a_path_meets_its_key_frames_and_goes_straight_where_they_do() {
        let keys = vec![(0.0, camera(0.0)), (4.0, camera(4.0)), (5.0, camera(5.0)), (9.5, camera(9.5))];
        let path = CameraPath::new(keys.clone()).unwrap();
        assert_eq!(path.frames(), 10);
        for (frame, key) in keys {
            assert_eq!(path.at(frame), key);
        }
        for frame in [0.3, 2.0, 4.9, 7.25] {
            assert!(
                path.at(frame).eye.distance(camera(f64::from(frame)).eye) < 1e-6,
                "{frame}: {}",
                path.at(frame).eye
            );
        }
        assert_eq!((path.at(-1.0), path.at(100.0)), (camera(0.0), camera(9.5)));
    }

    #[test]
    fn a_path_has_no_corner_at_a_key_frame() {
        let [a, b, c] = [DVec3::new(0.0, 0.0, 5.0), DVec3::new(2.0, 1.0, 4.0), DVec3::new(2.0, 3.0, 1.0)];
        let path =
            CameraPath::new(vec![(0.0, camera(0.0).eye(a)), (3.0, camera(0.0).eye(b)), (4.0, camera(0.0).eye(c))]);
        let path = path.unwrap();
        let step = 1.0 / 64.0;
        let speed = |from: f32| (path.at(from + step).eye - path.at(from).eye) / f64::from(step);
        let (before, after) = (speed(3.0 - step), speed(3.0));
        // The tangent at a key frame equals its finite difference, up to the error of this step.
        assert!(before.distance((c - a) / 4.0) < 0.1 && after.distance((c - a) / 4.0) < 0.1, "{before} {after}");
    }

    #[test]
    fn parallax_changes_evenly_where_the_screen_moves() {
        let path =
            CameraPath::new(vec![(0.0, camera(0.0).screen_distance(2.0)), (2.0, camera(0.0).screen_distance(6.0))]);
        assert_eq!(path.unwrap().at(1.0).screen, Screen::Distance(3.0));
    }

    #[test]
    fn paths_that_lead_nowhere_are_refused_by_name() {
        let refused = |keys: &[(f32, StereoCamera)]| CameraPath::new(keys.to_vec()).unwrap_err().to_string();
        assert!(refused(&[]).contains("at least one camera"));
        assert!(refused(&[(-1.0, camera(0.0))]).contains("frame is -1"));
        assert!(refused(&[(f32::NAN, camera(0.0))]).contains("frame is NaN"));
        assert!(refused(&[(1.0, camera(0.0)), (1.0, camera(1.0))]).contains("ascend"));
        let unlike = [(0.0, camera(0.0)), (1.0, camera(1.0).interaxial_pixels(3.0))];
        assert!(refused(&unlike).contains("by the same options"));
        assert!(refused(&[(0.0, camera(0.0).up(glam::Vec3::ZERO))]).contains("up is"));
    }
}
