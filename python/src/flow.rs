//! Motion of a pair's points.

use std::sync::Arc;

use pyo3::prelude::*;

use crate::{
    pair::{StereoPair, plane},
    picture::shaped,
};

/// The next pair, and the flow forwards and backwards.
pub(crate) type MotionTuple = (Py<StereoPair>, Py<Flow>, Py<Flow>);

/// Motion of a pair to the next pair of its item.
pub(crate) struct Motion {
    next: Py<StereoPair>,
    pub(crate) forward: Arc<stereotrace::Flow>,
    pub(crate) backward: Arc<stereotrace::Flow>,
    flows: [Py<Flow>; 2],
}

impl Motion {
    pub(crate) fn of(
        py: Python<'_>,
        next: StereoPair,
        forward: stereotrace::Flow,
        backward: stereotrace::Flow,
    ) -> PyResult<Self> {
        let (forward, backward) = (Arc::new(forward), Arc::new(backward));
        let flows = [Py::new(py, Flow(forward.clone()))?, Py::new(py, Flow(backward.clone()))?];
        Ok(Self { next: Py::new(py, next)?, forward, backward, flows })
    }

    pub(crate) fn next(&self) -> &StereoPair {
        self.next.get()
    }

    pub(crate) fn tuple(&self, py: Python<'_>) -> MotionTuple {
        let [forward, backward] = &self.flows;
        (self.next.clone_ref(py), forward.clone_ref(py), backward.clone_ref(py))
    }
}

/// Motion of a pair's points to another time, from ``Renderer.flow``: ``left`` and ``right``, each an ``EyeFlow``.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct Flow(Arc<stereotrace::Flow>);

impl Flow {
    pub(crate) fn of(flow: stereotrace::Flow) -> Self {
        Self(Arc::new(flow))
    }
}

#[pymethods]
impl Flow {
    /// Motion of the left view's points: an ``EyeFlow``.
    #[getter]
    fn left(&self) -> EyeFlow {
        EyeFlow { flow: self.0.clone(), is_right: false }
    }

    /// Motion of the right view's points: an ``EyeFlow``.
    #[getter]
    fn right(&self) -> EyeFlow {
        EyeFlow { flow: self.0.clone(), is_right: true }
    }
}

/// Motion of the points that one view shows, as arrays. Each access copies an array.
///
/// Arrays are row-major, top row first. They belong to the first surface that the ray through the pixel's centre hits.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct EyeFlow {
    flow: Arc<stereotrace::Flow>,
    is_right: bool,
}

impl EyeFlow {
    fn eye(&self) -> &stereotrace::EyeFlow {
        if self.is_right { &self.flow.right } else { &self.flow.left }
    }

    fn size(&self) -> [u32; 2] {
        [self.eye().width, self.eye().height]
    }
}

#[pymethods]
impl EyeFlow {
    /// Optical flow in pixels, to the right and down: float32, ``(height, width, 2)``. It is the point's place in this
    /// eye's picture at the other time, minus the pixel's centre. Sky moves by the camera's rotation alone. In
    /// pictures of 360 degrees flow takes the shorter way round.
    #[getter]
    fn flow(&self, py: Python<'_>) -> Py<PyAny> {
        shaped(py, self.size(), self.eye().flow.clone()).into_any().unbind()
    }

    /// The point's disparity at the other time minus its disparity now, in pixels: float32, ``(height, width)``.
    #[getter]
    fn disparity_change(&self, py: Python<'_>) -> Py<PyAny> {
        plane(py, self.size(), self.eye().disparity_change.clone())
    }

    /// Scene flow: the point's displacement in world units, in the world's frame: float32, ``(height, width, 3)``. It
    /// is 0 for sky.
    #[getter]
    fn displacement(&self, py: Python<'_>) -> Py<PyAny> {
        shaped(py, self.size(), self.eye().displacement.clone()).into_any().unbind()
    }

    /// Whether this eye sees the point at the other time: uint8, ``(height, width)``. 0: visible. 1: hidden by a
    /// nearer surface. 2: outside the picture. 3: behind the eye, where flow and change of disparity are NaN.
    #[getter]
    fn visibility(&self, py: Python<'_>) -> Py<PyAny> {
        plane(py, self.size(), self.eye().class.iter().map(|class| *class as u8).collect())
    }
}
