//! Defines the questions that the report answers by plots, one per scene, and the quantities along the plots' axes.

use super::{axis::Rule, text::count};
use crate::record::Record;

/// Quantity that a benchmark of the thesis varies. It is drawn along a plot's x axis.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Swept {
    Width,
    Interaxial,
    Lights,
}

impl Swept {
    pub(super) fn of(self, record: &Record) -> f64 {
        match self {
            Self::Width => f64::from(record.width),
            Self::Interaxial => f64::from(record.e_px),
            Self::Lights => record.lights as f64,
        }
    }

    pub(super) fn label(self) -> &'static str {
        match self {
            Self::Width => "picture width, pixels",
            Self::Interaxial => "interaxial e, pixels",
            Self::Lights => "lights",
        }
    }

    /// Describes the fixed settings.
    pub(super) fn fixed(self, record: &Record) -> String {
        let size = format!("{}x{}", record.width, record.height);
        let (e, lights) = (format!("e = {} px", record.e_px), count(record.lights, "light"));
        match self {
            Self::Width => format!("{e}, {lights}"),
            Self::Interaxial => format!("{size}, {lights}"),
            Self::Lights => format!("{size}, {e}"),
        }
    }
}

/// A figure of a record, in the plot's unit.
pub(super) type Value = fn(&Record) -> Option<f64>;

/// Minimum and maximum of a figure over the rounds.
pub(super) type Range = fn(&Record) -> Option<[f64; 2]>;

/// A question that the report answers by one plot per scene.
pub(super) struct Question {
    pub(super) suite: &'static str,
    /// Prefix of its plots' file names.
    pub(super) slug: &'static str,
    pub(super) title: &'static str,
    /// Description of the plot's axes.
    pub(super) sentence: &'static str,
    pub(super) swept: Swept,
    pub(super) y_label: &'static str,
    pub(super) rule: Rule,
    pub(super) value: Value,
    /// Minimum and maximum of the value over the rounds, for times.
    pub(super) range: Option<Range>,
    /// The value from counted box and primitive tests in place of time.
    pub(super) counted: Option<Value>,
}

pub(super) const SUITES: [(&str, &str); 5] = [
    ("dimensions", "Picture size"),
    ("interaxial", "Interaxial"),
    ("lights", "Lights"),
    ("mse-dimensions", "Error against picture size"),
    ("mse-interaxial", "Error against interaxial"),
];

pub(super) const QUESTIONS: [Question; 9] = [
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
        range: Some(speed_up_range),
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
        range: Some(|record| Some([record.pair_ms_max, record.pair_ms_min].map(|ms| 1e3 / ms))),
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
        range: Some(|record| Some([record.pair_ms_min, record.pair_ms_max])),
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
        range: Some(speed_up_range),
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
        range: None,
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
        range: None,
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
        range: Some(speed_up_range),
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
        range: None,
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
        range: None,
        counted: None,
    },
];

/// Returns the speed-up in percent. Returns `None` for naive, whose speed-up is 0 by definition.
fn speed_up(record: &Record) -> Option<f64> {
    (record.method != "naive").then_some(100.0 * record.speed_up)
}

/// Returns the range of the speed-up relative to naive's median, since naive's own spread moves all methods together.
fn speed_up_range(record: &Record) -> Option<[f64; 2]> {
    let naive = (1.0 + record.speed_up) * record.pair_ms;
    speed_up(record).map(|_| [record.pair_ms_max, record.pair_ms_min].map(|ms| 100.0 * (naive / ms - 1.0)))
}

/// Returns the error. Returns `None` for naive, whose error is 0 by definition.
fn error(record: &Record) -> Option<f64> {
    (record.method != "naive").then_some(record.mse)
}
