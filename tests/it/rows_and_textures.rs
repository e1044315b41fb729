//! Tests rows that are read as soon as they are finished, and views that stay on the device. Both must equal whole
//! pairs.

use crate::common;

use common::{gpu, has_small_bands, random_stage, renderer};
use stereotrace::{
    AmbientOcclusion, Builtin, EncodedView, Equirectangular, Error, Filter, GBuffer, Gpu, Light, Method, Options,
    Projection, Renderer, Rig, Rows, Scene, Sky, Span, StereoCamera, Tone, View, Visibility,
    blocking::Wait,
    glam::Vec3,
    output::{Anaglyph, Combination, Packing},
    wgpu,
};

/// Returns a camera whose picture has two bands of 64 rows, and 30 rows more.
fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.0, 0.5, 5.0), Vec3::ZERO)
        .screen_distance(5.0)
        .size(4096, 158)
        .interaxial_pixels(60.0)
}

#[test]
fn rows_come_from_the_top_down_and_make_the_whole_views() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    let rig = Rig::at(camera(), vec![-0.5, 0.5, 0.1]).traced(vec![0]);
    for method in [Method::Auto, Method::BRACKET, Method::VERIFIED, Method::ATOMIC, "buffer-edges".parse().unwrap()] {
        let options = Options::new(method).linear(true).cost_map(true);
        let whole = renderer.views(&uploaded, &rig).options(&options).read().wait().unwrap();
        let mut bands: Vec<Rows> = Vec::new();
        let rest = renderer
            .views(&uploaded, &rig)
            .options(&options)
            .rows(&mut |rows| {
                bands.push(rows);
                Ok(())
            })
            .wait();
        let rest = rest.unwrap();
        let firsts: Vec<u32> = bands.iter().map(|rows| rows.first).collect();
        assert!(!has_small_bands(renderer.gpu()) || firsts == [0, 64, 128], "{method}: {firsts:?}");
        for (index, view) in whole.views.iter().enumerate() {
            let of = |rows: &dyn Fn(&View) -> Vec<[u8; 4]>| -> Vec<_> {
                bands.iter().flat_map(|band| rows(&band.views[index].view)).collect()
            };
            assert!(of(&|rows| rows.rgba8.clone()) == view.view.rgba8, "{method} {index}");
            let words = |values: &[f32]| values.iter().map(|value| value.to_le_bytes()).collect::<Vec<_>>();
            assert!(of(&|rows| words(&rows.depth)) == words(&view.view.depth), "{method} {index}");
            let source: Vec<_> = bands.iter().flat_map(|band| band.views[index].source.clone()).collect();
            assert!(source == view.source, "{method} {index}");
            assert_eq!((rest.views[index].work, rest.views[index].view.height), (view.work, 0), "{method} {index}");
        }
    }
}

#[test]
fn what_a_sink_returns_ends_the_frame_and_the_next_one_is_whole() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    let options = Options::new(Method::BRACKET);
    let expected = renderer.pair(&uploaded, &camera()).options(&options).read().wait().unwrap();
    let mut calls = 0;
    let stopped = renderer
        .views(&uploaded, &Rig::pair(camera()))
        .options(&options)
        .rows(&mut |_| {
            calls += 1;
            Err(Error::Cancelled)
        })
        .wait();
    assert!(matches!(stopped, Err(Error::Cancelled)) && calls == 1, "{stopped:?} {calls}");
    let again = renderer.pair(&uploaded, &camera()).options(&options).read().wait().unwrap();
    assert!(again.right == expected.right && again.left == expected.left);
}

#[test]
fn one_eye_is_a_rig_too() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    let camera = camera().size(61, 40);
    let mono = renderer.views(&uploaded, &Rig::row(camera, 1)).read().wait().unwrap();
    assert_eq!(mono.views.len(), 1);
    let centred = camera.interaxial(0.0);
    let pair = renderer.pair(&uploaded, &centred).options(&Options::new(Method::Naive)).read().wait().unwrap();
    assert!(mono.views[0].view == pair.left);
    assert_eq!(mono.views[0].method, Method::Naive);
}

