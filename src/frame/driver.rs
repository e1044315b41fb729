//! Runs plans: bands of rows, encoders, indirect heads, timestamps, progress and cancel.

use std::{ops::ControlFlow, sync::Arc, time::Duration};

use super::{
    plan::{Eye, Launch, Plan, RightView, Stage, Step},
    targets::{FRAME_STRIDE, Target, Targets},
};
use crate::{
    Choice, Error, OnProgress, Pose, Progress, UploadedScene,
    gpu::{Gpu, Timestamps, bind_group_at},
    kernels::{Kernel, Kernels, SAMPLES_BINDING, STEPS_BINDING, Touches},
    layout::{self, WORKGROUP},
    variant::Variant,
};

/// One frame at work.
pub(crate) struct Driver<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) kernels: &'a Kernels,
    pub(crate) scene: &'a UploadedScene,
    pub(crate) pose: &'a Pose,
    pub(crate) variant: Variant,
    pub(crate) targets: &'a Targets,
    /// The 3D buffer, once it has been sized; before, the last frame's.
    pub(crate) slots: &'a mut Option<Arc<wgpu::Buffer>>,
    /// Bytes of it that a band uses.
    pub(crate) slot_bytes: u64,
    /// Rows of a band.
    pub(crate) rows: u32,
    pub(crate) frame: layout::Frame,
    pub(crate) timestamps: Option<&'a mut Timestamps>,
    /// What threads keep from dispatch to dispatch, for kernels that go on.
    pub(crate) lanes: Option<wgpu::Buffer>,
    /// Time of what the host did in place of a step.
    pub(crate) host: Duration,
    /// What `Auto` chose.
    pub(crate) choice: Option<Choice>,
    /// Where right pixels are in the end.
    pub(crate) right: RightView,
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
        self.clear(&[Target::Counters, Target::RightSource, Target::Bounds]).await?;
        self.variant.bits = plan.bits;
        self.right = plan.right;
        for stage in &plan.stages {
            match stage {
                Stage::Bands(steps) => self.bands(steps).await?,
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

    /// Those of these buffers that the frame has. (By `&mut self`, since a reference that is shared would keep the frame's future
    /// from other threads: the callback for progress is no `Sync`.)
    pub(crate) async fn clear(&mut self, targets: &[Target]) -> Result<(), Error> {
        let clear = || {
            let mut encoder = self.encoder();
            for buffer in targets.iter().filter_map(|target| self.targets.find(*target)) {
                encoder.clear_buffer(buffer, 0, None);
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
        let height = self.pose.size[1];
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
            self.rows_done += (self.frame.row_end - begin) as f32;
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

    /// The camera and a band's rows, for either view.
    pub(crate) fn write_frames(&mut self, begin: u32, end: u32) {
        (self.frame.row_begin, self.frame.row_end) = (begin, end);
        let spread = |height: u32| self.spread_rows((end - begin).div_ceil(height));
        let spreads = (spread(WORKGROUP), spread(2 * WORKGROUP), spread(layout::TILE * WORKGROUP));
        (self.frame.spread_8, self.frame.spread_16, self.frame.spread_64) = spreads;
        for eye in [Eye::Left, Eye::Right] {
            let frame = layout::Frame { eye: eye as u32, ..self.frame };
            let offset = eye as u64 * FRAME_STRIDE;
            self.gpu.queue.write_buffer(&self.targets.frames, offset, bytemuck::bytes_of(&frame));
        }
    }

    /// The stride in which so many rows of workgroups come: on software adapters, which run one part of them after the other in
    /// each of their threads, about a golden section of them, so that every part is spread over the picture.
    pub(super) fn spread_rows(&self, count: u32) -> u32 {
        if self.gpu.adapter_info().device_type != wgpu::DeviceType::Cpu {
            return 1;
        }
        let golden = 0.618 * f64::from(count);
        let off = |stride: u32| (f64::from(stride) - golden).abs();
        let strides = (1..count).filter(|stride| coprime(*stride, count));
        strides.min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(1)
    }

    pub(crate) fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, step: Step) {
        let targets = self.targets;
        match step {
            Step::EmptyLists => {
                let empty = &targets.empty_lists;
                encoder.copy_buffer_to_buffer(empty, 0, targets.get(Target::Lists), 0, Some(empty.size()));
            }
            Step::EmptySlots => {
                let slots = self.slots.as_ref().expect("sized before the step that empties it");
                encoder.clear_buffer(slots, 0, Some(self.slot_bytes));
            }
            Step::Run { name, kernel, eye, launch } => {
                if let Launch::Listed(list) = launch {
                    let head = u64::from(list) * size_of_val(&layout::EMPTY_LIST) as u64;
                    let (lists, indirect) = (targets.get(Target::Lists), &targets.indirect);
                    encoder.copy_buffer_to_buffer(lists, head, indirect, 0, Some(indirect.size()));
                }
                self.dispatch(encoder, name, kernel, eye, launch);
            }
        }
    }

    pub(crate) fn dispatch(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        name: &'static str,
        kernel: &Kernel,
        eye: Eye,
        launch: Launch,
    ) {
        let pipeline = self.kernels.get(self.gpu, kernel, self.variant);
        let own = self.own_bindings(kernel, eye, &pipeline.own);
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
        let [width, rows] = [self.pose.size[0], self.frame.row_end - self.frame.row_begin];
        // Pixels of a thread in x and in y.
        let mut over = |x: u32, y: u32| {
            pass.dispatch_workgroups(width.div_ceil(WORKGROUP * x), rows.div_ceil(WORKGROUP * y), 1);
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
    fn own_bindings(&self, kernel: &Kernel, eye: Eye, layout: &wgpu::BindGroupLayout) -> wgpu::BindGroup {
        let frame = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.targets.frames,
            offset: eye as u64 * FRAME_STRIDE,
            size: std::num::NonZeroU64::new(size_of::<layout::Frame>() as u64),
        });
        let buffer = |target: &Target| match target.of(eye) {
            Target::Slots => self.slots.as_ref().expect("sized before the step that uses it"),
            target => self.targets.get(target),
        };
        let storage = kernel.storage.iter().map(|(target, _)| buffer(target).as_entire_binding());
        let samples = kernel.samples(&self.variant).and(self.targets.samples.as_ref());
        let samples = samples.map(|view| (SAMPLES_BINDING, wgpu::BindingResource::TextureView(view)));
        let lanes = self.lanes.as_ref().filter(|_| kernel.in_steps());
        let lanes = lanes.map(|buffer| (STEPS_BINDING, buffer.as_entire_binding()));
        let resources = (0..).zip(std::iter::once(frame).chain(storage)).chain(samples).chain(lanes);
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

fn coprime(a: u32, b: u32) -> bool {
    if b == 0 { a == 1 } else { coprime(b, a % b) }
}
