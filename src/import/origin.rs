//! Origins of scenes from files.

use glam::DVec3;

/// Distance up to which [`Origin::Auto`] keeps the world's origin, in multiples of the file's longest side. At 8 sides
/// f32 still resolves a millionth of a side, as for the farthest corner of a scene at the origin.
const FARTHEST: f64 = 8.0;

/// Origin that a reader gives a scene: see [`Scene::origin`](crate::Scene::origin).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Origin {
    /// The world's origin, unless the coordinates lie more than 8 times their extent away from it. Then it is the
    /// centre of their bounding box, rounded to multiples of a power of ten of at most the extent.
    #[default]
    Auto,
    /// The world's origin.
    World,
    /// This world position.
    At(DVec3),
}

impl Origin {
    /// Returns the origin for coordinates within these bounds.
    pub(crate) fn choose(self, bounds: impl FnOnce() -> Option<(DVec3, DVec3)>) -> DVec3 {
        match self {
            Self::World => DVec3::ZERO,
            Self::At(origin) => origin,
            Self::Auto => bounds().map_or(DVec3::ZERO, |(low, high)| middle_of_far(low, high)),
        }
    }
}

fn middle_of_far(low: DVec3, high: DVec3) -> DVec3 {
    let (extent, middle) = ((high - low).max_element(), low.midpoint(high));
    let distance = middle.abs().max_element();
    if distance <= FARTHEST * extent {
        return DVec3::ZERO;
    }
    // A point has no extent; a millionth of its distance is used instead.
    let step = extent.max(1e-6 * distance).log10().floor();
    let (scale, is_fraction) = (10.0_f64.powf(step.abs()), step < 0.0);
    // Division by a whole number gives the double nearest to the decimal number. Multiplication by a fraction does not.
    if is_fraction { (middle * scale).round() / scale } else { (middle / scale).round() * scale }
}

/// Returns the bounding box of the finite points.
pub(crate) fn bounds_of(points: impl Iterator<Item = DVec3>) -> Option<(DVec3, DVec3)> {
    points.filter(|point| point.is_finite()).fold(None, |bounds: Option<(DVec3, DVec3)>, point| {
        let (low, high) = bounds.unwrap_or((point, point));
        Some((low.min(point), high.max(point)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_files_get_a_short_decimal_origin_and_near_ones_the_worlds() {
        let at = |middle: DVec3, extent: f64| {
            let half = DVec3::new(0.5, 0.3, 0.2) * extent;
            Origin::Auto.choose(|| Some((middle - half, middle + half)))
        };
        assert_eq!(at(DVec3::new(7.9, 0.0, 0.0), 1.0), DVec3::ZERO);
        assert_eq!(at(DVec3::new(8.1, 0.0, 0.0), 1.0), DVec3::new(8.0, 0.0, 0.0));
        assert_eq!(at(DVec3::new(45_123.04, 0.1, 12_456.31), 0.17), DVec3::new(45_123.0, 0.1, 12_456.3));
        assert_eq!(at(DVec3::new(500_012.0, 31.0, -5_400_070.0), 240.0), DVec3::new(500_000.0, 0.0, -5_400_100.0));
        assert_eq!(at(DVec3::new(0.0, 0.0, 3e5), 0.0), DVec3::new(0.0, 0.0, 3e5));
        assert_eq!(Origin::Auto.choose(|| None), DVec3::ZERO);
        assert_eq!(Origin::At(DVec3::ONE).choose(|| None), DVec3::ONE);
        assert_eq!(Origin::World.choose(|| Some((DVec3::ONE, DVec3::ONE))), DVec3::ZERO);
    }

    #[test]
    fn points_that_are_not_finite_are_left_out_of_the_bounds() {
        let points = [DVec3::ONE, DVec3::NAN, DVec3::INFINITY, DVec3::new(3.0, 0.0, 1.0)];
        assert_eq!(bounds_of(points.into_iter()), Some((DVec3::new(1.0, 0.0, 1.0), DVec3::new(3.0, 1.0, 1.0))));
        assert_eq!(bounds_of([DVec3::NAN].into_iter()), None);
    }
}
