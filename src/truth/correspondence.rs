//! Where the other eye's picture shows the point of each pixel, for all kinds of cameras.

use glam::DVec3;
#[cfg(not(target_arch = "wasm32"))]
use rayon::prelude::*;

use super::occlusion::{Pixels, SAME_POINT_PX};
use crate::{
    Error, Occlusion, Pose, Projection, Ray, Renderer, StereoPair, UploadedScene, View, view::camera::Projector,
};

/// Whether the other eye sees the point of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u8)]
pub enum MatchClass {
    /// The other eye sees it.
    Visible = 0,
    /// A nearer surface hides it.
    Hidden = 1,
    /// It lies outside the other picture. Its place is NaN if the other eye's lens does not show its direction at all.
    OutOfFrame = 2,
    /// It is behind the other eye, or within the viewing circle. Its place is NaN.
    Behind = 3,
}

/// Correspondence of the pictures of a pair, made by [`Renderer::correspondence`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Correspondence {
    /// Where the right picture shows the points of the left view.
    pub left: EyeMatches,
    /// Where the left picture shows the points of the right view.
    pub right: EyeMatches,
}

/// Where the other eye's picture shows the points of a view. All lists are row-major, `[height][width]`, top row first.
/// They describe the first surface along the ray through a pixel's centre.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EyeMatches {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The point's place x, y in the other picture: pixels from its top left corner, with pixel centres at halves. Sky
    /// lies at infinity.
    pub place: Vec<[f32; 2]>,
    /// Whether the other eye sees the point.
    pub class: Vec<MatchClass>,
}

impl EyeMatches {
    /// Returns, for each pixel, whether the other eye sees its point.
    pub fn visible(&self) -> Vec<bool> {
        self.class.iter().map(|&class| class == MatchClass::Visible).collect()
    }
}

