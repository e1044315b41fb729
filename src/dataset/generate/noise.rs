//! Noise that repeats with a period of 1.

use std::sync::OnceLock;

use glam::Vec2;

use crate::random::pcg;

/// Side of the table of noise in entries.
pub(super) const TABLE: usize = 256;

/// Returns a table of noise of several sizes, 0 to 1 with a mean of a half. It repeats at its edges.
pub(super) fn table() -> &'static [f32] {
    static NOISE: OnceLock<Vec<f32>> = OnceLock::new();
    NOISE.get_or_init(|| {
        (0..TABLE * TABLE)
            .map(|place| {
                let at = Vec2::new((place % TABLE) as f32, (place / TABLE) as f32) / TABLE as f32;
                let octaves = (0..5).map(|octave| value(at, 4 << octave) / (1 << octave) as f32);
                octaves.sum::<f32>() / 1.937_5
            })
            .collect()
    })
}

/// Returns smooth noise with a period of 1.
pub(super) fn smooth_noise(at: Vec2) -> f32 {
    let at = (at - at.floor()) * TABLE as f32;
    let (cell, within) = (at.floor(), at - at.floor());
    let entry = |dx: usize, dy: usize| table()[(cell.y as usize + dy) % TABLE * TABLE + (cell.x as usize + dx) % TABLE];
    let row = |dy| entry(0, dy) + (entry(1, dy) - entry(0, dy)) * within.x;
    row(0) + (row(1) - row(0)) * within.y
}

/// Returns a random number of a word, from 0 up to 1.
pub(super) fn unit(word: u32) -> f32 {
    (pcg(word) >> 8) as f32 / (1 << 24) as f32
}

/// Returns smooth noise with this number of grid points per period, 0 to 1.
fn value(at: Vec2, points: u32) -> f32 {
    let at = at * points as f32;
    let (cell, within) = (at.floor(), at - at.floor());
    let value = |dx: u32, dy: u32| {
        let [x, y] = [(cell.x as u32 + dx) % points, (cell.y as u32 + dy) % points];
        unit(x + 977 * y + 65_537 * points)
    };
    let smooth = within * within * (Vec2::splat(3.0) - 2.0 * within);
    let row = |dy: u32| value(0, dy) + (value(1, dy) - value(0, dy)) * smooth.x;
    row(0) + (row(1) - row(0)) * smooth.y
}
