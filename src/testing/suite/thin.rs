//! Objects thinner than a pixel.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::PIXEL;
use crate::{
    Material, Mesh, Texture,
    random::Random,
    scene::{
        MaterialId, Scene, Sphere,
        builtin::{
            add, paint,
            shapes::{Shading, Shape},
            stage::{EYE, stage},
        },
    },
};

/// Builds ribbons, tapering slivers and chains of spheres in front of the stage's brick wall.
pub(super) fn wires() -> Scene {
    const WIRES: usize = 90;
    /// Smallest and largest width of a wire, in pixels of a picture 600 pixels wide.
    const WIDTHS: [f32; 2] = [0.2, 0.9];
    const DISTANCES: [f32; 2] = [4.2, 10.0];
    let mut scene = stage();
    let colors =
        [[20, 22, 28], [240, 236, 220], [205, 60, 40], [40, 90, 170]].map(|srgb| paint(&mut scene, "wire", srgb));
    let mut random = Random(61);
    for wire in 0..WIRES {
        let distance = random.between(DISTANCES[0], DISTANCES[1]);
        let width = random.between(WIDTHS[0], WIDTHS[1]) * PIXEL * distance;
        let color = colors[wire / 3 % colors.len()];
        // The picture is as wide as the distance of the plane.
        let middle = Vec3::new(random.between(-0.48, 0.48), random.between(-0.2, 0.3), -1.0) * distance;
        // Half of the wires are upright, and half are slanted.
        let lean = if wire % 2 == 0 { 0.0 } else { random.between(-0.9, 0.9) };
        let along = Vec3::new(lean.sin(), lean.cos(), random.between(-0.2, 0.2));
        let half = along * random.between(0.1, 0.3) * distance;
        let across = Vec3::new(lean.cos(), -lean.sin(), 0.0) * (0.5 * width);
        let [low, high] = [middle - half, middle + half];
        if wire % 3 == 2 {
            chain(&mut scene, [EYE + low, EYE + high], 0.5 * width, color);
            continue;
        }
        let mut shape = Shape::new(format!("wire {wire}"), EYE);
        let tip = if wire % 3 == 0 { across } else { Vec3::ZERO };
        shape.quad([low - across, low + across, high + tip, high - tip], color);
        add(&mut scene, shape);
    }
    scene
}

/// Adds a row of spheres with gaps of a radius.
fn chain(scene: &mut Scene, [from, to]: [Vec3; 2], radius: f32, material: MaterialId) {
    let count = (from.distance(to) / (3.0 * radius)) as usize;
    for bead in 0..count {
        let center = from.lerp(to, bead as f32 / count as f32);
        scene.add_sphere(Sphere::new(center, radius, material)).expect("a bead has a radius");
    }
}

/// Builds strands that leave a sphere along its normals and bend down.
pub(super) fn hair() -> Scene {
    const STRANDS: usize = 5000;
    const SEGMENTS: usize = 5;
    const RADIUS: f32 = 1.05;
    const CENTER: Vec3 = Vec3::new(0.0, 0.1, -5.2);
    /// Smallest and largest width of a strand at the sphere's distance, in pixels of a picture 600 pixels wide.
    const WIDTHS: [f32; 2] = [0.1, 0.5];
    const GOLDEN_ANGLE: f32 = 2.399_963_2;
    let mut scene = stage();
    let skin = paint(&mut scene, "ball", [196, 150, 120]);
    let tones =
        [[60, 34, 20], [120, 74, 36], [206, 160, 84], [232, 204, 150]].map(|srgb| paint(&mut scene, "hair", srgb));
    let mut ball = Shape::new("ball", EYE + CENTER);
    let meridian = |t: f32| Vec2::new(RADIUS * (PI * t).sin(), -RADIUS * (PI * t).cos());
    ball.lathe([48, 24], meridian, |_, _| skin);
    add(&mut scene, ball);

    let mut random = Random(5);
    // The hair is one object, as in a scan, so object ids can't distinguish strands.
    let mut hair = Shape::new("hair", EYE + CENTER);
    for strand in 0..STRANDS {
        // Roots are spread evenly over the sphere: equal steps in height, and the golden angle around.
        let y = 1.0 - 2.0 * (strand as f32 + 0.5) / STRANDS as f32;
        let (sin, cos) = ((strand as f32 * GOLDEN_ANGLE) % TAU).sin_cos();
        let ring = (1.0 - y * y).sqrt();
        let normal = Vec3::new(ring * cos, y, ring * sin);
        let length = random.between(0.3, 0.8);
        let bend = random.between(0.2, 0.6);
        let curl = Vec3::new(random.between(-0.2, 0.2), 0.0, random.between(-0.2, 0.2));
        let half_width = 0.5 * PIXEL * -CENTER.z * random.between(WIDTHS[0], WIDTHS[1]);
        let across = Vec3::new(normal.y, -normal.x, 0.0).normalize_or(Vec3::X) * half_width;
        let tone = tones[(random.unit() * tones.len() as f32) as usize];
        let point = |s: f32, t: f32| {
            let root = normal * (RADIUS + length * t);
            root + (curl - Vec3::Y * bend) * (length * t * t) + across * (2.0 * s - 1.0)
        };
        hair.sheet([1, SEGMENTS], Shading::Flat, point, |_, _| tone);
    }
    add(&mut scene, hair);
    scene
}

