//! Reads the MTL files of an OBJ.

mod draft;
#[cfg(feature = "textures")]
mod files;
#[cfg(not(feature = "textures"))]
#[path = "mtl/no_files.rs"]
mod files;
mod maps;

use std::{
    collections::{HashMap, HashSet},
    path::{Path, PathBuf},
};

pub(super) use self::maps::Placement;
use self::{
    draft::{Draft, Found, read_statement},
    files::Textures,
};
use super::{Prepared, SceneOptions, lines, read_text, split_keyword};
use crate::{Error, Material, Texture, import::input::Files, import::warnings::Warnings, message::counted};

/// The materials of all MTL files of an OBJ.
#[derive(Default)]
pub(super) struct Library {
    pub(super) materials: Vec<Material>,
    /// Placement of each material's texture.
    pub(super) placements: Vec<Placement>,
    pub(super) textures: Vec<Texture>,
    /// Index of each material, by its name.
    pub(super) index_of: HashMap<String, usize>,
}

/// Reads the files in `mtllib` lines. Each line names one file, whose name may have spaces, or several files. The
/// materials of unreadable files are grey, with a warning. `options` say whether unreadable textures are an error.
pub(super) fn read(
    files: Files,
    obj: &Path,
    prepared: &Prepared,
    options: &SceneOptions,
    warnings: &mut Warnings,
) -> Result<Library, Error> {
    let folder = obj.parent().unwrap_or(Path::new(""));
    let used: HashSet<&str> = prepared.used_materials.iter().map(|(_, name)| &**name).collect();
    let mut textures = Textures::new(files, obj, options);
    let mut library = Library::default();
    let mut read = HashSet::new();
    let mut limits_left = options.limits;
    let mut libraries = Vec::new();
    for (line, name) in &prepared.libraries {
        let located = locate(files, folder, name);
        let located = located.map_err(|error| {
            Error::parse_from(obj, Some(*line), format!("mtllib '{name}': {}", error.without_path()), error)
        })?;
        libraries.extend(located.into_iter().map(|file| (*line, file)));
    }
    for (line, file) in libraries {
        // A file may have several names.
        if !read.insert(files.real(&file)) {
            continue;
        }
        match read_text(files, &file, &limits_left) {
            Ok((text, bytes)) => {
                limits_left.file_bytes -= bytes;
                library.add(&file, &text, &used, &mut textures)?;
            }
            Err(error) => warnings.warn_of("MTL files that can't be read", line, &error, "its materials are grey"),
        }
    }
    library.textures = textures.textures;
    Ok(library)
}

/// Returns the files of one `mtllib` line: several if at least one of them exists, else one with the whole name.
fn locate(files: Files, folder: &Path, names: &str) -> Result<Vec<PathBuf>, Error> {
    // This looks at the exact path, since the last component of several names belongs to the last one only.
    if !files.is_file(&files.join(folder, names)) {
        let several = names.split_whitespace().map(|name| files.locate(folder, name));
        let several = several.collect::<Result<Vec<_>, _>>()?;
        if several.iter().any(|file| files.is_file(file)) {
            return Ok(several);
        }
    }
    Ok(vec![files.locate(folder, names)?])
}

impl Library {
    /// Adds the materials of a file. Only textures of used materials are read.
    fn add(&mut self, file: &Path, text: &str, used: &HashSet<&str>, textures: &mut Textures) -> Result<(), Error> {
        let mut warnings = Warnings::new(file);
        let mut drafts: Vec<Draft> = Vec::new();
        for (line, content) in lines(text) {
            let (keyword, rest) = split_keyword(&content);
            match keyword {
                "newmtl" => drafts.push(Draft::new(rest, line)),
                _ => read_statement(keyword, rest, line, drafts.last_mut(), &mut warnings),
            }
        }
        let mut out_of_range = 0;
        for draft in drafts {
            let mut found = Found::new();
            for map in draft.maps.iter().filter(|_| used.contains(&*draft.name)) {
                let id = textures.find(file, map, &draft.name, &mut warnings)?;
                found.extend(id.map(|id| (map.purpose, id)));
            }
            out_of_range += self.finish(draft, &found, &mut warnings);
        }
        if out_of_range > 0 {
            let materials = counted(out_of_range, "material", "materials");
            warnings.warn_once(format!("values out of range, which are clamped, in {materials}"));
        }
        Ok(())
    }

    /// Adds a material; a later one replaces an earlier one of the same name. Returns 1 if it has values out of range.
    fn finish(&mut self, draft: Draft, found: &Found, warnings: &mut Warnings) -> usize {
        let placement = draft.placement(warnings);
        let (material, out_of_range) = draft.finish(found, warnings);
        match self.index_of.get(&material.name) {
            Some(&index) => (self.materials[index], self.placements[index]) = (material, placement),
            None => {
                self.index_of.insert(material.name.clone(), self.materials.len());
                self.materials.push(material);
                self.placements.push(placement);
            }
        }
        usize::from(out_of_range)
    }
}
