//! Shadow-buffers on the device. Missing tables are filled by drawing primitives. Tables are kept with the uploaded
//! scene (`docs/SHADOW-BUFFER.md`).

#[cfg_attr(not(any(test, feature = "testing")), allow(unreachable_pub, reason = "the twins export it"))]
pub(crate) mod mapping;
#[cfg(test)]
mod tests;

use std::{
    ops::Range,
    sync::{Arc, Mutex},
};

use glam::Vec3;

use crate::{
    Error, Options,
    accel::large::LargePrimitives,
    ask::shadow_buffer::{MAX_SHADOW_BUFFERS, Reading, ShadowBuffer, ShadowBufferWork, ShadowRule},
    frame::executor::{Executor, Resources, Workgroups, indirect_buffer},
    gpu::{Gpu, lock},
    kernel::layout::{self, WORKGROUP},
    kernel::variant::{Shadows, Variant},
    kernel::{Canvas, Kernel, Kernels, Resource, Role, kernel},
    t_buffer::{BEGIN_PASS, DRAW_FEW, DRAW_MORE, DRAW_PARTS, DRAWING_HEAD, Drawn, PROJECT_PRIMITIVES},
};
use mapping::Mapping;

// The T-buffer's kernels, specialised to test primitives at texel centres.
pub(crate) const PROJECT_MIDDLES: Kernel =
    Kernel { name: "project_middles", role: Role::Draw(Canvas::Middles), ..PROJECT_PRIMITIVES };
pub(crate) const DRAW_FEW_MIDDLES: Kernel =
    Kernel { name: "draw_few_middles", role: Role::Draw(Canvas::Middles), ..DRAW_FEW };
pub(crate) const DRAW_MORE_MIDDLES: Kernel =
    Kernel { name: "draw_more_middles", role: Role::Draw(Canvas::Middles), ..DRAW_MORE };
pub(crate) const DRAW_PARTS_MIDDLES: Kernel =
    Kernel { name: "draw_parts_middles", role: Role::Draw(Canvas::Middles), ..DRAW_PARTS };
pub(crate) const READ_MIDDLES: Kernel = kernel!("shadow_buffer", "read_middles", Role::Draw(Canvas::Middles));
// The T-buffer's kernels, specialised to mark texels in which a primitive may lie in front of the texel's surface.
pub(crate) const PROJECT_TEXELS: Kernel =
    Kernel { name: "project_texels", role: Role::Draw(Canvas::Texels), ..PROJECT_PRIMITIVES };
pub(crate) const MARK_FEW_TEXELS: Kernel =
    Kernel { name: "mark_few_texels", role: Role::Draw(Canvas::Texels), ..DRAW_FEW };
pub(crate) const MARK_MORE_TEXELS: Kernel =
    Kernel { name: "mark_more_texels", role: Role::Draw(Canvas::Texels), ..DRAW_MORE };
pub(crate) const MARK_PARTS_TEXELS: Kernel =
    Kernel { name: "mark_parts_texels", role: Role::Draw(Canvas::Texels), ..DRAW_PARTS };
pub(crate) const READ_TEXELS: Kernel = kernel!("shadow_buffer", "read_texels", Role::Draw(Canvas::Texels));

/// Format of a texel: t as bits, and the slot. With the hybrid rule, a texel holds a plane and the slot.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;
const HYBRID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
/// Slot value of a texel without known content (`shaders/shared/shadow_buffer.wgsl`).
const UNFILLED: u32 = 0xffff_fffe;
/// Number of words that describe a table's directions, in the row after the table, and the number of columns they need.
const HEAD: usize = 12;
const LEAST_COLUMNS: u32 = 6;
/// Maximum number of texels per submission. Each submission projects all primitives. While a texel is drawn, it takes
/// 24 bytes.
const BAND: u32 = 1 << 21;
/// Number of bytes per write when a layer is filled with one word.
const PIECE: usize = 1 << 22;

/// Shadow-buffer tables of all lights on a device, one layer each.
#[derive(Debug)]
pub(crate) struct Tables {
    texture: Texture,
    /// All layers, for kernels.
    pub(crate) view: wgpu::TextureView,
    /// Light, mapping and margin of each filled layer.
    layers: Vec<Layer>,
}

/// Shadow-buffers of the last frame that used any, kept with the uploaded scene.
pub(crate) type Kept = Mutex<Option<Arc<Tables>>>;