/// Returns the texels of a texture with four bytes per texel.
fn texels(gpu: &Gpu, texture: &wgpu::Texture) -> Vec<[u8; 4]> {
    let (width, height) = (texture.width(), texture.height());
    let row = (4 * width).next_multiple_of(256);
    let buffer = gpu.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    gpu.queue().submit([encoder.finish()]);
    let bytes = read(gpu, &buffer);
    let rows = bytes.chunks_exact(row as usize);
    rows.flat_map(|row| row[..4 * width as usize].as_chunks::<4>().0.to_vec()).collect()
}

fn read(gpu: &Gpu, buffer: &wgpu::Buffer) -> Vec<u8> {
    buffer.map_async(wgpu::MapMode::Read, .., |_| ());
    gpu.device().poll(wgpu::PollType::wait_indefinitely()).unwrap();
    buffer.get_mapped_range(..).unwrap().to_vec()
}

fn assert_shows(gpu: &Gpu, encoded: &EncodedView, expected: &View, what: &str) {
    assert!(texels(gpu, &encoded.color) == expected.rgba8, "{what}");
    let far = |z: f32| if z == f32::INFINITY { 3.4e38 } else { z };
    let depth: Vec<_> = expected.depth.iter().map(|&z| far(z).to_le_bytes()).collect();
    assert!(encoded.depth.as_ref().is_none_or(|texture| texels(gpu, texture) == depth), "{what}");
}

#[test]
fn encoded_views_are_those_that_are_read_back() {
    let gpu = gpu();
    let mut renderer = Renderer::new(gpu.clone());
    let mut scene = random_stage(4);
    let by_points = renderer.upload(&scene).wait().unwrap();
    scene.lights.push(Light::sphere(Vec3::new(1.0, 4.0, 3.0), 0.3, Vec3::splat(0.3)));
    let softly = renderer.upload(&scene).wait().unwrap();
    let rig = Rig::pair(camera());
    let methods = [Method::Auto, Method::Naive, Method::Ideal, Method::VERIFIED, "atomic-edges".parse().unwrap()];
    for (uploaded, method) in methods.map(|method| (&by_points, method)).into_iter().chain([(&softly, Method::BRACKET)])
    {
        let drawn = (GBuffer::Depth, Visibility::TBuffer);
        for (g_buffer, way) in [(GBuffer::Depth, Visibility::Rays), (GBuffer::None, Visibility::Rays), drawn] {
            let options = Options::new(method).g_buffer(g_buffer).shadow_rays(20).visibility(way);
            let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let encoded = renderer.views(uploaded, &rig).options(&options).encode(&mut encoder).wait().unwrap();
            let (by_bands, commands) = renderer.views(uploaded, &rig).options(&options).encode_bands().wait().unwrap();
            assert!(!has_small_bands(&gpu) || commands.len() == 3, "{method}: {}", commands.len());
            // Another frame of another size is rendered in between. The encoded frame must keep its resources.
            let other = camera().size(50, 41);
            renderer.pair(uploaded, &other).options(&Options::new(Method::BRACKET)).read().wait().unwrap();
            gpu.queue().submit([encoder.finish()]);
            gpu.queue().submit(commands);
            let pair = renderer
                .pair(uploaded, &camera())
                .options(&options.clone().g_buffer(GBuffer::Depth))
                .read()
                .wait()
                .unwrap();
            for encoded in [encoded, by_bands] {
                assert_eq!(encoded.views[0].depth.is_some(), g_buffer == GBuffer::Depth);
                assert_shows(&gpu, &encoded.views[0], &pair.left, &format!("{method} left"));
                assert_shows(&gpu, &encoded.views[1], &pair.right, &format!("{method} right"));
                assert_eq!(read(&gpu, &encoded.unfinished), [0; 4], "{method}");
            }
        }
    }
}

