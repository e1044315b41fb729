//! Outdoor scenes: hilly ground with trees, buildings, fences, poles and wires.

use glam::{Affine3A, DVec3, Vec2, Vec3};

use super::{
    World,
    clutter::grounded,
    form::Form,
    materials::{Paint, Stuff},
    plants, shapes,
    skies::heaven,
    standing,
    textures::Pattern,
};
use crate::Error;

/// Distance of cameras from objects in metres.
const CLEARANCE: f32 = 0.7;
/// Half the width of the ground in metres, and its number of cells per side.
const REACH: f32 = 160.0;
const CELLS: usize = 52;
/// Distance from the middle at which objects stand, in metres.
const SITE: f32 = 26.0;

/// The ground's height as a sum of waves.
pub(super) struct Ground {
    waves: Vec<(Vec2, f32, f32)>,
    /// Height in metres of hills at the rim.
    rim: f32,
}

impl Ground {
    /// Returns the height at a place.
    pub(super) fn height(&self, x: f32, z: f32) -> f32 {
        let at = Vec2::new(x, z);
        let waves: f32 = self.waves.iter().map(|(along, phase, height)| height * (along.dot(at) + phase).sin()).sum();
        // Waves grow towards the rim, so that the site is walkable.
        let out = (at.length() / REACH).min(1.0);
        waves * (0.25 + 4.0 * out) + self.rim * out * out
    }

    pub(super) fn at(&self, x: f32, z: f32) -> Vec3 {
        Vec3::new(x, self.height(x, z), z)
    }
}

/// Builds an outdoor scene around the origin, and returns cameras at eye height.
pub(super) fn build(world: &mut World<'_>, objects: Option<usize>) -> Result<Vec<[DVec3; 2]>, Error> {
    let heaven = heaven(world.palette.assets(), &mut world.dice.fork())?;
    let dice = &mut world.dice;
    let wave = |dice: &mut super::Dice| {
        let along = Vec2::from_angle(dice.angle()) * dice.log_between(0.05, 0.35);
        (along, dice.angle(), 0.03 * dice.unit() / along.length().max(0.1))
    };
    let ground = Ground { waves: (0..6).map(|_| wave(dice)).collect(), rim: dice.between(2.0, 22.0) };
    let count = objects.unwrap_or_else(|| dice.whole(22, 42));
    let height = dice.between(1.3, 1.9);
    world.terrain(&ground)?;
    if world.dice.chance(0.45) {
        world.road(&ground)?;
    }
    let [houses, fences] = [world.dice.whole(0, 3), world.dice.whole(0, 2)];
    for _ in 0..houses {
        world.house(&ground)?;
    }
    for _ in 0..fences {
        world.fence(&ground)?;
    }
    if world.dice.chance(0.55) {
        world.wires(&ground)?;
    }
    for _ in 0..count {
        world.scatter(&ground)?;
    }
    world.meadow(&ground)?;
    world.grove(&ground)?;
    let dice = &mut world.dice;
    let scene = &mut world.palette.scene;
    scene.ambient = Some(heaven.ambient * dice.between(0.9, 1.3));
    (scene.lights, scene.sky) = (vec![heaven.sun.light(2.0 * REACH)], heaven.sky);
    Ok(world.views(CLEARANCE, |dice| {
        let away = Vec2::from_angle(dice.angle()) * dice.between(3.0, 14.0);
        let eye = ground.at(away.x, away.y) + Vec3::Y * height;
        let near = Vec2::from_angle(dice.angle()) * dice.between(0.0, 4.0);
        let target = ground.at(near.x, near.y) + Vec3::Y * (height + dice.between(-0.5, 0.6));
        [eye, target]
    }))
}

