//! Where the other eye sees a pair's points.

use std::sync::Arc;

use pyo3::prelude::*;

use crate::{pair::plane, picture::shaped};

/// Places of a pair's points in the other eye's picture, from ``Renderer.correspondence``: ``left`` and ``right``, each
/// an ``EyeMatches``.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct Correspondence(Arc<stereotrace::Correspondence>);

impl Correspondence {
    pub(crate) fn of(found: stereotrace::Correspondence) -> Self {
        Self(Arc::new(found))
    }
}

#[pymethods]
impl Correspondence {
    /// Places of the left view's points in the right picture: an ``EyeMatches``.
    #[getter]
    fn left(&self) -> EyeMatches {
        EyeMatches { found: self.0.clone(), is_right: false }
    }

    /// Places of the right view's points in the left picture: an ``EyeMatches``.
    #[getter]
    fn right(&self) -> EyeMatches {
        EyeMatches { found: self.0.clone(), is_right: true }
    }
}

/// Places of one view's points in the other eye's picture, as arrays. Each access copies an array.
///
/// Arrays are row-major, top row first. They belong to the first surface that the ray through the pixel's centre hits.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct EyeMatches {
    found: Arc<stereotrace::Correspondence>,
    is_right: bool,
}

impl EyeMatches {
    fn eye(&self) -> &stereotrace::EyeMatches {
        if self.is_right { &self.found.right } else { &self.found.left }
    }

    fn size(&self) -> [u32; 2] {
        [self.eye().width, self.eye().height]
    }
}

#[pymethods]
impl EyeMatches {
    /// The point's x and y in the other picture: float32, ``(height, width, 2)``. They are pixels from the top left
    /// corner, with pixel centres at halves. Sky lies at infinity. Both are NaN behind the other eye, and where its
    /// lens does not show the direction.
    #[getter]
    fn place(&self, py: Python<'_>) -> Py<PyAny> {
        shaped(py, self.size(), self.eye().place.clone()).into_any().unbind()
    }

    /// Whether the other eye sees the point: uint8, ``(height, width)``. 0: visible. 1: hidden by a nearer surface. 2:
    /// outside the picture. 3: behind the eye.
    #[getter]
    fn visibility(&self, py: Python<'_>) -> Py<PyAny> {
        plane(py, self.size(), self.eye().class.iter().map(|class| *class as u8).collect())
    }
}
