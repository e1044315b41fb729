//! One frame: its plan, the buffers between its steps, the driver that runs it, and what is read back.

pub(crate) mod driver;
mod in_steps;
pub(crate) mod plan;
pub(crate) mod read;
pub(crate) mod targets;
#[cfg(test)]
mod tests;
pub(crate) mod uniform;

use std::{collections::BTreeSet, sync::Arc, time::Duration};

pub(crate) use targets::Cache;

use crate::{
    Error, Method, OnProgress, Options, Overlap, Pose, Renderer, Statistics, UploadedScene,
    layout::WORKGROUP,
    variant::{Kept, Variant},
};
use driver::Driver;
use plan::{Plan, RightView};
use targets::{Shape, Target, Targets};

/// Pixels of a band, in whole workgroups of rows: with 5 lights some 1.5 million rays, a tenth of a second on a slow
/// GPU, so that no watchdog trips whatever the picture's size. More lights make it less.
pub(crate) const BAND_PIXELS: u32 = 1 << 18;
/// Bands of a picture at most: eight dispatches each, the most that a method has, fit one query set.
const MAX_BANDS: u32 = 256;

/// A frame that has been traced: its buffers hold the pair.
pub(crate) struct Traced {
    pub(crate) statistics: Statistics,
    pub(crate) targets: Arc<Targets>,
    pub(crate) right: RightView,
}

/// Rows of a dispatch: whole workgroups of them.
fn band_rows([width, height]: [u32; 2], band_pixels: u32) -> u32 {
    let rows = (band_pixels / width).max(height.div_ceil(MAX_BANDS));
    rows.next_multiple_of(WORKGROUP).min(height.next_multiple_of(WORKGROUP))
}

impl Renderer {
    /// The steps of a frame; its buffers then hold the pair.
    pub(crate) async fn trace_frame(
        &mut self,
        scene: &UploadedScene,
        pose: &Pose,
        options: &Options,
        progress: &mut OnProgress<'_>,
    ) -> Result<Traced, Error> {
        scene.belongs_to(&self.gpu)?;
        let method = effective(options.method, pose, scene);
        method.check()?;
        if !self.steps.always
            && let Some(traced) = self.trace_at_once(scene, pose, options, method, progress).await?
        {
            return Ok(traced);
        }
        self.trace_in_steps(scene, pose, options, progress).await
    }

    /// The steps of a frame, unless the adapter cuts a thread's work short: then `None`.
    async fn trace_at_once(
        &mut self,
        scene: &UploadedScene,
        pose: &Pose,
        options: &Options,
        method: Method,
        progress: &mut OnProgress<'_>,
    ) -> Result<Option<Traced>, Error> {
        let early = if method == Method::Auto { scene.choose_early(&self.gpu, pose) } else { None };
        let method = early.map_or(method, |choice| choice.method);
        let plan = Plan::of(method);
        let shape = self.shape(scene, pose, options, method);
        let used = plan.targets();
        let targets = self.targets(shape, &used).await?;
        let mut driver = self.driver(scene, pose, options, &targets, progress);
        driver.rows_total = (pose.size[1] * plan.sweeps()) as f32;
        driver.run(&plan).await?;
        driver.finish().await?;
        let (slot_bytes, host) = (driver.slot_bytes, driver.host);
        let (choice, right, buffer_depth) = (driver.choice, driver.right, driver.frame.buffer_depth);
        let method = choice.map_or(method, |choice| choice.method);
        let mut statistics = match self.statistics(&targets, method).await? {
            Ok(statistics) => statistics,
            Err(threads) => {
                log::warn!(
                    "{method}: the adapter ended the loops of {threads} threads before their work was done; naive goes on in steps"
                );
                return Ok(None);
            }
        };
        statistics.choice = choice.or(early);
        statistics.buffer_depth = buffer_depth;
        statistics.intermediate_bytes = targets.intermediate_bytes(&used) + slot_bytes;
        if let Some(times) = statistics.times.as_mut().filter(|_| !host.is_zero()) {
            times.0.insert(1, ("reproject_on_the_host", host));
        }
        Ok(Some(Traced { statistics, targets, right }))
    }

    fn shape(&self, scene: &UploadedScene, pose: &Pose, options: &Options, method: Method) -> Shape {
        let band_pixels = self.band_pixels / (1 + scene.lights.len() as u32).div_ceil(6);
        let rows = band_rows(pose.size, band_pixels);
        Shape { size: pose.size, rows, kept: Kept::of(options.g_buffer, method), cost_map: options.cost_map }
    }

    async fn targets(&mut self, shape: Shape, used: &BTreeSet<Target>) -> Result<Arc<Targets>, Error> {
        if let Some(targets) = self.cache.targets.as_ref().filter(|targets| targets.fit(shape, used)) {
            return Ok(targets.clone());
        }
        self.cache.targets = None; // the old ones' memory first
        let make = || Targets::new(&self.gpu, shape, used);
        let targets = Arc::new(self.gpu.checked(make).await?);
        self.cache.targets = Some(targets.clone());
        Ok(targets)
    }

    /// A frame's driver, before its first step.
    fn driver<'a>(
        &'a mut self,
        scene: &'a UploadedScene,
        pose: &'a Pose,
        options: &Options,
        targets: &'a Targets,
        progress: &'a mut OnProgress<'a>,
    ) -> Driver<'a> {
        if let Some(timestamps) = &mut self.timestamps {
            timestamps.restart();
        }
        let counting = scene.variant.counting(options.count, options.cost_map);
        let close = scene.close_to(&[pose.eye_position(-1.0), pose.eye_position(1.0)]);
        Driver {
            gpu: &self.gpu,
            kernels: &self.kernels,
            scene,
            pose,
            variant: Variant { hits: targets.shape.kept, close, ..counting },
            targets,
            slots: &mut self.cache.slots,
            slot_bytes: 0,
            rows: targets.shape.rows,
            frame: uniform::frame_uniform(pose),
            timestamps: self.timestamps.as_mut(),
            lanes: None,
            host: Duration::ZERO,
            choice: None,
            right: RightView::Traced,
            rows_done: 0.0,
            rows_total: pose.size[1] as f32,
            progress,
        }
    }
}

/// The method that a pair is made by: without interaxial right equals left, and where there is nothing to hit there is nothing to
/// bracket.
fn effective(method: Method, pose: &Pose, scene: &UploadedScene) -> Method {
    match method {
        Method::Naive => Method::Naive,
        _ if pose.interaxial == 0.0 => Method::Ideal,
        Method::Auto | Method::Reuse { overlap: Overlap::Bracket(_), .. } if scene.ids.is_empty() => Method::Naive,
        method => method,
    }
}
