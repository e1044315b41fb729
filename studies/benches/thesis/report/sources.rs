//! Shows the sources of right pixels: pictures and shares of one render by `bracket`, and the records of this project's
//! own methods.

use std::fmt::Write as _;

use super::{
    Picture,
    accuracy::nearest_width,
    gallery::figure,
    names::{Names, OWN},
    sections::last_of_each,
    text::{count, escape},
};
use crate::{common::scenes, record::Record};

pub(super) const SLUG: &str = "sources";
pub(super) const TITLE: &str = "Where right pixels come from";
/// The method that is shown.
const METHOD: &str = "bracket";

/// One render by [`METHOD`] of a built-in scene. Shares are in percent of the right view's pixels.
pub(crate) struct Sources {
    pub(crate) scene: String,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) e_px: f32,
    pub(crate) lights: usize,
    /// Percentages of pixels in three groups. In the first, the hit is not deeper than the left samples that land in
    /// its tile. In the second, the hit is deeper. In the third, the tile has no bound.
    pub(crate) found: f64,
    pub(crate) deeper: f64,
    pub(crate) unbound: f64,
    /// Pixels without a shadow ray.
    pub(crate) shadows_taken: f64,
    /// Pixels of the right view that differ from naive's.
    pub(crate) differing: f64,
    /// Right view, re-trace map, shadow map and difference.
    pub(crate) pictures: Vec<Picture>,
}

pub(super) fn html(sources: &[Sources], records: &[Record], names: &Names) -> String {
    let mut html = format!("<h2 id=\"{SLUG}\">{TITLE}</h2>\n");
    if sources.is_empty() {
        html += "<p class=\"none\">Left out: there are no pictures of it.</p>\n";
    } else {
        let _ = writeln!(
            html,
            "<p>One render by <code>{METHOD}</code>, which is not of the thesis. It copies no colour: the left samples \
             that land in a tile of right pixels say how deep the tile has to be searched, one query of the BVH lists \
             what may be seen there, and each right pixel's own ray is met with that list. A hit no deeper than was \
             searched is the nearest one; what is left is traced. Shadow bits are reused from the left view: which \
             lights the point sees.</p>"
        );
    }
    sources.iter().for_each(|one| html += &of_scene(one));
    html + &table(&last_of_each(records), names)
}

fn of_scene(sources: &Sources) -> String {
    let Sources { width, height, e_px, .. } = sources;
    let mut html = format!(
        "<h3 id=\"{SLUG}-{}\">Built-in scene {}: {width}x{height}, e = {e_px} px, {}</h3>\n\
         <div class=\"pictures sources\">\n",
        escape(&sources.scene),
        escape(&sources.scene),
        count(sources.lights, "light"),
    );
    sources.pictures.iter().for_each(|picture| html += &figure(picture));
    html += "</div>\n<ul class=\"legend\">\n";
    let mut entry = |color: &str, name: &str, share: f64, meaning: &str| {
        let _ = writeln!(
            html,
            "<li><span class=\"swatch {color}\"></span>{name}, {color}: {meaning}: <b>{}%</b></li>",
            percent(share)
        );
    };
    entry("green", "re-trace map", sources.found, "found no deeper than the left samples that land in its tile");
    entry("red", "re-trace map", sources.deeper, "the hit lies deeper than they do; traced");
    entry(
        "yellow",
        "re-trace map",
        sources.unbound,
        "no bound, as no left sample landed or more may be seen than its list holds; traced",
    );
    let taken = "shadow bits reused from the left view, or no light is in front of the surface, or it is sky";
    entry("green", "shadow map", sources.shadows_taken, taken);
    entry("red", "shadow map", 100.0 - sources.shadows_taken, "shadow rays, at least one");
    entry("black", "difference", 100.0 - sources.differing, "the same as naive's in 8-bit colour");
    html + "</ul>\n"
}

/// Formats the records of this project's own methods, at the sizes of the accuracy plots.
fn table(records: &[&Record], names: &Names) -> String {
    let measured = records.iter().copied().filter(|record| record.suite == "dimensions");
    let taken: Vec<&Record> = names.scenes.iter().flat_map(|scene| nearest_width(measured.clone(), scene)).collect();
    let of_method = |method| taken.iter().copied().filter(move |record| record.method == method);
    let rows: String = OWN.into_iter().flat_map(of_method).map(|record| row(record, records)).collect();
    if rows.is_empty() {
        return format!("<p class=\"none\">Left out: there is no record of {}.</p>\n", OWN.join(", "));
    }
    let heads = [
        "cost of the second eye by time",
        "by counters",
        "re-traced %",
        "shadow rays of both eyes, % of naive's",
        "differing %",
        "of surfaces %",
        "wrong surface %",
        "of surfaces %",
        "MSE",
    ];
    let heads: String = heads.iter().map(|head| format!("<th scope=\"col\" class=\"n\">{head}</th>")).collect();
    format!(
        "<p>It and its kin as measured, by the records: the first eye costs 1, and the right view is set against \
         naive's, by all pixels and by those in which either view shows a surface.</p>\n\
         <div class=\"table plain\" tabindex=\"0\"><table>\n<thead><tr>\
         <th scope=\"col\">method</th><th scope=\"col\">scene</th><th scope=\"col\" class=\"n\">size</th>\
         {heads}</tr></thead>\n<tbody>\n{rows}</tbody>\n\
         </table></div>\n"
    )
}

fn row(record: &Record, records: &[&Record]) -> String {
    let key = |r: &Record| (r.suite.clone(), r.scene.clone(), r.width, r.e_px.to_bits(), r.lights, r.adapter.clone());
    let naive = records.iter().find(|other| other.method == "naive" && key(other) == key(record));
    let shadows = naive.filter(|naive| naive.rays_shadow > 0);
    let shadows = shadows.map(|naive| 100.0 * record.rays_shadow as f64 / naive.rays_shadow as f64);
    let cells = [
        format!("{:.3}", record.second_eye),
        format!("{:.3}", record.second_eye_counters),
        percent(100.0 * record.retraced),
        shadows.map(percent).unwrap_or_default(),
        percent(100.0 - record.identical),
        percent(100.0 - record.identical_of_surfaces),
        percent(record.wrong_surface),
        percent(record.wrong_of_surfaces),
        format!("{:.4}", record.mse),
    ];
    let cells: String = cells.iter().map(|cell| format!("<td class=\"n\">{cell}</td>")).collect();
    let (method, scene) = (escape(&record.method), escape(scenes::title(&record.scene)));
    let size = format!("{}x{}", record.width, record.height);
    format!("<tr><td>{method}</td><td>{scene}</td><td class=\"n\">{size}</td>{cells}</tr>\n")
}

/// Formats a percentage with two decimals, or with as many as show that it is neither 0 nor 100.
pub(super) fn percent(value: f64) -> String {
    let rest = value.abs().min((100.0 - value).abs());
    let decimals = (2..6).find(|&d| rest == 0.0 || rest >= 0.995 * 10_f64.powi(-d)).unwrap_or(6) as usize;
    format!("{value:.decimals$}")
}
