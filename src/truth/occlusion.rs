//! Ground truth visibility: traces a ray from the other eye to each point of a view.

use glam::{DVec3, Vec3};

use crate::{
    Error, Lens, MISS, Occlusion, Pose, Projection, Ray, RayHit, Renderer, StereoPair, UploadedScene, View,
    view::camera::{Circle, CircleRay, Field},
};

/// A ray has hit the point itself if the hit's disparity exceeds the point's disparity by at most this many pixels. The
/// value exceeds the rounding of depths and directions, even on surfaces seen edge-on. Wrong answers are limited to a
/// strip of this width along edges.
pub(super) const SAME_POINT_PX: f64 = 1.0 / 512.0;
/// Rays to points are lengthened by this share, which exceeds the rounding of t.
const ROUNDING: f64 = 1.0 / 1_048_576.0;

/// Whether the other eye sees the point of each pixel, for both views. The lists are row-major, `[height][width]`, top
/// row first.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Occlusions {
    /// Whether the right eye sees the point of each left pixel.
    pub left: Vec<Occlusion>,
    /// Whether the left eye sees the point of each right pixel.
    pub right: Vec<Occlusion>,
}

impl Renderer {
    /// Returns the nearest hits of rays that have hits within their limits, and misses for the others. It is faster
    /// than [`Renderer::closest_hits`] if most rays have no hit.
    pub(super) async fn nearer_hits(&self, scene: &UploadedScene, rays: &[Ray]) -> Result<Vec<RayHit>, Error> {
        let is_blocked = self.any_hits(scene, rays).await?.hits;
        let blocked = rays.iter().zip(&is_blocked).filter(|(_, is_blocked)| **is_blocked);
        let blocked = Vec::from_iter(blocked.map(|(ray, _)| *ray));
        let mut nearest = self.closest_hits(scene, &blocked).await?.hits.into_iter();
        let none = RayHit { t: f32::INFINITY, primitive: MISS };
        let hit = |is_blocked| if is_blocked { nearest.next().unwrap_or(none) } else { none };
        Ok(is_blocked.into_iter().map(hit).collect())
    }

    /// Returns whether the other eye sees the point at each pixel's centre, by tracing a ray from that eye to it.
    /// [`StereoPair::occlusion`] estimates the same from depths. Sky is visible unless something is in front of it. A
    /// pixel whose point lies outside the other picture ([`StereoPair::disparity`]) is out of frame, even if nothing
    /// hides the point. With lenses, [`Renderer::correspondence`] says where points lie.
    ///
    /// `pair` is a picture of `scene` with depths (the default [`GBuffer::Ids`](crate::GBuffer) has them), by any
    /// method. With methods that copy pixels ([`Method::ATOMIC`](crate::Method::ATOMIC) and similar), right depths
    /// belong to points up to half a pixel from the centre.
    ///
    /// # Errors
    /// [`Error::Options`] for a pair without depths, [`Error::Rig`] for toed-in eyes, and the errors of
    /// [`Renderer::closest_hits`].
    pub async fn occlusions(&self, scene: &UploadedScene, pair: &StereoPair) -> Result<Occlusions, Error> {
        if let Projection::Lenses(_) = pair.pose.projection {
            let [left, right] = self.matched_occlusions(scene, pair).await?;
            return Ok(Occlusions { left, right });
        }
        if pair.pose.projection == Projection::ToeIn {
            let reason = "its eyes are toed in, so rows are not epipolar lines, which occlusion needs";
            return Err(Error::Rig { reason: reason.into() });
        }
        let left = self.occlusion_of(scene, &pair.left, &pair.pose, -0.5).await?;
        Ok(Occlusions { left, right: self.occlusion_of(scene, &pair.right, &pair.pose, 0.5).await? })
    }

    /// Returns the occlusion of the view whose eye is `side` interaxials to the right of the midpoint.
    async fn occlusion_of(
        &self,
        scene: &UploadedScene,
        view: &View,
        pose: &Pose,
        side: f64,
    ) -> Result<Vec<Occlusion>, Error> {
        if view.depth.len() != view.rgba8.len() {
            let reason = "occlusion needs depths; these pictures have none".into();
            return Err(Error::Options { option: "g_buffer", reason });
        }
        let pixels = Pixels::of(pose, side);
        let width = view.width as usize;
        let (disparity, nominal) = (pose.disparities_of_eye(2.0 * side), pose.disparities_of_rows());
        let ray = |(index, &z): (usize, &f32)| {
            let (column, row) = (index % width, index / width);
            // Disparities above that of sky are proportional to 1/z in planar pictures, and grow less than 1/z around.
            let above_sky = nominal(row, z) - nominal(row, f32::INFINITY);
            let nearer = f64::from(z) * (above_sky / (above_sky + SAME_POINT_PX)) * (1.0 + ROUNDING);
            let t_max = if z.is_finite() && above_sky.is_finite() { nearer as f32 } else { f32::INFINITY };
            pixels.ray_of_other(column, row, z).t_max(t_max)
        };
        let rays: Vec<Ray> = view.depth.iter().enumerate().map(ray).collect();
        let hits = self.nearer_hits(scene, &rays).await?;
        let found = hits.iter().enumerate().map(|(index, hit)| {
            let (pixel, z) = ([index % width, index / width], view.depth[index]);
            // The point's column in the other view.
            let x = pose.in_turn(pixel[0] as f64 + 0.5 + 2.0 * side * disparity(pixel, z));
            if !(x >= 0.0 && x < width as f64) {
                return Occlusion::OutOfFrame;
            }
            let is_seen = nominal(pixel[1], hit.t) <= nominal(pixel[1], z) + SAME_POINT_PX;
            if is_seen { Occlusion::Visible } else { Occlusion::Hidden }
        });
        Ok(found.collect())
    }
}

