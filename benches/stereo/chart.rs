//! The chart: accuracy, by colours and by surfaces, against cost; one point a method and scene, with the frontier of the
//! methods' means.

use std::error::Error;

use plotters::{
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};
use stereotrace::metrics::Difference;

use crate::common::{
    chart::{Area, FONT, INK, LEGEND_LINE, LEGEND_X, Panel, Pixel, Point, axes, color, frontier, heading, marker},
    measure::{Measured, MethodFigures, Plan},
    provenance::Provenance,
    scenes,
};

/// Two panels, one above the other.
const SIZE: (u32, u32) = (800, 860);
/// Pixels from method to method in the row of zero.
const ZERO_STEP: i32 = 8;
const COST: &str = "cost of the second eye by time (first eye = 1)";

/// A figure that is an error, in percent.
type Percent = fn(&Difference) -> f64;

pub(crate) fn svg(measured: &[Measured], plan: &Plan, provenance: &Provenance) -> Result<String, Box<dyn Error>> {
    let panels: [(Panel<'_>, Percent); 2] = [
        (Panel { rows: 60..450, x: COST, y: "pixels that differ from naive's, %" }, |d| d.differing_percent),
        (Panel { rows: 462..852, x: COST, y: "wrong surface, % of pixels" }, |d| d.wrong_surface_percent),
    ];
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let [width, height] = plan.size;
        let title = format!("Accuracy against cost: {width}x{height}, e = {} px", plan.e_px);
        heading(&root, &title, &format!("{}, {}", provenance.adapter, provenance.day()))?;
        for (panel, error) in panels {
            let point = |m: &MethodFigures| (m.second_eye, error(&m.difference));
            let points: Vec<Vec<Point>> =
                measured.iter().map(|scene| scene.methods.iter().map(point).collect()).collect();
            draw(&root, &panel, &points)?;
        }
        legend(&root, measured)?;
        root.present()?;
    }
    Ok(text)
}

/// `points` by scene and method.
fn draw(root: &Area<'_>, panel: &Panel<'_>, points: &[Vec<Point>]) -> Result<(), Box<dyn Error>> {
    let means = means(points);
    // A mean can lie below all errors but zero.
    let place = axes(root, &[points.concat(), means.clone()].concat(), panel)?;
    // In the row of zero methods would hide each other: they stand one below the other there.
    let exact: Vec<usize> =
        (0..means.len()).filter(|&method| points.iter().any(|scene| scene[method].1 <= 0.0)).collect();
    let place = |method: usize, point: Point| {
        let (x, y) = place(point);
        let line = exact.iter().position(|&other| other == method).filter(|_| point.1 <= 0.0);
        (x, line.map_or(y, |line| y + (2 * line as i32 + 1 - exact.len() as i32) * ZERO_STEP / 2))
    };
    let frontier = frontier(&means);
    let line: Vec<Pixel> = frontier.iter().map(|&method| place(method, means[method])).collect();
    root.draw(&PathElement::new(line, INK.stroke_width(2)))?;
    for (scene, points) in points.iter().enumerate() {
        for (method, &point) in points.iter().enumerate() {
            marker(root, method, place(method, point), color(scene).filled(), WHITE.into())?;
        }
    }
    for method in frontier {
        marker(root, method, place(method, means[method]), WHITE.filled(), INK.stroke_width(2))?;
    }
    Ok(())
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

/// Mean point of each method over the scenes.
fn means(points: &[Vec<Point>]) -> Vec<Point> {
    let methods = points.first().map_or(0, Vec::len);
    let mean = |method: usize, part: fn(Point) -> f64| {
        points.iter().map(|scene| part(scene[method])).sum::<f64>() / points.len() as f64
    };
    (0..methods).map(|method| (mean(method, |p| p.0), mean(method, |p| p.1))).collect()
}
