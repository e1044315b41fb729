//! Makes one picture of both eyes on the device, from views that are there.

use bytemuck::{Pod, Zeroable};

use super::{Anaglyph, Combination, Packing};
use crate::{
    EncodedView, Error, Renderer,
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
    /// Encodes one picture of two views of an encoded frame ([`FrameBuilder::encode`](crate::FrameBuilder::encode)),
    /// into the same encoder or a later one. The result is sRGB-encoded, alpha 1, `Rgba8Unorm`, and can be sampled and
    /// copied. Its bytes are those of [`Combination::picture`]; where light is mixed, a byte may differ by 1, since
    /// devices approximate the sRGB curve.
    ///
    /// # Errors
    /// [`Error::Sizes`] if the views differ in size; [`Error::Limit`] if the picture is larger than the adapter's
    /// textures; [`Error::OutOfMemory`] and [`Error::DeviceLost`].
    pub async fn encode_combined(
        &self,
        how: Combination,
        [left, right]: [&EncodedView; 2],
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<wgpu::Texture, Error> {
        let [size, other] = [left, right].map(|view| [view.color.width(), view.color.height()]);
        if size != other {
            let sizes = format!("{}x{} and {}x{}", size[0], size[1], other[0], other[1]);
            return Err(Error::Sizes { sizes, reason: "both views must have the same size" });
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
            let srgb = [wgpu::TextureFormat::Rgba8UnormSrgb];
            let picture = self.gpu.texture("both eyes", [width, height], Rgba8Unorm, usage, &srgb);
            let combining = self.gpu.uniform_buffer("combining", bytemuck::bytes_of(&Combining::new(how, size)));
            let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
            let resources = Resources::default()
                .with(Resource::Combining, &combining)
                .with(Resource::LeftPicture, &view(&left.color))
                .with(Resource::RightPicture, &view(&right.color))
                .with(Resource::Picture, &view(&picture));
            let workgroups = Workgroups::Number([width.div_ceil(WORKGROUP), height.div_ceil(WORKGROUP), 1]);
            let mut executor = Executor::new(&self.gpu, &self.kernels, None, None);
            executor.run(encoder, COMBINE.name, (&COMBINE, Variant::PIXELS), &resources, workgroups);
            Ok(picture)
        };
        self.gpu.checked(encode).await
    }
}
