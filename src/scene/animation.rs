//! Animations: nodes whose transforms and morph weights depend on the time, and the objects that they move.

use std::{borrow::Cow, collections::HashSet, fmt, sync::Arc};

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

use super::{Light, LightShape, Mesh, Scene};
use crate::{Error, StereoCamera};

/// Largest sine of the roll of a camera that counts as level.
const LEVEL: f64 = 1e-4;

/// An animation of a scene file ([`SceneFile::animations`](crate::SceneFile::animations)). It moves objects, skins,
/// morph targets, lights and cameras.
///
/// ```no_run
/// use stereotrace::{Gpu, Renderer, SceneFile, SceneOptions, Update, blocking::Wait};
///
/// let mut file = SceneFile::open("fox.glb", &SceneOptions::default())?;
/// let walk = file.animations[0].clone();
/// let renderer = Renderer::new(Gpu::new().wait()?);
/// let mut uploaded = renderer.upload(&file.scene).wait()?;
/// for frame in 0..24 {
///     walk.pose(&mut file.scene, f64::from(frame) / 24.0)?;
///     renderer.update(&mut uploaded, &file.scene, Update::RefitOrRebuild).wait()?;
/// }
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Animation {
    name: Arc<str>,
    tracks: Arc<[Track]>,
    nodes: Arc<NodeTree>,
}

/// Nodes of a file, and what they move.
#[derive(Debug, Default)]
pub(crate) struct NodeTree {
    /// Nodes, parents before children.
    pub(crate) nodes: Vec<Node>,
    pub(crate) skins: Vec<Skin>,
    /// Objects that some animation moves.
    pub(crate) actors: Vec<Actor>,
    /// Node of each camera of the file, and the camera.
    pub(crate) cameras: Vec<(usize, StereoCamera)>,
    /// Lights that some animation moves: place in the scene's list, node, and the light at rest.
    pub(crate) lights: Vec<(usize, usize, Light)>,
}

/// A node. Nodes are referred to by their place in the list of a [`NodeTree`].
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) parent: Option<usize>,
    pub(crate) local: Local,
    /// Weights of the morph targets of the node's mesh.
    pub(crate) weights: Arc<[f64]>,
}

/// Transform of a node to its parent's frame.
#[derive(Clone, Debug)]
pub(crate) enum Local {
    /// A matrix, which can't be animated.
    Matrix(DAffine3),
    Parts {
        translation: DVec3,
        rotation: DQuat,
        scale: DVec3,
    },
}

/// A skin: the joints that move its vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct Skin {
    pub(crate) joints: Vec<usize>,
    /// Transforms from the mesh's frame to each joint's frame.
    pub(crate) inverse_binds: Vec<DAffine3>,
}

/// An object that moves.
#[derive(Clone, Debug)]
pub(crate) struct Actor {
    pub(crate) object: u32,
    pub(crate) node: usize,
    pub(crate) skin: Option<usize>,
    pub(crate) body: Arc<Body>,
    /// Name of the object.
    pub(crate) name: Arc<str>,
    /// Whether the winding of its triangles is reversed, since its node mirrors it at rest.
    pub(crate) mirrored: bool,
}

/// A mesh in its own frame, with what deforms it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Body {
    pub(crate) mesh: Mesh,
    pub(crate) targets: Vec<MorphTarget>,
    /// Number of displacements of all morph targets.
    pub(crate) displacements: u64,
    /// Joints and weights of each vertex: `influences[first[v]..first[v + 1]]`. Empty without a skin.
    pub(crate) first_influences: Vec<usize>,
    pub(crate) influences: Vec<(u32, f32)>,
}

/// Displacements of a morph target at a weight of 1, for each primitive of the file.
#[derive(Clone, Debug, Default)]
pub(crate) struct MorphTarget {
    pub(crate) positions: Vec<Changes>,
    pub(crate) normals: Vec<Changes>,
    pub(crate) tangents: Vec<Changes>,
}

/// Changes of vertices. Those that do not change are left out.
#[derive(Clone, Debug)]
pub(crate) struct Changes {
    /// Number that is added to the vertices' indices.
    pub(crate) first: u32,
    pub(crate) by_vertex: Arc<[(u32, Vec3)]>,
}

