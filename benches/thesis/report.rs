//! The report: plots by question and scene, the pictures and a table of all records, in one page that stands alone. Sections
//! of other matters are in files of their own beside this one.

#[path = "report/sources.rs"]
mod sources;
#[path = "report/stability.rs"]
mod stability;

use std::{
    cmp::Reverse,
    collections::HashSet,
    error::Error,
    fmt::Write as _,
    path::{Path, PathBuf},
};

use plotters::{
    coord::Shift,
    prelude::*,
    style::{
        FontTransform,
        text_anchor::{HPos, Pos, VPos},
    },
};

pub(crate) use self::{sources::Sources, stability::Stability};
use crate::{
    common::{
        chart::{FONT, GRID, INK, Point, frontier},
        files::save,
        scenes,
    },
    record::Record,
};

/// The thesis's stated ranges of the speed-up over naive: scene, or `*` for all of them, method, lowest and highest in
/// percent. They are drawn behind the speed-up against the picture's width.
///
/// Its averages over the sizes, from the lowest scene on the one machine to the highest on the other (figures 27 and 35).
const BANDS: &[(&str, &str, f64, f64)] =
    &[("*", "ideal", 29.0, 92.0), ("*", "atomic", 14.0, 67.0), ("*", "buffer", 6.0, 58.0)];

/// Width of the pictures, in pixels, that accuracy is set against cost at; the nearest one that was measured is taken.
const ACCURACY_WIDTH: u32 = 600;
/// The axis of the second eye's cost reaches no farther than a little beyond this (first eye = 1).
const DEAREST: f64 = 2.0;

/// A picture to show beside the plots.
pub(crate) struct Picture {
    pub(crate) scene: String,
    pub(crate) method: String,
    /// What it shows of them: left, right, anaglyph, difference x8, re-trace map, cost left, cost right.
    pub(crate) kind: String,
    pub(crate) caption: String,
    /// A PNG file.
    pub(crate) png: Vec<u8>,
}

/// What the page is made of.
#[derive(Default)]
pub(crate) struct Content {
    pub(crate) records: Vec<Record>,
    pub(crate) pictures: Vec<Picture>,
    pub(crate) sources: Vec<Sources>,
    /// `None` if that benchmark has not run.
    pub(crate) stability: Option<Stability>,
}

/// Writes report.html and its plots, an SVG file each, into `folder`, all or none, and returns their paths, the page's
/// last. Of a configuration that was measured more than once the plots show the last record, the table all.
pub(crate) fn write(content: &Content, folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let names = Names::of(&content.records, &content.pictures);
    let sections = sections(&content.records, &names, BANDS)?;
    let page = page(content, &names, &sections);
    let figures = sections.into_iter().flat_map(|section| section.groups).flat_map(|group| group.figures);
    let mut files: Vec<(String, String)> = figures.map(|figure| (format!("{}.svg", figure.name), figure.svg)).collect();
    files.push(("report.html".into(), page));
    save(&files, folder)
}

/// Scenes and methods in the order in which they are shown. A method's place gives it its look, a scene's its colour.
struct Names {
    scenes: Vec<String>,
    methods: Vec<String>,
}

/// The methods whose looks are the same in every report; others follow as they come.
const METHODS: [&str; 10] = [
    "naive",
    "ideal",
    "atomic",
    "buffer",
    "buffer-2e",
    "es-isler",
    "adelson-hodges",
    "atomic-edges",
    "bracket",
    "verified",
];
/// Those that the thesis does not have, and those that only its future work names.
const OWN: [&str; 4] = ["bracket", "verified", "bracket-rays", "auto"];
const FUTURE_WORK: [&str; 2] = ["atomic-edges", "buffer-edges"];

impl Names {
    fn of(records: &[Record], pictures: &[Picture]) -> Self {
        let pairs = records.iter().map(|r| (&r.scene, &r.method)).chain(pictures.iter().map(|p| (&p.scene, &p.method)));
        let methods = METHODS.into_iter().chain(pairs.clone().map(|(_, method)| method.as_str()));
        Self { scenes: distinct(pairs.map(|(scene, _)| scene.clone())), methods: distinct(methods.map(String::from)) }
    }

    /// An unknown name's place is behind all others.
    fn scene(&self, name: &str) -> usize {
        self.scenes.iter().position(|scene| scene == name).unwrap_or(self.scenes.len())
    }

    fn method(&self, name: &str) -> usize {
        self.methods.iter().position(|method| method == name).unwrap_or(self.methods.len())
    }
}

/// Each value once, in order of its first appearance.
fn distinct<T: PartialEq>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut kept = Vec::new();
    for value in values {
        if !kept.contains(&value) {
            kept.push(value);
        }
    }
    kept
}

// ---- what is plotted ----

/// What a suite varies, and so a plot's x axis.
#[derive(Clone, Copy, PartialEq)]
enum Swept {
    Width,
    Interaxial,
    Lights,
}

impl Swept {
    fn of(self, record: &Record) -> f64 {
        match self {
            Self::Width => f64::from(record.width),
            Self::Interaxial => f64::from(record.e_px),
            Self::Lights => record.lights as f64,
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Width => "picture width, pixels",
            Self::Interaxial => "interaxial e, pixels",
            Self::Lights => "lights",
        }
    }

    /// What stays the same along the axis.
    fn fixed(self, record: &Record) -> String {
        let size = format!("{}x{}", record.width, record.height);
        let (e, lights) = (format!("e = {} px", record.e_px), count(record.lights, "light"));
        match self {
            Self::Width => format!("{e}, {lights}"),
            Self::Interaxial => format!("{size}, {lights}"),
            Self::Lights => format!("{size}, {e}"),
        }
    }
}

/// How a plot's y axis runs.
#[derive(Clone, Copy)]
enum Rule {
    /// Evenly, from zero on or across it.
    Even,
    /// The same, or a row a decade where the values lie too far apart for that.
    Amount,
    /// A row a decade, with zero in a row of its own.
    Decades,
}

/// A figure of a record, in the unit that its plot names.
type Value = fn(&Record) -> Option<f64>;

/// A question that is plotted scene by scene.
struct Question {
    suite: &'static str,
    /// Begins the names of its files.
    slug: &'static str,
    title: &'static str,
    /// What is seen along the axes.
    sentence: &'static str,
    swept: Swept,
    y_label: &'static str,
    rule: Rule,
    value: Value,
    /// The same by counters in place of time.
    counted: Option<Value>,
}

const SUITES: [(&str, &str); 5] = [
    ("dimensions", "Picture size"),
    ("interaxial", "Interaxial"),
    ("lights", "Lights"),
    ("mse-dimensions", "Error against picture size"),
    ("mse-interaxial", "Error against interaxial"),
];

