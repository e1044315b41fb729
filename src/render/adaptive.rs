//! Frames of adaptive samples. The first level is a lattice of samples at the corners of pixels. On finer lattices,
//! only the missing samples of divided cells are traced (`src/sampling/cells.rs`). Each level is a frame of a larger
//! picture with a mask, so methods and kernels need no special case. Strips of pixel rows go through all levels in
//! turn.

use std::ops::{ControlFlow, Range};

use super::{
    frame::Done,
    samples::{check_centres, of_samples, part_of},
};
use crate::{
    Adaptive, Error, GBuffer, Method, OnProgress, Options, Progress, Renderer, UploadedScene,
    frame::{
        OnRows, Rows, ViewRows,
        plan::targets,
        wanted::{Mask, Part, Wanted},
    },
    sampling::{Cells, Centres},
    view::rig::Eyes,
};

/// Approximate maximum number of finest-level samples that the host holds at a time, for all views: about 150 MiB.
const HELD: u64 = 1 << 23;

/// A frame of adaptive samples.
struct Levels<'a> {
    scene: &'a UploadedScene,
    eyes: &'a Eyes,
    options: &'a Options,
    adaptive: Adaptive,
    /// Eyes at each level, with one pixel per sample of that level.
    lattices: Vec<Eyes>,
}

/// Samples of a strip of pixel rows.
struct Strip {
    /// Cells of each view.
    cells: Vec<Cells>,
    done: Done,
    /// For each view, how the samples in the upper left corners of the pixels were made.
    corners: Vec<ViewRows>,
}

impl Renderer {
    /// Renders all rows of a frame of adaptive samples, like [`Renderer::frame`].
    pub(super) async fn adaptive(
        &mut self,
        scene: &UploadedScene,
        eyes: &Eyes,
        options: &Options,
        pictures: bool,
        progress: &mut OnProgress<'_>,
        on_rows: &mut OnRows<'_>,
    ) -> Result<Done, Error> {
        options.check()?;
        let levels = Levels::new(scene, eyes, options)?;
        // Keeps buffers for each level's size, and for the last strip, which may be shorter. They are dropped
        // afterwards, even if the frame ends early.
        self.cache.keep(2 * levels.lattices.len());
        let done = self.strips(&levels, pictures, progress, on_rows).await;
        self.cache.keep(1);
        done
    }

    /// Renders all rows, strip by strip.
    async fn strips(
        &mut self,
        levels: &Levels<'_>,
        pictures: bool,
        progress: &mut OnProgress<'_>,
        on_rows: &mut OnRows<'_>,
    ) -> Result<Done, Error> {
        let Levels { scene, eyes, options, .. } = *levels;
        let asks_centre = options.g_buffer != GBuffer::None;
        let rays = (if asks_centre { 1.0 } else { 0.0 }, levels.adaptive.levels as f32);
        let (mut sum, mut centres): (Option<Done>, Option<Centres>) = (None, None);
        if asks_centre {
            check_centres(eyes, options, pictures)?;
            let mut progress = part_of(progress, 0.0, rays.0, rays);
            let options = Options { adaptive: None, ..options.clone() };
            let (done, kept) = self.centres(scene, eyes, &options, pictures, &mut progress).await?;
            (sum, centres) = (Some(done), Some(kept));
        }
        let height = eyes.pose.size[1];
        let step = levels.rows_at_a_time();
        for begin in (0..height).step_by(step as usize) {
            let rows = begin..height.min(begin + step);
            let share = |row: u32| rays.1 * row as f32 / height as f32;
            let parts = (rays.0 + share(rows.start), share(rows.end) - share(rows.start), rays);
            let strip = self.strip(levels, rows.clone(), progress, parts).await;
            let strip = strip.map_err(|error| of_samples(error, levels.most_samples()))?;
            let shown = if pictures { Some(levels.rows(&strip, &rows, centres.as_mut())) } else { None };
            sum = Some(sum.into_iter().fold(strip.done, Done::with));
            shown.map_or(Ok(()), &mut *on_rows)?;
        }
        match progress(Progress { pass: "divide", done: 1.0 }) {
            ControlFlow::Continue(()) => {
                Ok(Done { eyes: eyes.clone(), ..sum.expect("a picture has a row of pixels at least") })
            }
            ControlFlow::Break(()) => Err(Error::Cancelled),
        }
    }

