//! Reads OBJ and MTL files.
//!
//! tobj parses the numbers. It names no line in its errors, panics on some files,
//! takes `l` lines of three points for faces and doesn't tell `o` from `g`, so [`prepare`] goes over the text first:
//! it checks every index and leaves only lines that tobj reads as they are meant. It can only fan faces, so they are
//! split into triangles here (polygon.rs).

mod checks;
mod ears;
mod models;
mod mtl;
mod polygon;

use std::{borrow::Cow, collections::HashSet, io::Read, path::Path};

use glam::Vec3;

use self::{
    checks::{check_face, find_bad_number, find_mixed_color},
    models::join_models,
};
use super::{MAX_COORDINATE, MaterialId, Mesh, Scene, mesh::dropped_text, warnings::Warnings};
use crate::{Error, Limits, input, message::counted};

/// Diffuse reflectance of a material whose file gives none.
const GREY: Vec3 = Vec3::splat(0.7);

/// What is wrong, and on which line, counted from 1.
type Fault = (usize, String);

/// A run of faces that belong together: it ends at each `o` and `g`, and where faces with and without normals meet.
#[derive(Clone, Copy, Default)]
struct Section {
    /// How many `o` lines came before.
    object: usize,
    /// The object's name as an index into [`Prepared::names`]: a name may be long, and sections as many as faces.
    object_name: usize,
    /// The group's.
    group_name: usize,
}

/// An OBJ file in the form that tobj gets.
#[derive(Default)]
struct Prepared {
    /// What `mtllib` lines name, each once, with the first line that does.
    libraries: Vec<(usize, String)>,
    /// All other lines that matter. Each section opens with `o` and its index, so tobj's models bear that name.
    text: String,
    sections: Vec<Section>,
    /// The names of objects and groups, an empty one first.
    names: Vec<String>,
    /// The names given to `usemtl`, each once, with the first line that does.
    used_materials: Vec<(usize, String)>,
    /// Vertices and normals so far.
    vertices: usize,
    normals: usize,
    /// The lines of the faces of more than three corners.
    polygon_lines: Vec<usize>,
    /// What a face belongs to here, and whether the last one of it had normals.
    section: Section,
    section_has_normals: Option<bool>,
}

/// See [`Scene::from_obj_within`].
pub(super) fn read(path: &Path, limits: &Limits) -> Result<Scene, Error> {
    let (text, _) = read_text(path, limits)?;
    let mut warnings = Warnings::new(path);
    // Of a bad number and a bad index, the message names whichever comes first in the file.
    let prepared = prepare(&text, &mut warnings).map_err(|bad_index| {
        let bad_number = find_bad_number(&text).filter(|bad_number| bad_number.0 < bad_index.0);
        let (line, reason) = bad_number.unwrap_or(bad_index);
        Error::parse(path, Some(line), reason)
    })?;
    let library = mtl::read(path, &prepared.libraries, limits, &mut warnings);
    let models = parse(path, &text, &prepared, &library)?;

    for (line, name) in &prepared.used_materials {
        if !library.index_of.contains_key(name) {
            let text = format!("no material '{name}' in the MTL files; its faces are grey");
            warnings.warn("materials that are in no MTL file", *line, text);
        }
    }
    let mut scene = Scene::new();
    scene.materials.extend(library.materials);
    let (meshes, fanned) = join_models(&models, &prepared);
    for mesh in meshes {
        scene.push_mesh(&mesh).map_err(|error| Error::parse_from(path, None, error.to_string(), error))?;
    }
    if scene.triangles.is_empty() {
        let vertices = counted(prepared.vertices, "vertex", "vertices");
        let reason = format!("no faces and {vertices}; a scene needs `f` lines of 3 corners or more");
        return Err(Error::parse(path, None, reason));
    }
    if let Some(first) = fanned.first() {
        let text =
            "faces that cross themselves, are far from flat or too intricate, which are fanned from their first corner";
        let place = if fanned.len() == 1 { format!("on line {first}") } else { format!("from line {first} on") };
        warnings.warn_once(format!("{text}: {} {place}", fanned.len()));
    }
    if scene.dropped > 0 {
        warnings.warn_once(dropped_text(scene.dropped, &scene.triangles));
    }
    Ok(scene)
}

/// Lets tobj read numbers and gather what faces have.
fn parse(path: &Path, text: &str, prepared: &Prepared, library: &mtl::Library) -> Result<Vec<tobj::Model>, Error> {
    // One index for positions and normals: a model then has as many normals as positions, or too few to use.
    let options = tobj::LoadOptions { single_index: true, triangulate: false, ignore_points: true, ignore_lines: true };
    // The library is read already; its name goes first, so that a `usemtl` may stand before the file's own `mtllib`.
    let mut reader = b"mtllib all\n".chain(prepared.text.as_bytes());
    let loaded = tobj::load_obj_buf(&mut reader, &options, |_| {
        let indices = library.index_of.iter().map(|(name, &index)| (key(name), index)).collect();
        Ok((Vec::new(), indices))
    });
    let fault = |place: Option<Fault>, otherwise: &str| match place {
        Some((line, reason)) => Error::parse(path, Some(line), reason),
        None => Error::parse(path, None, otherwise),
    };
    let (models, _) = loaded.map_err(|error| match error {
        tobj::LoadError::FaceColorOutOfBounds => {
            let place = find_bad_number(text).or_else(|| find_mixed_color(text));
            fault(place, "vertex colours are incomplete")
        }
        error => match find_bad_number(text) {
            Some((line, reason)) => Error::parse(path, Some(line), reason),
            None => Error::parse_from(path, None, error.to_string(), error),
        },
    })?;
    let usable = |model: &tobj::Model| {
        model.mesh.positions.iter().all(|value| value.abs() <= MAX_COORDINATE)
            && model.mesh.normals.iter().all(|value| value.is_finite())
    };
    if models.iter().all(usable) {
        return Ok(models);
    }
    Err(fault(find_bad_number(text), "a coordinate is no usable number"))
}

