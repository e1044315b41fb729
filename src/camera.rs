//! The stereo camera: pose, off-axis frusta and parallax. Geometry as DESIGN, section 2.

mod comfort;
mod fitting;
mod path;
mod ranges;

pub use comfort::Comfort;
pub use path::CameraPath;
pub use ranges::{MAX_EYE_COORDINATE, MAX_EYE_SHIFT, MAX_SIDE, MIN_PIXEL_ANGLE, SCREEN_DISTANCES};

use glam::{DVec3, Vec3};

pub(crate) use self::ranges::least_pixel_angle;
use self::ranges::{check_fields, check_precision, check_screen_distance, fault};
use crate::Error;

/// Depth of a ray that hits nothing, in every buffer; WGSL has no infinity. Results turn it into `f32::INFINITY`.
pub const FAR: f32 = 3.4e38;

/// Distance between human eyes in metres, on average (thesis, eq. 12).
pub const HUMAN_INTERAXIAL: f32 = 0.065;

/// The rectangle on the screen plane, given by angle or by width.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Aperture {
    VerticalFov(f32),
    ScreenWidth(f32),
}

/// The distance between the eyes, in world units or in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Interaxial {
    World(f32),
    Pixels(f32),
}

/// Two eyes that look through one screen rectangle (off-axis projection).
///
/// World space is right-handed with y up. Both eyes look along `f = normalize(target - eye)`; they stand at
/// `eye ∓ r e/2` with `r = normalize(f × up)`, left first. The screen lies at distance `d` along `f`, and what lies
/// on it has zero parallax. Setters take any value; [`StereoCamera::pose`] and every render check them.
///
/// ```
/// use stereotrace::{StereoCamera, glam::Vec3};
///
/// let camera = StereoCamera::look_at(Vec3::new(0.0, 1.0, 5.0), Vec3::ZERO)
///     .size(640, 480)
///     .vertical_fov_degrees(40.0)
///     .screen_distance(5.0)
///     .interaxial_pixels(10.0);
/// assert_eq!(camera.pose()?.parallax_px(5.0), 0.0);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StereoCamera {
    eye: Vec3,
    target: Vec3,
    up: Vec3,
    aperture: Aperture,
    screen_distance: f32,
    interaxial: Interaxial,
    width: u32,
    height: u32,
}

/// A checked camera, in numbers that kernels and formulas use.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Pose {
    /// Midpoint between the eyes, world space.
    pub eye: Vec3,
    /// View direction `f`, unit length.
    pub forward: Vec3,
    /// The picture's right `r`, unit length.
    pub right: Vec3,
    /// The picture's up `u = r × f`, unit length.
    pub up: Vec3,
    /// Distance `d` from the plane of the eyes to the screen, world units.
    pub screen_distance: f32,
    /// Screen rectangle's width `W` and height `H`, world units.
    pub screen_size: [f32; 2],
    /// Distance between the eyes `e`, world units.
    pub interaxial: f32,
    /// `e_px = e w / W`: the parallax at infinity, pixels.
    pub interaxial_px: f32,
    /// Picture size `[w, h]`, pixels.
    pub size: [u32; 2],
}

impl StereoCamera {
    /// A camera at `eye` (the midpoint between the eyes) that looks at `target`: up is +y, 640 x 480 pixels, 45
    /// degrees of vertical field of view, the screen at the target, and a thirtieth of that distance between the eyes.
    pub fn look_at(eye: Vec3, target: Vec3) -> Self {
        // f64, in which no square of a difference vanishes or overflows.
        let distance = eye.as_dvec3().distance(target.as_dvec3()) as f32;
        Self {
            eye,
            target,
            up: Vec3::Y,
            aperture: Aperture::VerticalFov(45.0),
            screen_distance: distance,
            interaxial: Interaxial::World(distance / 30.0),
            width: 640,
            height: 480,
        }
    }

    /// The midpoint between the eyes; the screen's distance and the interaxial stay.
    pub fn eye(mut self, eye: Vec3) -> Self {
        self.eye = eye;
        self
    }

    /// A point to look at; the screen's distance stays.
    pub fn target(mut self, target: Vec3) -> Self {
        self.target = target;
        self
    }

    /// The direction that is up in the picture; it must not be parallel to the view direction.
    pub fn up(mut self, up: Vec3) -> Self {
        self.up = up;
        self
    }

    /// Picture size in pixels.
    pub fn size(mut self, width: u32, height: u32) -> Self {
        (self.width, self.height) = (width, height);
        self
    }

    /// Vertical field of view in degrees, between 0 and 180.
    pub fn vertical_fov_degrees(mut self, degrees: f32) -> Self {
        self.aperture = Aperture::VerticalFov(degrees);
        self
    }

    /// Width `W` of the screen rectangle in world units, instead of the field of view.
    pub fn screen_width(mut self, width: f32) -> Self {
        self.aperture = Aperture::ScreenWidth(width);
        self
    }

