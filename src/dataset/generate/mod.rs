//! Generates the scenes of a data set from random values: rooms, floating objects and outdoor scenes.
//!
//! A scene depends only on the spec, the user's folders and the item's draws.

mod assets;
mod clutter;
mod dice;
mod floating;
mod form;
mod furniture;
mod materials;
mod noise;
mod outdoors;
mod placing;
mod plants;
mod rooms;
mod shapes;
mod shell;
mod skies;
mod textures;
mod yards;

pub(super) use assets::Assets;

use glam::{Affine3A, DVec3, Quat, Vec3};

use self::{
    dice::Dice,
    form::Form,
    materials::{Paint, Palette, Stuff},
    placing::{Placed, Solid},
};
use super::{
    draws::Draws,
    spec::{Generate, SceneKind},
};
use crate::{Error, Material, Scene, StereoCamera, TextureId};

/// Version of the generator. It changes whenever the scenes of a spec change.
pub(super) const VERSION: u32 = 1;
/// Number of cameras that a scene proposes.
const VIEWS: usize = 60;
/// Smallest number of objects in a view, if the scene has enough of them, and the cosine of the view's half angle.
const FEWEST: usize = 6;
const CONE: f32 = 0.87;
/// Number of attempts to find a free place for an object.
const TRIES: usize = 12;
/// Maximum number of objects that a spec may ask for.
pub(super) const MOST_OBJECTS: u32 = 200;

/// A generated scene.
pub(super) struct Generated {
    pub(super) scene: Scene,
    /// A camera with the scene's field of view and interaxial, at the first of the views.
    pub(super) camera: StereoCamera,
    /// Eye and target of cameras in free space, world positions.
    pub(super) views: Vec<[DVec3; 2]>,
    /// For each object, whether it can move. Walls, the ground and grass stay.
    pub(super) can_move: Vec<bool>,
}

/// Shares of objects with special materials, 0 to 1.
#[derive(Clone, Copy, Debug)]
struct Shares {
    metals: f32,
    glass: f32,
    mirrors: f32,
    /// Share of surfaces that have one colour in place of a pattern.
    plain: f32,
}

/// A scene under construction.
struct World<'a> {
    palette: Palette<'a>,
    placed: Placed,
    dice: Dice,
    /// Size range of the user's meshes in metres.
    mesh_size: [f32; 2],
    /// High corner of the room, whose low corner is the origin.
    limits: Vec3,
    /// For each object, whether it can move.
    can_move: Vec<bool>,
}

/// Generates the scene of an item.
pub(super) fn generate(options: &Generate, assets: &Assets, draws: &Draws) -> Result<Generated, Error> {
    let share = |value, name: &str| draws.draw(value, &format!("generate.{name}")) as f32;
    let shares = Shares {
        metals: share(&options.metals, "metals"),
        glass: share(&options.glass, "glass"),
        mirrors: share(&options.mirrors, "mirrors"),
        plain: options.plain.as_ref().map_or(0.0, |plain| share(plain, "plain")),
    };
    let objects = options.objects.as_ref().map(|objects| draws.draw(objects, "generate.objects") as usize);
    let size = options.mesh_size.as_ref().map(|size| draws.draw(size, "generate.mesh_size") as f32);
    let mut world = World {
        palette: Palette::new(assets, shares, Dice::new(draws, "generate.materials")),
        placed: Placed::default(),
        dice: Dice::new(draws, "generate.scene"),
        mesh_size: size.map_or([0.0; 2], |size| [size; 2]),
        limits: Vec3::INFINITY,
        can_move: Vec::new(),
    };
    let views = match options.kind {
        SceneKind::Rooms => rooms::build(&mut world, objects)?,
        SceneKind::Floating => floating::build(&mut world, objects)?,
        SceneKind::Outdoors => outdoors::build(&mut world, objects)?,
    };
    let [eye, target] = views.first().copied().unwrap_or([DVec3::ZERO, -DVec3::Z]);
    let mut dice = Dice::new(draws, "generate.camera");
    let [low, high] = match options.kind {
        SceneKind::Rooms => [0.05, 0.16],
        SceneKind::Floating => [0.08, 0.35],
        SceneKind::Outdoors => [0.08, 0.4],
    };
    let camera = StereoCamera::look_at(eye, target)
        .vertical_fov_degrees(dice.between(40.0, 64.0))
        .interaxial(dice.log_between(low, high))
        .screen_distance(f32::INFINITY);
    Ok(Generated { scene: world.palette.scene, camera, views, can_move: world.can_move })
}

