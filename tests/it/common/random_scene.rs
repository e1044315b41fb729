//! Random scenes. One kind reveals wrong hits, the other kind wrong shadows.

use stereotrace::{
    Ellipsoid, Light, Material, MaterialId, Mesh, Scene, Sphere, Texture, Wrap,
    glam::{Mat3, Vec2, Vec3},
};

use super::random::Random;

/// Triangles, spheres and ellipsoids at random positions in a cube of about two units around the origin. Some triangles
/// occur twice with different ids, some have no area, some lie in one axis-aligned plane, and some are large. Each
/// sphere and ellipsoid occurs twice. Every other ellipsoid is rotated and sheared.
#[derive(Clone, Copy)]
pub(crate) struct RandomScene {
    pub seed: u32,
    pub triangles: usize,
    pub spheres: usize,
    pub ellipsoids: usize,
    /// Whether triangles have vertex normals, in random directions.
    pub smooth: bool,
    pub scale: f32,
    /// Offset that is added to each coordinate after scaling.
    pub offset: f32,
}

impl Default for RandomScene {
    fn default() -> Self {
        Self { seed: 1, triangles: 150, spheres: 20, ellipsoids: 0, smooth: false, scale: 1.0, offset: 0.0 }
    }
}

impl RandomScene {
    pub(crate) fn build(self) -> Scene {
        let mut random = Random::new(self.seed);
        let place = |point: Vec3| point * self.scale + Vec3::splat(self.offset);
        let mut scene = Scene::new();
        let corners: Vec<Vec3> = self.corners(&mut random).into_iter().map(place).collect();
        if !corners.is_empty() {
            let faces = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
            let mut mesh = Mesh::new(corners, faces);
            if self.smooth {
                mesh.normals = mesh.triangles.iter().map(|_| [(); 3].map(|()| random.point(1.0).normalize())).collect();
            }
            scene.add_mesh(&mesh).unwrap();
        }
        for _ in 0..self.spheres {
            let (center, radius) = (place(random.point(1.0)), random.between(0.02, 0.3) * self.scale);
            let sphere = Sphere::new(center, radius, MaterialId(0));
            scene.add_sphere(sphere).unwrap();
            scene.add_sphere(sphere).unwrap();
        }
        for index in 0..self.ellipsoids {
            let ellipsoid = random_ellipsoid(&mut random, index % 2 == 1, 0.4);
            let (center, axes) = (place(ellipsoid.center), ellipsoid.axes * self.scale);
            for _ in 0..2 {
                scene.add_ellipsoid(Ellipsoid::new(center, axes, MaterialId(0))).unwrap();
            }
        }
        scene
    }

    fn corners(&self, random: &mut Random) -> Vec<Vec3> {
        let mut corners = Vec::new();
        for index in 0..self.triangles {
            let at = random.point(1.0);
            let size = if index % 5 == 4 { 0.9 } else { 0.3 };
            let [a, b, c] = [(); 3].map(|()| at + random.point(size));
            match index % 10 {
                0 => corners.extend([a, b, c, c, a, b]),
                1 => corners.extend([a, a, b]),
                2 => corners.extend([a, b, c].map(|p| Vec3::new(p.x, p.y, 0.25))),
                _ => corners.extend([a, b, c]),
            }
        }
        corners
    }
}

/// Returns an ellipsoid around a point in a cube of two units, up to 20 times as long as it is thick.
pub(crate) fn random_ellipsoid(random: &mut Random, turned: bool, longest: f32) -> Ellipsoid {
    let radii = Vec3::from_array([(); 3].map(|()| longest * random.between(0.1, 1.0)));
    let axes = Mat3::from_diagonal(radii);
    let turn = Mat3::from_axis_angle(random.point(1.0).normalize(), random.between(0.0, 6.0));
    let shear = Mat3::from_cols(Vec3::X, Vec3::new(random.between(-0.5, 0.5), 1.0, 0.0), Vec3::Z);
    let axes = if turned { turn * (shear * axes) } else { axes };
    Ellipsoid::new(random.point(1.0), axes, MaterialId(0))
}

