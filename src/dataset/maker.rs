//! Makes the pairs of a spec.

use std::{collections::BTreeMap, sync::Arc};

use serde::Serialize;

use super::{
    Spec, array, checks,
    draws::Draws,
    figures::{percentiles, thin_count},
    generate::Assets,
    instant,
    poses::RandomPose,
    rolling,
    stage::{Stage, generator_sha256},
};
use crate::{
    Channel, Correspondence, Error, Flow, GroundTruth, Layers, Maker, Occlusion, OnProgress, Options, Renderer, Scene,
    StereoCamera, StereoPair, UploadedScene,
};

/// Default memory in bytes for the scenes that are kept.
const SCENE_MEMORY: usize = 1 << 30;
/// Memory of a scene on the host and on a software device together, as a multiple of [`Scene::memory`]. 1.8 and 2.9
/// were measured on a million triangles.
const COPIES: usize = 3;

/// Makes the pairs of a spec. It reads scenes when they are needed, and keeps the most recently used ones in memory and
/// on the device. A pair depends only on the spec and its number.
///
/// ```
/// use stereotrace::{Gpu, Renderer, blocking::Wait as _, dataset::{PairMaker, Spec}};
///
/// let spec = r#"{"pairs": 3, "size": [64, 48], "scenes": [{"builtin": "hall"}], "render": {"samples": 4}}"#;
/// let mut maker = PairMaker::new(Spec::from_json(spec, ".")?);
/// let mut renderer = Renderer::new(Gpu::new().wait()?);
/// let made = maker.pair(&mut renderer, 2, &mut |_| std::ops::ControlFlow::Continue(())).wait()?;
/// println!("eye at {:?}", made.record.eye);
/// # Ok::<(), stereotrace::Error>(())
/// ```
pub struct PairMaker {
    spec: Spec,
    /// Channels to render besides those of the spec.
    more: Vec<Channel>,
    scenes: Scenes,
}

/// The scenes of a spec in memory.
struct Scenes {
    memory: usize,
    /// Hashes that scenes must have.
    hashes: Vec<Option<String>>,
    /// Scenes by index, with the most recently used at the end.
    stages: Vec<(usize, Stage)>,
    /// Reasons why scenes can't be read. They are not read again for every pair.
    faults: BTreeMap<usize, Arc<Error>>,
    read: Vec<usize>,
    /// Files of the folders that generated scenes use, with the hash of all that they depend on, by index.
    assets: BTreeMap<usize, (Assets, String)>,
}

/// A pair of a data set.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MadePair {
    /// The pair.
    pub pair: StereoPair,
    /// Its ground truth, if outputs of the spec need it.
    pub truth: Option<GroundTruth>,
    /// Its camera.
    pub camera: StereoCamera,
    /// Its figures.
    pub record: Record,
    /// All surfaces along its lines of sight, if outputs of the spec need them.
    pub layers: Option<Layers>,
    /// Places of its points in the other eye's picture, if outputs of the spec need them.
    pub matches: Option<Correspondence>,
    /// The next pair, if the spec has motion without a rolling shutter.
    pub next: Option<Box<NextPair>>,
    /// Pairs of the array, if the spec has one. The first one is also [`MadePair::pair`].
    pub array: Vec<ArrayPair>,
}

/// A pair of an array of cameras.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ArrayPair {
    /// Numbers of its left and its right camera, or of the upper and the lower one. These have pictures that are turned
    /// counterclockwise ([`Views::pair_below`](crate::Views::pair_below)).
    pub cameras: [usize; 2],
    /// Its camera.
    pub camera: StereoCamera,
    /// The pair.
    pub pair: StereoPair,
    /// Its ground truth, if outputs of the spec need it.
    pub truth: Option<GroundTruth>,
    /// All surfaces along its lines of sight, if outputs of the spec need them.
    pub layers: Option<Layers>,
}

/// The second pair of an item with motion.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NextPair {
    /// The pair.
    pub pair: StereoPair,
    /// Its ground truth, if outputs of the spec need it.
    pub truth: Option<GroundTruth>,
    /// All surfaces along its lines of sight, if outputs of the spec need them.
    pub layers: Option<Layers>,
    /// Places of its points in the other eye's picture, if outputs of the spec need them.
    pub matches: Option<Correspondence>,
    /// Its camera.
    pub camera: StereoCamera,
    /// Motion of the first pair's points to this pair.
    pub forward: Flow,
    /// Motion of this pair's points to the first pair.
    pub backward: Flow,
}

