//! Buffers and textures that a frame's kernels read and write, by name.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use super::{
    bands::Bands,
    executor::{Held, Resources, indirect_buffer},
    history::History,
    uniforms::uniforms_bytes,
};
use crate::{
    Error, GBuffer,
    gpu::{Gpu, Staging, check_bytes},
    kernel::Resource,
    kernel::layout::{self, WORKGROUP},
};

/// A buffer or texture of a frame, and the index of the view that owns it. Resources that views share belong to view 0.
pub(crate) type Place = (Resource, usize);

/// View index for the samples of traced views that have a source. No kernel reads these samples.
const UNREAD: usize = usize::MAX;

impl Resource {
    /// Returns the place of the buffer or texture that a step binds by this name, for a view with this source. Returns
    /// `None` if targets do not hold the resource.
    pub(crate) fn of(self, view: usize, source: usize) -> Option<Place> {
        match self {
            Self::Source => Some((Self::View, source)),
            Self::SourceLinear => Some((Self::Linear, source)),
            Self::SourceCounters => Some((Self::Counters, source)),
            Self::SourceBrought => Some((Self::Brought, source)),
            Self::SourceSamples => Some((Self::KeptSamples, source)),
            Self::KeptSamples => Some((self, if view == source { view } else { UNREAD })),
            Self::View | Self::Linear | Self::Bounds | Self::Counters | Self::Brought | Self::LightParts => {
                Some((self, view))
            }
            Self::Packed | Self::Lists | Self::TBuffer | Self::Drawing => Some((self, 0)),
            Self::Unfinished | Self::Paths | Self::Proposed | Self::Bounced => Some((self, 0)),
            Self::Frame | Self::Bvh | Self::Geometry | Self::Table | Self::ObjectTable | Self::Acceleration => None,
            Self::History | Self::HistoryBounds | Self::EarlierLight | Self::KeptLight => None,
            Self::Slots | Self::SecondSamples | Self::Wanted | Self::ShadowBuffers | Self::Picture => None,
            Self::Texels | Self::Steps | Self::RayList | Self::Found => None,
            Self::NoisyLight | Self::SmoothLight | Self::Guides => None,
            Self::Samples | Self::Combining | Self::LeftPicture | Self::RightPicture => None,
        }
    }

    /// Returns whether the resource is output rather than an intermediate.
    fn is_output(self) -> bool {
        matches!(self, Self::View | Self::Packed | Self::Linear | Self::LightParts)
    }
}

/// Parameters that determine the sizes of a frame's buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    /// Size of the picture, in pixels.
    pub(crate) size: [u32; 2],
    pub(crate) bands: Bands,
    pub(crate) views: usize,
    pub(crate) cost_map: bool,
    pub(crate) g_buffer: GBuffer,
    /// Number of lights that are not point lights, plus one for sampled ambient light.
    pub(crate) soft_sources: u32,
    /// Size of the lists of drawn primitives in bytes; 0 without them.
    pub(crate) drawing_bytes: u64,
    /// Number of parts of soft light, at least one.
    pub(crate) parts: u32,
}

impl Shape {
    /// Returns the numbers of columns and rows of the frame's buffers, which hold one band.
    pub(crate) fn kept(&self) -> [u32; 2] {
        [self.size[0], self.bands.rows_kept()]
    }

    /// Returns the number of words per pixel that are read back: colour with marks, then depth, then slot.
    pub(crate) fn words_read(&self) -> u32 {
        match self.g_buffer {
            GBuffer::None => 1,
            GBuffer::Depth => 2,
            GBuffer::Ids => 3,
        }
    }

