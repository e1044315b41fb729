//! Tests the position of a texture's colours, and the colours beyond its edges.

use stereotrace::{
    Texture, Wrap,
    glam::{DVec2, DVec3, Vec2, Vec3},
};

use super::{before, four_colors, left, noise, sampled, square, textured, worst};

const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
const SIZE: u32 = 96;

/// Returns the texture coordinates at a pixel of the square's picture.
fn uv_at(index: usize, low: f64, high: f64) -> DVec2 {
    let size = SIZE as usize;
    let share = DVec2::new((index % size) as f64 + 0.5, (size - 1 - index / size) as f64 + 0.5) / size as f64;
    low + (high - low) * share
}

#[test]
fn the_first_row_of_a_picture_is_at_the_top_and_its_first_column_on_the_left() {
    let found = left(&textured(square(Vec2::ZERO, Vec2::ONE), four_colors()), &before(SIZE));
    let at = |column: u32, row: u32| found[(row * SIZE + column) as usize];
    let (low, high) = (SIZE / 4, 3 * SIZE / 4);
    let corners = [at(low, low), at(high, low), at(low, high), at(high, high)];
    for (found, expected) in corners.into_iter().zip([DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 1.0, 0.0)]) {
        // The pixel's centre is half a pixel away from the quadrant's centre.
        assert!((found - expected).abs().max_element() < 0.05, "{found} is not {expected}");
    }
}

#[test]
fn pictures_are_as_by_formula_within_and_beyond_their_edges() {
    let mut errors = Vec::new();
    for (width, height) in [(2, 2), (5, 3), (1, 7), (16, 16)] {
        for wrap in WRAPS {
            let texture = noise(width, height, 5).wrap(wrap);
            let found = left(&textured(square(Vec2::NEG_ONE, Vec2::splat(3.0)), texture.clone()), &before(SIZE));
            let error = worst(&found, |index| Some(sampled(&texture, uv_at(index, -1.0, 3.0))));
            errors.push(error);
            // The measured error is 2.7e-4. A half float has 11 bits, so texels are off by up to 2.4e-4.
            assert!(error < 4e-4, "{width}x{height} {wrap:?}: {error}");
        }
    }
    println!("worst errors {errors:?}");
}

#[test]
fn squares_are_where_they_are_said_to_be_within_and_beyond_the_edges() {
    let [first, second] = [Vec3::new(0.9, 0.1, 0.2), Vec3::new(0.1, 0.6, 0.8)];
    // The squares also hold far away in texture coordinates, where f32 has few digits left.
    for (squares, low, high) in
        [(1, -1.0, 3.0), (2, -1.0, 3.0), (3, -1.0, 3.0), (4, -1.0, 3.0), (5, -2.0, 2.0), (8, 1000.0, 1000.25)]
    {
        for wrap in WRAPS {
            let texture = Texture::checkerboard(first, second, squares).unwrap().wrap(wrap);
            let found = left(&textured(square(Vec2::splat(low), Vec2::splat(high)), texture.clone()), &before(SIZE));
            let [low, high] = [low, high].map(f64::from);
            // Pixels on a square's edge have a share of both colours.
            let half_pixel = 0.51 * (high - low) / f64::from(SIZE);
            let plain = |uv: DVec2| {
                let at = |x: f64, y: f64| sampled(&texture, uv + half_pixel * DVec2::new(x, y));
                let around = [at(-1.0, -1.0), at(1.0, -1.0), at(-1.0, 1.0), at(1.0, 1.0)];
                around.iter().all(|color| *color == around[0]).then(|| around[0])
            };
            let count = (0..found.len()).filter(|&index| plain(uv_at(index, low, high)).is_some()).count();
            assert!(count > found.len() / 3, "{squares} {wrap:?}: {count}");
            let error = worst(&found, |index| plain(uv_at(index, low, high)));
            assert!(error < 1e-6, "{squares} squares from {low} to {high}, {wrap:?}: {error}");
        }
    }
}

/// A pixel's colour is the mean over its area, for any number of squares in it.
#[test]
fn a_board_s_squares_are_averaged_exactly() {
    let texture = Texture::checkerboard(Vec3::ONE, Vec3::ZERO, 7).unwrap();
    for wrap in WRAPS {
        let texture = texture.clone().wrap(wrap);
        for (low, high) in [(-1.0, 3.0), (-0.3, 1.7), (-9.0, 9.5)] {
            let found = left(&textured(square(Vec2::splat(low), Vec2::splat(high)), texture.clone()), &before(SIZE));
            let [low, high] = [low, high].map(f64::from);
            const STEPS: i32 = 64;
            let pixel = (high - low) / f64::from(SIZE);
            let mean = |uv: DVec2| {
                let step = |at: i32| ((f64::from(at) + 0.5) / f64::from(STEPS) - 0.5) * pixel;
                let all = (0..STEPS).flat_map(|x| (0..STEPS).map(move |y| DVec2::new(step(x), step(y))));
                all.map(|offset| sampled(&texture, uv + offset)).sum::<DVec3>() / f64::from(STEPS * STEPS)
            };
            // Every seventh pixel is tested, to save time. The reference mean has steps of a 64th of a pixel, which is
            // its error.
            let error = worst(&found, |index| (index % 7 == 0).then(|| mean(uv_at(index, low, high))));
            assert!(error < 0.04, "{low} to {high}, {wrap:?}: {error}");
        }
    }
}
