//! View rectangles of a pose's eyes, and the parallax between them (DESIGN, section 2).

use glam::{DVec3, Vec3};

use super::{Equirectangular, Intrinsics, Lens, Pose, circle::Circle};
use crate::Error;

/// The picture's rectangle on a plane in front of the eyes. This plane is the screen if the camera was specified by its
/// screen; otherwise it is at depth 1. The values are f64, and are rounded once for kernels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frustum {
    /// Distance from the plane of the eyes to that plane.
    pub(crate) distance: f64,
    /// Width and height of the rectangle on that plane.
    pub(crate) size: [f64; 2],
    /// Centre of the rectangle, to the right of and above the axis of the midpoint between the eyes.
    pub(crate) center: [f64; 2],
    /// Shift of the rectangle to the left, relative to an eye's own axis, for an eye one interaxial to the right. It
    /// equals the interaxial on the screen, which all eyes share, and is 0 for parallel cameras.
    pub(crate) shift: f64,
}

/// The directions that a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Field {
    /// Rays through a rectangle.
    Screen(Frustum),
    /// Azimuths and elevations around a viewing circle.
    Sphere(Sphere),
    /// Rays through the lenses of the left and the right eye, which are parallel.
    Lenses([Lens; 2]),
}

/// The directions that an equirectangular picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sphere {
    pub(crate) projection: Equirectangular,
    /// Ranges of azimuths and elevations in radians. Their middle lies straight ahead on the horizon.
    pub(crate) angles: [f64; 2],
}

/// Projects points in world coordinates into the picture of an eye, like [`Pose::project`], in f64.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Projector {
    Screen {
        eye: DVec3,
        /// Columns per unit of the tangent to the right, along the right axis.
        right: DVec3,
        /// Rows per unit of the tangent downwards, along the down axis.
        down: DVec3,
        forward: DVec3,
        principal: [f64; 2],
    },
    Around {
        circle: Circle,
        center: DVec3,
        /// Right, up and forward.
        axes: [DVec3; 3],
        side: f64,
    },
    Lens {
        eye: DVec3,
        /// Right, down and forward.
        axes: [DVec3; 3],
        lens: Lens,
    },
}

impl Projector {
    /// Returns the column, the row and the depth of a point. A lens that does not show the point's direction gives a
    /// column and a row of NaN.
    pub(crate) fn project(&self, point: DVec3) -> [f64; 3] {
        match self {
            Self::Screen { eye, .. } => self.project_offset(point - eye),
            Self::Around { circle, center, axes, side } => {
                let from_center = point - center;
                circle.project(DVec3::from_array(axes.map(|axis| axis.dot(from_center))), *side)
            }
            Self::Lens { eye, axes, lens } => {
                let [x, y, z] = axes.map(|axis| axis.dot(point - eye));
                let place = if z > 0.0 { lens.pixel_of([x / z, y / z]) } else { None };
                let [column, row] = place.unwrap_or([f64::NAN; 2]);
                [column, row, z]
            }
        }
    }

    /// Returns the column and row of an infinitely distant point, given by its direction, or `None` if the eye looks
    /// away from it. A lens that does not show the direction gives NaN.
    pub(crate) fn project_direction(&self, direction: DVec3) -> Option<[f64; 2]> {
        match self {
            Self::Screen { .. } => {
                let [x, y, z] = self.project_offset(direction);
                (z > 0.0).then_some([x, y])
            }
            Self::Around { circle, axes, .. } => {
                Some(circle.project_direction(DVec3::from_array(axes.map(|axis| axis.dot(direction)))))
            }
            Self::Lens { axes, lens, .. } => {
                let [x, y, z] = axes.map(|axis| axis.dot(direction));
                (z > 0.0).then(|| lens.pixel_of([x / z, y / z]).unwrap_or([f64::NAN; 2]))
            }
        }
    }

    /// Projects a vector that begins at an eye into that eye's planar picture. Other pictures give NaN.
    pub(super) fn project_offset(&self, to: DVec3) -> [f64; 3] {
        let Self::Screen { right, down, forward, principal: [cx, cy], .. } = self else { return [f64::NAN; 3] };
        let z = to.dot(*forward);
        [cx + to.dot(*right) / z, cy + to.dot(*down) / z, z]
    }
}

impl Frustum {
    /// Returns the horizontal coordinate of the rectangle's left side, relative to the axis of an eye. The eye is
    /// `offset` interaxials to the right of the midpoint.
    fn left(&self, offset: f64) -> f64 {
        self.center[0] - 0.5 * self.size[0] - offset * self.shift
    }

