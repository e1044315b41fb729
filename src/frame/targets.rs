//! What kernels of a frame read and write, by name, and the buffers behind the names.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use super::plan::Eye;
use crate::{
    Error,
    gpu::{Gpu, check_bytes},
    layout::{self, WORKGROUP},
    variant::Kept,
};

/// A buffer of a frame, by what it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Target {
    /// Linear colour of the view at work: `LeftColor` or `RightColor`.
    Color,
    /// Linear colour of the left view, RGB and 1.
    LeftColor,
    /// Linear colour of the right view.
    RightColor,
    /// What pixels hit, of both views.
    Hits,
    /// The left column that a right pixel is taken from, and marks.
    RightSource,
    /// How deep each tile of right pixels is searched.
    Bounds,
    /// Counters of each row, and behind them a map of costs.
    Counters,
    /// Lists of pixels and tiles of a band, with indirect heads.
    Lists,
    /// What `search_tiles` finds in a band.
    Found,
    /// The 3D buffer of a band.
    Slots,
    /// 8-bit colour of both views.
    Pictures,
}

impl Target {
    /// The buffer that a step of a view means.
    pub(crate) fn of(self, eye: Eye) -> Self {
        match (self, eye) {
            (Self::Color, Eye::Left) => Self::LeftColor,
            (Self::Color, Eye::Right) => Self::RightColor,
            (target, _) => target,
        }
    }

    /// Whether it is a part of the pair, not something between its steps.
    fn is_output(self) -> bool {
        matches!(self, Self::LeftColor | Self::RightColor | Self::Pictures)
    }
}

/// What the sizes of a frame's buffers follow from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    pub(crate) size: [u32; 2],
    /// Rows of a band.
    pub(crate) rows: u32,
    pub(crate) kept: Kept,
    pub(crate) cost_map: bool,
}

impl Shape {
    fn bytes(&self, target: Target) -> u64 {
        let [width, height] = self.size.map(u64::from);
        let pixels = width * height;
        let band = width * u64::from(self.rows);
        let tiles = |rows: u64| width.div_ceil(layout::TILE.into()) * rows.div_ceil(layout::TILE.into());
        match target {
            Target::Color | Target::LeftColor | Target::RightColor => pixels.saturating_mul(16),
            Target::Hits => pixels.saturating_mul(2 * self.kept.bytes()),
            Target::RightSource => pixels * 4,
            Target::Bounds => tiles(height) * 4,
            Target::Counters => 4 * (height * layout::COUNTERS as u64 + if self.cost_map { 2 * pixels } else { 0 }),
            Target::Lists => layout::LISTS_HEADS + layout::LISTS as u64 * band * 4,
            Target::Found => 4 * tiles(self.rows.into()) * u64::from(layout::TILE_BLOCKS * layout::LIST_WORDS),
            Target::Pictures => pixels * 8,
            // Made when its depth is known.
            Target::Slots => 0,
        }
    }

    fn samples_bytes(&self) -> u64 {
        if self.kept == Kept::Samples { 16 * u64::from(self.size[0]) * u64::from(self.size[1]) } else { 0 }
    }

    /// # Errors
    /// [`Error::Limit`], naming the limit that a picture of this size does not keep.
    fn check(&self, gpu: &Gpu, targets: &BTreeSet<Target>) -> Result<(), Error> {
        let [width, height] = self.size;
        let what = format!("a {width}x{height} picture");
        let largest = targets.iter().map(|target| self.bytes(*target)).max().unwrap_or(0);
        check_bytes(&what, largest, gpu.binding_limit(), "render a smaller one")?;
        let limit = |what, needed, limit, allowed: u32, remedy| {
            Err(Error::Limit { what, needed, limit, allowed: allowed.to_string(), remedy })
        };
        let side = gpu.limits.max_texture_dimension_2d;
        if self.kept == Kept::Samples && width.max(height) > side {
            let (what, needed) = (format!("{what} by bracket"), format!("a texture of {width}x{height}"));
            return limit(what, needed, "max_texture_dimension_2d", side, "render a smaller one, or by another method");
        }
        let workgroups = width.max(self.rows).div_ceil(WORKGROUP);
        let allowed = gpu.limits.max_compute_workgroups_per_dimension;
        if workgroups > allowed {
            let needed = format!("{workgroups} workgroups in a row or column");
            return limit(what, needed, "max_compute_workgroups_per_dimension", allowed, "render a smaller one");
        }
        Ok(())
    }
}