    /// Returns the size of a resource in bytes. `searched` says whether lists have results of tile searches.
    fn bytes(&self, resource: Resource, searched: bool) -> u64 {
        let [width, rows] = self.kept().map(u64::from);
        let pixels = width * rows;
        let tiles = width.div_ceil(layout::TILE.into()) * rows.div_ceil(layout::TILE.into());
        match resource {
            Resource::View => pixels.saturating_mul(size_of::<layout::Pixel>() as u64),
            Resource::Packed => pixels.saturating_mul(4 * u64::from(self.words_read())),
            Resource::Linear | Resource::KeptSamples => pixels.saturating_mul(16),
            Resource::Bounds => tiles * 4 * u64::from(layout::BOUND_WORDS),
            Resource::Counters => {
                let each = u64::from(self.soft_sources) + u64::from(self.cost_map);
                4 * (rows * layout::COUNTERS as u64 + pixels.saturating_mul(each))
            }
            Resource::Lists => {
                let results = if searched { 1 + layout::TILE_WORDS } else { 0 };
                layout::LISTS_HEADS + 4 * tiles * u64::from(layout::TILE_PIXELS + results)
            }
            Resource::Paths => layout::PATHS_HEADS + pixels.saturating_mul(size_of::<layout::Path>() as u64),
            Resource::Bounced => bounced_bytes(pixels),
            Resource::Proposed => proposed_bytes(pixels),
            Resource::Brought => pixels.saturating_mul(size_of::<layout::Brought>() as u64),
            Resource::LightParts => pixels.saturating_mul(size_of::<layout::LightParts>() as u64),
            Resource::TBuffer => pixels.saturating_mul(8),
            Resource::Drawing => self.drawing_bytes,
            Resource::Unfinished => 4,
            other => unreachable!("targets do not hold {other:?}"),
        }
    }

    /// Returns whether a kernel can bind the largest buffer, and buffers of secondary rays or paths are not far larger
    /// than others.
    pub(crate) fn can_be_bound(&self, gpu: &Gpu, used: &Used) -> bool {
        used.buffers().all(|(resource, _)| {
            let is_state = matches!(resource, Resource::Bounced | Resource::Proposed);
            let limit = if is_state { STATE_BYTES } else { u64::MAX };
            self.bytes(resource, used.searched) <= gpu.binding_limit().min(limit)
        })
    }

    /// # Errors
    /// [`Error::Limit`] naming the limit that a picture of this width, or this number of views, exceeds.
    fn check(&self, gpu: &Gpu, used: &Used) -> Result<(), Error> {
        let [width, rows] = self.kept();
        let what = format!("a picture {width} pixels wide");
        let bytes = || used.buffers().map(|(resource, _)| self.bytes(resource, used.searched));
        check_bytes(&what, bytes().max().unwrap_or(0), gpu.binding_limit(), "render a narrower picture")?;
        let all: u64 = bytes().sum();
        if all > MOST_BYTES {
            return Err(Error::Limit {
                what: crate::message::counted(self.views, "view", "views") + &format!(" {width} pixels wide"),
                needed: format!("{} MiB", all >> 20),
                limit: "memory for a frame",
                allowed: format!("{} MiB", MOST_BYTES >> 20),
                remedy: "render fewer or narrower views at a time",
            });
        }
        let limit = |what, needed, limit, allowed: u32, remedy| {
            Err(Error::Limit { what, needed, limit, allowed: allowed.to_string(), remedy })
        };
        let side = gpu.limits.max_texture_dimension_2d;
        if used.samples().next().is_some() && width.max(rows) > side {
            let (what, needed) = (format!("{what} by bracket"), format!("a texture of {width}x{rows}"));
            return limit(
                what,
                needed,
                "max_texture_dimension_2d",
                side,
                "render a narrower picture, or use another method",
            );
        }
        let workgroups = width.max(rows).div_ceil(WORKGROUP);
        let allowed = gpu.limits.max_compute_workgroups_per_dimension;
        if workgroups > allowed {
            let needed = format!("{workgroups} workgroups in a row or column");
            return limit(what, needed, "max_compute_workgroups_per_dimension", allowed, "render a narrower picture");
        }
        Ok(())
    }
}

/// The buffers and textures of a frame. A renderer keeps them for the next frame.
#[derive(Debug)]
pub(crate) struct Targets {
    pub(crate) shape: Shape,
    /// Uniforms of each view ([`Uniforms`]).
    pub(crate) uniforms: wgpu::Buffer,
    /// Arguments of indirect dispatches, for the executor.
    pub(crate) indirect: wgpu::Buffer,
    /// Textures with the samples of views, which `bracket` reads.
    samples: BTreeMap<Place, wgpu::TextureView>,
    /// Initial heads of lists, and of lists of paths.
    pub(crate) empty_lists: wgpu::Buffer,
    buffers: BTreeMap<Place, wgpu::Buffer>,
}

