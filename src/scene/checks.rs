//! Checks of a scene's coordinates, colours, lights and extent.

use std::ops::RangeInclusive;

use glam::Vec3;

use super::{
    Finish, MAX_COORDINATE, MAX_LIGHTS, MAX_SOFT_LIGHTS, MIN_EXTENT, Material, MaterialId, Principled, Scene, Sky,
    Sphere, TextureId,
};
use crate::{Error, message::counted};

/// Largest f32 step that gives no warning, as a share of a scene's longest side. It is half a pixel if the side is 5000
/// pixels long. DESIGN, section 2, has the measurements.
const COARSE_STEP: f32 = 1e-4;

/// Valid ranges of [`Material`] values.
pub(crate) const OPACITIES: RangeInclusive<f32> = 0.0..=1.0;
pub(crate) const EXPONENTS: RangeInclusive<f32> = 0.0..=10_000.0;
pub(crate) const INDICES: RangeInclusive<f32> = 0.1..=10.0;
/// Largest share of light that a material may return, with a tolerance for the rounding of two shares.
const MOST_RETURNED: f32 = 1.0 + 1e-5;

impl Scene {
    pub(crate) fn check_material(&self, material: MaterialId) -> Result<(), String> {
        if (material.0 as usize) < self.materials.len() {
            return Ok(());
        }
        Err(format!("there is no material {}; the scene has {}", material.0, self.materials.len()))
    }

    pub(crate) fn check_sphere(&self, index: usize, sphere: &Sphere) -> Result<(), Error> {
        let check = || {
            check_coordinate(sphere.center)?;
            check_coordinate(sphere.center.abs() + sphere.radius)?;
            if sphere.radius <= 0.0 {
                return Err(format!("radius {} is not above 0", sphere.radius));
            }
            self.check_material(sphere.material)
        };
        check().map_err(|reason| Error::Scene { element: format!("sphere {index}"), reason })
    }

