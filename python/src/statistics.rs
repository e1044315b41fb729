//! Costs of a frame as dicts.

use pyo3::{prelude::*, types::PyDict};
use stereotrace::{Choice, PassTimes, Statistics, Work};

/// Returns the dict of `StereoPair.statistics`.
pub(crate) fn dict<'py>(py: Python<'py>, statistics: &Statistics) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("method", statistics.method.to_string())?;
    dict.set_item("choice", statistics.choice.as_ref().map(|choice| reasons(py, choice)).transpose()?)?;
    dict.set_item("in_steps", statistics.in_steps)?;
    dict.set_item("left", work(py, &statistics.left)?)?;
    dict.set_item("right", work(py, &statistics.right)?)?;
    dict.set_item("reused", statistics.reused)?;
    dict.set_item("bad", statistics.bad)?;
    dict.set_item("missed", statistics.missed)?;
    dict.set_item("retraced_share", statistics.retraced_share())?;
    // The share is NaN if nothing was counted.
    dict.set_item("second_eye", Some(statistics.second_eye()).filter(|share| share.is_finite()))?;
    dict.set_item("lost_candidates", statistics.lost_candidates)?;
    dict.set_item("buffer_depth", statistics.buffer_depth)?;
    dict.set_item("times", statistics.times.as_ref().map(seconds))?;
    dict.set_item("intermediate_bytes", statistics.intermediate_bytes)?;
    Ok(dict)
}

/// Returns the costs of one view as a dict.
pub(crate) fn work<'py>(py: Python<'py>, work: &Work) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("primary_rays", work.rays.primary)?;
    dict.set_item("verification_rays", work.rays.verification)?;
    dict.set_item("shadow_rays", work.rays.shadow)?;
    dict.set_item("secondary_rays", work.rays.secondary)?;
    dict.set_item("nodes", work.nodes)?;
    dict.set_item("primitive_tests", work.primitive_tests)?;
    dict.set_item("cost", work.cost())?;
    Ok(dict)
}

/// Returns name and seconds of each pass, in order.
fn seconds(times: &PassTimes) -> Vec<(&'static str, f64)> {
    times.passes.iter().map(|(name, time)| (*name, time.as_secs_f64())).collect()
}

fn reasons<'py>(py: Python<'py>, choice: &Choice) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("method", choice.method.to_string())?;
    for (name, value) in [
        ("by_bracket", choice.by_bracket),
        ("gaps", choice.gaps),
        ("shadow_rays", choice.shadow_rays),
        ("secondary_rays", choice.secondary_rays),
        ("bracket", choice.bracket),
        ("naive", choice.naive),
    ] {
        dict.set_item(name, value)?;
    }
    Ok(dict)
}
