//! Draws dashed lines and ranges of plots.

use plotters::prelude::*;

use crate::common::{
    chart::{Area, Drawn, Pixel},
    looks::{color, marker},
};

pub(super) const DOTS: &[f64] = &[2.0, 4.0];

/// Draws a line through the points with alternating lengths of strokes and gaps. Without lengths the line is solid.
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

/// Draws a vertical range from `top` to `bottom`, with the marker of this look in its middle.
pub(super) fn bracket(root: &Area<'_>, x: i32, (top, bottom): (i32, i32), look: usize) -> Drawn {
    let corners = [(x - 4, top), (x + 4, top), (x, top), (x, bottom), (x - 4, bottom), (x + 4, bottom)];
    stroke(root, &corners, &[], color(look).stroke_width(2))?;
    marker(root, look, (x, top.midpoint(bottom)), color(look).filled(), WHITE.into())
}
