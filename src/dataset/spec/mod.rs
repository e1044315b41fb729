//! The spec of a data set: scenes, poses, rig, random values and outputs. docs/DATA-SETS.md lists its keys.

mod array;
mod fields;
mod lens;
mod projector;
mod read;

use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};
use serde_json::{Map, Value};

pub(super) use self::{array::CameraArray, lens::LensEntry, projector::ProjectorEntry};
use super::{
    Layout,
    draws::{Drawn, Draws},
};
use crate::{Builtin, CameraPath, Channel, Equirectangular, Error, Layering, Options, PoleMerge, Span};

/// Number of a pair's attempts at one scene, if other pairs share the scene.
const ATTEMPTS_OF_SCENE: u32 = 5;

/// The checked spec of a data set.
///
/// ```
/// use stereotrace::dataset::Spec;
///
/// let spec = Spec::from_json(r#"{"pairs": 100, "scenes": [{"builtin": "hall"}], "seed": 7}"#, ".")?;
/// assert_eq!((spec.pairs(), spec.seed()), (100, 7));
/// let wrong = Spec::from_json(r#"{"pairs": 0, "scenes": [{"builtin": "hall"}]}"#, ".").unwrap_err();
/// assert!(wrong.to_string().starts_with("pairs: 0 must be a whole number"));
/// # Ok::<(), stereotrace::Error>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct Spec {
    pub(super) name: String,
    pub(super) seed: u32,
    pub(super) pairs: u32,
    pub(super) shard_pairs: u32,
    /// Number of consecutive pairs of one scene.
    pub(super) scene_pairs: u32,
    pub(super) format: Format,
    pub(super) size: Size,
    pub(super) scenes: Vec<SceneEntry>,
    pub(super) poses: Poses,
    pub(super) rig: Rig,
    pub(super) randomise: Randomise,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) motion: Option<Motion>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) layers: Option<LayersEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) sensor: Option<SensorEntry>,
    /// Options of rendering as given.
    pub(super) render: Map<String, Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) outputs: Option<Vec<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) compress: Option<bool>,
    /// Folder that paths of files are relative to. It is not part of the data set's identity.
    #[serde(skip)]
    pub(super) folder: PathBuf,
    /// Options of rendering. Drawn ones have one of their values.
    #[serde(skip)]
    pub(super) options: Options,
    /// Names and distributions of drawn options.
    #[serde(skip)]
    drawn_options: Vec<(String, DrawnOption)>,
    /// Output arrays of the eyes, in the order of files.
    #[serde(skip)]
    arrays: Vec<Array>,
}

/// Width and height of the pictures: one size, or several to choose from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(super) enum Size {
    One([u32; 2]),
    Several { choice: Vec<[u32; 2]> },
}

impl Size {
    pub(super) fn all(&self) -> &[[u32; 2]] {
        match self {
            Self::One(size) => std::slice::from_ref(size),
            Self::Several { choice } => choice,
        }
    }

    pub(super) fn draw(&self, draws: &Draws) -> [u32; 2] {
        match self {
            Self::One(size) => *size,
            Self::Several { choice } => choice[draws.index(choice.len(), "size")],
        }
    }
}

/// Distribution of an option of rendering.
#[derive(Clone, Debug)]
enum DrawnOption {
    Choice(Vec<String>),
    Number(Drawn<f64>),
    Whole(Drawn<u32>),
}

impl DrawnOption {
    /// Returns the texts of its choices, or of its least and its largest value.
    fn ends(&self) -> Vec<String> {
        match self {
            Self::Choice(choices) => choices.clone(),
            Self::Number(drawn) => Vec::from_iter(drawn.ends().iter().map(f64::to_string)),
            Self::Whole(drawn) => Vec::from_iter(drawn.ends().iter().map(u32::to_string)),
        }
    }

