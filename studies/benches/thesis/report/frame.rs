//! Draws the box of a plot, with its axes, grid and labels.

use plotters::{
    prelude::*,
    style::{
        FontTransform,
        text_anchor::{HPos, Pos, VPos},
    },
};

use super::axis::{Axis, label};
use crate::common::chart::{Area, Drawn, FONT, GRID, INK, Pixel, Point};

/// The box in which points are placed.
#[derive(Clone, Copy)]
pub(super) struct Frame<'a> {
    pub(super) left: i32,
    pub(super) right: i32,
    pub(super) top: i32,
    pub(super) bottom: i32,
    pub(super) x: &'a Axis,
    pub(super) y: &'a Axis,
}

impl Frame<'_> {
    pub(super) fn place(&self, (x, y): Point) -> Pixel {
        (self.x.place(x, self.left, self.right), self.y.place(y, self.bottom, self.top))
    }

    /// Draws axes, grid and labels. Numbers along x are drawn only with a label for x, since panels share the axis.
    pub(super) fn draw(&self, root: &Area<'_>, y_label: &str, x_label: Option<&str>) -> Drawn {
        let style = |size: i32, h, v| (FONT, size).into_font().color(&INK).pos(Pos::new(h, v));
        let mut taken = i32::MIN;
        for &tick in &self.x.ticks {
            let x = self.x.place(tick, self.left, self.right);
            root.draw(&PathElement::new(vec![(x, self.top), (x, self.bottom)], GRID))?;
            root.draw(&PathElement::new(vec![(x, self.bottom), (x, self.bottom + 4)], INK))?;
            let number = label(tick);
            let half = 4 * number.len() as i32;
            if x_label.is_some() && x - half > taken {
                root.draw(&Text::new(number, (x, self.bottom + 8), style(12, HPos::Center, VPos::Top)))?;
                taken = x + half + 4;
            }
        }
        let mut taken = i32::MAX;
        for &tick in &self.y.ticks {
            let y = self.y.place(tick, self.bottom, self.top);
            let tone = if tick == 0.0 { INK } else { GRID };
            root.draw(&PathElement::new(vec![(self.left, y), (self.right, y)], tone))?;
            root.draw(&PathElement::new(vec![(self.left - 4, y), (self.left, y)], INK))?;
            if y + 7 < taken {
                root.draw(&Text::new(label(tick), (self.left - 8, y), style(12, HPos::Right, VPos::Center)))?;
                taken = y - 7;
            }
        }
        for end in [(self.left, self.top), (self.right, self.bottom)] {
            root.draw(&PathElement::new(vec![(self.left, self.bottom), end], INK))?;
        }
        if self.y.zero {
            // The axis is broken between zero and the lowest decade.
            let (x, y) = (self.left, self.bottom - Axis::ZERO_ROW);
            root.draw(&Rectangle::new([(x - 2, y - 3), (x + 2, y + 3)], WHITE.filled()))?;
            for y in [y - 3, y + 3] {
                root.draw(&PathElement::new(vec![(x - 6, y + 3), (x + 6, y - 3)], INK))?;
            }
        }
        let turned = (FONT, 13).into_font().transform(FontTransform::Rotate270).color(&INK);
        let turned = turned.pos(Pos::new(HPos::Center, VPos::Center));
        root.draw(&Text::new(y_label.to_owned(), (16, self.top.midpoint(self.bottom)), turned))?;
        if let Some(x_label) = x_label {
            let at = (self.left.midpoint(self.right), self.bottom + 28);
            root.draw(&Text::new(x_label.to_owned(), at, style(13, HPos::Center, VPos::Top)))?;
        }
        Ok(())
    }
}