const QUESTIONS: [Question; 9] = [
    Question {
        suite: "dimensions",
        slug: "dimensions-speed-up",
        title: "speed-up against picture width",
        sentence: "Across: the picture's width in pixels. Up: naive's time for the pair over the method's, less 1, in \
                   percent; 0 is naive.",
        swept: Swept::Width,
        y_label: "speed-up over naive, %",
        rule: Rule::Even,
        value: speed_up,
        counted: None,
    },
    Question {
        suite: "dimensions",
        slug: "dimensions-fps",
        title: "pairs a second against picture width",
        sentence: "Across: the picture's width in pixels. Up: stereo pairs a second.",
        swept: Swept::Width,
        y_label: "pairs a second",
        rule: Rule::Amount,
        value: |record| Some(record.fps),
        counted: None,
    },
    Question {
        suite: "interaxial",
        slug: "interaxial-pair-time",
        title: "pair time against interaxial",
        sentence: "Across: the interaxial e in pixels. Up: median time of the pair's passes in milliseconds.",
        swept: Swept::Interaxial,
        y_label: "pair time, ms",
        rule: Rule::Amount,
        value: |record| Some(record.pair_ms),
        counted: None,
    },
    Question {
        suite: "interaxial",
        slug: "interaxial-speed-up",
        title: "speed-up against interaxial",
        sentence: "Across: the interaxial e in pixels. Up: naive's time for the pair over the method's, less 1, in \
                   percent; 0 is naive.",
        swept: Swept::Interaxial,
        y_label: "speed-up over naive, %",
        rule: Rule::Even,
        value: speed_up,
        counted: None,
    },
    Question {
        suite: "interaxial",
        slug: "interaxial-slot-time",
        title: "time a slot against interaxial",
        sentence: "Across: the interaxial e in pixels. Up: nanoseconds a slot and pixel that a buffer takes to be \
                   stored and searched.",
        swept: Swept::Interaxial,
        y_label: "time a slot and pixel, ns",
        rule: Rule::Amount,
        value: |record| record.slot_ns,
        counted: None,
    },
    Question {
        suite: "interaxial",
        slug: "interaxial-depth",
        title: "buffer depth against interaxial",
        sentence: "Across: the interaxial e in pixels. Up: a buffer's slots a right pixel.",
        swept: Swept::Interaxial,
        y_label: "slots a right pixel",
        rule: Rule::Even,
        value: |record| (record.buffer_depth > 0).then(|| f64::from(record.buffer_depth)),
        counted: None,
    },
    Question {
        suite: "lights",
        slug: "lights-speed-up",
        title: "speed-up against lights",
        sentence: "Across: the number of lights. Up: speed-up of the pair over naive in percent, by time (solid, \
                   filled markers) and by counters (dotted, hollow markers); 0 is naive.",
        swept: Swept::Lights,
        y_label: "speed-up over naive, %",
        rule: Rule::Even,
        value: speed_up,
        counted: Some(|record| (record.method != "naive").then_some(100.0 * record.speed_up_counters)),
    },
    Question {
        suite: "mse-dimensions",
        slug: "mse-dimensions",
        title: "MSE against picture width",
        sentence: "Across: the picture's width in pixels. Up: mean squared difference of the right view from naive's, \
                   a row a decade; in the row of zero the methods stand one above the other.",
        swept: Swept::Width,
        y_label: "MSE",
        rule: Rule::Decades,
        value: error,
        counted: None,
    },
    Question {
        suite: "mse-interaxial",
        slug: "mse-interaxial",
        title: "MSE against interaxial",
        sentence: "Across: the interaxial e in pixels. Up: mean squared difference of the right view from naive's, a \
                   row a decade; in the row of zero the methods stand one above the other.",
        swept: Swept::Interaxial,
        y_label: "MSE",
        rule: Rule::Decades,
        value: error,
        counted: None,
    },
];

/// In percent. Naive's own is 0 by definition.
fn speed_up(record: &Record) -> Option<f64> {
    (record.method != "naive").then_some(100.0 * record.speed_up)
}

/// Naive's own is 0 by definition.
fn error(record: &Record) -> Option<f64> {
    (record.method != "naive").then_some(record.mse)
}

/// A plot as a file.
struct Figure {
    /// Of the file, without its ending.
    name: String,
    svg: String,
}

/// The plots of a question.
struct Group {
    slug: &'static str,
    title: &'static str,
    sentence: String,
    figures: Vec<Figure>,
    /// What was left out, and why.
    note: Option<String>,
}

struct Section {
    slug: &'static str,
    title: &'static str,
    groups: Vec<Group>,
}

/// All plots. `bands` as in [`BANDS`].
fn sections(
    records: &[Record],
    names: &Names,
    bands: &[(&str, &str, f64, f64)],
) -> Result<Vec<Section>, Box<dyn Error>> {
    let records = last_of_each(records);
    let accuracy = COSTS.iter().map(|cost| accuracy_group(&records, names, cost)).collect::<Result<_, _>>()?;
    let mut sections = vec![Section { slug: "accuracy", title: "Accuracy against cost", groups: accuracy }];
    for (suite, title) in SUITES {
        let questions = QUESTIONS.iter().filter(|question| question.suite == suite);
        let groups = questions.map(|question| group(question, &records, names, bands)).collect::<Result<_, _>>()?;
        sections.push(Section { slug: suite, title, groups });
    }
    Ok(sections)
}

/// The last record of each configuration, in their order.
fn last_of_each(records: &[Record]) -> Vec<&Record> {
    let mut seen = HashSet::new();
    let key = |r: &Record| (r.width, r.height, r.e_px.to_bits(), r.lights);
    let mut kept: Vec<&Record> =
        records.iter().rev().filter(|r| seen.insert((&r.suite, &r.scene, &r.method, &r.adapter, key(r)))).collect();
    kept.reverse();
    kept
}

/// A question's plots, one a scene, and more where it was measured in several sizes or on several machines.
fn group(
    question: &Question,
    records: &[&Record],
    names: &Names,
    bands: &[(&str, &str, f64, f64)],
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
            let source = format!("{}; {}, {}", wanted.0, wanted.1, days(&taken));
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

/// A line a method, by time and by counters, of one scene in one setting.
fn lines(question: &Question, records: &[&Record], names: &Names) -> Vec<Line> {
    let values = [(false, Some(question.value)), (true, question.counted)];
    let line = |method: usize, counted: bool, value: Value| {
        let of_method = records.iter().filter(|record| names.method(&record.method) == method);
        let points = of_method.filter_map(|record| Some((question.swept.of(record), value(record)?)));
        let mut points: Vec<Point> = points.filter(|point| point.0.is_finite() && point.1.is_finite()).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Line { method, counted, points }
    };
    let all = (0..names.methods.len())
        .flat_map(|method| values.into_iter().filter_map(move |(counted, value)| Some((method, counted, value?))));
    all.map(|(method, counted, value)| line(method, counted, value)).filter(|line| !line.points.is_empty()).collect()
}

/// What the second eye costs relative to the first.
struct Cost {
    slug: &'static str,
    title: &'static str,
    of: fn(&Record) -> f64,
    x_label: &'static str,
    by: &'static str,
}

const COSTS: [Cost; 2] = [
    Cost {
        slug: "accuracy-time",
        title: "accuracy against cost by time",
        of: |record| record.second_eye,
        x_label: "cost of the second eye by time (first eye = 1)",
        by: "time",
    },
    Cost {
        slug: "accuracy-counters",
        title: "accuracy against cost by counters",
        of: |record| record.second_eye_counters,
        x_label: "cost of the second eye by counters (first eye = 1)",
        by: "counters",
    },
];

/// A plot an adapter, of the records nearest to [`ACCURACY_WIDTH`].
fn accuracy_group(records: &[&Record], names: &Names, cost: &Cost) -> Result<Group, Box<dyn Error>> {
    let suite: Vec<&Record> = records.iter().copied().filter(|record| record.suite == "dimensions").collect();
    let mut figures: Vec<Figure> = Vec::new();
    for adapter in distinct(suite.iter().map(|record| &record.adapter)) {
        let of_adapter = suite.iter().copied().filter(|record| record.adapter == *adapter);
        let nearest = |scene| nearest_width(of_adapter.clone(), scene);
        let taken: Vec<&Record> = names.scenes.iter().flat_map(nearest).collect();
        let dots = taken.iter().map(|record| Dot {
            scene: names.scene(&record.scene),
            method: names.method(&record.method),
            cost: (cost.of)(record),
            errors: [100.0 - record.identical, record.wrong_surface, record.mse],
        });
        let dots: Vec<Dot> =
            dots.filter(|dot| dot.cost.is_finite() && dot.errors.iter().all(|e| e.is_finite())).collect();
        if dots.is_empty() {
            continue;
        }
        let setting = |record: &&Record| format!("{}x{}, e = {} px", record.width, record.height, record.e_px);
        let settings = distinct(taken.iter().map(setting)).join("; ");
        let source = format!("{settings}; {adapter}, {}", days(&taken));
        let title = format!("Accuracy against cost by {}", cost.by);
        let (cheapest, dearest) = dots.iter().fold((0.0, 1.0), |(c, d): Point, dot| (c.min(dot.cost), d.max(dot.cost)));
        let mut x = Axis::even(cheapest, dearest.min(DEAREST), 8.0);
        (x.low, x.high) = (cheapest - 0.03, 1.06 * dearest.min(DEAREST));
        x.ticks.retain(|tick| (x.low..=x.high).contains(tick));
        let mut beyond = distinct(dots.iter().filter(|dot| dot.cost > x.high).map(|dot| dot.method));
        beyond.sort_unstable();
        let (title, source) = (title.as_str(), source.as_str());
        let svg = Scatter { title, source, x_label: cost.x_label, names, dots: &dots, x, beyond }.svg()?;
        let name = free_name(cost.slug, &figures);
        figures.push(Figure { name, svg });
    }
    let note = figures.is_empty().then(|| "Left out: there is no record of suite dimensions.".to_owned());
    let sentence = format!(
        "Across: what the second eye costs by {}, where the first costs 1; a method that goes beyond the axis has a \
         column at its end, and its costs in the legend. Up, from top to bottom: pixels of the right view that differ \
         from naive's, pixels that show another surface, and MSE, a row a decade with zero in a row of its own. A \
         marker's shape is its method, its colour its scene; hollow markers are means over the scenes of those methods \
         that no other beats in cost and accuracy, among the methods that were measured on every scene.",
        cost.by
    );
    Ok(Group { slug: cost.slug, title: cost.title, sentence, figures, note })
}

/// A scene's records of the width nearest to [`ACCURACY_WIDTH`].
fn nearest_width<'a>(records: impl Iterator<Item = &'a Record> + Clone, scene: &String) -> Vec<&'a Record> {
    let of_scene = records.filter(|record| record.scene == *scene);
    let width = of_scene.clone().map(|record| record.width);
    let width = width.min_by_key(|width| (width.abs_diff(ACCURACY_WIDTH), Reverse(*width)));
    of_scene.filter(move |record| Some(record.width) == width).collect()
}

