//! Tests vertex colours, highlights and emission against closed forms.

use stereotrace::{
    Light, Material, Mesh, Scene, Sphere, StereoCamera,
    glam::{DVec3, Vec2, Vec3},
    testing::cpu::{Eye, Frame},
};

use super::{before, left, square, worst};

const SIZE: u32 = 96;

/// Returns the left eye, and the direction of each of its rays.
fn rays(camera: &StereoCamera) -> (DVec3, Vec<DVec3>) {
    let frame = Frame::new(&camera.pose().unwrap());
    let [width, height] = frame.size();
    let direction = |index: usize| frame.direction(Eye::Left, index % width, index / width).as_dvec3();
    (frame.eye(Eye::Left).as_dvec3(), (0..width * height).map(direction).collect())
}

#[test]
fn colours_of_vertices_are_linear_between_the_corners() {
    // Packed colours have steps of 1/1023, 1/4095 and 1/1023. A corner may be off by half a step.
    let corners = [Vec3::new(0.123, 0.456, 0.789), Vec3::new(1.0, 0.0, 0.3331), Vec3::new(0.0501, 0.9, 0.6004)];
    let positions = vec![Vec3::new(-1.2, -1.5, 0.0), Vec3::new(2.0, -1.0, 0.0), Vec3::new(-0.8, 2.5, 0.0)];
    let [a, b, c] = [0, 1, 2].map(|corner: usize| positions[corner].as_dvec3());
    for first in 0..3 {
        let order = [0, 1, 2].map(|corner| (corner + first) % 3);
        let mut scene = Scene::new();
        let white = scene.add_material(Material::new(Vec3::ONE));
        let mesh = Mesh::new(positions.clone(), vec![order.map(|corner| corner as u32)]);
        scene.add_mesh(&mesh.colors(vec![order.map(|corner| corners[corner])]).materials(vec![white])).unwrap();
        let (eye, directions) = rays(&before(SIZE));
        let error = worst(&left(&scene, &before(SIZE)), |index| {
            let point = eye - directions[index] * (eye.z / directions[index].z);
            let weight = |p: DVec3, q: DVec3| (p - point).cross(q - point).z / (b - a).cross(c - a).z;
            let weights = [weight(b, c), weight(c, a), weight(a, b)];
            let inside = weights.iter().all(|weight| *weight > 0.0);
            inside.then(|| (0..3).map(|corner| corners[corner].as_dvec3() * weights[corner]).sum())
        });
        println!("colours of vertices: {error}");
        assert!(error < 0.5 / 1023.0 + 1e-6, "{error}");
    }
}

struct Lit {
    eye: DVec3,
    light: DVec3,
    specular: DVec3,
    exponent: f64,
}

impl Lit {
    /// Returns the colour by Lambert's and Phong's formulas, under a light of intensity 1.
    fn color(&self, point: DVec3, normal: DVec3, albedo: f64) -> DVec3 {
        let [to_light, to_eye] = [self.light, self.eye].map(|end| (end - point).normalize());
        let cosine = normal.dot(to_light);
        if cosine <= 0.0 {
            return DVec3::ZERO;
        }
        let mirrored = 2.0 * cosine * normal - to_light;
        let along = mirrored.dot(to_eye);
        let highlight = if along > 0.0 { along.powf(self.exponent) } else { 0.0 };
        (DVec3::splat(albedo * cosine) + self.specular * highlight).min(DVec3::ONE)
    }
}

fn scene_of(exponent: f32, specular: Vec3, light: Vec3) -> (Scene, stereotrace::MaterialId) {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::new(Vec3::splat(0.25)).specular(specular).exponent(exponent));
    scene.ambient = Some(Vec3::ZERO);
    scene.lights = vec![Light::point(light, Vec3::ONE)];
    (scene, material)
}

#[test]
fn highlights_are_phong_s_on_planes_and_spheres() {
    let specular = Vec3::new(0.6, 0.3, 0.1);
    let camera = before(SIZE);
    let (eye, directions) = rays(&camera);
    for exponent in [0.0, 1.0, 20.0, 10000.0] {
        for light in
            [Vec3::new(0.7, -0.4, 2.0), Vec3::new(0.4, 0.3, 6.0), Vec3::new(0.2, 0.1, -2.0), Vec3::new(3.0, 0.5, 0.2)]
        {
            let lit =
                Lit { eye, light: light.as_dvec3(), specular: specular.as_dvec3(), exponent: f64::from(exponent) };
            let (mut plane, material) = scene_of(exponent, specular, light);
            let mesh = square(Vec2::ZERO, Vec2::ONE).uv(Vec::new()).materials(vec![material; 2]);
            plane.add_mesh(&mesh).unwrap();
            let on_plane = |index: usize| {
                let point = eye - directions[index] * (eye.z / directions[index].z);
                // A light behind the square does not light its front.
                Some(lit.color(point, DVec3::Z, 0.25))
            };
            let (mut round, material) = scene_of(exponent, specular, light);
            round.add_sphere(Sphere::new(Vec3::ZERO, 0.9, material)).unwrap();
            let on_sphere = |index: usize| {
                let direction = directions[index].normalize();
                let along = -eye.dot(direction);
                let root = (along * along - eye.length_squared() + 0.81).sqrt();
                let point = eye + direction * (along - root);
                let normal = point.normalize();
                // A highlight begins abruptly at the light's horizon, so points within rounding errors of the horizon
                // are left out.
                let beside = normal.dot(lit.light - point).abs() > 1e-3;
                (root > 0.1 && beside).then(|| lit.color(point, normal, 0.25))
            };
            for (name, scene, expected) in
                [("plane", &plane, &on_plane as &dyn Fn(usize) -> Option<DVec3>), ("sphere", &round, &on_sphere)]
            {
                let error = worst(&left(scene, &camera), expected);
                // With an exponent of 10000, f32 leaves 3 digits. A cosine is off by 6e-8, and so is its logarithm.
                println!("{name}, exponent {exponent}, light {light}: {error:.2e}");
                let bound = if exponent > 100.0 { 2e-3 } else { 2e-5 };
                assert!(error < bound, "{name}, exponent {exponent}, light {light}: {error}");
            }
        }
    }
}

#[test]
fn emission_adds_to_whatever_light_there_is() {
    let emission = Vec3::new(0.2, 0.05, 0.4);
    let shown = |emission: Vec3, lights: usize, ambient: f32| {
        let mut scene = Scene::new();
        let material = Material::new(Vec3::splat(0.25)).emission(emission);
        let material = scene.add_material(material);
        let mesh = square(Vec2::ZERO, Vec2::ONE).uv(Vec::new()).materials(vec![material; 2]);
        scene.add_mesh(&mesh).unwrap();
        scene.ambient = Some(Vec3::splat(ambient));
        scene.lights = vec![Light::point(Vec3::new(0.5, 0.5, 2.0), Vec3::splat(0.7)); lights];
        left(&scene, &before(16))
    };
    for (lights, ambient) in [(0, 0.0), (0, 1.0), (1, 0.1), (2, 0.0)] {
        let without = shown(Vec3::ZERO, lights, ambient);
        let error = worst(&shown(emission, lights, ambient), |index| Some(without[index] + emission.as_dvec3()));
        assert!(error < 1e-6, "{lights} lights: {error}");
    }
    // Values above white are kept, since pictures are clamped but light is not.
    assert!(shown(Vec3::splat(5.0), 1, 0.1).iter().all(|color| color.cmpge(DVec3::splat(5.0)).all()));
}
