//! Stacked objects that fill the view, as in the procedural scene of Raghuvanshi and Dhande (figure 12).

use std::f32::consts::PI;

use glam::{Mat3, Vec3};

use super::{INTERAXIAL_SHARE, lamp, paint};
use crate::{MaterialId, Mesh, Scene, Sky, Sphere, StereoCamera};

/// Half the side of the square that the stack fills, in the plane z = 0.
const HALF_SIDE: f32 = 1.0;
/// Distance of the eyes from the stack's plane, where the screen is.
const EYE_DISTANCE: f32 = 6.0;
/// Distance between rows of spheres, in radii. Spheres lie in the gaps of the row below.
const ROW_STEP: f32 = 1.732_050_8;
/// Rotation of triangles about their upright axes in radians, alternately to both sides. A flat sheet would have no
/// shadows.
const TURN: f32 = 0.35;

/// Kind of the stacked objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum StackedKind {
    /// Spheres, each in the gap between two below.
    Spheres,
    /// Equilateral triangles, alternately on their sides and on their tips, and turned alternately by 20 degrees. Each
    /// is an object of its own.
    Triangles,
}

/// A stack of equal objects in rows from the ground up. They are as large as a square view permits, so a larger number
/// makes them smaller. One lamp in front of them, above and to the left, makes them cast shadows on each other.
///
/// ```
/// use stereotrace::scene::builtin::{StackedKind, StackedObjects};
///
/// let stack = StackedObjects::new(50, StackedKind::Spheres);
/// assert_eq!(stack.scene().spheres().len(), 50);
/// assert!(stack.camera(400, 400).pose().is_ok());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StackedObjects {
    /// Number of objects.
    pub count: usize,
    /// Kind of the objects.
    pub kind: StackedKind,
}

impl StackedObjects {
    /// Makes a stack of `count` objects of a kind.
    pub fn new(count: usize, kind: StackedKind) -> Self {
        Self { count, kind }
    }

    /// Builds the scene. Each call gives the same scene. Objects are ordered from the bottom up, and each row from left
    /// to right.
    pub fn scene(self) -> Scene {
        const PALETTE: [[u8; 3]; 7] = [
            [205, 66, 60],
            [236, 150, 58],
            [240, 206, 92],
            [112, 172, 92],
            [54, 142, 146],
            [72, 128, 200],
            [134, 92, 168],
        ];
        let mut scene = Scene::new();
        let materials = PALETTE.map(|color| paint(&mut scene, "stacked", color));
        let (rows, add): (_, fn(&mut Scene, Rows, usize, MaterialId)) = match self.kind {
            StackedKind::Spheres => (Rows::of_spheres(self.count), add_sphere),
            StackedKind::Triangles => (Rows::of_triangles(self.count), add_triangle),
        };
        for index in 0..self.count {
            add(&mut scene, rows, index, materials[index % materials.len()]);
        }
        scene.sky = Sky::Gradient { nadir: Vec3::new(0.5, 0.5, 0.52), zenith: Vec3::new(0.2, 0.32, 0.56) };
        scene.ambient = Some(Vec3::splat(0.15));
        scene.lights = vec![lamp([-3.0, 4.0, 5.0], 1.1, [1.0, 0.98, 0.94])];
        scene
    }

    /// Returns a camera whose picture the stack fills if the picture is square. In other pictures the stack fills a
    /// square in the middle.
    pub fn camera(self, width: u32, height: u32) -> StereoCamera {
        let aspect = (width as f32 / height.max(1) as f32).max(1.0);
        StereoCamera::look_at(EYE_DISTANCE * Vec3::Z, Vec3::ZERO)
            .screen_distance(EYE_DISTANCE)
            .screen_width(2.0 * HALF_SIDE * aspect)
            .size(width, height)
            .interaxial_pixels(INTERAXIAL_SHARE * width as f32)
    }
}

/// Rows of equal objects.
#[derive(Clone, Copy)]
struct Rows {
    /// Number of objects in the lowest row.
    columns: usize,
    rows: usize,
    /// Radius of a sphere, or half of a triangle's side.
    half: f32,
}

impl Rows {
    /// Returns the rows of the largest spheres that fit the square. Every second row lies in gaps and has one sphere
    /// less.
    fn of_spheres(count: usize) -> Self {
        Self::largest(count, |rows| {
            let columns = (count + rows / 2).div_ceil(rows);
            let height = 2.0 + ROW_STEP * (rows - 1) as f32;
            Self { columns, rows, half: 2.0 * HALF_SIDE / height.max(2.0 * columns as f32) }
        })
    }

    /// Returns the rows of the largest triangles that fit the square. Neighbours in a row are half a side apart.
    fn of_triangles(count: usize) -> Self {
        Self::largest(count, |rows| {
            let columns = count.div_ceil(rows);
            let height = ROW_STEP * rows as f32;
            Self { columns, rows, half: 2.0 * HALF_SIDE / height.max((columns + 1) as f32) }
        })
    }

    fn largest(count: usize, of_rows: impl Fn(usize) -> Self) -> Self {
        // More than four times a square's number of rows gives smaller objects: a row is at least half as high as an
        // object is wide.
        let most = 4 * count.isqrt() + 4;
        let all = (1..=most.min(count.max(1))).map(of_rows);
        all.max_by(|a, b| a.half.total_cmp(&b.half)).unwrap_or(Self { columns: 1, rows: 1, half: HALF_SIDE })
    }
}

