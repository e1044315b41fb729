//! What plots are drawn by: the looks of methods and scenes, text, strokes and markers.

use std::error::Error;

use plotters::{
    coord::Shift,
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use super::text::{escape, printable};
use crate::common::chart::{FONT, INK};

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
pub(super) const DOTS: &[f64] = &[2.0, 4.0];
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

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Pixel = (i32, i32);
pub(super) type Drawn = Result<(), Box<dyn Error>>;

/// An SVG with a white ground.
pub(super) fn drawing(
    size: (u32, u32),
    title: &str,
    draw: impl FnOnce(&Area<'_>) -> Drawn,
) -> Result<String, Box<dyn Error>> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        draw(&root)?;
        root.present()?;
    }
    Ok(svg.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{}\" ", escape(title)), 1))
}

pub(super) fn heading(root: &Area<'_>, title: &str, source: &str) -> Drawn {
    text(root, title, (14, 20), 16)?;
    text(root, source, (14, 41), 12)
}

/// Text from this point on, centred on its height.
pub(super) fn text(root: &Area<'_>, text: &str, at: Pixel, size: i32) -> Drawn {
    let style = (FONT, size).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
    Ok(root.draw(&Text::new(printable(text), at, style))?)
}

/// A line through the points, with strokes and gaps of these lengths in turn; solid without any.
pub(super) fn stroke(root: &Area<'_>, points: &[Pixel], lengths: &[f64], style: ShapeStyle) -> Drawn {
    for piece in dashed(points, lengths) {
        root.draw(&PathElement::new(piece, style))?;
    }
    Ok(())
}

pub(super) fn dashed(points: &[Pixel], lengths: &[f64]) -> Vec<Vec<Pixel>> {
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
pub(super) fn bracket(root: &Area<'_>, x: i32, (top, bottom): (i32, i32), method: usize) -> Drawn {
    let corners = [(x - 4, top), (x + 4, top), (x, top), (x, bottom), (x - 4, bottom), (x + 4, bottom)];
    stroke(root, &corners, &[], color(method).stroke_width(2))?;
    marker(root, method, (x, top.midpoint(bottom)), color(method).filled(), WHITE.into())
}

/// A method's marker, with a rim so that neighbours stand apart.
pub(super) fn marker(root: &Area<'_>, method: usize, (x, y): Pixel, fill: ShapeStyle, rim: ShapeStyle) -> Drawn {
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
pub(super) fn color(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

pub(super) fn dash(method: usize) -> &'static [f64] {
    DASHES[method % DASHES.len()]
}
