//! Triangle meshes, their checks, and their triangles in a scene.

use std::{ops::Range, sync::Arc};

use glam::{DVec3, Vec2, Vec3, Vec4};

use super::{
    MaterialId, PRINTED_WARNINGS, Scene,
    checks::{check_color, check_coordinate, rounding_text},
    moving::Stamp,
};
use crate::{
    Error,
    message::{counted, tidy},
};

/// Indexed triangles that form one object. It can't be written as `Mesh { .. }`, since fields may be added. Begin with
/// [`Mesh::new`], and set the other fields by the methods with their names.
///
/// ```
/// use stereotrace::{Material, Mesh, Scene, glam::Vec3};
///
/// let mut scene = Scene::new();
/// let red = scene.add_material(Material::new(Vec3::new(0.8, 0.1, 0.1)));
/// let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
/// scene.add_mesh(&Mesh::new(corners, vec![[0, 1, 2]]).name("sail").materials(vec![red]))?;
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Mesh {
    /// Name of the object, or empty. Clones and the scene share it, since thousands of objects in a file may have the
    /// same long name.
    pub name: Arc<str>,
    /// Positions of the vertices, relative to [`Scene::origin`].
    pub positions: Vec<Vec3>,
    /// Corners of each triangle, as indices into `positions`.
    pub triangles: Vec<[u32; 3]>,
    /// One material per triangle, or a single one for all.
    pub materials: Vec<MaterialId>,
    /// Three unit normals per triangle for smooth shading, or empty for flat triangles. A triangle with a zero among
    /// its normals is flat too.
    pub normals: Vec<[Vec3; 3]>,
    /// Three texture coordinates per triangle, or empty. (0, 0) is a texture's lower left corner.
    pub uv: Vec<[Vec2; 3]>,
    /// Three colours per triangle that multiply the albedo, linear RGB, or empty.
    pub colors: Vec<[Vec3; 3]>,
    /// Three tangents per triangle for normal textures, or empty. A tangent is a unit vector towards growing u. Its w
    /// is 1 or -1, the factor of `cross(normal, tangent)` towards growing v. Without tangents, a mesh whose materials
    /// have normal textures gets those of `MikkTSpace` when it is added.
    pub tangents: Vec<[Vec4; 3]>,
}

impl Mesh {
    /// Makes flat triangles without a name, in the scene's grey material. `positions` are relative to
    /// [`Scene::origin`]; `triangles` are indices into them.
    pub fn new(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        Self { positions, triangles, materials: vec![MaterialId::default()], ..Self::default() }
    }

    /// Sets the object's name.
    pub fn name(mut self, name: impl Into<Arc<str>>) -> Self {
        self.name = name.into();
        self
    }

    /// Sets one material per triangle, or a single one for all.
    pub fn materials(mut self, materials: Vec<MaterialId>) -> Self {
        self.materials = materials;
        self
    }

    /// Sets three unit normals per triangle for smooth shading, or none. [`Mesh::vertex_normals`] takes one per vertex.
    pub fn normals(mut self, normals: Vec<[Vec3; 3]>) -> Self {
        self.normals = normals;
        self
    }

    /// Sets three texture coordinates per triangle, or none.
    pub fn uv(mut self, uv: Vec<[Vec2; 3]>) -> Self {
        self.uv = uv;
        self
    }

    /// Sets three linear RGB colours per triangle, or none.
    pub fn colors(mut self, colors: Vec<[Vec3; 3]>) -> Self {
        self.colors = colors;
        self
    }

    /// Sets three tangents per triangle for normal textures, or none.
    pub fn tangents(mut self, tangents: Vec<[Vec4; 3]>) -> Self {
        self.tangents = tangents;
        self
    }

