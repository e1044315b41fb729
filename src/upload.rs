//! A scene on a device: its BVH and primitives, and the table that shading reads.

use std::{
    sync::{Arc, Mutex, OnceLock},
    time::Duration,
};

use glam::{DVec3, Vec3};
use web_time::Instant;

use crate::{
    BvhBuild, Choice, Error, Method, Options, Penumbra, Pose, Renderer, Scene, Texture,
    auto::{Asked, CostModel, Seen},
    bvh::{self, PackedBvh, Texel, TreeShape},
    cutouts::cutouts_of,
    geometry::GeometryTexels,
    gpu::{Gpu, Texels, bind_group},
    kernels::Kernels,
    large::LargePrimitives,
    layout,
    message::counted,
    steps::{shadow_buffer::Tables, soft::SoftLights},
    table::{Pictures, ShadingTable},
    traversal::{Fetch, Traversal},
    variant::{Shadows, Variant},
};

/// A scene on a device, to be rendered from any number of cameras.
#[derive(Debug)]
pub struct UploadedScene {
    pub(crate) geometry: wgpu::BindGroup,
    pub(crate) shading: wgpu::BindGroup,
    /// What these two bind.
    texels: [Arc<Texels>; 2],
    /// The pictures that the shading table has.
    pictures: Pictures,
    /// The textures whose masks stand behind the geometry.
    cutouts: Vec<(usize, Texture)>,
    /// Made when edges are first asked for.
    pub(crate) object_table: OnceLock<(wgpu::BindGroup, Texels)>,
    pub(crate) variant: Variant,
    pub(crate) objects: Vec<u32>,
    /// The scene's id of each primitive, in the BVH's order.
    pub(crate) ids: Vec<u32>,
    /// Positions of those that are points.
    pub(crate) lights: Vec<Vec3>,
    /// The same with their places among all lights.
    pub(crate) point_lights: Vec<(u32, Vec3)>,
    /// The scene's origin, world coordinates; all positions here are relative to it.
    pub(crate) origin: DVec3,
    /// Of all but planes.
    pub(crate) bounds: Option<(Vec3, Vec3)>,
    /// Those of the last frame that asked for some.
    pub(crate) shadow_tables: Mutex<Option<Arc<Tables>>>,
    pub(crate) soft: SoftLights,
    pub(crate) large: LargePrimitives,
    /// What is kept of the tree for a refit.
    shape: TreeShape,
    gpu: Gpu,
    info: UploadInfo,
}

/// How the tree of a scene that changed is brought up to date: docs/TRAVERSAL.md has what each costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Update {
    /// The tree keeps its shape and gets new boxes: quick, but rays visit more of a tree the farther its primitives
    /// moved. Where no primitive changed, lights, materials and sky alone are uploaded. The scene must have as many
    /// triangles, spheres, ellipsoids and planes as when the tree was built, and none that was without area or an
    /// exact copy of another then and is traced now. (A list, [`BvhBuild::Flat`], is made anew, whatever the scene
    /// has.)
    Refit,
    /// The tree is built anew.
    Rebuild(BvhBuild),
}

/// How a scene was brought to a device.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct UploadInfo {
    /// How its rays are traced. It is read in the other way than the renderer's where it does not fit that one.
    pub traversal: Traversal,
    /// Time to build and pack the BVH.
    pub build: Duration,
    /// Time to hand it to the driver.
    pub upload: Duration,
    /// Bytes of the BVH's nodes.
    pub node_bytes: u64,
    /// Bytes of the primitives, and of the masks of those that are cut out.
    pub primitive_bytes: u64,
    /// Triangles without area ([`Scene::degenerate_count`]): they are not in the BVH.
    pub dropped_triangles: usize,
}

impl UploadedScene {
    /// How it was brought to the device.
    pub fn info(&self) -> UploadInfo {
        self.info
    }

    /// Whether rays from these points, or from the lights, need t of large primitives more exactly.
    pub(crate) fn close_to(&self, eyes: &[Vec3]) -> bool {
        let shadows = if self.variant.shadows == Shadows::None { &[] } else { self.lights.as_slice() };
        let close = self.large.any_close_to(eyes) || self.large.any_close_to(shadows);
        log::debug!("close to a large primitive: {close}");
        close
    }

    /// The primitives' objects in the BVH's order, for the pass that tells edges by them.
    pub(crate) async fn upload_object_table(&self, gpu: &Gpu, kernels: &Kernels) -> Result<(), Error> {
        if self.object_table.get().is_some() {
            return Ok(());
        }
        let fetch = self.variant.traversal.fetch;
        let objects: Vec<u32> = self.ids.iter().map(|id| self.objects[*id as usize]).collect();
        let table = gpu.upload("object_table", &object_texels(&objects), fetch).await?;
        let layout = &kernels.layouts(fetch).table;
        let bind = || Ok(bind_group(gpu, "object_table", layout, std::iter::once(table.binding())));
        let group = gpu.checked(bind).await?;
        let _ = self.object_table.set((group, table)); // another frame's is as good
        Ok(())
    }

