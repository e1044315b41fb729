//! Small things that stand on tables and shelves.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3};

use super::textures::Pattern;
use super::{
    World,
    dice::Dice,
    form::{Form, Top},
    furniture,
    materials::{Paint, Stuff},
    plants, shapes, standing,
};
use crate::Error;

/// An object's name, its form, and the paints of its slots.
pub(super) type Thing = (&'static str, Form, Vec<Paint>);

impl World<'_> {
    /// Puts things on the tops of a placed object. `fullness` is their number per metre of a top's longer side.
    pub(super) fn fill(&mut self, form: &Form, transform: &Affine3A, fullness: f32) -> Result<(), Error> {
        for top in &form.tops {
            let size = top.high - top.low;
            let count = (size.x.max(size.z) * fullness * self.dice.between(0.4, 1.5)).round() as usize;
            for _ in 0..count.min(12) {
                self.stand(top, transform)?;
            }
        }
        Ok(())
    }

    /// Puts a thing on a top, if a free place is found.
    fn stand(&mut self, top: &Top, transform: &Affine3A) -> Result<(), Error> {
        let size = top.high - top.low;
        let most = Vec3::new(size.x, top.room, size.z).min(Vec3::splat(0.45));
        let Some((name, form, paints)) = self.thing(most)? else { return Ok(()) };
        let (low, high) = form.bounds();
        let reach = 0.5 * Vec2::new(high.x - low.x, high.z - low.z).max_element();
        for _ in 0..super::TRIES {
            let mut along = |low: f32, high: f32| {
                let inset = reach.min(0.5 * (high - low));
                self.dice.between(low + inset, high - inset)
            };
            let at = Vec3::new(along(top.low.x, top.high.x), top.low.y + 0.0005, along(top.low.z, top.high.z));
            let turn = if name == "books" { self.dice.between(-0.05, 0.05) } else { self.dice.angle() };
            if self.put(name, &form, &(*transform * standing(at, turn)), &paints)? {
                break;
            }
        }
        Ok(())
    }

    /// Returns a small object that stands on y = 0 and fits into a box of this size, with its paints.
    pub(super) fn thing(&mut self, most: Vec3) -> Result<Option<Thing>, Error> {
        let room = most.y.min(1.2 * most.x.min(most.z));
        if room < 0.05 {
            return Ok(None);
        }
        let height = room * self.dice.between(0.45, 0.95);
        if self.palette.assets().mesh_count() > 0 && self.dice.chance(0.4) {
            let made = self.model([0.6 * room, 0.95 * room])?;
            return Ok(made.map(|(form, paints)| ("mesh", form, paints)));
        }
        let mut dice = self.dice.fork();
        Ok(Some(match dice.below(10) {
            0..=2 => {
                let vessel = shapes::vessel(&mut dice, height);
                (vessel.name, vessel.form, vec![self.palette.object(Stuff::Ceramic, true)?])
            }
            3 | 4 => {
                let form = books(&mut dice, most);
                let paints = [Stuff::Card, Stuff::Cloth, Stuff::Any].map(|stuff| self.palette.paint(stuff));
                ("books", form, paints.into_iter().collect::<Result<_, _>>()?)
            }
            5 if height > 0.12 => {
                let form = plants::potted(&mut dice, height);
                ("plant", form, self.plant_paints()?)
            }
            6 if height > 0.2 => {
                let lamp = furniture::lamp(&mut dice, height);
                (lamp.name, lamp.form, self.paints(lamp.stuff, false)?)
            }
            7 => {
                let carton = shapes::carton(&mut dice);
                let paints = vec![self.palette.paint(Stuff::Card)?, self.palette.object(Stuff::Any, true)?];
                (carton.name, grounded(carton.form, height), paints)
            }
            _ => {
                let shape = shapes::any(&mut dice);
                let paints = self.paints(&[Stuff::Any, Stuff::Metal], shape.is_closed)?;
                (shape.name, grounded(shape.form, height), paints)
            }
        }))
    }

    /// Returns the paints of a potted plant: wood, leaves, pot and blades.
    pub(super) fn plant_paints(&mut self) -> Result<Vec<Paint>, Error> {
        let pot = self.palette.object(Stuff::Ceramic, false)?;
        let blade = self.palette.paint(Stuff::Grass)?;
        Ok(vec![self.palette.paint(Stuff::Bark)?, self.palette.foliage(Pattern::Leaves), pot, blade])
    }
}

/// Scales a form so that its longest side has this length, and puts it on the plane y = 0.
pub(super) fn grounded(form: Form, size: f32) -> Form {
    let mut form = form.centred(size);
    let low = form.bounds().0;
    form.positions.iter_mut().for_each(|at| at.y -= low.y);
    form
}

/// Returns a row or a stack of books.
fn books(dice: &mut Dice, most: Vec3) -> Form {
    let mut form = Form::default();
    let height = most.y.min(0.32) * dice.between(0.7, 0.95);
    let depth = most.z.min(0.22) * dice.between(0.7, 0.9);
    let count = dice.whole(2, 9);
    let is_stack = dice.chance(0.3);
    let mut at = 0.0;
    for _ in 0..count {
        let thick = dice.between(0.012, 0.045);
        let (tall, deep) = (height * dice.between(0.8, 1.0), depth * dice.between(0.85, 1.0));
        let slot = dice.whole(0, 2) as u16;
        if is_stack {
            if at + thick > most.y {
                break;
            }
            let mut book = Form::default();
            book.block(Vec3::new(deep.min(most.x), thick - 0.001, 0.72 * deep), at, slot);
            let turn = standing(Vec3::ZERO, dice.between(-0.2, 0.2));
            form.join(&book, turn, 0);
        } else {
            if at + thick > most.x {
                break;
            }
            form.cuboid(Vec3::new(at, 0.0, -0.5 * deep), Vec3::new(at + thick - 0.001, tall, 0.5 * deep), slot);
        }
        at += thick;
    }
    if !is_stack {
        form.positions.iter_mut().for_each(|point| point.x -= 0.5 * at);
    }
    form
}

/// Returns a cable on the floor.
pub(super) fn cable(dice: &mut Dice, length: f32) -> Form {
    let mut form = Form::default();
    let waves = [dice.between(0.5, 2.5), dice.angle(), dice.between(0.05, 0.25)];
    let line: Vec<Vec3> = (0..=40)
        .map(|step| {
            let t = step as f32 / 40.0;
            let side = waves[2] * (TAU * waves[0] * t + waves[1]).sin();
            Vec3::new((t - 0.5) * length, 0.006, side)
        })
        .collect();
    form.tube(&line, |_| 0.005, 5, false, 0);
    form
}
