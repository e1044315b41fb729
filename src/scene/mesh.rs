//! Triangle meshes: what they are given as, what becomes of them in a scene, and what is wrong with them.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::{
    MaterialId, PRINTED_WARNINGS, Scene,
    checks::{check_coordinate, rounding_text},
    moving::Stamp,
};
use crate::{
    Error,
    message::{counted, tidy},
};

/// Indexed triangles that make one object.
///
/// ```
/// use stereotrace::{Mesh, Scene, glam::Vec3};
///
/// let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
/// Scene::new().add_mesh(&Mesh::new(corners, vec![[0, 1, 2]]).name("sail"))?;
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Mesh {
    /// The object's name, or empty.
    pub name: String,
    /// World positions.
    pub positions: Vec<Vec3>,
    /// Corners of each triangle, indices into `positions`.
    pub triangles: Vec<[u32; 3]>,
    /// One material a triangle, or a single one for all.
    pub materials: Vec<MaterialId>,
    /// Three unit normals a triangle for smooth shading, or empty: the triangles are flat.
    /// A triangle with a zero among its normals is flat too.
    pub normals: Vec<[Vec3; 3]>,
}

impl Mesh {
    /// Flat triangles of a scene's grey, without a name: world positions, and the corners of each triangle as indices into
    /// them.
    pub fn new(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Self {
        Self { name: String::new(), positions, triangles, materials: vec![MaterialId::default()], normals: Vec::new() }
    }

    /// The object's name.
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// One material a triangle, or a single one for all.
    pub fn materials(mut self, materials: Vec<MaterialId>) -> Self {
        self.materials = materials;
        self
    }

    /// Three unit normals a triangle for smooth shading, or none.
    pub fn normals(mut self, normals: Vec<[Vec3; 3]>) -> Self {
        self.normals = normals;
        self
    }
}

/// A primitive's place in its scene: which object it belongs to, and where objects begin.
#[derive(Clone, Debug)]
pub(crate) struct Object {
    pub(crate) name: String,
    pub(crate) first_primitive: u32,
}

/// A triangle with everything a renderer asks of it.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Triangle {
    /// Corners in world space.
    pub corners: [Vec3; 3],
    /// Shading normals at the corners; a zero among them makes the triangle flat.
    pub normals: [Vec3; 3],
    /// Its material.
    pub material: MaterialId,
}

impl Triangle {
    /// All three corners have normals.
    pub fn is_smooth(&self) -> bool {
        self.normals.iter().all(|normal| *normal != Vec3::ZERO)
    }

    /// No area (exactly, in f64), or a corner that is no number: it can't be hit.
    pub fn is_degenerate(&self) -> bool {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        let normal: DVec3 = (b - a).cross(c - a);
        normal == DVec3::ZERO || !normal.is_finite()
    }
}

impl Scene {
    /// Adds a mesh as one object. That triangles without area are dropped is logged as a warning.
    ///
    /// # Errors
    /// [`Error::Scene`], naming mesh and element, for an index out of range, a coordinate that is not finite or is
    /// larger than [`MAX_COORDINATE`](super::MAX_COORDINATE), lists whose lengths don't fit, or a material that is not
    /// there.
    pub fn add_mesh(&mut self, mesh: &Mesh) -> Result<(), Error> {
        let (first, dropped) = (self.triangles.len(), self.dropped);
        self.push_mesh(mesh)?;
        self.warn_of_dropped(&mesh.name, self.dropped - dropped, first..self.triangles.len());
        Ok(())
    }

    /// Says how many more of a mesh's triangles are dropped, of the first meshes that have such.
    pub(super) fn warn_of_dropped(&mut self, name: &str, dropped: usize, of: Range<usize>) {
        if dropped == 0 {
            return;
        }
        self.dropping_meshes += 1;
        let text = match self.dropping_meshes {
            0..=PRINTED_WARNINGS => dropped_text(dropped, &self.triangles[of]),
            next if next == PRINTED_WARNINGS + 1 => {
                "more meshes with triangles without area follow; they are counted".into()
            }
            _ => return,
        };
        log::warn!("{}", tidy(&format!("mesh '{name}': {text}")));
    }

