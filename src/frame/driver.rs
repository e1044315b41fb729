//! Runs plans: bands of rows, encoders, indirect heads, timestamps, progress and cancel.

use std::{ops::ControlFlow, sync::Arc, time::Duration};

use super::{
    plan::{Launch, Made, Plan, Stage, Step},
    targets::{FRAME_STRIDE, Target, Targets},
};
use crate::{
    Choice, Error, OnProgress, Progress, UploadedScene,
    gpu::{Gpu, Timestamps, bind_group_at},
    kernels::{Access, Kernel, Kernels, SAMPLES_BINDING, STEPS_BINDING, Touches},
    layout::{self, WORKGROUP},
    rig::Eyes,
    variant::Variant,
};

/// One frame at work.
pub(crate) struct Driver<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) kernels: &'a Kernels,
    pub(crate) scene: &'a UploadedScene,
    pub(crate) eyes: &'a Eyes,
    pub(crate) variant: Variant,
    pub(crate) targets: &'a Targets,
    /// The 3D buffer, once it has been sized; before, the last frame's.
    pub(crate) slots: &'a mut Option<Arc<wgpu::Buffer>>,
    /// Bytes of it that a band uses.
    pub(crate) slot_bytes: u64,
    /// Rows of a band.
    pub(crate) rows: u32,
    /// Of each view; rows are those of the band at work.
    pub(crate) frames: Vec<layout::Frame>,
    pub(crate) timestamps: Option<&'a mut Timestamps>,
    /// What threads keep from dispatch to dispatch, for kernels that go on.
    pub(crate) lanes: Option<wgpu::Buffer>,
    /// Time of what the host did in place of a step.
    pub(crate) host: Duration,
    /// What `Auto` chose for each view.
    pub(crate) choices: Vec<Option<Choice>>,
    /// How each view came about.
    pub(crate) made: Vec<Made>,
    pub(crate) rows_done: f32,
    pub(crate) rows_total: f32,
    pub(crate) progress: &'a mut OnProgress<'a>,
}

