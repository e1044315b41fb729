//! Figures as the paper draws them: marked points over even axes, with curves through them.

use std::error::Error;

use plotters::{
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use crate::{
    common::chart::{FONT, GRID, INK, LEGEND_LINE, LEGEND_X, SIZE, color, heading, marker},
    fits::Point,
};

/// Points of one name, or a curve.
pub(crate) struct Series {
    name: String,
    points: Vec<Point>,
    marked: bool,
}

impl Series {
    pub(crate) fn marked(name: String, points: Vec<Point>) -> Self {
        Self { name, points, marked: true }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    pub(crate) fn curve(name: &str, points: Vec<Point>) -> Self {
        Self { name: name.into(), points, marked: false }
    }
}

/// A figure: even axes from 0 on. A curve has the colour of the series before it.
pub(crate) struct Chart<'a> {
    pub(crate) title: &'a str,
    pub(crate) x: &'a str,
    pub(crate) y: &'a str,
    pub(crate) series: Vec<Series>,
}

impl Chart<'_> {
    /// As SVG; `source` is where and when its figures were taken. `None` where there is no point to draw.
    pub(crate) fn svg(&self, source: &str) -> Result<Option<String>, Box<dyn Error>> {
        let shown: Vec<&Series> = self.series.iter().filter(|series| !series.points.is_empty()).collect();
        if shown.is_empty() {
            return Ok(None);
        }
        let most = |of: fn(&Point) -> f64| {
            shown.iter().flat_map(|series| &series.points).map(of).fold(f64::MIN_POSITIVE, f64::max)
        };
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
            root.fill(&WHITE)?;
            heading(&root, self.title, source)?;
            let mut chart = ChartBuilder::on(&root)
                .margin_top(60)
                .margin_right(SIZE.0 as i32 - LEGEND_X + 15)
                .margin_left(8)
                .margin_bottom(8)
                .x_label_area_size(44)
                .y_label_area_size(72)
                .build_cartesian_2d(0.0..1.03 * most(|point| point.0), 0.0..1.06 * most(|point| point.1))?;
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
            let (mut index, mut legend) = (0, 74);
            for series in shown {
                let tone = color(index - usize::from(!series.marked && index > 0));
                let pixels: Vec<(i32, i32)> = series.points.iter().map(|point| chart.backend_coord(point)).collect();
                root.draw(&PathElement::new(pixels.clone(), tone.stroke_width(if series.marked { 1 } else { 2 })))?;
                let sample = vec![(LEGEND_X - 4, legend), (LEGEND_X + 20, legend)];
                root.draw(&PathElement::new(sample, tone.stroke_width(if series.marked { 1 } else { 2 })))?;
                if series.marked {
                    for pixel in pixels.into_iter().chain([(LEGEND_X + 8, legend)]) {
                        marker(&root, index, pixel, tone.filled(), WHITE.into())?;
                    }
                    index += 1;
                }
                let style = (FONT, 12).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
                for (line, words) in series.name.split(", ").enumerate() {
                    let at = (LEGEND_X + 26, legend + line as i32 * (LEGEND_LINE - 4));
                    root.draw(&Text::new(words.to_owned(), at, style.clone()))?;
                }
                legend += LEGEND_LINE + (series.name.matches(", ").count() as i32) * (LEGEND_LINE - 4);
            }
            root.present()?;
        }
        Ok(Some(text))
    }
}

/// A place on an axis, as short as it is round.
fn label(value: &f64) -> String {
    format!("{}", (value * 1e6).round() / 1e6)
}
