//! Renders frames with several samples per pixel. A larger picture has a pixel for each sample, and the host filters
//! its rows as they arrive. Rows of samples are epipolar lines, as rows of pixels are (DESIGN, section 3). So methods
//! and kernels need no change.

#[cfg(test)]
mod tests;

use std::ops::ControlFlow;

use super::frame::Done;
use crate::{
    Error, GBuffer, Lighting, OnProgress, Options, Progress, Renderer, UploadedScene,
    ask::samples::side_of,
    frame::{
        OnRows, Rows,
        targets::{MOST_BYTES, too_large},
        wanted::Wanted,
    },
    message::counted,
    sampling,
    view::rig::Eyes,
};

impl Renderer {
    /// Renders all bands of a frame with the requested number of samples per pixel. With one sample it equals
    /// [`Renderer::frame`].
    pub(crate) async fn sampled(
        &mut self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        pictures: bool,
        progress: &mut OnProgress<'_>,
        on_rows: &mut OnRows<'_>,
    ) -> Result<Done, Error> {
        let side = side_of(options.samples)?;
        if options.adaptive.is_some() {
            return self.adaptive(scene, eyes, options, pictures, progress, on_rows).await;
        }
        if side == 1 {
            return self.frame(scene, eyes, options, Wanted::all(pictures), progress, on_rows).await;
        }
        let finer = eyes.with_samples(side)?;
        // An odd grid without jitter has a sample in the pixel's centre, so it needs no separate frame of centres.
        let asks_centre = (side % 2 == 0 || options.jitter) && options.g_buffer != GBuffer::None;
        let rays = (if asks_centre { 1.0 } else { 0.0 }, options.samples as f32); // rays per pixel, of both frames
        let (mut centre, mut centres) = (None, None);
        if asks_centre {
            check_centres(eyes, options, pictures)?;
            let mut progress = part_of(progress, 0.0, rays.0, rays);
            let (done, kept) = self.centres(scene, eyes, options, pictures, &mut progress).await?;
            (centre, centres) = (Some(done), Some(kept));
        }
        let mut gather = sampling::Gather::new(eyes.pose.size, side, options, centres);
        let mut add = |rows: Rows| gather.add(&rows).map_or(Ok(()), &mut *on_rows);
        let mut progress = part_of(progress, rays.0, rays.1, rays);
        let g_buffer = if asks_centre { GBuffer::None } else { options.g_buffer };
        let finer_options = Options { linear: true, g_buffer, ..options.clone() };
        let done = self.frame(scene, &finer, &finer_options, Wanted::all(pictures), &mut progress, &mut add).await;
        let done = done.map_err(|error| of_samples(error, options.samples))?;
        Ok(Done { eyes: eyes.clone(), ..centre.into_iter().fold(done, Done::with) })
    }

    /// Renders a frame with one sample per pixel, in the pixel's centre.
    pub(super) async fn centres(
        &mut self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        pictures: bool,
        progress: &mut OnProgress<'_>,
    ) -> Result<(Done, sampling::Centres), Error> {
        let mut centres = sampling::Centres::default();
        let mut keep = |rows: Rows| {
            centres.add(rows.views);
            Ok(())
        };
        // Linear colour is not needed here, but it makes this frame use the same kernels as the other frames do without
        // paths. Depths and ids do not depend on light.
        let options =
            Options { linear: true, samples: 1, lighting: Lighting::Direct, history: None, ..options.clone() };
        let done = self.frame(scene, eyes, &options, Wanted::all(pictures), progress, &mut keep).await?;
        Ok((done, centres))
    }
}

/// Maps a sub-frame's progress to the whole frame. `before` rays per pixel are already done. The sub-frame takes `rays`
/// more, and `all` gives the total.
pub(super) fn part_of(
    progress: &mut OnProgress<'_>,
    before: f32,
    rays: f32,
    all: (f32, f32),
) -> impl FnMut(Progress) -> ControlFlow<()> {
    move |Progress { pass, done }| progress(Progress { pass, done: (before + rays * done) / (all.0 + all.1) })
}

/// # Errors
/// [`Error::Limit`] if the data of pixels' centres does not fit into memory.
pub(super) fn check_centres(eyes: &Eyes, options: &Options, pictures: bool) -> Result<(), Error> {
    let ([width, height], views) = (eyes.pose.size, eyes.sources.len());
    // Bytes per pixel and view: depth, primitive id, object id, pixel source, shadow source and cost.
    let needed = (u64::from(width) * u64::from(height)).saturating_mul(18 * views as u64);
    if needed <= MOST_BYTES || !pictures {
        return Ok(());
    }
    let (views, samples) = (counted(views, "view", "views"), options.samples);
    let what = format!("depth and ids of {views} of {width}x{height} with {samples} samples per pixel");
    Err(too_large(what, needed, "use 9, 25 or 49 samples without jitter, or only colours (GBuffer::None)"))
}

/// Replaces the description of a limit error. The larger picture has a size that the caller did not give.
pub(super) fn of_samples(error: Error, samples: u32) -> Error {
    match error {
        error if samples == 1 => error,
        Error::Limit { what, needed, limit, allowed, .. } => Error::Limit {
            what: format!("{samples} samples per pixel: {what}"),
            needed,
            limit,
            allowed,
            remedy: "use fewer samples or pixels",
        },
        error => error,
    }
}

impl Done {
    /// Adds the cost of another frame of the same picture.
    pub(super) fn with(mut self, other: Self) -> Self {
        for (tally, other) in self.tallies.iter_mut().zip(&other.tallies) {
            tally.work += other.work;
            tally.reused += other.reused;
            tally.bad += other.bad;
            tally.missed += other.missed;
            tally.lost_candidates += other.lost_candidates;
        }
        self.in_all(other)
    }

    /// Adds the cost of another frame, except the tallies of its views.
    pub(super) fn in_all(mut self, other: Self) -> Self {
        self.in_steps |= other.in_steps;
        self.times = self.times.zip(other.times).map(|(mut times, others)| {
            times.add(&others);
            times
        });
        self.intermediate_bytes = self.intermediate_bytes.max(other.intermediate_bytes);
        self.shadow_buffer = self.shadow_buffer.with(other.shadow_buffer);
        self
    }
}