/// The parts of a scene that shadow-buffers depend on.
pub(crate) struct Casters<'a> {
    pub(crate) variant: &'a Variant,
    /// Whether the scene has no primitives.
    pub(crate) is_empty: bool,
    /// Primitives to draw, or `None` if none can be drawn.
    pub(crate) drawn: Option<Drawn>,
    /// Indices among all lights, and positions, of the point lights.
    pub(crate) point_lights: &'a [(u32, Vec3)],
    /// Bounds of all primitives except planes.
    pub(crate) bounds: Option<(Vec3, Vec3)>,
    pub(crate) large: &'a LargePrimitives,
}

/// A light, the mapping of its table, and the margin of the hybrid rule, if any.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layer {
    light: Vec3,
    mapping: Mapping,
    margin: Option<f32>,
}

/// Device resources for filling a layer.
struct Filling<'a> {
    gpu: &'a Gpu,
    kernels: &'a Kernels,
    with: Variant,
    drawn: Option<Drawn>,
    frame: wgpu::Buffer,
    counters: wgpu::Buffer,
    t_buffer: wgpu::Buffer,
    /// The finished texels, with the hybrid rule only.
    texels: Option<wgpu::Buffer>,
    drawing: wgpu::Buffer,
    indirect: wgpu::Buffer,
    /// Resources that the kernels bind: the buffers above and the scene's resources.
    resources: Resources,
}

/// A texture whose memory is freed when it is dropped, like `Texels`.
#[derive(Debug)]
struct Texture(wgpu::Texture);

impl Drop for Texture {
    fn drop(&mut self) {
        self.0.destroy();
    }
}

fn format_of(buffer: &ShadowBuffer) -> wgpu::TextureFormat {
    match buffer.rule {
        ShadowRule::Hybrid { .. } => HYBRID_FORMAT,
        ShadowRule::Object | ShadowRule::Depth { .. } => FORMAT,
    }
}

impl Casters<'_> {
    /// Returns the lights with a table: their indices among all lights, and their positions.
    fn lights(&self) -> impl Iterator<Item = (u32, Vec3)> + '_ {
        let near = self.variant.shadows == Shadows::FromLight && !self.is_empty;
        let can_draw = !self.variant.has_tree() || self.drawn.is_some();
        let lights = self.point_lights.iter().copied().filter(move |(place, _)| near && can_draw && *place < 32);
        lights.take(MAX_SHADOW_BUFFERS)
    }

    /// Returns how a frame's kernels read the tables; `None` if there are none.
    pub(crate) fn reading(&self, options: &Options) -> Option<Reading> {
        let lights = self.lights().fold(0, |mask, (place, _)| mask | 1 << place);
        options.shadow_buffer.filter(|_| lights != 0).map(|buffer| Reading::new(buffer.rule, lights))
    }

    fn layers(&self, buffer: &ShadowBuffer) -> Vec<Layer> {
        let mapping = |light| match (buffer.rule, self.bounds) {
            // Planes extend in all directions, and so does the paper's table.
            (ShadowRule::Depth { .. } | ShadowRule::Hybrid { .. }, Some(bounds)) if self.variant.planes == 0 => {
                Mapping::around(light, bounds, buffer.rows)
            }
            _ => Mapping::whole(buffer.rows),
        };
        let margin = match buffer.rule {
            ShadowRule::Hybrid { margin } => Some(margin),
            _ => None,
        };
        self.lights().map(|(_, light)| Layer { light, mapping: mapping(light), margin }).collect()
    }
}

/// Returns the tables that a frame queries, after filling missing ones; `None` if it queries none. `scene` has the
/// scene's resources, and `kept` the tables of the last frame.
pub(crate) async fn tables(
    (gpu, kernels): (&Gpu, &Kernels),
    casters: &Casters<'_>,
    scene: &Resources,
    kept_tables: &Kept,
    options: &Options,
) -> Result<Option<(Arc<Tables>, ShadowBufferWork)>, Error> {
    let Some(buffer) = options.shadow_buffer.filter(|_| casters.reading(options).is_some()) else {
        return Ok(None);
    };
    let format = format_of(&buffer);
    let size = Tables::size(gpu, &buffer, casters.lights().count())?;
    let layers = casters.layers(&buffer);
    let mut work = ShadowBufferWork { bytes: Tables::bytes(format, size), ..Default::default() };
    let fits = |kept: &Tables| kept.texture.0.size() == size && kept.texture.0.format() == format;
    let kept = lock(kept_tables).clone();
    if let Some(kept) = kept.filter(|kept| fits(kept) && kept.layers == layers) {
        return Ok(Some((kept, work)));
    }
    // Tables that another frame still reads are not overwritten. Incompletely filled tables are not kept.
    let before = lock(kept_tables).take().and_then(Arc::into_inner);
    let mut tables = match before.filter(fits) {
        Some(before) => before,
        None => gpu.checked(|| Ok(Tables::new(gpu, format, size))).await?,
    };
    for (index, layer) in layers.iter().enumerate().filter(|(index, layer)| tables.layers.get(*index) != Some(layer)) {
        let filling = Filler { gpu, kernels, casters, scene, options };
        filling.fill(&tables.texture, index as u32, layer, &mut work).await?;
    }
    tables.layers = layers;
    let filled = Arc::new(tables);
    *lock(kept_tables) = Some(filled.clone());
    Ok(Some((filled, work)))
}

