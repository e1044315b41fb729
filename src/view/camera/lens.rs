//! Lenses with distortion: what their pictures show, and checks of their coefficients.

use glam::DVec2;

use super::{
    Field, Intrinsics, Pose, Projection, StereoCamera,
    ranges::fault,
    warp::{Profile, Warp},
};
use crate::Error;

/// Number of places on each side of a picture to which a lens is checked, and the corner.
const PLACES: u32 = 16;
/// Largest angle between a fisheye's axis and a ray of its picture, in degrees. Depth is measured along the axis, so
/// rays must run forwards.
const WIDEST_DEGREES: f64 = 89.0;
/// Largest error of a kernel's inverse in pixels, before rounding.
const EXACT_PX: f64 = 1e-4;

/// A lens: focal lengths and principal point in pixels, and its distortion. **Pixel centres are at halves**: add a half
/// to `OpenCV`'s `cx` and `cy`.
///
/// The point (X, Y, Z) of an eye lies X to the right of its axis, Y below it and Z along it. The picture shows it at
/// `x = fx x' + cx` and `y = fy y' + cy`, where (x', y') is the distorted point of (X/Z, Y/Z) ([`Distortion`]).
///
/// ```
/// use stereotrace::{Builtin, Distortion, Lens};
///
/// let lens = Lens::new([320.0; 2], [320.0, 240.0]).distortion(Distortion::opencv(&[-0.2, 0.03, 1e-3, 0.0])?);
/// let camera = Builtin::Hall.camera(640, 480).interaxial(0.1).lens(lens);
/// assert!(camera.pose().is_ok());
/// let [x, y] = lens.tangents_of([600.0, 400.0]).unwrap();
/// assert!((lens.pixel_of([x, y]).unwrap()[0] - 600.0).abs() < 1e-9);
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Lens {
    /// Focal length along x.
    pub fx: f64,
    /// Focal length along y.
    pub fy: f64,
    /// Column of the principal point.
    pub cx: f64,
    /// Row of the principal point.
    pub cy: f64,
    /// How the lens distorts the picture.
    pub distortion: Distortion,
}

/// Distortion of a lens, as `OpenCV` defines it. `x = X/Z` and `y = Y/Z`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distortion {
    /// `OpenCV`'s standard model. With `r² = x² + y²` and
    /// `R = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶)`:
    ///
    /// - `x' = x R + 2 p1 x y + p2 (r² + 2 x²)`
    /// - `y' = y R + p1 (r² + 2 y²) + 2 p2 x y`
    RadialTangential {
        /// `k1` to `k6`.
        k: [f64; 6],
        /// `p1` and `p2`.
        p: [f64; 2],
    },
    /// `OpenCV`'s fisheye model (Kannala & Brandt 2006). With the angle `t = atan(r)` from the axis and
    /// `R = t (1 + k1 t² + k2 t⁴ + k3 t⁶ + k4 t⁸) / r`, `x' = x R` and `y' = y R`.
    Fisheye {
        /// `k1` to `k4`.
        k: [f64; 4],
    },
}

impl Distortion {
    /// No distortion.
    pub const NONE: Self = Self::RadialTangential { k: [0.0; 6], p: [0.0; 2] };

    /// Makes a radial-tangential distortion from coefficients in `OpenCV`'s order: `k1, k2, p1, p2`, then optionally
    /// `k3`, then optionally `k4, k5, k6`.
    ///
    /// # Errors
    /// [`Error::Camera`] for another number of coefficients than 0, 4, 5 or 8.
    pub fn opencv(coefficients: &[f64]) -> Result<Self, Error> {
        match *coefficients {
            [] => Ok(Self::NONE),
            [k1, k2, p1, p2] => Ok(Self::RadialTangential { k: [k1, k2, 0.0, 0.0, 0.0, 0.0], p: [p1, p2] }),
            [k1, k2, p1, p2, k3] => Ok(Self::RadialTangential { k: [k1, k2, k3, 0.0, 0.0, 0.0], p: [p1, p2] }),
            [k1, k2, p1, p2, k3, k4, k5, k6] => Ok(Self::RadialTangential { k: [k1, k2, k3, k4, k5, k6], p: [p1, p2] }),
            _ => {
                let reason = "OpenCV's vectors of 4, 5 or 8 coefficients are supported, without thin prisms and tilt";
                fault("lens", format!("a distortion of {} coefficients", coefficients.len()), reason)
            }
        }
    }

    /// Makes a fisheye distortion from `OpenCV`'s coefficients `k1` to `k4`.
    pub fn fisheye(k: [f64; 4]) -> Self {
        Self::Fisheye { k }
    }

    pub(super) fn warp(&self) -> Warp {
        match *self {
            Self::RadialTangential { k, p } => Warp { profile: Profile::Rational(k), tangential: p },
            Self::Fisheye { k } => Warp { profile: Profile::Polynomial(k), tangential: [0.0; 2] },
        }
    }

