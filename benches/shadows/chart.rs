//! The chart: how many pixels have wrong shadows against how many shadow rays are left.

use std::error::Error;

use plotters::{
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};
use stereotrace::Method;

use crate::{
    Figures,
    common::{
        chart::{FONT, INK, LEGEND_LINE, LEGEND_X, Panel, Point, SIZE, axes, color, heading, marker},
        provenance::Provenance,
        scenes,
    },
    name_of,
};

/// Of naive pairs: a line for each scene and rule, a point for each number of rows.
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
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        heading(
            &root,
            &format!(
                "Shadow-buffers, naive pairs of {}x{}, along each line {} rows",
                size[0],
                size[1],
                rows.join(", ")
            ),
            &format!("{}, {}", provenance.adapter, provenance.day()),
        )?;
        let panel = Panel {
            rows: 60..SIZE.1 - 8,
            x: "shadow rays of a pair (all = 1)",
            y: "pixels with another colour than by rays, %",
        };
        let points: Vec<Point> = shown.iter().map(|figures| point(figures)).collect();
        let at = axes(&root, &points, &panel)?;
        for (scene, rule) in names.iter().flat_map(|scene| rules.iter().map(move |rule| (scene, rule))) {
            let along = shown.iter().filter(|figures| figures.scene == *scene && name_of(figures.rule) == *rule);
            let line: Vec<_> = along.map(|figures| at(point(figures))).collect();
            let tone = color(place(&names, scene));
            root.draw(&PathElement::new(line.clone(), tone.mix(0.5).stroke_width(1)))?;
            for pixel in line {
                marker(&root, place(&rules, rule), pixel, tone.filled(), WHITE.into())?;
            }
        }
        let style = (FONT, 13).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
        let mut y = 70;
        for (index, rule) in rules.iter().enumerate() {
            marker(&root, index, (LEGEND_X + 8, y), INK.filled(), WHITE.into())?;
            root.draw(&Text::new(rule.clone(), (LEGEND_X + 24, y), style.clone()))?;
            y += LEGEND_LINE;
        }
        for (index, name) in names.iter().enumerate() {
            y += LEGEND_LINE;
            root.draw(&Rectangle::new([(LEGEND_X, y - 4), (LEGEND_X + 16, y + 4)], color(index).filled()))?;
            root.draw(&Text::new(scenes::title(name).to_owned(), (LEGEND_X + 24, y), style.clone()))?;
        }
        root.present()?;
    }
    Ok(text)
}
