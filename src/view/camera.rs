//! The stereo camera: pose, off-axis frusta and parallax (DESIGN, section 2).

mod circle;
mod comfort;
mod display;
mod fitting;
mod frustum;
mod intrinsics;
mod lens;
#[cfg(feature = "json")]
mod lens_json;
mod path;
mod projection;
mod ranges;
mod toe_in;
mod warp;

pub use comfort::Comfort;
pub use display::{ComfortRule, Comfortable, Display};
pub use intrinsics::Intrinsics;
pub use lens::{Distortion, Lens};
pub use path::CameraPath;
pub use projection::{Equirectangular, PoleMerge, Projection, Span};
pub use ranges::{
    MAX_COORDINATE, MAX_EYE_COORDINATE, MAX_EYE_SHIFT, MAX_SIDE, MAX_WORLD_COORDINATE, MIN_EXTENT, MIN_PIXEL_ANGLE,
    SCREEN_DISTANCES,
};

use glam::{DVec3, Vec3};

pub(crate) use self::intrinsics::Lenses;
use self::ranges::{check_eyes, check_fields, check_pixel_angles, check_screen_distance, fault};
pub(crate) use self::{
    circle::{Circle, CircleRay, FROM_POLE},
    frustum::{Field, Frustum, Parallax, Projector, Sphere},
    ranges::least_pixel_angle,
};
use crate::Error;

/// Depth of a ray that hits nothing, in all buffers, since WGSL has no infinity. Results contain `f32::INFINITY`
/// instead.
pub const FAR: f32 = 3.4e38;

/// Average distance between human eyes in metres (thesis, eq. 12).
pub const HUMAN_INTERAXIAL: f32 = 0.065;

/// Field of view: a vertical angle in degrees, the width of the screen rectangle, or focal lengths and the eyes' mean
/// principal point in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Aperture {
    VerticalFov(f32),
    ScreenWidth(f32),
    Lenses(Lenses),
}

/// Position of the screen: its distance from the eyes, or the offset between the eyes' principal points in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Screen {
    Distance(f32),
    Offset(f64),
}

/// Interaxial, in world units or in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Interaxial {
    World(f32),
    Pixels(f32),
}

/// A stereo camera: two eyes that look through one screen rectangle (off-axis projection), or two parallel cameras.
///
/// World space is right-handed with y up. Both eyes look along `f = normalize(target - eye)`. The left and right eye
/// are at `eye ∓ r e/2` with `r = normalize(f × up)`. The screen lies at distance `d` along `f`; points on it have
/// zero parallax. With `d` infinite the eyes are parallel cameras: points at infinity have zero parallax, nearer points
/// have disparity `f_px e / Z`.
///
/// [`Intrinsics`] describe a calibrated pair, and [`Projection`] a toed-in pair or pictures of all directions. Setters
/// accept any value; [`StereoCamera::pose`] and every render check the values.
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
    pub(crate) eye: DVec3,
    pub(crate) target: DVec3,
    pub(crate) up: Vec3,
    pub(crate) aperture: Aperture,
    pub(crate) screen: Screen,
    pub(crate) interaxial: Interaxial,
    pub(crate) projection: Projection,
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// A checked camera, as the values that kernels and formulas use. [`Pose::intrinsics`] returns them as a calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Pose {
    /// Midpoint between the eyes, world coordinates. [`Pose::eye_position`] returns the eyes' own positions.
    pub eye: DVec3,
    /// View direction `f`, unit length.
    pub forward: Vec3,
    /// Right axis `r` of the picture, unit length.
    pub right: Vec3,
    /// Up axis `u = r × f` of the picture, unit length.
    pub up: Vec3,
    /// Distance `d` from the plane of the eyes to the screen, world units; infinite for parallel cameras.
    pub screen_distance: f32,
    /// Screen rectangle's width `W` and height `H`, world units; infinite for parallel cameras.
    pub screen_size: [f32; 2],
    /// Interaxial `e`, world units.
    pub interaxial: f32,
    /// `e_px = e w / W = f_px e / d`: the parallax at infinity, pixels; 0 for parallel cameras.
    pub interaxial_px: f32,
    /// Picture size `[w, h]`, pixels.
    pub size: [u32; 2],
    /// How rays leave the eyes. For toed-in eyes the axes of this pose belong to the midpoint; [`Pose::of_eye`] gives
    /// an eye's own axes. `screen_size` and `interaxial_px` then describe the off-axis camera with the same settings.
    /// Equirectangular pictures and cameras with lenses have the values of parallel cameras there.
    pub projection: Projection,
    /// Distance to the subject in world units, for rules that need a length. It is the screen's distance, or the
    /// target's distance if the screen is at infinity.
    pub subject_distance: f32,
    /// The directions that the picture shows.
    pub(crate) field: Field,
    /// Origin of the rendered scene. The rendered eyes are f32 positions relative to it. `None` before a picture is
    /// rendered.
    pub(crate) scene_origin: Option<DVec3>,
}

