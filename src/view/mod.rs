//! Cameras and rigs of eyes.

pub mod camera;
pub mod rig;
