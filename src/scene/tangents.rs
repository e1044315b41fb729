//! Tangents for normal textures.

use std::borrow::Cow;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Affine3A, Vec4};

use super::{Mesh, Scene, Triangle};

/// A mesh whose tangents are computed.
struct Made<'a> {
    mesh: &'a Mesh,
    triangles: &'a [Triangle],
    tangents: Vec<[Vec4; 3]>,
}

impl Geometry for Made<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.triangles[face].corners[corner].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let triangle = &self.triangles[face];
        if triangle.is_smooth() {
            return triangle.normals[corner].to_array();
        }
        let [a, b, c] = triangle.corners;
        (b - a).cross(c - a).normalize_or_zero().to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.mesh.uv[face][corner].to_array()
    }

    fn set_tangent(&mut self, found: Option<TangentSpace>, face: usize, corner: usize) {
        if let Some(found) = found {
            self.tangents[face][corner] = Vec4::from_array(found.tangent_encoded());
        }
    }
}

impl Scene {
    /// Returns a mesh's tangents. If it has none, and its materials have normal textures, they are those of
    /// `MikkTSpace`, with which most normal textures are made (Mikkelsen 2008, "Simulation of Wrinkled Surfaces
    /// Revisited").
    pub(super) fn tangents_of<'a>(&self, mesh: &'a Mesh, triangles: &[Triangle]) -> Cow<'a, [[Vec4; 3]]> {
        let needs = |triangle: &Triangle| {
            let material = &self.materials[triangle.material.0 as usize];
            material.principled.is_some_and(|surface| surface.normal_texture.is_some())
        };
        let is_made = !mesh.uv.is_empty() && mesh.tangents.is_empty() && triangles.iter().any(needs);
        let mut made = Made { mesh, triangles, tangents: Vec::new() };
        if is_made {
            made.tangents.resize(triangles.len(), [Vec4::ZERO; 3]);
        }
        match is_made && generate_tangents(&mut made).is_ok() {
            true => Cow::Owned(made.tangents),
            false => Cow::Borrowed(&mesh.tangents),
        }
    }
}

/// Transforms a tangent. A mirroring transform also reverses the triangles' winding, and with it their outer side. So
/// the factor of v stays.
pub(super) fn transformed_tangent(tangent: Vec4, transform: &Affine3A) -> Vec4 {
    transform.transform_vector3(tangent.truncate()).normalize_or_zero().extend(tangent.w)
}
