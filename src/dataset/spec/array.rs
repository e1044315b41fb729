//! Arrays of cameras: cameras beside and below each other, and the pairs of them that have ground truth.

use serde::Serialize;
use serde_json::Value;

use super::{
    Array, Eye, Output, Spec,
    fields::{Fields, fault, finite, list, shown, whole},
};
use crate::{Channel, Error, Maker};

/// Maximum number of cameras, which have two digits in names.
const MOST_CAMERAS: u32 = 64;

/// Cameras in rows and columns. Camera 0 is at the top left, and its right neighbour is camera 1.
#[derive(Clone, Debug, Serialize)]
pub(in crate::dataset) struct CameraArray {
    pub(super) columns: Places,
    pub(super) rows: Places,
    pairs: Pairs,
}

/// A number of places an interaxial apart, or positions in interaxials.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Places {
    Count(u32),
    At(Vec<f64>),
}

impl Places {
    fn count(&self) -> usize {
        match self {
            Self::Count(count) => *count as usize,
            Self::At(positions) => positions.len(),
        }
    }

    /// Returns the positions in interaxials from their middle.
    fn centered(&self) -> Vec<f64> {
        let all = match self {
            Self::Count(count) => (0..*count).map(f64::from).collect(),
            Self::At(positions) => positions.clone(),
        };
        let middle = all.first().zip(all.last()).map_or(0.0, |(first, last)| 0.5 * (first + last));
        all.into_iter().map(|position| position - middle).collect()
    }
}

/// Choice of pairs.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
enum Pairs {
    Kind(PairKind),
    List(Vec<[u32; 2]>),
}

/// A choice of pairs by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum PairKind {
    /// Cameras next to each other.
    Neighbours,
    /// The first camera of each row or column, and each other camera there.
    First,
    /// All cameras of each row and of each column.
    All,
}

