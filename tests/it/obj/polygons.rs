//! Tests into which triangles faces of more than three corners are split.

use std::{
    collections::HashMap,
    f64::consts::TAU,
    time::{Duration, Instant},
};

use stereotrace::{
    Scene,
    glam::{DVec2, Quat, Vec3},
};

use super::{Folder, common::random::Random};

/// Maximum time for a face of 100,000 corners. It takes at most 2 s while three other tests run on two cores.
const LONG: Duration = Duration::from_secs(20);

/// The corners of a polygon in the plane.
type Outline = Vec<[f64; 2]>;

fn around(count: u32, mut radius: impl FnMut(u32) -> f64) -> Outline {
    let corner = |index: u32| {
        let (sin, cos) = (TAU * f64::from(index) / f64::from(count)).sin_cos();
        let radius = radius(index);
        [radius * cos, radius * sin]
    };
    (0..count).map(corner).collect()
}

/// Returns the outline of a comb, which has its teeth side by side on a beam.
fn comb(teeth: u32) -> Outline {
    let mut outline = vec![[0.0, -1.0]];
    outline.push([f64::from(teeth), -1.0]);
    for tooth in (0..teeth).rev().map(f64::from) {
        outline.extend([[tooth + 1.0, 0.0], [tooth + 0.75, 8.0], [tooth + 0.25, 8.0], [tooth, 0.0]]);
    }
    outline
}

/// Returns the outline of a rolled-up band.
fn spiral(corners: u32) -> Outline {
    let side = |offset: f64| {
        move |index: u32| {
            let (turn, radius) = (0.06 * f64::from(index), 1.0 + 0.01 * f64::from(index) + offset);
            [radius * turn.cos(), radius * turn.sin()]
        }
    };
    (0..corners / 2).map(side(0.3)).chain((0..corners / 2).rev().map(side(0.0))).collect()
}

/// Returns the outline of a square with a round bite out of one side.
fn bite(corners: u32) -> Outline {
    let arc = (0..corners - 4).map(|index| {
        let (sin, cos) = (0.5 * TAU * f64::from(index) / f64::from(corners - 5)).sin_cos();
        [0.9 * cos, -1.0 + 0.9 * sin]
    });
    let square = [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
    square.into_iter().chain(arc.rev()).collect()
}

/// Returns a square with a hole, whose outline goes to the hole and back along one edge.
fn keyhole() -> Outline {
    let outside = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
    let hole = [[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]];
    [&outside[..], &outside[..1], &hole, &hole[..1]].concat()
}

fn concave() -> Vec<(&'static str, Outline)> {
    let mut random = Random::new(5);
    vec![
        ("dart", vec![[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]]),
        ("L", vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]]),
        ("L with corners on its sides", {
            let ring = [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [1, 2], [1, 3], [0, 3], [0, 2], [0, 1]];
            ring.map(|corner| corner.map(f64::from)).to_vec()
        }),
        ("star", around(10, |index| if index % 2 == 0 { 1.0 } else { 0.3 })),
        ("gear", around(60, |index| if index % 4 < 2 { 1.0 } else { 0.8 })),
        ("comb", comb(9)),
        ("spiral", spiral(400)),
        ("bite", bite(50)),
        ("keyhole", keyhole()),
        ("spikes", around(80, |_| f64::from(random.between(0.05, 1.0)))),
    ]
}

/// Returns an OBJ file with a face for each outline, in a plane.
fn file(outlines: &[Outline], turn: Quat) -> String {
    let mut text = String::new();
    for outline in outlines {
        for &[x, y] in outline {
            let Vec3 { x, y, z } = turn * Vec3::new(x as f32, y as f32, 0.5);
            text += &format!("v {x} {y} {z}\n");
        }
        text += "f";
        (0..outline.len()).rev().for_each(|back| text += &format!(" -{}", back + 1));
        text += "\n";
    }
    text
}

