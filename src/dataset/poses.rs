//! Random cameras in the free space of a scene.

use std::{collections::HashMap, f32::consts::TAU};

use glam::{DVec3, Quat, Vec3};

use crate::{
    Error, Pose, Ray, RayHit, Renderer, Scene, StereoCamera, UploadedScene,
    occlusion::Pixels,
    random::{Random, pcg},
    scene::Primitive,
};

/// Cameras that are tried for an item before it is given up.
const TRIES: u32 = 2000;
/// Directions in which it is asked how near surfaces are.
const DIRECTIONS: usize = 128;
/// Rays of each eye that ask what its picture shows, across and down.
const GRID: [u32; 2] = [24, 16];
/// A camera in the scene looks up or down by at most this angle, in radians.
const STEEPEST: f32 = 0.4;
/// A place from which so much of what surrounds it shows its other side is inside of something.
const OTHER_SIDES: f32 = 0.25;

/// Random cameras in the free space of a scene: like a given one, but elsewhere. A camera within the scene's bounding
/// box becomes one anywhere in that box, looking anywhere, at most 23 degrees up or down; one outside of it stays as
/// far from the middle, and looks at what is there.
///
/// A camera is rejected that stands too near to a surface, from which a quarter of what surrounds it shows its other
/// side (it is inside of something, or behind a wall), whose eyes don't see each other, and whose picture shows too
/// little or disparities that are too large. The other side of an object is its back, as the order of its triangles'
/// corners says; of one that the given camera sees from the back, such as walls that were modelled as a block, it is
/// the front.
#[derive(Clone, Debug)]
pub struct FreePoses<'a> {
    scene: &'a Scene,
    camera: StereoCamera,
    seed: u32,
    clearance: f32,
    disparity: f32,
    surfaces: f32,
}

/// A camera that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RandomPose {
    /// Where it stands.
    pub camera: StereoCamera,
    /// How many were tried, with this one.
    pub tries: u32,
}

/// Why cameras were rejected, counted.
#[derive(Default)]
struct Rejected {
    near: u32,
    behind: u32,
    blocked: u32,
    disparity: u32,
    empty: u32,
}

impl<'a> FreePoses<'a> {
    /// Cameras like this one, by a seed.
    ///
    /// # Errors
    /// [`Error::Camera`] for a camera that has no picture, [`Error::Scene`] for a scene in which nothing is, or only
    /// infinite planes.
    pub fn new(scene: &'a Scene, camera: StereoCamera, seed: u32) -> Result<Self, Error> {
        let pose = camera.pose()?;
        if scene.bounds().is_none() {
            let reason = "it has nothing of a size, so there is no place to put cameras at".into();
            return Err(Error::Scene { element: "the scene".into(), reason });
        }
        let (clearance, surfaces) = (2.0 * pose.interaxial, if is_inside(scene, pose.eye) { 0.5 } else { 0.1 });
        Ok(Self { scene, camera, seed, clearance, disparity: f32::INFINITY, surfaces })
    }

    /// How far every surface is from the middle between the eyes, in world units; twice the interaxial where nothing is
    /// said.
    pub fn clearance(mut self, distance: f32) -> Self {
        self.clearance = distance;
        self
    }

    /// How large disparities may be, in pixels, before or behind the screen; any where nothing is said.
    pub fn disparity(mut self, pixels: f32) -> Self {
        self.disparity = pixels;
        self
    }

    /// How much of the left picture shows surfaces at least, 0 to 1; where nothing is said a half within a scene, and a
    /// tenth of what is seen from outside.
    pub fn surfaces(mut self, share: f32) -> Self {
        self.surfaces = share;
        self
    }

    /// The camera of an item, which follows from the scene, the camera, the seed and the item's number alone.
    ///
    /// # Errors
    /// [`Error::Options`] where 2000 cameras were all rejected, with the reasons; and those of
    /// [`Renderer::closest_hits_async`].
    pub async fn find_async(
        &self,
        renderer: &Renderer,
        uploaded: &UploadedScene,
        item: u32,
    ) -> Result<RandomPose, Error> {
        let given = self.camera.pose()?;
        let sides = self.sides(given.eye, &self.around(renderer, uploaded, given.eye).await?);
        let mut random = Random(pcg(pcg(self.seed).wrapping_add(item)));
        let mut rejected = Rejected::default();
        for tries in 1..=TRIES {
            let camera = self.candidate(&given, &mut random);
            let Ok(pose) = camera.pose() else { continue };
            let around = self.around(renderer, uploaded, pose.eye).await?;
            if around.iter().any(|hit| hit.t < self.clearance) {
                rejected.near += 1;
            } else if self.other_sides(pose.eye, &around, &sides) > OTHER_SIDES {
                rejected.behind += 1;
            } else if self.shows_enough(renderer, uploaded, &pose, &mut rejected).await? {
                return Ok(RandomPose { camera, tries });
            }
        }
        let Rejected { near, behind, blocked, disparity, empty } = rejected;
        let reason = format!(
            "no free place for item {item} among {TRIES}: {near} too near a surface, {behind} inside of something, {blocked} with a surface \
             between the eyes, {disparity} with too large disparities, {empty} that show too little"
        );
        Err(Error::Options { option: "poses", reason })
    }

