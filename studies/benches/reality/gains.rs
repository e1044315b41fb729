//! Measures figures 13 to 16: the gain of the buffers over the classical ray tracer with an increasing number of
//! objects.

use std::{error::Error, fmt::Write};

use stereotrace::{Renderer, scene::builtin::StackedObjects};

use crate::{
    charts::{Chart, Series},
    fits::{Line, Point},
    measure::{By, Measured, Sample, View, gain, of_way},
    options::Plan,
    quality::{Wrong, view},
    report::{Report, number},
    ways::{Rule, Way},
};

/// Numbers of objects for which the paper states its gains.
const READ_AT: [f64; 2] = [500.0, 6000.0];

/// A stack, and the cost of its picture by each way of rendering.
struct Stack {
    objects: usize,
    ways: Vec<Measured>,
    /// Percentage of pixels with a wrong shadow, for each way with a shadow-buffer in the figures.
    wrong: Vec<(Way, f64)>,
}

impl Stack {
    /// Returns the number of objects and the gain of a way over the classical ray tracer.
    fn gain(&self, way: Way, by: By) -> Option<Point> {
        Some((self.objects as f64, gain(&self.ways, Way::CLASSICAL, way, by)?))
    }

    /// Returns the upper limit on the gain of a T-buffer that leaves shadow rays unchanged. It is the ratio of all
    /// rays' tests to shadow rays' tests.
    fn limit(&self, side: u32) -> Option<f64> {
        let all = of_way(&self.ways, Way::CLASSICAL)?.work.primitive_tests as f64;
        let primary = f64::from(side).powi(2) * self.objects as f64;
        Some(all / (all - primary)).filter(|limit| limit.is_finite())
    }
}

pub(crate) fn measure(renderer: &mut Renderer, plan: &Plan, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let [few, many] = plan.gain_rows.map(Way::both);
    let paper = [Way::CLASSICAL, Way::T_BUFFER, few, many];
    let others =
        [few.kept(), few.rule(Rule::Hybrid), Way::BVH, Way::BVH_T_BUFFER, Way::bvh_shadow_buffer(plan.gain_rows[0])];
    let ways: Vec<Way> = paper.into_iter().chain(others).collect();
    let mut stacks = Vec::new();
    for &objects in &plan.objects {
        eprintln!("figures 13 to 16: {objects} objects");
        let stacked = StackedObjects::new(objects, plan.kind);
        let (scene, camera) = (stacked.scene(), stacked.camera(plan.side, plan.side));
        let ways = View::of(&scene, camera).measure(renderer, &ways, plan.rounds)?;
        let sample = |&measured| Sample { figure: "13 to 16", objects, side: plan.side, measured };
        report.samples.extend(ways.iter().map(sample));
        let truth = view(renderer, &scene, camera, Way::BVH)?;
        let mut wrong = Vec::new();
        for way in [few, many, few.rule(Rule::Hybrid)] {
            let found = Wrong::of(&view(renderer, &scene, camera, way)?, &truth);
            report.shadows.push(found.record("13 to 16", &format!("{objects} objects"), plan.side, way));
            wrong.push((way, found.percent()));
        }
        stacks.push(Stack { objects, ways, wrong });
    }
    for by in [By::Time, By::Tests] {
        if by == By::Tests || plan.rounds > 0 {
            report.text += &table(&stacks, &ways, plan.side, by);
            report.text += &fits(&stacks, plan, by);
            report.text += &growth(&stacks, plan, by);
        }
    }
    report.text += &wrong_shadows(&stacks);
    report.text += &against_bvh(&stacks, &ways);
    let by = if plan.rounds > 0 { By::Time } else { By::Tests };
    charts(&stacks, &ways, plan, by, report)
}

