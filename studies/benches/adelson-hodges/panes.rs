//! Builds scenes of panes that fill the view, in front of the eyes and behind them. Every ray follows the paper's worst
//! case down to the last level.

use stereotrace::{
    Finish, Light, Material, Mesh, Scene, StereoCamera,
    glam::{Vec2, Vec3},
};

use crate::{closed::Surfaces, counts::LEVELS};

/// Distance of the first pane in front of the eyes, in screen distances. The panes behind the eyes start at half of it.
const FIRST: f32 = 2.0;
/// Half a pane's side. Panes are so large that no ray leaves the space between two of them within `LEVELS` levels.
const HALF_SIDE: f32 = 12.0;

/// Builds the scene. There are `lights` lights on either side of all panes, so each hit has this number of lights in
/// front of it.
pub(crate) fn scene(surfaces: Surfaces, lights: usize) -> Scene {
    let mut scene = Scene::new();
    let glass = Finish::Glass { index: 1.0, transmission: Vec3::splat(0.75), fresnel: false };
    let finish = [Finish::Matte, Finish::Mirror { fresnel: false }, glass][surfaces.sent() as usize];
    let albedo = Vec3::splat(if surfaces.is_diffuse() { 0.1 } else { 0.0 });
    let pane = scene.add_material(Material::new(albedo).specular(Vec3::splat(0.5)).finish(finish));
    let before = if surfaces == Surfaces::Misses { 0 } else { LEVELS + 1 };
    let depths = (0..before).map(|index| -FIRST - index as f32).chain((0..=LEVELS).map(|index| 1.0 + index as f32));
    for z in depths {
        let corner = |x: f32, y: f32| (HALF_SIDE * Vec2::new(x, y)).extend(z);
        let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let mesh = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).materials(vec![pane]).name("pane");
        scene.add_mesh(&mesh).expect("a pane's lists fit each other");
    }
    if surfaces.is_diffuse() {
        let light = |index: usize, z: f32| Light::point(Vec3::new(index as f32, 3.0, z), Vec3::splat(0.2));
        scene.lights = (0..lights).flat_map(|index| [light(index, -100.0), light(index, 100.0)]).collect();
    }
    scene
}

pub(crate) fn camera(side: u32, e_px: f32) -> StereoCamera {
    let camera = StereoCamera::look_at(Vec3::ZERO, Vec3::NEG_Z).screen_distance(1.0).screen_width(1.0);
    camera.size(side, side).interaxial_pixels(e_px)
}
