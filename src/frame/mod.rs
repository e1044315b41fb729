//! One frame: its plan, the buffers between its steps, the driver that runs it, and what is read back.

pub(crate) mod driver;
mod in_steps;
pub(crate) mod plan;
pub(crate) mod read;
pub(crate) mod targets;
#[cfg(test)]
mod tests;
pub(crate) mod uniform;

use std::{sync::Arc, time::Duration};

pub(crate) use targets::Cache;

use crate::{
    Choice, Error, Method, OnProgress, Options, Renderer, UploadedScene,
    layout::{self, WORKGROUP},
    message::counted,
    pair::PassTimes,
    rig::Eyes,
    variant::Variant,
};
use driver::Driver;
use plan::{Made, Plan};
use targets::{Shape, Targets, Used};

/// Pixels of a band, in whole workgroups of rows: with 5 lights some 1.5 million rays, a tenth of a second on a slow
/// GPU, so that no watchdog trips whatever the picture's size. More lights make it less.
pub(crate) const BAND_PIXELS: u32 = 1 << 18;
/// Bands of a picture at most: eight dispatches each, the most that a method has, fit one query set.
const MAX_BANDS: u32 = 256;

/// A frame that has been traced: its buffers hold the views.
pub(crate) struct Traced {
    pub(crate) eyes: Eyes,
    pub(crate) targets: Arc<Targets>,
    /// How each view came about, and what it cost.
    pub(crate) made: Vec<Made>,
    pub(crate) counts: Vec<read::Counts>,
    /// The method of the frame, and what `Auto` chose for each view.
    pub(crate) method: Method,
    pub(crate) choices: Vec<Option<Choice>>,
    pub(crate) in_steps: bool,
    pub(crate) buffer_depth: u32,
    pub(crate) times: Option<PassTimes>,
    pub(crate) intermediate_bytes: u64,
}

/// Rows of a dispatch: whole workgroups of them.
fn band_rows([width, height]: [u32; 2], band_pixels: u32) -> u32 {
    let rows = (band_pixels / width).max(height.div_ceil(MAX_BANDS));
    rows.next_multiple_of(WORKGROUP).min(height.next_multiple_of(WORKGROUP))
}

impl Renderer {
    /// The steps of a frame; its buffers then hold the views.
    pub(crate) async fn trace_frame(
        &mut self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        progress: &mut OnProgress<'_>,
    ) -> Result<Traced, Error> {
        scene.belongs_to(&self.gpu)?;
        let method = effective(options.method, eyes, scene);
        if !self.steps.always
            && let Some(traced) = self.trace_at_once(scene, eyes, options, method, progress).await?
        {
            return Ok(traced);
        }
        self.trace_in_steps(scene, eyes, options, progress).await
    }

    /// The steps of a frame, unless the adapter cuts a thread's work short: then `None`.
    async fn trace_at_once(
        &mut self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        method: Method,
        progress: &mut OnProgress<'_>,
    ) -> Result<Option<Traced>, Error> {
        let early = if method == Method::Auto { scene.choose_early(&self.gpu, &eyes.pose) } else { None };
        let method = early.map_or(method, |choice| choice.method);
        let plan = Plan::of(method, &eyes.sources);
        let variant = Variant { bits: plan.bits, samples: plan.samples, ..self.variant(scene, eyes, options) };
        let used = plan.uses(&variant);
        let targets = self.targets(self.shape(scene, eyes, options), &used).await?;
        let mut driver = self.driver(scene, eyes, variant, &targets, progress);
        driver.rows_total = (eyes.pose.size[1] * plan.sweeps()) as f32;
        driver.run(&plan).await?;
        driver.finish().await?;
        let (slot_bytes, host, made) = (driver.slot_bytes, driver.host, std::mem::take(&mut driver.made));
        let own = |view: usize| eyes.sources[view] == view;
        let choose = |(view, choice): (usize, &Option<Choice>)| choice.or(early).filter(|_| !own(view));
        let choices = driver.choices.iter().enumerate().map(choose).collect();
        let buffer_depth = driver.frames.iter().map(|frame| frame.buffer_depth).max().unwrap_or(0);
        let counts = self.counts(&targets).await?;
        let threads = read::threads_cut_short(&counts);
        if threads > 0 {
            let threads = counted(threads, "thread", "threads");
            log::warn!(
                "{method}: the adapter ended the loops of {threads} before their work was done; naive goes on in steps"
            );
            return Ok(None);
        }
        let mut times = self.times().await?;
        if let Some(times) = times.as_mut().filter(|_| !host.is_zero()) {
            times.passes.insert(1, ("reproject_on_the_host", host));
        }
        let intermediate_bytes = targets.intermediate_bytes(&used) + slot_bytes;
        let eyes = eyes.clone();
        Ok(Some(Traced {
            eyes,
            targets,
            made,
            counts,
            method,
            choices,
            in_steps: false,
            buffer_depth,
            times,
            intermediate_bytes,
        }))
    }

