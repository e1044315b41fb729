//! Rendering of a frame: its plan, the bands of rows, and the buffers between steps. The driver runs the plan on each
//! band, and results are read back.

mod bands;
pub(crate) mod driver;
pub(crate) mod executor;
pub(crate) mod eyes;
pub(crate) mod history;
pub(crate) mod lanes;
pub(crate) mod plan;
pub(crate) mod read;
pub(crate) mod rows;
pub(crate) mod show;
pub(crate) mod targets;
pub(crate) mod uniforms;
pub(crate) mod view;
pub(crate) mod wanted;
pub(crate) mod work;

pub(crate) use bands::{Band, Bands, RAYS_PER_PIXEL, band_pixels, fewest_rows, read_back_bytes};
pub use rows::{OnRows, Rows, ViewRows};
pub(crate) use targets::Cache;
