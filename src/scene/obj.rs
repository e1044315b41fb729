//! Reads OBJ and MTL files.
//!
//! tobj parses the numbers and makes triangles of the faces. It names no line in its errors, panics on some files,
//! takes `l` lines of three points for faces and doesn't tell `o` from `g`, so [`prepare`] goes over the text first:
//! it checks every index and leaves only lines that tobj reads as they are meant.

use std::{
    borrow::Cow,
    collections::HashSet,
    fs,
    io::Read,
    path::{Path, PathBuf},
};

use glam::Vec3;

use super::{MAX_COORDINATE, Material, MaterialId, Mesh, Scene};
use crate::Error;

/// Diffuse reflectance of a material whose file gives none.
const GREY: Vec3 = Vec3::splat(0.7);

/// What is wrong, and on which line, counted from 1.
type Fault = (usize, String);

/// A run of faces that belong together: it ends at each `o` and `g`, and where faces with and without normals meet.
#[derive(Clone, Default)]
struct Section {
    /// How many `o` lines came before.
    object: usize,
    object_name: String,
    group_name: String,
}

/// An OBJ file in the form that tobj gets.
#[derive(Default)]
struct Prepared {
    /// The `mtllib` lines. They go first, so that a `usemtl` may stand before them.
    libraries: String,
    /// All other lines that matter. Each section opens with `o` and its index, so tobj's models bear that name.
    text: String,
    sections: Vec<Section>,
    /// The names given to `usemtl`, each once, with the first line that does.
    used_materials: Vec<(usize, String)>,
    vertices: usize,
}

/// See [`Scene::from_obj`].
pub(super) fn read(path: &Path) -> Result<Scene, Error> {
    let text = read_text(path).map_err(|source| Error::io(path, source))?;
    let fault = |fault: Fault| Error::file(path, Some(fault.0), fault.1);
    // Of a bad number and a bad index, the message names whichever comes first in the file.
    let prepared = prepare(&text).map_err(|bad_index| {
        let bad_number = find_bad_number(&text).filter(|bad_number| bad_number.0 < bad_index.0);
        fault(bad_number.unwrap_or(bad_index))
    })?;

    // One index for positions and normals: a model then has as many normals as positions, or too few to use.
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut reader = prepared.libraries.as_bytes().chain(prepared.text.as_bytes());
    let loaded = tobj::load_obj_buf(&mut reader, &options, |library| {
        let materials = read_libraries(folder, library);
        let keys = materials.iter().enumerate().map(|(index, material)| (key(&material.name), index)).collect();
        Ok((materials, keys))
    });
    let (models, materials) = match loaded {
        Ok((models, materials)) => (models, materials.unwrap_or_default()),
        Err(tobj::LoadError::FaceColorOutOfBounds) => {
            let place = find_bad_number(&text).or_else(|| find_mixed_color(&text));
            return Err(place.map_or_else(|| Error::file(path, None, "vertex colours are incomplete"), fault));
        }
        Err(error) => {
            let place = find_bad_number(&text);
            return Err(place.map_or_else(|| Error::file(path, None, error.to_string()), fault));
        }
    };
    let numbers = |model: &tobj::Model| {
        model.mesh.positions.iter().all(|value| value.abs() <= MAX_COORDINATE)
            && model.mesh.normals.iter().all(|value| value.is_finite())
    };
    if !models.iter().all(numbers) {
        let place = find_bad_number(&text);
        return Err(place.map_or_else(|| Error::file(path, None, "a coordinate is no usable number"), fault));
    }

    let known: HashSet<&str> = materials.iter().map(|material| material.name.as_str()).collect();
    for (line, name) in &prepared.used_materials {
        if !known.contains(name.as_str()) {
            log::warn!("{}:{line}: no material '{name}' in the MTL files; its faces are grey", path.display());
        }
    }
    let mut scene = Scene::new();
    for material in materials {
        let albedo = material.diffuse.map_or(GREY, |color| Vec3::from(color).clamp(Vec3::ZERO, Vec3::ONE));
        scene.materials.push(Material { name: material.name, albedo });
    }
    for mesh in join_models(&models, &prepared.sections) {
        scene.add_mesh(&mesh)?;
    }
    if scene.triangles.is_empty() {
        let reason =
            format!("no faces and {} vertices; a scene needs `f` lines of 3 corners or more", prepared.vertices);
        return Err(Error::file(path, None, reason));
    }
    Ok(scene)
}

