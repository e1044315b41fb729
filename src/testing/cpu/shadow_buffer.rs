//! Twin of `shaders/shared/shadow_canvas.wgsl`: maps texels of a shadow-buffer to directions and back, and fills them.
//!
//! The paper's theta (Raghuvanshi & Dhande, equation 4) runs from 0 to pi with `(cos theta cos phi, cos theta sin phi,
//! sin theta)`. This covers half of the sphere twice. Its inverse (equation 7) has an arcsin, which begins at -pi/2,
//! and an arccos, which loses the sign of phi. Here theta is the angle from a pole, with direction `(sin theta cos phi,
//! sin theta sin phi, cos theta)`. Both angles are arctangents of two arguments.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use super::intersect::closest_hit;
use crate::Scene;
pub use crate::shadow_buffer::mapping::Mapping;

impl Mapping {
    /// Returns whether the mapping covers all directions. Then rows continue beyond the poles and columns wrap around.
    pub fn is_whole(&self) -> bool {
        self.theta[0] == 0.0
    }

    /// Returns the unit direction of a place. A texel's middle is at `(r + 0.5, c + 0.5)`.
    pub fn direction(&self, row: f64, column: f64) -> DVec3 {
        let angle = |[begin, step]: [f32; 2], at: f64| f64::from(begin) + at * f64::from(step);
        let (theta, phi) = (angle(self.theta, row), angle(self.phi, column));
        let [x, y, z] = self.axes.map(Vec3::as_dvec3);
        x * (theta.sin() * phi.cos()) + y * (theta.sin() * phi.sin()) + z * theta.cos()
    }

    /// Returns the row and column of a direction of any length. There is no texel outside `0..rows` and `0..columns`.
    pub fn place(&self, direction: DVec3) -> [f64; 2] {
        let [x, y, z] = self.axes.map(|axis| axis.as_dvec3().dot(direction));
        let theta = x.hypot(y).atan2(z);
        let phi = if self.is_whole() { y.atan2(x).rem_euclid(TAU) } else { y.atan2(x) };
        [(theta, self.theta), (phi, self.phi)]
            .map(|(angle, [begin, step])| (angle - f64::from(begin)) / f64::from(step))
    }
}

/// Returns the contents of a light's table, row by row: t and id of the nearest hit along each texel's direction, or
/// `(FAR, MISS)`.
pub fn fill(scene: &Scene, light: Vec3, mapping: &Mapping) -> Vec<(f32, u32)> {
    let texels = (0..mapping.rows).flat_map(|row| (0..mapping.columns).map(move |column| (row, column)));
    let filled = texels.map(|(row, column)| {
        let direction = mapping.direction(f64::from(row) + 0.5, f64::from(column) + 0.5);
        closest_hit(scene, light, direction.as_vec3(), 0.0, crate::FAR)
    });
    filled.collect()
}
