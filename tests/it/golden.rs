//! Compares pictures with stored pictures, in addition to all tests against independent references.
//!
//! To renew the stored pictures, run `STEREOTRACE_RENEW_GOLDEN=1 cargo test --test golden`, and look at them.

use crate::common;

use common::{render, renderer};
use stereotrace::{
    Method,
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
        let found = std::env::temp_dir().join(format!("stereotrace-golden-{name}.png"));
        picture.save_png(&found).unwrap();
        let total = stored.len();
        panic!(
            "{differing} of {total} pixels differ from {path}; what was rendered is in {}. If it is right, renew with \
             STEREOTRACE_RENEW_GOLDEN=1",
            found.display()
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

#[test]
fn the_comparison_sees_a_single_changed_channel() {
    let grey = vec![[100, 100, 100, 255]; 10];
    let mut changed = grey.clone();
    changed[3][1] += TOLERANCE;
    assert_eq!(differing(&grey, &changed), 0);
    changed[3][1] += 1;
    assert_eq!(differing(&grey, &changed), 1);
}