/// The file as text. Names and comments in another encoding are no reason to refuse a file, so what is not UTF-8
/// becomes a replacement character; a byte order mark goes.
fn read_text(path: &Path) -> std::io::Result<String> {
    let bytes = fs::read(path)?;
    let mut text = String::from_utf8(bytes).unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into());
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

/// Lines with their numbers from 1; a line that ends in a backslash goes on in the next.
fn lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().zip(1..);
    std::iter::from_fn(move || {
        let (line, number) = lines.next()?;
        // Not in comments, which may end in the name of a folder.
        let Some(start) = line.strip_suffix('\\').filter(|start| !start.contains('#')) else {
            return Some((number, Cow::Borrowed(line)));
        };
        let mut joined = String::from(start);
        for (next, _) in lines.by_ref() {
            let part = next.strip_suffix('\\');
            joined.push(' ');
            joined.push_str(part.unwrap_or(next));
            if part.is_none() {
                break;
            }
        }
        Some((number, Cow::Owned(joined)))
    })
}

/// A line's first word and the rest. Comments may follow numbers, but `#` is also part of names.
fn split_keyword(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = match keyword {
        "v" | "vn" | "f" => rest.split_once('#').map_or(rest, |(numbers, _)| numbers),
        _ => rest,
    };
    (keyword, rest.trim())
}

/// The name under which tobj looks a material up. The sign lets a material have an empty name, which tobj refuses.
fn key(material: &str) -> String {
    format!("={material}")
}

/// Checks every index and writes the lines that tobj is to read. Texture coordinates and lines (`l`) are left out.
fn prepare(text: &str) -> Result<Prepared, Fault> {
    let mut prepared = Prepared { text: String::with_capacity(text.len() + 16), ..Prepared::default() };
    let mut section = Section::default();
    let mut section_has_normals = None;
    let mut normals = 0;
    let mut used_materials = HashSet::new();
    for (number, line) in lines(text) {
        let (keyword, rest) = split_keyword(&line);
        match keyword {
            "v" => prepared.vertices += 1,
            "vn" => normals += 1,
            "f" => {
                let has_normals = check_face(rest, prepared.vertices, normals).map_err(|reason| (number, reason))?;
                if section_has_normals != Some(has_normals) {
                    prepared.text.push_str(&format!("o {}\n", prepared.sections.len()));
                    prepared.sections.push(section.clone());
                    section_has_normals = Some(has_normals);
                }
            }
            "o" => {
                section.object += 1;
                section.object_name = rest.into();
                section_has_normals = None;
                continue;
            }
            "g" => {
                section.group_name = rest.into();
                section_has_normals = None;
                continue;
            }
            "usemtl" => {
                prepared.text.push_str(&format!("usemtl {}\n", key(rest)));
                if used_materials.insert(rest.to_owned()) {
                    prepared.used_materials.push((number, rest.into()));
                }
                continue;
            }
            "mtllib" => {
                prepared.libraries.push_str(&format!("mtllib {rest}\n"));
                continue;
            }
            _ => continue,
        }
        prepared.text.push_str(keyword);
        prepared.text.push(' ');
        prepared.text.push_str(rest);
        prepared.text.push('\n');
    }
    Ok(prepared)
}

/// Checks the corners of a face against the vertices and normals so far, and tells whether all corners have normals.
fn check_face(corners: &str, vertices: usize, normals: usize) -> Result<bool, String> {
    if corners.is_empty() {
        return Err("a face without corners".into());
    }
    let mut has_normals = true;
    for corner in corners.split_whitespace() {
        let mut parts = corner.split('/');
        let mut next = || parts.next().filter(|part| !part.is_empty());
        let (vertex, texture, normal) = (next(), next(), next());
        let fault = |reason: String| format!("face corner '{corner}': {reason}");
        if parts.next().is_some() {
            return Err(fault("more than vertex/texture/normal".into()));
        }
        let vertex = vertex.ok_or_else(|| fault("no vertex index".into()))?;
        check_index("vertex", vertex, vertices).map_err(fault)?;
        if let Some(texture) = texture {
            parse_index("texture", texture).map_err(fault)?;
        }
        match normal {
            Some(normal) => check_index("normal", normal, normals).map_err(fault)?,
            None => has_normals = false,
        }
    }
    Ok(has_normals)
}

