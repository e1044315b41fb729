//! Splits the polygons of faces into triangles.
//!
//! A split is correct if every triangle turns the way the polygon does. Then the triangles cover each point as often as
//! the polygon winds around it. In a simple polygon this is once inside and never outside. The fan from the first
//! corner is used if it is correct, as for every convex polygon. Otherwise ears are clipped.

use glam::{DVec2, DVec3, Vec3};

use super::ears::cut_ears;

/// Widths below this share of a face's size count as rounding. A fan may wrongly cover areas of this width.
const ROUNDING: f64 = 1e-5;
/// Largest thickness of a flat face along its normal, as a share of its size. Thicker faces have no clear split.
const FLAT: f64 = 0.2;
/// Largest number of corners for ear clipping, which then takes seconds at worst.
const MOST_CORNERS: usize = 1 << 17;

/// A split of a face of n corners into n - 2 triangles.
pub(crate) enum Split {
    /// A fan from the first corner.
    Fan,
    /// These triangles, as corner indices.
    Ears(Vec<[usize; 3]>),
    /// No split was found: the face crosses itself, is far from flat, or is too complex.
    Unknown,
}

/// Splits a face of at least three corners.
pub(crate) fn split(corners: &[Vec3]) -> Split {
    let Some((first, others)) = corners.split_first().filter(|(_, others)| others.len() > 2) else { return Split::Fan };
    let first = first.as_dvec3();
    let others = || others.iter().map(|corner| corner.as_dvec3() - first);
    let size = others().fold(0.0, |size: f64, corner| size.max(corner.abs().max_element()));

    // Newell's normal is the sum of the fan's normals.
    let (mut normal, mut areas) = (DVec3::ZERO, 0.0);
    for (b, c) in others().zip(others().skip(1)) {
        normal += b.cross(c);
        areas += b.cross(c).length();
    }
    if areas <= ROUNDING * size * size {
        return Split::Fan; // a line or a point
    }
    let Some(unit) = normal.try_normalize() else { return Split::Unknown };
    let heights = others()
        .map(|corner| corner.dot(unit))
        .fold([0.0, 0.0], |[low, high]: [f64; 2], height| [low.min(height), high.max(height)]);
    if heights[1] - heights[0] > FLAT * size {
        return Split::Unknown;
    }
    // Dropping the normal's longest component keeps all signs, and keeps coordinates exact.
    let flat = |corner: DVec3| {
        let longest = normal.abs().max_position();
        let [u, v] = [1, 2].map(|step| corner[(longest + step) % 3]);
        if normal[longest] > 0.0 { DVec2::new(u, v) } else { DVec2::new(v, u) }
    };
    if is_fan(others().map(flat), ROUNDING * size) {
        return Split::Fan;
    }
    if corners.len() > MOST_CORNERS {
        return Split::Unknown;
    }
    let points: Vec<DVec2> = std::iter::once(DVec2::ZERO).chain(others().map(flat)).collect();
    cut_ears(&points).map_or(Split::Unknown, Split::Ears)
}

/// Returns whether the corners go around the first one, at the origin, without turning back by more than rounding.
fn is_fan(corners: impl Iterator<Item = DVec2>, rounding: f64) -> bool {
    let mut front = DVec2::ZERO;
    for corner in corners {
        let area = front.perp_dot(corner);
        if area < -rounding * front.length().max(corner.length()) {
            return false;
        }
        if area >= 0.0 && corner.length() > rounding {
            front = corner;
        }
    }
    true
}
