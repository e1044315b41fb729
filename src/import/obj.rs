//! Reads OBJ and MTL files.
//!
//! tobj parses the numbers. Its errors name no line, and it panics on some files. It reads `l` lines of three points as
//! faces and doesn't distinguish `o` from `g`. So [`prepare`] processes the text first. It checks every index and keeps
//! only lines that tobj reads correctly. tobj can only split faces into fans, so they are split here (../polygon.rs).

mod checks;
mod models;
mod mtl;

use std::{borrow::Cow, collections::HashSet, io::Read, path::Path, sync::Arc};

use glam::{DVec3, Vec3};

use self::{
    checks::{Corners, check_face, find_bad_number},
    models::{Joined, join_models},
};
use super::{SceneOptions, origin::bounds_of, warnings::Warnings};
use crate::scene::{
    MAX_COORDINATE, MaterialId, Mesh, Scene,
    smooth::{check_crease, smooth_normals},
};
use crate::{Error, Limits, import::input::Files, message::counted};

/// Diffuse reflectance of a material whose file gives none.
const GREY: Vec3 = Vec3::splat(0.7);

/// Colour of a vertex without one, appended to its coordinates.
const WHITE: &str = " 1 1 1";

/// Line, counted from 1, and description of an error.
type Fault = (usize, String);

/// A run of faces with common properties. It ends at each `o` and `g`, and at each `s` if normals are made. It also
/// ends between faces with and without normals or texture coordinates.
#[derive(Clone, Copy)]
struct Section {
    /// Number of `o` lines before it.
    object: usize,
    /// Name of the object, as an index into [`Prepared::names`]. A name may be long, and there may be as many sections
    /// as faces.
    object_name: usize,
    /// Name of the group, as an index.
    group_name: usize,
    /// Smoothing group.
    smoothing: u32,
}

impl Section {
    /// Smoothing group of the faces before the first `s`.
    const UNGROUPED: u32 = u32::MAX;
}

/// An OBJ file in a form for tobj.
struct Prepared {
    /// Distinct names in `mtllib` lines, each with its first line.
    libraries: Vec<(usize, String)>,
    /// All other relevant lines. Each section begins with `o` and its index, so that tobj's models have this name.
    text: String,
    sections: Vec<Section>,
    /// Names of objects and groups, after an empty one.
    names: Vec<Arc<str>>,
    /// Distinct names in `usemtl` lines, each with its first line.
    used_materials: Vec<(usize, String)>,
    /// Number of vertices, texture coordinates and normals so far.
    counts: Corners<usize>,
    /// Whether some vertex so far has a colour. `colorless` is the number of vertices without a colour, and
    /// `first_weight` the line of the first vertex with a weight.
    has_colors: bool,
    colorless: usize,
    first_weight: Option<usize>,
    /// Lines of the faces with more than three corners.
    polygon_lines: Vec<usize>,
    /// Number of triangles of all faces.
    triangles: u64,
    /// Section of the next face, and the attributes of its last face.
    section: Section,
    section_has: Option<Corners<bool>>,
    /// Whether normals are made, so that smoothing groups matter.
    smooths: bool,
    /// Origin that vertices become relative to.
    origin: DVec3,
}

