//! MPI Sintel's layout: left disparities and masks, cameras, and flow.

use super::{Item, LayoutMotion, Root};
use crate::{
    Error, FlowClass, GroundTruth, Occlusion, StereoPair,
    output::{Batch, SINTEL_DISPARITIES},
};

/// Disparity in pixels from which the files can't hold it.
pub(super) const DISPARITY_LIMIT: f32 = SINTEL_DISPARITIES;
/// First four bytes of a .cam file.
const CAM: f32 = 202_021.25;

/// Adds a pair.
pub(super) fn pair(batch: &mut Batch, root: &Root<'_>, item: &Item<'_>) -> Result<(), Error> {
    frame(batch, root, (item.index, 1), item.pair, item.truth)
}

/// Adds the next pair as a second frame, and the left view's flow.
pub(super) fn motion(
    batch: &mut Batch,
    root: &Root<'_>,
    index: u32,
    pair: &StereoPair,
    motion: &LayoutMotion<'_>,
) -> Result<(), Error> {
    frame(batch, root, (index, 2), motion.pair, motion.truth)?;
    for (number, pair) in [(1, pair), (2, motion.pair)] {
        batch.add_png(root.file(&name("final", (index, number), "png"))?, &pair.left.picture())?;
    }
    let flow = &motion.forward.left;
    batch.add_flo(root.file(&name("flow", (index, 1), "flo"))?, flow)?;
    let mask = |is: fn(FlowClass) -> bool| Vec::from_iter(flow.class.iter().map(|&class| is(class)));
    let size = [flow.width, flow.height];
    let invalid = mask(|class| class == FlowClass::Behind);
    batch.add_mask(root.file(&name("invalid", (index, 1), "png"))?, size, &invalid)?;
    let lost = mask(|class| matches!(class, FlowClass::Hidden | FlowClass::OutOfFrame));
    batch.add_mask(root.file(&name("flow_occlusions", (index, 1), "png"))?, size, &lost)
}

/// Adds one frame of a sequence.
fn frame(
    batch: &mut Batch,
    root: &Root<'_>,
    of: (u32, u32),
    pair: &StereoPair,
    truth: &GroundTruth,
) -> Result<(), Error> {
    for (folder, view) in [("final_left", &pair.left), ("final_right", &pair.right)] {
        batch.add_png(root.file(&name(folder, of, "png"))?, &view.picture())?;
    }
    let (eye, size) = (&truth.left, [truth.left.width, truth.left.height]);
    batch.add_sintel_disparity(root.file(&name("disparities", of, "png"))?, size[0], size[1], &eye.disparity)?;
    for (folder, kind) in [("occlusions", Occlusion::Hidden), ("outofframe", Occlusion::OutOfFrame)] {
        let mask = Vec::from_iter(eye.occlusion.iter().map(|found| *found == kind));
        batch.add_mask(root.file(&name(folder, of, "png"))?, size, &mask)?;
    }
    let path = root.file(&name("camdata_left", of, "cam"))?;
    batch.add(path, &camera(truth)?)
}

/// Returns the path of a frame's file from the folder, the item, and the frame's number.
fn name(folder: &str, (index, frame): (u32, u32), ending: &str) -> String {
    format!("training/{folder}/{index:06}/frame_{frame:04}.{ending}")
}

/// Returns the left camera as Sintel's .cam file: 3x3 intrinsics and the 3x4 matrix from the world to the camera, as
/// f64, row by row. The camera's axes are right, down and forward. Principal points are relative to the centre of the
/// top left pixel.
fn camera(truth: &GroundTruth) -> Result<Vec<u8>, Error> {
    let pose = &truth.pose;
    let lens = pose.planar_intrinsics()?;
    let eye = pose.eye_position(-1.0);
    let axes = [pose.right, -pose.up, pose.forward].map(|axis| axis.as_dvec3().normalize());
    let intrinsics = [lens.fx, 0.0, lens.cx0 - 0.5, 0.0, lens.fy, lens.cy - 0.5, 0.0, 0.0, 1.0];
    let extrinsics = axes.map(|axis| [axis.x, axis.y, axis.z, -axis.dot(eye)]);
    let numbers = intrinsics.iter().chain(extrinsics.as_flattened());
    Ok(CAM.to_le_bytes().into_iter().chain(numbers.flat_map(|number| number.to_le_bytes())).collect())
}