/// Lower case letters, digits, - and _ of a name.
fn slug(name: &str) -> String {
    let fits = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "-_".contains(c);
    name.to_lowercase().chars().map(|c| if fits(c) { c } else { '-' }).collect()
}

/// The name, or the name and the first number from 2 on that is not taken.
fn free_name(name: &str, taken: &[Figure]) -> String {
    let is_free = |name: &String| taken.iter().all(|figure| figure.name != *name);
    let numbered = (1..).map(|n| if n == 1 { name.to_owned() } else { format!("{name}-{n}") });
    numbered.filter(is_free).take(1).collect()
}

/// First and last day of some records.
fn days<'a>(records: impl IntoIterator<Item = &'a &'a Record>) -> String {
    let mut days: Vec<&str> = records.into_iter().map(|r| r.date.split('T').next().unwrap_or(&r.date)).collect();
    days.sort_unstable();
    match (days.first(), days.last()) {
        (Some(first), Some(last)) if first != last => format!("{first} to {last}"),
        (first, _) => first.copied().unwrap_or_default().to_owned(),
    }
}

/// 1234567 and triangle as 1,234,567 triangles.
fn count(number: usize, noun: &str) -> String {
    let digits = number.to_string();
    let groups: Vec<_> = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy).collect();
    format!("{} {noun}{}", groups.join(","), if number == 1 { "" } else { "s" })
}

// ---- plots ----

/// Okabe and Ito's colours, that the colour-blind can tell apart, with brown for their yellow, and two more.
const COLORS: [RGBColor; 10] = [
    RGBColor(0, 0, 0),
    RGBColor(140, 81, 10),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(86, 180, 233),
    RGBColor(204, 121, 167),
    RGBColor(84, 39, 136),
    RGBColor(150, 0, 60),
];
/// Lengths of stroke and gap in turn, in pixels.
const DASHES: [&[f64]; 11] = [
    &[],
    &[2.0, 5.0],
    &[],
    &[12.0, 4.0],
    &[12.0, 4.0, 2.0, 4.0],
    &[6.0, 4.0],
    &[18.0, 3.0, 2.0, 3.0, 2.0, 3.0],
    &[3.0, 3.0],
    &[],
    &[9.0, 3.0],
    &[4.0, 8.0],
];
const DOTS: &[f64] = &[2.0, 4.0];
/// Corners of the methods' markers, about their point; without any a circle. No two methods of a run share one.
#[rustfmt::skip]
const SHAPES: [&[Pixel]; 13] = [
    &[(-5, -5), (5, -5), (5, 5), (-5, 5)],
    &[(0, -7), (7, 0), (0, 7), (-7, 0)],
    &[],
    &[(0, -7), (7, 5), (-7, 5)],
    &[(0, 7), (7, -5), (-7, -5)],
    &[(-7, -2), (-2, -2), (-2, -7), (2, -7), (2, -2), (7, -2), (7, 2), (2, 2), (2, 7), (-2, 7), (-2, 2), (-7, 2)],
    &[(-7, -4), (-4, -7), (0, -3), (4, -7), (7, -4), (3, 0), (7, 4), (4, 7), (0, 3), (-4, 7), (-7, 4), (-3, 0)],
    &[(0, -8), (2, -3), (8, -2), (3, 1), (5, 7), (0, 3), (-5, 7), (-3, 1), (-8, -2), (-2, -3)],
    &[(-5, -7), (7, 0), (-5, 7)],
    &[(5, -7), (-7, 0), (5, 7)],
    &[(-8, -3), (8, -3), (8, 3), (-8, 3)],
    &[(-3, -8), (3, -8), (3, 8), (-3, 8)],
    &[(-6, -7), (6, -7), (-6, 7), (6, 7)],
];

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Pixel = (i32, i32);
type Drawn = Result<(), Box<dyn Error>>;

/// A method's measured points, ordered by x.
struct Line {
    method: usize,
    counted: bool,
    points: Vec<Point>,
}

/// A question's answer on one scene.
struct LinePlot<'a> {
    title: &'a str,
    source: &'a str,
    question: &'a Question,
    names: &'a Names,
    lines: Vec<Line>,
    /// Method, lowest and highest value.
    ranges: Vec<(usize, f64, f64)>,
}

