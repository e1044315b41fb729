//! Draws a pair with text over it, by one pass of show.wgsl, into a window or a picture.

use bytemuck::{Pod, Zeroable};
use stereotrace::{
    Span, StereoPair, View,
    glam::DMat3,
    output::{Anaglyph, Picture},
    wgpu,
};

use super::head::Cut;

const SHADER: &str = include_str!("show.wgsl");
/// Format of the textures that the shader reads and decodes.
const TEXTURE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Format of pictures that are drawn for files.
const PICTURE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// Arrangement in which both views are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Look {
    /// Mixed for anaglyph glasses.
    Anaglyph(Anaglyph),
    /// Side by side, with the left view on the left unless `crossed`.
    Beside { crossed: bool },
    /// One view alone.
    One { right: bool },
}

/// Arrangement of a pair in the window, and the part of it that the window shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sight {
    pub(super) look: Look,
    /// The planar pictures that are shown of an equirectangular pair.
    pub(super) cut: Option<Cut>,
}

/// Uniforms with the layout of show.wgsl, where a column of a matrix has four words.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Shown {
    decoded: [f32; 256],
    of_left: [[f32; 4]; 3],
    of_right: [[f32; 4]; 3],
    to_pair: [[[f32; 4]; 3]; 2],
    size: [u32; 2],
    beside: u32,
    encoded: u32,
    turn: f32,
    pixel: f32,
    padding: [u32; 2],
}

/// Returns the size of one eye's picture in a window of this size, in pixels.
pub(super) fn eye_size(look: Look, [width, height]: [u32; 2]) -> [u32; 2] {
    match look {
        Look::Beside { .. } => [(width / 2).max(1), height],
        Look::Anaglyph(_) | Look::One { .. } => [width, height],
    }
}

impl Shown {
    /// `exchanged` says whether the first texture is the right view.
    fn new(Sight { look, cut }: Sight, size: [u32; 2], encoded: bool, exchanged: bool) -> Self {
        let one = |k: f32| [[k, 0.0, 0.0], [0.0, k, 0.0], [0.0, 0.0, k]];
        let (left, right) = match look {
            Look::Anaglyph(kind) => kind.matrices(),
            Look::Beside { .. } | Look::One { right: false } => (one(1.0), one(0.0)),
            Look::One { right: true } => (one(0.0), one(1.0)),
        };
        // The library's matrices are row-major, and the shader's matrices are column-major.
        let columns =
            |rows: [[f32; 3]; 3]| [0, 1, 2].map(|column| [rows[0][column], rows[1][column], rows[2][column], 0.0]);
        let beside = u32::from(matches!(look, Look::Beside { .. }));
        let size = eye_size(look, size);
        let share = |span| if span == Span::Full { 1.0 } else { 0.5 };
        let padded = |matrix: DMat3| matrix.to_cols_array_2d().map(|[x, y, z]| [x as f32, y as f32, z as f32, 0.0]);
        let [of_first, of_second] = cut.map_or([DMat3::ZERO; 2], |cut| cut.to_pair).map(padded);
        Self {
            to_pair: if exchanged { [of_second, of_first] } else { [of_first, of_second] },
            turn: cut.map_or(0.0, |cut| share(cut.span)),
            pixel: cut.map_or(0.0, |cut| (2.0 * cut.tangent / f64::from(size[1])) as f32),
            padding: [0; 2],
            decoded: decoded(),
            of_left: columns(left),
            of_right: columns(right),
            size,
            beside,
            encoded: encoded.into(),
        }
    }
}

