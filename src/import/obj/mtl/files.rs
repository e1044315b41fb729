//! Reads texture files, each once.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use super::maps::{Map, Use};
use crate::{
    Error, Limits, Texture, TextureId, TextureKind, Wrap,
    import::input::Files,
    import::{MissingTextures, SceneOptions, warnings::Warnings},
};

/// The textures of all MTL files of an OBJ.
pub(super) struct Textures<'a> {
    files: Files<'a>,
    obj: &'a Path,
    missing: MissingTextures,
    limits_left: Limits,
    /// Number of pixels that may still be decoded, also of pictures that turn out to be broken.
    decodable: u64,
    pub(super) textures: Vec<Texture>,
    /// Texture ids by file, whether it is clamped, whether its brightness is its alpha, and whether its values are
    /// data.
    ids: HashMap<(PathBuf, bool, bool, bool), TextureId>,
    /// Cached results for each file. Thousands of materials may use one large picture, so nothing is computed twice.
    read: HashMap<PathBuf, Known>,
}

struct Known {
    /// The texture, or the reason why it can't be read.
    texture: Result<Texture, String>,
    is_opaque: Option<bool>,
    has_normals: Option<bool>,
}

impl<'a> Textures<'a> {
    pub(super) fn new(files: Files<'a>, obj: &'a Path, options: &SceneOptions) -> Self {
        let (missing, limits_left) = (options.missing_textures, options.limits);
        let decodable = limits_left.decodable_pixels();
        let (textures, ids, read) = (Vec::new(), HashMap::new(), HashMap::new());
        Self { files, obj, missing, limits_left, decodable, textures, ids, read }
    }

    /// Returns the texture that a statement of a material names. Returns `None` for an unreadable texture if that is no
    /// error.
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
        let (keyword, name, reason) = (map.keyword, &map.name, error.without_path());
        // Pictures of heights are not used, so they may be missing.
        let is_bump = map.purpose == Use::Normal && map.keyword != "norm";
        match self.missing {
            MissingTextures::Error if !is_bump => {
                let text = format!("{keyword} '{name}' of material '{material}': {reason}");
                Err(Error::parse_from(mtl, Some(map.line), text, error))
            }
            MissingTextures::Error | MissingTextures::Warn => {
                let text = format_args!(
                    "{keyword} '{name}' of material '{material}': {reason}; the material is rendered without it"
                );
                warnings.warn("textures that can't be read", map.line, text);
                Ok(None)
            }
        }
    }

    fn load(&mut self, mtl: &Path, map: &Map) -> Result<TextureId, Error> {
        let files = self.files;
        let file = files.locate(mtl.parent().unwrap_or(Path::new("")), &map.name)?;
        // A file may have several names.
        let key = files.real(&file);
        let texture = match self.read.get(&key) {
            Some(Known { texture: Ok(texture), .. }) => texture.clone(),
            Some(Known { texture: Err(reason), .. }) => return Err(Error::parse(file, None, reason.clone())),
            None => {
                let texture = self.open(mtl, &file, &key);
                let known = texture.as_ref().map(Texture::clone).map_err(Error::without_path);
                self.read.insert(key.clone(), Known { texture: known, is_opaque: None, has_normals: None });
                texture?
            }
        };
        let by_brightness = map.purpose == Use::CutOut && self.is_opaque(&key);
        // Some programs name normals in statements for heights.
        if map.purpose == Use::Normal && map.keyword != "norm" && !self.has_normals(&key) {
            return Err(Error::parse(file, None, "it has heights, not normals"));
        }
        let ids = (key, map.clamp, by_brightness, map.purpose.is_data());
        if let Some(&id) = self.ids.get(&ids) {
            return Ok(id);
        }
        let texture = if by_brightness { self.with_brightness(&ids.0, texture)? } else { texture };
        let texture = texture.data(map.purpose.is_data());
        self.textures.push(if map.clamp { texture.wrap(Wrap::Clamp) } else { texture });
        let id = TextureId(self.textures.len() as u32 - 1);
        self.ids.insert(ids, id);
        Ok(id)
    }

    /// Reads a picture within the remaining limits. `real` is its path with all links followed.
    fn open(&mut self, mtl: &Path, file: &Path, real: &Path) -> Result<Texture, Error> {
        for (kind, own) in [("MTL", mtl), ("OBJ", self.obj)] {
            if self.files.real(own) == real {
                return Err(Error::parse(file, None, format!("it is the {kind} file itself")));
            }
        }
        let (mut limits, mut pixels) = (self.limits_left, 0);
        limits.texture_pixels = limits.texture_pixels.min(self.decodable);
        let texture = Texture::open_from(self.files, file, &limits, &mut pixels);
        self.decodable -= pixels;
        if texture.is_ok() {
            self.limits_left.texture_pixels -= pixels;
        }
        texture
    }

    /// Returns whether a picture that was read has no alpha below 255.
    fn is_opaque(&mut self, key: &Path) -> bool {
        match self.read.get_mut(key) {
            Some(Known { texture: Ok(texture), is_opaque, .. }) => {
                *is_opaque.get_or_insert_with(|| is_opaque_all_over(texture))
            }
            _ => false,
        }
    }

    /// Returns whether a picture that was read looks like normals.
    fn has_normals(&mut self, key: &Path) -> bool {
        match self.read.get_mut(key) {
            Some(Known { texture: Ok(texture), has_normals, .. }) => {
                *has_normals.get_or_insert_with(|| looks_like_normals(texture))
            }
            _ => false,
        }
    }

    /// Returns a copy of a picture whose alpha is its brightness.
    fn with_brightness(&mut self, file: &Path, texture: Texture) -> Result<Texture, Error> {
        let TextureKind::Image { size: [width, height], pixels } = texture.kind() else { return Ok(texture) };
        let (count, left) = (pixels.len() as u64, &mut self.limits_left.texture_pixels);
        *left = left.checked_sub(count).ok_or_else(|| Error::TooLarge {
            path: file.into(),
            size: format!("its copy with brightness as alpha has another {width}x{height} pixels, {count} in all"),
            limit: *left,
            remedy: format!("raise it with {} if the size is intended", self.limits_left.texture_option_name),
        })?;
        // Luma of Rec. 709.
        let luma = |[r, g, b]: [u8; 3]| 0.2126 * f32::from(r) + 0.7152 * f32::from(g) + 0.0722 * f32::from(b);
        let bright = |&[r, g, b, _]: &[u8; 4]| [r, g, b, luma([r, g, b]).round() as u8];
        Texture::image(*width, *height, pixels.iter().map(bright).collect())
    }
}

fn is_opaque_all_over(texture: &Texture) -> bool {
    match texture.kind() {
        TextureKind::Image { pixels, .. } => Arc::as_ref(pixels).iter().all(|pixel| pixel[3] == 255),
        TextureKind::Checkerboard { .. } => false,
    }
}

/// Returns whether a picture's mean is that of normals in tangent space: red and green near a half, and much blue.
fn looks_like_normals(texture: &Texture) -> bool {
    let TextureKind::Image { pixels, .. } = texture.kind() else { return false };
    let mut sums = [0_u64; 3];
    for pixel in pixels.iter() {
        (0..3).for_each(|channel| sums[channel] += u64::from(pixel[channel]));
    }
    let [red, green, blue] = sums.map(|sum| sum as f64 / (255.0 * pixels.len() as f64));
    (red - 0.5).abs() < 0.1 && (green - 0.5).abs() < 0.1 && blue > 0.7
}
