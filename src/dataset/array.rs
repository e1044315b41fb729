//! Pairs of an array of cameras.

use super::{
    draws::Draws,
    maker::{ArrayPair, truths_of},
    spec::{CameraArray, Spec},
    stage::Stage,
};
use crate::{Error, OnProgress, Options, Renderer, Rig, StereoCamera, Views};

/// Renders the cameras of an array, row by row, and returns its pairs with their ground truth.
pub(super) async fn pairs_of(
    renderer: &mut Renderer,
    (stage, spec): (&Stage, &Spec),
    array: &CameraArray,
    (draws, options): (&Draws, &Options),
    (camera, needs_truth): (StereoCamera, bool),
    progress: &mut OnProgress<'_>,
) -> Result<Vec<ArrayPair>, Error> {
    let interaxial = f64::from(camera.pose()?.interaxial);
    let (offsets, heights) = (array.offsets(), array.heights());
    let mut rows: Vec<Views> = Vec::with_capacity(heights.len());
    for height in &heights {
        let camera = if *height == 0.0 { camera } else { camera.raised(height * interaxial)? };
        let rig = Rig::at(camera, offsets.clone());
        let mut row = renderer.views(stage.uploaded()?, &rig).options(options).progress(progress).read().await?;
        if let Some(sensor) = &spec.sensor {
            for (column, view) in row.views.iter_mut().enumerate() {
                let name = format!("camera{}", rows.len() * offsets.len() + column);
                sensor.expose_view(&mut view.view, options, draws, &name);
            }
        }
        rows.push(row);
    }
    let mut found = Vec::new();
    for cameras in array.pairs() {
        let [[row, column], [other_row, other_column]] = cameras.map(|camera| array.place(camera));
        let pair = match array.is_vertical(cameras) {
            false => rows[row].pair(column, other_column)?,
            true => rows[row].pair_below(column, (&rows[other_row], other_column))?,
        };
        let truths = truths_of(renderer, (spec, false, needs_truth), (&stage.scene, stage.uploaded()?), &pair).await?;
        let camera = pair.pose.camera()?;
        found.push(ArrayPair { cameras, camera, pair, truth: truths.truth, layers: truths.layers });
    }
    Ok(found)
}
