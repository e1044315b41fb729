//! Triangle forms under construction, with texture coordinates in metres.
//!
//! The shapes of built-in scenes (`src/scene/builtin/shapes.rs`) have no texture coordinates, and no shared vertices.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::materials::Paint;
use crate::Mesh;

/// Cosine of the largest angle between faces that are shaded as one smooth surface.
const CREASE: f32 = 0.7;

/// A triangle of a form.
#[derive(Clone, Copy)]
pub(super) struct Face {
    pub(super) corners: [u32; 3],
    /// Normals at the corners, or zeros for a flat face.
    pub(super) normals: [Vec3; 3],
    /// Texture coordinates in metres.
    pub(super) uv: [Vec2; 3],
    /// Index of its paint.
    pub(super) slot: u16,
}

/// A horizontal rectangle on which other objects can stand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Top {
    pub(super) low: Vec3,
    pub(super) high: Vec3,
    /// Free height above, in metres.
    pub(super) room: f32,
}

/// An object in its own frame: y is up, and it stands on the plane y = 0. Lengths are in metres.
#[derive(Clone, Default)]
pub(super) struct Form {
    pub(super) positions: Vec<Vec3>,
    pub(super) faces: Vec<Face>,
    pub(super) tops: Vec<Top>,
    /// Colours at the corners of each face, or empty.
    pub(super) colors: Vec<[Vec3; 3]>,
}

impl Form {
    /// Adds a triangle, unless two of its corners coincide.
    fn face(&mut self, corners: [u32; 3], uv: [Vec2; 3], slot: u16) {
        let [a, b, c] = corners.map(|corner| self.positions[corner as usize]);
        if (b - a).cross(c - a).length_squared() > 1e-16 {
            self.faces.push(Face { corners, normals: [Vec3::ZERO; 3], uv, slot });
        }
    }

    fn point(&mut self, at: Vec3) -> u32 {
        self.positions.push(at);
        self.positions.len() as u32 - 1
    }

    /// Adds two flat triangles. Corners are in order around the quad, counter-clockwise as seen from the front.
    pub(super) fn quad(&mut self, corners: [Vec3; 4], slot: u16) {
        let [a, b, _, d] = corners;
        let (width, height) = (a.distance(b), a.distance(d));
        // Parts at different places show different pieces of a texture.
        let start = Vec2::new(a.x + a.z, a.y - 0.3 * a.z);
        let uv = [Vec2::ZERO, Vec2::new(width, 0.0), Vec2::new(width, height), Vec2::new(0.0, height)];
        self.quad_with(corners, uv.map(|at| at + start), slot);
    }

    /// Adds a quad with texture coordinates in metres.
    pub(super) fn quad_with(&mut self, corners: [Vec3; 4], uv: [Vec2; 4], slot: u16) {
        let [a, b, c, d] = corners.map(|corner| self.point(corner));
        self.face([a, b, c], [uv[0], uv[1], uv[2]], slot);
        self.face([a, c, d], [uv[0], uv[2], uv[3]], slot);
    }

    /// Adds a box along the axes.
    pub(super) fn cuboid(&mut self, low: Vec3, high: Vec3, slot: u16) {
        let corner = |bits: usize| {
            let pick = |axis: usize| if bits >> axis & 1 == 0 { low[axis] } else { high[axis] };
            Vec3::new(pick(0), pick(1), pick(2))
        };
        for sides in [[0, 1, 5, 4], [6, 7, 3, 2], [1, 0, 2, 3], [4, 5, 7, 6], [0, 4, 6, 2], [5, 1, 3, 7]] {
            self.quad(sides.map(corner), slot);
        }
    }

    /// Adds a box of this size, centred on the y axis, which stands at the height `y`.
    pub(super) fn block(&mut self, size: Vec3, y: f32, slot: u16) {
        let half = Vec3::new(0.5 * size.x, 0.0, 0.5 * size.z);
        self.cuboid(Vec3::Y * y - half, Vec3::Y * (y + size.y) + half, slot);
    }

    /// Adds a smooth surface of `columns` by `rows` patches. `point(s, t)` returns a position for s and t from 0 to 1.
    /// A closed sheet joins its last column to its first.
    pub(super) fn sheet(
        &mut self,
        [columns, rows]: [usize; 2],
        is_closed: bool,
        size: Vec2,
        point: impl Fn(f32, f32) -> Vec3,
        slot: u16,
    ) {
        let across = if is_closed { columns } else { columns + 1 };
        let first = self.positions.len() as u32;
        for row in 0..=rows {
            for column in 0..across {
                self.positions.push(point(column as f32 / columns as f32, row as f32 / rows as f32));
            }
        }
        let begin = self.faces.len();
        for row in 0..rows {
            for column in 0..columns {
                let at = |c: usize, r: usize| first + ((row + r) * across + (column + c) % across) as u32;
                let uv = |c: usize, r: usize| {
                    size * Vec2::new((column + c) as f32 / columns as f32, (row + r) as f32 / rows as f32)
                };
                self.face([at(0, 0), at(1, 0), at(1, 1)], [uv(0, 0), uv(1, 0), uv(1, 1)], slot);
                self.face([at(0, 0), at(1, 1), at(0, 1)], [uv(0, 0), uv(1, 1), uv(0, 1)], slot);
            }
        }
        self.smooth(begin);
    }

