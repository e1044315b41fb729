//! Ground truth for stereo vision, of both views of a pair: one object that all its files are written from.

use glam::DVec3;

use crate::{
    Error, MISS, MaterialId, Method, Occlusion, Pose, Renderer, Scene, StereoPair, UploadedScene, View,
    scene::{Primitive, ToSphere, Triangle},
    truth::occlusion::Pixels,
};

/// Ground truth of both views of a pair, made by [`Renderer::ground_truth_async`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GroundTruth {
    /// Ground truth of the left view.
    pub left: EyeTruth,
    /// Ground truth of the right view.
    pub right: EyeTruth,
    /// Camera of both views.
    pub pose: Pose,
}

/// Ground truth of one view. All lists are row-major, `[height][width]`, top row first. They describe the first surface
/// along the ray through a pixel's centre, even if it is a mirror or glass.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EyeTruth {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Depth `Z` along the view direction in world units; `f32::INFINITY` for sky.
    pub depth: Vec<f32>,
    /// Distance from the eye along the pixel's ray in world units; `f32::INFINITY` for sky.
    pub distance: Vec<f32>,
    /// Disparity `x_l - x_r` in pixels ([`StereoPair::disparity`]). Sky has the disparity of infinite depth.
    pub disparity: Vec<f32>,
    /// Whether the other eye sees the same point ([`Renderer::occlusions_async`]).
    pub occlusion: Vec<Occlusion>,
    /// Geometric normal facing the eye: unit length, world frame; zero for sky.
    pub geometric_normal: Vec<[f32; 3]>,
    /// Shading normal, interpolated where a mesh has normals, on the side of the geometric one: unit length, world
    /// frame; zero for sky.
    pub shading_normal: Vec<[f32; 3]>,
    /// Id of the primitive, or [`MISS`].
    pub primitive: Vec<u32>,
    /// Id of the primitive's object ([`Scene::object_of`]), or [`MISS`].
    pub object: Vec<u32>,
    /// Id of the primitive's material ([`MaterialId`]), or [`MISS`].
    pub material: Vec<u32>,
}

impl EyeTruth {
    /// Returns whether each pixel shows no surface.
    pub fn sky(&self) -> Vec<bool> {
        self.primitive.iter().map(|&id| id == MISS).collect()
    }

    /// Returns whether each pixel shows a surface: the mask of KITTI's `disp_occ`.
    pub fn surfaces(&self) -> Vec<bool> {
        self.primitive.iter().map(|&id| id != MISS).collect()
    }

    /// Returns whether each pixel shows a surface point that the other eye sees too: the mask of KITTI's `disp_noc`.
    pub fn surfaces_of_both(&self) -> Vec<bool> {
        let pixels = self.primitive.iter().zip(&self.occlusion);
        pixels.map(|(&id, &found)| id != MISS && found == Occlusion::Visible).collect()
    }
}

impl Pose {
    /// Transforms world directions, such as normals, to the camera's frame: x to the picture's right, y down, z along
    /// the view direction, as in `OpenCV`. Both eyes have the same axes.
    pub fn in_camera(&self, directions: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let axes = [self.right, -self.up, self.forward].map(|axis| axis.as_dvec3());
        let turned = |direction: &[f32; 3]| {
            let direction = DVec3::from_array(direction.map(f64::from));
            axes.map(|axis| axis.dot(direction) as f32)
        };
        directions.iter().map(turned).collect()
    }
}

