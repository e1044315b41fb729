//! The viewing circle of equirectangular pairs, in f64 (DESIGN, section 2).

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec3, Vec3};

use super::{
    Pose, Span,
    frustum::{Field, Sphere},
};

/// Number of steps that find the ray to a point where the circle's radius depends on the elevation.
const STEPS: u32 = 60;

/// Least angle between a ray and a pole, in rows.
pub(crate) const FROM_POLE: f64 = 1.0 / 16.0;

/// The viewing circle of a pose, and the azimuths and elevations of its pictures. Azimuths grow to the right from 0 in
/// the picture's middle. Columns and rows count from the picture's top left corner, with pixel centres at halves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Circle {
    /// Radius of the circle on the horizon: half of the interaxial.
    pub(crate) radius: f64,
    /// Azimuth per column and elevation per row, in radians.
    pub(crate) steps: [f64; 2],
    /// Column of azimuth 0, and row of the horizon.
    pub(crate) middle: [f64; 2],
    /// Number of columns of a full turn, if the picture shows all azimuths.
    pub(crate) turn: Option<f64>,
    /// Elevations in radians between which the radius shrinks to 0. Both are infinite if it does not.
    pub(crate) merge: [f64; 2],
}

/// A ray of an eye of a viewing circle, as coordinates along right, up and forward of the pose, relative to the
/// circle's centre. The direction has length 1 along the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CircleRay {
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3,
}

impl Circle {
    pub(crate) fn of(pose: &Pose, sphere: &Sphere) -> Self {
        let ([width, height], [across, down]) = (pose.size.map(f64::from), sphere.angles);
        Self {
            radius: 0.5 * f64::from(pose.interaxial),
            steps: [across / width, down / height],
            middle: [0.5 * width, 0.5 * height],
            turn: (sphere.projection.span == Span::Full).then_some(TAU / across * width),
            merge: sphere.projection.merge.map_or([f64::INFINITY; 2], |merge| {
                [merge.from, merge.to].map(|degrees| f64::from(degrees).to_radians())
            }),
        }
    }

    pub(crate) fn azimuth(&self, column: f64) -> f64 {
        (column - self.middle[0]) * self.steps[0]
    }

    /// Returns the elevation of a row. It stays away from the poles, where directions have no length along the ground.
    pub(crate) fn elevation(&self, row: f64) -> f64 {
        let most = FRAC_PI_2 - FROM_POLE * self.steps[1];
        ((self.middle[1] - row) * self.steps[1]).clamp(-most, most)
    }

    /// Returns the circle's radius for rays of this elevation.
    pub(crate) fn radius_at(&self, elevation: f64) -> f64 {
        let [from, to] = self.merge;
        let above = elevation.abs();
        if above <= from {
            return self.radius;
        }
        if above >= to { 0.0 } else { self.radius * (FRAC_PI_2 * (above - from) / (to - from)).cos() }
    }

    /// Returns the ray of an eye (-1 left, +1 right) through a point of its picture.
    pub(crate) fn ray(&self, [column, row]: [f64; 2], side: f64) -> CircleRay {
        let (azimuth, elevation) = (self.azimuth(column), self.elevation(row));
        let (sin, cos) = azimuth.sin_cos();
        CircleRay {
            origin: DVec3::new(cos, 0.0, -sin) * (side * self.radius_at(elevation)),
            direction: DVec3::new(sin, elevation.tan(), cos),
        }
    }

    /// Returns the difference of a point's columns in the left and the right picture, for a point at the horizontal
    /// distance `s` in rows of this elevation.
    pub(crate) fn disparity_px(&self, s: f64, elevation: f64) -> f64 {
        2.0 * (self.radius_at(elevation) / s).atan() / self.steps[0]
    }

    /// Projects a point, given as a [`CircleRay`]'s, into an eye's picture. Returns its column, row and horizontal
    /// distance along the ray. The distance is NaN within the circle.
    pub(crate) fn project(&self, point: DVec3, side: f64) -> [f64; 3] {
        let away = point.x.hypot(point.z);
        let distance = |radius: f64| ((away - radius) * (away + radius)).sqrt();
        let radius_seen_from = |radius: f64| self.radius_at((point.y / distance(radius)).atan());
        let mut radius = self.radius;
        if self.merge[0].is_finite() && radius_seen_from(radius) != radius {
            // Larger elevations have smaller radii, and so larger distances and smaller elevations.
            let (mut low, mut high) = (0.0, self.radius);
            for _ in 0..STEPS {
                radius = 0.5 * (low + high);
                if radius_seen_from(radius) > radius { low = radius } else { high = radius }
            }
            radius = 0.5 * (low + high);
        }
        let s = distance(radius);
        let azimuth = point.x.atan2(point.z) - side * (radius / s).atan();
        [self.column(azimuth), self.row((point.y / s).atan()), s]
    }