/// The buffers and textures that a plan's steps use.
#[derive(Clone, Debug, Default)]
pub(crate) struct Used {
    pub(crate) places: BTreeSet<Place>,
    /// Whether lists have results of tile searches.
    pub(crate) searched: bool,
    /// Whether a step reads the objects of primitives.
    pub(crate) objects: bool,
}

impl Used {
    fn buffers(&self) -> impl Iterator<Item = Place> + '_ {
        self.places.iter().copied().filter(|(resource, _)| *resource != Resource::KeptSamples)
    }

    fn samples(&self) -> impl Iterator<Item = Place> + '_ {
        self.places.iter().copied().filter(|(resource, _)| *resource == Resource::KeptSamples)
    }
}

/// Size of a buffer with the state of secondary rays or paths above which bands have fewer rows.
const STATE_BYTES: u64 = 256 << 20;

/// Returns the size of such a buffer above which the smallest bands do without it. They may have twice the usual size.
pub(crate) fn state_limit(gpu: &Gpu) -> u64 {
    gpu.binding_limit().min(2 * STATE_BYTES)
}

/// Returns the size of the buffer of secondary rays for a band of this number of pixels, in bytes.
pub(crate) fn bounced_bytes(pixels: u64) -> u64 {
    layout::BOUNCED_HEADS + pixels.saturating_mul(size_of::<layout::BouncedPixel>() as u64)
}

/// Returns the size of the buffer of light that is proposed to paths, for a band of this number of pixels, in bytes.
pub(crate) fn proposed_bytes(pixels: u64) -> u64 {
    pixels.saturating_mul(size_of::<layout::Proposed>() as u64)
}

/// Maximum size of a frame's buffers, and of its pictures on the host, in bytes. Drivers do not report free memory, and
/// a rig of many large views would take all of it.
pub(crate) const MOST_BYTES: u64 = 8 << 30;

/// Returns the error for data of whole pictures that need more than [`MOST_BYTES`].
pub(crate) fn too_large(what: String, needed: u64, remedy: &'static str) -> Error {
    Error::Limit {
        what,
        needed: format!("{} MiB", needed >> 20),
        limit: "memory for whole pictures",
        allowed: format!("{} MiB", MOST_BYTES >> 20),
        remedy,
    }
}

impl Targets {
    /// # Errors
    /// [`Error::Limit`] for a picture that the adapter cannot bind.
    pub(crate) fn new(gpu: &Gpu, shape: Shape, used: &Used) -> Result<Self, Error> {
        shape.check(gpu, used)?;
        let buffer = |place: Place| {
            let bytes = shape.bytes(place.0, used.searched);
            (place, gpu.storage_buffer(&format!("{:?} {}", place.0, place.1), bytes))
        };
        let plain = |label, size, usage| {
            let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
            gpu.device.create_buffer(&descriptor)
        };
        let empty_lists = plain(
            "empty_lists",
            layout::LISTS_HEADS + layout::PATHS_HEADS,
            wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
        );
        Ok(Self {
            shape,
            uniforms: plain(
                "uniforms",
                uniforms_bytes(shape.views, shape.parts),
                wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            ),
            indirect: indirect_buffer(gpu),
            samples: used.samples().map(|place| (place, samples_texture(gpu, shape.kept()))).collect(),
            empty_lists,
            buffers: used.buffers().map(buffer).collect(),
        })
    }

    /// Returns whether the buffers suit another frame.
    pub(crate) fn fit(&self, shape: Shape, used: &Used) -> bool {
        let is_large_enough = |place: Place| {
            self.buffers.get(&place).is_some_and(|buffer| buffer.size() >= shape.bytes(place.0, used.searched))
        };
        self.shape == shape
            && used.buffers().all(is_large_enough)
            && used.samples().all(|place| self.samples.contains_key(&place))
    }

    /// Returns the buffer of a view.
    pub(crate) fn get(&self, resource: Resource, view: usize) -> &wgpu::Buffer {
        &self.buffers[&(resource, view)]
    }

