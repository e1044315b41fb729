//! Writes cameras in the conventions of stereo vision, as Middlebury's `calib.txt` and as a complete JSON file.

use std::path::Path;

use super::Batch;
#[cfg(any(test, feature = "exr", feature = "json"))]
use crate::Pose;
use crate::{Error, EyeTruth, GroundTruth, view::camera::Intrinsics};

/// Returns the matrix, row by row, from world coordinates to the frame of an eye (-1 left, +1 right): x right, y down,
/// z along the view, in world units.
#[cfg(any(test, feature = "exr", feature = "json"))]
pub(super) fn world_to_camera(pose: &Pose, side: f64) -> [[f64; 4]; 4] {
    let own = pose.of_eye(side as f32);
    let (eye, Pose { right, up, forward, .. }) = (own.eye_position(0.0), own);
    let [right, up, forward] = [right, up, forward].map(|axis| axis.as_dvec3());
    let row = |axis: glam::DVec3| [axis.x, axis.y, axis.z, -axis.dot(eye)];
    [row(right), row(-up), row(forward), [0.0, 0.0, 0.0, 1.0]]
}

/// Returns the least and the largest disparity of all surfaces of both views, or the sky's disparity if there are no
/// surfaces.
fn disparity_range(truth: &GroundTruth) -> [f64; 2] {
    let of = |eye: &EyeTruth| eye.disparity.iter().copied().zip(eye.surfaces()).collect::<Vec<_>>();
    let surfaces = [of(&truth.left), of(&truth.right)].concat();
    let found = surfaces.into_iter().filter(|(d, is_surface)| *is_surface && d.is_finite()).map(|(d, _)| f64::from(d));
    match found.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], d| [low.min(d), high.max(d)]) {
        [low, high] if low <= high => [low, high],
        _ => [truth.pose.disparity_px(f32::INFINITY); 2],
    }
}

/// Returns the text of Middlebury's `calib.txt` (2014). A disparity D has the depth `baseline f / (D + doffs)`, with
/// the baseline in world units. Principal points are relative to the centre of the top left pixel, as in `OpenCV` and
/// unlike elsewhere in this library. `vmin` and `vmax` are the disparity range of all surfaces of both views. `ndisp`
/// suffices for a search from 0 on, so it ignores negative disparities.
///
/// # Errors
/// [`Error::Camera`] for equirectangular pictures, which have no intrinsics.
pub fn calib_txt(truth: &GroundTruth) -> Result<String, Error> {
    let pose = &truth.pose;
    let intrinsics = pose.planar_intrinsics()?;
    let Intrinsics { fx, fy, cx0, cx1, cy } = intrinsics;
    let camera = |cx: f64| format!("[{fx} 0 {}; 0 {fy} {}; 0 0 1]", cx - 0.5, cy - 0.5);
    let [low, high] = disparity_range(truth);
    let (vmin, vmax) = (low.floor(), high.ceil());
    Ok(format!(
        "cam0={}\ncam1={}\ndoffs={}\nbaseline={}\nwidth={}\nheight={}\nndisp={}\nisint=0\nvmin={vmin}\nvmax={vmax}\ndyavg=0\ndymax=0\n",
        camera(cx0),
        camera(cx1),
        intrinsics.doffs(),
        pose.baseline(),
        pose.size[0],
        pose.size[1],
        vmax.max(0.0) + 1.0,
    ))
}

impl Batch {
    /// Adds the camera in the format of Middlebury's `calib.txt` ([`calib_txt`]).
    ///
    /// # Errors
    /// As [`Batch::add`] and [`calib_txt`].
    pub fn add_calib(&mut self, path: impl AsRef<Path>, truth: &GroundTruth) -> Result<(), Error> {
        self.add(path, calib_txt(truth)?.as_bytes())
    }

    /// Adds the camera as a JSON file ([`Pose::to_json`]).
    ///
    /// # Errors
    /// As [`Batch::add`].
    #[cfg(feature = "json")]
    pub fn add_camera_json(&mut self, path: impl AsRef<Path>, pose: &Pose) -> Result<(), Error> {
        self.add(path, pose.to_json().as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        MISS, Occlusion, StereoCamera,
        glam::{DVec3, Vec3},
    };

    /// f = 128 px, e = 0.25, `e_px` = 8: the screen, 4 units away and 8 wide, is 256 pixels wide. All these numbers are
    /// exact in f32.
    pub(super) fn pose() -> Pose {
        let camera = StereoCamera::look_at(4.0 * Vec3::Z, Vec3::ZERO).size(256, 128);
        camera.screen_width(8.0).interaxial(0.25).pose().unwrap()
    }

    fn truth(disparity: [f32; 3], primitive: [u32; 3]) -> GroundTruth {
        let eye = EyeTruth {
            width: 3,
            height: 1,
            depth: vec![1.0; 3],
            distance: vec![1.0; 3],
            disparity: disparity.to_vec(),
            occlusion: vec![Occlusion::Visible; 3],
            geometric_normal: vec![[0.0; 3]; 3],
            shading_normal: vec![[0.0; 3]; 3],
            primitive: primitive.to_vec(),
            object: primitive.to_vec(),
            material: primitive.to_vec(),
        };
        GroundTruth { left: eye.clone(), right: eye, pose: pose() }
    }

    #[test]
    fn calib_txt_is_as_worked_out_by_hand() {
        // Principal points are 128 -+ 4, minus 0.5 since they are relative to the first pixel's centre. Sky has -8 and
        // is no surface.
        let expected = "cam0=[128 0 123.5; 0 128 63.5; 0 0 1]\ncam1=[128 0 131.5; 0 128 63.5; 0 0 1]\n\
                        doffs=8\nbaseline=0.25\nwidth=256\nheight=128\nndisp=13\nisint=0\nvmin=-2\nvmax=12\ndyavg=0\ndymax=0\n";
        assert_eq!(calib_txt(&truth([11.5, -1.25, -8.0], [0, 1, MISS])).unwrap(), expected);
        // Tests sky alone, and points in the plane of the eyes.
        assert!(calib_txt(&truth([-8.0; 3], [MISS; 3])).unwrap().contains("ndisp=1\nisint=0\nvmin=-8\nvmax=-8\n"));
        assert!(calib_txt(&truth([f32::INFINITY, 1.0, 2.0], [0; 3])).unwrap().contains("vmin=1\nvmax=2\n"));
    }

    #[test]
    fn intrinsics_and_matrices_show_points_where_the_pose_does() {
        let camera = StereoCamera::look_at(Vec3::new(3.0, -1.0, 2.0), Vec3::new(-1.0, 0.5, -4.0)).size(123, 77);
        let pose = camera.interaxial(0.4).screen_distance(3.0).pose().unwrap();
        let Intrinsics { fx, fy, cx0, cx1, cy } = pose.intrinsics().unwrap();
        for (side, cx) in [(-1.0, cx0), (1.0, cx1)] {
            for point in [Vec3::ZERO, Vec3::new(0.3, 0.2, -2.0), Vec3::new(-5.0, 2.0, -9.0)] {
                let [x, y, z] = [0, 1, 2].map(|row| {
                    let [a, b, c, d] = world_to_camera(&pose, side)[row];
                    DVec3::new(a, b, c).dot(point.as_dvec3()) + d
                });
                let [column, row, depth] = pose.project(point, side as f32).map(f64::from);
                let found = [fx * x / z + cx, fy * y / z + cy, z];
                let off = [found[0] - column, found[1] - row, found[2] - depth];
                assert!(off.iter().all(|off| off.abs() < 2e-5), "{found:?} {column} {row} {depth}");
            }
        }
    }
}
