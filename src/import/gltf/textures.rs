//! Reads pictures, each once, and derives textures and means for materials.

#[cfg(feature = "textures")]
use std::cell::Cell;
use std::{collections::HashMap, path::PathBuf};

use glam::{DVec3, Vec3};
use gltf_json::{
    Index, Texture as Description,
    texture::{MagFilter, WrappingMode},
    validation::Checked,
};

use super::document::Document;
use crate::{
    Error, Limits, MissingTextures, Scene, Texture, TextureId, TextureKind, Wrap,
    import::{
        SceneOptions,
        warnings::{Place, Warnings},
    },
    scene::linear,
    scene::material::MASK_ALPHA,
};

/// A picture with a texture's wrap mode.
#[derive(Clone)]
pub(super) struct Picture {
    number: usize,
    pub(super) texture: Texture,
}

/// Mean red, green and blue of a picture, 0 to 1.
#[derive(Clone, Copy)]
pub(super) struct Means {
    /// Mean of the sRGB values in linear light.
    pub(super) light: Vec3,
    /// Mean of the raw values.
    pub(super) values: Vec3,
}

/// Source of a picture. Images with equal sources share a picture.
#[derive(PartialEq, Eq, Hash)]
#[cfg_attr(not(feature = "textures"), allow(dead_code, reason = "pictures are not read"))]
enum Source {
    File(PathBuf),
    /// Address of a buffer's bytes, which don't move.
    Bytes(*const [u8]),
    /// URI of the image with this index.
    Uri(usize),
}

/// What distinguishes textures: picture, wrap, alpha threshold, and whether the values are data rather than colours.
type Key = (usize, Wrap, Option<u8>, bool);

/// Cached results for a picture. Thousands of materials may use one large picture, so nothing is computed twice.
#[derive(Default)]
struct Known {
    texture: Option<Texture>,
    means: Option<Means>,
    /// Number of pixels by alpha.
    alphas: Option<Box<[u64; 256]>>,
    /// Copies with an alpha of 255 at and above a threshold, 0 below.
    cut: HashMap<u8, Texture>,
    /// Reason why the picture can't be read.
    fault: Option<String>,
}

/// The textures of a file.
pub(super) struct Textures<'a> {
    document: &'a Document<'a>,
    missing: MissingTextures,
    limits_left: Limits,
    /// Number of pixels that may still be decoded, whether they are kept or not.
    #[cfg(feature = "textures")]
    decodable: Cell<u64>,
    /// Picture index of each image, and of each source.
    of_images: HashMap<usize, usize>,
    of_sources: HashMap<Source, usize>,
    pictures: Vec<Known>,
    /// Texture ids.
    ids: HashMap<Key, TextureId>,
    /// Textures that are not yet in the scene, and the number that are.
    new: Vec<Texture>,
    moved: usize,
}

impl<'a> Textures<'a> {
    pub(super) fn new(document: &'a Document<'a>, options: &SceneOptions) -> Self {
        let limits = options.limits;
        Self {
            document,
            missing: options.missing_textures,
            limits_left: limits,
            #[cfg(feature = "textures")]
            decodable: Cell::new(limits.decodable_pixels()),
            of_images: HashMap::new(),
            of_sources: HashMap::new(),
            pictures: Vec::new(),
            ids: HashMap::new(),
            new: Vec::new(),
            moved: 0,
        }
    }

