//! Makes the page's sections of plots: a group of figures for each question.

use std::{collections::HashSet, error::Error};

use super::{
    Content,
    accuracy::{COSTS, accuracy_group},
    line_plot::{Line, LinePlot},
    names::{Names, distinct},
    questions::{QUESTIONS, Question, SUITES, Value},
    text::days,
};
use crate::{
    common::{chart::Point, provenance::marked, scenes},
    record::Record,
};

/// A plot as a file.
pub(super) struct Figure {
    /// Name of the file, without its extension.
    pub(super) name: String,
    pub(super) svg: String,
}

/// Plots of a question.
pub(super) struct Group {
    pub(super) slug: &'static str,
    pub(super) title: &'static str,
    pub(super) sentence: String,
    pub(super) figures: Vec<Figure>,
    /// Note on plots that were left out, with the reason.
    pub(super) note: Option<String>,
}

pub(super) struct Section {
    pub(super) slug: &'static str,
    pub(super) title: &'static str,
    pub(super) groups: Vec<Group>,
}

/// Draws all plots. `bands` has the form of [`super::BANDS`].
pub(super) fn sections(
    content: &Content,
    names: &Names,
    bands: &[(&str, &str, f64, f64)],
) -> Result<Vec<Section>, Box<dyn Error>> {
    let records = last_of_each(&content.records);
    let smoke = content.smoke;
    let accuracy = COSTS.iter().map(|cost| accuracy_group(&records, names, cost, smoke)).collect::<Result<_, _>>()?;
    let mut sections = vec![Section { slug: "accuracy", title: "Accuracy against cost", groups: accuracy }];
    for (suite, title) in SUITES {
        let questions = QUESTIONS.iter().filter(|question| question.suite == suite);
        let groups =
            questions.map(|question| group(question, &records, names, bands, smoke)).collect::<Result<_, _>>()?;
        sections.push(Section { slug: suite, title, groups });
    }
    Ok(sections)
}

/// Returns the last record of each configuration, in the order of the records.
pub(super) fn last_of_each(records: &[Record]) -> Vec<&Record> {
    let mut seen = HashSet::new();
    let key = |r: &Record| (r.width, r.height, r.e_px.to_bits(), r.lights);
    let mut kept: Vec<&Record> =
        records.iter().rev().filter(|r| seen.insert((&r.suite, &r.scene, &r.method, &r.adapter, key(r)))).collect();
    kept.reverse();
    kept
}

/// Draws a question's plots, one per scene. If the question was measured in several sizes or on several machines, there
/// are more plots.
fn group(
    question: &Question,
    records: &[&Record],
    names: &Names,
    bands: &[(&str, &str, f64, f64)],
    smoke: bool,
) -> Result<Group, Box<dyn Error>> {
    let suite: Vec<&Record> = records.iter().copied().filter(|record| record.suite == question.suite).collect();
    let mut figures: Vec<Figure> = Vec::new();
    let mut without = Vec::new();
    for scene in &names.scenes {
        let of_scene = suite.iter().copied().filter(|record| record.scene == *scene);
        let setting = |record: &Record| (question.swept.fixed(record), record.adapter.clone());
        let before = figures.len();
        for wanted in distinct(of_scene.clone().map(setting)) {
            let taken: Vec<&Record> = of_scene.clone().filter(|record| setting(record) == wanted).collect();
            let lines = lines(question, &taken, names);
            if lines.is_empty() {
                continue;
            }
            let title = format!("{}: {}", scenes::title(scene), question.title);
            let source = marked(format!("{}; {}, {}", wanted.0, wanted.1, days(&taken)), smoke);
            let is_ranged = question.slug == "dimensions-speed-up";
            let ranges = bands.iter().filter(|band| is_ranged && (band.0 == scene || band.0 == "*"));
            let ranges = ranges.map(|&(_, method, low, high)| (names.method(method), low, high)).collect();
            let svg = LinePlot { title: &title, source: &source, question, names, lines, ranges }.svg()?;
            let name = free_name(&format!("{}-{}", question.slug, slug(scene)), &figures);
            figures.push(Figure { name, svg });
        }
        if figures.len() == before {
            without.push(scenes::title(scene));
        }
    }
    let note = if suite.is_empty() {
        Some(format!("Left out: there is no record of suite {}.", question.suite))
    } else if figures.is_empty() {
        Some(format!("Left out: no record of suite {} has this figure.", question.suite))
    } else {
        (!without.is_empty()).then(|| format!("Left out for lack of records: {}.", without.join(", ")))
    };
    let mut sentence = question.sentence.to_owned();
    if question.slug == "dimensions-speed-up" && !bands.is_empty() {
        sentence += " Bands, with brackets at their right: the ranges that the thesis states.";
    }
    Ok(Group { slug: question.slug, title: question.title, sentence, figures, note })
}

/// Returns the lines of one scene in one setting. Each method has one line from times, and one from counted tests.
fn lines(question: &Question, records: &[&Record], names: &Names) -> Vec<Line> {
    let values = [(false, Some(question.value)), (true, question.counted)];
    let line = |method: usize, counted: bool, value: Value| {
        let of_method = records.iter().filter(|record| names.method(&record.method) == method);
        let points = of_method.filter_map(|record| Some((question.swept.of(record), value(record)?)));
        let mut points: Vec<Point> = points.filter(|point| point.0.is_finite() && point.1.is_finite()).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let range = question.range.filter(|_| !counted);
        let of_method = records.iter().filter(|record| names.method(&record.method) == method);
        let ranges = of_method.filter_map(|record| Some((question.swept.of(record), range?(record)?)));
        Line { method, counted, points, ranges: ranges.collect() }
    };
    let all = (0..names.methods.len())
        .flat_map(|method| values.into_iter().filter_map(move |(counted, value)| Some((method, counted, value?))));
    all.map(|(method, counted, value)| line(method, counted, value)).filter(|line| !line.points.is_empty()).collect()
}

/// Returns a name in lower-case letters, digits, - and _.
pub(super) fn slug(name: &str) -> String {
    let fits = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "-_".contains(c);
    name.to_lowercase().chars().map(|c| if fits(c) { c } else { '-' }).collect()
}

/// Returns the name, or the name with the first free number from 2.
pub(super) fn free_name(name: &str, taken: &[Figure]) -> String {
    let is_free = |name: &String| taken.iter().all(|figure| figure.name != *name);
    let numbered = (1..).map(|n| if n == 1 { name.to_owned() } else { format!("{name}-{n}") });
    numbered.filter(is_free).take(1).collect()
}