    /// Returns the point that [`Distortion::warp`] moves, for the tangents of a direction.
    fn flat(&self, tangents: DVec2) -> DVec2 {
        match self {
            Self::RadialTangential { .. } => tangents,
            // The length becomes the angle.
            Self::Fisheye { .. } => match tangents.length() {
                0.0 => tangents,
                length => tangents * (length.atan() / length),
            },
        }
    }

    /// Does the inverse of [`Distortion::flat`].
    fn tangents(&self, flat: DVec2) -> DVec2 {
        match self {
            Self::RadialTangential { .. } => flat,
            Self::Fisheye { .. } => match flat.length() {
                0.0 => flat,
                angle => flat * (angle.tan() / angle),
            },
        }
    }

    pub(super) fn numbers(&self) -> Vec<f64> {
        match *self {
            Self::RadialTangential { k: [k1, k2, k3, rest @ ..], p: [p1, p2] } => {
                [&[k1, k2, p1, p2, k3][..], &rest].concat()
            }
            Self::Fisheye { k } => k.to_vec(),
        }
    }
}

impl std::fmt::Display for Distortion {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = if matches!(self, Self::Fisheye { .. }) { "fisheye" } else { "radial-tangential" };
        write!(formatter, "{name} {:?}", self.numbers())
    }
}

impl Lens {
    /// Makes a lens without distortion from its focal lengths and principal point in pixels.
    pub fn new([fx, fy]: [f64; 2], [cx, cy]: [f64; 2]) -> Self {
        Self { fx, fy, cx, cy, distortion: Distortion::NONE }
    }

    /// Sets the distortion.
    pub fn distortion(mut self, distortion: Distortion) -> Self {
        self.distortion = distortion;
        self
    }

    /// Returns where the picture shows the direction (x, y, 1), in pixels with centres at halves. It is `None` for
    /// directions beyond a fold, which the lens does not show, wherever the formula puts them.
    pub fn pixel_of(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let (warp, flat) = (self.distortion.warp(), self.distortion.flat(DVec2::new(x, y)));
        (flat.is_finite() && warp.reaches(flat)).then(|| self.pixel(warp.distorted(flat)))
    }

    /// Returns x and y of the direction (x, y, 1) that a place of the picture shows, or `None` if the distortion folds
    /// between the principal point and this place. A fisheye's directions are less than 90 degrees off its axis.
    pub fn tangents_of(&self, place: [f64; 2]) -> Option<[f64; 2]> {
        let flat = self.distortion.warp().inverse(self.point(place)).ok()?;
        self.is_ahead(flat).then(|| self.distortion.tangents(flat).to_array())
    }

    /// Does the same as [`Lens::tangents_of`] for a place in the picture of a checked lens.
    pub(crate) fn tangents_within(&self, place: [f64; 2]) -> [f64; 2] {
        self.distortion.tangents(self.distortion.warp().inverse_in_steps(self.point(place))).to_array()
    }

    /// Returns the lens for a picture that is `times` as wide and high, whose samples lie `aside` pixels to the right
    /// and down.
    pub(crate) fn scaled(self, [x, y]: [f64; 2], aside: f64) -> Self {
        let (fx, fy) = (x * self.fx, y * self.fy);
        Self { fx, fy, cx: x * self.cx + aside, cy: y * self.cy + aside, ..self }
    }

    fn point(&self, [x, y]: [f64; 2]) -> DVec2 {
        DVec2::new((x - self.cx) / self.fx, (y - self.cy) / self.fy)
    }

    fn pixel(&self, point: DVec2) -> [f64; 2] {
        [self.fx * point.x + self.cx, self.fy * point.y + self.cy]
    }

    fn is_ahead(&self, flat: DVec2) -> bool {
        !matches!(self.distortion, Distortion::Fisheye { .. }) || flat.length() < std::f64::consts::FRAC_PI_2
    }

    /// Checks the numbers, and that the picture of this size is not folded.
    fn check(&self, size: [u32; 2]) -> Result<(), Error> {
        let Self { fx, fy, cx, cy, distortion } = *self;
        for (name, value) in [("fx", fx), ("fy", fy)] {
            if !(value > 0.0 && value.is_finite()) {
                return fault("lens", format!("{name} {value}"), "a focal length must be a number of pixels above 0");
            }
        }
        for (name, value) in [("cx", cx), ("cy", cy)] {
            if !value.is_finite() {
                return fault("lens", format!("{name} {value}"), "a principal point must be a number of pixels");
            }
        }
        if !distortion.numbers().iter().all(|number| number.is_finite()) {
            return fault("lens", distortion.to_string(), "coefficients of distortion must be finite numbers");
        }
        border(size).try_for_each(|place| self.check_place(place))
    }

    /// Checks the lenses of both eyes.
    pub(crate) fn check_both([left, right]: &[Self; 2], size: [u32; 2]) -> Result<(), Error> {
        left.check(size)?;
        if right == left { Ok(()) } else { right.check(size) }
    }

