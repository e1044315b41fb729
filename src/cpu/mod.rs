//! Plain Rust twins of the kernels, under the same file names: slow, sequential, and free of BVH and wgpu. Tests
//! compare the kernels with them; swapping a pass for its twin is how to find the kernel that is wrong.
//!
//! They do the same arithmetic in the same order, so on adapters that don't contract or reorder f32 the results agree
//! bit for bit.

pub mod adelson_hodges;
pub mod bracket;
mod cutouts;
pub mod double_float;
pub mod intersect;
pub mod reproject;
pub mod resolve_right;
pub mod shadow_buffer;
pub mod trace_left;

use glam::Vec3;

use crate::{Pose, frame::uniform::frame_uniform, layout, samples::Jitter};

/// The frame as kernels read it, with vectors.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    raw: layout::Frame,
    jitter: Jitter,
}

/// Which eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Eye {
    /// The left one, which is traced first.
    Left,
    /// The right one.
    Right,
}

impl Frame {
    /// The frame of a camera.
    pub fn new(pose: &Pose) -> Self {
        Self::between(pose, -0.5, 0.5)
    }

    /// The frame of two eyes at offsets from the middle between a camera's eyes, in interaxials: the first is
    /// `Eye::Left`, the one that is traced first, whichever side it stands on.
    pub fn between(pose: &Pose, source: f32, target: f32) -> Self {
        Self { raw: frame_uniform(pose, source, target), jitter: Jitter::new(1, 0) }
    }

    /// The same where pixels are jittered samples, so many a side of a pixel (docs/DESIGN.md, section 3).
    pub fn jittered(self, side: u32, seed: u32) -> Self {
        Self { jitter: Jitter::new(side, seed), ..self }
    }

    /// Picture size, pixels.
    pub fn size(&self) -> [usize; 2] {
        self.raw.image_size.map(|side| side as usize)
    }

    /// World position of an eye.
    pub fn eye(&self, eye: Eye) -> Vec3 {
        match eye {
            Eye::Left => self.raw.source_eye.into(),
            Eye::Right => self.raw.target_eye.into(),
        }
    }

    /// `x_t - x_s` in pixels of a point at depth `z`.
    fn parallax(&self, z: f32) -> f32 {
        self.raw.parallax_px * (self.raw.at_infinity - self.raw.parallax_distance / z)
    }

    /// Direction from an eye through a pixel's centre, or its jittered sample, of length 1 along the view axis.
    pub fn direction(&self, eye: Eye, column: usize, row: usize) -> Vec3 {
        let corner: Vec3 = match eye {
            Eye::Left => self.raw.source_corner.into(),
            Eye::Right => self.raw.target_corner.into(),
        };
        let (x, y): (Vec3, Vec3) = (self.raw.step_x.into(), self.raw.step_y.into());
        let aside = self.jitter.aside(self.jitter.stratum(row as u32));
        corner + x * (column as f32 + 0.5 + aside) + y * (row as f32 + 0.5)
    }
}