    fn draw(&self, draws: &Draws, name: &str) -> String {
        match self {
            Self::Choice(choices) => choices[draws.index(choices.len(), name)].clone(),
            Self::Number(drawn) => draws.draw(drawn, name).to_string(),
            Self::Whole(drawn) => draws.draw(drawn, name).to_string(),
        }
    }
}

/// An output array of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Array {
    /// Whether it belongs to the item's next pair ([`NextPair`](super::NextPair)).
    pub next: bool,
    /// The eye.
    pub eye: Eye,
    /// Its content.
    pub output: Output,
}

impl Array {
    /// Returns the name of its view: `left`, `right`, `next.left` or `next.right`.
    pub fn view(self) -> &'static str {
        match (self.next, self.eye) {
            (false, eye) => eye.name(),
            (true, Eye::Left) => "next.left",
            (true, Eye::Right) => "next.right",
        }
    }
}

/// Content of an output array.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Output {
    /// An output of rendering or of ground truth.
    Channel(Channel),
    /// Optical flow to the item's other pair ([`EyeFlow::flow`](crate::EyeFlow::flow)).
    Flow,
    /// Visibility of the points in the other pair, as a number of [`FlowClass`](crate::FlowClass).
    FlowVisibility,
    /// Change of disparity to the other pair ([`EyeFlow::disparity_change`](crate::EyeFlow::disparity_change)).
    DisparityChange,
    /// Scene flow to the other pair ([`EyeFlow::displacement`](crate::EyeFlow::displacement)).
    SceneFlow,
    /// A list of all surfaces along the lines of sight ([`EyeLayers`](crate::EyeLayers)).
    Layer(LayerOutput),
    /// Places of the points in the other eye's picture ([`EyeMatches::place`](crate::EyeMatches::place)).
    Match,
    /// Visibility of the points from the other eye, as a number of [`MatchClass`](crate::MatchClass).
    MatchVisibility,
}

/// A list of [`EyeLayers`](crate::EyeLayers).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LayerOutput {
    /// Number of surfaces of each pixel.
    Count,
    /// Depths.
    Depth,
    /// Lengths of the lines.
    Distance,
    /// Disparities.
    Disparity,
    /// Differences of rows.
    VerticalDisparity,
    /// Whether the other eye sees the points, as a number of [`LayerClass`](crate::LayerClass).
    Visibility,
    /// Numbers of reflections and refractions.
    Bends,
    /// Positions.
    Position,
    /// Shading normals.
    Normal,
    /// Ids of objects.
    Object,
    /// Ids of materials.
    Material,
}

impl LayerOutput {
    const ALL: [Self; 11] = [
        Self::Count,
        Self::Depth,
        Self::Distance,
        Self::Disparity,
        Self::VerticalDisparity,
        Self::Visibility,
        Self::Bends,
        Self::Position,
        Self::Normal,
        Self::Object,
        Self::Material,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Count => "layer_count",
            Self::Depth => "layer_depth",
            Self::Distance => "layer_distance",
            Self::Disparity => "layer_disparity",
            Self::VerticalDisparity => "layer_vertical_disparity",
            Self::Visibility => "layer_visibility",
            Self::Bends => "layer_bends",
            Self::Position => "layer_position",
            Self::Normal => "layer_normal",
            Self::Object => "layer_object",
            Self::Material => "layer_material",
        }
    }
}

impl Output {
    const MOTION: [Self; 4] = [Self::Flow, Self::FlowVisibility, Self::DisparityChange, Self::SceneFlow];

