//! Reads MTL statements and converts them to materials.

use std::ops::RangeInclusive;

use glam::Vec3;

use super::{
    super::{GREY, without_comment},
    maps::{Map, Placement, Use, parse_map},
};
use crate::{
    Finish, Material, Principled,
    import::warnings::Warnings,
    scene::{
        TextureId,
        checks::{EXPONENTS, INDICES, OPACITIES},
    },
};

/// Default index of refraction, of window glass.
const GLASS_INDEX: f32 = 1.5;

/// A material under construction.
#[derive(Default)]
pub(super) struct Draft {
    pub(super) name: String,
    line: usize,
    diffuse: Option<Vec3>,
    specular: Option<Vec3>,
    emission: Option<Vec3>,
    transmission: Option<Vec3>,
    exponent: Option<f32>,
    index: Option<f32>,
    /// Values of `d` and its opposite `Tr`. `Tr` only counts without `d`, since some programs write 1 for opaque in
    /// both.
    dissolve: Option<f32>,
    transparency: Option<f32>,
    illumination: Option<u32>,
    roughness: Option<f32>,
    metallic: Option<f32>,
    clearcoat: Option<f32>,
    clearcoat_roughness: Option<f32>,
    /// Textures, one per use.
    pub(super) maps: Vec<Map>,
}

/// The textures of a material that were read.
pub(super) type Found = Vec<(Use, TextureId)>;

fn texture_for(found: &Found, purpose: Use) -> Option<TextureId> {
    found.iter().find(|(of, _)| *of == purpose).map(|(_, id)| *id)
}

impl Draft {
    pub(super) fn new(name: &str, line: usize) -> Self {
        Self { name: name.into(), line, ..Self::default() }
    }

    /// Returns the material, and whether a value was clamped to its range.
    pub(super) fn finish(self, found: &Found, warnings: &mut Warnings) -> (Material, bool) {
        let [texture, cutout] = [Use::Color, Use::CutOut].map(|purpose| texture_for(found, purpose));
        let mut bounds = Bounds { crossed: false };
        let finish = self.finish_of(&mut bounds);
        let mut material = Material::new(self.albedo(finish, texture, warnings)).name(self.name.clone()).finish(finish);
        (material.texture, material.cutout) = (texture, cutout);
        material.albedo = bounds.color(material.albedo);
        material.specular = match finish {
            // Models 0 and 1 have no highlights.
            Finish::Matte if matches!(self.illumination, Some(0 | 1)) => Vec3::ZERO,
            Finish::Matte => bounds.color(self.specular.unwrap_or(Vec3::ZERO)),
            _ => bounds.color(self.specular.unwrap_or(Vec3::ONE)),
        };
        if let Some(exponent) = self.exponent {
            material.exponent = bounds.number(exponent, EXPONENTS);
        }
        if let Some(emission) = self.emission {
            material.emission = emission.max(Vec3::ZERO);
            bounds.crossed |= material.emission != emission;
        }
        material.opacity = match finish {
            // A glass's transmission already contains its opacity.
            Finish::Glass { .. } => 1.0,
            _ => self.opacity(&mut bounds),
        };
        if material.opacity == 0.0 && self.dissolve.is_none() {
            warnings.warn(
                "invisible materials",
                self.line,
                format_args!(
                    "material '{}' is invisible, because its Tr is 1; if it should be opaque, give it a d of 1",
                    self.name
                ),
            );
        }
        material.principled = self.principled(&material, found, &mut bounds);
        bounds.crossed |= material.conserve();
        (material, bounds.crossed)
    }

    /// Returns the physically based surface, if a statement of MTL's extension (Pr, Pm, norm and similar) asks for one.
    fn principled(&self, material: &Material, found: &Found, bounds: &mut Bounds) -> Option<Principled> {
        let of = |purpose| texture_for(found, purpose);
        let [roughness, metallic] = [Use::Roughness, Use::Metallic].map(of);
        let is_asked = self.roughness.is_some() || self.metallic.is_some() || roughness.is_some() || metallic.is_some();
        let is_asked = is_asked || self.clearcoat.is_some_and(|coat| coat > 0.0);
        if !is_asked && of(Use::Emission).is_none() && of(Use::Normal).is_none() {
            return None;
        }
        let shares = 0.0..=1.0;
        let mut share =
            |value: Option<f32>, otherwise: f32| value.map_or(otherwise, |value| bounds.number(value, shares.clone()));
        // The width of Phong's highlight (Walter et al. 2007, section 5.2). Mirrors and glass are smooth.
        let by_exponent = match material.finish {
            Finish::Matte => (2.0 / (material.exponent + 2.0)).powf(0.25),
            Finish::Mirror { .. } | Finish::Glass { .. } => 0.0,
        };
        let rough = share(self.roughness, if roughness.is_some() { 1.0 } else { by_exponent });
        let metal = share(self.metallic, if metallic.is_some() { 1.0 } else { 0.0 });
        let coat = [share(self.clearcoat, 0.0), share(self.clearcoat_roughness, 0.0)];
        let mut surface = Principled::new(material.albedo, metal, rough).clearcoat(coat[0], coat[1]);
        match material.finish {
            Finish::Matte => {}
            Finish::Mirror { .. } => surface = Principled { base: material.specular, metallic: 1.0, ..surface },
            Finish::Glass { index, transmission, .. } => {
                surface = Principled { base: transmission, ..surface }.transmission(1.0).index(index);
            }
        }
        surface.emission = match (self.emission, of(Use::Emission)) {
            (None, Some(_)) => Vec3::ONE,
            _ => material.emission,
        };
        (surface.roughness_texture, surface.metallic_texture) = (roughness, metallic);
        (surface.emission_texture, surface.normal_texture) = (of(Use::Emission), of(Use::Normal));
        Some(surface)
    }

