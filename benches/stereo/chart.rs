//! The chart: accuracy against cost, one point a method and scene, with the frontier of the methods' means.

use std::error::Error;

use plotters::{
    coord::Shift,
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use crate::common::{
    chart::{FONT, GRID, INK, Point, frontier},
    measure::{Measured, Plan},
    provenance::Provenance,
    scenes,
};

const SIZE: (u32, u32) = (800, 500);
/// Where the legend's column begins and the plot ends.
const LEGEND_X: i32 = 625;
const LEGEND_LINE: i32 = 19;
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

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Pixel = (i32, i32);

pub(crate) fn svg(measured: &[Measured], plan: &Plan, provenance: &Provenance) -> Result<String, Box<dyn Error>> {
    let points: Vec<Vec<Point>> = measured
        .iter()
        .map(|scene| scene.methods.iter().map(|m| (m.second_eye, m.difference.wrong_surface_percent)).collect())
        .collect();
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let place = axes(&root, &points, plan, provenance)?;
        let means = means(&points);
        let frontier = frontier(&means);
        let line: Vec<Pixel> = frontier.iter().map(|&method| place(means[method])).collect();
        root.draw(&PathElement::new(line, INK.stroke_width(2)))?;
        for (scene, points) in points.iter().enumerate() {
            for (method, &point) in points.iter().enumerate() {
                marker(&root, method, place(point), color(scene).filled(), WHITE.into())?;
            }
        }
        for method in frontier {
            marker(&root, method, place(means[method]), WHITE.filled(), INK.stroke_width(2))?;
        }
        legend(&root, measured)?;
        root.present()?;
    }
    Ok(text)
}

/// Axes, grid and titles. Returns where a point goes.
fn axes(
    root: &Area<'_>,
    points: &[Vec<Point>],
    plan: &Plan,
    provenance: &Provenance,
) -> Result<impl Fn(Point) -> Pixel + use<>, Box<dyn Error>> {
    let scale = LogScale::of(points.iter().flatten().map(|point| point.1));
    let dearest = points.iter().flatten().fold(1.0, |most: f64, point| most.max(point.0));
    let [width, height] = plan.size;
    let title = format!("Accuracy against cost: {width}x{height}, e = {} px", plan.e_px);
    root.draw(&Text::new(title, (20, 14), (FONT, 17).into_font().color(&INK)))?;
    let source = format!("{}, {}", provenance.adapter, provenance.day());
    root.draw(&Text::new(source, (20, 36), (FONT, 12).into_font().color(&INK)))?;

    let mut chart = ChartBuilder::on(root)
        .margin_top(60)
        .margin_right(SIZE.0 as i32 - LEGEND_X + 15)
        .margin_left(8)
        .margin_bottom(8)
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
        .x_desc("cost of the second eye by time (first eye = 1)")
        .y_desc("wrong surface, % of pixels")
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

fn legend(root: &Area<'_>, measured: &[Measured]) -> Result<(), Box<dyn Error>> {
    let style = |size: i32| (FONT, size).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
    let mut y = 70;
    let mut line = |step: i32| {
        y += step;
        y
    };
    let text = |text: &str, x, y, size| root.draw(&Text::new(text.to_owned(), (LEGEND_X + x, y), style(size)));
    text("method", 0, line(0), 14)?;
    for (method, figures) in measured.iter().take(1).flat_map(|scene| &scene.methods).enumerate() {
        let y = line(LEGEND_LINE);
        marker(root, method, (LEGEND_X + 8, y), INK.filled(), WHITE.into())?;
        text(&figures.method.to_string(), 24, y, 13)?;
    }
    text("scene", 0, line(LEGEND_LINE + 12), 14)?;
    for (index, scene) in measured.iter().enumerate() {
        let y = line(LEGEND_LINE);
        root.draw(&Rectangle::new([(LEGEND_X, y - 4), (LEGEND_X + 16, y + 4)], color(index).filled()))?;
        text(scenes::title(&scene.scene), 24, y, 13)?;
    }
    let y = line(LEGEND_LINE + 14);
    root.draw(&PathElement::new(vec![(LEGEND_X - 4, y), (LEGEND_X + 20, y)], INK.stroke_width(2)))?;
    root.draw(&Circle::new((LEGEND_X + 8, y), 6, WHITE.filled()))?;
    root.draw(&Circle::new((LEGEND_X + 8, y), 6, INK.stroke_width(2)))?;
    text("means of all scenes,", 28, y, 13)?;
    text("on the frontier", 28, line(LEGEND_LINE - 3), 13)?;
    Ok(())
}

/// A method's marker, with a rim so that neighbours stand apart.
fn marker(
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

fn color(scene: usize) -> RGBColor {
    COLORS[scene % COLORS.len()]
}

/// Mean point of each method over the scenes.
fn means(points: &[Vec<Point>]) -> Vec<Point> {
    let methods = points.first().map_or(0, Vec::len);
    let mean = |method: usize, part: fn(Point) -> f64| {
        points.iter().map(|scene| part(scene[method])).sum::<f64>() / points.len() as f64
    };
    (0..methods).map(|method| (mean(method, |p| p.0), mean(method, |p| p.1))).collect()
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
