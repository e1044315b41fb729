//! How rays go through a scene on an adapter: one algorithm (shaders/shared/bvh.wgsl) in variants that find the same hits,
//! bit for bit.

use crate::Gpu;

/// How kernels read a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fetch {
    /// From textures: the fast way on CPU adapters.
    Texture,
    /// From storage buffers.
    Buffer,
}

/// How the boxes of the BVH are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Boxes {
    /// As f32 corners: 64 bytes a pair.
    F32,
    /// As 16-bit corners on a grid over the whole scene, rounded outwards: 32 bytes a pair. Detail smaller than a
    /// 65,536th of the scene is found, but slowly.
    Grid16,
}

/// How many rays a thread traces on one stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RaysPerLane {
    /// One.
    One,
    /// Four: a block of 2x2 pixels, or four neighbours of a list.
    Four,
}

impl RaysPerLane {
    /// Pixels of a thread's block in x and in y.
    pub(crate) fn block(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Four => 2,
        }
    }
}

/// A variant of the traversal. The picture does not depend on it, only the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Traversal {
    /// How the scene is read.
    pub fetch: Fetch,
    /// How boxes are stored.
    pub boxes: Boxes,
    /// How many rays a thread traces.
    pub rays: RaysPerLane,
}

impl Traversal {
    /// The fastest variant on an adapter: on CPU adapters by measurement (docs/TRAVERSAL.md), on GPUs by convention.
    pub fn of(gpu: &Gpu) -> Self {
        match gpu.adapter_info().device_type {
            wgpu::DeviceType::Cpu => Self { fetch: Fetch::Texture, boxes: Boxes::F32, rays: RaysPerLane::Four },
            _ => Self { fetch: Fetch::Buffer, boxes: Boxes::Grid16, rays: RaysPerLane::One },
        }
    }

    /// Every variant.
    pub const ALL: &'static [Self] = {
        const fn of(fetch: Fetch, boxes: Boxes, rays: RaysPerLane) -> Traversal {
            Traversal { fetch, boxes, rays }
        }
        use {Boxes::*, Fetch::*, RaysPerLane::*};
        &[
            of(Texture, F32, Four),
            of(Texture, F32, One),
            of(Texture, Grid16, Four),
            of(Texture, Grid16, One),
            of(Buffer, Grid16, Four),
            of(Buffer, Grid16, One),
            of(Buffer, F32, Four),
            of(Buffer, F32, One),
        ]
    };
}
