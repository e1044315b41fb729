//! Adelson & Hodges' sweep on the host, pixel by pixel (thesis, 2.3).

use crate::kernel::layout::Eyes;

/// Returns the target's column on which the sample in `column` at depth `z` lands. It may lie outside the picture.
fn landing(eyes: &Eyes, column: usize, z: f32) -> i32 {
    let parallax = eyes.parallax_px * (eyes.at_infinity - eyes.parallax_distance / z);
    (column as f32 + 0.5 + parallax).clamp(-1e9, 1e9).floor() as i32
}

/// Returns for each target pixel the key of its sample, or 0 if it must be traced. A key is the position of the
/// sample's column in the sweep, from 1 on.
///
/// For a target on the right, each row is swept from left to right, and later samples overwrite earlier ones. If two
/// neighbours land more than one column apart, the columns strictly between lie in a gap and are cleared. Columns past
/// the last sample are cleared too (DESIGN, section 4). For a target on the left, left and right are exchanged.
pub(crate) fn sweep(eyes: &Eyes, width: usize, source_depth: &[f32]) -> Vec<u32> {
    let mirrored = eyes.parallax_px < 0.0;
    let clear_between = |row: &mut [u32], after: i32, before: i32| {
        let (begin, end) = if mirrored { (before + 1, after) } else { (after + 1, before) };
        for column in begin.max(0)..end.min(width as i32) {
            row[column as usize] = 0;
        }
    };
    let mut keys = vec![0; source_depth.len()];
    for (row, depths) in keys.chunks_exact_mut(width).zip(source_depth.chunks_exact(width)) {
        let mut before = None;
        for place in 0..width {
            let column = if mirrored { width - 1 - place } else { place };
            let here = landing(eyes, column, depths[column]);
            clear_between(row, before.unwrap_or(here), here);
            if (0..width as i32).contains(&here) {
                row[here as usize] = place as u32 + 1;
            }
            before = Some(here);
        }
        let past = if mirrored { -1 } else { width as i32 };
        clear_between(row, before.unwrap_or(past), past);
    }
    keys
}
