//! Keywords of rendering: the library's `Options`, and the arrays to return.

use std::str::FromStr;

use pyo3::{prelude::*, types::PyDict};
use stereotrace::{Adaptive, AmbientOcclusion, GBuffer, Method, Options, Penumbra, ShadowBuffer, ShadowRule, Tone};

use crate::{
    errors::{raised, refused},
    values::{named, shown, two},
};

/// An array that a view may have.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Output {
    Color,
    Linear,
    Depth,
    Distance,
    Disparity,
    Occlusion,
    Normal,
    GeometricNormal,
    Primitive,
    Object,
    Material,
    Source,
    ShadowSource,
    Cost,
}

impl Output {
    pub(crate) const ALL: [Self; 14] = [
        Self::Color,
        Self::Linear,
        Self::Depth,
        Self::Distance,
        Self::Disparity,
        Self::Occlusion,
        Self::Normal,
        Self::GeometricNormal,
        Self::Primitive,
        Self::Object,
        Self::Material,
        Self::Source,
        Self::ShadowSource,
        Self::Cost,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Color => "color",
            Self::Linear => "linear",
            Self::Depth => "depth",
            Self::Distance => "distance",
            Self::Disparity => "disparity",
            Self::Occlusion => "occlusion",
            Self::Normal => "normal",
            Self::GeometricNormal => "geometric_normal",
            Self::Primitive => "primitive",
            Self::Object => "object",
            Self::Material => "material",
            Self::Source => "source",
            Self::ShadowSource => "shadow_source",
            Self::Cost => "cost",
        }
    }

    pub(crate) fn names() -> Vec<&'static str> {
        Self::ALL.map(Self::name).to_vec()
    }

    /// Returns whether [`stereotrace::Renderer::ground_truth`] makes it.
    fn is_ground_truth(self) -> bool {
        matches!(self, Self::Distance | Self::Occlusion | Self::Normal | Self::GeometricNormal | Self::Material)
    }

    /// Returns whether it needs depths.
    fn needs_depth(self) -> bool {
        matches!(self, Self::Depth | Self::Disparity)
    }
}

impl FromStr for Output {
    type Err = PyErr;

    fn from_str(name: &str) -> Result<Self, PyErr> {
        let found = Self::ALL.into_iter().find(|output| output.name() == name);
        found.ok_or_else(|| refused(format!("unknown output '{name}'; use one of {}", Self::names().join(", "))))
    }
}

/// Render options, and the arrays to return.
pub(crate) struct Request {
    pub(crate) options: Options,
    pub(crate) outputs: Vec<Output>,
}

impl Request {
    pub(crate) fn has(&self, output: Output) -> bool {
        self.outputs.contains(&output)
    }

    pub(crate) fn needs_ground_truth(&self) -> bool {
        self.outputs.iter().any(|output| output.is_ground_truth())
    }

    /// Reads the keywords for a rig. Its views have no disparity, which belongs to a pair of views; depths give it.
    pub(crate) fn of_rig(fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut request = Self::of(fields)?;
        if fields.is_none_or(|fields| !fields.contains("outputs").unwrap_or(false)) {
            request.outputs.retain(|output| *output != Output::Disparity);
        }
        match request.outputs.iter().find(|output| output.is_ground_truth() || **output == Output::Disparity) {
            Some(output) => Err(refused(format!("outputs: {} is available for pairs, not for rigs", output.name()))),
            None => Ok(request),
        }
    }

