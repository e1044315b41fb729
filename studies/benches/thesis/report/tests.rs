//! Tests of the report's parts, run by tests/report.rs.
#![allow(unused_imports, reason = "the benchmark has no test harness: tests/report.rs runs these")]

use std::error::Error;

use super::{
    Content,
    accuracy::COSTS,
    axis::{Axis, label},
    drawing::dashed,
    questions::QUESTIONS,
    scatter::{Dot, means},
    sections::{Figure, free_name, slug},
    text::{base64, escape},
    write,
};
use crate::common::chart::frontier;

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
    let dot = |scene, method, cost| Dot { scene, method, cost, costs: None, errors: [2.0 * cost; 3] };
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
