//! Formats the table of all records.

use std::fmt::Write as _;

use super::text::escape;
use crate::{common::scenes, record::Record};

/// A table's cell: its text, and its sort key if it differs from the text.
struct Cell {
    text: String,
    key: Option<f64>,
}

impl Cell {
    fn text(text: &str) -> Self {
        Self { text: escape(text), key: None }
    }

    /// Makes a cell of a number; it is empty if the number is not finite.
    fn number(value: f64, decimals: usize) -> Self {
        Self { text: if value.is_finite() { format!("{value:.decimals$}") } else { String::new() }, key: None }
    }
}

/// Heading of a column, whether it is sorted by number, and the cell of a record.
type Column = (&'static str, bool, fn(&Record) -> Cell);

const COLUMNS: [Column; 21] = [
    ("suite", false, |r| Cell::text(&r.suite)),
    ("scene", false, |r| Cell::text(scenes::title(&r.scene))),
    ("method", false, |r| Cell::text(&r.method)),
    ("size", true, |r| Cell {
        text: format!("{}x{}", r.width, r.height),
        key: Some(f64::from(r.width) * f64::from(r.height)),
    }),
    ("e", true, |r| Cell::text(&r.e_px.to_string())),
    ("lights", true, |r| Cell::text(&r.lights.to_string())),
    ("left ms", true, |r| Cell::number(r.left_ms, 3)),
    ("pair ms", true, |r| Cell::number(r.pair_ms, 3)),
    ("fps", true, |r| Cell::number(r.fps, 1)),
    ("second eye", true, |r| Cell::number(r.second_eye, 3)),
    ("by counters", true, |r| Cell::number(r.second_eye_counters, 3)),
    ("speed-up %", true, |r| Cell::number(100.0 * r.speed_up, 1)),
    ("by counters %", true, |r| Cell::number(100.0 * r.speed_up_counters, 1)),
    ("identical %", true, |r| Cell::number(r.identical, 3)),
    ("of surfaces %", true, |r| Cell::number(r.identical_of_surfaces, 3)),
    ("wrong surface %", true, |r| Cell::number(r.wrong_surface, 4)),
    ("of surfaces %", true, |r| Cell::number(r.wrong_of_surfaces, 4)),
    ("MSE", true, |r| Cell::number(r.mse, 4)),
    ("PSNR", true, |r| match r.psnr {
        Some(psnr) => Cell::number(psnr, 1),
        None => Cell { text: "∞".into(), key: Some(f64::INFINITY) },
    }),
    ("retraced %", true, |r| Cell::number(100.0 * r.retraced, 2)),
    ("slots", true, |r| Cell::text(&if r.buffer_depth > 0 { r.buffer_depth.to_string() } else { String::new() })),
];

pub(super) fn table(records: &[Record]) -> String {
    let mut html = "<h2 id=\"records\">Records</h2>\n".to_owned();
    if records.is_empty() {
        html += "<p class=\"none\">Left out: there are no records.</p>\n";
        return html;
    }
    html += "<p>Click on a heading to sort by it, and again to turn the order round. e is in pixels, PSNR in dB; \
             second eye is what it costs where the first costs 1; slots are a buffer's, a right pixel; of surfaces are \
             the pixels in which either view shows one.</p>\n\
             <div class=\"table\" tabindex=\"0\"><table id=\"table\">\n<thead><tr>";
    for (heading, is_number, _) in COLUMNS {
        let class = if is_number { " class=\"n\"" } else { "" };
        let _ = write!(html, "<th scope=\"col\"{class}><span role=\"button\" tabindex=\"0\">{heading}</span></th>");
    }
    html += "</tr></thead>\n<tbody>\n";
    for record in records {
        html += "<tr>";
        for (_, is_number, cell) in COLUMNS {
            let Cell { text, key } = cell(record);
            let class = if is_number { " class=\"n\"" } else { "" };
            let key = match key {
                Some(f64::INFINITY) => " data-key=\"Infinity\"".into(),
                Some(key) => format!(" data-key=\"{key}\""),
                None => String::new(),
            };
            let _ = write!(html, "<td{class}{key}>{text}</td>");
        }
        html += "</tr>\n";
    }
    html += "</tbody>\n</table></div>\n";
    html
}
