//! Draws charts in the paper's style: marked points on linear axes, with fitted curves.

use std::error::Error;

use plotters::prelude::*;

use crate::{
    common::{
        chart::{FONT, GRID, INK, LEGEND_X, Legend, SIZE, WIDTH, drawing, heading},
        looks::{color, error_bar, marker},
    },
    fits::Point,
};

/// A point, with the minimum and maximum of its y over the rounds if it was timed.
pub(crate) type Ranged = (Point, Option<[f64; 2]>);

/// Points with a common name, or a curve.
pub(crate) struct Series {
    name: String,
    points: Vec<Ranged>,
    marked: bool,
}

impl Series {
    pub(crate) fn marked(name: String, points: Vec<Ranged>) -> Self {
        Self { name, points, marked: true }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    pub(crate) fn curve(name: &str, points: Vec<Point>) -> Self {
        let points = points.into_iter().map(|point| (point, None)).collect();
        Self { name: name.into(), points, marked: false }
    }
}

/// A chart with linear axes from 0. A curve has the colour of the series before it.
pub(crate) struct Chart<'a> {
    pub(crate) title: &'a str,
    pub(crate) x: &'a str,
    pub(crate) y: &'a str,
    pub(crate) series: Vec<Series>,
}

impl Chart<'_> {
    /// Returns the chart as SVG, or `None` if there are no points. `source` tells where and when its figures were
    /// measured.
    pub(crate) fn svg(&self, source: &str) -> Result<Option<String>, Box<dyn Error>> {
        let shown: Vec<&Series> = self.series.iter().filter(|series| !series.points.is_empty()).collect();
        if shown.is_empty() {
            return Ok(None);
        }
        let points = || shown.iter().flat_map(|series| &series.points);
        let most_x = points().map(|(point, _)| point.0).fold(f64::MIN_POSITIVE, f64::max);
        let most_y = points().map(|(point, range)| range.map_or(point.1, |[_, most]| most));
        let most_y = most_y.fold(f64::MIN_POSITIVE, f64::max);
        let svg = drawing(SIZE, self.title, |root| {
            heading(root, self.title, source)?;
            let mut chart = ChartBuilder::on(root)
                .margin_top(60)
                .margin_right(WIDTH as i32 - LEGEND_X + 15)
                .margin_left(8)
                .margin_bottom(8)
                .x_label_area_size(44)
                .y_label_area_size(72)
                .build_cartesian_2d(0.0..1.03 * most_x, 0.0..1.06 * most_y)?;
            chart
                .configure_mesh()
                .light_line_style(TRANSPARENT)
                .bold_line_style(GRID)
                .axis_style(INK)
                .label_style((FONT, 13).into_font().color(&INK))
                .axis_desc_style((FONT, 14).into_font().color(&INK))
                .x_desc(self.x)
                .y_desc(self.y)
                .x_label_formatter(&label)
                .y_label_formatter(&label)
                .draw()?;
            let mut legend = Legend::new(root);
            let mut index = 0;
            for series in &shown {
                let look = index - usize::from(!series.marked && index > 0);
                let (tone, width) = (color(look), if series.marked { 1 } else { 2 });
                let pixels: Vec<_> = series.points.iter().map(|(point, _)| chart.backend_coord(point)).collect();
                root.draw(&PathElement::new(pixels.clone(), tone.stroke_width(width)))?;
                for (point, range) in &series.points {
                    if let Some(range) = range {
                        let [from, to] = range.map(|y| chart.backend_coord(&(point.0, y)));
                        error_bar(root, from, to, tone)?;
                    }
                }
                for pixel in pixels.into_iter().filter(|_| series.marked) {
                    marker(root, look, pixel, tone.filled(), WHITE.into())?;
                }
                legend.entry(&series.name, |root, (x, y)| {
                    root.draw(&PathElement::new(vec![(x - 12, y), (x + 12, y)], tone.stroke_width(width)))?;
                    if series.marked { marker(root, look, (x, y), tone.filled(), WHITE.into()) } else { Ok(()) }
                })?;
                index += usize::from(series.marked);
            }
            match points().any(|(_, range)| range.is_some()) {
                true => legend.error_bars(),
                false => Ok(()),
            }
        })?;
        Ok(Some(svg))
    }
}

/// Formats a value on an axis, rounded to six decimals.
fn label(value: &f64) -> String {
    format!("{}", (value * 1e6).round() / 1e6)
}