impl LinePlot<'_> {
    const SIZE: (u32, u32) = (680, 390);
    const LEGEND_X: i32 = 508;
    const RANGE_STEP: i32 = 18;

    fn svg(&self) -> Result<String, Box<dyn Error>> {
        let points = || self.lines.iter().flat_map(|line| line.points.iter());
        let limits = self.ranges.iter().flat_map(|&(_, low, high)| [low, high]);
        let values: Vec<f64> = points().map(|point| point.1).chain(limits).collect();
        let x = Axis::through(points().map(|point| point.0));
        let y = Axis::of(self.question.rule, &values);
        let right = Self::LEGEND_X - 18 - Self::RANGE_STEP * self.ranges.len() as i32;
        let frame = Frame { left: 72, right, top: 62, bottom: Self::SIZE.1 as i32 - 50, x: &x, y: &y };
        drawing(Self::SIZE, self.title, |root| {
            heading(root, self.title, self.source)?;
            frame.draw(root, self.question.y_label, Some(self.question.swept.label()))?;
            self.draw_ranges(root, &frame)?;
            self.draw_lines(root, &frame)?;
            self.legend(root)
        })
    }

    fn draw_ranges(&self, root: &Area<'_>, frame: &Frame<'_>) -> Drawn {
        for (index, &(method, low, high)) in self.ranges.iter().enumerate() {
            let y = |value| frame.place((0.0, value)).1;
            let (low, high, tone) = (y(low), y(high), color(method));
            root.draw(&Rectangle::new([(frame.left, high), (frame.right, low)], tone.mix(0.10).filled()))?;
            for y in [low, high] {
                stroke(root, &[(frame.left, y), (frame.right, y)], dash(method), tone.mix(0.6).stroke_width(1))?;
            }
            bracket(root, frame.right + 10 + Self::RANGE_STEP * index as i32, (high, low), method)?;
        }
        Ok(())
    }

    fn draw_lines(&self, root: &Area<'_>, frame: &Frame<'_>) -> Drawn {
        // Lines in the row of zero would hide each other: each gets a place of its own there.
        let meets_zero = |line: &&Line| line.points.iter().any(|point| point.1 <= 0.0);
        let count = self.lines.iter().filter(meets_zero).count() as f64;
        let places = self.lines.iter().enumerate().map(|(index, line)| {
            let before = self.lines[..index].iter().filter(meets_zero).count() as f64;
            let spread = frame.y.zero_row() * (before + 0.5 - count / 2.0) / (count + 1.0);
            let place = |&point: &Point| {
                let (x, y) = frame.place(point);
                (x, if point.1 > 0.0 { y } else { y + spread.round() as i32 })
            };
            (line, line.points.iter().map(place).collect::<Vec<Pixel>>())
        });
        let places: Vec<_> = places.collect();
        for (line, pixels) in &places {
            stroke(root, pixels, self.dash(line), color(line.method).stroke_width(2))?;
        }
        for (line, pixels) in &places {
            for &pixel in pixels {
                line_marker(root, line, pixel)?;
            }
        }
        Ok(())
    }

    fn dash(&self, line: &Line) -> &'static [f64] {
        match self.question.counted {
            Some(_) if line.counted => DOTS,
            Some(_) => &[],
            None => dash(line.method),
        }
    }

    fn legend(&self, root: &Area<'_>) -> Drawn {
        let mut y = 74;
        let step = (240 / self.lines.len() as i32).clamp(14, 20);
        let entry = |line: &Line, y: i32, name: &str| {
            let sample = [(Self::LEGEND_X, y), (Self::LEGEND_X + 36, y)];
            stroke(root, &sample, self.dash(line), color(line.method).stroke_width(2))?;
            line_marker(root, line, (Self::LEGEND_X + 18, y))?;
            text(root, name, (Self::LEGEND_X + 44, y), 13)
        };
        let mut shown = Vec::new();
        for line in &self.lines {
            if !shown.contains(&line.method) {
                shown.push(line.method);
                entry(&Line { counted: false, points: vec![], ..*line }, y, &self.names.methods[line.method])?;
                y += step;
            }
        }
        if self.question.counted.is_some() {
            y += 10;
            for (counted, name) in [(false, "by time"), (true, "by counters")] {
                entry(&Line { method: self.lines[0].method, counted, points: vec![] }, y, name)?;
                y += step;
            }
        }
        if let Some(&(method, ..)) = self.ranges.first() {
            bracket(root, Self::LEGEND_X + 18, (y + 6, y + 34), method)?;
            text(root, "range that the", (Self::LEGEND_X + 44, y + 12), 13)?;
            text(root, "thesis states", (Self::LEGEND_X + 44, y + 28), 13)?;
        }
        Ok(())
    }
}

/// One method on one scene.
struct Dot {
    scene: usize,
    method: usize,
    cost: f64,
    /// One a panel of [`PANELS`].
    errors: [f64; 3],
}

const PANELS: [&str; 3] = ["differing pixels, %", "wrong surface, % of pixels", "MSE"];

/// Three panels over the same costs, and a column at their right for each method whose cost goes beyond the axis.
struct Scatter<'a> {
    title: &'a str,
    source: &'a str,
    x_label: &'a str,
    names: &'a Names,
    dots: &'a [Dot],
    x: Axis,
    /// Methods with a cost beyond the axis.
    beyond: Vec<usize>,
}

impl Scatter<'_> {
    const SIZE: (u32, u32) = (820, 900);
    const LEGEND_X: i32 = 645;
    const LINE: i32 = 20;
    const PANEL: i32 = 254;
    const COLUMN: i32 = 22;

    fn svg(&self) -> Result<String, Box<dyn Error>> {
        let right = Self::LEGEND_X - 20 - Self::COLUMN * self.beyond.len() as i32;
        drawing(Self::SIZE, self.title, |root| {
            heading(root, self.title, self.source)?;
            for (panel, y_label) in PANELS.into_iter().enumerate() {
                // A mean can lie below all errors but zero.
                let means = means(self.dots, panel).into_iter().map(|(_, mean)| mean.1);
                let errors: Vec<f64> = self.dots.iter().map(|dot| dot.errors[panel]).chain(means).collect();
                let y = Axis::of(Rule::Decades, &errors);
                let top = 62 + panel as i32 * (Self::PANEL + 14);
                let frame = Frame { left: 78, right, top, bottom: top + Self::PANEL, x: &self.x, y: &y };
                frame.draw(root, y_label, (panel + 1 == PANELS.len()).then_some(self.x_label))?;
                self.draw_panel(root, &frame, panel)?;
            }
            self.legend(root)
        })
    }

    fn draw_panel(&self, root: &Area<'_>, frame: &Frame<'_>, panel: usize) -> Drawn {
        let place = |method: usize, (cost, error): Point| {
            let (x, y) = frame.place((cost, error));
            let column = self.beyond.iter().position(|&beyond| beyond == method && cost > self.x.high);
            (column.map_or(x, |column| frame.right + Self::COLUMN * column as i32 + Self::COLUMN / 2 + 2), y)
        };
        let end = frame.right + Self::COLUMN * self.beyond.len() as i32 + 2;
        if !self.beyond.is_empty() {
            for x in [frame.right, end] {
                stroke(root, &[(x, frame.top), (x, frame.bottom)], DOTS, INK.stroke_width(1))?;
            }
        }
        let means = means(self.dots, panel);
        let frontier = frontier(&means.iter().map(|&(_, mean)| mean).collect::<Vec<_>>());
        let means: Vec<(usize, Pixel)> =
            frontier.into_iter().map(|index| (means[index].0, place(means[index].0, means[index].1))).collect();
        let line: Vec<Pixel> = means.iter().map(|&(_, pixel)| pixel).collect();
        stroke(root, &line, &[], INK.stroke_width(2))?;
        for dot in self.dots {
            let at = place(dot.method, (dot.cost, dot.errors[panel]));
            marker(root, dot.method, at, color(dot.scene).filled(), WHITE.into())?;
        }
        for (method, pixel) in means {
            marker(root, method, pixel, WHITE.filled(), INK.stroke_width(2))?;
        }
        Ok(())
    }

    fn legend(&self, root: &Area<'_>) -> Drawn {
        let (x, mut y) = (Self::LEGEND_X, 72);
        let shown = |pick: fn(&Dot) -> usize, all: usize| {
            (0..all).filter(move |&index| self.dots.iter().any(|dot| pick(dot) == index))
        };
        text(root, "method", (x, y), 14)?;
        for method in shown(|dot| dot.method, self.names.methods.len()) {
            y += Self::LINE;
            marker(root, method, (x + 8, y), INK.filled(), WHITE.into())?;
            text(root, &self.names.methods[method], (x + 26, y), 13)?;
        }
        y += Self::LINE + 12;
        text(root, "scene", (x, y), 14)?;
        for scene in shown(|dot| dot.scene, self.names.scenes.len()) {
            y += Self::LINE;
            root.draw(&Rectangle::new([(x, y - 5), (x + 16, y + 5)], color(scene).filled()))?;
            text(root, scenes::title(&self.names.scenes[scene]), (x + 26, y), 13)?;
        }
        y += Self::LINE + 14;
        stroke(root, &[(x - 4, y), (x + 20, y)], &[], INK.stroke_width(2))?;
        root.draw(&Circle::new((x + 8, y), 6, WHITE.filled()))?;
        root.draw(&Circle::new((x + 8, y), 6, INK.stroke_width(2)))?;
        text(root, "means of all scenes,", (x + 26, y), 13)?;
        text(root, "on the frontier", (x + 26, y + 16), 13)?;
        if !self.beyond.is_empty() {
            y += Self::LINE + 36;
            text(root, "beyond the axis: cost", (x, y), 14)?;
        }
        for &method in &self.beyond {
            y += Self::LINE;
            let costs = || self.dots.iter().filter(|dot| dot.method == method).map(|dot| dot.cost);
            let (least, most) = (costs().fold(f64::INFINITY, f64::min), costs().fold(0.0, f64::max));
            marker(root, method, (x + 8, y), INK.filled(), WHITE.into())?;
            text(root, &format!("{least:.1} to {most:.1}"), (x + 26, y), 13)?;
        }
        Ok(())
    }
}

