//! Correspondence of the two views for stereo vision: disparities, and points that only one eye sees.

use glam::DVec3;

use crate::{
    Pose, Projection, StereoPair, View,
    view::camera::{Circle, Field},
};

/// A right sample hides a left point if its disparity is larger by more than this, in pixels. Narrower gaps behind
/// occluders are not detected.
const NEARER_PX: f64 = 0.25;

/// Whether the right eye sees the point that a left pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u8)]
pub enum Occlusion {
    /// The right eye sees it.
    Visible = 0,
    /// A nearer surface hides it.
    Hidden = 1,
    /// It lies outside the right picture.
    OutOfFrame = 2,
}

impl Pose {
    /// Returns the disparity `x_l - x_r` in pixels of a point at depth `z`, in f64: the opposite of
    /// [`Pose::parallax_px`]. It is `e_px (d/Z - 1)`: positive in front of the screen, 0 on it, negative behind it,
    /// `-e_px` at infinity. For parallel cameras it is `f_px e / Z`, which is 0 at infinity and positive elsewhere. For
    /// toed-in eyes it applies to points on the axis between them ([`Pose::parallax_px`]). For equirectangular pairs it
    /// is `2 atan(e / (2 s)) w / a` on the horizon, with horizontal distances `s = z` and `w` columns for `a` radians.
    /// For eyes with lenses it is the disparity without distortion, by the left lens's focal length.
    ///
    /// Both eyes look through one screen rectangle, so these disparities equal `f B / Z - e_px`. The first term is the
    /// disparity of two parallel cameras with baseline `B = e` and focal length `f = d w / W` pixels.
    pub fn disparity_px(&self, z: f32) -> f64 {
        match self.field {
            Field::Screen(frustum) => {
                let parallax = self.planar_parallax(&frustum);
                // Coinciding eyes have no disparity, not even in their plane.
                if parallax.reach() == 0.0 {
                    return 0.0;
                }
                let disparity = f64::from(parallax.distance) / f64::from(z) - f64::from(parallax.at_infinity);
                f64::from(parallax.scale_px) * disparity / self.toe_in_divisor(z.into())
            }
            Field::Sphere(sphere) => Circle::of(self, &sphere).disparity_px(z.into(), 0.0),
            Field::Lenses([left, _]) => left.fx * f64::from(self.interaxial) / f64::from(z),
        }
    }
}

impl Pose {
    /// Returns the disparity in pixels of a point that an eye (-1 left, +1 right) shows, from its column and its depth
    /// `z`.
    ///
    /// It is [`Pose::disparity_px`] plus the effect of the rendered eyes' rounding. Let `(ρ, υ, φ)` be the rounding
    /// along right, up and forward. The point then moves by `f (ρ - T φ) / (Z ± φ)` pixels in the other eye's
    /// picture. T is the tangent of the point's horizontal angle from that eye's axis. υ moves the point across rows
    /// only.
    pub(crate) fn disparities_of_eye(&self, side: f64) -> Box<dyn Fn([usize; 2], f32) -> f64 + '_> {
        let nominal = self.disparities_of_rows();
        let Some(frustum) = self.frustum() else { return Box::new(move |[_, row], s| nominal(row, s)) };
        let (rounding, [fx, _]) = (self.baseline_rounding(), frustum.focal_px(self.size));
        let [cx, _] = frustum.principal_px(self.size, 0.5 * side);
        Box::new(move |[column, row], z| {
            let nominal = nominal(row, z);
            if rounding == DVec3::ZERO || !nominal.is_finite() {
                return nominal;
            }
            let z = f64::from(z);
            let tangent = (column as f64 + 0.5 - cx) / fx + side * f64::from(self.interaxial) / z;
            nominal + fx * (rounding.x - tangent * rounding.z) / (z + side * rounding.z)
        })
    }
}

impl Pose {
    /// Returns the disparity in pixels of a point in a row, from its depth `z`, without the eyes' rounding. In
    /// equirectangular pictures the eyes' distance depends on the row ([`PoleMerge`](crate::PoleMerge)).
    pub(crate) fn disparities_of_rows(&self) -> impl Fn(usize, f32) -> f64 {
        let circle = self.circle();
        move |row, z| match circle {
            None => self.disparity_px(z),
            Some(circle) => circle.disparity_px(z.into(), circle.elevation(row as f64 + 0.5)),
        }
    }

    /// Returns a column of a picture of all directions between 0 and its width. Other columns stay as they are.
    pub(crate) fn in_turn(&self, column: f64) -> f64 {
        self.circle().and_then(|circle| circle.turn).map_or(column, |turn| column.rem_euclid(turn))
    }
}

