//! Defines looks: a colour, a marker and a dash pattern by number. A method has the same look in every chart and on
//! every page.

use plotters::prelude::*;

use super::chart::{Area, Drawn, INK, Pixel, anchored};

/// Names of the methods. The index of a method is the number of its look.
pub const METHODS: [&str; 17] = [
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
    "bracket-rays",
    "auto",
    "buffer-2",
    "buffer-4",
    "buffer-8",
    "atomic-unchecked",
    "buffer-unchecked",
];
/// Okabe and Ito's palette for colour-blind readers, with brown in place of its yellow, and four further colours.
const COLORS: [RGBColor; 12] = [
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
    RGBColor(0, 110, 120),
    RGBColor(120, 120, 120),
];
/// Dash patterns: alternating lengths of strokes and gaps in pixels. An empty pattern is a solid line.
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
/// Corners of the markers, relative to their centres. An empty list stands for a circle.
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
/// Radius of the circle.
const RADIUS: i32 = 6;

/// Returns the number of a method's look. A name that is not in the list gets a number that depends only on its
/// letters, so its look is also the same everywhere.
pub fn of_method(name: &str) -> usize {
    let by_letters = || name.bytes().fold(0, |sum: usize, letter| (31 * sum + usize::from(letter)) % 101);
    METHODS.iter().position(|method| *method == name).unwrap_or_else(|| METHODS.len() + by_letters())
}

pub fn color(look: usize) -> RGBColor {
    COLORS[look % COLORS.len()]
}

/// Returns the colour of a scene, for charts whose markers do not stand for methods. Black and brown come last.
pub fn scene_color(place: usize) -> RGBColor {
    color(place + 2)
}

pub fn dash(look: usize) -> &'static [f64] {
    DASHES[look % DASHES.len()]
}

/// Draws a marker, with a rim that separates it from its neighbours.
pub fn marker(root: &Area<'_>, look: usize, at: Pixel, fill: ShapeStyle, rim: ShapeStyle) -> Drawn {
    scaled(root, look, at, 1.0, fill, rim)
}

/// Draws a method's marker. If there are several scenes, it is larger and contains the scene's number, from 1.
pub fn numbered(root: &Area<'_>, look: usize, scene: Option<usize>, (x, y): Pixel) -> Drawn {
    let tone = color(look);
    let Some(scene) = scene else { return marker(root, look, (x, y), tone.filled(), WHITE.into()) };
    scaled(root, look, (x, y), 1.5, tone.filled(), WHITE.into())?;
    let RGBColor(red, green, blue) = tone;
    let is_light = 3 * u32::from(red) + 6 * u32::from(green) + u32::from(blue) > 1300;
    let style = anchored(11, if is_light { &INK } else { &WHITE });
    Ok(root.draw(&Text::new(scene.to_string(), (x, y), style))?)
}

fn scaled(root: &Area<'_>, look: usize, (x, y): Pixel, by: f64, fill: ShapeStyle, rim: ShapeStyle) -> Drawn {
    let larger = |length: i32| (f64::from(length) * by).round() as i32;
    let outline = SHAPES[look % SHAPES.len()];
    if outline.is_empty() {
        root.draw(&Circle::new((x, y), larger(RADIUS), fill))?;
        return Ok(root.draw(&Circle::new((x, y), larger(RADIUS), rim))?);
    }
    let mut corners: Vec<Pixel> = outline.iter().map(|(dx, dy)| (x + larger(*dx), y + larger(*dy))).collect();
    root.draw(&Polygon::new(corners.clone(), fill))?;
    corners.extend_from_within(..2); // the first side is drawn twice, so that the last corner is as sharp as the others
    Ok(root.draw(&PathElement::new(corners, rim))?)
}

/// Draws a bar with end caps between two pixels of one row or one column.
pub fn error_bar(root: &Area<'_>, from: Pixel, to: Pixel, tone: RGBColor) -> Drawn {
    let style = tone.mix(0.7).stroke_width(1);
    root.draw(&PathElement::new(vec![from, to], style))?;
    let across = if from.1 == to.1 { (0, 3) } else { (3, 0) };
    for (x, y) in [from, to] {
        root.draw(&PathElement::new(vec![(x - across.0, y - across.1), (x + across.0, y + across.1)], style))?;
    }
    Ok(())
}
