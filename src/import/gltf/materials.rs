//! Converts metallic-roughness materials to [`Material`]. docs/FORMATS.md has the rules.

use std::collections::HashMap;

use glam::{Mat2, Vec2, Vec3};
use gltf_json::{
    Material as Description, extensions::texture::TextureTransform, material::AlphaMode, texture::Info,
    validation::Checked,
};

use super::{
    document::Document,
    textures::{Picture, Textures},
};
use crate::{
    Error, Finish, Material, MaterialId, Scene, TextureId,
    import::{
        SceneOptions,
        warnings::{Place, Warnings},
    },
    message::counted,
    scene::checks::{EXPONENTS, INDICES},
};

/// Reflectance of dielectrics at normal incidence, by the specification.
const DIELECTRIC: f32 = 0.04;
/// Maximum roughness of a material that becomes a mirror, since its highlights would be points.
const MIRROR_ROUGHNESS: f32 = 0.1;

/// The specification's map from texture coordinates to a picture.
#[derive(Clone, Copy)]
pub(super) struct UvRule {
    /// Index of the primitive's set of texture coordinates.
    pub(super) set: u32,
    matrix: Mat2,
    offset: Vec2,
}

impl UvRule {
    const PLAIN: Self = Self { set: 0, matrix: Mat2::IDENTITY, offset: Vec2::ZERO };

    fn of(info: &Info) -> Self {
        let transform = info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref());
        let Some(TextureTransform { offset, rotation, scale, tex_coord, .. }) = transform else {
            return Self { set: info.tex_coord, ..Self::PLAIN };
        };
        let ((sin, cos), [x, y]) = (rotation.0.sin_cos(), scale.0);
        // The scale comes first, then the rotation, counterclockwise with v pointing down.
        let matrix = Mat2::from_cols(Vec2::new(x * cos, -x * sin), Vec2::new(y * sin, y * cos));
        Self { set: tex_coord.unwrap_or(info.tex_coord), matrix, offset: Vec2::from_array(offset.0) }
    }

    /// Returns texture coordinates with v pointing up.
    pub(super) fn place(&self, uv: Vec2) -> Vec2 {
        let uv = if self.matrix == Mat2::IDENTITY { uv } else { self.matrix * uv } + self.offset;
        Vec2::new(uv.x, 1.0 - uv.y)
    }
}

/// A material of the scene, and its texture's map.
#[derive(Clone, Copy)]
pub(super) struct Surface {
    pub(super) material: MaterialId,
    pub(super) uv: UvRule,
    pub(super) is_textured: bool,
}

/// The used materials.
pub(super) struct Surfaces<'a> {
    document: &'a Document<'a>,
    textures: Textures<'a>,
    /// Surfaces by material index; the specification's default material has none.
    found: HashMap<Option<usize>, Surface>,
    /// Materials that are not yet in the scene, and the number that are.
    new: Vec<Material>,
    moved: usize,
    out_of_range: usize,
}

/// Opacity and cut-out of a material.
struct Alpha {
    opacity: f32,
    cutout: Option<TextureId>,
}

impl<'a> Surfaces<'a> {
    pub(super) fn new(document: &'a Document<'a>, options: &SceneOptions) -> Self {
        let textures = Textures::new(document, options);
        // The scene already has its grey material.
        Self { document, textures, found: HashMap::new(), new: Vec::new(), moved: 1, out_of_range: 0 }
    }

    /// Returns the surface of a primitive by its material's index.
    pub(super) fn find(&mut self, index: Option<usize>, by: &str, warnings: &mut Warnings) -> Result<Surface, Error> {
        if let Some(surface) = self.found.get(&index) {
            return Ok(*surface);
        }
        let plain = Description::default();
        let description = match index {
            Some(index) => self.document.item(("materials", &self.document.root.materials), index, by)?,
            None => &plain,
        };
        let (material, uv) = self.read(description, index.unwrap_or_default(), warnings)?;
        let is_textured = material.texture.is_some();
        self.new.push(material);
        let surface = Surface { material: MaterialId((self.moved + self.new.len()) as u32 - 1), uv, is_textured };
        self.found.insert(index, surface);
        Ok(surface)
    }

