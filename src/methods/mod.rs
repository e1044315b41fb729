//! What methods promise, and how `auto` chooses.

pub(crate) mod auto;