/// Figures of a pair. Percentages and disparities are of the left view.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Record {
    /// Number of the pair.
    pub item: u32,
    /// Name of the scene.
    pub scene: String,
    /// Midpoint between the eyes, world position.
    pub eye: [f64; 3],
    /// View direction in the world.
    pub forward: [f64; 3],
    /// Up direction of the picture in the world.
    pub up: [f64; 3],
    /// Distance between the eyes in world units.
    pub interaxial: f64,
    /// Number of cameras tried for the pose; `None` for a pose that was given.
    pub tries: Option<u32>,
    /// The method that rendered the right view.
    pub method: String,
    /// Share of the right view that was traced, 0 to 1.
    pub retraced_share: f64,
    /// Smallest and largest disparity of surfaces in pixels; `None` if there are no surfaces.
    pub disparity: Option<[f64; 2]>,
    /// Nearest depth in world units; `None` if there are no surfaces.
    pub nearest_depth: Option<f64>,
    /// Percentage of sky.
    pub sky_percent: f64,
    /// Percentage of pixels that an occluder hides from the right eye, if ground truth was computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hidden_percent: Option<f64>,
    /// Percentage of pixels outside the right view, if ground truth was computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out_of_frame_percent: Option<f64>,
    /// Disparities in pixels that 1, 5, 25, 50, 75, 95 and 99 percent of the surfaces' pixels do not exceed; `None` if
    /// there are no surfaces.
    pub disparity_percentiles: Option<[f64; 7]>,
    /// Percentage of pixels on thin structures: runs in a row of at most a 64th of the width (at least one pixel)
    /// before something that is farther by 5% or more on both sides.
    pub thin_percent: f64,
    /// Reasons for which earlier attempts at the pair were rejected.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rejects: Vec<String>,
}

impl PairMaker {
    /// Creates a maker that keeps 1 GiB of scenes.
    pub fn new(spec: Spec) -> Self {
        let hashes = vec![None; spec.scenes.len()];
        let (stages, faults, read, assets) = (Vec::new(), BTreeMap::new(), Vec::new(), BTreeMap::new());
        let scenes = Scenes { memory: SCENE_MEMORY, hashes, stages, faults, read, assets };
        Self { spec, more: Vec::new(), scenes }
    }

    /// Sets the memory for kept scenes in bytes, on the host and the device together. The current scene is always kept.
    #[must_use]
    pub fn scene_memory(mut self, bytes: usize) -> Self {
        self.scenes.memory = bytes;
        self
    }

    /// Adds channels to those that the spec's outputs need.
    #[must_use]
    pub fn also(mut self, channels: &[Channel]) -> Self {
        self.more.extend(channels);
        self
    }

    /// Uses an uploaded scene as the first scene of the spec, in place of the spec's file. Poses are drawn from
    /// `camera`, in place of the spec's camera and rig.
    #[must_use]
    pub fn with_scene(mut self, scene: Scene, uploaded: UploadedScene, camera: StereoCamera) -> Self {
        self.scenes.stages = vec![(0, Stage::given(scene, uploaded, camera))];
        self
    }

    /// Sets the hashes that scenes must have when they are read, as [`PairMaker::scene_sha256`] returns them, by the
    /// scenes' indices. `None` accepts any content. Scenes that could not be read are tried again.
    pub fn expect_hashes(&mut self, hashes: &[Option<String>]) {
        self.scenes.faults.clear();
        self.scenes.hashes = (0..self.spec.scenes.len()).map(|index| hashes.get(index).cloned().flatten()).collect();
    }

    /// Returns the spec.
    pub fn spec(&self) -> &Spec {
        &self.spec
    }

    /// Returns the channels that pairs have: those of the spec's arrays, color and disparity, and those added by
    /// [`PairMaker::also`].
    pub fn channels(&self) -> Vec<Channel> {
        let of_arrays = self.spec.arrays().iter().filter_map(|array| array.output.channel());
        let needs_ids = self.spec.has_next() || self.spec.needs_layers(false);
        let all: Vec<_> = of_arrays
            .chain([Channel::Color, Channel::Disparity])
            .chain(needs_ids.then_some(Channel::Primitive))
            .chain(self.more.iter().copied())
            .collect();
        Channel::ALL.iter().copied().filter(|channel| all.contains(channel)).collect()
    }

