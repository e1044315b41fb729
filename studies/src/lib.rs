//! Studies of the papers that stereotrace builds on: benchmarks with reports, and tests of the reports' statements.
//!
//! - `thesis`: Al-Hagri 2012 (THESIS.md).
//! - `adelson-hodges`: Adelson & Hodges 1993 (ADELSON-HODGES.md).
//! - `reality`: Raghuvanshi & Dhande, T-buffer and shadow-buffer (REALITY.md).
//! - `moving`, `soft`, `samples`, `finish`, `shadows`, `visibility`: costs of parts of stereotrace.