impl StereoCamera {
    /// Makes a camera at `eye` (the midpoint between the eyes) that looks at `target`. Both are world coordinates,
    /// [`Vec3`] or [`DVec3`].
    ///
    /// Up is +y, the picture has 640 x 480 pixels, and the vertical field of view is 45 degrees. The screen is at the
    /// target, and the interaxial is a thirtieth of that distance.
    pub fn look_at(eye: impl Into<DVec3>, target: impl Into<DVec3>) -> Self {
        let (eye, target) = (eye.into(), target.into());
        let distance = eye.distance(target) as f32;
        Self {
            eye,
            target,
            up: Vec3::Y,
            aperture: Aperture::VerticalFov(45.0),
            screen: Screen::Distance(distance),
            interaxial: Interaxial::World(distance / 30.0),
            projection: Projection::OffAxis,
            width: 640,
            height: 480,
        }
    }

    /// Sets the midpoint between the eyes, world coordinates. The screen's distance and the interaxial stay.
    pub fn eye(mut self, eye: impl Into<DVec3>) -> Self {
        self.eye = eye.into();
        self
    }

    /// Sets the point to look at, world coordinates. The screen's distance stays.
    pub fn target(mut self, target: impl Into<DVec3>) -> Self {
        self.target = target.into();
        self
    }

    /// Sets the direction that is up in the picture. It must not be parallel to the view direction.
    pub fn up(mut self, up: Vec3) -> Self {
        self.up = up;
        self
    }

    /// Returns the vector given to [`StereoCamera::up`]. It may have any length and need not be perpendicular to the
    /// view direction.
    pub fn up_direction(&self) -> Vec3 {
        self.up
    }

    /// Returns the midpoint between the eyes, as given to [`StereoCamera::look_at`] or [`StereoCamera::eye`].
    pub fn eye_position(&self) -> DVec3 {
        self.eye
    }

    /// Returns the point given to [`StereoCamera::target`].
    pub fn target_position(&self) -> DVec3 {
        self.target
    }

    /// Sets the picture's size in pixels.
    pub fn size(mut self, width: u32, height: u32) -> Self {
        (self.width, self.height) = (width, height);
        self
    }

    /// Sets the vertical field of view in degrees, between 0 and 180.
    pub fn vertical_fov_degrees(mut self, degrees: f32) -> Self {
        self.aperture = Aperture::VerticalFov(degrees);
        self
    }

    /// Sets the width `W` of the screen rectangle in world units, instead of the field of view.
    pub fn screen_width(mut self, width: f32) -> Self {
        self.aperture = Aperture::ScreenWidth(width);
        self
    }

    /// Sets the intrinsics of a calibrated pair, for a picture of this [`StereoCamera::size`]. They replace the field
    /// of view and the screen's distance, which becomes `d = fx e / doffs`, or infinite if `doffs` is 0.
    ///
    /// A [`StereoCamera::screen_distance`] set afterwards overrides that distance; the principal points keep their
    /// mean.
    pub fn intrinsics(mut self, intrinsics: Intrinsics) -> Self {
        let (lenses, offset) = intrinsics.split();
        (self.aperture, self.screen) = (Aperture::Lenses(lenses), Screen::Offset(offset));
        self
    }

