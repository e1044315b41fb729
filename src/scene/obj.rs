//! Reads OBJ and MTL files.
//!
//! tobj parses the numbers. It names no line in its errors, panics on some files,
//! takes `l` lines of three points for faces and doesn't tell `o` from `g`, so [`prepare`] goes over the text first:
//! it checks every index and leaves only lines that tobj reads as they are meant. It can only fan faces, so they are
//! split into triangles here (../polygon.rs).

mod checks;
mod models;
mod mtl;

use std::{borrow::Cow, collections::HashSet, io::Read, path::Path, sync::Arc};

use glam::Vec3;

use self::{
    checks::{Corners, check_face, find_bad_number, mixed_color},
    models::{Joined, join_models},
};
use super::{
    MAX_COORDINATE, MaterialId, Mesh, Scene, SceneOptions,
    smooth::{check_crease, smooth_normals},
    warnings::Warnings,
};
use crate::{Error, Limits, input::Files, message::counted};

/// Diffuse reflectance of a material whose file gives none.
const GREY: Vec3 = Vec3::splat(0.7);

/// What is wrong, and on which line, counted from 1.
type Fault = (usize, String);

/// A run of faces that belong together: it ends at each `o` and `g`, at each `s` where normals are made, and where faces with and
/// without normals or texture coordinates meet.
#[derive(Clone, Copy)]
struct Section {
    /// How many `o` lines came before.
    object: usize,
    /// The object's name as an index into [`Prepared::names`]: a name may be long, and sections as many as faces.
    object_name: usize,
    /// The group's.
    group_name: usize,
    /// The smoothing group.
    smoothing: u32,
}

impl Section {
    /// The smoothing group of all faces before the first `s`.
    const UNGROUPED: u32 = u32::MAX;
}

/// An OBJ file in the form that tobj gets.
struct Prepared {
    /// What `mtllib` lines name, each once, with the first line that does.
    libraries: Vec<(usize, String)>,
    /// All other lines that matter. Each section opens with `o` and its index, so tobj's models bear that name.
    text: String,
    sections: Vec<Section>,
    /// The names of objects and groups, an empty one first.
    names: Vec<Arc<str>>,
    /// The names given to `usemtl`, each once, with the first line that does.
    used_materials: Vec<(usize, String)>,
    /// Vertices, texture coordinates and normals so far.
    counts: Corners<usize>,
    /// The first vertex's line, and whether it has a colour: then all have one.
    first_vertex: Option<(usize, bool)>,
    /// The lines of the faces of more than three corners.
    polygon_lines: Vec<usize>,
    /// What all faces become.
    triangles: u64,
    /// What a face belongs to here, and what the last one of it had.
    section: Section,
    section_has: Option<Corners<bool>>,
    /// Whether smoothing groups matter, since normals are made.
    smooths: bool,
}

