//! Plain Rust twins of the kernels, with the same file names: slow and sequential, without BVH and wgpu. Tests compare
//! the kernels with them. To find a faulty kernel, replace a pass by its twin.
//!
//! They perform the same arithmetic in the same order. So results are bit-identical on adapters that neither contract
//! nor reorder f32 operations.

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

use crate::{Pose, frame::eyes::eyes_uniform, kernel::layout, sampling::Jitter};

/// The frame uniform of the kernels, with vectors.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    raw: layout::Eyes,
    size: [u32; 2],
    jitter: Jitter,
}

/// One of the two eyes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Eye {
    /// The left eye, which is traced first.
    Left,
    /// The right eye.
    Right,
}

impl Frame {
    /// Makes the frame of a planar camera.
    pub fn new(pose: &Pose) -> Self {
        Self::between(pose, -0.5, 0.5)
    }

    /// Makes the frame of two eyes, given as offsets from the middle between a camera's eyes, in interaxials. `source`
    /// becomes `Eye::Left`, which is traced first, on whichever side it is.
    pub fn between(pose: &Pose, source: f32, target: f32) -> Self {
        let frustum = pose.frustum().expect("the twins' cameras are planar");
        Self { raw: eyes_uniform(pose, &frustum, source, target), size: pose.size, jitter: Jitter::new(1, 0) }
    }

    /// Returns the same frame where pixels are jittered samples, `side` a side of a pixel (docs/DESIGN.md, section 3).
    pub fn jittered(self, side: u32, seed: u32) -> Self {
        Self { jitter: Jitter::new(side, seed), ..self }
    }

    /// Returns the picture's size in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size.map(|side| side as usize)
    }

    /// Returns the position of an eye in scene coordinates.
    pub fn eye(&self, eye: Eye) -> Vec3 {
        match eye {
            Eye::Left => self.raw.source_eye.into(),
            Eye::Right => self.raw.target_eye.into(),
        }
    }

    /// Returns the parallax `x_t - x_s` of a point at depth `z`, in pixels.
    fn parallax(&self, z: f32) -> f32 {
        self.raw.parallax_px * (self.raw.at_infinity - self.raw.parallax_distance / z)
    }

    /// Returns the direction from an eye through a pixel's centre, or its jittered sample, with length 1 along the view
    /// axis.
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

impl crate::view::rig::Eyes {
    /// Returns the frame of a view and its source.
    #[cfg(test)]
    pub(crate) fn cpu_frame(&self, view: usize) -> Frame {
        Frame::between(&self.pose, self.offsets[self.sources[view]], self.offsets[view])
    }
}