    /// Returns the name in specs and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Channel(channel) => channel.name(),
            Self::Flow => "flow",
            Self::FlowVisibility => "flow_visibility",
            Self::DisparityChange => "disparity_change",
            Self::SceneFlow => "scene_flow",
            Self::Layer(layer) => layer.name(),
            Self::Match => "match",
            Self::MatchVisibility => "match_visibility",
        }
    }

    /// Returns the outputs that are no channels.
    fn not_channels() -> impl Iterator<Item = Self> {
        let matches = [Self::Match, Self::MatchVisibility];
        Self::MOTION.into_iter().chain(LayerOutput::ALL.map(Self::Layer)).chain(matches)
    }

    fn named(name: &str) -> Option<Self> {
        Self::not_channels().find(|output| output.name() == name).or_else(|| Some(Self::Channel(name.parse().ok()?)))
    }

    /// Returns the channel, or `None` for motion, layers and matches.
    pub(super) fn channel(self) -> Option<Channel> {
        match self {
            Self::Channel(channel) => Some(channel),
            _ => None,
        }
    }

    pub(super) fn is_motion(self) -> bool {
        Self::MOTION.contains(&self)
    }

    pub(super) fn is_match(self) -> bool {
        matches!(self, Self::Match | Self::MatchVisibility)
    }

    pub(super) fn is_layer(self) -> bool {
        matches!(self, Self::Layer(_))
    }
}

/// Noise of the eyes' sensors.
#[derive(Clone, Debug, Serialize)]
pub(super) struct SensorEntry {
    /// Electrons of a pixel's channel at linear light 1 after exposure. More electrons are clipped.
    pub(super) full_well: Drawn<f64>,
    /// Standard deviation of the read noise in electrons.
    pub(super) read_noise: Drawn<f64>,
}

/// How lines of sight meet the surfaces of layers.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct LayersEntry {
    pub(super) surfaces: u32,
    pub(super) refracted: bool,
    pub(super) mirrored: bool,
}

impl LayersEntry {
    pub(super) fn layering(self) -> Layering {
        Layering::new(self.surfaces).refracted(self.refracted).mirrored(self.mirrored)
    }
}

/// Motion of an item to its next pair.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Motion {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) animation: Option<String>,
    /// Time of the first pair in seconds; by default anywhere in the animation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) time: Option<Drawn<f64>>,
    /// Seconds from a pair to the next one.
    pub(super) step: Drawn<f64>,
    pub(super) camera: CameraMotion,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) objects: Option<ObjectMotion>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) shutter: Option<Shutter>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) rolling: Option<RollingShutter>,
}

/// Rows that are exposed one band after the other.
#[derive(Clone, Debug, Serialize)]
pub(super) struct RollingShutter {
    /// Share of the time to the next pair, from the top row's exposure to the bottom row's.
    pub(super) readout: Drawn<f64>,
    /// Number of bands of rows.
    pub(super) bands: u32,
}

/// Motion blur of both pairs.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Shutter {
    /// Share of the time to the next pair for which the shutter is open.
    pub(super) open: Drawn<f64>,
    /// Number of pictures within this time.
    pub(super) times: u32,
}

/// Motion of a camera in its own frame: world units and degrees.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct CameraMotion {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) right: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) up: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) forward: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) turn: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) rise: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) roll: Option<Drawn<f64>>,
}

impl CameraMotion {
    pub(super) fn is_given(&self) -> bool {
        let Self { right, up, forward, turn, rise, roll } = self;
        [right, up, forward, turn, rise, roll].into_iter().any(Option::is_some)
    }
}

/// Motion of single objects.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ObjectMotion {
    /// Share of the objects that move.
    pub(super) share: f64,
    /// Distance in world units.
    pub(super) distance: Drawn<f64>,
    /// Angle in degrees.
    pub(super) turn: Drawn<f64>,
}

/// Eye of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Eye {
    /// The left eye.
    Left,
    /// The right eye.
    Right,
}

impl Eye {
    const ALL: [Self; 2] = [Self::Left, Self::Right];

    /// Returns the name in outputs and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// Format of shards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    WebDataset,
    Parquet,
    Layout(Layout),
}

