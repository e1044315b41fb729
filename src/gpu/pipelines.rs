//! Compute pipelines, built at their first use, and bind groups.

use std::{
    collections::HashMap,
    hash::{DefaultHasher, Hash, Hasher},
    ops::Deref,
    sync::{Arc, Mutex, OnceLock, Weak},
};

use super::{Gpu, lock};

/// The description of a pipeline.
pub(crate) struct Program {
    pub(crate) label: &'static str,
    /// WGSL with one entry point.
    pub(crate) text: String,
    /// Types of the resources in bind group 0, from binding 0 on.
    pub(crate) bindings: Vec<wgpu::BindingType>,
    /// Values of `override` constants.
    pub(crate) constants: Vec<(&'static str, f64)>,
}

/// A compute pipeline and the layout of its bind group.
#[derive(Debug)]
pub(crate) struct Pipeline {
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) layout: wgpu::BindGroupLayout,
}

/// A pipeline that several users of a device may hold.
#[derive(Clone, Debug)]
pub(crate) struct Built(Arc<OnceLock<Pipeline>>);

impl Deref for Built {
    type Target = Pipeline;

    fn deref(&self) -> &Pipeline {
        self.0.get().expect("built before it is handed out")
    }
}

/// Pipelines of a device that are in use, by hashes of their descriptions. Different variants often have the same text,
/// and so do kernels of several renderers.
#[derive(Debug, Default)]
pub(crate) struct Held(Mutex<HashMap<[u64; 2], Weak<OnceLock<Pipeline>>>>);

impl Held {
    /// Returns a pipeline. While one thread builds it, other threads wait for it, but not for other pipelines.
    fn get(&self, gpu: &Gpu, program: Program) -> Built {
        let slot = {
            let mut held = lock(&self.0);
            let key = [0, 1].map(|seed| program.hash(seed));
            held.get(&key).and_then(Weak::upgrade).unwrap_or_else(|| {
                held.retain(|_, pipeline| pipeline.strong_count() > 0);
                let slot = Arc::default();
                held.insert(key, Arc::downgrade(&slot));
                slot
            })
        };
        slot.get_or_init(|| build(gpu, program));
        Built(slot)
    }
}

impl Program {
    /// Hashes the description, except the bindings, which follow from the text.
    fn hash(&self, seed: u8) -> u64 {
        let mut hasher = DefaultHasher::new();
        (seed, &self.text).hash(&mut hasher);
        for (name, value) in &self.constants {
            (name, value.to_bits()).hash(&mut hasher);
        }
        hasher.finish()
    }
}

impl Gpu {
    /// Returns a pipeline, which is built unless one of the same description is in use.
    pub(crate) fn pipeline(&self, program: Program) -> Built {
        self.pipelines.get(self, program)
    }
}

fn build(gpu: &Gpu, program: Program) -> Pipeline {
    let device = &gpu.device;
    let label = Some(program.label);
    let source = wgpu::ShaderSource::Wgsl(program.text.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
    let entries: Vec<_> = program.bindings.iter().zip(0..).map(|(ty, binding)| entry(binding, *ty)).collect();
    let bindings = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&bindings)],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label,
        layout: Some(&layout),
        module: &module,
        entry_point: None, // the module has only one
        compilation_options: wgpu::PipelineCompilationOptions { constants: &program.constants, ..Default::default() },
        cache: None,
    });
    Pipeline { pipeline, layout: bindings }
}

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None }
}

pub(crate) fn uniform_type() -> wgpu::BindingType {
    buffer_type(wgpu::BufferBindingType::Uniform)
}

pub(crate) fn storage_type(read_only: bool) -> wgpu::BindingType {
    buffer_type(wgpu::BufferBindingType::Storage { read_only })
}

fn buffer_type(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

/// The format of textures of texels ([`super::Texels`]).
pub(crate) const TEXELS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

pub(crate) fn texture_type(format: wgpu::TextureFormat, access: wgpu::StorageTextureAccess) -> wgpu::BindingType {
    let view_dimension = wgpu::TextureViewDimension::D2;
    wgpu::BindingType::StorageTexture { access, format, view_dimension }
}

/// Returns the type of a texture of texels that is read without filtering.
pub(crate) fn sampled_type() -> wgpu::BindingType {
    sampled(wgpu::TextureViewDimension::D2, wgpu::TextureSampleType::Uint)
}

/// Returns the type of a picture that is read without filtering.
pub(crate) fn sampled_float_type() -> wgpu::BindingType {
    sampled(wgpu::TextureViewDimension::D2, wgpu::TextureSampleType::Float { filterable: false })
}

/// Returns the type of an array of textures that are read without filtering.
pub(crate) fn sampled_layers_type() -> wgpu::BindingType {
    sampled(wgpu::TextureViewDimension::D2Array, wgpu::TextureSampleType::Uint)
}

fn sampled(view_dimension: wgpu::TextureViewDimension, sample_type: wgpu::TextureSampleType) -> wgpu::BindingType {
    wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

/// Returns a bind group of resources in the order of their bindings.
pub(crate) fn bind_group<'a>(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: impl Iterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
    let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}
