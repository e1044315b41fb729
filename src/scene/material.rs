//! Surface materials.

use glam::Vec3;

use super::{Principled, TextureId};

/// Minimum alpha of a solid pixel.
pub(crate) const MASK_ALPHA: u8 = 128;

/// Index of a [`Material`] in its [`Scene`](super::Scene). The default is the grey material of every scene.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MaterialId(pub u32);

/// Reflection and refraction of a surface, besides diffuse reflection.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Finish {
    /// Highlights of the lights only, unless [`Material::specular`] is black. MTL: `illum` 0 to 2.
    #[default]
    Matte,
    /// A mirror that reflects the share [`Material::specular`]. MTL: `illum` 3, 5 and 8.
    Mirror {
        /// Whether the share grows towards white at grazing angles (`illum` 5).
        fresnel: bool,
    },
    /// A refracting surface. MTL: `illum` 4, 6, 7 and 9.
    Glass {
        /// Index of refraction relative to the surroundings, 0.1 to 10; window glass has 1.5. MTL's `Ni`.
        index: f32,
        /// Share of the light that is transmitted, linear RGB, 0 to 1. MTL's `Tf`.
        transmission: Vec3,
        /// Whether the view angle splits light into a reflected share, from [`Material::specular`], and the transmitted
        /// remainder (`illum` 7). Otherwise all light is transmitted, except in total reflection.
        fresnel: bool,
    },
}

/// A surface material: diffuse reflection, highlights, mirror or glass, opacity and emission.
///
/// ```
/// use stereotrace::{Finish, Material, glam::Vec3};
///
/// let lacquer = Material::new(Vec3::new(0.5, 0.05, 0.05)).name("lacquer").specular(Vec3::splat(0.4)).exponent(60.0);
/// let silver = Material::new(Vec3::ZERO).specular(Vec3::splat(0.95)).finish(Finish::Mirror { fresnel: false });
/// # let _ = (lacquer, silver);
/// ```
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Material {
    /// Name in the file, or empty.
    pub name: String,
    /// Diffuse (Lambertian) reflectance, linear RGB, 0 to 1. MTL's `Kd`.
    pub albedo: Vec3,
    /// Texture whose colour multiplies the albedo. MTL's `map_Kd`.
    pub texture: Option<TextureId>,
    /// Texture whose alpha cuts holes: where it is below a half, rays pass through. The nearest pixel counts, without a
    /// filter. A checkerboard's alpha is its colours' brightness. Only triangles can be cut out; those without texture
    /// coordinates use the lower left pixel. MTL's `map_d`.
    pub cutout: Option<TextureId>,
    /// Share of the background that the surface hides, 0 to 1. MTL's `d`, or 1 - `Tr`.
    pub opacity: f32,
    /// Whether the alpha of `texture` multiplies the opacity; glass ignores it. A checkerboard's alpha is its colours'
    /// brightness, at most 1.
    #[cfg_attr(feature = "serde", serde(default))]
    pub alpha_blend: bool,
    /// Colour of highlights, or the share that a mirror or glass reflects; linear RGB, 0 to 1. MTL's `Ks`.
    pub specular: Vec3,
    /// Phong exponent, 0 to 10000; larger exponents give smaller highlights. MTL's `Ns`.
    pub exponent: f32,
    /// Whether highlights conserve energy, see [`Material::normalised`]. MTL's highlights don't.
    pub normalised: bool,
    /// Emitted radiance, linear RGB. It lights other surfaces only by paths of light. MTL's `Ke`.
    pub emission: Vec3,
    /// Reflection and refraction. MTL's `illum`.
    pub finish: Finish,
    /// Physically based surface; `None` by default. Paths of light show it in place of the other values, except the
    /// textures and the opacity. glTF files set it.
    #[cfg_attr(feature = "serde", serde(default))]
    pub principled: Option<Principled>,
}

impl Material {
    /// Default Phong exponent.
    pub(crate) const DEFAULT_EXPONENT: f32 = 30.0;

    /// Makes a diffuse, opaque material without a name. The albedo is linear RGB, 0 to 1.
    pub fn new(albedo: Vec3) -> Self {
        Self {
            name: String::new(),
            albedo,
            texture: None,
            cutout: None,
            opacity: 1.0,
            alpha_blend: false,
            specular: Vec3::ZERO,
            exponent: Self::DEFAULT_EXPONENT,
            normalised: false,
            emission: Vec3::ZERO,
            finish: Finish::Matte,
            principled: None,
        }
    }

    /// Sets the name, for messages.
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Sets the texture whose colour multiplies the albedo.
    pub fn texture(mut self, texture: TextureId) -> Self {
        self.texture = Some(texture);
        self
    }

    /// Sets the texture that cuts holes where its alpha is below a half.
    pub fn cutout(mut self, cutout: TextureId) -> Self {
        self.cutout = Some(cutout);
        self
    }

    /// Sets the share of the background that the surface hides, 0 to 1. The default is 1.
    pub fn opacity(mut self, opacity: f32) -> Self {
        self.opacity = opacity;
        self
    }

    /// Sets whether the alpha of the texture multiplies the opacity. The default is false.
    pub fn alpha_blend(mut self, blend: bool) -> Self {
        self.alpha_blend = blend;
        self
    }

    /// Sets the colour of highlights, or the share that a mirror or glass reflects; linear RGB, 0 to 1. The default is
    /// black.
    pub fn specular(mut self, specular: Vec3) -> Self {
        self.specular = specular;
        self
    }