/// Mean point in a panel, by method, of those methods that were measured on every scene.
fn means(dots: &[Dot], panel: usize) -> Vec<(usize, Point)> {
    let scenes = distinct(dots.iter().map(|dot| dot.scene)).len();
    let mut methods = distinct(dots.iter().map(|dot| dot.method));
    methods.sort_unstable();
    let mean = |method: usize| {
        let of_method: Vec<&Dot> = dots.iter().filter(|dot| dot.method == method).collect();
        let is_whole = distinct(of_method.iter().map(|dot| dot.scene)).len() == scenes;
        let mean =
            |part: &dyn Fn(&Dot) -> f64| of_method.iter().map(|dot| part(dot)).sum::<f64>() / of_method.len() as f64;
        is_whole.then(|| (method, (mean(&|dot| dot.cost), mean(&|dot| dot.errors[panel]))))
    };
    methods.into_iter().filter_map(mean).collect()
}

/// An SVG with a white ground.
fn drawing(size: (u32, u32), title: &str, draw: impl FnOnce(&Area<'_>) -> Drawn) -> Result<String, Box<dyn Error>> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        draw(&root)?;
        root.present()?;
    }
    Ok(svg.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{}\" ", escape(title)), 1))
}

fn heading(root: &Area<'_>, title: &str, source: &str) -> Drawn {
    text(root, title, (14, 20), 16)?;
    text(root, source, (14, 41), 12)
}

/// Text from this point on, centred on its height.
fn text(root: &Area<'_>, text: &str, at: Pixel, size: i32) -> Drawn {
    let style = (FONT, size).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
    Ok(root.draw(&Text::new(printable(text), at, style))?)
}

/// A line through the points, with strokes and gaps of these lengths in turn; solid without any.
fn stroke(root: &Area<'_>, points: &[Pixel], lengths: &[f64], style: ShapeStyle) -> Drawn {
    for piece in dashed(points, lengths) {
        root.draw(&PathElement::new(piece, style))?;
    }
    Ok(())
}

fn dashed(points: &[Pixel], lengths: &[f64]) -> Vec<Vec<Pixel>> {
    let (Some(&first), Some(&length)) = (points.first(), lengths.first()) else { return vec![points.to_vec()] };
    let (mut pieces, mut piece) = (Vec::new(), vec![first]);
    let (mut turn, mut left) = (0, length);
    for pair in points.windows(2) {
        let [(x, y), (dx, dy)] = [pair[0], (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1)];
        let whole = f64::from(dx).hypot(f64::from(dy));
        let mut done = 0.0;
        while whole - done > left {
            done += left;
            let at = |from: i32, d: i32| (f64::from(from) + f64::from(d) * done / whole).round() as i32;
            piece.push((at(x, dx), at(y, dy)));
            let ended = std::mem::replace(&mut piece, vec![(at(x, dx), at(y, dy))]);
            if turn % 2 == 0 {
                pieces.push(ended);
            }
            turn += 1;
            left = lengths[turn % lengths.len()];
        }
        left -= whole - done;
        piece.push(pair[1]);
    }
    if turn % 2 == 0 {
        pieces.push(piece);
    }
    pieces
}

/// A vertical range from `top` to `bottom`, with the method's marker in its middle.
fn bracket(root: &Area<'_>, x: i32, (top, bottom): (i32, i32), method: usize) -> Drawn {
    let corners = [(x - 4, top), (x + 4, top), (x, top), (x, bottom), (x - 4, bottom), (x + 4, bottom)];
    stroke(root, &corners, &[], color(method).stroke_width(2))?;
    marker(root, method, (x, top.midpoint(bottom)), color(method).filled(), WHITE.into())
}

/// Filled for times, hollow for counters.
fn line_marker(root: &Area<'_>, line: &Line, at: Pixel) -> Drawn {
    let tone = color(line.method);
    if line.counted {
        marker(root, line.method, at, WHITE.filled(), tone.stroke_width(2))
    } else {
        marker(root, line.method, at, tone.filled(), WHITE.into())
    }
}

/// A method's marker, with a rim so that neighbours stand apart.
fn marker(root: &Area<'_>, method: usize, (x, y): Pixel, fill: ShapeStyle, rim: ShapeStyle) -> Drawn {
    let outline = SHAPES[method % SHAPES.len()];
    if outline.is_empty() {
        root.draw(&Circle::new((x, y), 6, fill))?;
        return Ok(root.draw(&Circle::new((x, y), 6, rim))?);
    }
    let mut corners: Vec<Pixel> = outline.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
    root.draw(&Polygon::new(corners.clone(), fill))?;
    corners.extend_from_within(..2); // twice round the first side: the last corner is as sharp as the others
    Ok(root.draw(&PathElement::new(corners, rim))?)
}

/// Of a method where lines are methods, of a scene where points are scenes.
fn color(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

fn dash(method: usize) -> &'static [f64] {
    DASHES[method % DASHES.len()]
}

/// The box that points are placed in.
#[derive(Clone, Copy)]
struct Frame<'a> {
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
    x: &'a Axis,
    y: &'a Axis,
}

