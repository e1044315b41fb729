//! Walls with windows and doors, floors and ceilings.

use std::f32::consts::FRAC_PI_2;

use glam::{Affine3A, Vec2, Vec3};

use super::{
    World,
    dice::Dice,
    form::Form,
    materials::{Paint, Stuff},
    standing,
};
use crate::Error;

/// Thickness of walls in metres.
const THICK: f32 = 0.22;

/// An opening in a wall: its low and high corner on the wall, in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Opening {
    pub(super) low: Vec2,
    pub(super) high: Vec2,
}

/// A wall of a room in its own frame: x runs along the wall, y is up, and z points into the room.
pub(super) struct Wall {
    pub(super) width: f32,
    pub(super) to_world: Affine3A,
    pub(super) opening: Option<Opening>,
    pub(super) is_window: bool,
}

/// Returns the four walls of a room with its low corner at the origin.
pub(super) fn walls(size: Vec3, dice: &mut Dice) -> Vec<Wall> {
    let corners =
        [Vec3::ZERO, Vec3::new(size.x, 0.0, 0.0), Vec3::new(size.x, 0.0, size.z), Vec3::new(0.0, 0.0, size.z)];
    let door = dice.below(4);
    let windows = [dice.chance(0.5), dice.chance(0.4), dice.chance(0.5), dice.chance(0.4)];
    (0..4)
        .map(|side| {
            let width = if side % 2 == 0 { size.x } else { size.z };
            let to_world = standing(corners[side], -FRAC_PI_2 * side as f32);
            let is_window = side != door && windows[side];
            let opening = match (side == door, is_window) {
                (true, _) => Some(opening(width, [0.8, 1.0], 0.0, dice.between(2.0, 2.15), dice)),
                (_, true) => {
                    let sill = dice.between(0.3, 1.0);
                    let lintel = (size.y - dice.between(0.2, 0.5)).max(sill + 0.8);
                    Some(opening(width, [0.9, (0.7 * width).max(1.0)], sill, lintel, dice))
                }
                _ => None,
            };
            Wall { width, to_world, opening, is_window }
        })
        .collect()
}

fn opening(width: f32, [least, most]: [f32; 2], low: f32, high: f32, dice: &mut Dice) -> Opening {
    let size = dice.between(least, most).min(width - 0.4);
    let from = dice.between(0.2, width - 0.2 - size);
    Opening { low: Vec2::new(from, low), high: Vec2::new(from + size, high) }
}

impl Wall {
    /// Returns the wall with the sides of its opening, as slots 0 and 1.
    fn form(&self, height: f32) -> Form {
        let mut form = Form::default();
        let Some(Opening { low, high }) = self.opening else {
            panel(&mut form, Vec2::ZERO, Vec2::new(self.width, height), 0.0, 0);
            return form;
        };
        let panels = [
            (Vec2::ZERO, Vec2::new(low.x, height)),
            (Vec2::new(high.x, 0.0), Vec2::new(self.width, height)),
            (Vec2::new(low.x, 0.0), Vec2::new(high.x, low.y)),
            (Vec2::new(low.x, high.y), Vec2::new(high.x, height)),
        ];
        for (from, to) in panels.into_iter().filter(|(from, to)| (*to - *from).min_element() > 1e-3) {
            panel(&mut form, from, to, 0.0, 0);
        }
        let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        form.quad(
            [at(low.x, low.y, 0.0), at(low.x, low.y, -THICK), at(low.x, high.y, -THICK), at(low.x, high.y, 0.0)],
            1,
        );
        form.quad(
            [at(high.x, low.y, -THICK), at(high.x, low.y, 0.0), at(high.x, high.y, 0.0), at(high.x, high.y, -THICK)],
            1,
        );
        form.quad(
            [at(low.x, low.y, 0.0), at(high.x, low.y, 0.0), at(high.x, low.y, -THICK), at(low.x, low.y, -THICK)],
            1,
        );
        form.quad(
            [at(low.x, high.y, -THICK), at(high.x, high.y, -THICK), at(high.x, high.y, 0.0), at(low.x, high.y, 0.0)],
            1,
        );
        form
    }
}

fn panel(form: &mut Form, from: Vec2, to: Vec2, z: f32, slot: u16) {
    let corners = [from, Vec2::new(to.x, from.y), to, Vec2::new(from.x, to.y)];
    form.quad_with(corners.map(|at| at.extend(z)), corners, slot);
}

