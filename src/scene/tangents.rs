//! Tangents for normal textures, by `MikkTSpace`, with which most normal textures are made (Mikkelsen 2008, "Simulation
//! of Wrinkled Surfaces Revisited").

use std::{borrow::Cow, collections::HashMap};

use ahash::RandomState;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Affine3A, Vec3, Vec4};

use super::{Mesh, Scene, Triangle, components::welded};

/// Maximum number of triangles at a point. The algorithm takes time in proportion to its square, and a stack in
/// proportion to it.
const MOST_TRIANGLES: u32 = 256;

/// A mesh whose tangents are computed.
struct Made<'a> {
    mesh: &'a Mesh,
    tangents: Vec<[Vec4; 3]>,
}

impl Made<'_> {
    fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.mesh.triangles[triangle].map(|corner| self.mesh.positions[corner as usize])
    }
}

impl Geometry for Made<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, triangle: usize) -> usize {
        // The algorithm compares triangles without area with all others.
        let [a, b, c] = self.corners(triangle);
        if a == b || b == c || c == a { 0 } else { 3 }
    }

    fn position(&self, triangle: usize, corner: usize) -> [f32; 3] {
        self.corners(triangle)[corner].to_array()
    }

    fn normal(&self, triangle: usize, corner: usize) -> [f32; 3] {
        if let Some(normals) = self.mesh.normals.get(triangle).filter(|normals| !normals.contains(&Vec3::ZERO)) {
            return normals[corner].to_array();
        }
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a).normalize_or_zero().to_array()
    }

    fn tex_coord(&self, triangle: usize, corner: usize) -> [f32; 2] {
        self.mesh.uv[triangle][corner].to_array()
    }

    fn set_tangent(&mut self, found: Option<TangentSpace>, triangle: usize, corner: usize) {
        let found = found.map(|found| Vec4::from_array(found.tangent_encoded())).filter(|tangent| tangent.is_finite());
        self.tangents[triangle][corner] = found.unwrap_or_default();
    }
}

/// Returns the tangents of a mesh with texture coordinates, whose lists have been checked. The list is empty if too
/// many triangles meet at a point.
pub(crate) fn tangents(mesh: &Mesh) -> Vec<[Vec4; 3]> {
    let mut counts = HashMap::with_hasher(RandomState::new());
    for &corner in mesh.triangles.as_flattened() {
        let count = counts.entry(welded(mesh.positions[corner as usize])).or_insert(0);
        *count += 1;
        if *count > MOST_TRIANGLES {
            let reason = "so normal textures use the tangents of each triangle";
            log::warn!("mesh '{}': over {MOST_TRIANGLES} triangles meet at a point, {reason}", mesh.name);
            return Vec::new();
        }
    }
    let mut made = Made { mesh, tangents: vec![[Vec4::ZERO; 3]; mesh.triangles.len()] };
    match generate_tangents(&mut made) {
        Ok(()) => made.tangents,
        // Its error type has no values.
        Err(_) => Vec::new(),
    }
}

impl Scene {
    /// Returns a mesh's tangents. They are computed if it has none and its materials have normal textures.
    pub(super) fn tangents_of<'a>(&self, mesh: &'a Mesh, triangles: &[Triangle]) -> Cow<'a, [[Vec4; 3]]> {
        let needs = |triangle: &Triangle| {
            let material = &self.materials[triangle.material.0 as usize];
            material.principled.is_some_and(|surface| surface.normal_texture.is_some())
        };
        match !mesh.uv.is_empty() && mesh.tangents.is_empty() && triangles.iter().any(needs) {
            true => Cow::Owned(tangents(mesh)),
            false => Cow::Borrowed(&mesh.tangents),
        }
    }
}

/// Transforms a tangent. A mirroring transform also reverses the triangles' winding, and with it their outer side. So
/// the factor of v stays.
pub(super) fn transformed_tangent(tangent: Vec4, transform: &Affine3A) -> Vec4 {
    transform.transform_vector3(tangent.truncate()).normalize_or_zero().extend(tangent.w)
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;

    #[test]
    fn hostile_meshes_take_no_time_and_degenerate_triangles_have_no_tangents() {
        let fan = |count: u32| {
            let rim = |index: u32| Vec3::new((index as f32 * 1e-3).cos(), (index as f32 * 1e-3).sin(), 0.0);
            let positions = std::iter::once(Vec3::ZERO).chain((0..=count).map(rim)).collect();
            let triangles: Vec<[u32; 3]> = (0..count).map(|index| [0, index + 1, index + 2]).collect();
            let uv =
                triangles.iter().map(|corners| corners.map(|corner| Vec2::new(corner as f32, 0.5 * corner as f32)));
            let uv = uv.collect();
            Mesh::new(positions, triangles).uv(uv)
        };
        assert_eq!(tangents(&fan(200)).len(), 200);
        assert!(tangents(&fan(100_000)).is_empty());
        let copies = Mesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]; 100_000]);
        assert!(tangents(&copies.uv(vec![[Vec2::ZERO, Vec2::X, Vec2::Y]; 100_000])).is_empty());
        // A long strip with two degenerate triangles for each good one.
        let positions: Vec<Vec3> = (0..60_000).map(|index| Vec3::new(index as f32, (index % 2) as f32, 0.0)).collect();
        let triangles = (0..59_998_u32).map(|index| match index % 3 {
            0 => [index, index + 1, index + 2],
            1 => [index, index, index + 1],
            _ => [index, index + 1, index + 1],
        });
        let triangles: Vec<[u32; 3]> = triangles.collect();
        let uv = triangles.iter().map(|corners| corners.map(|corner| positions[corner as usize].truncate())).collect();
        let found = tangents(&Mesh::new(positions, triangles).uv(uv));
        assert!((found[0][0].truncate() - Vec3::X).length() < 1e-3 && found[1] == [Vec4::ZERO; 3], "{:?}", found[0]);
        let wild = Mesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
        let found = tangents(&wild.uv(vec![[Vec2::splat(-1e38), Vec2::splat(1e38), Vec2::new(3e38, -3e38)]]));
        assert!(found[0].iter().all(|tangent| tangent.is_finite()), "{found:?}");
    }
}
