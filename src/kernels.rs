//! The description of kernels: what each touches, its bindings and its WGSL file.

use crate::{
    cast,
    frame::targets::Target,
    gpu::{
        Built, Gpu, Pipelines, Program, TEXELS, entry, layout_of, sampled_layers_type, sampled_type, storage_type,
        texture_type, uniform_type,
    },
    layout,
    shadow_buffer::Reading,
    steps::resolve::TAKE_OVER,
    traversal::Fetch,
    variant::Variant,
    wgsl::Part,
};

/// How a kernel uses one of its storage buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    Read,
    Write,
}

/// What a kernel touches besides its own buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Touches {
    Pixels,
    Geometry,
    /// Geometry and the shading table.
    Shading,
    /// Geometry and a table of rays.
    RayList,
    /// A table of the primitives' objects.
    Objects,
}

impl Touches {
    pub(crate) fn geometry(self) -> bool {
        !matches!(self, Self::Pixels | Self::Objects)
    }

    pub(crate) fn table(self) -> bool {
        matches!(self, Self::Shading | Self::RayList | Self::Objects)
    }
}

/// A compute kernel. Its text has one entry point. Bind group 1 has the frame at binding 0, then `storage`.
pub(crate) struct Kernel {
    /// Unique name, which identifies its pipelines.
    pub(crate) name: &'static str,
    pub(crate) touches: Touches,
    pub(crate) storage: &'static [(Target, Access)],
    /// Its file. The definitions that it uses of `shaders/shared/` are added (`src/wgsl.rs`).
    pub(crate) main: Part,
}

use Access::{Read, Write};

/// Binding of shadow-buffers in group 1.
pub(crate) const SHADOW_BINDING: u32 = 8;
/// Binding of the mask of wanted pixels.
pub(crate) const MASK_BINDING: u32 = 9;
/// Binding of a second source's samples.
pub(crate) const SECOND_SAMPLES_BINDING: u32 = 10;
/// Binding of the texture that shows a view.
pub(crate) const PICTURE_BINDING: u32 = 11;
/// Binding of the source's linear colour.
const SOURCE_LINEAR_BINDING: u32 = 12;
/// Binding of the view's own linear colour.
const LINEAR_BINDING: u32 = 13;
/// Binding of the state of work in steps (`src/lanes.rs`).
pub(crate) const STEPS_BINDING: u32 = 14;
/// Binding of a source's samples.
pub(crate) const SAMPLES_BINDING: u32 = 15;

/// Returns the limits that kernels need of a device; all other limits are taken from `others`.
pub(crate) fn limits_over(others: wgpu::Limits) -> wgpu::Limits {
    wgpu::Limits {
        max_bind_groups: 3,
        max_bindings_per_bind_group: SAMPLES_BINDING + 1,
        max_storage_buffers_per_shader_stage: 6,
        max_storage_textures_per_shader_stage: 3,
        max_uniform_buffers_per_shader_stage: 2,
        max_buffers_and_acceleration_structures_per_shader_stage: 8,
        max_compute_invocations_per_workgroup: layout::LIST_WORKGROUP,
        max_compute_workgroup_size_x: layout::LIST_WORKGROUP,
        max_compute_workgroup_size_y: layout::WORKGROUP,
        max_compute_workgroup_size_z: 1,
        max_compute_workgroups_per_dimension: cast::BATCH as u32 / layout::LIST_WORKGROUP,
        ..others
    }
}

impl std::fmt::Debug for Kernel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl Kernel {
    /// Returns the side of a thread's block, in pixels.
    pub(crate) fn block(&self, with: &Variant) -> u32 {
        if !self.touches.geometry() { 1 } else { with.of_kernel(self).traversal.rays.block() }
    }

    /// Returns the buffers of linear colour that it uses, if requested, with their bindings in group 1.
    pub(crate) fn linear(&self, with: &Variant) -> &'static [(Target, u32)] {
        match self.touches {
            _ if !with.linear => &[],
            Touches::Shading => &[(Target::Linear, LINEAR_BINDING)],
            Touches::Pixels if self.name == TAKE_OVER.name => {
                &[(Target::SourceLinear, SOURCE_LINEAR_BINDING), (Target::Linear, LINEAR_BINDING)]
            }
            _ => &[],
        }
    }

    /// Returns how it uses the texture of a source's samples, at `SAMPLES_BINDING` of group 1.
    pub(crate) fn samples(&self, with: &Variant) -> Option<Access> {
        match self.name {
            "trace_left" | "shade_hits" if with.samples => Some(Write),
            "shade_tiles" | "shade_listed" | "trace_soft_asked" | "mark_busy" => Some(Read),
            _ => None,
        }
    }

    /// Returns whether it reads a second source's samples, at `SECOND_SAMPLES_BINDING` of group 1.
    pub(crate) fn asks_second(&self, with: &Variant) -> bool {
        with.second && self.touches == Touches::Shading && self.samples(with) == Some(Read)
    }

    /// Returns whether it depends on the mask of wanted pixels. (Other kernels depend on lists.)
    pub(crate) fn minds_mask(&self) -> bool {
        let names = ["trace_left", "trace_hits", "trace_soft", "shade_hits", "list_mirrors", "bound_tiles"];
        let of_tiles = ["search_tiles", "resolve_tiles", "shade_sky", "shade_tiles"];
        names.contains(&self.name) || of_tiles.contains(&self.name)
    }

    /// Returns how it reads shadow-buffers, at `SHADOW_BINDING` of group 1. Kernels that trace shadow rays in one
    /// dispatch do.
    pub(crate) fn shadow_buffer(&self, with: &Variant) -> Option<Reading> {
        let names = ["trace_left", "shade_hits", "shade_listed", "shade_traced", "trace_mirrored"];
        with.shadow_buffer.filter(|_| names.contains(&self.name) && with.casts_from_lights())
    }

    /// Returns whether it reads the mask of the current view, at `MASK_BINDING` of group 1. (`bound_tiles` sees it by
    /// the source's depths.)
    pub(crate) fn reads_mask(&self, with: &Variant) -> bool {
        with.masked && self.minds_mask() && self.touches.geometry()
    }

    /// Returns the format of the texture that it writes, at `PICTURE_BINDING` of group 1.
    pub(crate) fn picture(&self) -> Option<wgpu::TextureFormat> {
        match self.name {
            "show_color" => Some(wgpu::TextureFormat::Rgba8Unorm),
            "show_depth" => Some(wgpu::TextureFormat::R32Float),
            _ => None,
        }
    }

    /// Returns whether its threads continue in the next dispatch (`src/lanes.rs`).
    pub(crate) fn in_steps(&self) -> bool {
        matches!(self.name, "trace_in_steps" | "closest_hits_in_steps" | "any_hits_in_steps")
    }
}

