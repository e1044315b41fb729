//! Where the other eye sees a point of a line of sight.

use glam::{DMat2, DVec2, DVec3};

use super::{
    flow::{SAME_POINT, shorter_way},
    layers::{LayerClass, Layering},
    occlusion::{Pixels, SAME_POINT_PX},
    sight::{Bend, Onward, Place, Seen, Sight, State},
};
use crate::{Error, Pose, Renderer, view::camera::Projector};

/// Maximum number of Newton's steps.
const STEPS: usize = 16;
/// Distance in pixels over which derivatives are taken.
const DELTA: f64 = 1.0 / 64.0;
/// A line has reached a point that it passes at this distance, in pixels at the line's length.
const REACHED_PX: f64 = 1e-5;
/// Limits of the length of a step in pixels. A search that needs a shorter one has failed.
const LONGEST_STEP: f64 = 32.0;
const SHORTEST_STEP: f64 = 1e-3;

/// A line of sight of a pixel.
pub(super) struct Line {
    pub(super) pixel: usize,
    /// Column and row of the pixel's centre.
    pub(super) place: [f64; 2],
    /// Length of the camera ray's direction.
    pub(super) scale: f64,
    pub(super) sight: Sight,
    /// The bends so far, and the surfaces that they are at.
    pub(super) bends: Vec<(Bend, Seen)>,
}

impl Line {
    /// Returns the depth of the surface that the line is at, or of its image on the pixel's ray.
    pub(super) fn depth(&self, seen: &Seen) -> f64 {
        if self.bends.is_empty() { seen.t } else { seen.distance / self.scale }
    }

    fn is_by_plane_mirrors(&self) -> bool {
        self.bends.iter().all(|(bend, seen)| *bend == Bend::Reflected && seen.is_flat())
    }
}

/// Where the other eye sees a point.
#[derive(Clone, Copy)]
pub(super) struct Counterpart {
    /// Column and row in the left picture minus those in the right one.
    pub(super) apart: [f64; 2],
    pub(super) class: LayerClass,
}

/// The other eye of a pair.
pub(super) struct OtherEye<'a> {
    renderer: &'a Renderer,
    scene: Place<'a>,
    pose: &'a Pose,
    /// Side of the eye whose lines are given: -1 for the left one.
    side: f64,
    layering: &'a Layering,
    pixels: Pixels,
    projector: Projector,
    turn: Option<f64>,
}

/// A search for the line of sight of the other eye that reaches a point by way of the same surfaces.
struct Search<'a> {
    line: &'a Line,
    seen: Seen,
    /// Axes across the last leg.
    across: [DVec3; 2],
    /// Distance from the point at which the search ends, in world units.
    near: f64,
    place: DVec2,
    /// The last step.
    step: DVec2,
    /// Where to start again if the search fails.
    second_start: Option<DVec2>,
    found: Option<Leg>,
    has_failed: bool,
}

/// The last leg of a line of sight from the other eye.
#[derive(Clone, Copy)]
struct Leg {
    sight: Sight,
    /// Whether the line passes further see-through surfaces before the leg.
    is_through: bool,
}

impl<'a> OtherEye<'a> {
    pub(super) fn new(
        renderer: &'a Renderer,
        scene: Place<'a>,
        pose: &'a Pose,
        side: f64,
        layering: &'a Layering,
    ) -> Self {
        let (pixels, projector) = (Pixels::of(pose, -0.5 * side), pose.projector(-side as f32));
        let turn = pose.circle().and_then(|circle| circle.turn);
        Self { renderer, scene, pose, side, layering, pixels, projector, turn }
    }