impl World<'_> {
    /// Adds floor, ceiling, walls, windows, the door and the skirting.
    pub(super) fn shell(&mut self, size: Vec3, walls: &[Wall]) -> Result<(), Error> {
        let flat = |y: f32, is_floor: bool| {
            let corner = |x: f32, z: f32| Vec3::new(x * size.x, y, z * size.z);
            let corners = match is_floor {
                true => [corner(0.0, 1.0), corner(1.0, 1.0), corner(1.0, 0.0), corner(0.0, 0.0)],
                false => [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)],
            };
            let mut form = Form::default();
            form.quad_with(corners, corners.map(|at| Vec2::new(at.x, -at.z)), 0);
            form
        };
        let floor = self.palette.paint(Stuff::Floor)?;
        self.add("floor", &flat(0.0, true), &Affine3A::IDENTITY, &[floor])?;
        let ceiling = self.palette.paint(Stuff::Ceiling)?;
        self.add("ceiling", &flat(size.y, false), &Affine3A::IDENTITY, &[ceiling])?;
        let (main, trim) = (self.palette.paint(Stuff::Wall)?, self.palette.paint(Stuff::Wood)?);
        let accent = if self.dice.chance(0.4) { self.palette.paint(Stuff::Wall)? } else { main };
        for (side, wall) in walls.iter().enumerate() {
            let paint = if side == 0 { accent } else { main };
            self.add("wall", &wall.form(size.y), &wall.to_world, &[paint, trim])?;
            self.add("skirting", &skirting(wall), &wall.to_world, &[trim])?;
            match wall.opening {
                Some(opening) if wall.is_window => self.window(wall, opening, trim)?,
                Some(opening) => self.door(wall, opening)?,
                None => {}
            }
        }
        Ok(())
    }

    /// Adds a window's frame, bars, glass and sometimes curtains.
    fn window(&mut self, wall: &Wall, Opening { low, high }: Opening, trim: Paint) -> Result<(), Error> {
        let (mut form, size) = (Form::default(), high - low);
        let bar = self.dice.between(0.03, 0.06);
        let z = -0.6 * THICK;
        let mut rail = |from: Vec2, to: Vec2| form.cuboid(from.extend(z - 0.02), to.extend(z + 0.02), 0);
        let columns = ((size.x / self.dice.between(0.5, 1.2)) as usize).max(1);
        let rows = self.dice.whole(1, 3);
        for column in 0..=columns {
            let x = low.x + (size.x - bar) * column as f32 / columns as f32;
            rail(Vec2::new(x, low.y), Vec2::new(x + bar, high.y));
        }
        for row in 0..=rows {
            let y = low.y + (size.y - bar) * row as f32 / rows as f32;
            rail(Vec2::new(low.x, y), Vec2::new(high.x, y + bar));
        }
        self.add("window frame", &form, &wall.to_world, &[trim])?;
        if self.dice.chance(0.5) {
            let mut pane = Form::default();
            panel(&mut pane, low, high, z, 0);
            let glass = self.palette.pane();
            self.add("window pane", &pane, &wall.to_world, &[glass])?;
        }
        if self.dice.chance(0.45) {
            self.curtains(wall, [low, high])?;
        }
        Ok(())
    }

    fn curtains(&mut self, wall: &Wall, [low, high]: [Vec2; 2]) -> Result<(), Error> {
        let cloth = self.palette.paint(Stuff::Cloth)?;
        let metal = self.palette.metal();
        let rod = high.y + 0.1;
        let foot = if self.dice.chance(0.5) { 0.03 } else { (low.y - 0.12).max(0.03) };
        let width = (0.3 * (high.x - low.x)).min(0.6);
        let mut form = Form::default();
        form.bar(Vec3::new(low.x - 0.15, rod, 0.09), Vec3::new(high.x + 0.15, rod, 0.09), 0.012, 8, 1);
        for from in [low.x - 0.1, high.x + 0.1 - width] {
            let point = |s: f32, t: f32| {
                let fold = 0.03 * (s * width * 60.0).sin() * (0.5 + 0.5 * (1.0 - t));
                Vec3::new(from + s * width, foot + t * (rod - foot), 0.09 + fold)
            };
            form.sheet([48, 6], false, Vec2::new(1.4 * width, rod - foot), point, 0);
        }
        self.add("curtain", &form, &wall.to_world, &[cloth, metal])
    }

    fn door(&mut self, wall: &Wall, Opening { low, high }: Opening) -> Result<(), Error> {
        let mut form = Form::default();
        let z = -0.5 * THICK;
        form.cuboid(low.extend(z - 0.04), high.extend(z), 0);
        let size = high - low;
        for row in 0..self.dice.whole(1, 3) {
            let y = low.y + 0.12 + row as f32 * 0.6;
            let top = if row == 2 { high.y - 0.12 } else { y + 0.5 };
            form.cuboid(Vec3::new(low.x + 0.12, y, z), Vec3::new(high.x - 0.12, top, z + 0.012), 1);
        }
        form.body(Vec3::new(low.x + 0.9 * size.x, 1.02, z + 0.05), [14, 8], |_| 0.03, 2);
        let (main, metal) = (self.palette.paint(Stuff::Wood)?, self.palette.metal());
        let panel = self.palette.paint(Stuff::Wood)?;
        self.add("door", &form, &wall.to_world, &[main, panel, metal])
    }
}

/// Returns the skirting of a wall, left out at a door.
fn skirting(wall: &Wall) -> Form {
    let mut form = Form::default();
    let door = wall.opening.filter(|_| !wall.is_window);
    let gaps = door.map_or([wall.width; 2], |opening| [opening.low.x, opening.high.x]);
    for [from, to] in [[0.0, gaps[0]], [gaps[1], wall.width]] {
        if to - from > 0.01 {
            form.cuboid(Vec3::new(from, 0.0, 0.0), Vec3::new(to, 0.08, 0.012), 0);
        }
    }
    form
}