    /// Sets the distance `d` from the eyes to the screen, the plane of zero parallax, in world units. `f32::INFINITY`
    /// makes the eyes parallel cameras.
    pub fn screen_distance(mut self, distance: f32) -> Self {
        self.screen = Screen::Distance(distance);
        self
    }

    /// Returns parallel cameras with the same field of view and the same interaxial in world units.
    ///
    /// # Errors
    /// Returns the errors of [`StereoCamera::pose`].
    pub fn parallel(self) -> Result<Self, Error> {
        let pose = self.pose()?;
        if matches!(pose.projection, Projection::Equirectangular(_) | Projection::Lenses(_)) {
            return Ok(self);
        }
        let mut camera = self.interaxial(pose.interaxial).screen_distance(f32::INFINITY);
        // A screen at infinity has no width.
        if let Aperture::ScreenWidth(_) = camera.aperture {
            let [height, distance] = [pose.screen_size[1], pose.screen_distance].map(f64::from);
            camera.aperture = Aperture::VerticalFov((2.0 * (0.5 * height / distance).atan()).to_degrees() as f32);
        }
        Ok(camera)
    }

    /// Returns the camera with a picture of another width in pixels, and the same field of view and shape as nearly as
    /// whole pixels allow. The interaxial keeps its length in world units.
    ///
    /// ```
    /// use stereotrace::Builtin;
    ///
    /// let camera = Builtin::Hall.camera(1280, 720);
    /// let pose = camera.resized(320)?.pose()?;
    /// assert_eq!(pose.size, [320, 180]);
    /// assert_eq!(pose.interaxial, camera.pose()?.interaxial);
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns the errors of [`StereoCamera::pose`].
    pub fn resized(self, width: u32) -> Result<Self, Error> {
        let pose = self.pose()?;
        let [from_width, from_height] = pose.size.map(f64::from);
        let height = (f64::from(width) * from_height / from_width).round().clamp(1.0, 16.0 * f64::from(width)) as u32;
        // Scaled intrinsics keep the field of view, also for cameras given by intrinsics.
        let scales = [f64::from(width) / from_width, f64::from(height) / from_height];
        let camera = self.interaxial(pose.interaxial).size(width, height);
        if let Projection::Lenses(lenses) = self.projection {
            return Ok(camera.projection(Projection::Lenses(lenses.map(|lens| lens.scaled(scales, 0.0)))));
        }
        Ok(match pose.intrinsics() {
            Some(intrinsics) => camera.projection(Projection::OffAxis).intrinsics(intrinsics.scaled(scales)),
            None => camera,
        })
    }

    /// Sets how rays leave the eyes.
    ///
    /// [`Projection::Equirectangular`] pictures have no field of view and no screen, so those settings are ignored. The
    /// `up` direction is their vertical axis, and the target gives the azimuth in their middle. Their interaxial must
    /// be given in world units.
    pub fn projection(mut self, projection: Projection) -> Self {
        self.projection = projection;
        self
    }

    /// Returns how rays leave the eyes.
    pub fn projection_kind(&self) -> Projection {
        self.projection
    }

    /// Sets the interaxial `e` in world units.
    pub fn interaxial(mut self, distance: f32) -> Self {
        self.interaxial = Interaxial::World(distance);
        self
    }

    /// Sets the interaxial in pixels of this picture, which is the parallax at infinity. It requires a screen at a
    /// finite distance, since parallel cameras have no parallax at infinity.
    pub fn interaxial_pixels(mut self, pixels: f32) -> Self {
        self.interaxial = Interaxial::Pixels(pixels);
        self
    }

