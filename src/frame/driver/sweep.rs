//! Adelson & Hodges' sweep on the host, pixel by pixel (thesis, 2.3).

use crate::{
    kernel::layout::{self, Band},
    view::{camera::Circle, rig::Eyes},
};

/// How samples move from a view's source to the view.
pub(crate) struct Sweep {
    /// Number of columns.
    width: usize,
    motion: Motion,
}

enum Motion {
    Planar(layout::Eyes),
    /// To the right eye of a viewing circle, in rows that begin with this one of the picture.
    Around(Circle, u32),
}

impl Sweep {
    /// Returns the sweep of a view's band.
    pub(crate) fn of(eyes: &Eyes, view: usize, band: &Band) -> Self {
        let motion = match eyes.pose.circle() {
            None => Motion::Planar(eyes.uniform(view, 0.0)),
            Some(circle) => Motion::Around(circle, band.first_row + band.row_begin),
        };
        Self { width: band.size[0] as usize, motion }
    }

    /// Returns the target's column on which the sample in `column` at depth `z` lands. It may lie outside the picture.
    fn landing(&self, row: usize, column: usize, z: f32) -> i32 {
        let middle = column as f32 + 0.5;
        let landed = match &self.motion {
            Motion::Planar(eyes) => middle + eyes.parallax_px * (eyes.at_infinity - eyes.parallax_distance / z),
            Motion::Around(circle, first) => {
                let elevation = circle.elevation(*first as f64 + row as f64 + 0.5);
                (f64::from(middle) - circle.disparity_px(z.into(), elevation)) as f32
            }
        };
        landed.clamp(-1e9, 1e9).floor() as i32
    }

    /// Returns whether rows are swept from right to left.
    fn is_mirrored(&self) -> bool {
        matches!(&self.motion, Motion::Planar(eyes) if eyes.parallax_px < 0.0)
    }

    /// Returns the number of columns of a full turn, in pictures that show one.
    fn round(&self) -> Option<usize> {
        match &self.motion {
            Motion::Planar(_) => None,
            Motion::Around(circle, _) => circle.turn.map(|_| self.width),
        }
    }

    /// Returns the key of a sample at a place of the sweep that lands on a column, as in `camera.wgsl`.
    fn key(&self, place: usize, column: i32) -> u32 {
        match &self.motion {
            Motion::Planar(_) => place as u32 + 1,
            Motion::Around(..) => (place + self.width - column as usize) as u32 % self.width as u32 + 1,
        }
    }

    /// Returns for each target pixel the key of its sample, or 0 if it must be traced.
    ///
    /// For a target on the right, each row is swept from left to right, and later samples overwrite earlier ones. If
    /// two neighbours land more than one column apart, the columns strictly between lie in a gap and are cleared.
    /// Columns past the last sample are cleared too (DESIGN, section 4). For a target on the left, left and right are
    /// exchanged. Where a row is a full turn, its first half follows the last column again.
    pub(crate) fn keys(&self, source_depth: &[f32]) -> Vec<u32> {
        let (width, mirrored, round) = (self.width, self.is_mirrored(), self.round());
        let clear_between = |row: &mut [u32], after: i32, before: i32| {
            let (begin, end) = if mirrored { (before + 1, after) } else { (after + 1, before) };
            for column in begin.max(0)..end.min(width as i32) {
                row[column as usize] = 0;
            }
        };
        let mut keys = vec![0; source_depth.len()];
        for (index, (row, depths)) in keys.chunks_exact_mut(width).zip(source_depth.chunks_exact(width)).enumerate() {
            let mut before = None;
            for place in 0..width + round.unwrap_or(0) / 2 {
                let turned = if place < width { 0 } else { width };
                let column = if mirrored { width - 1 - place } else { place - turned };
                let here = self.landing(index, column, depths[column]) + turned as i32;
                clear_between(row, before.unwrap_or(here), here);
                if (0..width as i32).contains(&here) {
                    row[here as usize] = self.key(place - turned, here);
                }
                before = Some(here);
            }
            let past = if mirrored { -1 } else { width as i32 };
            if round.is_none() {
                clear_between(row, before.unwrap_or(past), past);
            }
        }
        keys
    }
}