impl StereoPair {
    /// Returns the disparity of each left pixel, `d = x_l - x_r` in pixels. Pixel `(i, j)` shows a point at
    /// `x_l = i + 0.5`. In the right view that point lies at `x_r = i + 0.5 - d` in row j, where it may be hidden
    /// ([`StereoPair::occlusion`]).
    ///
    /// The list is row-major, `[height][width]`, top row first. It is computed in f64 from [`View::depth`], for the
    /// rendered eyes ([`Pose::eye_position`]). Disparity is positive in front of the screen, 0 on it, and **negative
    /// behind it**. An off-axis camera has zero disparity at the screen, not at infinity. Sky is infinitely far and has
    /// `-e_px`, the minimum. Add [`Pose::interaxial_px`] for disparities of parallel cameras, which are 0 at infinity.
    /// With the screen at infinity, the cameras are already parallel. A point in the plane of the eyes has the
    /// disparity `f32::INFINITY`.
    ///
    /// The list is empty if depth was not kept ([`GBuffer::None`](crate::GBuffer)), and if the eyes are toed in
    /// ([`Projection::ToeIn`](crate::Projection)) or have lenses. Points then don't stay in their rows:
    /// [`Renderer::correspondence`](crate::Renderer::correspondence) returns their places.
    ///
    /// ```
    /// use stereotrace::{Builtin, render_stereo};
    ///
    /// let pair = render_stereo(&Builtin::Hall.scene(), &Builtin::Hall.camera(64, 48))?;
    /// let before_the_screen = pair.left.depth.iter().map(|z| *z < pair.pose.screen_distance);
    /// assert!(pair.disparity().iter().zip(before_the_screen).all(|(d, before)| (*d > 0.0) == before));
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    pub fn disparity(&self) -> Vec<f32> {
        self.disparities(&self.left, -1.0)
    }

    /// Returns the disparity of each right pixel: its point lies at `x_l = i + 0.5 + d` in the left view. Methods that
    /// copy pixels ([`Method::ATOMIC`](crate::Method::ATOMIC) and similar) return the left samples' disparities, which
    /// belong to points up to half a pixel from the pixel's centre.
    pub fn right_disparity(&self) -> Vec<f32> {
        self.disparities(&self.right, 1.0)
    }

    /// Returns whether the right eye sees the point of each left pixel, judged by the right view's depths. The list is
    /// row-major, `[height][width]`, top row first. It is empty where [`StereoPair::disparity`] is.
    ///
    /// A point lands up to half a pixel from the nearest right pixel's centre. The surface there is extrapolated to the
    /// landing position with the flatter of the disparity slopes to the two neighbours. If the slopes have opposite
    /// signs, the surface is taken as level. This is exact on any plane. The point is hidden if that surface has over
    /// 0.25 px more disparity. Sky is a surface at infinity.
    ///
    /// Silhouettes and creases lie between two samples, so pixels there may be wrong. Compared with rays from the right
    /// eye to each point, 0.3 to 2.9% of the pixels of the built-in scenes differ (docs/DESIGN.md, section 7).
    /// [`Renderer::occlusions`](crate::Renderer::occlusions) casts these rays.
    pub fn occlusion(&self) -> Vec<Occlusion> {
        if self.pose.projection.without_rows().is_some() {
            return Vec::new();
        }
        let width = (self.left.width as usize).max(1);
        let (left, right) = (self.exact(&self.left, -1.0), self.exact(&self.right, 1.0));
        let rows = left.chunks_exact(width).zip(right.chunks_exact(width));
        let landing = |column: usize, d: f64| self.pose.in_turn(column as f64 + 0.5 - d);
        let of_row = |(left, right): (&[f64], &[f64])| -> Vec<Occlusion> {
            left.iter().enumerate().map(|(column, &d)| seen(landing(column, d), d, right)).collect()
        };
        rows.flat_map(of_row).collect()
    }

    fn disparities(&self, view: &View, side: f64) -> Vec<f32> {
        match self.pose.projection {
            Projection::OffAxis | Projection::Equirectangular(_) => {
                self.exact(view, side).into_iter().map(|d| d as f32).collect()
            }
            Projection::ToeIn | Projection::Lenses(_) => Vec::new(),
        }
    }

    fn exact(&self, view: &View, side: f64) -> Vec<f64> {
        let width = (view.width as usize).max(1);
        let disparity = self.pose.disparities_of_eye(side);
        view.depth.iter().enumerate().map(|(index, &z)| disparity([index % width, index / width], z)).collect()
    }
}