fn parse_index(what: &str, word: &str) -> Result<isize, String> {
    word.parse().map_err(|_| format!("{what} index '{word}' is not a whole number"))
}

/// Indices count from 1, or from -1 backwards.
fn check_index(what: &str, word: &str, count: usize) -> Result<(), String> {
    match parse_index(what, word)? {
        0 => Err(format!("{what} index 0; the first is 1")),
        index if index.unsigned_abs() > count => {
            Err(format!("{what} index {index} is out of range: there are {count} before this line"))
        }
        _ => Ok(()),
    }
}

/// The first `v` or `vn` line whose numbers are missing, too many, unreadable, not finite or too large.
fn find_bad_number(text: &str) -> Option<Fault> {
    lines(text).find_map(|(number, line)| {
        let (keyword, rest) = split_keyword(&line);
        let fault = match keyword {
            "v" => check_numbers("vertex", rest, MAX_COORDINATE),
            // tobj reads three numbers and leaves alone what follows them.
            "vn" => {
                let words: Vec<&str> = rest.split_whitespace().take(3).collect();
                check_numbers("normal", &words.join(" "), f32::MAX)
            }
            _ => return None,
        };
        fault.err().map(|reason| (number, reason))
    })
}

fn check_numbers(what: &str, words: &str, largest: f32) -> Result<(), String> {
    let mut values = Vec::new();
    for word in words.split_whitespace() {
        values.push(word.parse::<f32>().map_err(|_| format!("{what}: '{word}' is not a number"))?);
    }
    let count = values.len();
    let (coordinates, more) = values.split_at_checked(3).ok_or_else(|| format!("{what}: {count} numbers of 3"))?;
    let scale = match *more {
        [] | [_, _, _] => 1.0,
        [0.0] => return Err(format!("{what}: the weight w is 0")),
        [w] => w,
        _ => return Err(format!("{what}: {count} numbers; give x y z, x y z w, or x y z r g b")),
    };
    match coordinates.iter().map(|value| value / scale).find(|value| value.is_nan() || value.abs() > largest) {
        None => Ok(()),
        Some(value) if value.is_finite() => {
            Err(format!("{what}: {value} is beyond ±{largest:e}; scale the scene down"))
        }
        Some(value) => Err(format!("{what}: {value} is not a finite number")),
    }
}

/// The first vertex that has a colour where the first vertex has none, or the other way round.
fn find_mixed_color(text: &str) -> Option<Fault> {
    let mut first = None;
    lines(text).find_map(|(number, line)| {
        let ("v", rest) = split_keyword(&line) else { return None };
        let colored = rest.split_whitespace().count() == 6;
        let (first_line, first_colored) = *first.get_or_insert((number, colored));
        let (has, had) = if colored { ("a", "none") } else { ("no", "one") };
        let reason = format!(
            "this vertex has {has} colour and the first, on line {first_line}, has {had}; give all vertices x y z r g b, \
             or none (colours are not used)"
        );
        (colored != first_colored).then_some((number, reason))
    })
}

/// Reads what a `mtllib` line names: one file, whose name may have spaces, or several. Grey replaces what can't be
/// read: a picture in grey is more use than none.
fn read_libraries(folder: &Path, names: &Path) -> Vec<tobj::Material> {
    let names = names.to_string_lossy();
    let whole = locate_library(folder, &names);
    let files: Vec<PathBuf> = if whole.is_file() || !names.contains(char::is_whitespace) {
        vec![whole]
    } else {
        names.split_whitespace().map(|name| locate_library(folder, name)).collect()
    };
    let mut materials = Vec::new();
    for file in files {
        match read_text(&file) {
            Ok(text) => parse_mtl(&file, &text, &mut materials),
            Err(error) => log::warn!("{}: {error}; its materials are grey", file.display()),
        }
    }
    materials
}

/// Names are relative to the OBJ; some come with the separators of another system.
fn locate_library(folder: &Path, name: &str) -> PathBuf {
    let file = folder.join(name);
    if file.is_file() { file } else { folder.join(name.replace('\\', "/")) }
}

