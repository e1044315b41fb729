//! Formats the page's pictures.

use std::fmt::Write as _;

use super::{
    Picture,
    names::Names,
    text::{base64, escape},
};
use crate::common::scenes;

/// Formats the pictures by scene and method, in the order of `names`.
pub(super) fn gallery(pictures: &[Picture], names: &Names) -> String {
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

/// Formats a picture that is enlarged by a click.
pub(super) fn figure(picture: &Picture) -> String {
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
