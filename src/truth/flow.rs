//! Ground truth for motion: where the points of a pair are at another time, in f64 on the host.

use std::ops::Range;

use glam::DVec3;
#[cfg(not(target_arch = "wasm32"))]
use rayon::prelude::*;

use crate::{
    Error, MISS, Pose, Projection, Ray, Renderer, Scene, StereoCamera, StereoPair, UploadedScene, View,
    truth::{
        ground_truth::{check_ids, check_pair},
        occlusion::Pixels,
        surface::{Moved, moved},
    },
    view::camera::Projector,
};

/// A ray has reached a point if it hits another primitive at most this share of the distance before the point. The
/// value exceeds the rounding of directions, except on surfaces seen edge-on.
pub(super) const SAME_POINT: f64 = 1.0 / 65536.0;
/// Number of pixels whose rays are traced at once. It limits the memory for them, and large lists would make the system
/// map fresh memory for each view.
const PART: usize = 1 << 17;

/// A scene and a camera at a time ([`Renderer::flow`]). The scene has the primitives of the pair's scene at other
/// positions.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// The scene at this time.
    pub scene: &'a Scene,
    /// The scene on the device, in the same state.
    pub uploaded: &'a UploadedScene,
    /// The camera at this time. Its picture may have another size than the pair.
    pub camera: &'a StereoCamera,
}

/// Whether an eye sees a point at the other time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u8)]
pub enum FlowClass {
    /// The eye sees the point.
    Visible = 0,
    /// A nearer surface hides it.
    Hidden = 1,
    /// It lies outside the picture.
    OutOfFrame = 2,
    /// It has no place in the picture: it is behind the eye, or within the viewing circle. Its flow and its disparity
    /// change are NaN.
    Behind = 3,
}

/// Motion of the points that a pair shows, made by [`Renderer::flow`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Flow {
    /// Motion of the left view's points.
    pub left: EyeFlow,
    /// Motion of the right view's points.
    pub right: EyeFlow,
}

/// Motion of the points that a view shows. All lists are row-major, `[height][width]`, top row first. They describe the
/// first surface along the ray through a pixel's centre, as [`EyeTruth`](crate::EyeTruth) does.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EyeFlow {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Optical flow in pixels, to the right and down: the point's place in this eye's picture at the other time, minus
    /// the pixel's centre. Sky moves by the camera's rotation alone. In a picture of all directions, flow takes the
    /// shorter way round. It is NaN for a point in a direction that the lens does not show
    /// ([`FlowClass::OutOfFrame`]).
    pub flow: Vec<[f32; 2]>,
    /// The point's disparity `x_l - x_r` at the other time minus its disparity now, in pixels. It is NaN for eyes with
    /// lenses.
    pub disparity_change: Vec<f32>,
    /// Scene flow: the point's displacement in world units, in the world's frame. It is 0 for sky.
    /// [`Pose::in_camera`] transforms it to the camera's frame.
    pub displacement: Vec<[f32; 3]>,
    /// Whether the eye sees the point at the other time.
    pub class: Vec<FlowClass>,
}

impl EyeFlow {
    /// Returns, for each pixel, whether its flow is a number.
    pub fn known(&self) -> Vec<bool> {
        self.class.iter().map(|&class| class != FlowClass::Behind).collect()
    }

    /// Returns, for each pixel, whether the eye sees its point at the other time.
    pub fn visible(&self) -> Vec<bool> {
        self.class.iter().map(|&class| class == FlowClass::Visible).collect()
    }
}

