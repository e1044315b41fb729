//! Tests devices: lost devices, devices of the caller, and devices whose limits a scene or a picture exceeds.

use stereotrace::{
    Error, Fetch, Gpu, Lighting, Method, Options, RaysPerLane, Renderer, Traversal, blocking::Wait,
    scene::builtin::Builtin, wgpu,
};

use super::{
    SIZE,
    common::{gpu_with_limits, own_gpu, renderer},
    render_builtin,
};

#[test]
fn a_destroyed_device_is_an_error_and_no_panic() {
    let mut renderer = Renderer::new(own_gpu());
    let scene = Builtin::Spheres.scene();
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let camera = Builtin::Spheres.camera(32, 32);
    renderer.pair(&uploaded, &camera).read().wait().unwrap();
    renderer.gpu().device().destroy();
    let error = renderer.pair(&uploaded, &camera).read().wait().unwrap_err();
    assert!(matches!(error, Error::DeviceLost(_)), "{error}");
    let error = renderer.upload(&scene).wait().unwrap_err();
    assert!(matches!(error, Error::DeviceLost(_)), "{error}");
}

#[test]
fn a_device_of_the_caller_with_webgpu_s_default_limits_renders_the_same() {
    let mut theirs = Renderer::new(gpu_with_limits(wgpu::Limits::default()));
    let scene = Builtin::Hall.scene();
    let uploaded = theirs.upload(&scene).wait().unwrap();
    let camera = Builtin::Hall.camera(SIZE.0, SIZE.1);
    let pair =
        theirs.pair(&uploaded, &camera).options(&Options::new(Method::BUFFER).linear(true)).read().wait().unwrap();
    assert!(pair.statistics.times.is_none(), "timestamps were not asked for");
    assert_eq!(pair.right, render_builtin(Builtin::Hall, Method::BUFFER).right);
    theirs.gpu().device().destroy();
    let error = theirs.pair(&uploaded, &camera).read().wait().unwrap_err();
    assert!(matches!(error, Error::DeviceLost(_)), "{error}");
    let error = Renderer::new(theirs.gpu().clone()).upload(&scene).wait().unwrap_err();
    assert!(matches!(error, Error::DeviceLost(_)), "{error}");
}

#[test]
fn a_picture_over_the_device_s_limits_is_an_error_that_names_the_limit() {
    let mut small = Renderer::with_traversal(limited(1 << 20, 8192), Traversal::of(&own_gpu()));
    let uploaded = small.upload(&Builtin::Spheres.scene()).wait().unwrap();
    let mut refused = |width, height, method| {
        let camera = Builtin::Hall.camera(width, height);
        small.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap_err().to_string()
    };
    let message = refused(60_000, 60_000, Method::Naive);
    assert!(
        message.starts_with("2 views of 60000x60000 needs ") && message.contains("FrameBuilder::rows"),
        "{message}"
    );
    let message = refused(2000, 64, Method::Naive);
    assert!(message.starts_with("a picture 2000 pixels wide needs 2 MiB"), "{message}");
    assert!(message.contains("max_storage_buffer_binding_size is 1 MiB"), "{message}");
    let mut renderer = Renderer::with_traversal(limited(1 << 27, 8192), Traversal::of(&own_gpu()));
    let uploaded = renderer.upload(&Builtin::Spheres.scene()).wait().unwrap();
    let (camera, options) = (Builtin::Hall.camera(8193, 1024), Options::new(Method::BRACKET));
    let message = renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap_err().to_string();
    assert!(message.starts_with("a picture 8193 pixels wide by bracket needs a texture of 8193x"), "{message}");
    assert!(message.contains("max_texture_dimension_2d is 8192"), "{message}");
}

/// Paths take 64 bytes per pixel and light in parts takes 80, so a band of the usual size would need 12 MiB.
#[test]
fn bands_of_paths_have_as_many_rows_as_the_device_can_bind() {
    let camera = Builtin::Near.camera(600, 260);
    let options = Options::new(Method::BRACKET).lighting(Lighting::Paths { bounces: 1, samples: 2 }).denoise(true);
    let [small, usual] = [limited(5 << 20, 8192), own_gpu()].map(|gpu| {
        let mut renderer = Renderer::new(gpu);
        let uploaded = renderer.upload(&Builtin::Near.scene()).wait().unwrap();
        renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap()
    });
    assert!(small.left.rgba8 == usual.left.rgba8);
    assert!(small.statistics.intermediate_bytes < usual.statistics.intermediate_bytes);
}

