//! Joins tobj's models into meshes.

use glam::{Vec2, Vec3};

use super::{MaterialId, Mesh, Prepared, Section, mtl::Placement};
use crate::{
    import::polygon::{Split, split},
    scene::{linear, smooth::unit},
};

/// Meshes made from tobj's models.
#[derive(Default)]
pub(super) struct Joined {
    /// The objects, with the smoothing group of each triangle if groups matter.
    pub(super) meshes: Vec<(Mesh, Vec<u32>)>,
    /// Lines of faces without a correct split.
    pub(super) fanned: Vec<usize>,
    /// Number of vertices with colours outside 0 to 1.
    pub(super) clamped_colors: usize,
}

/// Makes one mesh per object from tobj's models, which end at each change of material and section. `placements` has the
/// texture placement of each material.
pub(super) fn join_models(models: &[tobj::Model], prepared: &Prepared, placements: &[Placement]) -> Joined {
    let Prepared { sections, names, .. } = prepared;
    let mut lines = prepared.polygon_lines.iter().copied();
    let mut joined = Joined::default();
    let has_objects = sections.iter().any(|section| section.object > 0);
    let mut last: Option<&Section> = None;
    // The last model has no faces if nothing follows the last section's name.
    for model in models.iter().filter(|model| !model.mesh.indices.is_empty()) {
        let section =
            model.name.parse().ok().and_then(|index: usize| sections.get(index)).expect("prepare names every model");
        let continues = last.is_some_and(|last| match has_objects {
            true => last.object == section.object,
            // The index is compared first, since thousands of sections may share a long name.
            false => last.group_name == section.group_name || names[last.group_name] == names[section.group_name],
        });
        last = Some(section);
        if !continues {
            let name = if has_objects { section.object_name } else { section.group_name };
            joined.meshes.push((Mesh::default().name(names[name].clone()), Vec::new()));
        }
        if let Some((mesh, groups)) = joined.meshes.last_mut() {
            let placement = model.mesh.material_id.and_then(|index| placements.get(index)).copied().unwrap_or_default();
            add_model(mesh, &model.mesh, placement, &mut lines, &mut joined.fanned);
            if prepared.smooths {
                groups.resize(mesh.triangles.len(), section.smoothing);
            }
        }
        let color = |color: &&[f32; 3]| color.iter().any(|value| !(0.0..=1.0).contains(value));
        joined.clamped_colors += model.mesh.vertex_color.as_chunks::<3>().0.iter().filter(color).count();
    }
    for (mesh, _) in &mut joined.meshes {
        let count = mesh.triangles.len();
        fill(&mut mesh.normals, count, [Vec3::ZERO; 3]);
        fill(&mut mesh.uv, count, [Vec2::ZERO; 3]);
        fill(&mut mesh.colors, count, [Vec3::ONE; 3]);
    }
    joined
}

/// Extends a list to one entry per triangle, unless it is empty.
fn fill<T: Clone>(list: &mut Vec<T>, count: usize, none: T) {
    if !list.is_empty() {
        list.resize(count, none);
    }
}

/// Adds a model's triangles. `lines` yields the lines of its faces with more than three corners.
fn add_model(
    mesh: &mut Mesh,
    model: &tobj::Mesh,
    placement: Placement,
    lines: &mut impl Iterator<Item = usize>,
    fanned: &mut Vec<usize>,
) {
    let first_vertex = mesh.positions.len() as u32;
    let before = mesh.triangles.len();
    let (positions, _) = model.positions.as_chunks::<3>();
    mesh.positions.extend(positions.iter().copied().map(Vec3::from_array));
    let triangles = split_faces(model, &mesh.positions[first_vertex as usize..], lines, fanned);
    mesh.triangles.extend(triangles.iter().map(|corners| corners.map(|corner| first_vertex + corner)));
    let material = model.material_id.map_or(MaterialId(0), |index| MaterialId(index as u32 + 1));
    mesh.materials.resize(mesh.triangles.len(), material);
    // If there are fewer normals than positions, some corner has none, and the list does not say which. Attributes that
    // earlier models lack are filled in.
    let (normals, _) = model.normals.as_chunks::<3>();
    if normals.len() == positions.len() {
        mesh.normals.resize(before, [Vec3::ZERO; 3]);
        mesh.normals.extend(triangles.iter().map(|corners| {
            let normals = corners.map(|corner| unit(Vec3::from_array(normals[corner as usize])));
            if normals.contains(&Vec3::ZERO) { [Vec3::ZERO; 3] } else { normals }
        }));
    }
    let (uv, _) = model.texcoords.as_chunks::<2>();
    if uv.len() == positions.len() {
        mesh.uv.resize(before, [Vec2::ZERO; 3]);
        let place = |corner: u32| placement.place(Vec2::from_array(uv[corner as usize]));
        mesh.uv.extend(triangles.iter().map(|corners| corners.map(place)));
    }
    let (colors, _) = model.vertex_color.as_chunks::<3>();
    if colors.len() == positions.len() {
        mesh.colors.resize(before, [Vec3::ONE; 3]);
        let linear: Vec<Vec3> = colors.iter().map(|color| linear_color(*color)).collect();
        mesh.colors.extend(triangles.iter().map(|corners| corners.map(|corner| linear[corner as usize])));
    }
}

/// Converts a vertex colour to linear light. Scanners and modellers write sRGB colours.
fn linear_color(color: [f32; 3]) -> Vec3 {
    Vec3::from_array(color.map(|value| linear(value.clamp(0.0, 1.0))))
}

/// Returns the triangles of a model's faces.
fn split_faces(
    model: &tobj::Mesh,
    positions: &[Vec3],
    lines: &mut impl Iterator<Item = usize>,
    fanned: &mut Vec<usize>,
) -> Vec<[u32; 3]> {
    if model.face_arities.is_empty() {
        return model.indices.as_chunks::<3>().0.to_vec(); // all are triangles
    }
    let mut triangles = Vec::with_capacity(model.indices.len() - 2 * model.face_arities.len());
    let (mut indices, mut corners) = (model.indices.as_slice(), Vec::new());
    for &arity in &model.face_arities {
        let (face, others) = indices.split_at(arity as usize);
        indices = others;
        let line = if face.len() > 3 { lines.next() } else { None };
        corners.clear();
        corners.extend(face.iter().map(|&corner| positions[corner as usize]));
        match split(&corners) {
            Split::Ears(ears) => triangles.extend(ears.into_iter().map(|ear| ear.map(|corner| face[corner]))),
            fan => {
                fanned.extend(line.filter(|_| matches!(fan, Split::Unknown)));
                triangles.extend(face[1..].windows(2).map(|pair| [face[0], pair[0], pair[1]]));
            }
        }
    }
    triangles
}