    fn check_place(&self, place: [f64; 2]) -> Result<(), Error> {
        let (warp, target) = (self.distortion.warp(), self.point(place));
        let at = |share: f64, what: &str| {
            let [x, y] = self.pixel(target * share);
            let radius = (x - self.cx).hypot(y - self.cy);
            format!("{}, {what} at pixel ({x:.1}, {y:.1}), {radius:.1} px from the principal point", self.distortion)
        };
        let flat = match warp.inverse(target) {
            Ok(flat) => flat,
            Err(share) => {
                let reason = "the distortion must not fold the picture: use weaker coefficients, or a smaller picture";
                return fault("lens", at(share, "which folds"), reason);
            }
        };
        if matches!(self.distortion, Distortion::Fisheye { .. }) && flat.length() > WIDEST_DEGREES.to_radians() {
            let degrees = flat.length().to_degrees();
            let reason = "a fisheye's picture must end within 89 degrees of its axis: use a longer focal length, or a \
                          smaller picture";
            return fault("lens", at(1.0, &format!("which shows {degrees:.1} degrees off the axis")), reason);
        }
        let missed = DVec2::from(self.pixel(warp.distorted(warp.inverse_in_steps(target)))) - DVec2::from(place);
        if missed.is_nan() || missed.length() > EXACT_PX {
            let reason = "so near to a fold, kernels can't invert the distortion: use weaker coefficients, or a \
                          smaller picture";
            return fault("lens", at(1.0, "which hardly grows"), reason);
        }
        Ok(())
    }

    /// Returns the least angle in radians between neighbouring pixels of the picture's border.
    fn least_pixel_angle(&self, size: [u32; 2]) -> f64 {
        let angle = |[x, y]: [f64; 2]| {
            let [here, right, down] = [[x, y], [x + 1.0, y], [x, y + 1.0]].map(|place| {
                let [x, y] = self.tangents_within(place);
                glam::DVec3::new(x, y, 1.0).normalize()
            });
            here.distance(right).min(here.distance(down))
        };
        border(size).map(|[x, y]| [(x - 1.0).max(0.0), (y - 1.0).max(0.0)]).map(angle).fold(f64::INFINITY, f64::min)
    }
}

/// Returns places on the border of a picture.
fn border(size: [u32; 2]) -> impl Iterator<Item = [f64; 2]> {
    let [w, h] = size.map(f64::from);
    (0..PLACES).flat_map(move |place| {
        let share = f64::from(place) / f64::from(PLACES);
        [[w * share, 0.0], [w, h * share], [w * (1.0 - share), h], [0.0, h * (1.0 - share)]]
    })
}

/// Returns the least angle in radians between neighbouring pixels of the borders of both eyes' pictures.
pub(super) fn least_lens_angle(lenses: &[Lens; 2], size: [u32; 2]) -> f64 {
    lenses.iter().map(|lens| lens.least_pixel_angle(size)).fold(f64::INFINITY, f64::min)
}

impl StereoCamera {
    /// Gives both eyes this lens: [`StereoCamera::lenses`].
    pub fn lens(self, lens: Lens) -> Self {
        self.lenses(lens, lens)
    }

    /// Gives the left and the right eye a lens each, for a picture of this [`StereoCamera::size`]. The eyes are
    /// parallel. The lenses replace the field of view, the intrinsics and the screen; the interaxial must be given in
    /// world units.
    ///
    /// Rows of such pictures are not epipolar lines, so no samples can be reused.
    /// [`Method::Naive`](crate::Method::Naive) renders the pair even if another method is set, and a warning is logged.
    /// [`Renderer::correspondence`](crate::Renderer::correspondence) returns where the other eye sees each point.
    pub fn lenses(self, left: Lens, right: Lens) -> Self {
        self.projection(Projection::Lenses([left, right]))
    }

    /// Returns the rectified camera: the same eyes without lenses, as parallel cameras. Their intrinsics are those of
    /// the lenses, or the mean of both. A picture of this camera is the ground truth of the rectified picture.
    /// [`Remap`](crate::output::Remap) leads from it to the picture of the lens. Cameras without lenses are returned as
    /// they are.
    pub fn rectified(self) -> Self {
        let Projection::Lenses([left, right]) = self.projection else { return self };
        let focal = [0.5 * (left.fx + right.fx), 0.5 * (left.fy + right.fy)];
        let principal = [0.5 * (left.cx + right.cx), 0.5 * (left.cy + right.cy)];
        self.projection(Projection::OffAxis).intrinsics(Intrinsics::new(focal, principal))
    }
}

impl Pose {
    /// Returns the lens of an eye (-1 left, +1 right), or `None` for cameras without lenses.
    pub fn lens(&self, side: f32) -> Option<Lens> {
        match self.field {
            Field::Lenses([left, right]) => Some(if side > 0.0 { right } else { left }),
            Field::Screen(_) | Field::Sphere(_) => None,
        }
    }
}
