//! Makes data sets of stereo pairs with ground truth: camera poses and folder layouts.
//!
//! Item `i` of a data set depends only on the scene, the camera, the seed and `i`. So any item can be rendered again,
//! on any machine and in any order.

mod layout;
mod poses;

pub use layout::Layout;
pub use poses::{FreePoses, RandomPose};
