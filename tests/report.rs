//! The thesis benchmark's report, which is a program without a test harness of its own.
#![allow(dead_code, unreachable_pub, reason = "it is tested by parts")]

#[path = "../benches/common/mod.rs"]
mod common;
#[path = "common/folder.rs"]
mod folder;
#[path = "../benches/thesis/record.rs"]
mod record;
#[path = "../benches/thesis/report/mod.rs"]
mod report;

use std::{error::Error, fs};

use crate::{
    folder::Folder,
    record::Record,
    report::{Content, Picture, Sources, Stability},
};

fn page(content: &Content, folder: &Folder) -> Result<String, Box<dyn Error>> {
    let paths = report::write(content, folder.path())?;
    Ok(fs::read_to_string(paths.last().ok_or("no page")?)?)
}

/// Between this heading's anchor and the next one's.
fn section<'a>(page: &'a str, slug: &str) -> &'a str {
    let from = page.find(&format!("<h2 id=\"{slug}\">")).map_or("", |at| &page[at..]);
    let end = from.get(1..).and_then(|rest| rest.find("<h2 ")).map_or(from.len(), |at| at + 1);
    &from[..end]
}

fn record(method: &str, rays_shadow: u64, identical: f64) -> Record {
    Record {
        suite: "dimensions".into(),
        scene: "spheres".into(),
        triangles: 0,
        spheres: 1000,
        method: method.into(),
        width: 600,
        height: 600,
        e_px: 15.0,
        lights: 5,
        rounds: 1,
        left_ms: 10.0,
        pair_ms: 14.5,
        pair_ms_min: 14.5,
        pair_ms_max: 14.5,
        fps: 69.0,
        second_eye: 0.454,
        second_eye_counters: 0.131,
        speed_up: 0.4,
        speed_up_counters: 0.7,
        identical,
        differing: 100.0 - identical,
        wrong_surface: 0.0,
        identical_of_surfaces: 2.0 * identical - 100.0,
        wrong_of_surfaces: 0.25,
        mean_difference: 1.0,
        mse: 0.0175,
        psnr: Some(58.0),
        rays_primary: 10,
        rays_verification: 0,
        rays_shadow,
        nodes: 100,
        primitive_tests: 100,
        retraced: 0.0063,
        bad: 63,
        missed: 0,
        lost_candidates: 0,
        buffer_depth: 0,
        slot_ns: None,
        intermediate_bytes_per_pixel: 94.0,
        passes_ms: vec![],
        adapter: "an adapter".into(),
        driver: "a driver".into(),
        commit: "abc".into(),
        date: "2012-06-30T23:59:59Z".into(),
    }
}

fn sources() -> Sources {
    let picture = |kind: &str| Picture {
        scene: "hall".into(),
        method: "bracket".into(),
        kind: kind.into(),
        caption: "a caption".into(),
        png: b"foobar".into(),
    };
    Sources {
        scene: "hall".into(),
        width: 480,
        height: 300,
        e_px: 12.0,
        lights: 5,
        found: 98.25,
        deeper: 1.5,
        unbound: 0.25,
        shadows_taken: 91.5,
        differing: 0.000_694_4,
        pictures: ["right", "re-trace map", "shadow map", "difference x8"].map(picture).into(),
    }
}

#[test]
fn sources_are_shown_with_their_shares_and_records() -> Result<(), Box<dyn Error>> {
    let folder = Folder::new("report");
    let records = vec![record("naive", 1000, 100.0), record("atomic", 540, 73.0), record("bracket", 580, 99.9875)];
    let page = page(&Content { records, sources: vec![sources()], ..Content::default() }, &folder)?;
    assert!(page.contains("<a href=\"#sources\">Where right pixels come from</a>"));
    let section = section(&page, "sources");
    assert_eq!(section.matches("src=\"data:image/png;base64,Zm9vYmFy\"").count(), 4);
    for text in [
        "Built-in scene hall: 480x300, e = 12 px, 5 lights",
        "green: found no deeper than the left samples that land in its tile: <b>98.25%</b>",
        "red: the hit lies deeper than they do; traced: <b>1.50%</b>",
        "more may be seen than its list holds; traced: <b>0.25%</b>",
        "<b>91.50%</b>",
        "red: shadow rays, at least one: <b>8.50%</b>",
        "<b>99.9993%</b>", // one pixel is not rounded away
        // second eye by time and by counters, re-traced, shadow rays, differing and wrong surface, each of surfaces too, MSE
        "<tr><td>bracket</td><td>fixed spheres</td><td class=\"n\">600x600</td><td class=\"n\">0.454</td><td class=\"n\">0.131</td><td \
         class=\"n\">0.63</td><td class=\"n\">58.00</td><td class=\"n\">0.01</td><td class=\"n\">0.03</td><td \
         class=\"n\">0.00</td><td class=\"n\">0.25</td><td class=\"n\">0.0175</td></tr>",
    ] {
        assert!(section.contains(text), "{text}\n{section}");
    }
    assert!(!section.contains("<td>atomic</td>") && !section.contains("class=\"none\""), "{section}");
    Ok(())
}

