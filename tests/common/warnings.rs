//! What the library logs of files.

use std::sync::{Mutex, Once};

use super::folder::Folder;

/// Every warning of this process.
pub static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Collector;

impl log::Log for Collector {
    fn enabled(&self, _: &log::Metadata) -> bool {
        true
    }

    fn log(&self, record: &log::Record) {
        if record.level() == log::Level::Warn {
            WARNINGS.lock().unwrap().push(record.args().to_string());
        }
    }

    fn flush(&self) {}
}

/// From now on what is logged is kept.
pub fn collect() {
    static LOGGER: Once = Once::new();
    LOGGER.call_once(|| {
        log::set_logger(&Collector).unwrap();
        log::set_max_level(log::LevelFilter::Warn);
    });
}

/// The warnings that name a file of this folder, from the file's name on.
pub fn of(folder: &Folder) -> Vec<String> {
    let prefix = format!("{}{}", folder.path().display(), std::path::MAIN_SEPARATOR);
    let warnings = WARNINGS.lock().unwrap();
    warnings.iter().filter_map(|warning| warning.strip_prefix(&prefix)).map(str::to_owned).collect()
}
