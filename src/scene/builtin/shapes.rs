//! Triangle shapes for scenes built in code.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use crate::{MaterialId, Mesh};

/// Start of the tangents within a patch, and their length, as shares of the patch. The offset keeps creases between
/// patches sharp. It also gives a normal to edges that shrink to a point.
const TANGENT_START: f32 = 0.02;
const TANGENT_STEP: f32 = 0.05;

/// A mesh under construction, in its own coordinates.
pub(crate) struct Shape {
    origin: Vec3,
    mesh: Mesh,
}

/// Shading of a sheet's patches.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Shading {
    Flat,
    Smooth,
}

impl Shape {
    /// Begins an object whose points are relative to `origin`.
    pub(crate) fn new(name: impl Into<String>, origin: Vec3) -> Self {
        Self { origin, mesh: Mesh::default().name(name.into()) }
    }

    pub(crate) fn into_mesh(self) -> Mesh {
        self.mesh
    }

    /// Adds a triangle, unless two of its corners coincide.
    fn triangle(&mut self, corners: [Vec3; 3], normals: [Vec3; 3], material: MaterialId) {
        let corners = corners.map(|corner| corner + self.origin);
        let [a, b, c] = corners;
        if a == b || b == c || c == a {
            return;
        }
        let first = self.mesh.positions.len() as u32;
        self.mesh.positions.extend(corners);
        self.mesh.triangles.push([first, first + 1, first + 2]);
        self.mesh.normals.push(normals);
        self.mesh.materials.push(material);
    }

    /// Adds two flat triangles. Corners are in order around the quad.
    pub(crate) fn quad(&mut self, [a, b, c, d]: [Vec3; 4], material: MaterialId) {
        self.triangle([a, b, c], [Vec3::ZERO; 3], material);
        self.triangle([a, c, d], [Vec3::ZERO; 3], material);
    }

    /// Adds a box along the axes.
    pub(crate) fn cuboid(&mut self, low: Vec3, high: Vec3, material: MaterialId) {
        let corner = |bits: usize| {
            let pick = |axis: usize| if bits >> axis & 1 == 0 { low[axis] } else { high[axis] };
            Vec3::new(pick(0), pick(1), pick(2))
        };
        for sides in [[0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5]] {
            self.quad(sides.map(corner), material);
        }
    }