    /// [`Scene::add_mesh`] without a word about dropped triangles.
    pub(super) fn push_mesh(&mut self, mesh: &Mesh) -> Result<(), Error> {
        let triangles = self.checked_triangles(mesh)?;
        let end = self.triangles.len();
        self.mesh_objects.push(Object { name: mesh.name.clone(), first_primitive: end as u32 });
        self.replace_triangles(end..end, triangles);
        Ok(())
    }

    /// Puts triangles in the place of others, and keeps count of what is dropped and smooth.
    pub(super) fn replace_triangles(&mut self, range: Range<usize>, by: Vec<Triangle>) {
        let counts = |triangles: &[Triangle]| {
            triangles.iter().fold((0, 0), |(dropped, smooth), triangle| match triangle.is_degenerate() {
                true => (dropped + 1, smooth),
                false => (dropped, smooth + usize::from(triangle.is_smooth())),
            })
        };
        let (before, after) = (counts(&self.triangles[range.clone()]), counts(&by));
        self.dropped = self.dropped + after.0 - before.0;
        self.smooth = self.smooth + after.1 - before.1;
        self.triangles.splice(range, by);
        self.triangles_stamp = Stamp::new();
    }

    /// A mesh's triangles, if the scene can take them.
    pub(super) fn checked_triangles(&self, mesh: &Mesh) -> Result<Vec<Triangle>, Error> {
        let fault = |element: String, reason: String| Error::Scene {
            element: format!("mesh '{}', {element}", mesh.name),
            reason,
        };
        for (index, &position) in mesh.positions.iter().enumerate() {
            check_coordinate(position).map_err(|reason| fault(format!("vertex {index}"), reason))?;
        }
        let count = mesh.triangles.len();
        let triangles = |count| counted(count, "triangle", "triangles");
        if mesh.materials.len() != 1 && mesh.materials.len() != count {
            let reason = format!("{} for {}; give one for all or one each", mesh.materials.len(), triangles(count));
            return Err(fault("materials".into(), reason));
        }
        if !mesh.normals.is_empty() && mesh.normals.len() != count {
            let reason = format!("{} for {}; give none or three each", mesh.normals.len(), triangles(count));
            return Err(fault("normals".into(), reason));
        }
        let mut triangles = Vec::with_capacity(count);
        for (index, corners) in mesh.triangles.iter().enumerate() {
            let at = || format!("triangle {index}");
            if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= mesh.positions.len()) {
                let reason = format!("corner {corner} of {}", counted(mesh.positions.len(), "vertex", "vertices"));
                return Err(fault(at(), reason));
            }
            let material = mesh.materials[if mesh.materials.len() == 1 { 0 } else { index }];
            self.check_material(material).map_err(|reason| fault(at(), reason))?;
            let normals = mesh.normals.get(index).copied().unwrap_or_default();
            if normals.iter().any(|normal| !normal.is_finite()) {
                return Err(fault(at(), "a normal is not a finite number".into()));
            }
            let corners = corners.map(|corner| mesh.positions[corner as usize]);
            triangles.push(Triangle { corners, normals, material });
        }
        Ok(triangles)
    }
}

/// What to say of dropped triangles: how many of these, and whether they were lost to the rounding of coordinates.
pub(super) fn dropped_text(dropped: usize, triangles: &[Triangle]) -> String {
    let corners = || triangles.iter().flat_map(|triangle| triangle.corners);
    let (low, high) = (corners().fold(Vec3::INFINITY, Vec3::min), corners().fold(Vec3::NEG_INFINITY, Vec3::max));
    let mut text = format!("triangles without area, which are dropped: {dropped} of {}", triangles.len());
    // A mesh about the origin is a million steps across, ten times as many as this; fewer lose detail.
    if let Some(rounded) = rounding_text(low, high, 1e-5) {
        text += &format!("; {rounded}: move it nearer to the origin");
    }
    text
}
