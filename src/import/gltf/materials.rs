//! Converts metallic-roughness materials to [`Material`]. docs/FORMATS.md has the rules.

use std::{collections::HashMap, ops::RangeInclusive};

use glam::{Mat2, Vec2, Vec3};
use gltf_json::{
    Material as Description, extensions::texture::TextureTransform, material::AlphaMode, texture::Info,
    validation::Checked,
};

use super::{
    document::Document,
    more::{Clearcoat, MoreOfMaterial},
    textures::{Picture, Textures},
};
use crate::{
    Error, Finish, Material, MaterialId, Principled, Scene, TextureId,
    import::{
        SceneOptions,
        warnings::{Place, Warnings},
    },
    message::counted,
    scene::{checks::INDICES, principled::phong},
};

/// Maximum of the absorption per world unit; nothing passes.
const MOST_ABSORPTION: f32 = 1e6;
/// Maximum of a normal texture's scale.
const MOST_NORMAL_SCALE: f32 = 1e3;
/// Alphas of texels that are partly clear.
const PARTLY_CLEAR: RangeInclusive<usize> = 1..=229;
/// Largest share of such texels in a texture of leaves or hair, which is cut out instead of blended.
const MOST_PARTLY_CLEAR: f64 = 0.125;

/// The specification's map from texture coordinates to a picture.
#[derive(Clone, Copy, PartialEq)]
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
        Self::transformed(info.tex_coord, transform)
    }

    /// Returns the map of a texture by its set of texture coordinates and its transform.
    fn transformed(set: u32, transform: Option<&TextureTransform>) -> Self {
        let Some(TextureTransform { offset, rotation, scale, tex_coord, .. }) = transform else {
            return Self { set, ..Self::PLAIN };
        };
        let ((sin, cos), [x, y]) = (rotation.0.sin_cos(), scale.0);
        // The scale comes first, then the rotation, counterclockwise with v pointing down.
        let matrix = Mat2::from_cols(Vec2::new(x * cos, -x * sin), Vec2::new(y * sin, y * cos));
        Self { set: tex_coord.unwrap_or(set), matrix, offset: Vec2::from_array(offset.0) }
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
    pub(super) has_normal_texture: bool,
    /// Whether the file's tangents apply to its normal texture.
    pub(super) uses_tangents: bool,
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
#[derive(Default)]
struct Alpha {
    opacity: f32,
    /// Whether the base colour's alpha multiplies the opacity.
    blend: bool,
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
        let (material, uv) = self.read(description, index, warnings)?;
        let maps = material.principled.is_some_and(|surface| surface.textures().next().is_some());
        let is_textured = material.texture.is_some() || maps;
        // Tangents of a file belong to texture coordinates without a transform.
        let has_normal_texture = material.principled.is_some_and(|surface| surface.normal_texture.is_some());
        let uses_tangents = has_normal_texture && uv.matrix == Mat2::IDENTITY;
        self.new.push(material);
        let material = MaterialId((self.moved + self.new.len()) as u32 - 1);
        let surface = Surface { material, uv, is_textured, has_normal_texture, uses_tangents };
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
        index: Option<usize>,
        warnings: &mut Warnings,
    ) -> Result<(Material, UvRule), Error> {
        let (is_described, index) = (index.is_some(), index.unwrap_or_default());
        let name = format!("materials[{index}]");
        let document = self.document;
        let no_more = MoreOfMaterial::default();
        let more = document.more.get(index).filter(|_| is_described).unwrap_or(&no_more);
        note_left_out(description, more, index, warnings);
        let mut crossed = false;
        let mut share = |value: f32| {
            let inside = value.clamp(0.0, 1.0);
            crossed |= inside != value;
            inside
        };
        let metallic = &description.pbr_metallic_roughness;
        let [r, g, b, a] = metallic.base_color_factor.0.map(&mut share);
        let mut surface =
            Principled::new(Vec3::new(r, g, b), share(metallic.metallic_factor.0), share(metallic.roughness_factor.0));
        surface.emission = Vec3::from_array(description.emissive_factor.0.map(&mut share));
        let extensions = description.extensions.as_ref();
        if let Some(clear) = extensions.and_then(|extensions| extensions.transmission.as_ref()) {
            surface.transmission = share(clear.transmission_factor.0);
            surface.thin = true;
        }
        if let Some(ior) = extensions.and_then(|extensions| extensions.ior.as_ref()) {
            surface.index = Some(ior.ior.0).filter(|ior| INDICES.contains(ior)).unwrap_or(1.5);
        }
        if let Some(specular) = extensions.and_then(|extensions| extensions.specular.as_ref()) {
            let factor = share(specular.specular_factor.0);
            surface.specular = Vec3::from_array(specular.specular_color_factor.0.map(|value| factor * share(value)));
            surface.grazing = factor;
        }
        if let Some(volume) = extensions.and_then(|extensions| extensions.volume.as_ref()) {
            surface.thin = volume.thickness_factor.0 <= 0.0;
            let (color, distance) =
                (Vec3::from_array(volume.attenuation_color.0.map(&mut share)), volume.attenuation_distance.0);
            if distance > 0.0 {
                surface.absorption =
                    (-color.max(Vec3::splat(1e-6)).map(f32::ln) / distance).min(Vec3::splat(MOST_ABSORPTION));
            }
        }
        if let Some(coat) = more.clearcoat() {
            surface.clearcoat = share(coat.clearcoat_factor);
            surface.clearcoat_roughness = share(coat.clearcoat_roughness_factor);
        }
        self.out_of_range += usize::from(crossed);

        let uv = uv_rule(description, more);
        let base = match &metallic.base_color_texture {
            Some(info) => self.textures.picture(info.index, &format!("{name}, baseColorTexture"), warnings)?,
            None => None,
        };
        // Direct light shows the means of textures other than the base colour's.
        let mut seen = surface;
        if let Some(info) = &metallic.metallic_roughness_texture
            && let Some(picture) =
                self.textures.picture(info.index, &format!("{name}, metallicRoughnessTexture"), warnings)?
        {
            let means = self.textures.means_of(&picture).values;
            (seen.roughness, seen.metallic) = (seen.roughness * means.y, seen.metallic * means.z);
            match UvRule::of(info) == uv {
                true => {
                    let texture = Some(self.textures.data_id(&picture));
                    (surface.roughness_texture, surface.metallic_texture) = (texture, texture);
                }
                false => (surface.roughness, surface.metallic) = (seen.roughness, seen.metallic),
            }
        }
        surface.emission *= self.emission_strength(description, &name)?;
        seen.emission = surface.emission;
        if let Some(info) = description.emissive_texture.as_ref().filter(|_| surface.emission != Vec3::ZERO)
            && let Some(picture) = self.textures.picture(info.index, &format!("{name}, emissiveTexture"), warnings)?
        {
            seen.emission *= self.textures.means_of(&picture).light;
            match UvRule::of(info) == uv {
                true => surface.emission_texture = Some(self.textures.id(&picture)),
                false => surface.emission = seen.emission,
            }
        }
        if let Some(coat) = more.clearcoat().filter(|_| surface.is_coated()) {
            self.read_coat(coat, &mut surface, (uv, &name), warnings)?;
        }
        let clear = extensions.and_then(|extensions| extensions.transmission.as_ref());
        if let Some(info) = clear.and_then(|clear| clear.transmission_texture.as_ref())
            && let Some(picture) =
                self.textures.picture(info.index, &format!("{name}, transmissionTexture"), warnings)?
        {
            seen.transmission *= self.textures.means_of(&picture).values.x;
            match UvRule::of(info) == uv {
                true => surface.transmission_texture = Some(self.textures.data_id(&picture)),
                false => surface.transmission = seen.transmission,
            }
        }
        if let Some(info) = &description.normal_texture
            && UvRule::transformed(info.tex_coord, more.normal_transform()) == uv
            && let Some(picture) = self.textures.picture(info.index, &format!("{name}, normalTexture"), warnings)?
        {
            surface.normal_texture = Some(self.textures.data_id(&picture));
            surface.normal_scale = info.scale.clamp(-MOST_NORMAL_SCALE, MOST_NORMAL_SCALE);
        }
        let alpha = self.alpha(description, a, (base.as_ref(), &name), warnings)?;
        let texture = base.as_ref().map(|picture| self.textures.id(picture));

        let material_name = description.name.clone().unwrap_or_default();
        let unlit = extensions.is_some_and(|extensions| extensions.unlit.is_some());
        let mut material = if unlit && texture.is_none() {
            Material::new(Vec3::ZERO).emission(surface.base)
        } else if unlit {
            warnings.left_out("unlit materials with a texture, which are lit", Place::Item("materials", index));
            Material::new(surface.base)
        } else {
            let picture = base.as_ref().filter(|_| seen.metallic > 0.0);
            let mean = picture.map_or(Vec3::ONE, |picture| self.textures.means_of(picture).light);
            phong(&seen, mean).emission(seen.emission)
        };
        material = material.name(material_name);
        material.principled = (!unlit).then_some(surface);
        (material.texture, material.cutout) = (texture, alpha.cutout);
        if !matches!(material.finish, Finish::Glass { .. }) {
            (material.opacity, material.alpha_blend) = (alpha.opacity, alpha.blend);
        }
        material.conserve();
        Ok((material, uv))
    }

    /// Reads the textures of a clear coat.
    fn read_coat(
        &mut self,
        coat: &Clearcoat,
        surface: &mut Principled,
        (uv, name): (UvRule, &str),
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        let mut read = |info: &Option<Info>, field: &str, factor: &mut f32, mean_of: fn(Vec3) -> f32| {
            let Some(info) = info else { return Ok(None) };
            let picture = self.textures.picture(info.index, &format!("{name}, {field}"), warnings)?;
            let Some(picture) = picture else { return Ok(None) };
            if UvRule::of(info) == uv {
                return Ok(Some(self.textures.data_id(&picture)));
            }
            *factor *= mean_of(self.textures.means_of(&picture).values);
            Ok::<_, Error>(None)
        };
        let Principled { clearcoat, clearcoat_roughness, .. } = surface;
        let texture = read(&coat.clearcoat_texture, "clearcoatTexture", clearcoat, |mean| mean.x)?;
        let rough = &coat.clearcoat_roughness_texture;
        let rough = read(rough, "clearcoatRoughnessTexture", clearcoat_roughness, |mean| mean.y)?;
        (surface.clearcoat_texture, surface.clearcoat_roughness_texture) = (texture, rough);
        Ok(())
    }

    /// Returns the factor of the emissive colour.
    fn emission_strength(&self, description: &Description, name: &str) -> Result<f32, Error> {
        let extensions = description.extensions.as_ref();
        let strength = extensions.and_then(|extensions| extensions.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
        match strength >= 0.0 && strength.is_finite() {
            true => Ok(strength),
            false => Err(self
                .document
                .fault(format!("{name}: its emissiveStrength is {strength}; it must be finite and not negative"))),
        }
    }

    /// Returns a material's opacity and cut-out. A mask becomes a cut-out. So does the texture of a blended material if
    /// few of its texels are partly clear. Otherwise its alpha multiplies the opacity.
    fn alpha(
        &mut self,
        description: &Description,
        factor: f32,
        (picture, name): (Option<&Picture>, &str),
        warnings: &mut Warnings,
    ) -> Result<Alpha, Error> {
        let whole = Alpha { opacity: 1.0, ..Alpha::default() };
        let gone = Alpha::default();
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
                let counts = *self.textures.alphas(picture);
                let number = |alphas: RangeInclusive<usize>| counts[alphas].iter().sum::<u64>();
                if number(PARTLY_CLEAR) as f64 > MOST_PARTLY_CLEAR * number(1..=255) as f64 {
                    // Without the cut-out, rays meet what is clear, and pass.
                    let cutout = match counts[0] {
                        0 => None,
                        _ => self.textures.cutout_of(picture, 1).ok(),
                    };
                    return Ok(Alpha { opacity: factor, blend: true, cutout });
                }
                let sum = (128..=255).map(|alpha| alpha as f64 / 255.0 * counts[alpha] as f64).sum::<f64>();
                let opacity = factor * (sum / number(128..=255).max(1) as f64) as f32;
                let cutout = (number(0..=127) > 0).then(|| self.textures.id(picture));
                Ok(Alpha { opacity, blend: false, cutout })
            }
            (Checked::Invalid, _) => Err(self.document.fault("a material's alphaMode is unknown".into())),
        }
    }
}

