//! Reads meshes and places them at nodes.

use std::{collections::HashMap, ops::Range, sync::Arc};

use glam::{DVec3, Vec2, Vec3, Vec4};
use gltf_json::{
    Accessor, Index, Mesh as Description,
    accessor::Type,
    mesh::{Mode, Primitive, Semantic},
    validation::Checked,
};

use super::{
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
        animation::{Body, Changes, MorphTarget},
        smooth::{smooth_normals, unit},
        tangents::tangents,
    },
};

/// Meshes in their own coordinates, each read once.
pub(super) struct Meshes<'a> {
    document: &'a Document<'a>,
    crease_angle: Option<f32>,
    read: HashMap<usize, Arc<Body>>,
    triangles: u64,
    vertices: u64,
    displacements: u64,
    influences: u64,
    /// Weights of the morph targets of each mesh at rest.
    rest_weights: HashMap<usize, Arc<[f64]>>,
}

impl<'a> Meshes<'a> {
    pub(super) fn new(document: &'a Document<'a>, options: &SceneOptions) -> Self {
        Self {
            document,
            crease_angle: options.crease_angle,
            read: HashMap::new(),
            triangles: 0,
            vertices: 0,
            displacements: 0,
            influences: 0,
            rest_weights: HashMap::new(),
        }
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
            let (mut body, lacks_tangents) = read(document, mesh, description, surfaces, warnings)?;
            body.mesh = self.smoothed(body.mesh.name(description.name.as_deref().unwrap_or_default()));
            if lacks_tangents && !body.mesh.uv.is_empty() {
                body.mesh.tangents = tangents(&body.mesh);
            }
            self.read.insert(mesh, Arc::new(body));
        }
        let read = &self.read[&mesh];
        self.triangles += read.mesh.triangles.len() as u64;
        self.vertices += read.mesh.positions.len() as u64;
        self.displacements += read.displacements + read.targets.len() as u64;
        self.influences += read.influences.len() as u64;
        document.check_size("its scene", "triangles", self.triangles, 1)?;
        document.check_size("its scene", "vertices", self.vertices, 3)?;
        document.check_size("its scene", "displacements of morph targets", self.displacements, 3)?;
        document.check_size("its scene", "influences of joints", self.influences, 3 * INFLUENCES)
    }

    /// Returns a mesh that was read.
    pub(super) fn body(&self, mesh: usize) -> &Arc<Body> {
        &self.read[&mesh]
    }

    /// Returns the rest weights of a mesh's morph targets at a node.
    pub(super) fn weights(&mut self, mesh: usize, node: usize) -> Result<Arc<[f64]>, Error> {
        let root = &self.document.root;
        let targets = self.read[&mesh].targets.len();
        if targets == 0 {
            return Ok(Arc::default());
        }
        let own = root.nodes[node].weights.as_deref().filter(|own| !own.is_empty());
        let all_meshes = || {
            let weights = root.meshes[mesh].weights.as_deref().unwrap_or_default();
            self.document.weights(weights, targets, &format!("meshes[{mesh}]"))
        };
        match own {
            Some(own) => self.document.weights(own, targets, &format!("nodes[{node}]")),
            None => match self.rest_weights.get(&mesh) {
                Some(weights) => Ok(weights.clone()),
                None => {
                    let weights = all_meshes()?;
                    self.rest_weights.insert(mesh, weights.clone());
                    Ok(weights)
                }
            },
        }
    }

    /// Returns the name of the object that shows a mesh at a node.
    pub(super) fn name_of(&self, mesh: usize, node: usize) -> Arc<str> {
        // All nodes of a mesh share its name, since it may be long and the nodes many.
        match self.document.root.nodes[node].name.as_deref().filter(|name| !name.is_empty()) {
            Some(name) => name.into(),
            None => self.read[&mesh].mesh.name.clone(),
        }
    }

    /// Returns the box of each mesh in its own coordinates.
    pub(super) fn boxes(&self) -> HashMap<usize, Option<(DVec3, DVec3)>> {
        let of = |body: &Body| bounds_of(body.mesh.positions.iter().map(|position| position.as_dvec3()));
        self.read.iter().map(|(&index, body)| (index, of(body))).collect()
    }

    fn smoothed(&self, mut mesh: Mesh) -> Mesh {
        if let Some(degrees) = self.crease_angle.filter(|_| mesh.normals.is_empty()) {
            mesh.normals = smooth_normals(&mesh.positions, &mesh.triangles, &[], degrees);
        }
        mesh
    }
}

/// Reads all triangle primitives of a mesh as one mesh. Also returns whether it needs tangents that the file lacks.
fn read(
    document: &Document,
    index: usize,
    description: &Description,
    surfaces: &mut Surfaces,
    warnings: &mut Warnings,
) -> Result<(Body, bool), Error> {
    let mut body = Body::default();
    let mut displacements = Displacements { document, read: HashMap::new() };
    let (mut clamped_colors, mut lacks_tangents) = (0, false);
    for (number, primitive) in description.primitives.iter().enumerate() {
        let name = format!("meshes[{index}].primitives[{number}]");
        let place = Place::Item("meshes", index);
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
        let first = body.mesh.positions.len();
        add(document, &mut body.mesh, primitive, mode, &name, (surfaces, warnings), noted)?;
        let mesh = &body.mesh;
        document.check_size(&format!("meshes[{index}]"), "triangles", mesh.triangles.len() as u64, 1)?;
        document.check_size(&format!("meshes[{index}]"), "vertices", mesh.positions.len() as u64, 3)?;
        let vertices = first..mesh.positions.len();
        add_influences(document, &mut body, primitive, vertices.clone(), &name)?;
        add_targets(&mut displacements, &mut body, primitive, vertices, &name)?;
    }
    if !body.first_influences.is_empty() {
        body.first_influences.push(body.influences.len());
    }
    let mesh = &mut body.mesh;
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
    Ok((body, lacks_tangents))
}

