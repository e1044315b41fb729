//! Draws the chart: the second eye's colour error and the first eye's cost against the second eye's cost.

use std::error::Error;

use plotters::prelude::*;

use crate::{
    Figures,
    common::{
        chart::{INK, Legend, Panel, Point, WIDTH, axes, drawing, heading},
        looks::{error_bar, marker, scene_color},
        provenance::Provenance,
    },
};

/// Size of the chart, which has two panels, one above the other.
const SIZE: (u32, u32) = (WIDTH, 960);
const COST: &str = "cost of the second eye by time (first eye = 1)";

/// A figure, with its minimum and maximum over the rounds.
type Figure = fn(&Figures) -> [f64; 3];

pub(crate) fn svg(all: &[Figures], side: u32, provenance: &Provenance) -> Result<String, Box<dyn Error>> {
    let panels: [(Panel<'_>, Figure); 2] = [
        (Panel { rows: 60..500, x: COST, y: "mean distance from naive's colours, of 255" }, |f| [f.distance; 3]),
        (Panel { rows: 512..952, x: COST, y: "cost of the first eye (without lights = 1)" }, |f| {
            [f.first.median, f.first.min, f.first.max]
        }),
    ];
    let [mut names, mut scenes] = [Vec::new(), Vec::new()];
    for figures in all {
        (!names.contains(&figures.finish)).then(|| names.push(figures.finish));
        (!scenes.contains(&figures.scene.as_str())).then(|| scenes.push(&figures.scene));
    }
    let place_of = |list: &[&str], name: &str| list.iter().position(|other| *other == name).unwrap_or(0);
    let title = format!("bracket by what pictures show: {side}x{side}");
    drawing(SIZE, &title, |root| {
        heading(root, &title, &provenance.source())?;
        for (panel, value) in panels {
            let ends: Vec<Point> = all.iter().flat_map(|f| value(f).map(|y| (f.second.max.max(0.0), y))).collect();
            let place = axes(root, &ends, &panel)?;
            for figures in all {
                let tone = scene_color(place_of(&scenes, &figures.scene));
                let [y, low, high] = value(figures);
                let x = [figures.second.median, figures.second.min, figures.second.max].map(|cost| cost.max(0.0));
                error_bar(root, place((x[1], y)), place((x[2], y)), tone)?;
                if low < high {
                    error_bar(root, place((x[0], low)), place((x[0], high)), tone)?;
                }
                marker(root, place_of(&names, figures.finish), place((x[0], y)), tone.filled(), WHITE.into())?;
            }
        }
        let mut legend = Legend::new(root);
        legend.markers("picture", names.iter().copied().enumerate(), Some(INK))?;
        legend.scene_colors(scenes.iter().copied())?;
        legend.head("bars")?;
        legend.error_bars()
    })
}