    /// Sets a unit normal per vertex for smooth shading. The vertices and triangles must be set before.
    ///
    /// ```
    /// use stereotrace::{Mesh, glam::Vec3};
    ///
    /// // A square whose light varies as on a rounded one.
    /// let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    /// let normals = corners.map(|corner| (corner + 4.0 * Vec3::Z).normalize());
    /// let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).vertex_normals(&normals)?;
    /// assert_eq!(mesh.normals[1], [normals[0], normals[2], normals[3]]);
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Scene`] if there are not as many normals as vertices, or if a triangle's index is out of range.
    pub fn vertex_normals(mut self, normals: &[Vec3]) -> Result<Self, Error> {
        self.normals = self.at_corners("normals", normals)?;
        Ok(self)
    }

    /// Sets a texture coordinate per vertex. The vertices and triangles must be set before.
    ///
    /// # Errors
    /// The errors of [`Mesh::vertex_normals`].
    pub fn vertex_uv(mut self, uv: &[Vec2]) -> Result<Self, Error> {
        self.uv = self.at_corners("texture coordinates", uv)?;
        Ok(self)
    }

    /// Sets a linear RGB colour per vertex. The vertices and triangles must be set before.
    ///
    /// # Errors
    /// The errors of [`Mesh::vertex_normals`].
    pub fn vertex_colors(mut self, colors: &[Vec3]) -> Result<Self, Error> {
        self.colors = self.at_corners("colours", colors)?;
        Ok(self)
    }

    /// Sets a tangent per vertex for normal textures. The vertices and triangles must be set before.
    ///
    /// # Errors
    /// The errors of [`Mesh::vertex_normals`].
    pub fn vertex_tangents(mut self, tangents: &[Vec4]) -> Result<Self, Error> {
        self.tangents = self.at_corners("tangents", tangents)?;
        Ok(self)
    }

    /// Returns values of vertices for the corners of each triangle.
    fn at_corners<T: Copy>(&self, what: &str, of_vertices: &[T]) -> Result<Vec<[T; 3]>, Error> {
        if of_vertices.len() != self.positions.len() {
            let vertices = counted(self.positions.len(), "vertex", "vertices");
            return Err(self.fault(what, format!("{} for {vertices}; give one per vertex", of_vertices.len())));
        }
        let corners = |(index, corners): (usize, &[u32; 3])| {
            self.check_corners(index).map_err(|reason| self.fault(&format!("triangle {index}"), reason))?;
            Ok(corners.map(|corner| of_vertices[corner as usize]))
        };
        self.triangles.iter().enumerate().map(corners).collect()
    }

    pub(crate) fn fault(&self, element: &str, reason: String) -> Error {
        Error::Scene { element: format!("mesh '{}', {element}", self.name), reason }
    }

    pub(crate) fn check_corners(&self, triangle: usize) -> Result<(), String> {
        match self.triangles[triangle].iter().find(|&&corner| corner as usize >= self.positions.len()) {
            None => Ok(()),
            Some(corner) => Err(format!(
                "corner {corner} is out of range for {}",
                counted(self.positions.len(), "vertex", "vertices")
            )),
        }
    }

    /// Checks the lengths of the lists, and that texture coordinates and colours are valid.
    fn check_lists(&self) -> Result<(), (String, String)> {
        let count = self.triangles.len();
        let triangles = counted(count, "triangle", "triangles");
        if self.materials.len() != 1 && self.materials.len() != count {
            let reason = format!("{} for {triangles}; give one, or one per triangle", self.materials.len());
            return Err(("materials".into(), reason));
        }
        let lists = [
            ("normals", self.normals.len()),
            ("texture coordinates", self.uv.len()),
            ("colours", self.colors.len()),
            ("tangents", self.tangents.len()),
        ];
        if let Some((what, found)) = lists.into_iter().find(|(_, found)| *found != 0 && *found != count) {
            return Err((what.into(), format!("{found} for {triangles}; give none, or three per triangle")));
        }
        if let Some(index) = self.uv.iter().position(|uv| uv.iter().any(|uv| !uv.is_finite())) {
            return Err((format!("triangle {index}"), "a texture coordinate is not a finite number".into()));
        }
        if let Some(index) = self.tangents.iter().position(|corners| corners.iter().any(|one| !one.is_finite())) {
            return Err((format!("triangle {index}"), "a tangent is not a finite number".into()));
        }
        for (index, colors) in self.colors.iter().enumerate() {
            let check = colors.iter().try_for_each(|color| check_color("a corner's colour", *color));
            check.map_err(|reason| (format!("triangle {index}"), reason))?;
        }
        Ok(())
    }
}

/// A mesh object in a scene. Its primitives begin at `first_primitive`.
#[derive(Clone, Debug)]
pub(crate) struct Object {
    pub(crate) name: Arc<str>,
    pub(crate) first_primitive: u32,
    pub(crate) has_uv: bool,
    pub(crate) has_colors: bool,
    pub(crate) has_tangents: bool,
    /// Stamp that changes with the mesh.
    pub(crate) stamp: Stamp,
}

impl Object {
    pub(crate) fn new(mesh: &Mesh, has_tangents: bool, first_primitive: u32) -> Self {
        let [has_uv, has_colors] = [!mesh.uv.is_empty(), !mesh.colors.is_empty()];
        Self { name: mesh.name.clone(), first_primitive, has_uv, has_colors, has_tangents, stamp: Stamp::new() }
    }
}

/// A triangle with its shading normals and material.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Triangle {
    /// Corners, relative to [`Scene::origin`].
    pub corners: [Vec3; 3],
    /// Shading normals at the corners; a zero among them makes the triangle flat.
    pub normals: [Vec3; 3],
    /// Its material.
    pub material: MaterialId,
}

impl Triangle {
    /// Returns whether all three corners have normals.
    pub fn is_smooth(&self) -> bool {
        self.normals.iter().all(|normal| *normal != Vec3::ZERO)
    }

    /// Returns whether the triangle has no area (exactly, in f64) or a corner that is not finite. Rays can't hit it.
    pub fn is_degenerate(&self) -> bool {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        let normal: DVec3 = (b - a).cross(c - a);
        normal == DVec3::ZERO || !normal.is_finite()
    }
}

impl Scene {
    /// Adds a mesh as one object. Triangles without area are dropped, with a warning.
    ///
    /// # Errors
    /// [`Error::Scene`], naming mesh and element, for:
    ///
    /// - an index out of range, or an unknown material,
    /// - a coordinate that is not finite or larger than [`MAX_COORDINATE`](super::MAX_COORDINATE),
    /// - lists whose lengths don't match,
    /// - a normal, tangent, texture coordinate or colour that is not finite, or a negative colour.
    pub fn add_mesh(&mut self, mesh: &Mesh) -> Result<(), Error> {
        let (first, dropped) = (self.triangles.len(), self.dropped);
        self.push_mesh(mesh)?;
        self.warn_of_dropped(&mesh.name, self.dropped - dropped, first..self.triangles.len());
        Ok(())
    }

    /// Logs how many triangles of a mesh were dropped. Only the first such meshes are logged.
    pub(crate) fn warn_of_dropped(&mut self, name: &str, dropped: usize, of: Range<usize>) {
        if dropped == 0 {
            return;
        }
        self.dropping_meshes += 1;
        let text = match self.dropping_meshes {
            0..=PRINTED_WARNINGS => dropped_text(dropped, &self.triangles[of]),
            next if next == PRINTED_WARNINGS + 1 => {
                "more meshes have triangles without area; they are counted but not listed".into()
            }
            _ => return,
        };
        log::warn!("{}", tidy(&format!("mesh '{name}': {text}")));
    }

    /// Adds a mesh as [`Scene::add_mesh`] does, without a warning about dropped triangles.
    pub(crate) fn push_mesh(&mut self, mesh: &Mesh) -> Result<(), Error> {
        let triangles = self.checked_triangles(mesh)?;
        let tangents = self.tangents_of(mesh, &triangles);
        self.push_checked(mesh, triangles, &tangents);
        Ok(())
    }

    /// Adds a mesh with these tangents, whose triangles have been checked.
    pub(crate) fn push_checked(&mut self, mesh: &Mesh, triangles: Vec<Triangle>, tangents: &[[Vec4; 3]]) {
        let end = self.triangles.len();
        self.mesh_objects.push(Object::new(mesh, !tangents.is_empty(), end as u32));
        self.beside.replace(end..end, (mesh, tangents), None, end);
        self.replace_triangles(end..end, triangles);
    }

    /// Replaces a range of triangles and updates the counts of dropped and smooth ones.
    pub(crate) fn replace_triangles(&mut self, range: Range<usize>, by: Vec<Triangle>) {
        let counts = |triangles: &[Triangle]| {
            triangles.iter().fold((0, 0), |(dropped, smooth), triangle| match triangle.is_degenerate() {
                true => (dropped + 1, smooth),
                false => (dropped, smooth + usize::from(triangle.is_smooth())),
            })
        };
        let (before, after) = (counts(&self.triangles[range.clone()]), counts(&by));
        self.dropped = self.dropped + after.0 - before.0;
        self.smooth = self.smooth + after.1 - before.1;
        // The first mesh often holds most of a large file's memory, so it is moved, not copied.
        match self.triangles.is_empty() {
            true => self.triangles = by,
            false => drop(self.triangles.splice(range, by)),
        }
        self.triangles_stamp = Stamp::new();
    }

    /// Returns a mesh's triangles, after checking it against the scene.
    pub(crate) fn checked_triangles(&self, mesh: &Mesh) -> Result<Vec<Triangle>, Error> {
        for (index, &position) in mesh.positions.iter().enumerate() {
            check_coordinate(position).map_err(|reason| mesh.fault(&format!("vertex {index}"), reason))?;
        }
        mesh.check_lists().map_err(|(element, reason)| mesh.fault(&element, reason))?;
        let mut triangles = Vec::with_capacity(mesh.triangles.len());
        for (index, corners) in mesh.triangles.iter().enumerate() {
            let at = || format!("triangle {index}");
            mesh.check_corners(index).map_err(|reason| mesh.fault(&at(), reason))?;
            let material = mesh.materials[if mesh.materials.len() == 1 { 0 } else { index }];
            self.check_material(material).map_err(|reason| mesh.fault(&at(), reason))?;
            let normals = mesh.normals.get(index).copied().unwrap_or_default();
            if normals.iter().any(|normal| !normal.is_finite()) {
                return Err(mesh.fault(&at(), "a normal is not a finite number".into()));
            }
            let corners = corners.map(|corner| mesh.positions[corner as usize]);
            triangles.push(Triangle { corners, normals, material });
        }
        Ok(triangles)
    }
}

/// Returns a message about dropped triangles: how many there are, and whether the rounding of coordinates caused it.
pub(crate) fn dropped_text(dropped: usize, triangles: &[Triangle]) -> String {
    let corners = || triangles.iter().flat_map(|triangle| triangle.corners);
    let (low, high) = (corners().fold(Vec3::INFINITY, Vec3::min), corners().fold(Vec3::NEG_INFINITY, Vec3::max));
    let mut text = format!("dropped triangles without area: {dropped} of {}", triangles.len());
    // A mesh at the origin is a million f32 steps across, ten times as many as this limit. Fewer steps lose detail.
    if let Some(rounded) = rounding_text(low, high, 1e-5) {
        text += &format!("; {rounded}: move it nearer to the origin");
    }
    text
}
