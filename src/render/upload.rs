//! Scenes on a device: the BVH with its primitives, and the shading table.

use std::{
    sync::{
        Arc, Mutex, OnceLock,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    time::Duration,
};

use glam::{DVec3, Vec3};
use web_time::Instant;

use crate::{
    BvhBuild, Choice, Error, Method, Options, Penumbra, Pose, Renderer, Scene, ShadowBufferWork, Texture,
    accel::bvh::{self, PackedBvh, TreeShape},
    accel::cutouts::cutouts_of,
    accel::geometry::GeometryTexels,
    accel::large::LargePrimitives,
    accel::outlines::outlines_of,
    accel::table::{Pictures, ShadingTable},
    frame::{executor::Resources, history::SceneId, targets::Used},
    gpu::{Acceleration, Gpu, Texel, Texels},
    kernel::layout,
    kernel::traversal::{Fetch, Tracing, Traversal},
    kernel::variant::{Shadows, Variant},
    kernel::{Kernels, Resource},
    message::counted,
    methods::auto::{Asked, Calibration, CostModel, Seen},
    scene::shadowing::Shadowing,
    shadow_buffer::{self, Casters, Tables},
    steps::soft::SoftLights,
    t_buffer::Drawn,
};

/// A scene on a device, ready to be rendered from any number of cameras.
#[derive(Debug)]
pub struct UploadedScene {
    /// Uniform of the BVH.
    bvh: wgpu::Buffer,
    /// Nodes and primitives, and the shading table.
    texels: [Arc<Texels>; 2],
    /// What ray queries search, if they trace the scene's rays.
    acceleration: Option<Acceleration>,
    /// Sky and textures of the shading table.
    pictures: Pictures,
    /// Cut-out textures; their masks follow the geometry in memory.
    cutouts: Vec<(usize, Texture)>,
    /// Objects of the primitives; created when edges are first needed.
    object_table: OnceLock<Texels>,
    pub(crate) variant: Variant,
    pub(crate) objects: Vec<u32>,
    /// Scene id of each primitive, in BVH order.
    pub(crate) ids: Vec<u32>,
    /// Positions of the point lights.
    pub(crate) lights: Vec<Vec3>,
    /// Indices among all lights, and positions, of the point lights.
    pub(crate) point_lights: Vec<(u32, Vec3)>,
    /// Scene origin in world coordinates; all positions here are relative to it.
    pub(crate) origin: DVec3,
    /// Bounds of all primitives except planes.
    pub(crate) bounds: Option<(Vec3, Vec3)>,
    /// Shadow-buffers of the last frame that used any.
    shadow_tables: shadow_buffer::Kept,
    pub(crate) soft: SoftLights,
    pub(crate) large: LargePrimitives,
    /// Data of the tree that a refit needs.
    shape: TreeShape,
    gpu: Gpu,
    info: UploadInfo,
    /// Whether an update began to overwrite the texels and did not end.
    half_written: AtomicBool,
    /// Number of the scene, which no other scene or state has.
    number: u64,
    /// Number of the scene's current state, which no other scene or state has.
    pub(super) state: u64,
    pub(super) shadowing: Arc<Shadowing>,
}

/// Returns a number that no state of a scene has.
fn new_state() -> u64 {
    static STATES: AtomicU64 = AtomicU64::new(0);
    STATES.fetch_add(1, Ordering::Relaxed)
}

/// How the BVH of a changed scene is updated; docs/TRAVERSAL.md has the costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Update {
    /// Keeps the tree's shape and computes new boxes. It is fast, but rays visit more nodes the farther primitives
    /// moved. If no primitive changed, only lights, materials and sky are uploaded.
    ///
    /// The scene must have as many triangles, spheres, ellipsoids and planes as when the tree was built. A primitive
    /// that was degenerate or an exact copy then must not be traced now. (A list, [`BvhBuild::Flat`], is always
    /// rebuilt.)
    Refit,
    /// Refits the tree if that is possible, otherwise builds a new one with [`BvhBuild::Balanced`].
    RefitOrRebuild,
    /// Builds a new tree.
    Rebuild(BvhBuild),
}

