//! Makes the table of the paper's figures and this library's. It is printed in Markdown and written as CSV and JSON.

use std::{
    error::Error,
    fmt::Write,
    path::{Path, PathBuf},
};

use serde_json::json;

use crate::common::{
    files::save,
    provenance::Provenance,
    records::{self, Record},
};

/// A measured figure of the paper.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Claim {
    /// Section, figure or table of the paper.
    pub(crate) place: &'static str,
    /// Name of the figure, with its unit.
    pub(crate) figure: &'static str,
    /// The paper's value, or the reason why there is none.
    pub(crate) paper: &'static str,
}

/// Setting of this library's measurement.
#[derive(Clone, Debug)]
pub(crate) struct Setting {
    pub(crate) scene: String,
    pub(crate) e_px: f32,
    pub(crate) lights: usize,
    pub(crate) samples: u32,
    pub(crate) method: String,
}

/// Mean, minimum and maximum over several scenes or rounds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Values {
    pub(crate) mean: f64,
    pub(crate) least: f64,
    pub(crate) most: f64,
    pub(crate) count: usize,
}

#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) claim: Claim,
    pub(crate) setting: Setting,
    pub(crate) values: Values,
}

impl Values {
    /// Summarises at least one value.
    pub(crate) fn of(values: &[f64]) -> Self {
        let fold = |start: f64, choose: fn(f64, f64) -> f64| values.iter().copied().fold(start, choose);
        Self {
            mean: values.iter().sum::<f64>() / values.len() as f64,
            least: fold(f64::INFINITY, f64::min),
            most: fold(f64::NEG_INFINITY, f64::max),
            count: values.len(),
        }
    }

    fn text(&self) -> String {
        match self.count {
            1 => format!("{:.3}", self.mean),
            count => format!("{:.3} ({:.3} to {:.3}, {count})", self.mean, self.least, self.most),
        }
    }
}

/// Formats the table in Markdown. The paper's value is in the first row of each claim.
pub(crate) fn table(rows: &[Row], side: u32, provenance: &Provenance) -> String {
    let mut text = format!(
        "{provenance}\n{side}x{side} pixels; of several scenes or rounds the mean, in brackets the least, the largest \
        and \
         how many\n\n| in the paper | figure | its own | scene | e px | lights | samples | method | ours \
             |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    let mut last = None;
    for Row { claim, setting, values } in rows {
        let said = (claim.place, claim.figure, claim.paper);
        let (place, figure, paper) = if last == Some(said) { ("", "", "") } else { said };
        last = Some(said);
        let Setting { scene, e_px, lights, samples, method } = setting;
        let _ = writeln!(
            text,
            "| {place} | {figure} | {paper} | {scene} | {e_px} | {lights} | {samples} | {method} | {} |",
            values.text()
        );
    }
    text
}

/// Writes results.csv and results.json and returns their paths.
pub(crate) fn write(
    folder: &Path,
    rows: &[Row],
    side: u32,
    provenance: &Provenance,
) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let records: Vec<Record> = rows.iter().map(|row| record(row, side, provenance)).collect();
    let files = [("results.csv", records::csv(&records)), ("results.json", records::json(&records))];
    save(&files.map(|(name, text)| (name.to_owned(), text)), folder)
}

fn record(Row { claim, setting, values }: &Row, side: u32, provenance: &Provenance) -> Record {
    vec![
        ("place", json!(claim.place)),
        ("figure", json!(claim.figure)),
        ("paper", json!(claim.paper)),
        ("scene", json!(setting.scene)),
        ("side", json!(side)),
        ("e_px", json!(setting.e_px)),
        ("lights", json!(setting.lights)),
        ("samples", json!(setting.samples)),
        ("method", json!(setting.method)),
        ("mean", json!(values.mean)),
        ("least", json!(values.least)),
        ("most", json!(values.most)),
        ("count", json!(values.count)),
        ("adapter", json!(provenance.adapter)),
        ("driver", json!(provenance.driver)),
        ("commit", json!(provenance.commit)),
        ("date", json!(provenance.date)),
    ]
}