impl Format {
    fn all() -> Vec<(&'static str, Self)> {
        let layouts = Layout::ALL.iter().map(|&layout| Self::Layout(layout));
        [Self::WebDataset, Self::Parquet].into_iter().chain(layouts).map(|format| (format.name(), format)).collect()
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::WebDataset => "webdataset",
            Self::Parquet => "parquet",
            Self::Layout(layout) => layout.name(),
        }
    }

    pub(super) fn layout(self) -> Option<Layout> {
        match self {
            Self::Layout(layout) => Some(layout),
            Self::WebDataset | Self::Parquet => None,
        }
    }
}

impl Serialize for Format {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// A scene of a spec.
#[derive(Clone, Debug, Serialize)]
pub(super) struct SceneEntry {
    #[serde(flatten)]
    pub(super) source: Source,
    pub(super) weight: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) camera: Option<CameraEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) lights: Option<Lights>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) ambient: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) sky: Option<SkyEntry>,
    /// Limits of pictures; by default for generated scenes only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) checks: Option<ChecksEntry>,
}

impl SceneEntry {
    /// Returns the limits of pictures, or `None` if all pictures are kept.
    pub(super) fn limits(&self) -> Option<&Checks> {
        match &self.checks {
            Some(ChecksEntry::On(checks)) => Some(checks),
            Some(ChecksEntry::Off(_)) | None => None,
        }
    }
}

/// Limits of pictures, or false.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
pub(super) enum ChecksEntry {
    On(Checks),
    Off(bool),
}

/// Limits of pictures: largest shares of the left view, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Checks {
    pub(super) max_sky: f64,
    /// Share of black pixels.
    pub(super) max_dark: f64,
    /// Share of white pixels.
    pub(super) max_bright: f64,
    /// Share of one object's pixels that look like their neighbours.
    pub(super) max_plain: f64,
    /// Share of surfaces nearer than four times the interaxial.
    pub(super) max_near: f64,
    /// Number of further attempts after a rejected one.
    pub(super) redraws: u32,
}

impl Default for Checks {
    fn default() -> Self {
        Self { max_sky: 0.8, max_dark: 0.5, max_bright: 0.35, max_plain: 0.6, max_near: 0.5, redraws: 20 }
    }
}

/// Where a scene comes from.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Source {
    Builtin {
        #[serde(serialize_with = "by_name")]
        builtin: Builtin,
    },
    File {
        file: String,
        #[serde(skip_serializing_if = "Option::is_none")]
        crease_angle: Option<f64>,
        #[serde(skip_serializing_if = "Option::is_none")]
        missing_textures: Option<&'static str>,
        #[serde(skip_serializing_if = "Option::is_none")]
        outside_files: Option<&'static str>,
        #[serde(skip_serializing_if = "Option::is_none")]
        origin: Option<OriginEntry>,
    },
    Generate {
        generate: Box<Generate>,
    },
}

/// A kind of generated scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum SceneKind {
    Rooms,
    Floating,
    Outdoors,
}

impl SceneKind {
    const ALL: [Self; 3] = [Self::Rooms, Self::Floating, Self::Outdoors];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Rooms => "rooms",
            Self::Floating => "floating",
            Self::Outdoors => "outdoors",
        }
    }
}

/// Scenes that are generated, a new one for each item.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Generate {
    pub(super) kind: SceneKind,
    /// Folders of pictures, skies and meshes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) textures: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) skies: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) meshes: Option<String>,
    /// Length of a mesh's longest side in metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mesh_size: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) objects: Option<Drawn<u32>>,
    /// Shares of objects of special materials, 0 to 1.
    pub(super) metals: Drawn<f64>,
    pub(super) glass: Drawn<f64>,
    pub(super) mirrors: Drawn<f64>,
    /// Share of surfaces that have one colour in place of a pattern.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) plain: Option<Drawn<f64>>,
}

fn by_name<S: Serializer>(builtin: &Builtin, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(builtin.name())
}