/// Builds three tree crowns over the stage's floor: squares with leaf-shaped cut-outs.
pub(super) fn foliage() -> Scene {
    const SQUARES: usize = 130;
    const MASKS: usize = 3;
    const CROWNS: [[f32; 3]; 3] = [[-1.7, 2.6, -6.5], [0.4, 3.0, -8.0], [2.2, 2.5, -6.8]];
    let mut scene = stage();
    let bark = paint(&mut scene, "bark", [96, 72, 52]);
    let mut random = Random(17);
    let leaves: Vec<MaterialId> = (0..MASKS)
        .map(|mask| {
            let texture = scene.add_texture(leaf_mask(&mut random));
            let green = Vec3::new(0.10 + 0.05 * mask as f32, 0.32, 0.07);
            scene.add_material(Material::new(green).name("leaves").cutout(texture))
        })
        .collect();
    for (crown, center) in CROWNS.map(Vec3::from_array).into_iter().enumerate() {
        let mut trunk = Shape::new(format!("trunk {crown}"), Vec3::new(center.x, 0.0, center.z));
        trunk.lathe([12, 4], |t| Vec2::new(0.12 - 0.05 * t, center.y * t), |_, _| bark);
        add(&mut scene, trunk);
        for square in 0..SQUARES {
            let mut vector = |half: f32| Vec3::from_array([(); 3].map(|()| random.between(-half, half)));
            let middle = center + vector(0.75);
            let right = vector(1.0).normalize_or(Vec3::X) * 0.3;
            let up = vector(1.0).cross(right).normalize_or(Vec3::Y) * 0.3;
            let corners = [-right - up, right - up, right + up, up - right].map(|corner| middle + corner);
            let [a, b, c, d] = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
            let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).name(format!("leaves {crown}"));
            let mesh = mesh.materials(vec![leaves[square % MASKS]]).uv(vec![[a, b, c], [a, c, d]]);
            scene.add_mesh(&mesh).expect("a square has as many texture coordinates as corners");
        }
    }
    scene
}

/// Returns a mask of 96x96 pixels that contains slender leaves.
fn leaf_mask(random: &mut Random) -> Texture {
    const SIDE: usize = 96;
    const LEAVES: usize = 40;
    let mut pixels = vec![[255, 255, 255, 0]; SIDE * SIDE];
    for _ in 0..LEAVES {
        let middle = Vec2::new(random.between(0.05, 0.95), random.between(0.05, 0.95)) * SIDE as f32;
        let along = Vec2::from_angle(random.between(0.0, TAU));
        let (length, width) = (random.between(6.0, 12.0), random.between(1.0, 3.0));
        for (index, pixel) in pixels.iter_mut().enumerate() {
            let from = Vec2::new((index % SIDE) as f32 + 0.5, (index / SIDE) as f32 + 0.5) - middle;
            let (along, across) = (from.dot(along) / length, from.perp_dot(along) / width);
            if along * along + across * across < 1.0 {
                pixel[3] = 255;
            }
        }
    }
    Texture::image(SIDE as u32, SIDE as u32, pixels).expect("as many pixels as the sides say")
}

