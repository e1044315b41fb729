//! Pairs of an array of cameras.

use super::{
    instant::truths_of,
    maker::{ArrayPair, Shown, Take},
    spec::CameraArray,
    stage::Stage,
};
use crate::{Error, OnProgress, Renderer, Rig, Views};

/// Renders the cameras of an array, row by row, and their pairs with ground truth. The first pair is the item's.
pub(super) async fn shown(
    renderer: &mut Renderer,
    stage: &Stage,
    take: &Take<'_>,
    array: &CameraArray,
    progress: &mut OnProgress<'_>,
) -> Result<Shown, Error> {
    let Take { spec, draws, options, camera, .. } = *take;
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
    let mut pairs = Vec::new();
    for cameras in array.pairs() {
        let [[row, column], [other_row, other_column]] = cameras.map(|camera| array.place(camera));
        let pair = match row == other_row {
            true => rows[row].pair(column, other_column)?,
            false => rows[row].pair_below(column, (&rows[other_row], other_column))?,
        };
        let truths = truths_of(renderer, (take, false), (&stage.scene, stage.uploaded()?), &pair).await?;
        let camera = pair.pose.camera()?;
        pairs.push(ArrayPair { cameras, camera, pair, truth: truths.truth, layers: truths.layers });
    }
    let Some(ArrayPair { camera, pair, truth, layers, .. }) = pairs.first().cloned() else {
        unreachable!("each camera is in a pair");
    };
    Ok(Shown { camera, pair, truth, layers, matches: None, next: None, array: pairs })
}