/// Reads a scene, see [`Scene::from_obj_with`].
pub(crate) fn read(files: Files, path: &Path, options: &SceneOptions) -> Result<Scene, Error> {
    let crease = options.crease_angle.map_or(Ok(()), check_crease);
    crease.map_err(|reason| Error::Scene { element: "crease angle".into(), reason })?;
    let (text, _) = read_text(files, path, &options.limits)?;
    let mut warnings = Warnings::new(path);
    // If both a number and an index are bad, the message names the one on the earlier line.
    let origin = options.origin.choose(|| bounds_of(vertices(&text)));
    let prepared = prepare(&text, options.crease_angle.is_some(), origin, &mut warnings).map_err(|bad_index| {
        let bad_number = find_bad_number(&text, origin).filter(|bad_number| bad_number.0 <= bad_index.0);
        let (line, reason) = bad_number.unwrap_or(bad_index);
        Error::parse(path, Some(line), reason)
    })?;
    options.limits.check_triangles(path, ("it", "triangles"), prepared.triangles, 1)?;
    let library = mtl::read(files, path, &prepared, options, &mut warnings)?;
    let models = parse(path, &text, &prepared, &library)?;

    for (line, name) in &prepared.used_materials {
        if !library.index_of.contains_key(name) {
            let text = format_args!("no material '{name}' in the MTL files; its faces are grey");
            warnings.warn("materials missing from the MTL files", *line, text);
        }
    }
    let Joined { meshes, fanned, clamped_colors } = join_models(&models, &prepared, &library.placements);
    let mut scene = Scene::new();
    scene.set_origin(origin).map_err(|error| Error::parse_from(path, None, error.to_string(), error))?;
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

/// Logs warnings about faces without a correct split, clamped colours, and triangles without area.
fn warn_of_triangles(scene: &Scene, fanned: &[usize], clamped_colors: usize, warnings: &Warnings) {
    if let Some(first) = fanned.first() {
        let text = "faces that intersect themselves, are far from flat or too complex, triangulated as fans from their \
                    first corner";
        let place = if fanned.len() == 1 { format!("on line {first}") } else { format!("from line {first} on") };
        warnings.warn_once(format!("{text}: {} {place}", fanned.len()));
    }
    if clamped_colors > 0 {
        let vertices = counted(clamped_colors, "vertex", "vertices");
        warnings.warn_once(format!("colours outside 0 to 1, which are clamped, at {vertices}"));
    }
    warnings.warn_of_dropped(scene);
}

/// Parses the prepared text with tobj and checks its numbers.
fn parse(path: &Path, text: &str, prepared: &Prepared, library: &mtl::Library) -> Result<Vec<tobj::Model>, Error> {
    // A single index for all attributes of a corner. A model then has either as many normals as positions, or too few
    // to use. The same holds for the other attributes.
    let options = tobj::LoadOptions { single_index: true, triangulate: false, ignore_points: true, ignore_lines: true };
    // The library is already read. Its line comes first, since a `usemtl` may precede the file's own `mtllib`.
    let mut reader = b"mtllib all\n".chain(prepared.text.as_bytes());
    let loaded = tobj::load_obj_buf(&mut reader, &options, |_| {
        let indices = library.index_of.iter().map(|(name, &index)| (key(name), index)).collect();
        Ok((Vec::new(), indices))
    });
    let (models, _) = loaded.map_err(|error| match find_bad_number(text, prepared.origin) {
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
    let (line, reason) = match find_bad_number(text, prepared.origin) {
        Some((line, reason)) => (Some(line), reason),
        None => (None, "a coordinate is not a usable number".into()),
    };
    Err(Error::parse(path, line, reason))
}

/// Returns the file as text without a byte order mark, and its size. Names and comments may be in another encoding, so
/// bytes that are not UTF-8 become replacement characters.
fn read_text(files: Files, path: &Path, limits: &Limits) -> Result<(String, u64), Error> {
    let mut bytes = files.read(path, limits.file_bytes, limits.option_names[0])?.into_owned();
    let count = bytes.len() as u64;
    // A lone carriage return ends a line, as on the classic Mac OS.
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

/// Returns the positions of `v` lines in world coordinates, skipping invalid ones.
fn vertices(text: &str) -> impl Iterator<Item = DVec3> {
    lines(text).filter_map(|(_, line)| {
        let (keyword, rest) = split_keyword(&line);
        (keyword == "v").then(|| position(rest)).flatten()
    })
}

/// Returns the position of a `v` line: `x y z`, `x y z w` with a weight, or `x y z r g b` with a colour.
fn position(rest: &str) -> Option<DVec3> {
    let mut words = rest.split_whitespace();
    let mut number = || words.next()?.parse::<f64>().ok();
    let position = DVec3::new(number()?, number()?, number()?);
    match (number(), words.next()) {
        (Some(weight), None) => Some(position / weight),
        _ => Some(position),
    }
}

/// Returns lines with their numbers from 1. A line that ends in a backslash continues in the next.
fn lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().zip(1..);
    std::iter::from_fn(move || {
        let (line, number) = lines.next()?;
        // Comments do not continue, since they may end in the name of a folder.
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

/// Returns a line's first word and the rest. Comments may follow numbers, but `#` may be part of a name.
fn split_keyword(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = match keyword {
        "v" | "vt" | "vn" | "f" => without_comment(rest),
        _ => rest,
    };
    (keyword, rest.trim())
}

/// Removes the comment behind numbers. `1.#INF` and `-1.#IND`, as some compilers print non-finite numbers, have no
/// comment.
fn without_comment(numbers: &str) -> &str {
    let comment = numbers.match_indices('#').find(|(at, _)| !numbers[..*at].ends_with('.'));
    comment.map_or(numbers, |(at, _)| &numbers[..at])
}

/// Returns the name by which tobj finds a material. The `=` makes every name non-empty, since tobj refuses empty names.
fn key(material: &str) -> String {
    format!("={material}")
}

/// Checks every index and writes the lines for tobj. Lines (`l`) are left out.
fn prepare(text: &str, smooths: bool, origin: DVec3, warnings: &mut Warnings) -> Result<Prepared, Fault> {
    let mut prepared = Prepared::new(smooths, origin);
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
                warnings.warn("mtllib lines without a name", number, "mtllib names no file; it is ignored");
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
    if prepared.has_colors && prepared.colorless > 0 {
        let vertices = counted(prepared.colorless, "vertex", "vertices");
        warnings.warn_once(format!("{vertices} of {} without a colour, drawn white", prepared.counts.vertex));
    }
    // Normals supersede smoothing groups, so these are only logged without normals.
    if prepared.counts.normal == 0 {
        smoothing_groups.into_iter().for_each(|line| warnings.left_out("smoothing groups (s)", line));
    }
    Ok(prepared)
}

impl Prepared {
    fn new(smooths: bool, origin: DVec3) -> Self {
        Self {
            libraries: Vec::new(),
            text: String::new(),
            sections: Vec::new(),
            names: vec!["".into()],
            used_materials: Vec::new(),
            counts: Corners::default(),
            has_colors: false,
            colorless: 0,
            first_weight: None,
            polygon_lines: Vec::new(),
            triangles: 0,
            section: Section { object: 0, object_name: 0, group_name: 0, smoothing: Section::UNGROUPED },
            section_has: None,
            smooths,
            origin,
        }
    }

    fn keep(&mut self, keyword: &str, rest: &str) {
        for part in [keyword, " ", rest, "\n"] {
            self.text.push_str(part);
        }
    }

    /// Adds a vertex. tobj counts colours separately and would mix up vertices with and without colours. So if one
    /// vertex has a colour, all others become white.
    fn vertex(&mut self, rest: &str, line: usize) -> Result<(), Fault> {
        let numbers = rest.split_whitespace().count();
        if numbers == 6 && !self.has_colors {
            self.has_colors = true;
            self.whiten();
        }
        self.counts.vertex += 1;
        self.colorless += usize::from(numbers != 6);
        self.first_weight = self.first_weight.or((numbers == 4).then_some(line));
        if let Some(line) = self.first_weight.filter(|_| self.has_colors) {
            return Err((line, "this vertex has a weight w, but others have colours; write all as x y z r g b".into()));
        }
        match position(rest).filter(|_| self.origin != DVec3::ZERO) {
            None => self.keep("v", rest),
            // tobj reads f32, so the origin is subtracted before.
            Some(position) => {
                let [x, y, z] = (position - self.origin).as_vec3().to_array();
                let color = if numbers == 6 { rest.split_whitespace().skip(3).collect() } else { Vec::new() };
                self.keep("v", &format!("{x} {y} {z} {}", color.join(" ")));
            }
        }
        if self.has_colors && numbers == 3 {
            self.text.insert_str(self.text.len() - 1, WHITE);
        }
        Ok(())
    }

    /// Gives all vertices so far the colour white.
    fn whiten(&mut self) {
        if self.colorless == 0 {
            return;
        }
        let mut text = String::with_capacity(self.text.len() + WHITE.len() * self.colorless);
        for line in self.text.split_inclusive('\n') {
            text.push_str(line.trim_end_matches('\n'));
            text.push_str(if line.starts_with("v ") { WHITE } else { "" });
            text.push('\n');
        }
        self.text = text;
    }

    /// Adds texture coordinates or a normal.
    fn vector(&mut self, keyword: &str, rest: &str) {
        match keyword {
            "vn" => self.counts.normal += 1,
            _ => self.counts.texture += 1,
        }
        // tobj requires two texture coordinates; a missing second one is 0.
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

    /// Stores a name, ends the section and returns the name's index.
    fn name(&mut self, name: &str) -> usize {
        self.section_has = None;
        self.names.push(name.into());
        self.names.len() - 1
    }
}

/// Counts a line that is not passed to tobj.
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