/// What filling a layer needs besides the layer.
#[derive(Clone, Copy)]
struct Filler<'a> {
    gpu: &'a Gpu,
    kernels: &'a Kernels,
    casters: &'a Casters<'a>,
    scene: &'a Resources,
    options: &'a Options,
}

impl Filler<'_> {
    /// Fills a layer, with a limited number of rows per submission.
    async fn fill(
        &self,
        texture: &Texture,
        index: u32,
        layer: &Layer,
        work: &mut ShadowBufferWork,
    ) -> Result<(), Error> {
        let gpu = self.gpu;
        let Mapping { rows, columns, .. } = layer.mapping;
        // A row that is copied into a texture begins at a multiple of this many bytes.
        let per_row = columns.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT / texture.texel());
        let step = (BAND / per_row).clamp(1, rows);
        let begin = || {
            texture.write_head(gpu, index, &layer.mapping);
            Ok(Filling::new(self, layer, u64::from(per_row) * u64::from(step)))
        };
        let filling = gpu.checked(begin).await?;
        for begin in (0..rows).step_by(step as usize) {
            let band = begin..rows.min(begin + step);
            let submit = || {
                filling.begin(layer, &band, per_row);
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                filling.encode(&mut encoder, layer, &band);
                texture.encode_copy(&mut encoder, index, [columns, per_row], &band, filling.filled());
                gpu.submit([encoder.finish()]);
                Ok(())
            };
            gpu.checked(submit).await?;
        }
        let words: Vec<u32> = gpu.read(&filling.counters, layout::COUNTERS).await?;
        if words[layout::CUT_SHORT] > 0 {
            // An adapter ended a loop early, so the texels are unreliable.
            log::warn!("the adapter stopped filling a shadow-buffer early: falling back to shadow rays");
            let empty = || {
                texture.fill(gpu, index, UNFILLED);
                texture.write_head(gpu, index, &layer.mapping);
                Ok(())
            };
            gpu.checked(empty).await?;
        }
        work.filled += u64::from(rows) * u64::from(columns);
        work.nodes += u64::from(words[layout::NODES_VISITED]);
        work.primitive_tests += u64::from(words[layout::PRIMITIVES_TESTED]);
        Ok(())
    }
}

impl<'a> Filling<'a> {
    fn new(filler: &Filler<'a>, layer: &Layer, texels: u64) -> Self {
        let Filler { gpu, kernels, casters, scene, options } = *filler;
        let with = Variant { close: casters.large.any_close_to(&[layer.light]), ..*casters.variant };
        let drawn = casters.drawn;
        let indirect = indirect_buffer(gpu);
        let frame = gpu.uniform_buffer("frame", bytemuck::bytes_of(&layout::TableFrame::default()));
        let counters = gpu.storage_buffer("counters", layout::COUNTERS as u64 * 4);
        let t_buffer = gpu.storage_buffer("t_buffer", 8 * texels);
        let texels = layer.margin.map(|_| gpu.storage_buffer("texels", 16 * texels));
        let drawing = gpu.storage_buffer("drawing", drawn.unwrap_or_default().list_bytes());
        let mut resources = scene
            .clone()
            .with(Resource::Frame, &frame)
            .with(Resource::Counters, &counters)
            .with(Resource::TBuffer, &t_buffer)
            .with(Resource::Drawing, &drawing);
        if let Some(texels) = &texels {
            resources.set(Resource::Texels, texels);
        }
        let with = with.counting(options.count, false);
        Self { gpu, kernels, with, drawn, frame, counters, t_buffer, texels, drawing, indirect, resources }
    }

    /// Returns the buffer that the table's texels are copied from.
    fn filled(&self) -> &wgpu::Buffer {
        self.texels.as_ref().unwrap_or(&self.t_buffer)
    }