/// Statistics of an upload.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct UploadInfo {
    /// Traversal of the scene's rays. Its fetch differs from the renderer's if the scene does not fit that one.
    pub(crate) traversal: Traversal,
    /// Time to build and pack the BVH.
    pub build: Duration,
    /// Time to pass the data to the driver.
    pub upload: Duration,
    /// Size of the BVH's nodes in bytes, and of the indices of their parents, which only buffers have.
    pub node_bytes: u64,
    /// Size of the primitives and of the cut-out masks in bytes.
    pub primitive_bytes: u64,
    /// Degenerate triangles ([`Scene::degenerate_count`]), which are not in the BVH.
    pub dropped_triangles: usize,
}

impl UploadedScene {
    /// Returns the scene that a history of its frames belongs to.
    pub(super) fn id(&self) -> SceneId {
        (self.number, self.origin)
    }

    /// Returns the statistics of the upload.
    pub fn info(&self) -> UploadInfo {
        self.info
    }

    /// Returns the traversal of the scene's rays.
    #[cfg(any(test, feature = "testing"))]
    pub fn traversal(&self) -> Traversal {
        self.info.traversal
    }

    /// Returns whether rays from these points, or from the lights, need a more exact t for large primitives.
    pub(crate) fn close_to(&self, eyes: &[Vec3]) -> bool {
        let shadows = if self.variant.shadows == Shadows::None { &[] } else { self.lights.as_slice() };
        let close = self.large.any_close_to(eyes) || self.large.any_close_to(shadows);
        log::debug!("close to a large primitive: {close}");
        close
    }

    /// Returns texels that an update is about to overwrite.
    fn overwritten(&self, texels: usize) -> &Arc<Texels> {
        self.half_written.store(true, Ordering::Relaxed);
        &self.texels[texels]
    }

    /// Adds the resources of the scene's tree and shading table.
    pub(crate) fn resources(&self, all: &mut Resources) {
        let [geometry, table] = &self.texels;
        all.set(Resource::Bvh, &self.bvh);
        all.set(Resource::Geometry, &**geometry);
        all.set(Resource::Table, &**table);
        if let Some(scene) = &self.acceleration {
            all.set(Resource::Acceleration, scene);
        }
    }

    /// Returns the resources that a frame's views share.
    pub(super) async fn resources_for(
        &self,
        gpu: &Gpu,
        used: &Used,
        tables: Option<&Tables>,
    ) -> Result<Resources, Error> {
        let mut all = Resources::default();
        self.resources(&mut all);
        if let Some(tables) = tables {
            all.set(Resource::ShadowBuffers, &tables.view);
        }
        if used.objects {
            all.set(Resource::ObjectTable, self.object_table(gpu).await?);
        }
        Ok(all)
    }

    /// Returns the primitives to draw into a T-buffer, or `None` if their lists do not fit one binding.
    pub(super) fn drawn(&self) -> Option<Drawn> {
        Drawn::of(self.ids.len() as u32, &self.variant, &self.gpu)
    }

