//! Formats the printed tables.

use std::fmt::Write;

use crate::common::{
    measure::{Measured, MethodFigures, Plan},
    provenance::Provenance,
    scenes,
};

/// Formats a scene's tables: time, accuracy, counted work, and passes.
pub(crate) fn of(measured: &Measured, plan: &Plan, provenance: &Provenance) -> String {
    let [width, height] = plan.size;
    let mut text = format!("## {}\n\n", scenes::title(&measured.scene));
    let _ = writeln!(text, "{provenance}");
    let _ = writeln!(
        text,
        "{width}x{height}, {} triangles, {} spheres, {}, {} lights{}, {} rounds after {} to warm up\n",
        grouped(measured.triangles as u64),
        grouped(measured.spheres as u64),
        plan.eyes(),
        measured.lights,
        plan.sampled.text(),
        plan.rounds,
        plan.warm_ups,
    );
    text += &time(measured);
    text += &accuracy(measured);
    text += &work(measured, plan);
    text += &passes(measured, plan);
    text
}

/// Formats the times. The second eye's cost is (pair - left) / left, from times and from counted box and primitive
/// tests. "Predicted" is the speed-up that the counts predict.
fn time(measured: &Measured) -> String {
    let head = [
        "time",
        "pair ms",
        "min..max",
        "of naive",
        "wall ms",
        "left ms",
        "second eye",
        "min..max",
        "counted",
        "speed-up",
        "predicted",
        "share",
    ];
    table(measured, head, |figures| {
        let (speed_up, predicted) = (figures.speed_up, figures.speed_up_predicted());
        // Naive is the reference, so its own prediction is 0 up to noise.
        let share = if predicted > 0.05 { format!("{:.2}", speed_up / predicted) } else { "-".into() };
        [
            figures.method.to_string(),
            format!("{:.1}", figures.pair_ms.median),
            format!("{:.1}..{:.1}", figures.pair_ms.min, figures.pair_ms.max),
            format!("{:.3}", figures.ratio_to_naive),
            format!("{:.1}", figures.wall_ms),
            format!("{:.1}", figures.left_ms),
            format!("{:.3}", figures.second_eye.median),
            format!("{:.3}..{:.3}", figures.second_eye.min, figures.second_eye.max),
            format!("{:.3}", figures.second_eye_counters()),
            format!("{:+.1}%", 100.0 * speed_up),
            format!("{:+.1}%", 100.0 * predicted),
            share,
        ]
    })
}

/// Formats the right view's difference from naive's. Columns "of surfaces" only consider pixels in which either view
/// shows a surface.
fn accuracy(measured: &Measured) -> String {
    let head = [
        "accuracy",
        "identical %",
        "of surfaces %",
        "wrong surface %",
        "of surfaces %",
        "mean difference",
        "MSE",
        "PSNR dB",
    ];
    table(measured, head, |figures| {
        let difference = &figures.difference;
        [
            figures.method.to_string(),
            format!("{:.3}", difference.identical_percent),
            format!("{:.3}", difference.identical_of_surfaces_percent),
            format!("{:.4}", difference.wrong_surface_percent),
            format!("{:.4}", difference.wrong_of_surfaces_percent),
            format!("{:.2}", difference.mean_difference),
            format!("{:.4}", difference.mse),
            format!("{:.1}", difference.psnr),
        ]
    })
}

/// Formats the counts of both eyes. They are the same on every machine.
fn work(measured: &Measured, plan: &Plan) -> String {
    let head = [
        "counts",
        "re-traced %",
        "bad",
        "missed",
        "lost",
        "primary",
        "verification",
        "shadow",
        "nodes",
        "primitive tests",
        "B/pixel",
    ];
    let pixels = f64::from(plan.size[0]) * f64::from(plan.size[1]);
    table(measured, head, |figures| {
        let statistics = &figures.statistics;
        let both = |count: fn(&stereotrace::Work) -> u64| grouped(count(&statistics.left) + count(&statistics.right));
        [
            figures.method.to_string(),
            format!("{:.2}", 100.0 * statistics.retraced_share()),
            grouped(statistics.bad),
            grouped(statistics.missed),
            grouped(statistics.lost_candidates),
            both(|work| work.rays.primary),
            both(|work| work.rays.verification),
            both(|work| work.rays.shadow),
            both(|work| work.nodes),
            both(|work| work.primitive_tests),
            format!("{:.1}", statistics.intermediate_bytes as f64 / pixels),
        ]
    })
}

/// Formats the time of each pass, in total and per pixel.
fn passes(measured: &Measured, plan: &Plan) -> String {
    let pixels = f64::from(plan.size[0]) * f64::from(plan.size[1]);
    let mut text = "passes, ms (ns a pixel)\n".to_owned();
    for figures in &measured.methods {
        let pass = |(name, ms): &(&str, f64)| format!("{name} {ms:.1} ({:.0})", ms * 1e6 / pixels);
        let passes: Vec<_> = figures.passes.iter().map(pass).collect();
        let _ = writeln!(text, "{}: {}", figures.method, passes.join(", "));
    }
    text
}

/// Formats one row per method, with columns as wide as needed.
fn table<const N: usize>(measured: &Measured, head: [&str; N], row: impl Fn(&MethodFigures) -> [String; N]) -> String {
    let mut rows = vec![head.map(String::from)];
    rows.extend(measured.methods.iter().map(row));
    let widths: Vec<usize> =
        (0..N).map(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0)).collect();
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| match column {
            0 => format!("{cell:<width$}"),
            _ => format!("{cell:>width$}"),
        });
        text += &cells.collect::<Vec<_>>().join("  ");
        text.push('\n');
    }
    text.push('\n');
    text
}

/// Formats 1234567 as 1,234,567.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