    /// Gives the faces from `begin` on smooth normals, by their shared vertices.
    fn smooth(&mut self, begin: usize) {
        let of_face = |face: &Face| {
            let [a, b, c] = face.corners.map(|corner| self.positions[corner as usize]);
            (b - a).cross(c - a)
        };
        let first = self.faces[begin..].iter().flat_map(|face| face.corners).min().unwrap_or(0);
        let mut sums = vec![Vec3::ZERO; self.positions.len() - first as usize];
        for face in &self.faces[begin..] {
            let normal = of_face(face);
            face.corners.iter().for_each(|corner| sums[(corner - first) as usize] += normal);
        }
        let normals: Vec<Vec3> = self.faces[begin..].iter().map(|face| of_face(face).normalize_or_zero()).collect();
        for (face, own) in self.faces[begin..].iter_mut().zip(normals) {
            let smooth = face.corners.map(|corner| sums[(corner - first) as usize].normalize_or_zero());
            face.normals = smooth.map(|normal| if normal.dot(own) > CREASE { normal } else { own });
        }
    }

    /// Adds a surface of revolution about the y axis. Each run is a line of points (radius, height) with smooth
    /// shading; creases are between runs. The outside is to the right of the line's direction, such as upwards.
    pub(super) fn lathe(&mut self, runs: &[Vec<Vec2>], around: usize, slot: u16) {
        let widest = runs.iter().flatten().fold(0.0_f32, |widest, at| widest.max(at.x));
        let mut from = 0.0;
        for run in runs.iter().filter(|run| run.len() > 1) {
            let length: f32 = run.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
            let rows = run.len() - 1;
            let point = |s: f32, t: f32| {
                let at = run[((t * rows as f32).round() as usize).min(rows)];
                let (sin, cos) = (TAU * s).sin_cos();
                Vec3::new(at.x * cos, at.y, -at.x * sin)
            };
            let begin = self.faces.len();
            self.sheet([around, rows], true, Vec2::new(TAU * widest, length), point, slot);
            for face in &mut self.faces[begin..] {
                face.uv = face.uv.map(|uv| uv + Vec2::new(0.0, from));
            }
            from += length;
        }
    }

    /// Adds a round bar along the y axis with flat ends.
    pub(super) fn cylinder(&mut self, radius: f32, [low, high]: [f32; 2], around: usize, slot: u16) {
        let at = Vec2::new;
        self.lathe(
            &[
                vec![at(0.0, low), at(radius, low)],
                vec![at(radius, low), at(radius, high)],
                vec![at(radius, high), at(0.0, high)],
            ],
            around,
            slot,
        );
    }

    /// Adds a prism: an outline in the xz plane, extruded upwards from `low` to `high`. The outline is
    /// counter-clockwise seen from above with z down, and visible as a whole from its centre.
    pub(super) fn prism(&mut self, outline: &[Vec2], [low, high]: [f32; 2], slot: u16) {
        let count = outline.len();
        let at = |place: usize, y: f32| Vec3::new(outline[place % count].x, y, -outline[place % count].y);
        let center = outline.iter().sum::<Vec2>() / count as f32;
        let mut from = 0.0;
        for place in 0..count {
            let (a, b) = (place, place + 1);
            let width = outline[a].distance(outline[b % count]);
            let uv = [(from, low), (from + width, low), (from + width, high), (from, high)];
            self.quad_with([at(a, low), at(b, low), at(b, high), at(a, high)], uv.map(Vec2::from), slot);
            from += width;
            for (y, [first, second]) in [(low, [b, a]), (high, [a, b])] {
                let middle = self.point(Vec3::new(center.x, y, -center.y));
                let [one, two] = [first, second].map(|corner| self.point(at(corner, y)));
                let uv = [center, outline[first % count], outline[second % count]];
                self.face([middle, one, two], uv, slot);
            }
        }
    }