impl Frame<'_> {
    fn place(&self, (x, y): Point) -> Pixel {
        (self.x.place(x, self.left, self.right), self.y.place(y, self.bottom, self.top))
    }

    /// Axes, grid and labels; those of x only with a label for it, as panels share them.
    fn draw(&self, root: &Area<'_>, y_label: &str, x_label: Option<&str>) -> Drawn {
        let style = |size: i32, h, v| (FONT, size).into_font().color(&INK).pos(Pos::new(h, v));
        let mut taken = i32::MIN;
        for &tick in &self.x.ticks {
            let x = self.x.place(tick, self.left, self.right);
            root.draw(&PathElement::new(vec![(x, self.top), (x, self.bottom)], GRID))?;
            root.draw(&PathElement::new(vec![(x, self.bottom), (x, self.bottom + 4)], INK))?;
            let number = label(tick);
            let half = 4 * number.len() as i32;
            if x_label.is_some() && x - half > taken {
                root.draw(&Text::new(number, (x, self.bottom + 8), style(12, HPos::Center, VPos::Top)))?;
                taken = x + half + 4;
            }
        }
        let mut taken = i32::MAX;
        for &tick in &self.y.ticks {
            let y = self.y.place(tick, self.bottom, self.top);
            let tone = if tick == 0.0 { INK } else { GRID };
            root.draw(&PathElement::new(vec![(self.left, y), (self.right, y)], tone))?;
            root.draw(&PathElement::new(vec![(self.left - 4, y), (self.left, y)], INK))?;
            if y + 7 < taken {
                root.draw(&Text::new(label(tick), (self.left - 8, y), style(12, HPos::Right, VPos::Center)))?;
                taken = y - 7;
            }
        }
        for end in [(self.left, self.top), (self.right, self.bottom)] {
            root.draw(&PathElement::new(vec![(self.left, self.bottom), end], INK))?;
        }
        if self.y.zero {
            // The axis is broken between zero and the lowest decade.
            let (x, y) = (self.left, self.bottom - Axis::ZERO_ROW);
            root.draw(&Rectangle::new([(x - 2, y - 3), (x + 2, y + 3)], WHITE.filled()))?;
            for y in [y - 3, y + 3] {
                root.draw(&PathElement::new(vec![(x - 6, y + 3), (x + 6, y - 3)], INK))?;
            }
        }
        let turned = (FONT, 13).into_font().transform(FontTransform::Rotate270).color(&INK);
        let turned = turned.pos(Pos::new(HPos::Center, VPos::Center));
        root.draw(&Text::new(y_label.to_owned(), (16, self.top.midpoint(self.bottom)), turned))?;
        if let Some(x_label) = x_label {
            let at = (self.left.midpoint(self.right), self.bottom + 28);
            root.draw(&Text::new(x_label.to_owned(), at, style(13, HPos::Center, VPos::Top)))?;
        }
        Ok(())
    }
}

/// A range of values. On a logarithmic one, zero and what is below has a row of its own under the lowest decade.
struct Axis {
    is_log: bool,
    /// Decimal logarithms where it is logarithmic.
    low: f64,
    high: f64,
    zero: bool,
    ticks: Vec<f64>,
}

impl Axis {
    /// Pixels of the row of zero, and of the break above it.
    const ZERO_ROW: i32 = 52;

    fn of(rule: Rule, values: &[f64]) -> Self {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        match rule {
            Rule::Decades => Self::log(values),
            Rule::Amount if least > 0.0 && most / least > 15.0 => Self::log(values),
            Rule::Amount | Rule::Even => Self::even(least.min(0.0), most.max(0.0), 7.0),
        }
    }

    /// Round steps, about as many as said, that both ends lie on.
    fn even(low: f64, high: f64, steps: f64) -> Self {
        let rough = if high > low { (high - low) / steps } else { 1.0 };
        let decade = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0].map(|digit| digit * decade).into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * decade);
        let (first, last) =
            ((low / step).floor() as i64, ((high / step).ceil() as i64).max((low / step).floor() as i64 + 1));
        let ticks = (first..=last).map(|index| index as f64 * step).collect();
        Self { is_log: false, low: first as f64 * step, high: last as f64 * step, zero: false, ticks }
    }

    /// A tick at each value, and some room at the ends.
    fn through(values: impl Iterator<Item = f64>) -> Self {
        let mut ticks: Vec<f64> = values.collect();
        ticks.sort_by(f64::total_cmp);
        ticks.dedup();
        let (low, high) = (ticks.first().copied().unwrap_or(0.0), ticks.last().copied().unwrap_or(0.0));
        let room = if high > low { 0.04 * (high - low) } else { 1.0 };
        Self { is_log: false, low: low - room, high: high + room, zero: false, ticks }
    }

    /// From a round number to a round number: 1, 2 or 5 of a decade where there are few decades.
    fn log(values: &[f64]) -> Self {
        let logs = || values.iter().filter(|value| **value > 0.0).map(|value| value.log10());
        let zero = values.iter().any(|value| *value <= 0.0);
        let (least, most) = (logs().fold(f64::INFINITY, f64::min), logs().fold(f64::NEG_INFINITY, f64::max));
        let (least, most) = if least > most { (0.0, 1.0) } else { (least, most) };
        let digits: &[f64] = if most - least > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let decades = least.floor() as i32..=most.ceil() as i32 + 1;
        let round: Vec<f64> =
            decades.flat_map(|d| digits.iter().map(move |digit| f64::from(d) + digit.log10())).collect();
        let slack = 1e-9; // a round number is its own end
        let low = round.iter().copied().filter(|log| *log <= least + slack).fold(least.floor(), f64::max);
        let high = round.iter().copied().find(|log| *log >= most - slack && *log > low).unwrap_or(most.ceil());
        let inside = round.into_iter().filter(|log| (low - slack..=high + slack).contains(log));
        let ticks = zero.then_some(0.0).into_iter().chain(inside.map(|log| 10_f64.powf(log))).collect();
        Self { is_log: true, low, high, zero, ticks }
    }

    /// Where a value goes between two pixels, `from` the lowest one's.
    fn place(&self, value: f64, from: i32, to: i32) -> i32 {
        let (start, end) = (f64::from(from), f64::from(to));
        let row = self.zero_row() * (end - start).signum();
        if self.is_log && value <= 0.0 {
            return (start + 0.5 * row).round() as i32;
        }
        let value = if self.is_log { value.log10() } else { value };
        let share = (value - self.low) / (self.high - self.low);
        (start + row + share * (end - start - row)).round() as i32
    }

    /// Pixels of the row of zero, 0 without one.
    fn zero_row(&self) -> f64 {
        if self.zero { f64::from(Self::ZERO_ROW) } else { 0.0 }
    }
}

/// A number as short as it is round.
fn label(value: f64) -> String {
    if value != 0.0 && value.abs() < 0.99e-5 {
        return format!("{:.0e}", value);
    }
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

// ---- the page ----

/// The whole page.
fn page(content: &Content, names: &Names, sections: &[Section]) -> String {
    let Content { records, pictures, sources, stability } = content;
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<title>{TITLE}</title>\n<style>{STYLE}</style>\n</head>\n\
         <body>\n\
         <h1>{TITLE}</h1>\n"
    );
    html += &preamble(records, names);
    html += &contents(sections);
    for section in sections {
        let _ = writeln!(html, "<h2 id=\"{}\">{}</h2>", section.slug, escape(section.title));
        section.groups.iter().for_each(|group| html += &group_html(group));
    }
    html += &sources::html(sources, records, names);
    html += &stability::html(stability.as_ref());
    html += &gallery(pictures, names);
    html += &table(records);
    let _ = write!(html, "<script>{SCRIPT}</script>\n</body>\n</html>\n");
    html
}

const TITLE: &str = "Stereo ray tracing: the thesis's benchmarks measured again";

/// Where and when, and what to bear in mind.
fn preamble(records: &[Record], names: &Names) -> String {
    let list = |part: fn(&Record) -> &str| {
        let values = distinct(records.iter().map(part));
        if values.is_empty() { "none".into() } else { escape(&values.join(", ")) }
    };
    let dates = match days(&records.iter().collect::<Vec<_>>()) {
        dates if dates.is_empty() => "none".into(),
        dates => escape(&dates),
    };
    let measured = names.scenes.iter().filter_map(|scene| {
        let record = records.iter().find(|record| record.scene == *scene)?;
        let parts = [(record.triangles, "triangle"), (record.spheres, "sphere")];
        let parts = parts.iter().filter(|(number, _)| *number > 0).map(|&(number, noun)| count(number, noun));
        let parts = parts.collect::<Vec<_>>().join(", ");
        Some(format!("{} ({parts})", escape(scenes::title(scene))))
    });
    let measured = measured.collect::<Vec<_>>().join("; ");
    let sizes = records.iter().filter(|record| record.suite == "dimensions");
    let e = distinct(sizes.map(|record| record.e_px.to_string())).join(" or ");
    let e = if e.is_empty() { "15".into() } else { e };
    format!(
        "<p class=\"source\">Adapter: {}. Driver: {}. Commit: {}. Measured: {dates}, {}.</p>\n\
         <p>Scenes: {}.</p>\n\
         <p class=\"note\">The meshes are not the thesis's own, which has a Sponza of 279,163 triangles, a Buddha of \
         1,087,716 and a Dragon of 1,132,830. Where the picture's size is varied e stays {e} pixels, so the interaxial \
         in the world shrinks as the picture widens. Times are medians over the rounds, of the passes alone.</p>\n{}",
        list(|record| &record.adapter),
        list(|record| &record.driver),
        list(|record| &record.commit),
        count(records.len(), "record"),
        if measured.is_empty() { "none" } else { &measured },
        whose_methods(records),
    )
}

