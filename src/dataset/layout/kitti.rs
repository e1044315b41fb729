//! KITTI 2015's layout: left disparities, flow, and the second frame's disparities.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use glam::DVec3;

use super::{Item, Layout, LayoutMotion, Root};
use crate::{Error, EyeFlow, EyeTruth, GroundTruth, MISS, output::Batch, view::camera::Intrinsics};

/// Adds a pair.
pub(super) fn pair(batch: &mut Batch, root: &Root<'_>, item: &Item<'_>) -> Result<(), Error> {
    let Item { index, pair, truth } = item;
    let file = |folder: &str| root.file(&format!("training/{folder}/{index:06}_10.png"));
    batch.add_png(file("image_2")?, &pair.left.picture())?;
    batch.add_png(file("image_3")?, &pair.right.picture())?;
    let EyeTruth { width, height, disparity, .. } = &truth.left;
    batch.add_kitti_disparity(file("disp_occ_0")?, *width, *height, disparity, &truth.left.surfaces())?;
    batch.add_kitti_disparity(file("disp_noc_0")?, *width, *height, disparity, &truth.left.surfaces_of_both())?;
    let calibration = calibration(truth)?;
    batch.add(root.file(&format!("training/calib_cam_to_cam/{index:06}.txt"))?, calibration.as_bytes())
}

/// Adds the next pair, and the motion of the left view's points to it.
pub(super) fn motion(
    batch: &mut Batch,
    root: &Root<'_>,
    index: u32,
    truth: &GroundTruth,
    motion: &LayoutMotion<'_>,
) -> Result<(), Error> {
    let file = |folder: &str, number: u32| root.file(&format!("training/{folder}/{index:06}_{number}.png"));
    batch.add_png(file("image_2", 11)?, &motion.pair.left.picture())?;
    batch.add_png(file("image_3", 11)?, &motion.pair.right.picture())?;
    let (eye, flow) = (&truth.left, &motion.forward.left);
    let both = |one: Vec<bool>, other: Vec<bool>| Vec::from_iter(one.into_iter().zip(other).map(|(a, b)| a && b));
    batch.add_kitti_flow(file("flow_occ", 10)?, flow, &both(eye.surfaces(), flow.known()))?;
    batch.add_kitti_flow(file("flow_noc", 10)?, flow, &both(eye.surfaces(), flow.visible()))?;
    let then = eye.disparity.iter().zip(&flow.disparity_change).map(|(now, change)| now + change);
    let then: Vec<f32> = then.collect();
    // Points that have left the picture may have any disparity.
    let fits = then.iter().map(|&disparity| disparity > 0.0 && disparity < Layout::Kitti.disparity_limit() - 0.5);
    let valid = both(both(eye.surfaces(), flow.known()), fits.collect());
    batch.add_kitti_disparity(file("disp_occ_1", 10)?, eye.width, eye.height, &then, &valid)?;
    let seen = both(seen_by_both(motion), both(valid, flow.visible()));
    batch.add_kitti_disparity(file("disp_noc_1", 10)?, eye.width, eye.height, &then, &seen)?;
    let path = file("obj_map", 10)?;
    let objects = moving_objects(&path, eye, flow)?;
    batch.add_grey8(&path, [eye.width, eye.height], &objects)
}

/// Returns, for each pixel, whether both eyes see its point at the next time, as far as the next left view's nearest
/// pixel tells.
fn seen_by_both(motion: &LayoutMotion<'_>) -> Vec<bool> {
    let (flow, next) = (&motion.forward.left, &motion.truth.left);
    let seen = next.surfaces_of_both();
    let place = |(index, [u, v]): (usize, &[f32; 2])| {
        let width = flow.width as usize;
        let [x, y] = [(index % width) as f32 + 0.5 + u, (index / width) as f32 + 0.5 + v];
        let is_inside = (0.0..next.width as f32).contains(&x) && (0.0..next.height as f32).contains(&y);
        is_inside && seen[y as usize * next.width as usize + x as usize]
    };
    flow.flow.iter().enumerate().map(place).collect()
}

/// Returns a number from 1 for each object that moves, in the order of ids, and 0 elsewhere.
fn moving_objects(path: &Path, eye: &EyeTruth, flow: &EyeFlow) -> Result<Vec<u8>, Error> {
    let moves = |(&object, step): (&u32, &[f32; 3])| (object != MISS && *step != [0.0; 3]).then_some(object);
    let moving: BTreeSet<u32> = eye.object.iter().zip(&flow.displacement).filter_map(moves).collect();
    if moving.len() > usize::from(u8::MAX) {
        let text = format!("{} objects move, but KITTI's map holds 255", moving.len());
        return Err(Error::unwritable(path, text));
    }
    let numbers: BTreeMap<u32, u8> = moving.into_iter().zip(1..).collect();
    Ok(eye.object.iter().map(|object| numbers.get(object).copied().unwrap_or(0)).collect())
}

/// Returns KITTI's calibration text. Camera 2 is the left one, at the origin of the rectified frame, and camera 3 is
/// the right one. Principal points are relative to the centre of the top left pixel.
fn calibration(truth: &GroundTruth) -> Result<String, Error> {
    let pose = &truth.pose;
    let [width, height] = pose.size;
    let Intrinsics { fx, fy, cx0, cx1, cy } = pose.planar_intrinsics()?;
    let cy = cy - 0.5;
    let mut text = String::new();
    let rounding = pose.baseline_rounding();
    // Vector from the right eye to the left eye: right, down, forward. Apart from rounding, the right eye is on the
    // left eye's x axis.
    let to_left = DVec3::new(-pose.baseline(), rounding.y, -rounding.z) + DVec3::ZERO; // avoids -0
    for (name, cx, shift) in [("02", cx0 - 0.5, DVec3::ZERO), ("03", cx1 - 0.5, to_left)] {
        let DVec3 { x, y, z } = shift;
        let (right, down) = (fx * x + cx * z, fy * y + cy * z);
        text += &format!(
            "S_{name}: {width} {height}\nK_{name}: {fx} 0 {cx} 0 {fy} {cy} 0 0 1\nD_{name}: 0 0 0 0 0\n\
             R_{name}: 1 0 0 0 1 0 0 0 1\nT_{name}: {x} {y} {z}\nS_rect_{name}: {width} {height}\n\
             R_rect_{name}: 1 0 0 0 1 0 0 0 1\nP_rect_{name}: {fx} 0 {cx} {right} 0 {fy} {cy} {down} 0 0 1 {z}\n"
        );
    }
    Ok(text)
}