    /// Returns the parts of the scene that shadow-buffers depend on.
    pub(crate) fn casters(&self) -> Casters<'_> {
        Casters {
            variant: &self.variant,
            is_empty: self.ids.is_empty(),
            drawn: self.drawn(),
            point_lights: &self.point_lights,
            bounds: self.bounds,
            large: &self.large,
        }
    }

    /// Returns the shadow-buffers that a frame queries, after filling missing ones; `None` if it queries none.
    pub(crate) async fn shadow_tables(
        &self,
        kernels: &Kernels,
        options: &Options,
    ) -> Result<Option<(Arc<Tables>, ShadowBufferWork)>, Error> {
        if options.shadow_buffer.is_none() {
            return Ok(None);
        }
        let mut resources = Resources::default();
        self.resources(&mut resources);
        shadow_buffer::tables((&self.gpu, kernels), &self.casters(), &resources, &self.shadow_tables, options).await
    }

    /// Returns the primitives' objects in BVH order, uploaded at the first call, for the pass that finds edges.
    async fn object_table(&self, gpu: &Gpu) -> Result<&Texels, Error> {
        if self.object_table.get().is_none() {
            let objects: Vec<u32> = self.ids.iter().map(|id| self.objects[*id as usize]).collect();
            let fetch = self.variant.traversal.fetch;
            let table = gpu.upload("object_table", &object_texels(&objects), fetch).await?;
            let _ = self.object_table.set(table); // a concurrent frame may have stored an equal table first
        }
        Ok(self.object_table.get().expect("set above"))
    }

    /// Adds the importance sampling weights to a sky map when its light is first used. They are stored in words of its
    /// texels that nothing else reads.
    pub(crate) async fn weigh_sky(&self) -> Result<(), Error> {
        let Some((first, texels)) = self.pictures.sky_to_weigh() else { return Ok(()) };
        self.gpu.fill_from(&self.texels[1], first, texels).await?;
        self.pictures.set_weighed(); // a concurrent frame may have computed equal weights
        Ok(())
    }

    /// Returns the cost model of `Auto` for a frame.
    pub(crate) fn cost_model(&self, gpu: &Gpu, calibration: Calibration, options: &Options) -> CostModel {
        CostModel::of(gpu, calibration, self.asked(options))
    }

    /// Returns the maximum number of light queries per pixel of a frame.
    fn asked(&self, options: &Options) -> Asked {
        let points = if self.variant.shadows == Shadows::None { 0 } else { self.lights.len() as u32 };
        let soft = self.soft.rays(options);
        Asked { points, soft, shares: options.penumbra != Penumbra::Exact }
    }

    /// Returns the number of rays to lights from each point.
    pub(crate) fn rays_per_point(&self, options: &Options) -> u32 {
        let Asked { points, soft, .. } = self.asked(options);
        points.saturating_add(soft)
    }

    /// Returns the choice of `Auto` if it must be `Naive`. This assumes a left view without gaps and a shadow ray for
    /// every light and pixel. If `bracket` is not cheaper even then, the method is `Naive`.
    pub(crate) fn choose_early(&self, model: CostModel, pose: &Pose, options: &Options) -> Option<Choice> {
        let pixels = u64::from(pose.size[0]) * u64::from(pose.size[1]);
        let shadow_rays = u64::from(self.rays_per_point(options)).saturating_mul(pixels);
        let best = model.choose(pose.size, Seen { shadow_rays, ..Seen::default() });
        (best.method == Method::Naive).then_some(best)
    }

    /// Returns whether the uploaded primitives equal the primitives of this scene, which may be a clone.
    pub(crate) fn is_of(&self, scene: &Scene) -> bool {
        self.shape.is_of(scene)
    }

    /// # Errors
    /// [`Error::ForeignScene`] if the scene is on another [`Gpu`]; [`Error::Scene`] if its last update did not end.
    pub(crate) fn belongs_to(&self, gpu: &Gpu) -> Result<(), Error> {
        if !self.gpu.is(gpu) {
            return Err(Error::ForeignScene);
        }
        if self.half_written.load(Ordering::Relaxed) {
            let reason = "its last update failed or was dropped before its end; upload it again".into();
            return Err(Error::Scene { element: "the uploaded scene".into(), reason });
        }
        Ok(())
    }
}

impl Renderer {
    /// Builds a scene's BVH with [`BvhBuild::Balanced`], which suits a few pictures, and uploads it.
    ///
    /// # Errors
    /// The errors of [`Renderer::upload_with`].
    pub async fn upload(&self, scene: &Scene) -> Result<UploadedScene, Error> {
        self.upload_with(scene, BvhBuild::Balanced).await
    }

