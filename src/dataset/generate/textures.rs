//! Textures made of noise and patterns.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::{
    dice::Dice,
    noise::{TABLE, table, unit},
};
use crate::{Texture, srgb};

/// Side of most textures in pixels.
pub(super) const SIDE: usize = 256;

/// A pattern. All but glyphs, paintings, facades and leaves repeat without a seam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pattern {
    Marble,
    Planks,
    Grain,
    Bricks,
    Tiles,
    Checks,
    Stripes,
    Plaid,
    Speckle,
    Plaster,
    Weave,
    Dots,
    Glyphs,
    Painting,
    Patches,
    Gravel,
    Grass,
    Bark,
    Facade,
    Leaves,
    Needles,
    /// A whole tree, seen from far away.
    Crown,
}

/// A pattern with its parameters.
struct Recipe {
    pattern: Pattern,
    /// From the darkest to the brightest part, encoded sRGB, 0 to 255.
    colors: [Vec3; 4],
    count: f32,
    /// Offset of the noise, and a word that all hashes depend on.
    shift: Vec2,
    seed: u32,
    strength: f32,
    noise: &'static [f32],
    /// Parts of paintings and leaves.
    parts: Vec<Part>,
}

/// A shape of a painting, or a leaf.
struct Part {
    at: Vec2,
    size: f32,
    /// Sine and cosine of its direction.
    turn: (f32, f32),
    color: Vec3,
}

/// Returns the whole part of positive numbers, faster than `floor`.
fn whole(at: Vec2) -> Vec2 {
    at.as_ivec2().as_vec2()
}

/// Makes a texture of a pattern in shades of two linear colours, with `side` pixels per side.
pub(super) fn texture(pattern: Pattern, [first, second]: [Vec3; 2], side: usize, dice: &mut Dice) -> Texture {
    let encoded = |color: Vec3| Vec3::from_array(color.to_array().map(|channel| f32::from(srgb::encode(channel))));
    let (first, second) = (encoded(first), encoded(second));
    let dark = first * dice.between(0.45, 0.75);
    let mut recipe = Recipe {
        pattern,
        colors: [dark, first, first.lerp(second, dice.between(0.4, 0.8)), second],
        count: dice.whole(2, 5) as f32,
        shift: Vec2::new(dice.unit(), dice.unit()),
        seed: (dice.unit() * (1 << 24) as f32) as u32,
        strength: dice.unit(),
        noise: table(),
        parts: Vec::new(),
    };
    recipe.parts = match pattern {
        Pattern::Painting => (0..9).map(|_| shape(dice)).collect(),
        Pattern::Leaves => (0..11).rev().map(|leaf| recipe.leaf(leaf, dice)).collect(),
        Pattern::Needles => (0..16).map(|_| recipe.blade(dice)).collect(),
        _ => Vec::new(),
    };
    let pixel = |place: usize| {
        let at = Vec2::new((place % side) as f32 + 0.5, (place / side) as f32 + 0.5) / side as f32;
        let (color, alpha) = recipe.pixel(at);
        let [r, g, b] = color.clamp(Vec3::ZERO, Vec3::splat(255.0)).to_array().map(|channel| channel as u8);
        [r, g, b, if alpha { 255 } else { 0 }]
    };
    // The size fits the number of pixels, so there is no error.
    Texture::image(side as u32, side as u32, (0..side * side).map(pixel).collect())
        .unwrap_or_else(|error| unreachable!("{error}"))
}

/// Draws a shape of a painting.
fn shape(dice: &mut Dice) -> Part {
    let hue = dice.angle();
    Part {
        at: Vec2::new(dice.unit(), dice.unit()),
        size: dice.between(0.05, 0.3),
        turn: dice.angle().sin_cos(),
        color: 128.0 + 75.0 * Vec3::new(hue.cos(), (hue + 2.1).cos(), (hue + 4.2).cos()),
    }
}

impl Recipe {
    /// Returns noise with a period of 1, 0 to 1, by the nearest entry of the table.
    fn noise(&self, at: Vec2) -> f32 {
        let at = ((at + self.shift) * TABLE as f32).as_ivec2();
        self.noise[(at.y as usize % TABLE) * TABLE + at.x as usize % TABLE]
    }

    /// Draws a leaf of a twig, counted from below.
    fn leaf(&self, leaf: usize, dice: &mut Dice) -> Part {
        let (along, side) = (leaf as f32 / 11.0, if leaf.is_multiple_of(2) { 1.0 } else { -1.0 });
        Part {
            at: Vec2::new(0.5, 0.97 - 0.85 * along),
            size: dice.between(0.32, 0.44),
            turn: (side * dice.between(1.0, 1.3) * (1.0 - 0.6 * along)).sin_cos(),
            color: self.shade(dice.between(0.2, 0.8)),
        }
    }

