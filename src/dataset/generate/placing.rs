//! Places objects so that they do not overlap.

use glam::{Affine3A, DVec3, Vec3};

use super::form::Form;

/// The triangles of a placed object, in the world.
pub(super) struct Solid {
    pub(super) low: Vec3,
    pub(super) high: Vec3,
    triangles: Vec<[Vec3; 3]>,
}

/// The objects of a scene so far.
#[derive(Default)]
pub(super) struct Placed {
    pub(super) solids: Vec<Solid>,
}

impl Solid {
    pub(super) fn of(form: &Form, transform: &Affine3A) -> Self {
        let at: Vec<Vec3> = form.positions.iter().map(|&at| transform.transform_point3(at)).collect();
        let triangles = form.faces.iter().map(|face| face.corners.map(|corner| at[corner as usize])).collect();
        let low = at.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = at.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        Self { low, high, triangles }
    }

    /// Returns whether the boxes overlap.
    fn is_near(&self, other: &Self) -> bool {
        self.low.cmplt(other.high).all() && other.low.cmplt(self.high).all()
    }

    /// Returns whether surfaces intersect, or one of the objects is inside the other. Bounds are compared first.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        self.is_near(other)
            && (self.intersects(other) || self.holds_a_corner_of(other) || other.holds_a_corner_of(self))
    }

    fn intersects(&self, other: &Self) -> bool {
        let (low, high) = (self.low.max(other.low), self.high.min(other.high));
        let [mine, theirs] = [self, other].map(|solid| solid.within(low, high));
        let mut first = 0;
        for (span, triangle) in &mine {
            while first < theirs.len() && theirs[first].0[1] < span[0] && theirs[first].0[1] < low.x {
                first += 1;
            }
            let candidates = theirs[first..].iter().take_while(|(other, _)| other[0] <= span[1]);
            if candidates.filter(|(other, _)| other[1] >= span[0]).any(|(_, other)| cross(triangle, other)) {
                return true;
            }
        }
        false
    }

    /// Returns the triangles that reach into a box, with their extent along x, by its lower end.
    fn within(&self, low: Vec3, high: Vec3) -> Vec<([f32; 2], [Vec3; 3])> {
        let mut found: Vec<_> = self
            .triangles
            .iter()
            .filter(|[a, b, c]| a.min(*b).min(*c).cmple(high).all() && a.max(*b).max(*c).cmpge(low).all())
            .map(|&[a, b, c]| ([a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x)], [a, b, c]))
            .collect();
        found.sort_by(|one, other| one.0[0].total_cmp(&other.0[0]));
        found
    }

    /// Returns whether a corner of the other object is inside this one, by the number of surfaces on a ray.
    fn holds_a_corner_of(&self, other: &Self) -> bool {
        let Some(&[corner, ..]) = other.triangles.first() else { return false };
        if corner.cmplt(self.low).any() || corner.cmpgt(self.high).any() {
            return false;
        }
        // The direction is along no edge of usual objects.
        let end = corner + Vec3::new(0.412, 0.777, 0.476) * 2.0 * (self.high - self.low).length();
        self.triangles.iter().filter(|triangle| pierces([corner, end], triangle)).count() % 2 == 1
    }

    /// Returns whether a point is within a distance of its box.
    pub(super) fn is_within(&self, point: Vec3, distance: f32) -> bool {
        point.clamp(self.low, self.high).distance(point) < distance
    }
}

impl Placed {
    /// Returns whether an object overlaps none of the others.
    pub(super) fn is_free(&self, solid: &Solid) -> bool {
        !self.solids.iter().any(|other| other.overlaps(solid))
    }
}

/// Returns whether two triangles intersect. Those that only touch, or lie in one plane, do not.
fn cross(one: &[Vec3; 3], other: &[Vec3; 3]) -> bool {
    let ranges = |[a, b, c]: &[Vec3; 3]| (a.min(*b).min(*c), a.max(*b).max(*c));
    let ((low, high), (other_low, other_high)) = (ranges(one), ranges(other));
    if low.cmpgt(other_high).any() || other_low.cmpgt(high).any() {
        return false;
    }
    let edges = |[a, b, c]: [Vec3; 3]| [[a, b], [b, c], [c, a]];
    edges(*one).iter().any(|edge| pierces(*edge, other)) || edges(*other).iter().any(|edge| pierces(*edge, one))
}

