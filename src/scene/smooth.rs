//! Smooth normals for meshes whose files have none.
//!
//! Around each vertex the triangles are grouped into fans. Neighbours across an edge belong to one fan if their normals
//! differ by less than the crease angle. A fan has one normal at the vertex. It is the mean of its triangles' normals,
//! weighted by their angles at the vertex, so it does not depend on how faces were split. Vertices are identified by
//! position alone: duplicates for texture coordinates are merged.

use glam::{DVec3, Vec3};

use super::Mesh;
use crate::Error;

/// Largest number of triangles at an edge that can be smooth across it.
const MOST_AT_AN_EDGE: usize = 8;
/// A triangle stays flat if its vertex normals differ from its own by less than this. Shading does not show the
/// difference.
const FLAT: f32 = 1e-6;

impl Mesh {
    /// Replaces the normals. Edges across which the normals of triangles differ by less than `crease_degrees` are
    /// smooth, the others stay sharp. Triangles whose corners all have the triangle's normal stay flat; if all do, the
    /// mesh has no normals. An edge between triangles of opposite winding is sharp.
    ///
    /// # Errors
    /// [`Error::Scene`] for an angle outside 0 to 180, and for a corner that is out of range.
    pub fn smooth(mut self, crease_degrees: f32) -> Result<Self, Error> {
        check_crease(crease_degrees).map_err(|reason| self.fault("crease angle", reason))?;
        for index in 0..self.triangles.len() {
            self.check_corners(index).map_err(|reason| self.fault(&format!("triangle {index}"), reason))?;
        }
        self.normals = smooth_normals(&self.positions, &self.triangles, &[], crease_degrees);
        Ok(self)
    }
}

pub(crate) fn check_crease(degrees: f32) -> Result<(), String> {
    match (0.0..=180.0).contains(&degrees) {
        true => Ok(()),
        false => Err(format!("it is {degrees} degrees; it must be within 0 to 180")),
    }
}

/// Normalises a vector; zero stays zero. f64 keeps the direction of tiny and huge normals.
#[cfg(feature = "scene-files")]
pub(crate) fn unit(normal: Vec3) -> Vec3 {
    normal.as_dvec3().normalize_or_zero().as_vec3()
}

/// Returns three normals per triangle, zeros for flat triangles, or an empty list if all are flat. `groups` has
/// smoothing groups of the first triangles. Triangles of different groups never share a fan, and triangles of group 0
/// are flat.
pub(crate) fn smooth_normals(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    groups: &[u32],
    crease_degrees: f32,
) -> Vec<[Vec3; 3]> {
    let vertices = weld(positions);
    let faces: Vec<Vec3> =
        triangles.iter().map(|corners| face_normal(corners.map(|at| positions[at as usize]))).collect();
    let group = |triangle: u32| groups.get(triangle as usize).copied().unwrap_or(u32::MAX);
    let (starts, corners) =
        corners_around(&vertices, triangles, |index| faces[index] != Vec3::ZERO && group(index as u32) != 0);
    let cosine = f64::from(crease_degrees).to_radians().cos();
    let joined = |a: u32, b: u32| {
        let [m, n] = [a, b].map(|triangle| faces[triangle as usize].as_dvec3());
        group(a) == group(b) && m.dot(n) > cosine
    };

    let mut normals = vec![[Vec3::ZERO; 3]; triangles.len()];
    let mut fans = Fans::default();
    for bounds in starts.windows(2) {
        let around = &corners[bounds[0] as usize..bounds[1] as usize];
        fans.find(around, &vertices, triangles, joined);
        fans.add_up(around, positions, triangles, &faces);
        for (place, &(triangle, corner)) in around.iter().enumerate() {
            let face = faces[triangle as usize];
            let first = fans.first_of(place);
            let mean = fans.sums[first].normalize_or_zero().as_vec3();
            // In a fan that turns by more than a right angle, a mean normal on the triangle's back would make it appear
            // unlit.
            normals[triangle as usize][corner as usize] = if mean.dot(face) > 0.0 { mean } else { face };
        }
    }
    let mut is_smooth = false;
    for (normals, face) in normals.iter_mut().zip(&faces) {
        match normals.iter().all(|normal| (*normal - *face).abs().max_element() < FLAT) {
            true => *normals = [Vec3::ZERO; 3],
            false => is_smooth = true,
        }
    }
    if is_smooth { normals } else { Vec::new() }
}