impl World<'_> {
    fn terrain(&mut self, ground: &Ground) -> Result<(), Error> {
        let stuff = self.dice.pick(&[Stuff::Grass, Stuff::Grass, Stuff::Soil, Stuff::Stone]);
        let pattern = match stuff {
            Stuff::Grass => Pattern::Grass,
            Stuff::Soil => self.dice.pick(&[Pattern::Gravel, Pattern::Plaster, Pattern::Speckle]),
            _ => self.dice.pick(&[Pattern::Bricks, Pattern::Tiles, Pattern::Gravel]),
        };
        let tile = self.dice.between(4.0, 7.0);
        let paint = self.palette.ground(pattern, stuff, tile);
        // Cells are small in the middle.
        let spread = |t: f32| {
            let t = 2.0 * t - 1.0;
            REACH * t * (0.25 + 0.75 * t * t)
        };
        let mut form = Form::default();
        let point = |s: f32, t: f32| ground.at(spread(s), -spread(t));
        form.sheet([CELLS, CELLS], false, Vec2::ONE, point, 0);
        let positions = std::mem::take(&mut form.positions);
        for face in &mut form.faces {
            face.uv = face.corners.map(|corner| {
                let at = positions[corner as usize];
                Vec2::new(at.x, -at.z)
            });
        }
        form.positions = positions;
        self.add("ground", &form, &Affine3A::IDENTITY, &[paint])
    }

    /// Adds a winding road or path.
    fn road(&mut self, ground: &Ground) -> Result<(), Error> {
        let mut dice = self.dice.fork();
        let (along, offset) = (Vec2::from_angle(dice.angle()), dice.between(-6.0, 6.0));
        let (half, bends) = (dice.between(0.7, 2.6), [dice.between(0.0, 5.0), dice.angle()]);
        let stuff = dice.pick(&[Stuff::Stone, Stuff::Soil]);
        let pattern = dice.pick(&[Pattern::Plaster, Pattern::Gravel, Pattern::Bricks, Pattern::Speckle]);
        let tile = dice.between(1.5, 3.0);
        let paint = self.palette.patterned(pattern, stuff, tile);
        let mut form = Form::default();
        let point = |s: f32, t: f32| {
            let run = 110.0 * (t - 0.5);
            let aside = offset + bends[0] * (run / 16.0 + bends[1]).sin() + half * (1.0 - 2.0 * s);
            let at = along * run + along.perp() * aside;
            // It lies on the ground's highest parts, so that no hill shows through.
            ground.at(at.x, at.y) + Vec3::Y * 0.04
        };
        form.sheet([6, 220], false, Vec2::new(2.0 * half, 110.0), point, 0);
        self.add("road", &form, &Affine3A::IDENTITY, &[paint])
    }

    /// Puts a tree, bush, rock, bench, box or other object on the ground.
    fn scatter(&mut self, ground: &Ground) -> Result<(), Error> {
        let mut dice = self.dice.fork();
        let is_tree = dice.chance(0.36);
        let (name, form, paints) = match dice.below(8) {
            _ if is_tree => {
                let is_conifer = dice.chance(0.3);
                let height = dice.between(3.0, 10.0);
                let form =
                    if is_conifer { plants::conifer(&mut dice, height) } else { plants::tree(&mut dice, height) };
                let leaves = if is_conifer { Pattern::Needles } else { Pattern::Leaves };
                ("tree", form, vec![self.palette.paint(Stuff::Bark)?, self.palette.foliage(leaves)])
            }
            0 | 1 => {
                let height = dice.between(0.5, 1.8);
                let paints = vec![self.palette.paint(Stuff::Bark)?, self.palette.foliage(Pattern::Leaves)];
                ("bush", plants::bush(&mut dice, height), paints)
            }
            2 | 3 => {
                let size = dice.log_between(0.25, 2.6);
                let form = grounded(shapes::lump(&mut dice).form, size);
                ("rock", form, vec![self.palette.paint(Stuff::Stone)?])
            }
            4 if self.palette.assets().mesh_count() > 0 => match self.model([0.6, 2.5])? {
                Some((form, paints)) => ("mesh", form, paints),
                None => return Ok(()),
            },
            4 | 5 => {
                let (form, stuff) = super::yards::post(&mut dice);
                ("post", form, self.paints(stuff, false)?)
            }
            6 => {
                let (form, stuff) = super::yards::bench(&mut dice);
                ("bench", form, self.paints(stuff, false)?)
            }
            _ => {
                let shape = shapes::any(&mut dice);
                let paints = self.paints(&[Stuff::Any, Stuff::Any], shape.is_closed)?;
                (shape.name, grounded(shape.form, dice.between(0.4, 1.5)), paints)
            }
        };
        for _ in 0..super::TRIES {
            let away = Vec2::from_angle(dice.angle()) * SITE * dice.unit().powf(0.7);
            let sink = if name == "rock" { 0.12 } else { 0.01 };
            let at = ground.at(away.x, away.y) - Vec3::Y * sink;
            if self.put(name, &form, &standing(at, dice.angle()), &paints)? {
                break;
            }
        }
        Ok(())
    }

    /// Adds distant trees of crossed quads.
    fn grove(&mut self, ground: &Ground) -> Result<(), Error> {
        let leaves = self.palette.foliage(Pattern::Crown);
        let mut form = Form::default();
        for _ in 0..self.dice.whole(10, 130) {
            let mut dice = self.dice.fork();
            let away = Vec2::from_angle(dice.angle()) * dice.between(1.6 * SITE, 0.75 * REACH);
            let height = dice.between(4.0, 11.0);
            let tree = plants::tuft(&mut dice, height);
            form.join(&tree, standing(ground.at(away.x, away.y), 0.0), 0);
        }
        if form.faces.is_empty() { Ok(()) } else { self.add("grove", &form, &Affine3A::IDENTITY, &[leaves; 2]) }
    }

    /// Adds tufts of grass and small stones, which may touch other objects.
    fn meadow(&mut self, ground: &Ground) -> Result<(), Error> {
        let leaves = self.palette.foliage(Pattern::Needles);
        let paints: [Paint; 2] = [leaves; 2];
        let count = self.dice.whole(0, 260);
        let mut form = Form::default();
        for _ in 0..count {
            let mut dice = self.dice.fork();
            let away = Vec2::from_angle(dice.angle()) * 18.0 * dice.unit().sqrt();
            let height = dice.between(0.12, 0.4);
            let tuft = plants::tuft(&mut dice, height);
            form.join(&tuft, standing(ground.at(away.x, away.y), 0.0), 0);
        }
        if count == 0 { Ok(()) } else { self.add("grass", &form, &Affine3A::IDENTITY, &paints) }
    }
}