    /// Somewhere else, by random numbers alone.
    fn candidate(&self, given: &Pose, random: &mut Random) -> StereoCamera {
        let (low, high) = self.scene.local_bounds().unwrap_or_default();
        let to_world = |place: Vec3| self.scene.origin() + place.as_dvec3();
        let up = self.camera.up_direction().normalize_or_zero();
        let yaw = Quat::from_axis_angle(up, random.between(0.0, TAU));
        let mut within =
            |low: Vec3, high: Vec3| Vec3::from_array([0, 1, 2].map(|axis| random.between(low[axis], high[axis])));
        if is_inside(self.scene, given.eye) {
            let eye = within(low, high);
            let level = yaw * up.any_orthonormal_vector();
            let pitch = random.between(-STEEPEST, STEEPEST);
            let ahead = level * pitch.cos() + up * pitch.sin();
            return self.camera.eye(to_world(eye)).target(to_world(eye + ahead));
        }
        let middle = low.midpoint(high);
        // A point of the box's inner half.
        let target = within(low.midpoint(middle), high.midpoint(middle));
        let eye = middle + yaw * (self.scene.local(given.eye) - middle);
        self.camera.eye(to_world(eye)).target(to_world(target))
    }

    /// What is in all directions from a place.
    async fn around(&self, renderer: &Renderer, uploaded: &UploadedScene, place: DVec3) -> Result<Vec<RayHit>, Error> {
        let rays: Vec<Ray> = (0..DIRECTIONS).map(|index| Ray::new(place, direction(index))).collect();
        Ok(renderer.closest_hits_async(uploaded, &rays).await?.hits)
    }

    /// Of each object that is seen from a place, whether more of it is seen from behind.
    fn sides(&self, place: DVec3, around: &[RayHit]) -> HashMap<u32, bool> {
        let mut balance = HashMap::<u32, i32>::new();
        for (object, behind) in self.faces(place, around) {
            *balance.entry(object).or_default() += if behind { 1 } else { -1 };
        }
        balance.into_iter().map(|(object, balance)| (object, balance > 0)).collect()
    }

    /// The share of all directions in which an object shows the other side.
    fn other_sides(&self, place: DVec3, around: &[RayHit], sides: &HashMap<u32, bool>) -> f32 {
        let is_other = |(object, behind): &(u32, bool)| *behind != sides.get(object).copied().unwrap_or(false);
        self.faces(place, around).filter(is_other).count() as f32 / DIRECTIONS as f32
    }

    /// What is met around a place: each time its object, and whether it is met from behind.
    fn faces(&self, place: DVec3, around: &[RayHit]) -> impl Iterator<Item = (u32, bool)> {
        let place = self.scene.local(place);
        around.iter().enumerate().filter(|(_, hit)| hit.t.is_finite()).map(move |(index, hit)| {
            let behind = match self.scene.primitive(hit.primitive) {
                Primitive::Triangle(triangle) => {
                    let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
                    (b - a).cross(c - a).dot(direction(index).as_dvec3()) > 0.0
                }
                Primitive::Sphere(sphere) => place.distance(sphere.center) < sphere.radius,
                Primitive::Ellipsoid(ellipsoid) => ellipsoid.holds(place),
                Primitive::Plane(_) => false,
            };
            (self.scene.object_of(hit.primitive), behind)
        })
    }

    /// Whether the eyes see each other, and enough that is not too near.
    async fn shows_enough(
        &self,
        renderer: &Renderer,
        uploaded: &UploadedScene,
        pose: &Pose,
        rejected: &mut Rejected,
    ) -> Result<bool, Error> {
        let [across, down] = GRID.map(|count| count as usize);
        let [width, height] = pose.size.map(|side| side as usize);
        let eyes = [-0.5, 0.5].map(|side| Pixels::of(pose, side));
        let mut rays: Vec<Ray> = eyes
            .iter()
            .flat_map(|eye| {
                (0..across * down).map(|cell| {
                    let (column, row) = (cell % across, cell / across);
                    let pixel = [(2 * column + 1) * width / (2 * across), (2 * row + 1) * height / (2 * down)];
                    Ray::new(eye.eye(), eye.direction(pixel[0], pixel[1]).as_vec3())
                })
            })
            .collect();
        let between = eyes[1].eye() - eyes[0].eye();
        if between != DVec3::ZERO {
            rays.push(Ray::new(eyes[0].eye(), between.as_vec3()).t_max(1.0));
        }
        let hits = renderer.closest_hits_async(uploaded, &rays).await?.hits;
        let (seen, between) = hits.split_at(2 * across * down);
        let too_far_aside = |hit: &RayHit| pose.disparity_px(hit.t).abs() >= f64::from(self.disparity);
        let surfaces = seen[..across * down].iter().filter(|hit| hit.t.is_finite()).count();
        if between.iter().any(|hit| hit.t.is_finite()) {
            rejected.blocked += 1;
        } else if seen.iter().any(too_far_aside) {
            rejected.disparity += 1;
        } else if (surfaces as f32) < self.surfaces * (across * down) as f32 {
            rejected.empty += 1;
        } else {
            return Ok(true);
        }
        Ok(false)
    }
}

fn is_inside(scene: &Scene, place: DVec3) -> bool {
    scene.bounds().is_some_and(|(low, high)| place.cmpge(low).all() && place.cmple(high).all())
}

/// The directions of a spiral around a sphere, evenly spread.
fn direction(index: usize) -> Vec3 {
    const GOLDEN_ANGLE: f32 = 2.399_963_2;
    let z = 1.0 - (2 * index + 1) as f32 / DIRECTIONS as f32;
    let (sin, cos) = (index as f32 * GOLDEN_ANGLE).sin_cos();
    let across = (1.0 - z * z).sqrt();
    Vec3::new(across * cos, across * sin, z)
}
