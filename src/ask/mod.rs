//! Settings of a caller: methods, options and progress callbacks.

pub(crate) mod channel;
pub(crate) mod method;
pub(crate) mod options;
pub(crate) mod progress;
pub(crate) mod samples;
pub(crate) mod settings;
pub(crate) mod shadow_buffer;
pub(crate) mod visibility;
