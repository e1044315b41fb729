//! The integration tests: one program, so that they are linked once and share a device and its pipelines.
//!
//! `cargo test --test it NAME` runs those of a module or a name.

mod common;
mod solids;
mod truth;

mod adaptive;
mod async_forms;
mod bracket;
mod bytes;
mod camera_ranges;
mod cameras;
mod cutouts;
mod dataset;
mod dense;
mod disparity;
mod ellipsoids;
mod errors;
mod far_off;
mod files;
mod flat;
mod furnace;
mod geometry;
mod gltf;
mod golden;
mod ground_truth;
mod grounds;
mod huge_scenes;
mod jitter;
mod lighting;
mod limits;
mod memory;
mod mirrors;
mod moving;
mod numbers;
mod obj;
mod planes;
mod ply;
mod rays;
mod rows_and_textures;
mod samples;
mod scenes;
mod shadow_buffer;
mod sky_light;
mod slivers;
mod soft_light;
mod steps;
mod stereo;
mod suite;
mod t_buffer;
mod textures;
mod threads;
mod together;
mod twins;
mod views;
mod watertight;
