//! Draws a pair with text over it, into a window or a picture. The passes of show.wgsl draw each eye's part, and then
//! the window. Between them, the library makes one picture of both parts.

use bytemuck::{Pod, Zeroable};
use stereotrace::{
    Error, Gpu, Renderer, Span, StereoPair, View,
    blocking::Wait,
    output::{Combination, Picture},
    wgpu,
};

use super::head::Cut;

const SHADER: &str = include_str!("show.wgsl");
/// Format of all pictures but the window's.
const PICTURE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Arrangement in which both views are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Look {
    /// Both views: an anaglyph, or views beside each other.
    Both(Combination),
    /// One view alone.
    One { right: bool },
}

/// Arrangement of a pair in the window, and the part of it that the window shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sight {
    pub(super) look: Look,
    /// Whether the eyes are exchanged.
    pub(super) swap: bool,
    /// The planar pictures that are shown of an equirectangular pair.
    pub(super) cut: Option<Cut>,
}

/// Returns the size of one eye's part of a window of this size, in pixels.
pub(super) fn eye_size(look: Look, [width, height]: [u32; 2]) -> [u32; 2] {
    match look {
        Look::Both(Combination::Packed(_)) => [(width / 2).max(1), height],
        _ => [width, height],
    }
}

/// `Part` of show.wgsl, where a column of a matrix has four words.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Part {
    to_pair: [[f32; 4]; 3],
    size: [f32; 2],
    turn: f32,
    pixel: f32,
}

impl Part {
    /// Returns the part that an eye, 0 or 1 for the pair's left or right one, sees of its view.
    fn new(cut: Option<Cut>, eye: usize, size: [u32; 2]) -> Self {
        let size = size.map(|side| side as f32);
        let Some(Cut { span, to_pair, tangent }) = cut else {
            return Self { to_pair: [[0.0; 4]; 3], size, turn: 0.0, pixel: 0.0 };
        };
        Self {
            to_pair: to_pair[eye].to_cols_array_2d().map(|[x, y, z]| [x as f32, y as f32, z as f32, 0.0]),
            size,
            turn: if span == Span::Full { 1.0 } else { 0.5 },
            pixel: 2.0 * tangent as f32 / size[1],
        }
    }
}

/// Textures and pipelines of the shown pair, on one device.
pub(super) struct Show {
    renderer: Renderer,
    module: wgpu::ShaderModule,
    of_view: wgpu::RenderPipeline,
    /// Pipeline for the window's format.
    of_window: wgpu::RenderPipeline,
    parts: [wgpu::Buffer; 2],
    stretch: wgpu::Sampler,
    wrap: wgpu::Sampler,
    views: [wgpu::Texture; 2],
    panel: wgpu::Texture,
    /// Whether the text is at the window's lower edge.
    is_below: bool,
    first_row: wgpu::Buffer,
}

