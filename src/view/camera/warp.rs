//! Maps of lens distortion and their inverses, in f64. `shaders/shared/lens.wgsl` has the same formulas in f32.

use glam::{DMat2, DVec2};

/// Number of equal parts of the way from the principal point to a pixel, as in `lens.wgsl`. Each part takes one step of
/// Newton's method.
const PARTS: u32 = 16;
/// Number of Newton's steps at the end of the way, as in `lens.wgsl`.
const LAST_STEPS: u32 = 8;
/// Longest and shortest part of the way by which [`Warp::inverse`] proceeds.
const PART_LENGTHS: [f64; 2] = [1.0 / 16.0, 1e-6];
/// Maximum number of Newton's steps in a part of the way.
const STEPS: u32 = 16;
/// Number of places between two ends of a part at which the map is tested for folds.
const TESTS: u32 = 4;
/// Number of places between the axis and a point at which [`Warp::reaches`] tests the map.
const REACH_TESTS: u32 = 64;

/// Share by which a lens moves points away from its axis, as a function of the squared distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Profile {
    /// `(1 + k1 s + k2 s² + k3 s³) / (1 + k4 s + k5 s² + k6 s³) - 1`.
    Rational([f64; 6]),
    /// `k1 s + k2 s² + k3 s³ + k4 s⁴`.
    Polynomial([f64; 4]),
}

/// A map of the plane that fixes 0: `v q(|v|²)` and a tangential part are added to v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Warp {
    pub(super) profile: Profile,
    pub(super) tangential: [f64; 2],
}

impl Profile {
    /// Returns the share q at a squared distance, and its derivative.
    fn excess(self, s: f64) -> [f64; 2] {
        match self {
            Self::Rational([k1, k2, k3, k4, k5, k6]) => {
                // 1 is subtracted from the fraction before it is evaluated, so that small values are accurate.
                let [a, b, c] = [k1 - k4, k2 - k5, k3 - k6];
                let (top, bottom) = (s * (a + s * (b + s * c)), 1.0 + s * (k4 + s * (k5 + s * k6)));
                let top_slope = a + s * (2.0 * b + s * (3.0 * c));
                let bottom_slope = k4 + s * (2.0 * k5 + s * (3.0 * k6));
                [top / bottom, (top_slope * bottom - top * bottom_slope) / (bottom * bottom)]
            }
            Self::Polynomial([k1, k2, k3, k4]) => {
                [s * (k1 + s * (k2 + s * (k3 + s * k4))), k1 + s * (2.0 * k2 + s * (3.0 * k3 + s * (4.0 * k4)))]
            }
        }
    }
}

impl Warp {
    pub(super) fn distorted(&self, v: DVec2) -> DVec2 {
        let [q, _] = self.profile.excess(v.length_squared());
        let ([p1, p2], s) = (self.tangential, v.length_squared());
        let tangential = DVec2::new(
            2.0 * p1 * v.x * v.y + p2 * (s + 2.0 * v.x * v.x),
            p1 * (s + 2.0 * v.y * v.y) + 2.0 * p2 * v.x * v.y,
        );
        v + (v * q + tangential)
    }

    /// Returns the derivative of [`Warp::distorted`].
    pub(super) fn jacobian(&self, v: DVec2) -> DMat2 {
        let [q, slope] = self.profile.excess(v.length_squared());
        let ([p1, p2], DVec2 { x, y }) = (self.tangential, v);
        let across = 2.0 * (x * y * slope + p1 * x + p2 * y);
        let xx = 1.0 + q + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
        let yy = 1.0 + q + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
        DMat2::from_cols_array(&[xx, across, across, yy])
    }

    /// Returns whether the map keeps the orientation of the plane at a point. Where it does not, the picture is folded.
    fn is_upright(&self, v: DVec2) -> bool {
        self.jacobian(v).determinant() > 0.0
    }

    /// Returns whether the map has no fold between the axis and a point.
    pub(super) fn reaches(&self, v: DVec2) -> bool {
        (1..=REACH_TESTS).all(|test| self.is_upright(v * (f64::from(test) / f64::from(REACH_TESTS))))
    }

    /// Returns the point that the map moves to `target`. The point is followed from the axis outwards, so there is one
    /// answer at most. If the map folds before `target`, the error is the share of the way to the fold.
    pub(super) fn inverse(&self, target: DVec2) -> Result<DVec2, f64> {
        let [longest, shortest] = PART_LENGTHS;
        let (mut v, mut done, mut part) = (DVec2::ZERO, 0.0_f64, longest);
        while done < 1.0 {
            let next = (done + part).min(1.0);
            if let Some(found) = self.onward(v, target * next) {
                (v, done, part) = (found, next, (2.0 * part).min(longest));
            } else if part > shortest {
                part *= 0.5;
            } else {
                return Err(done);
            }
        }
        Ok(v)
    }

    /// Follows the point that the map moves to `target`, from a point whose image is near `target`.
    fn onward(&self, from: DVec2, target: DVec2) -> Option<DVec2> {
        let mut v = from;
        for _ in 0..STEPS {
            let step = self.step(v, target);
            v += step;
            if !v.is_finite() {
                return None;
            }
            if step.length() <= 1e-9 * v.length() {
                let found = v + self.step(v, target);
                let is_upright = |test| self.is_upright(from.lerp(found, f64::from(test) / f64::from(TESTS)));
                return (found.is_finite() && (1..=TESTS).all(is_upright)).then_some(found);
            }
        }
        (v == DVec2::ZERO).then_some(v)
    }

    /// Returns a step of Newton's method from `v`.
    fn step(&self, v: DVec2, target: DVec2) -> DVec2 {
        self.jacobian(v).inverse() * (target - self.distorted(v))
    }

    /// Does the same as [`Warp::inverse`] in the steps of `lens.wgsl`, for lenses that were checked.
    pub(super) fn inverse_in_steps(&self, target: DVec2) -> DVec2 {
        (1..=PARTS + LAST_STEPS).fold(DVec2::ZERO, |v, step| {
            let share = (f64::from(step) / f64::from(PARTS)).min(1.0);
            v + self.step(v, target * share)
        })
    }
}
