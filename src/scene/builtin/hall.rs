//! A vaulted hall with columns: 200,000 triangles in many layers.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::{
    add, lamp, paint,
    shapes::{Shading, Shape, torus},
};
use crate::{MaterialId, Mesh, Scene, Sky, StereoCamera, random::pcg};

/// x of the rows of columns in metres; the outermost are engaged in the walls.
const ROWS: [f32; 6] = [-12.0, -7.6, -3.2, 3.2, 7.6, 12.0];
/// Distance between columns of a row along z. The first line across the hall, at z = 0, is in the wall behind the
/// camera.
const BAY: f32 = 4.4;
const BAYS: usize = 10;
/// Height of the capitals' tops, where the arches spring, and height of the vaults above them.
const SPRINGING: f32 = 4.7;
const RISE: f32 = 2.8;

const EYE: Vec3 = Vec3::new(0.75, 1.75, -BAY + 0.45);
const TARGET: Vec3 = Vec3::new(-0.2, 2.7, -BAY - 11.5);
const SCREEN: f32 = 7.8;

/// Materials of the hall.
struct Stone {
    shafts: [MaterialId; 3],
    trim: MaterialId,
    vault: MaterialId,
    wall: MaterialId,
    dado: MaterialId,
    voussoirs: [MaterialId; 2],
    tiles: [MaterialId; 4],
    carpet: [MaterialId; 3],
    wood: MaterialId,
    bronze: MaterialId,
    gold: MaterialId,
    cloths: [MaterialId; 4],
    glass: [MaterialId; 5],
}

impl Stone {
    fn new(scene: &mut Scene) -> Self {
        let mut add = |name: &str, srgb| paint(scene, name, srgb);
        Self {
            shafts: [
                add("rose marble", [222, 188, 168]),
                add("sandstone", [228, 204, 168]),
                add("limestone", [226, 214, 190]),
            ],
            trim: add("pale stone", [238, 226, 202]),
            vault: add("plaster", [240, 230, 210]),
            wall: add("wall", [222, 198, 160]),
            dado: add("dado", [150, 92, 66]),
            voussoirs: [add("brick", [178, 84, 58]), add("voussoir", [236, 218, 184])],
            tiles: [
                add("cream tile", [224, 206, 176]),
                add("cream tile 2", [212, 192, 160]),
                add("slate tile", [92, 98, 104]),
                add("slate tile 2", [78, 84, 92]),
            ],
            carpet: [
                add("carpet", [150, 30, 36]),
                add("carpet border", [206, 160, 70]),
                add("carpet ground", [44, 48, 88]),
            ],
            wood: add("wood", [110, 70, 42]),
            bronze: add("bronze", [130, 96, 52]),
            gold: add("gold", [222, 176, 72]),
            cloths: [
                add("crimson", [178, 34, 44]),
                add("azure", [40, 82, 156]),
                add("emerald", [30, 120, 86]),
                add("violet", [106, 52, 128]),
            ],
            glass: [
                add("ruby glass", [200, 40, 50]),
                add("sapphire glass", [40, 80, 190]),
                add("amber glass", [246, 186, 60]),
                add("turquoise glass", [50, 170, 180]),
                add("lead", [60, 52, 50]),
            ],
        }
    }
}

fn row_z(line: usize) -> f32 {
    -BAY * line as f32
}

/// Returns a camera in the nave. The nearest base of a column is just beyond half the screen's distance.
pub(crate) fn camera() -> StereoCamera {
    StereoCamera::look_at(EYE, TARGET).screen_distance(SCREEN).vertical_fov_degrees(52.0)
}

pub(crate) fn scene() -> Scene {
    with_floor(|floor| floor)
}

