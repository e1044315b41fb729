//! Reads lights of the extension `KHR_lights_punctual`.

use std::f32::consts::FRAC_PI_4;
use std::f64::consts::PI;

use glam::{DAffine3, DVec3, Vec3};
use gltf_json::{
    extensions::scene::khr_lights_punctual::{Light as Description, Type},
    validation::Checked,
};

use super::{Placed, document::Document};
use crate::{
    Error, Falloff, Light, Scene,
    import::warnings::{Place, Warnings},
    scene::{MAX_LIGHTS, MAX_SOFT_LIGHTS},
};

/// Radiance of a white surface at the scene's centre over which the lights of a file by Blender are in photometric
/// units. Its exporter multiplies watts by [`LUMENS`] for lights, but not for surfaces that emit light.
const BLENDER_PHOTOMETRIC: f64 = 20.0;
/// Lumens per watt in files by Blender.
const LUMENS: f64 = 683.0;

/// Gives the scene its lights, and returns the node of each. Together, lights and emission are scaled so that the
/// lights add at most 1 to a white surface at the centre of the scene's box. Photometric units rely on a camera's
/// exposure. For that rule, lights are at least half the box's longest side away.
pub(super) fn read(
    document: &Document,
    places: &[Placed<(usize, usize)>],
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<Vec<usize>, Error> {
    let root = &document.root;
    let descriptions = root.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    let descriptions = descriptions.map_or(&[][..], |extension| &extension.lights);
    let (low, high) = scene.bounds().unwrap_or_default();
    let (middle, nearest) = (low.midpoint(high), 0.5 * (high - low).max_element().max(1e-6));
    let mut lights: Vec<(Light, DVec3)> = Vec::new();
    let mut nodes = Vec::new();
    let mut total = DVec3::ZERO;
    let mut directional = 0;
    for &((node, index), place) in places {
        let description = document.item(("lights", descriptions), index, format_args!("nodes[{node}]"))?;
        let item = Place::Item("lights", index);
        let Checked::Valid(kind) = description.type_ else {
            return Err(document.fault(format!("lights[{index}]: its type is unknown")));
        };
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
        let light = light_of(description, kind, place);
        light
            .check(scene.origin(), scene.textures().len())
            .map_err(|reason| document.fault(format!("lights[{index}] at nodes[{node}]: {reason}")))?;
        let distance = place.translation.distance(middle).max(nearest);
        total += color * strength / if kind == Type::Directional { 1.0 } else { distance * distance };
        lights.push((light, color * strength));
        nodes.push(node);
    }
    let brightest = total.max_element();
    let is_blenders = root.asset.generator.as_ref().is_some_and(|generator| generator.contains("Blender"));
    let unit = if is_blenders && brightest > BLENDER_PHOTOMETRIC { LUMENS } else { 1.0 };
    let scale = (brightest / unit).max(1.0);
    if scale > 1.0 {
        warnings.warn_once(format!(
            "its lights are {scale:.4} times as bright as a white surface can show; they and its emission are scaled \
             down to 1"
        ));
        scene.dim_emission((1.0 / scale) as f32);
    }
    let with_light = |(light, radiance): (Light, DVec3)| {
        let intensity = (radiance / (unit * scale)).as_vec3();
        Light { intensity, ..light }
    };
    scene.lights = lights.into_iter().map(with_light).collect();
    Ok(nodes)
}

/// Returns a light without its intensity.
fn light_of(description: &Description, kind: Type, place: DAffine3) -> Light {
    let towards = place.transform_vector3(DVec3::Z).normalize_or_zero();
    if kind == Type::Directional {
        return Light::directional(towards, 0.0, Vec3::ZERO);
    }
    let mut light = Light::point(place.translation, Vec3::ZERO);
    light.falloff = Falloff::Quadratic { range: description.range };
    match (kind, &description.spot) {
        (Type::Spot, Some(spot)) => light.with_cone(-towards.as_vec3(), spot.inner_cone_angle, spot.outer_cone_angle),
        (Type::Spot, None) => light.with_cone(-towards.as_vec3(), 0.0, FRAC_PI_4),
        _ => light,
    }
}
