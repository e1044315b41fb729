//! Verification without rays (thesis, 6.2): pixels whose sample lies at an edge in the source view are marked, and
//! traced later.

use super::step;
use crate::{
    frame::plan::{Launch, Step},
    kernel::{Kernel, Role, kernel},
};

pub(crate) const MARK_EDGES: Kernel = kernel!("edges", "mark_edges", Role::Objects);

pub(crate) fn mark(view: usize) -> Vec<Step> {
    vec![step(&MARK_EDGES, view, Launch::Pixels)]
}