    /// Returns the picture of a texture; `by` names it in messages. Returns `None` for an unreadable picture if that is
    /// no error.
    pub(super) fn picture(
        &mut self,
        index: Index<Description>,
        by: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<Picture>, Error> {
        let Some((image, number)) = self.number(index, by, warnings)? else { return Ok(None) };
        let Some(texture) = self.loaded((image, number), by, warnings)? else { return Ok(None) };
        if let TextureKind::Image { pixels, .. } = texture.kind()
            && self.pictures[number].texture.is_none()
        {
            // The picture was decoded within this remaining limit.
            self.limits_left.texture_pixels -= pixels.len() as u64;
            self.pictures[number].texture = Some(texture.clone());
        }
        let wrap = self.wrap(index, warnings)?;
        Ok(Some(Picture { number, texture: texture.wrap(wrap) }))
    }

    /// Returns the means of a picture.
    pub(super) fn means_of(&mut self, picture: &Picture) -> Means {
        *self.pictures[picture.number].means.get_or_insert_with(|| means(&picture.texture))
    }

    /// Returns the number of a picture's pixels by alpha.
    pub(super) fn alphas(&mut self, picture: &Picture) -> &[u64; 256] {
        self.pictures[picture.number].alphas.get_or_insert_with(|| Box::new(alphas(&picture.texture)))
    }

    /// Returns the texture id of a picture.
    pub(super) fn id(&mut self, picture: &Picture) -> TextureId {
        self.added((picture.number, picture.texture.wrap, None, false), picture.texture.clone())
    }

    /// Returns the texture id of a picture whose values are data.
    pub(super) fn data_id(&mut self, picture: &Picture) -> TextureId {
        self.added((picture.number, picture.texture.wrap, None, true), picture.texture.clone().data(true))
    }

    /// Returns the texture id of a picture that is cut out below an alpha. Returns `None` if the picture exceeds the
    /// limits and that is no error.
    pub(super) fn cutout(
        &mut self,
        picture: &Picture,
        least: u8,
        by: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<TextureId>, Error> {
        match self.cutout_of(picture, least) {
            Ok(id) => Ok(Some(id)),
            Err(error) => self.lost(by, error, warnings),
        }
    }

    /// Returns the texture id of a picture that is cut out below an alpha.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if a copy of the picture exceeds the limits.
    pub(super) fn cutout_of(&mut self, picture: &Picture, least: u8) -> Result<TextureId, Error> {
        let counts = self.alphas(picture);
        let between = usize::from(least.min(MASK_ALPHA))..usize::from(least.max(MASK_ALPHA));
        if counts[between].iter().all(|&count| count == 0) {
            return Ok(self.id(picture));
        }
        // Thresholds that cut the same pixels share one texture.
        let least = (least..=255).find(|&alpha| counts[usize::from(alpha)] > 0).unwrap_or(255);
        let wrap = picture.texture.wrap;
        let texture = match self.pictures[picture.number].cut.get(&least) {
            Some(texture) => texture.clone(),
            None => {
                let texture = self.cut(picture, least)?;
                self.pictures[picture.number].cut.insert(least, texture.clone());
                texture
            }
        };
        Ok(self.added((picture.number, wrap, Some(least), false), texture.wrap(wrap)))
    }

    /// Returns a copy of a picture with an alpha of 255 from `least` on, 0 below.
    fn cut(&mut self, picture: &Picture, least: u8) -> Result<Texture, Error> {
        let TextureKind::Image { size: [width, height], pixels } = picture.texture.kind() else {
            return Ok(picture.texture.clone());
        };
        let (count, left) = (pixels.len() as u64, &mut self.limits_left.texture_pixels);
        *left = left.checked_sub(count).ok_or_else(|| Error::TooLarge {
            path: self.document.path.into(),
            size: format!("the cut-out copy of its picture has another {width}x{height} pixels, {count} in all"),
            limit: *left,
            remedy: format!("raise it with {} if the size is intended", self.limits_left.texture_option_name),
        })?;
        let cut = |&[r, g, b, alpha]: &[u8; 4]| [r, g, b, if alpha >= least { 255 } else { 0 }];
        Texture::image(*width, *height, pixels.iter().map(cut).collect())
    }

    fn added(&mut self, key: Key, texture: Texture) -> TextureId {
        *self.ids.entry(key).or_insert_with(|| {
            self.new.push(texture);
            TextureId((self.moved + self.new.len()) as u32 - 1)
        })
    }

    /// Adds new textures to the scene.
    pub(super) fn move_to(&mut self, scene: &mut Scene) {
        self.moved += self.new.len();
        for texture in self.new.drain(..) {
            scene.add_texture(texture);
        }
    }

    /// Returns the image of a texture, or `None` if only unsupported extensions have one.
    fn image(&self, index: Index<Description>, by: &str) -> Result<Option<usize>, Error> {
        let description = self.document.item(("textures", &self.document.root.textures), index.value(), by)?;
        let own = Some(description.source.value()).filter(|&source| source != u32::MAX as usize);
        Ok(self.document.extended_image(index.value()).or(own))
    }

    /// Returns the index of a texture's image and of its picture. Returns `None` for an unreadable picture if that is
    /// no error.
    fn number(
        &mut self,
        index: Index<Description>,
        by: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<(usize, usize)>, Error> {
        let Some(image) = self.image(index, by)? else {
            return self.lost(by, self.document.fault("it has no picture of a supported type".into()), warnings);
        };
        if cfg!(not(feature = "textures")) {
            let text = format_args!("{by} is ignored: stereotrace is built without its feature `textures`");
            warnings.warn("textures", None, text);
            return Ok(None);
        }
        let number = match self.of_images.get(&image) {
            Some(&number) => number,
            None => {
                let next = self.pictures.len();
                let source = self.source(image, by);
                let number = source.as_ref().map_or(next, |source| *self.of_sources.get(source).unwrap_or(&next));
                self.of_images.insert(image, number);
                if number == next {
                    self.pictures.push(Known::default());
                }
                match source {
                    Ok(source) => drop(self.of_sources.insert(source, number)),
                    Err(error) => return self.faulty(number, by, error, warnings),
                }
                number
            }
        };
        match &self.pictures[number].fault {
            None => Ok(Some((image, number))),
            Some(fault) => {
                warn_of_lost(by, fault, warnings);
                Ok(None)
            }
        }
    }

    /// Returns the texture of an image's picture. Returns `None` for an unreadable picture if that is no error.
    fn loaded(
        &mut self,
        (image, number): (usize, usize),
        by: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<Texture>, Error> {
        if let Some(texture) = &self.pictures[number].texture {
            return Ok(Some(texture.clone()));
        }
        match self.load(image, by) {
            Ok(texture) => Ok(Some(texture)),
            Err(error) => self.faulty(number, by, error, warnings),
        }
    }

    /// Stores why a picture can't be read, so that it is not read again.
    fn faulty<T>(
        &mut self,
        number: usize,
        by: &str,
        error: Error,
        warnings: &mut Warnings,
    ) -> Result<Option<T>, Error> {
        self.pictures[number].fault = Some(reason(&error));
        self.lost(by, error, warnings)
    }

    /// Returns an error or logs a warning for an unreadable texture.
    fn lost<T>(&self, by: &str, error: Error, warnings: &mut Warnings) -> Result<Option<T>, Error> {
        let reason = reason(&error);
        match self.missing {
            MissingTextures::Error => {
                Err(Error::parse_from(self.document.path, None, format!("{by}: {reason}"), error))
            }
            MissingTextures::Warn => {
                warn_of_lost(by, &reason, warnings);
                Ok(None)
            }
        }
    }

    /// Returns a texture's wrap mode.
    fn wrap(&self, index: Index<Description>, warnings: &mut Warnings) -> Result<Wrap, Error> {
        let index = index.value();
        let Some(sampler) = self.document.root.textures[index].sampler else { return Ok(Wrap::Repeat) };
        let samplers = ("samplers", &*self.document.root.samplers);
        let sampler = self.document.item(samplers, sampler.value(), format_args!("textures[{index}]"))?;
        let [Checked::Valid(along_u), Checked::Valid(along_v)] = [sampler.wrap_s, sampler.wrap_t] else {
            return Err(self.document.fault(format!("the sampler of textures[{index}]: its wrap mode is unknown")));
        };
        if along_u != along_v {
            warnings
                .left_out("wrapT modes that differ from wrapS, which is used for both", Place::Item("textures", index));
        }
        if sampler.mag_filter == Some(Checked::Valid(MagFilter::Nearest)) {
            warnings.left_out("nearest-pixel filters", Place::Item("textures", index));
        }
        Ok(match along_u {
            WrappingMode::ClampToEdge => Wrap::Clamp,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::Repeat => Wrap::Repeat,
        })
    }

    #[cfg(feature = "textures")]
    fn source(&self, index: usize, by: &str) -> Result<Source, Error> {
        let (document, name) = (self.document, format!("images[{index}]"));
        let image = document.item(("images", &document.root.images), index, by)?;
        Ok(match (&image.uri, image.buffer_view) {
            (Some(uri), _) if Document::is_data(uri) => Source::Uri(index),
            (Some(uri), _) => Source::File(document.files.real(&document.located(uri, &name)?)),
            (None, Some(view)) => Source::Bytes(document.view(view, &name)?.1),
            (None, None) => return Err(document.fault(format!("{name} has no URI and no bufferView"))),
        })
    }

    #[cfg(feature = "textures")]
    fn load(&self, index: usize, by: &str) -> Result<Texture, Error> {
        let (document, name) = (self.document, format!("images[{index}]"));
        let image = document.item(("images", &document.root.images), index, by)?;
        let (mut limits, mut pixels) = (self.limits_left, 0);
        limits.texture_pixels = limits.texture_pixels.min(self.decodable.get());
        let mut decode =
            |bytes: &[u8]| Texture::decode_counted(document.path, std::io::Cursor::new(bytes), &limits, &mut pixels);
        let loaded = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match document.decoded(uri, &name)? {
                Some(bytes) => decode(&bytes),
                None => Texture::open_from(document.files, &document.located(uri, &name)?, &limits, &mut pixels),
            },
            (None, Some(view)) => decode(document.view(view, &name)?.1),
            (None, None) => Err(document.fault(format!("{name} has no URI and no bufferView"))),
        };
        // Broken pictures count too, since all their pixels may have been decoded.
        self.decodable.set(self.decodable.get() - pixels);
        loaded
    }

    #[cfg(not(feature = "textures"))]
    fn source(&self, _: usize, by: &str) -> Result<Source, Error> {
        unreachable!("{by} is left out before it is read")
    }

    #[cfg(not(feature = "textures"))]
    fn load(&self, _: usize, by: &str) -> Result<Texture, Error> {
        unreachable!("{by} is left out before it is read")
    }
}

/// Logs an unreadable texture. The text is formatted only if printed, since thousands of materials may share a long
/// reason.
fn warn_of_lost(by: &str, reason: &str, warnings: &mut Warnings) {
    warnings.warn(
        "textures that can't be read",
        None,
        format_args!("{by}: {reason}; the material is rendered without it"),
    );
}

/// Returns an error's text without the path of the main file, since messages truncate long words.
fn reason(error: &Error) -> String {
    match error {
        Error::Io { source, path } => format!("{}: {source}", path.display()),
        Error::Parse { reason, .. } => reason.clone(),
        Error::TooLarge { size, limit, remedy, .. } => format!("{size}, over the limit of {limit}; {remedy}"),
        other => other.to_string(),
    }
}

/// Returns the number of a texture's pixels by alpha.
fn alphas(texture: &Texture) -> [u64; 256] {
    let mut counts = [0; 256];
    if let TextureKind::Image { pixels, .. } = texture.kind() {
        pixels.iter().for_each(|pixel| counts[usize::from(pixel[3])] += 1);
    }
    counts
}

/// Returns exact means, from the number of pixels with each value.
fn means(texture: &Texture) -> Means {
    let TextureKind::Image { pixels, .. } = texture.kind() else {
        return Means { light: Vec3::ONE, values: Vec3::ONE };
    };
    let mut counts = [[0u64; 3]; 256];
    for pixel in pixels.iter() {
        (0..3).for_each(|channel| counts[usize::from(pixel[channel])][channel] += 1);
    }
    let (mut light, mut values) = (DVec3::ZERO, DVec3::ZERO);
    for (value, counts) in counts.iter().enumerate() {
        let counts = DVec3::from_array(counts.map(|count| count as f64));
        let value = value as f32 / 255.0;
        light += f64::from(linear(value)) * counts;
        values += f64::from(value) * counts;
    }
    let count = pixels.len() as f64;
    Means { light: (light / count).as_vec3(), values: (values / count).as_vec3() }
}
