//! Cameras as stereo vision has them: intrinsics of both eyes, Middlebury's `calib.txt`, and a JSON file that has all of it.

use std::path::Path;

use super::Batch;
use crate::{Error, EyeTruth, GroundTruth, Pose};

/// A pinhole camera: what is at `(x, y, z)` in its frame (x right, y down, z along the view) is seen at column `fx x / z + cx` and
/// row `fy y / z + cy`, in pixels from the picture's top left corner, so that pixel centres are at halves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Intrinsics {
    /// Focal length along rows, pixels.
    pub fx: f64,
    /// Focal length along columns, pixels.
    pub fy: f64,
    /// Column of the principal point.
    pub cx: f64,
    /// Row of the principal point.
    pub cy: f64,
}

impl Pose {
    /// The intrinsics of an eye: -1 left, +1 right, 0 the midpoint. Off-axis eyes look along parallel axes through one screen, so
    /// their principal points are `e_px` apart, the left eye's on the left.
    pub fn intrinsics(&self, side: f64) -> Intrinsics {
        let [w, h] = self.size.map(f64::from);
        let [across, tall] = self.screen_size.map(f64::from);
        let d = f64::from(self.screen_distance);
        let aside = 0.5 * side * f64::from(self.interaxial) * w / across;
        Intrinsics { fx: d * w / across, fy: d * h / tall, cx: 0.5 * w + aside, cy: 0.5 * h }
    }

    /// The matrix, row by row, that takes points of the world to an eye's frame: x right, y down, z along the view, in world units.
    pub fn world_to_camera(&self, side: f64) -> [[f64; 4]; 4] {
        let [right, down, forward] = [self.right, -self.up, self.forward].map(|axis| axis.as_dvec3());
        let eye = self.eye.as_dvec3() + right * (0.5 * side * f64::from(self.interaxial));
        let row = |axis: glam::DVec3| [axis.x, axis.y, axis.z, -axis.dot(eye)];
        [row(right), row(down), row(forward), [0.0, 0.0, 0.0, 1.0]]
    }
}

/// Least and largest disparity of the surfaces of both views, of the sky where there are none.
fn disparity_range(truth: &GroundTruth) -> [f64; 2] {
    let of = |eye: &EyeTruth| eye.disparity.iter().copied().zip(eye.surfaces()).collect::<Vec<_>>();
    let surfaces = [of(&truth.left), of(&truth.right)].concat();
    let found = surfaces.into_iter().filter(|(d, is_surface)| *is_surface && d.is_finite()).map(|(d, _)| f64::from(d));
    match found.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], d| [low.min(d), high.max(d)]) {
        [low, high] if low <= high => [low, high],
        _ => [truth.pose.disparity_px(f32::INFINITY); 2],
    }
}

/// The text of Middlebury's `calib.txt` (2014): the depth of what has disparity D is `baseline f / (D + doffs)`, the baseline in
/// world units. Principal points are counted from the centre of the top left pixel, as OpenCV counts and we do not. The disparities
/// are those of all surfaces of both views; `ndisp` is enough for a search from 0 on, so it says nothing of negative ones.
pub fn calib_txt(truth: &GroundTruth) -> String {
    let pose = &truth.pose;
    let [left, right] = [-1.0, 1.0].map(|side| pose.intrinsics(side));
    let camera = |eye: Intrinsics| format!("[{} 0 {}; 0 {} {}; 0 0 1]", eye.fx, eye.cx - 0.5, eye.fy, eye.cy - 0.5);
    let [low, high] = disparity_range(truth);
    let (vmin, vmax) = (low.floor(), high.ceil());
    format!(
        "cam0={}\ncam1={}\ndoffs={}\nbaseline={}\nwidth={}\nheight={}\nndisp={}\nisint=0\nvmin={vmin}\nvmax={vmax}\ndyavg=0\ndymax=0\n",
        camera(left),
        camera(right),
        right.cx - left.cx,
        f64::from(pose.interaxial),
        pose.size[0],
        pose.size[1],
        vmax.max(0.0) + 1.0,
    )
}

impl Batch {
    /// Adds the camera as Middlebury's `calib.txt` has it ([`calib_txt`]).
    ///
    /// # Errors
    /// As [`Batch::add`].
    pub fn add_calib(&mut self, path: impl AsRef<Path>, truth: &GroundTruth) -> Result<(), Error> {
        self.add(path, calib_txt(truth).as_bytes())
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