impl Renderer {
    /// Computes where the other eye's picture shows the point of each pixel, in two dimensions, and whether that eye
    /// sees the point. With lenses ([`StereoCamera::lenses`](crate::StereoCamera::lenses)) and toed-in eyes, points
    /// don't stay in their rows, so this replaces disparities. Other pairs have correspondences too.
    ///
    /// `pair` is a picture of `scene` with depths (the default [`GBuffer::Ids`](crate::GBuffer) has them). Places are
    /// computed in f64 from depths. One ray per pixel from the other eye finds whether it sees the point.
    ///
    /// ```
    /// use stereotrace::{Builtin, Distortion, Gpu, Lens, MatchClass, Renderer, blocking::Wait};
    ///
    /// let lens = Lens::new([60.0; 2], [32.0, 24.0]).distortion(Distortion::opencv(&[-0.2, 0.03, 1e-3, 0.0])?);
    /// let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(64, 48).interaxial(0.2).lens(lens));
    /// let mut renderer = Renderer::new(Gpu::new().wait()?);
    /// let uploaded = renderer.upload(&scene).wait()?;
    /// let pair = renderer.pair(&uploaded, &camera).read().wait()?;
    /// let matches = renderer.correspondence(&uploaded, &pair).wait()?;
    /// assert!(matches.left.class.contains(&MatchClass::Visible));
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Options`] for a pair without depths, and the errors of [`Renderer::closest_hits`].
    pub async fn correspondence(&self, scene: &UploadedScene, pair: &StereoPair) -> Result<Correspondence, Error> {
        Ok(Correspondence {
            left: self.matches_of(scene, &pair.left, &pair.pose, -1.0).await?,
            right: self.matches_of(scene, &pair.right, &pair.pose, 1.0).await?,
        })
    }

    /// Returns the matches of the view of an eye (-1 left, 1 right).
    async fn matches_of(
        &self,
        scene: &UploadedScene,
        view: &View,
        pose: &Pose,
        side: f32,
    ) -> Result<EyeMatches, Error> {
        if view.depth.len() != view.rgba8.len() {
            let reason = "correspondence needs depths; these pictures have none".into();
            return Err(Error::Options { option: "g_buffer", reason });
        }
        let eyes = BothEyes::of(pose, side);
        let points = eyes.points(view);
        let in_frame = || points.iter().filter(|point| point.class == MatchClass::Visible);
        let rays: Vec<Ray> = in_frame().map(|point| point.ray).collect();
        let hits = self.closest_hits(scene, &rays).await?.hits;
        let mut hits = hits.iter();
        let class = points.iter().map(|point| match point.class {
            MatchClass::Visible if hits.next().is_some_and(|hit| eyes.hides(point, hit.t)) => MatchClass::Hidden,
            class => class,
        });
        let class = class.collect();
        let place = points.iter().map(|point| point.place.map(|place| place as f32)).collect();
        Ok(EyeMatches { width: view.width, height: view.height, place, class })
    }

    /// Returns the occlusion of both views by their correspondence.
    pub(super) async fn matched_occlusions(
        &self,
        scene: &UploadedScene,
        pair: &StereoPair,
    ) -> Result<[Vec<Occlusion>; 2], Error> {
        let Correspondence { left, right } = self.correspondence(scene, pair).await?;
        let occlusion = |class: &MatchClass| match class {
            MatchClass::Visible => Occlusion::Visible,
            MatchClass::Hidden => Occlusion::Hidden,
            MatchClass::OutOfFrame | MatchClass::Behind => Occlusion::OutOfFrame,
        };
        Ok([left, right].map(|eye| eye.class.iter().map(occlusion).collect()))
    }
}

/// The rays of an eye's pixels, and the projection into the other eye's picture.
struct BothEyes {
    pixels: Pixels,
    own: Projector,
    other: Projector,
    /// Position of the other eye, or `None` in pictures of all directions, whose rays start on a circle.
    other_eye: Option<DVec3>,
    other_pixels: Pixels,
    pose: Pose,
}

/// A pixel's point. Points in front of the other picture have the class [`MatchClass::Visible`], before rays are
/// traced.
struct Point {
    /// Column and row of the pixel's centre.
    center: [f64; 2],
    /// Column and row in the other picture.
    place: [f64; 2],
    class: MatchClass,
    /// A ray from the other eye to the point.
    ray: Ray,
    /// The ray's t at the point, infinite for sky.
    t: f64,
}

impl BothEyes {
    fn of(pose: &Pose, side: f32) -> Self {
        let is_turned = pose.projection == Projection::ToeIn;
        let pixels_of = |side: f32| match is_turned {
            true => Pixels::of(&pose.of_eye(side), 0.0),
            false => Pixels::of(pose, 0.5 * f64::from(side)),
        };
        Self {
            pixels: pixels_of(side),
            own: pose.projector(side),
            other: pose.projector(-side),
            other_eye: pose.circle().is_none().then(|| pose.eye_position(-side)),
            other_pixels: pixels_of(-side),
            pose: *pose,
        }
    }

    fn points(&self, view: &View) -> Vec<Point> {
        let width = (view.width as usize).max(1);
        let point =
            |(index, &z): (usize, &f32)| self.point([index % width, index / width].map(|at| at as f64 + 0.5), z);
        #[cfg(not(target_arch = "wasm32"))]
        return view.depth.par_iter().enumerate().map(point).collect();
        #[cfg(target_arch = "wasm32")]
        view.depth.iter().enumerate().map(point).collect()
    }

    fn point(&self, center: [f64; 2], z: f32) -> Point {
        let (origin, direction) = self.pixels.ray_through(center);
        let is_sky = z == f32::INFINITY;
        let at = origin + direction * if is_sky { 0.0 } else { f64::from(z) };
        let [x, y, depth] = match is_sky {
            false => self.other.project(at),
            true => match self.other.project_direction(direction) {
                Some([x, y]) => [x, y, f64::INFINITY],
                // The lens does not show the direction.
                None => [f64::NAN, f64::NAN, if self.is_before_other(direction) { f64::INFINITY } else { -1.0 }],
            },
        };
        let class = match depth > 0.0 {
            false => MatchClass::Behind,
            true if self.shows([x, y]) => MatchClass::Visible,
            true => MatchClass::OutOfFrame,
        };
        let place = if class == MatchClass::Behind { [f64::NAN; 2] } else { [x, y] };
        let (ray, t) = match self.other_eye {
            Some(eye) if is_sky => (Ray::new(eye, direction.as_vec3()), f64::INFINITY),
            Some(eye) => (Ray::new(eye, (at - eye).as_vec3()), 1.0),
            None => {
                let (eye, direction) = self.other_pixels.ray_through(place);
                (Ray::new(eye, direction.as_vec3()), depth)
            }
        };
        Point { center, place, class, ray, t }
    }

    /// Returns whether the other eye looks towards a direction.
    fn is_before_other(&self, direction: DVec3) -> bool {
        direction.dot(self.pose.forward.as_dvec3()) > 0.0
    }

    /// Returns whether the other picture contains a place.
    fn shows(&self, [column, row]: [f64; 2]) -> bool {
        let [width, height] = self.pose.size.map(f64::from);
        (0.0..width).contains(&column) && (0.0..height).contains(&row)
    }

    /// Returns whether a hit of the other eye's ray hides the point. Hits that this eye sees at the point's own place
    /// are the point itself.
    fn hides(&self, point: &Point, t: f32) -> bool {
        if f64::from(t) >= point.t || t == f32::INFINITY {
            return false;
        }
        let [x, y, _] = self.own.project(point.ray.origin + point.ray.direction.as_dvec3() * f64::from(t));
        let [column, row] = point.center;
        let is_itself = (x - column).hypot(y - row) <= SAME_POINT_PX;
        !is_itself
    }
}
