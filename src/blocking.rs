//! Blocking forms: each runs its async form to the end on the calling thread. The feature `blocking` enables them,
//! except on wasm32, where blocking stops the browser from finishing the work.

use std::ops::ControlFlow;

use pollster::block_on;

#[cfg(feature = "png")]
use crate::output::dataset::{FreePoses, RandomPose};
use crate::{
    BvhBuild, Cast, Encoded, Error, Gpu, GroundTruth, Occlusions, OnProgress, OnRows, Options, Ray, RayHit, Renderer,
    Rig, Scene, Statistics, StereoCamera, StereoPair, Update, UploadedScene, Views, gpu::Adapter, render_stereo_async,
    render_views_async,
};

impl Gpu {
    /// Opens a device and blocks: see [`Gpu::new_async`].
    ///
    /// # Errors
    /// As [`Gpu::open_async`].
    pub fn new() -> Result<Self, Error> {
        block_on(Self::new_async())
    }

    /// Opens an adapter and blocks: see [`Gpu::open_async`].
    ///
    /// ```no_run
    /// use stereotrace::{Adapter, Gpu};
    ///
    /// let gpu = Gpu::open(Adapter::Software)?; // or Gpu::open("software")
    /// println!("{}", gpu.adapter_name());
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Gpu::open_async`].
    pub fn open(adapter: impl Into<Adapter>) -> Result<Self, Error> {
        block_on(Self::open_async(adapter))
    }
}

impl Renderer {
    /// Builds a scene's BVH with [`BvhBuild::Balanced`], which suits a few pictures, and uploads it. Blocks.
    ///
    /// # Errors
    /// As [`Renderer::upload_async`].
    pub fn upload(&self, scene: &Scene) -> Result<UploadedScene, Error> {
        self.upload_with(scene, BvhBuild::Balanced)
    }

    /// Builds a scene's BVH with a given effort and uploads it. Blocks.
    ///
    /// # Errors
    /// As [`Renderer::upload_async`].
    pub fn upload_with(&self, scene: &Scene, build: BvhBuild) -> Result<UploadedScene, Error> {
        block_on(self.upload_async(scene, build))
    }

    /// Updates an uploaded scene to its current state and blocks: see [`Renderer::update_async`].
    ///
    /// ```
    /// use stereotrace::{Builtin, Gpu, Options, Renderer, Update, glam::{Affine3A, Vec3}};
    ///
    /// let (mut scene, camera) = (Builtin::Spheres.scene(), Builtin::Spheres.camera(64, 48));
    /// let mut renderer = Renderer::new(Gpu::new()?);
    /// let mut uploaded = renderer.upload(&scene)?;
    /// for _ in 0..3 {
    ///     scene.transform_object(0, &Affine3A::from_translation(0.1 * Vec3::Y))?;
    ///     renderer.update(&mut uploaded, &scene, Update::Refit)?;
    ///     renderer.render(&uploaded, &camera, &Options::default())?;
    /// }
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Renderer::update_async`].
    pub fn update(&self, uploaded: &mut UploadedScene, scene: &Scene, how: Update) -> Result<(), Error> {
        block_on(self.update_async(uploaded, scene, how))
    }

    /// Renders a pair and blocks: see [`Renderer::render_async`].
    ///
    /// # Errors
    /// As [`Renderer::render_async`].
    pub fn render(
        &mut self,
        scene: &UploadedScene,
        camera: &StereoCamera,
        options: &Options,
    ) -> Result<StereoPair, Error> {
        self.render_with(scene, camera, options, &mut |_| ControlFlow::Continue(()))
    }

    /// Renders a pair with a progress callback and blocks: see [`Renderer::render_async`].
    ///
    /// # Errors
    /// As [`Renderer::render_async`].
    pub fn render_with(
        &mut self,
        scene: &UploadedScene,
        camera: &StereoCamera,
        options: &Options,
        progress: &mut OnProgress<'_>,
    ) -> Result<StereoPair, Error> {
        block_on(self.render_async(scene, camera, options, progress))
    }

    /// Runs the passes of a frame without reading the pictures back, and blocks.
    ///
    /// # Errors
    /// As [`Renderer::render_async`].
    pub fn trace(
        &mut self,
        scene: &UploadedScene,
        camera: &StereoCamera,
        options: &Options,
    ) -> Result<Statistics, Error> {
        block_on(self.trace_async(scene, camera, options))
    }

    /// Renders the views of a rig and blocks: see [`Renderer::render_views_async`].
    ///
    /// ```
    /// use stereotrace::{Builtin, Gpu, Options, Renderer, Rig, output::quilt};
    ///
    /// let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(96, 64).interaxial_pixels(2.0));
    /// let mut renderer = Renderer::new(Gpu::new()?);
    /// let uploaded = renderer.upload(&scene)?;
    /// let views = renderer.render_views(&uploaded, &Rig::row(camera, 6), &Options::default())?;
    /// assert_eq!(quilt(&views, 3, 2)?.width, 3 * 96);
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Renderer::render_views_async`].
    pub fn render_views(&mut self, scene: &UploadedScene, rig: &Rig, options: &Options) -> Result<Views, Error> {
        self.render_views_with(scene, rig, options, &mut |_| ControlFlow::Continue(()))
    }

    /// Renders the views of a rig with a progress callback and blocks.
    ///
    /// # Errors
    /// As [`Renderer::render_views_async`].
    pub fn render_views_with(
        &mut self,
        scene: &UploadedScene,
        rig: &Rig,
        options: &Options,
        progress: &mut OnProgress<'_>,
    ) -> Result<Views, Error> {
        block_on(self.render_views_async(scene, rig, options, progress))
    }

    /// Renders the views of a rig, passes on their rows as they are done, and blocks: see
    /// [`Renderer::render_rows_async`].
    ///
    /// ```
    /// use stereotrace::{Builtin, Gpu, Options, Renderer, Rig};
    ///
    /// let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(96, 200));
    /// let mut renderer = Renderer::new(Gpu::new()?);
    /// let uploaded = renderer.upload(&scene)?;
    /// let mut rows = 0;
    /// renderer.render_rows(&uploaded, &Rig::pair(camera), &Options::default(), &mut |band| {
    ///     assert_eq!(band.first, rows);
    ///     rows += band.views[0].view.height;
    ///     Ok(())
    /// })?;
    /// assert_eq!(rows, 200);
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Renderer::render_rows_async`].
    pub fn render_rows(
        &mut self,
        scene: &UploadedScene,
        rig: &Rig,
        options: &Options,
        on_rows: &mut OnRows<'_>,
    ) -> Result<Views, Error> {
        block_on(self.render_rows_async(scene, rig, options, &mut |_| ControlFlow::Continue(()), on_rows))
    }

    /// Adds the commands of a frame to an encoder and blocks: see [`Renderer::encode_async`].
    ///
    /// # Errors
    /// As [`Renderer::encode_async`].
    pub fn encode(
        &mut self,
        scene: &UploadedScene,
        rig: &Rig,
        options: &Options,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<Encoded, Error> {
        block_on(self.encode_async(scene, rig, options, encoder))
    }

    /// Encodes a command buffer for each band of rows and blocks: see [`Renderer::encode_bands_async`].
    ///
    /// # Errors
    /// As [`Renderer::encode_async`].
    pub fn encode_bands(
        &mut self,
        scene: &UploadedScene,
        rig: &Rig,
        options: &Options,
    ) -> Result<(Encoded, Vec<wgpu::CommandBuffer>), Error> {
        block_on(self.encode_bands_async(scene, rig, options))
    }

    /// Returns the nearest hit of each ray and blocks: see [`Renderer::closest_hits_async`].
    ///
    /// ```
    /// use stereotrace::{Gpu, Material, Ray, Renderer, Scene, Sphere, glam::Vec3};
    ///
    /// let mut scene = Scene::new();
    /// let grey = scene.add_material(Material::new(Vec3::splat(0.5)));
    /// scene.add_sphere(Sphere::new(Vec3::ZERO, 1.0, grey))?;
    /// let renderer = Renderer::new(Gpu::new()?);
    /// let uploaded = renderer.upload(&scene)?;
    /// let rays = [-Vec3::Z, Vec3::Z].map(|direction| Ray::new(4.0 * Vec3::Z, direction));
    /// let cast = renderer.closest_hits(&uploaded, &rays)?;
    /// assert_eq!([cast.hits[0].t, cast.hits[1].t], [3.0, f32::INFINITY]);
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Renderer::closest_hits_async`].
    pub fn closest_hits(&self, scene: &UploadedScene, rays: &[Ray]) -> Result<Cast<RayHit>, Error> {
        block_on(self.closest_hits_async(scene, rays))
    }

    /// Returns whether each ray hits anything and blocks: see [`Renderer::any_hits_async`].
    ///
    /// # Errors
    /// As [`Renderer::closest_hits_async`].
    pub fn any_hits(&self, scene: &UploadedScene, rays: &[Ray]) -> Result<Cast<bool>, Error> {
        block_on(self.any_hits_async(scene, rays))
    }

    /// Returns whether the other eye sees the point that each pixel shows, and blocks: see
    /// [`Renderer::occlusions_async`].
    ///
    /// # Errors
    /// As [`Renderer::occlusions_async`].
    pub fn occlusions(&self, scene: &UploadedScene, pair: &StereoPair) -> Result<Occlusions, Error> {
        block_on(self.occlusions_async(scene, pair))
    }

    /// Computes the ground truth of both views of a pair and blocks: see [`Renderer::ground_truth_async`].
    ///
    /// ```
    /// use stereotrace::{Builtin, Gpu, Method, Options, Renderer, output::Batch};
    ///
    /// let (scene, camera) = (Builtin::Hall.scene(), Builtin::Hall.camera(64, 48));
    /// let mut renderer = Renderer::new(Gpu::new()?);
    /// let uploaded = renderer.upload(&scene)?;
    /// let pair = renderer.render(&uploaded, &camera, &Options::new(Method::BRACKET))?;
    /// let truth = renderer.ground_truth(&uploaded, &scene, &pair)?;
    /// let folder = std::env::temp_dir();
    /// let mut files = Batch::new();
    /// files.add_pfm(folder.join("disp0.pfm"), 64, 48, &truth.left.disparity)?;
    /// files.add_calib(folder.join("calib.txt"), &truth)?;
    /// files.commit()?;
    /// # Ok::<(), stereotrace::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Renderer::ground_truth_async`].
    pub fn ground_truth(
        &self,
        uploaded: &UploadedScene,
        scene: &Scene,
        pair: &StereoPair,
    ) -> Result<GroundTruth, Error> {
        block_on(self.ground_truth_async(uploaded, scene, pair))
    }
}

#[cfg(feature = "png")]
impl FreePoses<'_> {
    /// Finds the camera of an item and blocks: see [`FreePoses::find_async`].
    ///
    /// # Errors
    /// As [`FreePoses::find_async`].
    pub fn find(&self, renderer: &Renderer, scene: &UploadedScene, item: u32) -> Result<RandomPose, Error> {
        block_on(self.find_async(renderer, scene, item))
    }
}

/// Opens a device, uploads the scene and renders the views of a rig, and blocks: see [`render_views_async`].
///
/// # Errors
/// As [`render_views_async`].
pub fn render_views(scene: &Scene, rig: &Rig) -> Result<Views, Error> {
    block_on(render_views_async(scene, rig))
}

/// Opens a device, uploads the scene and renders a stereo pair, and blocks: see [`render_stereo_async`].
///
/// # Errors
/// As [`render_stereo_async`].
pub fn render_stereo(scene: &Scene, camera: &StereoCamera) -> Result<StereoPair, Error> {
    block_on(render_stereo_async(scene, camera))
}