#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
pub(super) enum OriginEntry {
    Named(&'static str),
    At([f64; 3]),
}

/// Camera of a scene: one of its file, or a given one.
#[derive(Clone, Debug, Serialize)]
pub(super) struct CameraEntry {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) eye: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) target: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) up: Option<[f64; 3]>,
}

/// Lights of a scene: a number of placed ones, or given ones.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Lights {
    Placed(u32),
    Given(Vec<LightEntry>),
}

#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct LightEntry {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) position: Option<[f64; 3]>,
    /// Direction to a light at infinity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) towards: Option<[f64; 3]>,
    pub(super) intensity: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) radius: Option<f64>,
}

#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(super) enum SkyEntry {
    Color([f64; 3]),
    /// A picture's file, or `procedural`.
    Named(String),
}

/// Poses of cameras.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub(super) enum Poses {
    Free {
        #[serde(skip_serializing_if = "Option::is_none")]
        clearance: Option<Drawn<f64>>,
        #[serde(skip_serializing_if = "Option::is_none")]
        max_disparity: Option<f64>,
        #[serde(skip_serializing_if = "Option::is_none")]
        min_surfaces: Option<f64>,
    },
    /// Angles in degrees about the camera's target, and a factor of its distance.
    Orbit {
        turn: Drawn<f64>,
        rise: Drawn<f64>,
        distance: Drawn<f64>,
    },
    Fixed,
    /// Cameras of a file: item i has the camera of frame i.
    Path {
        file: String,
        /// Its content; `None` until it is read.
        #[serde(skip)]
        path: Option<CameraPath>,
    },
}

impl Poses {
    /// Returns the cameras of a path.
    pub(super) fn path(&self) -> Option<&CameraPath> {
        match self {
            Self::Path { path, .. } => path.as_ref(),
            Self::Free { .. } | Self::Orbit { .. } | Self::Fixed => None,
        }
    }
}

/// Fields of the camera that replace those of the scene's.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Rig {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) interaxial: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) interaxial_px: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) baseline: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) screen_distance: Option<Drawn<Distance>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) fov: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) fx: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) fy: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) cx: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) cy: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) lens: Option<LensEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) array: Option<CameraArray>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) projector: Option<ProjectorEntry>,
    #[serde(flatten)]
    pub(super) around: Option<AroundEntry>,
}

/// Projection of equirectangular pictures.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct AroundEntry {
    #[serde(serialize_with = "in_degrees")]
    pub(super) projection: Span,
    pub(super) pole_merge: MergeEntry,
}

fn in_degrees<S: Serializer>(span: &Span, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u32(span.degrees() as u32)
}

/// Elevations in degrees between which the eyes approach each other, or false.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
pub(super) enum MergeEntry {
    Angles([f64; 2]),
    Off(bool),
}

impl AroundEntry {
    pub(super) fn projection(self) -> Equirectangular {
        let merge = match self.pole_merge {
            MergeEntry::Angles([from, to]) => Some(PoleMerge { from: from as f32, to: to as f32 }),
            MergeEntry::Off(_) => None,
        };
        Equirectangular { span: self.projection, merge }
    }
}

/// A length, or infinity, which is written as `"inf"`, since JSON has no infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Distance(pub(super) f64);

impl Serialize for Distance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_infinite() { serializer.serialize_str("inf") } else { serializer.serialize_f64(self.0) }
    }
}

#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Randomise {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) lights: Option<RandomLights>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) materials: Option<RandomMaterials>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) ambient: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) exposure: Option<Drawn<f64>>,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct RandomLights {
    pub(super) count: Drawn<u32>,
    /// Total strength of the lights.
    pub(super) strength: Drawn<f64>,
    pub(super) tint: Drawn<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) radius: Option<Drawn<f64>>,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct RandomMaterials {
    /// Share of the materials that change.
    pub(super) share: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) albedo: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) tint: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) specular: Option<Drawn<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) exponent: Option<Drawn<f64>>,
}