    /// Checks the camera and computes its axes and sizes.
    ///
    /// Within these ranges `bracket-rays` renders the same picture as `naive`, to the last bit, on adapters that don't
    /// contract f32:
    ///
    /// | field | range |
    /// |---|---|
    /// | size | 1 to [`MAX_SIDE`] pixels per side |
    /// | eye, target | within [`MAX_WORLD_COORDINATE`]; eyes within [`MAX_EYE_COORDINATE`] of the scene's origin |
    /// | screen distance, given or by principal points | [`SCREEN_DISTANCES`], or infinite |
    /// | field of view, screen width, intrinsics, size, interaxial | both eyes' pixels span [`MIN_PIXEL_ANGLE`] |
    /// | intrinsics | focal lengths above 0, `cx1` at least `cx0`, and equal if the interaxial is 0 |
    /// | interaxial | 0, or so large that the eyes' rounding changes it by at most [`MAX_EYE_SHIFT`] of it |
    ///
    /// The limits on eyes and interaxial that depend on [`Scene::origin`](crate::Scene::origin) are checked by a
    /// render.
    ///
    /// # Errors
    /// [`Error::Camera`], naming the field, for:
    ///
    /// - values outside these ranges,
    /// - a field of view outside 0 to 180 degrees,
    /// - a target equal to the eye, or `up` parallel to the view,
    /// - a screen at infinity with a screen width or an interaxial in pixels,
    /// - principal points with an interaxial in pixels,
    /// - different principal points with toed-in eyes.
    pub fn pose(&self) -> Result<Pose, Error> {
        check_fields(self)?;
        // f64 arithmetic gives the nearest f32 axes and corners, even in distant and tiny scenes.
        let towards = self.target - self.eye;
        let forward = towards.normalize_or_zero();
        if forward == DVec3::ZERO {
            return fault("target", self.target.to_string(), "it must differ from the eye");
        }
        if let Screen::Distance(distance) = self.screen {
            check_screen_distance(distance)?;
        }
        let side = forward.cross(self.up.as_dvec3().normalize_or_zero());
        if side.length() <= 1e-6 {
            return fault("up", self.up.to_string(), "it must not be zero or parallel to the view direction");
        }
        let right = side.normalize();
        let target_distance = (towards.length() as f32).clamp(*SCREEN_DISTANCES.start(), *SCREEN_DISTANCES.end());
        match self.projection {
            Projection::Equirectangular(projection) => return self.around(projection, right, target_distance),
            Projection::Lenses(lenses) => return self.through_glass(lenses, [right, forward], target_distance),
            Projection::OffAxis | Projection::ToeIn => {}
        }
        let mut view = match (self.screen, self.aperture) {
            (Screen::Distance(d), Aperture::VerticalFov(degrees)) if d.is_finite() => {
                let height = 2.0 * d * half_fov(degrees)?.tan();
                self.through_screen(d, [height * self.width as f32 / self.height as f32, height])?
            }
            (Screen::Distance(d), Aperture::ScreenWidth(width)) if d.is_finite() => {
                if !(width > 0.0 && width.is_finite()) {
                    return fault("screen_width", width.to_string(), "it must be above 0");
                }
                self.through_screen(d, [width, width * self.height as f32 / self.width as f32])?
            }
            _ => self.through_lenses()?,
        };
        let is_finite = view.screen_distance.is_finite();
        if self.projection == Projection::ToeIn {
            // Each eye's picture is centred on the eye's own axis.
            view.frustum.shift = 0.0;
        }
        let pose = Pose {
            eye: self.eye,
            forward: forward.as_vec3(),
            right: right.as_vec3(),
            up: right.cross(forward).as_vec3(),
            screen_distance: view.screen_distance,
            screen_size: view.screen_size,
            interaxial: view.interaxial,
            interaxial_px: view.interaxial_px,
            size: [self.width, self.height],
            projection: self.projection,
            subject_distance: if is_finite { view.screen_distance } else { target_distance },
            field: Field::Screen(view.frustum),
            scene_origin: None,
        };
        check_pixel_angles(self, &pose)?;
        Ok(pose)
    }