    /// Returns the placement of the material's textures. Texture coordinates are transformed when they are read, so all
    /// textures share that of the first one.
    pub(super) fn placement(&self, warnings: &mut Warnings) -> Placement {
        let order = |map: &&Map| Use::ALL.iter().position(|(_, purpose)| *purpose == map.purpose);
        let Some(first) = self.maps.iter().min_by_key(order) else { return Placement::default() };
        if let Some(other) = self.maps.iter().find(|map| map.placement != first.placement) {
            let text = format!(
                "material '{}' has different -s or -o for {} and {}; those of {} are used",
                self.name, other.keyword, first.keyword, first.keyword
            );
            warnings.warn("textures with different scales or offsets", other.line, text);
        }
        first.placement
    }

    /// Returns the diffuse colour. The default is grey, white with a texture, and black for mirrors and glass.
    fn albedo(&self, finish: Finish, texture: Option<TextureId>, warnings: &mut Warnings) -> Vec3 {
        match (self.diffuse, texture, finish) {
            (Some(diffuse), Some(_), Finish::Matte) if diffuse.max_element() <= 0.0 => {
                let text = format!("material '{}' has a texture and a black Kd; white is used instead", self.name);
                warnings.warn("textures on black (map_Kd with a Kd of 0)", self.line, text);
                Vec3::ONE
            }
            (Some(diffuse), ..) => diffuse,
            (None, Some(_), _) => Vec3::ONE,
            (None, None, Finish::Matte) => GREY,
            (None, None, _) => Vec3::ZERO,
        }
    }

    /// Returns the finish of the illumination model. Maya writes model 4 for all its materials, so it is glass only if
    /// another value says so too.
    fn finish_of(&self, bounds: &mut Bounds) -> Finish {
        let fresnel = match self.illumination {
            Some(3 | 8) => return Finish::Mirror { fresnel: false },
            Some(5) => return Finish::Mirror { fresnel: true },
            Some(4) if !self.is_clear() => return Finish::Matte,
            Some(4 | 6 | 9) => false,
            Some(7) => true,
            _ => return Finish::Matte,
        };
        let index = self.index.map_or(GLASS_INDEX, |index| bounds.number(index, INDICES));
        let opacity = self.opacity(bounds);
        let through = if opacity < 1.0 { 1.0 - opacity } else { 1.0 };
        let transmission = through * bounds.color(self.transmission.unwrap_or(Vec3::ONE));
        Finish::Glass { index, transmission, fresnel }
    }

    /// Returns whether light passes by `d`, `Tr` or `Tf`, or there is no diffuse colour to show instead.
    fn is_clear(&self) -> bool {
        self.opacity(&mut Bounds { crossed: false }) < 1.0
            || self.transmission.is_some_and(|color| color != Vec3::ONE)
            || self.diffuse.is_none_or(|diffuse| diffuse.max_element() <= 0.0)
    }

    fn opacity(&self, bounds: &mut Bounds) -> f32 {
        let opacity = self.dissolve.or(self.transparency.map(|transparency| 1.0 - transparency));
        opacity.map_or(1.0, |opacity| bounds.number(opacity, OPACITIES))
    }
}

/// Clamps values to their ranges and stores whether any was outside.
struct Bounds {
    crossed: bool,
}

impl Bounds {
    fn color(&mut self, color: Vec3) -> Vec3 {
        let clamped = color.clamp(Vec3::ZERO, Vec3::ONE);
        self.crossed |= clamped != color;
        clamped
    }

    fn number(&mut self, value: f32, range: RangeInclusive<f32>) -> f32 {
        let clamped = value.clamp(*range.start(), *range.end());
        self.crossed |= clamped != value;
        clamped
    }
}