    /// Adds a surface `point(s, t)`, with s and t from 0 to 1, divided into patches. `material(column, row)` returns a
    /// patch's material.
    pub(crate) fn sheet(
        &mut self,
        [columns, rows]: [usize; 2],
        shading: Shading,
        point: impl Fn(f32, f32) -> Vec3,
        material: impl Fn(usize, usize) -> MaterialId,
    ) {
        let [width, height] = [1.0 / columns as f32, 1.0 / rows as f32];
        for row in 0..rows {
            for column in 0..columns {
                // Corners are in order around the patch.
                let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(right, up)| {
                    let (s, t) = ((column + right) as f32 * width, (row + up) as f32 * height);
                    let (inward_s, inward_t) = (width * (1.0 - 2.0 * right as f32), height * (1.0 - 2.0 * up as f32));
                    let (near_s, near_t) = (s + TANGENT_START * inward_s, t + TANGENT_START * inward_t);
                    let near = point(near_s, near_t);
                    let along_s = (point(near_s + TANGENT_STEP * inward_s, near_t) - near) * inward_s.signum();
                    let along_t = (point(near_s, near_t + TANGENT_STEP * inward_t) - near) * inward_t.signum();
                    (point(s, t), along_s.normalize_or_zero().cross(along_t.normalize_or_zero()).normalize_or_zero())
                });
                let smooth = shading == Shading::Smooth && corners.iter().all(|(_, normal)| *normal != Vec3::ZERO);
                let material = material(column, row);
                for pick in [[0, 1, 2], [0, 2, 3]] {
                    let normals = if smooth { pick.map(|k| corners[k].1) } else { [Vec3::ZERO; 3] };
                    self.triangle(pick.map(|k| corners[k].0), normals, material);
                }
            }
        }
    }

    /// Adds a surface of revolution about the y axis; `profile(t)` is (radius, height).
    pub(crate) fn lathe(
        &mut self,
        [around, rows]: [usize; 2],
        profile: impl Fn(f32) -> Vec2,
        material: impl Fn(usize, usize) -> MaterialId,
    ) {
        let point = |s: f32, t: f32| {
            let at = profile(t);
            spin(at.x, s, at.y)
        };
        self.sheet([around, rows], Shading::Smooth, point, material);
    }

    /// Adds a column's shaft with `flutes` hollows, each of `facets` patches and `depth` deep.
    pub(crate) fn fluted_shaft(
        &mut self,
        [flutes, facets, rows]: [usize; 3],
        depth: f32,
        profile: impl Fn(f32) -> Vec2,
        material: MaterialId,
    ) {
        let point = |s: f32, t: f32| {
            let (at, x) = (profile(t), (s * flutes as f32).fract());
            spin(at.x - depth * 4.0 * x * (1.0 - x), s, at.y)
        };
        self.sheet([flutes * facets, rows], Shading::Smooth, point, |_, _| material);
    }

    /// Adds the visible parts of a half-elliptic arch: its underside and two faces. `along` is half its span and
    /// `across` half its thickness (horizontal), `rise` its height above the origin. `feet` and `crown` are the lengths
    /// of its stones there.
    pub(crate) fn arch(
        &mut self,
        along: Vec3,
        across: Vec3,
        rise: f32,
        [feet, crown]: [f32; 2],
        stones: usize,
        material: impl Fn(usize) -> MaterialId,
    ) {
        const PATCHES_PER_STONE: usize = 2;
        let span = along.length();
        let at = |s: f32, outward: f32, side: f32| {
            let (sin, cos) = (PI * s).sin_cos();
            let flat = along * ((1.0 + feet * outward / span) * cos);
            flat + across * side + Vec3::Y * ((rise + crown * outward) * sin)
        };
        let columns = stones * PATCHES_PER_STONE;
        let stone = |column: usize, _: usize| material(column / PATCHES_PER_STONE);
        self.sheet([columns, 1], Shading::Smooth, |s, t| at(s, 0.0, 2.0 * t - 1.0), stone);
        for side in [-1.0, 1.0] {
            self.sheet([columns, 1], Shading::Flat, |s, t| at(s, t, side), stone);
        }
    }

    /// Adds a groin vault over a rectangle, seen from below: the higher one of two crossing half-elliptic barrels. The
    /// origin is above the rectangle's centre, at the height where the vault springs.
    pub(crate) fn groin_vault(&mut self, half: Vec2, rise: f32, patches: [usize; 2], material: MaterialId) {
        for quarter in 0..4 {
            let point = |s: f32, t: f32| {
                // One of the four lunettes between the diagonals: u along its edge of the rectangle, v towards it.
                let (u, height) = (PI * (s - 0.5)).sin_cos();
                let v = u.abs() + (1.0 - u.abs()) * t;
                let (x, z) = [(u, v), (v, -u), (-u, -v), (-v, u)][quarter];
                Vec3::new(x * half.x, height.max(0.0) * rise, z * half.y)
            };
            self.sheet(patches, Shading::Smooth, point, |_, _| material);
        }
    }
}

/// Returns the point at `radius` and `height`, `turn` (0 to 1) of the way around the y axis.
fn spin(radius: f32, turn: f32, height: f32) -> Vec3 {
    // `fract` makes both ends of the circle equal to the last bit.
    let (sin, cos) = (TAU * turn.fract()).sin_cos();
    Vec3::new(radius * cos, height, -radius * sin)
}

/// Returns the profile of a round moulding: a half circle of `radius` that bulges from `inner`, with its lower end at
/// `bottom`.
pub(crate) fn torus(inner: f32, bottom: f32, radius: f32) -> impl Fn(f32) -> Vec2 {
    move |t| {
        let (sin, cos) = (PI * t).sin_cos();
        Vec2::new(inner + radius * sin, bottom + radius * (1.0 - cos))
    }
}
