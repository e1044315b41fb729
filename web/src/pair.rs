//! Rendered pairs.

use js_sys::{Float32Array, Uint8Array, Uint32Array};
use serde::Serialize;
use stereotrace::{Statistics, StereoPair, Values, View, metrics, output::Anaglyph};
use wasm_bindgen::prelude::*;
use web_sys::ImageData;

use crate::{
    difference,
    errors::{raised, refused},
    values::{image, named, written},
};

/// A stereo pair: the left and the right view, how the right one was made, and its cost.
#[wasm_bindgen]
pub struct Pair(pub(crate) StereoPair);

#[wasm_bindgen]
impl Pair {
    /// Width of a view in pixels.
    #[wasm_bindgen(getter)]
    pub fn width(&self) -> u32 {
        self.0.left.width
    }

    /// Height of a view in pixels.
    #[wasm_bindgen(getter)]
    pub fn height(&self) -> u32 {
        self.0.left.height
    }

    /// Returns the view of an eye, `"left"` or `"right"`.
    #[wasm_bindgen(unchecked_return_type = "ImageData")]
    pub fn view(&self, #[wasm_bindgen(unchecked_param_type = "Eye")] eye: &str) -> Result<ImageData, JsValue> {
        image(&self.eye(eye)?.picture())
    }

    /// Returns the anaglyph for coloured glasses, mixed in linear light. The default is `"dubois"`, for red-cyan
    /// glasses.
    pub fn anaglyph(
        &self,
        #[wasm_bindgen(unchecked_optional_param_type = "AnaglyphName")] kind: Option<String>,
    ) -> Result<ImageData, JsValue> {
        let kind: Anaglyph = kind.map_or(Ok(Anaglyph::Dubois), |kind| named(&kind))?;
        image(&self.0.anaglyph(kind))
    }

    /// Returns both views packed into one picture, such as side by side.
    pub fn packed(
        &self,
        #[wasm_bindgen(unchecked_param_type = "PackingName")] packing: &str,
    ) -> Result<ImageData, JsValue> {
        image(&self.0.packed(named(packing)?))
    }

    /// Returns a picture of the sources of right pixels. Green pixels were reused from the left view. Red and yellow
    /// ones were traced because reuse failed, and grey ones were traced without reuse.
    #[wasm_bindgen(js_name = retraceMap)]
    pub fn retrace_map(&self) -> Result<ImageData, JsValue> {
        image(&self.0.retrace_picture())
    }

    /// Returns a picture of how right pixels got their shadows by a bracket method: green ones reused visibility bits,
    /// red ones traced shadow rays. Undefined for other methods.
    #[wasm_bindgen(js_name = shadowMap, unchecked_return_type = "ImageData | undefined")]
    pub fn shadow_map(&self) -> Result<JsValue, JsValue> {
        self.0.shadow_picture().map_or(Ok(JsValue::UNDEFINED), |picture| Ok(image(&picture)?.into()))
    }

    /// Returns the values of an output of an eye, by rows from the top. Ids are 4294967295 for sky.
    #[wasm_bindgen(unchecked_return_type = "Float32Array | Uint32Array | Uint8Array")]
    pub fn channel(
        &self,
        #[wasm_bindgen(unchecked_param_type = "Eye")] eye: &str,
        #[wasm_bindgen(unchecked_param_type = "ChannelName")] name: &str,
    ) -> Result<JsValue, JsValue> {
        self.eye(eye)?;
        let channels = if eye == "left" { self.0.left_channels(None) } else { self.0.right_channels(None) };
        Ok(match channels.get(named(name)?).map_err(raised)? {
            Values::Color(colors) => Uint8Array::from(colors.as_flattened()).into(),
            Values::Linear(colors) => Float32Array::from(colors.as_flattened()).into(),
            Values::Floats(values) => Float32Array::from(&*values).into(),
            Values::Vectors(vectors) => Float32Array::from(vectors.as_flattened()).into(),
            Values::Ids(values) | Values::Counts(values) => Uint32Array::from(values).into(),
            Values::Codes(codes) => Uint8Array::from(&*codes).into(),
            _ => return Err(refused(&format!("{name}: it has no array"))),
        })
    }

    /// Cost of the pair.
    #[wasm_bindgen(getter, unchecked_return_type = "Statistics")]
    pub fn statistics(&self) -> Result<JsValue, JsValue> {
        written(&Costs::of(&self.0.statistics))
    }

    /// Compares the right view with another pair's. With a pair of the same camera by `"naive"` this gives its errors.
    #[wasm_bindgen(unchecked_return_type = "Difference")]
    pub fn difference(&self, truth: &Self) -> Result<JsValue, JsValue> {
        let found = metrics::compare(&self.0.right, &truth.0.right, &self.0.pose).map_err(raised)?;
        written(&Differences {
            identical_percent: found.identical_percent,
            wrong_surface_percent: found.wrong_surface_percent,
            psnr: found.psnr,
            p999: found.p999,
            mean_difference: found.mean_difference,
            largest_parallax_error: found.largest_parallax_error_px,
        })
    }

    /// Returns the difference as a picture: dark grey where both are equal, yellow to red where they differ.
    #[wasm_bindgen(js_name = differenceMap)]
    pub fn difference_map(&self, truth: &Self) -> Result<ImageData, JsValue> {
        // Called for its checks only.
        metrics::compare(&self.0.right, &truth.0.right, &self.0.pose).map_err(raised)?;
        image(&difference::picture(&self.0.right, &truth.0.right))
    }
}

impl Pair {
    fn eye(&self, eye: &str) -> Result<&View, JsValue> {
        match eye {
            "left" => Ok(&self.0.left),
            "right" => Ok(&self.0.right),
            other => Err(refused(&format!("eye: unknown '{other}'; use left or right"))),
        }
    }
}

/// `Difference` of `types.d.ts`.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Differences {
    identical_percent: f64,
    wrong_surface_percent: f64,
    psnr: f64,
    p999: f64,
    mean_difference: f64,
    largest_parallax_error: f64,
}

/// `Statistics` of `types.d.ts`.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Costs {
    method: String,
    choice: Option<String>,
    in_steps: bool,
    retraced_share: f64,
    second_eye: Option<f64>,
    left: Rays,
    right: Rays,
    passes: Option<Vec<Pass>>,
}

/// Numbers of rays, as JavaScript numbers, which are exact up to 2^53.
#[derive(Serialize)]
struct Rays {
    primary: f64,
    verification: f64,
    shadow: f64,
    secondary: f64,
}

#[derive(Serialize)]
struct Pass {
    name: &'static str,
    ms: f64,
}

impl Rays {
    fn of(rays: &stereotrace::Rays) -> Self {
        let [primary, verification, shadow, secondary] =
            [rays.primary, rays.verification, rays.shadow, rays.secondary].map(|count| count as f64);
        Self { primary, verification, shadow, secondary }
    }
}

impl Costs {
    fn of(statistics: &Statistics) -> Self {
        let passes = statistics.times.as_ref().map(|times| {
            let pass = |(name, time): &(&'static str, std::time::Duration)| Pass { name, ms: 1e3 * time.as_secs_f64() };
            times.passes.iter().map(pass).collect()
        });
        Self {
            method: statistics.method.to_string(),
            choice: statistics.choice.map(|choice| choice.to_string()),
            in_steps: statistics.in_steps,
            retraced_share: statistics.retraced_share(),
            second_eye: Some(statistics.second_eye()).filter(|cost| cost.is_finite()),
            left: Rays::of(&statistics.left.rays),
            right: Rays::of(&statistics.right.rays),
            passes,
        }
    }
}
