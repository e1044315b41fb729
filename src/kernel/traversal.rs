//! Variants of traversal for different adapters. All use one algorithm (shaders/shared/bvh.wgsl) and find the same
//! hits, bit for bit.

use std::fmt;

use crate::Gpu;
pub use crate::gpu::Fetch;

/// How the boxes of the BVH are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Boxes {
    /// Corners in f32: 64 bytes per pair of nodes.
    F32,
    /// 16-bit corners on a grid over the whole scene, rounded outwards: 32 bytes per pair of nodes. Detail smaller than
    /// a 65,536th of the scene is found too, but slowly.
    Grid16,
}

/// The number of rays that a thread traces with one stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum RaysPerLane {
    /// One ray.
    One,
    /// Four rays: a block of 2x2 pixels, or four neighbours in a list.
    Four,
}

impl RaysPerLane {
    /// Returns the side of the block of pixels that a thread computes, in pixels.
    pub(crate) fn block(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Four => 2,
        }
    }
}

/// Where a traversal keeps the links that it has yet to follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Stack {
    /// In an array of each thread, as deep as the tree.
    Private,
    /// In 4 KiB of workgroup memory, for traversals with one ray per lane that count nothing and run in one dispatch.
    /// Links beyond 16 are found again from the tree (`shaders/shared/stack.wgsl`).
    Workgroup,
}

/// What follows rays through the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Tracing {
    /// The kernels' own traversal of the BVH.
    Kernels,
    /// The device's ray queries ([`Gpu::has_ray_queries`](crate::Gpu::has_ray_queries)), with one ray per lane. Kernels
    /// that count or run in several dispatches, and scenes that do not fit the device's acceleration structures, use
    /// the kernels' traversal.
    RayQueries,
}

/// A variant of the traversal. It affects the time only, not the picture, but for [`Tracing::RayQueries`]: a ray may
/// miss a triangle that it sees edge-on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Traversal {
    /// How the scene is read.
    pub fetch: Fetch,
    /// How boxes are stored.
    pub boxes: Boxes,
    /// Number of rays that a thread traces.
    pub rays: RaysPerLane,
    /// Where stacks are.
    pub stack: Stack,
    /// What follows rays.
    pub tracing: Tracing,
}

impl Traversal {
    /// Returns the fastest variant for an adapter: on CPU adapters by measurement (docs/TRAVERSAL.md), on GPUs by
    /// convention. Ray queries are used if the device has them ([`Gpu::has_ray_queries`]).
    pub fn of(gpu: &Gpu) -> Self {
        let usual = match gpu.adapter_info().device_type {
            wgpu::DeviceType::Cpu => Self::CPU,
            _ => Self::GPU,
        };
        match gpu.has_ray_queries() {
            true => usual.rays(RaysPerLane::One).tracing(Tracing::RayQueries),
            false => usual,
        }
    }

    const CPU: Self = Self {
        fetch: Fetch::Texture,
        boxes: Boxes::F32,
        rays: RaysPerLane::Four,
        stack: Stack::Private,
        tracing: Tracing::Kernels,
    };
    /// Variant for GPUs. Arrays of threads are in memory there, or take many registers (scripts/shapes/shapes.tsv).
    pub(crate) const GPU: Self = Self {
        fetch: Fetch::Buffer,
        boxes: Boxes::Grid16,
        rays: RaysPerLane::One,
        stack: Stack::Workgroup,
        tracing: Tracing::Kernels,
    };

    /// Sets how the scene is read.
    pub fn fetch(mut self, fetch: Fetch) -> Self {
        self.fetch = fetch;
        self
    }

    /// Sets how boxes are stored.
    pub fn boxes(mut self, boxes: Boxes) -> Self {
        self.boxes = boxes;
        self
    }

    /// Sets the number of rays that a thread traces.
    pub fn rays(mut self, rays: RaysPerLane) -> Self {
        self.rays = rays;
        self
    }

    /// Sets where stacks are.
    pub fn stack(mut self, stack: Stack) -> Self {
        self.stack = stack;
        self
    }

    /// Sets what follows rays.
    pub fn tracing(mut self, tracing: Tracing) -> Self {
        self.tracing = tracing;
        self
    }

    /// Returns whether kernels that trace in one dispatch use ray queries.
    pub(crate) fn queries_rays(self) -> bool {
        (self.tracing, self.rays) == (Tracing::RayQueries, RaysPerLane::One)
    }

    /// Returns whether kernels read parents of nodes, which only buffers have.
    pub(crate) fn climbs(self) -> bool {
        (self.fetch, self.rays, self.stack) == (Fetch::Buffer, RaysPerLane::One, Stack::Workgroup)
    }

    /// All variants of the kernels' own traversal.
    pub const ALL: &'static [Self] = {
        const fn of(fetch: Fetch, boxes: Boxes, rays: RaysPerLane, stack: Stack) -> Traversal {
            Traversal { fetch, boxes, rays, stack, tracing: Tracing::Kernels }
        }
        use {Boxes::*, Fetch::*, RaysPerLane::*, Stack::*};
        &[
            of(Texture, F32, Four, Private),
            of(Texture, F32, One, Private),
            of(Texture, Grid16, Four, Private),
            of(Texture, Grid16, One, Private),
            of(Buffer, Grid16, Four, Private),
            of(Buffer, Grid16, One, Workgroup),
            of(Buffer, F32, Four, Private),
            of(Buffer, F32, One, Workgroup),
            of(Buffer, Grid16, One, Private),
            of(Buffer, F32, One, Private),
        ]
    };
}

impl fmt::Display for Traversal {
    /// Formats a variant for tables: `textures, f32, 4 rays`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fetch = match self.fetch {
            Fetch::Texture => "textures",
            Fetch::Buffer => "buffers",
        };
        let boxes = match self.boxes {
            Boxes::Grid16 => "16-bit",
            Boxes::F32 => "f32",
        };
        let rays = match self.rays {
            RaysPerLane::One => "1 ray",
            RaysPerLane::Four => "4 rays",
        };
        let stack = match self.stack {
            Stack::Private => "",
            Stack::Workgroup => ", stacks in workgroups",
        };
        let tracing = match self.tracing {
            Tracing::Kernels => "",
            Tracing::RayQueries => ", ray queries",
        };
        f.pad(&format!("{fetch}, {boxes}, {rays}{stack}{tracing}"))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_variant_prints_as_another_and_is_made_by_its_setters() {
        let queries = Traversal::ALL.iter().map(|way| way.tracing(Tracing::RayQueries));
        let all: Vec<_> = Traversal::ALL.iter().copied().chain(queries).collect();
        let names: BTreeSet<String> = all.iter().map(Traversal::to_string).collect();
        assert_eq!(names.len(), 2 * Traversal::ALL.len(), "{names:?}");
        assert_eq!(Traversal::ALL[0].to_string(), "textures, f32, 4 rays");
        for with in all {
            let made = Traversal::ALL[0].fetch(with.fetch).boxes(with.boxes).rays(with.rays).stack(with.stack);
            assert_eq!(made.tracing(with.tracing), with);
        }
    }
}
