//! Tests of the built-in scenes' views for each eye, by ray casts with a separate tree.

use std::{collections::BTreeSet, time::Duration};

use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2},
    ray::{Ray, RayHit},
};

use super::*;
use crate::Pose;
use crate::random::pcg;

/// A scene, its camera and a tree for ray casts, in pictures of `SIZE`.
struct Caster {
    scene: Scene,
    pose: Pose,
    bvh: Bvh2,
}

const SIZE: [u32; 2] = [160, 90];
const LEFT: f32 = -1.0;
const RIGHT: f32 = 1.0;

impl Caster {
    fn new(builtin: Builtin, [width, height]: [u32; 2]) -> Self {
        let scene = builtin.scene();
        let triangles = scene.triangles().iter().map(|t| Aabb::from_points(&t.corners.map(Into::into)));
        let spheres = scene.spheres().iter();
        let spheres = spheres.map(|s| Aabb::new((s.center - s.radius).into(), (s.center + s.radius).into()));
        let boxes: Vec<Aabb> = triangles.chain(spheres).collect();
        let bvh = build_bvh2(&boxes, BvhBuildParams::very_fast_build(), &mut Duration::default());
        Self { pose: builtin.camera(width, height).pose().unwrap(), scene, bvh }
    }

    /// Returns all hits of the ray through a pixel's centre: depth and primitive, nearest first.
    fn hits(&self, side: f32, i: u32, j: u32) -> Vec<(f32, u32)> {
        let pose = &self.pose;
        let [x, y] = [i, j].map(|k| k as f32 + 0.5);
        let (x, y) = (x / pose.size[0] as f32 - 0.5, 0.5 - y / pose.size[1] as f32);
        let screen = pose.forward * pose.screen_distance;
        let point =
            pose.eye.as_vec3() + screen + pose.right * pose.screen_size[0] * x + pose.up * pose.screen_size[1] * y;
        let origin = pose.eye_in_scene(side);
        // The direction has length 1 along the view, so t is the depth.
        let direction = (point - origin) / pose.screen_distance;
        let mut hits = Vec::new();
        let ray = Ray::new_inf(origin.into(), direction.into());
        self.bvh.ray_traverse(ray, &mut RayHit::none(), |_, index| {
            let primitive = self.bvh.primitive_indices[index];
            hits.extend(self.intersect(primitive, origin, direction).map(|t| (t, primitive)));
            f32::INFINITY
        });
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        hits
    }

    fn intersect(&self, primitive: u32, origin: Vec3, direction: Vec3) -> Option<f32> {
        let triangles = self.scene.triangles();
        let Some(triangle) = triangles.get(primitive as usize) else {
            let sphere = self.scene.spheres()[primitive as usize - triangles.len()];
            let to = origin - sphere.center;
            let (a, b) = (direction.length_squared(), to.dot(direction));
            let root = b * b - a * (to.length_squared() - sphere.radius * sphere.radius);
            return (root >= 0.0).then(|| (-b - root.sqrt()) / a).filter(|t| *t > 0.0);
        };
        // Intersection test of Möller and Trumbore 1997.
        let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
        let (to, direction) = (origin.as_dvec3() - a, direction.as_dvec3());
        let normal = direction.cross(c - a);
        let scale = 1.0 / (b - a).dot(normal);
        let (u, v) = (to.dot(normal) * scale, direction.dot(to.cross(b - a)) * scale);
        let t = (c - a).dot(to.cross(b - a)) * scale;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t as f32)
    }

    fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let [width, height] = self.pose.size;
        (0..height).flat_map(move |j| (0..width).map(move |i| (i, j)))
    }

    /// Returns the depth and object name of each of an eye's visible points. Pixels without a hit are left out.
    fn visible(&self, side: f32) -> Vec<(f32, &str)> {
        let nearest = self.pixels().filter_map(|(i, j)| self.hits(side, i, j).first().copied());
        nearest.map(|(depth, primitive)| (depth, self.name(primitive))).collect()
    }

    fn name(&self, primitive: u32) -> &str {
        self.scene.object_name(self.scene.object_of(primitive))
    }

    /// Returns the ratio of the smallest depth in both eyes' pictures to the screen's distance.
    fn nearest_ratio(&self) -> f32 {
        let depths = [LEFT, RIGHT].into_iter().flat_map(|side| self.visible(side));
        depths.map(|(depth, _)| depth).fold(f32::INFINITY, f32::min) / self.pose.screen_distance
    }

    /// Returns the number of an eye's pixels that show an object whose name has this prefix.
    fn count(&self, side: f32, prefix: &str) -> usize {
        self.visible(side).iter().filter(|(_, name)| name.starts_with(prefix)).count()
    }
}

#[test]
fn every_scene_builds_and_has_lights_and_a_valid_camera() {
    for &builtin in Builtin::ALL {
        let scene = builtin.scene();
        scene.check().unwrap();
        assert_eq!(scene.lights.len(), if scene.planes().is_empty() { 5 } else { 1 }, "{builtin}");
        let total: f32 = scene.lights.iter().map(|light| light.intensity.max_element()).sum();
        assert!((1.1..1.3).contains(&total), "{builtin}: {total}");
        assert_eq!(scene.degenerate_count(), 0, "{builtin}");
        let pose = builtin.camera(600, 400).pose().unwrap();
        assert!((pose.interaxial_px - 15.0).abs() < 1e-4, "{builtin}");
    }
}