#[test]
fn a_scene_uploaded_to_another_device_is_refused() {
    let other = Renderer::new(own_gpu());
    let theirs = other.upload(&Builtin::Spheres.scene()).wait().unwrap();
    let camera = Builtin::Spheres.camera(32, 32);
    let error = renderer().pair(&theirs, &camera).read().wait().unwrap_err();
    assert!(matches!(error, Error::ForeignScene), "{error}");
}

/// Opens a device of the tests' adapter with lower limits.
fn limited(bytes: u64, side: u32) -> Gpu {
    let mut limits = own_gpu().device().limits();
    limits.max_storage_buffer_binding_size = bytes;
    limits.max_texture_dimension_2d = side;
    limits.max_texture_dimension_1d = limits.max_texture_dimension_1d.min(side);
    gpu_with_limits(limits)
}

#[test]
fn a_scene_over_one_limit_is_read_the_other_way_and_over_both_refused_with_the_count_that_fits() {
    // The hall's primitives take 12 MiB.
    let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(33, 20));
    let buffers = Traversal::of(&own_gpu()).fetch(Fetch::Buffer).rays(RaysPerLane::One);
    let whole = {
        let mut renderer = Renderer::with_traversal(own_gpu(), buffers);
        let uploaded = renderer.upload(&scene).wait().unwrap();
        assert_eq!(uploaded.traversal(), buffers);
        renderer.pair(&uploaded, &camera).options(&Options::new(Method::ATOMIC)).read().wait().unwrap()
    };
    let mut small = Renderer::with_traversal(limited(1 << 20, 8192), buffers);
    let uploaded = small.upload(&scene).wait().unwrap();
    assert_eq!(uploaded.traversal().fetch, Fetch::Texture);
    let pair = small.pair(&uploaded, &camera).options(&Options::new(Method::ATOMIC)).read().wait().unwrap();
    assert_eq!(pair.right.primitive, whole.right.primitive);

    let tiny = Renderer::with_traversal(limited(1 << 20, 2048), buffers);
    let error = tiny.upload(&scene).wait().unwrap_err();
    let message = error.to_string();
    assert!(matches!(error, Error::Limit { limit: "max_storage_buffer_binding_size", .. }), "{message}");
    // 1 MiB holds 65,536 texels. A primitive with normals takes four, and its share of the nodes takes one or a half.
    assert!(message.starts_with(&format!("a scene of {} primitives needs ", scene.primitive_count())), "{message}");
    let fits =
        message.split_once("enough for 65536, about ").and_then(|(_, rest)| rest.split(' ').next()?.parse().ok());
    assert!(fits.is_some_and(|fits: u32| (13_000..15_000).contains(&fits)), "{message}");

    // The sky takes 2 MiB.
    let mut scene = Builtin::Near.scene();
    scene.sky = stereotrace::Sky::Map(stereotrace::SkyMap::procedural(512).unwrap());
    assert_eq!(small.upload(&scene).wait().unwrap().traversal().fetch, Fetch::Texture);
    let message = tiny.upload(&scene).wait().unwrap_err().to_string();
    assert!(message.starts_with("the scene's table of lights, materials, sky and textures needs 131"), "{message}");
    assert!(message.ends_with("enough for 65536; use smaller or fewer pictures"), "{message}");
}

/// `bracket` keeps a texture as wide as the picture. WebGPU guarantees 8192 pixels.
#[test]
fn auto_traces_both_views_of_pictures_that_are_too_wide_for_bracket() {
    let mut renderer = Renderer::new(gpu_with_limits(wgpu::Limits::default()));
    let uploaded = renderer.upload(&Builtin::Near.scene()).wait().unwrap();
    let camera = Builtin::Near.camera(8200, 1).vertical_fov_degrees(0.005);
    let mut pair = |method| renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait();
    let refused = pair(Method::BRACKET).unwrap_err().to_string();
    assert!(refused.contains("8192"), "{refused}");
    let (found, naive) = (pair(Method::Auto).unwrap(), pair(Method::Naive).unwrap());
    assert!(found.right == naive.right && found.statistics.method == Method::Naive);
}