    fn top(&self) -> f64 {
        self.center[1] + 0.5 * self.size[1]
    }

    /// Returns the largest horizontal and vertical coordinate in the rectangle, as tangents, for eyes up to `offset`
    /// interaxials to either side. Coordinates are relative to the eye's axis.
    pub(crate) fn aside(&self, offset: f64) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| 0.5 * self.size[axis] + self.center[axis].abs());
        [(x + offset * self.shift) / self.distance, y / self.distance]
    }

    /// Returns the focal lengths along x and y in pixels, for a picture of the given size.
    pub(crate) fn focal_px(&self, size: [u32; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.distance * f64::from(size[axis]) / self.size[axis])
    }

    /// Returns where the axis of an eye meets a picture of the given size, in pixels. The eye is `offset` interaxials
    /// to the right of the midpoint.
    pub(crate) fn principal_px(&self, size: [u32; 2], offset: f64) -> [f64; 2] {
        let ([width, height], [w, h]) = (self.size, size.map(f64::from));
        [-self.left(offset) / width * w, self.top() / height * h]
    }

    /// Returns the direction from an eye of a pose through the picture's top left corner, with length 1 along the view
    /// axis. The eye is `offset` interaxials to the right of the midpoint and is not toed in.
    pub(crate) fn corner(&self, pose: &Pose, offset: f64) -> DVec3 {
        pose.in_world(DVec3::new(self.left(offset) / self.distance, self.top() / self.distance, 1.0))
    }

    /// Returns how the direction through a pixel of a pose changes from one pixel to the next: to the right, and
    /// downwards.
    pub(crate) fn pixel_steps(&self, pose: &Pose) -> [DVec3; 2] {
        let [x, y] = self.steps(pose.size);
        [pose.right.as_dvec3() * x, pose.up.as_dvec3() * -y]
    }

    /// Returns the width and height of a pixel, as tangents, for a picture of the given size.
    pub(crate) fn steps(&self, size: [u32; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.size[axis] / f64::from(size[axis]) / self.distance)
    }
}

/// Parallax as a function of depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Parallax {
    Planar(PlanarParallax),
    /// `-2 atan(radius / s)` radians on the horizon of a viewing circle.
    Circle {
        px_per_radian: f32,
        radius: f32,
    },
}

impl Parallax {
    /// Returns the parallax in pixels at depth `z`.
    pub(crate) fn px(self, z: f32) -> f32 {
        match self {
            Self::Planar(parallax) => parallax.px(z),
            Self::Circle { px_per_radian, radius } => -2.0 * px_per_radian * (radius / z).atan(),
        }
    }

    /// Returns the parallax for an interaxial `apart` times as large. A negative factor means an eye to the left.
    pub(crate) fn times(self, apart: f32) -> Self {
        match self {
            Self::Planar(parallax) => Self::Planar(parallax.times(apart)),
            Self::Circle { px_per_radian, radius } => Self::Circle { px_per_radian, radius: apart * radius },
        }
    }

    /// Returns how much the parallax grows from depth `near` to depth `far`, in pixels.
    pub(crate) fn between(self, near: f32, far: f32) -> f64 {
        match self {
            Self::Planar(parallax) => parallax.reach() * (1.0 / f64::from(near) - 1.0 / f64::from(far)),
            Self::Circle { .. } => f64::from(self.px(far)) - f64::from(self.px(near)),
        }
    }
}

/// Parallax of planar pictures: `scale_px (at_infinity - distance / Z)` pixels. It is `e_px (1 - d/Z)` through one
/// screen, and `f_px (0 - e/Z)` between parallel cameras.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlanarParallax {
    pub(crate) scale_px: f32,
    /// Factor of the parallax at infinity: 1, or 0 for parallel cameras.
    pub(crate) at_infinity: f32,
    /// Distance of the screen, or the interaxial of parallel cameras, in world units.
    pub(crate) distance: f32,
}

impl PlanarParallax {
    /// Returns the parallax in pixels at depth `z`.
    pub(crate) fn px(self, z: f32) -> f32 {
        self.scale_px * (self.at_infinity - self.distance / z)
    }

    /// Returns the parallax for an interaxial `apart` times as large. A negative factor means an eye to the left.
    pub(crate) fn times(self, apart: f32) -> Self {
        Self { scale_px: apart * self.scale_px, ..self }
    }

    /// Returns the decrease of parallax per unit of `1/Z`, in pixels times world units.
    pub(crate) fn reach(self) -> f64 {
        f64::from(self.scale_px) * f64::from(self.distance)
    }
}