/// See [`Scene::from_obj_with`].
pub(super) fn read(files: Files, path: &Path, options: &SceneOptions) -> Result<Scene, Error> {
    let crease = options.crease_angle.map_or(Ok(()), check_crease);
    crease.map_err(|reason| Error::Scene { element: "crease angle".into(), reason })?;
    let (text, _) = read_text(files, path, &options.limits)?;
    let mut warnings = Warnings::new(path);
    // Of a bad number and a bad index, the message names whichever comes first in the file.
    let prepared = prepare(&text, options.crease_angle.is_some(), &mut warnings).map_err(|bad_index| {
        let bad_number = find_bad_number(&text).filter(|bad_number| bad_number.0 <= bad_index.0);
        let (line, reason) = bad_number.unwrap_or(bad_index);
        Error::parse(path, Some(line), reason)
    })?;
    options.limits.check_triangles(path, ("it", "triangles"), prepared.triangles, 1)?;
    let library = mtl::read(files, path, &prepared, options, &mut warnings)?;
    let models = parse(path, &text, &prepared, &library)?;

    for (line, name) in &prepared.used_materials {
        if !library.index_of.contains_key(name) {
            let text = format_args!("no material '{name}' in the MTL files; its faces are grey");
            warnings.warn("materials that are in no MTL file", *line, text);
        }
    }
    let Joined { meshes, fanned, clamped_colors } = join_models(&models, &prepared, &library.placements);
    let mut scene = Scene::new();
    scene.materials.extend(library.materials);
    scene.textures = library.textures;
    for (mut mesh, groups) in meshes {
        if let Some(degrees) = options.crease_angle.filter(|_| mesh.normals.is_empty()) {
            mesh.normals = smooth_normals(&mesh.positions, &mesh.triangles, &groups, degrees);
        }
        scene.push_mesh(&mesh).map_err(|error| Error::parse_from(path, None, error.to_string(), error))?;
    }
    if scene.triangles.is_empty() {
        let vertices = counted(prepared.counts.vertex, "vertex", "vertices");
        let reason = format!("no faces and {vertices}; a scene needs `f` lines of 3 corners or more");
        return Err(Error::parse(path, None, reason));
    }
    warn_of_triangles(&scene, &fanned, clamped_colors, &warnings);
    Ok(scene)
}

/// Warns of faces that were split wrongly, of colours that are none, and of triangles without area.
fn warn_of_triangles(scene: &Scene, fanned: &[usize], clamped_colors: usize, warnings: &Warnings) {
    if let Some(first) = fanned.first() {
        let text =
            "faces that cross themselves, are far from flat or too intricate, which are fanned from their first corner";
        let place = if fanned.len() == 1 { format!("on line {first}") } else { format!("from line {first} on") };
        warnings.warn_once(format!("{text}: {} {place}", fanned.len()));
    }
    if clamped_colors > 0 {
        let vertices = counted(clamped_colors, "vertex", "vertices");
        warnings.warn_once(format!("colours beyond 0 to 1, which are brought into it, at {vertices}"));
    }
    warnings.warn_of_dropped(scene);
}

/// Lets tobj read numbers and gather what faces have.
fn parse(path: &Path, text: &str, prepared: &Prepared, library: &mtl::Library) -> Result<Vec<tobj::Model>, Error> {
    // One index for all that corners have: a model then has as many normals as positions, or too few to use, and so on.
    let options = tobj::LoadOptions { single_index: true, triangulate: false, ignore_points: true, ignore_lines: true };
    // The library is read already; its name goes first, so that a `usemtl` may stand before the file's own `mtllib`.
    let mut reader = b"mtllib all\n".chain(prepared.text.as_bytes());
    let loaded = tobj::load_obj_buf(&mut reader, &options, |_| {
        let indices = library.index_of.iter().map(|(name, &index)| (key(name), index)).collect();
        Ok((Vec::new(), indices))
    });
    let (models, _) = loaded.map_err(|error| match find_bad_number(text) {
        Some((line, reason)) => Error::parse(path, Some(line), reason),
        None => Error::parse_from(path, None, error.to_string(), error),
    })?;
    let usable = |model: &tobj::Model| {
        let tobj::Mesh { positions, normals, texcoords, vertex_color, .. } = &model.mesh;
        positions.iter().all(|value| value.abs() <= MAX_COORDINATE)
            && normals.iter().chain(texcoords).chain(vertex_color).all(|value| value.is_finite())
    };
    if models.iter().all(usable) {
        return Ok(models);
    }
    let (line, reason) = match find_bad_number(text) {
        Some((line, reason)) => (Some(line), reason),
        None => (None, "a coordinate is no usable number".into()),
    };
    Err(Error::parse(path, line, reason))
}

