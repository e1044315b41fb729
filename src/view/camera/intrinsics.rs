//! Camera intrinsics: focal lengths and principal points in pixels.

use super::ranges::fault;
use crate::Error;

/// Focal lengths and principal points of a calibrated pair, in pixels: `x = fx X/Z + cx` and `y = fy Y/Z + cy`. The
/// point lies `X` to the right of an eye's axis, `Y` below it and `Z` along it. x and y are measured from the picture's
/// top left corner, with **pixel centres at halves**. `OpenCV`, Middlebury and KITTI have pixel centres at integers:
/// add a half to their `cx` and `cy`.
///
/// Both eyes share `fx`, `fy` and `cy`, and have no lens distortion, so rows are epipolar lines. If `cx1` is above
/// `cx0`, the eyes look through one screen at `d = fx e / (cx1 - cx0)`. If both are equal, the eyes are parallel
/// cameras. The values are f64, so that calibrations pass through unchanged.
///
/// ```
/// use stereotrace::{StereoCamera, camera::Intrinsics, glam::Vec3};
///
/// // Middlebury 2014, Motorcycle: world units are millimetres.
/// let intrinsics = Intrinsics::new([3979.911; 2], [1244.772 + 0.5, 1019.507 + 0.5]).right_cx(1369.115 + 0.5);
/// let camera = StereoCamera::look_at(Vec3::ZERO, -Vec3::Z).size(2964, 1988);
/// let camera = camera.intrinsics(intrinsics).interaxial(193.001);
/// let pose = camera.pose()?;
/// assert!((pose.disparity_px(3000.0) - (3979.911 * 193.001 / 3000.0 - 124.343)).abs() < 1e-4);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Intrinsics {
    /// Focal length along x.
    pub fx: f64,
    /// Focal length along y; it differs from `fx` if pixels are not square.
    pub fy: f64,
    /// Column of the left eye's principal point.
    pub cx0: f64,
    /// Column of the right eye's principal point.
    pub cx1: f64,
    /// Row of both principal points.
    pub cy: f64,
}

impl Intrinsics {
    /// Makes the intrinsics of parallel cameras, whose principal points coincide.
    pub fn new([fx, fy]: [f64; 2], [cx, cy]: [f64; 2]) -> Self {
        Self { fx, fy, cx0: cx, cx1: cx, cy }
    }

    /// Sets the column of the right eye's principal point.
    pub fn right_cx(mut self, cx1: f64) -> Self {
        self.cx1 = cx1;
        self
    }

    /// Returns `cx1 - cx0`, the parallax at infinity: Middlebury's `doffs`.
    pub fn doffs(&self) -> f64 {
        self.cx1 - self.cx0
    }

    /// Returns the intrinsics for the same view in a picture `x` times as wide and `y` times as high.
    pub fn scaled(self, [x, y]: [f64; 2]) -> Self {
        Self { fx: x * self.fx, fy: y * self.fy, cx0: x * self.cx0, cx1: x * self.cx1, cy: y * self.cy }
    }

    /// Splits the intrinsics into the part that both eyes share, and `doffs`.
    pub(super) fn split(self) -> (Lenses, f64) {
        let Self { fx, fy, cx0, cx1, cy } = self;
        (Lenses { focal: [fx, fy], principal: [0.5 * (cx0 + cx1), cy] }, self.doffs())
    }
}

/// Focal lengths and the mean of both eyes' principal points, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lenses {
    pub(crate) focal: [f64; 2],
    pub(crate) principal: [f64; 2],
}

impl Lenses {
    /// Makes the lenses from half of the vertical field of view, in radians, and the picture's size.
    pub(super) fn of_fov(half: f64, size: [f64; 2]) -> Self {
        let [_, y] = size.map(|side| 0.5 * side);
        Self { focal: [y / half.tan(); 2], principal: size.map(|side| 0.5 * side) }
    }

    pub(super) fn checked(self) -> Result<Self, Error> {
        let [fx, fy] = self.focal;
        if let Some(bad) = [fx, fy].into_iter().find(|focal| !(*focal > 0.0 && focal.is_finite())) {
            let field = if bad.to_bits() == fx.to_bits() { "fx" } else { "fy" };
            return fault(field, bad.to_string(), "a focal length must be a number of pixels above 0");
        }
        for (field, value) in ["cx", "cy"].into_iter().zip(self.principal) {
            if !value.is_finite() {
                return fault(field, value.to_string(), "a principal point must be a number of pixels");
            }
        }
        Ok(self)
    }
}
