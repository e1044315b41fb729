//! A hall with further materials: slightly reflecting marble, shining metals, spheres of glass and chrome, and lamps
//! with soft shadows.

use glam::{Vec2, Vec3};

use super::hall;
use crate::{Finish, LightShape, Material, MaterialId, Mesh, Scene, Sphere, Texture, TextureId, random::pcg};

/// Side of a marble picture on the floor, in metres and in pixels.
const SLAB: f32 = 3.2;
const SIDE: u32 = 256;
/// Radius of a lamp's globe in metres.
const GLOBE: f32 = 0.12;

/// Builds the hall with finished materials. Its floor has texture coordinates.
pub(crate) fn hall() -> Scene {
    let mut scene = hall::with_floor(with_uv);
    let marble = scene.add_texture(marble());
    let finished = scene.materials().iter().map(|material| finish(material.clone(), marble)).collect::<Vec<_>>();
    for (index, material) in (0..).zip(finished) {
        scene.set_material(MaterialId(index), material).expect("it returns no more light than it gets");
    }
    balls(&mut scene);
    for light in &mut scene.lights {
        light.shape = LightShape::Sphere { radius: GLOBE };
    }
    scene
}

/// Adds texture coordinates by projection from above.
fn with_uv(floor: Mesh) -> Mesh {
    let corner = |place: u32| {
        let at = floor.positions[place as usize];
        Vec2::new(at.x, -at.z) / SLAB
    };
    let uv = floor.triangles.iter().map(|corners| corners.map(corner)).collect();
    floor.uv(uv)
}

fn finish(material: Material, marble: TextureId) -> Material {
    let polished = Finish::Mirror { fresnel: true };
    match material.name.as_str() {
        "cream tile" | "cream tile 2" | "slate tile" | "slate tile 2" => {
            material.texture(marble).specular(Vec3::splat(0.06)).finish(polished)
        }
        "rose marble" | "sandstone" | "limestone" => material.specular(Vec3::splat(0.2)).exponent(60.0),
        "gold" | "bronze" => {
            let specular = 0.5 * material.albedo;
            Material { albedo: 0.5 * material.albedo, ..material }.specular(specular).exponent(80.0)
        }
        name if name.ends_with("glass") => material.specular(Vec3::splat(0.25)).exponent(120.0),
        _ => material,
    }
}

/// Adds spheres of glass and chrome in the aisle, where the first lamp lights them.
fn balls(scene: &mut Scene) {
    let glass = Finish::Glass { index: 1.5, transmission: Vec3::new(0.93, 0.97, 0.95), fresnel: true };
    let glass = Material::new(Vec3::ZERO).name("glass ball").specular(Vec3::splat(0.04)).finish(glass);
    let chrome = Material::new(Vec3::splat(0.03)).name("chrome").specular(Vec3::splat(0.85));
    let materials =
        [glass, chrome.finish(Finish::Mirror { fresnel: false })].map(|material| scene.add_material(material));
    for (center, radius, material) in
        [(Vec3::new(-1.0, 0.62, -8.6), 0.6, materials[0]), (Vec3::new(1.75, 0.47, -7.7), 0.45, materials[1])]
    {
        scene.add_sphere(Sphere::new(center, radius, material)).expect("its radius is above 0");
    }
}

/// Returns bright stone with darker veins, which tiles seamlessly.
fn marble() -> Texture {
    let vein = |at: Vec2| {
        // Veins are at the zeros of a wave that noise of several sizes distorts.
        let bent = (0..4).map(|octave| noise(at, 4 << octave) / (1 << octave) as f32).sum::<f32>();
        let wave = (std::f32::consts::TAU * (at.x + 2.0 * at.y) + 5.0 * bent).sin();
        (1.0 - wave.abs()).powi(6)
    };
    let pixel = |place: u32| {
        let at = Vec2::new((place % SIDE) as f32, (place / SIDE) as f32) / SIDE as f32;
        let [vein, cloud] = [vein(at), noise(at + Vec2::splat(0.37), 3)];
        let bright = 255.0 * (0.97 - 0.45 * vein - 0.12 * cloud);
        [bright, 0.99 * bright, 0.96 * bright, 255.0].map(|channel| channel as u8)
    };
    Texture::image(SIDE, SIDE, (0..SIDE * SIDE).map(pixel).collect()).expect("it has as many pixels as its sides say")
}

/// Returns smooth noise, 0 to 1, with `points` grid points per side of the picture.
fn noise(at: Vec2, points: u32) -> f32 {
    let at = at * points as f32;
    let (cell, within) = (at.floor(), at - at.floor());
    let value = |dx: u32, dy: u32| {
        let [x, y] = [(cell.x as u32 + dx) % points, (cell.y as u32 + dy) % points];
        pcg(x + 977 * y + 65_537 * points) as f32 / u32::MAX as f32
    };
    let smooth = within * within * (Vec2::splat(3.0) - 2.0 * within);
    let row = |dy: u32| value(0, dy) + (value(1, dy) - value(0, dy)) * smooth.x;
    row(0) + (row(1) - row(0)) * smooth.y
}