    /// Adds a tube along a line of points, with a radius at each point. Its ends are closed, unless it is a ring.
    pub(super) fn tube(&mut self, line: &[Vec3], radius: impl Fn(f32) -> f32, sides: usize, is_ring: bool, slot: u16) {
        let frames = frames(line, is_ring);
        let rows = if is_ring { line.len() } else { line.len() - 1 };
        let length: f32 = line.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        let widest = (0..=8).map(|step| radius(step as f32 / 8.0)).fold(0.0, f32::max);
        let point = |s: f32, t: f32| {
            let place = (t * rows as f32).round() as usize % line.len();
            let (sin, cos) = (TAU * s).sin_cos();
            line[place] + frames[place] * Vec3::new(cos, sin, 0.0) * radius(if is_ring { t.fract() } else { t })
        };
        self.sheet([sides, rows], true, Vec2::new(TAU * widest, length), point, slot);
        if !is_ring {
            for (place, end, turn) in [(0, 0.0, -1.0), (rows, 1.0, 1.0)] {
                let middle = self.point(line[place]);
                let rim: Vec<u32> =
                    (0..sides).map(|side| self.point(point(turn * side as f32 / sides as f32, end))).collect();
                for side in 0..sides {
                    self.face([middle, rim[side], rim[(side + 1) % sides]], [Vec2::ZERO; 3], slot);
                }
            }
        }
    }

    /// Adds a straight round bar between two points.
    pub(super) fn bar(&mut self, from: Vec3, to: Vec3, radius: f32, sides: usize, slot: u16) {
        self.tube(&[from, to], |_| radius, sides, false, slot);
    }

    /// Adds a closed round body. `reach(direction)` is the distance of its surface from the centre.
    pub(super) fn body(&mut self, center: Vec3, [around, rows]: [usize; 2], reach: impl Fn(Vec3) -> f32, slot: u16) {
        let mean = 0.5 * (reach(Vec3::X) + reach(Vec3::Y));
        let point = |s: f32, t: f32| {
            let (sin, cos) = (TAU * s).sin_cos();
            let (up, out) = (std::f32::consts::PI * (t - 0.5)).sin_cos();
            // All columns meet in one point at the poles.
            let out = if t == 0.0 || t == 1.0 { 0.0 } else { out };
            let direction = Vec3::new(out * cos, up, -out * sin);
            center + direction * reach(direction)
        };
        self.sheet([around, rows], true, Vec2::new(TAU, 0.5 * TAU) * mean, point, slot);
    }

    /// Adds another form, turned and moved. Its slots begin at `slot`.
    pub(super) fn join(&mut self, other: &Self, transform: Affine3A, slot: u16) {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions.iter().map(|&at| transform.transform_point3(at)));
        self.faces.extend(other.faces.iter().map(|face| Face {
            corners: face.corners.map(|corner| first + corner),
            normals: face.normals.map(|normal| transform.transform_vector3(normal).normalize_or_zero()),
            slot: face.slot + slot,
            ..*face
        }));
    }

    /// Returns the low and the high corner of its box.
    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        self.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &at| (low.min(at), high.max(at)))
    }

    /// Scales it and moves it, so that its box's middle is at the origin and the longest side has this length.
    pub(super) fn centred(mut self, longest: f32) -> Self {
        let (low, high) = self.bounds();
        let scale = longest / (high - low).max_element().max(1e-6);
        let middle = low.midpoint(high);
        self.positions.iter_mut().for_each(|at| *at = (*at - middle) * scale);
        self.faces.iter_mut().for_each(|face| face.uv = face.uv.map(|uv| uv * scale));
        self.tops.clear();
        self
    }

    /// Returns its mesh at a place. `paints` has an entry for each slot; the last one stands for further slots.
    pub(super) fn mesh(&self, name: &str, transform: &Affine3A, paints: &[Paint]) -> Mesh {
        let positions = self.positions.iter().map(|&at| transform.transform_point3(at)).collect();
        let paint = |face: &Face| paints[usize::from(face.slot).min(paints.len() - 1)];
        let turned = |normal: Vec3| transform.transform_vector3(normal).normalize_or_zero();
        Mesh::new(positions, self.faces.iter().map(|face| face.corners).collect())
            .name(name)
            .materials(self.faces.iter().map(|face| paint(face).material).collect())
            .normals(self.faces.iter().map(|face| face.normals.map(turned)).collect())
            .uv(self.faces.iter().map(|face| face.uv.map(|uv| paint(face).coordinates(uv))).collect())
            .colors(self.colors.clone())
    }
}

/// Returns the rotation of each point of a line whose z axis follows the line, with as little twist as possible.
fn frames(line: &[Vec3], is_ring: bool) -> Vec<Quat> {
    let count = line.len();
    let along = |place: usize| {
        let (before, after) = match is_ring {
            true => ((place + count - 1) % count, (place + 1) % count),
            false => (place.saturating_sub(1), (place + 1).min(count - 1)),
        };
        (line[after] - line[before]).normalize_or(Vec3::Z)
    };
    let mut turn = Quat::from_rotation_arc(Vec3::Z, along(0));
    let mut frames = vec![turn];
    for place in 1..count {
        turn = Quat::from_rotation_arc(turn * Vec3::Z, along(place)) * turn;
        frames.push(turn.normalize());
    }
    frames
}
