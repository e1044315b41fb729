//! Samples per pixel and their filters (docs/DESIGN.md, section 3).

mod cells;
mod gather;
mod jitter;
mod parts;

pub(crate) use self::{
    cells::Cells,
    gather::{Centres, Gather},
    jitter::Jitter,
    parts::PartSums,
};
use crate::{
    Error, Filter, Pose,
    view::camera::{self, Field},
    view::rig::Eyes,
};

impl Eyes {
    /// Returns the same eyes and screen with one pixel per sample, for `side` x `side` samples per pixel.
    ///
    /// # Errors
    /// [`Error::Samples`] if directions in f32 don't resolve the samples.
    pub(crate) fn with_samples(&self, side: u32) -> Result<Self, Error> {
        let Pose { size, mut field, .. } = self.pose;
        if let Field::Lenses(lenses) = &mut field {
            *lenses = lenses.map(|lens| lens.scaled([side.into(); 2], 0.0));
        }
        self.finer(Pose { size: size.map(|pixels| pixels * side), field, ..self.pose }, side)
    }

    /// Returns the same eyes with one pixel per sample of a lattice of `side` samples per pixel side. Its first and
    /// last samples lie on the picture's borders, so the screen is one sample larger.
    ///
    /// # Errors
    /// Returns the errors of [`Eyes::with_samples`].
    pub(crate) fn with_lattice(&self, side: u32) -> Result<Self, Error> {
        let Pose { size, screen_size, mut field, .. } = self.pose;
        let samples = size.map(|pixels| pixels * side);
        let larger = |axis: usize, length: f32| length * (1.0 + 1.0 / samples[axis] as f32);
        let screen_size = [larger(0, screen_size[0]), larger(1, screen_size[1])];
        match &mut field {
            Field::Screen(frustum) => {
                frustum.size = [0, 1].map(|axis| larger(axis, frustum.size[axis] as f32).into());
            }
            Field::Sphere(sphere) => {
                sphere.angles = [0, 1].map(|axis| sphere.angles[axis] * (1.0 + 1.0 / f64::from(samples[axis])));
            }
            Field::Lenses(lenses) => *lenses = lenses.map(|lens| lens.scaled([side.into(); 2], 0.5)),
        }
        self.finer(Pose { size: samples.map(|samples| samples + 1), screen_size, field, ..self.pose }, side)
    }

    /// Returns the same eyes with a pose that has `side` samples per pixel side.
    fn finer(&self, mut pose: Pose, side: u32) -> Result<Self, Error> {
        pose.interaxial_px *= side as f32;
        let fault = |reason| Err(Error::Samples { samples: side * side, reason });
        let ([width, height], [across, down]) = (self.pose.size, pose.size);
        if across.max(down) > camera::MAX_SIDE {
            return fault(format!(
                "for {width}x{height} pixels they form a grid of {across}x{down}, whose sides must be at most 131072 \
                 (2^17): use fewer samples or pixels"
            ));
        }
        let aside = self.offsets.iter().fold(0.0_f32, |most, offset| most.max(offset.abs()));
        let angle = camera::least_pixel_angle(&pose, aside.into());
        if angle < f64::from(camera::MIN_PIXEL_ANGLE) {
            return fault(format!(
                "for {width}x{height} pixels they are {angle:.1e} radians apart in the picture's corners, but must be \
                 at least 3.8e-6 (2^-18) apart: use fewer samples or pixels"
            ));
        }
        Ok(Self { pose, ..self.clone() })
    }
}

/// The samples of a pixel in a row or a column, and their weights, which sum to 1.
#[derive(Clone, Debug, PartialEq)]
struct Window {
    first: u32,
    weights: Vec<f64>,
}

impl Window {
    /// Creates the window of pixel `pixel` of `pixels`, with `side` samples each. Samples lie `aside` cell widths to
    /// the right of their cells' centres.
    fn new(filter: Filter, side: u32, [pixel, pixels]: [u32; 2], aside: f32) -> Self {
        // Positions are in units of samples: sample s lies at s + 0.5 + aside.
        let (centre, reach) = ((f64::from(pixel) + 0.5) * f64::from(side), filter.radius() * f64::from(side));
        let away = |sample: u32| f64::from(sample) + 0.5 + f64::from(aside) - centre;
        // The range extends by one more cell on either side, since jittered samples stay in their cells.
        let nearest = (centre - reach - 1.0).floor().max(0.0) as u32;
        let farthest = ((centre + reach + 1.0).ceil() as u32).min(pixels * side);
        let within = |sample: &u32| away(*sample).abs() < reach;
        let first = (nearest..farthest).find(within).unwrap_or(farthest);
        let end = (first..farthest).rfind(within).map_or(first, |last| last + 1);
        let mut weights: Vec<f64> = (first..end).map(|sample| filter.weight(away(sample) / f64::from(side))).collect();
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        Self { first, weights }
    }

    /// Returns the index after the last sample.
    fn end(&self) -> u32 {
        self.first + self.weights.len() as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ask::samples::{MAX_SIDE, side_of};

    /// Creates a window without jitter.
    fn window(filter: Filter, side: u32, pixel: u32, pixels: u32) -> Window {
        Window::new(filter, side, [pixel, pixels], 0.0)
    }

    #[test]
    fn windows_are_centred_and_whole() {
        for (filter, own) in [(Filter::Box, 1), (Filter::Tent, 2), (Filter::Gauss, 3)] {
            for side in 1..=MAX_SIDE {
                let Window { first, weights } = window(filter, side, 5, 11);
                // The tent's outermost samples have no weight if they lie exactly one pixel away.
                let none = u32::from(filter == Filter::Tent && side % 2 == 1);
                assert_eq!(weights.len() as u32, own * side - none, "{filter} {side}");
                let mean: f64 = (first..).zip(&weights).map(|(s, weight)| (f64::from(s) + 0.5) * weight).sum();
                assert!((mean / f64::from(side) - 5.5).abs() < 1e-12, "{filter} {side}: {mean}");
                for pixel in 0..11 {
                    let window = window(filter, side, pixel, 11);
                    assert!((window.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                    assert!(window.end() <= 11 * side && window.weights.iter().all(|weight| *weight > 0.0));
                    assert!(window.first <= pixel * side && window.end() >= (pixel + 1) * side);
                }
            }
        }
        assert_eq!(window(Filter::Tent, 2, 0, 3).weights, [0.75, 0.75, 0.25].map(|weight: f64| weight / 1.75));
    }

    #[test]
    fn what_is_no_grid_is_refused_by_name() {
        for samples in [0, 2, 5, 65, 81, u32::MAX] {
            let message = side_of(samples).unwrap_err().to_string();
            let expected = format!("invalid samples: {samples} per pixel; use 1, 4, 9, 16, 25, 36, 49 or 64");
            assert_eq!(message, expected);
        }
        assert_eq!([1, 4, 9, 16, 25, 36, 49, 64].map(|samples| side_of(samples).unwrap()), [1, 2, 3, 4, 5, 6, 7, 8]);
    }
}
