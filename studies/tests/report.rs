//! Tests the thesis benchmark's report, since the benchmark has no test harness of its own.
#![allow(dead_code, unreachable_pub, reason = "it is tested by parts")]

#[path = "../../benches/common/mod.rs"]
mod common;
#[path = "../../tests/it/common/folder.rs"]
mod folder;
#[path = "../benches/thesis/record.rs"]
mod record;
#[path = "../benches/thesis/report/mod.rs"]
mod report;

use std::{error::Error, fs};

use stereotrace::{Method, glam::DVec3};

use crate::{
    common::{looks, provenance::SMOKE, scenes},
    folder::Folder,
    record::Record,
    report::{Content, Picture, Sources, Stability},
};

fn page(content: &Content, folder: &Folder) -> Result<String, Box<dyn Error>> {
    let paths = report::write(content, folder.path())?;
    Ok(fs::read_to_string(paths.last().ok_or("no page")?)?)
}

/// Returns the part of the page between this heading's anchor and the next one's.
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
        // The columns are: second eye from times and from counted tests, re-traced, shadow rays, differing and wrong
        // surface (each of all pixels and of surfaces), MSE.
        "<tr><td>bracket</td><td>fixed spheres</td><td class=\"n\">600x600</td><td class=\"n\">0.454</td><td \
        class=\"n\">0.131</td><td \
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

    folder.write("stability.svg", "<svg role=\"img\" width=\"100%\">\n<g/>\n</svg>\n");
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
        "<svg role=\"img\" width=\"100%\">\n<g/>",
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

#[test]
fn every_method_has_a_look_of_its_own() {
    let places: Vec<usize> = looks::METHODS.iter().map(|name| looks::of_method(name)).collect();
    assert_eq!(places, Vec::from_iter(0..looks::METHODS.len()));
    for method in Method::ALL {
        assert!(looks::METHODS.contains(&method.to_string().as_str()), "{method}: give it a look");
    }
    assert_eq!(looks::of_method("buffer-7"), looks::of_method("buffer-7"));
    assert!(looks::of_method("buffer-7") >= looks::METHODS.len());
}

#[test]
fn a_quick_look_says_that_its_figures_mean_nothing() -> Result<(), Box<dyn Error>> {
    let folder = Folder::new("smoke");
    for smoke in [true, false] {
        let page = page(&Content { records: vec![record("atomic", 1, 99.0)], smoke, ..Content::default() }, &folder)?;
        let marks = page.matches(&SMOKE.to_uppercase()).count();
        // The page's head and each of its charts are marked.
        assert_eq!(marks, if smoke { 1 + page.matches("<svg ").count() } else { 0 });
        assert!(page.matches("<svg ").count() > 3 && page.matches("width=\"100%\"").count() > 3);
    }
    Ok(())
}

/// Tests that charts of times have error bars and charts of counts have none.
#[test]
fn times_have_bars_and_counts_have_none() -> Result<(), Box<dyn Error>> {
    let folder = Folder::new("bars");
    let records = vec![Record { pair_ms_min: 12.0, pair_ms_max: 19.0, ..record("atomic", 1, 99.0) }];
    page(&Content { records, ..Content::default() }, &folder)?;
    let svg = |name: &str| fs::read_to_string(folder.file(&format!("{name}.svg")));
    assert!(svg("accuracy-time")?.contains("least to most of the"));
    assert!(!svg("accuracy-counters")?.contains("least to most of the"));
    Ok(())
}

/// A triangle, a camera at (0, 0, 5) and a light, as another program would write them.
const GLTF: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
"extensionsUsed": ["KHR_lights_punctual"],
"extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 10}]}},
"nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 5]},
{"translation": [1, 2, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
"cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"buffers": [{"byteLength": 36, "uri":
"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
"bufferViews": [{"buffer": 0, "byteLength": 36}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
"min": [0, 0, 0], "max": [1, 1, 0]}]}"#;

#[test]
fn benchmarks_take_any_scene_file() -> Result<(), Box<dyn Error>> {
    let folder = Folder::new("own");
    let load = |name: &str, content: &str, lights| {
        let path = folder.write(name, content);
        scenes::load(&path.display().to_string(), [60, 40], 4.0, lights)
    };
    let own = load("house.gltf", GLTF, None)?.ok_or("a path is a scene")?;
    assert_eq!((own.name.as_str(), own.scene.lights.len()), ("house", 1));
    assert_eq!(
        (own.scene.lights[0].position, own.camera.pose()?.eye),
        (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 0.0, 5.0))
    );
    let placed = load("house.gltf", GLTF, Some(3))?.ok_or("a path is a scene")?;
    assert!(placed.scene.lights.len() == 3);
    let plain = load("room.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", None)?.ok_or("a path is a scene")?;
    assert_eq!((plain.name.as_str(), plain.scene.lights.len()), ("room", 5));
    assert!(scenes::load("no-such-scene", [60, 40], 4.0, None)?.is_none());
    let missing = scenes::load("no/such.glb", [60, 40], 4.0, None).err().map(|error| error.to_string());
    assert!(missing.is_some_and(|error| error.contains("no/such.glb")));
    Ok(())
}