/// Reads a statement into the current material, or counts it as unsupported.
pub(super) fn read_statement(
    keyword: &str,
    rest: &str,
    line: usize,
    draft: Option<&mut Draft>,
    warnings: &mut Warnings,
) {
    let numbers = without_comment(rest).trim();
    let is_value = Use::named(keyword).is_some()
        || matches!(
            keyword,
            "Kd" | "Ks" | "Ke" | "Tf" | "Ns" | "Ni" | "d" | "Tr" | "illum" | "Pr" | "Pm" | "Pc" | "Pcr"
        );
    match draft {
        _ if !is_value => note_left_out(keyword, numbers, line, warnings),
        Some(draft) => draft.take(keyword, rest, numbers, line, warnings),
        None => warnings.warn(
            "statements before the first newmtl",
            line,
            format!("{keyword} before the first newmtl; it is ignored"),
        ),
    }
}

impl Draft {
    fn take(&mut self, keyword: &str, rest: &str, numbers: &str, line: usize, warnings: &mut Warnings) {
        let color = |place: &mut Option<Vec3>| {
            let color = parse_color(numbers);
            *place = color.or(*place);
            color.map(drop).ok_or("not a colour of three finite numbers")
        };
        let number = |place: &mut Option<f32>, words: &str| {
            let number = words.parse().ok().filter(|value: &f32| value.is_finite());
            *place = number.or(*place);
            number.map(drop).ok_or("not a finite number")
        };
        let taken = match keyword {
            "Kd" => color(&mut self.diffuse),
            "Ks" => color(&mut self.specular),
            "Ke" => color(&mut self.emission),
            "Tf" => color(&mut self.transmission),
            "Ns" => number(&mut self.exponent, numbers),
            "Ni" => number(&mut self.index, numbers),
            // A halo, which makes edges more transparent, is ignored without a warning.
            "d" => number(&mut self.dissolve, numbers.strip_prefix("-halo").unwrap_or(numbers).trim()),
            "Tr" => number(&mut self.transparency, numbers),
            "Pr" => number(&mut self.roughness, numbers),
            "Pm" => number(&mut self.metallic, numbers),
            "Pc" => number(&mut self.clearcoat, numbers),
            "Pcr" => number(&mut self.clearcoat_roughness, numbers),
            "illum" => {
                self.illumination = numbers.parse().ok().filter(|model| *model <= 10);
                self.illumination.map(drop).ok_or("not an illumination model from 0 to 10")
            }
            _ => {
                let named = Use::named(keyword).expect("the other values are above");
                let map = parse_map(named, rest, line, warnings);
                self.maps.retain(|other| other.purpose != named.1);
                let taken = map.as_ref().map(drop).ok_or("not a file name");
                self.maps.extend(map);
                taken
            }
        };
        if let Err(fault) = taken {
            let (kind, consequence) = match keyword {
                "Kd" => ("invalid diffuse colours (Kd)", "the material is grey"),
                _ => ("invalid values", "it is ignored"),
            };
            // The text is formatted only if printed, since a long name may have thousands of errors.
            let name = &self.name;
            let text = format_args!("{keyword} '{rest}' of material '{name}' is {fault}; {consequence}");
            warnings.warn(kind, line, text);
        }
    }
}

/// Counts an unsupported statement.
fn note_left_out(keyword: &str, numbers: &str, line: usize, warnings: &mut Warnings) {
    match keyword {
        "Ka" if parse_color(numbers) != Some(Vec3::ZERO) => warnings.left_out("ambient colours (Ka)", line),
        "Ps" | "aniso" | "anisor" => warnings.left_out("sheen and anisotropy (Ps, aniso, anisor)", line),
        "bump" | "disp" | "decal" | "refl" => warnings.left_out(OTHER_MAPS, line),
        _ if keyword.starts_with("map_") => warnings.left_out(OTHER_MAPS, line),
        // Sharpness has no effect here, since reflections are always sharp.
        "Ka" | "sharpness" | "" => {}
        _ if keyword.starts_with('#') => {}
        _ => warnings.left_out("unknown statements", line),
    }
}

const OTHER_MAPS: &str = "other textures (heights, displacement, reflections and similar)";

/// Parses three numbers, or one for all three (MTL's rule).
pub(super) fn parse_color(words: &str) -> Option<Vec3> {
    let mut words = words.split_whitespace();
    let mut next = || words.next().map(|word| word.parse().ok().filter(|value: &f32| value.is_finite()));
    match [next(), next(), next(), next()] {
        [Some(Some(r)), Some(Some(g)), Some(Some(b)), None] => Some(Vec3::new(r, g, b)),
        [Some(Some(grey)), None, ..] => Some(Vec3::splat(grey)),
        _ => None,
    }
}