/// Returns a vertex number for each position. Equal positions have the same number.
fn weld(positions: &[Vec3]) -> Vec<u32> {
    // Adding zero turns -0 into 0. Sorting avoids hashes: round numbers share low zero bits, which would collide.
    let bits = |at: u32| (positions[at as usize] + 0.0).to_array().map(f32::to_bits);
    let mut order: Vec<([u32; 3], u32)> = (0..positions.len() as u32).map(|at| (bits(at), at)).collect();
    order.sort_unstable();
    let mut vertices = vec![0; positions.len()];
    let mut last = None;
    let mut vertex = 0;
    for (bits, at) in order {
        vertex += u32::from(last.is_some_and(|last| last != bits));
        last = Some(bits);
        vertices[at as usize] = vertex;
    }
    vertices
}

/// Returns the unit normal, or zero for a triangle without area.
fn face_normal(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

/// Returns the start of each vertex's corners in a list, and this list of corners, each as a triangle and its corner.
/// Only triangles that `wanted` accepts are included.
fn corners_around(
    vertices: &[u32],
    triangles: &[[u32; 3]],
    wanted: impl Fn(usize) -> bool,
) -> (Vec<u32>, Vec<(u32, u8)>) {
    let count = vertices.iter().max().map_or(0, |last| *last as usize + 1);
    let mut starts = vec![0u32; count + 1];
    let all = || {
        let wanted = triangles.iter().enumerate().filter(|(index, _)| wanted(*index));
        wanted.flat_map(|(index, corners)| {
            (0..3).map(move |corner| (vertices[corners[corner] as usize] as usize, (index as u32, corner as u8)))
        })
    };
    all().for_each(|(vertex, _)| starts[vertex + 1] += 1);
    for vertex in 0..count {
        starts[vertex + 1] += starts[vertex];
    }
    let mut next = starts.clone();
    let mut corners = vec![(0, 0); starts[count] as usize];
    for (vertex, corner) in all() {
        corners[next[vertex] as usize] = corner;
        next[vertex] += 1;
    }
    (starts, corners)
}

/// The fans around one vertex. It is reused for all vertices to save allocations.
#[derive(Default)]
struct Fans {
    /// Union-find parents: another corner of the same fan. A fan's first corner is its own parent.
    parents: Vec<u32>,
    /// The vertices at the other ends of each corner's edges, with the corner's index.
    ends: Vec<(u32, u32)>,
    /// Sum of each fan's weighted normals, at the index of its first corner.
    sums: Vec<DVec3>,
}

impl Fans {
    fn find(
        &mut self,
        around: &[(u32, u8)],
        vertices: &[u32],
        triangles: &[[u32; 3]],
        joined: impl Fn(u32, u32) -> bool,
    ) {
        self.parents.clear();
        self.parents.extend(0..around.len() as u32);
        let ends = around.iter().zip(0..).flat_map(|(&(triangle, corner), place)| {
            let end = move |step: u8| triangles[triangle as usize][usize::from((corner + step) % 3)];
            [1, 2].map(|step| (vertices[end(step) as usize], place))
        });
        self.ends.clear();
        self.ends.extend(ends);
        self.ends.sort_unstable();
        let ends = std::mem::take(&mut self.ends);
        for edge in ends.chunk_by(|a, b| a.0 == b.0).filter(|edge| edge.len() <= MOST_AT_AN_EDGE) {
            for (index, &(_, a)) in edge.iter().enumerate() {
                for &(_, b) in &edge[index + 1..] {
                    if joined(around[a as usize].0, around[b as usize].0) {
                        let [a, b] = [self.first_of(a as usize), self.first_of(b as usize)];
                        self.parents[a.max(b)] = a.min(b) as u32;
                    }
                }
            }
        }
        self.ends = ends;
    }

    fn first_of(&mut self, mut place: usize) -> usize {
        while self.parents[place] as usize != place {
            // Path halving keeps long chains from being walked repeatedly.
            self.parents[place] = self.parents[self.parents[place] as usize];
            place = self.parents[place] as usize;
        }
        place
    }

    fn add_up(&mut self, around: &[(u32, u8)], positions: &[Vec3], triangles: &[[u32; 3]], faces: &[Vec3]) {
        self.sums.clear();
        self.sums.resize(around.len(), DVec3::ZERO);
        for (place, &(triangle, corner)) in around.iter().enumerate() {
            let at = |step: u8| {
                positions[triangles[triangle as usize][usize::from((corner + step) % 3)] as usize].as_dvec3()
            };
            let angle = (at(1) - at(0)).angle_between(at(2) - at(0));
            let first = self.first_of(place);
            self.sums[first] += angle * faces[triangle as usize].as_dvec3();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{PI, TAU};

    use glam::Vec3Swizzles;

    use super::*;

    /// Makes a mesh in which each triangle has its own vertices, so that only positions join them.
    fn soup(corners: Vec<[Vec3; 3]>) -> Mesh {
        let triangles = (0..corners.len() as u32).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
        Mesh::new(corners.concat(), triangles)
    }

    fn quad([a, b, c, d]: [Vec3; 4]) -> [[Vec3; 3]; 2] {
        [[a, b, c], [a, c, d]]
    }

    /// Makes a cube whose sides wind outwards.
    fn cube() -> Mesh {
        let sides = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z].map(|normal| {
            let [u, v] = [normal.zxy(), normal.cross(normal.zxy())];
            quad([normal - u - v, normal + u - v, normal + u + v, normal - u + v])
        });
        soup(sides.concat())
    }

    fn ball(rings: u32) -> Mesh {
        let segments = 2 * rings;
        let at = |ring: u32, segment: u32| {
            let (polar, around) =
                (PI * ring as f32 / rings as f32, TAU * (segment % segments) as f32 / segments as f32);
            let ring_radius = if ring == 0 || ring == rings { 0.0 } else { polar.sin() };
            Vec3::new(ring_radius * around.cos(), polar.cos(), -ring_radius * around.sin())
        };
        let mut corners = Vec::new();
        for (ring, segment) in (0..rings).flat_map(|ring| (0..segments).map(move |segment| (ring, segment))) {
            let face = [at(ring, segment), at(ring + 1, segment), at(ring + 1, segment + 1), at(ring, segment + 1)];
            let [low, high] = quad(face);
            corners.extend((ring + 1 < rings).then_some(low));
            corners.extend((ring > 0).then_some(high));
        }
        soup(corners)
    }

    #[test]
    fn a_cube_stays_flat_and_costs_nothing_until_its_edges_are_smooth() {
        assert!(cube().smooth(30.0).unwrap().normals.is_empty());
        assert!(cube().smooth(89.9).unwrap().normals.is_empty());
        let round = cube().smooth(90.1).unwrap();
        for (normals, corners) in round.normals.iter().zip(round.positions.as_chunks::<3>().0) {
            for (normal, corner) in normals.iter().zip(corners) {
                // Weights are angles, so corners point along the diagonals, however a side is split.
                assert!((*normal - corner.normalize()).length() < 1e-6, "{normal} {corner}");
            }
        }
    }

    #[test]
    fn a_ball_is_smooth_all_over_with_normals_along_its_radius() {
        let ball = ball(24).smooth(30.0).unwrap();
        let mut most = 0.0f32;
        for (normals, corners) in ball.normals.iter().zip(ball.positions.as_chunks::<3>().0) {
            for (normal, corner) in normals.iter().zip(corners) {
                most = most.max((*normal - *corner).length());
            }
        }
        // Measured: 0.0039. Triangles are 7.5 degrees wide, 0.13.
        assert!(most < 0.005, "{most}");
        assert_eq!(ball.normals.len(), 2 * 48 * 23);
    }

    #[test]
    fn a_cylinder_is_round_and_its_caps_are_flat() {
        let at = |index: u32, y: f32| {
            let around = TAU * (index % 32) as f32 / 32.0;
            Vec3::new(around.cos(), y, -around.sin())
        };
        let mut corners = Vec::new();
        for index in 0..32 {
            corners.extend(quad([at(index, -1.0), at(index + 1, -1.0), at(index + 1, 1.0), at(index, 1.0)]));
            corners.extend([
                [Vec3::Y, at(index, 1.0), at(index + 1, 1.0)],
                [-Vec3::Y, at(index + 1, -1.0), at(index, -1.0)],
            ]);
        }
        let cylinder = soup(corners).smooth(30.0).unwrap();
        for (index, normals) in cylinder.normals.iter().enumerate() {
            let corners = &cylinder.positions[3 * index..][..3];
            for (normal, corner) in normals.iter().zip(corners) {
                let expected = if index % 4 < 2 { corner.with_y(0.0) } else { Vec3::ZERO };
                assert!((*normal - expected).length() < 1e-5, "{index}: {normal} {corner}");
            }
        }
        let sharp = cylinder.smooth(11.0).unwrap();
        assert!(sharp.normals.is_empty(), "sides are 11.25 degrees apart");
    }

    #[test]
    fn groups_part_what_their_angle_would_join_and_group_0_is_flat() {
        let roof = soup(vec![
            [Vec3::ZERO, Vec3::X, Vec3::Y],
            [Vec3::X, Vec3::new(1.0, 1.0, -0.2), Vec3::Y],
            [Vec3::new(1.0, 1.0, -0.2), Vec3::new(0.5, 1.5, -0.5), Vec3::Y],
        ]);
        let smooth = |groups: &[u32]| -> Vec<bool> {
            let normals = smooth_normals(&roof.positions, &roof.triangles, groups, 60.0);
            (0..3).map(|index| normals.get(index).is_some_and(|normals| normals[0] != Vec3::ZERO)).collect()
        };
        assert_eq!(smooth(&[]), [true; 3]);
        assert_eq!(smooth(&[5, 5, 5]), [true; 3]);
        assert_eq!(smooth(&[1, 1, 2]), [true, true, false]);
        assert_eq!(smooth(&[0, 1, 1]), [false, true, true]);
        assert_eq!(smooth(&[0, 0, 0]), [false; 3]);
    }

    #[test]
    fn what_has_no_area_or_faces_the_other_way_joins_nothing() {
        let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.1), Vec3::Y];
        let both = soup(vec![[a, b, c], [a, c, d], [a, a, c], [a, c, c], [c, b, a], [d, c, a]]).smooth(60.0).unwrap();
        for index in [0, 1] {
            let normals = both.normals[index];
            assert!(normals.iter().all(|normal| normal.z > 0.9), "{normals:?}");
            assert!((both.normals[4 + index][0].z) < -0.9, "{:?}", both.normals[4 + index]);
            assert_eq!(both.normals[2 + index], [Vec3::ZERO; 3]);
        }
        // If one of two triangles is turned over, their edge is sharp.
        assert!(soup(vec![[a, b, c], [d, c, a]]).smooth(60.0).unwrap().normals.is_empty());
        assert!(Mesh::default().smooth(30.0).unwrap().normals.is_empty());
    }

    /// Tests cones, whose triangles all share their tip, and many triangles at one edge.
    #[test]
    fn a_vertex_of_100_000_triangles_takes_no_square_of_time() {
        let at = |index: u32| {
            let around = TAU * (index % 100_000) as f32 / 100_000.0;
            Vec3::new(around.cos(), 0.0, around.sin())
        };
        let started = std::time::Instant::now();
        let cone = soup((0..100_000).map(|index| [Vec3::Y, at(index + 1), at(index)]).collect()).smooth(30.0).unwrap();
        assert!((cone.normals[0][0] - Vec3::Y).length() < 1e-3, "{}", cone.normals[0][0]);
        let sheaf = soup((0..100_000).map(|index| [Vec3::ZERO, Vec3::Y, at(index)]).collect());
        assert!(sheaf.smooth(30.0).unwrap().normals.is_empty());
        assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
    }

    #[test]
    fn angles_and_corners_out_of_range_are_refused_by_name() {
        let said = |degrees| cube().name("die").smooth(degrees).unwrap_err().to_string();
        assert!(said(f32::NAN).contains("mesh 'die', crease angle: it is NaN degrees; it must be within 0 to 180"));
        assert!(said(-1.0).contains("it is -1 degrees") && said(181.0).contains("it is 181 degrees"));
        let message = Mesh::new(vec![Vec3::ZERO; 3], vec![[0, 1, 3]]).smooth(30.0).unwrap_err().to_string();
        assert!(message.contains("triangle 0: corner 3 is out of range for 3 vertices"), "{message}");
    }
}
