//! Reads animations and skins.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use glam::{DAffine3, DMat4};
use gltf_json::{
    Accessor, Index,
    accessor::Type,
    animation::{Interpolation as Described, Property as Target, Sampler},
    validation::Checked,
};

use super::document::Document;
use crate::{
    Error,
    import::warnings::{Place, Warnings},
    message::counted,
    scene::animation::{Interpolation, NodeTree, Property, Skin, Track},
};

/// An animation's name and its tracks.
pub(super) type Clip = (Arc<str>, Vec<Track>);

/// Reads all animations. `places` has each node's place in the tree, or `None` for a node outside the scene, whose
/// tracks are left out. A node's rest weights give its number of morph targets.
pub(super) fn read(
    numbers: &mut Numbers,
    places: &[Option<usize>],
    tree: &NodeTree,
    warnings: &mut Warnings,
) -> Result<Vec<Clip>, Error> {
    let document = numbers.document;
    let mut clips = Vec::new();
    for (index, animation) in document.root.animations.iter().enumerate() {
        let mut tracks: Vec<Track> = Vec::new();
        let mut targets_seen = HashSet::new();
        for (number, channel) in animation.channels.iter().enumerate() {
            let name = format!("animations[{index}].channels[{number}]");
            let Checked::Valid(target) = channel.target.path else {
                warnings.left_out("animations of other properties than nodes have", Place::Item("animations", index));
                continue;
            };
            let node = channel.target.node.value();
            document.item(("nodes", &document.root.nodes), node, &name)?;
            let sampler = document.item(("samplers", &animation.samplers), channel.sampler.value(), &name)?;
            let Some(node) = places[node] else { continue };
            let sampler_name = format!("animations[{index}].samplers[{}]", channel.sampler.value());
            let targets = tree.nodes[node].weights.len();
            if let Some(track) = track(numbers, (node, target, targets), sampler, &sampler_name)? {
                if !targets_seen.insert(track.target()) {
                    return Err(document.fault(format!("{name}: another channel has the same node and path")));
                }
                tracks.push(track);
            }
        }
        let name = animation.name.as_deref().map_or_else(|| format!("animation {index}").into(), Arc::from);
        clips.push((name, tracks));
    }
    Ok(clips)
}

/// Reads a sampler for a node's property; `None` for weights of a node without morph targets.
fn track(
    numbers: &mut Numbers,
    (node, target, targets): (usize, Target, usize),
    sampler: &Sampler,
    name: &str,
) -> Result<Option<Track>, Error> {
    let property = match target {
        Target::Translation => Property::Translation,
        Target::Rotation => Property::Rotation,
        Target::Scale => Property::Scale,
        Target::MorphTargetWeights => Property::Weights,
    };
    let document = numbers.document;
    let Checked::Valid(interpolation) = sampler.interpolation else {
        return Err(document.fault(format!("{name}: its interpolation is unknown")));
    };
    let interpolation = match interpolation {
        Described::Step => Interpolation::Step,
        Described::Linear => Interpolation::Linear,
        Described::CubicSpline => Interpolation::CubicSpline,
    };
    let times = times(numbers, sampler.input, name)?;
    let by = format!("{name}, output");
    let values = match property {
        Property::Translation | Property::Scale => numbers.of::<3>(sampler.output, Type::Vec3, &by)?,
        Property::Rotation => numbers.of::<4>(sampler.output, Type::Vec4, &by)?,
        Property::Weights if targets == 0 => return Ok(None),
        Property::Weights => numbers.of::<1>(sampler.output, Type::Scalar, &by)?,
    };
    let per_key = property.width(targets) * if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    if values.len() != times.len() * per_key {
        let keys = counted(times.len(), "key frame", "key frames");
        let reason = format!("{by}: it has {} numbers for {keys} of {per_key} each", values.len());
        return Err(document.fault(reason));
    }
    Ok(Some(Track { node, property, interpolation, times, values }))
}

/// Reads the times of key frames.
fn times(numbers: &mut Numbers, input: Index<Accessor>, name: &str) -> Result<Arc<[f64]>, Error> {
    let document = numbers.document;
    let times = numbers.of::<1>(input, Type::Scalar, &format!("{name}, input"))?;
    if times.is_empty() {
        return Err(document.fault(format!("{name}, input: it has no key frames")));
    }
    if let Some(after) = (1..times.len()).find(|&key| times[key] < times[key - 1]) {
        let (time, before) = (times[after], times[after - 1]);
        let reason = format!("{name}, input: key frame {after} at {time} s comes after one at {before} s");
        return Err(document.fault(reason));
    }
    Ok(times)
}

/// Numbers of accessors, each read once, since many samplers may share one.
pub(super) struct Numbers<'a, 'b> {
    document: &'a Document<'b>,
    read: HashMap<(usize, usize), Arc<[f64]>>,
}

impl<'a, 'b> Numbers<'a, 'b> {
    pub(super) fn new(document: &'a Document<'b>) -> Self {
        Self { document, read: HashMap::new() }
    }

    /// Returns the numbers of an accessor with elements of N numbers.
    fn of<const N: usize>(&mut self, accessor: Index<Accessor>, kind: Type, by: &str) -> Result<Arc<[f64]>, Error> {
        let key = (accessor.value(), N);
        if let Some(values) = self.read.get(&key) {
            return Ok(values.clone());
        }
        let values = self.document.floats::<N>(accessor, &[kind], 0.0, by)?;
        self.document.count_decoded(N * values.len(), by)?;
        let values: Arc<[f64]> = values.as_flattened().iter().map(|&value| value.into()).collect();
        self.read.insert(key, values.clone());
        Ok(values)
    }
}

/// Reads all skins. A skin with a joint outside the scene is returned without joints.
pub(super) fn skins(numbers: &mut Numbers, places: &[Option<usize>]) -> Result<Vec<Skin>, Error> {
    let document = numbers.document;
    let mut read = |(index, skin): (usize, &gltf_json::Skin)| {
        let name = format!("skins[{index}]");
        if skin.joints.is_empty() {
            return Err(document.fault(format!("{name}: it has no joints")));
        }
        let mut joints = Vec::with_capacity(skin.joints.len());
        for joint in &skin.joints {
            document.item(("nodes", &document.root.nodes), joint.value(), &name)?;
            match places[joint.value()] {
                Some(place) => joints.push(place),
                None => return Ok(Skin::default()),
            }
        }
        let inverse_binds = match skin.inverse_bind_matrices {
            None => vec![DAffine3::IDENTITY; joints.len()],
            Some(accessor) => {
                let by = format!("{name}, inverseBindMatrices");
                let matrices = numbers.of::<16>(accessor, Type::Mat4, &by)?;
                let (matrices, _) = matrices.as_chunks::<16>();
                if matrices.len() < joints.len() {
                    let (found, joints) = (matrices.len(), counted(joints.len(), "joint", "joints"));
                    return Err(document.fault(format!("{by}: it has length {found} for {joints}")));
                }
                let matrix = |matrix: &[f64; 16]| DAffine3::from_mat4(DMat4::from_cols_array(matrix));
                matrices.iter().take(joints.len()).map(matrix).collect()
            }
        };
        Ok(Skin { joints, inverse_binds })
    };
    document.root.skins.iter().enumerate().map(&mut read).collect()
}