/// Values of a node's property over time.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    pub(crate) node: usize,
    pub(crate) property: Property,
    pub(crate) interpolation: Interpolation,
    /// Times of the key frames in seconds, in order.
    pub(crate) times: Arc<[f64]>,
    /// Values of the key frames; with cubic splines, incoming tangent, value and outgoing tangent of each.
    pub(crate) values: Arc<[f64]>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Property {
    Translation,
    Rotation,
    Scale,
    Weights,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

impl Animation {
    /// Makes an animation. No two tracks have one target.
    pub(crate) fn new(name: Arc<str>, mut tracks: Vec<Track>, nodes: Arc<NodeTree>) -> Self {
        tracks.sort_by_key(Track::target);
        Self { name, tracks: tracks.into(), nodes }
    }

    /// Returns the animation's name, or an empty text.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the time of the last key frame in seconds. The first key frame may be later than 0.
    pub fn duration(&self) -> f64 {
        self.tracks.iter().filter_map(|track| track.times.last().copied()).fold(0.0, f64::max)
    }

    /// Moves the scene's objects and lights to their places at a time in seconds. Before its first key frame and after
    /// its last one, a property keeps that key frame's value. Properties without key frames have the file's values.
    ///
    /// The scene must be the file's scene. Lights with another shape or intensity than the file's do not move. Cones
    /// and projectors of others point along their node's -z axis. Objects keep their primitives, so
    /// [`Renderer::flow`](crate::Renderer::flow) follows their points.
    /// [`Update::RefitOrRebuild`](crate::Update::RefitOrRebuild) follows on the device.
    ///
    /// # Errors
    /// [`Error::Scene`] if the time is not finite, if the scene lacks an object of the animation, or if a coordinate is
    /// out of range ([`Scene::set_mesh`]). The scene may then have objects of both times.
    pub fn pose(&self, scene: &mut Scene, seconds: f64) -> Result<(), Error> {
        let tree = &*self.nodes;
        let places = self.places_at(seconds)?;
        let to_origin = DAffine3::from_translation(-scene.origin());
        let joints = tree.joints(&places, to_origin);
        for actor in &tree.actors {
            let weights = match self.tracks.binary_search_by_key(&(actor.node, Property::Weights), Track::target) {
                Ok(place) => Cow::Owned(self.tracks[place].at(seconds)),
                Err(_) => Cow::Borrowed(&*tree.nodes[actor.node].weights),
            };
            let skin = actor.skin.map(|skin| &*joints[skin]);
            let mesh = actor.body.posed(&weights, skin, to_origin * places[actor.node], actor.mirrored);
            if !scene.has_mesh(actor.object, &actor.name, mesh.triangles.len()) {
                let reason = "it is not an object of the animation's file";
                return Err(Error::Scene { element: format!("object {}", actor.object), reason: reason.into() });
            }
            scene.set_mesh(actor.object, &mesh.name(actor.name.clone()))?;
        }
        for (index, node, rest) in &tree.lights {
            if let Some(light) = scene.lights.get_mut(*index) {
                light.follow(rest, places[*node]);
            }
        }
        Ok(())
    }

    /// Returns the file's cameras at a time in seconds, in the order of
    /// [`SceneFile::cameras`](crate::SceneFile::cameras). They keep their lenses, screens and interaxials.
    ///
    /// # Errors
    /// [`Error::Scene`] if the time is not finite.
    pub fn cameras(&self, seconds: f64) -> Result<Vec<StereoCamera>, Error> {
        let places = self.places_at(seconds)?;
        let moved = |&(node, rest): &(usize, StereoCamera)| {
            rest.at_node(places[node], rest.eye.distance(rest.target_position()))
        };
        Ok(self.nodes.cameras.iter().map(moved).collect())
    }

    /// Passes everything that poses depend on to `sink`, as bytes in pieces, like [`Scene::content`].
    pub fn content(&self, mut sink: impl FnMut(&[u8])) {
        let NodeTree { nodes, skins, actors, cameras, lights } = &*self.nodes;
        // Debug formatting of numbers is lossless.
        let mut text = |value: &dyn fmt::Debug| {
            let text = format!("{value:?}");
            sink(&text.len().to_le_bytes());
            sink(text.as_bytes());
        };
        text(&(&self.name, nodes, skins, cameras, lights));
        for Track { node, property, interpolation, times, values } in &*self.tracks {
            text(&(node, property, interpolation, times.len(), values.len()));
        }
        let mut seen = HashSet::new();
        for Actor { object, node, skin, body, name, mirrored } in actors {
            text(&(object, node, skin, name, mirrored));
            if seen.insert(Arc::as_ptr(body)) {
                text(&(&body.mesh.positions, &body.targets, &body.first_influences, &body.influences));
            }
        }
        for track in &*self.tracks {
            sink(bytemuck::cast_slice(&track.times));
            sink(bytemuck::cast_slice(&track.values));
        }
    }

    /// Returns each node's transform to the world.
    fn places_at(&self, seconds: f64) -> Result<Vec<DAffine3>, Error> {
        if !seconds.is_finite() {
            let element = format!("animation '{}'", self.name);
            return Err(Error::Scene { element, reason: format!("its time is {seconds}; it must be finite") });
        }
        let mut locals: Vec<Local> = self.nodes.nodes.iter().map(|node| node.local.clone()).collect();
        for track in self.tracks.iter().filter(|track| track.property != Property::Weights) {
            let value = track.at(seconds);
            match (&mut locals[track.node], track.property) {
                (Local::Parts { translation, .. }, Property::Translation) => *translation = DVec3::from_slice(&value),
                (Local::Parts { rotation, .. }, Property::Rotation) => *rotation = DQuat::from_slice(&value),
                (Local::Parts { scale, .. }, Property::Scale) => *scale = DVec3::from_slice(&value),
                (Local::Matrix(_), _) | (_, Property::Weights) => {}
            }
        }
        Ok(self.nodes.places(&locals))
    }
}

impl NodeTree {
    /// Returns each node's transform to the world at rest.
    pub(crate) fn rest_places(&self) -> Vec<DAffine3> {
        let locals: Vec<Local> = self.nodes.iter().map(|node| node.local.clone()).collect();
        self.places(&locals)
    }

    /// Returns each node's transform to the world.
    pub(crate) fn places(&self, locals: &[Local]) -> Vec<DAffine3> {
        let mut places: Vec<DAffine3> = Vec::with_capacity(locals.len());
        for (node, local) in self.nodes.iter().zip(locals) {
            let own = local.transform();
            places.push(node.parent.map_or(own, |parent| places[parent] * own));
        }
        places
    }

    /// Returns the transforms of the joints of each skin, from the mesh's frame to the scene's.
    pub(crate) fn joints(&self, places: &[DAffine3], to_origin: DAffine3) -> Vec<Vec<DAffine3>> {
        let joints = |skin: &Skin| {
            let pairs = skin.joints.iter().zip(&skin.inverse_binds);
            pairs.map(|(&joint, inverse_bind)| to_origin * places[joint] * *inverse_bind).collect()
        };
        self.skins.iter().map(joints).collect()
    }
}

impl Local {
    pub(crate) fn transform(&self) -> DAffine3 {
        match self {
            Self::Matrix(matrix) => *matrix,
            Self::Parts { translation, rotation, scale } => {
                DAffine3::from_scale_rotation_translation(*scale, *rotation, *translation)
            }
        }
    }
}

impl Body {
    /// Returns the mesh with these weights of its morph targets, relative to the scene's origin. Joints move it if it
    /// has a skin, otherwise `place` does.
    pub(crate) fn posed(&self, weights: &[f64], joints: Option<&[DAffine3]>, place: DAffine3, mirrored: bool) -> Mesh {
        let mut mesh = self.mesh.clone();
        self.morph(&mut mesh, weights);
        match joints {
            Some(joints) => {
                let vertices = 0..mesh.positions.len();
                let place_of = |vertex| Placing::of(self.place_of(vertex, joints).unwrap_or(place));
                let places: Vec<Placing> = vertices.map(place_of).collect();
                transform(&mut mesh, |vertex| &places[vertex as usize]);
            }
            None => {
                let place = Placing::of(place);
                transform(&mut mesh, |_| &place);
            }
        }
        if mirrored {
            mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
            mesh.normals.iter_mut().for_each(|corners| corners.swap(1, 2));
            mesh.uv.iter_mut().for_each(|corners| corners.swap(1, 2));
            mesh.colors.iter_mut().for_each(|corners| corners.swap(1, 2));
            mesh.tangents.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        mesh
    }

    /// Adds the changes of the morph targets to a copy of the mesh.
    fn morph(&self, mesh: &mut Mesh, weights: &[f64]) {
        let sum = |changes: fn(&MorphTarget) -> &[Changes]| -> Option<Vec<DVec3>> {
            let targets = self.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0);
            let mut all = targets.flat_map(|(target, weight)| changes(target).iter().map(move |one| (one, *weight)));
            let first = all.next()?;
            let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
            for (changes, weight) in std::iter::once(first).chain(all) {
                for &(vertex, change) in &*changes.by_vertex {
                    sums[(changes.first + vertex) as usize] += change.as_dvec3() * weight;
                }
            }
            Some(sums)
        };
        let sums = [sum(|target| &target.positions), sum(|target| &target.normals), sum(|target| &target.tangents)];
        let [positions, normals, tangents] = sums;
        let changed = |value: Vec3, by: DVec3| (value.as_dvec3() + by).as_vec3();
        for (position, by) in mesh.positions.iter_mut().zip(positions.iter().flatten()) {
            *position = changed(*position, *by);
        }
        if let Some(sums) = normals {
            let corners = mesh.normals.as_flattened_mut().iter_mut().zip(mesh.triangles.as_flattened());
            // A triangle that is flat at rest stays flat.
            for (normal, vertex) in corners.filter(|(normal, _)| **normal != Vec3::ZERO) {
                *normal = changed(*normal, sums[*vertex as usize]).normalize_or_zero();
            }
        }
        if let Some(sums) = tangents {
            let corners = mesh.tangents.as_flattened_mut().iter_mut().zip(mesh.triangles.as_flattened());
            for (tangent, vertex) in corners {
                let way = changed(tangent.truncate(), sums[*vertex as usize]);
                *tangent = way.extend(tangent.w);
            }
        }
    }

    /// Returns the transform of a vertex, blended from those of its joints, or `None` for a vertex without any.
    fn place_of(&self, vertex: usize, joints: &[DAffine3]) -> Option<DAffine3> {
        let [begin, end] = [vertex, vertex + 1].map(|place| self.first_influences.get(place).copied());
        let range = begin?..end?;
        if range.is_empty() {
            return None;
        }
        let mut blend = DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO };
        for &(joint, weight) in &self.influences[range] {
            let (joint, weight) = (joints[joint as usize], f64::from(weight));
            blend.matrix3 += joint.matrix3 * weight;
            blend.translation += joint.translation * weight;
        }
        Some(blend)
    }
}