    /// Checks an equirectangular camera with this right axis and distance of the target.
    fn around(&self, projection: Equirectangular, right: DVec3, subject_distance: f32) -> Result<Pose, Error> {
        projection.check()?;
        let reason = "equirectangular pictures have no parallax at infinity: give it in world units";
        let interaxial = self.world_interaxial(reason)?;
        let up = self.up.as_dvec3().normalize();
        let field = Field::Sphere(Sphere { projection, angles: [projection.span.radians(), std::f64::consts::PI] });
        self.without_screen([right, up, up.cross(right)], interaxial, subject_distance, field)
    }

    /// Checks a camera with lenses, with these right and forward axes and this distance of the target.
    fn through_glass(
        &self,
        lenses: [Lens; 2],
        [right, forward]: [DVec3; 2],
        subject_distance: f32,
    ) -> Result<Pose, Error> {
        Lens::check_both(&lenses, [self.width, self.height])?;
        let reason = "eyes with lenses are parallel, without parallax at infinity: give it in world units";
        let interaxial = self.world_interaxial(reason)?;
        let axes = [right, right.cross(forward), forward];
        self.without_screen(axes, interaxial, subject_distance, Field::Lenses(lenses))
    }

    /// Returns the interaxial in world units. `reason` says why it can't be in pixels.
    fn world_interaxial(&self, reason: &'static str) -> Result<f32, Error> {
        match self.interaxial {
            Interaxial::World(interaxial) if interaxial >= 0.0 && interaxial.is_finite() => Ok(interaxial),
            Interaxial::World(_) => fault("interaxial", self.interaxial_text(), "it must be a number of at least 0"),
            Interaxial::Pixels(_) => fault("interaxial", self.interaxial_text(), reason),
        }
    }

    /// Returns the pose of parallel eyes that look through no screen, with these axes: right, up and forward.
    fn without_screen(
        &self,
        [right, up, forward]: [DVec3; 3],
        interaxial: f32,
        subject_distance: f32,
        field: Field,
    ) -> Result<Pose, Error> {
        let pose = Pose {
            eye: self.eye,
            forward: forward.as_vec3(),
            right: right.as_vec3(),
            up: up.as_vec3(),
            screen_distance: f32::INFINITY,
            screen_size: [f32::INFINITY; 2],
            interaxial,
            interaxial_px: 0.0,
            size: [self.width, self.height],
            projection: self.projection,
            subject_distance,
            field,
            scene_origin: None,
        };
        check_pixel_angles(self, &pose)?;
        Ok(pose)
    }

    /// Computes the view through a rectangle on a screen at a finite distance.
    fn through_screen(&self, distance: f32, screen_size: [f32; 2]) -> Result<Sight, Error> {
        if !screen_size.iter().all(|side| *side > 0.0 && side.is_finite()) {
            let value = format!("{} x {}", screen_size[0], screen_size[1]);
            return fault("screen size", value, "choose a field of view and a screen distance that f32 can hold");
        }
        let width = self.width as f32;
        let (interaxial, interaxial_px) = match self.interaxial {
            Interaxial::World(world) => (world, world * width / screen_size[0]),
            Interaxial::Pixels(pixels) => (pixels * screen_size[0] / width, pixels),
        };
        let [across, up] = screen_size.map(f64::from);
        let frustum =
            Frustum { distance: distance.into(), size: [across, up], center: [0.0; 2], shift: interaxial.into() };
        self.sight(distance, screen_size, interaxial, interaxial_px, frustum)
    }