    /// Distance `d` from the eyes to the screen, the plane of zero parallax, in world units.
    pub fn screen_distance(mut self, distance: f32) -> Self {
        self.screen_distance = distance;
        self
    }

    /// Distance `e` between the eyes in world units.
    pub fn interaxial(mut self, distance: f32) -> Self {
        self.interaxial = Interaxial::World(distance);
        self
    }

    /// Distance between the eyes in pixels of this picture: the parallax at infinity.
    pub fn interaxial_pixels(mut self, pixels: f32) -> Self {
        self.interaxial = Interaxial::Pixels(pixels);
        self
    }

    /// Checks the camera and works out its axes and sizes.
    ///
    /// Within these ranges `bracket-rays` shows what `naive` does, to the last bit, where adapters don't contract f32:
    ///
    /// | field | range |
    /// |---|---|
    /// | size | 1 to [`MAX_SIDE`] a side |
    /// | eye, target | coordinates within [`MAX_EYE_COORDINATE`], for both eyes |
    /// | screen distance | [`SCREEN_DISTANCES`] |
    /// | field of view or screen width, size, interaxial | pixels span [`MIN_PIXEL_ANGLE`] as seen from both eyes |
    /// | interaxial | 0, or so large that the eyes' rounding changes it by at most [`MAX_EYE_SHIFT`] of it |
    ///
    /// # Errors
    /// [`Error::Camera`], naming the field, for what lies outside of them, a field of view outside 0 to 180 degrees, a
    /// target that is the eye, or `up` parallel to the view.
    pub fn pose(&self) -> Result<Pose, Error> {
        check_fields(self)?;
        // f64, so that axes and corners are the nearest f32 also for far-off and tiny scenes.
        let forward = (self.target.as_dvec3() - self.eye.as_dvec3()).normalize_or_zero();
        if forward == DVec3::ZERO {
            return fault("target", self.target.to_string(), "it must differ from the eye");
        }
        check_screen_distance(self.screen_distance)?;
        let side = forward.cross(self.up.as_dvec3().normalize_or_zero());
        if side.length() <= 1e-6 {
            return fault("up", self.up.to_string(), "it must not be zero or parallel to the view direction");
        }
        let right = side.normalize();
        let (width, screen_size) = (self.width as f32, self.screen_size()?);
        let (interaxial, interaxial_px) = match self.interaxial {
            Interaxial::World(world) => (world, world * width / screen_size[0]),
            Interaxial::Pixels(pixels) => (pixels * screen_size[0] / width, pixels),
        };
        if !(interaxial >= 0.0 && interaxial.is_finite() && interaxial_px.is_finite()) {
            let value = match self.interaxial {
                Interaxial::World(world) => world.to_string(),
                Interaxial::Pixels(pixels) => format!("{pixels} px"),
            };
            return fault("interaxial", value, "it must be a number of at least 0");
        }
        let pose = Pose {
            eye: self.eye,
            forward: forward.as_vec3(),
            right: right.as_vec3(),
            up: right.cross(forward).as_vec3(),
            screen_distance: self.screen_distance,
            screen_size,
            interaxial,
            interaxial_px,
            size: [self.width, self.height],
        };
        check_precision(self, &pose)?;
        Ok(pose)
    }

    /// Width and height of the screen rectangle in world units.
    fn screen_size(&self) -> Result<[f32; 2], Error> {
        let (width, height) = (self.width as f32, self.height as f32);
        let positive = |value: f32| value > 0.0 && value.is_finite();
        let screen_size = match self.aperture {
            Aperture::VerticalFov(degrees) => {
                if !(degrees > 0.0 && degrees < 180.0) {
                    return fault("vertical_fov", degrees.to_string(), "it must lie between 0 and 180 degrees");
                }
                let screen_height = 2.0 * self.screen_distance * (0.5 * degrees).to_radians().tan();
                [screen_height * width / height, screen_height]
            }
            Aperture::ScreenWidth(screen_width) => {
                if !positive(screen_width) {
                    return fault("screen_width", screen_width.to_string(), "it must be above 0");
                }
                [screen_width, screen_width * height / width]
            }
        };
        if !screen_size.iter().all(|side| positive(*side)) {
            let value = format!("{} x {}", screen_size[0], screen_size[1]);
            return fault("screen size", value, "choose a field of view and a screen distance that f32 can hold");
        }
        Ok(screen_size)
    }
}

impl Pose {
    /// Parallax `x_r - x_l = e_px (1 - d/Z)` in pixels of a point at depth `z` (thesis, eq. 10, in pixels):
    /// `e_px` at infinity, 0 on the screen, `-e_px` at `d/2`.
    pub fn parallax_px(&self, z: f32) -> f32 {
        self.interaxial_px * (1.0 - self.screen_distance / z)
    }

    /// World position of an eye: -1 left, +1 right, 0 the midpoint.
    pub fn eye_position(&self, side: f32) -> Vec3 {
        (self.eye.as_dvec3() + self.right.as_dvec3() * f64::from(0.5 * side * self.interaxial)).as_vec3()
    }

