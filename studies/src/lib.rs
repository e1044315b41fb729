//! Studies of the papers that stereotrace builds on. They are benchmarks with reports, and tests of what the reports
//! say:
//!
//! - `thesis`: Al-Hagri 2012 (THESIS.md).
//! - `adelson-hodges`: Adelson & Hodges 1993 (ADELSON-HODGES.md).
//! - `reality`: Raghuvanshi & Dhande, T-buffer and shadow-buffer (REALITY.md).
//! - `moving`, `soft`, `samples`, `finish`, `shadows`, `visibility`: what parts of stereotrace cost.
