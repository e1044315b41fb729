//! Draws the chart: errors against time, both logarithmic, with a line for each method and scene.

use std::error::Error;

use plotters::prelude::*;

use crate::common::{
    chart::{FONT, GRID, INK, LEGEND_X, Legend, SIZE, WIDTH, drawing, heading},
    looks::{color, marker},
    provenance::Provenance,
    scenes,
};

/// A method on a scene: its points for increasing numbers of paths.
pub(crate) struct Line {
    pub(crate) scene: String,
    pub(crate) method: &'static str,
    /// Milliseconds of a pair, and the right view's error.
    pub(crate) points: Vec<(f64, f64)>,
}

/// Numbers of the methods' looks, in the order of the table.
const LOOKS: [usize; 4] = [0, 9, 8, 5];

pub(crate) fn svg(
    lines: &[Line],
    methods: &[&str],
    size: [u32; 2],
    provenance: &Provenance,
) -> Result<String, Box<dyn Error>> {
    let title = format!("Light by paths, {}x{}: error of the right view against time", size[0], size[1]);
    let points = || lines.iter().flat_map(|line| &line.points);
    let range = |part: fn(&(f64, f64)) -> f64| {
        let least = points().map(part).fold(f64::INFINITY, f64::min);
        0.8 * least..1.25 * points().map(part).fold(0.0, f64::max)
    };
    let mut names: Vec<&str> = lines.iter().map(|line| &*line.scene).collect();
    names.dedup();
    drawing(SIZE, &title, |root| {
        heading(root, &title, &provenance.source())?;
        let mut chart = ChartBuilder::on(root)
            .margin_top(60)
            .margin_right(WIDTH as i32 - LEGEND_X + 15)
            .margin_left(8)
            .margin_bottom(8)
            .x_label_area_size(44)
            .y_label_area_size(70)
            .build_cartesian_2d(range(|point| point.0).log_scale(), range(|point| point.1).log_scale())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID)
            .axis_style(INK)
            .label_style((FONT, 13).into_font().color(&INK))
            .axis_desc_style((FONT, 14).into_font().color(&INK))
            .x_label_formatter(&|ms| format!("{ms:.0}"))
            .y_label_formatter(&|error| format!("{error:.3}").trim_end_matches('0').to_owned())
            .x_desc("time of a pair, ms (without denoising)")
            .y_desc("rms error of the right view, linear light")
            .draw()?;
        for line in lines {
            let look = methods.iter().position(|method| *method == line.method).map_or(0, |place| LOOKS[place]);
            let pixels: Vec<_> = line.points.iter().map(|point| chart.backend_coord(point)).collect();
            root.draw(&PathElement::new(pixels.clone(), color(look).stroke_width(2)))?;
            for at in &pixels {
                marker(root, look, *at, color(look).filled(), WHITE.into())?;
            }
            if let (Some(number), Some(&(x, y))) = (names.iter().position(|name| *name == line.scene), pixels.first()) {
                let style = (FONT, 13).into_font().color(&INK);
                root.draw(&Text::new((number + 1).to_string(), (x - 16, y - 8), style))?;
            }
        }
        let mut legend = Legend::new(root);
        legend.markers("method", LOOKS.into_iter().zip(methods.iter().copied()), None)?;
        legend.scene_numbers(names.iter().copied().map(scenes::title))
    })
}
