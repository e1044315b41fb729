//! Formats the printed tables, in Markdown.

use std::fmt::Write;

use crate::{common::provenance::Provenance, film::Film, options::Plan, trials::Row};

/// Formats cost and accuracy, one row per trial and method.
pub(crate) fn of_trials(rows: &[Row], plan: &Plan, provenance: &Provenance) -> String {
    let [width, height] = plan.size;
    let mut text = format!(
        "{provenance}\n{width}x{height}{}; second eye: the first one's cost = 1; pair: naive's cost = 1, \
         both by counters; the rest: the right view against naive's, of \
         all pixels and of those in which either view shows a surface\n\n",
        if plan.rich { ", 4 samples, mirrors, lights that are balls" } else { "" },
    );
    text += "| trial | method | second eye | pair | identical % | of surfaces % | wrong surface % | of surfaces % | \
        PSNR dB | why it \
             is hard |\n|---|---|---|---|---|---|---|---|---|---|\n";
    let mut last = None;
    for row in rows {
        // The reason is printed once per trial.
        let reason = if last == Some(row.trial) { "" } else { row.trial.reason() };
        last = Some(row.trial);
        let figures = match &row.figures {
            Ok(figures) => format!(
                "{:.3} | {:.3} | {:.3} | {:.3} | {:.4} | {:.4} | {:.1}",
                figures.second_eye,
                figures.of_naive,
                figures.difference.identical_percent,
                figures.difference.identical_of_surfaces_percent,
                figures.difference.wrong_surface_percent,
                figures.difference.wrong_of_surfaces_percent,
                figures.difference.psnr,
            ),
            Err(error) => format!("{} | | | | | |", cell(error)),
        };
        let _ = writeln!(text, "| {} | {} | {figures} | {reason} |", row.trial, row.method);
    }
    text
}

/// Formats the flicker, one row per method.
pub(crate) fn of_films(films: &[Film], plan: &Plan) -> String {
    let [width, height] = plan.size;
    let mut text = format!(
        "Spheres that turn once in {} frames, {width}x{height}; flicker: pixels that are wrong in exactly one of two \
         successive frames\n\n| method | flicker % |\n|---|---|\n",
        plan.frames
    );
    for film in films {
        let figure = match &film.flicker {
            Ok(percent) => format!("{percent:.3}"),
            Err(error) => cell(error),
        };
        let _ = writeln!(text, "| {} | {figure} |", film.method);
    }
    text
}

/// Formats an error for a table's cell.
fn cell(error: &str) -> String {
    error.replace('|', "/").replace('\n', " ")
}
