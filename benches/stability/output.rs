//! Writes the result files: results.csv, results.json, flicker.csv and stability.svg.

use std::{
    error::Error,
    path::{Path, PathBuf},
};

use serde_json::{Value, json};

use crate::{
    chart,
    common::{
        files::save,
        provenance::Provenance,
        records::{self, Record},
    },
    film::Film,
    options::Plan,
    trials::{Figures, Row},
};

/// Writes the files and returns their paths. All contents are made before the first file is written.
pub(crate) fn write_all(
    folder: &Path,
    rows: &[Row],
    films: &[Film],
    plan: &Plan,
    provenance: &Provenance,
) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let of_rows: Vec<Record> = rows.iter().map(|row| of_row(row, plan, provenance)).collect();
    let of_films: Vec<Record> = films.iter().map(|film| of_film(film, plan, provenance)).collect();
    let files = [
        ("results.csv", records::csv(&of_rows)),
        ("results.json", records::json(&of_rows)),
        ("flicker.csv", records::csv(&of_films)),
        ("stability.svg", chart::svg(rows, plan, provenance)?),
    ];
    save(&files.map(|(name, text)| (name.to_owned(), text)), folder)
}

fn of_row(row: &Row, plan: &Plan, provenance: &Provenance) -> Record {
    let figure = |value: fn(&Figures) -> f64| json!(row.figures.as_ref().ok().map(value));
    let mut record = vec![
        ("trial", json!(row.trial.name())),
        ("reason", json!(row.trial.reason())),
        ("method", json!(row.method.to_string())),
        ("width", json!(plan.size[0])),
        ("height", json!(plan.size[1])),
        ("second_eye_counters", figure(|figures| figures.second_eye)),
        ("pair_of_naive_counters", figure(|figures| figures.of_naive)),
        ("identical", figure(|figures| figures.difference.identical_percent)),
        ("wrong_surface", figure(|figures| figures.difference.wrong_surface_percent)),
        ("surface", figure(|figures| figures.difference.surface_percent)),
        ("identical_of_surfaces", figure(|figures| figures.difference.identical_of_surfaces_percent)),
        ("wrong_of_surfaces", figure(|figures| figures.difference.wrong_of_surfaces_percent)),
        ("psnr", figure(|figures| figures.difference.psnr)), // null if infinite: the pictures are equal
        ("error", json!(row.figures.as_ref().err())),
    ];
    record.extend(origin(provenance));
    record
}

fn of_film(film: &Film, plan: &Plan, provenance: &Provenance) -> Record {
    let mut record = vec![
        ("method", json!(film.method.to_string())),
        ("width", json!(plan.size[0])),
        ("height", json!(plan.size[1])),
        ("frames", json!(plan.frames)),
        ("flicker", json!(film.flicker.as_ref().ok())),
        ("error", json!(film.flicker.as_ref().err())),
    ];
    record.extend(origin(provenance));
    record
}

fn origin(provenance: &Provenance) -> [(&'static str, Value); 4] {
    [
        ("adapter", json!(provenance.adapter)),
        ("driver", json!(provenance.driver)),
        ("commit", json!(provenance.commit)),
        ("date", json!(provenance.date)),
    ]
}
