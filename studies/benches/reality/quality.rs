//! Renders figures 9 to 12 and 18, and counts pixels with a wrong shadow.

use std::{error::Error, fmt::Write};

use serde_json::{Value, json};
use stereotrace::{
    Renderer, Rig, RigView, Scene, StereoCamera,
    blocking::Wait,
    output::Picture,
    scene::builtin::{Builtin, StackedObjects},
};

use crate::{
    charts::{Chart, Ranged, Series},
    common::records::Record,
    options::Plan,
    report::{Report, number},
    ways::{Rule, Table, Way},
};

/// The paper's three configurations, with the numbers of their figures.
const CONFIGURATIONS: [(&str, Builtin); 3] =
    [("9", Builtin::ThreeSpheres), ("10", Builtin::ThreeSpheresMirrors), ("11", Builtin::ThreeSpheresTextured)];

/// Numbers of objects in the paper's figure 12.
const STACKED: [usize; 3] = [3, 50, 100];

/// Renders one eye's view in a way.
pub(crate) fn view(
    renderer: &mut Renderer,
    scene: &Scene,
    camera: StereoCamera,
    way: Way,
) -> Result<RigView, Box<dyn Error>> {
    let uploaded = renderer.upload_with(scene, way.build()).wait()?;
    let mut views = renderer.views(&uploaded, &Rig::at(camera, vec![0.0])).options(&way.options()).read().wait()?;
    Ok(views.views.remove(0))
}

/// Numbers of pixels that are darker or brighter than the true ones.
#[derive(Clone, Copy, Default)]
pub(crate) struct Wrong {
    darker: usize,
    brighter: usize,
    pixels: usize,
}

impl Wrong {
    pub(crate) fn of(found: &RigView, truth: &RigView) -> Self {
        let (found, truth) = (&found.view.rgba8, &truth.view.rgba8);
        let mut wrong = Self { pixels: truth.len(), ..Self::default() };
        for (found, truth) in found.iter().zip(truth).filter(|(found, truth)| found != truth) {
            let light = |[red, green, blue, _]: &[u8; 4]| u32::from(*red) + u32::from(*green) + u32::from(*blue);
            match light(found) < light(truth) {
                true => wrong.darker += 1,
                false => wrong.brighter += 1,
            }
        }
        wrong
    }

    pub(crate) fn percent(&self) -> f64 {
        100.0 * (self.darker + self.brighter) as f64 / self.pixels as f64
    }

    /// Returns the record for shadows.csv.
    pub(crate) fn record(&self, figure: &str, scene: &str, side: u32, way: Way) -> Record {
        let of_table = |of: fn(Table) -> Value| way.table.map_or(Value::Null, of);
        vec![
            ("figure", json!(figure)),
            ("scene", json!(scene)),
            ("way", json!(way.to_string())),
            ("shadow_rows", of_table(|table| json!(table.rows))),
            ("shadow_rule", of_table(|table| json!(table.rule.to_string()))),
            ("side", json!(side)),
            ("too_dark", json!(self.darker)),
            ("too_bright", json!(self.brighter)),
            ("pixels", json!(self.pixels)),
        ]
    }
}

/// Renders figure 12: stacks of the paper's numbers of objects, and the share of the view that they fill.
pub(crate) fn stacks(renderer: &mut Renderer, plan: &Plan, report: &mut Report) -> Result<(), Box<dyn Error>> {
    report.text += "## Figure 12\n\n| objects | pixels that show one, % |\n|---|---|\n";
    for objects in STACKED {
        let stacked = StackedObjects::new(objects, plan.kind);
        let found = view(renderer, &stacked.scene(), stacked.camera(plan.side, plan.side), Way::BVH)?;
        let filled = found.view.depth.iter().filter(|depth| depth.is_finite()).count();
        let percent = 100.0 * filled as f64 / found.view.depth.len() as f64;
        let _ = writeln!(report.text, "| {objects} | {} |", number(Some(percent)));
        report.pictures.push((format!("figure-12-{objects}"), found.view.picture()));
    }
    report.text += "\n";
    Ok(())
}