    /// Checks the scene before an upload, since its public fields accept any value.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let check =
            |element: String, check: Result<(), String>| check.map_err(|reason| Error::Scene { element, reason });
        check("ambient".into(), check_color("it", self.rendered_ambient()))?;
        match &self.sky {
            Sky::Constant(color) => check("sky".into(), check_color("it", *color))?,
            Sky::Gradient { nadir, zenith } => {
                check("sky".into(), check_color("nadir", *nadir))?;
                check("sky".into(), check_color("zenith", *zenith))?;
            }
            Sky::Map(_) => {} // its constructor checked it
        }
        for (index, material) in self.materials.iter().enumerate() {
            check(format!("material {index} '{}'", material.name), self.check_surface(material))?;
        }
        self.check_cut_out_others()?;
        check_light_count(self.lights.len())?;
        for (index, light) in self.lights.iter().enumerate() {
            check(format!("light {index}"), check_color("intensity", light.intensity))?;
            check(format!("light {index}"), light.check(self.origin, self.textures.len()))?;
        }
        let soft = self.soft_lights().count();
        if soft > MAX_SOFT_LIGHTS {
            let reason = format!("{soft} of them are not points; a scene can have at most {MAX_SOFT_LIGHTS} of these");
            return Err(Error::Scene { element: "lights".into(), reason });
        }
        check("geometry".into(), self.check_extent())
    }

    /// Checks a material's values and textures.
    fn check_surface(&self, material: &Material) -> Result<(), String> {
        check_color("albedo", material.albedo)?;
        check_color("specular", material.specular)?;
        check_color("emission", material.emission)?;
        check_within("opacity", material.opacity, &OPACITIES)?;
        check_within("exponent", material.exponent, &EXPONENTS)?;
        if let Finish::Glass { index, transmission, .. } = material.finish {
            check_within("index", index, &INDICES)?;
            check_color("transmission", transmission)?;
        }
        if let Some(surface) = &material.principled {
            surface.check()?;
        }
        let own = [("texture", material.texture), ("cutout", material.cutout)];
        let own = own.into_iter().filter_map(|(what, texture)| Some((what, texture?)));
        for (what, texture) in own.chain(material.principled.iter().flat_map(Principled::textures)) {
            check_texture(what, texture, self.textures.len())?;
        }
        let returned = material.most_returned();
        if returned.max_element() <= MOST_RETURNED {
            return Ok(());
        }
        Err(format!(
            "it returns more light than it receives: albedo, reflection and transmission sum to {returned}; each \
             channel can be at most 1"
        ))
    }

    /// Checks that only triangles have cut-outs.
    fn check_cut_out_others(&self) -> Result<(), Error> {
        if !self.is_cut_out() {
            return Ok(());
        }
        let is_cut_out = |id: MaterialId| self.materials[id.0 as usize].cutout.is_some();
        let spheres = self.spheres.iter().map(|sphere| sphere.material).enumerate();
        let ellipsoids = self.ellipsoids.iter().map(|ellipsoid| ellipsoid.material).enumerate();
        let planes = self.planes.iter().map(|plane| plane.material).enumerate();
        let balls = spheres.map(|ball| ("sphere", ball)).chain(ellipsoids.map(|ball| ("ellipsoid", ball)));
        let mut others = balls.chain(planes.map(|plane| ("plane", plane)));
        match others.find(|(_, (_, material))| is_cut_out(*material)) {
            None => Ok(()),
            Some((kind, (index, MaterialId(material)))) => {
                let reason = format!("its material {material} has a cut-out; only triangles can be cut out");
                Err(Error::Scene { element: format!("{kind} {index}"), reason })
            }
        }
    }

    /// Returns a warning if the scene is so far from the origin that rounding shows in its picture.
    pub(crate) fn rounding_warning(&self) -> Option<String> {
        let (low, high) = self.local_bounds()?;
        let rounded = rounding_text(low, high, COARSE_STEP)?;
        let side = (high - low).max_element();
        Some(format!(
            "the scene's {rounded}, and its longest side is {side}: detail and shadows break up; set an origin nearer \
             to it"
        ))
    }

    /// Checks the longest side. Far from the origin, a sphere or an ellipsoid can be smaller than an f32 step, with an
    /// empty box; its own size counts then.
    fn check_extent(&self) -> Result<(), String> {
        let Some((low, high)) = self.local_bounds() else { return Ok(()) };
        let across = self.spheres.iter().map(|sphere| 2.0 * sphere.radius);
        let across = across.chain(self.ellipsoids.iter().map(|one| 2.0 * one.half_extent().max_element() as f32));
        let extent = across.fold((high - low).max_element(), f32::max);
        match extent >= MIN_EXTENT {
            true => Ok(()),
            false => {
                Err(format!("its longest side is {extent:?}; it must be at least {MIN_EXTENT:?}: scale the scene up"))
            }
        }
    }
}

/// Returns a message about the f32 step of coordinates in a box, if it is above a share of the longest side.
pub(crate) fn rounding_text(low: Vec3, high: Vec3, share: f32) -> Option<String> {
    let largest = low.abs().max(high.abs()).max_element();
    let step = largest.next_up() - largest;
    (largest > 0.0 && step > share * (high - low).max_element())
        .then(|| format!("coordinates near {largest:e} are rounded to steps of {step}"))
}

pub(crate) fn check_light_count(count: usize) -> Result<(), Error> {
    if count <= MAX_LIGHTS {
        return Ok(());
    }
    Err(Error::Scene {
        element: "lights".into(),
        reason: format!("{count} lights; a scene can have at most {MAX_LIGHTS}"),
    })
}

/// Checks a texture's id in a scene with this number of textures.
pub(crate) fn check_texture(what: &str, TextureId(id): TextureId, textures: usize) -> Result<(), String> {
    match (id as usize) < textures {
        true => Ok(()),
        false => Err(format!("{what} {id} is out of range for {}", counted(textures, "texture", "textures"))),
    }
}

/// Checks that light or reflectance is finite and not negative.
pub(crate) fn check_color(what: &str, color: Vec3) -> Result<(), String> {
    match color.is_finite() && color.min_element() >= 0.0 {
        true => Ok(()),
        false => Err(format!("{what} is {color}; it must be finite and not negative")),
    }
}

