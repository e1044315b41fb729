//! Physically based surfaces: metallic-roughness with specular reflection, transmission and volume.

use glam::Vec3;

use super::{
    Finish, Material, Scene, TextureId,
    checks::{EXPONENTS, INDICES, check_color, check_within},
};

/// Roughness up to which direct light shows a mirror, since its highlights would be points.
const MIRROR_ROUGHNESS: f32 = 0.1;

/// A physically based surface (glTF 2.0, appendix B), which paths of light show ([`Lighting::Paths`]). Direct light
/// shows Phong's approximation of it, with the means of its textures.
///
/// ```
/// use stereotrace::{Material, Principled, glam::Vec3};
///
/// let gold = Material::new(Vec3::ZERO).principled(Principled::new(Vec3::new(1.0, 0.77, 0.34), 1.0, 0.3));
/// let window = Principled::new(Vec3::ONE, 0.0, 0.0).transmission(1.0).thin(true);
/// # let _ = (gold, window);
/// ```
///
/// [`Lighting::Paths`]: crate::Lighting::Paths
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Principled {
    /// Diffuse reflectance of a dielectric, or reflectance of a metal at normal incidence; linear RGB, 0 to 1.
    /// [`Material::texture`] multiplies it.
    pub base: Vec3,
    /// 0 for a dielectric, 1 for a metal.
    pub metallic: f32,
    /// Square root of GGX's alpha, 0 to 1; 0 is smooth.
    pub roughness: f32,
    /// Texture whose green multiplies the roughness.
    pub roughness_texture: Option<TextureId>,
    /// Texture whose blue multiplies `metallic`.
    pub metallic_texture: Option<TextureId>,
    /// Index of refraction of a dielectric, 0.1 to 10; 1.5 by default.
    pub index: f32,
    /// Factor of a dielectric's reflectance at normal incidence, linear RGB, 0 to 1; white by default.
    pub specular: Vec3,
    /// Reflectance of a dielectric at grazing angles, 0 to 1; 1 by default.
    pub grazing: f32,
    /// Share of the surface that a clear coat covers, 0 to 1. Its index of refraction is 1.5. Glass shows no coat.
    pub clearcoat: f32,
    /// Square root of the alpha of the coat's highlights, 0 to 1; 0 is smooth.
    pub clearcoat_roughness: f32,
    /// Texture whose red multiplies `clearcoat`.
    pub clearcoat_texture: Option<TextureId>,
    /// Texture whose green multiplies `clearcoat_roughness`.
    pub clearcoat_roughness_texture: Option<TextureId>,
    /// Share of the light that enters a dielectric and is transmitted rather than scattered, 0 to 1.
    pub transmission: f32,
    /// Texture whose red multiplies `transmission`.
    pub transmission_texture: Option<TextureId>,
    /// Whether the surface is thin: transmitted light is not refracted.
    pub thin: bool,
    /// Light that is absorbed inside, per world unit and linear RGB: the negative logarithm of the share that is left.
    pub absorption: Vec3,
    /// Texture of normals in tangent space, with green up. Only triangles with texture coordinates show it.
    pub normal_texture: Option<TextureId>,
    /// Factor of the normals' x and y; 1 by default.
    pub normal_scale: f32,
    /// Emitted radiance, linear RGB.
    pub emission: Vec3,
    /// Texture that multiplies the emitted radiance.
    pub emission_texture: Option<TextureId>,
}

impl Principled {
    /// Makes a surface from its base colour (linear RGB, 0 to 1), metallic share and roughness, both 0 to 1.
    pub fn new(base: Vec3, metallic: f32, roughness: f32) -> Self {
        Self {
            base,
            metallic,
            roughness,
            roughness_texture: None,
            metallic_texture: None,
            index: 1.5,
            specular: Vec3::ONE,
            grazing: 1.0,
            clearcoat: 0.0,
            clearcoat_roughness: 0.0,
            clearcoat_texture: None,
            clearcoat_roughness_texture: None,
            transmission: 0.0,
            transmission_texture: None,
            thin: false,
            absorption: Vec3::ZERO,
            normal_texture: None,
            normal_scale: 1.0,
            emission: Vec3::ZERO,
            emission_texture: None,
        }
    }

    /// Sets the share of the light that enters a dielectric and is transmitted, 0 to 1.
    pub fn transmission(mut self, transmission: f32) -> Self {
        self.transmission = transmission;
        self
    }

    /// Sets whether the surface is thin: transmitted light is not refracted.
    pub fn thin(mut self, thin: bool) -> Self {
        self.thin = thin;
        self
    }

