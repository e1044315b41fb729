//! Runs plans: encoders, bindings, indirect heads and timestamps.

use std::{ops::ControlFlow, sync::Arc, time::Duration};

use super::{
    bands::Band,
    plan::{Launch, Plan, Stage, Step},
    targets::{FRAME_STRIDE, Target, Targets, samples_of},
    wanted::Mask,
};
use crate::{
    Error, OnProgress, Options, Progress, Renderer, Tone, UploadedScene,
    auto::CostModel,
    gpu::{Gpu, Timestamps, bind_group_at},
    kernels::{
        Kernel, Kernels, MASK_BINDING, PICTURE_BINDING, SAMPLES_BINDING, SECOND_SAMPLES_BINDING, SHADOW_BINDING,
        STEPS_BINDING, Touches,
    },
    lanes::Lanes,
    layout::{self, WORKGROUP},
    rig::Eyes,
    samples::Jitter,
    steps::{shadow_buffer::Tables, soft::Part, t_buffer, trace::TRACE_LEFT},
    variant::Variant,
};

/// Runs one frame.
pub(crate) struct Driver<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) kernels: &'a Kernels,
    pub(crate) scene: &'a UploadedScene,
    pub(crate) eyes: &'a Eyes,
    pub(crate) variant: Variant,
    pub(crate) targets: &'a Targets,
    /// The cost model of `Auto`.
    pub(crate) model: CostModel,
    /// The 3D buffer. Until it is sized, it is the last frame's.
    pub(crate) slots: &'a mut Option<wgpu::Buffer>,
    /// Bytes of it that this band uses, and the most that any band has used.
    pub(crate) slot_bytes: u64,
    pub(crate) most_slot_bytes: u64,
    /// The uniforms of each view. Their rows are those of the current band.
    pub(crate) frames: Vec<layout::Frame>,
    /// Parts of soft light, one per dispatch.
    pub(crate) parts: Vec<Part>,
    /// Slots a pixel of the deepest 3D buffer.
    pub(crate) buffer_depth: u32,
    pub(crate) timestamps: Option<&'a mut Timestamps>,
    /// State that threads keep between dispatches, for kernels that run in steps.
    pub(crate) lanes: Option<Lanes>,
    /// Masks of the wanted pixels of each view in the current band, if not all are wanted.
    pub(crate) masks: Vec<wgpu::TextureView>,
    /// Shadow-buffers, if kernels read them.
    pub(crate) shadow_tables: Option<Arc<Tables>>,
    /// The texture that the current kernel writes, if any.
    pub(crate) picture: Option<wgpu::TextureView>,
    /// Time of steps on the host.
    pub(crate) host: Duration,
    pub(crate) rows_done: u32,
    pub(crate) progress: &'a mut OnProgress<'a>,
}

impl<'a> Driver<'a> {
    /// Prepares a frame's first step.
    pub(crate) fn new(
        renderer: &'a mut Renderer,
        scene: &'a UploadedScene,
        eyes: &'a Eyes,
        variant: Variant,
        targets: &'a Targets,
        options: &Options,
        progress: &'a mut OnProgress<'a>,
    ) -> Self {
        if let Some(timestamps) = &mut renderer.timestamps {
            timestamps.restart();
        }
        let model = scene.cost_model(&renderer.gpu, options);
        let jitter = Jitter::of(options);
        let frame = |view| layout::Frame {
            runs: renderer.runs,
            least_spared: model.least_spared(),
            cost_of_listed: model.listed,
            cost_of_disagreed: model.disagreed,
            bounces: options.bounces,
            words_read: targets.shape.words_read(),
            soft_sources: targets.shape.soft_sources,
            seed: options.seed.wrapping_add(if options.noise_by_view { view as u32 } else { 0 }),
            occlusion_radius: options.surroundings().map_or(0.0, |occlusion| occlusion.radius),
            share_tolerance: options.penumbra.tolerance(),
            exposure: options.exposure.exp2(),
            filmic: u32::from(options.tone == Tone::Filmic),
            ..jitter.beside(eyes.frame(view))
        };
        Self {
            gpu: &renderer.gpu,
            kernels: &renderer.kernels,
            scene,
            eyes,
            variant,
            targets,
            model,
            slots: &mut renderer.cache.slots,
            slot_bytes: 0,
            most_slot_bytes: 0,
            frames: (0..eyes.sources.len()).map(frame).collect(),
            parts: if variant.is_soft() { scene.soft.parts(options) } else { Vec::new() },
            buffer_depth: 0,
            timestamps: renderer.timestamps.as_mut(),
            lanes: None,
            masks: Vec::new(),
            shadow_tables: None,
            picture: None,
            host: Duration::ZERO,
            rows_done: 0,
            progress,
        }
    }
}