/// Which of the measured methods are the thesis's and which are not.
fn whose_methods(records: &[Record]) -> String {
    let measured = distinct(records.iter().map(|record| record.method.as_str()));
    let named = |wanted: &dyn Fn(&&str) -> bool| {
        let names = measured.iter().filter(|method| wanted(method));
        names.map(|method| format!("<code>{}</code>", escape(method))).collect::<Vec<_>>().join(", ")
    };
    let parts = [
        ("The thesis's, with its buffer in several depths", named(&|m| !OWN.contains(m) && !FUTURE_WORK.contains(m))),
        ("Named by the thesis as future work", named(&|m| FUTURE_WORK.contains(m))),
        ("Not the thesis's but this project's own", named(&|m| OWN.contains(m))),
    ];
    let parts = parts.iter().filter(|(_, names)| !names.is_empty());
    let text = parts.map(|(whose, names)| format!("{whose}: {names}.")).collect::<Vec<_>>().join(" ");
    if text.is_empty() { text } else { format!("<p>Methods. {text}</p>\n") }
}

fn contents(sections: &[Section]) -> String {
    let mut html = "<nav>\n<h2>Contents</h2>\n<ul>\n".to_owned();
    for section in sections {
        let _ = write!(html, "<li><a href=\"#{}\">{}</a>\n<ul>", section.slug, escape(section.title));
        for group in &section.groups {
            let note = if group.figures.is_empty() { " (left out)" } else { "" };
            let _ = write!(html, "<li><a href=\"#plot-{}\">{}</a>{note}</li>", group.slug, escape(group.title));
        }
        html += "</ul></li>\n";
    }
    let last = [
        (sources::SLUG, sources::TITLE),
        (stability::SLUG, stability::TITLE),
        ("pictures", "Pictures"),
        ("records", "Records"),
    ];
    for (slug, title) in last {
        let _ = writeln!(html, "<li><a href=\"#{slug}\">{title}</a></li>");
    }
    html += "</ul>\n</nav>\n";
    html
}

fn group_html(group: &Group) -> String {
    let mut title = group.title.to_owned();
    title[..1].make_ascii_uppercase();
    let mut html = format!("<h3 id=\"plot-{}\">{}</h3>\n", group.slug, escape(&title));
    if !group.figures.is_empty() {
        let _ = writeln!(html, "<p>{}</p>\n<div class=\"plots {}\">", escape(&group.sentence), group.slug);
        for figure in &group.figures {
            let Figure { name, svg } = figure;
            let _ = writeln!(
                html,
                "<figure id=\"{name}\">\n{svg}<figcaption><code>{name}.svg</code></figcaption>\n</figure>"
            );
        }
        html += "</div>\n";
    }
    if let Some(note) = &group.note {
        let _ = writeln!(html, "<p class=\"none\">{}</p>", escape(note));
    }
    html
}

/// The pictures by scene and method, each in the order given.
fn gallery(pictures: &[Picture], names: &Names) -> String {
    let mut html = "<h2 id=\"pictures\">Pictures</h2>\n".to_owned();
    if pictures.is_empty() {
        html += "<p class=\"none\">Left out: there are no pictures.</p>\n";
        return html;
    }
    html += "<p>Click on a picture to see it as large as the page allows.</p>\n";
    for scene in &names.scenes {
        let of_scene = pictures.iter().filter(|picture| picture.scene == *scene);
        if of_scene.clone().next().is_none() {
            continue;
        }
        let _ = writeln!(html, "<h3>{}</h3>", escape(scenes::title(scene)));
        for method in &names.methods {
            let mut of_method = of_scene.clone().filter(|picture| picture.method == *method).peekable();
            if of_method.peek().is_none() {
                continue;
            }
            let _ = writeln!(html, "<h4>{}</h4>\n<div class=\"pictures\">", escape(method));
            for picture in of_method {
                html += &figure(picture);
            }
            html += "</div>\n";
        }
    }
    html
}

/// A picture that a click enlarges.
fn figure(picture: &Picture) -> String {
    let alt = format!("{}, {}: {}", scenes::title(&picture.scene), picture.method, picture.kind);
    format!(
        "<figure><label><input type=\"checkbox\" aria-label=\"enlarge\"><img loading=\"lazy\" alt=\"{}\" \
         src=\"data:image/png;base64,{}\"></label><figcaption><b>{}</b> {}</figcaption></figure>\n",
        escape(&alt),
        base64(&picture.png),
        escape(&picture.kind),
        escape(&picture.caption)
    )
}

/// A table's cell: what it shows, and the number it is sorted by where that is another.
struct Cell {
    text: String,
    key: Option<f64>,
}

impl Cell {
    fn text(text: &str) -> Self {
        Self { text: escape(text), key: None }
    }

    /// Empty for what is no number.
    fn number(value: f64, decimals: usize) -> Self {
        Self { text: if value.is_finite() { format!("{value:.decimals$}") } else { String::new() }, key: None }
    }
}

/// Heading, whether it is sorted as a number, and a record's cell.
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

