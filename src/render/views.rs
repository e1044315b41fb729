//! Results of a rig: its views and their cost.

use crate::{Choice, Method, PassTimes, PixelSource, Pose, ShadowBufferWork, ShadowSource, View, Work};

/// Views of a rig.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Views {
    /// One view per eye, in the rig's order.
    pub views: Vec<RigView>,
    /// Camera at the rig's midpoint.
    pub pose: Pose,
    /// Time of each pass in order; `None` if the adapter has no timestamps, or too few for all passes.
    pub times: Option<PassTimes>,
    /// Whether threads spread their work over several dispatches: see
    /// [`Statistics::in_steps`](crate::Statistics::in_steps).
    pub in_steps: bool,
    /// Device memory of the buffers between the passes in bytes, without the views themselves.
    pub intermediate_bytes: u64,
    /// Cost of filling shadow-buffers: see [`Statistics::shadow_buffer`](crate::Statistics::shadow_buffer).
    pub shadow_buffer: ShadowBufferWork,
}

impl Views {
    /// Returns the mean cost of the views that are not traced relative to the mean cost of the traced ones, by counters
    /// (DESIGN, section 7). NaN unless counting is on.
    pub fn other_views(&self) -> f64 {
        let sum = |traced: bool| {
            let costs = self.views.iter().enumerate().filter(|(index, view)| (view.made_from == *index) == traced);
            costs.fold((0.0, 0.0), |(cost, views), (_, view)| (cost + view.work.cost() as f64, views + 1.0))
        };
        let ((traced, sources), (made, others)) = (sum(true), sum(false));
        (made / others) / (traced / sources)
    }
}

/// One view of a rig and its statistics.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RigView {
    /// Picture and G-buffer of the eye.
    pub view: View,
    /// The eye's offset from the rig's midpoint, in interaxials.
    pub offset: f32,
    /// Index of the view's source; its own index if it was traced.
    pub made_from: usize,
    /// Method that made the view.
    pub method: Method,
    /// Reason for the choice of [`Method::Auto`]; `None` with other methods.
    pub choice: Option<Choice>,
    /// Source of each pixel, row-major.
    pub source: Vec<PixelSource>,
    /// Source of each pixel's visibility bits, row-major; empty unless made by `bracket`.
    pub shadow_source: Vec<ShadowSource>,
    /// Work of the view.
    pub work: Work,
}
