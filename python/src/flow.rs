//! Motion of a pair's points.

use pyo3::prelude::*;
use stereotrace::EyeFlow as Inner;

use crate::{
    pair::{StereoPair, plane},
    picture::shaped,
};

/// The next pair, and the flow forwards and backwards.
pub(crate) type MotionTuple = (Py<StereoPair>, Py<Flow>, Py<Flow>);

/// Motion of a pair to the next pair of its item.
pub(crate) struct Motion(MotionTuple);

impl Motion {
    pub(crate) fn of(py: Python<'_>, (next, forward, backward): (StereoPair, Flow, Flow)) -> PyResult<Self> {
        Ok(Self((Py::new(py, next)?, Py::new(py, forward)?, Py::new(py, backward)?)))
    }

    pub(crate) fn tuple(&self, py: Python<'_>) -> MotionTuple {
        let (next, forward, backward) = &self.0;
        (next.clone_ref(py), forward.clone_ref(py), backward.clone_ref(py))
    }
}

/// Motion of a pair's points to another time, from ``Renderer.flow``: ``left`` and ``right``, each an ``EyeFlow``.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct Flow {
    /// Motion of the left view's points: an ``EyeFlow``.
    #[pyo3(get)]
    left: Py<EyeFlow>,
    /// Motion of the right view's points: an ``EyeFlow``.
    #[pyo3(get)]
    right: Py<EyeFlow>,
}

impl Flow {
    pub(crate) fn of(py: Python<'_>, flow: stereotrace::Flow) -> PyResult<Self> {
        Ok(Self { left: Py::new(py, EyeFlow::of(py, flow.left))?, right: Py::new(py, EyeFlow::of(py, flow.right))? })
    }
}

/// Motion of the points that one view shows, as arrays.
///
/// Arrays are row-major, top row first. They belong to the first surface that the ray through the pixel's centre hits.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct EyeFlow {
    /// Optical flow in pixels, to the right and down: float32, ``(height, width, 2)``. It is the point's place in this
    /// eye's picture at the other time, minus the pixel's centre. Sky moves by the camera's rotation alone. In
    /// pictures of 360 degrees flow takes the shorter way round.
    #[pyo3(get)]
    flow: Py<PyAny>,
    /// The point's disparity at the other time minus its disparity now, in pixels: float32, ``(height, width)``.
    #[pyo3(get)]
    disparity_change: Py<PyAny>,
    /// Scene flow: the point's displacement in world units, in the world's frame: float32, ``(height, width, 3)``. It
    /// is 0 for sky.
    #[pyo3(get)]
    displacement: Py<PyAny>,
    /// Whether this eye sees the point at the other time: uint8, ``(height, width)``. 0: visible. 1: hidden by a
    /// nearer surface. 2: outside the picture. 3: behind the eye, where flow and change of disparity are NaN.
    #[pyo3(get)]
    visibility: Py<PyAny>,
}

impl EyeFlow {
    fn of(py: Python<'_>, flow: Inner) -> Self {
        let size = [flow.width, flow.height];
        Self {
            flow: shaped(py, size, flow.flow).into_any().unbind(),
            disparity_change: plane(py, size, flow.disparity_change),
            displacement: shaped(py, size, flow.displacement).into_any().unbind(),
            visibility: plane(py, size, flow.class.into_iter().map(|class| class as u8).collect()),
        }
    }
}
