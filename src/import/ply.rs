//! Reads PLY files: text, and binary of either byte order.
//!
//! header.rs reads the header. values.rs reads the body's numbers one by one. So a header with false counts reserves no
//! memory.

mod header;
mod values;

use std::path::Path;

use glam::{DVec3, Vec2, Vec3};

use self::{
    header::{Element, Encoding, Header, Kind},
    values::{Binary, Text, Values},
};
use super::{
    SceneOptions,
    origin::bounds_of,
    polygon::{Split, split},
    warnings::{Place, Warnings},
};
use crate::scene::{
    MaterialId, Mesh, Scene, linear,
    smooth::{check_crease, smooth_normals, unit},
};
use crate::{Error, import::input::Files, message::counted};

/// Line of a text file, if known, and description of an error.
type Fault = (Option<usize>, String);

/// Names of vertex properties, in the order of the values that `read_vertices` reads.
const PLACES: [&[&str]; 11] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
    &["u", "s", "texture_u", "texture_s"],
    &["v", "t", "texture_v", "texture_t"],
];
const POSITION: usize = 0;
const NORMAL: usize = 3;
const COLOR: usize = 6;
const UV: usize = 9;

/// Content of a file, before it becomes a mesh.
#[derive(Default)]
struct Content {
    /// World positions.
    positions: Vec<DVec3>,
    /// One normal per vertex, or empty. The same holds for `colors` and `uv`.
    normals: Vec<Vec3>,
    colors: Vec<Vec3>,
    uv: Vec<Vec2>,
    clamped_colors: usize,
    /// Corners of all faces, one face after the other.
    corners: Vec<u32>,
    /// Number of corners of each face.
    counts: Vec<u32>,
    /// Number of triangles of all faces. Reading stops when it exceeds `most_triangles`.
    triangles: u64,
    most_triangles: u64,
}

/// Reads a scene, see [`Scene::from_ply_with`].
pub(crate) fn read(files: Files, path: &Path, options: &SceneOptions) -> Result<Scene, Error> {
    let crease = options.crease_angle.map_or(Ok(()), check_crease);
    crease.map_err(|reason| Error::Scene { element: "crease angle".into(), reason })?;
    let bytes = files.read_bytes(path, options.limits.file_bytes, options.limits.option_names[0])?;
    let mut warnings = Warnings::new(path);
    let fault = |(line, reason): Fault| Error::parse(path, line, reason);
    let (header, body) = header::read(&bytes).map_err(fault)?;
    note_left_out(&header, &mut warnings);
    let mut content = Content { most_triangles: options.limits.triangles, ..Content::default() };
    let read = match header.encoding {
        Encoding::Text => content.read_elements(&header, &mut Text::new(body, header.lines), &mut warnings),
        Encoding::Little => content.read_elements(&header, &mut Binary::new(body, false), &mut warnings),
        Encoding::Big => content.read_elements(&header, &mut Binary::new(body, true), &mut warnings),
    };
    read.map_err(fault)?;
    options.limits.check_triangles(path, ("it", "triangles"), content.triangles, 1)?;
    drop(bytes);
    let origin = options.origin.choose(|| bounds_of(content.positions.iter().copied()));
    let mut mesh = content.into_mesh(origin, &mut warnings).map_err(fault)?;
    if let Some(degrees) = options.crease_angle.filter(|_| mesh.normals.is_empty()) {
        mesh.normals = smooth_normals(&mesh.positions, &mesh.triangles, &[], degrees);
    }
    let mut scene = Scene::new();
    scene.set_origin(origin).map_err(|error| Error::parse_from(path, None, error.to_string(), error))?;
    scene.push_mesh(&mesh).map_err(|error| Error::parse_from(path, None, error.to_string(), error))?;
    warnings.warn_of_dropped(&scene);
    Ok(scene)
}

/// Counts elements and properties that are not supported.
fn note_left_out(header: &Header, warnings: &mut Warnings) {
    for element in &header.elements {
        match &*element.name {
            "vertex" => {
                for property in element.properties.iter().filter(|property| vertex_place(property).is_none()) {
                    let what = match &*property.name {
                        "alpha" | "a" | "diffuse_alpha" => "opacities of vertices (alpha)",
                        _ => "unknown properties of vertices",
                    };
                    warnings.left_out(what, property.line);
                }
            }
            "face" => {
                for property in element.properties.iter().filter(|property| !is_corners(property)) {
                    let what = match &*property.name {
                        "red" | "green" | "blue" | "alpha" => "colours of faces",
                        "texcoord" => "texture coordinates of faces (texcoord)",
                        _ => "unknown properties of faces",
                    };
                    warnings.left_out(what, property.line);
                }
            }
            "tristrips" => warnings.left_out("strips of triangles (tristrips)", element.line),
            "edge" => warnings.left_out("edges", element.line),
            _ => warnings.left_out("unknown elements", element.line),
        }
    }
    if let Some(line) = header.texture_file {
        warnings.left_out("texture files (comment TextureFile)", line);
    }
}