    /// Draws a blade from the lower edge, with the columns of its ends as its place.
    fn blade(&self, dice: &mut Dice) -> Part {
        Part {
            at: Vec2::new(dice.between(0.15, 0.85), dice.unit()),
            size: dice.between(0.45, 1.0),
            turn: (0.0, 1.0),
            color: self.shade(dice.between(0.2, 0.8)),
        }
    }

    fn hash(&self, x: f32, y: f32) -> f32 {
        unit((x as i32 as u32).wrapping_mul(7919) ^ (y as i32 as u32).wrapping_mul(104_729) ^ self.seed)
    }

    /// Returns a colour between the recipe's colours, 0 to 1.
    fn shade(&self, share: f32) -> Vec3 {
        let place = share.clamp(0.0, 1.0) * 3.0;
        let low = (place as usize).min(2);
        self.colors[low].lerp(self.colors[low + 1], place - low as f32)
    }

    /// Returns the colour at a place from 0 to 1, and whether it is solid.
    fn pixel(&self, at: Vec2) -> (Vec3, bool) {
        match self.pattern {
            Pattern::Leaves => self.leaves(at),
            Pattern::Needles => self.needles(at),
            Pattern::Crown => self.crown(at),
            Pattern::Painting => (self.painting(at), true),
            Pattern::Glyphs => (self.glyphs(at), true),
            Pattern::Facade => (self.facade(at), true),
            Pattern::Bricks | Pattern::Tiles | Pattern::Planks => (self.courses(at), true),
            Pattern::Checks | Pattern::Stripes | Pattern::Plaid | Pattern::Dots | Pattern::Weave => {
                (self.printed(at), true)
            }
            _ => (self.natural(at), true),
        }
    }

    /// Stone, wood, plaster, soil and other irregular patterns.
    fn natural(&self, at: Vec2) -> Vec3 {
        let coarse = self.noise(at);
        let fine = self.noise(at * 4.0);
        match self.pattern {
            Pattern::Marble => {
                let wave = (TAU * (at.x + self.count * at.y) + 9.0 * coarse).sin();
                let vein = (1.0 - wave.abs()).powi(4);
                self.shade(0.95 - 0.75 * vein - 0.4 * (fine - 0.5))
            }
            Pattern::Grain => {
                let rings = (TAU * (self.count * at.x * 3.0 + 2.0 * self.noise(at * Vec2::new(2.0, 1.0)))).sin();
                let fibre = self.noise(at * Vec2::new(24.0, 1.0));
                self.shade(0.45 + 0.22 * rings + 0.7 * (fibre - 0.5))
            }
            Pattern::Speckle => {
                let grains = self.noise(at * 8.0);
                let other = self.noise(at * 7.0 + 0.5);
                let spot = if grains > 0.63 {
                    1.0
                } else if other < 0.36 {
                    0.0
                } else {
                    0.55
                };
                self.shade(spot + 0.25 * (fine - 0.5))
            }
            Pattern::Plaster => {
                self.shade(0.6 + (0.5 + 0.6 * self.strength) * (self.noise(at * 7.0) - 0.5) + 0.12 * (coarse - 0.5))
            }
            Pattern::Patches => self.shade(((coarse * 9.0).floor() / 4.0).rem_euclid(1.0) + 0.2 * (fine - 0.5)),
            Pattern::Gravel => {
                let (edge, id) = self.cells(at, 14.0);
                self.shade(0.15 + 0.55 * self.hash(id.x, id.y) + 0.5 * edge.min(0.5) + 0.4 * (fine - 0.5))
            }
            Pattern::Grass => {
                let blades = self.noise(at * 9.0) + self.noise(Vec2::new(at.y, at.x) * 13.0);
                self.shade(0.5 + 0.8 * (blades - 1.0) + 0.15 * (coarse - 0.5) + 0.3 * (fine - 0.5))
            }
            _ => {
                let ridges = self.noise(at * Vec2::new(9.0, 2.0));
                self.shade(0.45 + 1.8 * (ridges - 0.5) + 0.5 * (fine - 0.5))
            }
        }
    }