/// Builds the scene with a changed floor. `change` is applied to the floor's mesh.
pub(crate) fn with_floor(change: impl Fn(Mesh) -> Mesh) -> Scene {
    let mut scene = Scene::new();
    let stone = Stone::new(&mut scene);
    let floor = change(floor(&stone).into_mesh());
    scene.add_mesh(&floor).expect("a shape's lists fit each other and its points are finite");
    walls(&mut scene, &stone);
    for (row, x) in ROWS.into_iter().enumerate() {
        for line in 0..=BAYS {
            let shaft = stone.shafts[(pcg((row * 31 + line) as u32) % 3) as usize];
            let mut shape = Shape::new(format!("column {row} {line}"), Vec3::new(x, 0.0, row_z(line)));
            column(&mut shape, &stone, shaft);
            add(&mut scene, shape);
        }
    }
    arches(&mut scene, &stone);
    vaults(&mut scene, &stone);
    banners(&mut scene, &stone);
    furniture(&mut scene, &stone);
    // Rays leave the hall only through rounding at a seam.
    scene.sky = Sky::Constant(Vec3::new(0.3, 0.26, 0.2));
    scene.ambient = Some(Vec3::splat(0.15));
    scene.lights = vec![
        lamp([-0.6, 3.4, -1.4], 0.35, [1.0, 0.9, 0.76]),
        lamp([1.2, 6.3, -15.4], 0.3, [1.0, 0.86, 0.66]),
        lamp([-9.8, 5.0, -11.0], 0.18, [1.0, 0.82, 0.6]),
        lamp([9.8, 5.0, -19.8], 0.17, [1.0, 0.82, 0.6]),
        lamp([-0.8, 6.2, -36.0], 0.2, [0.96, 0.92, 0.9]),
    ];
    scene
}

fn floor(stone: &Stone) -> Shape {
    const TILES: [usize; 2] = [30, 55];
    let (left, right) = (ROWS[0], ROWS[ROWS.len() - 1]);
    let far = row_z(BAYS);
    let mut floor = Shape::new("floor", Vec3::ZERO);
    floor.sheet(
        TILES,
        Shading::Flat,
        |s, t| Vec3::new(left + (right - left) * s, 0.0, far * t),
        |column, row| stone.tiles[(column + row) % 2 * 2 + (pcg((column * 977 + row) as u32) % 2) as usize],
    );
    floor
}

/// Adds walls that reach behind the vaults, with a painted dado below.
fn walls(scene: &mut Scene, stone: &Stone) {
    const DADO: f32 = 1.1;
    let (left, right) = (ROWS[0], ROWS[ROWS.len() - 1]);
    let far = row_z(BAYS);
    let top = SPRINGING + RISE + 0.3;
    let corners = [(left, 0.0), (left, far), (right, far), (right, 0.0)];
    for (side, name) in ["west", "north", "east", "south"].into_iter().enumerate() {
        let [(x0, z0), (x1, z1)] = [corners[side], corners[(side + 1) % 4]];
        let mut wall = Shape::new(format!("{name} wall"), Vec3::ZERO);
        for (low, high, material) in [(-0.1, DADO, stone.dado), (DADO, top, stone.wall)] {
            let at = |x, y, z| Vec3::new(x, y, z);
            wall.quad([at(x0, low, z0), at(x1, low, z1), at(x1, high, z1), at(x0, high, z0)], material);
        }
        add(scene, wall);
    }
}

/// Adds plinth, base, fluted shaft, capital and impost, up to the height where the arches spring.
fn column(shape: &mut Shape, stone: &Stone, shaft: MaterialId) {
    const AROUND: usize = 26;
    const BASE_TOP: f32 = 0.62;
    const SHAFT_TOP: f32 = 3.75;
    let trim = |_: usize, _: usize| stone.trim;
    let slab = |shape: &mut Shape, half: f32, low: f32, high: f32| {
        shape.cuboid(Vec3::new(-half, low, -half), Vec3::new(half, high, half), stone.trim);
    };
    slab(shape, 0.48, -0.1, 0.26);
    shape.lathe([AROUND, 6], torus(0.36, 0.26, 0.1), trim);
    shape.lathe([AROUND, 4], torus(0.35, 0.46, 0.06), trim);
    shape.lathe([AROUND, 1], |t| Vec2::new(0.37 - 0.02 * t, 0.57 + 0.05 * t), trim);
    // The taper increases with height (entasis).
    let profile = |t: f32| Vec2::new(0.345 - 0.06 * t * t, BASE_TOP + (SHAFT_TOP - BASE_TOP) * t);
    shape.fluted_shaft([18, 4, 4], 0.03, profile, shaft);
    shape.lathe([AROUND, 4], torus(0.27, SHAFT_TOP, 0.05), trim);
    // The capital's bell is a quarter ellipse from the ring to the abacus.
    let bell = |t: f32| {
        let (sin, cos) = (0.5 * PI * t).sin_cos();
        Vec2::new(0.45 - 0.17 * cos, SHAFT_TOP + 0.1 + 0.5 * sin)
    };
    shape.lathe([AROUND, 8], bell, |_, row| if row == 5 { stone.gold } else { stone.trim });
    slab(shape, 0.47, SHAFT_TOP + 0.6, SHAFT_TOP + 0.74);
    slab(shape, 0.4, SHAFT_TOP + 0.7, SPRINGING);
}