pub(super) fn check_within(what: &str, value: f32, range: &RangeInclusive<f32>) -> Result<(), String> {
    match range.contains(&value) {
        true => Ok(()),
        false => Err(format!("{what} is {value}; it must be within {} to {}", range.start(), range.end())),
    }
}

pub(crate) fn check_coordinate(point: Vec3) -> Result<(), String> {
    match point.to_array().into_iter().find(|value| value.is_nan() || value.abs() > MAX_COORDINATE) {
        None => Ok(()),
        Some(value) if value.is_finite() => Err(format!("coordinate {value} is beyond ±{MAX_COORDINATE:e}")),
        Some(value) => Err(format!("coordinate {value} is not a finite number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Texture;

    #[test]
    fn materials_that_no_surface_has_are_refused_by_name_and_value() {
        let plain = || Material::new(Vec3::splat(0.5)).name("jade");
        let glass = |index, transmission| plain().finish(Finish::Glass { index, transmission, fresnel: true });
        let mirror = Finish::Mirror { fresnel: false };
        // This glass reflects its specular colour at any angle.
        let glass_of = |albedo, specular, transmission| {
            let finish = Finish::Glass { index: 1.5, transmission: Vec3::splat(transmission), fresnel: false };
            Material::new(Vec3::splat(albedo)).specular(Vec3::splat(specular)).finish(finish).name("jade")
        };
        let said = |material: Material| {
            let mut scene = Scene::new();
            scene.add_texture(Texture::checkerboard(Vec3::ONE, Vec3::ZERO, 8).unwrap());
            scene.add_material(material);
            scene.check().map_err(|error| error.to_string())
        };
        for (material, expected) in [
            (Material::new(Vec3::NAN).name("jade"), "albedo is [NaN"),
            (plain().specular(-Vec3::Y), "specular is [-0, -1, -0]"),
            (plain().emission(Vec3::INFINITY), "emission is [inf"),
            (plain().opacity(1.5), "opacity is 1.5; it must be within 0 to 1"),
            (plain().opacity(f32::NAN), "opacity is NaN"),
            (plain().exponent(-1.0), "exponent is -1; it must be within 0 to 10000"),
            (plain().exponent(f32::INFINITY), "exponent is inf"),
            (glass(0.0, Vec3::ZERO), "index is 0; it must be within 0.1 to 10"),
            (glass(f32::NAN, Vec3::ZERO), "index is NaN"),
            (glass(1.5, Vec3::NAN), "transmission is [NaN"),
            (plain().texture(TextureId(1)), "texture 1 is out of range for 1 texture"),
            (plain().cutout(TextureId(u32::MAX)), "cutout 4294967295 is out of range for 1 texture"),
            (
                plain().specular(Vec3::new(0.1, 0.6, 0.1)).finish(mirror),
                "returns more light than it receives: albedo, reflection and",
            ),
            (glass(1.5, Vec3::ONE), "; each channel can be at most 1"),
        ] {
            let message = said(material).unwrap_err();
            assert!(message.contains("material 1 'jade'") && message.contains(expected), "{expected}: {message}");
        }
        for material in [
            Material::new(Vec3::new(0.5, 1.5, 0.5)).name("jade"),
            plain().specular(Vec3::splat(0.6)).normalised(true),
            glass_of(0.4, 0.4, 0.5),
        ] {
            let message = said(material).unwrap_err();
            assert!(
                message.contains("material 1 'jade'") && message.contains("returns more light than it receives"),
                "{message}"
            );
        }
        for material in [
            plain().specular(Vec3::splat(0.5)).normalised(true),
            glass_of(0.4, 0.4, 0.3),
            plain().specular(Vec3::ONE).exponent(0.0).opacity(0.0).emission(Vec3::splat(15.0)),
            plain().specular(Vec3::splat(0.5)).finish(mirror).texture(TextureId(0)).cutout(TextureId(0)),
            Material::new(Vec3::splat(0.7)).specular(Vec3::splat(0.3)).finish(mirror),
            glass(10.0, Vec3::splat(0.5)).specular(Vec3::splat(0.5)).exponent(10_000.0),
        ] {
            said(material).unwrap();
        }
    }
}
