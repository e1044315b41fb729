//! Files of textures, each read once.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use super::maps::Map;
use crate::{
    Error, Limits, Texture, TextureId, TextureKind, Wrap,
    input::Files,
    scene::{MissingTextures, SceneOptions, warnings::Warnings},
};

/// The textures of all MTL files of an OBJ.
pub(super) struct Textures<'a> {
    files: Files<'a>,
    obj: &'a Path,
    missing: MissingTextures,
    limits_left: Limits,
    pub(super) textures: Vec<Texture>,
    /// By file, and whether it is clamped and its brightness is its alpha.
    ids: HashMap<(PathBuf, bool, bool), TextureId>,
    read: HashMap<PathBuf, Texture>,
}

impl<'a> Textures<'a> {
    pub(super) fn new(files: Files<'a>, obj: &'a Path, options: &SceneOptions) -> Self {
        let (missing, limits_left) = (options.missing_textures, options.limits);
        Self { files, obj, missing, limits_left, textures: Vec::new(), ids: HashMap::new(), read: HashMap::new() }
    }

    /// The texture that a statement of a material names.
    pub(super) fn find(
        &mut self,
        mtl: &Path,
        map: &Map,
        material: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<TextureId>, Error> {
        let error = match self.load(mtl, map) {
            Ok(id) => return Ok(Some(id)),
            Err(error) => error,
        };
        let reason = error.without_path();
        let text = format!("{} '{}' of material '{material}': {reason}", map.keyword, map.name);
        match self.missing {
            MissingTextures::Error => Err(Error::parse_from(mtl, Some(map.line), text, error)),
            MissingTextures::Warn => {
                warnings.warn("textures that can't be read", map.line, format!("{text}; the material is without it"));
                Ok(None)
            }
        }
    }

    fn load(&mut self, mtl: &Path, map: &Map) -> Result<TextureId, Error> {
        let files = self.files;
        let file = files.locate(mtl.parent().unwrap_or(Path::new("")), &map.name)?;
        // A file may have several names.
        let key = files.real(&file);
        for (kind, own) in [("MTL", mtl), ("OBJ", self.obj)] {
            if files.real(own) == key {
                return Err(Error::parse(file, None, format!("it is the {kind} file itself")));
            }
        }
        let texture = match self.read.get(&key) {
            Some(texture) => texture.clone(),
            None => {
                let texture = Texture::open_from(files, &file, &self.limits_left)?;
                self.take_from_limit(&texture);
                self.read.insert(key.clone(), texture.clone());
                texture
            }
        };
        let by_brightness = map.keyword == "map_d" && is_opaque(&texture);
        let ids = (key, map.clamp, by_brightness);
        if let Some(&id) = self.ids.get(&ids) {
            return Ok(id);
        }
        let texture = if by_brightness { self.with_brightness(texture)? } else { texture };
        self.textures.push(if map.clamp { texture.wrap(Wrap::Clamp) } else { texture });
        let id = TextureId(self.textures.len() as u32 - 1);
        self.ids.insert(ids, id);
        Ok(id)
    }

    fn take_from_limit(&mut self, texture: &Texture) {
        if let TextureKind::Image { pixels, .. } = texture.kind() {
            self.limits_left.texture_pixels = self.limits_left.texture_pixels.saturating_sub(pixels.len() as u64);
        }
    }

    /// A picture without alpha, whose brightness takes its place.
    fn with_brightness(&mut self, texture: Texture) -> Result<Texture, Error> {
        let TextureKind::Image { size: [width, height], pixels } = texture.kind() else { return Ok(texture) };
        let mut pixels = Vec::clone(pixels);
        for [r, g, b, alpha] in &mut pixels {
            // Rec. 709's luma.
            *alpha = (0.2126 * f32::from(*r) + 0.7152 * f32::from(*g) + 0.0722 * f32::from(*b)).round() as u8;
        }
        let texture = Texture::image(*width, *height, pixels)?;
        self.take_from_limit(&texture);
        Ok(texture)
    }
}

fn is_opaque(texture: &Texture) -> bool {
    match texture.kind() {
        TextureKind::Image { pixels, .. } => Arc::as_ref(pixels).iter().all(|pixel| pixel[3] == 255),
        TextureKind::Checkerboard { .. } => false,
    }
}
