//! A guide in five chapters for readers new to the field. The tests compile and run its examples.

#[doc = include_str!("../docs/guide/1-first-anaglyph.md")]
pub mod first_anaglyph {}

#[doc = include_str!("../docs/guide/2-own-model.md")]
pub mod own_model {}

#[doc = include_str!("../docs/guide/3-data-set.md")]
pub mod data_set {}

#[doc = include_str!("../docs/guide/4-choosing-a-method.md")]
pub mod choosing_a_method {}

#[doc = include_str!("../docs/guide/5-own-device.md")]
pub mod own_device {}