    /// Renders the given pixel rows through all levels. For the progress callback, `before` rays per pixel are already
    /// done. The rows take `rays` more, and `all` gives the total.
    async fn strip(
        &mut self,
        levels: &Levels<'_>,
        rows: Range<u32>,
        progress: &mut OnProgress<'_>,
        (before, rays, all): (f32, f32, (f32, f32)),
    ) -> Result<Strip, Error> {
        let eyes = levels.eyes;
        let size = [eyes.pose.size[0], rows.len() as u32];
        let mut cells: Vec<_> = eyes.sources.iter().map(|_| Cells::new(size, levels.adaptive.levels)).collect();
        let mut corners: Vec<_> = eyes.sources.iter().map(|_| ViewRows::new(size[0])).collect();
        let mut method = levels.options.method;
        let mut sum: Option<Done> = None;
        for (level, lattice) in (0..).zip(&levels.lattices) {
            let masks = (level > 0).then(|| levels.masks(&cells, level, &rows, method));
            let of_level = (rows.start << level, (rows.end << level) + 1);
            let is_wanted = |mask: &Mask| mask.count(of_level.0..of_level.1) > 0;
            if masks.as_ref().is_some_and(|masks| !masks.iter().any(is_wanted)) {
                break;
            }
            let wanted = Wanted { pictures: true, part: Some(Part { rows: of_level, masks: masks.as_deref() }) };
            let mut keep = |rows: Rows| {
                for (view, samples) in rows.views.into_iter().enumerate() {
                    if level == 0 {
                        corners[view].append(levels.corners(&samples));
                    }
                    cells[view].add(level, samples.view);
                }
                Ok(())
            };
            let share = rays / levels.lattices.len() as f32;
            let mut progress = part_of(progress, before + share * level as f32, share, all);
            let options = levels.options_of(level, method);
            let done = self.frame(levels.scene, lattice, &options, wanted, &mut progress, &mut keep).await?;
            if method == Method::Auto {
                let chosen = targets(&eyes.sources).map(|(view, _)| done.method_of(view));
                method = chosen.reduce(|a, b| if a == Method::Naive { b } else { a }).unwrap_or(Method::Naive);
            }
            sum = Some(match sum {
                Some(sum) => sum.with(done),
                None => done,
            });
            if level + 1 < levels.adaptive.levels {
                levels.divide(&mut cells, level, method);
            }
        }
        Ok(Strip { cells, corners, done: sum.expect("the first level is not masked") })
    }
}

impl<'a> Levels<'a> {
    /// # Errors
    /// [`Error::Samples`] if the f32 ray directions of neighbouring samples of the last level are not distinct.
    fn new(scene: &'a UploadedScene, eyes: &'a Eyes, options: &'a Options) -> Result<Self, Error> {
        let adaptive = options.adaptive.expect("asked for");
        eyes.with_lattice(1 << (adaptive.levels - 1))?; // checks the finest level first
        let lattices = (0..adaptive.levels).map(|level| eyes.with_lattice(1 << level)).collect::<Result<_, _>>()?;
        Ok(Self { scene, eyes, options, adaptive, lattices })
    }

    /// Returns the number of samples of a maximally divided pixel, without the samples shared with its neighbours.
    fn most_samples(&self) -> u32 {
        1 << (2 * (self.adaptive.levels - 1))
    }

    /// Returns the number of pixel rows in a strip.
    fn rows_at_a_time(&self) -> u32 {
        let [width, height] = self.eyes.pose.size;
        let views = self.eyes.sources.len() as u64;
        let row = u64::from(width) * u64::from(self.most_samples()) * views;
        (HELD / row).clamp(1, height.into()) as u32
    }