/// A transform, also of normals and tangents.
struct Placing {
    place: DAffine3,
    /// Matrix that keeps normals perpendicular; `None` if they stay as they are.
    upright: Option<DMat3>,
    /// -1 if the transform mirrors, else 1.
    sign: f64,
}

impl Placing {
    fn of(place: DAffine3) -> Self {
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = place.matrix3;
        let sign = place.matrix3.determinant().signum();
        // The cofactors are the inverse transposed up to a factor. They exist for singular matrices too.
        let upright = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
        Self { place, upright: (place.matrix3 != DMat3::IDENTITY).then_some(upright), sign }
    }
}

/// Transforms a mesh vertex by vertex.
fn transform<'a>(mesh: &mut Mesh, place_of: impl Fn(u32) -> &'a Placing) {
    for (normals, corners) in mesh.normals.iter_mut().zip(&mesh.triangles) {
        for (normal, &corner) in normals.iter_mut().zip(corners) {
            if let Some(upright) = place_of(corner).upright {
                *normal = (upright * normal.as_dvec3()).normalize_or_zero().as_vec3();
            }
        }
        if normals.contains(&Vec3::ZERO) {
            *normals = [Vec3::ZERO; 3];
        }
    }
    for (tangents, corners) in mesh.tangents.iter_mut().zip(&mesh.triangles) {
        for (tangent, &corner) in tangents.iter_mut().zip(corners) {
            let Placing { place, sign, .. } = place_of(corner);
            let way = place.transform_vector3(tangent.truncate().as_dvec3());
            *tangent = way.normalize_or_zero().as_vec3().extend(tangent.w * *sign as f32);
        }
    }
    for (vertex, position) in (0..).zip(&mut mesh.positions) {
        *position = place_of(vertex).place.transform_point3(position.as_dvec3()).as_vec3();
    }
}