impl Renderer {
    /// Computes where the points of a pair are at another time: optical flow, change of disparity, scene flow, and
    /// whether the same eye sees them. `scene` must be the scene that the pair shows. Pairs need what
    /// [`Renderer::ground_truth`] needs.
    ///
    /// The point of a pixel is where its ray meets the primitive. It keeps its barycentric coordinates on a triangle,
    /// and its coordinates along the axes of an ellipsoid or a plane. Spheres do not turn. All this is computed in f64
    /// on the host. One ray per pixel from the eye at the other time finds whether it sees the point.
    ///
    /// ```
    /// use stereotrace::{
    ///     Builtin, Gpu, Moment, Renderer, StereoCamera, Update, blocking::Wait, glam::{Affine3A, Vec3},
    /// };
    ///
    /// let (before, camera) = (Builtin::Near.scene(), Builtin::Near.camera(64, 48));
    /// let mut after = before.clone();
    /// after.transform_object(0, &Affine3A::from_translation(Vec3::new(0.1, 0.0, 0.0)))?;
    /// let mut renderer = Renderer::new(Gpu::new().wait()?);
    /// let mut uploaded = renderer.upload(&before).wait()?;
    /// let pair = renderer.pair(&uploaded, &camera).read().wait()?;
    /// renderer.update(&mut uploaded, &after, Update::Refit).wait()?;
    /// let then = Moment { scene: &after, uploaded: &uploaded, camera: &camera };
    /// let flow = renderer.flow(&pair, &before, then).wait()?;
    /// let moved = pair.left.object.iter().zip(&flow.left.displacement).filter(|(object, _)| **object == 0);
    /// assert!(moved.into_iter().all(|(_, [x, ..])| (x - 0.1).abs() < 1e-6));
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Options`] for a pair without ids or by a method that copies pixels; [`Error::Rig`] for toed-in eyes;
    /// [`Error::Scene`] if the scenes differ in more than positions, or if `then.scene` is not the uploaded scene;
    /// [`Error::Camera`] for a camera of another projection than the pair's; and the errors of
    /// [`Renderer::closest_hits`].
    pub async fn flow(&self, pair: &StereoPair, scene: &Scene, then: Moment<'_>) -> Result<Flow, Error> {
        check_pair(pair)?;
        let motion = Motion { now: (scene, pair.pose), then: (then.scene, checked(pair, scene, &then)?) };
        Ok(Flow {
            left: self.eye_flow(&pair.left, &motion, -1.0, then.uploaded).await?,
            right: self.eye_flow(&pair.right, &motion, 1.0, then.uploaded).await?,
        })
    }

    async fn eye_flow(
        &self,
        view: &View,
        motion: &Motion<'_>,
        side: f32,
        uploaded: &UploadedScene,
    ) -> Result<EyeFlow, Error> {
        let count = view.primitive.len();
        let mut found = EyeFlow {
            width: view.width,
            height: view.height,
            flow: Vec::with_capacity(count),
            disparity_change: Vec::with_capacity(count),
            displacement: Vec::with_capacity(count),
            class: Vec::with_capacity(count),
        };
        let own = EyeMotion::of(motion, side);
        let eye = Pixels::of(&motion.then.1, 0.5 * f64::from(side));
        for first in (0..count).step_by(PART) {
            let points = own.points(view, first..count.min(first + PART));
            let ray = |point: &Point| {
                let (origin, direction) = eye.ray_through(point.place);
                Ray::new(origin, direction.as_vec3()).t_max(point.reached_from() as f32)
            };
            let in_frame = points.iter().filter(|point| point.class == FlowClass::Visible);
            let rays: Vec<Ray> = in_frame.map(ray).collect();
            let hits = self.nearer_hits(uploaded, &rays).await?;
            let mut hits = hits.iter().zip(&rays);
            for point in points {
                found.flow.push(point.flow);
                found.disparity_change.push(point.disparity_change);
                found.displacement.push(point.displacement);
                let is_hidden = point.class == FlowClass::Visible
                    && hits.next().is_some_and(|(hit, ray)| {
                        let is_itself =
                            hit.primitive == point.primitive && point.outward.dot(ray.direction.as_dvec3()) <= 0.0;
                        !is_itself && f64::from(hit.t) < point.reached_from()
                    });
                found.class.push(if is_hidden { FlowClass::Hidden } else { point.class });
            }
        }
        Ok(found)
    }
}

/// Returns the pose at the other time, and checks that the scenes have the same primitives.
fn checked(pair: &StereoPair, scene: &Scene, then: &Moment<'_>) -> Result<Pose, Error> {
    let fault = |element: String, reason: String| Err(Error::Scene { element, reason });
    if let Some(reason) = scene.other_topology(then.scene) {
        return fault("the scene at the other time".into(), reason);
    }
    if !then.uploaded.is_of(then.scene) {
        let reason = "neither it nor the scene it was cloned from was uploaded, or it has changed since";
        return fault("the scene at the other time".into(), reason.into());
    }
    check_ids(scene, pair)?;
    let pose = then.camera.pose_in(then.scene.origin())?;
    if [pair.pose.projection, pose.projection].contains(&Projection::ToeIn) {
        return Err(Error::Rig { reason: "toed-in eyes have no disparity, which flow needs".into() });
    }
    let is_same = match (pair.pose.projection, pose.projection) {
        (Projection::OffAxis, Projection::OffAxis) | (Projection::Lenses(_), Projection::Lenses(_)) => true,
        (Projection::Equirectangular(now), Projection::Equirectangular(then)) => now == then,
        _ => false,
    };
    if !is_same {
        let value = match pose.projection {
            Projection::OffAxis | Projection::ToeIn => "planar",
            Projection::Lenses(_) => "of lenses",
            Projection::Equirectangular(_) => "equirectangular",
        };
        let reason = "it must be the pair's, with the same span and pole merge";
        return Err(Error::Camera { field: "projection", value: value.into(), reason });
    }
    Ok(pose)
}

/// Scenes and poses at both times.
struct Motion<'a> {
    now: (&'a Scene, Pose),
    then: (&'a Scene, Pose),
}

/// Motion of a pixel's point. Points in front of the other picture have the class [`FlowClass::Visible`], before rays
/// are traced.
struct Point {
    /// Column and row in the other picture.
    place: [f64; 2],
    /// Depth at the other time.
    depth: f64,
    primitive: u32,
    /// Outward normal of a closed primitive at the other time, of any length; zero for other primitives.
    outward: DVec3,
    flow: [f32; 2],
    disparity_change: f32,
    displacement: [f32; 3],
    class: FlowClass,
}

impl Point {
    /// Returns the depth from which on a hit is taken as the point.
    fn reached_from(&self) -> f64 {
        self.depth * (1.0 - SAME_POINT)
    }
}

/// Rays of one eye's pixels, and projections of their points at both times.
struct EyeMotion<'a> {
    motion: &'a Motion<'a>,
    side: f64,
    pixels: Pixels,
    /// Projects points into the other eye's picture now.
    other_now: Projector,
    /// Projects points into the pictures of this eye and the other one at the other time.
    own: Projector,
    other: Projector,
    /// Widths of pictures of all directions, now and at the other time.
    turns: [Option<f64>; 2],
    has_rows: bool,
}

impl<'a> EyeMotion<'a> {
    fn of(motion: &'a Motion<'a>, side: f32) -> Self {
        let [now, then] = [&motion.now.1, &motion.then.1];
        Self {
            motion,
            side: side.into(),
            pixels: Pixels::of(now, 0.5 * f64::from(side)),
            other_now: now.projector(-side),
            own: then.projector(side),
            other: then.projector(-side),
            turns: [now, then].map(|pose| pose.circle().and_then(|circle| circle.turn)),
            has_rows: now.projection.without_rows().is_none(),
        }
    }

    /// Returns the points of a range of a view's pixels.
    fn points(&self, view: &View, pixels: Range<usize>) -> Vec<Point> {
        let width = (view.width as usize).max(1);
        let point = |index: usize| {
            let pixel = [index % width, index / width];
            let ray = self.pixels.ray(pixel[0], pixel[1]);
            let center = pixel.map(|place| place as f64 + 0.5);
            match view.primitive[index] {
                MISS => self.sky(center, ray.1),
                id => self.surface(center, ray, (id, view.depth[index])),
            }
        };
        #[cfg(not(target_arch = "wasm32"))]
        return pixels.into_par_iter().map(point).collect();
        #[cfg(target_arch = "wasm32")]
        pixels.map(point).collect()
    }

    fn sky(&self, center: [f64; 2], direction: DVec3) -> Point {
        let [now, then] = [&self.motion.now.1, &self.motion.then.1];
        let place = self.own.project_direction(direction);
        let apart = f64::from(now.interaxial_px) - f64::from(then.interaxial_px);
        self.point(center, place.map(|place| (place, f64::INFINITY)), apart, DVec3::ZERO, (MISS, DVec3::ZERO))
    }

    fn surface(&self, center: [f64; 2], (origin, direction): (DVec3, DVec3), (id, depth): (u32, f32)) -> Point {
        let (now, then) = (self.motion.now.0, self.motion.then.0);
        let primitives = (&now.primitive(id), &then.primitive(id));
        let Some(Moved { positions: [before, after], outward }) =
            moved(primitives, (origin - now.origin(), direction), f64::from(depth))
        else {
            unreachable!("the scenes have the same topology");
        };
        let (before, after) = (before + now.origin(), after + then.origin());
        let [x, y, z] = self.own.project(after);
        let place = (z > 0.0).then_some(([x, y], z));
        let disparity = |turn, own: f64, other: f64| self.side * shorter_way(turn, other - own);
        let [now_in_other, ..] = self.other_now.project(before);
        let [in_other, ..] = self.other.project(after);
        let change = disparity(self.turns[1], x, in_other) - disparity(self.turns[0], center[0], now_in_other);
        self.point(center, place, change, after - before, (id, outward))
    }

    fn point(
        &self,
        center: [f64; 2],
        seen: Option<([f64; 2], f64)>,
        change: f64,
        displacement: DVec3,
        (primitive, outward): (u32, DVec3),
    ) -> Point {
        let (place, depth) = seen.unwrap_or(([f64::NAN; 2], f64::NAN));
        let [width, height] = self.motion.then.1.size.map(f64::from);
        let is_inside = (0.0..width).contains(&place[0]) && (0.0..height).contains(&place[1]);
        let class = match seen {
            None => FlowClass::Behind,
            Some(_) if is_inside => FlowClass::Visible,
            Some(_) => FlowClass::OutOfFrame,
        };
        Point {
            place,
            depth,
            primitive,
            outward,
            flow: [shorter_way(self.turns[1], place[0] - center[0]) as f32, (place[1] - center[1]) as f32],
            disparity_change: if class == FlowClass::Behind || !self.has_rows { f32::NAN } else { change as f32 },
            displacement: displacement.as_vec3().to_array(),
            class,
        }
    }
}

/// Returns a difference of columns, by the shorter way round a picture of all directions with so many columns.
pub(super) fn shorter_way(turn: Option<f64>, columns: f64) -> f64 {
    turn.map_or(columns, |turn| columns - turn * (columns / turn).round())
}
