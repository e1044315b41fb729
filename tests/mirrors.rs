//! Mirrors, glass and veils against a plain tracer in double precision, closed forms, and `Naive` of the same run.

mod common;

use common::gpu;
use stereotrace::{
    Finish, MAX_BOUNCES, Material, MaterialId, Mesh, Method, Options, RaysPerLane, Renderer, Scene, Sky, Sphere,
    StereoCamera, StereoPair, Traversal,
    glam::{DVec3, Vec3},
    scene::builtin::Builtin,
};

/// The wall behind everything: its colour says where it is hit, red from left to right and green from below.
const WALL_Z: f32 = -4.0;
const WALL_HALF: f32 = 6.0;
const SKY: Vec3 = Vec3::new(0.1, 0.2, 0.6);

#[derive(Clone, Copy)]
struct Ball {
    center: DVec3,
    radius: f64,
    finish: Finish,
    specular: f64,
}

fn glass(index: f32, fresnel: bool) -> Finish {
    Finish::Glass { index, transmission: Vec3::ONE, fresnel }
}

fn scene_of(balls: &[Ball]) -> Scene {
    let mut scene = Scene::new();
    let white = scene.add_material(Material::new(Vec3::ONE));
    let corner = |x: f32, y: f32| Vec3::new(x * WALL_HALF, y * WALL_HALF, WALL_Z);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let color = |index: u32| Vec3::new(f32::from(u8::from([1, 2].contains(&index))), f32::from(u8::from(index > 1)), 0.3);
    let colors = triangles.iter().map(|triangle: &[u32; 3]| triangle.map(color)).collect();
    scene.add_mesh(&Mesh::new(corners, triangles).materials(vec![white]).colors(colors)).unwrap();
    for ball in balls {
        let material = Material::new(Vec3::ZERO).specular(Vec3::splat(ball.specular as f32)).finish(ball.finish);
        let material = scene.add_material(material);
        scene.add_sphere(Sphere::new(ball.center.as_vec3(), ball.radius as f32, material)).unwrap();
    }
    scene.sky = Sky::Constant(SKY);
    scene
}

fn camera() -> StereoCamera {
    StereoCamera::look_at(Vec3::new(0.3, 0.2, 6.0), Vec3::ZERO).size(96, 72).interaxial_pixels(6.0)
}

/// What comes along a ray, with so many bounces left.
fn seen(balls: &[Ball], origin: DVec3, direction: DVec3, left: u32) -> DVec3 {
    let hit_of = |ball: &Ball| {
        let to = origin - ball.center;
        let (b, c) = (to.dot(direction), to.length_squared() - ball.radius * ball.radius);
        let root = (b * b - c).sqrt();
        [-b - root, -b + root].into_iter().find(|t| *t > 1e-6).unwrap_or(f64::INFINITY)
    };
    let wall = (f64::from(WALL_Z) - origin.z) / direction.z;
    let at = origin + direction * wall;
    let half = f64::from(WALL_HALF);
    let wall = if wall > 0.0 && at.x.abs().max(at.y.abs()) < half { wall } else { f64::INFINITY };
    let nearest = balls.iter().map(|ball| (hit_of(ball), ball)).min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((t, ball)) = nearest.filter(|(t, _)| *t < wall) else {
        let color = DVec3::new(0.5 + 0.5 * at.x / half, 0.5 + 0.5 * at.y / half, 0.3);
        return if wall.is_finite() { color } else { SKY.as_dvec3() };
    };
    if left == 0 {
        return DVec3::ZERO;
    }
    let point = origin + direction * t;
    let outward = (point - ball.center).normalize();
    let entering = outward.dot(direction) < 0.0;
    let normal = if entering { outward } else { -outward };
    let mirrored = || seen(balls, point, direction.reflect(normal), left - 1);
    match ball.finish {
        Finish::Mirror { fresnel } => {
            let cosine = -normal.dot(direction);
            let grazing = if fresnel { (1.0 - ball.specular) * (1.0 - cosine).powi(5) } else { 0.0 };
            mirrored() * (ball.specular + grazing)
        }
        Finish::Glass { index, fresnel, .. } => {
            let (from, to) = if entering { (1.0, f64::from(index)) } else { (f64::from(index), 1.0) };
            let angle = (-normal.dot(direction)).acos();
            let sine = from / to * angle.sin();
            if sine >= 1.0 {
                return mirrored();
            }
            let inner = sine.asin();
            // Fresnel's sine and tangent laws; straight on they have a limit.
            let back = match angle < 1e-4 {
                true => ((from - to) / (from + to)).powi(2),
                false => {
                    let across = ((angle - inner).sin() / (angle + inner).sin()).powi(2);
                    0.5 * (across + ((angle - inner).tan() / (angle + inner).tan()).powi(2))
                }
            };
            let (reflected, passed) =
                if fresnel { (ball.specular * back, 1.0 - back) } else { (ball.specular, 1.0 - ball.specular) };
            let along = (direction + normal * angle.cos()).normalize_or_zero();
            let bent = along * inner.sin() - normal * inner.cos();
            mirrored() * reflected + seen(balls, point, bent, left - 1) * passed
        }
        _ => unreachable!(),
    }
}

