//! Reads the MTL files that an OBJ names, down to a colour for each material.

use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
};

use glam::Vec3;

use super::{GREY, lines, read_text, split_keyword, without_comment};
use crate::{Limits, Material, scene::warnings::Warnings};

/// From this illumination model on, materials are mirrors or glass, with one exception that nothing writes (10).
const FIRST_MIRROR: u32 = 3;

/// The materials of all MTL files of an OBJ.
#[derive(Default)]
pub(super) struct Library {
    pub(super) materials: Vec<Material>,
    /// Where each name is in the list.
    pub(super) index_of: HashMap<String, usize>,
}

/// Reads the files that `mtllib` lines name. Each line names one file, whose name may have spaces, or several. Grey
/// replaces what can't be read: a picture in grey is more use than none.
pub(super) fn read(obj: &Path, names: &[(usize, String)], limits: &Limits, warnings: &mut Warnings) -> Library {
    let folder = obj.parent().unwrap_or(Path::new(""));
    let mut library = Library::default();
    let mut read = HashSet::new();
    let mut limits_left = *limits;
    let files = names.iter().flat_map(|(line, name)| locate(folder, name).into_iter().map(move |file| (*line, file)));
    for (line, file) in files {
        // A file may have several names.
        if !read.insert(file.canonicalize().unwrap_or_else(|_| file.clone())) {
            continue;
        }
        match read_text(&file, &limits_left) {
            Ok((text, bytes)) => {
                limits_left.file_bytes -= bytes;
                library.add(&file, &text);
            }
            Err(error) => warnings.warn_of("MTL files that can't be read", line, &error, "its materials are grey"),
        }
    }
    library
}

/// The files of one `mtllib` line: several where one of them is there, else the name as it stands.
fn locate(folder: &Path, names: &str) -> Vec<PathBuf> {
    let whole = locate_one(folder, names);
    if whole.is_file() {
        return vec![whole];
    }
    let several: Vec<_> = names.split_whitespace().map(|name| locate_one(folder, name)).collect();
    if several.iter().any(|file| file.is_file()) { several } else { vec![whole] }
}

/// Names are relative to the OBJ; some come with the separators of another system.
fn locate_one(folder: &Path, name: &str) -> PathBuf {
    let file = folder.join(name);
    if file.is_file() { file } else { folder.join(name.replace('\\', "/")) }
}

/// A material as its lines are read.
struct Draft {
    name: String,
    line: usize,
    diffuse: Option<Vec3>,
    specular: Vec3,
    illumination: Option<u32>,
}

impl Library {
    /// Adds the materials of a file.
    fn add(&mut self, file: &Path, text: &str) {
        let mut warnings = Warnings::new(file);
        let mut current: Option<Draft> = None;
        for (line, content) in lines(text) {
            let (keyword, rest) = split_keyword(&content);
            if keyword == "newmtl" {
                if let Some(draft) = current.take() {
                    self.finish(draft, &mut warnings);
                }
                let name = rest.into();
                current = Some(Draft { name, line, diffuse: None, specular: Vec3::ZERO, illumination: None });
            } else {
                read_statement(keyword, rest, line, current.as_mut(), &mut warnings);
            }
        }
        if let Some(draft) = current {
            self.finish(draft, &mut warnings);
        }
    }

    /// Of several materials of one name the last holds.
    fn finish(&mut self, draft: Draft, warnings: &mut Warnings) {
        let albedo = draft.albedo(warnings).clamp(Vec3::ZERO, Vec3::ONE);
        let material = Material::new(albedo).name(draft.name.clone());
        match self.index_of.get(&draft.name) {
            Some(&index) => self.materials[index] = material,
            None => {
                self.index_of.insert(draft.name, self.materials.len());
                self.materials.push(material);
            }
        }
    }
}

