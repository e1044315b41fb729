//! Finds random cameras in the free space of a scene.

use std::{collections::HashMap, f32::consts::TAU};

use glam::{DVec3, Quat, Vec3};

use crate::{
    Error, Pose, Ray, RayHit, Renderer, Scene, StereoCamera, UploadedScene,
    random::{Random, pcg},
    scene::Primitive,
    truth::occlusion::Pixels,
};

/// Maximum number of candidates per item.
const TRIES: u32 = 2000;
/// Number of directions in which distances to surfaces are measured.
const DIRECTIONS: usize = 128;
/// Numbers of rays per eye, across and down, that sample the eye's picture.
const GRID: [u32; 2] = [24, 16];
/// Maximum angle up or down of a camera within the scene, in radians.
const STEEPEST: f32 = 0.4;
/// A point counts as inside an object if more than this share of directions from the point hits other sides.
const OTHER_SIDES: f32 = 0.25;

/// Finds random cameras in the free space of a scene, derived from a given camera. A given camera within the scene's
/// bounding box yields cameras anywhere in that box, in any direction, at most 23 degrees up or down. A given camera
/// outside the box yields cameras at the same distance from the box's centre that look at the scene.
///
/// A camera is rejected if
///
/// - it is too near to a surface,
/// - over a quarter of the directions from it hit the other side of an object, so it is inside an object or behind a
///   wall,
/// - a surface lies between the eyes,
/// - disparities are too large,
/// - the picture shows too few surfaces.
///
/// The other side of an object is its back, by the order of its triangles' corners. If the given camera sees mostly the
/// back of an object, such as walls modelled as a block, the other side is the front.
#[derive(Clone, Debug)]
pub struct FreePoses<'a> {
    scene: &'a Scene,
    camera: StereoCamera,
    seed: u32,
    clearance: f32,
    disparity: f32,
    surfaces: f32,
    /// Eye and target of the candidates, or empty for random ones.
    given: &'a [[DVec3; 2]],
}

/// Accepted random camera.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RandomPose {
    /// The camera.
    pub camera: StereoCamera,
    /// Number of candidates tried, including this one.
    pub tries: u32,
}

/// Number of rejected candidates by reason.
#[derive(Default)]
struct Rejected {
    near: u32,
    behind: u32,
    blocked: u32,
    disparity: u32,
    empty: u32,
}

impl<'a> FreePoses<'a> {
    /// Creates a generator of random cameras derived from `camera`, with a seed.
    ///
    /// # Errors
    /// [`Error::Camera`] for an invalid camera, [`Error::Scene`] for a scene that is empty or has infinite planes only.
    pub fn new(scene: &'a Scene, camera: StereoCamera, seed: u32) -> Result<Self, Error> {
        let pose = camera.pose()?;
        if scene.bounds().is_none() {
            let reason = "it is empty or has only infinite planes, so cameras can't be placed".into();
            return Err(Error::Scene { element: "the scene".into(), reason });
        }
        let (clearance, surfaces) = (2.0 * pose.interaxial, if is_inside(scene, pose.eye) { 0.5 } else { 0.1 });
        Ok(Self { scene, camera, seed, clearance, disparity: f32::INFINITY, surfaces, given: &[] })
    }

    /// Sets the minimum distance of surfaces from the midpoint between the eyes, in world units; twice the interaxial
    /// by default.
    pub fn clearance(mut self, distance: f32) -> Self {
        self.clearance = distance;
        self
    }

    /// Sets the maximum disparity in pixels, in front of the screen or behind it; unlimited by default.
    pub fn disparity(mut self, pixels: f32) -> Self {
        self.disparity = pixels;
        self
    }

    /// Sets the minimum share of the left picture that shows surfaces, 0 to 1. The default is 0.5 within a scene, and
    /// 0.1 outside it.
    pub fn surfaces(mut self, share: f32) -> Self {
        self.surfaces = share;
        self
    }

    /// Sets the candidates in place of random ones, by eye and target. They are in free space, and may be near sheets
    /// whose both sides are visible, so other sides of objects do not count.
    #[cfg(feature = "dataset")]
    pub(super) fn among(mut self, given: &'a [[DVec3; 2]]) -> Self {
        self.given = given;
        self
    }