#[test]
fn the_page_says_whose_the_methods_are() -> Result<(), Box<dyn Error>> {
    let folder = Folder::new("methods");
    let records = ["naive", "atomic", "atomic-edges", "bracket"].map(|method| record(method, 1, 99.0)).into();
    let page = page(&Content { records, ..Content::default() }, &folder)?;
    for text in [
        "in several depths: <code>naive</code>, <code>atomic</code>. ",
        "future work: <code>atomic-edges</code>. ",
        "own: <code>bracket</code>.</p>",
    ] {
        assert!(page.contains(text), "{text}");
    }
    Ok(())
}

#[test]
fn the_stability_suite_is_shown_as_its_benchmark_left_it() -> Result<(), Box<dyn Error>> {
    let folder = Folder::new("stability");
    assert!(Stability::read(folder.path())?.is_none());
    let row = |method: &str, figures: &str| {
        format!(
            "{{\"trial\": \"wires\", \"reason\": \"wires pass\", \"method\": \"{method}\", \"width\": 300, \"height\": \
             300, {figures}, \"adapter\": \"a <b>\", \"driver\": \"d\", \"commit\": \"abc\", \"date\": \
             \"2012-06-30T23:59:59Z\", \"psnr\": null}}"
        )
    };
    let found = row(
        "bracket",
        "\"second_eye_counters\": 0.0882, \"identical\": 96.92, \"wrong_surface\": 0.0011, \
         \"identical_of_surfaces\": 91.5, \"wrong_of_surfaces\": 0.25, \"error\": null",
    );
    let failed = row(
        "buffer",
        "\"second_eye_counters\": null, \"identical\": null, \"wrong_surface\": null, \"error\": \"too deep\"",
    );
    folder.write("results.json", format!("[{found},\n{failed}]"));
    let stability = Stability::read(folder.path())?;
    assert!(!section(&page(&Content { stability, ..Content::default() }, &folder)?, "stability").contains("<svg"));

    folder.write("stability.svg", "<svg width=\"8\" height=\"5\">\n<g/>\n</svg>\n");
    let content = Content { stability: Stability::read(folder.path())?, ..Content::default() };
    let page = page(&content, &folder)?;
    let section = section(&page, "stability");
    for text in [
        "1 scene made to be hard",
        "300x300; adapter: a &lt;b&gt;; commit: abc; 2012-06-30.",
        "<b>wires</b> wires pass</th>",
        "<td class=\"n first\">0.09</td><td class=\"n\">96.92</td><td class=\"n\">91.50</td><td \
         class=\"n\">0.001</td><td class=\"n\">0.25</td>",
        "<td class=\"first error\" colspan=\"5\">too deep</td>",
        "<svg role=\"img\" aria-label=\"Stability: accuracy against cost\" width=\"8\" height=\"5\">\n<g/>",
    ] {
        assert!(section.contains(text), "{text}\n{section}");
    }

    folder.write("results.json", "[{}]");
    let message = Stability::read(folder.path()).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(message.contains("results.json: missing field") && message.contains("cargo bench"), "{message}");
    Ok(())
}

#[test]
fn without_results_the_page_names_the_stability_command() -> Result<(), Box<dyn Error>> {
    let folder = Folder::new("without");
    let page = page(&Content::default(), &folder)?;
    assert!(section(&page, "stability").contains("<code>cargo bench --bench stability</code>"));
    assert!(section(&page, "sources").contains("Left out"));
    Ok(())
}
