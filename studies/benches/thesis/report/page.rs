//! Formats the page: its preamble, its contents and its sections in order.

use std::fmt::Write as _;

use super::{
    Content,
    gallery::gallery,
    names::{FUTURE_WORK, Names, OWN, distinct},
    sections::{Figure, Group, Section},
    sources, stability,
    table::table,
    text::{count, days, escape},
};
use crate::{
    common::{provenance::SMOKE, scenes},
    record::Record,
};

const TITLE: &str = "Stereo ray tracing: the thesis's benchmarks measured again";
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Formats the whole page.
pub(super) fn page(content: &Content, names: &Names, sections: &[Section]) -> String {
    let Content { records, pictures, sources, stability, smoke } = content;
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<title>{TITLE}</title>\n<style>\n{STYLE}</style>\n</head>\n\
         <body>\n\
         <h1>{TITLE}</h1>\n"
    );
    if *smoke {
        let _ = writeln!(html, "<p class=\"smoke\">{}</p>", SMOKE.to_uppercase());
    }
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
    let _ = write!(html, "<script>\n{SCRIPT}</script>\n</body>\n</html>\n");
    html
}

/// Formats where and when the figures were measured, and notes on them.
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

/// Lists which measured methods are the thesis's and which are not.
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
