//! The chart: accuracy against cost, one point a method and scene, with the frontier of the methods' means.

use std::error::Error;

use plotters::{
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use crate::common::{
    chart::{Area, FONT, INK, LEGEND_LINE, LEGEND_X, Pixel, Point, SIZE, Titles, axes, color, frontier, marker},
    measure::{Measured, Plan},
    provenance::Provenance,
    scenes,
};

pub(crate) fn svg(measured: &[Measured], plan: &Plan, provenance: &Provenance) -> Result<String, Box<dyn Error>> {
    let points: Vec<Vec<Point>> = measured
        .iter()
        .map(|scene| scene.methods.iter().map(|m| (m.second_eye, m.difference.wrong_surface_percent)).collect())
        .collect();
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let [width, height] = plan.size;
        let titles = Titles {
            title: format!("Accuracy against cost: {width}x{height}, e = {} px", plan.e_px),
            source: format!("{}, {}", provenance.adapter, provenance.day()),
            x: "cost of the second eye by time (first eye = 1)",
            y: "wrong surface, % of pixels",
        };
        let place = axes(&root, &points.concat(), titles)?;
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
