//! Passes of a picture.

use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicU32, Ordering},
};

use pyo3::prelude::*;

use crate::errors::refused;

/// The passes of a picture so far, for the argument ``passes`` of ``Renderer.render`` and ``Renderer.render_views``.
///
/// Each call with it renders one more pass, with random numbers of its own, and returns the mean of all passes. So a
/// picture by paths can be shown early and refined:
///
///     passes = stereotrace.Passes()
///     while passes.paths < 64:
///         pair = renderer.render(scene, camera, passes=passes, lighting="paths=8", denoise=True)
///
/// All passes must have the same scene, cameras and options, except ``exposure``, ``tone`` and the number of paths,
/// which is the pass's weight. Otherwise the call raises ``ValueError``. A pass that is stopped while it is traced
/// leaves the earlier ones as they are. ``adaptive`` has no passes. Depth and ids belong to the first pass.
#[pyclass(frozen, module = "stereotrace")]
pub(crate) struct Passes {
    /// The passes, unless a frame is adding to them.
    all: Mutex<Option<stereotrace::Passes>>,
    /// Numbers of the last pass, which a callback may read during the next one.
    count: AtomicU32,
    paths: AtomicU32,
}

impl Passes {
    /// Runs a frame that may add to passes, which are its own meanwhile.
    ///
    /// # Errors
    /// If another frame has the passes, and those of the frame.
    pub(crate) fn lent<T>(
        passes: Option<&Self>,
        frame: impl FnOnce(Option<&mut stereotrace::Passes>) -> PyResult<T>,
    ) -> PyResult<T> {
        let Some(passes) = passes else { return frame(None) };
        let taken = passes.all.lock().unwrap_or_else(PoisonError::into_inner).take();
        let mut all = taken.ok_or_else(|| refused("passes: another frame is adding to them"))?;
        let done = frame(Some(&mut all));
        passes.count.store(all.count(), Ordering::Relaxed);
        passes.paths.store(all.paths(), Ordering::Relaxed);
        *passes.all.lock().unwrap_or_else(PoisonError::into_inner) = Some(all);
        done
    }
}

#[pymethods]
impl Passes {
    #[new]
    fn new() -> Self {
        Self { all: Mutex::new(Some(stereotrace::Passes::new())), count: AtomicU32::new(0), paths: AtomicU32::new(0) }
    }

    /// Number of passes.
    #[getter]
    fn count(&self) -> u32 {
        self.count.load(Ordering::Relaxed)
    }

    /// Number of paths per pixel of all passes; 0 without light by paths.
    #[getter]
    fn paths(&self) -> u32 {
        self.paths.load(Ordering::Relaxed)
    }

    fn __repr__(&self) -> String {
        format!("Passes({}, {} paths)", self.count(), self.paths())
    }
}