/// The buffers of a frame. A renderer keeps them for the next one.
#[derive(Debug)]
pub(crate) struct Targets {
    pub(crate) shape: Shape,
    /// A `layout::Frame` of each view.
    pub(crate) frames: wgpu::Buffer,
    /// The head of the list at work: what dispatches may not be bound for writing.
    pub(crate) indirect: wgpu::Buffer,
    /// What `bracket` asks of the left view's samples.
    pub(crate) samples: Option<wgpu::TextureView>,
    /// The heads of empty lists.
    pub(crate) empty_lists: wgpu::Buffer,
    buffers: BTreeMap<Target, wgpu::Buffer>,
}

/// From one view's `layout::Frame` to the next, in bytes: WebGPU's default alignment of uniform offsets.
pub(crate) const FRAME_STRIDE: u64 = 256;

impl Targets {
    /// # Errors
    /// [`Error::Limit`] for a picture that the adapter can't bind.
    pub(crate) fn new(gpu: &Gpu, shape: Shape, wanted: &BTreeSet<Target>) -> Result<Self, Error> {
        shape.check(gpu, wanted)?;
        let buffer = |target: &Target| (*target, gpu.storage_buffer(&format!("{target:?}"), shape.bytes(*target)));
        let plain = |label, size, usage| {
            let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
            gpu.device.create_buffer(&descriptor)
        };
        let empty = [layout::EMPTY_LIST; layout::LISTS];
        let empty_lists =
            plain("empty_lists", layout::LISTS_HEADS, wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST);
        gpu.queue.write_buffer(&empty_lists, 0, bytemuck::cast_slice(&empty));
        Ok(Self {
            shape,
            frames: plain("frames", 2 * FRAME_STRIDE, wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST),
            indirect: plain("indirect", 12, wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST),
            samples: (shape.kept == Kept::Samples).then(|| samples_texture(gpu, shape.size)),
            empty_lists,
            buffers: wanted.iter().map(buffer).collect(),
        })
    }

    /// Whether they will do for another frame.
    pub(crate) fn fit(&self, shape: Shape, wanted: &BTreeSet<Target>) -> bool {
        self.shape == shape && wanted.iter().all(|target| self.buffers.contains_key(target))
    }

    /// The buffer behind a name; `Slots` and `Color` are the driver's to tell.
    pub(crate) fn get(&self, target: Target) -> &wgpu::Buffer {
        &self.buffers[&target]
    }

    /// The same, if the frame has it.
    pub(crate) fn find(&self, target: Target) -> Option<&wgpu::Buffer> {
        self.buffers.get(&target)
    }

    /// Bytes between the steps of a plan that uses these, without the pair's own pictures.
    pub(crate) fn intermediate_bytes(&self, used: &BTreeSet<Target>) -> u64 {
        let between = used.iter().filter(|target| !target.is_output());
        between.map(|target| self.buffers[target].size()).sum::<u64>() + self.shape.samples_bytes()
    }
}

fn samples_texture(gpu: &Gpu, [width, height]: [u32; 2]) -> wgpu::TextureView {
    // Not left to wgpu, which clears it at its first use: after a clear Mesa's software driver takes every timestamp too early.
    gpu.filled_texture("left_samples", width, &vec![[0; 4]; width as usize * height as usize])
}

/// Kept by a renderer from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Cache {
    pub(crate) targets: Option<Arc<Targets>>,
    pub(crate) slots: Option<Arc<wgpu::Buffer>>,
}