    /// Adds new materials and textures to the scene.
    pub(super) fn move_to(&mut self, scene: &mut Scene) {
        self.textures.move_to(scene);
        self.moved += self.new.len();
        for material in self.new.drain(..) {
            scene.add_material(material);
        }
    }

    pub(super) fn warn_of_ranges(&self, warnings: &Warnings) {
        if self.out_of_range > 0 {
            let materials = counted(self.out_of_range, "material", "materials");
            warnings.warn_once(format!("values out of range, which are clamped, in {materials}"));
        }
    }

    fn read(
        &mut self,
        description: &Description,
        index: usize,
        warnings: &mut Warnings,
    ) -> Result<(Material, UvRule), Error> {
        let name = format!("materials[{index}]");
        note_left_out(description, index, warnings);
        let mut crossed = false;
        let mut share = |value: f32| {
            let inside = value.clamp(0.0, 1.0);
            crossed |= inside != value;
            inside
        };
        let metallic = &description.pbr_metallic_roughness;
        let [r, g, b, a] = metallic.base_color_factor.0.map(&mut share);
        let base = Vec3::new(r, g, b);
        let emission = Vec3::from_array(description.emissive_factor.0.map(&mut share));
        let (mut metal, mut roughness) = (share(metallic.metallic_factor.0), share(metallic.roughness_factor.0));
        let extensions = description.extensions.as_ref();
        let clear = extensions.and_then(|extensions| extensions.transmission.as_ref());
        let clear = share(clear.map_or(0.0, |transmission| transmission.transmission_factor.0));
        self.out_of_range += usize::from(crossed);

        let picture = match &metallic.base_color_texture {
            Some(info) => self.textures.picture(info.index, &format!("{name}, baseColorTexture"), warnings)?,
            None => None,
        };
        let uv = match (&metallic.base_color_texture, &picture) {
            (Some(info), Some(_)) => UvRule::of(info),
            _ => UvRule::PLAIN,
        };
        if let Some(info) = &metallic.metallic_roughness_texture {
            let means = self.textures.means(info.index, &format!("{name}, metallicRoughnessTexture"), warnings)?;
            let means = means.map_or(Vec3::ONE, |means| means.values);
            (roughness, metal) = (roughness * means.y, metal * means.z);
        }
        let emission = emission * self.emission_scale(description, &name, warnings)?;
        let alpha = self.alpha(description, a, (picture.as_ref(), &name), warnings)?;
        let texture = picture.as_ref().map(|picture| self.textures.id(picture));

        let material_name = description.name.clone().unwrap_or_default();
        let unlit = extensions.is_some_and(|extensions| extensions.unlit.is_some());
        let mut material = if unlit && texture.is_none() {
            Material::new(Vec3::ZERO).emission(base)
        } else if unlit {
            warnings.left_out("unlit materials with a texture, which are lit", Place::Item("materials", index));
            Material::new(base)
        } else {
            let picture = picture.as_ref().filter(|_| metal > 0.0);
            let mean = picture.map_or(Vec3::ONE, |picture| self.textures.mean_light(picture));
            let ior = extensions.and_then(|extensions| extensions.ior.as_ref()).map(|ior| ior.ior.0);
            surface(base, mean, (metal, roughness), clear, ior).emission(emission)
        };
        material = material.name(material_name);
        (material.texture, material.cutout) = (texture, alpha.cutout);
        if !matches!(material.finish, Finish::Glass { .. }) {
            material.opacity = alpha.opacity;
        }
        material.conserve();
        Ok((material, uv))
    }

