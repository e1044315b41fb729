//! Figure 17: how long a picture takes as the shadow-buffer's resolution grows.

use std::{error::Error, fmt::Write};

use stereotrace::{Renderer, scene::builtin::StackedObjects};

use crate::{
    charts::{Chart, Series},
    fits::{Parabola, Point},
    measure::{By, Measured, Sample, View, of_way},
    options::Plan,
    report::{Report, number},
    ways::Way,
};

/// Steps that the curve is drawn with.
const STEPS: u32 = 60;

pub(crate) fn measure(renderer: &mut Renderer, plan: &Plan, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let objects = plan.fixed_objects;
    eprintln!("figure 17: {objects} objects");
    let ways = Way::there(plan.time_rows.iter().map(|&rows| Way::both(rows)).chain([Way::CLASSICAL, Way::BVH]));
    let stacked = StackedObjects::new(objects, plan.kind);
    let scene = stacked.scene();
    let all = View::of(&scene, stacked.camera(plan.side, plan.side)).measure(renderer, &ways, plan.rounds)?;
    let sample = |&measured| Sample { figure: "17", objects, side: plan.side, measured };
    report.samples.extend(all.iter().map(sample));
    report.text += &table(&all, plan);
    let points = points(&all, plan);
    let parabola = Parabola::through(&points);
    let mut series = vec![Series::marked("both buffers".into(), points.clone())];
    if let (Some(parabola), Some(first), Some(last)) = (parabola, points.first(), points.last()) {
        let x = |step: u32| first.0 + (last.0 - first.0) * f64::from(step) / f64::from(STEPS);
        let curve = (0..=STEPS).map(x).map(|x| (x, parabola.at(x))).collect();
        series.push(Series::curve("parabola of least squares", curve));
    }
    let title = format!("Figure 17: {objects} objects");
    report.chart("figure-17", Chart { title: &title, x: "rows of the shadow-buffer", y: "milliseconds", series })
}

/// Milliseconds over rows.
fn points(all: &[Measured], plan: &Plan) -> Vec<Point> {
    let time = |&rows: &u32| Some((f64::from(rows), By::Time.cost(of_way(all, Way::both(rows))?)?));
    plan.time_rows.iter().filter_map(time).collect()
}

fn table(all: &[Measured], plan: &Plan) -> String {
    let mut text =
        format!("## Figure 17\n\n{} objects, {side}x{side} pixels.\n\n", plan.fixed_objects, side = plan.side);
    text += "| way | milliseconds, median (least to most) | millions of tests |\n|---|---|---|\n";
    for one in all {
        let ms = one.ms.map_or("not measured yet".into(), |ms| {
            format!("{} ({} to {})", number(Some(ms.median)), number(Some(ms.min)), number(Some(ms.max)))
        });
        let _ = writeln!(text, "| {} | {ms} | {} |", one.way, number(Some(one.work.primitive_tests as f64 / 1e6)));
    }
    text += "\n| | constant, ms | linear, ms a thousand rows | quadratic, ms a million texels of 1:2 | r² |\n|---|---|---|---|---|\n";
    text += "| the paper | | | | .9996, of its own times |\n";
    match Parabola::through(&points(all, plan)) {
        Some(Parabola { constant, linear, square, r_squared }) => {
            // A buffer of r rows has 2 r² texels.
            let [constant, linear, square] = [constant, 1e3 * linear, 0.5e6 * square].map(|one| number(Some(one)));
            let _ = writeln!(text, "| ours | {constant} | {linear} | {square} | {r_squared:.4} |\n");
        }
        None => text += "| ours | not measured yet | | | |\n\n",
    }
    text
}
