//! Motion blur and sensor noise of an item's pictures. Depths, ids and ground truth stay the same.

use std::ops::Range;

use super::{
    draws::Draws,
    maker::Take,
    rolling,
    sensor::Sensor,
    spec::{Motion, SensorEntry, Spec},
    stage::Stage,
};
use crate::{Error, MotionBlur, Options, Renderer, StereoPair, View};

/// Returns the blur of the pair at a time of the item's motion, or one that changes nothing if the spec has no shutter.
/// The time is 0 at the first pair and 1 at the next pair. With `rows`, it is the blur of these rows alone.
pub(super) async fn blur(
    renderer: &mut Renderer,
    stage: &mut Stage,
    take: &Take<'_>,
    motion: &Motion,
    (middle, rows): (f64, Option<&Range<u32>>),
) -> Result<MotionBlur, Error> {
    let Take { spec, draws, options, camera, .. } = *take;
    let mut blur = MotionBlur::new();
    let Some(shutter) = &motion.shutter else { return Ok(blur) };
    let open = draws.draw(&shutter.open, "motion.shutter.open");
    for (offset, options) in MotionBlur::instants(open, shutter.times, options) {
        let camera = stage.advance(renderer, (motion, spec.poses.path()), draws, camera, middle + offset).await?;
        let camera = rows.map_or(Ok(camera), |rows| rolling::camera_of(&camera, rows))?;
        let (_, uploaded) = stage.next()?;
        blur.add(&renderer.pair(uploaded, &camera).options(&options).read().await?)?;
    }
    Ok(blur)
}

impl Spec {
    /// Returns whether pictures are changed in linear light after rendering.
    pub(super) fn changes_light(&self) -> bool {
        self.sensor.is_some() || self.motion.as_ref().is_some_and(|motion| motion.shutter.is_some())
    }
}

impl SensorEntry {
    /// Adds the sensor's noise to a pair. `name` names its random numbers.
    pub(super) fn expose(&self, pair: &mut StereoPair, options: &Options, draws: &Draws, name: &str) {
        for (view, eye) in [(&mut pair.left, "left"), (&mut pair.right, "right")] {
            self.expose_view(view, options, draws, &format!("{name}.{eye}"));
        }
    }

    /// Adds the sensor's noise to a view. `name` names its random numbers.
    pub(super) fn expose_view(&self, view: &mut View, options: &Options, draws: &Draws, name: &str) {
        let draw = |value, key: &str| draws.draw(value, &format!("sensor.{key}"));
        let sensor =
            Sensor { full_well: draw(&self.full_well, "full_well"), read_noise: draw(&self.read_noise, "read_noise") };
        sensor.expose(view, options, draws.bits(&format!("sensor.{name}")));
    }
}
