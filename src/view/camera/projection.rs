//! Projections: how the rays of a picture leave the eyes.

use super::{Lens, ranges::fault};
use crate::Error;

/// How the rays of a picture leave the two eyes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Projection {
    /// Both eyes look along one direction, through one screen rectangle. If the screen is at infinity they are parallel
    /// cameras. Rows of the pictures are epipolar lines: no point has vertical parallax.
    #[default]
    OffAxis,
    /// The eyes turn towards each other, so that their axes meet at the screen's distance, as on a toe-in rig. Points
    /// then have vertical parallax of up to [`Comfort::vertical_parallax_px`](crate::Comfort::vertical_parallax_px).
    /// Rows are not epipolar lines, so no samples can be reused. [`Method::Naive`](crate::Method::Naive) renders the
    /// pair even if another method is set, and a warning is logged.
    ToeIn,
    /// Pictures of all directions, or of half of them, for headsets.
    Equirectangular(Equirectangular),
    /// Parallel eyes, each with a lens of its own: the left one's, then the right one's
    /// ([`StereoCamera::lenses`](crate::StereoCamera::lenses)). Rows are not epipolar lines.
    Lenses([Lens; 2]),
}

/// Omnidirectional stereo: columns of a picture are azimuths, and rows are elevations. Each eye's rays are tangents of
/// a horizontal circle whose diameter is the interaxial (Ishiguro 1992; Peleg & Ben-Ezra 1999). The columns of one eye
/// touch it turning one way, those of the other eye turning the other way. So in all directions the eyes are an
/// interaxial apart. Rows of the pictures are epipolar lines.
///
/// The circle's axis is the camera's `up`. Its centre is the camera's eye, and the picture's middle shows the target's
/// azimuth. A pixel's depth is the horizontal distance `s` along its ray. The point lies `s / cos(elevation)` along
/// the ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equirectangular {
    /// Range of azimuths.
    pub span: Span,
    /// Range of elevations over which the eyes approach each other, or `None` for eyes that are an interaxial apart
    /// everywhere. Straight up and down, no rotation of the head would fit them.
    pub merge: Option<PoleMerge>,
}

/// Range of azimuths of an equirectangular picture. All elevations are in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Span {
    /// 360 degrees. The picture's left and right borders meet behind the camera.
    Full,
    /// 180 degrees, before the camera.
    Half,
}

/// Merging of the eyes towards the poles: the interaxial is multiplied by `cos(90° (p - from) / (to - from))` at
/// elevations `p` between `from` and `to`, and by 0 beyond, above and below the horizon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoleMerge {
    /// Elevation in degrees from which on the eyes approach each other.
    pub from: f32,
    /// Elevation in degrees from which on both eyes are at the circle's centre.
    pub to: f32,
}

/// Merges between 60 and 75 degrees.
impl Default for PoleMerge {
    fn default() -> Self {
        Self { from: 60.0, to: 75.0 }
    }
}

impl PoleMerge {
    /// Returns whether the elevations are in order, from the horizon to the pole.
    pub(crate) fn is_valid(self) -> bool {
        0.0 <= self.from && self.from < self.to && self.to <= 90.0
    }
}

impl Projection {
    /// Returns the settings of equirectangular pictures, or `None` for planar ones.
    pub fn equirectangular(self) -> Option<Equirectangular> {
        match self {
            Self::OffAxis | Self::ToeIn | Self::Lenses(_) => None,
            Self::Equirectangular(equirectangular) => Some(equirectangular),
        }
    }

    /// Returns what eyes are called whose rows are not epipolar lines, or `None` for other eyes.
    pub(crate) fn without_rows(self) -> Option<&'static str> {
        match self {
            Self::OffAxis | Self::Equirectangular(_) => None,
            Self::ToeIn => Some("toed-in eyes"),
            Self::Lenses(_) => Some("eyes with lenses"),
        }
    }
}

impl Span {
    /// Returns the span of 360 or of 180 degrees, or `None` for another number.
    pub fn from_degrees(degrees: f64) -> Option<Self> {
        match degrees {
            360.0 => Some(Self::Full),
            180.0 => Some(Self::Half),
            _ => None,
        }
    }

