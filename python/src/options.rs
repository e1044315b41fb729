//! Keywords of rendering: the library's `Options`, and the arrays to return.

use pyo3::{
    prelude::*,
    types::{PyDict, PyString},
};
use stereotrace::{Channel, Maker, Options};

use crate::{
    errors::{raised, refused},
    values::{named, shown, two},
};

/// Render options, and the arrays to return.
pub(crate) struct Request {
    pub(crate) options: Options,
    pub(crate) outputs: Vec<Channel>,
}

impl Request {
    pub(crate) fn has(&self, output: Channel) -> bool {
        self.outputs.contains(&output)
    }

    pub(crate) fn needs_ground_truth(&self) -> bool {
        self.outputs.iter().any(|output| output.maker() == Maker::GroundTruth)
    }

    /// Reads the keywords for a rig. Its views have no disparity, which belongs to a pair of views; depths give it.
    pub(crate) fn of_rig(fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut request = Self::of(fields)?;
        if fields.is_none_or(|fields| !fields.contains("outputs").unwrap_or(false)) {
            request.outputs.retain(|output| *output != Channel::Disparity);
        }
        match request
            .outputs
            .iter()
            .find(|output| output.maker() == Maker::GroundTruth || **output == Channel::Disparity)
        {
            Some(output) => Err(refused(format!("outputs: {} is available for pairs, not for rigs", output.name()))),
            None => Ok(request),
        }
    }

    /// Reads the keywords of `stereotrace.RenderOptions`.
    pub(crate) fn of(fields: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut options = Options::default();
        let mut outputs = vec![Channel::Color, Channel::Depth, Channel::Disparity];
        for (name, value) in fields.into_iter().flatten() {
            let name: String = name.extract()?;
            match &*name {
                "outputs" => outputs = channels(&value)?,
                _ => options = options.set(&name, &text(&name, &value)?).map_err(raised)?,
            }
        }
        Ok(Self { options: options.channels(&outputs), outputs })
    }
}

/// Reads the names of outputs, or one name.
fn channels(value: &Bound<'_, PyAny>) -> PyResult<Vec<Channel>> {
    let names = value.extract::<String>().map(|one| vec![one]).or_else(|_| value.extract::<Vec<String>>());
    let names = names.map_err(|_| refused(format!("outputs: {} must be a list of names", shown(value))))?;
    names.iter().map(|name| named(name)).collect()
}

/// Returns a value as the text that the library reads: `None` is `off`, and a tuple is joined by colons.
fn text(name: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    if value.is_none() {
        return Ok("off".into());
    }
    if let Ok(flag) = value.extract::<bool>() {
        return Ok(flag.to_string());
    }
    if value.is_instance_of::<PyString>() || value.extract::<f64>().is_ok() {
        return Ok(value.str()?.to_string());
    }
    let (first, second): (Bound<'_, PyAny>, Bound<'_, PyAny>) =
        two(value).map_err(|_| refused(format!("{name}: {} can't be its value", shown(value))))?;
    // Python gives adaptive antialiasing's levels before its tolerance.
    let (first, second) = if name == "adaptive" { (second, first) } else { (first, second) };
    Ok(format!("{}:{}", first.str()?, second.str()?))
}

/// Checks names and values of the options of ``Renderer.render``, without a device. Raises ``ValueError`` if one is
/// wrong.
#[pyfunction]
#[pyo3(signature = (**options))]
pub(crate) fn check_options(options: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
    Request::of(options)?.options.check().map_err(raised)
}
