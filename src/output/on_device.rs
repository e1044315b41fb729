//! Makes one picture of both eyes on the device, from pictures that are there.

use bytemuck::{Pod, Zeroable};

use super::{Anaglyph, Combination, Packing};
use crate::{
    Error, Renderer,
    frame::executor::{Executor, Resources, Workgroups},
    gpu::MAX_WORKGROUPS,
    kernel::{Kernel, Resource, Role, kernel, layout::WORKGROUP, variant::Variant},
    srgb::linear_of,
};

pub(crate) const COMBINE: Kernel = kernel!("show", "combine", Role::Pixels);

/// `Combining` of shaders/show/combine.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Combining {
    pub(crate) decoded: [f32; 256],
    pub(crate) of_left: [[f32; 4]; 3],
    pub(crate) of_right: [[f32; 4]; 3],
    pub(crate) size: [u32; 2],
    pub(crate) arrangement: u32,
    pub(crate) _pad: u32,
}

impl Combining {
    fn new(how: Combination, size: [u32; 2]) -> Self {
        // The matrices of anaglyphs are row-major, those of the kernel column-major.
        let columns =
            |rows: [[f32; 3]; 3]| [0, 1, 2].map(|column| [rows[0][column], rows[1][column], rows[2][column], 0.0]);
        let kind = if let Combination::Anaglyph(kind) = how { kind } else { Anaglyph::Colour };
        let (of_left, of_right) = kind.matrices();
        Self {
            decoded: std::array::from_fn(|byte| linear_of(byte as u8)),
            of_left: columns(of_left),
            of_right: columns(of_right),
            size,
            arrangement: match how {
                Combination::Anaglyph(_) => 0,
                Combination::Packed(Packing::SideBySide) => 1,
                Combination::Packed(Packing::CrossEyed) => 2,
                Combination::Packed(Packing::HalfSideBySide) => 3,
                Combination::Packed(Packing::TopBottom) => 4,
                Combination::Packed(Packing::HalfTopBottom) => 5,
                Combination::Packed(Packing::RowInterlaced) => 6,
                Combination::Packed(Packing::ColumnInterlaced) => 7,
                Combination::Packed(Packing::Checkerboard) => 8,
            },
            _pad: 0,
        }
    }
}

impl Renderer {
    /// Encodes one picture of both eyes' pictures, such as [`EncodedView::color`](crate::EncodedView::color) of a frame
    /// in the same encoder or an earlier one. Both are sRGB-encoded, `Rgba8Unorm`, with the usage `TEXTURE_BINDING`.
    /// The result has the same format, alpha 1, and can also be copied. Its bytes are those of
    /// [`Combination::picture`]; where light is mixed, a byte may differ by 1, since devices approximate the sRGB
    /// curve.
    ///
    /// # Errors
    /// [`Error::Sizes`] if the pictures differ in size; [`Error::Limit`] if the result is larger than the adapter's
    /// textures; [`Error::OutOfMemory`], [`Error::DeviceLost`], and [`Error::Gpu`] for textures that can't be sampled.
    pub async fn encode_combined(
        &self,
        how: Combination,
        [left, right]: [&wgpu::Texture; 2],
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<wgpu::Texture, Error> {
        let [size, other] = [left, right].map(|eye| [eye.width(), eye.height()]);
        if size != other {
            let sizes = format!("{}x{} and {}x{}", size[0], size[1], other[0], other[1]);
            return Err(Error::Sizes { sizes, reason: "both pictures must have the same size" });
        }
        let [width, height] = how.size(size);
        let side = self.gpu.limits.max_texture_dimension_2d.min(MAX_WORKGROUPS * WORKGROUP);
        if width.max(height) > side {
            return Err(Error::Limit {
                what: format!("a {width}x{height} picture of both eyes in a texture"),
                needed: format!("a side of {}", width.max(height)),
                limit: "max_texture_dimension_2d",
                allowed: side.to_string(),
                remedy: "encode smaller views",
            });
        }
        let encode = || {
            use wgpu::{TextureFormat::Rgba8Unorm, TextureUsages as Usages};

            let usage = Usages::STORAGE_BINDING | Usages::TEXTURE_BINDING | Usages::COPY_SRC;
            let picture = self.gpu.texture("both eyes", [width, height], Rgba8Unorm, usage, &[]);
            let combining = self.gpu.uniform_buffer("combining", bytemuck::bytes_of(&Combining::new(how, size)));
            let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
            let resources = Resources::default()
                .with(Resource::Combining, &combining)
                .with(Resource::LeftPicture, &view(left))
                .with(Resource::RightPicture, &view(right))
                .with(Resource::Picture, &view(&picture));
            let workgroups = Workgroups::Number([width.div_ceil(WORKGROUP), height.div_ceil(WORKGROUP), 1]);
            let mut executor = Executor::new(&self.gpu, &self.kernels, None, None);
            executor.run(encoder, COMBINE.name, (&COMBINE, Variant::PIXELS), &resources, workgroups);
            Ok(picture)
        };
        self.gpu.checked(encode).await
    }
}
