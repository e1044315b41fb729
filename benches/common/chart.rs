//! What the charts share: their look, axes by decades, markers, and the frontier.

use std::{error::Error, ops::Range};

use plotters::{coord::Shift, prelude::*};

pub const FONT: &str = "sans-serif";
pub const INK: RGBColor = RGBColor(40, 40, 40);
pub const GRID: RGBColor = RGBColor(225, 225, 225);

pub const SIZE: (u32, u32) = (800, 500);
/// Where the legend's column begins and the plot ends.
pub const LEGEND_X: i32 = 625;
pub const LEGEND_LINE: i32 = 19;
/// Okabe and Ito's colours, that the colour-blind can tell apart, with brown for their yellow.
const COLORS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(140, 81, 10),
];

pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub type Pixel = (i32, i32);

/// A point of a chart: cost of the second eye relative to the first, and an error.
pub type Point = (f64, f64);

/// Which points no other one beats in cost without losing in accuracy, cheapest first.
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

/// What is written above a chart; `source` is where and when its figures were taken.
pub fn heading(root: &Area<'_>, title: &str, source: &str) -> Result<(), Box<dyn Error>> {
    root.draw(&Text::new(title, (20, 14), (FONT, 17).into_font().color(&INK)))?;
    root.draw(&Text::new(source, (20, 36), (FONT, 12).into_font().color(&INK)))?;
    Ok(())
}

/// A plot's place on the chart, and what is written beside its axes.
pub struct Panel<'a> {
    /// From its top to below its labels, in pixels.
    pub rows: Range<u32>,
    pub x: &'a str,
    pub y: &'a str,
}

/// Axes and grid; errors are in percent, by decades, with zero in a row of its own. Returns where a point goes.
pub fn axes(
    root: &Area<'_>,
    points: &[Point],
    panel: &Panel<'_>,
) -> Result<impl Fn(Point) -> Pixel + use<>, Box<dyn Error>> {
    let scale = LogScale::of(points.iter().map(|point| point.1));
    let dearest = points.iter().fold(1.0, |most: f64, point| most.max(point.0));
    let mut chart = ChartBuilder::on(root)
        .margin_top(panel.rows.start)
        .margin_right(SIZE.0 as i32 - LEGEND_X + 15)
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

/// A method's marker, with a rim so that neighbours stand apart.
pub fn marker(
    root: &Area<'_>,
    method: usize,
    (x, y): Pixel,
    fill: ShapeStyle,
    rim: ShapeStyle,
) -> Result<(), Box<dyn Error>> {
    let outline: &[Pixel] = match method % 6 {
        0 => &[(-5, -5), (5, -5), (5, 5), (-5, 5)],
        1 => &[(0, -7), (7, 0), (0, 7), (-7, 0)],
        2 => {
            root.draw(&Circle::new((x, y), 6, fill))?;
            root.draw(&Circle::new((x, y), 6, rim))?;
            return Ok(());
        }
        3 => &[(0, -7), (7, 5), (-7, 5)],
        4 => &[(0, 7), (7, -5), (-7, -5)],
        _ => &[
            (-7, -2),
            (-2, -2),
            (-2, -7),
            (2, -7),
            (2, -2),
            (7, -2),
            (7, 2),
            (2, 2),
            (2, 7),
            (-2, 7),
            (-2, 2),
            (-7, 2),
        ],
    };
    let mut corners: Vec<Pixel> = outline.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
    root.draw(&Polygon::new(corners.clone(), fill))?;
    corners.extend_from_within(..2); // twice round the first side: the last corner is as sharp as the others
    root.draw(&PathElement::new(corners, rim))?;
    Ok(())
}

/// The colour of a scene or method by its place.
pub fn color(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

/// A row a decade; zero is a row below the lowest one.
#[derive(Clone, Copy)]
struct LogScale {
    /// Decimal logarithms.
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

    /// A number of labels that leaves each row its own.
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
