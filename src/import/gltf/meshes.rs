//! Reads meshes and places them at nodes.

use std::collections::HashMap;

use glam::{BVec3, DAffine3, DMat3, DVec3, Vec2, Vec3, Vec4};
use gltf_json::{
    Mesh as Description,
    accessor::Type,
    mesh::{Mode, Primitive, Semantic},
    validation::Checked,
};

use super::{
    Placed,
    document::Document,
    materials::{Surfaces, UvRule},
};
use crate::{
    Error,
    import::{
        SceneOptions,
        origin::bounds_of,
        warnings::{Place, Warnings},
    },
    message::counted,
    scene::{
        Mesh,
        smooth::{smooth_normals, unit},
        tangents::tangents,
    },
};

/// Meshes in their own coordinates, each read once.
pub(super) struct Meshes<'a> {
    document: &'a Document<'a>,
    crease_angle: Option<f32>,
    read: HashMap<usize, Mesh>,
    triangles: u64,
    vertices: u64,
}

impl<'a> Meshes<'a> {
    pub(super) fn new(document: &'a Document<'a>, options: &SceneOptions) -> Self {
        Self { document, crease_angle: options.crease_angle, read: HashMap::new(), triangles: 0, vertices: 0 }
    }

    /// Reads a node's mesh unless it is known, and counts its triangles and vertices.
    pub(super) fn read(
        &mut self,
        mesh: usize,
        node: usize,
        (surfaces, warnings): (&mut Surfaces, &mut Warnings),
    ) -> Result<(), Error> {
        let document = self.document;
        let description = document.item(("meshes", &document.root.meshes), mesh, format_args!("nodes[{node}]"))?;
        if !self.read.contains_key(&mesh) {
            let (read, lacks_tangents) = read(document, mesh, description, surfaces, warnings)?;
            let mut read = self.smoothed(read.name(description.name.as_deref().unwrap_or_default()));
            if lacks_tangents && !read.uv.is_empty() {
                read.tangents = tangents(&read);
            }
            self.read.insert(mesh, read);
        }
        let read = &self.read[&mesh];
        self.triangles += read.triangles.len() as u64;
        self.vertices += read.positions.len() as u64;
        document.check_size("its scene", "triangles", self.triangles, 1)?;
        document.check_size("its scene", "vertices", self.vertices, 3)
    }

    /// Returns a box around the placed meshes, in world coordinates, from each mesh's transformed box.
    pub(super) fn bounds(&self, shown: &[Placed<(usize, usize)>]) -> Option<(DVec3, DVec3)> {
        let own: HashMap<usize, Option<(DVec3, DVec3)>> = self
            .read
            .iter()
            .map(|(&index, mesh)| (index, bounds_of(mesh.positions.iter().map(|position| position.as_dvec3()))))
            .collect();
        bounds_of(shown.iter().flat_map(|((_, mesh), place)| {
            let corners = own[mesh].into_iter().flat_map(|(low, high)| {
                (0..8).map(move |corner| {
                    let is_high = [0, 1, 2].map(|axis| corner >> axis & 1 == 1);
                    DVec3::select(BVec3::from_array(is_high), high, low)
                })
            });
            corners.map(|corner| place.transform_point3(corner))
        }))
    }

    /// Returns a copy of a mesh for a node, transformed by `place` to coordinates relative to the scene's origin.
    pub(super) fn instance(&self, mesh: usize, node: usize, place: DAffine3) -> Mesh {
        let mesh = placed(&self.read[&mesh], place);
        // All nodes of a mesh share its name, since it may be long and the nodes many.
        match self.document.root.nodes[node].name.as_deref().filter(|name| !name.is_empty()) {
            Some(name) => mesh.name(name),
            None => mesh,
        }
    }

    fn smoothed(&self, mut mesh: Mesh) -> Mesh {
        if let Some(degrees) = self.crease_angle.filter(|_| mesh.normals.is_empty()) {
            mesh.normals = smooth_normals(&mesh.positions, &mesh.triangles, &[], degrees);
        }
        mesh
    }
}