impl Driver<'_> {
    /// Uploads tables that only some plans read.
    pub(crate) async fn upload_tables(&mut self, plan: &Plan) -> Result<(), Error> {
        if plan.touches_objects() {
            self.scene.upload_object_table(self.gpu, self.kernels).await?;
        }
        Ok(())
    }

    /// Uploads the masks of a band. Those of the previous band have been submitted with its commands.
    pub(crate) async fn upload_masks(&mut self, masks: &[Mask], band: &Band) -> Result<(), Error> {
        let gpu = self.gpu;
        let upload = |mask: &Mask| {
            let (width, texels) = mask.rows(band.first..band.seen.end);
            gpu.filled_texture("wanted_pixels", width, texels)
        };
        let uploaded = gpu.checked(|| Ok(masks.iter().map(upload).collect())).await?;
        let before = std::mem::replace(&mut self.masks, uploaded);
        before.iter().for_each(|view| view.texture().destroy());
        Ok(())
    }

    /// Uploads what all bands of a plan share.
    pub(crate) async fn begin(&mut self, plan: &Plan) -> Result<(), Error> {
        self.upload_tables(plan).await?;
        let write = || {
            self.gpu.queue.write_buffer(&self.targets.empty_lists, 0, bytemuck::cast_slice(&self.heads(plan)));
            Ok(())
        };
        self.gpu.checked(write).await
    }

    /// Returns the initial heads of lists. Dispatches that run whole or not at all are whole until `choose` decides.
    pub(crate) fn heads(&self, plan: &Plan) -> [[u32; 4]; layout::HEADS] {
        let rows = self.targets.shape.bands.rows;
        let block = TRACE_LEFT.block(&self.variant);
        let mut heads = [layout::EMPTY_LIST; layout::HEADS];
        let tile = if plan.wide { layout::WIDE_TILE } else { layout::TILE };
        for (head, block) in [(layout::TO_SEARCH, tile), (layout::ALL_TRACED, block)] {
            heads[head as usize][..3].copy_from_slice(&self.workgroups(rows, [block, block]));
        }
        heads
    }

    /// Runs all stages of a band. Returns the commands that are not submitted yet.
    pub(crate) async fn band(&mut self, plan: &Plan, band: &Band) -> Result<wgpu::CommandEncoder, Error> {
        let gpu = self.gpu;
        let mut encoder = self.encoder();
        let begin = || {
            self.set_rows(band);
            self.upload_frames();
            self.clear(&mut encoder, plan.clears_marks());
            Ok(())
        };
        gpu.checked(begin).await?;
        for stage in &plan.stages {
            match stage {
                Stage::Steps(steps) => {
                    let encode = || {
                        self.encode_all(&mut encoder, steps);
                        Ok(())
                    };
                    gpu.checked(encode).await?;
                }
                Stage::Host(host) => {
                    let before = std::mem::replace(&mut encoder, self.encoder());
                    gpu.checked(|| Ok(gpu.submit([before.finish()]))).await?;
                    host.run(self).await?;
                }
            }
        }
        Ok(encoder)
    }

    /// Clears buffers that steps add to, optionally with the marks of views that are not traced.
    pub(crate) fn clear(&mut self, encoder: &mut wgpu::CommandEncoder, marks: bool) {
        for (view, source) in self.eyes.sources.iter().enumerate() {
            let pixels = (marks && *source != view).then_some(Target::View);
            for target in [Target::Counters, Target::Bounds].into_iter().chain(pixels) {
                if let Some(buffer) = self.targets.find((target, view)) {
                    encoder.clear_buffer(buffer, 0, None);
                }
            }
        }
    }

    /// Reports a frame's progress: the rows done, plus `more` rows.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if the caller stops it.
    pub(crate) fn tell(&mut self, pass: &'static str, more: f32) -> Result<(), Error> {
        let done = ((self.rows_done as f32 + more) / self.targets.shape.bands.height() as f32).min(1.0);
        match (self.progress)(Progress { pass, done }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Cancelled),
        }
    }

    /// Sets the rows of a band for each view. For sources these include the rows above and below that steps read.
    pub(crate) fn set_rows(&mut self, band: &Band) {
        for (view, frame) in self.frames.iter_mut().enumerate() {
            let rows = if self.eyes.sources[view] == view { &band.seen } else { &band.rows };
            frame.first_row = band.first;
            frame.image_size[1] = band.seen.end - band.first;
            (frame.row_begin, frame.row_end) = (rows.start - band.first, rows.end - band.first);
        }
    }

    /// Returns the uniforms of all views, as laid out in the buffer.
    pub(crate) fn frame_bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; self.targets.shape.uniforms_bytes() as usize];
        let parts = self.targets.shape.parts as usize;
        for (index, place) in bytes.chunks_exact_mut(FRAME_STRIDE as usize).enumerate() {
            let mut frame = self.frames[index / parts];
            if let Some(part) = self.parts.get(index % parts) {
                (frame.soft_light, frame.soft_slot, frame.soft_first) = (part.light, part.slot, part.first);
            }
            place[..size_of::<layout::Frame>()].copy_from_slice(bytemuck::bytes_of(&frame));
        }
        bytes
    }

    pub(crate) fn upload_frames(&self) {
        self.gpu.queue.write_buffer(&self.targets.frames, 0, &self.frame_bytes());
    }

    /// Returns the number of a view's rows at work.
    fn rows_of(&self, view: usize) -> u32 {
        self.frames[view].row_end - self.frames[view].row_begin
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
            Step::EmptyLists(lists) => {
                let empty = &targets.empty_lists;
                encoder.copy_buffer_to_buffer(empty, 0, targets.get(lists, 0), 0, Some(empty.size()));
            }
            Step::EmptySlots => {
                let slots = self.slots.as_ref().expect("sized before the step that empties it");
                encoder.clear_buffer(slots, 0, Some(self.slot_bytes));
            }
            Step::EmptyTBuffer => {
                encoder.clear_buffer(targets.get(Target::TBuffer, 0), 0, None);
                encoder.clear_buffer(targets.get(Target::Drawing, 0), 0, Some(t_buffer::DRAWING_HEAD));
            }
            Step::Copy(view) => self.encode_copy(encoder, view),
            Step::Run { name, kernel, view, launch, part } => {
                if let Launch::Listed(from, list) = launch {
                    let head = u64::from(list) * size_of_val(&layout::EMPTY_LIST) as u64;
                    let (lists, indirect) = (targets.get(from, 0), &targets.indirect);
                    encoder.copy_buffer_to_buffer(lists, head, indirect, 0, Some(indirect.size()));
                }
                self.dispatch(encoder, name, kernel, (view, part), launch);
            }
        }
    }

    /// Copies the rows at work of a view from its source.
    fn encode_copy(&self, encoder: &mut wgpu::CommandEncoder, view: usize) {
        let first = self.frames[view].row_begin;
        let (width, rows) = (self.targets.shape.size[0], self.rows_of(view));
        for target in [Target::View, Target::Linear] {
            let buffers = [self.eyes.sources[view], view].map(|view| self.targets.find((target, view)));
            if let [Some(from), Some(to)] = buffers {
                let row = u64::from(width) * 16; // bytes, of either
                let begin = row * u64::from(first);
                encoder.copy_buffer_to_buffer(from, begin, to, begin, Some(row * u64::from(rows)));
            }
        }
    }

    pub(crate) fn dispatch(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        name: &'static str,
        kernel: &Kernel,
        (view, part): (usize, usize),
        launch: Launch,
    ) {
        let pipeline = self.kernels.get(self.gpu, kernel, self.variant);
        let own = self.own_bindings(kernel, (view, part), &pipeline.own);
        let timestamp_writes = self.timestamps.as_mut().and_then(|timestamps| timestamps.next(name));
        let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(&pipeline.pipeline);
        if kernel.touches.geometry() {
            pass.set_bind_group(0, &self.scene.geometry, &[]);
        }
        pass.set_bind_group(1, &own, &[]);
        if kernel.touches.table() {
            let table = match kernel.touches {
                Touches::Objects => &self.scene.object_table.get().expect("uploaded before the step that reads it").0,
                _ => &self.scene.shading,
            };
            pass.set_bind_group(2, table, &[]);
        }
        let rows = self.rows_of(view);
        let block = kernel.block(&self.variant);
        let [x, y, z] = match launch {
            Launch::Pixels => self.workgroups(rows, [block, block]),
            Launch::Runs(pixels) => self.workgroups(rows, [pixels, 1]),
            Launch::Tiles => self.workgroups(rows, [layout::TILE, layout::TILE]),
            Launch::WideTiles => self.workgroups(rows, [layout::WIDE_TILE, layout::WIDE_TILE]),
            Launch::Rows => [1, rows.div_ceil(WORKGROUP * WORKGROUP), 1],
            Launch::Primitives => t_buffer::workgroups(self.targets.shape.drawn),
            Launch::Once => [1, 1, 1],
            Launch::Listed(..) => return pass.dispatch_workgroups_indirect(&self.targets.indirect, 0),
        };
        pass.dispatch_workgroups(x, y, z);
    }

    /// Returns the workgroups for this many rows, if each thread has a block of `across` x `down` pixels.
    fn workgroups(&self, rows: u32, [across, down]: [u32; 2]) -> [u32; 3] {
        let runs = self.frames[0].runs;
        let columns = self.targets.shape.size[0].div_ceil(WORKGROUP * across);
        [columns, rows.div_ceil(WORKGROUP * down).div_ceil(runs), runs]
    }

    /// Returns bind group 1 of a kernel: the frame, the buffers in its `storage`, and its other resources.
    fn own_bindings(
        &self,
        kernel: &Kernel,
        (view, part): (usize, usize),
        layout: &wgpu::BindGroupLayout,
    ) -> wgpu::BindGroup {
        let source = self.eyes.sources[view];
        let frame = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.targets.frames,
            offset: (view * self.targets.shape.parts as usize + part) as u64 * FRAME_STRIDE,
            size: std::num::NonZeroU64::new(size_of::<layout::Frame>() as u64),
        });
        let buffer = |target: Target| match target.of(view, source) {
            (Target::Slots, _) => self.slots.as_ref().expect("sized before the step that uses it"),
            (target, view) => self.targets.get(target, view),
        };
        let storage = kernel.storage.iter().map(|(target, _)| buffer(*target).as_entire_binding());
        let linear = kernel.linear(&self.variant).iter();
        let linear = linear.map(|(target, binding)| (*binding, buffer(*target).as_entire_binding()));
        let samples = kernel.samples(&self.variant).map(|access| {
            let texture = self.targets.samples(samples_of(view, source, access));
            (SAMPLES_BINDING, wgpu::BindingResource::TextureView(texture))
        });
        let second = kernel.asks_second(&self.variant).then(|| {
            let texture = self.targets.samples(self.eyes.seconds[view]);
            (SECOND_SAMPLES_BINDING, wgpu::BindingResource::TextureView(texture))
        });
        let mask = kernel.reads_mask(&self.variant.of_kernel(kernel)).then(|| &self.masks[view]);
        let mask = mask.map(|texture| (MASK_BINDING, wgpu::BindingResource::TextureView(texture)));
        let tables =
            self.shadow_tables.as_ref().filter(|_| kernel.shadow_buffer(&self.variant.of_kernel(kernel)).is_some());
        let tables = tables.map(|tables| (SHADOW_BINDING, wgpu::BindingResource::TextureView(&tables.view)));
        let picture = self.picture.as_ref().filter(|_| kernel.picture().is_some());
        let picture = picture.map(|texture| (PICTURE_BINDING, wgpu::BindingResource::TextureView(texture)));
        let lanes = self.lanes.as_ref().filter(|_| kernel.in_steps());
        let lanes = lanes.map(|lanes| (STEPS_BINDING, lanes.buffer.as_entire_binding()));
        let resources = (0..)
            .zip(std::iter::once(frame).chain(storage))
            .chain(linear)
            .chain(samples)
            .chain(second)
            .chain(mask)
            .chain(tables)
            .chain(lanes)
            .chain(picture);
        bind_group_at(self.gpu, kernel.name, layout, resources)
    }
}