impl Pose {
    /// Returns the parallax between the two eyes.
    pub(crate) fn parallax(&self) -> Parallax {
        match self.field {
            Field::Screen(frustum) => Parallax::Planar(self.planar_parallax(&frustum)),
            Field::Sphere(sphere) => Parallax::Circle {
                px_per_radian: (f64::from(self.size[0]) / sphere.angles[0]) as f32,
                radius: 0.5 * self.interaxial,
            },
            Field::Lenses([left, _]) => Parallax::Planar(PlanarParallax {
                scale_px: left.fx as f32,
                at_infinity: 0.0,
                distance: self.interaxial,
            }),
        }
    }

    /// Returns the parallax between the two eyes of a planar pose.
    pub(crate) fn planar_parallax(&self, frustum: &Frustum) -> PlanarParallax {
        if self.screen_distance.is_finite() {
            return PlanarParallax { scale_px: self.interaxial_px, at_infinity: 1.0, distance: self.screen_distance };
        }
        let [fx, _] = frustum.focal_px(self.size);
        PlanarParallax { scale_px: fx as f32, at_infinity: 0.0, distance: self.interaxial }
    }

    /// Returns a typical parallax in pixels, for rules of thumb. It is `e_px`, or the disparity at the subject's
    /// distance for parallel cameras.
    pub(crate) fn typical_parallax_px(&self) -> f32 {
        if self.screen_distance.is_finite() { self.interaxial_px } else { -self.parallax().px(self.subject_distance) }
    }

    /// Returns the parallax `x_r - x_l = e_px (1 - d/Z)` in pixels of a point at depth `z` (thesis, eq. 10, in pixels).
    /// It is `e_px` at infinity, 0 on the screen and `-e_px` at `d/2`. Between parallel cameras it is `-f_px e / Z`: 0
    /// at infinity, negative nearer.
    ///
    /// For toed-in eyes it is the parallax of points on the axis between the eyes, at depth `z` along that axis:
    /// `e_px (1 - d/Z) / (1 + e²/(4 d Z))`. Elsewhere use [`Pose::project`]. For equirectangular pairs it is
    /// `-2 atan(e / (2 s)) w / a` on the horizon, with horizontal distances `s = z` and `w` columns for `a` radians.
    /// For eyes with lenses it is the parallax without distortion, by the left lens's focal length.
    pub fn parallax_px(&self, z: f32) -> f32 {
        self.parallax().px(z) / self.toe_in_divisor(z.into()) as f32
    }

    /// Returns an eye's position in world coordinates (-1 left, +1 right, 0 the midpoint).
    ///
    /// The pose of a rendered picture returns the rendered eyes. They are f32 positions relative to
    /// [`Scene::origin`](crate::Scene::origin), so they may differ from `eye ± right e/2` in the last bit. All ground
    /// truth, matrices and calibrations describe these eyes.
    pub fn eye_position(&self, side: f32) -> DVec3 {
        match self.scene_origin {
            Some(origin) => origin + self.eye_in_scene(side).as_dvec3(),
            None => self.unrounded_eye(side),
        }
    }

    /// Returns an eye's position relative to the scene's origin, as kernels get it.
    pub(crate) fn eye_in_scene(&self, side: f32) -> Vec3 {
        self.local(self.unrounded_eye(side)).as_vec3()
    }

    /// Converts a world position to one relative to the scene's origin.
    pub(crate) fn local(&self, point: DVec3) -> DVec3 {
        point - self.scene_origin.unwrap_or_default()
    }

    fn unrounded_eye(&self, side: f32) -> DVec3 {
        self.eye + self.right.as_dvec3() * f64::from(0.5 * side * self.interaxial)
    }

    /// Returns the rounding error of the vector from the left eye to the right one, along `right`, `up` and `forward`,
    /// in world units. It is 0 if no picture was rendered.
    pub(crate) fn baseline_rounding(&self) -> DVec3 {
        if self.scene_origin.is_none() {
            return DVec3::ZERO;
        }
        let [left, right] = [-1.0, 1.0].map(|side| self.eye_in_scene(side).as_dvec3());
        let rounding = right - left - self.right.as_dvec3() * f64::from(self.interaxial);
        DVec3::from_array([self.right, self.up, self.forward].map(|axis| rounding.dot(axis.as_dvec3())))
    }

    /// Returns the distance between the rendered eyes along `right`: the interaxial plus its rounding error, in world
    /// units.
    pub fn baseline(&self) -> f64 {
        f64::from(self.interaxial) + self.baseline_rounding().x
    }

