//! A scene on a device: its BVH and primitives, and the table that shading reads.

use std::{sync::OnceLock, time::Duration};

use glam::Vec3;
use web_time::Instant;

use crate::{
    BvhBuild, Choice, Error, Method, Pose, Renderer, Scene, Sky,
    auto::CostModel,
    bvh,
    geometry::GeometryTexels,
    gpu::{Gpu, Texels, bind_group},
    kernels::Kernels,
    large::LargePrimitives,
    message::counted,
    traversal::{Fetch, Traversal},
    variant::{Shadows, Variant},
};

/// A scene on a device, to be rendered from any number of cameras.
#[derive(Debug)]
pub struct UploadedScene {
    pub(crate) geometry: wgpu::BindGroup,
    pub(crate) shading: wgpu::BindGroup,
    /// What these two bind.
    _texels: [Texels; 2],
    /// Made when edges are first asked for.
    pub(crate) object_table: OnceLock<(wgpu::BindGroup, Texels)>,
    pub(crate) variant: Variant,
    pub(crate) objects: Vec<u32>,
    /// The scene's id of each primitive, in the BVH's order.
    pub(crate) ids: Vec<u32>,
    pub(crate) lights: Vec<Vec3>,
    pub(crate) large: LargePrimitives,
    gpu: Gpu,
    info: UploadInfo,
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
    /// Bytes of the primitives.
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

    /// What `Auto` chooses where even a left view without gaps, with a shadow ray for every light and pixel, could only end in `Naive`.
    pub(crate) fn choose_early(&self, gpu: &Gpu, pose: &Pose) -> Option<Choice> {
        let lights = if self.variant.shadows == Shadows::None { 0 } else { self.lights.len() };
        let pixels = u64::from(pose.size[0]) * u64::from(pose.size[1]);
        let best = CostModel::of(gpu).choose(pose, (lights as u64).saturating_mul(pixels), 0);
        (best.method == Method::Naive).then_some(best)
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
    /// Builds a scene's BVH with a given effort and uploads it. What does not fit the adapter's storage bindings goes to
    /// textures, and the other way round. A scene that is so far from the origin that the step of f32 there is over a
    /// ten-thousandth of its longest side is logged as a warning, once for each renderer.
    ///
    /// # Errors
    /// [`Error::Scene`] for a value that can't be rendered, [`Error::Limit`] for a scene larger than the adapter
    /// takes, saying how many primitives fit, [`Error::OutOfMemory`] and [`Error::DeviceLost`].
    pub async fn upload_async(&self, scene: &Scene, build: BvhBuild) -> Result<UploadedScene, Error> {
        scene.check()?;
        if let Some(warning) = scene.rounding_warning() {
            self.rounding_warned.call_once(|| log::warn!("{warning}")); // a film uploads a scene for each picture
        }
        let started = Instant::now();
        let packed = bvh::build(scene, build, self.traversal.boxes)?;
        let built = started.elapsed();
        let fetch = fetch_that_fits(&self.gpu, self.traversal.fetch, scene, &packed)?;
        let traversal = self.traversal.fetch(fetch);
        let layouts = self.kernels.layouts(fetch);
        let gpu = &self.gpu;
        let texels = GeometryTexels::new(&packed, fetch);
        let geometry = gpu.upload_each("geometry", texels.count(), texels.texels(), fetch).await?;
        let texels = texels_before_sky(scene) + sky_pixels(scene).len();
        let table = gpu.upload_each("shading_table", texels, shading_table(scene), fetch).await?;
        let bind = || {
            let objects: Vec<u32> = (0..scene.primitive_count() as u32).map(|id| scene.object_of(id)).collect();
            let bvh = gpu.uniform_buffer("bvh", bytemuck::bytes_of(&packed.uniform));
            let bindings = [bvh.as_entire_binding(), geometry.binding()];
            Ok(UploadedScene {
                geometry: bind_group(gpu, "geometry", &layouts.geometry, bindings.into_iter()),
                shading: bind_group(gpu, "shading_table", &layouts.table, std::iter::once(table.binding())),
                _texels: [geometry, table],
                object_table: OnceLock::new(),
                variant: Variant::of(scene, traversal, &packed),
                lights: scene.lights.iter().map(|light| light.position).collect(),
                large: LargePrimitives::of(scene),
                gpu: gpu.clone(),
                info: UploadInfo {
                    traversal,
                    build: built,
                    upload: Duration::ZERO,
                    node_bytes: size_of_val(packed.nodes.as_slice()) as u64,
                    primitive_bytes: size_of_val(packed.primitives.as_slice()) as u64,
                    dropped_triangles: scene.degenerate_count(),
                },
                objects,
                ids: packed.ids,
            })
        };
        let mut uploaded = gpu.checked(bind).await?;
        uploaded.info.upload = started.elapsed() - built;
        Ok(uploaded)
    }
}

/// The way to read a scene: the wanted one, or the other one where only that can hold it.
fn fetch_that_fits(gpu: &Gpu, wanted: Fetch, scene: &Scene, packed: &bvh::PackedBvh) -> Result<Fetch, Error> {
    let other = match wanted {
        Fetch::Texture => Fetch::Buffer,
        Fetch::Buffer => Fetch::Texture,
    };
    let geometry = |fetch| GeometryTexels::new(packed, fetch).count() as u64;
    let table = (texels_before_sky(scene) + sky_pixels(scene).len()) as u64;
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
            what: "the scene's table of lights, materials and sky".into(),
            needed: format!("{table} texels of 16 bytes"),
            limit,
            allowed: format!("enough for {capacity}"),
            remedy: "use a smaller sky",
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

/// Texels of the shading table before its lights.
const TABLE_HEAD: usize = 3;

fn texels_before_sky(scene: &Scene) -> usize {
    TABLE_HEAD + 2 * scene.lights.len() + scene.materials().len()
}

/// The pixels of a sky that is a picture.
fn sky_pixels(scene: &Scene) -> &[Vec3] {
    if let Sky::Map(map) = &scene.sky { map.pixels() } else { &[] }
}

/// What shading reads of a scene, a texel each: see shaders/shared/shade.wgsl.
fn shading_table(scene: &Scene) -> impl Iterator<Item = bvh::Texel> {
    let texel = |vector: Vec3, word: u32| {
        let [x, y, z] = vector.to_array().map(f32::to_bits);
        [x, y, z, word]
    };
    let plain = move |vector| texel(vector, 0);
    let [nadir, zenith] = match &scene.sky {
        Sky::Constant(color) => [*color; 2].map(plain),
        Sky::Gradient { nadir, zenith } => [*nadir, *zenith].map(plain),
        Sky::Map(map) => [[texels_before_sky(scene) as u32, map.size()[0], map.size()[1], 0], [0; 4]],
    };
    let head: [_; TABLE_HEAD] = [texel(scene.rendered_ambient(), scene.lights.len() as u32), nadir, zenith];
    let lights = scene.lights.iter().flat_map(|light| [light.position, light.intensity]);
    let albedos = scene.materials().iter().map(|material| material.albedo);
    head.into_iter().chain(lights.chain(albedos).chain(sky_pixels(scene).iter().copied()).map(plain))
}

/// Objects, four a texel.
fn object_texels(objects: &[u32]) -> Vec<bvh::Texel> {
    let texel = |four: &[u32]| std::array::from_fn(|index| four.get(index).copied().unwrap_or(crate::MISS));
    if objects.is_empty() { vec![[crate::MISS; 4]] } else { objects.chunks(4).map(texel).collect() }
}