    /// Sets the Phong exponent, 0 to 10000. The default is 30.
    pub fn exponent(mut self, exponent: f32) -> Self {
        self.exponent = exponent;
        self
    }

    /// Sets whether highlights conserve energy; the default is false. Then [`Material::specular`] is the share of a
    /// light that they reflect.
    ///
    /// A light of intensity I adds `I specular (n + 2)/2 max(0, r·v)ⁿ max(0, n·l)` for the exponent n. This is a
    /// reciprocal reflectance of `specular (n + 2)/2π max(0, r·v)ⁿ` (Lafortune & Willems 1994, "Using the Modified
    /// Phong Reflectance Model"). For light from straight above, its sum over all directions is `specular`. It is less
    /// where the surface cuts off a part of the lobe. Albedo plus specular may then be at most 1 in each channel.
    ///
    /// By default, MTL's Phong adds `I specular max(0, r·v)ⁿ`. From straight above it returns the light's share
    /// `2 specular / (n + 1)`: hardly any for small highlights, more than `specular` for exponents below 1.
    ///
    /// Reflections of the surroundings in mirrors and glass don't change, but lights' highlights on them do.
    pub fn normalised(mut self, normalised: bool) -> Self {
        self.normalised = normalised;
        self
    }

    /// Sets the emitted radiance, linear RGB. The default is black.
    pub fn emission(mut self, emission: Vec3) -> Self {
        self.emission = emission;
        self
    }

    /// Sets reflection and refraction. The default is [`Finish::Matte`].
    pub fn finish(mut self, finish: Finish) -> Self {
        self.finish = finish;
        self
    }

    /// Returns whether the material has highlights or emits light.
    pub(crate) fn shines(&self) -> bool {
        self.emission != Vec3::ZERO || self.specular != Vec3::ZERO
    }

    /// Returns whether it has highlights that conserve energy.
    pub(crate) fn shines_normalised(&self) -> bool {
        self.normalised && self.specular != Vec3::ZERO
    }

    /// Returns whether hits on the material send further rays: a mirror, glass, or a surface with an opacity below 1.
    pub(crate) fn sends_rays(&self) -> bool {
        self.finish != Finish::Matte || self.opacity < 1.0 || self.blends()
    }

    /// Returns whether its texture's alpha multiplies the opacity.
    pub(crate) fn blends(&self) -> bool {
        self.alpha_blend && self.texture.is_some() && !matches!(self.finish, Finish::Glass { .. })
    }

    /// Returns the largest share of each channel's light that the material can return: diffuse, reflected and
    /// transmitted. It ignores highlights that don't conserve energy.
    pub(crate) fn most_returned(&self) -> Vec3 {
        let (albedo, reflected) = (self.albedo, self.specular);
        match self.finish {
            Finish::Matte if !self.normalised => albedo,
            Finish::Matte | Finish::Mirror { .. } => albedo + reflected,
            // Light is either reflected or transmitted, depending on the angle.
            Finish::Glass { transmission, fresnel: true, .. } => albedo + reflected.max(transmission),
            Finish::Glass { transmission, .. } => albedo + reflected + (Vec3::ONE - reflected) * transmission,
        }
    }

    /// Scales the shares so that the material returns at most 1. Returns whether it had returned more.
    #[cfg(any(feature = "obj", feature = "gltf", test))]
    pub(crate) fn conserve(&mut self) -> bool {
        if self.most_returned().max_element() <= 1.0 {
            return false;
        }
        // The transmitted share is t of the light that is not reflected.
        // Scaling everything by k gives k (a + r + t) - k² r t = 1.
        let passed = match self.finish {
            Finish::Glass { transmission, fresnel: false, .. } => transmission,
            _ => Vec3::ZERO,
        };
        let (sum, product) = (self.most_returned() + self.specular * passed, self.specular * passed);
        let scale = |channel: usize| {
            let (sum, product) = (f64::from(sum[channel]), f64::from(product[channel]));
            2.0 / (sum + (sum * sum - 4.0 * product).max(0.0).sqrt())
        };
        let scale = (0..3).map(scale).fold(1.0, f64::min) as f32;
        self.albedo *= scale;
        self.specular *= scale;
        if let Finish::Glass { transmission, .. } = &mut self.finish {
            *transmission *= scale;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn what_is_scaled_down_returns_all_that_came_and_no_more() {
        let mut random = Random::new(5);
        let mut scaled = 0;
        for index in 0..3000 {
            let mut color = || Vec3::from_array([(); 3].map(|()| random.unit()));
            let transmission = color();
            let finish = match index % 4 {
                0 => Finish::Matte,
                1 => Finish::Mirror { fresnel: false },
                kind => Finish::Glass { index: 1.5, transmission, fresnel: kind == 2 },
            };
            let before = Material::new(color()).specular(color()).normalised(index % 8 == 0).finish(finish);
            let mut after = before.clone();
            if after.conserve() {
                scaled += 1;
                assert!((after.most_returned().max_element() - 1.0).abs() < 1e-5, "{before:?} {after:?}");
                assert!(after.albedo.cmple(before.albedo).all(), "{before:?} {after:?}");
            } else {
                assert!(after == before && before.most_returned().max_element() <= 1.0);
            }
        }
        assert!(scaled > 1000, "{scaled}");
    }
}