fn table(records: &[Record]) -> String {
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

const STYLE: &str = "
body { font: 16px/1.5 sans-serif; color: #222; background: #fff; max-width: 1400px; margin: 0 auto; padding: 16px; }
h1 { font-size: 1.6em; line-height: 1.25; }
h2 { font-size: 1.3em; border-bottom: 1px solid #ccc; margin-top: 2em; }
h1, h2, h3, h4 { break-after: avoid; }
p, li { max-width: 80em; overflow-wrap: anywhere; }
a { color: #0057a3; }
.source { color: #444; font-size: 0.9em; }
.note { border-left: 4px solid #e69f00; padding-left: 12px; }
.none { color: #666; font-style: italic; }
nav > ul { columns: 22em; padding-left: 1.2em; }
nav > ul > li { break-inside: avoid; }
.plots { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 500px), 1fr)); gap: 20px; }
figure { margin: 0; min-width: 0; break-inside: avoid; }
.accuracy-time, .accuracy-counters { grid-template-columns: 1fr; }
.plots figure { overflow-x: auto; }
.plots svg { display: block; width: 100%; min-width: 440px; max-width: 820px; height: auto; }
figcaption { font-size: 0.85em; color: #444; overflow-wrap: anywhere; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 165px), 1fr)); gap: 12px; }
.sources { grid-template-columns: repeat(auto-fill, minmax(min(100%, 300px), 1fr)); }
.legend { list-style: none; padding: 0; }
.swatch { display: inline-block; width: 1em; height: 1em; margin-right: 0.5em; vertical-align: -0.15em; }
.green { background: #008000; }
.red { background: #e00000; }
.yellow { background: #f0c800; }
.black { background: #000; }
.pictures input { position: absolute; opacity: 0; }
.pictures img { display: block; width: 100%; height: auto; cursor: zoom-in; background: #eee; }
.pictures input:focus-visible + img { outline: 3px solid #0057a3; }
.pictures figure:has(input:checked) { grid-column: 1 / -1; }
.pictures input:checked + img { cursor: zoom-out; }
.table { overflow: auto; max-height: 85vh; border: 1px solid #ccc; }
table { border-collapse: collapse; font-size: 0.75em; font-variant-numeric: tabular-nums; }
th { position: sticky; top: 0; background: #eee; padding: 0; }
th span { display: block; padding: 4px 6px; cursor: pointer; }
th[aria-sort=ascending] span::after { content: ' \\2191'; }
th[aria-sort=descending] span::after { content: ' \\2193'; }
td { padding: 2px 6px; border-top: 1px solid #eee; white-space: nowrap; }
th, td { text-align: left; }
.plain th, .suite th { padding: 4px 6px; }
.plain table, .suite table { font-size: 0.8em; }
.suite thead { position: sticky; top: 0; z-index: 1; }
.suite thead th, .suite td.error { font-weight: normal; }
.suite tbody th { left: 0; font-weight: normal; min-width: 14em; border-top: 1px solid #ddd; }
.suite .first { border-left: 1px solid #aaa; }
.suite .error { white-space: normal; }
.stability svg { display: block; width: 100%; max-width: 820px; height: auto; }
.n { text-align: right; }
@page table { size: landscape; }
@media print {
  body { max-width: none; padding: 0; font-size: 11px; }
  h3 + p { break-inside: avoid; break-after: avoid; }
  .plots, .pictures { gap: 8px; }
  .plots { grid-template-columns: 1fr; }
  .plots svg { min-width: 0; max-width: 520px; }
  .accuracy-time svg, .accuracy-counters svg { max-width: 700px; }
  .pictures { grid-template-columns: repeat(4, 1fr); }
  .table { page: table; overflow: visible; max-height: none; border: 0; }
  table { font-size: 8px; }
  .suite table { font-size: 6px; }
  .suite th { min-width: 0; padding: 1px; }
  th { position: static; }
  th span, td { padding: 1px 3px; }
}
";

const SCRIPT: &str = "
const table = document.getElementById('table');
const heads = table ? [...table.tHead.rows[0].cells] : [];
heads.forEach((head, column) => head.firstElementChild.onclick = () => {
  const sign = head.getAttribute('aria-sort') === 'ascending' ? -1 : 1;
  heads.forEach(other => other.removeAttribute('aria-sort'));
  head.setAttribute('aria-sort', sign > 0 ? 'ascending' : 'descending');
  const key = row => row.cells[column].dataset.key ?? row.cells[column].textContent;
  const byNumber = head.classList.contains('n');
  const body = table.tBodies[0];
  const order = (a, b) => {
    const [x, y] = [key(a), key(b)];
    if (x === '' || y === '') return (x === '') - (y === ''); // what has no figure stays last
    return sign * (byNumber ? x - y || 0 : x.localeCompare(y));
  };
  body.append(...[...body.rows].sort(order));
});
heads.forEach(head => head.firstElementChild.onkeydown = event => {
  if (event.key !== 'Enter' && event.key !== ' ') return;
  event.preventDefault();
  head.firstElementChild.click();
});
";

/// Text for HTML and SVG, in attributes too.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in printable(text).chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            other => escaped.push(other),
        }
    }
    escaped
}

/// Control characters, which neither HTML nor SVG may hold, become spaces.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// RFC 4648, with padding.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |index: usize| u32::from(chunk.get(index).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let index = (bits >> (18 - 6 * digit)) & 63;
            text.push(if digit <= chunk.len() { char::from(DIGITS[index as usize]) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    #[allow(unused_imports, reason = "the benchmark has no test harness: tests/report.rs runs these")]
    use super::*;

    #[test]
    fn escaped_text_is_no_markup() {
        assert_eq!(escape("<a b=\"c\">&'\u{1}"), "&lt;a b=&quot;c&quot;&gt;&amp;&#39; ");
    }

    #[test]
    fn base64_is_that_of_rfc_4648() {
        let vectors = ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"];
        for (length, expected) in vectors.into_iter().enumerate() {
            assert_eq!(base64(&b"foobar"[..length]), expected);
        }
        assert_eq!(base64(&[0xfb, 0xff, 0xfe]), "+//+");
    }

    #[test]
    fn frontier_is_what_no_other_point_beats() {
        let points = [(1.0, 0.0), (0.3, 2.0), (0.4, 3.0), (0.0, 9.0), (0.3, 1.0), (1.2, 0.0)];
        assert_eq!(frontier(&points), [3, 4, 0]);
        assert!(frontier(&[]).is_empty());
    }

    #[test]
    fn means_are_of_methods_that_every_scene_has() {
        let dot = |scene, method, cost| Dot { scene, method, cost, errors: [2.0 * cost; 3] };
        let dots = [dot(0, 2, 1.0), dot(0, 3, 1.0), dot(1, 2, 2.0)];
        assert_eq!(means(&dots, 1), [(2, (1.5, 3.0))]);
    }

    #[test]
    fn axes_end_at_round_numbers() {
        let even = Axis::even(-12.0, 61.0, 7.0);
        assert_eq!((even.low, even.high, even.ticks.len()), (-20.0, 80.0, 6));
        assert_eq!(Axis::even(0.0, 0.0, 7.0).ticks, [0.0, 1.0]);

        let log = Axis::log(&[0.0, 0.02, 700.0]);
        let ticks: Vec<String> = log.ticks.iter().map(|tick| label(*tick)).collect();
        assert_eq!(ticks, ["0", "0.01", "0.1", "1", "10", "100", "1000"]);
        assert!(log.place(0.0, 400, 0) > log.place(0.01, 400, 0));
        assert_eq!((log.place(0.01, 400, 0), log.place(1000.0, 400, 0)), (400 - Axis::ZERO_ROW, 0));

        let short = Axis::log(&[7.0, 90.0]);
        let ticks: Vec<String> = short.ticks.iter().map(|tick| label(*tick)).collect();
        assert_eq!(ticks, ["5", "10", "20", "50", "100"]);
        for none in [&[] as &[f64], &[0.0], &[3.0]] {
            let axis = Axis::log(none);
            assert!(axis.low < axis.high && axis.ticks.iter().all(|tick| tick.is_finite()), "{none:?}");
        }
    }

    #[test]
    fn dashes_go_on_round_corners() {
        let pieces = dashed(&[(0, 0), (3, 0), (3, 5)], &[4.0, 2.0]);
        assert_eq!(pieces, [vec![(0, 0), (3, 0), (3, 1)], vec![(3, 3), (3, 5)]]);
        assert_eq!(dashed(&[(0, 0), (9, 9)], &[]), [[(0, 0), (9, 9)]]);
    }

    #[test]
    fn files_have_free_names_of_plain_letters() {
        assert_eq!(slug("Sponza 4x/<é>"), "sponza-4x----");
        let taken = ["a", "a-2"].map(|name| Figure { name: name.into(), svg: String::new() });
        assert_eq!((free_name("b", &taken), free_name("a", &taken)), ("b".into(), "a-3".into()));
    }

    #[test]
    fn page_without_records_says_what_it_leaves_out() -> Result<(), Box<dyn Error>> {
        let folder = crate::folder::Folder::new("report");
        let paths = write(&Content::default(), folder.path())?;
        let page = std::fs::read_to_string(&paths[0])?;
        assert_eq!((paths.len(), folder.names().len()), (1, 1));
        assert_eq!(page.matches("class=\"none\"").count(), QUESTIONS.len() + COSTS.len() + 5);
        Ok(())
    }
}
