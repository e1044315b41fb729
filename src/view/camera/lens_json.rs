//! The JSON of lenses: an object with `fx`, `fy` (`fx` if missing), `cx` and `cy`, and `radial_tangential` or
//! `fisheye`, the coefficients in `OpenCV`'s order.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::{Distortion, Lens};
use crate::Error;

/// Keys of a lens.
const KEYS: [&str; 6] = ["fx", "fy", "cx", "cy", "radial_tangential", "fisheye"];

impl Lens {
    /// Reads the lenses of the left and the right eye from JSON text: an object with one lens for both eyes, or with
    /// the lenses `left` and `right`. A lens is an object with these numbers (docs/FORMATS.md):
    ///
    /// - `fx`, `fy`, `cx` and `cy` in pixels, with pixel centres at halves; `fy` is `fx` if it is missing,
    /// - optionally `radial_tangential`, 4, 5 or 8 coefficients in `OpenCV`'s order, or `fisheye`, 4 coefficients.
    ///
    /// ```
    /// use stereotrace::Lens;
    ///
    /// let text = r#"{ "fx": 300, "cx": 320, "cy": 240, "radial_tangential": [-0.2, 0.03, 0.001, 0] }"#;
    /// let [left, right] = Lens::pair_from_json(text)?;
    /// assert_eq!((left.fy, left), (300.0, right));
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parse`], naming the key, if the text is not JSON or no lens.
    pub fn pair_from_json(text: &str) -> Result<[Self; 2], Error> {
        let fault = |reason| Error::parse(Path::new("lens JSON"), None, reason);
        let value = serde_json::from_str(text).map_err(|error| fault(format!("invalid JSON: {error}")))?;
        Self::pair_from_value(&value).map_err(fault)
    }

    /// Returns the lens as JSON text, which [`Lens::pair_from_json`] reads.
    pub fn to_json(&self) -> String {
        self.to_value().to_string()
    }

    pub(crate) fn pair_from_value(value: &Value) -> Result<[Self; 2], String> {
        match (value.get("left"), value.get("right")) {
            (None, None) => Self::from_value(value).map(|lens| [lens; 2]),
            (Some(left), Some(right)) => {
                let of = |name: &str, value| Self::from_value(value).map_err(|reason| format!("{name}: {reason}"));
                Ok([of("left", left)?, of("right", right)?])
            }
            _ => Err("left and right must be given together".into()),
        }
    }

    pub(crate) fn to_value(self) -> Value {
        let Self { fx, fy, cx, cy, distortion } = self;
        let name = if matches!(distortion, Distortion::Fisheye { .. }) { "fisheye" } else { "radial_tangential" };
        json!({ "fx": fx, "fy": fy, "cx": cx, "cy": cy, name: distortion.numbers() })
    }

    pub(crate) fn from_value(value: &Value) -> Result<Self, String> {
        let fields = value.as_object().ok_or_else(|| format!("a lens is {value}; it must be an object"))?;
        if let Some(key) = fields.keys().find(|key| !KEYS.contains(&key.as_str())) {
            return Err(format!("a lens has no '{key}'; its keys are {}", KEYS.join(", ")));
        }
        let fx = number(fields, "fx")?;
        let fy = if fields.contains_key("fy") { number(fields, "fy")? } else { fx };
        let lens = Self::new([fx, fy], [number(fields, "cx")?, number(fields, "cy")?]);
        let distortion = match (fields.get("radial_tangential"), fields.get("fisheye")) {
            (None, None) => Distortion::NONE,
            (Some(list), None) => {
                let found = Distortion::opencv(&numbers(list, "radial_tangential")?);
                found.map_err(|_| format!("radial_tangential is {list}; it must have 4, 5 or 8 coefficients"))?
            }
            (None, Some(list)) => {
                let found = numbers(list, "fisheye")?.try_into();
                Distortion::fisheye(found.map_err(|_| format!("fisheye is {list}; it must have 4 coefficients"))?)
            }
            (Some(_), Some(_)) => return Err("a lens is radial_tangential or fisheye, but both are given".into()),
        };
        Ok(lens.distortion(distortion))
    }
}

fn number(fields: &Map<String, Value>, name: &str) -> Result<f64, String> {
    let value = fields.get(name).ok_or_else(|| format!("{name} of a lens is missing"))?;
    value.as_f64().ok_or_else(|| format!("{name} of a lens is {value}; it must be a number"))
}

fn numbers(list: &Value, name: &str) -> Result<Vec<f64>, String> {
    let found = list.as_array().and_then(|list| list.iter().map(Value::as_f64).collect());
    found.ok_or_else(|| format!("{name} is {list}; it must be a list of numbers"))
}