    /// Returns the indices of the scenes read so far, in this order.
    pub fn scenes_read(&self) -> &[usize] {
        &self.scenes.read
    }

    /// Returns whether a scene is in memory.
    pub fn has_scene(&self, index: usize) -> bool {
        self.scenes.stages.iter().any(|(kept, _)| *kept == index)
    }

    /// Returns the index of a pair's scene.
    pub fn scene_of(&self, item: u32) -> usize {
        let weights: Vec<f64> = self.spec.scenes.iter().map(|scene| scene.weight).collect();
        self.spec.scene_draws(&self.draws(item)).weighted(&weights, "scene")
    }

    /// Returns a scene with the lights and materials of the last pair, and reads it if it is not in memory. A generated
    /// scene is that of the last pair, or that of the first item.
    ///
    /// # Errors
    /// [`Error::DataSetScene`] if the scene can't be read or has another hash than expected; [`Error::Spec`] for an
    /// index out of range.
    pub fn scene(&mut self, index: usize) -> Result<&Scene, Error> {
        let kept = self.scenes.stages.iter().find(|(kept, _)| *kept == index);
        let draws = match kept.and_then(|(_, stage)| stage.made_for) {
            Some([item, attempt]) => Draws { attempt, ..self.draws(item) },
            None => self.draws(0),
        };
        Ok(&self.scenes.stage(&self.spec, index, &draws)?.scene)
    }

    /// Returns a SHA-256 of everything that pictures of a scene depend on: its content and its camera in the spec. For
    /// generated scenes, it covers the options, the generator's version and the contents of the user's folders.
    ///
    /// # Errors
    /// The errors of [`PairMaker::scene`].
    pub fn scene_sha256(&mut self, index: usize) -> Result<String, Error> {
        if self.spec.generator(index).is_some() {
            return Ok(self.scenes.assets(&self.spec, index)?.1.clone());
        }
        let draws = self.draws(0);
        let stage = self.scenes.stage(&self.spec, index, &draws)?;
        stage.undress();
        stage.sha256(&self.spec, index).map_err(|error| Error::DataSetScene { index, source: error.into() })
    }

    /// Makes a pair. Scenes are uploaded to the renderer's device, to a new device too. If the scene has checks, a
    /// rejected pair is drawn again.
    ///
    /// # Errors
    /// The errors of [`PairMaker::scene`], [`FreePoses::find`](super::FreePoses::find), [`Renderer::pair`] and
    /// [`Renderer::ground_truth`]; [`Error::Spec`] for a number out of range, and if all attempts were rejected.
    pub async fn pair(
        &mut self,
        renderer: &mut Renderer,
        item: u32,
        progress: &mut OnProgress<'_>,
    ) -> Result<MadePair, Error> {
        self.check_item(item)?;
        let index = self.scene_of(item);
        let Some(limits) = self.spec.scenes[index].limits().copied() else {
            return self.attempt(renderer, &self.draws(item), progress).await;
        };
        let mut rejects = Vec::new();
        for attempt in 0..=limits.redraws {
            let draws = Draws { attempt, ..self.draws(item) };
            let fault = match self.attempt(renderer, &draws, progress).await {
                Ok(mut made) => match checks::fault(&made.pair, &limits) {
                    None => {
                        made.record.rejects = rejects;
                        return Ok(made);
                    }
                    Some(fault) => fault,
                },
                Err(Error::Options { option: "poses", reason }) => reason,
                Err(error) => return Err(error),
            };
            rejects.push(fault);
        }
        let reason = format!("item {item} was rejected {} times: {}", rejects.len(), rejects.join("; "));
        Err(Error::Spec { key: format!("scenes[{index}].checks"), reason })
    }

    /// Makes a pair by these draws, whatever it shows.
    async fn attempt(
        &mut self,
        renderer: &mut Renderer,
        draws: &Draws,
        progress: &mut OnProgress<'_>,
    ) -> Result<MadePair, Error> {
        let index = self.scene_of(draws.item);
        let stage = self.scenes.stage(&self.spec, index, draws)?;
        stage.seek(&self.spec, draws)?;
        let RandomPose { camera, tries } = stage.posed(renderer, &self.spec, index, draws).await?;
        let mut made = self.drawn(renderer, draws, camera, progress).await?;
        made.record.tries = Some(tries);
        Ok(made)
    }

