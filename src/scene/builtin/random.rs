//! Ellipsoids and spheres at random positions over a checkerboard, as in the random scenes of Adelson and Hodges 1993.

use glam::{Mat3, Quat, Vec3};

use super::{lamp, paint};
use crate::{Ellipsoid, Finish, MaterialId, Mesh, Scene, Sky, Sphere, StereoCamera, random::Random};

/// Half the sides of the box with the objects, and its centre. The floor is below it, and the camera in front of it.
const HALF_BOX: Vec3 = Vec3::new(4.5, 2.6, 3.5);
const CENTER: Vec3 = Vec3::new(0.0, 2.7, 0.0);
/// Number of the floor's squares per side.
const SQUARES: usize = 14;
const SQUARE_SIDE: f32 = 1.5;
/// Longest semi-axis, as a share of the side of the cube that each object has on average. Objects fill a tenth of the
/// box at any count.
const LONGEST: f32 = 0.36;
/// Number of attempts to find a free place. After these an object may overlap another.
const TRIES: usize = 2000;

/// A random scene: `count` spheres and ellipsoids with random rotations, which fill a box over a checkerboard.
///
/// ```
/// use stereotrace::scene::builtin::RandomObjects;
///
/// let scene = RandomObjects::new(20, 1993).sphere_share(0.4).scene();
/// assert_eq!(scene.spheres().len() + scene.ellipsoids().len(), 20);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RandomObjects {
    /// Number of objects. Each is checked against all others, so thousands take a while.
    pub count: usize,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Share of spheres, 0 to 1; their number is exact up to rounding. The rest are ellipsoids.
    pub sphere_share: f32,
    /// Share of mirrors. Mirrors and glass make up 0 to 1 together; the other objects are diffuse. The materials' names
    /// are `reflective`, `refractive` and `diffuse`.
    pub reflective_share: f32,
    /// Share of glass objects, see `reflective_share`.
    pub refractive_share: f32,
}

impl RandomObjects {
    /// Makes a scene of `count` diffuse ellipsoids.
    pub fn new(count: usize, seed: u32) -> Self {
        Self { count, seed, sphere_share: 0.0, reflective_share: 0.0, refractive_share: 0.0 }
    }

    /// Sets the share of spheres, 0 to 1.
    pub fn sphere_share(mut self, share: f32) -> Self {
        self.sphere_share = share;
        self
    }

    /// Sets the shares of reflective and refractive objects, 0 to 1 together.
    pub fn shares(mut self, reflective: f32, refractive: f32) -> Self {
        (self.reflective_share, self.refractive_share) = (reflective, refractive);
        self
    }

    /// Builds the scene. Each call gives the same scene. The objects' places do not depend on the shares of materials.
    pub fn scene(self) -> Scene {
        const PALETTE: [[u8; 3]; 8] = [
            [200, 60, 60],
            [235, 140, 50],
            [240, 205, 90],
            [110, 170, 90],
            [50, 140, 140],
            [70, 130, 200],
            [120, 90, 170],
            [225, 220, 205],
        ];
        let mut scene = Scene::new();
        scene.sky = Sky::Gradient { nadir: Vec3::new(0.45, 0.45, 0.42), zenith: Vec3::new(0.16, 0.28, 0.52) };
        add_floor(&mut scene);
        let glass = Finish::Glass { index: 1.5, transmission: Vec3::splat(0.95), fresnel: true };
        let kinds = [
            ("reflective", Finish::Mirror { fresnel: false }, 0.7),
            ("refractive", glass, 0.95),
            ("diffuse", Finish::Matte, 0.0),
        ];
        let materials = kinds.map(|(kind, finish, specular)| {
            PALETTE.map(|color| {
                let id = paint(&mut scene, kind, color);
                let material = &mut scene.materials[id.0 as usize];
                if finish != Finish::Matte {
                    material.albedo *= if specular < 0.9 { 0.3 } else { 0.05 };
                }
                (material.specular, material.finish) = (Vec3::splat(specular), finish);
                id
            })
        });
        // The seed is hashed. Otherwise consecutive seeds would share all numbers but one.
        let mut random = Random(crate::random::pcg(self.seed));
        let spheres = (self.sphere_share.clamp(0.0, 1.0) * self.count as f32).round() as usize;
        let mut placed = Vec::with_capacity(self.count);
        for index in 0..self.count {
            let (center, longest) = self.place(&mut random, &placed);
            placed.push((center, longest));
            let radii = Vec3::new(longest, longest * random.between(0.3, 0.8), longest * random.between(0.3, 0.8));
            let turn = Mat3::from_quat(random_turn(&mut random));
            let kind = match random.unit() {
                unit if unit < self.reflective_share => 0,
                unit if unit < self.reflective_share + self.refractive_share => 1,
                _ => 2,
            };
            let material = materials[kind][(random.unit() * PALETTE.len() as f32) as usize];
            let added = match index < spheres {
                true => scene.add_sphere(Sphere::new(center, 0.7 * longest, material)),
                false => scene.add_ellipsoid(Ellipsoid::new(center, turn * Mat3::from_diagonal(radii), material)),
            };
            added.expect("sizes are above 0 and centres finite");
        }
        scene.ambient = Some(Vec3::splat(0.15));
        scene.lights = vec![
            lamp([-7.0, 11.0, 9.0], 0.5, [1.0, 0.95, 0.88]),
            lamp([9.0, 8.0, 7.0], 0.25, [1.0, 0.93, 0.85]),
            lamp([-10.0, 5.0, 4.0], 0.15, [0.8, 0.88, 1.0]),
            lamp([2.0, 14.0, -4.0], 0.1, [0.9, 0.9, 1.0]),
            lamp([0.5, 4.0, 14.0], 0.2, [1.0, 1.0, 1.0]),
        ];
        scene
    }

