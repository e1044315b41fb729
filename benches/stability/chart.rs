//! Draws the chart: pixels that differ against cost, with one point per method and trial.

use std::{cmp::Reverse, error::Error};

use plotters::prelude::*;

use crate::{
    common::{
        chart::{Legend, Panel, Point, SIZE, axes, drawing, heading},
        looks,
        provenance::Provenance,
    },
    options::Plan,
    trials::Row,
};

pub(crate) fn svg(rows: &[Row], plan: &Plan, provenance: &Provenance) -> Result<String, Box<dyn Error>> {
    // Points with their methods' indices. Methods that failed on a trial have no point.
    let mut points: Vec<(usize, Point)> = rows
        .iter()
        .filter_map(|row| {
            let figures = row.figures.as_ref().ok()?;
            let method = plan.methods.iter().position(|&method| method == row.method)?;
            Some((method, (figures.second_eye, figures.difference.differing_percent)))
        })
        .collect();
    // Methods with equal pictures and costs have the same position. The first method is drawn last, above the others.
    points.sort_by_key(|(method, _)| Reverse(*method));
    let [width, height] = plan.size;
    let title = format!("Stability: {} trials, {width}x{height}", plan.trials.len());
    let names: Vec<String> = plan.methods.iter().map(ToString::to_string).collect();
    let looks: Vec<usize> = names.iter().map(|name| looks::of_method(name)).collect();
    drawing(SIZE, &title, |root| {
        heading(root, &title, &provenance.source())?;
        let panel = Panel {
            rows: 60..SIZE.1 - 8,
            x: "cost of the second eye by counters (first eye = 1)",
            y: "pixels that differ from naive's, %",
        };
        let all: Vec<Point> = points.iter().map(|(_, point)| *point).collect();
        let place = axes(root, &all, &panel)?;
        for (method, point) in points {
            let look = looks[method];
            looks::marker(root, look, place(point), looks::color(look).filled(), WHITE.into())?;
        }
        let mut legend = Legend::new(root);
        legend.markers("method", looks.iter().copied().zip(names.iter().map(String::as_str)), None)?;
        legend.note(&["where markers meet,", "the upper name's is seen"])
    })
}
