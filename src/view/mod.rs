//! Cameras and rigs of eyes.

pub(crate) mod camera;
pub(crate) mod rig;