    /// Returns the distance to the edge of a cell of a jittered grid, in cells, and the cell.
    fn cells(&self, at: Vec2, count: f32) -> (f32, Vec2) {
        let at = at * count;
        let cell = whole(at);
        let (mut nearest, mut second, mut found) = (f32::INFINITY, f32::INFINITY, cell);
        for offset in 0..9 {
            let other = cell + Vec2::new((offset % 3) as f32 - 1.0, (offset / 3) as f32 - 1.0);
            let id = other.rem_euclid(Vec2::splat(count));
            let point = other + Vec2::new(self.hash(id.x, id.y + 300.0), self.hash(id.x + 300.0, id.y));
            let distance = point.distance(at);
            if distance < nearest {
                (second, nearest, found) = (nearest, distance, id);
            } else {
                second = second.min(distance);
            }
        }
        (second - nearest, found)
    }

    /// Bricks, tiles and planks: rows of rectangles with joints.
    fn courses(&self, at: Vec2) -> Vec3 {
        let (columns, rows, joint) = match self.pattern {
            Pattern::Bricks => (4.0, 12.0, 0.06),
            Pattern::Tiles => (self.count, self.count, 0.03),
            _ => (1.0, 2.0 + self.count, 0.02),
        };
        let row = (at.y * rows).trunc();
        let shift = match self.pattern {
            Pattern::Bricks => 0.5 * (row % 2.0),
            Pattern::Tiles => 0.0,
            _ => self.hash(row, 3.0),
        };
        let along = at.x * columns + shift;
        let column = along.floor().rem_euclid(columns);
        let (u, v) = (along.fract(), (at.y * rows).fract());
        let aspect = if self.pattern == Pattern::Bricks { rows / columns } else { 1.0 };
        let joints = match self.pattern {
            Pattern::Planks => u.min(1.0 - u) * rows < joint * 2.0 || v.min(1.0 - v) < joint,
            _ => u.min(1.0 - u) * aspect < joint || v.min(1.0 - v) < joint,
        };
        let own = self.hash(column, row);
        let grain = match self.pattern {
            Pattern::Planks => self.noise(at * Vec2::new(2.0, 24.0) + own),
            _ => self.noise(at * 6.0),
        };
        if joints {
            return self.colors[0] * if self.pattern == Pattern::Planks { 0.6 } else { 1.15 } + 20.0 * grain;
        }
        self.shade(0.25 + 0.5 * own + 0.7 * (grain - 0.5))
    }

    /// Printed or woven patterns with sharp edges.
    fn printed(&self, at: Vec2) -> Vec3 {
        let count = 2.0 * self.count;
        let cell = whole(at * count);
        let within = at * count - cell;
        let wear = 24.0 * (self.noise(at * 3.0) - 0.5);
        let flat = match self.pattern {
            Pattern::Checks => self.colors[if (cell.x + cell.y) % 2.0 == 0.0 { 1 } else { 3 }],
            Pattern::Stripes => {
                let widths = self.hash(cell.x, 0.0);
                self.colors[if within.x < 0.2 + 0.6 * widths { 3 } else { (cell.x as usize) % 2 }]
            }
            Pattern::Plaid => {
                let line = |share: f32| {
                    if share < 0.35 {
                        0.35
                    } else if (0.6..0.66).contains(&share) {
                        0.5
                    } else {
                        0.0
                    }
                };
                self.shade(0.3 + line(within.x) + line(within.y))
            }
            Pattern::Dots => {
                let radius = 0.2 + 0.2 * self.hash(cell.x, cell.y);
                self.colors[if within.distance(Vec2::splat(0.5)) < radius { 3 } else { 1 }]
            }
            _ => {
                let threads = whole(at * 48.0);
                let over = (threads.x + threads.y) % 2.0;
                self.shade(0.35 + 0.3 * over + 0.35 * (self.hash(threads.x, threads.y) - 0.5))
            }
        };
        flat + wear
    }

    /// Lines of signs like those of a script.
    fn glyphs(&self, at: Vec2) -> Vec3 {
        let paper = self.colors[3].lerp(Vec3::splat(235.0), 0.6) + 12.0 * (self.noise(at * 3.0) - 0.5);
        let rows = 10.0 + 2.0 * self.count;
        let row = (at.y * rows).trunc();
        let line = self.hash(row, 77.0);
        let is_title = row < 2.0;
        let scale = if is_title { 1.0 } else { 2.0 };
        let columns = 16.0 * scale;
        let column = (at.x * columns).floor();
        let margin = at.x < 0.06 || at.x > 0.6 + 0.36 * line || (row as i32) % 7 == 6;
        let is_space = self.hash(column, row * 3.0) < 0.18;
        if margin || is_space || (is_title && row == 1.0) {
            return paper;
        }
        let dot = Vec2::new((at.x * columns).fract() * 5.0, (at.y * rows).fract() * 7.0).floor();
        let inside = dot.x < 4.0 && (1.0..6.0).contains(&dot.y);
        let is_ink = inside && self.hash(column * 5.0 + dot.x, row * 7.0 + dot.y + 0.5 * line) < 0.55;
        if is_ink { self.colors[0] * 0.4 } else { paper }
    }