impl Draft {
    /// The diffuse colour. A mirror or glass without one would be black for want of reflections.
    fn albedo(&self, warnings: &mut Warnings) -> Vec3 {
        let mirror = self.illumination.filter(|model| *model >= FIRST_MIRROR);
        let black = self.diffuse.is_none_or(|diffuse| diffuse.max_element() <= 0.0);
        match mirror {
            Some(model) if black => {
                let shiny = self.specular.max_element() > 0.0;
                let (what, albedo) = if shiny { ("its specular colour (Ks)", self.specular) } else { ("grey", GREY) };
                warnings.warn(
                    "mirrors and glasses without a diffuse colour",
                    self.line,
                    format!(
                        "material '{}' is a mirror or glass (illum {model}) without a diffuse colour; \
                         reflection is not rendered, {what} takes its place",
                        self.name
                    ),
                );
                albedo
            }
            _ => self.diffuse.unwrap_or(GREY),
        }
    }
}

/// Takes what a line says of the current material, and notes what pictures don't show of it. Values that change nothing, as
/// exporters write them, are not worth a word.
fn read_statement(keyword: &str, rest: &str, line: usize, draft: Option<&mut Draft>, warnings: &mut Warnings) {
    let numbers = without_comment(rest).trim();
    let color = parse_color(numbers);
    let is = |value: f32| color.is_some_and(|color| color == Vec3::splat(value));
    match (keyword, draft) {
        ("Kd", Some(draft)) => match color {
            Some(color) => draft.diffuse = Some(color),
            None => {
                let reason = "is no colour, which takes three finite numbers; it is grey";
                let text = format!("Kd '{rest}' of material '{}' {reason}", draft.name);
                warnings.warn("diffuse colours (Kd) that are none", line, text);
            }
        },
        ("Kd", None) => warnings.warn(
            "diffuse colours (Kd) before the first newmtl",
            line,
            "Kd before the first newmtl; it is left out",
        ),
        ("Ks", draft) => {
            if let (Some(draft), Some(color)) = (draft, color) {
                draft.specular = color;
            }
            if !is(0.0) {
                warnings.left_out("highlights (Ks)", line);
            }
        }
        ("illum", draft) => {
            let model = numbers.parse().ok();
            if model.is_some_and(|model| model >= FIRST_MIRROR) {
                warnings.left_out("reflections and refractions (illum 3 and above)", line);
            }
            if let Some(draft) = draft {
                draft.illumination = model;
            }
        }
        ("Ke", _) if !is(0.0) => warnings.left_out("emissions (Ke)", line),
        ("Ka", _) if !is(0.0) => warnings.left_out("ambient colours of their own (Ka)", line),
        ("Ni", _) => warnings.left_out("indices of refraction (Ni)", line),
        ("d" | "Tf", _) if !is(1.0) => warnings.left_out("transparencies (d, Tr, Tf)", line),
        ("Tr", _) if !is(0.0) => warnings.left_out("transparencies (d, Tr, Tf)", line),
        ("Pr" | "Pm" | "Ps" | "Pc" | "Pcr" | "aniso" | "anisor", _) => {
            warnings.left_out("physically based parameters (Pr, Pm and their like)", line);
        }
        ("bump" | "disp" | "decal" | "refl" | "norm", _) => warnings.left_out(TEXTURES, line),
        (keyword, _) if keyword.starts_with("map_") => warnings.left_out(TEXTURES, line),
        // Ns and sharpness say more of what is left out anyway.
        ("Ke" | "Ka" | "d" | "Tf" | "Tr" | "Ns" | "sharpness" | "", _) => {}
        (keyword, _) if keyword.starts_with('#') => {}
        _ => warnings.left_out("unknown statements", line),
    }
}

const TEXTURES: &str = "textures (map_Kd and their like)";

/// Three numbers, or one for all three (MTL's rule).
fn parse_color(words: &str) -> Option<Vec3> {
    let mut words = words.split_whitespace();
    let mut next = || words.next().map(|word| word.parse().ok().filter(|value: &f32| value.is_finite()));
    match [next(), next(), next(), next()] {
        [Some(Some(r)), Some(Some(g)), Some(Some(b)), None] => Some(Vec3::new(r, g, b)),
        [Some(Some(grey)), None, ..] => Some(Vec3::splat(grey)),
        _ => None,
    }
}