    /// Adds to a sky that is a picture what rays are chosen by, where its light is first asked for: to words of its
    /// texels that nothing else reads.
    pub(crate) async fn weigh_sky(&self) -> Result<(), Error> {
        let Some((first, texels)) = self.pictures.sky_to_weigh() else { return Ok(()) };
        self.gpu.fill_from(&self.texels[1], first, texels).await?;
        self.pictures.set_weighed(); // another frame's weights are the same
        Ok(())
    }

    /// What `Auto` goes by in a frame.
    pub(crate) fn cost_model(&self, gpu: &Gpu, options: &Options) -> CostModel {
        CostModel::of(gpu, self.asked(options))
    }

    /// What a frame asks of lights at most.
    fn asked(&self, options: &Options) -> Asked {
        let points = if self.variant.shadows == Shadows::None { 0 } else { self.lights.len() as u32 };
        let soft = self.soft.rays(options);
        Asked { points, soft, shares: options.penumbra != Penumbra::Exact }
    }

    /// What `Auto` chooses where even a left view without gaps, with a shadow ray for every light and pixel, could only
    /// end in `Naive`.
    pub(crate) fn choose_early(&self, gpu: &Gpu, pose: &Pose, options: &Options) -> Option<Choice> {
        let Asked { points, soft, .. } = self.asked(options);
        let pixels = u64::from(pose.size[0]) * u64::from(pose.size[1]);
        let shadow_rays = (u64::from(points) + u64::from(soft)).saturating_mul(pixels);
        let best = self.cost_model(gpu, options).choose(pose, Seen { shadow_rays, ..Seen::default() });
        (best.method == Method::Naive).then_some(best)
    }

    /// Whether its primitives are this scene's, or a clone's of it.
    pub(crate) fn is_of(&self, scene: &Scene) -> bool {
        self.shape.is_of(scene)
    }

    /// # Errors
    /// [`Error::ForeignScene`] if another [`Gpu`] holds it.
    pub(crate) fn belongs_to(&self, gpu: &Gpu) -> Result<(), Error> {
        if self.gpu.is(gpu) {
            return Ok(());
        }
        Err(Error::ForeignScene)
    }
}

impl Renderer {
    /// Builds a scene's BVH with a given effort and uploads it. What does not fit the adapter's storage bindings goes
    /// to textures, and the other way round. A scene that is so far from the origin that the step of f32 there is
    /// over a ten-thousandth of its longest side is logged as a warning, once for each renderer.
    ///
    /// # Errors
    /// [`Error::Scene`] for a value that can't be rendered, [`Error::Limit`] for a scene larger than the adapter
    /// takes, saying how many primitives fit, [`Error::OutOfMemory`] and [`Error::DeviceLost`].
    pub async fn upload_async(&self, scene: &Scene, build: BvhBuild) -> Result<UploadedScene, Error> {
        self.check(scene)?;
        let started = Instant::now();
        let tree = built(scene, build, self.traversal)?;
        self.bring(scene, tree, self.traversal, started, None).await
    }

    /// Brings a scene that was uploaded to what it is now: what moved ([`Scene::transform_object`],
    /// [`Scene::set_mesh`], [`Scene::set_sphere`], [`Scene::set_ellipsoid`], [`Scene::set_plane`]), was added, or
    /// is lit otherwise. Memory of the device is used again where there is room in it. The picture is that of
    /// a scene uploaded anew. What is left of an update that failed for the want of memory is to be uploaded anew.
    ///
    /// # Errors
    /// Those of [`Renderer::upload_async`], [`Error::ForeignScene`] if another [`Gpu`] holds it, and [`Error::Scene`]
    /// where [`Update::Refit`] can't keep the tree.
    pub async fn update_async(&self, uploaded: &mut UploadedScene, scene: &Scene, how: Update) -> Result<(), Error> {
        uploaded.belongs_to(&self.gpu)?;
        self.check(scene)?;
        let started = Instant::now();
        let traversal = uploaded.info.traversal;
        let table_fits = self.gpu.texel_capacity(traversal.fetch) >= ShadingTable::of(scene).count() as u64;
        let same_geometry = uploaded.shape.is_of(scene) && uploaded.cutouts == cutouts_of(scene);
        if how == Update::Refit && same_geometry && table_fits {
            let (table, shading, pictures) = self.bring_table(scene, traversal.fetch, Some(uploaded)).await?;
            let Variant { world_boxes, stack_size, .. } = uploaded.variant;
            uploaded.variant = Variant::over_tree(scene, traversal, world_boxes, stack_size);
            uploaded.origin = scene.origin();
            uploaded.lights = positions(scene);
            uploaded.point_lights = point_lights(scene);
            uploaded.soft = SoftLights::of(scene);
            (uploaded.shading, uploaded.texels[1], uploaded.pictures) = (shading, table, pictures);
            (uploaded.info.build, uploaded.info.upload) = (Duration::ZERO, started.elapsed());
            return Ok(());
        }
        let tree = match how {
            Update::Refit => {
                let packed = uploaded.shape.refit(scene, traversal.boxes)?;
                let shape = uploaded.shape.refitted(scene, &packed);
                (packed, shape)
            }
            Update::Rebuild(build) => built(scene, build, traversal)?,
        };
        *uploaded = self.bring(scene, tree, traversal, started, Some(uploaded)).await?;
        Ok(())
    }