#[test]
fn a_name_parses_back_and_an_unknown_one_lists_the_names() {
    for &builtin in Builtin::ALL {
        assert_eq!(builtin.to_string().parse::<Builtin>().unwrap(), builtin);
    }
    let message = "sponza".parse::<Builtin>().unwrap_err().to_string();
    assert!(
        message.contains("'sponza'") && message.contains("spheres, hall, hall-finished, fence, hidden, near, grazing")
    );
}

#[test]
fn the_spheres_never_change() {
    let scene = Builtin::Spheres.scene();
    assert_eq!((scene.spheres().len(), scene.triangles().len()), (spheres::SPHERE_COUNT, 0));
    let words = scene.spheres().iter().flat_map(|sphere| {
        let [x, y, z] = sphere.center.to_array();
        [x.to_bits(), y.to_bits(), z.to_bits(), sphere.radius.to_bits(), sphere.material.0]
    });
    let fingerprint = words.fold(0, |hash, word| pcg(hash ^ word));
    assert_eq!(fingerprint, 0xba48_afd2, "{fingerprint:#x}");
}

#[test]
fn the_spheres_fill_most_of_the_picture_and_begin_at_half_the_distance() {
    let caster = Caster::new(Builtin::Spheres, [120, 90]);
    assert!((0.5..0.53).contains(&caster.nearest_ratio()));
    assert!(caster.visible(LEFT).len() > 120 * 90 * 7 / 10, "{}", caster.visible(LEFT).len());
}

#[test]
fn the_hall_has_100_000_triangles_and_many_objects() {
    let scene = Builtin::Hall.scene();
    assert!(scene.triangles().len() >= 100_000);
    assert!(scene.has_normals() && scene.spheres().is_empty());
    let names: BTreeSet<&str> = (0..scene.object_count() as u32).map(|k| scene.object_name(k)).collect();
    assert_eq!(names.len(), scene.object_count(), "names are unique");
}

#[test]
fn the_hall_begins_just_behind_half_the_distance_and_is_closed() {
    for size in [SIZE, [120, 90], [90, 90]] {
        let caster = Caster::new(Builtin::Hall, size);
        let nearest = caster.nearest_ratio();
        assert!((0.5..0.56).contains(&nearest), "{size:?}: {nearest}");
        assert_eq!(caster.visible(LEFT).len(), caster.pixels().count(), "{size:?}: sky is seen");
    }
}

#[test]
fn in_half_of_the_halls_image_columns_two_objects_stand_before_the_wall() {
    let caster = Caster::new(Builtin::Hall, SIZE);
    let layers = |i, j| {
        let hits = caster.hits(LEFT, i, j);
        let names = hits.iter().map(|&(_, primitive)| caster.name(primitive));
        let ends = ["floor", "vault", "west wall", "north wall", "east wall"];
        let before = names.take_while(|name| !ends.iter().any(|end| name.starts_with(end)));
        before.collect::<BTreeSet<_>>().len()
    };
    // This row crosses shafts and banners above the floor.
    let row = 2 * SIZE[1] / 5;
    let deep = (0..SIZE[0]).filter(|&i| layers(i, row) >= 2).count();
    assert!(2 * deep >= SIZE[0] as usize, "{deep} of {}", SIZE[0]);
}

#[test]
fn no_two_objects_of_the_hall_share_a_surface() {
    let caster = Caster::new(Builtin::Hall, SIZE);
    for (i, j) in caster.pixels() {
        for pair in caster.hits(LEFT, i, j).windows(2) {
            let [(near, first), (far, second)] = [pair[0], pair[1]];
            let names = [first, second].map(|primitive| caster.name(primitive));
            assert!(far - near > 1e-5 || names[0] == names[1], "pixel {i}, {j}, depth {near}: {names:?}");
        }
    }
}

#[test]
fn the_wall_is_seen_between_the_slats_of_the_fence() {
    let caster = Caster::new(Builtin::Fence, [400, 225]);
    let (slats, wall) = (caster.count(LEFT, "slat"), caster.count(LEFT, "wall"));
    assert!(slats > 20_000 && wall > 20_000, "{slats} {wall}");
    assert!(caster.nearest_ratio() > 0.5);
}

#[test]
fn the_hidden_pillar_is_seen_by_the_right_eye_only() {
    for size in [[600, 338], [300, 300]] {
        let caster = Caster::new(Builtin::Hidden, size);
        assert!((caster.pose.interaxial - stage::INTERAXIAL).abs() < 1e-6);
        let [left, right] = [LEFT, RIGHT].map(|side| caster.count(side, "hidden"));
        assert_eq!(left, 0, "{size:?}");
        assert!(right > 400, "{size:?}: {right}");
    }
}

#[test]
fn the_near_ball_is_at_a_seventh_of_the_distance() {
    let nearest = Caster::new(Builtin::Near, SIZE).nearest_ratio();
    assert!((nearest * stage::NEAR_FACTOR - 1.0).abs() < 0.01, "{nearest}");
}

#[test]
fn the_grazing_sheets_are_edges_to_the_left_eye_and_surfaces_to_the_right_one() {
    let caster = Caster::new(Builtin::Grazing, [600, 338]);
    let [left, right] = [LEFT, RIGHT].map(|side| caster.count(side, "sheet"));
    assert!(right > 15_000 && left * 20 < right, "{left} {right}");
}