    /// Returns where this eye sees the surfaces that lines of the given pixels are at.
    pub(super) async fn counterparts(&self, own: &Pixels, lines: &[Line]) -> Result<Vec<Counterpart>, Error> {
        let none = Counterpart { apart: [f64::NAN; 2], class: LayerClass::Unknown };
        let mut found = vec![none; lines.len()];
        let is_straight = |index: &usize| lines[*index].bends.is_empty();
        let (straight, bent): (Vec<_>, Vec<_>) = (0..lines.len()).partition(is_straight);
        let of = |indices: &[usize]| Vec::from_iter(indices.iter().map(|&index| &lines[index]));
        let of_straight = self.of_straight(own, &of(&straight)).await?;
        let of_bent = self.of_bent(own, &of(&bent)).await?;
        for (index, counterpart) in straight.into_iter().zip(of_straight).chain(bent.into_iter().zip(of_bent)) {
            found[index] = counterpart;
        }
        Ok(found)
    }

    async fn of_straight(&self, own: &Pixels, lines: &[&Line]) -> Result<Vec<Counterpart>, Error> {
        let disparity = self.pose.disparities_of_eye(self.side);
        let nominal = self.pose.disparities_of_rows();
        let points = Vec::from_iter(lines.iter().map(|line| {
            let pixel = line.place.map(|place| place as usize);
            let depth = if let State::At(seen) = line.sight.state { seen.t as f32 } else { f32::INFINITY };
            (pixel, depth)
        }));
        let sights = points.iter().map(|&([column, row], depth)| {
            let ray = own.ray_of_other(column, row, depth);
            Sight::new(self.scene.scene, (ray.origin, ray.direction.as_dvec3()))
        });
        let is_reached = |index: usize, seen: &Seen| {
            let ([_, row], depth) = points[index];
            nominal(row, seen.t as f32) <= nominal(row, depth) + SAME_POINT_PX
        };
        let classes = self.classes(sights.collect(), is_reached).await?;
        Ok(Vec::from_iter(points.iter().zip(classes).map(|(&(pixel, depth), class)| {
            let apart = disparity(pixel, depth);
            let place = [pixel[0] as f64 + 0.5 + self.side * apart, pixel[1] as f64 + 0.5];
            Counterpart { apart: [apart, 0.0], class: if self.shows(place) { class } else { LayerClass::OutOfFrame } }
        })))
    }

    /// Returns whether the picture contains a place.
    fn shows(&self, [column, row]: [f64; 2]) -> bool {
        let [width, height] = self.pose.size.map(f64::from);
        (0.0..width).contains(&self.pose.in_turn(column)) && (0.0..height).contains(&row)
    }

    /// Follows lines of sight until they reach a point or meet what hides it.
    async fn classes(
        &self,
        mut sights: Vec<Sight>,
        is_reached: impl Fn(usize, &Seen) -> bool,
    ) -> Result<Vec<LayerClass>, Error> {
        let mut classes = vec![LayerClass::Visible; sights.len()];
        let mut open = Vec::from_iter(0..sights.len());
        while !open.is_empty() {
            self.renderer.advance(self.scene, sights.iter_mut().filter(|sight| sight.is_open()).collect()).await?;
            open.retain(|&index| {
                let State::At(seen) = sights[index].state else { return false };
                if is_reached(index, &seen) {
                    return false;
                }
                let onward = seen.onward(self.scene.scene, &sights[index], self.layering);
                classes[index] = match onward {
                    Onward::Straight => LayerClass::Through,
                    Onward::Bends(Bend::Refracted(_)) => LayerClass::Unknown,
                    Onward::Ends | Onward::Bends(Bend::Reflected) => LayerClass::Hidden,
                };
                sights[index].continue_by(onward);
                onward == Onward::Straight
            });
            // Lines that have ended are not followed.
            for (index, sight) in sights.iter_mut().enumerate() {
                if sight.is_open() && classes[index] != LayerClass::Through {
                    sight.state = State::Gone;
                }
            }
        }
        Ok(classes)
    }