    /// Builds a scene's BVH with a given effort and uploads it. If the scene does not fit the adapter's storage
    /// bindings it is stored in textures, and vice versa. A warning is logged, once per renderer, if the f32 step at
    /// the scene's distance from the origin exceeds a ten-thousandth of its longest side.
    ///
    /// # Errors
    /// [`Error::Scene`] for a value that can't be rendered; [`Error::Limit`] for a scene too large for the adapter,
    /// with the number of primitives that fit; [`Error::OutOfMemory`] and [`Error::DeviceLost`].
    pub async fn upload_with(&self, scene: &Scene, build: BvhBuild) -> Result<UploadedScene, Error> {
        self.check(scene)?;
        let started = Instant::now();
        let tree = built(scene, build, self.traversal)?;
        self.bring(scene, tree, self.traversal, started, None).await
    }

    /// Updates an uploaded scene to its current state. Primitives may have moved ([`Scene::transform_object`],
    /// [`Scene::set_mesh`], [`Scene::set_sphere`], [`Scene::set_ellipsoid`], [`Scene::set_plane`]) or been added, and
    /// lighting may have changed. Device memory is reused if it is large enough. The picture equals the picture after a
    /// new upload. After an update that failed for lack of memory, or whose future was dropped, the scene must be
    /// uploaded again: frames and further updates refuse it.
    ///
    /// # Errors
    /// The errors of [`Renderer::upload`]; [`Error::ForeignScene`] if the scene is on another [`Gpu`]; [`Error::Scene`]
    /// if [`Update::Refit`] can't keep the tree.
    pub async fn update(&self, uploaded: &mut UploadedScene, scene: &Scene, how: Update) -> Result<(), Error> {
        uploaded.belongs_to(&self.gpu)?;
        self.check(scene)?;
        let started = Instant::now();
        let traversal = uploaded.info.traversal;
        let table_fits = self.gpu.texel_capacity(traversal.fetch) >= ShadingTable::of(scene).count() as u64;
        let same_geometry = uploaded.shape.is_of(scene) && uploaded.cutouts == cutouts_of(scene);
        let may_refit = matches!(how, Update::Refit | Update::RefitOrRebuild);
        if may_refit && same_geometry && table_fits {
            let (table, pictures) = self.bring_table(scene, traversal.fetch, Some(uploaded)).await?;
            let Variant { world_boxes, stack_size, .. } = uploaded.variant;
            uploaded.variant = Variant::over_tree(scene, traversal, world_boxes, stack_size);
            uploaded.origin = scene.origin();
            uploaded.lights = positions(scene);
            uploaded.point_lights = point_lights(scene);
            uploaded.soft = SoftLights::of(scene);
            (uploaded.texels[1], uploaded.pictures) = (table, pictures);
            uploaded.half_written = AtomicBool::new(false);
            uploaded.state = new_state();
            let (components, slots) = (&uploaded.shape.components, uploaded.ids.len());
            uploaded.shadowing = Arc::new(Shadowing::of(scene, components, slots, Some(&uploaded.shadowing)));
            (uploaded.info.build, uploaded.info.upload) = (Duration::ZERO, started.elapsed());
            return Ok(());
        }
        let refitted = || {
            let packed = uploaded.shape.refit(scene, traversal.boxes)?;
            let shape = uploaded.shape.refitted(scene, &packed);
            Ok((packed, shape))
        };
        let tree = match how {
            Update::Refit => refitted()?,
            Update::RefitOrRebuild => match refitted() {
                Err(Error::Scene { .. }) => built(scene, BvhBuild::Balanced, traversal)?,
                found => found?,
            },
            Update::Rebuild(build) => built(scene, build, traversal)?,
        };
        *uploaded = self.bring(scene, tree, traversal, started, Some(uploaded)).await?;
        Ok(())
    }

    fn check(&self, scene: &Scene) -> Result<(), Error> {
        scene.check()?;
        if let Some(warning) = scene.rounding_warning() {
            self.rounding_warned.call_once(|| log::warn!("{warning}")); // an animation uploads a scene per frame
        }
        Ok(())
    }

