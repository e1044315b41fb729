//! Cameras as calibrations have them: focal lengths and principal points in pixels.

use super::ranges::fault;
use crate::Error;

/// Focal lengths and principal points of a calibrated pair, in pixels: `x = fx X/Z + cx` and `y = fy Y/Z + cy` of a
/// point `X` to the right of an eye's axis, `Y` below it and `Z` along it, x and y from the picture's top left corner
/// with **pixel centres at halves**. (`OpenCV`, Middlebury and KITTI count them at integers: add a half to their `cx`
/// and `cy`.)
///
/// Both eyes have the same `fx`, `fy` and `cy`, and no lens distortion: rows are epipolar lines. Where `cx1` is above
/// `cx0` the eyes look through one screen at `d = fx e / (cx1 - cx0)`; where both are equal they are parallel cameras.
/// f64, so that calibrations go round unchanged.
///
/// ```
/// use stereotrace::{StereoCamera, camera::Intrinsics, glam::Vec3};
///
/// // Middlebury 2014, Motorcycle: world units are millimetres.
/// let intrinsics = Intrinsics::new([3979.911; 2], [1244.772 + 0.5, 1019.507 + 0.5]).right_cx(1369.115 + 0.5);
/// let camera = StereoCamera::look_at(Vec3::ZERO, -Vec3::Z).size(2964, 1988).intrinsics(intrinsics).interaxial(193.001);
/// let pose = camera.pose()?;
/// assert!((pose.disparity_px(3000.0) - (3979.911 * 193.001 / 3000.0 - 124.343)).abs() < 1e-4);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Intrinsics {
    /// Focal length along x.
    pub fx: f64,
    /// Focal length along y; not `fx` where pixels are not square.
    pub fy: f64,
    /// Column of the left eye's principal point.
    pub cx0: f64,
    /// Column of the right eye's principal point.
    pub cx1: f64,
    /// Row of both principal points.
    pub cy: f64,
}

impl Intrinsics {
    /// Of parallel cameras, whose principal points are in one place.
    pub fn new([fx, fy]: [f64; 2], [cx, cy]: [f64; 2]) -> Self {
        Self { fx, fy, cx0: cx, cx1: cx, cy }
    }

    /// Column of the right eye's principal point.
    pub fn right_cx(mut self, cx1: f64) -> Self {
        self.cx1 = cx1;
        self
    }

    /// `cx1 - cx0`: Middlebury's `doffs`, the parallax at infinity.
    pub fn doffs(&self) -> f64 {
        self.cx1 - self.cx0
    }

    /// Of a picture so many times as wide and high that shows the same.
    pub fn scaled(self, [x, y]: [f64; 2]) -> Self {
        Self { fx: x * self.fx, fy: y * self.fy, cx0: x * self.cx0, cx1: x * self.cx1, cy: y * self.cy }
    }

    /// What both eyes have in common, and `doffs`.
    pub(super) fn split(self) -> (Lenses, f64) {
        let Self { fx, fy, cx0, cx1, cy } = self;
        (Lenses { focal: [fx, fy], principal: [0.5 * (cx0 + cx1), cy] }, self.doffs())
    }
}

/// Focal lengths, and the principal point in the middle between the eyes', in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lenses {
    pub(super) focal: [f64; 2],
    pub(super) principal: [f64; 2],
}

impl Lenses {
    /// Of a field of view, given half of its vertical angle in radians.
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