/// Returns the index of a vertex property in [`PLACES`].
fn vertex_place(property: &header::Property) -> Option<usize> {
    let is_scalar = matches!(property.kind, Kind::Scalar(_));
    PLACES.iter().position(|names| is_scalar && names.contains(&&*property.name))
}

fn is_corners(property: &header::Property) -> bool {
    matches!(property.kind, Kind::List { .. }) && matches!(&*property.name, "vertex_indices" | "vertex_index")
}

/// Skips an unwanted element. An element without properties has no bytes, for any count.
fn skip(element: &Element, values: &mut impl Values) -> Result<(), (u64, String)> {
    let all = if element.properties.is_empty() { 0 } else { element.count };
    for index in 0..all {
        skip_one(element, values).map_err(|reason| (index, reason))?;
    }
    Ok(())
}

fn skip_one(element: &Element, values: &mut impl Values) -> Result<(), String> {
    values.begin()?;
    for property in &element.properties {
        skip_property(property.kind, values)?;
    }
    values.end()
}

fn skip_property(kind: Kind, values: &mut impl Values) -> Result<(), String> {
    match kind {
        Kind::Scalar(scalar) => values.skip(scalar, 1),
        Kind::List { count, item } => {
            let count = values.count(count)?;
            values.skip(item, count)
        }
    }
}

impl Content {
    fn read_elements(
        &mut self,
        header: &Header,
        values: &mut impl Values,
        warnings: &mut Warnings,
    ) -> Result<(), Fault> {
        let vertices =
            header.elements.iter().find(|element| element.name == "vertex").map_or(0, |element| element.count);
        for element in &header.elements {
            let read = match &*element.name {
                "vertex" => self.read_vertices(element, values),
                "face" => self.read_faces(element, vertices, values, warnings),
                _ => skip(element, values),
            };
            read.map_err(|(index, reason)| (values.line(), format!("{} {index}: {reason}", element.name)))?;
            if self.triangles > self.most_triangles {
                break;
            }
        }
        Ok(())
    }

    fn read_vertices(&mut self, element: &Element, values: &mut impl Values) -> Result<(), (u64, String)> {
        let places: Vec<Option<usize>> = element.properties.iter().map(vertex_place).collect();
        let has = |first: usize, count: usize| (first..first + count).all(|place| places.contains(&Some(place)));
        if let Some(missing) = (POSITION..POSITION + 3).find(|place| !places.contains(&Some(*place))) {
            return Err((0, format!("there is no property {}", PLACES[missing][0])));
        }
        let [has_normals, has_colors, has_uv] = [has(NORMAL, 3), has(COLOR, 3), has(UV, 2)];
        for index in 0..element.count {
            let mut vertex = [0.0f64; PLACES.len()];
            let mut read = || {
                values.begin()?;
                for (property, place) in element.properties.iter().zip(&places) {
                    match (property.kind, *place) {
                        (Kind::Scalar(scalar), Some(place)) => {
                            let value = values.number(scalar)?;
                            // Integer colours are shares of the largest integer.
                            let is_share = !scalar.is_float() && (COLOR..UV).contains(&place);
                            vertex[place] = if is_share { value / scalar.largest() } else { value };
                        }
                        (kind, _) => skip_property(kind, values)?,
                    }
                }
                values.end()
            };
            read().map_err(|reason| (index, reason))?;
            if let Some(place) = vertex.iter().position(|value| !(*value as f32).is_finite()) {
                return Err((
                    index,
                    format!("its {} is {}; it must be a finite number", PLACES[place][0], vertex[place]),
                ));
            }
            let position = DVec3::new(vertex[POSITION], vertex[POSITION + 1], vertex[POSITION + 2]);
            self.positions.push(position);
            let vertex = vertex.map(|value| value as f32);
            let three = |first: usize| Vec3::new(vertex[first], vertex[first + 1], vertex[first + 2]);
            if has_normals {
                self.normals.push(unit(three(NORMAL)));
            }
            if has_colors {
                let color = three(COLOR);
                self.clamped_colors += usize::from(color.min_element() < 0.0 || color.max_element() > 1.0);
                // Scanners and modellers write sRGB colours.
                self.colors.push(color.clamp(Vec3::ZERO, Vec3::ONE).map(linear));
            }
            if has_uv {
                self.uv.push(Vec2::new(vertex[UV], vertex[UV + 1]));
            }
        }
        Ok(())
    }