impl Spec {
    /// Reads a spec from JSON text and fills in defaults. Paths of scene files are relative to `folder`.
    ///
    /// # Errors
    /// [`Error::Spec`], which names the key, for text that is no JSON, unknown keys and invalid values.
    pub fn from_json(text: &str, folder: impl Into<PathBuf>) -> Result<Self, Error> {
        read::spec(text, folder.into())
    }

    /// Returns the spec with its defaults as JSON text, which [`Spec::from_json`] reads.
    pub fn to_json(&self) -> String {
        // Fails only for maps with keys that are no text, of which there are none.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Returns the number of pairs.
    pub fn pairs(&self) -> u32 {
        self.pairs
    }

    /// Returns the seed of all random values.
    pub fn seed(&self) -> u32 {
        self.seed
    }

    /// Returns the output arrays of the eyes, in the order of files. A layout has color, disparity and occlusion.
    pub fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    /// Returns the names of the views and outputs of an item's arrays, in the order of files: views `left`, `right`,
    /// `next.left` and `next.right`. With an array of cameras, views are `camera00` and so on, and `pair00-01.left` for
    /// what depends on both cameras of a pair.
    pub fn files(&self) -> Vec<(String, Output)> {
        match &self.rig.array {
            Some(cameras) => array::files_of(cameras, &self.arrays),
            None => self.arrays.iter().map(|array| (array.view().to_owned(), array.output)).collect(),
        }
    }

    /// Returns the draws of a pair's scene, which are those of the first of its [`Spec::scene_pairs`].
    pub(super) fn scene_draws(&self, draws: &Draws) -> Draws {
        match self.scene_pairs {
            1 => *draws,
            pairs => {
                let Draws { seed, item, attempt } = *draws;
                Draws { seed, item: item - item % pairs, attempt: attempt - attempt % ATTEMPTS_OF_SCENE }
            }
        }
    }

    /// Returns the motion and the rolling shutter.
    pub(super) fn rolling(&self) -> Option<(&Motion, &RollingShutter)> {
        let motion = self.motion.as_ref()?;
        motion.rolling.as_ref().map(|rolling| (motion, rolling))
    }

    /// Returns whether items have a next pair.
    pub(super) fn has_next(&self) -> bool {
        self.motion.is_some() && self.rolling().is_none()
    }

    /// Returns a pair's options of rendering.
    pub(super) fn options_of(&self, draws: &Draws) -> Result<Options, Error> {
        self.drawn_options.iter().try_fold(self.options.clone(), |options, (name, drawn)| {
            options.set(name, &drawn.draw(draws, &format!("render.{name}")))
        })
    }

    /// Returns whether arrays of the first or the next pair are layers.
    pub(super) fn needs_layers(&self, next: bool) -> bool {
        self.arrays.iter().any(|array| array.next == next && array.output.is_layer())
    }

    /// Returns whether arrays of the first or the next pair are matches.
    pub(super) fn needs_matches(&self, next: bool) -> bool {
        self.arrays.iter().any(|array| array.next == next && array.output.is_match())
    }

    /// Returns a scene's name in records.
    pub(super) fn scene_name(&self, scene: usize) -> String {
        match &self.scenes[scene].source {
            Source::Builtin { builtin } => format!("builtin:{}", builtin.name()),
            Source::File { file, .. } => file.clone(),
            Source::Generate { generate } => format!("generate:{}", generate.kind.name()),
        }
    }

    /// Returns the options of a generated scene, or `None` for another scene.
    pub(super) fn generator(&self, scene: usize) -> Option<&Generate> {
        match &self.scenes.get(scene)?.source {
            Source::Generate { generate } => Some(generate),
            Source::Builtin { .. } | Source::File { .. } => None,
        }
    }

    pub(super) fn path_of(&self, file: impl AsRef<Path>) -> PathBuf {
        self.folder.join(file)
    }
}

#[cfg(test)]
mod tests;