/// Returns the maps of a material's textures, the normal texture's last.
fn uv_rules<'a>(description: &'a Description, more: &'a MoreOfMaterial) -> impl Iterator<Item = UvRule> + 'a {
    let metallic = &description.pbr_metallic_roughness;
    let clear = description.extensions.as_ref().and_then(|extensions| extensions.transmission.as_ref());
    let infos = [&metallic.base_color_texture, &metallic.metallic_roughness_texture, &description.emissive_texture];
    let infos = infos.into_iter().flatten().chain(clear.and_then(|clear| clear.transmission_texture.as_ref()));
    let coat = more.clearcoat();
    let coat = coat.map(|coat| [&coat.clearcoat_texture, &coat.clearcoat_roughness_texture]);
    let infos = infos.chain(coat.into_iter().flatten().flatten());
    let normal = description.normal_texture.as_ref();
    infos.map(UvRule::of).chain(normal.map(|info| UvRule::transformed(info.tex_coord, more.normal_transform())))
}

/// Returns the map of a material's textures: that of the first one it has.
fn uv_rule(description: &Description, more: &MoreOfMaterial) -> UvRule {
    uv_rules(description, more).next().unwrap_or(UvRule::PLAIN)
}

/// Counts unsupported textures.
fn note_left_out(description: &Description, more: &MoreOfMaterial, index: usize, warnings: &mut Warnings) {
    let place = Place::Item("materials", index);
    let rule = uv_rule(description, more);
    let mut rules: Vec<UvRule> = uv_rules(description, more).collect();
    if description.normal_texture.is_some() && rules.pop() != Some(rule) {
        warnings.left_out("normal textures with another map than their material's first texture", place);
    }
    if rules.iter().any(|other| *other != rule) {
        warnings.left_out("textures with another map than their material's first texture; means are used", place);
    }
    if description.occlusion_texture.is_some() {
        warnings.left_out("occlusion textures", place);
    }
    if more.clearcoat().is_some_and(|coat| coat.clearcoat_normal_texture.is_some()) {
        warnings.left_out("normal textures of clear coats", place);
    }
    let extensions = description.extensions.as_ref();
    let specular = extensions.and_then(|extensions| extensions.specular.as_ref());
    if specular.is_some_and(|of| of.specular_texture.is_some() || of.specular_color_texture.is_some()) {
        warnings.left_out("textures of KHR_materials_specular", place);
    }
}