    /// Uploads the uniforms for these rows.
    fn begin(&self, layer: &Layer, rows: &Range<u32>, per_row: u32) {
        let Mapping { axes: [x, y, z], theta, phi, columns, .. } = layer.mapping;
        let mapping = layout::Mapping {
            light: layer.light.to_array(),
            theta_begin: theta[0],
            axis_x: x.to_array(),
            theta_step: theta[1],
            axis_y: y.to_array(),
            phi_begin: phi[0],
            axis_z: z.to_array(),
            phi_step: phi[1],
            columns,
            margin: layer.margin.unwrap_or(0.0),
            ..Default::default()
        };
        let band = layout::Band { size: [per_row, rows.len() as u32], first_row: rows.start, ..Default::default() };
        let frame = layout::TableFrame { mapping, band };
        self.gpu.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame));
    }

    /// Encodes three steps: drawing the nearest hit of each texel, reading it, and marking texels with possible nearer
    /// primitives.
    fn encode(&self, encoder: &mut wgpu::CommandEncoder, layer: &Layer, rows: &Range<u32>) {
        encoder.clear_buffer(&self.t_buffer, 0, None);
        encoder.clear_buffer(&self.drawing, 0, Some(DRAWING_HEAD));
        let (project, read) = match layer.margin {
            Some(_) => (&PROJECT_TEXELS, &READ_TEXELS),
            None => (&PROJECT_MIDDLES, &READ_MIDDLES),
        };
        let mut executor = Executor::new(self.gpu, self.kernels, Some(&self.indirect), None);
        let mut run = |kernel: &Kernel, resources: &Resources, workgroups: Workgroups<'_>| {
            executor.run(encoder, kernel.name, (kernel, self.with), resources, workgroups);
        };
        let lists = [0, 1, 2].map(|list| Workgroups::Listed(&self.drawing, list));
        if let Some(drawn) = self.drawn {
            run(project, &self.resources, Workgroups::Number(drawn.workgroups()));
            for _ in 0..2 {
                run(&BEGIN_PASS, &self.resources, Workgroups::Number([1, 1, 1]));
                for (kernel, list) in
                    [&DRAW_FEW_MIDDLES, &DRAW_MORE_MIDDLES, &DRAW_PARTS_MIDDLES].into_iter().zip(lists)
                {
                    run(kernel, &self.resources, list);
                }
            }
        }
        let side = WORKGROUP * read.block(&self.with);
        let [x, y] = [layer.mapping.columns, rows.len() as u32].map(|texels| texels.div_ceil(side));
        run(read, &self.resources, Workgroups::Number([x, y, 1]));
        if let Some(texels) = self.texels.as_ref().filter(|_| self.drawn.is_some()) {
            // The marking kernels write to the finished texels instead of the T-buffer.
            let resources = self.resources.clone().with(Resource::TBuffer, texels);
            for (kernel, list) in [&MARK_FEW_TEXELS, &MARK_MORE_TEXELS, &MARK_PARTS_TEXELS].into_iter().zip(lists) {
                run(kernel, &resources, list);
            }
        }
    }
}

impl Drop for Filling<'_> {
    fn drop(&mut self) {
        let all = [&self.frame, &self.counters, &self.t_buffer, &self.drawing, &self.indirect];
        all.into_iter().chain(&self.texels).for_each(wgpu::Buffer::destroy);
    }
}