    /// Computes the view by focal lengths and principal points. The principal points determine the screen's distance,
    /// or follow from it.
    fn through_lenses(&self) -> Result<Sight, Error> {
        let [w, h] = [self.width, self.height].map(f64::from);
        let lenses = match self.aperture {
            Aperture::Lenses(lenses) => lenses.checked()?,
            Aperture::VerticalFov(degrees) => Lenses::of_fov(f64::from(half_fov(degrees)?), [w, h]),
            Aperture::ScreenWidth(width) => {
                let reason = "give a finite screen distance with it, or use a field of view or intrinsics";
                return fault("screen_width", width.to_string(), reason);
            }
        };
        let Lenses { focal: [fx, fy], principal: [cx, cy] } = lenses;
        let (interaxial, offset, distance) = self.offset_and_distance(fx)?;
        let frustum = Frustum {
            distance: 1.0,
            size: [w / fx, h / fy],
            center: [(0.5 * w - cx) / fx, (cy - 0.5 * h) / fy],
            shift: offset / fx,
        };
        let screen_size = [w / fx * distance, h / fy * distance].map(|side| side as f32);
        self.sight(distance as f32, screen_size, interaxial as f32, offset as f32, frustum)
    }

    /// Returns the interaxial in world units, the offset between the principal points in pixels, and the screen's
    /// distance. `fx` is the focal length in pixels.
    fn offset_and_distance(&self, fx: f64) -> Result<(f64, f64, f64), Error> {
        match (self.screen, self.interaxial) {
            (Screen::Distance(d), Interaxial::World(e)) => {
                let (d, e) = (f64::from(d), f64::from(e));
                Ok((e, fx * e / d, d))
            }
            (Screen::Distance(d), Interaxial::Pixels(pixels)) if d.is_finite() => {
                let (d, pixels) = (f64::from(d), f64::from(pixels));
                Ok((pixels * d / fx, pixels, d))
            }
            (Screen::Offset(offset), Interaxial::World(e)) => {
                let e = f64::from(e);
                let distance = if offset == 0.0 { f64::INFINITY } else { fx * e / offset };
                self.check_offset(offset, distance)?;
                Ok((e, offset, distance))
            }
            (_, Interaxial::Pixels(_)) => {
                let reason = "in pixels it is the parallax at infinity, which principal points set, and which is 0 for \
                              parallel cameras: give it in world units";
                fault("interaxial", self.interaxial_text(), reason)
            }
        }
    }

    /// Checks the screen's distance that an offset between the principal points gives.
    fn check_offset(&self, offset: f64, distance: f64) -> Result<(), Error> {
        if offset.is_nan() || offset < 0.0 {
            let reason =
                "cx1 must be at least cx0: otherwise points at infinity would be farther left in the right view";
            return fault("doffs", offset.to_string(), reason);
        }
        if offset > 0.0 && self.projection == Projection::ToeIn {
            let reason = "toed-in eyes have equal principal points: give a screen distance after the intrinsics";
            return fault("doffs", offset.to_string(), reason);
        }
        if !distance.is_finite() && offset == 0.0 {
            return Ok(());
        }
        check_screen_distance(distance as f32).map_err(|_| Error::Camera {
            field: "screen_distance",
            value: format!("{:?}, from principal points {offset} px apart", distance as f32),
            reason: "fx times interaxial over their distance must lie between 1e-6 and 1e9; parallel cameras have \
                     equal principal points",
        })
    }

    fn sight(
        &self,
        screen_distance: f32,
        screen_size: [f32; 2],
        interaxial: f32,
        interaxial_px: f32,
        frustum: Frustum,
    ) -> Result<Sight, Error> {
        if !(interaxial >= 0.0 && interaxial.is_finite() && interaxial_px.is_finite()) {
            let value = match self.interaxial {
                Interaxial::World(world) => world.to_string(),
                Interaxial::Pixels(pixels) => format!("{pixels} px"),
            };
            return fault("interaxial", value, "it must be a number of at least 0");
        }
        Ok(Sight { screen_distance, screen_size, interaxial, interaxial_px, frustum })
    }

    /// Returns the interaxial as it was given.
    fn interaxial_text(&self) -> String {
        match self.interaxial {
            Interaxial::World(world) => format!("{world:?}"),
            Interaxial::Pixels(pixels) => format!("{pixels:?} px"),
        }
    }

