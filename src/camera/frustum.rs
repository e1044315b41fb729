//! Where the eyes of a pose look, and how far points move from one to the other (DESIGN, section 2).

use glam::{DVec3, Vec3};

use super::{Intrinsics, Pose};

/// The picture's rectangle on a plane before the eyes: on the screen, where the camera was given by it, else at depth
/// 1. In f64: kernels get what is rounded once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frustum {
    /// From the plane of the eyes to that plane.
    pub(crate) distance: f64,
    /// Width and height there.
    pub(crate) size: [f64; 2],
    /// The rectangle's middle, to the right of the axis of the midpoint between the eyes and above it.
    pub(crate) center: [f64; 2],
    /// How much farther to the left the rectangle stands of an eye's own axis, for an eye that stands an interaxial to
    /// the right: the interaxial itself on the screen, which is one for all eyes, and 0 for parallel cameras.
    pub(crate) shift: f64,
}

impl Frustum {
    /// From the axis of an eye at an offset from the midpoint, in interaxials, to the rectangle's left side.
    fn left(&self, offset: f64) -> f64 {
        self.center[0] - 0.5 * self.size[0] - offset * self.shift
    }

    fn top(&self) -> f64 {
        self.center[1] + 0.5 * self.size[1]
    }

    /// From the axis of an eye that stands so far to either side to the farthest points of the rectangle's sides, in
    /// units of its distance.
    pub(crate) fn aside(&self, offset: f64) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| 0.5 * self.size[axis] + self.center[axis].abs());
        [(x + offset * self.shift) / self.distance, y / self.distance]
    }

    /// Width and height of a pixel of a picture of so many, in units of the distance.
    pub(crate) fn steps(&self, size: [u32; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.size[axis] / f64::from(size[axis]) / self.distance)
    }
}

/// How far points move from one eye to another: `scale_px (at_infinity - distance / Z)` pixels. Through one screen that
/// is `e_px (1 - d/Z)`, between parallel cameras `f_px (0 - e/Z)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parallax {
    pub(crate) scale_px: f32,
    /// 1, or 0 for parallel cameras.
    pub(crate) at_infinity: f32,
    /// World units.
    pub(crate) distance: f32,
}

impl Parallax {
    /// Of a point at depth `z`.
    pub(crate) fn px(self, z: f32) -> f32 {
        self.scale_px * (self.at_infinity - self.distance / z)
    }

    /// The same between eyes that are so many times as far apart, to the left if it is negative.
    pub(crate) fn times(self, apart: f32) -> Self {
        Self { scale_px: apart * self.scale_px, ..self }
    }

    /// How much parallax changes with `1/Z`, pixels times world units.
    pub(crate) fn reach(self) -> f64 {
        f64::from(self.scale_px) * f64::from(self.distance)
    }
}

impl Pose {
    /// What an interaxial makes of a depth.
    pub(crate) fn parallax(&self) -> Parallax {
        if self.screen_distance.is_finite() {
            return Parallax { scale_px: self.interaxial_px, at_infinity: 1.0, distance: self.screen_distance };
        }
        Parallax { scale_px: self.focal_px()[0] as f32, at_infinity: 0.0, distance: self.interaxial }
    }

    /// How far points about the camera's subject move from eye to eye, in pixels: `e_px`, or for parallel cameras the
    /// disparity at the subject's distance. What rules of thumb go by.
    pub(crate) fn typical_parallax_px(&self) -> f32 {
        if self.screen_distance.is_finite() { self.interaxial_px } else { -self.parallax().px(self.subject_distance) }
    }

    /// Parallax `x_r - x_l = e_px (1 - d/Z)` in pixels of a point at depth `z` (thesis, eq. 10, in pixels): `e_px` at
    /// infinity, 0 on the screen, `-e_px` at `d/2`. Between parallel cameras it is `-f_px e / Z`: 0 at infinity, and
    /// negative before it.
    ///
    /// Of eyes that are toed in it is that of points on the axis between them, at a depth along it, `e_px (1 - d/Z) /
    /// (1 + e²/(4 d Z))`; elsewhere [`Pose::project`] tells.
    pub fn parallax_px(&self, z: f32) -> f32 {
        self.parallax().px(z) / self.toe_in_divisor(z.into()) as f32
    }

    /// World position of an eye: -1 left, +1 right, 0 the midpoint.
    ///
    /// The pose of a picture has the eyes that were rendered. They are f32 positions relative to
    /// [`Scene::origin`](crate::Scene::origin), so that they may differ from `eye ± right e/2` in the last bit. All
    /// ground truth, matrices and calibrations are of these eyes.
    pub fn eye_position(&self, side: f32) -> DVec3 {
        match self.scene_origin {
            Some(origin) => origin + self.eye_in_scene(side).as_dvec3(),
            None => self.unrounded_eye(side),
        }
    }

    /// The same, relative to the scene's origin, as kernels get it.
    pub(crate) fn eye_in_scene(&self, side: f32) -> Vec3 {
        self.local(self.unrounded_eye(side)).as_vec3()
    }