/// Transforms a mesh. A mirroring transform also reverses the winding, so that outer sides stay outer sides.
fn placed(mesh: &Mesh, place: DAffine3) -> Mesh {
    let mut mesh = mesh.clone();
    for position in &mut mesh.positions {
        *position = place.transform_point3(position.as_dvec3()).as_vec3();
    }
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = place.matrix3;
    let sign = place.matrix3.determinant().signum();
    // The cofactors are the inverse transposed up to a factor. They keep normals perpendicular, and exist for singular
    // matrices.
    let upright = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
    if place.matrix3 != DMat3::IDENTITY {
        for normals in &mut mesh.normals {
            *normals = normals.map(|normal| (upright * normal.as_dvec3()).normalize_or_zero().as_vec3());
            if normals.contains(&Vec3::ZERO) {
                *normals = [Vec3::ZERO; 3];
            }
        }
    }
    for tangent in mesh.tangents.as_flattened_mut() {
        let way = place.matrix3 * tangent.truncate().as_dvec3();
        *tangent = way.normalize_or_zero().as_vec3().extend(tangent.w * sign as f32);
    }
    if sign < 0.0 {
        mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        mesh.normals.iter_mut().for_each(|corners| corners.swap(1, 2));
        mesh.uv.iter_mut().for_each(|corners| corners.swap(1, 2));
        mesh.colors.iter_mut().for_each(|corners| corners.swap(1, 2));
        mesh.tangents.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    mesh
}

/// Reads all triangle primitives of a mesh as one mesh. Also returns whether it needs tangents that the file lacks.
fn read(
    document: &Document,
    index: usize,
    description: &Description,
    surfaces: &mut Surfaces,
    warnings: &mut Warnings,
) -> Result<(Mesh, bool), Error> {
    let mut mesh = Mesh::default();
    let (mut clamped_colors, mut lacks_tangents) = (0, false);
    for (number, primitive) in description.primitives.iter().enumerate() {
        let name = format!("meshes[{index}].primitives[{number}]");
        let place = Place::Item("meshes", index);
        if primitive.targets.is_some() {
            warnings.left_out("morph targets", place);
        }
        let Checked::Valid(mode) = primitive.mode else {
            return Err(document.fault(format!("{name}: its mode is unknown")));
        };
        if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
            warnings.left_out("points and lines", place);
            continue;
        }
        if !primitive.attributes.contains_key(&Checked::Valid(Semantic::Positions)) {
            warnings.left_out("primitives without positions", place);
            continue;
        }
        let noted = (&mut clamped_colors, &mut lacks_tangents);
        add(document, &mut mesh, primitive, mode, &name, (surfaces, warnings), noted)?;
        document.check_size(&format!("meshes[{index}]"), "triangles", mesh.triangles.len() as u64, 1)?;
        document.check_size(&format!("meshes[{index}]"), "vertices", mesh.positions.len() as u64, 3)?;
    }
    if lacks_tangents {
        // Those of the whole mesh are computed.
        mesh.tangents.clear();
    }
    let count = mesh.triangles.len();
    fill(&mut mesh.normals, count, [Vec3::ZERO; 3]);
    fill(&mut mesh.uv, count, [Vec2::ZERO; 3]);
    fill(&mut mesh.colors, count, [Vec3::ONE; 3]);
    fill(&mut mesh.tangents, count, [Vec4::ZERO; 3]);
    if clamped_colors > 0 {
        let vertices = counted(clamped_colors, "vertex", "vertices");
        let text = format!("meshes[{index}]: colours outside 0 to 1, which are clamped, at {vertices}");
        warnings.warn("meshes with colours outside 0 to 1", None, text);
    }
    Ok((mesh, lacks_tangents))
}

/// Extends a list to one entry per triangle, unless it is empty.
fn fill<T: Clone>(list: &mut Vec<T>, count: usize, none: T) {
    if !list.is_empty() {
        list.resize(count, none);
    }
}