    /// Returns the factor of the emissive colour.
    fn emission_scale(
        &mut self,
        description: &Description,
        name: &str,
        warnings: &mut Warnings,
    ) -> Result<Vec3, Error> {
        let extensions = description.extensions.as_ref();
        let strength = extensions.and_then(|extensions| extensions.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
        if !(strength >= 0.0 && strength.is_finite()) {
            return Err(self
                .document
                .fault(format!("{name}: its emissiveStrength is {strength}; it must be finite and not negative")));
        }
        let Some(info) = description.emissive_texture.as_ref().filter(|_| description.emissive_factor.0 != [0.0; 3])
        else {
            return Ok(Vec3::splat(strength));
        };
        let means = self.textures.means(info.index, &format!("{name}, emissiveTexture"), warnings)?;
        Ok(strength * means.map_or(Vec3::ONE, |means| means.light))
    }

    /// Returns a material's opacity and cut-out. A mask becomes a cut-out. Blending becomes one opacity, with a cut-out
    /// where the texture's alpha is below a half.
    fn alpha(
        &mut self,
        description: &Description,
        factor: f32,
        (picture, name): (Option<&Picture>, &str),
        warnings: &mut Warnings,
    ) -> Result<Alpha, Error> {
        let whole = Alpha { opacity: 1.0, cutout: None };
        let gone = Alpha { opacity: 0.0, cutout: None };
        match (description.alpha_mode, picture) {
            (Checked::Valid(AlphaMode::Opaque), _) => Ok(whole),
            (Checked::Valid(AlphaMode::Mask), picture) => {
                let cutoff = description.alpha_cutoff.unwrap_or_default().0;
                let least = if factor > 0.0 { 255.0 * cutoff / factor } else { f32::INFINITY };
                match picture {
                    _ if cutoff <= 0.0 => Ok(whole),
                    _ if least > 255.0 => Ok(gone),
                    None => Ok(whole),
                    Some(picture) => {
                        let by = format!("{name}, alphaCutoff");
                        Ok(Alpha { cutout: self.textures.cutout(picture, least.ceil() as u8, &by, warnings)?, ..whole })
                    }
                }
            }
            (Checked::Valid(AlphaMode::Blend), None) => Ok(Alpha { opacity: factor, ..whole }),
            (Checked::Valid(AlphaMode::Blend), Some(picture)) => {
                let counts = self.textures.alphas(picture);
                let has = |alphas: std::ops::Range<usize>| counts[alphas].iter().any(|&count| count > 0);
                // If no alpha reaches a half, the whole surface has one opacity.
                let first = if has(128..256) { 128 } else { 0 };
                let of = |weight: fn(usize) -> f64| -> f64 {
                    (first..256).map(|alpha| weight(alpha) * counts[alpha] as f64).sum()
                };
                let opacity = factor * (of(|alpha| alpha as f64 / 255.0) / of(|_| 1.0)) as f32;
                let cutout = (first == 128 && has(0..128)).then(|| self.textures.id(picture));
                Ok(Alpha { opacity, cutout })
            }
            (Checked::Invalid, _) => Err(self.document.fault("a material's alphaMode is unknown".into())),
        }
    }
}

/// Converts metal and roughness to diffuse colour, highlights and mirrors. `mean` is the texture's mean colour, since
/// highlights have no texture.
fn surface(base: Vec3, mean: Vec3, (metal, roughness): (f32, f32), clear: f32, ior: Option<f32>) -> Material {
    let is_mirror = roughness <= MIRROR_ROUGHNESS;
    let rough = if is_mirror { 0.0 } else { roughness };
    let scattered = (1.0 - metal) * (1.0 - clear) * (1.0 - DIELECTRIC * (1.0 - rough)) + metal * rough;
    let specular = (1.0 - metal) * DIELECTRIC + metal * base * mean;
    let exponent = (0.5 / (rough * rough * rough * rough).max(1e-9) - 0.5).clamp(*EXPONENTS.start(), *EXPONENTS.end());
    let material = Material::new(base * scattered).exponent(exponent).normalised(true);
    let index = ior.filter(|ior| INDICES.contains(ior)).unwrap_or(1.5);
    match (clear * (1.0 - metal) > 0.0, is_mirror) {
        (true, _) => {
            let transmission = base * clear * (1.0 - metal);
            material.specular(specular).finish(Finish::Glass { index, transmission, fresnel: true })
        }
        (false, true) => material.specular(specular).finish(Finish::Mirror { fresnel: true }),
        (false, false) => material.specular(specular * (1.0 - rough)),
    }
}

/// Counts unsupported textures.
fn note_left_out(description: &Description, index: usize, warnings: &mut Warnings) {
    let place = Place::Item("materials", index);
    if description.normal_texture.is_some() {
        warnings.left_out("normal textures", place);
    }
    if description.occlusion_texture.is_some() {
        warnings.left_out("occlusion textures", place);
    }
    let extensions = description.extensions.as_ref();
    let clear = extensions.and_then(|extensions| extensions.transmission.as_ref());
    if clear.is_some_and(|clear| clear.transmission_texture.is_some()) {
        warnings.left_out("transmission textures", place);
    }
}
