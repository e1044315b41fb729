//! Shared parts of the charts: width, logarithmic axes, legends, and the frontier.

use std::{error::Error, ops::Range};

use plotters::{
    coord::Shift,
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use super::{
    looks::{color, marker, scene_color},
    scenes,
    text::{escape, printable},
};

pub const FONT: &str = "sans-serif";
pub const INK: RGBColor = RGBColor(40, 40, 40);
pub const GRID: RGBColor = RGBColor(225, 225, 225);

/// Width of a chart in pixels. Pages and documents scale charts to their own width.
pub const WIDTH: u32 = 1000;
/// Size of a chart with one panel.
pub const SIZE: (u32, u32) = (WIDTH, 560);
/// x where the plot ends and the legend's column begins.
pub const LEGEND_X: i32 = 800;
const LEGEND_TOP: i32 = 70;
const LEGEND_LINE: i32 = 19;
/// Distance from the left end of the legend's column to the text of its entries.
const LEGEND_INDENT: i32 = 26;

pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub type Pixel = (i32, i32);
pub type Drawn = Result<(), Box<dyn Error>>;

/// A point of a chart: the cost of the second eye relative to the first, and an error.
pub type Point = (f64, f64);

/// Returns the indices of the Pareto-optimal points, cheapest first.
pub fn frontier(points: &[Point]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1)));
    let mut best = f64::INFINITY;
    order.retain(|&index| {
        let better = points[index].1 < best;
        best = best.min(points[index].1);
        better
    });
    order
}

/// Draws an SVG with a white background that fills the width of its container.
pub fn drawing(size: (u32, u32), title: &str, draw: impl FnOnce(&Area<'_>) -> Drawn) -> Result<String, Box<dyn Error>> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        draw(&root)?;
        root.present()?;
    }
    let own = format!("<svg width=\"{}\" height=\"{}\" ", size.0, size.1);
    Ok(svg.replacen(&own, &format!("<svg role=\"img\" aria-label=\"{}\" width=\"100%\" ", escape(title)), 1))
}

/// Draws a chart's title. `source` tells where and when its figures were measured.
pub fn heading(root: &Area<'_>, title: &str, source: &str) -> Drawn {
    text(root, title, (20, 22), 17)?;
    text(root, source, (20, 43), 12)
}

/// Draws text that starts at a point and is vertically centred on it.
pub fn text(root: &Area<'_>, text: &str, at: Pixel, size: i32) -> Drawn {
    let style = (FONT, size).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
    Ok(root.draw(&Text::new(printable(text), at, style))?)
}

/// Returns the style of text that is centred on its point.
pub fn anchored(size: i32, color: &RGBColor) -> TextStyle<'_> {
    TextStyle::from((FONT, size).into_font()).color(color).pos(Pos::new(HPos::Center, VPos::Center))
}

/// The legend beside a plot. All charts have it in the same column, with the same layout.
pub struct Legend<'a, 'b> {
    root: &'a Area<'b>,
    y: i32,
}

impl<'a, 'b> Legend<'a, 'b> {
    /// x of the centres of the legend's markers.
    const MARKER_X: i32 = LEGEND_X + 8;

    pub fn new(root: &'a Area<'b>) -> Self {
        Self { root, y: LEGEND_TOP }
    }

    /// Starts a group of entries with a heading.
    pub fn head(&mut self, words: &str) -> Drawn {
        if self.y > LEGEND_TOP {
            self.y += LEGEND_LINE / 2;
        }
        text(self.root, words, (LEGEND_X, self.y), 14)?;
        self.y += LEGEND_LINE;
        Ok(())
    }

    /// Adds an entry, with a symbol that `draw` puts in front of it. The text is broken into lines after each `, `.
    pub fn entry(&mut self, words: &str, draw: impl FnOnce(&Area<'_>, Pixel) -> Drawn) -> Drawn {
        draw(self.root, (Self::MARKER_X, self.y))?;
        for line in words.split_inclusive(", ") {
            text(self.root, line.trim_end(), (LEGEND_X + LEGEND_INDENT, self.y), 13)?;
            self.y += LEGEND_LINE - 3;
        }
        self.y += 3;
        Ok(())
    }

    /// Adds entries for markers of these looks, in their own colours or all in `tone`.
    pub fn markers<'c>(
        &mut self,
        head: &str,
        names: impl IntoIterator<Item = (usize, &'c str)>,
        tone: Option<RGBColor>,
    ) -> Drawn {
        self.head(head)?;
        for (look, name) in names {
            let fill = tone.unwrap_or(color(look));
            self.entry(name, |root, at| marker(root, look, at, fill.filled(), WHITE.into()))?;
        }
        Ok(())
    }

    /// Adds an entry for each scene, in the colour of the scene's index.
    pub fn scene_colors<'c>(&mut self, names: impl IntoIterator<Item = &'c str>) -> Drawn {
        self.head("scene")?;
        for (place, name) in names.into_iter().enumerate() {
            self.entry(scenes::title(name), |root, (x, y)| {
                let corners = [(x - 8, y - 4), (x + 8, y + 4)];
                Ok(root.draw(&Rectangle::new(corners, scene_color(place).filled()))?)
            })?;
        }
        Ok(())
    }