/// Maximum number of sets of four joints that a primitive may have.
const MOST_SETS: u32 = 8;
/// Influences per vertex that the limit on triangles allows for.
const INFLUENCES: u64 = 4;

/// Reads the joints and weights of a primitive's vertices. Weights are scaled to a sum of 1.
fn add_influences(
    document: &Document,
    body: &mut Body,
    primitive: &Primitive,
    vertices: Range<usize>,
    name: &str,
) -> Result<(), Error> {
    let attribute = |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let mut sets = Vec::new();
    for set in 0.. {
        if set == MOST_SETS {
            return Err(document.fault(format!("{name}: it has over {MOST_SETS} sets of joints")));
        }
        let (Some(joints), Some(weights)) = (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set)))
        else {
            break;
        };
        let by = |what: &str| format!("{name}, {what}_{set}");
        let joints = document.floats::<4>(joints, &[Type::Vec4], 0.0, &by("JOINTS"))?;
        let weights = document.floats::<4>(weights, &[Type::Vec4], 0.0, &by("WEIGHTS"))?;
        for (what, found) in [("JOINTS", joints.len()), ("WEIGHTS", weights.len())] {
            if found != vertices.len() {
                let vertices = counted(vertices.len(), "vertex", "vertices");
                return Err(document.fault(format!("{}: it has length {found} for {vertices}", by(what))));
            }
        }
        sets.push((joints, weights));
    }
    if sets.is_empty() && body.first_influences.is_empty() {
        return Ok(());
    }
    // Earlier primitives may have no joints.
    body.first_influences.resize(vertices.start, 0);
    for vertex in 0..vertices.len() {
        body.first_influences.push(body.influences.len());
        let all = || sets.iter().flat_map(|(joints, weights)| joints[vertex].into_iter().zip(weights[vertex]));
        let sum: f32 = all().map(|(_, weight)| weight.max(0.0)).sum();
        let scaled = all().filter(|(_, weight)| *weight > 0.0).map(|(joint, weight)| (joint as u32, weight / sum));
        body.influences.extend(scaled);
    }
    Ok(())
}

impl Document<'_> {
    /// Returns the weights of a number of morph targets. An empty list stands for zeros.
    fn weights(&self, weights: &[f32], targets: usize, by: &str) -> Result<Arc<[f64]>, Error> {
        match weights {
            [] => Ok(vec![0.0; targets].into()),
            _ if weights.len() != targets => {
                let targets = counted(targets, "morph target", "morph targets");
                Err(self.fault(format!("{by}: it has {} weights for {targets}", weights.len())))
            }
            _ => Ok(weights.iter().map(|&weight| weight.into()).collect()),
        }
    }
}

/// Reads the morph targets of a primitive.
fn add_targets(
    displacements: &mut Displacements,
    body: &mut Body,
    primitive: &Primitive,
    vertices: Range<usize>,
    name: &str,
) -> Result<(), Error> {
    let targets = primitive.targets.as_deref().unwrap_or_default();
    body.targets.resize_with(body.targets.len().max(targets.len()), MorphTarget::default);
    let has_normals = primitive.attributes.contains_key(&Checked::Valid(Semantic::Normals));
    for (index, (target, own)) in targets.iter().zip(&mut body.targets).enumerate() {
        let by = format!("{name}.targets[{index}]");
        for (accessor, list) in [
            (target.positions, &mut own.positions),
            (target.normals.filter(|_| has_normals), &mut own.normals),
            (target.tangents, &mut own.tangents),
        ] {
            let Some(accessor) = accessor else { continue };
            let by_vertex = displacements.of(accessor, vertices.len(), &by)?;
            body.displacements += by_vertex.len() as u64;
            list.push(Changes { first: vertices.start as u32, by_vertex });
        }
    }
    Ok(())
}

/// Displacements of a mesh's morph targets, each accessor read once, since many targets may share one.
struct Displacements<'a, 'b> {
    document: &'a Document<'b>,
    read: HashMap<usize, OfVertices>,
}

/// Displacements that are not zero, with the indices of their vertices.
#[derive(Clone)]
struct OfVertices {
    /// Number of vertices.
    vertices: usize,
    changes: Arc<[(u32, Vec3)]>,
}

impl Displacements<'_, '_> {
    /// Returns the displacements in an accessor that are not zero, with the indices of their vertices.
    fn of(&mut self, accessor: Index<Accessor>, vertices: usize, by: &str) -> Result<Arc<[(u32, Vec3)]>, Error> {
        let document = self.document;
        let found = match self.read.get(&accessor.value()) {
            Some(found) => found.clone(),
            None => {
                let all = document.floats::<3>(accessor, &[Type::Vec3], 0.0, by)?;
                let changes = (0..).zip(&all).map(|(vertex, change)| (vertex, Vec3::from_array(*change)));
                let changes = changes.filter(|(_, change)| *change != Vec3::ZERO).collect();
                let found = OfVertices { vertices: all.len(), changes };
                document.count_decoded(3 * found.changes.len(), by)?;
                self.read.insert(accessor.value(), found.clone());
                found
            }
        };
        if found.vertices != vertices {
            let vertices = counted(vertices, "vertex", "vertices");
            return Err(document.fault(format!("{by}: it has length {} for {vertices}", found.vertices)));
        }
        Ok(found.changes)
    }
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