    /// Areas, discs and bars of colour, like a poster.
    fn painting(&self, at: Vec2) -> Vec3 {
        let mut color = self.shade(at.y * 0.8 + 0.3 * (self.noise(at * 2.0) - 0.5));
        for (index, Part { at: center, size, turn: (sin, cos), color: other }) in self.parts.iter().enumerate() {
            let offset = at - *center;
            let turned = Vec2::new(cos * offset.x + sin * offset.y, cos * offset.y - sin * offset.x).abs();
            let inside = match index % 3 {
                0 => offset.length_squared() < size * size,
                1 => turned.x < *size && turned.y < 0.3 * size,
                _ => turned.x + turned.y < *size,
            };
            if inside {
                color = color.lerp(*other, 0.75);
            }
        }
        color + 26.0 * (self.noise(at * 4.0) - 0.5)
    }

    /// Rows of windows in a wall.
    fn facade(&self, at: Vec2) -> Vec3 {
        let count = 4.0;
        let cell = whole(at * count);
        let within = at * count - cell;
        let half = Vec2::new(0.18 + 0.14 * self.strength, 0.28);
        let offset = (within - Vec2::new(0.5, 0.48)).abs();
        let wall = self.shade(0.65 + 0.4 * (self.noise(at * 4.0) - 0.5)) + 14.0 * (self.noise(at * 8.0) - 0.5);
        if offset.cmpgt(half + 0.035).any() {
            let is_ledge = within.y > 0.94;
            return if is_ledge { wall * 0.75 } else { wall };
        }
        let is_frame = offset.cmpgt(half).any() || offset.x < 0.012 || (within.y - 0.4).abs() < 0.012;
        if is_frame {
            return self.colors[3].lerp(Vec3::splat(230.0), 0.6);
        }
        let glass = Vec3::new(40.0, 52.0, 66.0) + 70.0 * within.y * self.hash(cell.x, cell.y);
        let curtain = self.hash(cell.x + 9.0, cell.y) > 0.6 && offset.x > half.x * 0.45;
        if curtain { glass.lerp(Vec3::splat(200.0), 0.6) } else { glass }
    }

    /// Broad leaves on a twig, with holes between them.
    fn leaves(&self, at: Vec2) -> (Vec3, bool) {
        let grain = 0.8 + 0.4 * self.noise(at * 4.0);
        for Part { at: base, size, turn: (sin, cos), color } in &self.parts {
            let offset = at - *base;
            let (out, aside) = (sin * offset.x - cos * offset.y, cos * offset.x + sin * offset.y);
            let t = out / size;
            // The outline is half an ellipse on each side.
            if (0.0..1.0).contains(&t) && aside * aside < 0.04 * t * (1.0 - t) {
                let vein = if aside.abs() < 0.006 { 1.25 } else { 1.0 };
                return (*color * vein * grain, true);
            }
        }
        (self.colors[1] * 0.6, (at.x - 0.5).abs() < 0.01 && at.y > 0.15)
    }

    /// The crown and the trunk of a tree.
    fn crown(&self, at: Vec2) -> (Vec3, bool) {
        let leaves = self.noise(at * 3.0) + 0.5 * self.noise(at * 8.0);
        let offset = (at - Vec2::new(0.5, 0.4)) / Vec2::new(0.42 + 0.08 * self.strength, 0.4);
        if offset.length() < 0.55 + 0.5 * leaves {
            return (self.shade(0.9 * leaves - 0.25 * offset.y), leaves > 0.52);
        }
        (self.colors[0] * 0.5, (at.x - 0.5).abs() < 0.03 && at.y > 0.6)
    }

    /// Narrow blades or needles that rise from the lower edge.
    fn needles(&self, at: Vec2) -> (Vec3, bool) {
        for Part { at: ends, size: height, color, .. } in &self.parts {
            let t = (1.0 - at.y) / height;
            let middle = ends.x + (ends.y - ends.x) * t * t;
            if t < 1.0 && (at.x - middle).abs() < 0.028 * (1.0 - t) + 0.004 {
                return (*color * (0.7 + 0.5 * t), true);
            }
        }
        (self.shade(0.4), false)
    }
}
