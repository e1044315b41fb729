//! Meshes out of tobj's models.

use glam::Vec3;

use super::{MaterialId, Mesh, Prepared, Section};

/// Makes one mesh of each object out of tobj's models, which end at each change of material and section.
pub(super) fn join_models(models: &[tobj::Model], prepared: &Prepared) -> Vec<Mesh> {
    let Prepared { sections, names, .. } = prepared;
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
            add_model(mesh, &model.mesh);
        }
    }
    for mesh in &mut meshes {
        if !mesh.normals.is_empty() {
            mesh.normals.resize(mesh.triangles.len(), [Vec3::ZERO; 3]);
        }
    }
    meshes
}

fn add_model(mesh: &mut Mesh, model: &tobj::Mesh) {
    let first_vertex = mesh.positions.len() as u32;
    let first_triangle = mesh.triangles.len();
    let (positions, _) = model.positions.as_chunks::<3>();
    let (triangles, _) = model.indices.as_chunks::<3>();
    mesh.positions.extend(positions.iter().copied().map(Vec3::from_array));
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

/// Zero has no direction and stays zero; f64, so that tiny and huge normals keep theirs.
fn unit(normal: Vec3) -> Vec3 {
    normal.as_dvec3().normalize_or_zero().as_vec3()
}