/// The file as text, and its size. Names and comments in another encoding are no reason to refuse a file, so what is
/// not UTF-8 becomes a replacement character; a byte order mark goes.
fn read_text(path: &Path, limits: &Limits) -> Result<(String, u64), Error> {
    let mut bytes = input::read(path, limits.file_bytes, limits.option_names[0])?;
    let count = bytes.len() as u64;
    // A carriage return alone ends a line, as it did on the Mac before its system X.
    for at in 0..bytes.len() {
        if bytes[at] == b'\r' && bytes.get(at + 1) != Some(&b'\n') {
            bytes[at] = b'\n';
        }
    }
    let mut text = String::from_utf8(bytes).unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into());
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok((text, count))
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
        "v" | "vn" | "f" => without_comment(rest),
        _ => rest,
    };
    (keyword, rest.trim())
}

/// Numbers without the comment behind them. `1.#INF` and `-1.#IND` are what some compilers print for numbers that are none,
/// and no 1 with a comment.
fn without_comment(numbers: &str) -> &str {
    let comment = numbers.match_indices('#').find(|(at, _)| !numbers[..*at].ends_with('.'));
    comment.map_or(numbers, |(at, _)| &numbers[..at])
}

/// The name under which tobj looks a material up. The sign lets a material have an empty name, which tobj refuses.
fn key(material: &str) -> String {
    format!("={material}")
}

/// Checks every index and writes the lines that tobj is to read. Texture coordinates and lines (`l`) are left out.
fn prepare(text: &str, warnings: &mut Warnings) -> Result<Prepared, Fault> {
    let mut prepared = Prepared { names: vec![String::new()], ..Prepared::default() };
    prepared.text.reserve(text.len() + 16);
    let mut smoothing_groups = Vec::new();
    let mut libraries = HashSet::new();
    let mut used_materials = HashSet::new();
    for (number, line) in lines(text) {
        let (keyword, rest) = split_keyword(&line);
        match keyword {
            "v" | "vn" => prepared.vector(keyword, rest, number, warnings),
            "f" => prepared.face(rest, number, warnings).map_err(|reason| (number, reason))?,
            "o" => {
                prepared.section.object += 1;
                prepared.section.object_name = prepared.name(rest);
            }
            "g" => prepared.section.group_name = prepared.name(rest),
            "usemtl" => {
                prepared.keep("usemtl", &key(rest));
                if used_materials.insert(rest.to_owned()) {
                    prepared.used_materials.push((number, rest.into()));
                }
            }
            "mtllib" if rest.is_empty() => {
                warnings.warn("mtllib lines without a name", number, "mtllib names no file; it is left out");
            }
            "mtllib" if libraries.insert(rest.to_owned()) => prepared.libraries.push((number, rest.into())),
            "s" if !matches!(rest, "" | "0" | "off") => smoothing_groups.push(number),
            "mtllib" | "s" => {}
            _ => note_left_out(keyword, number, warnings),
        }
    }
    // Beside normals, which say more, they go without saying.
    if prepared.normals == 0 {
        smoothing_groups.into_iter().for_each(|line| warnings.left_out("smoothing groups (s)", line));
    }
    Ok(prepared)
}

impl Prepared {
    fn keep(&mut self, keyword: &str, rest: &str) {
        for part in [keyword, " ", rest, "\n"] {
            self.text.push_str(part);
        }
    }

    /// A vertex or a normal.
    fn vector(&mut self, keyword: &str, rest: &str, line: usize, warnings: &mut Warnings) {
        if keyword == "vn" {
            self.normals += 1;
        } else {
            // All vertices have colours or none has.
            if self.vertices == 0 && rest.split_whitespace().count() > 4 {
                warnings.left_out("vertex colours", line);
            }
            self.vertices += 1;
        }
        self.keep(keyword, rest);
    }

    fn face(&mut self, rest: &str, line: usize, warnings: &mut Warnings) -> Result<(), String> {
        let has_normals = check_face(rest, self.vertices, self.normals)?;
        if self.section_has_normals != Some(has_normals) {
            self.keep("o", &self.sections.len().to_string());
            self.sections.push(self.section);
            self.section_has_normals = Some(has_normals);
        }
        match rest.split_whitespace().take(4).count() {
            4 => self.polygon_lines.push(line),
            3 => {}
            _ => warnings.left_out("faces of fewer than three corners (f)", line),
        }
        self.keep("f", rest);
        Ok(())
    }

    /// Keeps a name, which begins a section, and returns its index.
    fn name(&mut self, name: &str) -> usize {
        self.section_has_normals = None;
        self.names.push(name.into());
        self.names.len() - 1
    }
}

/// Notes a line that tobj is not to see.
fn note_left_out(keyword: &str, line: usize, warnings: &mut Warnings) {
    match keyword {
        "l" => warnings.left_out("lines (l)", line),
        "p" => warnings.left_out("points (p)", line),
        "vp" | "cstype" | "deg" | "bmat" | "step" | "curv" | "curv2" | "surf" | "parm" | "trim" | "hole" | "scrv"
        | "sp" | "end" | "con" => warnings.left_out("statements of curves and surfaces", line),
        // Of texture coordinates textures tell, in the MTL.
        "" | "vt" => {}
        comment if comment.starts_with('#') => {}
        _ => warnings.left_out("unknown statements", line),
    }
}