/// Returns the linear light of each sRGB-encoded byte (IEC 61966-2-1).
fn decoded() -> [f32; 256] {
    std::array::from_fn(|byte| {
        let encoded = byte as f64 / 255.0;
        let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
}

/// Textures and pipeline of the shown pair, on one device.
pub(super) struct Show {
    device: wgpu::Device,
    queue: wgpu::Queue,
    module: wgpu::ShaderModule,
    /// Pipeline for the window's format.
    pipeline: wgpu::RenderPipeline,
    format: wgpu::TextureFormat,
    uniforms: wgpu::Buffer,
    stretch: wgpu::Sampler,
    wrap: wgpu::Sampler,
    eyes: [wgpu::Texture; 2],
    /// Whether the eyes are exchanged.
    swap: bool,
    panel: wgpu::Texture,
}

impl Show {
    /// Creates a black picture and a pipeline for targets of this format.
    pub(super) fn new(device: wgpu::Device, queue: wgpu::Queue, format: wgpu::TextureFormat) -> Self {
        let source = wgpu::ShaderSource::Wgsl(SHADER.into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("show"), source });
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("shown"),
            size: size_of::<Shown>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let sampler = |label, address_mode_u| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some(label),
                address_mode_u,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            })
        };
        let stretch = sampler("stretch", wgpu::AddressMode::ClampToEdge);
        let wrap = sampler("wrap", wgpu::AddressMode::Repeat);
        let eyes = [0, 1].map(|_| texture(&device, "eye", [1, 1]));
        let panel = texture(&device, "panel", [1, 1]);
        let pipeline = pipeline(&device, &module, format);
        Self { device, queue, module, pipeline, format, uniforms, stretch, wrap, eyes, swap: false, panel }
    }

    /// Uploads another pair, with its eyes exchanged if `swap`.
    pub(super) fn set_pair(&mut self, pair: &StereoPair, swap: bool) {
        self.swap = swap;
        let eyes = if swap { [&pair.right, &pair.left] } else { [&pair.left, &pair.right] };
        for (to, View { width, height, rgba8, .. }) in self.eyes.iter_mut().zip(eyes) {
            fill(&self.device, &self.queue, to, ("eye", [*width, *height]), rgba8);
        }
    }

    /// Uploads another picture of the text.
    pub(super) fn set_panel(&mut self, Picture { width, height, rgba8, .. }: &Picture) {
        fill(&self.device, &self.queue, &mut self.panel, ("panel", [*width, *height]), rgba8);
    }

    /// Draws into a window's texture.
    pub(super) fn draw(&self, sight: Sight, target: &wgpu::Texture) {
        let commands = self.encode(sight, target, &self.pipeline, self.format);
        self.queue.submit([commands.finish()]);
    }

    /// Draws the picture of a window of this size and reads it back.
    pub(super) fn picture(&self, sight: Sight, size: [u32; 2]) -> Result<Picture, stereotrace::Error> {
        self.picture_in(sight, size, PICTURE)
    }

    fn picture_in(
        &self,
        sight: Sight,
        [width, height]: [u32; 2],
        format: wgpu::TextureFormat,
    ) -> Result<Picture, stereotrace::Error> {
        let target = self.device.create_texture(&wgpu::TextureDescriptor {
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            format,
            ..descriptor("picture", [width, height])
        });
        let pipeline = pipeline(&self.device, &self.module, format);
        let mut commands = self.encode(sight, &target, &pipeline, format);
        // Rows of a copied texture are padded to multiples of 256 bytes.
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        commands.copy_texture_to_buffer(target.as_image_copy(), to, target.size());
        self.queue.submit([commands.finish()]);
        let fault = |error: &dyn std::fmt::Display| stereotrace::Error::Gpu(error.to_string());
        buffer.map_async(wgpu::MapMode::Read, .., |_| ());
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| fault(&error))?;
        let bytes = buffer.get_mapped_range(..).map_err(|error| fault(&error))?;
        let rows = bytes.chunks_exact(row as usize).flat_map(|row| row[..4 * width as usize].as_chunks::<4>().0);
        Ok(Picture::new(width, height, rows.copied().collect()))
    }

    fn encode(
        &self,
        sight: Sight,
        target: &wgpu::Texture,
        pipeline: &wgpu::RenderPipeline,
        format: wgpu::TextureFormat,
    ) -> wgpu::CommandEncoder {
        let crossed = sight.look == Look::Beside { crossed: true };
        let shown = Shown::new(sight, [target.width(), target.height()], !format.is_srgb(), crossed != self.swap);
        self.queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&shown));
        let [left, right] = [0, 1].map(|eye| view(&self.eyes[if crossed { 1 - eye } else { eye }]));
        let panel = view(&self.panel);
        let resources = [
            self.uniforms.as_entire_binding(),
            wgpu::BindingResource::TextureView(&left),
            wgpu::BindingResource::TextureView(&right),
            wgpu::BindingResource::TextureView(&panel),
            wgpu::BindingResource::Sampler(&self.stretch),
            wgpu::BindingResource::Sampler(&self.wrap),
        ];
        let entries = (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("show"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &Vec::from_iter(entries),
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("show") });
        let target = view(target);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("show"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations::default(),
            })],
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        encoder
    }
}

