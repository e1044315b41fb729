//! Eyes that are turned towards each other.

use glam::DVec3;

use super::{Convergence, Frustum, Pose};

impl Pose {
    /// By how much an eye, -1 the left one, +1 the right one, is turned to the right, in radians: 0 unless eyes are
    /// toed in.
    pub(super) fn turn(&self, side: f32) -> f64 {
        match self.convergence {
            Convergence::OffAxis => 0.0,
            Convergence::ToeIn => -(0.5 * f64::from(side * self.interaxial) / f64::from(self.screen_distance)).atan(),
        }
    }

    /// View direction and right of an eye.
    pub(super) fn axes(&self, side: f32) -> (DVec3, DVec3) {
        let (sin, cos) = self.turn(side).sin_cos();
        let (forward, right) = (self.forward.as_dvec3(), self.right.as_dvec3());
        (forward * cos + right * sin, right * cos - forward * sin)
    }

    /// `1 + e²/(4 d Z)`, by which points on the axis between eyes that are toed in move less than through a screen:
    /// `2 f tan(atan(e / 2d) - atan(e / 2Z))` is their parallax. 1 for other eyes.
    pub(crate) fn toe_in_divisor(&self, z: f64) -> f64 {
        match self.convergence {
            Convergence::OffAxis => 1.0,
            Convergence::ToeIn => {
                let half = 0.5 * f64::from(self.interaxial);
                1.0 + half / f64::from(self.screen_distance) * (half / z)
            }
        }
    }

    /// An eye's own camera, -1 the left one, +1 the right one: one eye alone, at its place, with its own axes and
    /// principal point.
    pub fn of_eye(&self, side: f32) -> Self {
        let (forward, right) = self.axes(side);
        let [x, y] = self.frustum.center;
        Self {
            eye: self.eye_position(side),
            forward: forward.as_vec3(),
            right: right.as_vec3(),
            interaxial: 0.0,
            interaxial_px: 0.0,
            convergence: Convergence::OffAxis,
            frustum: Frustum {
                center: [x - 0.5 * f64::from(side) * self.frustum.shift, y],
                shift: 0.0,
                ..self.frustum
            },
            ..*self
        }
    }

    /// The largest distance in rows, in pixels, between the places that a point has in the two pictures: of points in
    /// the corners of either, at depths `nearest` and `farthest`. 0 unless eyes are toed in.
    pub(super) fn vertical_parallax_px(&self, nearest: f32, farthest: f32) -> f32 {
        if self.convergence == Convergence::OffAxis {
            return 0.0;
        }
        let [w, h] = self.size.map(f64::from);
        let mut most = 0.0_f64;
        for side in [-1.0, 1.0] {
            let own = self.of_eye(side);
            let (corner, [across, down]) = (own.corner(0.0), own.pixel_steps());
            let apart = self.eye_position(side) - self.eye_position(-side);
            for (x, y) in [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h)] {
                let direction = corner + across * x + down * y;
                for z in [nearest, farthest] {
                    // At infinity it does not matter where the eyes stand.
                    let to = direction + apart / f64::from(z);
                    let [_, row, depth] = self.project_from_eye(to, -side);
                    // What stands beside or behind the other eye is in no picture of its.
                    if depth > 0.0 {
                        most = most.max((row - y).abs());
                    }
                }
            }
        }
        most as f32
    }
}