/// The file as text, and its size. Names and comments in another encoding are no reason to refuse a file, so what is
/// not UTF-8 becomes a replacement character; a byte order mark goes.
fn read_text(files: Files, path: &Path, limits: &Limits) -> Result<(String, u64), Error> {
    let mut bytes = files.read(path, limits.file_bytes, limits.option_names[0])?.into_owned();
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
        "v" | "vt" | "vn" | "f" => without_comment(rest),
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

/// Checks every index and writes the lines that tobj is to read. Lines (`l`) are left out.
fn prepare(text: &str, smooths: bool, warnings: &mut Warnings) -> Result<Prepared, Fault> {
    let mut prepared = Prepared::new(smooths);
    prepared.text.reserve(text.len() + 16);
    let mut smoothing_groups = Vec::new();
    let mut libraries = HashSet::new();
    let mut used_materials = HashSet::new();
    for (number, line) in lines(text) {
        let (keyword, rest) = split_keyword(&line);
        match keyword {
            "v" => prepared.vertex(rest, number)?,
            "vt" | "vn" => prepared.vector(keyword, rest),
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
            "s" => {
                let group = if rest == "off" { 0 } else { rest.parse().unwrap_or(1) };
                if smooths {
                    (prepared.section.smoothing, prepared.section_has) = (group, None);
                } else if group != 0 && !rest.is_empty() {
                    smoothing_groups.push(number);
                }
            }
            "mtllib" => {}
            _ => note_left_out(keyword, number, warnings),
        }
    }
    // Beside normals, which say more, they go without saying.
    if prepared.counts.normal == 0 {
        smoothing_groups.into_iter().for_each(|line| warnings.left_out("smoothing groups (s)", line));
    }
    Ok(prepared)
}

impl Prepared {
    fn new(smooths: bool) -> Self {
        Self {
            libraries: Vec::new(),
            text: String::new(),
            sections: Vec::new(),
            names: vec!["".into()],
            used_materials: Vec::new(),
            counts: Corners::default(),
            first_vertex: None,
            polygon_lines: Vec::new(),
            triangles: 0,
            section: Section { object: 0, object_name: 0, group_name: 0, smoothing: Section::UNGROUPED },
            section_has: None,
            smooths,
        }
    }

    fn keep(&mut self, keyword: &str, rest: &str) {
        for part in [keyword, " ", rest, "\n"] {
            self.text.push_str(part);
        }
    }

    /// tobj counts colours on their own: of vertices with and without, it gives some another's.
    fn vertex(&mut self, rest: &str, line: usize) -> Result<(), Fault> {
        let has_color = rest.split_whitespace().count() == 6;
        let first = *self.first_vertex.get_or_insert((line, has_color));
        if first.1 != has_color {
            return Err((line, mixed_color(has_color, first.0)));
        }
        self.counts.vertex += 1;
        self.keep("v", rest);
        Ok(())
    }

    /// Texture coordinates or a normal.
    fn vector(&mut self, keyword: &str, rest: &str) {
        match keyword {
            "vn" => self.counts.normal += 1,
            _ => self.counts.texture += 1,
        }
        // Of texture coordinates tobj wants two, but one alone has 0 beside it.
        let lacks_one = keyword == "vt" && rest.split_whitespace().count() == 1;
        self.keep(keyword, rest);
        if lacks_one {
            self.text.insert_str(self.text.len() - 1, " 0");
        }
    }

    fn face(&mut self, rest: &str, line: usize, warnings: &mut Warnings) -> Result<(), String> {
        let has = check_face(rest, self.counts)?;
        if self.section_has != Some(has) {
            self.keep("o", &self.sections.len().to_string());
            self.sections.push(self.section);
            self.section_has = Some(has);
        }
        let corners = rest.split_whitespace().count();
        match corners {
            3 => {}
            4.. => self.polygon_lines.push(line),
            _ => warnings.left_out("faces of fewer than three corners (f)", line),
        }
        self.triangles += corners.saturating_sub(2) as u64;
        self.keep("f", rest);
        Ok(())
    }

    /// Keeps a name, which begins a section, and returns its index.
    fn name(&mut self, name: &str) -> usize {
        self.section_has = None;
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
        "" => {}
        comment if comment.starts_with('#') => {}
        _ => warnings.left_out("unknown statements", line),
    }
}
