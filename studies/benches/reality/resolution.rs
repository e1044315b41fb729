//! Measures figure 17: rendering time against the shadow-buffer's resolution.

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

/// Number of segments of the drawn curve.
const STEPS: u32 = 60;

pub(crate) fn measure(renderer: &mut Renderer, plan: &Plan, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let objects = plan.fixed_objects;
    eprintln!("figure 17: {objects} objects");
    let ways: Vec<Way> = plan.time_rows.iter().map(|&rows| Way::both(rows)).chain([Way::CLASSICAL, Way::BVH]).collect();
    let stacked = StackedObjects::new(objects, plan.kind);
    let scene = stacked.scene();
    let all = View::of(&scene, stacked.camera(plan.side, plan.side)).measure(renderer, &ways, plan.rounds)?;
    let sample = |&measured| Sample { figure: "17", objects, side: plan.side, measured };
    report.samples.extend(all.iter().map(sample));
    report.text += &table(&all, plan);
    let by = if plan.rounds > 0 { By::Time } else { By::Tests };
    let points = points(&all, plan, by);
    let parabola = Parabola::through(&points);
    let ranged = |&point: &Point| {
        let measured = of_way(&all, Way::both(point.0 as u32));
        (point, measured.and_then(|measured| by.range(measured)))
    };
    let mut series = vec![Series::marked("both buffers".into(), points.iter().map(ranged).collect())];
    if let (Some(parabola), Some(first), Some(last)) = (parabola, points.first(), points.last()) {
        let x = |step: u32| first.0 + (last.0 - first.0) * f64::from(step) / f64::from(STEPS);
        let curve = (0..=STEPS).map(x).map(|x| (x, parabola.at(x))).collect();
        series.push(Series::curve("parabola of least squares", curve));
    }
    let title = format!("Figure 17: {objects} objects");
    report.chart("figure-17", Chart { title: &title, x: "rows of the shadow-buffer", y: by.unit(), series })
}

/// Returns the cost of the paper's two buffers for each number of rows.
fn points(all: &[Measured], plan: &Plan, by: By) -> Vec<Point> {
    let cost = |&rows: &u32| Some((f64::from(rows), by.cost(of_way(all, Way::both(rows))?)?));
    plan.time_rows.iter().filter_map(cost).collect()
}

fn table(all: &[Measured], plan: &Plan) -> String {
    let (objects, side) = (plan.fixed_objects, plan.side);
    let mut text = format!("## Figure 17\n\n{objects} objects, {side}x{side} pixels.\n\n");
    text += "| way | milliseconds, median (least to most) | millions of tests | millions of texels filled \
        |\n|---|---|---|---|\n";
    for one in all {
        let ms = one.ms.map_or("not measured yet".into(), |ms| {
            format!("{} ({} to {})", number(Some(ms.median)), number(Some(ms.min)), number(Some(ms.max)))
        });
        let tests = number(By::Tests.cost(one).map(|tests| tests / 1e6));
        let _ = writeln!(text, "| {} | {ms} | {tests} | {} |", one.way, number(Some(one.filling.filled as f64 / 1e6)));
    }
    text += "\nThe parabola of least squares over rows:\n\n\
             | | at no rows | linear, a thousand rows | quadratic, a million texels | r² |\n|---|---|---|---|---|\n\
             | the paper, by time | | | | .9996 |\n";
    for (name, by, unit) in [("ours, ms", By::Time, 1.0), ("ours, millions of tests", By::Tests, 1e-6)] {
        match Parabola::through(&points(all, plan, by)) {
            Some(Parabola { constant, linear, square, r_squared }) => {
                // A buffer of r rows has 2 r² texels.
                let [constant, linear, square] =
                    [constant, 1e3 * linear, 0.5e6 * square].map(|one| number(Some(unit * one)));
                let _ = writeln!(text, "| {name} | {constant} | {linear} | {square} | {r_squared:.4} |");
            }
            None => {
                let _ = writeln!(text, "| {name} | not measured yet | | | |");
            }
        }
    }
    text + "\n"
}