impl Driver<'_> {
    /// All stages, in order.
    pub(crate) async fn run(&mut self, plan: &Plan) -> Result<(), Error> {
        if plan.touches_objects() {
            self.scene.upload_object_table(self.gpu, self.kernels).await?;
        }
        self.clear().await?;
        self.made.clone_from(&plan.made);
        for stage in &plan.stages {
            match stage {
                Stage::Bands(steps) => self.bands(steps).await?,
                Stage::Wait => {}
                Stage::Host(host) => {
                    let steps = host.run(self).await?;
                    if !steps.is_empty() {
                        self.bands(&steps).await?;
                    }
                }
            }
        }
        Ok(())
    }

    /// What steps add to. (By `&mut self`, since a reference that is shared would keep the frame's future from other threads: the
    /// callback for progress is no `Sync`.)
    pub(crate) async fn clear(&mut self) -> Result<(), Error> {
        let clear = || {
            let mut encoder = self.encoder();
            for (view, source) in self.eyes.sources.iter().enumerate() {
                // Of a view that is not traced the marks.
                let pixels = (*source != view).then_some(Target::View);
                for target in [Target::Counters, Target::Bounds].into_iter().chain(pixels) {
                    if let Some(buffer) = self.targets.find((target, view)) {
                        encoder.clear_buffer(buffer, 0, None);
                    }
                }
            }
            self.gpu.queue.submit([encoder.finish()]);
            Ok(())
        };
        self.gpu.checked(clear).await
    }

    /// Steps over the picture, band by band, each in one submission. At most two bands are in flight, so that progress means
    /// something and a callback can stop the frame.
    pub(crate) async fn bands(&mut self, steps: &[Step]) -> Result<(), Error> {
        let gpu = self.gpu;
        let name = steps.iter().rev().find_map(|step| step.name()).unwrap_or_default();
        let height = self.eyes.pose.size[1];
        let mut before = None;
        for begin in (0..height).step_by(self.rows as usize) {
            let submit = || {
                self.write_frames(begin, height.min(begin + self.rows));
                let mut encoder = self.encoder();
                for step in steps {
                    self.encode(&mut encoder, *step);
                }
                Ok(gpu.submit([encoder.finish()]))
            };
            let submission = gpu.checked(submit).await?;
            if let Some(before) = before.replace(submission) {
                gpu.finished(before).await?;
            }
            self.rows_done += self.at_work()[1] as f32;
            self.tell(name, 0.0)?;
        }
        Ok(())
    }

    /// Tells the caller how far the frame is, with so many rows more than are done.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if the caller stops it.
    pub(crate) fn tell(&mut self, pass: &'static str, more: f32) -> Result<(), Error> {
        let done = ((self.rows_done + more) / self.rows_total).min(1.0);
        match (self.progress)(Progress { pass, done }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Cancelled),
        }
    }

    /// The eyes and a band's rows, for each view.
    pub(crate) fn write_frames(&mut self, begin: u32, end: u32) {
        let mut bytes = vec![0; self.frames.len() * FRAME_STRIDE as usize];
        for (frame, place) in self.frames.iter_mut().zip(bytes.chunks_exact_mut(FRAME_STRIDE as usize)) {
            (frame.row_begin, frame.row_end) = (begin, end);
            place[..size_of::<layout::Frame>()].copy_from_slice(bytemuck::bytes_of(frame));
        }
        self.gpu.queue.write_buffer(&self.targets.frames, 0, &bytes);
    }

    /// Picture size and rows at work.
    fn at_work(&self) -> [u32; 2] {
        [self.eyes.pose.size[0], self.frames[0].row_end - self.frames[0].row_begin]
    }

    pub(crate) fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, step: Step) {
        let targets = self.targets;
        match step {
            Step::EmptyLists => {
                let empty = &targets.empty_lists;
                encoder.copy_buffer_to_buffer(empty, 0, targets.lists(), 0, Some(empty.size()));
            }
            Step::EmptySlots => {
                let slots = self.slots.as_ref().expect("sized before the step that empties it");
                encoder.clear_buffer(slots, 0, Some(self.slot_bytes));
            }
            Step::Copy(view) => self.encode_copy(encoder, view),
            Step::Run { name, kernel, view, launch } => {
                if let Launch::Listed(list) = launch {
                    let head = u64::from(list) * size_of_val(&layout::EMPTY_LIST) as u64;
                    let (lists, indirect) = (targets.lists(), &targets.indirect);
                    encoder.copy_buffer_to_buffer(lists, head, indirect, 0, Some(indirect.size()));
                }
                self.dispatch(encoder, name, kernel, view, launch);
            }
        }
    }

    /// The rows at work of a view become its source's.
    fn encode_copy(&self, encoder: &mut wgpu::CommandEncoder, view: usize) {
        let first = self.frames[view].row_begin;
        let [width, rows] = self.at_work();
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
        view: usize,
        launch: Launch,
    ) {
        let pipeline = self.kernels.get(self.gpu, kernel, self.variant);
        let own = self.own_bindings(kernel, view, &pipeline.own);
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
        let [width, rows] = self.at_work();
        // Pixels of a thread in x and in y.
        let runs = self.frames[view].runs;
        let mut over = |x: u32, y: u32| {
            let rows = rows.div_ceil(WORKGROUP * y).div_ceil(runs);
            pass.dispatch_workgroups(width.div_ceil(WORKGROUP * x), rows, runs);
        };
        match launch {
            Launch::Pixels => over(kernel.block(&self.variant), kernel.block(&self.variant)),
            Launch::Runs => over(layout::TILE, 1),
            Launch::Tiles => over(layout::TILE, layout::TILE),
            Launch::Rows => pass.dispatch_workgroups(1, rows.div_ceil(WORKGROUP * WORKGROUP), 1),
            Launch::Listed(_) => pass.dispatch_workgroups_indirect(&self.targets.indirect, 0),
        }
    }

    /// Group 1 of a kernel: the frame, the buffers that it names, and what else it has.
    fn own_bindings(&self, kernel: &Kernel, view: usize, layout: &wgpu::BindGroupLayout) -> wgpu::BindGroup {
        let source = self.eyes.sources[view];
        let frame = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.targets.frames,
            offset: view as u64 * FRAME_STRIDE,
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
            let texture = &self.targets.samples[if access == Access::Write { &view } else { &source }];
            (SAMPLES_BINDING, wgpu::BindingResource::TextureView(texture))
        });
        let lanes = self.lanes.as_ref().filter(|_| kernel.in_steps());
        let lanes = lanes.map(|buffer| (STEPS_BINDING, buffer.as_entire_binding()));
        let resources = (0..).zip(std::iter::once(frame).chain(storage)).chain(linear).chain(samples).chain(lanes);
        bind_group_at(self.gpu, kernel.name, layout, resources)
    }

    /// Waits for the last band and lets the timestamps be read.
    pub(crate) async fn finish(&mut self) -> Result<(), Error> {
        let resolve = || {
            let mut encoder = self.encoder();
            if let Some(timestamps) = &self.timestamps {
                timestamps.resolve(&mut encoder);
            }
            Ok(self.gpu.submit([encoder.finish()]))
        };
        let submission = self.gpu.checked(resolve).await?;
        self.gpu.finished(submission).await
    }
}
