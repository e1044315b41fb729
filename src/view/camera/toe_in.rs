//! Poses with toed-in eyes.

use glam::DVec3;

use super::{Field, Frustum, Pose, Projection};

impl Pose {
    /// Returns the angle in radians by which an eye (-1 left, +1 right) is turned to the right. It is 0 unless the eyes
    /// are toed in.
    pub(super) fn turn(&self, side: f32) -> f64 {
        match self.projection {
            Projection::OffAxis | Projection::Equirectangular(_) | Projection::Lenses(_) => 0.0,
            Projection::ToeIn => -(0.5 * f64::from(side * self.interaxial) / f64::from(self.screen_distance)).atan(),
        }
    }

    /// Returns an eye's view direction and right axis.
    pub(super) fn axes(&self, side: f32) -> (DVec3, DVec3) {
        let (sin, cos) = self.turn(side).sin_cos();
        let (forward, right) = (self.forward.as_dvec3(), self.right.as_dvec3());
        (forward * cos + right * sin, right * cos - forward * sin)
    }

    /// Returns `1 + e²/(4 d Z)`, the divisor of a screen's parallax for toed-in eyes, or 1 for other eyes. It follows
    /// from `2 f tan(atan(e / 2d) - atan(e / 2Z))`, the parallax of points on the axis between the eyes.
    pub(crate) fn toe_in_divisor(&self, z: f64) -> f64 {
        match self.projection {
            Projection::OffAxis | Projection::Equirectangular(_) | Projection::Lenses(_) => 1.0,
            Projection::ToeIn => {
                let half = 0.5 * f64::from(self.interaxial);
                1.0 + half / f64::from(self.screen_distance) * (half / z)
            }
        }
    }

    /// Returns the camera of one eye alone (-1 left, +1 right), with its own position, axes and principal point. An eye
    /// of an equirectangular pair has no single position; its pose is returned as it is.
    pub fn of_eye(&self, side: f32) -> Self {
        if let Some(lens) = self.lens(side) {
            let (projection, field) = (Projection::Lenses([lens; 2]), Field::Lenses([lens; 2]));
            return Self { eye: self.eye_position(side), interaxial: 0.0, projection, field, ..*self };
        }
        let Field::Screen(frustum) = self.field else { return *self };
        let (forward, right) = self.axes(side);
        let [x, y] = frustum.center;
        let center = [x - 0.5 * f64::from(side) * frustum.shift, y];
        Self {
            eye: self.eye_position(side),
            forward: forward.as_vec3(),
            right: right.as_vec3(),
            interaxial: 0.0,
            interaxial_px: 0.0,
            projection: Projection::OffAxis,
            field: Field::Screen(Frustum { center, shift: 0.0, ..frustum }),
            ..*self
        }
    }

    /// Returns the largest vertical parallax in pixels, over points in the corners of either picture at depths
    /// `nearest` and `farthest`. It is 0 unless the eyes are toed in.
    pub(super) fn vertical_parallax_px(&self, nearest: f32, farthest: f32) -> f32 {
        let (Projection::ToeIn, Field::Screen(_)) = (self.projection, self.field) else { return 0.0 };
        let [w, h] = self.size.map(f64::from);
        let mut most = 0.0_f64;
        for side in [-1.0, 1.0] {
            let own = self.of_eye(side);
            let Some(rectangle) = own.frustum() else { continue };
            let (corner, [across, down]) = (rectangle.corner(&own, 0.0), rectangle.pixel_steps(&own));
            let apart = self.eye_position(side) - self.eye_position(-side);
            for (x, y) in [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h)] {
                let direction = corner + across * x + down * y;
                for z in [nearest, farthest] {
                    // At infinite z the offset between the eyes vanishes.
                    let to = direction + apart / f64::from(z);
                    let [_, row, depth] = self.projector(-side).project_offset(to);
                    // Points beside or behind the other eye are not in its picture.
                    if depth > 0.0 {
                        most = most.max((row - y).abs());
                    }
                }
            }
        }
        most as f32
    }
}