    /// Sets a clear coat: the share of the surface that it covers, and its roughness, both 0 to 1.
    pub fn clearcoat(mut self, share: f32, roughness: f32) -> Self {
        (self.clearcoat, self.clearcoat_roughness) = (share, roughness);
        self
    }

    /// Sets the index of refraction, 0.1 to 10.
    pub fn index(mut self, index: f32) -> Self {
        self.index = index;
        self
    }

    /// Sets the emitted radiance, linear RGB.
    pub fn emission(mut self, emission: Vec3) -> Self {
        self.emission = emission;
        self
    }

    /// Returns the textures besides [`Material::texture`], with their names in messages.
    pub(crate) fn textures(&self) -> impl Iterator<Item = (&'static str, TextureId)> {
        let all = [
            ("roughness_texture", self.roughness_texture),
            ("metallic_texture", self.metallic_texture),
            ("normal_texture", self.normal_texture),
            ("emission_texture", self.emission_texture),
            ("transmission_texture", self.transmission_texture),
            ("clearcoat_texture", self.clearcoat_texture),
            ("clearcoat_roughness_texture", self.clearcoat_roughness_texture),
        ];
        all.into_iter().filter_map(|(name, texture)| Some((name, texture?)))
    }

    pub(crate) fn is_coated(&self) -> bool {
        self.clearcoat > 0.0
    }

    /// # Errors
    /// The reason why a value is out of range.
    pub(crate) fn check(&self) -> Result<(), String> {
        let shares = 0.0..=1.0;
        for (name, color) in [("base", self.base), ("specular", self.specular)] {
            check_color(name, color)?;
            check_within(name, color.max_element(), &shares)?;
        }
        check_color("emission", self.emission)?;
        check_color("absorption", self.absorption)?;
        check_within("metallic", self.metallic, &shares)?;
        check_within("roughness", self.roughness, &shares)?;
        check_within("transmission", self.transmission, &shares)?;
        check_within("grazing", self.grazing, &shares)?;
        check_within("clearcoat", self.clearcoat, &shares)?;
        check_within("clearcoat_roughness", self.clearcoat_roughness, &shares)?;
        check_within("normal_scale", self.normal_scale, &(-1e3..=1e3))?;
        check_within("index", self.index, &INDICES)
    }
}

impl Material {
    /// Sets a physically based surface, and Phong's approximation of it, for direct light.
    pub fn principled(mut self, surface: Principled) -> Self {
        let (name, texture, cutout) = (self.name, self.texture, self.cutout);
        let (opacity, blend) = (self.opacity, self.alpha_blend);
        self = phong(&surface, Vec3::ONE).name(name).emission(surface.emission).alpha_blend(blend);
        if !matches!(self.finish, Finish::Glass { .. }) {
            self.opacity = opacity;
        }
        (self.texture, self.cutout, self.principled) = (texture, cutout, Some(surface));
        self
    }
}

impl Scene {
    /// Returns whether some material is physically based.
    pub(crate) fn has_principled(&self) -> bool {
        self.materials.iter().any(|material| material.principled.is_some())
    }

    /// Returns whether some material has a clear coat.
    pub(crate) fn has_coats(&self) -> bool {
        self.materials.iter().any(|material| material.principled.is_some_and(|surface| surface.is_coated()))
    }
}

/// Returns Phong's approximation of a surface. `mean` is the mean of the base colour's texture, since highlights have
/// no texture.
pub(crate) fn phong(surface: &Principled, mean: Vec3) -> Material {
    /// Reflectance of dielectrics at normal incidence, by the specification.
    const DIELECTRIC: f32 = 0.04;
    let Principled { base, metallic: metal, roughness, transmission: clear, index, .. } = *surface;
    let is_mirror = roughness <= MIRROR_ROUGHNESS;
    let rough = if is_mirror { 0.0 } else { roughness };
    let scattered = (1.0 - metal) * (1.0 - clear) * (1.0 - DIELECTRIC * (1.0 - rough)) + metal * rough;
    let specular = (1.0 - metal) * DIELECTRIC + metal * base * mean;
    let exponent = (0.5 / (rough * rough * rough * rough).max(1e-9) - 0.5).clamp(*EXPONENTS.start(), *EXPONENTS.end());
    let material = Material::new(base * scattered).exponent(exponent).normalised(true);
    match (clear * (1.0 - metal) > 0.0, is_mirror) {
        (true, _) => {
            let transmission = base * clear * (1.0 - metal);
            material.specular(specular).finish(Finish::Glass { index, transmission, fresnel: true })
        }
        (false, true) => material.specular(specular).finish(Finish::Mirror { fresnel: true }),
        (false, false) => material.specular(specular * (1.0 - rough)),
    }
}