/// Adds an arch on every side of every bay, of brick and stone alternately.
fn arches(scene: &mut Scene, stone: &Stone) {
    const STONES: usize = 15;
    const HALF_THICKNESS: f32 = 0.3;
    /// Distance of an arch's underside from the columns' axes and the vault's edge.
    const WIDTH: f32 = 0.36;
    let mut arch = |name: String, from: Vec3, to: Vec3| {
        let half = 0.5 * (to - from);
        let along = half - half.normalize() * WIDTH;
        let across = along.cross(Vec3::Y).normalize() * HALF_THICKNESS;
        let mut shape = Shape::new(name, from.midpoint(to) + Vec3::Y * SPRINGING);
        // At the crown the arch ends slightly above the vault's edge; at its feet it meets the next arch.
        shape.arch(along, across, RISE - WIDTH, [WIDTH, WIDTH + 0.04], STONES, |k| stone.voussoirs[k % 2]);
        add(scene, shape);
    };
    for (row, x) in ROWS.into_iter().enumerate() {
        for line in 0..BAYS {
            let [from, to] = [line, line + 1].map(|line| Vec3::new(x, 0.0, row_z(line)));
            arch(format!("arch along {row} {line}"), from, to);
        }
    }
    for line in 0..=BAYS {
        for (row, pair) in ROWS.windows(2).enumerate() {
            let [from, to] = [pair[0], pair[1]].map(|x| Vec3::new(x, 0.0, row_z(line)));
            arch(format!("arch across {row} {line}"), from, to);
        }
    }
}

fn vaults(scene: &mut Scene, stone: &Stone) {
    for line in 0..BAYS {
        for (row, pair) in ROWS.windows(2).enumerate() {
            let half = Vec2::new(0.5 * (pair[1] - pair[0]), 0.5 * BAY);
            let center = Vec3::new(pair[0].midpoint(pair[1]), SPRINGING, row_z(line) - 0.5 * BAY);
            let mut vault = Shape::new(format!("vault {row} {line}"), center);
            vault.groin_vault(half, RISE, [14, 4], stone.vault);
            add(scene, vault);
        }
    }
}

/// Adds cloths without thickness: on poles at the columns of the nave, and in the arches of the aisles.
fn banners(scene: &mut Scene, stone: &Stone) {
    for line in 2..BAYS {
        for (side, row) in [(1.0, 2), (-1.0, 3)] {
            let cloth = stone.cloths[(line + 2 * row) % stone.cloths.len()];
            let mut pole = Shape::new(format!("pole {row} {line}"), Vec3::new(ROWS[row], 4.05, row_z(line)));
            let reach: f32 = side * 1.45;
            pole.cuboid(Vec3::new(reach.min(0.0), -0.025, -0.025), Vec3::new(reach.max(0.0), 0.025, 0.025), stone.wood);
            add(scene, pole);
            let corner = Vec3::new(ROWS[row] + side * 0.5, 4.0, row_z(line));
            let name = format!("banner {row} {line}");
            add(scene, banner(name, corner, Vec3::X * side * 0.85, 1.75, cloth, stone.gold));
        }
    }
    for line in 1..BAYS {
        for (row, side) in [(1, 1.0), (4, -1.0)] {
            if (line + row) % 2 == 0 {
                let cloth = stone.cloths[(line + 2 * row) % stone.cloths.len()];
                let corner = Vec3::new(ROWS[row], 4.6, row_z(line) - 0.5 * BAY - side * 0.9);
                let name = format!("banner {row} {line}");
                add(scene, banner(name, corner, Vec3::Z * side * 1.8, 3.0, cloth, stone.gold));
            }
        }
    }
}

