//! Writes geometry and rays as plain little-endian arrays, which other tracers can read (scripts/embree.py).

use std::{error::Error, fs, path::Path};

use stereotrace::{Scene, output::Batch};

use crate::lists::{Kind, Query};

/// Writes `triangles.f32` with nine numbers per triangle. For each kind of ray it writes `KIND.QUERY.f32` with eight
/// numbers per ray: origin, direction, `t_min`, `t_max`. Spheres are left out.
pub(crate) fn write(folder: &Path, scene: &Scene, kinds: &[Kind]) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    let corners = scene.triangles().iter().flat_map(|triangle| triangle.corners).flat_map(|corner| corner.to_array());
    let mut batch = Batch::new();
    batch.add(folder.join("triangles.f32"), &bytes(corners))?;
    for kind in kinds {
        let numbers = kind.lists.iter().flatten().flat_map(|ray| {
            ray.origin.as_vec3().to_array().into_iter().chain(ray.direction.to_array()).chain([ray.t_min, ray.t_max])
        });
        let query = if kind.query == Query::Closest { "closest" } else { "any" };
        let name = kind.name.replace([' ', '%'], "-");
        batch.add(folder.join(format!("{name}.{query}.f32")), &bytes(numbers))?;
    }
    batch.commit()?;
    Ok(())
}

fn bytes(numbers: impl Iterator<Item = f32>) -> Vec<u8> {
    numbers.flat_map(f32::to_le_bytes).collect()
}
