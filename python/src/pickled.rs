//! Pickles: objects as bytes that `restored` reads. Pickles of another version of the package may not be readable.

use pyo3::{prelude::*, types::PyBytes};
use serde::{Serialize, de::DeserializeOwned};

use crate::{camera::Camera, errors::refused, light::Light, material::Material, scene::Scene};

/// Value of `__reduce__`: the function that restores the object, and its arguments.
pub(crate) type Reduced<'py> = (Bound<'py, PyAny>, (&'static str, Bound<'py, PyBytes>));

/// Returns the value of `__reduce__` for an object of this kind.
pub(crate) fn reduced<'py>(py: Python<'py>, kind: &'static str, state: &[u8]) -> PyResult<Reduced<'py>> {
    let restored = py.import("stereotrace._stereotrace")?.getattr("_restored")?;
    Ok((restored, (kind, PyBytes::new(py, state))))
}

/// Serialises a value.
pub(crate) fn bytes(value: &impl Serialize) -> PyResult<Vec<u8>> {
    postcard::to_allocvec(value).map_err(|error| refused(format!("it can't be pickled: {error}")))
}

/// Deserialises a value.
pub(crate) fn value<T: DeserializeOwned>(kind: &str, state: &[u8]) -> PyResult<T> {
    postcard::from_bytes(state).map_err(|error| refused(format!("pickled {kind}: {error}")))
}

/// Restores a pickled object. Raises ``ValueError`` for bytes that are no pickle, or one of another version.
#[pyfunction(name = "_restored")]
pub(crate) fn restored<'py>(py: Python<'py>, kind: &str, state: &[u8]) -> PyResult<Bound<'py, PyAny>> {
    match kind {
        "Camera" => Camera::restored(state)?.into_pyobject(py).map(Bound::into_any),
        "Light" => Light(value(kind, state)?).into_pyobject(py).map(Bound::into_any),
        "Material" => Material(value(kind, state)?).into_pyobject(py).map(Bound::into_any),
        "Scene" => Scene::restored(py, state)?.into_pyobject(py).map(Bound::into_any),
        _ => Err(refused(format!("pickled {kind}: there is no such class"))),
    }
}
