//! Writes ground truth files.

use std::{error::Error, path::Path};

use stereotrace::{Flow, GroundTruth, Layering, Layers, Projection, StereoPair, blocking::Wait, output::Batch};

use crate::arguments::Stage;

/// Adds the ground truth of both views. With lenses, places in the other picture replace disparities.
pub(crate) fn add_truth_of(
    batch: &mut Batch,
    stage: &Stage,
    pair: &StereoPair,
    folder: &Path,
) -> Result<(), Box<dyn Error>> {
    add_truth(batch, &stage.renderer.ground_truth(&stage.uploaded, &stage.scene, pair).wait()?, folder)?;
    if let Projection::Lenses(_) = pair.pose.projection {
        let matches = stage.renderer.correspondence(&stage.uploaded, pair).wait()?;
        for (n, eye) in [&matches.left, &matches.right].into_iter().enumerate() {
            batch.add_matches_flo(folder.join(format!("match{n}.flo")), eye)?;
        }
    }
    Ok(())
}

/// Adds the ground truth of both views. KITTI's disparities are added for parallel cameras only: with a finite screen
/// they are negative behind it, which these files can't hold.
fn add_truth(batch: &mut Batch, truth: &GroundTruth, folder: &Path) -> Result<(), Box<dyn Error>> {
    for (n, eye) in [&truth.left, &truth.right].into_iter().enumerate() {
        let (width, height) = (eye.width, eye.height);
        let file = |name: &str, ending: &str| folder.join(format!("{name}{n}.{ending}"));
        if !eye.disparity.is_empty() {
            batch.add_pfm(file("disp", "pfm"), width, height, &eye.disparity)?;
        }
        batch.add_nocc_mask(folder.join(format!("mask{n}nocc.png")), eye)?;
        batch.add_occlusion(file("occlusion", "png"), eye)?;
        batch.add_sky_mask(file("sky", "png"), eye)?;
        batch.add_pfm(file("depth_z", "pfm"), width, height, &eye.depth)?;
        batch.add_pfm(file("distance", "pfm"), width, height, &eye.distance)?;
        batch.add_pfm_color(file("normals", "pfm"), width, height, &eye.shading_normal)?;
        batch.add_ids_png(file("objects", "png"), width, height, &eye.object)?;
        batch.add_ids_png(file("materials", "png"), width, height, &eye.material)?;
        if truth.pose.intrinsics().is_some_and(|intrinsics| intrinsics.doffs() == 0.0) {
            let (all, of_both) = (eye.surfaces(), eye.surfaces_of_both());
            batch.add_kitti_disparity(file("disp_occ_", "png"), width, height, &eye.disparity, &all)?;
            batch.add_kitti_disparity(file("disp_noc_", "png"), width, height, &eye.disparity, &of_both)?;
        }
    }
    if truth.pose.intrinsics().is_some() {
        batch.add_calib(folder.join("calib.txt"), truth)?;
    }
    Ok(batch.add_camera_json(folder.join("camera.json"), &truth.pose)?)
}

/// Reads a number of surfaces, and what bends lines of sight: `4`, `4:refracted`, `4:mirrored` or both.
pub(crate) fn layering(text: &str) -> Result<Layering, String> {
    let mut parts = text.split(':');
    let surfaces = parts.next().and_then(|number| number.parse().ok());
    let most = Layering::MOST_SURFACES;
    let Some(surfaces) = surfaces.filter(|surfaces| (1..=most).contains(surfaces)) else {
        return Err(format!("it must begin with the number of surfaces, 1 to {most}"));
    };
    parts.try_fold(Layering::new(surfaces), |layering, part| match part {
        "refracted" => Ok(layering.refracted(true)),
        "mirrored" => Ok(layering.mirrored(true)),
        _ => Err(format!("unknown '{part}'; use refracted or mirrored")),
    })
}

/// Adds all surfaces along the lines of sight of both views. Layer 1 is the nearest one.
pub(crate) fn add_layers(batch: &mut Batch, layers: &Layers, folder: &Path) -> Result<(), Box<dyn Error>> {
    for (n, eye) in [&layers.left, &layers.right].into_iter().enumerate() {
        let (width, height) = (eye.width, eye.height);
        for layer in 0..eye.surfaces {
            let file = |name: &str, ending: &str| folder.join(format!("layer{}_{name}{n}.{ending}", layer + 1));
            for (name, list) in [
                ("disp", &eye.disparity),
                ("disp_y", &eye.vertical_disparity),
                ("depth_z", &eye.depth),
                ("distance", &eye.distance),
            ] {
                batch.add_pfm(file(name, "pfm"), width, height, eye.layer(list, layer))?;
            }
            batch.add_pfm_color(file("normals", "pfm"), width, height, eye.layer(&eye.shading_normal, layer))?;
            batch.add_ids_png(file("objects", "png"), width, height, eye.layer(&eye.object, layer))?;
            batch.add_ids_png(file("materials", "png"), width, height, eye.layer(&eye.material, layer))?;
            batch.add_layer_classes(file("class", "png"), eye, layer)?;
        }
    }
    Ok(())
}

/// Adds the motion of both views' points to the next picture (`forward`) or to the one before (`backward`).
pub(crate) fn add_flow(batch: &mut Batch, flow: &Flow, direction: &str, folder: &Path) -> Result<(), Box<dyn Error>> {
    for (n, eye) in [&flow.left, &flow.right].into_iter().enumerate() {
        let file = |name: &str, ending: &str| folder.join(format!("{name}_{direction}{n}.{ending}"));
        batch.add_flo(file("flow", "flo"), eye)?;
        batch.add_png(file("flow", "png"), &eye.picture(None))?;
        batch.add_flow_classes(file("flow_class", "png"), eye)?;
        // Eyes with lenses have none.
        if !eye.disparity_change.iter().all(|change| change.is_nan()) {
            batch.add_pfm(file("disp_change", "pfm"), eye.width, eye.height, &eye.disparity_change)?;
        }
        batch.add_pfm_color(file("scene_flow", "pfm"), eye.width, eye.height, &eye.displacement)?;
    }
    Ok(())
}
