//! Twin of `shaders/shared/shadow_canvas.wgsl`: which direction a texel of a shadow-buffer has, which texel a direction
//! has, and what stands there.
//!
//! The paper (Raghuvanshi & Dhande, equation 4) has theta run from 0 to pi with `(cos theta cos phi, cos theta sin phi,
//! sin theta)`, which covers half of the sphere twice, and its inverse (equation 7) an arcsin, which runs from -pi/2,
//! and an arccos, which loses the sign of phi. Here theta is the angle from a pole, `(sin theta cos phi, sin theta sin
//! phi, cos theta)`, and both come back by arctangents of two arguments.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::intersect::closest_hit;
use crate::Scene;

/// Texels kept around the directions in which a scene lies, on each side.
const BORDER: f64 = 2.0;
/// Fewer rows than this are not worth fitting.
const LEAST_ROWS: u32 = 16;
/// A scene that is seen at more than this angle from the middle has a table of all directions, radians.
const WIDEST: f64 = 80.0 * PI / 180.0;

/// Where directions from a light stand in its shadow-buffer. Row r and column c are a texel's from r to r + 1 and c to
/// c + 1; its own direction is that of its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Mapping {
    /// Unit vectors from which the angles are counted: phi = 0, phi = pi/2, and the pole at theta = 0.
    pub axes: [Vec3; 3],
    /// Theta of the first row's begin, and a row's angle, radians.
    pub theta: [f32; 2],
    /// Phi of the first column's begin, and a column's angle, radians.
    pub phi: [f32; 2],
    /// Rows that are filled.
    pub rows: u32,
    /// Columns that are filled.
    pub columns: u32,
}

impl Mapping {
    /// All directions, by so many rows and twice as many columns, around the world's z axis, the paper's.
    pub fn whole(rows: u32) -> Self {
        let step = (PI / f64::from(rows)) as f32;
        Self { axes: [Vec3::X, Vec3::Y, Vec3::Z], theta: [0.0, step], phi: [0.0, step], rows, columns: 2 * rows }
    }

    /// Those directions alone in which a box lies that the light stands outside of, by at most so many rows and twice
    /// as many columns: finer than [`Mapping::whole`]. All directions where the box surrounds the light, or nearly.
    pub fn around(light: Vec3, (low, high): (Vec3, Vec3), rows: u32) -> Self {
        let whole = Self::whole(rows);
        if rows < LEAST_ROWS {
            return whole;
        }
        let fitted =
            [Vec3::X, Vec3::Y, Vec3::Z].into_iter().filter_map(|up| Self::fitted(light, (low, high), up, rows));
        fitted
            .min_by(|a, b| a.theta[1].total_cmp(&b.theta[1]))
            .filter(|fitted| fitted.theta[1] < whole.theta[1])
            .unwrap_or(whole)
    }

    /// With the middle of the box on the equator, so that texels are nearly square, and a pole as near to `up` as that
    /// allows.
    fn fitted(light: Vec3, (low, high): (Vec3, Vec3), up: Vec3, rows: u32) -> Option<Self> {
        let light = light.as_dvec3();
        let ahead = ((low.as_dvec3() + high.as_dvec3()) * 0.5 - light).try_normalize()?;
        let y = up.as_dvec3().cross(ahead).try_normalize().filter(|_| up.as_dvec3().dot(ahead).abs() < 0.9)?;
        let axes = [ahead, y, ahead.cross(y)].map(DVec3::as_vec3);
        let corner = |index: u32| {
            let side = |axis: usize| if index >> axis & 1 == 0 { low[axis] } else { high[axis] };
            DVec3::new(side(0).into(), side(1).into(), side(2).into()) - light
        };
        let (mut theta, mut phi) = (0.0_f64, 0.0_f64);
        for corner in (0..8).map(corner) {
            let [x, y, z] = axes.map(|axis| axis.as_dvec3().dot(corner));
            // How far aside and up a box reaches at most as seen from the light: y / x and z / x are largest in a
            // corner.
            phi = phi.max(y.abs().atan2(x));
            theta = theta.max(z.abs().atan2(x));
        }
        if phi.max(theta) > WIDEST {
            return None;
        }
        let texels = |count: u32| f64::from(count) - 2.0 * BORDER;
        // No less than what f32 tells apart.
        let step = (2.0 * theta / texels(rows)).max(2.0 * phi / texels(2 * rows)).max(1e-6) as f32;
        let count = |half: f64, most: u32| ((2.0 * half / f64::from(step) + 2.0 * BORDER).ceil() as u32).min(most);
        let (rows, columns) = (count(theta, rows), count(phi, 2 * rows));
        let begin = |middle: f64, count: u32| (middle - 0.5 * f64::from(count) * f64::from(step)) as f32;
        Some(Self { axes, theta: [begin(0.5 * PI, rows), step], phi: [begin(0.0, columns), step], rows, columns })
    }

    /// Whether it has all directions, so that rows go on beyond the poles and columns beyond the last one.
    pub fn is_whole(&self) -> bool {
        self.theta[0] == 0.0
    }

    /// The unit direction of a place in it: of a texel's middle at `(r + 0.5, c + 0.5)`.
    pub fn direction(&self, row: f64, column: f64) -> DVec3 {
        let angle = |[begin, step]: [f32; 2], at: f64| f64::from(begin) + at * f64::from(step);
        let (theta, phi) = (angle(self.theta, row), angle(self.phi, column));
        let [x, y, z] = self.axes.map(Vec3::as_dvec3);
        x * (theta.sin() * phi.cos()) + y * (theta.sin() * phi.sin()) + z * theta.cos()
    }

    /// The place of a direction of any length: row and column. Outside of `0..rows` or `0..columns` it has no texel.
    pub fn place(&self, direction: DVec3) -> [f64; 2] {
        let [x, y, z] = self.axes.map(|axis| axis.as_dvec3().dot(direction));
        let theta = x.hypot(y).atan2(z);
        let phi = if self.is_whole() { y.atan2(x).rem_euclid(TAU) } else { y.atan2(x) };
        [(theta, self.theta), (phi, self.phi)]
            .map(|(angle, [begin, step])| (angle - f64::from(begin)) / f64::from(step))
    }
}

/// What a light's table holds, row by row: t and the primitive's id of the nearest hit along each texel's direction;
/// `(FAR, MISS)` where there is none.
pub fn fill(scene: &Scene, light: Vec3, mapping: &Mapping) -> Vec<(f32, u32)> {
    let texels = (0..mapping.rows).flat_map(|row| (0..mapping.columns).map(move |column| (row, column)));
    let filled = texels.map(|(row, column)| {
        let direction = mapping.direction(f64::from(row) + 0.5, f64::from(column) + 0.5);
        closest_hit(scene, light, direction.as_vec3(), 0.0, crate::FAR)
    });
    filled.collect()
}
