//! What is read of an MTL and not rendered yet. This file goes, with its two callers and `Material::stands_in`, when it is.

use glam::Vec3;

use super::super::GREY;
use crate::{Finish, Material, scene::warnings::Warnings};

/// A mirror or glass without a diffuse colour would be black for want of reflections: it takes its specular one, or grey.
pub(super) fn stand_in_for_reflection(
    material: &mut Material,
    specular: Option<Vec3>,
    (model, line): (u32, usize),
    warnings: &mut Warnings,
) {
    if material.finish == Finish::Matte || material.albedo.max_element() > 0.0 {
        return;
    }
    let shiny = specular.filter(|specular| specular.max_element() > 0.0);
    let what = if shiny.is_some() { "its specular colour (Ks)" } else { "grey" };
    material.albedo = shiny.map_or(GREY, |_| material.specular);
    material.stands_in = true;
    warnings.warn(
        "mirrors and glasses without a diffuse colour",
        line,
        format!(
            "material '{}' is a mirror or glass (illum {model}) without a diffuse colour; reflection is not rendered, \
             {what} takes its place",
            material.name
        ),
    );
}

/// Notes a statement that pictures don't show. Values that change nothing, as exporters write them, are not worth a word.
pub(super) fn note(keyword: &str, numbers: &str, line: usize, warnings: &mut Warnings) {
    let is = |value: f32| super::draft::parse_color(numbers).is_some_and(|color| color == Vec3::splat(value));
    let what = match keyword {
        "Ks" if !is(0.0) => "highlights (Ks)",
        "illum" if numbers.parse().is_ok_and(|model: u32| model >= 3) => {
            "reflections and refractions (illum 3 and above)"
        }
        "Ke" if !is(0.0) => "emissions (Ke)",
        "Ni" => "indices of refraction (Ni)",
        "d" | "Tf" if !is(1.0) => "transparencies (d, Tr, Tf)",
        "Tr" if !is(0.0) => "transparencies (d, Tr, Tf)",
        "map_Kd" | "map_d" => "textures (map_Kd, map_d)",
        _ => return,
    };
    warnings.left_out(what, line);
}
