//! Rebuilds the paper's random scenes from its description, and lists the paper's values for them.

use stereotrace::{
    Ellipsoid, MaterialId, Scene, StereoCamera,
    scene::builtin::{Builtin, RandomObjects},
};

use crate::{
    counts::clear,
    options::Plan,
    random::{DIFFERING, DISTANCE, DISTANCE_OF_ALL, LEFT_EDGE, PAPER_RAYS, TRACED, WRONG},
};

/// Seed of the random numbers, as in the built-in scenes. Further scenes have the next seeds.
pub(crate) const SEED: u32 = 1993;
/// Screen distance that is nearer than all objects.
const BEFORE_ALL: f32 = 9.0;
/// Factor on the objects' volume. With it, the objects in a scene of 1000 are as large as in a scene of 100.
const CROWD: f32 = 10.0;

/// Number of scenes in the groups that isolate the cause of differences.
const FEW: usize = 10;

/// Scenes for which the paper states common results.
pub(crate) struct Group {
    pub(crate) name: &'static str,
    /// Figure or table of the paper.
    pub(crate) place: &'static str,
    pub(crate) scenes: Vec<Scene>,
    pub(crate) camera: StereoCamera,
    /// The paper's values, by figure.
    pub(crate) paper: &'static [(&'static str, &'static str)],
}

/// The paper's values for 20 objects. The saved share of rays, 1 - 0.0707, follows from the first value.
const TWENTY: &[(&str, &str)] = &[
    (TRACED, "7.07; elsewhere M = 0.15, and never over 0.18"),
    (LEFT_EDGE, "at most 4.39; about half of those traced"),
    (PAPER_RAYS, "92.93 by the pixels traced"),
    (DIFFERING, "14.6"),
    (DISTANCE, "2.64"),
    (DISTANCE_OF_ALL, "0.385 by these two"),
    (WRONG, "0: \"absolutely impossible\""),
];

/// Returns the groups of scenes; smoke runs have one.
pub(crate) fn of(plan: &Plan) -> Vec<Group> {
    let camera = Builtin::Random20.camera(plan.side, plan.side);
    let twenty = |seed: u32| RandomObjects::new(20, SEED + seed).sphere_share(0.4).scene();
    let twenties: Vec<Scene> = (0..plan.seeds).map(twenty).collect();
    let group = |name, place, scenes, paper| Group { name, place, scenes, camera, paper };
    let mut groups = vec![group("20 objects", "figures 5, 6", twenties.clone(), TWENTY)];
    if plan.smoke {
        return groups;
    }
    let behind = camera.screen_distance(BEFORE_ALL);
    let of_one_colour: Vec<Scene> = twenties.iter().take(FEW).map(with_floor_of_one_colour).collect();
    let mut unshadowed = of_one_colour.clone();
    unshadowed.iter_mut().for_each(|scene| scene.shadows = false);
    groups.push(Group { camera: behind, ..group("20, all behind the screen", "figures 5, 6", twenties, TWENTY) });
    groups.push(group("20, floor of one colour", "figures 5, 6", of_one_colour, TWENTY));
    groups.push(group("20, floor of one colour, no shadows", "figures 5, 6", unshadowed, TWENTY));
    let random = |count, reflective, refractive| RandomObjects::new(count, SEED).shares(reflective, refractive).scene();
    let (glass, both, crowd) = (random(125, 0.0, 0.1), random(125, 0.1, 0.1), random(1000, 0.1, 0.1));
    let large = enlarged(&crowd, CROWD.cbrt());
    let mut add = |name, place, scene: &Scene, paper| groups.push(group(name, place, vec![scene.clone()], paper));
    add("125 diffuse", "table 1", &random(125, 0.0, 0.0), &[(PAPER_RAYS, "94.6"), (DISTANCE, "2.69")]);
    add("125, 10% mirrors", "table 1", &random(125, 0.1, 0.0), &[(PAPER_RAYS, "89")]);
    add("125, 10% glass", "table 1", &glass, &[(PAPER_RAYS, "80")]);
    add("125, 10% clear glass", "table 1", &clear(&glass), &[(PAPER_RAYS, "80")]);
    add("125, 10% each", "table 1, figure 8", &both, &[(PAPER_RAYS, "72"), (DISTANCE, "6.6")]);
    add("125, 10% each, clear", "table 1, figure 8", &clear(&both), &[(PAPER_RAYS, "72"), (DISTANCE, "6.6")]);
    add("100, 10% each", "table 2", &random(100, 0.1, 0.1), &[]);
    add("1000, 10% each", "table 2", &crowd, &[(PAPER_RAYS, "68"), (TRACED, "M = 0.05")]);
    add("1000 as large as 100", "table 2", &large, &[(PAPER_RAYS, "68"), (TRACED, "M = 0.05")]);
    add("1000 as large as 100, clear", "table 2", &clear(&large), &[(PAPER_RAYS, "68"), (TRACED, "M = 0.05")]);
    groups
}

/// Returns the scene with a floor of one colour, since the edges of the checkerboard also move by half a pixel.
fn with_floor_of_one_colour(scene: &Scene) -> Scene {
    let place =
        |name: &str| scene.materials().iter().position(|material| material.name == name).expect("a floor has it");
    let (light, dark) = (place("light square"), place("dark square"));
    let mut other = scene.clone();
    other
        .set_material(MaterialId(dark as u32), scene.materials()[light].clone())
        .expect("it is a material of the scene");
    other
}

/// Returns the scene with ellipsoids enlarged in place, so that they intersect.
fn enlarged(scene: &Scene, factor: f32) -> Scene {
    let mut other = scene.clone();
    let first = scene.object_count() - scene.ellipsoids().len();
    for (index, one) in scene.ellipsoids().iter().enumerate() {
        let larger = Ellipsoid::new(one.center, one.axes * factor, one.material);
        other.set_ellipsoid((first + index) as u32, larger).expect("it was in range, and is larger");
    }
    other
}

/// Returns the scene with only its first `count` lights. A single light is twice as bright.
pub(crate) fn lit(scene: &Scene, count: usize) -> Scene {
    let mut scene = scene.clone();
    scene.lights.truncate(count);
    if let [light] = scene.lights.as_mut_slice() {
        light.intensity *= 2.0;
    }
    scene
}