    fn check(&self, scene: &Scene) -> Result<(), Error> {
        scene.check()?;
        if let Some(warning) = scene.rounding_warning() {
            self.rounding_warned.call_once(|| log::warn!("{warning}")); // a film uploads a scene for each picture
        }
        Ok(())
    }

    /// Uploads what was packed, to where another state of the scene stands if there is one.
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
        let traversal = traversal.fetch(fetch);
        let texels = GeometryTexels::new(&packed, fetch);
        let room = before.map(|before| &before.texels[0]);
        let geometry = self.written("geometry", room, texels.count(), texels.texels().into_iter(), fetch).await?;
        let (table, shading, pictures) = self.bring_table(scene, fetch, before).await?;
        let bind = || {
            let bvh = match packed.masks.is_empty() {
                true => gpu.uniform_buffer("bvh", bytemuck::bytes_of(&packed.uniform)),
                false => {
                    let cutouts = texels.masks_begin() as u32;
                    let uniform = layout::CutOutBvh { bvh: packed.uniform, cutouts, ..Default::default() };
                    gpu.uniform_buffer("bvh", bytemuck::bytes_of(&uniform))
                }
            };
            let bindings = [bvh.as_entire_binding(), geometry.binding()];
            Ok(bind_group(gpu, "geometry", &self.kernels.layouts(fetch).geometry, bindings.into_iter()))
        };
        Ok(UploadedScene {
            geometry: gpu.checked(bind).await?,
            shading,
            texels: [geometry, table],
            pictures,
            cutouts: cutouts_of(scene),
            object_table: OnceLock::new(),
            variant: Variant::of(scene, traversal, &packed),
            objects: (0..scene.primitive_count() as u32).map(|id| scene.object_of(id)).collect(),
            lights: positions(scene),
            point_lights: point_lights(scene),
            bounds: scene.local_bounds(),
            origin: scene.origin(),
            shadow_tables: Mutex::default(),
            soft: SoftLights::of(scene),
            large: LargePrimitives::of(scene),
            shape,
            gpu: gpu.clone(),
            info: UploadInfo {
                traversal,
                build,
                upload: started.elapsed() - build,
                node_bytes: size_of_val(packed.nodes.as_slice()) as u64,
                primitive_bytes: (size_of_val(&*packed.primitives) + size_of_val(&*packed.masks)) as u64,
                dropped_triangles: scene.degenerate_count(),
            },
            ids: packed.ids,
        })
    }

    /// Uploads the shading table; of one that stands there with the same pictures at the same place, what is before
    /// them.
    async fn bring_table(
        &self,
        scene: &Scene,
        fetch: Fetch,
        before: Option<&UploadedScene>,
    ) -> Result<(Arc<Texels>, wgpu::BindGroup, Pictures), Error> {
        let table = ShadingTable::of(scene);
        let count = table.count();
        let is_there = |before: &&UploadedScene| before.pictures.are_those_of(scene);
        let room = before.map(|before| &before.texels[1]).filter(|room| room.has_room(count, fetch));
        let staying = before.filter(is_there).filter(|_| room.is_some()).map(|before| &before.pictures);
        let written = if staying.is_some() { table.before_pictures() } else { count };
        let pictures = staying.cloned().unwrap_or_else(|| Pictures::of(scene));
        let table = self.written("shading_table", room, count, table.texels().take(written), fetch).await?;
        let bind = || {
            let layout = &self.kernels.layouts(fetch).table;
            Ok(bind_group(&self.gpu, "shading_table", layout, std::iter::once(table.binding())))
        };
        let group = self.gpu.checked(bind).await?;
        Ok((table, group, pictures))
    }

    /// Writes texels to where there is room for so many, or to a place of their own.
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

/// A tree, and what a refit keeps of it.
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

/// The way to read a scene: the wanted one, or the other one where only that can hold it.
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
            log::info!("the scene is too large to be read by {wanted:?}: {fetch:?} it is");
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

/// Objects, four a texel.
fn object_texels(objects: &[u32]) -> Vec<Texel> {
    let texel = |four: &[u32]| std::array::from_fn(|index| four.get(index).copied().unwrap_or(crate::MISS));
    if objects.is_empty() { vec![[crate::MISS; 4]] } else { objects.chunks(4).map(texel).collect() }
}