    /// Returns the range of azimuths in degrees.
    pub fn degrees(self) -> f64 {
        self.radians().to_degrees()
    }

    /// Returns what is wrong with the size of a picture in pixels, or `None` if it has as many degrees per column as
    /// per row, as players expect.
    pub fn shape_fault(self, [width, height]: [u32; 2]) -> Option<String> {
        let (expected, shape) = match self {
            Self::Full => (2 * u64::from(height), "twice the height"),
            Self::Half => (u64::from(height), "the height"),
        };
        let fault = || format!("the width of a picture of {} degrees must be {shape}", self.degrees());
        (u64::from(width) != expected).then(fault)
    }

    /// Returns the range of azimuths in radians.
    pub(crate) fn radians(self) -> f64 {
        match self {
            Self::Full => std::f64::consts::TAU,
            Self::Half => std::f64::consts::PI,
        }
    }
}

impl Equirectangular {
    /// Makes the projection with the default merge at the poles.
    pub fn new(span: Span) -> Self {
        Self { span, merge: Some(PoleMerge::default()) }
    }

    /// Checks the angles of the merge.
    pub(super) fn check(self) -> Result<(), Error> {
        let Some(merge) = self.merge else { return Ok(()) };
        if merge.is_valid() {
            return Ok(());
        }
        let PoleMerge { from, to } = merge;
        let reason = "the first must be at least 0, the second larger, and at most 90";
        fault("pole merge", format!("{from} to {to} degrees"), reason)
    }
}

/// The JSON of a projection: `"off-axis"`, `"toe-in"`, an object with `span_deg` (360 or 180) and `pole_merge_deg` (two
/// elevations, or null), or an object with `lenses` (the left and the right one).
#[cfg(feature = "json")]
mod json {
    use serde_json::{Value, json};

    use super::{Equirectangular, Lens, PoleMerge, Projection, Span};

    impl Projection {
        pub(crate) fn to_value(self) -> Value {
            match self {
                Self::OffAxis => json!("off-axis"),
                Self::ToeIn => json!("toe-in"),
                Self::Lenses(lenses) => json!({ "lenses": lenses.map(Lens::to_value) }),
                Self::Equirectangular(Equirectangular { span, merge }) => json!({
                    "span_deg": span.degrees(),
                    "pole_merge_deg": merge.map(|merge| [merge.from, merge.to].map(f64::from)),
                }),
            }
        }

        pub(crate) fn from_value(value: &Value) -> Result<Self, String> {
            let fault = |name: &str, value: &Value, rule: &str| Err(format!("{name} is {value}; it must be {rule}"));
            let Value::Object(fields) = value else {
                return match value.as_str() {
                    Some("off-axis") => Ok(Self::OffAxis),
                    Some("toe-in") => Ok(Self::ToeIn),
                    _ => fault("projection", value, "off-axis, toe-in, or an object with span_deg"),
                };
            };
            if let Some(lenses) = fields.get("lenses") {
                return match lenses.as_array().map(Vec::as_slice) {
                    Some([left, right]) => Ok(Self::Lenses([Lens::from_value(left)?, Lens::from_value(right)?])),
                    _ => fault("lenses", lenses, "a list of two lenses"),
                };
            }
            let span = fields.get("span_deg").unwrap_or(&Value::Null);
            let Some(span) = span.as_f64().and_then(Span::from_degrees) else {
                return fault("span_deg", span, "360 or 180");
            };
            let merge = match fields.get("pole_merge_deg") {
                None => Some(PoleMerge::default()),
                Some(Value::Null) => None,
                Some(value) => match value.as_array().map(|list| list.iter().map(Value::as_f64).collect::<Vec<_>>()) {
                    Some(list) if let [Some(from), Some(to)] = list[..] => {
                        Some(PoleMerge { from: from as f32, to: to as f32 })
                    }
                    _ => return fault("pole_merge_deg", value, "two angles, or null"),
                },
            };
            Ok(Self::Equirectangular(Equirectangular { span, merge }))
        }
    }
}
