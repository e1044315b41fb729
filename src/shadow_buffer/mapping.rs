//! The directions of a shadow-buffer's texels. `src/testing/cpu/shadow_buffer.rs` compares them with the paper's
//! formulas.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

/// Number of texels kept on each side around a scene's directions.
const BORDER: f64 = 2.0;
/// Minimum number of rows for a table that is fitted to the scene. A smaller table covers all directions.
const LEAST_ROWS: u32 = 16;
/// Maximum angle between the middle and the edge of a scene, in radians. A wider scene has a table of all directions.
const WIDEST: f64 = 80.0 * PI / 180.0;

/// Directions of the texels in a light's shadow-buffer. Texel (r, c) extends from r to r + 1 in rows and from c to c +
/// 1 in columns. Its direction is the direction of its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Mapping {
    /// Unit vectors of the angles: phi = 0, phi = pi/2, and the pole at theta = 0.
    pub axes: [Vec3; 3],
    /// Theta at the begin of the first row, and the angle of a row, in radians.
    pub theta: [f32; 2],
    /// Phi at the begin of the first column, and the angle of a column, in radians.
    pub phi: [f32; 2],
    /// Number of rows that are filled.
    pub rows: u32,
    /// Number of columns that are filled.
    pub columns: u32,
}

impl Mapping {
    /// Creates a table of all directions around the world's z axis, as in the paper, with twice as many columns as
    /// rows.
    pub fn whole(rows: u32) -> Self {
        let step = (PI / f64::from(rows)) as f32;
        Self { axes: [Vec3::X, Vec3::Y, Vec3::Z], theta: [0.0, step], phi: [0.0, step], rows, columns: 2 * rows }
    }

    /// Creates a table of the directions from the light to a box that does not contain the light. The table has at most
    /// `rows` rows and twice as many columns. It is finer than [`Mapping::whole`], which is returned if the box
    /// surrounds the light, or nearly does.
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

    /// Creates a table with the box's middle on the equator, so that texels are nearly square. A pole is as near to
    /// `up` as possible.
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
            // The largest extent of the box to the side and upwards, seen from the light: y / x and z / x are largest
            // in a corner.
            phi = phi.max(y.abs().atan2(x));
            theta = theta.max(z.abs().atan2(x));
        }
        if phi.max(theta) > WIDEST {
            return None;
        }
        let texels = |count: u32| f64::from(count) - 2.0 * BORDER;
        // A step below 1e-6 radians is too small for f32.
        let step = (2.0 * theta / texels(rows)).max(2.0 * phi / texels(2 * rows)).max(1e-6) as f32;
        let count = |half: f64, most: u32| ((2.0 * half / f64::from(step) + 2.0 * BORDER).ceil() as u32).min(most);
        let (rows, columns) = (count(theta, rows), count(phi, 2 * rows));
        let begin = |middle: f64, count: u32| (middle - 0.5 * f64::from(count) * f64::from(step)) as f32;
        Some(Self { axes, theta: [begin(0.5 * PI, rows), step], phi: [begin(0.0, columns), step], rows, columns })
    }
}
