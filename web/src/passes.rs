//! Passes of a picture.

use std::cell::Cell;

use futures_util::lock::Mutex;
use wasm_bindgen::prelude::*;

/// The passes of a picture so far. `Renderer.addTo` renders one more pass, with random numbers of its own, and returns
/// the mean of all passes. So a picture by paths can be shown early and refined.
#[wasm_bindgen]
#[derive(Default)]
pub struct Passes {
    pub(crate) all: Mutex<stereotrace::Passes>,
    count: Cell<u32>,
    paths: Cell<u32>,
}

#[wasm_bindgen]
impl Passes {
    /// Makes a picture without passes.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of passes.
    #[wasm_bindgen(getter)]
    pub fn count(&self) -> u32 {
        self.count.get()
    }

    /// Number of paths per pixel of all passes; 0 without light by paths.
    #[wasm_bindgen(getter)]
    pub fn paths(&self) -> u32 {
        self.paths.get()
    }
}

impl Passes {
    /// Keeps the numbers of passes that JavaScript reads.
    pub(crate) fn tell(&self, all: &stereotrace::Passes) {
        self.count.set(all.count());
        self.paths.set(all.paths());
    }
}
