//! The chart: how far the second eye's colours are off, and how dear the first one is, against what the second one costs.

use std::error::Error;

use plotters::{
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use crate::{
    Figures,
    common::{
        chart::{Area, FONT, INK, LEGEND_LINE, Panel, Pixel, Point, axes, color, heading, marker},
        provenance::Provenance,
        scenes,
    },
};

/// Two panels, one above the other.
const SIZE: (u32, u32) = (860, 860);
/// Beside the plots, which end where the other charts' do, as seen from the right.
const LEGEND_X: i32 = 685;
const COST: &str = "cost of the second eye by time (first eye = 1)";

type Figure = fn(&Figures) -> f64;

pub(crate) fn svg(all: &[Figures], side: u32, provenance: &Provenance) -> Result<String, Box<dyn Error>> {
    let panels: [(Panel<'_>, Figure); 2] = [
        (Panel { rows: 60..450, x: COST, y: "mean distance from naive's colours, of 255" }, |f| f.distance),
        (Panel { rows: 462..852, x: COST, y: "cost of the first eye (without lights = 1)" }, |f| f.first),
    ];
    let [mut names, mut titles] = [Vec::new(), Vec::new()];
    for figures in all {
        (!names.contains(&figures.finish)).then(|| names.push(figures.finish));
        (!titles.contains(&figures.scene.as_str())).then(|| titles.push(&figures.scene));
    }
    let place_of = |list: &[&str], name: &str| list.iter().position(|other| *other == name).unwrap_or(0);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let title = format!("bracket by what pictures show: {side}x{side}");
        heading(&root, &title, &format!("{}, {}", provenance.adapter, provenance.day()))?;
        for (panel, value) in panels {
            let points: Vec<Point> = all.iter().map(|figures| (figures.second.max(0.0), value(figures))).collect();
            let place = axes(&root, &points, &panel)?;
            for (figures, &point) in all.iter().zip(&points) {
                let (name, scene) = (place_of(&names, figures.finish), place_of(&titles, &figures.scene));
                draw(&root, name, place(point), color(scene))?;
            }
        }
        let style = |size: i32| (FONT, size).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
        let mut y = 70;
        for (index, name) in names.iter().enumerate() {
            draw(&root, index, (LEGEND_X + 8, y), INK)?;
            root.draw(&Text::new((*name).to_owned(), (LEGEND_X + 24, y), style(13)))?;
            y += LEGEND_LINE;
        }
        for (index, name) in titles.iter().enumerate() {
            y += LEGEND_LINE;
            root.draw(&Rectangle::new([(LEGEND_X, y - 4), (LEGEND_X + 16, y + 4)], color(index).filled()))?;
            root.draw(&Text::new(scenes::title(name).to_owned(), (LEGEND_X + 24, y), style(13)))?;
        }
        root.present()?;
    }
    Ok(text)
}

/// The second half of the markers is hollow: there are but six shapes.
fn draw(root: &Area<'_>, name: usize, place: Pixel, color: RGBColor) -> Result<(), Box<dyn Error>> {
    match name / 6 {
        0 => marker(root, name, place, color.filled(), WHITE.into()),
        _ => marker(root, name, place, WHITE.filled(), color.stroke_width(2)),
    }
}
