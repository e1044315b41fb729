//! Collects the benchmark's report: text for the terminal, and files that are written together.

use std::{
    error::Error,
    fs,
    path::{Path, PathBuf},
};

use stereotrace::output::{Batch, Picture};

use crate::{
    charts::Chart,
    common::{
        provenance::Provenance,
        records::{self, Record},
    },
    measure::Sample,
};

/// Results collected while the benchmark runs.
pub(crate) struct Report {
    pub(crate) provenance: Provenance,
    /// Text in Markdown.
    pub(crate) text: String,
    /// Measurements for results.csv.
    pub(crate) samples: Vec<Sample>,
    /// Records for shadows.csv.
    pub(crate) shadows: Vec<Record>,
    charts: Vec<(String, String)>,
    pub(crate) pictures: Vec<(String, Picture)>,
}

impl Report {
    pub(crate) fn new(provenance: Provenance) -> Self {
        let text = format!("{provenance}\n\n");
        Self { provenance, text, samples: vec![], shadows: vec![], charts: vec![], pictures: vec![] }
    }

    /// Draws a chart, if it has any points.
    pub(crate) fn chart(&mut self, name: &str, chart: Chart<'_>) -> Result<(), Box<dyn Error>> {
        self.charts.extend(chart.svg(&self.provenance.source())?.map(|svg| (format!("{name}.svg"), svg)));
        Ok(())
    }

    /// Writes all files of the report. No file gets its final name before all are written.
    pub(crate) fn write(&self, folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
        fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let samples: Vec<Record> = self.samples.iter().map(|sample| sample.record(&self.provenance)).collect();
        let mut batch = Batch::new();
        batch.add(folder.join("report.md"), self.text.as_bytes())?;
        for (name, list) in [("results", &samples), ("shadows", &self.shadows)] {
            if !list.is_empty() {
                batch.add(folder.join(format!("{name}.csv")), records::csv(list).as_bytes())?;
                batch.add(folder.join(format!("{name}.json")), records::json(list).as_bytes())?;
            }
        }
        for (name, svg) in &self.charts {
            batch.add(folder.join(name), svg.as_bytes())?;
        }
        for (name, picture) in &self.pictures {
            batch.add_png(folder.join(format!("{name}.png")), picture)?;
        }
        Ok(batch.commit()?)
    }
}

/// Formats a figure with about three digits, or a dash if there is none.
pub(crate) fn number(value: Option<f64>) -> String {
    match value {
        None => "-".into(),
        Some(value) if value.abs() >= 100.0 || value == 0.0 => format!("{value:.0}"),
        Some(value) if value.abs() >= 10.0 => format!("{value:.1}"),
        Some(value) if value.abs() >= 1.0 => format!("{value:.2}"),
        Some(value) => format!("{value:.3}"),
    }
}
