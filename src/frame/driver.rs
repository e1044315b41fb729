//! Runs the steps of a frame: sets uniforms, binds each view's resources, and computes the number of threads of each
//! step.

mod host;
mod in_steps;
pub(crate) mod slots;
pub(crate) mod sweep;

use std::{ops::ControlFlow, time::Duration};

use super::{
    bands::Band,
    executor::{Executor, Resources, Workgroups},
    history::Remembered,
    lanes::Lanes,
    plan::{Launch, Plan, Stage, Step},
    show::FILTER_SAMPLES,
    targets::Targets,
    uniforms::Uniforms,
    wanted::Mask,
};
use crate::{
    Error, OnProgress, Progress,
    gpu::{Gpu, Submission, Timestamps},
    kernel::{
        Kernel, Kernels, Resource,
        layout::{self, WORKGROUP},
        variant::Variant,
    },
    view::rig::Eyes,
};
use slots::Slots;

/// Maximum number of steps per submission: of bands of the usual size, and of much smaller ones. Two of three steps of
/// a path trace, and paths become fewer, so that 24 steps trace about as much as bands are sized for.
const MOST_STEPS: [u32; 2] = [24, 96];

/// The device, and the objects that a renderer keeps between frames.
pub(crate) struct Engine<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) kernels: &'a Kernels,
    /// 3D buffer of the last frame.
    pub(crate) slots: &'a mut Option<wgpu::Buffer>,
    /// Timestamps, if the frame is timed.
    pub(crate) timestamps: Option<&'a mut Timestamps>,
    /// Number of pixels of usual bands.
    pub(crate) band_pixels: u32,
}

/// Inputs of a frame. Only the rows in the uniforms change while it is rendered.
pub(crate) struct Setting<'a> {
    pub(crate) eyes: &'a Eyes,
    pub(crate) variant: Variant,
    pub(crate) targets: &'a Targets,
    pub(crate) uniforms: Uniforms,
    /// Resources of the scene, which all views share.
    pub(crate) shared: Resources,
    /// Samples of frames, if the plan reads or keeps them.
    pub(crate) history: Option<Remembered>,
}

/// Driver of one frame.
pub(crate) struct Driver<'a> {
    gpu: &'a Gpu,
    eyes: &'a Eyes,
    variant: Variant,
    targets: &'a Targets,
    executor: Executor<'a>,
    kernels: &'a Kernels,
    band_pixels: u32,
    /// Resources that steps bind, for each view.
    resources: Vec<Resources>,
    /// Uniforms of each view, with the rows of the current band.
    uniforms: Uniforms,
    slots: Slots<'a>,
    history: Option<Remembered>,
    /// State that threads keep between dispatches, for kernels that run in steps.
    lanes: Option<Lanes>,
    /// Masks of the wanted pixels of each view in the current band, if not all are wanted.
    masks: Vec<wgpu::TextureView>,
    /// Time spent on the host in steps.
    host: Duration,
    rows_done: u32,
    progress: &'a mut OnProgress<'a>,
}

impl<'a> Driver<'a> {
    /// Creates the driver of a frame, and discards the timestamps of the last frame.
    pub(crate) fn new(engine: Engine<'a>, setting: Setting<'a>, progress: &'a mut OnProgress<'a>) -> Self {
        let Engine { gpu, kernels, slots, mut timestamps, band_pixels } = engine;
        let Setting { eyes, variant, targets, uniforms, shared, history } = setting;
        if let Some(timestamps) = &mut timestamps {
            timestamps.restart();
        }
        let views = eyes.sources.iter().zip(&eyes.seconds).enumerate();
        let resources = |(view, (source, second)): (usize, (&usize, &usize))| {
            let mut all = shared.clone();
            targets.add_resources(view, *source, *second, &mut all);
            history.iter().for_each(|history| history.add_resources(&mut all));
            all
        };
        Self {
            gpu,
            eyes,
            variant,
            targets,
            executor: Executor::new(gpu, kernels, Some(&targets.indirect), timestamps),
            kernels,
            band_pixels,
            resources: views.map(resources).collect(),
            uniforms,
            slots: Slots::new(slots),
            history,
            lanes: None,
            masks: Vec::new(),
            host: Duration::ZERO,
            rows_done: 0,
            progress,
        }
    }
}