/// Filtering on the device rounds samples to f16, so a byte may differ by 1 from the host's.
#[test]
fn samples_are_filtered_on_the_device_as_for_files() {
    let gpu = gpu();
    let mut renderer = Renderer::new(gpu.clone());
    let scene = renderer.upload(&random_stage(4)).wait().unwrap();
    let plain = || Options::new(Method::BRACKET).g_buffer(GBuffer::None);
    for (size, options) in [
        ([61, 43], plain().samples(4)),
        ([61, 43], plain().samples(9).filter(Filter::Tent).jitter(false).exposure(1.0)),
        ([40, 131], plain().samples(16).filter(Filter::Gauss).seed(5).tone(Tone::Filmic)),
        ([1100, 131], plain().samples(4).filter(Filter::Tent)), // three bands on a CPU adapter
    ] {
        let camera = camera().size(size[0], size[1]);
        let rig = Rig::pair(camera);
        let pair = renderer.pair(&scene, &camera).options(&options).read().wait().unwrap();
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let encoded = renderer.views(&scene, &rig).options(&options).encode(&mut encoder).wait().unwrap();
        let (by_bands, commands) = renderer.views(&scene, &rig).options(&options).encode_bands().wait().unwrap();
        gpu.queue().submit([encoder.finish()]);
        gpu.queue().submit(commands);
        for encoded in [encoded, by_bands] {
            for (view, expected) in encoded.views.iter().zip([&pair.left, &pair.right]) {
                let found = texels(&gpu, &view.color);
                assert_eq!(found.len(), expected.rgba8.len());
                let channels = found.as_flattened().iter().zip(expected.rgba8.as_flattened());
                let off: Vec<u8> = channels.map(|(a, b)| a.abs_diff(*b)).collect();
                let differing = off.iter().filter(|&&by| by > 0).count();
                println!("{size:?}, {} samples: {differing} of {} bytes differ", options.samples, off.len());
                assert!(off.iter().all(|&by| by <= 1), "{size:?} {:?}", off.iter().max());
                assert!(differing * 50 < off.len(), "{differing} of {}", off.len());
            }
            assert_eq!(read(&gpu, &encoded.unfinished), [0; 4]);
        }
    }
}

#[test]
fn pictures_of_both_eyes_on_the_device_are_those_for_files() {
    let gpu = gpu();
    let mut renderer = Renderer::new(gpu.clone());
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    let camera = camera().size(61, 43);
    let options = Options::new(Method::BRACKET).g_buffer(GBuffer::None);
    let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
    let anaglyphs = Anaglyph::ALL.iter().map(|&kind| (Combination::Anaglyph(kind), 1));
    let packings = Packing::ALL.iter().map(|&packing| {
        let mixes = matches!(packing, Packing::HalfSideBySide | Packing::HalfTopBottom);
        (Combination::Packed(packing), u8::from(mixes))
    });
    for (how, most) in anaglyphs.chain(packings) {
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let rig = Rig::pair(camera);
        let encoded = renderer.views(&uploaded, &rig).options(&options).encode(&mut encoder).wait().unwrap();
        let [left, right] = &encoded.views[..] else { unreachable!("two eyes") };
        let picture = renderer.encode_combined(how, [&left.color, &right.color], &mut encoder).wait().unwrap();
        gpu.queue().submit([encoder.finish()]);
        let expected = how.picture(&pair.left, &pair.right);
        assert_eq!([picture.width(), picture.height()], [expected.width, expected.height], "{how:?}");
        let found = texels(&gpu, &picture).into_flattened();
        let apart = found.iter().zip(expected.rgba8.as_flattened()).map(|(a, b)| a.abs_diff(*b));
        let apart = Vec::from_iter(apart);
        let differing = apart.iter().filter(|&&apart| apart > 0).count();
        println!("{how:?}: {differing} of {} bytes differ", apart.len());
        assert!(apart.iter().all(|&apart| apart <= most) && differing * 100 <= apart.len(), "{how:?} {differing}");
    }
    let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let mut encoded = |size: [u32; 2]| {
        let rig = Rig::pair(camera.size(size[0], size[1]));
        renderer.views(&uploaded, &rig).options(&options).encode(&mut encoder).wait().unwrap()
    };
    let [small, large] = [encoded([60, 43]), encoded([61, 43])];
    let how = Combination::Packed(Packing::SideBySide);
    let refused = renderer.encode_combined(how, [&small.views[0].color, &large.views[1].color], &mut encoder).wait();
    assert!(matches!(refused, Err(Error::Sizes { .. })), "{refused:?}");
}

