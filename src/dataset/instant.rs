//! Pairs at one instant, and the next pair of an item with motion.

use super::{
    maker::{NextPair, Shown, Take},
    shutter,
    stage::Stage,
};
use crate::{
    Correspondence, Error, GroundTruth, Layers, Moment, MotionBlur, OnProgress, Renderer, Scene, StereoPair,
    UploadedScene,
};

/// Renders a pair, and its next pair and the flow between both if the spec has motion.
pub(super) async fn shown(
    renderer: &mut Renderer,
    stage: &mut Stage,
    take: &Take<'_>,
    progress: &mut OnProgress<'_>,
) -> Result<Shown, Error> {
    let Take { spec, draws, options, camera, .. } = *take;
    let mut pair = renderer.pair(stage.uploaded()?, &camera).options(options).progress(progress).read().await?;
    let mut next_blur = MotionBlur::new();
    if let Some(motion) = &spec.motion {
        let first = shutter::blur(renderer, stage, take, motion, (0.0, None)).await?;
        first.apply(&mut pair, options)?;
        next_blur = shutter::blur(renderer, stage, take, motion, (1.0, None)).await?;
    }
    if let Some(sensor) = &spec.sensor {
        sensor.expose(&mut pair, options, draws, "first");
    }
    let of = (&stage.scene, stage.uploaded()?);
    let Truths { truth, layers, matches } = truths_of(renderer, (take, false), of, &pair).await?;
    let mut shown = Shown { camera, pair, truth, layers, matches, next: None, array: Vec::new() };
    let Some(motion) = &spec.motion else { return Ok(shown) };
    let next_camera = stage.advance(renderer, (motion, spec.poses.path()), draws, camera, 1.0).await?;
    let (scene, uploaded) = stage.next()?;
    let mut pair = renderer.pair(uploaded, &next_camera).options(options).read().await?;
    next_blur.apply(&mut pair, options)?;
    if let Some(sensor) = &spec.sensor {
        sensor.expose(&mut pair, options, draws, "next");
    }
    let Truths { truth, layers, matches } = truths_of(renderer, (take, true), (scene, uploaded), &pair).await?;
    let now = Moment { scene: &stage.scene, uploaded: stage.uploaded()?, camera: &camera };
    let then = Moment { scene, uploaded, camera: &next_camera };
    let forward = renderer.flow(&shown.pair, &stage.scene, then).await?;
    let backward = renderer.flow(&pair, scene, now).await?;
    shown.next = Some(Box::new(NextPair { pair, truth, layers, matches, camera: next_camera, forward, backward }));
    Ok(shown)
}

/// Ground truth of an item's first or next pair, as far as outputs of the spec need it.
pub(super) struct Truths {
    pub(super) truth: Option<GroundTruth>,
    pub(super) layers: Option<Layers>,
    matches: Option<Correspondence>,
}

pub(super) async fn truths_of(
    renderer: &Renderer,
    (take, next): (&Take<'_>, bool),
    (scene, uploaded): (&Scene, &UploadedScene),
    pair: &StereoPair,
) -> Result<Truths, Error> {
    let spec = take.spec;
    let truth = match take.needs_truth {
        true => Some(renderer.ground_truth(uploaded, scene, pair).await?),
        false => None,
    };
    let layers = match spec.layers.filter(|_| spec.needs_layers(next)) {
        Some(layers) => Some(renderer.layers(uploaded, scene, pair, &layers.layering()).await?),
        None => None,
    };
    let matches = match spec.needs_matches(next) {
        true => Some(renderer.correspondence(uploaded, pair).await?),
        false => None,
    };
    Ok(Truths { truth, layers, matches })
}
