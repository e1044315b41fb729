//! Scene Flow's layout, as in Monkaa and Driving.

use super::{Item, Root};
use crate::{Error, Flow, GroundTruth, output::Batch};

/// Adds a pair.
pub(super) fn pair(batch: &mut Batch, root: &Root<'_>, item: &Item<'_>) -> Result<(), Error> {
    let Item { index, pair, truth } = item;
    for (eye, view, truth) in [("left", &pair.left, &truth.left), ("right", &pair.right, &truth.right)] {
        let file = |kind: &str, ending: &str| root.file(&format!("{kind}/stereotrace/{eye}/{index:04}.{ending}"));
        batch.add_png(file("frames_finalpass", "png")?, &view.picture())?;
        batch.add_pfm(file("disparity", "pfm")?, truth.width, truth.height, &truth.disparity)?;
        for (kind, ids) in [("object_index", &truth.object), ("material_index", &truth.material)] {
            batch.add_indices_pfm(file(kind, "pfm")?, truth.width, truth.height, ids)?;
        }
    }
    let path = root.file(&format!("camera_data/stereotrace/{index:04}.txt"))?;
    batch.add(path, camera_data(*index, truth).as_bytes())
}

/// Adds the flow and the change of disparity of frame `index`.
pub(super) fn motion(
    batch: &mut Batch,
    root: &Root<'_>,
    index: u32,
    (folder, name): (&str, &str),
    flow: &Flow,
) -> Result<(), Error> {
    for (eye, letter, flow) in [("left", 'L', &flow.left), ("right", 'R', &flow.right)] {
        let file = format!("optical_flow/stereotrace/{folder}/{eye}/OpticalFlow{name}_{index:04}_{letter}.pfm");
        batch.add_flow_pfm(root.file(&file)?, flow)?;
        let file = format!("disparity_change/stereotrace/{folder}/{eye}/{index:04}.pfm");
        batch.add_pfm(root.file(&file)?, flow.width, flow.height, &flow.disparity_change)?;
    }
    Ok(())
}

/// Returns an entry of `camera_data.txt`: the matrices from an eye's frame to the world, row by row. The frame has x
/// right, y up, and the camera looks along -z.
fn camera_data(index: u32, truth: &GroundTruth) -> String {
    let pose = &truth.pose;
    let [right, up, back] = [pose.right, pose.up, -pose.forward].map(|axis| axis.as_dvec3());
    let matrix = |side: f32| {
        let eye = pose.eye_position(side);
        let rows = [0, 1, 2].map(|axis| format!("{} {} {} {}", right[axis], up[axis], back[axis], eye[axis]));
        format!("{} 0 0 0 1", rows.join(" "))
    };
    format!("Frame {index}\nL {}\nR {}\n\n", matrix(-1.0), matrix(1.0))
}
