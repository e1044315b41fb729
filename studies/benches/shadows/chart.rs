//! Draws the chart: pixels with wrong shadows against the remaining shadow rays.

use std::error::Error;

use plotters::prelude::*;
use stereotrace::Method;

use crate::{
    Figures,
    common::{
        chart::{INK, Legend, Panel, Point, SIZE, axes, drawing, heading},
        looks::{marker, scene_color},
        provenance::Provenance,
    },
    name_of,
};

/// Draws the figures of naive pairs, with one line per scene and rule and one point per number of rows.
pub(crate) fn svg(all: &[Figures], size: [u32; 2], provenance: &Provenance) -> Result<String, Box<dyn Error>> {
    let shown: Vec<&Figures> = all.iter().filter(|figures| figures.method == Method::Naive).collect();
    let [mut names, mut rules, mut rows] = [Vec::new(), Vec::new(), Vec::new()];
    for figures in &shown {
        for (list, name) in [
            (&mut names, figures.scene.clone()),
            (&mut rules, name_of(figures.rule)),
            (&mut rows, figures.rows.to_string()),
        ] {
            if !list.contains(&name) {
                list.push(name);
            }
        }
    }
    let place = |list: &[String], name: &str| list.iter().position(|other| other == name).unwrap_or(0);
    let point = |figures: &Figures| -> Point { (1.0 - 0.01 * figures.saved[0], figures.wrong) };
    let [width, height] = size;
    let title = format!("Shadow-buffers, naive pairs of {width}x{height}, along each line {} rows", rows.join(", "));
    drawing(SIZE, &title, |root| {
        heading(root, &title, &provenance.source())?;
        let panel = Panel {
            rows: 60..SIZE.1 - 8,
            x: "shadow rays of a pair (all = 1)",
            y: "pixels with another colour than by rays, %",
        };
        let points: Vec<Point> = shown.iter().map(|figures| point(figures)).collect();
        let at = axes(root, &points, &panel)?;
        for (scene, rule) in names.iter().flat_map(|scene| rules.iter().map(move |rule| (scene, rule))) {
            let along = shown.iter().filter(|figures| figures.scene == *scene && name_of(figures.rule) == *rule);
            let line: Vec<_> = along.map(|figures| at(point(figures))).collect();
            let tone = scene_color(place(&names, scene));
            root.draw(&PathElement::new(line.clone(), tone.mix(0.5).stroke_width(1)))?;
            for pixel in line {
                marker(root, place(&rules, rule), pixel, tone.filled(), WHITE.into())?;
            }
        }
        let mut legend = Legend::new(root);
        legend.markers("rule", rules.iter().map(String::as_str).enumerate(), Some(INK))?;
        legend.scene_colors(names.iter().map(String::as_str))
    })
}
