//! Tests the limits that a device must have. A device below a limit is refused, and the error names the limit. A device
//! at the limit renders everything.

use crate::common;

use common::{device, gpu};
use stereotrace::{
    Error, Fetch, Gpu, Method, Options, Renderer, Traversal, blocking::Wait, scene::builtin::Builtin, wgpu,
};

/// Name of a limit, and access to its value.
type Limit = (&'static str, fn(&mut wgpu::Limits) -> &mut u32);

const CHECKED: [Limit; 11] = [
    ("max_bind_groups", |limits| &mut limits.max_bind_groups),
    ("max_bindings_per_bind_group", |limits| &mut limits.max_bindings_per_bind_group),
    ("max_storage_buffers_per_shader_stage", |limits| &mut limits.max_storage_buffers_per_shader_stage),
    ("max_storage_textures_per_shader_stage", |limits| &mut limits.max_storage_textures_per_shader_stage),
    ("max_uniform_buffers_per_shader_stage", |limits| &mut limits.max_uniform_buffers_per_shader_stage),
    ("max_buffers_and_acceleration_structures_per_shader_stage", |limits| {
        &mut limits.max_buffers_and_acceleration_structures_per_shader_stage
    }),
    ("max_compute_invocations_per_workgroup", |limits| &mut limits.max_compute_invocations_per_workgroup),
    ("max_compute_workgroup_size_x", |limits| &mut limits.max_compute_workgroup_size_x),
    ("max_compute_workgroup_size_y", |limits| &mut limits.max_compute_workgroup_size_y),
    ("max_compute_workgroup_size_z", |limits| &mut limits.max_compute_workgroup_size_z),
    ("max_compute_workgroups_per_dimension", |limits| &mut limits.max_compute_workgroups_per_dimension),
];

/// Returns the name of the limit because of which the device is refused.
fn refused(limits: wgpu::Limits) -> &'static str {
    let (device, queue) = device(limits);
    match Gpu::from_device(device, queue) {
        Err(error @ Error::Limit { limit, .. }) => {
            let message = error.to_string();
            assert!(message.starts_with("rendering needs ") && message.contains("Gpu::required_limits()"), "{message}");
            limit
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_device_below_a_limit_that_kernels_need_is_refused_by_the_limit_s_name() {
    for (name, place) in CHECKED {
        let mut limits = Gpu::required_limits();
        *place(&mut limits) -= 1;
        assert_eq!(refused(limits), name);
    }
    assert_eq!(refused(wgpu::Limits::downlevel_defaults()), "max_storage_buffers_per_shader_stage");
    let invocations = wgpu::Limits { max_compute_invocations_per_workgroup: 32, ..wgpu::Limits::default() };
    assert_eq!(refused(invocations), "max_compute_invocations_per_workgroup");
    refused(wgpu::Limits::downlevel_webgl2_defaults());
}

/// Checks that naive and the default method show the same pictures on a device with these limits, by both ways to read
/// a scene.
fn renders_the_same(limits: &wgpu::Limits) {
    let own = gpu();
    let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(49, 33));
    for fetch in [Fetch::Texture, Fetch::Buffer] {
        let (device, queue) = device(limits.clone());
        let theirs = Gpu::from_device(device, queue).unwrap();
        let traversal = Traversal::of(&own).fetch(fetch);
        let [expected, found] = [&own, &theirs].map(|gpu| {
            let mut renderer = Renderer::with_traversal(gpu.clone(), traversal);
            let uploaded = renderer.upload(&scene).wait().unwrap();
            assert_eq!(uploaded.traversal().fetch, fetch);
            let mut render =
                |method| renderer.pair(&uploaded, &camera).options(&Options::new(method)).read().wait().unwrap();
            [Method::Naive, Method::default(), Method::BRACKET].map(|method| {
                let pair = render(method);
                (pair.left, pair.right)
            })
        });
        assert!(found == expected, "{fetch:?}");
    }
}

#[test]
fn a_device_with_webgpu_s_default_limits_renders_by_either_fetch() {
    renders_the_same(&wgpu::Limits::default());
}

#[test]
fn a_device_with_no_more_than_the_required_limits_renders_by_either_fetch() {
    // Textures of scenes are 8192 texels wide.
    renders_the_same(&wgpu::Limits { max_texture_dimension_2d: 8192, ..Gpu::required_limits() });
}
