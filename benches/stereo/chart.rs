//! Draws the chart: errors of colours and of surfaces against cost, with one point per method and scene. A line shows
//! the frontier of the methods' means.

use std::error::Error;

use plotters::prelude::*;
use stereotrace::metrics::Difference;

use crate::common::{
    chart::{Area, Drawn, INK, Legend, Panel, Pixel, Point, WIDTH, axes, drawing, frontier, heading},
    looks,
    measure::{Measured, MethodFigures, Plan},
    provenance::Provenance,
};

/// Size of the chart, which has two panels, one above the other.
const SIZE: (u32, u32) = (WIDTH, 960);
/// Distance between methods in the row of zero, in pixels.
const ZERO_STEP: i32 = 10;
const COST: &str = "cost of the second eye by time (first eye = 1)";

/// An error in percent.
type Percent = fn(&Difference) -> f64;

/// A method on a scene: its point in the chart, and its minimum and maximum cost over the rounds.
#[derive(Clone, Copy)]
struct Placed {
    point: Point,
    costs: [f64; 2],
}

pub(crate) fn svg(measured: &[Measured], plan: &Plan, provenance: &Provenance) -> Result<String, Box<dyn Error>> {
    let panels: [(Panel<'_>, Percent); 2] = [
        (Panel { rows: 60..500, x: COST, y: "pixels that differ from naive's, %" }, |d| d.differing_percent),
        (Panel { rows: 512..952, x: COST, y: "wrong surface, % of pixels" }, |d| d.wrong_surface_percent),
    ];
    let [width, height] = plan.size;
    let title = format!("Accuracy against cost: {width}x{height}, {}", plan.eyes());
    let of_scenes = measured.iter().take(1).flat_map(|scene| &scene.methods);
    let names: Vec<String> = of_scenes.map(|figures| figures.method.to_string()).collect();
    let looks: Vec<usize> = names.iter().map(|name| looks::of_method(name)).collect();
    drawing(SIZE, &title, |root| {
        heading(root, &title, &provenance.source())?;
        for (panel, error) in panels {
            let placed = |m: &MethodFigures| Placed {
                point: (m.second_eye.median, error(&m.difference)),
                costs: [m.second_eye.min, m.second_eye.max],
            };
            let scenes: Vec<Vec<Placed>> =
                measured.iter().map(|scene| scene.methods.iter().map(placed).collect()).collect();
            draw(root, &panel, &scenes, &looks)?;
        }
        let mut legend = Legend::new(root);
        legend.markers("method", looks.iter().copied().zip(names.iter().map(String::as_str)), None)?;
        legend.scene_numbers(measured.iter().map(|scene| scene.scene.as_str()))?;
        legend.means()?;
        legend.error_bars()
    })
}

/// Draws a panel. `scenes` holds the methods of each scene.
fn draw(root: &Area<'_>, panel: &Panel<'_>, scenes: &[Vec<Placed>], looks: &[usize]) -> Drawn {
    let points: Vec<Vec<Point>> =
        scenes.iter().map(|scene| scene.iter().map(|placed| placed.point).collect()).collect();
    let means = means(&points);
    // The axes must include the bars' ends and the means, since a mean can be below all nonzero errors.
    let ends = scenes.iter().flatten().map(|placed| (placed.costs[1], placed.point.1));
    let place = axes(root, &ends.chain(means.iter().copied()).collect::<Vec<_>>(), panel)?;
    // In the row of zero, methods would hide each other, so each method is drawn at its own height there.
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
    let all = || scenes.iter().enumerate().flat_map(|(scene, row)| row.iter().enumerate().map(move |of| (scene, of)));
    for (_, (method, placed)) in all() {
        let [from, to] = placed.costs.map(|cost| place(method, (cost.max(0.0), placed.point.1)));
        looks::error_bar(root, from, to, looks::color(looks[method]))?;
    }
    for (scene, (method, placed)) in all() {
        looks::numbered(root, looks[method], (scenes.len() > 1).then_some(scene + 1), place(method, placed.point))?;
    }
    for method in frontier {
        looks::marker(root, looks[method], place(method, means[method]), WHITE.filled(), INK.stroke_width(2))?;
    }
    Ok(())
}

/// Returns the mean point of each method over the scenes.
fn means(points: &[Vec<Point>]) -> Vec<Point> {
    let methods = points.first().map_or(0, Vec::len);
    let mean = |method: usize, part: fn(Point) -> f64| {
        points.iter().map(|scene| part(scene[method])).sum::<f64>() / points.len() as f64
    };
    (0..methods).map(|method| (mean(method, |p| p.0), mean(method, |p| p.1))).collect()
}