impl Renderer {
    /// Computes the ground truth of both views of a pair: disparities, occlusions (one ray from the other eye to each
    /// point), depths, distances, normals and ids. `uploaded` must be the current state of `scene` or of a clone.
    /// `pair` must be rendered from it by [`Method::Naive`], [`Method::Auto`] or a [`Method::Bracket`], which hit each
    /// pixel's own surface.
    ///
    /// Occlusions are traced on the device. The rest is computed in f64 on the host, with some 50 bytes per pixel and
    /// eye.
    ///
    /// # Errors
    /// [`Error::Options`] for a pair without ids (the default [`GBuffer::Ids`](crate::GBuffer) has them) or by another
    /// method; [`Error::Scene`] if `scene` is not the uploaded one, or lacks a primitive that the pair shows; and the
    /// errors of [`Renderer::occlusions_async`].
    pub async fn ground_truth_async(
        &self,
        uploaded: &UploadedScene,
        scene: &Scene,
        pair: &StereoPair,
    ) -> Result<GroundTruth, Error> {
        check(uploaded, scene, pair)?;
        let occlusions = self.occlusions_async(uploaded, pair).await?;
        let (left, right) = (pair.disparity(), pair.right_disparity());
        Ok(GroundTruth {
            left: eye_truth(scene, &pair.left, &Pixels::of(&pair.pose, -0.5), left, occlusions.left)?,
            right: eye_truth(scene, &pair.right, &Pixels::of(&pair.pose, 0.5), right, occlusions.right)?,
            pose: pair.pose,
        })
    }
}

fn check(uploaded: &UploadedScene, scene: &Scene, pair: &StereoPair) -> Result<(), Error> {
    let fault = |option, reason: String| Err(Error::Options { option, reason });
    if [&pair.left, &pair.right].iter().any(|view| view.primitive.len() != view.rgba8.len()) {
        return fault("g_buffer", "ground truth needs depths and ids; use GBuffer::Ids".into());
    }
    // Without interaxial both views are the left one.
    let is_exact = matches!(pair.statistics.method, Method::Naive | Method::Bracket(_)) || pair.pose.interaxial == 0.0;
    if !is_exact {
        let method = pair.statistics.method;
        let reason = format!("{method} shows points up to half a pixel off; use naive, auto or a bracket method");
        return fault("method", format!("ground truth is for pixel centres, but {reason}"));
    }
    if !uploaded.is_of(scene) {
        let reason = "neither it nor the scene it was cloned from was uploaded, or it has changed since".into();
        return Err(Error::Scene { element: "the ground truth's scene".into(), reason });
    }
    Ok(())
}

fn eye_truth(
    scene: &Scene,
    view: &View,
    pixels: &Pixels,
    disparity: Vec<f32>,
    occlusion: Vec<Occlusion>,
) -> Result<EyeTruth, Error> {
    let width = (view.width as usize).max(1);
    let count = view.primitive.len();
    let mut truth = EyeTruth {
        width: view.width,
        height: view.height,
        depth: view.depth.clone(),
        distance: Vec::with_capacity(count),
        disparity,
        occlusion,
        geometric_normal: Vec::with_capacity(count),
        shading_normal: Vec::with_capacity(count),
        primitive: view.primitive.clone(),
        object: view.object.clone(),
        material: Vec::with_capacity(count),
    };
    let eye = pixels.eye() - scene.origin();
    for (index, (&z, &id)) in view.depth.iter().zip(&view.primitive).enumerate() {
        let direction = pixels.direction(index % width, index / width);
        truth.distance.push((f64::from(z) * direction.length()) as f32);
        let surface = match id {
            MISS => Surface::NONE,
            id if (id as usize) < scene.primitive_count() => {
                surface(&scene.primitive(id), eye, direction, f64::from(z))
            }
            id => {
                let reason = format!("the scene has {} primitives", scene.primitive_count());
                return Err(Error::Scene { element: format!("primitive {id} of a picture"), reason });
            }
        };
        truth.geometric_normal.push(surface.geometric.as_vec3().to_array());
        truth.shading_normal.push(surface.shading.as_vec3().to_array());
        truth.material.push(surface.material);
    }
    Ok(truth)
}

/// Surface at a ray's hit: the f64 counterpart of `surface_of` in shaders/shared.
struct Surface {
    geometric: DVec3,
    shading: DVec3,
    material: u32,
}

