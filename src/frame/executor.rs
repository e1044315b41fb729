//! Runs kernels. Only this module binds resources and begins passes, for frames, ray lists and shadow-buffers.

use std::collections::BTreeMap;

use crate::{
    gpu::{Acceleration, Gpu, Texels, Timestamps, bind_group},
    kernel::variant::Variant,
    kernel::{Kernel, Kernels, Ready, Resource},
};

/// A resource on the device.
#[derive(Clone, Debug)]
pub(crate) enum Held {
    Buffer(wgpu::Buffer),
    /// One uniform in a buffer of several.
    Uniform {
        buffer: wgpu::Buffer,
        offset: u64,
        bytes: u64,
    },
    Texture(wgpu::TextureView),
    Acceleration(Acceleration),
}

impl Held {
    fn binding(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Uniform { buffer, offset, bytes } => wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset: *offset,
                size: std::num::NonZeroU64::new(*bytes),
            }),
            Self::Texture(view) => wgpu::BindingResource::TextureView(view),
            Self::Acceleration(scene) => scene.binding(),
        }
    }
}

impl From<&wgpu::Buffer> for Held {
    fn from(buffer: &wgpu::Buffer) -> Self {
        Self::Buffer(buffer.clone())
    }
}

impl From<&wgpu::TextureView> for Held {
    fn from(view: &wgpu::TextureView) -> Self {
        Self::Texture(view.clone())
    }
}

impl From<&Acceleration> for Held {
    fn from(scene: &Acceleration) -> Self {
        Self::Acceleration(scene.clone())
    }
}

impl From<&Texels> for Held {
    fn from(texels: &Texels) -> Self {
        match texels {
            Texels::Texture(view) => view.into(),
            Texels::Buffer(buffer) => buffer.into(),
        }
    }
}

/// Resources by name. The code that creates a resource also frees it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Resources(BTreeMap<Resource, Held>);

impl Resources {
    /// Adds a resource, or replaces it.
    pub(crate) fn set(&mut self, resource: Resource, held: impl Into<Held>) {
        self.0.insert(resource, held.into());
    }

    /// Adds a resource, or replaces it.
    pub(crate) fn with(mut self, resource: Resource, held: impl Into<Held>) -> Self {
        self.set(resource, held);
        self
    }
}

/// Number of workgroups of a dispatch.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Workgroups<'a> {
    Number([u32; 3]),
    /// Indirect dispatch by the head of a list in a buffer: the buffer, and the list's index.
    Listed(&'a wgpu::Buffer, u32),
}

/// Encodes kernels with their resources.
#[derive(Debug)]
pub(crate) struct Executor<'a> {
    gpu: &'a Gpu,
    kernels: &'a Kernels,
    /// Buffer for the head of the current list. The head is copied, since an indirect buffer may not be bound for
    /// writing.
    indirect: Option<&'a wgpu::Buffer>,
    timestamps: Option<&'a mut Timestamps>,
}

/// Number of bytes of a list's head that an indirect dispatch reads.
pub(crate) const INDIRECT_BYTES: u64 = 12;

/// Creates a buffer for the head of a list.
pub(crate) fn indirect_buffer(gpu: &Gpu) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("indirect"),
        size: INDIRECT_BYTES,
        usage: wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

impl<'a> Executor<'a> {
    /// Creates an executor. `indirect` is needed for dispatches over lists. Without `timestamps`, nothing is timed.
    pub(crate) fn new(
        gpu: &'a Gpu,
        kernels: &'a Kernels,
        indirect: Option<&'a wgpu::Buffer>,
        timestamps: Option<&'a mut Timestamps>,
    ) -> Self {
        Self { gpu, kernels, indirect, timestamps }
    }

    pub(crate) fn timestamps(&mut self) -> Option<&mut Timestamps> {
        self.timestamps.as_deref_mut()
    }

    /// Encodes a pass of one kernel. `name` is its name in timings.
    pub(crate) fn run(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        name: &'static str,
        (kernel, with): (&Kernel, Variant),
        resources: &Resources,
        workgroups: Workgroups<'_>,
    ) {
        let Ready { pipeline, bound } = self.kernels.get(self.gpu, kernel, with);
        let held = bound.iter().map(|resource| match resources.0.get(resource) {
            Some(held) => held.binding(),
            None => panic!("{name} binds {resource:?}, which nothing made"),
        });
        let group = bind_group(self.gpu, name, &pipeline.layout, held);
        let indirect = || self.indirect.expect("made for dispatches over lists");
        if let Workgroups::Listed(lists, list) = workgroups {
            let head = u64::from(list) * size_of_val(&crate::kernel::layout::EMPTY_LIST) as u64;
            encoder.copy_buffer_to_buffer(lists, head, indirect(), 0, Some(INDIRECT_BYTES));
        }
        let timestamp_writes = self.timestamps.as_mut().and_then(|timestamps| timestamps.next(name));
        let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, &group, &[]);
        match workgroups {
            Workgroups::Number([x, y, z]) => {
                self.gpu.counted.dispatches.add(1);
                pass.dispatch_workgroups(x, y, z);
            }
            Workgroups::Listed(..) => {
                self.gpu.counted.indirect_dispatches.add(1);
                pass.dispatch_workgroups_indirect(self.indirect.expect("as above"), 0);
            }
        }
    }
}
