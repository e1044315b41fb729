//! Tests the limits that a device must have. A device below a limit is refused, and the error names the limit. A device
//! at the limit renders everything.

use crate::common;

use common::{device, gpu};
use stereotrace::{
    Error, Fetch, Finish, Gpu, Material, Mesh, Method, Options, Renderer, Scene, Sky, StereoCamera, Traversal,
    blocking::Wait, glam::Vec3, scene::builtin::Builtin, wgpu,
};

/// Name of a limit, and access to its value.
type Limit = (&'static str, fn(&mut wgpu::Limits) -> &mut u32);

const CHECKED: [Limit; 12] = [
    ("max_bind_groups", |limits| &mut limits.max_bind_groups),
    ("max_bindings_per_bind_group", |limits| &mut limits.max_bindings_per_bind_group),
    ("max_storage_buffers_per_shader_stage", |limits| &mut limits.max_storage_buffers_per_shader_stage),
    ("max_storage_textures_per_shader_stage", |limits| &mut limits.max_storage_textures_per_shader_stage),
    ("max_uniform_buffers_per_shader_stage", |limits| &mut limits.max_uniform_buffers_per_shader_stage),
    ("max_buffers_and_acceleration_structures_per_shader_stage", |limits| {
        &mut limits.max_buffers_and_acceleration_structures_per_shader_stage
    }),
    ("max_compute_invocations_per_workgroup", |limits| &mut limits.max_compute_invocations_per_workgroup),
    ("max_compute_workgroup_storage_size", |limits| &mut limits.max_compute_workgroup_storage_size),
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

/// The picture consists of mirrors, so the list of pixels with mirrors takes more workgroups than a row of a dispatch
/// may have.
#[test]
fn lists_of_wide_pictures_are_traced_to_their_ends() {
    let mut scene = Scene::new();
    let mirror = Material::new(Vec3::ZERO).specular(Vec3::ONE).finish(Finish::Mirror { fresnel: false });
    let id = scene.add_material(mirror);
    let corners = [Vec3::new(-9e3, -9e3, -5.0), Vec3::new(9e3, -9e3, -5.0), Vec3::new(0.0, 9e3, -5.0)];
    scene.add_mesh(&Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).materials(vec![id])).unwrap();
    scene.sky = Sky::Constant(Vec3::splat(0.5));
    let (device, queue) = device(Gpu::required_limits());
    let mut renderer = Renderer::new(Gpu::from_device(device, queue).unwrap());
    let uploaded = renderer.upload(&scene).wait().unwrap();
    let camera = StereoCamera::look_at(Vec3::ZERO, -Vec3::Z).size(16_500, 64).vertical_fov_degrees(0.1).interaxial(0.0);
    let pair = renderer.pair(&uploaded, &camera).options(&Options::new(Method::Naive)).read().wait().unwrap();
    assert_eq!(pair.statistics.left.rays.secondary, 16_500 * 64);
    assert!(pair.left.rgba8.iter().all(|color| *color == pair.left.rgba8[0] && color[0] > 100));
}
