//! Pickles: objects as bytes that `restored` reads. Those of another version of the package may not be readable.

use pyo3::{prelude::*, types::PyBytes};
use serde::{Serialize, de::DeserializeOwned};

use crate::{camera::Camera, errors::refused, light::Light, material::Material, scene::Scene};

/// What `__reduce__` returns: what makes the object again, and from what.
pub(crate) type Reduced<'py> = (Bound<'py, PyAny>, (&'static str, Bound<'py, PyBytes>));

/// What makes an object of this kind again from bytes.
pub(crate) fn reduced<'py>(py: Python<'py>, kind: &'static str, state: &[u8]) -> PyResult<Reduced<'py>> {
    let restored = py.import("stereotrace._stereotrace")?.getattr("_restored")?;
    Ok((restored, (kind, PyBytes::new(py, state))))
}

/// A value as bytes.
pub(crate) fn bytes(value: &impl Serialize) -> PyResult<Vec<u8>> {
    postcard::to_allocvec(value).map_err(|error| refused(format!("it can't be pickled: {error}")))
}

/// The value that bytes say.
pub(crate) fn value<T: DeserializeOwned>(kind: &str, state: &[u8]) -> PyResult<T> {
    postcard::from_bytes(state).map_err(|error| refused(format!("pickled {kind}: {error}")))
}

/// Makes a pickled object again. Raises ``ValueError`` for bytes that are none, or another version's.
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
