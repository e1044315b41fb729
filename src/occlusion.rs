//! Which points of one view the other eye sees, by a ray to each: ground truth for stereo vision.

use glam::DVec3;

use crate::{Convergence, Error, Occlusion, Pose, Ray, Renderer, StereoPair, UploadedScene, View};

/// A ray to a point that hits something with no more disparity than this besides, in pixels, has met that point: more
/// than what depths, and directions to them, round by on surfaces that are seen edge-on. What is told so wrongly is a
/// strip beside an edge that is no wider.
const SAME_POINT_PX: f64 = 1.0 / 512.0;

/// Whether the other eye sees what each pixel shows, of both views. Row-major, `[height][width]`, top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Occlusions {
    /// Whether the right eye sees what each left pixel shows.
    pub left: Vec<Occlusion>,
    /// Whether the left eye sees what each right pixel shows.
    pub right: Vec<Occlusion>,
}

impl Renderer {
    /// Whether the other eye sees the very point that each pixel's centre shows: by a ray from that eye to it, in place
    /// of what [`StereoPair::occlusion`] tells from depths. Sky is seen where nothing stands before it. A pixel
    /// whose point leaves the other picture ([`StereoPair::disparity`]) is out of frame, seen or not.
    ///
    /// `pair` is a picture of `scene` with depths ([`GBuffer::Ids`](crate::GBuffer), the default, has them), by
    /// whatever method. Of methods that take pixels over ([`Method::ATOMIC`](crate::Method::ATOMIC) and its like)
    /// right depths are those of points up to half a pixel aside.
    ///
    /// # Errors
    /// [`Error::Options`] for a pair without depths, [`Error::Rig`] for one whose eyes are toed in, and those of
    /// [`Renderer::closest_hits_async`].
    pub async fn occlusions_async(&self, scene: &UploadedScene, pair: &StereoPair) -> Result<Occlusions, Error> {
        if pair.pose.convergence == Convergence::ToeIn {
            let reason = "its eyes are toed in: where points leave the other picture goes by rows, which are no epipolar lines there";
            return Err(Error::Rig { reason: reason.into() });
        }
        let left = self.occlusion_of(scene, &pair.left, &pair.pose, -0.5).await?;
        Ok(Occlusions { left, right: self.occlusion_of(scene, &pair.right, &pair.pose, 0.5).await? })
    }

    /// Of the view whose eye stands so much of the interaxial to the right of the middle.
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
        let rays = view.depth.iter().enumerate().map(|(index, &z)| pixels.ray(index % width, index / width, z));
        let rays: Vec<Ray> = rays.collect();
        let hits = self.closest_hits_async(scene, &rays).await?.hits;
        let disparity = pose.disparities_of_eye(2.0 * side);
        let found = hits.iter().enumerate().map(|(index, hit)| {
            let (column, z) = (index % width, view.depth[index]);
            // To the other side of its own column by its disparity.
            let x = column as f64 + 0.5 + 2.0 * side * disparity(column, z);
            if !(x >= 0.0 && x < width as f64) {
                return Occlusion::OutOfFrame;
            }
            let is_seen = pose.disparity_px(hit.t) <= pose.disparity_px(z) + SAME_POINT_PX;
            if is_seen { Occlusion::Visible } else { Occlusion::Hidden }
        });
        Ok(found.collect())
    }
}

/// Where an eye's pixels look, and the other eye.
pub(crate) struct Pixels {
    /// World coordinates.
    other_eye: DVec3,
    /// From the other eye to this one.
    aside: DVec3,
    /// Directions whose length along the view axis is 1: through the picture's top left corner, and from a pixel to
    /// its right and lower neighbours.
    corner: DVec3,
    right: DVec3,
    down: DVec3,
}

impl Pixels {
    /// Of the view whose eye stands so much of the interaxial to the right of the middle.
    pub(crate) fn of(pose: &Pose, side: f64) -> Self {
        let [other, own] = [-2.0, 2.0].map(|times| pose.eye_position((times * side) as f32));
        let [right, down] = pose.pixel_steps();
        Self { other_eye: other, aside: own - other, corner: pose.corner(side), right, down }
    }

    /// Its eye, world coordinates.
    pub(crate) fn eye(&self) -> DVec3 {
        self.other_eye + self.aside
    }

    /// Through a pixel's centre, of length 1 along the view axis: so a depth is its t.
    pub(crate) fn direction(&self, column: usize, row: usize) -> DVec3 {
        self.corner + self.right * (column as f64 + 0.5) + self.down * (row as f64 + 0.5)
    }

    /// From the other eye to what a pixel shows at this depth, which is its t.
    fn ray(&self, column: usize, row: usize, z: f32) -> Ray {
        let direction = self.direction(column, row);
        // A point in the plane of the eyes has no direction of this length; it is out of frame.
        let aside = if z > 0.0 { self.aside / f64::from(z) } else { DVec3::ZERO };
        Ray::new(self.other_eye, (direction + aside).as_vec3())
    }
}