    /// Returns the column and row of an infinitely distant point, which are the same for both eyes.
    pub(crate) fn project_direction(&self, direction: DVec3) -> [f64; 2] {
        let azimuth = direction.x.atan2(direction.z);
        [self.column(azimuth), self.row(direction.y.atan2(direction.x.hypot(direction.z)))]
    }

    fn column(&self, azimuth: f64) -> f64 {
        let column = self.middle[0] + azimuth / self.steps[0];
        self.turn.map_or(column, |turn| column.rem_euclid(turn))
    }

    fn row(&self, elevation: f64) -> f64 {
        self.middle[1] - elevation / self.steps[1]
    }
}

impl Pose {
    /// Returns the angles of a column and of a row of an equirectangular picture in radians; `None` for planar
    /// pictures. A disparity in columns times the first angle is the angle at which both eyes see a point from its
    /// distance.
    pub fn radians_per_pixel(&self) -> Option<[f64; 2]> {
        self.circle().map(|circle| circle.steps)
    }

    /// Returns the viewing circle of an equirectangular pose.
    pub(crate) fn circle(&self) -> Option<Circle> {
        match self.field {
            Field::Screen(_) | Field::Lenses(_) => None,
            Field::Sphere(sphere) => Some(Circle::of(self, &sphere)),
        }
    }

    /// Returns a vector of this pose's axes as a vector of the world's.
    pub(crate) fn in_world(&self, vector: DVec3) -> DVec3 {
        let [right, up, forward] = [self.right, self.up, self.forward].map(Vec3::as_dvec3);
        forward * vector.z + right * vector.x + up * vector.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Equirectangular, PoleMerge, Projection, StereoCamera, random::Random};

    fn circle(span: Span, merge: Option<PoleMerge>, interaxial: f32) -> Circle {
        let camera = StereoCamera::look_at(DVec3::ZERO, DVec3::X).size(720, 360).interaxial(interaxial);
        camera
            .projection(Projection::Equirectangular(Equirectangular { span, merge }))
            .pose()
            .unwrap()
            .circle()
            .unwrap()
    }

    /// The right eye sees a point at azimuth φ and distance D along the ground at `φ - asin(r / D)`, the left one at
    /// `φ + asin(r / D)`, and both in one row, at the horizontal distance `√(D² - r²)`.
    #[test]
    fn a_point_is_in_one_row_and_as_far_from_both_eyes() {
        let mut random = Random::new(11);
        let circle = circle(Span::Full, None, 0.5);
        for _ in 0..1000 {
            let point = random.point(4.0).as_dvec3();
            let away = point.x.hypot(point.z);
            if away < 0.3 {
                continue;
            }
            let [[left, row, s], [right, other_row, other_s]] = [-1.0, 1.0].map(|side| circle.project(point, side));
            assert_eq!((row, s), (other_row, other_s));
            let (azimuth, touching) = (point.x.atan2(point.z), (0.25 / away).asin());
            let column = |azimuth: f64| (360.0 + azimuth / TAU * 720.0).rem_euclid(720.0);
            assert!(
                (left - column(azimuth + touching)).abs() < 1e-9 && (right - column(azimuth - touching)).abs() < 1e-9
            );
            assert!((s - (away * away - 0.0625).sqrt()).abs() < 1e-12);
            let apart = (left - right).rem_euclid(720.0);
            assert!((apart - circle.disparity_px(s, 0.0)).abs() < 1e-9, "{apart}");
        }
    }

    #[test]
    fn rays_meet_the_points_that_project_to_their_pixels() {
        let mut random = Random::new(12);
        for merge in [None, Some(PoleMerge::default()), Some(PoleMerge { from: 0.0, to: 90.0 })] {
            let circle = circle(Span::Full, merge, 0.8);
            for _ in 0..1000 {
                let place = [random.between(0.0, 720.0).into(), random.between(1.0, 359.0).into()];
                let (side, s) = (if random.unit() < 0.5 { -1.0 } else { 1.0 }, f64::from(random.between(0.01, 9.0)));
                let CircleRay { origin, direction } = circle.ray(place, side);
                let [column, row, found] = circle.project(origin + direction * s, side);
                let off = (column - place[0]).abs().max((row - place[1]).abs());
                assert!(off < 1e-6 && (found - s).abs() < 1e-6 * s.max(1.0), "{place:?} {s}: {column} {row} {found}");
            }
        }
    }

    #[test]
    fn eyes_merge_between_two_elevations() {
        let circle = circle(Span::Half, Some(PoleMerge::default()), 2.0);
        let radius = |degrees: f64| circle.radius_at(degrees.to_radians());
        assert_eq!([0.0, 60.0, -60.0, 75.1, -90.0].map(radius), [1.0, 1.0, 1.0, 0.0, 0.0]);
        assert!((radius(67.5) - 0.5_f64.sqrt()).abs() < 1e-12 && (radius(-65.0) - 0.75_f64.sqrt()).abs() < 1e-12);
    }
}
