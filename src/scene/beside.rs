//! Optional vertex attributes of triangles. Each list is as long as the scene's triangles, or empty if no mesh has the
//! attribute.

use std::ops::Range;

use glam::{Affine3A, Vec2, Vec3, Vec4};

use super::{Material, Mesh, Scene, Texture, Triangle, mesh::Object, tangents::transformed_tangent};

/// Texture coordinates of triangles that have none: zero.
const NO_UV: [Vec2; 3] = [Vec2::ZERO; 3];
/// Vertex colours of triangles that have none: white, which leaves the albedo unchanged.
const NO_COLORS: [Vec3; 3] = [Vec3::ONE; 3];

/// Tangents of triangles that have none.
const NO_TANGENTS: [Vec4; 3] = [Vec4::ZERO; 3];

/// Texture coordinates, colours and tangents at the corners of triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Beside {
    pub(crate) uv: Vec<[Vec2; 3]>,
    pub(crate) colors: Vec<[Vec3; 3]>,
    pub(crate) tangents: Vec<[Vec4; 3]>,
    /// Numbers of objects that have each attribute.
    with_uv: usize,
    with_colors: usize,
    with_tangents: usize,
}

impl Beside {
    /// Replaces the attributes of the object `replaced` by a mesh's, or inserts them. `triangles` is the scene's
    /// previous number of triangles.
    pub(crate) fn replace(
        &mut self,
        range: Range<usize>,
        (mesh, tangents): (&Mesh, &[[Vec4; 3]]),
        replaced: Option<&Object>,
        triangles: usize,
    ) {
        let count = mesh.triangles.len();
        // Counting avoids a loop over all objects for each added one, which takes quadratic time.
        self.with_uv -= usize::from(replaced.is_some_and(|object| object.has_uv));
        self.with_uv += usize::from(!mesh.uv.is_empty());
        self.with_colors -= usize::from(replaced.is_some_and(|object| object.has_colors));
        self.with_colors += usize::from(!mesh.colors.is_empty());
        self.with_tangents -= usize::from(replaced.is_some_and(|object| object.has_tangents));
        self.with_tangents += usize::from(!tangents.is_empty());
        replace(&mut self.uv, range.clone(), (&mesh.uv, count), self.with_uv > 0, (NO_UV, triangles));
        replace(&mut self.colors, range.clone(), (&mesh.colors, count), self.with_colors > 0, (NO_COLORS, triangles));
        replace(&mut self.tangents, range, (tangents, count), self.with_tangents > 0, (NO_TANGENTS, triangles));
    }

    /// Transforms the tangents of a range of triangles.
    pub(super) fn transform_tangents(&mut self, range: Range<usize>, transform: &Affine3A) {
        let corners = self.tangents.get_mut(range).unwrap_or_default().as_flattened_mut();
        corners.iter_mut().for_each(|tangent| *tangent = transformed_tangent(*tangent, transform));
    }
}

/// Replaces a range of a list by the mesh's attributes. If the mesh lacks the attribute, each triangle gets `none`. If
/// no mesh of the scene has the attribute, the list becomes empty.
fn replace<T: Copy>(
    list: &mut Vec<T>,
    range: Range<usize>,
    (by, count): (&[T], usize),
    wanted: bool,
    (none, triangles): (T, usize),
) {
    if !wanted {
        *list = Vec::new();
        return;
    }
    if list.is_empty() {
        list.resize(triangles, none);
    }
    match by.is_empty() {
        true => drop(list.splice(range, std::iter::repeat_n(none, count))),
        false => drop(list.splice(range, by.iter().copied())),
    }
}

impl Scene {
    /// Returns the texture coordinates at the corners of each triangle; they are zero for triangles without any. The
    /// list is empty if no mesh has texture coordinates.
    pub fn uv(&self) -> &[[Vec2; 3]] {
        &self.beside.uv
    }

    /// Returns the tangents at the corners of each triangle ([`Mesh::tangents`]). They are zero for triangles without
    /// any. The list is empty if no mesh has tangents.
    pub fn tangents(&self) -> &[[Vec4; 3]] {
        &self.beside.tangents
    }

    /// Returns whether some surface has a texture or vertex colours.
    pub(crate) fn is_textured(&self) -> bool {
        let is_textured = |material: &Material| {
            material.texture.is_some() || material.principled.is_some_and(|surface| surface.textures().next().is_some())
        };
        !self.colors().is_empty() || self.materials().iter().any(is_textured)
    }

    /// Returns whether some material has a cut-out.
    pub(crate) fn is_cut_out(&self) -> bool {
        self.materials().iter().any(|material| material.cutout.is_some())
    }

    /// Returns the cut-out texture of a triangle, if it has one.
    pub(crate) fn cutout_of(&self, triangle: &Triangle) -> Option<&Texture> {
        let cutout = self.materials()[triangle.material.0 as usize].cutout?;
        self.textures().get(cutout.0 as usize)
    }

    /// Returns the colours at the corners of each triangle, linear RGB. They multiply its albedo, and are white for
    /// triangles without any. The list is empty if no mesh has colours.
    pub fn colors(&self) -> &[[Vec3; 3]] {
        &self.beside.colors
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec4};

    use super::*;

