//! What a scene may hold: coordinates, colours, lights and its extent in bounds.

use glam::Vec3;

use super::{MAX_COORDINATE, MAX_LIGHTS, MIN_EXTENT, MaterialId, Scene, Sky, Sphere};
use crate::Error;

/// The step of f32, as a share of a scene's longest side, above which pictures suffer: half a pixel where the side is 5000
/// pixels long. DESIGN, section 2, has the measurements.
const COARSE_STEP: f32 = 1e-4;

impl Scene {
    pub(super) fn check_material(&self, material: MaterialId) -> Result<(), String> {
        if (material.0 as usize) < self.materials.len() {
            return Ok(());
        }
        Err(format!("material {} of {}", material.0, self.materials.len()))
    }

    pub(super) fn check_sphere(&self, index: usize, sphere: &Sphere) -> Result<(), Error> {
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

    /// The public fields hold any value until a scene is uploaded; here they are checked.
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
            Sky::Map(_) => {} // checked when it was made
        }
        for (index, material) in self.materials.iter().enumerate() {
            check(format!("material {index} '{}'", material.name), check_color("albedo", material.albedo))?;
        }
        check_light_count(self.lights.len())?;
        for (index, light) in self.lights.iter().enumerate() {
            check(format!("light {index}"), check_color("intensity", light.intensity))?;
            check(format!("light {index}"), check_coordinate(light.position))?;
        }
        check("geometry".into(), self.check_extent())
    }

    /// What to say of a scene that is so far from the origin that its picture suffers.
    pub(crate) fn rounding_warning(&self) -> Option<String> {
        let (low, high) = self.bounds()?;
        let rounded = rounding_text(low, high, COARSE_STEP)?;
        let side = (high - low).max_element();
        Some(format!(
            "the scene's {rounded}, and its longest side is {side}: detail and shadows break up; move it nearer to the \
             origin"
        ))
    }

    /// Far from the origin a sphere or an ellipsoid can be less than a step of f32 across, and its box nothing.
    fn check_extent(&self) -> Result<(), String> {
        let Some((low, high)) = self.bounds() else { return Ok(()) };
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

/// What coordinates between two corners are rounded to, where that is more than a share of the longest side.
pub(super) fn rounding_text(low: Vec3, high: Vec3, share: f32) -> Option<String> {
    let largest = low.abs().max(high.abs()).max_element();
    let step = largest.next_up() - largest;
    (largest > 0.0 && step > share * (high - low).max_element())
        .then(|| format!("coordinates near {largest:e} are rounded to steps of {step}"))
}

pub(super) fn check_light_count(count: usize) -> Result<(), Error> {
    if count <= MAX_LIGHTS {
        return Ok(());
    }
    Err(Error::Scene { element: "lights".into(), reason: format!("{count} of them; it can have at most {MAX_LIGHTS}") })
}

/// Light and reflectance are finite and not negative.
fn check_color(what: &str, color: Vec3) -> Result<(), String> {
    match color.is_finite() && color.min_element() >= 0.0 {
        true => Ok(()),
        false => Err(format!("{what} is {color}; it must be finite and not negative")),
    }
}

pub(super) fn check_coordinate(point: Vec3) -> Result<(), String> {
    match point.to_array().into_iter().find(|value| value.is_nan() || value.abs() > MAX_COORDINATE) {
        None => Ok(()),
        Some(value) if value.is_finite() => Err(format!("coordinate {value} is beyond ±{MAX_COORDINATE:e}")),
        Some(value) => Err(format!("coordinate {value} is not a finite number")),
    }
}