/// Camera rays of one eye, and rays from the other eye to their hits.
#[expect(clippy::large_enum_variant, reason = "there is one value for a view")]
pub(crate) enum Pixels {
    Planar(PlanarPixels),
    Lens(LensPixels),
    Around {
        circle: Circle,
        pose: Pose,
        /// -1 for the left eye, 1 for the right one.
        side: f64,
    },
}

/// Camera rays of a planar eye, and the position of the other eye.
pub(crate) struct PlanarPixels {
    /// Position of the other eye in world coordinates.
    other_eye: DVec3,
    /// Vector from the other eye to this one, in world units.
    aside: DVec3,
    /// Direction through the picture's top left corner, of length 1 along the view axis.
    corner: DVec3,
    /// Change of the direction from a pixel to its right neighbour.
    right: DVec3,
    /// Change of the direction from a pixel to the pixel below.
    down: DVec3,
}

/// Camera rays of an eye with a lens, and the position of the other eye.
pub(crate) struct LensPixels {
    eye: DVec3,
    other_eye: DVec3,
    /// Right, down and forward.
    axes: [DVec3; 3],
    lens: Lens,
}

impl LensPixels {
    fn of(pose: &Pose, side: f64, [left, right]: [Lens; 2]) -> Self {
        let [other_eye, eye] = [-2.0, 2.0].map(|times| pose.eye_position((times * side) as f32));
        let axes = [pose.right, -pose.up, pose.forward].map(Vec3::as_dvec3);
        Self { eye, other_eye, axes, lens: if side > 0.0 { right } else { left } }
    }

    /// Returns the direction through a point of the picture, of length 1 along the view axis.
    fn direction(&self, place: [f64; 2]) -> DVec3 {
        let ([x, y], [right, down, forward]) = (self.lens.tangents_within(place), self.axes);
        right * x + down * y + forward
    }
}

impl Pixels {
    /// Creates the rays of the view whose eye is `side` interaxials to the right of the midpoint.
    pub(crate) fn of(pose: &Pose, side: f64) -> Self {
        let frustum = match pose.field {
            Field::Screen(frustum) => frustum,
            Field::Sphere(sphere) => {
                return Self::Around { circle: Circle::of(pose, &sphere), pose: *pose, side: 2.0 * side };
            }
            Field::Lenses(lenses) => return Self::Lens(LensPixels::of(pose, side, lenses)),
        };
        let [other, own] = [-2.0, 2.0].map(|times| pose.eye_position((times * side) as f32));
        let [right, down] = frustum.pixel_steps(pose);
        Self::Planar(PlanarPixels {
            other_eye: other,
            aside: own - other,
            corner: frustum.corner(pose, side),
            right,
            down,
        })
    }

    /// Returns the origin of the ray through a pixel's centre, and its direction, whose length makes t the depth.
    pub(crate) fn ray(&self, column: usize, row: usize) -> (DVec3, DVec3) {
        self.ray_through([column as f64 + 0.5, row as f64 + 0.5])
    }

    /// Returns the ray through a point of the picture like [`Pixels::ray`]. Columns and rows count from the top left
    /// corner, with pixel centres at halves.
    pub(crate) fn ray_through(&self, place: [f64; 2]) -> (DVec3, DVec3) {
        match self {
            Self::Planar(pixels) => (pixels.other_eye + pixels.aside, pixels.direction(place)),
            Self::Lens(pixels) => (pixels.eye, pixels.direction(place)),
            Self::Around { circle, pose, side } => in_world(pose, circle.ray(place, *side)),
        }
    }

    /// Returns the ray from the other eye to the point of a pixel at depth `z`, which is the ray's t.
    pub(super) fn ray_of_other(&self, column: usize, row: usize, z: f32) -> Ray {
        let (eye, direction) = match self {
            Self::Planar(pixels) => {
                // A point in the plane of the eyes has no direction of this length; it is out of frame.
                let aside = if z > 0.0 { pixels.aside / f64::from(z) } else { DVec3::ZERO };
                (pixels.other_eye, pixels.direction([column as f64 + 0.5, row as f64 + 0.5]) + aside)
            }
            Self::Lens(pixels) => {
                let aside = if z > 0.0 { (pixels.eye - pixels.other_eye) / f64::from(z) } else { DVec3::ZERO };
                (pixels.other_eye, pixels.direction([column as f64 + 0.5, row as f64 + 0.5]) + aside)
            }
            Self::Around { circle, pose, side } => {
                let row = row as f64 + 0.5;
                let shift = side * circle.disparity_px(z.into(), circle.elevation(row));
                in_world(pose, circle.ray([column as f64 + 0.5 + shift, row], -side))
            }
        };
        Ray::new(eye, direction.as_vec3())
    }
}

impl PlanarPixels {
    /// Returns the direction through a point of the picture, of length 1 along the view axis.
    fn direction(&self, [column, row]: [f64; 2]) -> DVec3 {
        self.corner + self.right * column + self.down * row
    }
}

/// Returns a ray's origin in world coordinates, and its direction.
fn in_world(pose: &Pose, ray: CircleRay) -> (DVec3, DVec3) {
    (pose.eye_position(0.0) + pose.in_world(ray.origin), pose.in_world(ray.direction))
}
