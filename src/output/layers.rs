//! Surfaces along lines of sight as files.

use std::path::Path;

use super::Batch;
use crate::{Error, EyeLayers, LayerClass};

impl Batch {
    /// Adds what the other eye sees of a layer (0 is the nearest one) as an 8-bit grey PNG file. 0: it sees the point.
    /// 64: through further see-through surfaces. 255: the point is hidden. 128: it is outside the other picture. 192:
    /// not known. 32: the pixel has no such surface.
    ///
    /// # Errors
    /// [`Error::Io`] as [`Batch::add`], and for a layer that is not there.
    pub fn add_layer_classes(&mut self, path: impl AsRef<Path>, layers: &EyeLayers, layer: u32) -> Result<(), Error> {
        let path = path.as_ref();
        if layer >= layers.surfaces {
            return Err(Error::unwritable(path, format!("there is no layer {layer}; there are {}", layers.surfaces)));
        }
        let grey = |class: &LayerClass| match class {
            LayerClass::Visible => 0,
            LayerClass::Through => 64,
            LayerClass::Hidden => 255,
            LayerClass::OutOfFrame => 128,
            LayerClass::Unknown => 192,
            LayerClass::None => 32,
        };
        let samples = Vec::from_iter(layers.layer(&layers.class, layer).iter().map(grey));
        self.add_grey8(path, [layers.width, layers.height], &samples)
    }
}
