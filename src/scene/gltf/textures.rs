//! Pictures, each read once, and what materials make of them.

use std::{collections::HashMap, sync::Arc};

use glam::{DVec3, Vec3};
use gltf_json::{
    Image, Index, Texture as Description,
    texture::{MagFilter, WrappingMode},
    validation::Checked,
};

use super::document::Document;
use crate::{
    Error, Limits, MissingTextures, Scene, Texture, TextureId, TextureKind, Wrap,
    scene::{
        SceneOptions, linear,
        warnings::{Place, Warnings},
    },
};

/// A picture as a texture shows it.
#[derive(Clone)]
pub(super) struct Picture {
    image: usize,
    pub(super) texture: Texture,
}

/// The means of a picture's red, green and blue, 0 to 1.
#[derive(Clone, Copy)]
pub(super) struct Means {
    /// Of sRGB, as light.
    pub(super) light: Vec3,
    /// Of its values as they are.
    pub(super) values: Vec3,
}

/// The textures of a file.
pub(super) struct Textures<'a> {
    document: &'a Document<'a>,
    missing: MissingTextures,
    limits_left: Limits,
    read: HashMap<usize, Texture>,
    means: HashMap<usize, Means>,
    /// By image, wrap, and the alpha from which on there is a surface.
    ids: HashMap<(usize, Wrap, Option<u8>), TextureId>,
    /// Those that no scene has yet, and how many it has.
    new: Vec<Texture>,
    moved: usize,
}

impl<'a> Textures<'a> {
    pub(super) fn new(document: &'a Document<'a>, options: &SceneOptions) -> Self {
        Self {
            document,
            missing: options.missing_textures,
            limits_left: options.limits,
            read: HashMap::new(),
            means: HashMap::new(),
            ids: HashMap::new(),
            new: Vec::new(),
            moved: 0,
        }
    }