/// Returns whether a left point that lands at `x` is visible in a row of right disparities.
fn seen(x: f64, disparity: f64, right: &[f64]) -> Occlusion {
    // Compared as floats, since x may be huge near the plane of the eyes.
    if !(x >= 0.0 && x < right.len() as f64) {
        return Occlusion::OutOfFrame;
    }
    let nearest = x as usize;
    let here = right[nearest];
    let from_left = nearest.checked_sub(1).map(|left| here - right[left]);
    let to_right = right.get(nearest + 1).map(|right| right - here);
    let slope = match (from_left, to_right) {
        (Some(a), Some(b)) if a * b <= 0.0 => 0.0,
        (Some(a), Some(b)) if a.abs() < b.abs() => a,
        (a, b) => b.or(a).unwrap_or(0.0),
    };
    let surface = here + slope * (x - (nearest as f64 + 0.5));
    if surface > disparity + NEARER_PX { Occlusion::Hidden } else { Occlusion::Visible }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::{MISS, Statistics, StereoCamera};

    /// `e_px` = 8 and d = 4: disparity 8 (4/Z - 1).
    fn pose(width: u32) -> Pose {
        let camera = StereoCamera::look_at(4.0 * Vec3::Z, Vec3::ZERO).screen_distance(4.0);
        camera.size(width, 1).interaxial_pixels(8.0).pose().unwrap()
    }

    fn depth_of(disparity: f64) -> f32 {
        (4.0 / (disparity / 8.0 + 1.0)) as f32
    }

    fn view(disparities: &[f64]) -> View {
        let (count, colors) = (disparities.len(), disparities.len());
        View {
            width: count as u32,
            height: 1,
            rgba8: vec![[0; 4]; colors],
            linear: vec![[0.0; 4]; colors],
            depth: disparities.iter().map(|&d| depth_of(d)).collect(),
            primitive: vec![MISS; count],
            object: vec![MISS; count],
            albedo: Vec::new(),
            cost: Vec::new(),
        }
    }

    fn pair(left: &[f64], right: &[f64]) -> StereoPair {
        StereoPair {
            left: view(left),
            right: view(right),
            source: Vec::new(),
            shadow_source: Vec::new(),
            statistics: Statistics::default(),
            pose: pose(left.len() as u32),
        }
    }

    /// Columns with the wanted occlusion.
    fn columns(pair: &StereoPair, wanted: Occlusion) -> Vec<usize> {
        pair.occlusion().iter().enumerate().filter(|(_, found)| **found == wanted).map(|(column, _)| column).collect()
    }

    #[test]
    fn disparity_is_above_0_before_the_screen_and_minus_e_at_the_sky() {
        let pose = pose(40);
        assert!((pose.disparity_px(2.0) - 8.0).abs() < 1e-6);
        assert_eq!(pose.disparity_px(4.0), 0.0);
        assert!((pose.disparity_px(8.0) + 4.0).abs() < 1e-6);
        assert!((pose.disparity_px(f32::INFINITY) + 8.0).abs() < 1e-6);
        assert_eq!(pose.disparity_px(0.0), f64::INFINITY);
        for z in [0.1, 1.0, 3.0, 7.0, 1e6, f32::INFINITY] {
            assert!((pose.disparity_px(z) + f64::from(pose.parallax_px(z))).abs() < 1e-5 * pose.disparity_px(z).abs());
        }
        let none = StereoCamera::look_at(Vec3::Z, Vec3::ZERO).interaxial(0.0).pose().unwrap();
        assert!([0.0, 1.0, f32::INFINITY].iter().all(|&z| none.disparity_px(z).to_bits() == 0));
    }

    #[test]
    fn a_board_before_a_wall_hides_as_many_columns_as_it_moves() {
        // The wall is on the screen; the board moves by 8 columns, from 20..25 to 12..17.
        let board =
            |from: usize| Vec::from_iter((0..40).map(|i| if (from..from + 5).contains(&i) { 8.0 } else { 0.0 }));
        let pair = pair(&board(20), &board(12));
        assert_eq!(columns(&pair, Occlusion::Hidden), [12, 13, 14, 15, 16]);
        assert_eq!(columns(&pair, Occlusion::OutOfFrame), [0; 0]);
        assert_eq!(pair.disparity()[22], 8.0);
        assert_eq!(pair.right_disparity()[14], 8.0);
    }

    #[test]
    fn what_leaves_the_picture_is_out_of_frame_and_sky_is_seen_beside_it() {
        // Sky moves 8 columns to the right, past the edge.
        let pair = pair(&[-8.0; 40], &[-8.0; 40]);
        assert_eq!(columns(&pair, Occlusion::OutOfFrame), Vec::from_iter(32..40));
        assert_eq!(columns(&pair, Occlusion::Hidden), [0; 0]);
    }

    #[test]
    fn a_plane_hides_nothing_of_itself_however_slanted_it_is() {
        // A plane with disparity a + b x on the left has (a + b x) / (1 - b) at x on the right. Slopes over 1 turn its
        // back to the right eye.
        for slope in [-9.0, -1.0, -0.3, 0.0, 0.2, 0.5, 0.9] {
            for start in [0.0, 0.13, 0.5, 0.77] {
                // The plane is deepest at the edge, and no deeper than the screen.
                let first = if slope < 0.0 { start - 40.0 * slope } else { start };
                let left = Vec::from_iter((0..40).map(|i| first + slope * (f64::from(i) + 0.5)));
                let right = Vec::from_iter((0..40).map(|i| (first + slope * (f64::from(i) + 0.5)) / (1.0 - slope)));
                let pair = pair(&left, &right);
                assert_eq!(columns(&pair, Occlusion::Hidden), [0; 0], "{slope} {start}");
                assert!(columns(&pair, Occlusion::Visible).len() >= 3, "{slope} {start}");
            }
        }
    }

    #[test]
    fn without_depth_there_is_nothing_to_tell() {
        let mut pair = pair(&[0.0; 4], &[0.0; 4]);
        pair.left.depth.clear();
        assert!(pair.disparity().is_empty() && pair.occlusion().is_empty());
    }
}