    /// Returns the texture with the samples of a traced view.
    pub(crate) fn samples_of(&self, view: usize) -> &wgpu::TextureView {
        &self.samples[&(Resource::KeptSamples, view)]
    }

    /// Returns a buffer, if the frame has it.
    pub(crate) fn find(&self, place: Place) -> Option<&wgpu::Buffer> {
        self.buffers.get(&place)
    }

    /// Adds the resources that steps bind for a view with these sources.
    pub(crate) fn add_resources(&self, view: usize, source: usize, second: usize, all: &mut Resources) {
        let held = |place| {
            let texture = || self.samples.get(&place).map(Held::from);
            self.buffers.get(&place).map(Held::from).or_else(texture)
        };
        for resource in Resource::ALL {
            if let Some(held) = resource.of(view, source).and_then(held) {
                all.set(*resource, held);
            }
        }
        if let Some(samples) = self.samples.get(&(Resource::KeptSamples, second)) {
            all.set(Resource::SecondSamples, samples);
        }
    }

    /// Returns the size of a plan's intermediate buffers and textures in bytes, without its output.
    pub(crate) fn intermediate_bytes(&self, used: &Used) -> u64 {
        let between = used.places.iter().filter(|(resource, _)| !resource.is_output());
        between.map(|(resource, _)| self.shape.bytes(*resource, used.searched)).sum()
    }
}

/// A browser frees buffers only at garbage collection, unless they are destroyed.
impl Drop for Targets {
    fn drop(&mut self) {
        let own = [&self.uniforms, &self.indirect, &self.empty_lists];
        self.buffers.values().chain(own).for_each(wgpu::Buffer::destroy);
        self.samples.values().for_each(|view| view.texture().destroy());
    }
}

fn samples_texture(gpu: &Gpu, [width, height]: [u32; 2]) -> wgpu::TextureView {
    // The texture is filled here. Otherwise wgpu clears it at its first use, and after a clear Mesa's software driver
    // takes every timestamp too early.
    gpu.filled_texture("source_samples", width, &vec![[0; 4]; width as usize * height as usize])
}

/// Resources that a renderer keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct Cache {
    /// Targets of recent frames. The most recently used one is last.
    pub(crate) targets: Vec<Arc<Targets>>,
    /// Number of targets that are kept besides the current one.
    others: usize,
    pub(crate) slots: Option<wgpu::Buffer>,
    /// Samples of the last frame that kept them.
    pub(crate) history: Option<History>,
    /// Staging buffers for reuse. None of them is mapped.
    pub(crate) staging: Vec<Staging>,
}

impl Cache {
    /// Sets the number of targets that are kept, for frames that take turns among as many shapes.
    pub(crate) fn keep(&mut self, targets: usize) {
        self.others = targets.saturating_sub(1);
        self.make_room(targets);
    }

    /// Returns targets that suit a frame.
    pub(crate) fn fitting(&mut self, shape: Shape, used: &Used) -> Option<Arc<Targets>> {
        let place = self.targets.iter().rposition(|targets| targets.fit(shape, used))?;
        let found = self.targets.remove(place);
        self.targets.push(found.clone());
        Some(found)
    }

    /// Returns the number of targets that are kept besides the current one.
    pub(crate) fn others(&self) -> usize {
        self.others
    }

    /// Drops the oldest targets until `left` remain, so that their memory is free first.
    pub(crate) fn make_room(&mut self, left: usize) {
        self.targets.drain(..self.targets.len().saturating_sub(left));
    }

    /// Takes the staging buffers of this size. Up to two others are kept for each target besides the current one.
    pub(crate) fn staging_of(&mut self, bytes: u64) -> Vec<Staging> {
        let (fitting, mut others): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.staging).into_iter().partition(|staging| staging.bytes() == bytes);
        others.drain(..others.len().saturating_sub(2 * self.others));
        self.staging = others;
        fitting
    }
}

impl Drop for Cache {
    fn drop(&mut self) {
        self.slots.iter().for_each(wgpu::Buffer::destroy); // see `Drop for Targets`
    }
}