/// Uploads pixels into a texture, which is replaced if its size differs.
fn fill(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    to: &mut wgpu::Texture,
    (label, size): (&str, [u32; 2]),
    pixels: &[[u8; 4]],
) {
    if [to.width(), to.height()] != size {
        *to = texture(device, label, size);
    }
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size[0]), rows_per_image: None };
    queue.write_texture(to.as_image_copy(), bytemuck::cast_slice(pixels), layout, to.size());
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn descriptor(label: &str, [width, height]: [u32; 2]) -> wgpu::TextureDescriptor<'_> {
    wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: TEXTURE,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    }
}

fn texture(device: &wgpu::Device, label: &str, size: [u32; 2]) -> wgpu::Texture {
    device.create_texture(&descriptor(label, size))
}

fn pipeline(device: &wgpu::Device, module: &wgpu::ShaderModule, format: wgpu::TextureFormat) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("show"),
        layout: None,
        vertex: wgpu::VertexState {
            module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

#[cfg(test)]
mod tests {
    use std::sync::OnceLock;

    use stereotrace::{
        Builtin, Equirectangular, Gpu, Method, Options, Projection, Renderer, StereoCamera,
        blocking::Wait,
        glam::DVec3,
        output::{Packing, anaglyph, packed},
    };

    use super::super::head::Head;
    use super::*;

    const SIZE: [u32; 2] = [93, 40];
    const LEFT: Look = Look::One { right: false };

    fn plain(look: Look) -> Sight {
        Sight { look, cut: None }
    }

    /// Returns a pair of random pixels, and a device to draw it on.
    fn setting() -> &'static (StereoPair, Gpu) {
        static SETTING: OnceLock<(StereoPair, Gpu)> = OnceLock::new();
        SETTING.get_or_init(|| {
            let gpu = Gpu::open("software").wait().unwrap();
            let mut renderer = Renderer::new(gpu.clone());
            let scene = renderer.upload(&Builtin::Spheres.scene()).wait().unwrap();
            let camera = Builtin::Spheres.camera(SIZE[0], SIZE[1]);
            let mut pair = renderer.pair(&scene, &camera).options(&Options::new(Method::Naive)).read().wait().unwrap();
            let mut state = 1_u32;
            let mut byte = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 24) as u8
            };
            for pixel in pair.left.rgba8.iter_mut().chain(&mut pair.right.rgba8) {
                *pixel = [byte(), byte(), byte(), 255];
            }
            (pair, gpu)
        })
    }

    fn shown(swap: bool, look: Look, size: [u32; 2]) -> Picture {
        let (pair, gpu) = setting();
        let mut show = Show::new(gpu.device().clone(), gpu.queue().clone(), PICTURE);
        show.set_pair(pair, swap);
        show.picture(plain(look), size).unwrap()
    }

    /// Returns the largest difference of any channel.
    fn difference(a: &Picture, b: &Picture) -> u8 {
        assert_eq!((a.width, a.height), (b.width, b.height));
        let channels = a.rgba8.iter().flatten().zip(b.rgba8.iter().flatten());
        channels.map(|(a, b)| a.abs_diff(*b)).max().unwrap()
    }

    #[test]
    fn anaglyphs_are_the_library_s() {
        let (pair, _) = setting();
        for &kind in Anaglyph::ALL {
            for swap in [false, true] {
                let (left, right) = if swap { (&pair.right, &pair.left) } else { (&pair.left, &pair.right) };
                let expected = anaglyph(left, right, kind);
                let found = shown(swap, Look::Anaglyph(kind), SIZE);
                assert!(difference(&found, &expected) <= 1, "{kind}: {}", difference(&found, &expected));
            }
        }
        let other = shown(true, Look::Anaglyph(Anaglyph::Dubois), SIZE);
        assert!(difference(&other, &anaglyph(&pair.left, &pair.right, Anaglyph::Dubois)) > 100);
    }

    #[test]
    fn eyes_alone_and_beside_each_other_are_as_they_were_rendered() {
        let (pair, _) = setting();
        for (right, view) in [(false, &pair.left), (true, &pair.right)] {
            assert_eq!(difference(&shown(false, Look::One { right }, SIZE), &view.picture()), 0);
        }
        for (crossed, packing) in [(false, Packing::SideBySide), (true, Packing::CrossEyed)] {
            let found = shown(false, Look::Beside { crossed }, [2 * SIZE[0], SIZE[1]]);
            assert_eq!(difference(&found, &packed(&pair.left, &pair.right, packing)), 0);
        }
        // The last column of an odd width belongs to no eye.
        let odd = shown(false, Look::Beside { crossed: false }, [2 * SIZE[0] + 1, SIZE[1]]);
        let row = &odd.rgba8[..odd.width as usize];
        assert_eq!(row[..SIZE[0] as usize], pair.left.rgba8[..SIZE[0] as usize]);
        assert_eq!(row[odd.width as usize - 1], [0, 0, 0, 255]);
    }

    #[test]
    fn a_smaller_picture_fills_the_window() {
        let (pair, _) = setting();
        let mut flat = pair.clone();
        flat.left.rgba8.fill([10, 200, 90, 255]);
        let (_, gpu) = setting();
        let mut show = Show::new(gpu.device().clone(), gpu.queue().clone(), PICTURE);
        show.set_pair(&flat, false);
        let found = show.picture(plain(LEFT), [200, 77]).unwrap();
        assert!(found.rgba8.iter().all(|pixel| *pixel == [10, 200, 90, 255]));
    }

    #[test]
    fn text_stands_over_the_picture_in_its_corner() {
        let (pair, gpu) = setting();
        let mut show = Show::new(gpu.device().clone(), gpu.queue().clone(), PICTURE);
        show.set_pair(pair, false);
        show.set_panel(&Picture::new(2, 1, vec![[255, 255, 255, 255], [9, 9, 9, 0]]));
        let found = show.picture(plain(LEFT), SIZE).unwrap();
        assert_eq!(found.rgba8[0], [255; 4]);
        assert_eq!(found.rgba8[1..], pair.left.rgba8[1..]);
    }

    #[test]
    fn windows_that_take_encoded_values_show_the_same() {
        let (pair, gpu) = setting();
        let format = wgpu::TextureFormat::Rgba8Unorm;
        let shown = Shown::new(plain(LEFT), SIZE, !format.is_srgb(), false);
        assert_eq!((shown.encoded, shown.size), (1, SIZE));
        let mut show = Show::new(gpu.device().clone(), gpu.queue().clone(), format);
        show.set_pair(pair, false);
        let found = show.picture_in(plain(LEFT), SIZE, format).unwrap();
        assert!(difference(&found, &pair.left.picture()) <= 1);
    }

    #[test]
    fn parts_of_equirectangular_pairs_are_what_planar_cameras_see() {
        let gpu = Gpu::open("software").wait().unwrap(); // other tests poll theirs
        let mut renderer = Renderer::new(gpu.clone());
        let scene = renderer.upload(&Builtin::Hall.scene()).wait().unwrap();
        let options = Options::new(Method::Naive).samples(4);
        let hall = Builtin::Hall.camera(64, 64);
        let eye = hall.pose().unwrap().eye;
        let around = |span, size: [u32; 2]| {
            let projection = Projection::Equirectangular(Equirectangular { span, merge: None });
            let camera = StereoCamera::look_at(eye, eye + DVec3::X).projection(projection).interaxial(0.2);
            camera.size(size[0], size[1])
        };
        let pairs = [around(Span::Full, [1024, 512]), around(Span::Half, [512, 512])];
        let pairs = pairs.map(|camera| renderer.pair(&scene, &camera).options(&options).read().wait().unwrap());
        let mut show = Show::new(gpu.device().clone(), gpu.queue().clone(), PICTURE);
        for (pair, span, [right, up]) in [
            (&pairs[0], Span::Full, [0.0, 0.0]),
            (&pairs[0], Span::Full, [3.0, 0.4]),
            (&pairs[0], Span::Full, [-1.2, -0.9]),
            (&pairs[1], Span::Half, [0.4, -0.3]),
        ] {
            let mut head = Head::new(span);
            head.turn(right, up);
            show.set_pair(pair, false);
            let cut = Some(head.cut(0.2, f64::INFINITY));
            // An eye of the viewing circle is beside the ray, so the ray of the window's middle is that of a planar
            // camera there. Other rays start elsewhere, by at most the circle's radius.
            let planar = [-1.0, 1.0].map(|side| {
                let beside = DVec3::new(-right.sin(), 0.0, right.cos()) * (side * 0.1);
                let ahead = DVec3::new(right.cos() * up.cos(), up.sin(), right.sin() * up.cos());
                let camera = StereoCamera::look_at(eye + beside, eye + beside + ahead).interaxial(0.0);
                let camera = camera.size(64, 48).vertical_fov_degrees(head.fov() as f32);
                renderer.pair(&scene, &camera).options(&options).read().wait().unwrap().left
            });
            let middle = |pixels: &[[u8; 4]]| {
                let places = (18..30).flat_map(|row| (26..38).map(move |column| 64 * row + column));
                Vec::from_iter(places.map(|place: usize| pixels[place]))
            };
            for (eye, look) in [LEFT, Look::One { right: true }].into_iter().enumerate() {
                let found = middle(&show.picture(Sight { look, cut }, [64, 48]).unwrap().rgba8);
                let errors = planar.each_ref().map(|view| {
                    let expected = middle(&view.rgba8);
                    let channels = found.iter().flatten().zip(expected.iter().flatten());
                    channels.map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / (4 * found.len()) as f64
                });
                println!("{span:?}, {right} right, {up} up, eye {eye}: {errors:?}");
                // The errors are at most 9.4, and at most 0.7 of those to the other eye's camera.
                assert!(
                    errors[eye] < 11.0 && errors[eye] < 0.75 * errors[1 - eye],
                    "{span:?} {right} {up} {eye}: {errors:?}"
                );
            }
        }
    }

    #[test]
    fn each_view_keeps_its_own_turn_when_the_eyes_are_exchanged() {
        let cut = Head::new(Span::Full).cut(0.4, 1.0);
        let [left, right] = cut.to_pair.map(|matrix| matrix.x_axis.z as f32);
        assert!((left + right).abs() < 1e-6 && left < -0.1);
        for (exchanged, expected) in [(false, [left, right]), (true, [right, left])] {
            let shown = Shown::new(Sight { look: LEFT, cut: Some(cut) }, SIZE, true, exchanged);
            assert_eq!(shown.to_pair.map(|matrix| matrix[0][2]), expected);
        }
    }
}
