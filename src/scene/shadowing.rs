//! The parts of a scene that decide which points see which lights.

use std::sync::Arc;

use glam::Vec3;

use super::{Ellipsoid, Light, Material, Plane, Scene, Sphere, Stamp, Texture};

/// Number of lights with visibility bits (`bits.wgsl`).
const WITH_BITS: usize = 16;

/// An axis-aligned box: its low and its high corner, relative to the scene's origin.
pub(crate) type Box3 = [Vec3; 2];

/// The state of an uploaded scene, as far as the visibility of lights depends on it.
#[derive(Debug)]
pub(crate) struct Shadowing {
    /// The lights that have bits, without their intensity.
    lights: Vec<Light>,
    /// Indices of the lights that are not points. They decide which share a light has, and whether there are any.
    soft: Vec<usize>,
    shadows: bool,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    meshes: Vec<(Stamp, Option<Box3>)>,
    spheres: Vec<Sphere>,
    ellipsoids: Vec<Ellipsoid>,
    planes: Vec<Plane>,
    /// Connected component of each primitive, and the number of primitives in the tree.
    components: Arc<Vec<u32>>,
    slots: usize,
}

/// The visibility bits of an earlier state that hold in a later one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Kept {
    /// One bit for each light.
    pub(crate) lights: u32,
    /// Boxes around objects that moved, before and after. They may hide a light whose ray to a point meets a box.
    pub(crate) moved: Vec<Box3>,
    /// Whether nothing changed, so that the light of paths holds too.
    pub(crate) unchanged: bool,
}

impl Shadowing {
    /// Returns the state of a scene. `before` is an earlier state, whose boxes of unchanged meshes are copied.
    pub(crate) fn of(scene: &Scene, components: &Arc<Vec<u32>>, slots: usize, before: Option<&Self>) -> Self {
        let known = |index: usize, stamp: Stamp| before?.meshes.get(index).filter(|(other, _)| *other == stamp);
        let ends = scene.mesh_objects.iter().skip(1).map(|next| next.first_primitive as usize);
        let meshes = scene.mesh_objects.iter().zip(ends.chain([scene.triangles.len()])).enumerate();
        let meshes = meshes.map(|(index, (object, end))| match known(index, object.stamp) {
            Some(known) => *known,
            None => {
                let triangles = &scene.triangles[object.first_primitive as usize..end];
                (object.stamp, around(triangles.iter().flat_map(|triangle| triangle.corners)))
            }
        });
        Self {
            lights: scene
                .lights
                .iter()
                .take(WITH_BITS)
                .map(|&light| Light { intensity: Vec3::ZERO, ..light })
                .collect(),
            soft: scene.soft_lights().map(|(index, _)| index).collect(),
            shadows: scene.shadows,
            materials: scene.materials.clone(),
            textures: scene.textures.clone(),
            meshes: meshes.collect(),
            spheres: scene.spheres.clone(),
            ellipsoids: scene.ellipsoids.clone(),
            planes: scene.planes.clone(),
            components: components.clone(),
            slots,
        }
    }

    /// Returns what holds of the bits of an earlier state, with at most `most` boxes; `None` if nothing does. A sampled
    /// ambient light has the bit after the lights'. It holds only if nothing changed.
    pub(crate) fn since(self: &Arc<Self>, earlier: &Arc<Self>, most: u32) -> Option<Kept> {
        if Arc::ptr_eq(self, earlier) {
            return Some(Kept { lights: (1 << WITH_BITS) - 1, moved: Vec::new(), unchanged: true });
        }
        if self.fixed() != earlier.fixed() {
            return None;
        }
        let mut moved = Vec::new();
        for (now, then) in changed(&self.meshes, &earlier.meshes) {
            match (now.1, then.1) {
                (Some(now), Some(then)) if meet(now, then) => moved.push(union(now, then)),
                (now, then) => moved.extend(now.into_iter().chain(then)),
            }
        }
        let spheres = changed(&self.spheres, &earlier.spheres).flat_map(|(now, then)| [now.corners(), then.corners()]);
        let ellipsoids = changed(&self.ellipsoids, &earlier.ellipsoids);
        moved.extend(spheres.chain(ellipsoids.flat_map(|(now, then)| [now.corners(), then.corners()])));
        if most == 0 && !moved.is_empty() {
            return None;
        }
        let lights = self.lights.iter().zip(&earlier.lights).enumerate();
        let lights = lights.filter(|(_, (now, then))| now == then).map(|(index, _)| 1 << index).sum();
        Some(Kept { lights, moved: at_most(most, &mut moved), unchanged: false })
    }

