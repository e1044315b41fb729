//! Log messages of the library go to the browser's console. Warnings are also kept, for `Scene.warnings`.

use std::cell::RefCell;

use log::{Level, LevelFilter, Log, Metadata, Record};
use wasm_bindgen::JsValue;

thread_local! {
    static WARNINGS: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Maximum number of kept warnings.
const MOST: usize = 100;

struct Console;

impl Log for Console {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= Level::Warn
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let text = record.args().to_string();
        if record.level() == Level::Error {
            return complain(&text);
        }
        web_sys::console::warn_1(&JsValue::from(&text));
        WARNINGS.with_borrow_mut(|warnings| {
            if warnings.len() < MOST {
                warnings.push(text);
            }
        });
    }

    fn flush(&self) {}
}

/// Installs the logger.
pub(crate) fn listen() {
    // A logger that the program has already installed is kept.
    if log::set_logger(&Console).is_ok() {
        log::set_max_level(LevelFilter::Warn);
    }
}

/// Writes an error to the console.
pub(crate) fn complain(text: &str) {
    web_sys::console::error_1(&JsValue::from(text));
}

/// Returns the warnings since the last call.
pub(crate) fn taken() -> Vec<String> {
    WARNINGS.take()
}