    /// Returns a place for another object, within the box and apart from the others, and its longest semi-axis.
    fn place(&self, random: &mut Random, placed: &[(Vec3, f32)]) -> (Vec3, f32) {
        let side = (8.0 * HALF_BOX.x * HALF_BOX.y * HALF_BOX.z / self.count as f32).cbrt();
        let longest = LONGEST * side * random.between(0.6, 1.0);
        let mut center = CENTER;
        for _ in 0..TRIES {
            let within = HALF_BOX - longest.min(HALF_BOX.min_element());
            let offset = Vec3::from_array(within.to_array().map(|half| random.between(-half, half)));
            center = CENTER + offset;
            let apart = |(other, reach): &(Vec3, f32)| other.distance(center) > longest + reach;
            if placed.iter().all(apart) {
                break;
            }
        }
        (center, longest)
    }
}

/// Returns the camera of these scenes. Its interaxial is the same as in the other built-in scenes.
pub(crate) fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.0, 4.2, 13.0), Vec3::new(0.0, 2.3, 0.0))
        .screen_distance(12.0)
        .vertical_fov_degrees(38.0)
}

/// Returns a uniformly distributed rotation: a normalised point of the 4D unit ball. The arithmetic is explicit, so
/// that every machine rounds alike.
fn random_turn(random: &mut Random) -> Quat {
    loop {
        let [x, y, z, w] = [(); 4].map(|()| random.between(-1.0, 1.0));
        let squared = x * x + y * y + z * z + w * w;
        if (0.01..1.0).contains(&squared) {
            let length = squared.sqrt();
            return Quat::from_xyzw(x / length, y / length, z / length, w / length);
        }
    }
}

/// Adds two triangles per square, in alternating materials.
fn add_floor(scene: &mut Scene) {
    let materials = [paint(scene, "light square", [215, 210, 200]), paint(scene, "dark square", [70, 75, 85])];
    let corner = |index: usize| {
        let at = |place: usize| (place as f32 - 0.5 * SQUARES as f32) * SQUARE_SIDE;
        Vec3::new(at(index % (SQUARES + 1)), 0.0, at(index / (SQUARES + 1)))
    };
    let mut triangles = Vec::new();
    let mut of_triangles: Vec<MaterialId> = Vec::new();
    for (row, column) in (0..SQUARES).flat_map(|row| (0..SQUARES).map(move |column| (row, column))) {
        let first = (row * (SQUARES + 1) + column) as u32;
        let next = first + SQUARES as u32 + 1;
        triangles.extend([[first, next, next + 1], [first, next + 1, first + 1]]);
        of_triangles.extend([materials[(row + column) % 2]; 2]);
    }
    let corners = (0..(SQUARES + 1) * (SQUARES + 1)).map(corner).collect();
    let floor = Mesh::new(corners, triangles).materials(of_triangles).name("floor");
    scene.add_mesh(&floor).expect("the floor's lists fit each other and its points are finite");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::pcg;

    #[test]
    fn objects_stand_apart_over_the_floor_and_shares_change_materials_alone() {
        for count in [0, 1, 20, 125] {
            let plain = RandomObjects::new(count, 5).sphere_share(0.4);
            let scene = plain.scene();
            assert_eq!(
                (scene.spheres().len(), scene.primitive_count()),
                (2 * count / 5, count + 2 * SQUARES * SQUARES)
            );
            let (low, high) = scene.bounds().unwrap();
            assert!(low.y == 0.0 && high.as_vec3().y < CENTER.y + HALF_BOX.y + 1e-3, "{low} {high}");
            let mixed = plain.shares(0.3, 0.3).scene();
            let shape = |scene: &Scene| -> Vec<_> {
                let ellipsoids = scene.ellipsoids().iter().map(|one| (one.center, one.axes.x_axis.length()));
                scene.spheres().iter().map(|one| (one.center, one.radius / 0.7)).chain(ellipsoids).collect()
            };
            assert_eq!(shape(&scene), shape(&mixed));
            for (index, (center, longest)) in shape(&scene).iter().enumerate() {
                let apart = |(other, reach): &(Vec3, f32)| other.distance(*center) > (longest + reach) * 0.9999;
                assert!(shape(&scene)[..index].iter().all(apart), "{count} {index}");
            }
            let of_kind = |scene: &Scene, kind: &str| {
                let materials = scene.ellipsoids().iter().map(|one| one.material);
                let materials = materials.chain(scene.spheres().iter().map(|one| one.material));
                materials.filter(|id| scene.materials()[id.0 as usize].name == kind).count()
            };
            assert_eq!((of_kind(&scene, "diffuse"), of_kind(&scene, "reflective")), (count, 0));
            let kinds = ["diffuse", "reflective", "refractive"].map(|kind| of_kind(&mixed, kind));
            assert!(
                kinds.iter().sum::<usize>() == count && (count < 20 || kinds.iter().all(|&kind| kind > count / 10))
            );
        }
    }

    #[test]
    fn the_random_scenes_never_change() {
        let words = |count, share| {
            let scene = RandomObjects::new(count, 1993).sphere_share(share).scene();
            let ellipsoids = scene.ellipsoids().iter().flat_map(|one| {
                let numbers: Vec<f32> = one.center.to_array().into_iter().chain(one.axes.to_cols_array()).collect();
                numbers.into_iter().map(f32::to_bits).chain([one.material.0]).collect::<Vec<_>>()
            });
            ellipsoids.fold(0, |hash, word| pcg(hash ^ word))
        };
        let found = [words(20, 0.4), words(1000, 0.0)];
        assert_eq!(found, [0x8f94_ccfd, 0x8214_51a6], "{found:#x?}");
    }
}
