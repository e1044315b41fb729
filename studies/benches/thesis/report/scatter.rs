//! Draws plots of all scenes and methods at once: errors against the cost of the second eye, in three panels.

use std::error::Error;

use plotters::prelude::*;

use super::{
    axis::{Axis, Rule},
    drawing::{DOTS, stroke},
    frame::Frame,
    names::{Names, distinct},
};
use crate::common::{
    chart::{Area, Drawn, INK, LEGEND_X, Legend, Pixel, Point, WIDTH, drawing, frontier, heading},
    looks::{color, error_bar, marker, numbered},
};

/// One method on one scene.
pub(super) struct Dot {
    pub(super) scene: usize,
    pub(super) method: usize,
    pub(super) cost: f64,
    /// Minimum and maximum of the cost over the rounds, for times.
    pub(super) costs: Option<[f64; 2]>,
    /// One error for each of the [`PANELS`].
    pub(super) errors: [f64; 3],
}

const PANELS: [&str; 3] = ["differing pixels, %", "wrong surface, % of pixels", "MSE"];

/// Three panels over the same costs. If the cost of a method is beyond the axis, it is drawn in a column to the right
/// of the panels.
pub(super) struct Scatter<'a> {
    pub(super) title: &'a str,
    pub(super) source: &'a str,
    pub(super) x_label: &'a str,
    pub(super) names: &'a Names,
    pub(super) dots: &'a [Dot],
    pub(super) x: Axis,
    /// Methods with a cost beyond the axis.
    pub(super) beyond: Vec<usize>,
}

impl Scatter<'_> {
    const SIZE: (u32, u32) = (WIDTH, 1020);
    const PANEL: i32 = 294;
    const COLUMN: i32 = 22;

    pub(super) fn svg(&self) -> Result<String, Box<dyn Error>> {
        let right = LEGEND_X - 20 - Self::COLUMN * self.beyond.len() as i32;
        drawing(Self::SIZE, self.title, |root| {
            heading(root, self.title, self.source)?;
            for (panel, y_label) in PANELS.into_iter().enumerate() {
                // The axis must include the means, since a mean can be below all nonzero errors.
                let means = means(self.dots, panel).into_iter().map(|(_, mean)| mean.1);
                let errors: Vec<f64> = self.dots.iter().map(|dot| dot.errors[panel]).chain(means).collect();
                let y = Axis::of(Rule::Decades, &errors);
                let top = 62 + panel as i32 * (Self::PANEL + 14);
                let frame = Frame { left: 78, right, top, bottom: top + Self::PANEL, x: &self.x, y: &y };
                frame.draw(root, y_label, (panel + 1 == PANELS.len()).then_some(self.x_label))?;
                self.draw_panel(root, &frame, panel)?;
            }
            self.legend(root)
        })
    }

    fn draw_panel(&self, root: &Area<'_>, frame: &Frame<'_>, panel: usize) -> Drawn {
        let place = |method: usize, (cost, error): Point| {
            let (x, y) = frame.place((cost, error));
            let column = self.beyond.iter().position(|&beyond| beyond == method && cost > self.x.high);
            (column.map_or(x, |column| frame.right + Self::COLUMN * column as i32 + Self::COLUMN / 2 + 2), y)
        };
        let end = frame.right + Self::COLUMN * self.beyond.len() as i32 + 2;
        if !self.beyond.is_empty() {
            for x in [frame.right, end] {
                stroke(root, &[(x, frame.top), (x, frame.bottom)], DOTS, INK.stroke_width(1))?;
            }
        }
        let means = means(self.dots, panel);
        let frontier = frontier(&means.iter().map(|&(_, mean)| mean).collect::<Vec<_>>());
        let means: Vec<(usize, Pixel)> =
            frontier.into_iter().map(|index| (means[index].0, place(means[index].0, means[index].1))).collect();
        let line: Vec<Pixel> = means.iter().map(|&(_, pixel)| pixel).collect();
        stroke(root, &line, &[], INK.stroke_width(2))?;
        let dots = || self.dots.iter().map(|dot| (dot, self.names.look(dot.method)));
        for (dot, look) in dots() {
            let costs = dot.costs.filter(|costs| costs[1] <= self.x.high);
            if let Some([from, to]) =
                costs.map(|costs| costs.map(|cost| place(dot.method, (cost.max(self.x.low), dot.errors[panel]))))
            {
                error_bar(root, from, to, color(look))?;
            }
        }
        let many = dots().any(|(dot, _)| dot.scene != self.dots[0].scene);
        for (dot, look) in dots() {
            let at = place(dot.method, (dot.cost, dot.errors[panel]));
            numbered(root, look, many.then_some(dot.scene + 1), at)?;
        }
        for (method, pixel) in means {
            marker(root, self.names.look(method), pixel, WHITE.filled(), INK.stroke_width(2))?;
        }
        Ok(())
    }

    fn legend(&self, root: &Area<'_>) -> Drawn {
        let mut legend = Legend::new(root);
        let name = |method: usize| (self.names.look(method), self.names.methods[method].as_str());
        let methods = (0..self.names.methods.len()).filter(|&method| self.dots.iter().any(|dot| dot.method == method));
        legend.markers("method", methods.map(name), None)?;
        // Dots are numbered by the scene's index among all scenes, and all of these were measured.
        legend.scene_numbers(self.names.scenes.iter().map(String::as_str))?;
        legend.means()?;
        if self.dots.iter().any(|dot| dot.costs.is_some()) {
            legend.error_bars()?;
        }
        if !self.beyond.is_empty() {
            legend.head("beyond the axis: cost")?;
        }
        for &method in &self.beyond {
            let look = self.names.look(method);
            let costs = || self.dots.iter().filter(|dot| dot.method == method).map(|dot| dot.cost);
            let (least, most) = (costs().fold(f64::INFINITY, f64::min), costs().fold(0.0, f64::max));
            legend.entry(&format!("{least:.1} to {most:.1}"), |root, at| {
                marker(root, look, at, color(look).filled(), WHITE.into())
            })?;
        }
        Ok(())
    }
}

/// Returns the mean point in a panel of each method that was measured on every scene.
pub(super) fn means(dots: &[Dot], panel: usize) -> Vec<(usize, Point)> {
    let scenes = distinct(dots.iter().map(|dot| dot.scene)).len();
    let mut methods = distinct(dots.iter().map(|dot| dot.method));
    methods.sort_unstable();
    let mean = |method: usize| {
        let of_method: Vec<&Dot> = dots.iter().filter(|dot| dot.method == method).collect();
        let is_whole = distinct(of_method.iter().map(|dot| dot.scene)).len() == scenes;
        let mean =
            |part: &dyn Fn(&Dot) -> f64| of_method.iter().map(|dot| part(dot)).sum::<f64>() / of_method.len() as f64;
        is_whole.then(|| (method, (mean(&|dot| dot.cost), mean(&|dot| dot.errors[panel]))))
    };
    methods.into_iter().filter_map(mean).collect()
}
