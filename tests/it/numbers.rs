//! Tests numbers from which no picture, scene or ray can be made. They are refused, and the error names the field.

use crate::common;

use std::{f32::consts::PI, num::NonZeroU32, panic::catch_unwind};

use common::renderer;
use stereotrace::{
    BufferDepth, Check, Error, Light, MISS, MaterialId, Mesh, Method, Options, Ray, Scene, SkyMap, Sphere,
    StereoCamera,
    blocking::Wait,
    camera::MAX_SIDE,
    glam::Vec3,
    output::{save_ids_pfm, save_pfm},
    scene::{
        MAX_LIGHTS,
        builtin::{Builtin, spheres_turned},
    },
    testing::suite::Trial,
};

/// Typical and extreme results of a caller's arithmetic.
const NUMBERS: [f32; 16] = [
    0.0,
    -0.0,
    f32::MIN_POSITIVE,
    1e-45,
    1e-20,
    -1.0,
    1.0,
    PI,
    180.0,
    1e8,
    1e20,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

#[test]
fn any_number_makes_a_camera_a_picture_or_an_error_that_names_the_field() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Near.scene()).wait().unwrap();
    let setters: [fn(StereoCamera, f32) -> StereoCamera; 8] = [
        |camera, number| camera.eye(Vec3::new(number, 0.0, 1.0)),
        |camera, number| camera.target(Vec3::new(0.0, number, 0.0)),
        |camera, number| camera.up(Vec3::new(number, number, 0.0)),
        StereoCamera::vertical_fov_degrees,
        StereoCamera::screen_width,
        StereoCamera::screen_distance,
        StereoCamera::interaxial,
        StereoCamera::interaxial_pixels,
    ];
    let base = Builtin::Near.camera(9, 7);
    let bounds =
        |number: f32| StereoCamera::fitting((Vec3::splat(-number).as_dvec3(), Vec3::splat(number).as_dvec3()), 9, 7);
    let cameras = setters.iter().flat_map(|set| NUMBERS.map(|number| set(base, number))).chain(NUMBERS.map(bounds));
    let mut refused = 0;
    for camera in cameras {
        match renderer.pair(&uploaded, &camera).read().wait() {
            Ok(pair) => assert_eq!(pair.right.rgba8.len(), 63, "{camera:?}"),
            Err(Error::Camera { .. }) => refused += 1,
            Err(error) => panic!("{camera:?}: {error}"),
        }
    }
    assert!(refused > 30, "{refused}");
}

#[test]
fn any_size_makes_a_picture_or_an_error() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Near.scene()).wait().unwrap();
    let sides = [0, 1, 2, 65_536, MAX_SIDE, MAX_SIDE + 1, u32::MAX - 6, u32::MAX];
    for (width, height) in sides.iter().flat_map(|&width| sides.map(|height| (width, height))) {
        let valid = width.min(height) > 0 && width.max(height) <= MAX_SIDE;
        assert_eq!(
            StereoCamera::fitting((Vec3::ZERO.as_dvec3(), Vec3::ONE.as_dvec3()), width, height).pose().is_ok(),
            valid
        );
        for camera in [Builtin::Near.camera(width, height), Trial::Wires.camera(width, height)] {
            // The camera of the wires has a screen of fixed width. At some sizes its pixels are too narrow or the
            // screen is too high.
            if let Err(error) = camera.pose() {
                assert!(!valid || error.to_string().contains("screen_width is"), "{error}");
                assert!(error.to_string().contains(&format!("{width}x{height}")), "{error}");
            }
            // Pictures that need at most 16 GiB for their colours are skipped, since some adapter may accept them.
            if valid && u64::from(width) * u64::from(height) <= 1 << 30 {
                continue;
            }
            for method in [Method::Naive, Method::default(), Method::BUFFER, Method::ES_ISLER] {
                for options in [Options::new(method), Options::new(method).cost_map(true)] {
                    let error =
                        renderer.pair(&uploaded, &camera).options(&options).read().wait().unwrap_err().to_string();
                    assert!(error.contains(&format!("{width}x{height}")), "{error}");
                }
            }
        }
    }
}