impl<'a> Driver<'a> {
    pub(crate) fn gpu(&self) -> &'a Gpu {
        self.gpu
    }

    /// Builds the pipelines of a plan.
    pub(crate) fn prepare<'p>(&self, plan: &'p Plan) -> impl Future<Output = Result<(), Error>> + use<'a, 'p> {
        self.kernels.prepare(self.gpu, plan.kernels(), self.variant)
    }

    /// Returns the workgroups of a step.
    fn launched(&self, kernel: &Kernel, view: usize, launch: Launch) -> Workgroups<'a> {
        let targets = self.targets;
        let rows = self.rows_of(view);
        let block = kernel.block(&self.variant);
        Workgroups::Number(match launch {
            Launch::Pixels => self.workgroups(rows, [block, block]),
            Launch::Runs(pixels) => self.workgroups(rows, [pixels, 1]),
            Launch::Tiles | Launch::WideTiles | Launch::EachTile => self.tiles(rows, launch),
            Launch::Picture(block) => self.workgroups(targets.shape.bands.height(), block),
            Launch::Rows => [1, rows.div_ceil(WORKGROUP * WORKGROUP), 1],
            Launch::Number(workgroups) => workgroups,
            Launch::Once => [1, 1, 1],
            Launch::Listed(lists, list) => return Workgroups::Listed(targets.get(lists, 0), list),
        })
    }
}