/// Adds a primitive to a mesh.
fn add(
    document: &Document,
    mesh: &mut Mesh,
    primitive: &Primitive,
    mode: Mode,
    name: &str,
    (surfaces, warnings): (&mut Surfaces, &mut Warnings),
    (clamped_colors, lacks_tangents): (&mut usize, &mut bool),
) -> Result<(), Error> {
    let attribute = |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let Some(positions) = attribute(Semantic::Positions) else { return Ok(()) };
    let by = |what: &str| format!("{name}, {what}");
    let count = document.element_count(positions, &by("POSITION"))?;
    let triangles = corners(document, primitive, mode, count, name)?;
    let surface = surfaces.find(primitive.material.map(|material| material.value()), name, warnings)?;
    let before = mesh.triangles.len();
    let first = mesh.positions.len() as u32;
    let positions = document.floats::<3>(positions, &[Type::Vec3], 0.0, &by("POSITION"))?;

    // An attribute, if present, has one entry per vertex.
    let fits =
        |what: &str, found: usize| match found == count {
            true => Ok(()),
            false => Err(document
                .fault(format!("{name}: {what} has length {found} for {}", counted(count, "vertex", "vertices")))),
        };
    if let Some(normals) = attribute(Semantic::Normals) {
        let normals = document.floats::<3>(normals, &[Type::Vec3], 0.0, &by("NORMAL"))?;
        fits("NORMAL", normals.len())?;
        mesh.normals.resize(before, [Vec3::ZERO; 3]);
        mesh.normals.extend(triangles.iter().map(|corners| {
            let normals = corners.map(|corner| unit(Vec3::from_array(normals[corner as usize])));
            if normals.contains(&Vec3::ZERO) { [Vec3::ZERO; 3] } else { normals }
        }));
    }
    let UvRule { set, .. } = surface.uv;
    if let Some(uv) = attribute(Semantic::TexCoords(set)) {
        let uv = document.floats::<2>(uv, &[Type::Vec2], 0.0, &by("TEXCOORD"))?;
        fits("TEXCOORD", uv.len())?;
        mesh.uv.resize(before, [Vec2::ZERO; 3]);
        let place = |corner: u32| surface.uv.place(Vec2::from_array(uv[corner as usize]));
        mesh.uv.extend(triangles.iter().map(|corners| corners.map(place)));
    } else if surface.is_textured {
        warnings.left_out("textures of primitives without texture coordinates, except for one corner", Place::File);
    }
    if let Some(tangents) = attribute(Semantic::Tangents).filter(|_| surface.uses_tangents) {
        let tangents = document.floats::<4>(tangents, &[Type::Vec4], 0.0, &by("TANGENT"))?;
        fits("TANGENT", tangents.len())?;
        mesh.tangents.resize(before, [Vec4::ZERO; 3]);
        let tangent = |corner: u32| {
            let [x, y, z, side] = tangents[corner as usize];
            unit(Vec3::new(x, y, z)).extend(if side < 0.0 { -1.0 } else { 1.0 })
        };
        mesh.tangents.extend(triangles.iter().map(|corners| corners.map(tangent)));
    } else if surface.has_normal_texture {
        *lacks_tangents = true;
    }
    if let Some(colors) = attribute(Semantic::Colors(0)) {
        let colors = document.floats::<4>(colors, &[Type::Vec3, Type::Vec4], 1.0, &by("COLOR_0"))?;
        fits("COLOR_0", colors.len())?;
        if colors.iter().any(|color| color[3] < 1.0) {
            warnings.left_out("opacities of vertices (COLOR_0)", Place::File);
        }
        let inside = |color: &&[f32; 4]| color[..3].iter().all(|value| (0.0..=1.0).contains(value));
        *clamped_colors += colors.len() - colors.iter().filter(inside).count();
        mesh.colors.resize(before, [Vec3::ONE; 3]);
        let color = |corner: u32| {
            let [r, g, b, _] = colors[corner as usize];
            Vec3::new(r, g, b).clamp(Vec3::ZERO, Vec3::ONE)
        };
        mesh.colors.extend(triangles.iter().map(|corners| corners.map(color)));
    }
    mesh.positions.extend(positions.into_iter().map(Vec3::from_array));
    mesh.materials.extend(std::iter::repeat_n(surface.material, triangles.len()));
    mesh.triangles.extend(triangles.into_iter().map(|corners| corners.map(|corner| first + corner)));
    Ok(())
}

/// Returns the corners of a primitive's triangles, as indices of its vertices.
fn corners(
    document: &Document,
    primitive: &Primitive,
    mode: Mode,
    vertices: usize,
    name: &str,
) -> Result<Vec<[u32; 3]>, Error> {
    let indices = match primitive.indices {
        Some(indices) => document.indices(indices, &format!("{name}, indices"))?,
        None => (0..vertices as u32).collect(),
    };
    if let Some(at) = indices.iter().position(|&corner| corner as usize >= vertices) {
        let are = counted(vertices, "vertex", "vertices");
        return Err(document.fault(format!("{name}: index {at} is {}, out of range for {are}", indices[at])));
    }
    if mode == Mode::Triangles && indices.len() % 3 != 0 {
        return Err(document.fault(format!("{name}: {} corners are not a multiple of 3", indices.len())));
    }
    Ok(match mode {
        Mode::TriangleStrip => {
            let turned = |(index, corners): (usize, &[u32])| match (index % 2, corners) {
                (0, &[a, b, c]) => [a, b, c],
                (_, corners) => [corners[0], corners[2], corners[1]],
            };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            let around = indices.get(1..).unwrap_or_default();
            around.windows(2).map(|pair| [pair[0], pair[1], indices[0]]).collect()
        }
        _ => indices.as_chunks::<3>().0.to_vec(),
    })
}