#[test]
fn numbers_that_make_no_scene_are_refused_by_name() {
    for angle in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let message = spheres_turned(angle).unwrap_err().to_string();
        assert!(message.contains(&angle.to_string()), "{message}");
    }
    for angle in NUMBERS.into_iter().filter(|angle| angle.is_finite()) {
        spheres_turned(angle).unwrap();
    }
    for width in [0, 1, 3, 100_000, u32::MAX] {
        assert!(SkyMap::procedural(width).is_err(), "{width}");
        assert!(SkyMap::new(width, u32::MAX, Vec::new()).is_err(), "{width}");
    }
    let mut scene = Scene::new();
    for number in NUMBERS {
        let sphere = Sphere::new(Vec3::splat(number), 1.0, MaterialId(0));
        assert_eq!(scene.add_sphere(sphere).is_ok(), number.abs() <= 1e8, "{number}");
        let sphere = Sphere::new(Vec3::ZERO, number, MaterialId(0));
        assert_eq!(scene.add_sphere(sphere).is_ok(), number > 0.0 && number <= 1e8, "{number}");
        let mesh = Mesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::splat(number)], vec![[0, 1, 2]]);
        assert_eq!(scene.add_mesh(&mesh).is_ok(), number.abs() <= 1e8, "{number}");
    }
    let unknown = Sphere::new(Vec3::ZERO, 1.0, MaterialId(u32::MAX));
    assert!(scene.add_sphere(unknown).unwrap_err().to_string().contains("no material 4294967295; the scene has 1"));
    assert!(scene.add_mesh(&Mesh::new(vec![Vec3::ZERO], vec![[0, 0, u32::MAX]])).is_err());
    scene.add_mesh(&Mesh::new(Vec::new(), Vec::new())).unwrap();
    assert_eq!((scene.object_of(MISS), scene.object_name(MISS)), (MISS, ""));
}

#[test]
fn more_lights_than_a_scene_can_have_are_refused() {
    let camera = Builtin::Near.camera(9, 7);
    let mut scene = Builtin::Near.scene();
    for count in [MAX_LIGHTS + 1, usize::MAX] {
        let message = scene.place_lights(count, &camera).unwrap_err().to_string();
        assert!(message.contains(&format!("lights: {count} lights; a scene can have at most 1048576")), "{message}");
    }
    assert_eq!(scene.lights.len(), 5, "a refused number changes nothing");
    scene.lights = vec![Light::point(Vec3::Y, Vec3::ZERO); MAX_LIGHTS + 1];
    assert!(renderer().upload(&scene).wait().unwrap_err().to_string().contains("1048577 lights"));
}

#[test]
fn any_number_makes_a_ray_an_answer_or_an_error() {
    let renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Near.scene()).wait().unwrap();
    for number in NUMBERS {
        let rays = [
            Ray::new(Vec3::ZERO, Vec3::new(number, 0.0, 0.0)),
            Ray::new(Vec3::ZERO, -Vec3::Z).t_min(number),
            Ray::new(Vec3::ZERO, -Vec3::Z).t_max(number),
        ];
        for ray in rays {
            match renderer.closest_hits(&uploaded, &[ray]).wait() {
                Ok(cast) => assert!(!cast.hits[0].t.is_nan(), "{ray:?}"),
                Err(error) => assert!(matches!(error, Error::Ray { .. }), "{error}"),
            }
        }
        let error = renderer.any_hits(&uploaded, &[Ray::new(Vec3::splat(number), -Vec3::Z)]).wait().err();
        assert_eq!(error.is_some(), !number.is_finite(), "{number}");
    }
}

#[test]
fn any_depth_of_the_buffer_renders() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Near.scene()).wait().unwrap();
    for slots in [1, 2, u32::MAX] {
        let depth = BufferDepth::Fixed(NonZeroU32::new(slots).unwrap());
        let options = Options::new(Method::Buffer(depth, Check::All));
        let pair = renderer.pair(&uploaded, &Builtin::Near.camera(9, 7)).options(&options).read().wait().unwrap();
        assert_eq!(pair.statistics.buffer_depth, slots.min(9));
    }
}

#[test]
fn pictures_of_another_size_than_said_are_refused() {
    let path = std::env::temp_dir().join(format!("stereotrace_{}_none.pfm", std::process::id()));
    for (width, height) in [(0, 1), (1, 0), (2, 2), (u32::MAX, u32::MAX)] {
        assert!(save_pfm(&path, width, height, &[1.0]).is_err());
        assert!(save_ids_pfm(&path, width, height, &[1]).is_err());
        assert!(!path.exists());
    }
    let pair = common::render(&Builtin::Near.scene(), &Builtin::Near.camera(9, 7), Method::Naive);
    assert_eq!(pair.left.cost_picture(0), None);
    assert!(catch_unwind(|| pair.pose.comfort(0.0, f32::NAN, 0.0).warnings()).is_ok());
}
