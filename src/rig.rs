//! Eyes on one line behind one screen: which are traced, and from which the others are made.

use crate::{Pose, cpu, frame::uniform::frame_uniform, layout};

/// The eyes of a frame, checked.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Eyes {
    /// Of the middle.
    pub(crate) pose: Pose,
    /// Of each eye from the middle along `pose.right`, in interaxials.
    pub(crate) offsets: Vec<f32>,
    /// Of each view the one that it is made from; one that is traced is its own.
    pub(crate) sources: Vec<usize>,
}

impl Eyes {
    /// Left and right; the right view is made from the left one.
    pub(crate) fn pair(pose: &Pose) -> Self {
        Self { pose: *pose, offsets: vec![-0.5, 0.5], sources: vec![0, 0] }
    }

    pub(crate) fn positions(&self) -> Vec<glam::Vec3> {
        self.offsets.iter().map(|offset| self.pose.eye_position(2.0 * offset)).collect()
    }

    /// As kernels read a view and its source.
    pub(crate) fn frame(&self, view: usize) -> layout::Frame {
        frame_uniform(&self.pose, self.offsets[self.sources[view]], self.offsets[view])
    }

    /// The same for the kernels' twins.
    pub(crate) fn cpu_frame(&self, view: usize) -> cpu::Frame {
        cpu::Frame::between(&self.pose, self.offsets[self.sources[view]], self.offsets[view])
    }

    /// A view and its source as a pair: the pose whose interaxial is the distance between them.
    pub(crate) fn pair_of(&self, view: usize) -> Pose {
        let apart = (self.offsets[view] - self.offsets[self.sources[view]]).abs();
        let Pose { interaxial, interaxial_px, .. } = self.pose;
        Pose { interaxial: apart * interaxial, interaxial_px: apart * interaxial_px, ..self.pose }
    }
}
