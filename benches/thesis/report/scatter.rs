//! All scenes and methods at once: errors against the cost of the second eye, in three panels.

use std::error::Error;

use plotters::prelude::*;

use super::{
    axis::{Axis, Rule},
    drawing::{Area, DOTS, Drawn, Pixel, color, drawing, heading, marker, stroke, text},
    frame::Frame,
    names::{Names, distinct},
};
use crate::common::{
    chart::{INK, Point, frontier},
    scenes,
};

/// One method on one scene.
pub(super) struct Dot {
    pub(super) scene: usize,
    pub(super) method: usize,
    pub(super) cost: f64,
    /// One a panel of [`PANELS`].
    pub(super) errors: [f64; 3],
}

const PANELS: [&str; 3] = ["differing pixels, %", "wrong surface, % of pixels", "MSE"];

/// Three panels over the same costs, and a column at their right for each method whose cost goes beyond the axis.
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
    const SIZE: (u32, u32) = (820, 900);
    const LEGEND_X: i32 = 645;
    const LINE: i32 = 20;
    const PANEL: i32 = 254;
    const COLUMN: i32 = 22;

    pub(super) fn svg(&self) -> Result<String, Box<dyn Error>> {
        let right = Self::LEGEND_X - 20 - Self::COLUMN * self.beyond.len() as i32;
        drawing(Self::SIZE, self.title, |root| {
            heading(root, self.title, self.source)?;
            for (panel, y_label) in PANELS.into_iter().enumerate() {
                // A mean can lie below all errors but zero.
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
        for dot in self.dots {
            let at = place(dot.method, (dot.cost, dot.errors[panel]));
            marker(root, dot.method, at, color(dot.scene).filled(), WHITE.into())?;
        }
        for (method, pixel) in means {
            marker(root, method, pixel, WHITE.filled(), INK.stroke_width(2))?;
        }
        Ok(())
    }

    fn legend(&self, root: &Area<'_>) -> Drawn {
        let (x, mut y) = (Self::LEGEND_X, 72);
        let shown = |pick: fn(&Dot) -> usize, all: usize| {
            (0..all).filter(move |&index| self.dots.iter().any(|dot| pick(dot) == index))
        };
        text(root, "method", (x, y), 14)?;
        for method in shown(|dot| dot.method, self.names.methods.len()) {
            y += Self::LINE;
            marker(root, method, (x + 8, y), INK.filled(), WHITE.into())?;
            text(root, &self.names.methods[method], (x + 26, y), 13)?;
        }
        y += Self::LINE + 12;
        text(root, "scene", (x, y), 14)?;
        for scene in shown(|dot| dot.scene, self.names.scenes.len()) {
            y += Self::LINE;
            root.draw(&Rectangle::new([(x, y - 5), (x + 16, y + 5)], color(scene).filled()))?;
            text(root, scenes::title(&self.names.scenes[scene]), (x + 26, y), 13)?;
        }
        y += Self::LINE + 14;
        stroke(root, &[(x - 4, y), (x + 20, y)], &[], INK.stroke_width(2))?;
        root.draw(&Circle::new((x + 8, y), 6, WHITE.filled()))?;
        root.draw(&Circle::new((x + 8, y), 6, INK.stroke_width(2)))?;
        text(root, "means of all scenes,", (x + 26, y), 13)?;
        text(root, "on the frontier", (x + 26, y + 16), 13)?;
        if !self.beyond.is_empty() {
            y += Self::LINE + 36;
            text(root, "beyond the axis: cost", (x, y), 14)?;
        }
        for &method in &self.beyond {
            y += Self::LINE;
            let costs = || self.dots.iter().filter(|dot| dot.method == method).map(|dot| dot.cost);
            let (least, most) = (costs().fold(f64::INFINITY, f64::min), costs().fold(0.0, f64::max));
            marker(root, method, (x + 8, y), INK.filled(), WHITE.into())?;
            text(root, &format!("{least:.1} to {most:.1}"), (x + 26, y), 13)?;
        }
        Ok(())
    }
}

/// Mean point in a panel, by method, of those methods that were measured on every scene.
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