impl Driver<'_> {
    pub(crate) fn timestamps(&mut self) -> Option<&mut Timestamps> {
        self.executor.timestamps()
    }

    /// Returns the time spent on the host in steps so far.
    pub(crate) fn time_on_host(&self) -> Duration {
        self.host
    }

    /// Returns the number of slots per pixel of the deepest 3D buffer so far.
    pub(crate) fn buffer_depth(&self) -> u32 {
        self.slots.most_depth()
    }

    /// Returns the largest size of the 3D buffer so far plus the size of the lanes, in bytes.
    pub(crate) fn bytes_beside_targets(&self) -> u64 {
        self.slots.most_bytes() + self.lanes.as_ref().map_or(0, |lanes| lanes.buffer.size())
    }

    /// Uploads the masks of a band. Destroys the masks of the previous band, whose commands have been submitted.
    pub(crate) async fn upload_masks(&mut self, masks: &[Mask], band: &Band) -> Result<(), Error> {
        let gpu = self.gpu;
        let upload = |mask: &Mask| {
            let (width, texels) = mask.rows(band.first..band.seen.end);
            gpu.filled_texture("wanted_pixels", width, texels)
        };
        let uploaded: Vec<_> = gpu.checked(|| Ok(masks.iter().map(upload).collect())).await?;
        self.resources.iter_mut().zip(&uploaded).for_each(|(all, mask)| all.set(Resource::Wanted, mask));
        let before = std::mem::replace(&mut self.masks, uploaded);
        before.iter().for_each(|view| view.texture().destroy());
        Ok(())
    }

    /// Builds the pipelines of a plan, uploads the initial heads of lists, which all its bands share, and runs the
    /// steps before the first band.
    pub(crate) async fn begin(&mut self, plan: &Plan) -> Result<(), Error> {
        self.prepare(plan).await?;
        let gpu = self.gpu;
        let begin = || {
            gpu.queue.write_buffer(&self.targets.empty_lists, 0, bytemuck::cast_slice(&self.heads(plan)));
            if plan.before.is_empty() {
                return Ok(());
            }
            self.upload_uniforms();
            let mut encoder = self.encoder();
            self.history.iter().for_each(|history| encoder.clear_buffer(&history.bounds, 0, None));
            self.encode_all(&mut encoder, &plan.before);
            gpu.submit([encoder.finish()]);
            Ok(())
        };
        gpu.checked(begin).await
    }

    /// Returns the initial heads of lists. The dispatches that `choose` enables or disables as a whole are initially
    /// enabled.
    pub(crate) fn heads(&self, plan: &Plan) -> [[u32; 4]; layout::HEADS + layout::PATH_HEADS] {
        let rows = self.targets.shape.bands.rows;
        let block = self.variant.traversal.rays.block();
        let mut heads = [layout::EMPTY_LIST; layout::HEADS + layout::PATH_HEADS];
        let mut fill = |head: u32, workgroups: [u32; 3]| heads[head as usize][..3].copy_from_slice(&workgroups);
        fill(layout::TO_SEARCH, self.tiles(rows, plan.search.launch()));
        fill(layout::ALL_TRACED, self.workgroups(rows, [block, block]));
        heads
    }

    /// Returns the number of steps per submission. Steps of paths and mirrors trace up to one ray per pixel each, so
    /// that too many at once would take too long for a GPU's watchdog.
    fn steps_at_once(&self) -> usize {
        let shape = &self.targets.shape;
        let pixels = u64::from(shape.size[0]) * u64::from(shape.bands.rows);
        let [few, many] = MOST_STEPS.map(u64::from);
        (few * u64::from(self.band_pixels) / pixels).clamp(few, many) as usize
    }

    /// Runs all stages of a band. Returns the commands that are not submitted yet. If there are many steps, as with
    /// paths, they are submitted in parts. While the host waits for a part, the device works at the next one.
    pub(crate) async fn band(&mut self, plan: &Plan, band: &Band) -> Result<wgpu::CommandEncoder, Error> {
        let gpu = self.gpu;
        let mut encoder = self.encoder();
        let begin = || {
            self.uniforms.set_rows(&self.eyes.sources, band);
            self.upload_uniforms();
            self.clear(&mut encoder, plan.clears_marks());
            Ok(())
        };
        gpu.checked(begin).await?;
        let (all, most) = (plan.step_count() as f32, self.steps_at_once());
        let mut encoded = 0;
        let mut flight: Option<Submission> = None;
        for stage in &plan.stages {
            match stage {
                Stage::Steps(steps) => {
                    for steps in steps.chunks(most) {
                        if encoded >= most {
                            let before = std::mem::replace(&mut encoder, self.encoder());
                            let submitted = gpu.checked(|| Ok(gpu.submit([before.finish()]))).await?;
                            if let Some(before) = flight.replace(submitted) {
                                gpu.finished(before).await?;
                            }
                            self.tell(plan.name(), band.count() as f32 * (encoded - most) as f32 / all)?;
                        }
                        let encode = || {
                            self.encode_all(&mut encoder, steps);
                            Ok(())
                        };
                        gpu.checked(encode).await?;
                        encoded += steps.len();
                    }
                }
                Stage::Host(host) => {
                    let before = std::mem::replace(&mut encoder, self.encoder());
                    gpu.checked(|| Ok(gpu.submit([before.finish()]))).await?;
                    self.run_on_host(host).await?;
                }
            }
        }
        Ok(encoder)
    }

    /// Encodes a band of a plan without stages on the host. The band's rows are set by the last call of `uniforms_of`.
    pub(crate) fn encode_band(&mut self, encoder: &mut wgpu::CommandEncoder, plan: &Plan) {
        self.clear(encoder, plan.clears_marks());
        for stage in &plan.stages {
            match stage {
                Stage::Steps(steps) => self.encode_all(encoder, steps),
                Stage::Host(host) => unreachable!("{host:?} cannot be encoded"),
            }
        }
    }

    /// Clears buffers that steps add to. `marks` says whether the pixels of views that are not traced are cleared too,
    /// since they hold marks.
    fn clear(&mut self, encoder: &mut wgpu::CommandEncoder, marks: bool) {
        for (view, source) in self.eyes.sources.iter().enumerate() {
            let pixels = (marks && *source != view).then_some(Resource::View);
            for resource in [Resource::Counters, Resource::Bounds, Resource::Brought].into_iter().chain(pixels) {
                if let Some(buffer) = self.targets.find((resource, view)) {
                    encoder.clear_buffer(buffer, 0, None);
                }
            }
        }
    }

    /// Adds a band's rows to the rows that are done, and reports progress.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if the caller stops the frame.
    pub(crate) fn band_done(&mut self, plan: &Plan, band: &Band) -> Result<(), Error> {
        self.rows_done += band.count();
        self.tell(plan.name(), 0.0)
    }

    /// Reports a frame's progress: the rows that are done, plus `more` rows.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if the caller stops it.
    fn tell(&mut self, pass: &'static str, more: f32) -> Result<(), Error> {
        let done = ((self.rows_done as f32 + more) / self.targets.shape.bands.height() as f32).min(1.0);
        match (self.progress)(Progress { pass, done }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Cancelled),
        }
    }

    /// Sets the rows of a band, and returns the contents of the uniform buffer for it.
    pub(crate) fn uniforms_of(&mut self, band: &Band) -> Vec<u8> {
        self.uniforms.set_rows(&self.eyes.sources, band);
        self.uniforms.bytes()
    }

    fn upload_uniforms(&self) {
        self.gpu.queue.write_buffer(&self.targets.uniforms, 0, &self.uniforms.bytes());
    }

    /// Returns the number of rows of a view in the current dispatch.
    fn rows_of(&self, view: usize) -> u32 {
        self.uniforms.band(view).row_end - self.uniforms.band(view).row_begin
    }

    pub(crate) fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    pub(crate) fn encode_all(&mut self, encoder: &mut wgpu::CommandEncoder, steps: &[Step]) {
        steps.iter().for_each(|step| self.encode(encoder, *step));
    }

    pub(crate) fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, step: Step) {
        let targets = self.targets;
        match step {
            Step::EmptyLists => {
                let (empty, lists) = (&targets.empty_lists, targets.get(Resource::Lists, 0));
                encoder.copy_buffer_to_buffer(empty, 0, lists, 0, Some(layout::LISTS_HEADS));
            }
            Step::EmptyPaths => {
                let (empty, paths) = (&targets.empty_lists, targets.get(Resource::Paths, 0));
                encoder.copy_buffer_to_buffer(empty, layout::LISTS_HEADS, paths, 0, Some(layout::PATHS_HEADS));
            }
            Step::EmptyBounced => {
                let (empty, bounced) = (&targets.empty_lists, targets.get(Resource::Bounced, 0));
                encoder.copy_buffer_to_buffer(empty, layout::LISTS_HEADS, bounced, 0, Some(layout::BOUNCED_HEADS));
            }
            Step::EmptySlots => self.slots.clear(encoder),
            Step::Clear(resource, bytes) => encoder.clear_buffer(targets.get(resource, 0), 0, bytes),
            Step::Copy(view) => self.encode_copy(encoder, view),
            Step::CopyBounds(view) => self.encode_copy_of_bounds(encoder, view),
            Step::Remember(view) => self.encode_copy_of_samples(encoder, view),
            Step::Run { name, kernel, view, launch, part } => {
                let workgroups = self.launched(kernel, view, launch);
                let uniform = self.uniforms.held(view, part, &targets.uniforms);
                self.resources[view].set(Resource::Frame, uniform);
                self.executor.run(encoder, name, (kernel, self.variant), &self.resources[view], workgroups);
            }
        }
    }

    /// Encodes a kernel that writes a view to a texture.
    pub(crate) fn encode_shown(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        kernel: &'static Kernel,
        view: usize,
        texture: &wgpu::TextureView,
    ) {
        self.resources[view].set(Resource::Picture, texture);
        self.encode(encoder, Step::Run { name: kernel.name, kernel, view, launch: Launch::Pixels, part: 0 });
    }

    /// Encodes the filter of a view's samples, which a kernel has written to a texture, to a picture of this size.
    pub(crate) fn encode_filtered(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        view: usize,
        samples: &wgpu::TextureView,
        (picture, size): (&wgpu::TextureView, [u32; 2]),
    ) {
        self.resources[view].set(Resource::Samples, samples);
        self.resources[view].set(Resource::Picture, picture);
        let [columns, rows] = size.map(|side| side.div_ceil(layout::WORKGROUP));
        let (kernel, launch) = (&FILTER_SAMPLES, Launch::Number([columns, rows, 1]));
        self.encode(encoder, Step::Run { name: kernel.name, kernel, view, launch, part: 0 });
    }

    /// Encodes a copy of a view's current rows from its source.
    fn encode_copy(&self, encoder: &mut wgpu::CommandEncoder, view: usize) {
        let first = self.uniforms.band(view).row_begin;
        let (width, rows) = (self.targets.shape.size[0], self.rows_of(view));
        for resource in [Resource::View, Resource::Linear] {
            let buffers = [self.eyes.sources[view], view].map(|view| self.targets.find((resource, view)));
            if let [Some(from), Some(to)] = buffers {
                let row = u64::from(width) * 16; // bytes per row in either buffer
                let begin = row * u64::from(first);
                encoder.copy_buffer_to_buffer(from, begin, to, begin, Some(row * u64::from(rows)));
            }
        }
    }

    fn history(&self) -> &Remembered {
        self.history.as_ref().expect("a plan with a history has one")
    }

    fn encode_copy_of_bounds(&self, encoder: &mut wgpu::CommandEncoder, view: usize) {
        let (band, to) = (self.uniforms.band(view), self.targets.get(Resource::Bounds, view));
        let tile_rows = |rows: u32| u64::from(rows.div_ceil(layout::TILE));
        let bytes = u64::from(band.size[0].div_ceil(layout::TILE)) * 4 * u64::from(layout::BOUND_WORDS);
        let (first, count) = (tile_rows(band.first_row), tile_rows(band.size[1]));
        encoder.copy_buffer_to_buffer(&self.history().bounds, first * bytes, to, 0, Some(count * bytes));
    }

    fn encode_copy_of_samples(&self, encoder: &mut wgpu::CommandEncoder, view: usize) {
        let band = self.uniforms.band(view);
        let place = |texture, y| wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x: 0, y, z: 0 },
            aspect: wgpu::TextureAspect::All,
        };
        let (from, to) = (self.targets.samples_of(view).texture(), self.history().current.texture());
        let size = wgpu::Extent3d { width: band.size[0], height: self.rows_of(view), depth_or_array_layers: 1 };
        let (from, to) = (place(from, band.row_begin), place(to, band.first_row + band.row_begin));
        encoder.copy_texture_to_texture(from, to, size);
    }

    /// Returns the workgroups of a launch over the tiles of this many rows.
    fn tiles(&self, rows: u32, launch: Launch) -> [u32; 3] {
        match launch {
            Launch::EachTile => [self.targets.shape.size[0].div_ceil(layout::TILE), rows.div_ceil(layout::TILE), 1],
            Launch::WideTiles => self.workgroups(rows, [layout::WIDE_TILE, layout::WIDE_TILE]),
            _ => self.workgroups(rows, [layout::TILE, layout::TILE]),
        }
    }

    /// Returns the workgroups for this many rows, if each thread computes a block of `across` x `down` pixels.
    fn workgroups(&self, rows: u32, [across, down]: [u32; 2]) -> [u32; 3] {
        let runs = self.uniforms.band(0).runs;
        let columns = self.targets.shape.size[0].div_ceil(WORKGROUP * across);
        [columns, rows.div_ceil(WORKGROUP * down).div_ceil(runs), runs]
    }
}