    /// Returns the options of a level's frame. The depths of the last level are not needed.
    fn options_of(&self, level: u32, method: Method) -> Options {
        let is_last = level + 1 == self.adaptive.levels;
        let g_buffer = if is_last { GBuffer::None } else { GBuffer::Depth };
        Options { method, adaptive: None, history: None, linear: true, g_buffer, ..self.options.clone() }
    }

    /// Returns, for each view, a mask of the samples that a level traces.
    fn masks(&self, cells: &[Cells], level: u32, rows: &Range<u32>, method: Method) -> Vec<Mask> {
        // If other views reuse a view's samples, the mask also contains the corners of cells.
        let is_asked = |view| method != Method::Naive && targets(&self.eyes.sources).any(|(_, source)| source == view);
        let mask = |(view, cells): (usize, &Cells)| cells.wanted(level, rows.start << level, is_asked(view));
        cells.iter().enumerate().map(mask).collect()
    }

    /// Divides cells whose corners differ. A cell is also divided if a cell that differs in another view is reprojected
    /// into it.
    fn divide(&self, cells: &mut [Cells], level: u32, method: Method) {
        let tolerance = self.adaptive.tolerance;
        let differing: Vec<_> = cells.iter().map(|cells| cells.differing(level, tolerance)).collect();
        let mut divided = differing.clone();
        // With `Ideal`, views are copies of their source, so the cells already agree.
        let pairs = targets(&self.eyes.sources).filter(|_| method != Method::Ideal);
        for (from, to) in pairs.flat_map(|(view, source)| [(view, source), (source, view)]) {
            let apart = self.eyes.offsets[to] - self.eyes.offsets[from];
            let parallax = self.eyes.pose.parallax().times(apart);
            cells[from].seen_by(&cells[to], level, &differing[from], parallax, &mut divided[to]);
        }
        cells.iter_mut().zip(divided).for_each(|(cells, divided)| cells.divide(level, divided));
    }

    /// Returns how the first-level samples in the upper left corners of the pixels were made.
    fn corners(&self, samples: &ViewRows) -> ViewRows {
        let width = self.eyes.pose.size[0];
        let mut corners = ViewRows::new(width);
        corners.view.height = samples.view.height;
        // A row of samples has one sample more than a row has pixels.
        corners.source = rows_of(&samples.source, width).concat();
        corners.shadow_source = rows_of(&samples.shadow_source, width).concat();
        corners
    }

    /// Returns the pictures of the given pixel rows.
    fn rows(&self, strip: &Strip, rows: &Range<u32>, centres: Option<&mut Centres>) -> Rows {
        let count = rows.len() as u32;
        let width = self.eyes.pose.size[0];
        let mut views = match centres {
            Some(centres) => centres.take(count, strip.cells.len(), width),
            None => strip.corners.iter().map(|corners| corners.first_rows(count)).collect(),
        };
        let exposure = self.options.exposure.exp2();
        for (rows, cells) in views.iter_mut().zip(&strip.cells) {
            let view = &mut rows.view;
            for color in (0..count).flat_map(|row| cells.row(row)) {
                view.rgba8.push(self.options.tone.rgba8(color, exposure));
                if self.options.linear {
                    let [red, green, blue] = color;
                    view.linear.push([red, green, blue, 1.0]);
                }
            }
            let costs = cells.costs();
            view.cost.resize(costs.len(), 0);
            view.cost.iter_mut().zip(costs).for_each(|(sum, cost)| *sum += cost);
        }
        Rows { first: rows.start, views }
    }
}

/// Splits a list into rows of `width + 1` elements and returns the first `width` elements of each row.
fn rows_of<T>(list: &[T], width: u32) -> Vec<&[T]> {
    list.chunks_exact(width as usize + 1).map(|row| &row[..width as usize]).collect()
}