    fn read_faces(
        &mut self,
        element: &Element,
        vertices: u64,
        values: &mut impl Values,
        warnings: &mut Warnings,
    ) -> Result<(), (u64, String)> {
        let Some(wanted) = element.properties.iter().position(is_corners) else { return skip(element, values) };
        for index in 0..element.count {
            let first = self.corners.len();
            let mut read = || {
                values.begin()?;
                for (place, property) in element.properties.iter().enumerate() {
                    match property.kind {
                        Kind::List { count, item } if place == wanted => {
                            for _ in 0..values.count(count)? {
                                self.corners.push(corner(values.number(item)?, vertices)?);
                            }
                        }
                        kind => skip_property(kind, values)?,
                    }
                }
                values.end()
            };
            read().map_err(|reason| (index, reason))?;
            let count = self.corners.len() - first;
            if count < 3 {
                warnings.left_out("faces of fewer than three corners", values.line().map_or(Place::File, Place::Line));
                self.corners.truncate(first);
                continue;
            }
            self.counts.push(u32::try_from(count).map_err(|_| (index, format!("it has {count} corners")))?);
            self.triangles += count as u64 - 2;
            if self.triangles > self.most_triangles {
                break;
            }
        }
        Ok(())
    }

    /// Splits the faces into triangles, with positions relative to the origin.
    fn into_mesh(self, origin: DVec3, warnings: &mut Warnings) -> Result<Mesh, Fault> {
        if self.counts.is_empty() {
            let points = counted(self.positions.len(), "vertex", "vertices");
            let what = format!("it is a point cloud, with {points} and no faces");
            return Err((None, format!("{what}; a scene needs faces of 3 corners or more")));
        }
        let positions: Vec<Vec3> = self.positions.iter().map(|position| (position - origin).as_vec3()).collect();
        let mut mesh = Mesh::new(Vec::new(), Vec::with_capacity(self.corners.len() - 2 * self.counts.len()));
        let (mut rest, mut fanned, mut first_fanned, mut points) = (&self.corners[..], 0usize, 0, Vec::new());
        for (index, &count) in self.counts.iter().enumerate() {
            let (face, others) = rest.split_at(count as usize);
            rest = others;
            if let &[a, b, c] = face {
                mesh.triangles.push([a, b, c]);
                continue;
            }
            points.clear();
            points.extend(face.iter().map(|&corner| positions[corner as usize]));
            match split(&points) {
                Split::Ears(ears) => mesh.triangles.extend(ears.into_iter().map(|ear| ear.map(|corner| face[corner]))),
                fan => {
                    if matches!(fan, Split::Unknown) {
                        first_fanned = if fanned == 0 { index } else { first_fanned };
                        fanned += 1;
                    }
                    mesh.triangles.extend(face[1..].windows(2).map(|pair| [face[0], pair[0], pair[1]]));
                }
            }
        }
        if fanned > 0 {
            let text = "faces that intersect themselves, are far from flat or too complex, triangulated as fans from \
                        their first";
            warnings.warn_once(format!("{text} corner: {fanned} from face {first_fanned} on"));
        }
        if self.clamped_colors > 0 {
            let vertices = counted(self.clamped_colors, "vertex", "vertices");
            warnings.warn_once(format!("colours outside 0 to 1, which are clamped, at {vertices}"));
        }
        mesh.materials = vec![MaterialId::default()];
        mesh.normals = spread(&self.normals, &mesh.triangles);
        // A zero normal has no direction, so the triangle is flat.
        mesh.normals
            .iter_mut()
            .filter(|normals| normals.contains(&Vec3::ZERO))
            .for_each(|flat| *flat = [Vec3::ZERO; 3]);
        mesh.colors = spread(&self.colors, &mesh.triangles);
        mesh.uv = spread(&self.uv, &mesh.triangles);
        mesh.positions = positions;
        Ok(mesh)
    }
}

/// Spreads a list with an entry per vertex to the corners of triangles.
fn spread<T: Copy>(of_vertices: &[T], triangles: &[[u32; 3]]) -> Vec<[T; 3]> {
    if of_vertices.is_empty() {
        return Vec::new();
    }
    triangles.iter().map(|corners| corners.map(|corner| of_vertices[corner as usize])).collect()
}

/// Checks a vertex index of any number type.
fn corner(value: f64, vertices: u64) -> Result<u32, String> {
    let is_there = value >= 0.0 && value <= f64::from(u32::MAX) && (value as u64) < vertices;
    match is_there && value.fract() == 0.0 {
        true => Ok(value as u32),
        false => Err(format!(
            "corner {value} is out of range for {}, numbered from 0",
            counted(vertices, "vertex", "vertices")
        )),
    }
}
