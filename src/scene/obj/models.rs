//! Meshes out of tobj's models.

use glam::Vec3;

use super::{
    MaterialId, Mesh, Prepared, Section,
    polygon::{Split, split},
};

/// Makes one mesh of each object out of tobj's models, which end at each change of material and section. Returns the lines
/// of faces for which no split was found, too.
pub(super) fn join_models(models: &[tobj::Model], prepared: &Prepared) -> (Vec<Mesh>, Vec<usize>) {
    let Prepared { sections, names, .. } = prepared;
    let mut lines = prepared.polygon_lines.iter().copied();
    let mut fanned = Vec::new();
    let has_objects = sections.iter().any(|section| section.object > 0);
    let mut meshes: Vec<Mesh> = Vec::new();
    let mut last: Option<&Section> = None;
    // The last model has no faces if nothing follows the last section's name.
    for model in models.iter().filter(|model| !model.mesh.indices.is_empty()) {
        let section =
            model.name.parse().ok().and_then(|index: usize| sections.get(index)).expect("prepare names every model");
        let continues = last.is_some_and(|last| match has_objects {
            true => last.object == section.object,
            false => names[last.group_name] == names[section.group_name],
        });
        last = Some(section);
        if !continues {
            let name = if has_objects { section.object_name } else { section.group_name };
            meshes.push(Mesh { name: names[name].clone(), ..Mesh::default() });
        }
        if let Some(mesh) = meshes.last_mut() {
            add_model(mesh, &model.mesh, &mut lines, &mut fanned);
        }
    }
    for mesh in &mut meshes {
        if !mesh.normals.is_empty() {
            mesh.normals.resize(mesh.triangles.len(), [Vec3::ZERO; 3]);
        }
    }
    (meshes, fanned)
}

/// Adds a model's triangles. `lines` are those of the faces of more than three corners from the model's first on.
fn add_model(mesh: &mut Mesh, model: &tobj::Mesh, lines: &mut impl Iterator<Item = usize>, fanned: &mut Vec<usize>) {
    let first_vertex = mesh.positions.len() as u32;
    let first_triangle = mesh.triangles.len();
    let (positions, _) = model.positions.as_chunks::<3>();
    mesh.positions.extend(positions.iter().copied().map(Vec3::from_array));
    let triangles = split_faces(model, &mesh.positions[first_vertex as usize..], lines, fanned);
    mesh.triangles.extend(triangles.iter().map(|corners| corners.map(|corner| first_vertex + corner)));
    let material = model.material_id.map_or(MaterialId(0), |index| MaterialId(index as u32 + 1));
    mesh.materials.resize(mesh.triangles.len(), material);
    // Fewer normals than positions: some corner has none, and the list no longer says which.
    if model.normals.len() == model.positions.len() {
        // Normals that tobj left out for a flat model before this one.
        mesh.normals.resize(first_triangle, [Vec3::ZERO; 3]);
        let (normals, _) = model.normals.as_chunks::<3>();
        mesh.normals.extend(triangles.iter().map(|corners| {
            let normals = corners.map(|corner| unit(Vec3::from_array(normals[corner as usize])));
            if normals.contains(&Vec3::ZERO) { [Vec3::ZERO; 3] } else { normals }
        }));
    }
}

/// The triangles of a model's faces.
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

/// Zero has no direction and stays zero; f64, so that tiny and huge normals keep theirs.
fn unit(normal: Vec3) -> Vec3 {
    normal.as_dvec3().normalize_or_zero().as_vec3()
}
