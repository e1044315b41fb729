//! The chart: pixels that differ against cost, one point a method and trial.

use std::{cmp::Reverse, error::Error};

use plotters::{
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use crate::{
    common::{
        chart::{FONT, INK, LEGEND_LINE, LEGEND_X, Panel, Point, SIZE, axes, color, heading, marker},
        provenance::Provenance,
    },
    options::Plan,
    trials::Row,
};

pub(crate) fn svg(rows: &[Row], plan: &Plan, provenance: &Provenance) -> Result<String, Box<dyn Error>> {
    // Each with its method's place; those that failed have no point.
    let mut points: Vec<(usize, Point)> = rows
        .iter()
        .filter_map(|row| {
            let figures = row.figures.as_ref().ok()?;
            let method = plan.methods.iter().position(|&method| method == row.method)?;
            Some((method, (figures.second_eye, figures.difference.differing_percent)))
        })
        .collect();
    // Methods whose pictures and costs are the same share a place: the first one is drawn last.
    points.sort_by_key(|(method, _)| Reverse(*method));
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let [width, height] = plan.size;
        let title = format!("Stability: {} trials, {width}x{height}", plan.trials.len());
        heading(&root, &title, &format!("{}, {}", provenance.adapter, provenance.day()))?;
        let panel = Panel {
            rows: 60..SIZE.1 - 8,
            x: "cost of the second eye by counters (first eye = 1)",
            y: "pixels that differ from naive's, %",
        };
        let all: Vec<Point> = points.iter().map(|(_, point)| *point).collect();
        let place = axes(&root, &all, &panel)?;
        for (method, point) in points {
            marker(&root, method, place(point), color(method).filled(), WHITE.into())?;
        }
        let mut y = 70;
        let style = (FONT, 13).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
        for (index, method) in plan.methods.iter().enumerate() {
            marker(&root, index, (LEGEND_X + 8, y), color(index).filled(), WHITE.into())?;
            root.draw(&Text::new(method.to_string(), (LEGEND_X + 24, y), style.clone()))?;
            y += LEGEND_LINE;
        }
        for line in ["where markers meet,", "the upper name's is seen"] {
            root.draw(&Text::new(line, (LEGEND_X, y + 6), style.clone()))?;
            y += LEGEND_LINE - 3;
        }
        root.present()?;
    }
    Ok(text)
}