impl Texture {
    /// Creates a texture filled with zeros. The zeros are written explicitly: otherwise wgpu would clear the texture at
    /// its first use. After such a clear, Mesa's software driver takes every timestamp too early.
    fn new(gpu: &Gpu, format: wgpu::TextureFormat, size: wgpu::Extent3d) -> Self {
        use wgpu::TextureUsages as Usages;

        let usage = Usages::TEXTURE_BINDING | Usages::COPY_DST | Usages::COPY_SRC;
        let texture = Self(gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow_buffers"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        }));
        (0..size.depth_or_array_layers).for_each(|layer| texture.fill(gpu, layer, 0));
        texture
    }

    /// Returns the size of a texel in bytes.
    fn texel(&self) -> u32 {
        self.0.format().block_copy_size(None).expect("no depth")
    }

    /// Fills a layer with one word.
    fn fill(&self, gpu: &Gpu, layer: u32, word: u32) {
        let (width, height) = (self.0.width(), self.0.height());
        let row = width as usize * self.texel() as usize / 4;
        let rows = (PIECE / (4 * row)).clamp(1, height as usize);
        let words = vec![word; row * rows];
        for begin in (0..height).step_by(rows) {
            let rows = (height - begin).min(rows as u32);
            let bytes = bytemuck::cast_slice(&words[..row * rows as usize]);
            self.write(gpu, [0, begin, layer], [width, rows], bytes);
        }
    }

    fn write(&self, gpu: &Gpu, [x, y, z]: [u32; 3], [width, height]: [u32; 2], bytes: &[u8]) {
        let target = wgpu::TexelCopyTextureInfo {
            texture: &self.0,
            mip_level: 0,
            origin: wgpu::Origin3d { x, y, z },
            aspect: wgpu::TextureAspect::All,
        };
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * self.texel()), rows_per_image: None };
        gpu.queue.write_texture(target, bytes, layout, wgpu::Extent3d { width, height, depth_or_array_layers: 1 });
    }

    /// Encodes the copy of filled rows into the texture.
    fn encode_copy(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        layer: u32,
        [columns, per_row]: [u32; 2],
        rows: &Range<u32>,
        filled: &wgpu::Buffer,
    ) {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(per_row * self.texel()),
            rows_per_image: None,
        };
        let to = wgpu::TexelCopyTextureInfo {
            texture: &self.0,
            mip_level: 0,
            origin: wgpu::Origin3d { x: 0, y: rows.start, z: layer },
            aspect: wgpu::TextureAspect::All,
        };
        let size = wgpu::Extent3d { width: columns, height: rows.len() as u32, depth_or_array_layers: 1 };
        encoder.copy_buffer_to_texture(wgpu::TexelCopyBufferInfo { buffer: filled, layout }, to, size);
    }

    /// Writes the words that describe a table's directions to the row after the table (`directions_of` in
    /// `shaders/shared/shadow_buffer.wgsl`).
    fn write_head(&self, gpu: &Gpu, layer: u32, mapping: &Mapping) {
        let Mapping { axes: [x, _, z], theta, phi, rows, columns } = *mapping;
        let floats = [theta, phi, [x.x, x.y], [x.z, z.x], [z.y, z.z]].map(|two| two.map(f32::to_bits));
        let mut words = vec![columns, rows];
        words.extend(floats.as_flattened());
        let (row, columns) = (self.0.height() - 1, 4 * HEAD as u32 / self.texel());
        self.write(gpu, [0, row, layer], [columns, 1], bytemuck::cast_slice(&words[..HEAD]));
    }
}

impl Tables {
    /// Creates tables without a filled layer.
    fn new(gpu: &Gpu, format: wgpu::TextureFormat, size: wgpu::Extent3d) -> Self {
        let texture = Texture::new(gpu, format, size);
        let view = texture.0.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Self { texture, view, layers: Vec::new() }
    }

    /// Returns the size of a texture for this many lights.
    ///
    /// # Errors
    /// [`Error::Limit`] naming the exceeded limit.
    fn size(gpu: &Gpu, buffer: &ShadowBuffer, lights: usize) -> Result<wgpu::Extent3d, Error> {
        let side = gpu.limits.max_texture_dimension_2d;
        let columns = buffer.rows.saturating_mul(2);
        let what = format!("a shadow-buffer of {} rows", buffer.rows);
        let remedy = "use fewer rows";
        if columns > side || buffer.rows.saturating_add(1) > side {
            return Err(Error::Limit {
                what,
                needed: format!("{columns} columns"),
                limit: "max_texture_dimension_2d",
                allowed: side.to_string(),
                remedy,
            });
        }
        let (width, height) = (columns.max(LEAST_COLUMNS), buffer.rows + 1);
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: lights as u32 };
        // Textures have no size limit in bytes, so tables must not exceed the limit of buffers.
        let (bytes, allowed) = (Self::bytes(format_of(buffer), size), gpu.limits.max_buffer_size);
        if bytes > allowed {
            let mib = |bytes: u64| format!("{} MiB", bytes.div_ceil(1 << 20));
            return Err(Error::Limit {
                what: format!("{what} for each of {lights} lights"),
                needed: mib(bytes),
                limit: "max_buffer_size",
                allowed: mib(allowed),
                remedy,
            });
        }
        Ok(size)
    }

    fn bytes(format: wgpu::TextureFormat, size: wgpu::Extent3d) -> u64 {
        let texel = u64::from(format.block_copy_size(None).expect("no depth"));
        texel * u64::from(size.width) * u64::from(size.height) * u64::from(size.depth_or_array_layers)
    }
}
