//! Draws plots of accuracy against the second eye's cost, which is measured in time and in counted box and primitive
//! tests.

use std::{cmp::Reverse, error::Error};

use super::{
    axis::Axis,
    names::{Names, distinct},
    scatter::{Dot, Scatter},
    sections::{Figure, Group, free_name},
    text::days,
};
use crate::{
    common::{chart::Point, provenance::marked},
    record::Record,
};

/// Width in pixels of the pictures in the accuracy plots. The nearest measured width is used.
const ACCURACY_WIDTH: u32 = 600;
/// Largest cost of the second eye on the axis, relative to the first eye. The axis ends slightly beyond it.
const DEAREST: f64 = 2.0;

/// A measure of the second eye's cost relative to the first.
pub(super) struct Cost {
    slug: &'static str,
    title: &'static str,
    of: fn(&Record) -> f64,
    /// Minimum and maximum over the rounds, for times.
    range: Option<fn(&Record) -> [f64; 2]>,
    x_label: &'static str,
    by: &'static str,
}

pub(super) const COSTS: [Cost; 2] = [
    Cost {
        slug: "accuracy-time",
        title: "accuracy against cost by time",
        of: |record| record.second_eye,
        range: Some(|record| [record.pair_ms_min, record.pair_ms_max].map(|pair| pair / record.left_ms - 1.0)),
        x_label: "cost of the second eye by time (first eye = 1)",
        by: "time",
    },
    Cost {
        slug: "accuracy-counters",
        title: "accuracy against cost by counters",
        of: |record| record.second_eye_counters,
        range: None,
        x_label: "cost of the second eye by counters (first eye = 1)",
        by: "counters",
    },
];

/// Draws one plot per adapter, of the records nearest to [`ACCURACY_WIDTH`].
pub(super) fn accuracy_group(
    records: &[&Record],
    names: &Names,
    cost: &Cost,
    smoke: bool,
) -> Result<Group, Box<dyn Error>> {
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
            costs: cost.range.map(|range| range(record)),
            errors: [100.0 - record.identical, record.wrong_surface, record.mse],
        });
        let dots: Vec<Dot> =
            dots.filter(|dot| dot.cost.is_finite() && dot.errors.iter().all(|e| e.is_finite())).collect();
        if dots.is_empty() {
            continue;
        }
        let setting = |record: &&Record| format!("{}x{}, e = {} px", record.width, record.height, record.e_px);
        let settings = distinct(taken.iter().map(setting)).join("; ");
        let source = marked(format!("{settings}; {adapter}, {}", days(&taken)), smoke);
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
         marker is a method's, the number in it its scene, and a bar the pair's least and most over the rounds; hollow \
             markers are means over the scenes of those methods \
         that no other beats in cost and accuracy, among the methods that were measured on every scene.",
        cost.by
    );
    Ok(Group { slug: cost.slug, title: cost.title, sentence, figures, note })
}

/// Returns a scene's records of the width nearest to [`ACCURACY_WIDTH`].
pub(super) fn nearest_width<'a>(records: impl Iterator<Item = &'a Record> + Clone, scene: &String) -> Vec<&'a Record> {
    let of_scene = records.filter(|record| record.scene == *scene);
    let width = of_scene.clone().map(|record| record.width);
    let width = width.min_by_key(|width| (width.abs_diff(ACCURACY_WIDTH), Reverse(*width)));
    of_scene.filter(move |record| Some(record.width) == width).collect()
}