    /// Returns the camera of an item, which depends only on the scene, the camera, the seed and the item's number.
    ///
    /// # Errors
    /// [`Error::Options`] if 2000 candidates were rejected, with the reasons; and the errors of
    /// [`Renderer::closest_hits`].
    pub async fn find(&self, renderer: &Renderer, uploaded: &UploadedScene, item: u32) -> Result<RandomPose, Error> {
        let given = self.camera.pose()?;
        let sides = match self.given.is_empty() {
            true => self.sides(given.eye, &self.around(renderer, uploaded, given.eye).await?),
            false => HashMap::new(),
        };
        let mut random = Random(pcg(pcg(self.seed).wrapping_add(item)));
        let mut rejected = Rejected::default();
        let most = if self.given.is_empty() { TRIES } else { self.given.len() as u32 };
        for tries in 1..=most {
            let camera = match self.given.get(tries as usize - 1) {
                Some([eye, target]) => self.camera.eye(*eye).target(*target),
                None => self.candidate(&given, &mut random),
            };
            let Ok(pose) = camera.pose() else { continue };
            let around = self.around(renderer, uploaded, pose.eye).await?;
            if around.iter().any(|hit| hit.t < self.clearance) {
                rejected.near += 1;
            } else if self.given.is_empty() && self.other_sides(pose.eye, &around, &sides) > OTHER_SIDES {
                rejected.behind += 1;
            } else if self.shows_enough(renderer, uploaded, &pose, &mut rejected).await? {
                return Ok(RandomPose { camera, tries });
            }
        }
        let Rejected { near, behind, blocked, disparity, empty } = rejected;
        let reason = format!(
            "no free camera position for item {item} in {most} tries: {near} too near a surface, {behind} inside an \
             object, {blocked} with a surface between the eyes, {disparity} with too large disparities, {empty} that \
             show too little"
        );
        Err(Error::Options { option: "poses", reason })
    }

    /// Returns a random camera without checking it.
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
        // The target is a random point in the inner half of the box.
        let target = within(low.midpoint(middle), high.midpoint(middle));
        let eye = middle + yaw * (self.scene.local(given.eye) - middle);
        self.camera.eye(to_world(eye)).target(to_world(target))
    }

    /// Traces rays in all directions from a point.
    async fn around(&self, renderer: &Renderer, uploaded: &UploadedScene, place: DVec3) -> Result<Vec<RayHit>, Error> {
        let rays: Vec<Ray> = (0..DIRECTIONS).map(|index| Ray::new(place, direction(index))).collect();
        Ok(renderer.closest_hits(uploaded, &rays).await?.hits)
    }

    /// Returns, for each object visible from a point, whether rays hit more back faces than front faces.
    fn sides(&self, place: DVec3, around: &[RayHit]) -> HashMap<u32, bool> {
        let mut balance = HashMap::<u32, i32>::new();
        for (object, behind) in self.faces(place, around) {
            *balance.entry(object).or_default() += if behind { 1 } else { -1 };
        }
        balance.into_iter().map(|(object, balance)| (object, balance > 0)).collect()
    }

    /// Returns the share of all directions in which an object shows its other side.
    fn other_sides(&self, place: DVec3, around: &[RayHit], sides: &HashMap<u32, bool>) -> f32 {
        let is_other = |(object, behind): &(u32, bool)| *behind != sides.get(object).copied().unwrap_or(false);
        self.faces(place, around).filter(is_other).count() as f32 / DIRECTIONS as f32
    }

    /// Returns, for each hit around a point, the object and whether its back face was hit.
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

    /// Returns whether the eyes see each other, and the picture shows enough surfaces with acceptable disparities.
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
                    let (origin, direction) = eye.ray(pixel[0], pixel[1]);
                    Ray::new(origin, direction.as_vec3())
                })
            })
            .collect();
        let [left, right] = [-1.0, 1.0].map(|side| pose.eye_position(side));
        if left != right {
            rays.push(Ray::new(left, (right - left).as_vec3()).t_max(1.0));
        }
        let hits = renderer.closest_hits(uploaded, &rays).await?.hits;
        let (seen, between) = hits.split_at(2 * across * down);
        let disparity = pose.disparities_of_rows();
        let too_far_aside = |(index, hit): (usize, &RayHit)| {
            let row = index % (across * down) / across;
            let row = (2 * row + 1) * height / (2 * down);
            disparity(row, hit.t).abs() >= f64::from(self.disparity)
        };
        let surfaces = seen[..across * down].iter().filter(|hit| hit.t.is_finite()).count();
        if between.iter().any(|hit| hit.t.is_finite()) {
            rejected.blocked += 1;
        } else if seen.iter().enumerate().any(too_far_aside) {
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

/// Returns a direction of an evenly spread spiral on the unit sphere.
fn direction(index: usize) -> Vec3 {
    const GOLDEN_ANGLE: f32 = 2.399_963_2;
    let z = 1.0 - (2 * index + 1) as f32 / DIRECTIONS as f32;
    let (sin, cos) = (index as f32 * GOLDEN_ANGLE).sin_cos();
    let across = (1.0 - z * z).sqrt();
    Vec3::new(across * cos, across * sin, z)
}
