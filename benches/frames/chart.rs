//! Draws the chart: how far pictures of films differ from naive's, and how much they flicker, against the cost of a
//! pair.

use std::error::Error;

use super::{Figures, Film, Sampled, methods};
use crate::common::{
    chart::{Drawn, Legend, Panel, Point, WIDTH, axes, drawing, heading},
    looks,
    provenance::Provenance,
};

/// Size of the chart, which has two panels, one above the other.
const SIZE: (u32, u32) = (WIDTH, 960);
const COST: &str = "time of a pair (naive = 1)";

/// A percentage of a film.
type Percent = fn(&Figures) -> f64;

pub(super) fn svg(
    films: &[Film],
    [width, height]: [u32; 2],
    provenance: &Provenance,
) -> Result<String, Box<dyn Error>> {
    let panels: [(Panel<'_>, Percent); 2] = [
        (Panel { rows: 60..500, x: COST, y: "pixels that differ from naive's, %" }, |figures| {
            100.0 - figures.identical
        }),
        (Panel { rows: 512..952, x: COST, y: "pixels that flicker, %" }, Figures::flicker),
    ];
    let title = format!("Films, accuracy against cost: {width}x{height}");
    let mut names: Vec<&str> = films.iter().map(|film| film.scene.as_str()).collect();
    names.dedup();
    // Naive's own point says nothing.
    let drawn: Vec<(usize, &str)> = methods(Sampled::default())
        .iter()
        .map(|(name, _)| *name)
        .skip(1)
        .map(|name| (looks::of_method(name), name))
        .collect();
    drawing(SIZE, &title, |root| {
        heading(root, &title, &provenance.source())?;
        for (panel, percent) in panels {
            let points = |film: &Film| -> Vec<Point> {
                let times = film.times();
                let point = |(figures, ms): (&Figures, &f64)| (ms / times[0], percent(figures).max(0.0));
                film.figures.iter().zip(&times).skip(1).map(point).collect()
            };
            let all: Vec<Vec<Point>> = films.iter().map(points).collect();
            let place = axes(root, &all.concat(), &panel)?;
            for (film, points) in films.iter().zip(&all) {
                let number = names.iter().position(|name| *name == film.scene).map(|scene| scene + 1);
                let draw = |(&point, &(look, _)): (&Point, &(usize, &str))| -> Drawn {
                    looks::numbered(root, look, number, place(point))
                };
                points.iter().zip(&drawn).try_for_each(draw)?;
            }
        }
        let mut legend = Legend::new(root);
        legend.markers("method", drawn.iter().copied(), None)?;
        legend.scene_numbers(names.iter().copied())
    })
}
