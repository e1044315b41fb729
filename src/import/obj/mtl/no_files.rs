//! Replaces files.rs without the feature `textures`: no picture is read.

use std::path::Path;

use super::maps::Map;
use crate::{
    Error, Texture, TextureId,
    import::input::Files,
    import::{SceneOptions, warnings::Warnings},
};

pub(super) struct Textures {
    pub(super) textures: Vec<Texture>,
}

impl Textures {
    pub(super) fn new(_: Files, _: &Path, _: &SceneOptions) -> Self {
        Self { textures: Vec::new() }
    }

    #[allow(clippy::unnecessary_wraps, reason = "where textures are read, it may fail")]
    pub(super) fn find(
        &mut self,
        _: &Path,
        map: &Map,
        material: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<TextureId>, Error> {
        let text = format!(
            "{} '{}' of material '{material}' is ignored: stereotrace is built without its feature `textures`",
            map.keyword, map.name
        );
        warnings.warn("textures", map.line, text);
        Ok(None)
    }
}
