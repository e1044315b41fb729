//! Rendered views of a row of eyes, and quilts.

use stereotrace::output::{quilt, quilt_name};
use wasm_bindgen::prelude::*;
use web_sys::ImageData;

use crate::{
    errors::{raised, refused},
    values::image,
};

/// Views of a row of eyes, from left to right.
#[wasm_bindgen]
pub struct Views(pub(crate) stereotrace::Views);

#[wasm_bindgen]
impl Views {
    /// Number of views.
    #[wasm_bindgen(getter)]
    pub fn count(&self) -> usize {
        self.0.views.len()
    }

    /// Returns a view. Indices count from 0 at the left.
    pub fn view(&self, index: usize) -> Result<ImageData, JsValue> {
        let view = self.0.views.get(index);
        let missing = || refused(&format!("view {index}: there are {}, counted from 0", self.count()));
        image(&view.ok_or_else(missing)?.view.picture())
    }

    /// Returns all views in one picture for light-field displays, from left to right, with the bottom row first.
    pub fn quilt(&self, columns: u32, rows: u32) -> Result<ImageData, JsValue> {
        image(&quilt(&self.0, columns, rows).map_err(raised)?)
    }

    /// Returns the file name that tells players the quilt's columns, rows and aspect ratio: `NAME_qsCxRaA.png`.
    #[wasm_bindgen(js_name = quiltName)]
    pub fn quilt_name(&self, name: &str, columns: u32, rows: u32) -> String {
        quilt_name(name, &self.0, columns, rows)
    }

    /// Number of views that were traced. The others were made from these.
    #[wasm_bindgen(getter)]
    pub fn traced(&self) -> usize {
        self.0.views.iter().enumerate().filter(|(index, view)| view.made_from == *index).count()
    }
}
