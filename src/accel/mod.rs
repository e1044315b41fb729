//! The tree of a scene: built by obvhs, packed for kernels, refitted and uploaded.

pub(crate) mod bvh;
pub(crate) mod cutouts;
pub(crate) mod geometry;
pub(crate) mod large;
pub(crate) mod table;
pub(crate) mod tree;
