//! Scene data for kernels: the tree and its primitives, cut-out masks, and the shading table.

pub(crate) mod bvh;
pub(crate) mod cutouts;
pub(crate) mod emitters;
pub(crate) mod facets;
pub(crate) mod geometry;
pub(crate) mod large;
pub(crate) mod outlines;
pub(crate) mod table;
pub(crate) mod tree;