    /// A world position relative to the scene's origin.
    pub(crate) fn local(&self, point: DVec3) -> DVec3 {
        point - self.scene_origin.unwrap_or_default()
    }

    fn unrounded_eye(&self, side: f32) -> DVec3 {
        self.eye + self.right.as_dvec3() * f64::from(0.5 * side * self.interaxial)
    }

    /// What rounding adds to the way from the left eye to the right one: along `right`, `up` and `forward`, world
    /// units. 0 where no picture was rendered.
    pub(crate) fn baseline_rounding(&self) -> DVec3 {
        if self.scene_origin.is_none() {
            return DVec3::ZERO;
        }
        let [left, right] = [-1.0, 1.0].map(|side| self.eye_in_scene(side).as_dvec3());
        let rounding = right - left - self.right.as_dvec3() * f64::from(self.interaxial);
        DVec3::from_array([self.right, self.up, self.forward].map(|axis| rounding.dot(axis.as_dvec3())))
    }

    /// The distance between the eyes that were rendered, along `right`: the interaxial and what rounding adds to it.
    pub fn baseline(&self) -> f64 {
        f64::from(self.interaxial) + self.baseline_rounding().x
    }

    /// Where a point in world coordinates lands in an eye's picture: `[x, y, Z]`, x and y in pixels from the top left
    /// corner (pixel centres at halves), `Z` its depth along the eye's view direction.
    pub fn project(&self, point: impl Into<DVec3>, side: f32) -> [f32; 3] {
        self.project_from_eye(point.into() - self.eye_position(side), side).map(|value| value as f32)
    }

    /// The same of a vector from that eye.
    pub(super) fn project_from_eye(&self, to: DVec3, side: f32) -> [f64; 3] {
        let (forward, right) = self.axes(side);
        let Frustum { distance, size: [width, height], .. } = self.frustum;
        let z = to.dot(forward);
        let across = to.dot(right) * distance / z - self.frustum.left(0.5 * f64::from(side));
        let down = self.frustum.top() - to.dot(self.up.as_dvec3()) * distance / z;
        [across / width * f64::from(self.size[0]), down / height * f64::from(self.size[1]), z]
    }

    /// From an eye at an offset from the midpoint, in interaxials, through the picture's top left corner, of length 1
    /// along the view axis. Of eyes that are not turned.
    pub(crate) fn corner(&self, offset: f64) -> DVec3 {
        let [forward, right, up] = [self.forward, self.right, self.up].map(Vec3::as_dvec3);
        let distance = self.frustum.distance;
        forward + right * (self.frustum.left(offset) / distance) + up * (self.frustum.top() / distance)
    }

    /// What such a direction changes by from a pixel to its right neighbour, and to the one below.
    pub(crate) fn pixel_steps(&self) -> [DVec3; 2] {
        let [x, y] = self.frustum.steps(self.size);
        [self.right.as_dvec3() * x, self.up.as_dvec3() * -y]
    }

    /// The camera's numbers as a calibration has them, of a picture of this size with pixel centres at halves.
    pub fn intrinsics(&self) -> Intrinsics {
        let [[cx0, cy], [cx1, _]] = [-1.0, 1.0].map(|side| self.principal_px(side));
        Intrinsics { cx1, ..Intrinsics::new(self.focal_px(), [cx0, cy]) }
    }

    /// Focal lengths along x and y, pixels: what a point moves by that moves aside by its depth. Through a screen `d w
    /// / W`.
    pub fn focal_px(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.frustum.distance * f64::from(self.size[axis]) / self.frustum.size[axis])
    }

    /// The principal point of an eye, -1 left, +1 right, 0 the midpoint: where its axis meets the picture, in pixels
    /// from the top left corner, pixel centres at halves. It may lie outside of the picture.
    pub fn principal_px(&self, side: f32) -> [f64; 2] {
        let Frustum { size: [width, height], .. } = self.frustum;
        let [w, h] = self.size.map(f64::from);
        [-self.frustum.left(0.5 * f64::from(side)) / width * w, self.frustum.top() / height * h]
    }

    /// Depths of the nearest and the farthest corner of a box (low and high corner), along the view direction: those of
    /// what [`Scene::bounds`](crate::Scene::bounds) holds. Below 0 behind the eyes.
    pub fn depth_range_of(&self, (low, high): (DVec3, DVec3)) -> (f32, f32) {
        let forward = self.forward.as_dvec3();
        let [a, b] = [low, high].map(|corner| (corner - self.eye) * forward);
        (a.min(b).element_sum() as f32, a.max(b).element_sum() as f32)
    }

    /// The same camera with eyes so many times as far apart, before the same screen.
    pub(crate) fn apart(self, times: f32) -> Self {
        Self {
            interaxial: times * self.interaxial,
            interaxial_px: times * self.interaxial_px,
            frustum: Frustum { shift: f64::from(times) * self.frustum.shift, ..self.frustum },
            ..self
        }
    }
}