/// Returns how many triangles cover a point, which must not lie on an edge.
fn covered(triangles: &[[DVec2; 3]], point: DVec2) -> usize {
    let inside = |&[a, b, c]: &[DVec2; 3]| {
        let left = [[a, b], [b, c], [c, a]].map(|[from, to]| (to - from).perp_dot(point - from) > 0.0);
        left == [true; 3] || left == [false; 3]
    };
    triangles.iter().filter(|triangle| inside(triangle)).count()
}

/// Returns whether a point is inside an outline, by the number of edges that a ray to the right crosses.
fn is_inside(outline: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let crosses = |(&[ax, ay], &[bx, by]): (&[f64; 2], &[f64; 2])| {
        (ay > y) != (by > y) && ax + (y - ay) / (by - ay) * (bx - ax) > x
    };
    outline.iter().zip(outline.iter().cycle().skip(1)).filter(|&edge| crosses(edge)).count() % 2 == 1
}

/// Returns how many of `points` random points are covered wrongly. The triangles must cover a point inside the outline
/// exactly once, and a point outside not at all.
fn wrong(scene: &Scene, outline: &[[f64; 2]], turn: Quat, points: u32) -> u32 {
    let place = |[x, y]: [f64; 2]| (turn * Vec3::new(x as f32, y as f32, 0.5)).to_array().map(f32::to_bits);
    let in_plane: HashMap<_, _> = outline.iter().map(|&corner| (place(corner), DVec2::from(corner))).collect();
    let corners =
        |triangle: &stereotrace::Triangle| triangle.corners.map(|at| in_plane[&at.to_array().map(f32::to_bits)]);
    let triangles: Vec<_> = scene.triangles().iter().map(corners).collect();
    let all = || outline.iter().map(|&corner| DVec2::from(corner));
    let (low, high) = (all().reduce(DVec2::min).unwrap(), all().reduce(DVec2::max).unwrap());
    let mut random = Random::new(7);
    let mut between = |low: f64, high: f64| low + (high - low) * f64::from(random.between(0.0, 1.0));
    let mut wrong = 0;
    for _ in 0..points {
        let point = DVec2::new(between(low.x, high.x), between(low.y, high.y));
        wrong += u32::from(covered(&triangles, point) != usize::from(is_inside(outline, point.into())));
    }
    wrong
}

#[test]
fn concave_faces_cover_their_inside_once_from_whatever_corner_they_begin() {
    let folder = Folder::new("concave");
    let mut random = Random::new(3);
    for (name, outline) in concave() {
        for first in 0..outline.len().min(12) {
            let mut outline = outline.clone();
            outline.rotate_left(first);
            let turn = Quat::from_scaled_axis(random.point(3.0));
            let scene = folder.scene(file(std::slice::from_ref(&outline), turn));
            assert_eq!(scene.primitive_count(), outline.len() - 2, "{name} from {first}");
            let wrong = wrong(&scene, &outline, turn, 500);
            assert_eq!(wrong, 0, "{name} from {first}: {wrong} of 500 points are covered wrongly");
        }
    }
    let fanned = folder.warnings().into_iter().find(|warning| warning.contains("as fans"));
    assert_eq!(fanned, None);
}

/// Returns whether the scene's only face was split into a fan.
fn is_fanned(scene: &Scene, outline: &[[f64; 2]], turn: Quat) -> bool {
    let corners: Vec<_> = outline.iter().map(|&[x, y]| turn * Vec3::new(x as f32, y as f32, 0.5)).collect();
    let fan = corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]);
    scene.triangles().iter().map(|triangle| triangle.corners).eq(fan)
}