    /// Where a world point lands in an eye's picture: `[x, y, Z]`, x and y in pixels from the top left corner
    /// (pixel centres at halves), `Z` its depth along the view direction.
    pub fn project(&self, point: Vec3, side: f32) -> [f32; 3] {
        let eye = self.eye.as_dvec3() + self.right.as_dvec3() * f64::from(0.5 * side * self.interaxial);
        let to = point.as_dvec3() - eye;
        let z = to.dot(self.forward.as_dvec3());
        let (w, h) = (f64::from(self.size[0]), f64::from(self.size[1]));
        let pixels = w / f64::from(self.screen_size[0]);
        let d = f64::from(self.screen_distance);
        // The screen is centred between the eyes, so an eye's own offset comes back in.
        let on_screen = to.dot(self.right.as_dvec3()) * d / z + f64::from(0.5 * side * self.interaxial);
        let y = to.dot(self.up.as_dvec3()) * d / z;
        [(0.5 * w + on_screen * pixels) as f32, (0.5 * h - y * pixels) as f32, z as f32]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> StereoCamera {
        StereoCamera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO)
            .size(200, 100)
            .screen_width(4.0)
            .screen_distance(5.0)
            .interaxial(0.2)
    }

    #[test]
    fn a_point_on_the_right_is_right_of_the_centre_and_moves_left_as_it_comes_near() {
        let pose = camera().pose().unwrap();
        let mut last = f32::INFINITY;
        for z in [-10.0, 0.0, 2.0, 3.0] {
            let point = Vec3::new(0.3, 0.0, z);
            let ([left, ..], [right, _, depth]) = (pose.project(point, -1.0), pose.project(point, 1.0));
            assert!(left > 100.0 && right > 100.0 - pose.interaxial_px);
            assert!((right - left - pose.parallax_px(depth)).abs() < 1e-4, "{left} {right} {depth}");
            assert!(right - left < last);
            last = right - left;
        }
    }

    #[test]
    fn parallax_is_e_at_infinity_zero_on_the_screen_and_minus_e_at_half_of_it() {
        let pose = camera().pose().unwrap();
        assert_eq!(pose.interaxial_px, 10.0);
        assert_eq!(pose.parallax_px(f32::INFINITY), 10.0);
        assert_eq!(pose.parallax_px(FAR), 10.0);
        assert_eq!(pose.parallax_px(5.0), 0.0);
        assert_eq!(pose.parallax_px(2.5), -10.0);
    }

    #[test]
    fn an_invalid_camera_names_its_field() {
        let broken = [
            (camera().size(0, 5), "size"),
            (camera().screen_distance(0.0), "screen_distance"),
            (camera().screen_distance(f32::NAN), "screen_distance"),
            (camera().interaxial(-1.0), "interaxial"),
            (camera().interaxial(f32::NAN), "interaxial"),
            (camera().interaxial_pixels(f32::INFINITY), "interaxial"),
            (camera().up(Vec3::Z), "up"),
            (camera().up(Vec3::ZERO), "up"),
            (camera().vertical_fov_degrees(180.0), "vertical_fov"),
            (camera().screen_width(-1.0), "screen_width"),
            (camera().screen_distance(1e38), "screen_distance"),
            (camera().up(Vec3::INFINITY), "up"),
            (camera().vertical_fov_degrees(1e-44), "screen size"),
            (StereoCamera::look_at(Vec3::ONE, Vec3::ONE), "target"),
            (StereoCamera::look_at(Vec3::NAN, Vec3::ONE), "eye"),
        ];
        for (camera, field) in broken {
            let message = camera.pose().unwrap_err().to_string();
            assert!(message.starts_with(&format!("invalid camera: {field} is ")), "{message}");
        }
    }

    #[test]
    fn a_fitting_camera_sees_the_whole_box() {
        for scale in [1e-3, 1.0, 1e6] {
            for (width, height) in [(100, 100), (300, 100), (100, 300)] {
                let (low, high) = (Vec3::new(1.0, 2.0, 3.0) * scale, Vec3::new(4.0, 9.0, 5.0) * scale);
                let pose = StereoCamera::fitting((low, high), width, height).pose().unwrap();
                for corner in 0..8 {
                    let pick = |bit: usize, axis: usize| if corner >> bit & 1 == 0 { low[axis] } else { high[axis] };
                    let [x, y, z] = pose.project(Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2)), 0.0);
                    assert!(z > 0.0 && (0.0..width as f32).contains(&x) && (0.0..height as f32).contains(&y));
                }
            }
        }
    }

    #[test]
    fn a_moved_camera_keeps_its_screen_and_interaxial() {
        let (eye, target) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(-4.0, 0.5, 0.0));
        let (moved, before) = (camera().eye(eye).target(target).pose().unwrap(), camera().pose().unwrap());
        let direction = StereoCamera::look_at(eye, target).pose().unwrap().forward;
        assert_eq!((moved.eye, moved.forward), (eye, direction));
        assert_eq!((moved.screen_distance, moved.interaxial), (before.screen_distance, before.interaxial));
    }
}