impl Show {
    /// Creates a black picture and a pipeline for targets of this format.
    pub(super) fn new(gpu: Gpu, format: wgpu::TextureFormat) -> Self {
        let device = gpu.device();
        let source = wgpu::ShaderSource::Wgsl(SHADER.into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("show"), source });
        let uniform = |label, size| {
            let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
            let (label, size) = (Some(label), size as u64);
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
        };
        let sampler = |label, address_mode_u| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some(label),
                address_mode_u,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            })
        };
        let uploaded = |label| texture(device, label, [1, 1], wgpu::TextureUsages::COPY_DST);
        Self {
            of_view: pipeline(device, &module, "view", PICTURE),
            of_window: pipeline(device, &module, "show", format),
            parts: [0, 1].map(|_| uniform("part", size_of::<Part>())),
            stretch: sampler("stretch", wgpu::AddressMode::ClampToEdge),
            wrap: sampler("wrap", wgpu::AddressMode::Repeat),
            views: [0, 1].map(|_| uploaded("view")),
            panel: uploaded("panel"),
            is_below: false,
            first_row: uniform("first row", size_of::<[u32; 4]>()),
            module,
            renderer: Renderer::new(gpu),
        }
    }

    /// Uploads another pair.
    pub(super) fn set_pair(&mut self, pair: &StereoPair) {
        for (to, View { width, height, rgba8, .. }) in self.views.iter_mut().zip([&pair.left, &pair.right]) {
            fill(self.renderer.gpu(), to, ("view", [*width, *height]), rgba8);
        }
    }

    /// Uploads another picture of the text, for the window's upper or lower edge.
    pub(super) fn set_panel(&mut self, Picture { width, height, rgba8, .. }: &Picture, is_below: bool) {
        self.is_below = is_below;
        fill(self.renderer.gpu(), &mut self.panel, ("panel", [*width, *height]), rgba8);
    }

    /// Draws into a window's texture.
    pub(super) fn draw(&self, sight: Sight, target: &wgpu::Texture) -> Result<(), Error> {
        let commands = self.encode(sight, target, &self.of_window)?;
        self.renderer.gpu().queue().submit([commands.finish()]);
        Ok(())
    }

    /// Draws the picture of a window of this size and reads it back.
    pub(super) fn picture(&self, sight: Sight, [width, height]: [u32; 2]) -> Result<Picture, Error> {
        let (device, queue) = (self.renderer.gpu().device(), self.renderer.gpu().queue());
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let target = texture(device, "picture", [width, height], usage);
        let mut commands = self.encode(sight, &target, &pipeline(device, &self.module, "show", PICTURE))?;
        // Rows of a copied texture are padded to multiples of 256 bytes.
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        commands.copy_texture_to_buffer(target.as_image_copy(), to, target.size());
        queue.submit([commands.finish()]);
        let fault = |error: &dyn std::fmt::Display| Error::Gpu(error.to_string());
        buffer.map_async(wgpu::MapMode::Read, .., |_| ());
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| fault(&error))?;
        let bytes = buffer.get_mapped_range(..).map_err(|error| fault(&error))?;
        let rows = bytes.chunks_exact(row as usize).flat_map(|row| row[..4 * width as usize].as_chunks::<4>().0);
        Ok(Picture::new(width, height, rows.copied().collect()))
    }

    fn encode(
        &self,
        Sight { look, swap, cut }: Sight,
        target: &wgpu::Texture,
        pipeline: &wgpu::RenderPipeline,
    ) -> Result<wgpu::CommandEncoder, Error> {
        let device = self.renderer.gpu().device();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("show") });
        let size = eye_size(look, [target.width(), target.height()]);
        let [left, right] = [usize::from(swap), usize::from(!swap)];
        let picture = match look {
            Look::One { right: false } => self.seen(left, cut, size, &mut encoder),
            Look::One { right: true } => self.seen(right, cut, size, &mut encoder),
            Look::Both(how) => {
                let [left, right] = [left, right].map(|eye| self.seen(eye, cut, size, &mut encoder));
                self.renderer.encode_combined(how, [&left, &right], &mut encoder).wait()?
            }
        };
        let [picture, panel] = [&picture, &self.panel].map(view);
        let first_row = if self.is_below { target.height().saturating_sub(self.panel.height()) } else { 0 };
        self.renderer.gpu().queue().write_buffer(&self.first_row, 0, bytemuck::bytes_of(&[first_row, 0, 0, 0]));
        let resources = [
            (0, wgpu::BindingResource::TextureView(&picture)),
            (1, wgpu::BindingResource::TextureView(&panel)),
            (4, self.first_row.as_entire_binding()),
        ];
        run(device, &mut encoder, pipeline, &resources, target);
        Ok(encoder)
    }

    /// Returns what an eye, 0 or 1 for the pair's left or right one, sees in a part of the window.
    fn seen(&self, eye: usize, cut: Option<Cut>, size: [u32; 2], encoder: &mut wgpu::CommandEncoder) -> wgpu::Texture {
        let seen = &self.views[eye];
        if cut.is_none() && [seen.width(), seen.height()] == size {
            return seen.clone();
        }
        let gpu = self.renderer.gpu();
        gpu.queue().write_buffer(&self.parts[eye], 0, bytemuck::bytes_of(&Part::new(cut, eye, size)));
        let part = texture(gpu.device(), "part", size, wgpu::TextureUsages::RENDER_ATTACHMENT);
        let resources = [
            (0, wgpu::BindingResource::TextureView(&view(seen))),
            (2, self.parts[eye].as_entire_binding()),
            (3, wgpu::BindingResource::Sampler(if cut.is_some() { &self.wrap } else { &self.stretch })),
        ];
        run(gpu.device(), encoder, &self.of_view, &resources, &part);
        part
    }
}

