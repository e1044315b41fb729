//! Collects the warnings that the library logs.

use std::{
    cell::RefCell,
    sync::{Mutex, Once},
};

use super::folder::Folder;

/// All warnings that this process has logged.
pub(crate) static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

thread_local! {
    static OF_THIS_THREAD: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

struct Collector;

impl log::Log for Collector {
    fn enabled(&self, _: &log::Metadata) -> bool {
        true
    }

    fn log(&self, record: &log::Record) {
        if record.level() == log::Level::Warn {
            let text = record.args().to_string();
            OF_THIS_THREAD.with_borrow_mut(|warnings| warnings.push(text.clone()));
            WARNINGS.lock().unwrap().push(text);
        }
    }

    fn flush(&self) {}
}

/// Keeps all warnings that are logged from now on.
pub(crate) fn collect() {
    static LOGGER: Once = Once::new();
    LOGGER.call_once(|| {
        log::set_logger(&Collector).unwrap();
        log::set_max_level(log::LevelFilter::Warn);
    });
}

/// Returns the warnings of this thread, which belongs to one test.
pub(crate) fn of_this_thread() -> Vec<String> {
    OF_THIS_THREAD.with_borrow(Vec::clone)
}

/// Returns the warnings that name a file of this folder, from the file's name on.
pub(crate) fn of(folder: &Folder) -> Vec<String> {
    let prefix = format!("{}{}", folder.path().display(), std::path::MAIN_SEPARATOR);
    let warnings = WARNINGS.lock().unwrap();
    warnings.iter().filter_map(|warning| warning.strip_prefix(&prefix)).map(str::to_owned).collect()
}