    /// Returns the parts that must not change for any bit to hold.
    fn fixed(&self) -> impl PartialEq + use<'_> {
        let Self { soft, shadows, materials, textures, planes, components, slots, .. } = self;
        let counts = [self.meshes.len(), self.spheres.len(), self.ellipsoids.len(), *slots];
        (soft, shadows, counts, (materials, textures, planes), components)
    }
}

/// Returns the elements that differ between two lists of the same length.
fn changed<'a, T: PartialEq>(now: &'a [T], then: &'a [T]) -> impl Iterator<Item = (&'a T, &'a T)> {
    now.iter().zip(then).filter(|(now, then)| now != then)
}

/// Returns the box around points, or `None` without any.
pub(super) fn around(points: impl IntoIterator<Item = Vec3>) -> Option<Box3> {
    points.into_iter().map(|point| [point; 2]).reduce(union)
}

fn union([low, high]: Box3, [other_low, other_high]: Box3) -> Box3 {
    [low.min(other_low), high.max(other_high)]
}

fn meet([low, high]: Box3, [other_low, other_high]: Box3) -> bool {
    low.cmple(other_high).all() && other_low.cmple(high).all()
}

/// Returns at most `most` boxes that enclose these. Neighbours are joined: the list is halved at the median of its
/// longest axis.
fn at_most(most: u32, boxes: &mut [Box3]) -> Vec<Box3> {
    if boxes.len() <= most as usize {
        return boxes.to_vec();
    }
    let whole = boxes.iter().copied().reduce(union).expect("more than none");
    if most == 1 {
        return vec![whole];
    }
    let axis = (whole[1] - whole[0]).max_position();
    let middle = boxes.len() / 2;
    boxes.select_nth_unstable_by(middle, |a, b| (a[0] + a[1])[axis].total_cmp(&(b[0] + b[1])[axis]));
    let (before, after) = boxes.split_at_mut(middle);
    [at_most(most / 2, before), at_most(most - most / 2, after)].concat()
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::{MaterialId, Mesh, random::Random, scene::components};

    #[test]
    fn few_boxes_enclose_many() {
        let mut random = Random::new(5);
        let boxes: Vec<Box3> = (0..100)
            .map(|_| {
                let low = random.point(9.0);
                [low, low + 0.1]
            })
            .collect();
        for most in [1, 2, 3, 16, 99, 100] {
            let few = at_most(most, &mut boxes.clone());
            assert!(few.len() <= most as usize);
            let holds = |[low, high]: &Box3, [a, b]: &Box3| low.cmple(*a).all() && b.cmple(*high).all();
            assert!(boxes.iter().all(|one| few.iter().any(|around| holds(around, one))), "{most}");
            let volume: f32 = few.iter().map(|[low, high]| (high - low).element_product()).sum();
            assert!(most < 16 || volume < 0.5 * 18.0_f32.powi(3), "{most} boxes: {volume}");
        }
    }

    #[test]
    fn an_object_that_moved_gives_its_boxes_before_and_after() {
        let mut scene = Scene::new();
        for x in [0.0, 3.0] {
            let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|corner| corner + x).to_vec();
            scene.add_mesh(&Mesh::new(corners, vec![[0, 1, 2]])).unwrap();
        }
        scene.add_sphere(Sphere::new(Vec3::splat(9.0), 1.0, MaterialId(0))).unwrap();
        let state = |scene: &Scene, before: Option<&Shadowing>| {
            Arc::new(Shadowing::of(scene, &Arc::new(components::of(scene)), 3, before))
        };
        let first = state(&scene, None);
        scene.transform_object(0, &Affine3A::from_translation(Vec3::new(0.5, 0.5, 0.0))).unwrap();
        let second = state(&scene, Some(&first));
        let near = [Vec3::ZERO, Vec3::new(1.5, 1.5, 0.0)];
        assert_eq!(second.since(&first, 16), Some(Kept { lights: 0, moved: vec![near], unchanged: false }));
        assert_eq!(second.since(&first, 0), None, "no room for a box");
        scene.transform_object(0, &Affine3A::from_translation(Vec3::splat(5.0))).unwrap();
        scene.transform_object(2, &Affine3A::from_translation(Vec3::X)).unwrap();
        let third = state(&scene, Some(&second));
        assert_eq!(third.since(&second, 16).unwrap().moved.len(), 4);
        assert_eq!(third.since(&first, 16).unwrap().moved.len(), 4, "two updates");
        let copy = state(&scene.clone(), Some(&third));
        assert_eq!(copy.since(&third, 16), Some(Kept::default()), "nothing moved");
        scene.set_mesh(0, &Mesh::new(vec![], vec![])).unwrap();
        assert_eq!(state(&scene, Some(&third)).since(&third, 16), None, "other primitives");
    }
}
