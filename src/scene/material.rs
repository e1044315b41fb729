//! What surfaces are made of.

use glam::Vec3;

use super::TextureId;

/// Index of a [`Material`] in its [`Scene`](super::Scene); the default is the grey that every scene begins with.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MaterialId(pub u32);

/// What a surface does with light beside scattering it.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Finish {
    /// Nothing but highlights of the lights, where [`Material::specular`] is not black. MTL: `illum` 0 to 2.
    #[default]
    Matte,
    /// It mirrors its surroundings by the share of [`Material::specular`]. MTL: `illum` 3, 5 and 8.
    Mirror {
        /// The share grows towards white as the view grazes the surface (`illum` 5).
        fresnel: bool,
    },
    /// It refracts what is behind it. MTL: `illum` 4, 6, 7 and 9.
    Glass {
        /// Index of refraction over that of what surrounds it, 0.1 to 10; window glass has 1.5. MTL's `Ni`.
        index: f32,
        /// Share of the light that comes through, linear RGB, 0 to 1. MTL's `Tf`.
        transmission: Vec3,
        /// The angle of view says how much is reflected, by the share of [`Material::specular`], and what is left
        /// comes through (`illum` 7). Else all of it comes through but for what is reflected totally.
        fresnel: bool,
    },
}

/// A surface: what it scatters, shines, reflects, lets through and gives off.
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
    /// The material's name in its file, or empty.
    pub name: String,
    /// Diffuse (Lambertian) reflectance, linear RGB, 0 to 1. MTL's `Kd`.
    pub albedo: Vec3,
    /// The albedo is multiplied by this texture's colour; its alpha says nothing. MTL's `map_Kd`.
    pub texture: Option<TextureId>,
    /// Where this texture's alpha is below a half there is no surface: no ray meets it there, and light passes. The
    /// texture's nearest pixel says, without a filter. A checkerboard's alpha is its colours' brightness.
    /// Triangles only; those without texture coordinates are in the lower left pixel. MTL's `map_d`.
    pub cutout: Option<TextureId>,
    /// The share of what is behind the surface that it hides, 0 to 1. MTL's `d`, or 1 - `Tr`.
    pub opacity: f32,
    /// Colour of highlights; of mirrors and glass the share that they reflect. Linear RGB, 0 to 1. MTL's `Ks`.
    pub specular: Vec3,
    /// Phong's exponent: the larger, the smaller a highlight; 0 to 10000. MTL's `Ns`.
    pub exponent: f32,
    /// Whether highlights are of as much light as [`Material::specular`] says, as [`Material::normalised`] has it.
    /// MTL's are not.
    pub normalised: bool,
    /// Radiance that it gives off by itself, linear RGB. It lights nothing else. MTL's `Ke`.
    pub emission: Vec3,
    /// What it does with light beside scattering it. MTL's `illum`.
    pub finish: Finish,
}

impl Material {
    /// Phong's exponent where nothing is said.
    pub(crate) const DEFAULT_EXPONENT: f32 = 30.0;

    /// A diffuse, opaque material without a name: reflectance in linear RGB, 0 to 1.
    pub fn new(albedo: Vec3) -> Self {
        Self {
            name: String::new(),
            albedo,
            texture: None,
            cutout: None,
            opacity: 1.0,
            specular: Vec3::ZERO,
            exponent: Self::DEFAULT_EXPONENT,
            normalised: false,
            emission: Vec3::ZERO,
            finish: Finish::Matte,
        }
    }

    /// Its name, for messages.
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// What its albedo is multiplied by.
    pub fn texture(mut self, texture: TextureId) -> Self {
        self.texture = Some(texture);
        self
    }

    /// Where there is no surface: where this texture's alpha is below a half.
    pub fn cutout(mut self, cutout: TextureId) -> Self {
        self.cutout = Some(cutout);
        self
    }

    /// The share of what is behind it that it hides, 0 to 1. 1 where nothing is said.
    pub fn opacity(mut self, opacity: f32) -> Self {
        self.opacity = opacity;
        self
    }

    /// Colour of its highlights, or what a mirror or glass reflects; linear RGB, 0 to 1. Black where nothing is said.
    pub fn specular(mut self, specular: Vec3) -> Self {
        self.specular = specular;
        self
    }

    /// Phong's exponent, 0 to 10000. 30 where nothing is said.
    pub fn exponent(mut self, exponent: f32) -> Self {
        self.exponent = exponent;
        self
    }

    /// Whether highlights conserve energy, so that [`Material::specular`] is the share of a light that they send on. A
    /// light of intensity I then adds `I specular (n + 2)/2 max(0, r·v)ⁿ max(0, n·l)` for the exponent n (Lafortune
    /// & Willems 1994, "Using the Modified Phong Reflectance Model": a reflectance of `specular (n + 2)/2π max(0,
    /// r·v)ⁿ`, alike in both directions), whose sum over all directions is `specular` where light comes
    /// straight from above, and less the more of the lobe the surface cuts off. Albedo and specular may then be at most
    /// 1 together in each channel. By MTL's Phong, where nothing is said, it is `I specular max(0, r·v)ⁿ`, of which
    /// straight above `2 specular / (n + 1)` of the light comes back: of small highlights hardly any, of exponents
    /// below 1 more than `specular`. What mirrors and glass reflect of their surroundings stays what it is; lights'
    /// highlights on them change alike.
    pub fn normalised(mut self, normalised: bool) -> Self {
        self.normalised = normalised;
        self
    }

    /// Radiance that it gives off, linear RGB. Black where nothing is said.
    pub fn emission(mut self, emission: Vec3) -> Self {
        self.emission = emission;
        self
    }

    /// Whether it mirrors or refracts. It does neither where nothing is said.
    pub fn finish(mut self, finish: Finish) -> Self {
        self.finish = finish;
        self
    }

    /// Whether it has highlights or gives off light.
    pub(crate) fn shines(&self) -> bool {
        self.emission != Vec3::ZERO || self.specular != Vec3::ZERO
    }

    /// Whether it has highlights that conserve energy.
    pub(crate) fn shines_normalised(&self) -> bool {
        self.normalised && self.specular != Vec3::ZERO
    }

    /// Whether rays go on from it: a mirror, glass, or a veil that hides only a share of what is behind it.
    pub(crate) fn sends_rays(&self) -> bool {
        self.finish != Finish::Matte || self.opacity < 1.0
    }

    /// The most that it sends back of the light of each channel: what it scatters, and what it reflects and lets
    /// through. Highlights that don't conserve energy are left out.
    pub(super) fn most_returned(&self) -> Vec3 {
        let (albedo, reflected) = (self.albedo, self.specular);
        match self.finish {
            Finish::Matte if !self.normalised => albedo,
            Finish::Matte | Finish::Mirror { .. } => albedo + reflected,
            // The angle says which share is whose.
            Finish::Glass { transmission, fresnel: true, .. } => albedo + reflected.max(transmission),
            Finish::Glass { transmission, .. } => albedo + reflected + (Vec3::ONE - reflected) * transmission,
        }
    }

    /// Scales all of that down to what came, and says whether it was more.
    #[cfg(any(feature = "obj", feature = "gltf", test))]
    pub(super) fn conserve(&mut self) -> bool {
        if self.most_returned().max_element() <= 1.0 {
            return false;
        }
        // What is let through is a share of what is not reflected: with all of it k times as much, k (a + r + t) - k² r
        // t is to be 1.
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
