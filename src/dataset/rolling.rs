//! Rolling shutter: each band of rows shows the scene at a time of its own, and so does its ground truth.

use std::ops::Range;

use super::{
    maker::{Shown, Take},
    shutter,
    spec::{Motion, RollingShutter},
    stage::Stage,
};
use crate::{Error, GroundTruth, OnProgress, Renderer, StereoCamera, StereoPair, view::camera::Intrinsics};

/// Renders a pair band by band. The middle row shows the pair's own time.
pub(super) async fn shown(
    renderer: &mut Renderer,
    stage: &mut Stage,
    take: &Take<'_>,
    (motion, rolling): (&Motion, &RollingShutter),
    progress: &mut OnProgress<'_>,
) -> Result<Shown, Error> {
    let Take { spec, draws, camera, needs_truth, .. } = *take;
    let pose = camera.pose()?;
    let height = pose.size[1];
    let readout = draws.draw(&rolling.readout, "motion.rolling.readout");
    let mut found: Option<(StereoPair, Option<GroundTruth>)> = None;
    for (number, rows) in bands(height, rolling.bands).enumerate() {
        let time = readout * (0.5 * f64::from(rows.start + rows.end) / f64::from(height) - 0.5);
        // Samples would be at the same places in each band.
        let options = &take.options.clone().seed(take.options.seed.wrapping_add(number as u32));
        let blur = shutter::blur(renderer, stage, &Take { options, ..*take }, motion, (time, Some(&rows))).await?;
        let there = stage.advance(renderer, (motion, spec.poses.path()), draws, camera, time).await?;
        let (scene, uploaded) = stage.next()?;
        let part = camera_of(&there, &rows)?;
        let mut band = renderer.pair(uploaded, &part).options(options).progress(progress).read().await?;
        blur.apply(&mut band, options)?;
        let truth = match needs_truth {
            true => Some(renderer.ground_truth(uploaded, scene, &band).await?),
            false => None,
        };
        match &mut found {
            None => found = Some((band, truth)),
            Some((pair, above)) => {
                pair.append(band);
                above.iter_mut().zip(truth).for_each(|(above, truth)| above.append(truth));
            }
        }
    }
    let Some((mut pair, mut truth)) = found else { unreachable!("pictures have rows") };
    pair.pose = pose;
    truth.iter_mut().for_each(|truth| truth.pose = pose);
    if let Some(sensor) = &spec.sensor {
        sensor.expose(&mut pair, take.options, draws, "first");
    }
    Ok(Shown { camera, pair, truth, layers: None, matches: None, next: None, array: Vec::new() })
}

/// Returns the rows of each band, from the top down.
fn bands(height: u32, count: u32) -> impl Iterator<Item = Range<u32>> {
    let count = count.min(height);
    let edge = move |band: u32| (u64::from(band) * u64::from(height) / u64::from(count)) as u32;
    (0..count).map(move |band| edge(band)..edge(band + 1))
}

/// Returns the camera of some rows of a camera's picture.
pub(super) fn camera_of(camera: &StereoCamera, rows: &Range<u32>) -> Result<StereoCamera, Error> {
    let pose = camera.pose()?;
    let lens = pose.planar_intrinsics()?;
    let lens = Intrinsics { cy: lens.cy - f64::from(rows.start), ..lens };
    let part = pose.camera()?.size(pose.size[0], rows.end - rows.start).intrinsics(lens).interaxial(pose.interaxial);
    part.pose()?;
    Ok(part)
}