impl Property {
    /// Returns how many numbers a value has.
    pub(crate) fn width(self, targets: usize) -> usize {
        match self {
            Self::Translation | Self::Scale => 3,
            Self::Rotation => 4,
            Self::Weights => targets,
        }
    }
}

impl Track {
    /// Returns the node and the property that the track animates.
    pub(crate) fn target(&self) -> (usize, Property) {
        (self.node, self.property)
    }

    /// Returns the value at a time in seconds (glTF 2.0, appendix C).
    fn at(&self, seconds: f64) -> Vec<f64> {
        let per_key = if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let width = self.values.len() / (self.times.len() * per_key).max(1);
        // The part of a key frame: 0 for its incoming tangent, 1 for its value, 2 for its outgoing tangent.
        let part = |key: usize, part: usize| {
            let begin = if per_key == 3 { (3 * key + part) * width } else { key * width };
            &self.values[begin..begin + width]
        };
        let after = self.times.partition_point(|time| *time <= seconds);
        let (Some(before), true) = (after.checked_sub(1), after < self.times.len()) else {
            return self.unit(part(after.min(self.times.len() - 1), 1).to_vec());
        };
        let length = self.times[after] - self.times[before];
        let share = (seconds - self.times[before]) / length;
        let (low, high) = (part(before, 1), part(after, 1));
        let blend = |factors: &dyn Fn(usize) -> f64| (0..width).map(factors).collect::<Vec<f64>>();
        let value = match self.interpolation {
            Interpolation::Step => low.to_vec(),
            Interpolation::Linear if self.property == Property::Rotation => {
                let [low, high] = [low, high].map(|value| DQuat::from_slice(value).normalize());
                low.slerp(high, share).to_array().to_vec()
            }
            Interpolation::Linear => blend(&|place| low[place] + (high[place] - low[place]) * share),
            Interpolation::CubicSpline => {
                let (leaving, arriving) = (part(before, 2), part(after, 0));
                let (square, cube) = (share * share, share * share * share);
                blend(&|place| {
                    (2.0 * cube - 3.0 * square + 1.0) * low[place]
                        + length * (cube - 2.0 * square + share) * leaving[place]
                        + (3.0 * square - 2.0 * cube) * high[place]
                        + length * (cube - square) * arriving[place]
                })
            }
        };
        self.unit(value)
    }