/// Returns whether a segment passes through a triangle (Möller & Trumbore 1997). Its ends do not count.
fn pierces([from, to]: [Vec3; 2], triangle: &[Vec3; 3]) -> bool {
    /// Share of the segment at each end, and of the triangle at its rim, that does not count.
    const RIM: f64 = 1e-4;
    let [a, b, c] = triangle.map(Vec3::as_dvec3);
    let (from, along) = (from.as_dvec3(), (to - from).as_dvec3());
    let (first, second) = (b - a, c - a);
    let across: DVec3 = along.cross(second);
    let determinant = first.dot(across);
    if determinant.abs() < 1e-14 {
        return false;
    }
    let offset = from - a;
    let u = offset.dot(across) / determinant;
    let turned = offset.cross(first);
    let v = along.dot(turned) / determinant;
    let t = second.dot(turned) / determinant;
    u > RIM && v > RIM && u + v < 1.0 - RIM && t > RIM && t < 1.0 - RIM
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> Form {
        let mut frame = Form::default();
        for (low, high) in [
            ([-1.0, 0.0, -0.1], [-0.8, 2.0, 0.1]),
            ([0.8, 0.0, -0.1], [1.0, 2.0, 0.1]),
            ([-1.0, 2.0, -0.1], [1.0, 2.2, 0.1]),
        ] {
            frame.cuboid(Vec3::from(low), Vec3::from(high), 0);
        }
        frame
    }

    fn ball(radius: f32) -> Form {
        let mut ball = Form::default();
        ball.body(Vec3::ZERO, [24, 12], |_| radius, 0);
        ball
    }

    fn at(form: &Form, x: f32, y: f32, z: f32) -> Solid {
        Solid::of(form, &Affine3A::from_translation(Vec3::new(x, y, z)))
    }

    #[test]
    fn an_object_within_the_bounds_of_another_may_be_free() {
        let placed = Placed { solids: vec![at(&frame(), 0.0, 0.0, 0.0)] };
        let inside = at(&ball(0.5), 0.0, 1.0, 0.0);
        assert!(inside.is_near(&placed.solids[0]), "the bounds must overlap");
        assert!(placed.is_free(&inside), "the ball is in the frame's opening");
        assert!(!placed.is_free(&at(&ball(0.5), 0.5, 1.0, 0.0)), "the ball meets a post");
        assert!(!placed.is_free(&at(&ball(0.5), 0.0, 1.7, 0.0)), "the ball meets the lintel");
        assert!(placed.is_free(&at(&ball(0.5), 0.0, 1.0, 3.0)), "the bounds are apart");
    }

    #[test]
    fn an_object_inside_another_overlaps_although_no_surfaces_meet() {
        let placed = Placed { solids: vec![at(&ball(1.0), 0.0, 0.0, 0.0)] };
        assert!(!placed.is_free(&at(&ball(0.2), 0.1, 0.0, 0.0)));
        let placed = Placed { solids: vec![at(&ball(0.2), 0.1, 0.0, 0.0)] };
        assert!(!placed.is_free(&at(&ball(1.0), 0.0, 0.0, 0.0)));
    }

    #[test]
    fn objects_that_stand_on_each_other_do_not_overlap() {
        let mut table = Form::default();
        table.block(Vec3::new(1.0, 0.5, 1.0), 0.0, 0);
        let mut cup = Form::default();
        cup.cylinder(0.05, [0.0, 0.1], 16, 0);
        let placed = Placed { solids: vec![at(&table, 0.0, 0.0, 0.0)] };
        assert!(placed.is_free(&at(&cup, 0.2, 0.5, 0.1)));
        assert!(!placed.is_free(&at(&cup, 0.2, 0.48, 0.1)));
    }
}