    /// Reads the keywords of `stereotrace.RenderOptions`.
    pub(crate) fn of(fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut options = Options::default();
        let mut outputs = vec![Output::Color, Output::Depth, Output::Disparity];
        for (name, value) in fields.into_iter().flatten() {
            let name: String = name.extract()?;
            let wrong = |expected: &str| refused(format!("{name}: {} must be {expected}", shown(&value)));
            let text = || value.extract::<String>().map_err(|_| wrong("a name"));
            let count = || value.extract::<u32>().map_err(|_| wrong("a whole number, 0 or more"));
            let number = || value.extract::<f32>().map_err(|_| wrong("a number"));
            let flag = || value.extract::<bool>().map_err(|_| wrong("True or False"));
            options = match &*name {
                "method" => options.method(named::<Method>(&text()?)?),
                "outputs" => {
                    let names: Vec<String> = match value.extract::<String>() {
                        Ok(one) => vec![one],
                        Err(_) => value.extract().map_err(|_| wrong("a list of names"))?,
                    };
                    outputs = names.iter().map(|name| name.parse()).collect::<PyResult<_>>()?;
                    options
                }
                "samples" => options.samples(count()?),
                "filter" => options.filter(named(&text()?)?),
                "jitter" => options.jitter(flag()?),
                "adaptive" if value.is_none() => options,
                "adaptive" => {
                    let (levels, tolerance) = two(&value).map_err(|_| wrong("levels and tolerance, as (4, 8.0)"))?;
                    options.adaptive(Adaptive::new(levels, tolerance))
                }
                "bounces" => options.bounces(count()?),
                "shadow_rays" => options.shadow_rays(count()?),
                "ambient_occlusion" if value.is_none() => options,
                "ambient_occlusion" => {
                    let (rays, radius) =
                        two(&value).map_err(|_| wrong("rays and a radius in world units, as (16, 0.5)"))?;
                    options.occlusion(AmbientOcclusion::new(rays, radius))
                }
                "sky_rays" if value.is_none() => options,
                "sky_rays" => options.sky_rays(count()?),
                "penumbra" => options.penumbra(match &*text()? {
                    "exact" => Penumbra::Exact,
                    "shared" => Penumbra::default(),
                    _ => return Err(wrong("exact or shared")),
                }),
                "seed" => options.seed(count()?),
                "exposure" => options.exposure(number()?),
                "tone" => options.tone(match &*text()? {
                    "clamp" => Tone::Clamp,
                    "filmic" => Tone::Filmic,
                    _ => return Err(wrong("clamp or filmic")),
                }),
                "noise_by_view" => options.noise_by_view(flag()?),
                "visibility" => options.visibility(named(&text()?)?),
                "shadow_buffer" if value.is_none() => options,
                "shadow_buffer" => {
                    let (rows, rule): (u32, String) =
                        two(&value).map_err(|_| wrong("rows and a rule, as (400, 'hybrid')"))?;
                    options.shadow_buffer(ShadowBuffer::new(rows).rule(match &*rule {
                        "object" => ShadowRule::Object,
                        "depth" => ShadowRule::DEPTH,
                        "hybrid" => ShadowRule::HYBRID,
                        _ => return Err(wrong("rows and a rule: object, depth or hybrid")),
                    }))
                }
                "count" => options.count(flag()?),
                _ => return Err(refused(format!("unknown option '{name}'; the options are {}", NAMES.join(", ")))),
            };
        }
        let has = |of: fn(Output) -> bool| outputs.iter().copied().any(of);
        let needs_ids = has(|output| output.is_ground_truth() || matches!(output, Output::Primitive | Output::Object));
        options = options.g_buffer(match (needs_ids, has(Output::needs_depth)) {
            (true, _) => GBuffer::Ids,
            (false, true) => GBuffer::Depth,
            (false, false) => GBuffer::None,
        });
        options = options.linear(outputs.contains(&Output::Linear)).cost_map(outputs.contains(&Output::Cost));
        Ok(Self { options, outputs })
    }
}

/// Names of the keywords.
const NAMES: [&str; 18] = [
    "method",
    "outputs",
    "samples",
    "filter",
    "jitter",
    "adaptive",
    "bounces",
    "shadow_rays",
    "ambient_occlusion",
    "sky_rays",
    "penumbra",
    "seed",
    "exposure",
    "tone",
    "noise_by_view",
    "visibility",
    "shadow_buffer",
    "count",
];

/// Checks names and values of the options of ``Renderer.render``, without a device. Raises ``ValueError`` if one is
/// wrong.
#[pyfunction]
#[pyo3(signature = (**options))]
pub(crate) fn check_options(options: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
    Request::of(options)?.options.check().map_err(raised)
}
