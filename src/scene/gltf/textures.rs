//! Pictures, each read once, and what materials make of them.

use std::{collections::HashMap, sync::Arc};

use glam::{DVec3, Vec3};
use gltf_json::{
    Index, Texture as Description,
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
        let Some((image, texture)) = self.loaded(index, by, warnings)? else { return Ok(None) };
        if let TextureKind::Image { pixels, .. } = texture.kind()
            && self.read.insert(image, texture.clone()).is_none()
        {
            let left = &mut self.limits_left.texture_pixels;
            *left = left.saturating_sub(pixels.len() as u64);
        }
        let wrap = self.wrap(index, warnings)?;
        Ok(Some(Picture { image, texture: texture.wrap(wrap) }))
    }

    /// The means of a texture's picture, which is not kept.
    pub(super) fn means(
        &mut self,
        index: Index<Description>,
        by: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<Means>, Error> {
        let image = self.image(index, by)?;
        if let Some(means) = image.and_then(|image| self.means.get(&image)) {
            return Ok(Some(*means));
        }
        let Some((image, texture)) = self.loaded(index, by, warnings)? else { return Ok(None) };
        let means = means(&texture);
        self.means.insert(image, means);
        Ok(Some(means))
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

    /// The number of a texture's image, if it has one that may be read: others are of formats of extensions.
    fn image(&self, index: Index<Description>, by: &str) -> Result<Option<usize>, Error> {
        let description = self.document.item(("textures", &self.document.root.textures), index.value(), by)?;
        let own = Some(description.source.value()).filter(|&source| source != u32::MAX as usize);
        Ok(self.document.extended_image(index.value()).or(own))
    }

    /// The picture of a texture, and its image's number; `None` for one that can't be read, where that is no error.
    fn loaded(
        &self,
        index: Index<Description>,
        by: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<(usize, Texture)>, Error> {
        let Some(image) = self.image(index, by)? else {
            return self.lost(by, self.document.fault("it has no picture that is read".into()), warnings);
        };
        if let Some(texture) = self.read.get(&image) {
            return Ok(Some((image, texture.clone())));
        }
        if cfg!(not(feature = "textures")) {
            let text = format!("{by} is left out: stereotrace is built without its feature `textures`");
            warnings.warn("textures", None, text);
            return Ok(None);
        }
        match self.load(image, by) {
            Ok(texture) => Ok(Some((image, texture))),
            Err(error) => self.lost(by, error, warnings),
        }
    }

    /// What becomes of a texture that can't be read.
    fn lost<T>(&self, by: &str, error: Error, warnings: &mut Warnings) -> Result<Option<T>, Error> {
        let text = format!("{by}: {}", reason(&error));
        match self.missing {
            MissingTextures::Error => Err(Error::parse_from(self.document.path, None, text, error)),
            MissingTextures::Warn => {
                warnings.warn("textures that can't be read", None, format!("{text}; the material is without it"));
                Ok(None)
            }
        }
    }

    /// What lies beyond a texture's edges.
    fn wrap(&self, index: Index<Description>, warnings: &mut Warnings) -> Result<Wrap, Error> {
        let index = index.value();
        let Some(sampler) = self.document.root.textures[index].sampler else { return Ok(Wrap::Repeat) };
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

    #[cfg(feature = "textures")]
    fn load(&self, index: usize, by: &str) -> Result<Texture, Error> {
        let (document, name) = (self.document, format!("images[{index}]"));
        let image = document.item(("images", &document.root.images), index, by)?;
        let decode = |bytes: &[u8]| Texture::decode(document.path, std::io::Cursor::new(bytes), &self.limits_left);
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match document.decoded(uri, &name)? {
                Some(bytes) => decode(&bytes),
                None => Texture::open_from(document.files, &document.located(uri, &name)?, &self.limits_left),
            },
            (None, Some(view)) => decode(document.view(view, &name)?.1),
            (None, None) => Err(document.fault(format!("{name} has no URI and no bufferView"))),
        }
    }

    #[cfg(not(feature = "textures"))]
    fn load(&self, _: usize, by: &str) -> Result<Texture, Error> {
        unreachable!("{by} is left out before it is read")
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