    async fn of_bent(&self, own: &Pixels, lines: &[&Line]) -> Result<Vec<Counterpart>, Error> {
        let mut searches = Vec::from_iter(lines.iter().filter_map(|line| self.search(own, line)));
        for _ in 0..STEPS {
            self.step(&mut searches).await?;
        }
        let found = Vec::from_iter(searches.iter().filter_map(|search| Some((search, search.found?))));
        let sights = found.iter().map(|(_, leg)| leg.sight).collect();
        let is_reached = |index: usize, seen: &Seen| {
            let (search, leg) = &found[index];
            let length = leg.sight.origin.distance(search.seen.position);
            seen.primitive == search.seen.primitive
                || seen.position.distance(leg.sight.origin) >= length * (1.0 - SAME_POINT)
        };
        let classes = self.classes(sights, is_reached).await?;
        let mut classes = found.iter().zip(classes).map(|((_, leg), class)| match class {
            LayerClass::Visible if leg.is_through => LayerClass::Through,
            class => class,
        });
        Ok(Vec::from_iter(searches.iter().map(|search| {
            let class = if search.found.is_some() { classes.next() } else { None };
            self.counterpart(search, class)
        })))
    }

    /// Starts a search at the point's image in plane mirrors: a point on the pixel's ray, at the line's whole length.
    /// Curved surfaces may show it nearer to the place of the first bend, which is the second start.
    fn search<'l>(&self, own: &Pixels, line: &'l Line) -> Option<Search<'l>> {
        let State::At(seen) = line.sight.state else { return None };
        let (origin, direction) = own.ray_through(line.place);
        let [column, row, depth] = self.projector.project(origin + direction.normalize() * seen.distance);
        let bend = line.bends.first()?.1.position + self.scene.scene.origin();
        let [bend_column, bend_row, bend_depth] = self.projector.project(bend);
        let beside = own.ray_through([line.place[0] + 1.0, line.place[1]]).1;
        let angle = direction.normalize().distance(beside.normalize());
        let [u, v] = <[DVec3; 2]>::from(line.sight.direction.normalize().any_orthonormal_pair());
        Some(Search {
            line,
            seen,
            across: [u, v],
            near: REACHED_PX * angle * seen.distance,
            place: DVec2::new(column, row),
            step: DVec2::ZERO,
            second_start: (bend_depth > 0.0 && !line.is_by_plane_mirrors())
                .then_some(DVec2::new(bend_column, bend_row)),
            found: None,
            has_failed: depth.is_nan() || depth <= 0.0,
        })
    }

    /// Takes one step of Newton's method in all searches that go on.
    async fn step(&self, searches: &mut [Search<'_>]) -> Result<(), Error> {
        let mut going = Vec::from_iter(searches.iter_mut().filter(|search| search.goes_on()));
        let legs = self.legs(&going, DVec2::ZERO).await?;
        for (search, leg) in going.iter_mut().zip(&legs) {
            let misses = leg.and_then(|leg| search.misses_by(&leg));
            match (misses, leg) {
                (Some(misses), Some(leg)) if misses.length() <= search.near => search.found = Some(*leg),
                (Some(_), _) => {}
                (None, _) => search.step_back(),
            }
        }
        let keeps = |(search, leg): &(&mut Search<'_>, Option<Leg>)| {
            search.goes_on() && leg.is_some_and(|leg| search.misses_by(&leg).is_some())
        };
        let (mut going, legs): (Vec<_>, Vec<_>) = going.into_iter().zip(legs).filter(keeps).unzip();
        let right = self.legs(&going, DVec2::new(DELTA, 0.0)).await?;
        let down = self.legs(&going, DVec2::new(0.0, DELTA)).await?;
        for (index, search) in going.iter_mut().enumerate() {
            let miss = |leg: &Option<Leg>| leg.as_ref().and_then(|leg| search.misses_by(leg));
            let derived = (miss(&legs[index]), miss(&right[index]), miss(&down[index]));
            let (Some(here), Some(right), Some(down)) = derived else {
                search.start_again();
                continue;
            };
            let slopes = DMat2::from_cols((right - here) / DELTA, (down - here) / DELTA);
            search.go_by(-(slopes.inverse() * here));
        }
        Ok(())
    }

    /// Follows the lines of sight beside the searches' places past the searches' bends.
    async fn legs(&self, searches: &[&mut Search<'_>], aside: DVec2) -> Result<Vec<Option<Leg>>, Error> {
        let scene = self.scene.scene;
        let begin = |search: &&mut Search<'_>| {
            let ray = self.pixels.ray_through((search.place + aside).to_array());
            Leg { sight: Sight::new(scene, ray), is_through: false }
        };
        let mut legs = Vec::from_iter(searches.iter().map(|search| Some(begin(search))));
        loop {
            let going = legs.iter_mut().zip(searches).filter_map(|(leg, search)| {
                let sight = &mut leg.as_mut()?.sight;
                ((sight.bends as usize) < search.line.bends.len()).then_some(sight)
            });
            let going = Vec::from_iter(going);
            if going.is_empty() {
                return Ok(legs);
            }
            self.renderer.advance(self.scene, going).await?;
            for (leg, search) in legs.iter_mut().zip(searches) {
                let Some(found) = leg else { continue };
                let bends = &search.line.bends;
                let Some((bend, at)) = bends.get(found.sight.bends as usize) else { continue };
                *leg = self.bent_alike(*found, *bend, at);
            }
        }
    }

    /// Continues a line beyond its surface, if that is see-through or bends lines like `at`.
    fn bent_alike(&self, mut leg: Leg, bend: Bend, at: &Seen) -> Option<Leg> {
        let State::At(seen) = leg.sight.state else { return None };
        let onward = seen.onward(self.scene.scene, &leg.sight, self.layering);
        match onward {
            Onward::Straight => leg.is_through = true,
            Onward::Bends(found) if found == bend && seen.surface.object == at.surface.object => {}
            Onward::Bends(_) | Onward::Ends => return None,
        }
        leg.sight.continue_by(onward);
        Some(leg)
    }

    fn counterpart(&self, search: &Search<'_>, class: Option<LayerClass>) -> Counterpart {
        let place = search.place.to_array();
        let class = match class {
            _ if !self.shows(place) => LayerClass::OutOfFrame,
            Some(class) => class,
            None if search.has_failed && search.line.is_by_plane_mirrors() => LayerClass::Hidden,
            None => return Counterpart { apart: [f64::NAN; 2], class: LayerClass::Unknown },
        };
        let [x, y] = [0, 1].map(|axis| self.side * (place[axis] - search.line.place[axis]));
        Counterpart { apart: [shorter_way(self.turn, x), y], class }
    }
}

impl Search<'_> {
    fn goes_on(&self) -> bool {
        self.found.is_none() && !self.has_failed
    }

    fn go_by(&mut self, step: DVec2) {
        if step.is_finite() {
            self.step = step.clamp_length_max(LONGEST_STEP);
            self.place += self.step;
        } else {
            self.start_again();
        }
    }

    /// Halves a step after which the line met other surfaces.
    fn step_back(&mut self) {
        self.step *= 0.5;
        self.place -= self.step;
        if self.step.length() < SHORTEST_STEP {
            self.start_again();
        }
    }

    fn start_again(&mut self) {
        match self.second_start.take() {
            Some(start) => (self.place, self.step) = (start, DVec2::ZERO),
            None => self.has_failed = true,
        }
    }

    /// Returns by how much a leg misses the point, across the leg. `None` if the point is behind the leg's start.
    fn misses_by(&self, leg: &Leg) -> Option<DVec2> {
        let to_point = self.seen.position - leg.sight.origin;
        let along = leg.sight.direction;
        let ahead = to_point.dot(along);
        let aside = to_point - along * ahead;
        (ahead > 0.0).then(|| DVec2::from_array(self.across.map(|axis| axis.dot(aside))))
    }
}
