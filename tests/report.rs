//! The thesis benchmark's report, which is a program without a test harness of its own.
#![allow(dead_code, unreachable_pub, reason = "it is tested by parts")]

#[path = "../benches/common/mod.rs"]
mod common;
#[path = "../benches/thesis/record.rs"]
mod record;
#[path = "../benches/thesis/report.rs"]
mod report;