    /// Uploads a packed scene. It reuses the memory of the scene's earlier state, if there is any.
    async fn bring(
        &self,
        scene: &Scene,
        (packed, shape): (PackedBvh, TreeShape),
        traversal: Traversal,
        started: Instant,
        before: Option<&UploadedScene>,
    ) -> Result<UploadedScene, Error> {
        let build = started.elapsed();
        let gpu = &self.gpu;
        let fetch = fetch_that_fits(gpu, traversal.fetch, scene, &packed)?;
        let wanted = traversal.tracing(self.traversal.tracing);
        let acceleration = self.accelerated(scene, &packed.ids, wanted).await?;
        let tracing = if acceleration.is_some() { Tracing::RayQueries } else { Tracing::Kernels };
        let traversal = traversal.fetch(fetch).tracing(tracing);
        let texels = GeometryTexels::new(&packed, fetch);
        let room = before.map(|before| before.overwritten(0));
        let geometry = self.written("geometry", room, texels.count(), texels.texels().into_iter(), fetch).await?;
        let (table, pictures) = self.bring_table(scene, fetch, before).await?;
        let bvh = || {
            let [cutouts, parents] = [texels.masks_begin() as u32, texels.parents_word()];
            Ok(gpu.uniform_buffer("bvh", bytemuck::bytes_of(&layout::Bvh { cutouts, parents, ..packed.uniform })))
        };
        let earlier = before.map(|before| &*before.shadowing);
        let shadowing = Shadowing::of(scene, &packed.components, packed.ids.len(), earlier);
        Ok(UploadedScene {
            bvh: gpu.checked(bvh).await?,
            texels: [geometry, table],
            acceleration,
            pictures,
            cutouts: cutouts_of(scene),
            object_table: OnceLock::new(),
            variant: Variant::over_tree(scene, traversal, packed.world_boxes, packed.stack_size),
            objects: (0..scene.primitive_count() as u32).map(|id| scene.object_of(id)).collect(),
            lights: positions(scene),
            point_lights: point_lights(scene),
            bounds: scene.local_bounds(),
            origin: scene.origin(),
            shadow_tables: Mutex::default(),
            soft: SoftLights::of(scene),
            large: LargePrimitives::of(scene),
            shape,
            half_written: AtomicBool::new(false),
            number: before.map_or_else(new_state, |before| before.number),
            state: new_state(),
            shadowing: Arc::new(shadowing),
            gpu: gpu.clone(),
            info: UploadInfo {
                traversal,
                build,
                upload: started.elapsed() - build,
                node_bytes: size_of_val(packed.nodes.as_slice()) as u64 + texels.parents_bytes(),
                primitive_bytes: (size_of_val(&*packed.primitives) + size_of_val(&*packed.masks)) as u64,
                dropped_triangles: scene.degenerate_count(),
            },
            ids: packed.ids,
        })
    }

    /// Builds what ray queries search; `None` if the kernels trace the scene's rays themselves.
    async fn accelerated(
        &self,
        scene: &Scene,
        ids: &[u32],
        traversal: Traversal,
    ) -> Result<Option<Acceleration>, Error> {
        if !traversal.queries_rays() || !self.gpu.has_ray_queries() {
            return Ok(None);
        }
        let Some(outlines) = outlines_of(scene, ids) else { return Ok(None) };
        if !self.gpu.can_accelerate(&outlines) {
            log::info!(
                "{} primitives are too many for this device's ray queries: kernels trace them",
                outlines.count()
            );
            return Ok(None);
        }
        self.gpu.accelerate(&outlines).await.map(Some)
    }

    /// Uploads the shading table. If the memory holds the same sky and textures at the same offset, only the texels
    /// before and after them are written.
    async fn bring_table(
        &self,
        scene: &Scene,
        fetch: Fetch,
        before: Option<&UploadedScene>,
    ) -> Result<(Arc<Texels>, Pictures), Error> {
        let table = ShadingTable::of(scene);
        let count = table.count();
        let is_there = |before: &&UploadedScene| before.pictures.are_those_of(scene);
        let room = before.map(|before| before.overwritten(1)).filter(|room| room.has_room(count, fetch));
        let staying = before.filter(is_there).filter(|_| room.is_some()).map(|before| &before.pictures);
        let written = if staying.is_some() { table.before_pictures() } else { count };
        let pictures = staying.cloned().unwrap_or_else(|| Pictures::of(scene));
        let texels = self.written("shading_table", room, count, table.texels().take(written), fetch).await?;
        if staying.is_some() {
            self.gpu.fill_from(&texels, table.before_paths(), table.path_texels()).await?;
        }
        Ok((texels, pictures))
    }

