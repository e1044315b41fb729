//! Makes data sets of stereo pairs with ground truth: specs, random values, camera poses and folder layouts.
//!
//! Item `i` of a data set depends only on the spec and `i`. So any item can be rendered again, on any machine and in
//! any order.

#[cfg(feature = "dataset")]
mod array;
#[cfg(feature = "dataset")]
mod checks;
#[cfg(feature = "dataset")]
mod draws;
#[cfg(feature = "dataset")]
mod figures;
#[cfg(feature = "dataset")]
mod generate;
#[cfg(feature = "dataset")]
mod instant;
mod layout;
#[cfg(feature = "dataset")]
mod maker;
#[cfg(feature = "dataset")]
mod motion;
mod poses;
#[cfg(feature = "dataset")]
mod projector;
#[cfg(feature = "dataset")]
mod rolling;
#[cfg(feature = "dataset")]
mod sensor;
#[cfg(feature = "dataset")]
mod shutter;
#[cfg(feature = "dataset")]
mod spec;
#[cfg(feature = "dataset")]
mod stage;

pub use layout::{Layout, LayoutMotion};
#[cfg(feature = "dataset")]
pub use maker::{ArrayPair, MadePair, NextPair, PairMaker, Record};
pub use poses::{FreePoses, RandomPose};
#[cfg(feature = "dataset")]
pub use spec::{Array, Eye, LayerOutput, Output, Spec};
