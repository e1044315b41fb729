//! Closed meshes, and tests for points that are certain to lie inside them.
use std::collections::HashMap;

use stereotrace::glam::{DVec3, Vec3};

use crate::common::random::Random;

/// A closed mesh of about unit size around the origin, with a function that recognises some of the points inside it.
pub(crate) struct Solid {
    pub name: &'static str,
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    pub inside: Box<dyn Fn(DVec3) -> bool>,
    /// Coordinates of the mesh's axis-aligned faces. A ray's origin at such a coordinate sees those faces exactly
    /// edge-on.
    pub levels: Vec<f32>,
}

/// Returns a sphere of 20 * 4^subdivisions triangles with radius 1.
pub(crate) fn icosphere(subdivisions: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5.0_f32.sqrt());
    let mut positions: Vec<Vec3> = (0..12)
        .map(|i| {
            let (a, b) = (if i & 1 == 0 { 1.0 } else { -1.0 }, if i & 2 == 0 { golden } else { -golden });
            [Vec3::new(a, b, 0.0), Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a)][i / 4].normalize()
        })
        .collect();
    let mut triangles = hull_triangles(&positions);
    for _ in 0..subdivisions {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    (positions, triangles)
}

/// Returns the convex hull of few points in general position: the triangles that have all other points on one side.
fn hull_triangles(points: &[Vec3]) -> Vec<[u32; 3]> {
    let at = |index: usize| points[index].as_dvec3();
    let mut triangles = Vec::new();
    for a in 0..points.len() {
        for b in a + 1..points.len() {
            for c in b + 1..points.len() {
                let normal = (at(b) - at(a)).cross(at(c) - at(a));
                let sides = (0..points.len()).filter(|i| ![a, b, c].contains(i)).map(|i| normal.dot(at(i) - at(a)));
                let (low, high) = sides.fold((0.0_f64, 0.0_f64), |(low, high), side| (low.min(side), high.max(side)));
                if high <= 1e-6 {
                    triangles.push([a as u32, b as u32, c as u32]);
                } else if low >= -1e-6 {
                    triangles.push([a as u32, c as u32, b as u32]);
                }
            }
        }
    }
    triangles
}

/// Returns the surface of a set of cubes on a lattice, with shared corners, centred.
fn cubes(name: &'static str, filled: impl Fn([i32; 3]) -> bool + 'static, count: i32) -> Solid {
    let mut corners = HashMap::new();
    let mut lattice: Vec<[i32; 3]> = Vec::new();
    let mut triangles = Vec::new();
    let cells = (0..count * count * count).map(|i| [i % count, i / count % count, i / count / count]);
    for cell in cells.filter(|&cell| filled(cell)) {
        for (axis, side) in [0, 1, 2].into_iter().flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let mut beyond = cell;
            beyond[axis] += 2 * side - 1;
            if (0..count).contains(&beyond[axis]) && filled(beyond) {
                continue;
            }
            let mut corner = |u: i32, v: i32| {
                let mut corner = cell;
                corner[axis] += side;
                corner[(axis + 1) % 3] += u;
                corner[(axis + 2) % 3] += v;
                *corners.entry(corner).or_insert_with(|| {
                    lattice.push(corner);
                    lattice.len() as u32 - 1
                })
            };
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            triangles.extend(if cell[0] % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    let place = move |step: i32| 2.0 * step as f32 / count as f32 - 1.0;
    let inside = move |point: DVec3| {
        // All cells within a tenth of a cell's side from the point are filled.
        let side = 0.5 * f64::from(count);
        (0..8).all(|corner| {
            let away = DVec3::from_array([0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -0.1 } else { 0.1 }));
            let cell = ((point + 1.0) * side + away).floor().as_ivec3().to_array();
            cell.iter().all(|index| (0..count).contains(index)) && filled(cell)
        })
    };
    Solid {
        name,
        positions: lattice.iter().map(|corner| Vec3::from_array(corner.map(place))).collect(),
        triangles,
        inside: Box::new(inside),
        levels: (0..=count).map(place).collect(),
    }
}

fn torus() -> Solid {
    let (around, along) = (48, 20);
    let (major, minor) = (0.7_f32, 0.28_f32);
    let point = |i: u32, j: u32| {
        let (a, b) = (i as f32 / around as f32, j as f32 / along as f32);
        let ((sin_a, cos_a), (sin_b, cos_b)) =
            ((a * std::f32::consts::TAU).sin_cos(), (b * std::f32::consts::TAU).sin_cos());
        Vec3::new((major + minor * cos_b) * cos_a, minor * sin_b, (major + minor * cos_b) * sin_a)
    };
    let at = |i: u32, j: u32| (i % around) * along + j % along;
    let cells = (0..around * along).map(|index| (index / along, index % along));
    let triangles = cells.clone().flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    let inside = move |point: DVec3| {
        let ring = point.x.hypot(point.z) - f64::from(major);
        ring.hypot(point.y) < 0.9 * f64::from(minor)
    };
    Solid {
        name: "torus",
        positions: cells.clone().map(|(i, j)| point(i, j)).collect(),
        triangles: triangles.collect(),
        inside: Box::new(inside),
        levels: vec![0.0],
    }
}

/// Returns a solid of every kind.
pub(crate) fn solids() -> Vec<Solid> {
    let (positions, triangles) = icosphere(3);
    let sphere_inside = |point: DVec3| point.length() < 0.95;
    let mut random = Random::new(17);
    let spiky: Vec<Vec3> = positions.iter().map(|position| position * random.between(0.45, 1.0)).collect();
    let hull: Vec<Vec3> = (0..40).map(|_| random.point(1.0).normalize() * Vec3::new(1.0, 0.6, 0.8)).collect();
    let hull_faces = hull_triangles(&hull);
    let planes: Vec<(DVec3, DVec3)> = hull_faces
        .iter()
        .map(|face| {
            let [a, b, c] = face.map(|corner| hull[corner as usize].as_dvec3());
            (a, (b - a).cross(c - a).normalize())
        })
        .collect();
    let hull_inside = move |point: DVec3| planes.iter().all(|(on, normal)| normal.dot(point - on) < -0.03);
    let solid = |name, positions, triangles, inside| Solid { name, positions, triangles, inside, levels: Vec::new() };
    vec![
        solid("sphere", positions.clone(), triangles.clone(), Box::new(sphere_inside) as Box<dyn Fn(DVec3) -> bool>),
        solid("star", spiky, triangles, Box::new(|point: DVec3| point.length() < 0.35)),
        solid("hull", hull, hull_faces, Box::new(hull_inside)),
        torus(),
        cubes("box", |_| true, 1),
        cubes("fine box", |_| true, 8),
        cubes("stairs", |[x, y, _]| y <= x, 8),
    ]
}