#[test]
fn faces_that_their_first_corner_sees_whole_are_fanned_as_ever() {
    let folder = Folder::new("fans");
    let mut random = Random::new(4);
    let dart = vec![[1.0, 1.0], [0.0, 4.0], [0.0, 0.0], [4.0, 0.0]];
    let on_sides = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0], [0.0, 1.0]].to_vec();
    // Due to rounding in the file, a corner of `rounded` lies beside a line. `again` repeats its first corner at the
    // end, and `line` has no area.
    let rounded = [[0.0, 0.0], [1.0, 2e-6], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].to_vec();
    let again = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]].to_vec();
    let line = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [3.0, 0.0], [0.5, 0.0]].to_vec();
    for outline in [dart, on_sides, rounded, again, line, around(4, |_| 2.0), around(100, |_| 1.0)] {
        for clockwise in [false, true] {
            let mut outline = outline.clone();
            if clockwise {
                outline[1..].reverse();
            }
            for turn in [Quat::IDENTITY, Quat::from_scaled_axis(random.point(3.0))] {
                let scene = folder.scene(file(std::slice::from_ref(&outline), turn));
                assert!(is_fanned(&scene, &outline, turn), "{outline:?} {turn}");
            }
        }
    }
    let fanned = folder.warnings().into_iter().find(|warning| warning.contains("as fans"));
    assert_eq!(fanned, None);
}

#[test]
fn faces_that_cross_themselves_or_are_not_flat_are_fanned_and_counted_once_with_a_line() {
    let folder = Folder::new("crossing");
    let text = "scene.obj: faces that intersect themselves, are far from flat or too complex, triangulated as fans \
                from their first corner";
    let bow = vec![[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]];
    let lopsided = vec![[0.0, 0.0], [3.0, 3.0], [3.0, 0.0], [0.0, 2.0]];
    let pentagram = (0..5).map(|index| around(5, |_| 1.0)[2 * index % 5]).collect();
    for outline in [bow, lopsided, pentagram] {
        let scene = folder.scene(file(std::slice::from_ref(&outline), Quat::IDENTITY));
        assert!(is_fanned(&scene, &outline, Quat::IDENTITY));
        let expected = format!("{text}: 1 on line {}", outline.len() + 1);
        assert_eq!(folder.warnings().last(), Some(&expected));
    }
    // The squares are folded along their diagonal, one by a right angle and one a little.
    let square = |height: f64| format!("v 0 0 0\nv 1 0 {height}\nv 1 1 0\nv 0 1 {height}\n");
    let before = folder.warnings().len();
    let scene = folder.scene(format!("{0}{1}f 5 6 7 8\nf 1 2 3 4\nf 1 2 3\nf 4 3 2 1\n", square(0.7), square(0.1)));
    assert_eq!(scene.primitive_count(), 7);
    let expected = format!("{text}: 2 from line 10 on");
    assert_eq!(folder.warnings()[before..], [expected]);
}

#[test]
fn faces_of_100_000_corners_take_no_square_of_time() {
    let folder = Folder::new("long_faces");
    let mut random = Random::new(6);
    let mut red = Vec::new();
    for (name, outline) in [
        ("gear", around(100_000, |index| if index % 4 < 2 { 1.0 } else { 0.8 })),
        ("comb", comb(25_000)),
        ("spiral", spiral(100_000)),
        ("bite", bite(100_000)),
        ("spikes", around(100_000, |_| f64::from(random.between(0.05, 1.0)))),
        ("gear of more than are cut", around(140_000, |index| if index % 4 < 2 { 1.0 } else { 0.8 })),
        ("on three points", [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 0.0]].repeat(25_000)),
        ("crossing", (0..100_000).map(|_| random.point(1.0).truncate().as_dvec2().into()).collect()),
    ] {
        let started = Instant::now();
        let scene = folder.scene(file(std::slice::from_ref(&outline), Quat::IDENTITY));
        let taken = started.elapsed();
        let wrong = wrong(&scene, &outline, Quat::IDENTITY, 20);
        println!("{name}: {taken:.1?}, {wrong} of 20 points wrong");
        let fanned = ["gear of more than are cut", "on three points", "crossing"].contains(&name);
        if taken > LONG || (wrong > 0) != fanned || scene.primitive_count() != outline.len() - 2 {
            red.push(name);
        }
    }
    assert!(red.is_empty(), "{red:?}");
    let fanned: Vec<_> = folder.warnings().into_iter().filter(|warning| warning.contains("as fans")).collect();
    assert_eq!(fanned.len(), 3, "{fanned:?}");
}
