//! All surfaces along the lines of sight of a pair.

use std::sync::Arc;

use numpy::{Element, IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;

use crate::pair::plane;

/// All surfaces along the lines of sight of a pair, from ``Renderer.layers``: ``left`` and ``right``, each an
/// ``EyeLayers``.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct Layers(Arc<stereotrace::Layers>);

impl Layers {
    pub(crate) fn of(layers: stereotrace::Layers) -> Self {
        Self(Arc::new(layers))
    }
}

#[pymethods]
impl Layers {
    /// Surfaces of the left view: an ``EyeLayers``.
    #[getter]
    fn left(&self) -> EyeLayers {
        EyeLayers { layers: self.0.clone(), is_right: false }
    }

    /// Surfaces of the right view: an ``EyeLayers``.
    #[getter]
    fn right(&self) -> EyeLayers {
        EyeLayers { layers: self.0.clone(), is_right: true }
    }
}

/// The surfaces that the lines of sight of one view meet, in their order from the eye. Each access copies an array.
///
/// All arrays but ``count`` have the shape ``(surfaces, height, width)``, nearest surface first, top row first. Where a
/// pixel has fewer surfaces, ids are ``stereotrace.MISS``, lengths are infinite, and the other values are 0.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct EyeLayers {
    layers: Arc<stereotrace::Layers>,
    is_right: bool,
}

impl EyeLayers {
    fn eye(&self) -> &stereotrace::EyeLayers {
        if self.is_right { &self.layers.right } else { &self.layers.left }
    }

    /// Returns a list as an array of the shape `(surfaces, height, width)`.
    fn array<T: Element>(&self, py: Python<'_>, values: Vec<T>) -> PyResult<Py<PyAny>> {
        let eye = self.eye();
        let shape = [eye.surfaces, eye.height, eye.width].map(|side| side as usize);
        Ok(values.into_pyarray(py).reshape(shape)?.into_any().unbind())
    }

    /// Returns a list of vectors as an array of the shape `(surfaces, height, width, 3)`.
    fn vectors(&self, py: Python<'_>, values: Vec<[f32; 3]>) -> PyResult<Py<PyAny>> {
        let eye = self.eye();
        let shape = [eye.surfaces, eye.height, eye.width, 3].map(|side| side as usize);
        Ok(values.into_flattened().into_pyarray(py).reshape(shape)?.into_any().unbind())
    }
}

#[pymethods]
impl EyeLayers {
    /// Number of surfaces of each pixel: uint32, ``(height, width)``.
    #[getter]
    fn count(&self, py: Python<'_>) -> Py<PyAny> {
        plane(py, [self.eye().width, self.eye().height], self.eye().count.clone())
    }

    /// Depth in world units: float32. After a bend it is the depth of the point on the pixel's ray that is as far away
    /// as the line is long.
    #[getter]
    fn depth(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, self.eye().depth.clone())
    }

    /// Length of the line from the eye to the surface in world units: float32.
    #[getter]
    fn distance(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, self.eye().distance.clone())
    }

    /// Disparity ``x_l - x_r`` in pixels: float32. After a bend it is the virtual disparity, between the places where
    /// both eyes see the same point by way of the same surfaces.
    #[getter]
    fn disparity(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, self.eye().disparity.clone())
    }

    /// Difference of rows ``y_l - y_r`` of these places in pixels: float32. It is 0 before a bend.
    #[getter]
    fn vertical_disparity(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, self.eye().vertical_disparity.clone())
    }

    /// Whether the other eye sees the point: uint8. 0: it does. 1: through further see-through surfaces. 2: an opaque
    /// surface hides it. 3: it is outside the other picture. 4: not known. 5: there is no such surface.
    #[getter]
    fn visibility(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, self.eye().class.iter().map(|class| *class as u8).collect())
    }

    /// Number of reflections and refractions before the surface: uint32.
    #[getter]
    fn bends(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, self.eye().bends.clone())
    }

    /// Position relative to ``Scene.origin``: float32, ``(surfaces, height, width, 3)``.
    #[getter]
    fn position(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.vectors(py, self.eye().position.clone())
    }

    /// Shading normal on the side that the line comes from, world frame: float32, ``(surfaces, height, width, 3)``.
    #[getter]
    fn normal(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.vectors(py, self.eye().shading_normal.clone())
    }

    /// Geometric normal on the side that the line comes from, world frame: float32, ``(surfaces, height, width, 3)``.
    #[getter]
    fn geometric_normal(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.vectors(py, self.eye().geometric_normal.clone())
    }

    /// Id of the primitive: uint32.
    #[getter]
    fn primitive(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, self.eye().primitive.clone())
    }

    /// Id of the object: uint32.
    #[getter]
    fn object(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, self.eye().object.clone())
    }

    /// Id of the material: uint32.
    #[getter]
    fn material(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.array(py, self.eye().material.clone())
    }
}