    /// Adds an entry for each scene with its number, counted from 1. Methods' markers contain these numbers.
    pub fn scene_numbers<'c>(&mut self, names: impl IntoIterator<Item = &'c str>) -> Drawn {
        self.head("scene")?;
        for (place, name) in names.into_iter().enumerate() {
            let number = (place + 1).to_string();
            self.entry(scenes::title(name), |root, at| Ok(root.draw(&Text::new(number, at, anchored(13, &INK)))?))?;
        }
        Ok(())
    }

    /// Explains the line and the hollow markers of the frontier.
    pub fn means(&mut self) -> Drawn {
        self.y += LEGEND_LINE / 2;
        self.entry("means of all scenes, on the frontier", |root, (x, y)| {
            root.draw(&PathElement::new(vec![(x - 12, y), (x + 12, y)], INK.stroke_width(2)))?;
            root.draw(&Circle::new((x, y), 6, WHITE.filled()))?;
            Ok(root.draw(&Circle::new((x, y), 6, INK.stroke_width(2)))?)
        })
    }

    /// Explains the error bars.
    pub fn error_bars(&mut self) -> Drawn {
        self.entry("least to most of the rounds", |root, (x, y)| {
            super::looks::error_bar(root, (x - 9, y), (x + 9, y), INK)
        })
    }

    /// Adds lines of text without a marker.
    pub fn note(&mut self, lines: &[&str]) -> Drawn {
        self.y += LEGEND_LINE / 2;
        for line in lines {
            text(self.root, line, (LEGEND_X, self.y), 13)?;
            self.y += LEGEND_LINE - 3;
        }
        Ok(())
    }
}

/// Position of a plot on the chart, and the labels of its axes.
pub struct Panel<'a> {
    /// Pixel rows of the panel, including the labels below the plot.
    pub rows: Range<u32>,
    pub x: &'a str,
    pub y: &'a str,
}

/// Draws axes and grid, and returns a function from points to pixels. Errors are percentages on a logarithmic axis.
/// Zero has a separate row.
pub fn axes(
    root: &Area<'_>,
    points: &[Point],
    panel: &Panel<'_>,
) -> Result<impl Fn(Point) -> Pixel + use<>, Box<dyn Error>> {
    let scale = LogScale::of(points.iter().map(|point| point.1));
    let dearest = points.iter().fold(1.0, |most: f64, point| most.max(point.0));
    let mut chart = ChartBuilder::on(root)
        .margin_top(panel.rows.start)
        .margin_right(WIDTH as i32 - LEGEND_X + 15)
        .margin_left(8)
        .margin_bottom(root.dim_in_pixel().1 - panel.rows.end)
        .x_label_area_size(44)
        .y_label_area_size(62)
        .build_cartesian_2d(0.0..1.06 * dearest, scale.rows())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(INK)
        .label_style((FONT, 13).into_font().color(&INK))
        .axis_desc_style((FONT, 14).into_font().color(&INK))
        .x_desc(panel.x)
        .y_desc(panel.y)
        .x_labels(8)
        .x_label_formatter(&|x| format!("{x:.1}"))
        .y_labels(scale.labels())
        .y_label_formatter(&|row| scale.label(*row))
        .draw()?;
    // The axis is broken between zero and the lowest decade.
    let (x, y) = chart.backend_coord(&(0.0, scale.break_row()));
    root.draw(&Rectangle::new([(x - 2, y - 3), (x + 2, y + 3)], WHITE.filled()))?;
    for y in [y - 3, y + 3] {
        root.draw(&PathElement::new(vec![(x - 6, y + 3), (x + 6, y - 3)], INK))?;
    }
    let (left, right) = (chart.backend_coord(&(0.0, 0.0)).0, chart.backend_coord(&(1.0, 0.0)).0);
    let (zero, decade) = (chart.backend_coord(&(0.0, 0.0)).1, chart.backend_coord(&(0.0, 1.0)).1);
    Ok(move |(cost, percent): Point| {
        let x = f64::from(left) + cost * f64::from(right - left);
        let y = f64::from(zero) + scale.row(percent) * f64::from(decade - zero);
        (x.round() as i32, y.round() as i32)
    })
}

/// A logarithmic scale with one row per decade. Zero is one row below the lowest decade.
#[derive(Clone, Copy)]
struct LogScale {
    /// Decimal logarithms of the scale's ends.
    lowest: f64,
    highest: f64,
}

impl LogScale {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let logs = values.filter(|value| *value > 0.0).map(f64::log10);
        let (low, high) = logs.fold((0.0_f64, 1.0_f64), |(low, high), log| (low.min(log), high.max(log)));
        Self { lowest: low.floor(), highest: high.ceil() }
    }

    fn row(self, value: f64) -> f64 {
        if value > 0.0 { value.log10() } else { self.lowest - 1.0 }
    }

    fn rows(self) -> std::ops::Range<f64> {
        self.lowest - 1.3..self.highest
    }

    fn break_row(self) -> f64 {
        self.lowest - 0.5
    }

    /// Returns a number of labels that is large enough for one label per row.
    fn labels(self) -> usize {
        (self.highest - self.lowest) as usize + 3
    }

    fn label(self, row: f64) -> String {
        if row.fract() != 0.0 {
            return String::new();
        }
        if row < self.lowest { "0".into() } else { format!("{}", 10_f64.powf(row)) }
    }
}