    /// Writes texels to the existing memory `room` if they fit, otherwise to new memory.
    async fn written(
        &self,
        label: &'static str,
        room: Option<&Arc<Texels>>,
        count: usize,
        texels: impl Iterator<Item = Texel>,
        fetch: Fetch,
    ) -> Result<Arc<Texels>, Error> {
        let room = match room.filter(|room| room.has_room(count, fetch)) {
            Some(room) => room.clone(),
            None => Arc::new(self.gpu.room(label, count, fetch).await?),
        };
        self.gpu.fill(&room, texels).await?;
        Ok(room)
    }
}

/// Builds a tree, and collects the data that a refit of the tree needs.
fn built(scene: &Scene, build: BvhBuild, traversal: Traversal) -> Result<(PackedBvh, TreeShape), Error> {
    let packed = bvh::build(scene, build, traversal.boxes)?;
    let shape = TreeShape::of(scene, &packed);
    Ok((packed, shape))
}

fn positions(scene: &Scene) -> Vec<Vec3> {
    point_lights(scene).into_iter().map(|(_, position)| position).collect()
}

fn point_lights(scene: &Scene) -> Vec<(u32, Vec3)> {
    let points = (0..).zip(&scene.lights).filter(|(_, light)| !light.is_soft());
    points.map(|(place, light)| (place, scene.local_position(light))).collect()
}

/// Returns the wanted fetch if it can hold the scene, else the other one if that can.
fn fetch_that_fits(gpu: &Gpu, wanted: Fetch, scene: &Scene, packed: &PackedBvh) -> Result<Fetch, Error> {
    let other = match wanted {
        Fetch::Texture => Fetch::Buffer,
        Fetch::Buffer => Fetch::Texture,
    };
    let geometry = |fetch| GeometryTexels::new(packed, fetch).count() as u64;
    let table = ShadingTable::of(scene).count() as u64;
    let fits = |&fetch: &Fetch| gpu.texel_capacity(fetch) >= geometry(fetch).max(table);
    if let Some(fetch) = [wanted, other].into_iter().find(fits) {
        if fetch != wanted {
            log::info!("the scene is too large to be read from a {wanted:?}: falling back to a {fetch:?}");
        }
        return Ok(fetch);
    }
    let (fetch, limit) = match gpu.texel_capacity(Fetch::Buffer) > gpu.texel_capacity(Fetch::Texture) {
        true => (Fetch::Buffer, "max_storage_buffer_binding_size"),
        false => (Fetch::Texture, "max_texture_dimension_2d"),
    };
    let (capacity, geometry) = (gpu.texel_capacity(fetch), geometry(fetch));
    let primitives = scene.primitive_count() as u64;
    if table > geometry {
        return Err(Error::Limit {
            what: "the scene's table of lights, materials, sky and textures".into(),
            needed: format!("{table} texels of 16 bytes"),
            limit,
            allowed: format!("enough for {capacity}"),
            remedy: "use smaller or fewer pictures",
        });
    }
    Err(Error::Limit {
        what: format!("a scene of {}", counted(primitives, "primitive", "primitives")),
        needed: format!("{geometry} texels of 16 bytes"),
        limit,
        allowed: format!("enough for {capacity}, about {} primitives", capacity * primitives / geometry),
        remedy: "use fewer primitives",
    })
}

/// Packs objects, four per texel.
fn object_texels(objects: &[u32]) -> Vec<Texel> {
    let texel = |four: &[u32]| std::array::from_fn(|index| four.get(index).copied().unwrap_or(crate::MISS));
    if objects.is_empty() { vec![[crate::MISS; 4]] } else { objects.chunks(4).map(texel).collect() }
}
