//! Provenance of figures: adapter, driver, commit, date, and whether they come from a smoke run.

use std::{
    fmt,
    process::Command,
    time::{SystemTime, UNIX_EPOCH},
};

use stereotrace::Gpu;

use super::options::is_quick;

/// Text that marks the figures of a smoke run.
pub const SMOKE: &str = "smoke run: its figures mean nothing";

/// Machine, source version and date of a measurement.
pub struct Provenance {
    pub adapter: String,
    pub driver: String,
    /// Commit of the source, or "unknown".
    pub commit: String,
    /// Date and time in UTC, as 2012-06-30T23:59:59Z.
    pub date: String,
    /// Whether it is a smoke run.
    pub smoke: bool,
}

impl Provenance {
    pub fn of(gpu: &Gpu) -> Self {
        let git = Command::new("git").args(["rev-parse", "HEAD"]).current_dir(env!("CARGO_MANIFEST_DIR")).output();
        let commit = git.ok().filter(|output| output.status.success());
        let commit = commit.and_then(|output| String::from_utf8(output.stdout).ok());
        let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        Self {
            adapter: gpu.adapter_name(),
            driver: gpu.driver(),
            commit: commit.map_or("unknown".into(), |commit| commit.trim().to_owned()),
            date: utc(seconds),
            smoke: is_quick(),
        }
    }

    /// Returns the date without the time.
    pub fn day(&self) -> &str {
        self.date.split('T').next().unwrap_or(&self.date)
    }

    /// Returns the text below a chart's title.
    pub fn source(&self) -> String {
        marked(format!("{}, {}", self.adapter, self.day()), self.smoke)
    }
}

/// Appends the mark of a smoke run if these are its figures.
pub fn marked(source: String, smoke: bool) -> String {
    if smoke { format!("{source} - {}", SMOKE.to_uppercase()) } else { source }
}

/// Formats the text that is printed above tables.
impl fmt::Display for Provenance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "adapter: {}\ndriver:  {}\ncommit:  {}\ndate:    {}",
            self.adapter, self.driver, self.commit, self.date
        )?;
        if self.smoke { write!(f, "\n{}", SMOKE.to_uppercase()) } else { Ok(()) }
    }
}

/// Formats seconds since 1970 as a date, after Hinnant's `civil_from_days`.
fn utc(seconds: u64) -> String {
    let (days, time) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    // Years begin in March here, so that the leap day is their last day.
    let march_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * march_month + 2) / 5 + 1;
    let month = if march_month < 10 { march_month + 3 } else { march_month - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}Z", time / 3600, time / 60 % 60, time % 60)
}
