//! Data sets of stereo pairs with ground truth: where cameras stand, and how files lie in folders.
//!
//! Item `i` of a data set follows from the scene, the camera, the seed and `i` alone, so that any of them can be made
//! again, anywhere and in any order.

mod layout;
mod poses;

pub use layout::Layout;
pub use poses::{FreePoses, RandomPose};
