//! Compares pictures with stored pictures, in addition to all tests against independent references.
//!
//! To renew the stored pictures, run `STEREOTRACE_RENEW_GOLDEN=1 cargo test --test it golden`, and look at them.

use crate::common;

use common::{render, renderer};
use stereotrace::{
    Adaptive, AmbientOcclusion, Filter, Light, Method, Options, Tone,
    blocking::Wait,
    output::{Anaglyph, Picture},
    scene::builtin::Builtin,
    wgpu,
};

/// Maximum difference of a channel that is ignored, since other adapters round differently.
const TOLERANCE: u8 = 3;

/// Returns how many pixels of `total` may differ by more. Software adapters differ little: 2 of 20,736 pixels on
/// llvmpipe's Vulkan, its OpenGL and `SwiftShader`. Five times as many are allowed. On GPUs single pixels at edges may
/// differ, and half a percent is allowed.
fn allowed(total: usize) -> usize {
    match renderer().gpu().adapter_info().device_type {
        wgpu::DeviceType::Cpu => total / 2000,
        _ => total / 200,
    }
}

/// Returns the number of pixels with a channel that differs by more than [`TOLERANCE`].
fn differing(a: &[[u8; 4]], b: &[[u8; 4]]) -> usize {
    assert_eq!(a.len(), b.len());
    let differs = |(a, b): &(&[u8; 4], &[u8; 4])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > TOLERANCE);
    a.iter().zip(b).filter(differs).count()
}

/// Returns the difference of two pictures, 16 times as bright.
fn amplified(a: &[[u8; 4]], b: &[[u8; 4]]) -> Vec<[u8; 4]> {
    let channel = |a: u8, b: u8| a.abs_diff(b).saturating_mul(16);
    a.iter().zip(b).map(|(a, b)| [channel(a[0], b[0]), channel(a[1], b[1]), channel(a[2], b[2]), 255]).collect()
}

fn check(name: &str, picture: &Picture) {
    let path = format!("{}/tests/it/golden/{name}.png", env!("CARGO_MANIFEST_DIR"));
    if std::env::var_os("STEREOTRACE_RENEW_GOLDEN").is_some() {
        picture.save_png(&path).unwrap();
        return;
    }
    let stored = image::open(&path).unwrap_or_else(|error| panic!("{path}: {error}")).to_rgba8();
    assert_eq!(stored.dimensions(), (picture.width, picture.height));
    let stored: Vec<[u8; 4]> = stored.pixels().map(|pixel| pixel.0).collect();
    let differing = differing(&stored, &picture.rgba8);
    if differing > allowed(stored.len()) {
        let file = |what: &str| std::env::temp_dir().join(format!("stereotrace-golden-{name}{what}.png"));
        let (found, difference) = (file(""), file("-difference"));
        picture.save_png(&found).unwrap();
        Picture::new(picture.width, picture.height, amplified(&stored, &picture.rgba8)).save_png(&difference).unwrap();
        let total = stored.len();
        panic!(
            "{differing} of {total} pixels differ from {path}. The rendered picture is {}, the difference {}. If it is \
             right, renew with STEREOTRACE_RENEW_GOLDEN=1",
            found.display(),
            difference.display()
        );
    }
}

#[test]
fn the_hall_s_anaglyph_and_map_are_as_stored() {
    let pair = render(&Builtin::Hall.scene(), &Builtin::Hall.camera(192, 108), Method::ATOMIC);
    check("hall_anaglyph", &pair.anaglyph(Anaglyph::Dubois));
    check("hall_map", &pair.retrace_picture());
}

#[test]
fn the_hall_s_right_view_by_the_default_method_is_as_stored() {
    let mut renderer = renderer();
    let uploaded = renderer.upload(&Builtin::Hall.scene()).wait().unwrap();
    let pair = renderer.pair(&uploaded, &Builtin::Hall.camera(192, 108)).read().wait().unwrap();
    drop(renderer); // `check` takes this renderer
    // With five lights, bracket is cheaper than naive on software adapters and on GPUs.
    assert_eq!(pair.statistics.method, Method::BRACKET);
    check("hall_default", &pair.right.picture());
}

#[test]
fn the_spheres_right_view_is_as_stored() {
    let pair = render(&Builtin::Spheres.scene(), &Builtin::Spheres.camera(120, 90), Method::Naive);
    check("spheres_right", &pair.right.picture());
}

/// Soft light, ambient occlusion, mirrors, glass, textures and several samples per pixel, reused by the right view.
#[test]
fn right_views_with_every_feature_are_as_stored() {
    let options = Options::new(Method::BRACKET).shadow_rays(8).samples(4).filter(Filter::Tent);
    let soft = |builtin: Builtin, radius: f32| {
        let mut scene = builtin.scene();
        for light in &mut scene.lights {
            *light = Light::sphere(light.position, radius, light.intensity);
        }
        scene
    };
    let sky = Options::new(Method::BRACKET).sky_rays(16).tone(Tone::Filmic).adaptive(Adaptive::new(3, 8.0));
    for (name, scene, builtin, options) in [
        ("finished_soft", soft(Builtin::HallFinished, 0.2), Builtin::HallFinished, &options),
        ("textured_mirrors_sky", Builtin::ThreeSpheresTextured.scene(), Builtin::ThreeSpheresTextured, &sky),
        (
            "occlusion",
            Builtin::Near.scene(),
            Builtin::Near,
            &options.clone().ambient_occlusion(AmbientOcclusion::new(16, 1.0)),
        ),
    ] {
        let mut renderer = renderer();
        let uploaded = renderer.upload(&scene).wait().unwrap();
        let pair = renderer.pair(&uploaded, &builtin.camera(128, 72)).options(options).read().wait().unwrap();
        drop(renderer); // `check` takes this renderer
        check(name, &pair.right.picture());
    }
}

#[test]
fn the_comparison_sees_a_single_changed_channel() {
    let grey = vec![[100, 100, 100, 255]; 10];
    let mut changed = grey.clone();
    changed[3][1] += TOLERANCE;
    assert_eq!(differing(&grey, &changed), 0);
    changed[3][1] += 1;
    assert_eq!(differing(&grey, &changed), 1);
}
