//! Tests flicker, the stability benchmark's figure for a film.

#[path = "../benches/common/flicker.rs"]
#[allow(unreachable_pub, reason = "benchmarks share it")]
mod flicker;

use crate::flicker::Flicker;

/// Returns a frame of black pixels. At an `x`, the pixel differs by one step of red. At an `a`, it differs in alpha
/// only.
fn frame(pattern: &str) -> Vec<[u8; 4]> {
    let pixel = |mark| match mark {
        'x' => [1, 0, 0, 255],
        'a' => [0, 0, 0, 254],
        _ => [0, 0, 0, 255],
    };
    pattern.chars().map(pixel).collect()
}

fn flicker(patterns: &[&str]) -> Option<f64> {
    let mut flicker = Flicker::default();
    for pattern in patterns {
        flicker.add(&frame(pattern), &frame("...."));
    }
    flicker.percent()
}

#[test]
fn pixels_that_are_wrong_in_one_of_two_frames_flicker() {
    assert_eq!(flicker(&["....", "x..."]), Some(25.0));
    assert_eq!(flicker(&["xx..", "x.x."]), Some(50.0));
}

#[test]
fn errors_that_stay_and_alpha_do_not_flicker() {
    assert_eq!(flicker(&["....", "....", "...."]), Some(0.0));
    assert_eq!(flicker(&["xx..", "xx..", "xx.."]), Some(0.0));
    assert_eq!(flicker(&["....", "aa.."]), Some(0.0));
}

#[test]
fn the_figure_is_the_mean_of_all_frames_but_the_first() {
    assert_eq!(flicker(&["xxxx", "....", "x...", "x...", "...."]), Some((100.0 + 25.0 + 0.0 + 25.0) / 4.0));
    assert_eq!(flicker(&[]), None);
    assert_eq!(flicker(&["x..."]), None);
}

#[test]
fn an_error_is_against_the_truth_of_the_same_frame() {
    let mut flicker = Flicker::default();
    flicker.add(&frame("x..."), &frame("x..."));
    flicker.add(&frame("...."), &frame("...."));
    assert_eq!(flicker.percent(), Some(0.0));
    flicker.add(&frame("...."), &frame("...x"));
    assert_eq!(flicker.percent(), Some(12.5));
}