    /// Makes triangles with texture coordinates and colours, if requested. Each triangle's values equal its number.
    fn strip(numbers: &[f32], uv: bool, colors: bool) -> Mesh {
        let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let mut mesh = Mesh::new(corners, vec![[0, 1, 2]; numbers.len()]);
        if uv {
            mesh = mesh.uv(numbers.iter().map(|&number| [Vec2::splat(number); 3]).collect());
        }
        if colors {
            mesh = mesh.colors(numbers.iter().map(|&number| [Vec3::splat(number); 3]).collect());
        }
        mesh
    }

    fn numbers(scene: &Scene) -> (Vec<f32>, Vec<f32>) {
        (scene.uv().iter().map(|uv| uv[2].y).collect(), scene.colors().iter().map(|colors| colors[1].z).collect())
    }

    #[test]
    fn lists_follow_their_triangles_and_go_with_the_last_mesh_that_has_any() {
        let mut scene = Scene::new();
        scene.add_mesh(&strip(&[9.0, 9.0], false, false)).unwrap();
        assert_eq!(numbers(&scene), (vec![], vec![]));
        scene.add_mesh(&strip(&[1.0, 2.0, 3.0], true, false)).unwrap();
        scene.add_mesh(&strip(&[4.0], false, true)).unwrap();
        assert_eq!(numbers(&scene), (vec![0., 0., 1., 2., 3., 0.], vec![1., 1., 1., 1., 1., 4.]));
        // A transform keeps the attributes; another mesh brings its own.
        scene.transform_object(1, &Affine3A::from_translation(Vec3::Z)).unwrap();
        assert_eq!(numbers(&scene).0, [0., 0., 1., 2., 3., 0.]);
        scene.set_mesh(0, &strip(&[5.0], true, true)).unwrap();
        assert_eq!(numbers(&scene), (vec![5., 1., 2., 3., 0.], vec![5., 1., 1., 1., 4.]));
        scene.set_mesh(1, &strip(&[6.0, 7.0], false, false)).unwrap();
        assert_eq!(numbers(&scene), (vec![5., 0., 0., 0.], vec![5., 1., 1., 4.]));
        scene.set_mesh(0, &strip(&[8.0, 8.0], false, false)).unwrap();
        assert_eq!(numbers(&scene), (vec![], vec![1., 1., 1., 1., 4.]));
        scene.set_mesh(2, &strip(&[], false, true)).unwrap();
        assert_eq!(numbers(&scene), (vec![], vec![]));
    }

    #[test]
    fn lists_that_do_not_fit_are_refused_by_name_and_change_nothing() {
        let mut scene = Scene::new();
        scene.add_mesh(&strip(&[1.0], true, true)).unwrap();
        let mut said = |mesh: Mesh| scene.set_mesh(0, &mesh.name("flag")).unwrap_err().to_string();
        let two = || strip(&[1.0, 2.0], true, true);
        for (mesh, expected) in [
            (two().uv(vec![NO_UV]), "texture coordinates: 1 for 2 triangles; give none, or three per triangle"),
            (two().colors(vec![NO_COLORS; 3]), "colours: 3 for 2 triangles; give none, or three per triangle"),
            (two().uv(vec![NO_UV, [Vec2::ZERO, Vec2::ZERO, Vec2::NAN]]), "triangle 1: a texture coordinate is not a"),
            (two().colors(vec![[Vec3::INFINITY; 3], NO_COLORS]), "triangle 0: a corner's colour is [inf"),
            (two().colors(vec![NO_COLORS, [-Vec3::X; 3]]), "triangle 1: a corner's colour is [-1"),
        ] {
            let message = said(mesh);
            assert!(message.contains("mesh 'flag', ") && message.contains(expected), "{expected}: {message}");
        }
        assert_eq!(numbers(&scene), (vec![1.0], vec![1.0]));
    }

    #[test]
    fn values_of_vertices_go_to_the_corners_and_must_fit() {
        let square = |last: u32| Mesh::new(vec![Vec3::ZERO; 4], vec![[0, 1, 2], [0, 2, last]]).name("flag");
        let values = [0.0, 1.0, 2.0, 3.0];
        let corners =
            |of: fn(f32) -> f32| [[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|at: usize| of(values[at])));
        let full = square(3).vertex_uv(&values.map(Vec2::splat)).unwrap();
        let full = full.vertex_colors(&values.map(|value| Vec3::splat(2.0 * value))).unwrap();
        let full = full.vertex_tangents(&values.map(|value| Vec4::splat(3.0 * value))).unwrap();
        assert_eq!(full.uv.iter().map(|corners| corners.map(|uv| uv.y)).collect::<Vec<_>>(), corners(|value| value));
        let colors: Vec<_> = full.colors.iter().map(|corners| corners.map(|color| color.z)).collect();
        assert_eq!(colors, corners(|value| 2.0 * value));
        let tangents: Vec<_> = full.tangents.iter().map(|corners| corners.map(|tangent| tangent.w)).collect();
        assert_eq!(tangents, corners(|value| 3.0 * value));
        let few = square(3).vertex_normals(&[Vec3::Z; 3]).unwrap_err().to_string();
        assert!(few.contains("mesh 'flag', normals: 3 for 4 vertices; give one per vertex"), "{few}");
        let beyond = square(4).vertex_normals(&[Vec3::Z; 4]).unwrap_err().to_string();
        assert!(beyond.contains("triangle 1: corner 4 is out of range"), "{beyond}");
    }
}