/// Layouts of a scene's two bind groups, for one way to read it.
#[derive(Debug)]
pub(crate) struct SceneLayouts {
    /// The BVH's uniform, and its nodes and primitives.
    pub(crate) geometry: wgpu::BindGroupLayout,
    /// The table that a kernel looks up by index.
    pub(crate) table: wgpu::BindGroupLayout,
}

impl SceneLayouts {
    fn new(gpu: &Gpu, texels: wgpu::BindingType) -> Self {
        Self {
            geometry: layout_of(gpu, "geometry", &[uniform_type(), texels]),
            table: layout_of(gpu, "table", &[texels]),
        }
    }
}

/// The kernels built so far, and their shared layouts.
#[derive(Debug)]
pub(crate) struct Kernels {
    textures: SceneLayouts,
    buffers: SceneLayouts,
    built: Pipelines<(&'static str, Variant)>,
}

impl Kernels {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self {
            textures: SceneLayouts::new(gpu, texture_type(TEXELS, wgpu::StorageTextureAccess::ReadOnly)),
            buffers: SceneLayouts::new(gpu, storage_type(true)),
            built: Pipelines::default(),
        }
    }

    /// Returns the layouts of a scene that is read this way.
    pub(crate) fn layouts(&self, fetch: Fetch) -> &SceneLayouts {
        match fetch {
            Fetch::Texture => &self.textures,
            Fetch::Buffer => &self.buffers,
        }
    }

    /// Returns the pipeline of a kernel, built at its first use.
    pub(crate) fn get(&self, gpu: &Gpu, kernel: &Kernel, with: Variant) -> Built {
        let with = with.of_kernel(kernel);
        self.built.get(gpu, (kernel.name, with), || self.program(kernel, &with))
    }

    fn program(&self, kernel: &Kernel, with: &Variant) -> Program<'_> {
        let mut own = vec![entry(0, uniform_type())];
        for (index, (_, access)) in kernel.storage.iter().enumerate() {
            own.push(entry(index as u32 + 1, storage_type(*access == Read)));
        }
        for (target, binding) in kernel.linear(with) {
            own.push(entry(*binding, storage_type(*target == Target::SourceLinear)));
        }
        if kernel.in_steps() {
            own.push(entry(STEPS_BINDING, storage_type(false)));
        }
        let write = wgpu::StorageTextureAccess::WriteOnly;
        own.extend(kernel.picture().map(|format| entry(PICTURE_BINDING, texture_type(format, write))));
        own.extend(kernel.samples(with).map(|access| {
            let access = match access {
                Read => wgpu::StorageTextureAccess::ReadOnly,
                Write => wgpu::StorageTextureAccess::WriteOnly,
            };
            entry(SAMPLES_BINDING, texture_type(TEXELS, access))
        }));
        // Read as sampled textures, of which more are allowed.
        own.extend(kernel.asks_second(with).then(|| entry(SECOND_SAMPLES_BINDING, sampled_type())));
        own.extend(kernel.shadow_buffer(with).map(|_| entry(SHADOW_BINDING, sampled_layers_type())));
        own.extend(kernel.reads_mask(with).then(|| entry(MASK_BINDING, sampled_type())));
        let scene = self.layouts(with.traversal.fetch);
        let text = kernel.text(with);
        let counting = [("COUNT", with.count), ("COST_MAP", with.cost_map)];
        let counting = counting.into_iter().filter(|(name, _)| text.contains(&format!("override {name}:")));
        let constants = counting.map(|(name, on)| (name, f64::from(u8::from(on)))).collect();
        Program {
            label: kernel.name,
            text,
            own,
            shared: [
                kernel.touches.geometry().then_some(&scene.geometry),
                kernel.touches.table().then_some(&scene.table),
            ],
            constants,
        }
    }
}

#[cfg(test)]
mod tests;