fn render(scene: &Scene, camera: &StereoCamera, options: Options) -> StereoPair {
    let mut renderer = Renderer::new(gpu());
    let uploaded = renderer.upload(scene).unwrap();
    renderer.render(&uploaded, camera, &options.linear(true)).unwrap()
}

#[test]
fn balls_send_on_what_a_tracer_in_double_precision_sees() {
    let ball = |x: f64, y: f64, z: f64, radius: f64, finish, specular| Ball {
        center: DVec3::new(x, y, z),
        radius,
        finish,
        specular,
    };
    let balls = [
        ball(-1.6, 0.7, 0.0, 0.9, glass(1.5, true), 1.0),
        ball(0.5, -0.8, 0.5, 0.8, Finish::Mirror { fresnel: false }, 0.9),
        ball(1.9, 0.8, -0.5, 0.7, glass(1.33, false), 0.0),
        ball(0.2, 1.1, -1.0, 0.6, Finish::Mirror { fresnel: true }, 0.4),
        ball(-1.4, -1.3, -0.5, 0.7, glass(0.8, true), 1.0),
        ball(2.0, -1.2, 0.2, 0.5, glass(1.8, false), 0.3),
    ];
    let (scene, camera) = (scene_of(&balls), camera());
    let pose = camera.pose().unwrap();
    for bounces in [0, 1, 2, 5] {
        let pair = render(&scene, &camera, Options::new(Method::BRACKET).bounces(bounces));
        for (view, side) in [(&pair.left, -1.0), (&pair.right, 1.0)] {
            let eye = pose.eye_position(side).as_dvec3();
            let mut off = 0;
            for (index, found) in view.linear.iter().enumerate() {
                let (column, row) = ((index % 96) as f64 + 0.5, (index / 96) as f64 + 0.5);
                let screen = pose.screen_size.map(f64::from);
                let middle = pose.eye_position(0.0).as_dvec3() + pose.forward.as_dvec3() * f64::from(pose.screen_distance);
                let point = middle
                    + pose.right.as_dvec3() * (screen[0] * (column / 96.0 - 0.5))
                    + pose.up.as_dvec3() * (screen[1] * (0.5 - row / 72.0));
                let expected = seen(&balls, eye, (point - eye).normalize(), bounces);
                let [r, g, b, _] = found.map(f64::from);
                off += usize::from((DVec3::new(r, g, b) - expected).abs().max_element() > 0.004);
            }
            println!("{bounces} bounces, eye {side}: {off} of {}", view.linear.len());
            // Where a rim of something is seen by way of another ball, f32 may see past it.
            assert!(off <= 20, "{bounces} bounces, eye {side}: {off}");
        }
    }
}