/// Returns a hanging cloth with folds, a border, chevrons and a pointed lower edge.
fn banner(name: String, corner: Vec3, across: Vec3, drop: f32, cloth: MaterialId, gold: MaterialId) -> Shape {
    const PATCHES: [usize; 2] = [16, 24];
    let depth = across.cross(Vec3::Y).normalize() * 0.045;
    let mut shape = Shape::new(name, corner);
    shape.sheet(
        PATCHES,
        Shading::Smooth,
        |s, t| {
            let length = drop * (1.0 - 0.16 * (2.0 * s - 1.0).abs());
            across * s - Vec3::Y * (length * t) + depth * ((0.3 + t) * (2.5 * PI * s + 1.5 * t).sin())
        },
        |column, row| {
            let border = column == 1 || column == 14 || row == 22;
            // Rows follow the pointed lower edge, so bars along them are chevrons.
            let chevron = (4..12).contains(&column) && matches!(row, 7 | 8 | 11 | 12 | 15 | 16);
            if border || chevron { gold } else { cloth }
        },
    );
    shape
}

/// Adds a carpet that leads to steps and a round window at the far end, with urns beside the carpet.
fn furniture(scene: &mut Scene, stone: &Stone) {
    let far = row_z(BAYS);
    add(scene, carpet(stone, far));
    add(scene, steps(stone, far));
    add(scene, round_window(stone, far));
    for line in [2, 4, 6, 8] {
        for side in [-1.0, 1.0] {
            add(scene, urn(stone, line, side));
        }
    }
}

fn carpet(stone: &Stone, far: f32) -> Shape {
    let mut carpet = Shape::new("carpet", Vec3::new(0.0, 0.015, 0.0));
    let length = far + 5.5;
    carpet.sheet(
        [14, 120],
        Shading::Flat,
        |s, t| Vec3::new(1.25 * (2.0 * s - 1.0), 0.0, -0.8 + (length + 0.8) * t),
        |column, row| {
            let from_edge = column.min(13 - column);
            let diamond = (row % 10).abs_diff(5) + (6 - from_edge) == 5;
            match from_edge {
                1 => stone.carpet[1],
                0 | 2 => stone.carpet[2],
                _ if diamond => stone.carpet[1],
                _ => stone.carpet[0],
            }
        },
    );
    carpet
}

fn steps(stone: &Stone, far: f32) -> Shape {
    let mut steps = Shape::new("steps", Vec3::new(0.0, 0.0, far));
    for step in 0..4 {
        let half = 2.6 - 0.3 * step as f32;
        let (height, front) = (0.18 * (step + 1) as f32, 4.6 - 0.45 * step as f32);
        let material = stone.shafts[step % 2 + 1];
        let hidden = -0.1 - 0.02 * step as f32;
        steps.cuboid(Vec3::new(-half, hidden, hidden), Vec3::new(half, height, front), material);
    }
    steps
}

fn round_window(stone: &Stone, far: f32) -> Shape {
    let mut window = Shape::new("round window", Vec3::new(0.0, 4.75, far + 0.06));
    window.sheet(
        [72, 10],
        Shading::Flat,
        |s, t| {
            let (sin, cos) = (2.0 * PI * s.fract()).sin_cos();
            Vec3::new(cos, sin, 0.0) * (2.1 * t)
        },
        |column, row| {
            let petal = column / 3;
            match row {
                9 => stone.trim,
                4 | 8 => stone.glass[4],
                0..=3 if column % 9 == 0 => stone.glass[4],
                0..=3 => stone.glass[2 - (petal / 3 + row / 2) % 2 * 2],
                _ if column % 6 == 0 => stone.glass[4],
                _ => stone.glass[[1, 3][(petal / 2 + row / 7) % 2]],
            }
        },
    );
    window
}

/// Returns an urn on a pedestal, left or right of the carpet, between a line of columns and the previous one.
fn urn(stone: &Stone, line: usize, side: f32) -> Shape {
    let at = Vec3::new(side * 2.0, 0.0, row_z(line) - 0.5 * BAY);
    let mut urn = Shape::new(format!("urn {line} {}", if side < 0.0 { "left" } else { "right" }), at);
    urn.cuboid(Vec3::new(-0.28, -0.1, -0.28), Vec3::new(0.28, 0.55, 0.28), stone.trim);
    urn.cuboid(Vec3::new(-0.33, 0.54, -0.33), Vec3::new(0.33, 0.63, 0.33), stone.trim);
    // The profile rises from the foot over the belly to the neck and the lip.
    let profile = |t: f32| Vec2::new(0.12 + 0.17 * (PI * t.powf(0.8)).sin().powi(2) + 0.1 * t.powi(6), 0.62 + 0.75 * t);
    urn.lathe([32, 20], profile, |_, row| if row == 9 || row == 15 { stone.gold } else { stone.bronze });
    urn
}
