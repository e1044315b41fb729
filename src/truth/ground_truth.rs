//! Ground truth for stereo vision, of both views of a pair. All ground truth files are written from one object.

use glam::{DVec3, Vec3};

use crate::{
    Error, MISS, Method, Occlusion, Pose, Renderer, Scene, StereoPair, UploadedScene, View,
    truth::{occlusion::Pixels, surface::at},
};

/// Ground truth of both views of a pair, made by [`Renderer::ground_truth`].
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
    /// Disparity `x_l - x_r` in pixels ([`StereoPair::disparity`]). Sky has the disparity of infinite depth. The list
    /// is empty for eyes with lenses ([`Renderer::correspondence`]).
    pub disparity: Vec<f32>,
    /// Whether the other eye sees the same point ([`Renderer::occlusions`]).
    pub occlusion: Vec<Occlusion>,
    /// Geometric normal facing the eye: unit length, world frame; zero for sky.
    pub geometric_normal: Vec<[f32; 3]>,
    /// Shading normal, interpolated where a mesh has normals, on the side of the geometric normal: unit length, world
    /// frame; zero for sky.
    pub shading_normal: Vec<[f32; 3]>,
    /// Id of the primitive, or [`MISS`].
    pub primitive: Vec<u32>,
    /// Id of the primitive's object ([`Scene::object_of`]), or [`MISS`].
    pub object: Vec<u32>,
    /// Id of the primitive's material ([`MaterialId`](crate::MaterialId)), or [`MISS`].
    pub material: Vec<u32>,
}

#[cfg(feature = "dataset")]
impl GroundTruth {
    /// Appends the rows of other ground truth below these.
    pub(crate) fn append(&mut self, below: Self) {
        self.left.append(below.left);
        self.right.append(below.right);
    }
}

impl EyeTruth {
    #[cfg(feature = "dataset")]
    fn append(&mut self, mut below: Self) {
        self.height += below.height;
        self.depth.append(&mut below.depth);
        self.distance.append(&mut below.distance);
        self.disparity.append(&mut below.disparity);
        self.occlusion.append(&mut below.occlusion);
        self.geometric_normal.append(&mut below.geometric_normal);
        self.shading_normal.append(&mut below.shading_normal);
        self.primitive.append(&mut below.primitive);
        self.object.append(&mut below.object);
        self.material.append(&mut below.material);
    }

    /// Returns, for each pixel, whether it shows no surface.
    pub fn sky(&self) -> Vec<bool> {
        self.primitive.iter().map(|&id| id == MISS).collect()
    }

    /// Returns, for each pixel, whether it shows a surface: the mask of KITTI's `disp_occ`.
    pub fn surfaces(&self) -> Vec<bool> {
        self.primitive.iter().map(|&id| id != MISS).collect()
    }

    /// Returns, for each pixel, whether it shows a surface point that the other eye sees too: the mask of KITTI's
    /// `disp_noc`.
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
    /// Computes the ground truth of both views of a pair: disparities, occlusions, depths, distances, normals and ids.
    /// Occlusions take one ray from the other eye to each point. `uploaded` must be the current state of `scene` or of
    /// a clone. `pair` must be rendered from it by [`Method::Naive`], [`Method::Auto`] or a [`Method::Bracket`], which
    /// hit each pixel's own surface.
    ///
    /// Occlusions are traced on the device. The rest is computed in f64 on the host, with some 50 bytes per pixel and
    /// eye.
    ///
    /// # Errors
    /// [`Error::Options`] for a pair without ids (the default [`GBuffer::Ids`](crate::GBuffer) has them) or by another
    /// method; [`Error::Scene`] if `scene` is not the uploaded scene, or lacks a primitive that the pair shows; and the
    /// errors of [`Renderer::occlusions`].
    pub async fn ground_truth(
        &self,
        uploaded: &UploadedScene,
        scene: &Scene,
        pair: &StereoPair,
    ) -> Result<GroundTruth, Error> {
        check_pair(pair)?;
        check_scene(uploaded, scene, pair)?;
        let occlusions = self.occlusions(uploaded, pair).await?;
        let (left, right) = (pair.disparity(), pair.right_disparity());
        Ok(GroundTruth {
            left: eye_truth(scene, &pair.left, &Pixels::of(&pair.pose, -0.5), left, occlusions.left),
            right: eye_truth(scene, &pair.right, &Pixels::of(&pair.pose, 0.5), right, occlusions.right),
            pose: pair.pose,
        })
    }
}

/// Checks that a pair shows the surfaces at its pixels' centres, and has their ids.
pub(super) fn check_pair(pair: &StereoPair) -> Result<(), Error> {
    let fault = |option, reason: String| Err(Error::Options { option, reason });
    if [&pair.left, &pair.right].iter().any(|view| view.primitive.len() != view.rgba8.len()) {
        return fault("g_buffer", "ground truth needs depths and ids; use GBuffer::Ids".into());
    }
    // With an interaxial of 0 both views equal the left view.
    let is_exact = matches!(pair.statistics.method, Method::Naive | Method::Bracket(_)) || pair.pose.interaxial == 0.0;
    if !is_exact {
        let method = pair.statistics.method;
        let reason = format!("{method} shows points up to half a pixel off; use naive, auto or a bracket method");
        return fault("method", format!("ground truth is for pixel centres, but {reason}"));
    }
    Ok(())
}

/// Checks that a scene is uploaded, and has the primitives that a pair shows.
pub(super) fn check_scene(uploaded: &UploadedScene, scene: &Scene, pair: &StereoPair) -> Result<(), Error> {
    if !uploaded.is_of(scene) {
        let reason = "neither it nor the scene it was cloned from was uploaded, or it has changed since".into();
        return Err(Error::Scene { element: "the ground truth's scene".into(), reason });
    }
    check_ids(scene, pair)
}

/// Checks that a scene has the primitives that a pair shows.
pub(super) fn check_ids(scene: &Scene, pair: &StereoPair) -> Result<(), Error> {
    let count = scene.primitive_count();
    let mut ids = [&pair.left, &pair.right].into_iter().flat_map(|view| &view.primitive);
    match ids.find(|&&id| id != MISS && id as usize >= count) {
        None => Ok(()),
        Some(id) => {
            let reason = format!("the scene has {count} primitives");
            Err(Error::Scene { element: format!("primitive {id} of a picture"), reason })
        }
    }
}

fn eye_truth(scene: &Scene, view: &View, pixels: &Pixels, disparity: Vec<f32>, occlusion: Vec<Occlusion>) -> EyeTruth {
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
    for (index, (&z, &id)) in view.depth.iter().zip(&view.primitive).enumerate() {
        let (eye, direction) = pixels.ray(index % width, index / width);
        let eye = eye - scene.origin();
        truth.distance.push((f64::from(z) * direction.length()) as f32);
        let (geometric, shading, material) = match id {
            MISS => (Vec3::ZERO, Vec3::ZERO, MISS),
            id => {
                let surface = at(scene, id, (eye, direction), f64::from(z));
                (surface.geometric_normal, surface.shading_normal, surface.material.0)
            }
        };
        truth.geometric_normal.push(geometric.to_array());
        truth.shading_normal.push(shading.to_array());
        truth.material.push(material);
    }
    truth
}