/// Formats one row per stack, with each way's cost and gain.
fn table(stacks: &[Stack], ways: &[Way], side: u32, by: By) -> String {
    let mut text = format!(
        "## Figures 13 to 16, by {}\n\n{side}x{side} pixels, one lamp. {}; in brackets the gain over the classical ray \
        tracer.\n\n| objects |",
        by.name(),
        match by {
            By::Time => "Milliseconds of a frame by the host's clock, medians",
            _ => "Millions of tests",
        }
    );
    ways.iter().for_each(|way| {
        let _ = write!(text, " {way} |");
    });
    text += " T-buffer alone gains at most |\n|---|";
    text += &"---|".repeat(ways.len() + 1);
    text += "\n";
    for stack in stacks {
        let _ = write!(text, "| {} |", stack.objects);
        for &way in ways {
            let cost = of_way(&stack.ways, way).and_then(|one| by.cost(one));
            let cost = cost.map(|cost| if by == By::Tests { cost / 1e6 } else { cost });
            let gain = stack.gain(way, by).filter(|_| way != Way::CLASSICAL).map(|gain| gain.1);
            let gain = gain.map_or(String::new(), |gain| format!(" ({})", number(Some(gain))));
            let _ = write!(text, " {}{gain} |", number(cost));
        }
        let _ = writeln!(text, " {} |", number(stack.limit(side)));
    }
    text + "\n"
}

/// Formats the growth of the gains, next to the paper's statements.
fn fits(stacks: &[Stack], plan: &Plan, by: By) -> String {
    let mut text = String::from("| figure | way | gain a thousand objects (slope) | at none | r² of the line |");
    READ_AT.iter().for_each(|objects| {
        let _ = write!(text, " gain at {objects} objects |");
    });
    text += " the paper |\n|---|---|---|---|---|---|---|---|\n";
    let [few, many] = plan.gain_rows;
    for (figure, way, says) in [
        ("14", Way::T_BUFFER, "saturates near 2.2 by some 5000 objects"),
        ("15", Way::both(few), "linear"),
        ("16", Way::both(many), "linear, less steep than with fewer rows"),
        ("none", Way::BVH, "not in it"),
    ] {
        let points: Vec<Point> = stacks.iter().filter_map(|stack| stack.gain(way, by)).collect();
        let Some(line) = Line::through(&points) else {
            let _ = writeln!(text, "| {figure} | {way} | not measured yet | | | | | {says} |");
            continue;
        };
        let _ = write!(
            text,
            "| {figure} | {way} | {} | {} | {:.4} |",
            number(Some(1e3 * line.slope)),
            number(Some(line.intercept)),
            line.r_squared
        );
        for objects in READ_AT {
            let there = points.iter().find(|point| point.0 == objects).map(|point| point.1);
            let _ = write!(text, " {} |", number(there));
        }
        let _ = writeln!(text, " {says} |");
    }
    text + "\n"
}

/// Formats the growth of the cost. In the paper the classical ray tracer's cost is linear, and the cost of both buffers
/// is almost constant.
fn growth(stacks: &[Stack], plan: &Plan, by: By) -> String {
    let mut text =
        format!("Cost by {} over objects:\n\n| way | most over least | r² of the line |\n|---|---|---|\n", by.name());
    for way in [Way::CLASSICAL, Way::T_BUFFER, Way::both(plan.gain_rows[0]), Way::both(plan.gain_rows[1]), Way::BVH] {
        let point = |stack: &Stack| Some((stack.objects as f64, by.cost(of_way(&stack.ways, way)?)?));
        let points: Vec<Point> = stacks.iter().filter_map(point).collect();
        let fold = |start: f64, choose: fn(f64, f64) -> f64| points.iter().map(|point| point.1).fold(start, choose);
        let ratio = fold(0.0, f64::max) / fold(f64::INFINITY, f64::min);
        let line = Line::through(&points).map_or(f64::NAN, |line| line.r_squared);
        let _ = writeln!(text, "| {way} | {} | {line:.4} |", number(Some(ratio)));
    }
    text + "\n"
}