impl PairKind {
    const ALL: [(&'static str, Self); 3] =
        [("neighbours", Self::Neighbours), ("first", Self::First), ("all", Self::All)];

    fn holds(self, one: usize, other: usize) -> bool {
        match self {
            Self::Neighbours => other == one + 1,
            Self::First => one == 0,
            Self::All => true,
        }
    }
}

impl CameraArray {
    /// Returns the number of cameras in a row.
    fn width(&self) -> usize {
        self.columns.count()
    }

    /// Returns the number of cameras.
    pub(in crate::dataset) fn count(&self) -> usize {
        self.width() * self.rows.count()
    }

    /// Returns a camera's row and column.
    pub(in crate::dataset) fn place(&self, camera: usize) -> [usize; 2] {
        [camera / self.width(), camera % self.width()]
    }

    /// Returns the offsets of a row's cameras to the right of the middle, in interaxials.
    pub(in crate::dataset) fn offsets(&self) -> Vec<f32> {
        self.columns.centered().into_iter().map(|offset| offset as f32).collect()
    }

    /// Returns the heights of the rows above the middle, in interaxials.
    pub(in crate::dataset) fn heights(&self) -> Vec<f64> {
        self.rows.centered().into_iter().map(|below| -below).collect()
    }

    /// Returns the distance from the middle to the farthest camera, in interaxials.
    pub(in crate::dataset) fn radius(&self) -> f64 {
        let half = |places: &Places| places.centered().last().copied().unwrap_or(0.0);
        half(&self.columns).hypot(half(&self.rows))
    }

    /// Returns the pairs: each a left and a right camera of a row, or an upper and a lower one of a column.
    pub(in crate::dataset) fn pairs(&self) -> Vec<[usize; 2]> {
        let kind = match &self.pairs {
            Pairs::List(pairs) => return pairs.iter().map(|pair| pair.map(|camera| camera as usize)).collect(),
            Pairs::Kind(kind) => kind,
        };
        let all = (0..self.count()).flat_map(|one| (one + 1..self.count()).map(move |other| [one, other]));
        let is_chosen = |pair: &[usize; 2]| {
            let [[row, column], [other_row, other_column]] = pair.map(|camera| self.place(camera));
            (row == other_row && kind.holds(column, other_column))
                || (column == other_column && kind.holds(row, other_row))
        };
        all.filter(is_chosen).collect()
    }
}

pub(super) fn array(value: &Value, at: &str) -> Result<CameraArray, Error> {
    let fields = Fields::of(value, at)?;
    let columns = fields.get("columns", places)?;
    let found = CameraArray {
        columns: fields.needed("columns", columns)?,
        rows: fields.get("rows", places)?.unwrap_or(Places::Count(1)),
        pairs: fields.get("pairs", pairs)?.unwrap_or(Pairs::Kind(PairKind::Neighbours)),
    };
    fields.end()?;
    let count = found.count();
    if !(2..=MOST_CAMERAS as usize).contains(&count) {
        return fault(at, format!("it has {count} cameras; 2 to {MOST_CAMERAS} are possible"));
    }
    let pairs = found.pairs();
    for (index, pair) in pairs.iter().enumerate() {
        let at = format!("{at}.pairs[{index}]");
        if let Some(camera) = pair.iter().find(|camera| **camera >= count) {
            return fault(&at, format!("there is no camera {camera}; there are {count}, from 0"));
        }
        let [[row, column], [other_row, other_column]] = pair.map(|camera| found.place(camera));
        if pair[0] >= pair[1] || (row != other_row && column != other_column) {
            let reason = "it must be a camera and another one farther right in its row, or farther down in its column";
            return fault(&at, format!("{pair:?}: {reason}"));
        }
        if pairs[..index].contains(pair) {
            return fault(&at, format!("{pair:?} is there twice"));
        }
    }
    match (0..count).find(|camera| !pairs.iter().flatten().any(|of_pair| of_pair == camera)) {
        Some(camera) => fault(&fields.path("pairs"), format!("camera {camera} is in no pair")),
        None => Ok(found),
    }
}

/// Reads a number of places, or their positions.
fn places(value: &Value, at: &str) -> Result<Places, Error> {
    let Value::Array(_) = value else { return whole(1, MOST_CAMERAS)(value, at).map(Places::Count) };
    let positions = list(finite)(value, at)?;
    match !positions.is_empty() && positions.windows(2).all(|two| two[0] < two[1]) {
        true => Ok(Places::At(positions)),
        false => fault(at, format!("{} must be positions in ascending order", shown(value))),
    }
}

fn pairs(value: &Value, at: &str) -> Result<Pairs, Error> {
    let named = || PairKind::ALL.into_iter().find(|(name, _)| value.as_str() == Some(name));
    match (value, named()) {
        (_, Some((_, kind))) => Ok(Pairs::Kind(kind)),
        (Value::Array(_), _) => list(super::fields::array(whole(0, MOST_CAMERAS)))(value, at).map(Pairs::List),
        _ => fault(at, format!("unknown {}; use neighbours, first, all, or a list of pairs", shown(value))),
    }
}

impl Output {
    /// Returns whether it depends on both cameras of a pair. Other outputs belong to one camera.
    fn is_of_pair(self) -> bool {
        self.is_layer() || matches!(self, Self::Channel(Channel::Disparity | Channel::Occlusion))
    }
}

/// Returns the views and outputs of the arrays of an item with these cameras.
pub(super) fn files_of(cameras: &CameraArray, arrays: &[Array]) -> Vec<(String, Output)> {
    let (pairs, left) = (cameras.pairs(), |array: &&Array| array.eye == Eye::Left);
    let of_cameras = arrays.iter().filter(|array| !array.output.is_of_pair()).filter(left);
    let of_cameras = of_cameras
        .flat_map(|array| (0..cameras.count()).map(move |camera| (format!("camera{camera:02}"), array.output)));
    let of_pairs = arrays.iter().filter(|array| array.output.is_of_pair()).flat_map(|array| {
        pairs.iter().map(move |[one, other]| (format!("pair{one:02}-{other:02}.{}", array.view()), array.output))
    });
    of_cameras.chain(of_pairs).collect()
}

/// Refuses an array of cameras with values that need a single pair.
pub(super) fn check_together(spec: &Spec) -> Result<(), Error> {
    if spec.rig.array.is_none() {
        return Ok(());
    }
    let rig = [("lens", spec.rig.lens.is_some()), ("projection", spec.rig.around.is_some())]
        .iter()
        .find(|(_, is)| *is)
        .copied();
    if let Some((key, _)) = rig {
        return fault(&format!("rig.{key}"), "an array has planar cameras without lenses: leave it out");
    }
    if let Some(layout) = spec.format.layout() {
        return fault("format", format!("{layout} holds two cameras: use webdataset or parquet for an array"));
    }
    if spec.motion.is_some() {
        return fault("motion", "items with an array of cameras have no next pair");
    }
    for array in &spec.arrays {
        let is_of_other_view = array.output.channel().is_some_and(|channel| channel.maker() == Maker::OtherView);
        if array.output.is_match() || is_of_other_view {
            return fault("outputs", format!("{}: an array of cameras does not have it", array.output.name()));
        }
        if !array.output.is_of_pair() && !spec.arrays.contains(&Array { eye: Eye::Left, ..*array }) {
            return fault("outputs", format!("{}: leave out the eye, since each camera has it", array.output.name()));
        }
    }
    Ok(())
}