/// The scene has nothing to hit. But its light is computed in several parts, and each part needs uniforms in each band.
#[test]
fn a_sky_alone_is_encoded_whole_in_every_band() {
    let gpu = gpu();
    let mut renderer = Renderer::new(gpu.clone());
    let mut scene = Scene::new();
    scene.sky = Sky::Constant(Vec3::new(0.2, 0.5, 0.9));
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let camera = camera().size(300, 260);
    let options =
        Options::new(Method::Naive).g_buffer(GBuffer::Depth).ambient_occlusion(AmbientOcclusion::new(32, 1.0));
    let (encoded, commands) =
        renderer.views(&uploaded, &Rig::pair(camera)).options(&options).encode_bands().wait().unwrap();
    assert!(!has_small_bands(&gpu) || commands.len() > 1, "{}", commands.len());
    gpu.queue().submit(commands);
    let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
    assert!(pair.left.rgba8.iter().all(|pixel| *pixel == pair.left.rgba8[0]));
    assert_shows(&gpu, &encoded.views[0], &pair.left, "left");
    assert_shows(&gpu, &encoded.views[1], &pair.right, "right");
}

#[test]
fn equirectangular_views_are_encoded_too() {
    let gpu = gpu();
    let mut renderer = Renderer::new(gpu.clone());
    let uploaded = renderer.upload(&Builtin::Hall.scene()).wait().unwrap();
    let projection = Projection::Equirectangular(Equirectangular::new(Span::Full));
    let camera = Builtin::Hall.camera(128, 64).interaxial(0.2).projection(projection);
    for method in [Method::BRACKET, Method::ATOMIC] {
        let options = Options::new(method).g_buffer(GBuffer::Depth);
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let encoded = renderer.pair(&uploaded, &camera).options(&options).encode(&mut encoder).wait().unwrap();
        gpu.queue().submit([encoder.finish()]);
        let pair = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap();
        for (encoded, view) in encoded.views.iter().zip([&pair.left, &pair.right]) {
            assert_shows(&gpu, encoded, view, &method.to_string());
        }
        assert_eq!(read(&gpu, &encoded.unfinished), [0; 4], "{method}");
    }
}

#[test]
fn what_cannot_be_encoded_is_refused_by_name() {
    let gpu = gpu();
    let mut renderer = Renderer::new(gpu.clone());
    let uploaded = renderer.upload(&random_stage(4)).wait().unwrap();
    let mut refused = |camera: StereoCamera, options: Options| {
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer
            .views(&uploaded, &Rig::pair(camera))
            .options(&options)
            .encode(&mut encoder)
            .wait()
            .unwrap_err()
            .to_string()
    };
    let small = camera().size(64, 48);
    for method in ["buffer", "buffer-8", "adelson-hodges"] {
        let message = refused(small, Options::new(method.parse().unwrap()));
        assert!(
            message.starts_with(&format!("{method} can't be encoded in advance: a part of it runs on the host")),
            "{message}"
        );
    }
    let naive = Options::new(Method::Naive);
    assert!(refused(small, naive.clone().linear(true)).starts_with("linear colour can't be"));
    assert!(refused(small, naive.clone().cost_map(true)).starts_with("a cost map can't be"));
    let side = gpu.device().limits().max_texture_dimension_2d;
    let message = refused(camera().size(8, side + 1), naive);
    assert!(message.contains("max_texture_dimension_2d") && message.contains("FrameBuilder::rows"), "{message}");
}
