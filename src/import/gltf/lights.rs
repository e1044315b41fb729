//! Reads lights of the extension `KHR_lights_punctual`.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use gltf_json::{
    extensions::scene::khr_lights_punctual::{Light as Description, Type},
    validation::Checked,
};

use super::{Placed, document::Document};
use crate::{
    Error, Light,
    import::warnings::{Place, Warnings},
    scene::{MAX_LIGHTS, MAX_SOFT_LIGHTS},
};

/// Returns the scene's lights. Lights here have no falloff. A point light gets its intensity at the centre of the
/// scene's box, at a distance of at least half the box's longest side. Together, the lights are scaled to at most 1 on
/// a white surface there, since photometric units rely on a camera's exposure.
pub(super) fn read(
    document: &Document,
    places: &[Placed<(usize, usize)>],
    (origin, bounds): (DVec3, Option<(DVec3, DVec3)>),
    warnings: &mut Warnings,
) -> Result<Vec<Light>, Error> {
    let root = &document.root;
    let descriptions = root.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    let descriptions = descriptions.map_or(&[][..], |extension| &extension.lights);
    let (low, high) = bounds.unwrap_or_default();
    let (middle, nearest) = (low.midpoint(high), 0.5 * (high - low).max_element().max(1e-6));
    let mut lights: Vec<(Light, DVec3)> = Vec::new();
    let mut directional = 0;
    for &((node, index), place) in places {
        let description = document.item(("lights", descriptions), index, format_args!("nodes[{node}]"))?;
        let item = Place::Item("lights", index);
        let Checked::Valid(kind) = description.type_ else {
            return Err(document.fault(format!("lights[{index}]: its type is unknown")));
        };
        note_left_out(description, kind, item, warnings);
        directional += usize::from(kind == Type::Directional);
        if lights.len() == MAX_LIGHTS || kind == Type::Directional && directional > MAX_SOFT_LIGHTS {
            warnings.left_out("lights over a scene's limit", item);
            continue;
        }
        let color = Vec3::from_array(description.color).as_dvec3();
        let strength = f64::from(description.intensity) / PI;
        if !(strength >= 0.0 && strength.is_finite() && color.is_finite() && color.min_element() >= 0.0) {
            let reason = format!(
                "lights[{index}]: its intensity is {} times {color}; it must be finite and not negative",
                description.intensity
            );
            return Err(document.fault(reason));
        }
        let (light, radiance) = match kind {
            Type::Directional => {
                let towards = place.transform_vector3(DVec3::Z).normalize_or_zero();
                (Light::directional(towards, 0.0, Vec3::ZERO), color * strength)
            }
            Type::Point | Type::Spot => {
                let distance = place.translation.distance(middle).max(nearest);
                (Light::point(place.translation, Vec3::ZERO), color * strength / (distance * distance))
            }
        };
        light.check(origin).map_err(|reason| document.fault(format!("lights[{index}] at nodes[{node}]: {reason}")))?;
        lights.push((light, radiance));
    }
    let total: DVec3 = lights.iter().map(|(_, radiance)| radiance).sum();
    let brightest = total.max_element();
    if brightest > 1.0 {
        warnings.warn_once(format!(
            "its lights are {brightest:.4} times as bright as a white surface can show; they are scaled down to 1"
        ));
    }
    let with_light =
        |(light, radiance): (Light, DVec3)| Light { intensity: (radiance / brightest.max(1.0)).as_vec3(), ..light };
    Ok(lights.into_iter().map(with_light).collect())
}

fn note_left_out(description: &Description, kind: Type, place: Place, warnings: &mut Warnings) {
    if kind != Type::Directional {
        warnings.left_out("falloffs of lights", place);
    }
    if kind == Type::Spot {
        warnings.left_out("cones of spot lights, which shine in all directions", place);
    }
    if description.range.is_some() {
        warnings.left_out("ranges of lights", place);
    }
}
