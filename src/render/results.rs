//! Builds results from a frame and the rows of its views.

use super::frame::Done;
use crate::{RigView, Statistics, StereoPair, Views, frame::ViewRows};

impl Done {
    /// Appends the eye of another frame, for a pair made of two single-eye frames.
    pub(crate) fn beside(mut self, other: Self) -> Self {
        self.eyes.offsets.extend(&other.eyes.offsets);
        self.eyes.sources.push(1);
        self.eyes.seconds.push(1);
        self.tallies.extend(&other.tallies);
        self.choices.extend(&other.choices);
        self.in_all(other)
    }

    /// Returns the statistics of a pair.
    pub(crate) fn pair_statistics(&self) -> Statistics {
        let [left, right] = [&self.tallies[0], &self.tallies[1]];
        Statistics {
            method: self.method_of(1),
            choice: self.choices[1],
            in_steps: self.in_steps,
            left: left.work,
            right: right.work,
            reused: right.reused,
            bad: right.bad,
            missed: right.missed,
            lost_candidates: right.lost_candidates,
            buffer_depth: self.buffer_depth,
            times: self.times.clone(),
            intermediate_bytes: self.intermediate_bytes,
            shadow_buffer: self.shadow_buffer,
        }
    }
}

impl StereoPair {
    pub(crate) fn of(done: Done, views: Vec<ViewRows>) -> Self {
        let statistics = done.pair_statistics();
        let mut views = views.into_iter();
        let mut next = || views.next().expect("a pair has two views");
        let (left, right) = (next(), next());
        Self {
            left: left.view,
            right: right.view,
            source: right.source,
            shadow_source: right.shadow_source,
            statistics,
            pose: done.eyes.pose,
        }
    }
}

impl Views {
    pub(crate) fn of(done: Done, views: Vec<ViewRows>) -> Self {
        let with_what_it_cost = |(index, rows): (usize, ViewRows)| RigView {
            view: rows.view,
            offset: done.eyes.offsets[index],
            made_from: done.eyes.sources[index],
            method: done.method_of(index),
            choice: done.choices[index],
            source: rows.source,
            shadow_source: rows.shadow_source,
            work: done.tallies[index].work,
        };
        let views = views.into_iter().enumerate().map(with_what_it_cost).collect();
        let Done { times, in_steps, intermediate_bytes, shadow_buffer, eyes, .. } = done;
        Self { views, pose: eyes.pose, times, in_steps, intermediate_bytes, shadow_buffer }
    }
}
