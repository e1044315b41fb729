//! The sweep of Adelson and Hodges, sequentially. It is both the method itself and the twin of
//! `shaders/reproject/reproject_scanline.wgsl`.

use super::{
    Frame,
    reproject::{in_sweep, landing_x},
};

/// Returns the right column where left sample `column` at depth `z` lands, which may lie outside the picture.
pub fn landing(frame: &Frame, column: usize, z: f32) -> i32 {
    landing_x(frame, column, z).clamp(-1e9, 1e9).floor() as i32
}

/// Returns the key of each target pixel's sample, or 0 if the pixel must be traced. A key is the position of the
/// sample's column in the sweep, from 1.
///
/// For a target on the right each row is swept from left to right, and a later sample overwrites. If two neighbours
/// land more than one column apart, the columns strictly between them are a gap and are cleared. Columns past the last
/// sample are cleared too (DESIGN, section 4). For a target on the left everything is mirrored.
pub fn sweep(frame: &Frame, left_depth: &[f32]) -> Vec<u32> {
    let width = frame.size()[0];
    let mut right_source = vec![0; left_depth.len()];
    for (row, depths) in right_source.chunks_exact_mut(width).zip(left_depth.chunks_exact(width)) {
        let mirrored = frame.raw.parallax_px < 0.0;
        let clear_between = |row: &mut [u32], after: i32, before: i32| match mirrored {
            false => clear(row, after + 1, before),
            true => clear(row, before + 1, after),
        };
        let mut before = None;
        for (place, column) in in_sweep(frame).enumerate() {
            let here = landing(frame, column, depths[column]);
            clear_between(row, before.unwrap_or(here), here);
            if (0..width as i32).contains(&here) {
                row[here as usize] = place as u32 + 1;
            }
            before = Some(here);
        }
        let past = if mirrored { -1 } else { width as i32 };
        clear_between(row, before.unwrap_or(past), past);
    }
    right_source
}

/// Clears columns `[begin, end)` within the picture.
fn clear(row: &mut [u32], begin: i32, end: i32) {
    for column in begin.max(0)..end.min(row.len() as i32) {
        row[column as usize] = 0;
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::{StereoCamera, random::Random};

    /// State of a right column in the right-to-left variant.
    #[derive(Clone, Copy, PartialEq)]
    enum Column {
        Free,
        /// In a gap: the column stays empty, even if later samples of the sweep land there.
        Blocked,
        Taken(u32),
    }

    /// Sweeps from right to left; the first write wins. The paper's version has two states: it marks gaps as hit and so
    /// never traces them. A third state makes the result equal to the forward sweep's.
    fn sweep_from_the_right(frame: &Frame, left_depth: &[f32]) -> Vec<u32> {
        let [width, height] = frame.size();
        let mut right_source = Vec::with_capacity(width * height);
        for depths in left_depth.chunks_exact(width) {
            let mut row = vec![Column::Free; width];
            let fill = |row: &mut Vec<Column>, begin: i32, end: i32, with: Column| {
                for column in begin.max(0)..end.min(width as i32) {
                    if row[column as usize] == Column::Free {
                        row[column as usize] = with;
                    }
                }
            };
            let landings: Vec<i32> = (0..width).map(|column| landing(frame, column, depths[column])).collect();
            fill(&mut row, landings[width - 1] + 1, width as i32, Column::Blocked);
            for column in (0..width).rev() {
                let here = landings[column];
                fill(&mut row, here, here + 1, Column::Taken(column as u32 + 1));
                if column > 0 {
                    fill(&mut row, landings[column - 1] + 1, here, Column::Blocked);
                }
            }
            right_source.extend(row.iter().map(|column| match column {
                Column::Taken(source) => *source,
                Column::Free | Column::Blocked => 0,
            }));
        }
        right_source
    }

    #[test]
    fn the_sweep_from_the_right_gives_the_same_picture() {
        let camera = StereoCamera::look_at(4.0 * Vec3::Z, Vec3::ZERO).screen_distance(4.0);
        let mut random = Random::new(3);
        for interaxial_px in [0.5, 6.0, 30.0] {
            let frame = Frame::new(&camera.size(97, 40).interaxial_pixels(interaxial_px).pose().unwrap());
            // Surfaces a few pixels wide at random depths, slanted, with sky between.
            let mut depths = Vec::new();
            while depths.len() < 97 * 40 {
                let (z, slope) = (random.between(0.5, 9.5), random.between(-0.5, 0.5));
                let sky = random.unit() < 0.15;
                let width = 1 + random.below(12);
                depths.extend((0..width).map(|i| if sky { crate::FAR } else { (z + slope * i as f32).max(1e-3) }));
            }
            depths.truncate(97 * 40);
            let forward = sweep(&frame, &depths);
            assert!(forward.contains(&0) && forward.iter().filter(|source| **source > 0).count() > 100);
            assert!(forward == sweep_from_the_right(&frame, &depths), "{interaxial_px}");
        }
    }

    #[test]
    fn to_the_left_it_is_the_sweep_to_the_right_in_a_mirror() {
        let camera = StereoCamera::look_at(4.0 * Vec3::Z, Vec3::ZERO).screen_distance(4.0);
        let pose = camera.size(97, 5).interaxial_pixels(9.0).pose().unwrap();
        let mut random = Random::new(7);
        let depths: Vec<f32> = (0..97 * 5).map(|index| 3.0 + (index / 7 % 5) as f32 + 0.1 * random.unit()).collect();
        let mirrored: Vec<f32> = depths.chunks_exact(97).flat_map(|row| row.iter().rev().copied()).collect();
        let to_right = sweep(&Frame::between(&pose, -0.5, 0.5), &depths);
        let to_left = sweep(&Frame::between(&pose, 0.5, -0.5), &mirrored);
        let back: Vec<u32> = to_left.chunks_exact(97).flat_map(|row| row.iter().rev().copied()).collect();
        assert!(to_right.contains(&0) && to_right.iter().filter(|key| **key > 0).count() > 300);
        assert_eq!(to_right, back);
    }

    #[test]
    fn a_gap_that_the_background_had_covered_is_cleared() {
        // For e_px = 8 and d = 4, z = 8 moves by 4 columns, z = 4 by 0 and the sky by 8.
        let camera = StereoCamera::look_at(4.0 * Vec3::Z, Vec3::ZERO).screen_distance(4.0);
        let frame = Frame::new(&camera.size(20, 1).interaxial_pixels(8.0).pose().unwrap());
        let depths: Vec<f32> = (0..20).map(|column| if (6..9).contains(&column) { 4.0 } else { 8.0 }).collect();
        let source = sweep(&frame, &depths);
        // Columns 0 to 5 land in 4 to 9, columns 6 to 8 stay and overwrite, and column 9 lands in 13. So 9 to 12 lie in
        // a gap, where sample 5 had been written to column 9.
        let expected: [u32; 20] = [0, 0, 0, 0, 1, 2, 7, 8, 9, 0, 0, 0, 0, 10, 11, 12, 13, 14, 15, 16];
        assert_eq!(source, expected);
    }
}