/// Takes names and diffuse colours. tobj's own reader panics on a colour that lacks numbers, and gives the whole file
/// up for a bad line in it.
fn parse_mtl(file: &Path, text: &str, materials: &mut Vec<tobj::Material>) {
    let mut current: Option<tobj::Material> = None;
    for (number, line) in lines(text) {
        match split_keyword(&line) {
            ("newmtl", name) => {
                materials.extend(current.take());
                current = Some(tobj::Material { name: name.into(), ..Default::default() });
            }
            ("Kd", words) => match (&mut current, parse_color(words)) {
                (Some(material), Some(color)) => material.diffuse = Some(color),
                (Some(material), None) => log::warn!(
                    "{}:{number}: Kd '{words}' of material '{}' is no colour, which takes three finite numbers; it is grey",
                    file.display(),
                    material.name
                ),
                (None, _) => log::warn!("{}:{number}: Kd before the first newmtl; it is left out", file.display()),
            },
            ("map_Kd", _) => {
                log::warn!("{}:{number}: textures are not read; the material keeps its Kd", file.display());
            }
            _ => {}
        }
    }
    materials.extend(current);
}

/// Three numbers, or one for all three (MTL's rule).
fn parse_color(words: &str) -> Option<[f32; 3]> {
    let words = words.split_once('#').map_or(words, |(numbers, _)| numbers);
    let values: Option<Vec<f32>> =
        words.split_whitespace().map(|word| word.parse().ok().filter(|value: &f32| value.is_finite())).collect();
    match values?[..] {
        [r, g, b] => Some([r, g, b]),
        [grey] => Some([grey; 3]),
        _ => None,
    }
}

/// Makes one mesh of each object out of tobj's models, which end at each change of material and section.
fn join_models(models: &[tobj::Model], sections: &[Section]) -> Vec<Mesh> {
    let has_objects = sections.iter().any(|section| section.object > 0);
    let mut meshes: Vec<Mesh> = Vec::new();
    let mut last: Option<&Section> = None;
    // The last model has no faces if nothing follows the last section's name.
    for model in models.iter().filter(|model| !model.mesh.indices.is_empty()) {
        let section =
            model.name.parse().ok().and_then(|index: usize| sections.get(index)).expect("prepare names every model");
        let continues = last.is_some_and(|last| match has_objects {
            true => last.object == section.object,
            false => last.group_name == section.group_name,
        });
        last = Some(section);
        if !continues {
            let name = if has_objects { &section.object_name } else { &section.group_name };
            meshes.push(Mesh { name: name.clone(), ..Mesh::default() });
        }
        if let Some(mesh) = meshes.last_mut() {
            add_model(mesh, &model.mesh);
        }
    }
    for mesh in &mut meshes {
        if !mesh.normals.is_empty() {
            mesh.normals.resize(mesh.triangles.len(), [Vec3::ZERO; 3]);
        }
    }
    meshes
}

fn add_model(mesh: &mut Mesh, model: &tobj::Mesh) {
    let first_vertex = mesh.positions.len() as u32;
    let first_triangle = mesh.triangles.len();
    let (positions, _) = model.positions.as_chunks::<3>();
    let (triangles, _) = model.indices.as_chunks::<3>();
    mesh.positions.extend(positions.iter().copied().map(Vec3::from_array));
    mesh.triangles.extend(triangles.iter().map(|corners| corners.map(|corner| first_vertex + corner)));
    let material = model.material_id.map_or(MaterialId(0), |index| MaterialId(index as u32 + 1));
    mesh.materials.resize(mesh.triangles.len(), material);
    // Fewer normals than positions: some corner has none, and the list no longer says which.
    if model.normals.len() == model.positions.len() {
        // Normals that tobj left out for a flat model before this one.
        mesh.normals.resize(first_triangle, [Vec3::ZERO; 3]);
        let (normals, _) = model.normals.as_chunks::<3>();
        mesh.normals.extend(triangles.iter().map(|corners| {
            let normals = corners.map(|corner| unit(Vec3::from_array(normals[corner as usize])));
            if normals.contains(&Vec3::ZERO) { [Vec3::ZERO; 3] } else { normals }
        }));
    }
}

/// Zero has no direction and stays zero; f64, so that tiny and huge normals keep theirs.
fn unit(normal: Vec3) -> Vec3 {
    normal.as_dvec3().normalize_or_zero().as_vec3()
}
