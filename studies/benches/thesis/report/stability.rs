//! Formats the table and the chart of the stability benchmark's results.

use std::{error::Error, fmt::Write as _, fs, io::ErrorKind, path::Path};

use serde::Deserialize;

use super::{
    names::distinct,
    sources::percent,
    text::{count, escape},
};

pub(super) const SLUG: &str = "stability";
pub(super) const TITLE: &str = "Stability suite";
const COMMAND: &str = "cargo bench --bench stability";
/// Number of columns per method: cost, and identical pixels and wrong surfaces, both as shares of all pixels and of
/// surfaces.
const COLUMNS: usize = 5;

/// Results of the benchmark.
pub(crate) struct Stability {
    rows: Vec<Row>,
    /// Its chart as SVG, if the file exists.
    chart: Option<String>,
}

/// A method on a trial, with the record's displayed fields. Figures are missing if the method failed.
#[derive(Deserialize)]
struct Row {
    trial: String,
    reason: String,
    method: String,
    width: u32,
    height: u32,
    second_eye_counters: Option<f64>,
    identical: Option<f64>,
    wrong_surface: Option<f64>,
    /// This value is also missing in files of older benchmarks.
    identical_of_surfaces: Option<f64>,
    wrong_of_surfaces: Option<f64>,
    error: Option<String>,
    adapter: String,
    commit: String,
    date: String,
}

impl Stability {
    /// Reads the results in a folder. Returns `None` if there is no results.json.
    pub(crate) fn read(folder: &Path) -> Result<Option<Self>, Box<dyn Error>> {
        let text = |name: &str| match fs::read_to_string(folder.join(name)) {
            Ok(text) => Ok(Some(text)),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(format!("{}: {error}", folder.join(name).display())),
        };
        let name = "results.json";
        let Some(results) = text(name)? else { return Ok(None) };
        let rows = serde_json::from_str(&results)
            .map_err(|error| format!("{}: {error}; run {COMMAND} again", folder.join(name).display()))?;
        Ok(Some(Self { rows, chart: text("stability.svg")? }))
    }
}

pub(super) fn html(stability: Option<&Stability>) -> String {
    let mut html = format!("<h2 id=\"{SLUG}\">{TITLE}</h2>\n");
    let Some(Stability { rows, chart }) = stability.filter(|stability| !stability.rows.is_empty()) else {
        html += &format!("<p class=\"none\">Left out: there are no results; <code>{COMMAND}</code> makes them.</p>\n");
        return html;
    };
    let list = |part: &dyn Fn(&Row) -> String| escape(&distinct(rows.iter().map(part)).join(", "));
    let trials: Vec<&str> = distinct(rows.iter().map(|row| row.trial.as_str()));
    let _ = writeln!(
        html,
        "<p>{} made to be hard, by <code>{COMMAND}</code>: {}; adapter: {}; commit: {}; {}. Cost is the second eye's \
         by counters, the first eye's being 1; the rest sets the right view against naive's, in percent of its pixels \
         and of those in which either view shows a surface.</p>",
        count(trials.len(), "scene"),
        list(&|row| format!("{}x{}", row.width, row.height)),
        list(&|row| row.adapter.clone()),
        list(&|row| row.commit.clone()),
        list(&|row| row.date.split('T').next().unwrap_or_default().to_owned()),
    );
    html += &table(rows, &trials);
    if let Some(chart) = chart {
        let _ = writeln!(html, "<figure class=\"stability\">\n{chart}</figure>");
    }
    html
}

/// Formats one row per trial, with [`COLUMNS`] columns per method.
fn table(rows: &[Row], trials: &[&str]) -> String {
    let methods: Vec<&str> = distinct(rows.iter().map(|row| row.method.as_str()));
    let mut html = "<div class=\"table suite\" tabindex=\"0\"><table>\n<thead>\n<tr><th scope=\"col\" \
        rowspan=\"2\">trial, and why \
                    it is hard</th>"
        .to_owned();
    for method in &methods {
        let _ = write!(html, "<th scope=\"colgroup\" colspan=\"{COLUMNS}\" class=\"first\">{}</th>", escape(method));
    }
    html += "</tr>\n<tr>";
    for _ in &methods {
        html += "<th scope=\"col\" class=\"n first\">cost</th>";
        for head in ["identical %", "of surfaces %", "wrong surface %", "of surfaces %"] {
            let _ = write!(html, "<th scope=\"col\" class=\"n\">{head}</th>");
        }
    }
    html += "</tr>\n</thead>\n<tbody>\n";
    for &trial in trials {
        let of_trial = || rows.iter().filter(|row| row.trial == trial);
        let reason = of_trial().next().map_or("", |row| &row.reason);
        let _ = write!(html, "<tr><th scope=\"row\"><b>{}</b> {}</th>", escape(trial), escape(reason));
        for &method in &methods {
            html += &cells(of_trial().find(|row| row.method == method));
        }
        html += "</tr>\n";
    }
    html + "</tbody>\n</table></div>\n"
}

fn cells(row: Option<&Row>) -> String {
    let Some(row) = row else { return format!("<td class=\"first\" colspan=\"{COLUMNS}\"></td>") };
    match (row.second_eye_counters, row.identical, row.wrong_surface) {
        (Some(cost), Some(identical), Some(wrong)) => {
            let cells = [Some(identical), row.identical_of_surfaces, Some(wrong), row.wrong_of_surfaces];
            let cell =
                |figure: Option<f64>| format!("<td class=\"n\">{}</td>", figure.map(percent).unwrap_or_default());
            format!("<td class=\"n first\">{cost:.2}</td>{}", cells.map(cell).concat())
        }
        _ => {
            let error = row.error.as_deref().unwrap_or("no figures");
            format!("<td class=\"first error\" colspan=\"{COLUMNS}\">{}</td>", escape(error))
        }
    }
}