/// Builds cables between posts on both sides of a street, and across it.
pub(super) fn cables() -> Scene {
    const SPANS: usize = 5;
    const LINES: usize = 4;
    const POST: f32 = 2.1;
    const HEIGHT: f32 = 3.6;
    /// Radii of the cables. At distance 8 the stage's pixels of 600 are 0.0133 units wide.
    const RADII: [f32; 2] = [0.001, 0.006];
    let mut scene = stage();
    let wood = paint(&mut scene, "post", [110, 90, 70]);
    let black = paint(&mut scene, "cable", [26, 26, 30]);
    let walls = [[150, 140, 128], [120, 126, 140]].map(|srgb| paint(&mut scene, "house", srgb));
    for (house, x) in [-4.6, 4.6].into_iter().enumerate() {
        let mut shape = Shape::new(format!("house {house}"), Vec3::new(x, 0.0, -8.0));
        shape.cuboid(Vec3::new(-1.2, 0.0, -3.0), Vec3::new(1.2, 3.0, 3.0), walls[house]);
        add(&mut scene, shape);
    }
    let mut random = Random(29);
    let place = |side: f32, span: usize| Vec3::new(side * POST, HEIGHT, -3.0 - 8.0 * span as f32 / SPANS as f32);
    for span in 0..=SPANS {
        for side in [-1.0, 1.0] {
            let top = place(side, span);
            let mut post = Shape::new("post", Vec3::new(top.x, 0.0, top.z));
            post.lathe([8, 1], |t| Vec2::new(0.05, (HEIGHT + 0.1) * t), |_, _| wood);
            add(&mut scene, post);
            let mut radius = || random.between(RADII[0], RADII[1]);
            for line in 0..LINES {
                let aside = Vec3::new(0.12 * line as f32 - 0.18, 0.0, 0.0);
                if span < SPANS {
                    cable(&mut scene, [top + aside, place(side, span + 1) + aside], radius(), black);
                }
                if side < 0.0 {
                    let below = -0.1 * (1 + line) as f32 * Vec3::Y;
                    let along = Vec3::new(0.0, 0.0, -0.3 * line as f32);
                    cable(&mut scene, [top + below, place(1.0, span) + below + along], radius(), black);
                }
            }
        }
    }
    scene
}

/// Adds a six-sided tube that hangs between two points.
fn cable(scene: &mut Scene, [from, to]: [Vec3; 2], radius: f32, material: MaterialId) {
    const SAG: f32 = 0.3;
    let across = (to - from).cross(Vec3::Y).normalize_or(Vec3::X);
    let point = |s: f32, t: f32| {
        let (sin, cos) = ((TAU * s) % TAU).sin_cos();
        from.lerp(to, t) + radius * (cos * across + sin * Vec3::Y) - Vec3::Y * (4.0 * SAG * t * (1.0 - t))
    };
    let mut shape = Shape::new("cable", Vec3::ZERO);
    shape.sheet([6, 12], Shading::Flat, point, |_, _| material);
    add(scene, shape);
}

/// Builds a plate with fins and bars, like a technical drawing.
pub(super) fn strips() -> Scene {
    const FINS: usize = 36;
    const BARS: usize = 40;
    let mut scene = stage();
    let steel = paint(&mut scene, "plate", [176, 182, 190]);
    let brass = paint(&mut scene, "strip", [200, 170, 90]);
    let mut random = Random(43);
    // Maps a point to the plate that leans against the wall: x along it, y up along it, z above it.
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, 0.6 + 0.8 * y + 0.6 * z, -8.0 - 0.6 * y + 0.8 * z);
    let block = |shape: &mut Shape, low: Vec3, high: Vec3, material: MaterialId| {
        let corner = |bits: usize| {
            let pick = |axis: usize| if bits >> axis & 1 == 0 { low[axis] } else { high[axis] };
            at(pick(0), pick(1), pick(2))
        };
        for sides in [[0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5]] {
            shape.quad(sides.map(corner), material);
        }
    };
    let mut part = Shape::new("part", Vec3::ZERO);
    block(&mut part, Vec3::new(-3.0, 0.0, -0.1), Vec3::new(3.0, 3.2, 0.0), steel);
    // The fins are upright on the plate.
    for fin in 0..FINS {
        let x = -2.8 + 3.4 * fin as f32 / FINS as f32;
        let (width, height) = (random.between(0.002, 0.02), random.between(0.05, 0.25));
        block(&mut part, Vec3::new(x, 0.2, 0.0), Vec3::new(x + width, 1.6, height), steel);
    }
    // Bars run up the plate, each on two feet.
    for bar in 0..BARS {
        let x = 0.8 + 2.1 * bar as f32 / BARS as f32;
        let (width, height) = (random.between(0.001, 0.012), random.between(0.1, 0.6));
        let [low, high] = [0.2, if bar % 2 == 0 { 3.0 } else { 2.0 }];
        block(&mut part, Vec3::new(x, low, height), Vec3::new(x + width, high, height + 0.01), brass);
        for y in [low, high - 0.03] {
            block(&mut part, Vec3::new(x, y, 0.0), Vec3::new(x + width, y + 0.03, height), brass);
        }
    }
    add(&mut scene, part);
    scene
}