    /// Gives rotations their unit length.
    fn unit(&self, value: Vec<f64>) -> Vec<f64> {
        if self.property != Property::Rotation {
            return value;
        }
        let unit = DQuat::from_slice(&value);
        let unit = if unit.length_squared() > 0.0 { unit.normalize() } else { DQuat::IDENTITY };
        unit.to_array().to_vec()
    }
}

impl StereoCamera {
    /// Returns this camera at a node, which looks along its -z axis at a point `distance` away. A camera without roll
    /// gets the world's up. The picture is the same, and orbits about this axis stay level.
    pub(crate) fn at_node(self, place: DAffine3, distance: f64) -> Self {
        let forward = place.transform_vector3(DVec3::NEG_Z).normalize_or_zero();
        let own_up = place.transform_vector3(DVec3::Y).normalize_or_zero();
        let is_level = forward.cross(own_up).dot(DVec3::Y).abs() < LEVEL && own_up.y > LEVEL;
        let eye = place.translation;
        self.eye(eye).target(eye + distance * forward).up(if is_level { DVec3::Y } else { own_up }.as_vec3())
    }
}

impl Light {
    /// Moves the light to a node if it is the light that the node had at rest. Spot lights, projectors and directional
    /// lights shine along the node's -z axis. The node's y axis is up in a projector's picture.
    fn follow(&mut self, rest: &Self, place: DAffine3) {
        let is_same = self.intensity == rest.intensity && self.shape == rest.shape && self.falloff == rest.falloff;
        if !is_same {
            return;
        }
        let towards = place.transform_vector3(DVec3::Z).normalize_or_zero();
        self.position = if matches!(self.shape, LightShape::Directional { .. }) { towards } else { place.translation };
        if let Some(cone) = &mut self.cone {
            cone.direction = -towards.as_vec3();
        }
        if let Some(projector) = &mut self.projector {
            projector.direction = -towards.as_vec3();
            projector.up = place.transform_vector3(DVec3::Y).normalize_or_zero().as_vec3();
        }
    }
}