    /// The picture of a texture that `by` names; `None` for one that can't be read, where that is no error.
    pub(super) fn picture(
        &mut self,
        index: Index<Description>,
        by: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<Picture>, Error> {
        let (image, description) = self.image(index, by)?;
        let Some(image) = image else { return self.lost(by, "it has no picture that is read", None, warnings) };
        let texture = match self.read.get(&image.0) {
            Some(texture) => Ok(texture.clone()),
            None => self.load(image, by, warnings)?,
        };
        match texture {
            Ok(texture) => {
                if let TextureKind::Image { pixels, .. } = texture.kind()
                    && self.read.insert(image.0, texture.clone()).is_none()
                {
                    let left = &mut self.limits_left.texture_pixels;
                    *left = left.saturating_sub(pixels.len() as u64);
                }
                let wrap = self.wrap(description, index.value(), warnings)?;
                Ok(Some(Picture { image: image.0, texture: texture.wrap(wrap) }))
            }
            Err(None) => Ok(None),
            Err(Some(error)) => self.lost(by, &reason(&error), Some(error), warnings),
        }
    }

    /// The means of a texture's picture, which is not kept.
    pub(super) fn means(
        &mut self,
        index: Index<Description>,
        by: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<Means>, Error> {
        let (image, _) = self.image(index, by)?;
        let Some(image) = image else { return self.lost(by, "it has no picture that is read", None, warnings) };
        if let Some(means) = self.means.get(&image.0) {
            return Ok(Some(*means));
        }
        let texture = match self.read.get(&image.0) {
            Some(texture) => Ok(texture.clone()),
            None => self.load(image, by, warnings)?,
        };
        match texture {
            Ok(texture) => {
                let means = means(&texture);
                self.means.insert(image.0, means);
                Ok(Some(means))
            }
            Err(None) => Ok(None),
            Err(Some(error)) => self.lost(by, &reason(&error), Some(error), warnings),
        }
    }

    /// The number of a picture among the scene's textures; where `least` is given, with an alpha of 255 from there on and of 0 below.
    pub(super) fn id(&mut self, picture: &Picture, least: Option<u8>) -> Result<TextureId, Error> {
        let key = (picture.image, picture.texture.wrap, least);
        if let Some(&id) = self.ids.get(&key) {
            return Ok(id);
        }
        let texture = match (least, picture.texture.kind()) {
            (Some(least), TextureKind::Image { size: [width, height], pixels }) => {
                let mut pixels = Vec::clone(pixels);
                pixels.iter_mut().for_each(|pixel| pixel[3] = if pixel[3] >= least { 255 } else { 0 });
                let left = &mut self.limits_left.texture_pixels;
                *left = left.saturating_sub(pixels.len() as u64);
                Texture::image(*width, *height, pixels)?.wrap(picture.texture.wrap)
            }
            _ => picture.texture.clone(),
        };
        self.new.push(texture);
        let id = TextureId((self.moved + self.new.len()) as u32 - 1);
        self.ids.insert(key, id);
        Ok(id)
    }

    /// Gives the scene those that it has not.
    pub(super) fn move_to(&mut self, scene: &mut Scene) {
        self.moved += self.new.len();
        for texture in self.new.drain(..) {
            scene.add_texture(texture);
        }
    }

    /// The image of a texture, if it has one that can be read.
    fn image(
        &self,
        index: Index<Description>,
        by: &str,
    ) -> Result<(Option<(usize, &'a Image)>, &'a Description), Error> {
        let root = &self.document.root;
        let description = self.document.item(("textures", &root.textures), index.value(), by)?;
        let source = description.source.value();
        if source == u32::MAX as usize {
            return Ok((None, description)); // in a format of an extension alone
        }
        let name = format!("textures[{}]", index.value());
        let image = self.document.item(("images", &root.images), source, name)?;
        Ok((Some((source, image)), description))
    }

    /// What becomes of a texture that can't be read.
    fn lost<T>(
        &self,
        by: &str,
        reason: &str,
        error: Option<Error>,
        warnings: &mut Warnings,
    ) -> Result<Option<T>, Error> {
        let text = format!("{by}: {reason}");
        match (self.missing, error) {
            (MissingTextures::Error, Some(error)) => Err(Error::parse_from(self.document.path, None, text, error)),
            (MissingTextures::Error, None) => Err(self.document.fault(text)),
            (MissingTextures::Warn, _) => {
                warnings.warn("textures that can't be read", None, format!("{text}; the material is without it"));
                Ok(None)
            }
        }
    }

    /// What lies beyond a texture's edges.
    fn wrap(&self, description: &Description, index: usize, warnings: &mut Warnings) -> Result<Wrap, Error> {
        let Some(sampler) = description.sampler else { return Ok(Wrap::Repeat) };
        let samplers = ("samplers", &*self.document.root.samplers);
        let sampler = self.document.item(samplers, sampler.value(), format_args!("textures[{index}]"))?;
        let [Checked::Valid(along_u), Checked::Valid(along_v)] = [sampler.wrap_s, sampler.wrap_t] else {
            return Err(self
                .document
                .fault(format!("the sampler of textures[{index}]: its wrap is none that there is")));
        };
        if along_u != along_v {
            warnings.left_out(
                "textures whose wrapT is not their wrapS, which is taken for both",
                Place::Item("textures", index),
            );
        }
        if sampler.mag_filter == Some(Checked::Valid(MagFilter::Nearest)) {
            warnings.left_out("filters that take the nearest pixel", Place::Item("textures", index));
        }
        Ok(match along_u {
            WrappingMode::ClampToEdge => Wrap::Clamp,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::Repeat => Wrap::Repeat,
        })
    }

    /// A picture, or what hinders: `None` where no picture is read at all.
    #[cfg(feature = "textures")]
    fn load(
        &self,
        (index, image): (usize, &Image),
        _: &str,
        _: &mut Warnings,
    ) -> Result<Result<Texture, Option<Error>>, Error> {
        let (document, name) = (self.document, format!("images[{index}]"));
        let decode = |bytes: &[u8]| Texture::decode(document.path, std::io::Cursor::new(bytes), &self.limits_left);
        let texture = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match document.decoded(uri, &name)? {
                Some(bytes) => decode(&bytes),
                None => Texture::open_within(document.located(uri, &name)?, &self.limits_left),
            },
            (None, Some(view)) => decode(document.view(view, &name)?.1),
            (None, None) => Err(document.fault(format!("{name} has no URI and no bufferView"))),
        };
        Ok(texture.map_err(Some))
    }

    #[cfg(not(feature = "textures"))]
    #[allow(clippy::unnecessary_wraps, reason = "where textures are read, it may fail")]
    fn load(
        &self,
        _: (usize, &Image),
        by: &str,
        warnings: &mut Warnings,
    ) -> Result<Result<Texture, Option<Error>>, Error> {
        let text = format!("{by} is left out: stereotrace is built without its feature `textures`");
        warnings.warn("textures", None, text);
        Ok(Err(None))
    }
}

/// Without the path of a file that is named already: messages cut long words.
fn reason(error: &Error) -> String {
    match error {
        Error::Io { source, path } => format!("{}: {source}", path.display()),
        Error::Parse { reason, .. } => reason.clone(),
        Error::TooLarge { size, limit, remedy, .. } => format!("{size}, over the limit of {limit}; {remedy}"),
        other => other.to_string(),
    }
}

impl Picture {
    /// How many of its pixels have each alpha.
    pub(super) fn alphas(&self) -> [u64; 256] {
        let mut counts = [0; 256];
        if let TextureKind::Image { pixels, .. } = self.texture.kind() {
            Arc::as_ref(pixels).iter().for_each(|pixel| counts[usize::from(pixel[3])] += 1);
        }
        counts
    }

    pub(super) fn mean_light(&self) -> Vec3 {
        means(&self.texture).light
    }
}

/// Exactly, by how many pixels have each value.
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
