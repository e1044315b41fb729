//! Checks the numbers and indices of an OBJ file before tobj reads them, since tobj's errors name no line.

use glam::DVec3;

use crate::message::{counted, noun};

use super::{Fault, lines, split_keyword};
use crate::scene::MAX_COORDINATE;

/// A value for each attribute of a face's corner.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) struct Corners<T> {
    pub(super) vertex: T,
    pub(super) texture: T,
    pub(super) normal: T,
}

/// Checks the indices of a face's corners against the counts so far. Returns which attributes all corners have.
pub(super) fn check_face(corners: &str, counts: Corners<usize>) -> Result<Corners<bool>, String> {
    if corners.is_empty() {
        return Err("a face without corners".into());
    }
    let mut has = Corners { vertex: true, texture: true, normal: true };
    for corner in corners.split_whitespace() {
        let mut parts = corner.split('/');
        let mut next = || parts.next().filter(|part| !part.is_empty());
        let (vertex, texture, normal) = (next(), next(), next());
        let fault = |reason: String| format!("face corner '{corner}': {reason}");
        if parts.next().is_some() {
            return Err(fault("more than vertex/texture/normal".into()));
        }
        let vertex = vertex.ok_or_else(|| fault("no vertex index".into()))?;
        check_index("vertex", vertex, counts.vertex).map_err(fault)?;
        match texture {
            Some(texture) => check_index("texture", texture, counts.texture).map_err(fault)?,
            None => has.texture = false,
        }
        match normal {
            Some(normal) => check_index("normal", normal, counts.normal).map_err(fault)?,
            None => has.normal = false,
        }
    }
    Ok(has)
}

fn parse_index(what: &str, word: &str) -> Result<isize, String> {
    word.parse().map_err(|_| format!("{what} index '{word}' is not a whole number"))
}

/// Checks an index. Indices count from 1, or backwards from -1.
fn check_index(what: &str, word: &str, count: usize) -> Result<(), String> {
    match parse_index(what, word)? {
        0 => Err(format!("{what} index 0; the first is 1")),
        index if index.unsigned_abs() > count => {
            let are = noun(count, "is", "are");
            Err(format!("{what} index {index} is out of range: there {are} {count} before this line"))
        }
        _ => Ok(()),
    }
}

/// Returns the first `v`, `vt` or `vn` line whose numbers are missing, too many, unreadable, not finite or too large.
/// Vertices may lie up to [`MAX_COORDINATE`] from the scene's origin.
pub(super) fn find_bad_number(text: &str, origin: DVec3) -> Option<Fault> {
    lines(text).find_map(|(number, line)| {
        let (keyword, rest) = split_keyword(&line);
        let fault = match keyword {
            "v" => check_numbers("vertex", rest, MAX_COORDINATE, origin),
            "vt" => check_texture(rest),
            // tobj reads three numbers and ignores the rest.
            "vn" => {
                let words: Vec<&str> = rest.split_whitespace().take(3).collect();
                check_numbers("normal", &words.join(" "), f32::MAX, DVec3::ZERO)
            }
            _ => return None,
        };
        fault.err().map(|reason| (number, reason))
    })
}

fn check_numbers(what: &str, words: &str, largest: f32, origin: DVec3) -> Result<(), String> {
    let mut values = Vec::new();
    for word in words.split_whitespace() {
        values.push(word.parse::<f64>().map_err(|_| format!("{what}: '{word}' is not a number"))?);
    }
    let count = values.len();
    let (coordinates, more) = values
        .split_at_checked(3)
        .ok_or_else(|| format!("{what}: {} instead of 3", counted(count, "number", "numbers")))?;
    let scale = match *more {
        [] => 1.0,
        [r, g, b] => match [r, g, b].into_iter().find(|value| !value.is_finite()) {
            Some(value) => return Err(format!("{what}: colour {value} is not a finite number")),
            None => 1.0,
        },
        [0.0] => return Err(format!("{what}: the weight w is 0")),
        [w] => w,
        _ => return Err(format!("{what}: {count} numbers; give x y z, x y z w, or x y z r g b")),
    };
    let is_bad = |(value, from): &(f64, f64)| value.is_nan() || (value - from).abs() > f64::from(largest);
    let bad = coordinates.iter().map(|value| value / scale).zip(origin.to_array()).find(is_bad);
    match bad.map(|(value, _)| value) {
        None => Ok(()),
        Some(value) if value.is_finite() => {
            let of = if origin == DVec3::ZERO { "" } else { " of the scene's origin" };
            Err(format!("{what}: {value:?} is beyond ±{largest:e}{of}; scale the scene down"))
        }
        Some(value) => Err(format!("{what}: {value} is not a finite number")),
    }
}

/// Checks one or two texture coordinates. A third number is the depth in a solid texture.
fn check_texture(words: &str) -> Result<(), String> {
    let what = "texture coordinates";
    let mut count = 0;
    for word in words.split_whitespace().take(2) {
        let value: f32 = word.parse().map_err(|_| format!("{what}: '{word}' is not a number"))?;
        if !value.is_finite() {
            return Err(format!("{what}: {value} is not a finite number"));
        }
        count += 1;
    }
    if count > 0 { Ok(()) } else { Err(format!("{what}: 0 numbers instead of 2")) }
}
