//! A scene's acceleration structure on the device, for ray queries. wgpu calls them experimental.

use super::Gpu;
use crate::Error;

/// Type of the binding of an acceleration structure.
pub(crate) const ACCELERATION: wgpu::BindingType = wgpu::BindingType::AccelerationStructure { vertex_return: false };

/// Features that ray queries need.
pub(super) const RAY_QUERIES: wgpu::Features = wgpu::Features::EXPERIMENTAL_RAY_QUERY;

/// Shapes that the device searches: triangles by their corners, or boxes by their low and high corners.
#[derive(Debug)]
pub(crate) enum Outlines {
    Triangles(Vec<[[f32; 3]; 3]>),
    Boxes(Vec<[[f32; 3]; 2]>),
}

impl Outlines {
    pub(crate) fn count(&self) -> usize {
        match self {
            Self::Triangles(all) => all.len(),
            Self::Boxes(all) => all.len(),
        }
    }

    fn bytes(&self) -> &[u8] {
        match self {
            Self::Triangles(all) => bytemuck::cast_slice(all),
            Self::Boxes(all) => bytemuck::cast_slice(all),
        }
    }
}

/// An acceleration structure with one instance. It keeps the structure of its primitives alive.
#[derive(Clone, Debug)]
pub(crate) struct Acceleration(wgpu::Tlas);

impl Acceleration {
    pub(crate) fn binding(&self) -> wgpu::BindingResource<'_> {
        wgpu::BindingResource::AccelerationStructure(&self.0)
    }
}

/// Size of a corner in bytes.
const CORNER_BYTES: u64 = size_of::<[f32; 3]>() as u64;

impl Gpu {
    /// Returns whether ray queries can search these outlines.
    pub(crate) fn can_accelerate(&self, outlines: &Outlines) -> bool {
        // wgpu compares the number of vertices with the limit of primitives.
        let corners = if let Outlines::Triangles(_) = outlines { 3 } else { 1 };
        let most = u64::from(self.limits.max_blas_primitive_count) / corners;
        let fits = outlines.bytes().len() as u64 <= self.limits.max_buffer_size;
        self.has_ray_queries() && outlines.count() as u64 <= most && fits
    }

    /// Builds an acceleration structure. There must be at least one primitive, and [`Gpu::can_accelerate`] must hold.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] and [`Error::DeviceLost`].
    pub(crate) async fn accelerate(&self, outlines: &Outlines) -> Result<Acceleration, Error> {
        let build = || Ok(self.build_acceleration(outlines));
        self.checked(build).await
    }

    fn build_acceleration(&self, outlines: &Outlines) -> Acceleration {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("outlines"),
            size: outlines.bytes().len() as u64,
            usage: wgpu::BufferUsages::BLAS_INPUT | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, outlines.bytes());
        let flags = wgpu::AccelerationStructureFlags::PREFER_FAST_TRACE;
        let update_mode = wgpu::AccelerationStructureUpdateMode::Build;
        let make = |sizes| {
            let descriptor = wgpu::CreateBlasDescriptor { label: Some("primitives"), flags, update_mode };
            self.device.create_blas(&descriptor, sizes)
        };
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut scene = self.device.create_tlas(&wgpu::CreateTlasDescriptor {
            label: Some("scene"),
            max_instances: 1,
            flags,
            update_mode,
        });
        let mut place = |blas: &wgpu::Blas| {
            let unmoved = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
            scene[0] = Some(wgpu::TlasInstance::new(blas, unmoved, 0, 255));
        };
        let count = outlines.count() as u32;
        let geometry = wgpu::AccelerationStructureGeometryFlags::empty();
        match outlines {
            Outlines::Triangles(_) => {
                let size = wgpu::BlasTriangleGeometrySizeDescriptor {
                    vertex_format: wgpu::VertexFormat::Float32x3,
                    vertex_count: 3 * count,
                    index_format: None,
                    index_count: None,
                    flags: geometry,
                };
                let blas = make(wgpu::BlasGeometrySizeDescriptors::Triangles { descriptors: vec![size.clone()] });
                place(&blas);
                let triangles = wgpu::BlasTriangleGeometry {
                    size: &size,
                    vertex_buffer: &buffer,
                    first_vertex: 0,
                    vertex_stride: CORNER_BYTES,
                    index_buffer: None,
                    first_index: None,
                    transform_buffer: None,
                    transform_buffer_offset: None,
                };
                let geometry = wgpu::BlasGeometries::TriangleGeometries(vec![triangles]);
                encoder.build_acceleration_structures([&wgpu::BlasBuildEntry { blas: &blas, geometry }], [&scene]);
            }
            Outlines::Boxes(_) => {
                let size = wgpu::BlasAABBGeometrySizeDescriptor { primitive_count: count, flags: geometry };
                let blas = make(wgpu::BlasGeometrySizeDescriptors::AABBs { descriptors: vec![size.clone()] });
                place(&blas);
                let boxes = wgpu::BlasAabbGeometry {
                    size: &size,
                    stride: 2 * CORNER_BYTES,
                    aabb_buffer: &buffer,
                    primitive_offset: 0,
                };
                let geometry = wgpu::BlasGeometries::AabbGeometries(vec![boxes]);
                encoder.build_acceleration_structures([&wgpu::BlasBuildEntry { blas: &blas, geometry }], [&scene]);
            }
        }
        self.submit([encoder.finish()]);
        Acceleration(scene)
    }
}
