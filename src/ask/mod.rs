//! What a caller asks for: method, options and outputs.

pub mod method;
pub(crate) mod options;
pub(crate) mod progress;
pub(crate) mod samples;
pub(crate) mod shadow_buffer;
pub(crate) mod visibility;
