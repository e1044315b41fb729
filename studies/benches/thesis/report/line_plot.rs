//! Draws the plot of a question for one scene, with one line per method.

use std::error::Error;

use plotters::prelude::*;

use super::{
    axis::Axis,
    drawing::{DOTS, bracket, stroke},
    frame::Frame,
    names::Names,
    questions::Question,
};
use crate::common::{
    chart::{Area, Drawn, Pixel, Point, drawing, heading, text},
    looks::{color, dash, error_bar, marker},
};

/// A method's measured points, ordered by x.
pub(super) struct Line {
    pub(super) method: usize,
    pub(super) counted: bool,
    pub(super) points: Vec<Point>,
    /// x of the points, with minimum and maximum of y over the rounds, for times.
    pub(super) ranges: Vec<(f64, [f64; 2])>,
}

/// Plot of a question for one scene.
pub(super) struct LinePlot<'a> {
    pub(super) title: &'a str,
    pub(super) source: &'a str,
    pub(super) question: &'a Question,
    pub(super) names: &'a Names,
    pub(super) lines: Vec<Line>,
    /// Ranges that the thesis states: method, lowest and highest value.
    pub(super) ranges: Vec<(usize, f64, f64)>,
}

impl LinePlot<'_> {
    const SIZE: (u32, u32) = (680, 390);
    const LEGEND_X: i32 = 508;
    const RANGE_STEP: i32 = 18;

    pub(super) fn svg(&self) -> Result<String, Box<dyn Error>> {
        let points = || self.lines.iter().flat_map(|line| line.points.iter());
        let limits = self.ranges.iter().flat_map(|&(_, low, high)| [low, high]);
        let bars = self.lines.iter().flat_map(|line| line.ranges.iter().flat_map(|(_, range)| *range));
        let values: Vec<f64> = points().map(|point| point.1).chain(limits).chain(bars).collect();
        let x = Axis::through(points().map(|point| point.0));
        let y = Axis::of(self.question.rule, &values);
        let right = Self::LEGEND_X - 18 - Self::RANGE_STEP * self.ranges.len() as i32;
        let frame = Frame { left: 72, right, top: 62, bottom: Self::SIZE.1 as i32 - 50, x: &x, y: &y };
        drawing(Self::SIZE, self.title, |root| {
            heading(root, self.title, self.source)?;
            frame.draw(root, self.question.y_label, Some(self.question.swept.label()))?;
            self.draw_ranges(root, &frame)?;
            self.draw_lines(root, &frame)?;
            self.legend(root)
        })
    }

    fn draw_ranges(&self, root: &Area<'_>, frame: &Frame<'_>) -> Drawn {
        for (index, &(method, low, high)) in self.ranges.iter().enumerate() {
            let y = |value| frame.place((0.0, value)).1;
            let look = self.names.look(method);
            let (low, high, tone) = (y(low), y(high), color(look));
            root.draw(&Rectangle::new([(frame.left, high), (frame.right, low)], tone.mix(0.10).filled()))?;
            for y in [low, high] {
                stroke(root, &[(frame.left, y), (frame.right, y)], dash(look), tone.mix(0.6).stroke_width(1))?;
            }
            bracket(root, frame.right + 10 + Self::RANGE_STEP * index as i32, (high, low), look)?;
        }
        Ok(())
    }

    fn draw_lines(&self, root: &Area<'_>, frame: &Frame<'_>) -> Drawn {
        // In the row of zero, lines would hide each other, so each line has its own height there.
        let meets_zero = |line: &&Line| line.points.iter().any(|point| point.1 <= 0.0);
        let count = self.lines.iter().filter(meets_zero).count() as f64;
        let places = self.lines.iter().enumerate().map(|(index, line)| {
            let before = self.lines[..index].iter().filter(meets_zero).count() as f64;
            let spread = frame.y.zero_row() * (before + 0.5 - count / 2.0) / (count + 1.0);
            let place = |&point: &Point| {
                let (x, y) = frame.place(point);
                (x, if point.1 > 0.0 { y } else { y + spread.round() as i32 })
            };
            (line, line.points.iter().map(place).collect::<Vec<Pixel>>())
        });
        let places: Vec<_> = places.collect();
        for (line, pixels) in &places {
            stroke(root, pixels, self.dash(line), self.color(line).stroke_width(2))?;
            for &(x, range) in &line.ranges {
                let [from, to] = range.map(|y| frame.place((x, y)));
                error_bar(root, from, to, self.color(line))?;
            }
        }
        for (line, pixels) in &places {
            for &pixel in pixels {
                self.line_marker(root, line, pixel)?;
            }
        }
        Ok(())
    }

    fn dash(&self, line: &Line) -> &'static [f64] {
        match self.question.counted {
            Some(_) if line.counted => DOTS,
            Some(_) => &[],
            None => dash(self.names.look(line.method)),
        }
    }

    fn legend(&self, root: &Area<'_>) -> Drawn {
        let mut y = 74;
        let step = (240 / self.lines.len() as i32).clamp(14, 20);
        let entry = |line: &Line, y: i32, name: &str| {
            let sample = [(Self::LEGEND_X, y), (Self::LEGEND_X + 36, y)];
            stroke(root, &sample, self.dash(line), self.color(line).stroke_width(2))?;
            self.line_marker(root, line, (Self::LEGEND_X + 18, y))?;
            text(root, name, (Self::LEGEND_X + 44, y), 13)
        };
        let mut shown = Vec::new();
        for line in &self.lines {
            if !shown.contains(&line.method) {
                shown.push(line.method);
                entry(
                    &Line { counted: false, points: vec![], ranges: vec![], ..*line },
                    y,
                    &self.names.methods[line.method],
                )?;
                y += step;
            }
        }
        if self.question.counted.is_some() {
            y += 10;
            for (counted, name) in [(false, "by time"), (true, "by counters")] {
                entry(&Line { method: self.lines[0].method, counted, points: vec![], ranges: vec![] }, y, name)?;
                y += step;
            }
        }
        if let Some(&(method, ..)) = self.ranges.first() {
            bracket(root, Self::LEGEND_X + 18, (y + 6, y + 34), self.names.look(method))?;
            text(root, "range that the", (Self::LEGEND_X + 44, y + 12), 13)?;
            text(root, "thesis states", (Self::LEGEND_X + 44, y + 28), 13)?;
        }
        Ok(())
    }

    fn color(&self, line: &Line) -> RGBColor {
        color(self.names.look(line.method))
    }

    /// Draws a marker, which is filled for times and hollow for counted tests.
    fn line_marker(&self, root: &Area<'_>, line: &Line, at: Pixel) -> Drawn {
        let (look, tone) = (self.names.look(line.method), self.color(line));
        if line.counted {
            marker(root, look, at, WHITE.filled(), tone.stroke_width(2))
        } else {
            marker(root, look, at, tone.filled(), WHITE.into())
        }
    }
}