    fn shape(&self, scene: &UploadedScene, eyes: &Eyes, options: &Options) -> Shape {
        let band_pixels = self.band_pixels / (1 + scene.lights.len() as u32).div_ceil(6);
        let rows = band_rows(eyes.pose.size, band_pixels);
        Shape { size: eyes.pose.size, rows, views: eyes.sources.len(), cost_map: options.cost_map }
    }

    /// What kernels of a frame are specialised to, whatever its plan.
    fn variant(&self, scene: &UploadedScene, eyes: &Eyes, options: &Options) -> Variant {
        let counting = scene.variant.counting(options.count, options.cost_map);
        Variant { linear: options.linear, close: scene.close_to(&eyes.positions()), ..counting }
    }

    async fn targets(&mut self, shape: Shape, used: &Used) -> Result<Arc<Targets>, Error> {
        if let Some(targets) = self.cache.targets.as_ref().filter(|targets| targets.fit(shape, used)) {
            return Ok(targets.clone());
        }
        self.cache.targets = None; // the old ones' memory first
        let make = || Targets::new(&self.gpu, shape, used);
        let targets = Arc::new(self.gpu.checked(make).await?);
        self.cache.targets = Some(targets.clone());
        Ok(targets)
    }

    async fn times(&self) -> Result<Option<PassTimes>, Error> {
        match &self.timestamps {
            Some(timestamps) => timestamps.read(&self.gpu).await,
            None => Ok(None),
        }
    }

    /// A frame's driver, before its first step.
    fn driver<'a>(
        &'a mut self,
        scene: &'a UploadedScene,
        eyes: &'a Eyes,
        variant: Variant,
        targets: &'a Targets,
        progress: &'a mut OnProgress<'a>,
    ) -> Driver<'a> {
        if let Some(timestamps) = &mut self.timestamps {
            timestamps.restart();
        }
        let runs = self.runs;
        let views = eyes.sources.len();
        Driver {
            gpu: &self.gpu,
            kernels: &self.kernels,
            scene,
            eyes,
            variant,
            targets,
            slots: &mut self.cache.slots,
            slot_bytes: 0,
            rows: targets.shape.rows,
            frames: (0..views).map(|view| layout::Frame { runs, ..eyes.frame(view) }).collect(),
            timestamps: self.timestamps.as_mut(),
            lanes: None,
            host: Duration::ZERO,
            choices: vec![None; views],
            made: vec![Made::Traced; views],
            rows_done: 0.0,
            rows_total: eyes.pose.size[1] as f32,
            progress,
        }
    }
}

/// The method that views are made by: without interaxial all are equal, and where there is nothing to hit there is nothing to
/// bracket.
fn effective(method: Method, eyes: &Eyes, scene: &UploadedScene) -> Method {
    match method {
        Method::Naive => Method::Naive,
        _ if eyes.pose.interaxial == 0.0 => Method::Ideal,
        Method::Auto | Method::Bracket(_) if scene.ids.is_empty() => Method::Naive,
        method => method,
    }
}