/// Returns fans of triangles that share their edges, and spheres, above a floor among four lights.
pub(crate) fn random_stage(seed: u32) -> Scene {
    let mut random = Random::new(seed);
    let mut scene = Scene::new();
    scene.add_material(Material::new(Vec3::splat(0.5)));
    let floor = [[-4.0, -1.0, -6.0], [4.0, -1.0, -6.0], [4.0, -1.0, 3.0], [-4.0, -1.0, 3.0]].map(Vec3::from_array);
    scene.add_mesh(&Mesh::new(floor.to_vec(), vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    for _ in 0..12 {
        let middle = random.point(1.5) + Vec3::NEG_Z;
        let corners: Vec<Vec3> = std::iter::once(middle).chain((0..4).map(|_| middle + random.point(0.8))).collect();
        scene.add_mesh(&Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3], [0, 3, 4]])).unwrap();
    }
    for _ in 0..6 {
        let (center, radius) = (random.point(1.5), random.between(0.1, 0.4));
        scene.add_sphere(Sphere::new(center, radius, MaterialId(0))).unwrap();
    }
    scene.ambient = Some(Vec3::splat(0.1));
    for position in [[3.0, 4.0, 2.0], [-3.0, 3.0, 1.0], [0.5, 5.0, -2.0], [0.0, 0.5, 5.0]] {
        scene.lights.push(Light::point(Vec3::from_array(position), Vec3::splat(0.4)));
    }
    scene
}

/// Returns a picture with random alpha.
pub(crate) fn random_mask(random: &mut Random, width: u32, height: u32) -> Texture {
    let pixel = |alpha: f32| [90, 160, 60, alpha as u8];
    let pixels = (0..width * height).map(|_| pixel(random.between(0.0, 256.0))).collect();
    Texture::image(width, height, pixels).unwrap()
}

/// Returns leaves above a floor, between two lights. The leaves are squares cut out by masks of every kind, whose
/// texture coordinates go far beyond 0 to 1. Some leaves have one triangle that is not cut out, and some have no
/// texture coordinates. With `spheres`, eight spheres are added.
pub(crate) fn random_foliage(seed: u32, spheres: bool) -> Scene {
    let mut random = Random::new(seed);
    let mut scene = Scene::new();
    let masks = [
        random_mask(&mut random, 7, 5),
        random_mask(&mut random, 16, 9).wrap(Wrap::Mirror),
        random_mask(&mut random, 3, 4).wrap(Wrap::Clamp),
        Texture::checkerboard(Vec3::new(0.2, 0.9, 0.1), Vec3::new(1.0, 0.2, 0.9), 5).unwrap(),
        Texture::image(1, 1, vec![[255, 255, 255, 127]]).unwrap(),
    ];
    let materials = masks.map(|mask| {
        let texture = scene.add_texture(mask);
        scene.add_material(Material::new(0.5 + 0.4 * random.point(1.0)).cutout(texture))
    });
    let floor = [[-4.0, -1.2, -6.0], [4.0, -1.2, -6.0], [4.0, -1.2, 3.0], [-4.0, -1.2, 3.0]].map(Vec3::from_array);
    scene.add_mesh(&Mesh::new(floor.to_vec(), vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    for index in 0..36 {
        let middle = random.point(1.3);
        let (right, up) = (random.point(0.5), random.point(0.5));
        let corners = [-right - up, right - up, right + up, up - right].map(|corner| middle + corner);
        let low = Vec2::new(random.between(-3.0, 3.0), random.between(-3.0, 3.0));
        let high = low + Vec2::new(random.between(0.5, 3.0), random.between(0.5, 3.0));
        let uv = [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)];
        let leaf = materials[index % 5];
        let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
        let mesh = match index % 7 {
            // The first triangle is cut out, and the second is not.
            0 => mesh.materials(vec![leaf, MaterialId(0)]),
            _ => mesh.materials(vec![leaf]),
        };
        let uv = vec![[uv[0], uv[1], uv[2]], [uv[0], uv[2], uv[3]]];
        scene.add_mesh(&if index % 9 == 8 { mesh } else { mesh.uv(uv) }).unwrap();
    }
    for _ in 0..if spheres { 8 } else { 0 } {
        let (center, radius) = (random.point(1.3), random.between(0.1, 0.3));
        scene.add_sphere(Sphere::new(center, radius, MaterialId(0))).unwrap();
    }
    scene.ambient = Some(Vec3::splat(0.1));
    for position in [[3.0, 4.0, 2.0], [-2.0, 3.0, 3.0]] {
        scene.lights.push(Light::point(Vec3::from_array(position), Vec3::splat(0.6)));
    }
    scene
}
