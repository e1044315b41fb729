//! Maps from rectified pictures to pictures of lenses.

use crate::{Error, StereoCamera};

/// Where an eye's picture shows the pixels of the rectified picture ([`StereoCamera::rectified`]): the maps of
/// `OpenCV`'s `initUndistortRectifyMap`, without rotation. `cv2.remap(picture, x, y, …)` makes the rectified picture.
///
/// ```
/// use stereotrace::{Builtin, Distortion, Lens, output::Remap};
///
/// let lens = Lens::new([60.0; 2], [32.0, 24.0]).distortion(Distortion::opencv(&[-0.2, 0.03, 0.0, 0.0])?);
/// let camera = Builtin::Hall.camera(64, 48).interaxial(0.2).lens(lens);
/// let map = Remap::new(&camera, -1.0)?;
/// // The principal point stays at its place. Here, pixel centres are at integers.
/// assert!((map.x[24 * 64 + 32] - 32.0).abs() < 1e-3);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Remap {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Columns in the eye's picture, `[height][width]`, top row first. **Pixel centres are at integers**, as in
    /// `OpenCV` and unlike elsewhere in this library. NaN where the lens does not show the direction.
    pub x: Vec<f32>,
    /// Rows in the eye's picture, like `x`.
    pub y: Vec<f32>,
}

impl Remap {
    /// Computes the maps of an eye (-1 left, +1 right) of a camera with lenses.
    ///
    /// # Errors
    /// [`Error::Camera`] for a camera without lenses, and for an invalid one.
    pub fn new(camera: &StereoCamera, side: f32) -> Result<Self, Error> {
        let pose = camera.pose()?;
        let (Some(lens), Some(ideal)) = (pose.lens(side), camera.rectified().pose()?.intrinsics()) else {
            let reason = "only pictures of lenses are rectified; set the camera's lens";
            return Err(Error::Camera { field: "lens", value: "missing".into(), reason });
        };
        let [width, height] = pose.size;
        let mut maps = Self { width, height, x: Vec::new(), y: Vec::new() };
        for row in 0..height {
            for column in 0..width {
                let x = (f64::from(column) + 0.5 - ideal.cx0) / ideal.fx;
                let y = (f64::from(row) + 0.5 - ideal.cy) / ideal.fy;
                let [x, y] = lens.pixel_of([x, y]).unwrap_or([f64::NAN; 2]);
                maps.x.push((x - 0.5) as f32);
                maps.y.push((y - 0.5) as f32);
            }
        }
        Ok(maps)
    }
}