    /// Projects a point in world coordinates into an eye's picture (-1 left, +1 right, 0 the midpoint). Returns
    /// `[x, y, Z]`. x and y are pixels from the top left corner, with pixel centres at halves. `Z` is the depth along
    /// the eye's view direction. In equirectangular pictures it is the horizontal distance along the eye's ray, and NaN
    /// for points within the viewing circle. x and y are NaN for points that an eye's lens does not show.
    pub fn project(&self, point: impl Into<DVec3>, side: f32) -> [f32; 3] {
        self.projector(side).project(point.into()).map(|value| value as f32)
    }

    /// Prepares the projection of many points into an eye's picture.
    pub(crate) fn projector(&self, side: f32) -> Projector {
        match self.field {
            Field::Screen(frustum) => {
                let (forward, right) = self.axes(side);
                let [fx, fy] = frustum.focal_px(self.size);
                let [cx, cy] = frustum.principal_px(self.size, 0.5 * f64::from(side));
                let [right, down] = [right * fx, self.up.as_dvec3() * -fy];
                Projector::Screen { eye: self.eye_position(side), right, down, forward, principal: [cx, cy] }
            }
            Field::Sphere(sphere) => Projector::Around {
                circle: Circle::of(self, &sphere),
                center: self.eye_position(0.0),
                axes: [self.right, self.up, self.forward].map(Vec3::as_dvec3),
                side: side.into(),
            },
            Field::Lenses([left, right]) => Projector::Lens {
                eye: self.eye_position(side),
                axes: [self.right, -self.up, self.forward].map(Vec3::as_dvec3),
                lens: if side > 0.0 { right } else { left },
            },
        }
    }

    /// Returns the camera's intrinsics, for a picture of this size with pixel centres at halves. Equirectangular
    /// pictures have none, and neither have cameras with lenses ([`Pose::lens`]).
    pub fn intrinsics(&self) -> Option<Intrinsics> {
        let [[cx0, cy], [cx1, _]] = [self.principal_px(-1.0)?, self.principal_px(1.0)?];
        Some(Intrinsics { cx1, ..Intrinsics::new(self.focal_px()?, [cx0, cy]) })
    }

    /// Returns the intrinsics, or an error for pictures that have none.
    pub(crate) fn planar_intrinsics(&self) -> Result<Intrinsics, Error> {
        self.intrinsics().ok_or_else(|| {
            let (value, reason) = match self.field {
                Field::Lenses(_) => {
                    ("by lenses with distortion", "such pictures are not rectified; use the rectified camera")
                }
                Field::Screen(_) | Field::Sphere(_) => {
                    ("equirectangular", "such pictures have no intrinsics; use planar ones")
                }
            };
            Error::Camera { field: "projection", value: value.into(), reason }
        })
    }

    /// Returns the focal lengths along x and y in pixels: `d w / W` through a screen. Equirectangular pictures have
    /// none.
    pub fn focal_px(&self) -> Option<[f64; 2]> {
        self.frustum().map(|frustum| frustum.focal_px(self.size))
    }

    /// Returns the principal point of an eye (-1 left, +1 right, 0 the midpoint), where its axis meets the picture. It
    /// is in pixels from the top left corner, with pixel centres at halves, and may lie outside the picture.
    /// Equirectangular pictures have none.
    pub fn principal_px(&self, side: f32) -> Option<[f64; 2]> {
        self.frustum().map(|frustum| frustum.principal_px(self.size, 0.5 * f64::from(side)))
    }

    /// Returns the rectangle of a planar pose.
    pub(crate) fn frustum(&self) -> Option<Frustum> {
        match self.field {
            Field::Screen(frustum) => Some(frustum),
            Field::Sphere(_) | Field::Lenses(_) => None,
        }
    }

    /// Returns the depths of the nearest and the farthest corner of a box along the view direction. The box is given by
    /// its low and high corner, as in [`Scene::bounds`](crate::Scene::bounds). Depths behind the eyes are negative.
    pub fn depth_range_of(&self, (low, high): (DVec3, DVec3)) -> (f32, f32) {
        let forward = self.forward.as_dvec3();
        let [a, b] = [low, high].map(|corner| (corner - self.eye) * forward);
        (a.min(b).element_sum() as f32, a.max(b).element_sum() as f32)
    }

    /// Returns the same camera with `times` its interaxial and the same screen.
    pub(crate) fn apart(self, times: f32) -> Self {
        Self {
            interaxial: times * self.interaxial,
            interaxial_px: times * self.interaxial_px,
            field: match self.field {
                Field::Screen(frustum) => Field::Screen(Frustum { shift: f64::from(times) * frustum.shift, ..frustum }),
                other @ (Field::Sphere(_) | Field::Lenses(_)) => other,
            },
            ..self
        }
    }
}
