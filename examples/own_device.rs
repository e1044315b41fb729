//! Renders a pair that stays on the device. The caller's own pipeline samples both views and makes a red-cyan anaglyph
//! of them. It uses the caller's own device and submission. A live view would show the texture that this example writes
//! to a file.
//!
//! ```sh
//! cargo run --release --example own_device -- out/anaglyph.png
//! ```

use std::error::Error;

use stereotrace::{
    Builtin, GBuffer, Gpu, Method, Options, Renderer, Rig,
    blocking::Wait,
    output::{Anaglyph, Picture},
    wgpu,
};

const SIZE: [u32; 2] = [640, 448];

/// Shader that computes the anaglyph. `OF_LEFT` and `OF_RIGHT` stand for matrices on linear colour.
const SHADER: &str = "
@group(0) @binding(0) var left: texture_2d<f32>;
@group(0) @binding(1) var right: texture_2d<f32>;

@vertex
fn whole_screen(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(4.0 * f32(index & 1u) - 1.0, 4.0 * f32(index >> 1u) - 1.0, 0.0, 1.0);
}

@fragment
fn anaglyph(@builtin(position) place: vec4f) -> @location(0) vec4f {
    let l = textureLoad(left, vec2u(place.xy), 0).rgb;
    let r = textureLoad(right, vec2u(place.xy), 0).rgb;
    return vec4f(clamp(OF_LEFT * l + OF_RIGHT * r, vec3f(0.0), vec3f(1.0)), 1.0);
}
";

/// Returns the shader for Dubois's red-cyan anaglyphs.
fn shader() -> String {
    // WGSL lists a matrix by columns, the library by rows.
    let wgsl = |rows: [[f32; 3]; 3]| {
        let columns: Vec<String> = (0..9).map(|index| format!("{:?}", rows[index % 3][index / 3])).collect();
        format!("mat3x3f({})", columns.join(", "))
    };
    let (left, right) = Anaglyph::Dubois.matrices();
    SHADER.replace("OF_LEFT", &wgsl(left)).replace("OF_RIGHT", &wgsl(right))
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or("anaglyph.png".into());
    let (device, queue) = own_device()?;
    let mut renderer = Renderer::new(Gpu::from_device(device.clone(), queue.clone())?);
    let scene = renderer.upload(&Builtin::Hall.scene()).wait()?;
    let rig = Rig::pair(Builtin::Hall.camera(SIZE[0], SIZE[1]));
    let options = Options::new(Method::default()).g_buffer(GBuffer::None);

    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let pair = renderer.views(&scene, &rig).options(&options).encode(&mut encoder).wait()?;
    let shown = texture(&device);
    draw(&device, &mut encoder, [&pair.views[0].linear(), &pair.views[1].linear()], &shown);
    let bytes = download(&device, &mut encoder, &shown);
    queue.submit([encoder.finish()]);

    let unfinished = read(&device, &pair.unfinished)?;
    if unfinished != [0; 4] {
        return Err("the adapter ended some threads before their work was done".into());
    }
    let pixels = read(&device, &bytes)?.as_chunks::<4>().0.to_vec();
    Picture::new(SIZE[0], SIZE[1], pixels).save_png(&path)?;
    println!("{path}: a pair by {} that never left the device", Method::default());
    Ok(())
}

/// Creates the program's own device, with the features and limits that the library requires. A program can add its own.
fn own_device() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let descriptor = wgpu::DeviceDescriptor {
        required_features: Gpu::required_features(),
        required_limits: Gpu::required_limits(),
        ..Default::default()
    };
    Ok(pollster::block_on(adapter.request_device(&descriptor))?)
}

/// Creates the texture that a live view would get from its window.
fn texture(device: &wgpu::Device) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("shown"),
        size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn draw(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    views: [&wgpu::TextureView; 2],
    shown: &wgpu::Texture,
) {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("anaglyph"),
        source: wgpu::ShaderSource::Wgsl(shader().into()),
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("anaglyph"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(shown.format().into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("views"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[0, 1].map(|eye| wgpu::BindGroupEntry {
            binding: eye,
            resource: wgpu::BindingResource::TextureView(views[eye as usize]),
        }),
    });
    let target = shown.create_view(&wgpu::TextureViewDescriptor::default());
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("anaglyph"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations::default(),
        })],
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..3, 0..1);
}

/// Returns a buffer that holds the texture's pixels once the commands have run. Its rows are a multiple of 256 bytes,
/// as copies require.
fn download(device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, texture: &wgpu::Texture) -> wgpu::Buffer {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("download"),
        size: u64::from(4 * SIZE[0] * SIZE[1]),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * SIZE[0]), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    buffer
}

fn read(device: &wgpu::Device, buffer: &wgpu::Buffer) -> Result<Vec<u8>, Box<dyn Error>> {
    buffer.map_async(wgpu::MapMode::Read, .., |_| ());
    device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(buffer.get_mapped_range(..)?.to_vec())
}
