//! A closed room of painted walls and a lamp, with balls of each kind of surface.

use stereotrace::{
    Error, Material, Mesh, Principled, Scene, Sky, Sphere, StereoCamera,
    glam::{Vec2, Vec3},
};

/// Radius of the balls, in world units.
const RADIUS: f32 = 0.32;

/// Returns the room, and a camera with a picture of this size and parallax at infinity.
pub(crate) fn room([width, height]: [u32; 2], e_px: f32) -> Result<(Scene, StereoCamera), Error> {
    let mut scene = Scene::new();
    scene.sky = Sky::Constant(Vec3::ZERO);
    for (center, sides, albedo) in [
        (Vec3::ZERO, [3.0 * Vec3::X, 3.0 * Vec3::Z], Vec3::new(0.55, 0.5, 0.45)),
        (3.0 * Vec3::Y, [3.0 * Vec3::X, 3.0 * Vec3::Z], Vec3::splat(0.75)),
        (Vec3::new(-3.0, 1.5, 0.0), [1.5 * Vec3::Y, 3.0 * Vec3::Z], Vec3::new(0.65, 0.12, 0.1)),
        (Vec3::new(3.0, 1.5, 0.0), [1.5 * Vec3::Y, 3.0 * Vec3::Z], Vec3::new(0.15, 0.45, 0.2)),
        (Vec3::new(0.0, 1.5, -3.0), [3.0 * Vec3::X, 1.5 * Vec3::Y], Vec3::splat(0.7)),
        (Vec3::new(0.0, 1.5, 3.0), [3.0 * Vec3::X, 1.5 * Vec3::Y], Vec3::splat(0.7)),
    ] {
        rectangle(&mut scene, center, sides, Material::new(albedo))?;
    }
    let lamp = Material::new(Vec3::ZERO).emission(Vec3::splat(12.0));
    rectangle(&mut scene, Vec3::new(0.0, 2.98, 0.0), [0.6 * Vec3::X, 0.6 * Vec3::Z], lamp)?;
    // From left to right smoother, from front to back: lacquer, metal, glass.
    let glass = |roughness| Principled::new(Vec3::ONE, 0.0, roughness).transmission(1.0);
    for (column, roughness) in [1.0, 0.6, 0.3, 0.1].into_iter().enumerate() {
        let rows = [
            Principled::new(Vec3::new(0.2, 0.35, 0.7), 0.0, roughness),
            Principled::new(Vec3::new(1.0, 0.77, 0.34), 1.0, roughness),
            glass(0.5 * roughness),
        ];
        for (row, surface) in rows.into_iter().enumerate() {
            let base = if row == 2 { Vec3::ONE } else { surface.base };
            let material = scene.add_material(Material::new(base).principled(surface));
            let place = Vec2::new(column as f32 - 1.5, 1.0 - row as f32);
            scene.add_sphere(Sphere::new(Vec3::new(place.x, RADIUS, place.y), RADIUS, material))?;
        }
    }
    let camera = StereoCamera::look_at(Vec3::new(0.2, 1.6, 2.9), Vec3::new(0.0, 0.7, 0.0)).vertical_fov_degrees(60.0);
    Ok((scene, camera.size(width, height).interaxial_pixels(e_px)))
}

fn rectangle(scene: &mut Scene, center: Vec3, [a, b]: [Vec3; 2], material: Material) -> Result<(), Error> {
    let corners = vec![center - a - b, center + a - b, center + a + b, center - a + b];
    let material = scene.add_material(material);
    scene.add_mesh(&Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).materials(vec![material]))
}