    /// Makes a pair from a given camera. It is not checked.
    ///
    /// # Errors
    /// The errors of [`PairMaker::pair`] except those of poses.
    pub async fn pair_from(
        &mut self,
        renderer: &mut Renderer,
        item: u32,
        camera: StereoCamera,
        progress: &mut OnProgress<'_>,
    ) -> Result<MadePair, Error> {
        self.check_item(item)?;
        self.drawn(renderer, &self.draws(item), camera, progress).await
    }

    /// Makes a pair by these draws from a given camera.
    async fn drawn(
        &mut self,
        renderer: &mut Renderer,
        draws: &Draws,
        camera: StereoCamera,
        progress: &mut OnProgress<'_>,
    ) -> Result<MadePair, Error> {
        let (item, index, channels) = (draws.item, self.scene_of(draws.item), self.channels());
        let stage = self.scenes.stage(&self.spec, index, draws)?;
        let spec = &self.spec;
        stage.seek(spec, draws)?;
        stage.dress(spec, index, draws, &camera)?;
        if let Err(error) = stage.bring(renderer).await {
            stage.undress(); // the next pair may be valid
            return Err(error);
        }
        let options = options_of(spec, draws, &channels)?;
        let needs_truth = channels.iter().any(|channel| channel.maker() == Maker::GroundTruth);
        let view = Take { spec, draws, options: &options, camera, needs_truth };
        let Shown { camera, pair, truth, layers, matches, next, array } = match (&spec.rig.array, spec.rolling()) {
            (Some(array), _) => array::shown(renderer, stage, &view, array, progress).await?,
            (None, Some((motion, rolling))) => {
                rolling::shown(renderer, stage, &view, (motion, rolling), progress).await?
            }
            (None, None) => instant::shown(renderer, stage, &view, progress).await?,
        };
        let record = record(item, spec.scene_name(index), &pair, truth.as_ref());
        Ok(MadePair { pair, truth, layers, matches, camera, record, next, array })
    }

    fn check_item(&self, item: u32) -> Result<(), Error> {
        match self.spec.pairs {
            pairs if item < pairs => Ok(()),
            pairs => Err(Error::Spec { key: "pairs".into(), reason: format!("no pair {item}; there are {pairs}") }),
        }
    }

    fn draws(&self, item: u32) -> Draws {
        Draws { seed: self.spec.seed, item, attempt: 0 }
    }
}

/// Returns the options of an item's pairs.
fn options_of(spec: &Spec, draws: &Draws, channels: &[Channel]) -> Result<Options, Error> {
    let exposure = spec.randomise.exposure.as_ref().map_or(0.0, |value| draws.draw(value, "exposure"));
    let mut options = spec.options_of(draws)?.channels(channels).exposure(exposure as f32);
    if !spec.render.contains_key("seed") {
        options = options.seed(spec.seed.wrapping_add(draws.item));
    }
    options.linear |= spec.changes_light();
    Ok(options)
}

/// How an item is rendered.
pub(super) struct Take<'a> {
    pub(super) spec: &'a Spec,
    pub(super) draws: &'a Draws,
    pub(super) options: &'a Options,
    pub(super) camera: StereoCamera,
    /// Whether outputs need ground truth.
    pub(super) needs_truth: bool,
}

/// What an item shows: the parts of [`MadePair`] without its record.
pub(super) struct Shown {
    pub(super) camera: StereoCamera,
    pub(super) pair: StereoPair,
    pub(super) truth: Option<GroundTruth>,
    pub(super) layers: Option<Layers>,
    pub(super) matches: Option<Correspondence>,
    pub(super) next: Option<Box<NextPair>>,
    pub(super) array: Vec<ArrayPair>,
}

impl Scenes {
    /// Moves a scene to the end of the list, and reads or generates it if it is not there.
    fn stage(&mut self, spec: &Spec, index: usize, draws: &Draws) -> Result<&mut Stage, Error> {
        if index >= spec.scenes.len() {
            let reason = format!("no scene {index}; there are {}", spec.scenes.len());
            return Err(Error::Spec { key: "scenes".into(), reason });
        }
        let draws = &spec.scene_draws(draws);
        self.stages.retain(|(kept, stage)| *kept != index || !stage.is_for_another(draws));
        let kept = self.stages.iter().position(|(kept, _)| *kept == index);
        let stage = match kept {
            Some(place) => self.stages.remove(place).1,
            None if spec.generator(index).is_some() => {
                let (assets, _) = self.assets(spec, index)?;
                Stage::generated(spec, index, assets, draws)
                    .map_err(|error| Error::DataSetScene { index, source: error.into() })?
            }
            None => self.opened(spec, index)?,
        };
        self.stages.push((index, stage));
        let used = |stages: &[(usize, Stage)]| stages.iter().map(|(_, stage)| stage.scene.memory()).sum::<usize>();
        while self.stages.len() > 1 && COPIES.saturating_mul(used(&self.stages)) > self.memory {
            self.stages.remove(0);
        }
        let Some((_, stage)) = self.stages.last_mut() else { unreachable!("a stage was pushed") };
        Ok(stage)
    }