impl World<'_> {
    /// Adds a part of the surroundings, without a test for overlap.
    fn add(&mut self, name: &str, form: &Form, transform: &Affine3A, paints: &[Paint]) -> Result<(), Error> {
        self.can_move.push(false);
        self.palette.scene.add_mesh(&form.mesh(name, transform, paints))
    }

    /// Adds an object that can move, if it overlaps no other one. Returns whether it was added.
    fn put(&mut self, name: &str, form: &Form, transform: &Affine3A, paints: &[Paint]) -> Result<bool, Error> {
        let solid = Solid::of(form, transform);
        let is_free = self.placed.is_free(&solid);
        if is_free {
            self.can_move.push(true);
            self.palette.scene.add_mesh(&form.mesh(name, transform, paints))?;
            self.placed.solids.push(solid);
        }
        Ok(is_free)
    }

    /// Returns paints for the slots of an object.
    fn paints(&mut self, stuff: &[Stuff], is_closed: bool) -> Result<Vec<Paint>, Error> {
        stuff.iter().map(|&stuff| self.palette.object(stuff, is_closed)).collect()
    }

    /// Returns one of the user's meshes with its paints, scaled to a size between these limits in metres. A size in
    /// the spec replaces the limits.
    fn model(&mut self, usual: [f32; 2]) -> Result<Option<(Form, Vec<Paint>)>, Error> {
        let count = self.palette.assets().mesh_count();
        if count == 0 {
            return Ok(None);
        }
        let model = self.palette.assets().mesh(self.dice.below(count))?;
        let [low, high] = if self.mesh_size[0] > 0.0 { self.mesh_size } else { usual };
        let size = self.dice.log_between(low, high);
        let first = self.palette.scene.textures().len() as u32;
        for texture in &model.textures {
            self.palette.scene.add_texture(texture.clone());
        }
        let moved = |id: Option<TextureId>| id.map(|TextureId(id)| TextureId(first + id));
        let paints = model
            .materials
            .iter()
            .map(|own| {
                let (texture, cutout) = (moved(own.texture), moved(own.cutout));
                self.palette.given(Material { texture, cutout, ..own.clone() })
            })
            .collect();
        let mut form = model.form.clone();
        form.positions.iter_mut().for_each(|at| *at *= size);
        Ok(Some((form, paints)))
    }

    /// Returns cameras whose eyes are apart from all objects. `draw` returns an eye and a target.
    fn views(&mut self, clearance: f32, mut draw: impl FnMut(&mut Dice) -> [Vec3; 2]) -> Vec<[DVec3; 2]> {
        let mut found = Vec::new();
        for _ in 0..20 * VIEWS {
            let [eye, target] = draw(&mut self.dice);
            let is_free = !self.placed.solids.iter().any(|solid| solid.is_within(eye, clearance));
            if is_free
                && eye.distance(target) > 0.5
                && self.shown(eye, target) >= FEWEST.min(self.placed.solids.len() / 5)
            {
                found.push([eye.as_dvec3(), target.as_dvec3()]);
            }
            if found.len() == VIEWS {
                break;
            }
        }
        found
    }

    /// Returns the number of objects whose middle is within a cone about the view direction.
    fn shown(&self, eye: Vec3, target: Vec3) -> usize {
        let forward = (target - eye).normalize_or_zero();
        let is_shown = |solid: &&Solid| {
            let to = solid.low.midpoint(solid.high) - eye;
            to.normalize_or_zero().dot(forward) > CONE
        };
        self.placed.solids.iter().filter(is_shown).count()
    }
}

/// Returns the transform of an object that stands upright at a place, turned about the y axis.
fn standing(at: Vec3, turn: f32) -> Affine3A {
    Affine3A::from_rotation_translation(Quat::from_rotation_y(turn), at)
}

#[cfg(test)]
mod tests;
