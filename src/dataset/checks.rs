//! Reasons for which a pair is rejected, by its left view.

use super::spec::Checks;
use crate::{MISS, StereoPair};

/// Largest encoded value of a black pixel's channels, and smallest one of a white pixel's.
const BLACK: u8 = 6;
const WHITE: u8 = 252;
/// Largest difference of a channel between pixels that look alike.
const ALIKE: u8 = 1;
/// Depth in interaxials within which surfaces are too near to be matched.
const NEAR: f32 = 4.0;

/// Returns why a pair is rejected, or `None` for a good one.
pub(super) fn fault(pair: &StereoPair, limits: &Checks) -> Option<String> {
    let view = &pair.left;
    let share = |count: usize| count as f64 / view.depth.len() as f64;
    let pixels = || view.rgba8.iter().zip(&view.depth);
    let surfaces = pixels().filter(|(_, depth)| depth.is_finite()).count();
    if surfaces == 0 {
        return Some("it shows no surface".into());
    }
    let near = NEAR * pair.pose.interaxial;
    let dark = view.rgba8.iter().filter(|[r, g, b, _]| *r.max(g).max(b) <= BLACK).count();
    let bright = pixels().filter(|([r, g, b, _], depth)| *r.min(g).min(b) >= WHITE && depth.is_finite()).count();
    for (what, found, most) in [
        ("sky", share(view.depth.len() - surfaces), limits.max_sky),
        ("black", share(dark), limits.max_dark),
        ("burnt out", share(bright), limits.max_bright),
        (
            "nearer than four interaxials",
            share(view.depth.iter().filter(|depth| **depth < near).count()),
            limits.max_near,
        ),
    ] {
        if found > most {
            return Some(format!("{:.0}% of it is {what}, over {:.0}%", 100.0 * found, 100.0 * most));
        }
    }
    let plain = share(plainest(&view.rgba8, &view.object, pair.pose.size[0] as usize));
    let reason =
        || format!("{:.0}% of it is one object without texture, over {:.0}%", 100.0 * plain, 100.0 * limits.max_plain);
    (plain > limits.max_plain).then(reason)
}

/// Returns the largest number of an object's pixels that look like their right and lower neighbours.
fn plainest(colors: &[[u8; 4]], objects: &[u32], width: usize) -> usize {
    let mut counts = std::collections::HashMap::<u32, usize>::new();
    let alike = |one: [u8; 4], other: [u8; 4]| one.iter().zip(other).all(|(a, b)| a.abs_diff(b) <= ALIKE);
    for (place, &object) in objects.iter().enumerate().filter(|(_, object)| **object != MISS) {
        let right = if place % width + 1 < width { place + 1 } else { place };
        let below = if place + width < objects.len() { place + width } else { place };
        if [right, below].iter().all(|&next| objects[next] == object && alike(colors[place], colors[next])) {
            *counts.entry(object).or_default() += 1;
        }
    }
    counts.into_values().max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plainest_object_is_counted_by_pixels_like_their_neighbours() {
        // Two rows of four pixels: a plain object of six pixels, and another one of two.
        let grey = [100, 100, 100, 255];
        let colors = [grey, grey, grey, [9, 9, 9, 255], grey, grey, grey, [9, 9, 9, 255]];
        let objects = [0, 0, 0, 1, 0, 0, 0, 1];
        // The third column's pixels have another object on their right.
        assert_eq!(plainest(&colors, &objects, 4), 4);
        let striped = colors.map(|color| if color == grey { [100, 103, 100, 255] } else { color });
        let mut striped = striped;
        striped[1] = grey;
        striped[5] = grey;
        assert_eq!(plainest(&striped, &objects, 4), 2, "stripes are no plain surface; the narrow object is");
        assert_eq!(plainest(&colors, &[MISS; 8], 4), 0);
    }
}