    /// Returns the files of a generated scene's folders, and the hash of all that it depends on. They are read once.
    fn assets(&mut self, spec: &Spec, index: usize) -> Result<&(Assets, String), Error> {
        if !self.assets.contains_key(&index) {
            let found = self.read_once(spec, index, |spec, index| {
                let Some(options) = spec.generator(index) else { unreachable!("the caller asks for generated scenes") };
                let assets = Assets::open(spec, options)?;
                let hash = generator_sha256(spec, index, &assets)?;
                Ok(((assets, hash.clone()), Some(hash)))
            })?;
            self.assets.insert(index, found);
        }
        Ok(&self.assets[&index])
    }

    fn opened(&mut self, spec: &Spec, index: usize) -> Result<Stage, Error> {
        let is_expected = self.hashes[index].is_some();
        self.read_once(spec, index, |spec, index| {
            let stage = Stage::open(spec, index)?;
            let hash = if is_expected { Some(stage.sha256(spec, index)?) } else { None };
            Ok((stage, hash))
        })
    }

    /// Reads the files of a scene, and checks its hash. After an error, they are not read again.
    fn read_once<T>(
        &mut self,
        spec: &Spec,
        index: usize,
        read: impl FnOnce(&Spec, usize) -> Result<(T, Option<String>), Error>,
    ) -> Result<T, Error> {
        if let Some(source) = self.faults.get(&index) {
            return Err(Error::DataSetScene { index, source: source.clone() });
        }
        self.read.push(index);
        let checked = read(spec, index).and_then(|(found, hash)| match &self.hashes[index] {
            Some(expected) if hash.as_ref() != Some(expected) => Err(Error::Spec {
                key: spec.scene_name(index),
                reason: "it has changed since the data set was begun".into(),
            }),
            _ => Ok(found),
        });
        checked.map_err(|error| {
            let source = Arc::new(error);
            self.faults.insert(index, source.clone());
            Error::DataSetScene { index, source }
        })
    }
}

fn record(item: u32, scene: String, pair: &StereoPair, truth: Option<&GroundTruth>) -> Record {
    let (pose, depth) = (&pair.pose, &pair.left.depth);
    let percent = |count: usize| 100.0 * count as f64 / depth.len() as f64;
    let of = |kind| truth.map(|truth| percent(truth.left.occlusion.iter().filter(|found| **found == kind).count()));
    let nearest = pair.left.depth_range().0;
    let disparities = pair.disparity();
    let surfaces = disparities.iter().zip(depth).filter(|(_, depth)| depth.is_finite());
    let surfaces: Vec<f32> = surfaces.map(|(disparity, _)| *disparity).collect();
    let range = surfaces.iter().fold(None, |range: Option<[f64; 2]>, &disparity| {
        let disparity = f64::from(disparity);
        let [low, high] = range.unwrap_or([disparity; 2]);
        Some([low.min(disparity), high.max(disparity)])
    });
    let width = pose.size[0] as usize;
    Record {
        item,
        scene,
        eye: pose.eye.to_array(),
        forward: pose.forward.to_array().map(f64::from),
        up: pose.up.to_array().map(f64::from),
        interaxial: f64::from(pose.interaxial),
        tries: None,
        method: pair.statistics.method.to_string(),
        retraced_share: pair.statistics.retraced_share(),
        disparity: range,
        nearest_depth: Some(f64::from(nearest)).filter(|depth| depth.is_finite()),
        sky_percent: percent(depth.iter().filter(|depth| depth.is_infinite()).count()),
        hidden_percent: of(Occlusion::Hidden),
        out_of_frame_percent: of(Occlusion::OutOfFrame),
        disparity_percentiles: percentiles(surfaces),
        thin_percent: percent(thin_count(depth, width)),
        rejects: Vec::new(),
    }
}