/// Formats the error that comes with the gains. It grows, since cells keep their size while objects shrink.
fn wrong_shadows(stacks: &[Stack]) -> String {
    let mut text = "## Wrong shadows in figures 13 to 16\n\nPixels whose colour is not that of traced shadows, \
        percent.\n\n| objects |"
        .to_owned();
    let ways = stacks.first().map_or(&[][..], |stack| &stack.wrong);
    ways.iter().for_each(|(way, _)| {
        let _ = write!(text, " {way} |");
    });
    text += "\n|---|";
    text += &"---|".repeat(ways.len());
    text += "\n";
    for stack in stacks {
        let _ = write!(text, "| {} |", stack.objects);
        stack.wrong.iter().for_each(|(_, percent)| {
            let _ = write!(text, " {} |", number(Some(*percent)));
        });
        text += "\n";
    }
    text + "\n"
}

/// Formats the comparison with rays through a tree, which the paper could not make.
fn against_bvh(stacks: &[Stack], ways: &[Way]) -> String {
    let mut text = "## The same beside a tree\n\nCost of rays through a tree over that of each way, by time and by \
        boxes and primitive tests: above 1 the way wins.\n\n| objects |"
        .to_owned();
    let others: Vec<Way> = ways.iter().copied().filter(|&way| way != Way::BVH).collect();
    others.iter().for_each(|way| {
        let _ = write!(text, " {way}: by time, counters |");
    });
    text += "\n|---|";
    text += &"---|".repeat(others.len());
    text += "\n";
    for stack in stacks {
        let _ = write!(text, "| {} |", stack.objects);
        for &way in &others {
            let [time, counters] = [By::Time, By::Counters].map(|by| number(gain(&stack.ways, Way::BVH, way, by)));
            let _ = write!(text, " {time}, {counters} |");
        }
        text += "\n";
    }
    text + "\n"
}

fn charts(stacks: &[Stack], ways: &[Way], plan: &Plan, by: By, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let cost = |way: Way| {
        let point = |stack: &Stack| {
            let measured = of_way(&stack.ways, way)?;
            Some(((stack.objects as f64, by.cost(measured)?), by.range(measured)))
        };
        Series::marked(way.to_string(), stacks.iter().filter_map(point).collect())
    };
    let gains = |way: Way| {
        let points: Vec<Point> = stacks.iter().filter_map(|stack| stack.gain(way, by)).collect();
        // The range of the gain is relative to the classical ray tracer's median. The classical ray tracer's own spread
        // would move all ways together.
        let range = |stack: &Stack| {
            let classical = by.cost(of_way(&stack.ways, Way::CLASSICAL)?)?;
            by.range(of_way(&stack.ways, way)?).map(|[least, most]| [classical / most, classical / least])
        };
        let ranges = stacks.iter().filter(|stack| stack.gain(way, by).is_some()).map(range);
        let line = Line::through(&points);
        (line, Series::marked(way.to_string(), points.into_iter().zip(ranges).collect()))
    };
    let (unit, x) = (by.unit(), "objects");
    let alone = [Way::CLASSICAL, Way::T_BUFFER, Way::BVH];
    let series = alone.into_iter().filter(|way| ways.contains(way)).map(cost).collect();
    report.chart("figure-13", Chart { title: "Figure 13: without a shadow-buffer", x, y: unit, series })?;
    let y = format!("gain over the classical ray tracer by {}", by.name());
    let alone = gains(Way::T_BUFFER).1;
    report
        .chart("figure-14", Chart { title: "Figure 14: gain of the T-buffer alone", x, y: &y, series: vec![alone] })?;
    let mut series = Vec::new();
    for (line, points) in plan.gain_rows.map(|rows| gains(Way::both(rows))) {
        let ends = [plan.objects.first(), plan.objects.last()].map(|count| count.map_or(0.0, |&count| count as f64));
        series.push(points);
        series.extend(line.map(|line| Series::curve("line of least squares", ends.map(|x| (x, line.at(x))).to_vec())));
    }
    series.push(gains(Way::BVH).1);
    report.chart("figures-15-16", Chart { title: "Figures 15 and 16: gain of both buffers", x, y: &y, series })
}