    /// Checks the camera for a scene with this origin. The eyes are then f32 positions relative to it.
    ///
    /// # Errors
    /// Returns the errors of [`StereoCamera::pose`], and [`Error::Camera`] if f32 can't represent the eyes.
    pub(crate) fn pose_in(&self, scene_origin: DVec3) -> Result<Pose, Error> {
        let pose = Pose { scene_origin: Some(scene_origin), ..self.pose()? };
        check_eyes(self, &pose)?;
        Ok(pose)
    }

    /// Checks two eyes of a rendered pose that are `times` interaxials apart.
    ///
    /// # Errors
    /// [`Error::Camera`] if f32 can't represent the eyes.
    pub(crate) fn check_apart(&self, pose: &Pose, times: f32) -> Result<(), Error> {
        let apart = times * pose.interaxial;
        if !apart.is_finite() {
            return fault("interaxial", apart.to_string(), "it must be a number of at least 0");
        }
        let (camera, pose) = (self.interaxial(apart), pose.apart(times));
        check_pixel_angles(&camera, &pose)?;
        check_eyes(&camera, &pose)
    }
}

/// The fields of [`Pose`] that do not depend on the axes.
struct Sight {
    screen_distance: f32,
    screen_size: [f32; 2],
    interaxial: f32,
    interaxial_px: f32,
    frustum: Frustum,
}

/// Returns half of a vertical field of view, in radians.
fn half_fov(degrees: f32) -> Result<f32, Error> {
    if degrees > 0.0 && degrees < 180.0 {
        return Ok((0.5 * degrees).to_radians());
    }
    fault("vertical_fov", degrees.to_string(), "it must lie between 0 and 180 degrees")
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
            (camera().interaxial_pixels(3.0).vertical_fov_degrees(40.0).screen_distance(f32::INFINITY), "interaxial"),
            (camera().screen_distance(f32::INFINITY), "screen_width"),
            (camera().screen_distance(f32::NEG_INFINITY), "screen_distance"),
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
                let (low, high) = (DVec3::new(1.0, 2.0, 3.0) * scale, DVec3::new(4.0, 9.0, 5.0) * scale);
                let pose = StereoCamera::fitting((low, high), width, height).pose().unwrap();
                for corner in 0..8 {
                    let pick = |bit: usize, axis: usize| if corner >> bit & 1 == 0 { low[axis] } else { high[axis] };
                    let [x, y, z] = pose.project(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)), 0.0);
                    assert!(z > 0.0 && (0.0..width as f32).contains(&x) && (0.0..height as f32).contains(&y));
                }
            }
        }
    }

    #[test]
    fn parallel_cameras_see_as_much_from_as_far_apart() {
        let by_fov = camera().vertical_fov_degrees(40.0);
        for given in [camera(), by_fov, camera().interaxial_pixels(7.0), by_fov.screen_distance(f32::INFINITY)] {
            let (before, after) = (given.pose().unwrap(), given.parallel().unwrap().pose().unwrap());
            assert_eq!((after.screen_distance, after.interaxial), (f32::INFINITY, before.interaxial));
            let (before, after) = (before.intrinsics().unwrap(), after.intrinsics().unwrap());
            assert!((after.fx / before.fx - 1.0).abs() < 1e-6 && (after.fy / before.fy - 1.0).abs() < 1e-6);
            assert!(after.doffs() == 0.0 && (after.cx0 - 0.5 * (before.cx0 + before.cx1)).abs() < 1e-9);
        }
        assert!(camera().interaxial(-1.0).parallel().is_err());
    }

    #[test]
    fn a_moved_camera_keeps_its_screen_and_interaxial() {
        let (eye, target) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-4.0, 0.5, 0.0));
        let (moved, before) = (camera().eye(eye).target(target).pose().unwrap(), camera().pose().unwrap());
        let direction = StereoCamera::look_at(eye, target).pose().unwrap().forward;
        assert_eq!((moved.eye, moved.forward), (eye, direction));
        assert_eq!((moved.screen_distance, moved.interaxial), (before.screen_distance, before.interaxial));
    }
}