/// Adds the sphere at an index from the bottom up. Even rows are complete; odd rows have one sphere less.
fn add_sphere(scene: &mut Scene, Rows { columns, rows, half: radius }: Rows, index: usize, material: MaterialId) {
    let two_rows = (2 * columns - 1).max(1);
    let (row, column) = match index % two_rows {
        within if within < columns => (index / two_rows * 2, within),
        within => (index / two_rows * 2 + 1, within - columns),
    };
    let left = -radius * (columns - 1) as f32 + if row % 2 == 1 { radius } else { 0.0 };
    let bottom = -0.5 * ROW_STEP * radius * (rows - 1) as f32;
    let center = Vec3::new(left + 2.0 * radius * column as f32, bottom + ROW_STEP * radius * row as f32, 0.0);
    scene.add_sphere(Sphere::new(center, radius, material)).expect("it has a radius");
}

/// Adds the triangle at an index from the bottom up. Every second one stands on its tip.
fn add_triangle(scene: &mut Scene, Rows { columns, rows, half }: Rows, index: usize, material: MaterialId) {
    let (row, column) = (index / columns, index % columns);
    let height = ROW_STEP * half;
    let x = half * (column as f32 - 0.5 * (columns - 1) as f32);
    let y = height * (row as f32 + 0.5 - 0.5 * rows as f32);
    let on_tip = (row + column) % 2 == 1;
    let flip = if on_tip { Mat3::from_rotation_z(PI) } else { Mat3::IDENTITY };
    let turn = Mat3::from_rotation_y(if on_tip { -TURN } else { TURN });
    let corners = [[-half, -0.5 * height], [half, -0.5 * height], [0.0, 0.5 * height]];
    let corners = corners.map(|[dx, dy]| Vec3::new(x, y, 0.0) + turn * (flip * Vec3::new(dx, dy, 0.0)));
    let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).materials(vec![material]).name(format!("triangle {index}"));
    scene.add_mesh(&mesh).expect("its corners are finite");
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNTS: [usize; 9] = [1, 2, 3, 10, 50, 100, 500, 2000, 6000];

    fn square(scene: &Scene) -> (Vec3, Vec3) {
        scene.local_bounds().unwrap()
    }

    #[test]
    fn stacks_have_so_many_objects_within_the_square_and_reach_across_it() {
        for (count, kind) in COUNTS.into_iter().flat_map(|n| [(n, StackedKind::Spheres), (n, StackedKind::Triangles)]) {
            let scene = StackedObjects::new(count, kind).scene();
            assert_eq!((scene.primitive_count(), scene.object_count()), (count, count), "{kind:?}");
            let (low, high) = square(&scene);
            let edge = HALF_SIDE * 1.0001;
            assert!(
                low.cmpge(Vec3::splat(-edge)).all() && high.cmple(Vec3::splat(edge)).all(),
                "{kind:?} {low} {high}"
            );
            // The stack touches the bottom and both sides, or the top. A single or incomplete row leaves room above.
            let [wide, high] = [high.x - low.x, high.y - low.y];
            assert!(wide.max(high) > 1.8 * HALF_SIDE, "{count} {kind:?}: {wide} wide, {high} high");
            assert_eq!(scene.lights.len(), 1);
        }
        assert_eq!(StackedObjects::new(0, StackedKind::Spheres).scene().primitive_count(), 0);
    }

    #[test]
    fn stacked_balls_touch_and_never_meet() {
        for count in [2, 3, 10, 50, 333] {
            let scene = StackedObjects::new(count, StackedKind::Spheres).scene();
            let radius = scene.spheres()[0].radius;
            for (index, one) in scene.spheres().iter().enumerate() {
                let nearest = scene.spheres().iter().enumerate().filter(|(other, _)| *other != index);
                let nearest = nearest.map(|(_, other)| other.center.distance(one.center)).fold(f32::INFINITY, f32::min);
                assert!((nearest / radius - 2.0).abs() < 1e-3, "{count}, {index}: {nearest} {radius}");
            }
        }
    }

    /// Computes the share of the square that the spheres' discs cover, from their areas.
    #[test]
    fn the_more_balls_the_fuller_the_square() {
        let share = |count: usize| count as f32 * PI * Rows::of_spheres(count).half.powi(2) / (2.0 * HALF_SIDE).powi(2);
        assert!((share(3) - 0.589).abs() < 1e-3, "{}", share(3));
        for (count, least) in [(10, 0.6), (50, 0.78), (100, 0.78), (1000, 0.84), (6000, 0.87)] {
            // The bound is the densest packing of discs.
            assert!((least..0.9069).contains(&share(count)), "{count}: {}", share(count));
        }
    }

    #[test]
    fn fewer_rows_or_more_hold_no_larger_balls() {
        for count in 1..200_usize {
            let tried = (1..=count).map(|rows| {
                let columns = (count + rows / 2).div_ceil(rows);
                (2.0 / (2.0 + ROW_STEP * (rows - 1) as f32)).min(1.0 / columns as f32)
            });
            let best = tried.fold(0.0, f32::max);
            assert!((Rows::of_spheres(count).half - best).abs() < 1e-6, "{count}");
        }
    }
}