impl Surface {
    const NONE: Self = Self { geometric: DVec3::ZERO, shading: DVec3::ZERO, material: MISS };

    /// Creates a surface lit by its geometric normal, which may have any length but 0.
    fn flat(normal: DVec3, direction: DVec3, material: MaterialId) -> Self {
        let normal = towards_viewer(normal, direction);
        Self { geometric: normal, shading: normal, material: material.0 }
    }
}

/// Returns the surface where a ray from the eye, relative to the scene's origin, hits a primitive near `t`.
fn surface(primitive: &Primitive<'_>, eye: DVec3, direction: DVec3, t: f64) -> Surface {
    match *primitive {
        Primitive::Triangle(triangle) => triangle_surface(triangle, eye, direction),
        Primitive::Plane(plane) => Surface::flat(plane.unit_normal().as_dvec3(), direction, plane.material),
        Primitive::Sphere(sphere) => {
            let outward = outward(&ToSphere::identity(sphere.radius), eye - sphere.center.as_dvec3(), direction, t);
            Surface::flat(outward, direction, sphere.material)
        }
        Primitive::Ellipsoid(ellipsoid) => {
            let outward = outward(&ellipsoid.to_sphere(), eye - ellipsoid.center.as_dvec3(), direction, t);
            Surface::flat(outward, direction, ellipsoid.material)
        }
    }
}

fn towards_viewer(normal: DVec3, direction: DVec3) -> DVec3 {
    let unit = normal.normalize_or_zero();
    if unit.dot(direction) > 0.0 { -unit } else { unit }
}

fn triangle_surface(triangle: &Triangle, eye: DVec3, direction: DVec3) -> Surface {
    let [a, b, c] = triangle.corners.map(|corner| corner.as_dvec3() - eye);
    let flat = Surface::flat((b - a).cross(c - a), direction, triangle.material);
    if !triangle.is_smooth() {
        return flat;
    }
    // A corner's barycentric weight is the volume that the ray spans with the opposite edge. Rounding may leave the
    // point slightly outside.
    let volumes = [b.cross(c), c.cross(a), a.cross(b)].map(|edge| edge.dot(direction));
    let sign = volumes.iter().sum::<f64>().signum();
    let shares = volumes.map(|volume| (sign * volume).max(0.0));
    let normals = triangle.normals.map(|normal| normal.as_dvec3().normalize_or_zero());
    let sum: f64 = shares.iter().sum();
    let blend = normals.iter().zip(shares).map(|(normal, share)| *normal * (share / sum)).sum::<DVec3>();
    // As in the kernels, the geometric normal is used if the normals cancel each other or the blend is NaN, as with
    // slivers.
    let is_usable = blend.length_squared() > 1e-6;
    if !is_usable {
        return flat;
    }
    let unit = blend.normalize();
    Surface { shading: if unit.dot(flat.geometric) < 0.0 { -unit } else { unit }, ..flat }
}

/// Returns the normal, of any length, where a ray hits an ellipsoid near `t`. The hit is computed again, because the
/// rounding of a depth may be large compared with the radius of a small ellipsoid.
fn outward(map: &ToSphere, from_center: DVec3, direction: DVec3, t: f64) -> DVec3 {
    let rows = map.rows.map(|row| row.as_dvec3());
    let mapped = |vector: DVec3| DVec3::from_array(rows.map(|row| row.dot(vector)));
    let (origin, along, radius) = (mapped(from_center), mapped(direction), f64::from(map.radius));
    let middle = -origin.dot(along) / along.length_squared();
    let nearest = origin + along * middle;
    // A ray that misses by rounding is taken to hit at its closest approach.
    let half = ((radius * radius - nearest.length_squared()).max(0.0) / along.length_squared()).sqrt();
    let met = nearest + along * if t < middle { -half } else { half };
    rows[0] * met.x + rows[1] * met.y + rows[2] * met.z
}