/// Encodes a pass that draws a whole target.
fn run(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::RenderPipeline,
    resources: &[(u32, wgpu::BindingResource<'_>)],
    target: &wgpu::Texture,
) {
    let entries = resources.iter().cloned().map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("show"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &Vec::from_iter(entries),
    });
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("show"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &view(target),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations::default(),
        })],
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..3, 0..1);
}

/// Uploads pixels into a texture, which is replaced if its size differs.
fn fill(gpu: &Gpu, to: &mut wgpu::Texture, (label, size): (&str, [u32; 2]), pixels: &[[u8; 4]]) {
    if [to.width(), to.height()] != size {
        *to = texture(gpu.device(), label, size, wgpu::TextureUsages::COPY_DST);
    }
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size[0]), rows_per_image: None };
    gpu.queue().write_texture(to.as_image_copy(), bytemuck::cast_slice(pixels), layout, to.size());
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Creates a texture that can be sampled.
fn texture(device: &wgpu::Device, label: &str, [width, height]: [u32; 2], usage: wgpu::TextureUsages) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: PICTURE,
        usage: usage | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    fragment: &str,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
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
            entry_point: Some(fragment),
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
        Builtin, Equirectangular, Method, Options, Projection, StereoCamera,
        glam::DVec3,
        output::{Anaglyph, Packing},
    };

    use super::super::head::Head;
    use super::*;

    const SIZE: [u32; 2] = [93, 40];
    const LEFT: Look = Look::One { right: false };

    const RIGHT: Look = Look::One { right: true };

    fn plain(look: Look) -> Sight {
        Sight { look, swap: false, cut: None }
    }

    /// Returns all arrangements of both views in the window.
    fn combinations() -> impl Iterator<Item = Combination> {
        let packings = [Packing::SideBySide, Packing::CrossEyed].map(Combination::Packed);
        Anaglyph::ALL.iter().map(|&kind| Combination::Anaglyph(kind)).chain(packings)
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

    fn show(pair: &StereoPair) -> Show {
        let (_, gpu) = setting();
        let mut show = Show::new(gpu.clone(), PICTURE);
        show.set_pair(pair);
        show
    }

    /// Returns the largest difference of any channel.
    fn difference(a: &Picture, b: &Picture) -> u8 {
        assert_eq!((a.width, a.height), (b.width, b.height));
        let channels = a.rgba8.iter().flatten().zip(b.rgba8.iter().flatten());
        channels.map(|(a, b)| a.abs_diff(*b)).max().unwrap()
    }

    #[test]
    fn both_views_are_shown_as_in_files() {
        let (pair, _) = setting();
        let show = show(pair);
        for how in combinations() {
            let most = u8::from(matches!(how, Combination::Anaglyph(_)));
            for (swap, [left, right]) in [(false, [&pair.left, &pair.right]), (true, [&pair.right, &pair.left])] {
                let expected = how.picture(left, right);
                let sight = Sight { swap, ..plain(Look::Both(how)) };
                let found = show.picture(sight, [expected.width, expected.height]).unwrap();
                assert!(difference(&found, &expected) <= most, "{how:?}: {}", difference(&found, &expected));
                let exchanged = show.picture(Sight { swap: !swap, ..sight }, [expected.width, expected.height]);
                assert!(difference(&exchanged.unwrap(), &expected) > 100, "{how:?}");
            }
        }
    }

    #[test]
    fn one_view_alone_is_as_it_was_rendered() {
        let (pair, _) = setting();
        let show = show(pair);
        for (look, swap, view) in [
            (LEFT, false, &pair.left),
            (RIGHT, false, &pair.right),
            (LEFT, true, &pair.right),
            (RIGHT, true, &pair.left),
        ] {
            let found = show.picture(Sight { swap, ..plain(look) }, SIZE).unwrap();
            assert_eq!(difference(&found, &view.picture()), 0, "{look:?} {swap}");
        }
    }

    #[test]
    fn the_last_column_of_an_odd_width_belongs_to_no_eye() {
        let (pair, _) = setting();
        let how = Combination::Packed(Packing::SideBySide);
        let expected = how.picture(&pair.left, &pair.right);
        let odd = show(pair).picture(plain(Look::Both(how)), [expected.width + 1, expected.height]).unwrap();
        let rows = |picture: &Picture| Vec::from_iter(picture.rgba8.chunks(picture.width as usize).map(<[_]>::to_vec));
        for (found, expected) in rows(&odd).iter().zip(rows(&expected)) {
            assert_eq!(found.split_last(), Some((&[0, 0, 0, 255], &expected[..])));
        }
    }

    /// Magnification keeps the colours of a view's corners, unless another view's pixels reach them.
    #[test]
    fn smaller_views_fill_their_parts_of_the_window() {
        let (pair, _) = setting();
        let show = show(pair);
        let corners = |rgba8: &[[u8; 4]], width: usize, columns: [usize; 2]| {
            [0, rgba8.len() - width].map(|row| columns.map(|column| rgba8[row + column]))
        };
        let [left, right] = [&pair.left, &pair.right].map(|view| corners(&view.rgba8, 93, [0, 92]));
        let alone = show.picture(plain(RIGHT), [200, 77]).unwrap();
        assert_eq!(corners(&alone.rgba8, 200, [0, 199]), right);
        let beside = plain(Look::Both(Combination::Packed(Packing::SideBySide)));
        let beside = show.picture(beside, [400, 77]).unwrap();
        assert_eq!([[0, 199], [200, 399]].map(|columns| corners(&beside.rgba8, 400, columns)), [left, right]);
    }

    #[test]
    fn text_stands_over_the_picture_in_a_left_corner() {
        let (pair, _) = setting();
        let mut show = show(pair);
        let text = Picture::new(2, 1, vec![[255, 255, 255, 255], [9, 9, 9, 0]]);
        for (is_below, place) in [(false, 0), (true, (SIZE[0] * (SIZE[1] - 1)) as usize)] {
            show.set_panel(&text, is_below);
            let mut expected = pair.left.rgba8.clone();
            expected[place] = [255; 4];
            assert_eq!(show.picture(plain(LEFT), SIZE).unwrap().rgba8, expected);
        }
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
        let mut show = Show::new(gpu.clone(), PICTURE);
        for (pair, span, [right, up]) in [
            (&pairs[0], Span::Full, [0.0, 0.0]),
            (&pairs[0], Span::Full, [3.0, 0.4]),
            (&pairs[0], Span::Full, [-1.2, -0.9]),
            (&pairs[1], Span::Half, [0.4, -0.3]),
        ] {
            let mut head = Head::new(span);
            head.turn(right, up);
            show.set_pair(pair);
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
            for (eye, look) in [LEFT, RIGHT].into_iter().enumerate() {
                let found = middle(&show.picture(Sight { cut, ..plain(look) }, [64, 48]).unwrap().rgba8);
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
        let (pair, _) = setting();
        let show = show(pair);
        let cut = Some(Head::new(Span::Full).cut(0.4, 1.0));
        let picture = |look, swap| show.picture(Sight { look, swap, cut }, SIZE).unwrap();
        let [left, right] = [LEFT, RIGHT].map(|look| picture(look, false));
        assert!(difference(&left, &right) > 100);
        assert_eq!([picture(LEFT, true), picture(RIGHT, true)], [right, left]);
    }
}