/// Renders figures 9 to 11: the three configurations. All ways that trace shadows should give the same picture.
pub(crate) fn pictures(renderer: &mut Renderer, plan: &Plan, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let ways = [Way::CLASSICAL, Way::T_BUFFER, Way::BVH, Way::BVH_T_BUFFER];
    report.text += "## Figures 9 to 11\n\nPixels that differ from the classical ray tracer's; the paper's pictures by \
        both algorithms are \
                    identical for figure 9.\n\n| figure | scene |";
    ways[1..].iter().for_each(|way| {
        let _ = write!(report.text, " {way} |");
    });
    report.text += "\n|---|---|";
    report.text += &"---|".repeat(ways.len() - 1);
    report.text += "\n";
    for (figure, builtin) in CONFIGURATIONS {
        eprintln!("figure {figure}: {builtin}");
        let (scene, camera) = (builtin.scene(), builtin.camera(plan.side, plan.side));
        let truth = view(renderer, &scene, camera, ways[0])?;
        let _ = write!(report.text, "| {figure} | {builtin} |");
        for &way in &ways[1..] {
            let wrong = Wrong::of(&view(renderer, &scene, camera, way)?, &truth);
            let _ = write!(report.text, " {} |", wrong.darker + wrong.brighter);
        }
        report.text += "\n";
        // The paper's last configuration uses the shadow-buffer.
        let shown = match builtin {
            Builtin::ThreeSpheresTextured => view(renderer, &scene, camera, Way::both(plan.quality_rows[0]))?,
            _ => truth,
        };
        report.pictures.push((format!("figure-{figure}"), shown.view.picture()));
    }
    report.text += "\n";
    Ok(())
}

/// Renders figure 18: wrong shadows against resolution, for three textured spheres on a ground and for a stack.
pub(crate) fn shadows(renderer: &mut Renderer, plan: &Plan, report: &mut Report) -> Result<(), Box<dyn Error>> {
    report.text += "## Figure 18\n\nThe paper's rule is that of objects. Pixels whose colour is not that of traced \
        shadows, percent, and of these the share that is darker than it \
                    should be. The paper: large gains from 400 to 1200 rows, none to be seen from there on.\n\n\
                    | scene | shadows | wrong % | too dark, of the wrong % |\n|---|---|---|---|\n";
    let stacked = StackedObjects::new(plan.fixed_objects, plan.kind);
    let three = Builtin::ThreeSpheresTextured;
    let mut series = Vec::new();
    for (name, scene, camera) in [
        (three.to_string(), three.scene(), three.camera(plan.side, plan.side)),
        (format!("{} objects", plan.fixed_objects), stacked.scene(), stacked.camera(plan.side, plan.side)),
    ] {
        eprintln!("figure 18: {name}");
        let truth = view(renderer, &scene, camera, Way::BVH)?;
        report.pictures.push((format!("figure-18-{}-traced", name.replace(' ', "-")), truth.view.picture()));
        let rules = [Rule::Object, Rule::Depth, Rule::Hybrid];
        let ways = rules.iter().flat_map(|&rule| plan.quality_rows.iter().map(move |&rows| Way::both(rows).rule(rule)));
        let mut points: [Vec<Ranged>; 3] = Default::default();
        for way in ways {
            let Some(Table { rows, rule, .. }) = way.table else { continue };
            let found = view(renderer, &scene, camera, way)?;
            let wrong = Wrong::of(&found, &truth);
            let dark = 100.0 * wrong.darker as f64 / (wrong.darker + wrong.brighter).max(1) as f64;
            let _ = writeln!(report.text, "| {name} | {way} | {:.3} | {} |", wrong.percent(), number(Some(dark)));
            points[rule as usize].push(((f64::from(rows), wrong.percent()), None));
            report.shadows.push(wrong.record("18", &name, plan.side, way));
            let file = format!("figure-18-{}-{rule}-{rows}", name.replace(' ', "-"));
            report.pictures.push((format!("{file}-wrong"), marked(&found, &truth)));
            report.pictures.push((file, found.view.picture()));
        }
        let named = rules.iter().zip(points).map(|(rule, points)| Series::marked(format!("{name}, {rule}"), points));
        series.extend(named);
    }
    if series.iter().all(Series::is_empty) {
        report.text += "| all | by shadow-buffer | not measured yet | |\n";
    }
    report.text += "\n";
    let chart = Chart {
        title: "Figure 18: pixels with a wrong shadow",
        x: "rows of the shadow-buffer",
        y: "percent of the pixels",
        series,
    };
    report.chart("figure-18", chart)
}

/// Returns the true picture in grey with wrong pixels marked: red if too dark, blue if too bright.
fn marked(found: &RigView, truth: &RigView) -> Picture {
    let mark = |(found, truth): (&[u8; 4], &[u8; 4])| {
        let light = |[red, green, blue, _]: &[u8; 4]| u32::from(*red) + u32::from(*green) + u32::from(*blue);
        match found == truth {
            true => {
                let grey = (128 + light(truth) / 6) as u8;
                [grey, grey, grey, 255]
            }
            false if light(found) < light(truth) => [214, 30, 20, 255],
            false => [20, 70, 220, 255],
        }
    };
    let rgba8 = found.view.rgba8.iter().zip(&truth.view.rgba8).map(mark).collect();
    Picture::new(truth.view.width, truth.view.height, rgba8)
}
