//! Shadow-buffers on the device: filled where none is kept, and kept with the uploaded scene (`docs/SHADOW-BUFFER.md`).

#[cfg(test)]
mod tests;

use std::{ops::Range, sync::Arc};

use glam::Vec3;

use crate::{
    Error, Options, Renderer, UploadedScene,
    cpu::shadow_buffer::Mapping,
    frame::{
        band_pixels,
        targets::Target::{Counters, Found},
    },
    gpu::{Gpu, bind_group, lock},
    kernels::{Access::Write, Kernel, Touches},
    layout::{self, WORKGROUP},
    shadow_buffer::{MAX_SHADOW_BUFFERS, Reading, ShadowBuffer, ShadowBufferWork, ShadowRule},
    variant::{Shadows, Variant},
    wgsl::part,
};

pub(crate) const FILL_SHADOW_BUFFER: Kernel = Kernel {
    name: "fill_shadow_buffer",
    touches: Touches::Geometry,
    storage: &[(Counters, Write), (Found, Write)],
    main: part!("fill_shadow_buffer.wgsl"),
};

/// t as bits, and the primitive's place.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;
/// Bytes of a texel.
const TEXEL: u64 = 8;
/// Texels of the row behind a table that says where its directions are.
const HEAD: u32 = 6;
/// Bytes of zeros that are handed over at a time.
const PIECE: u64 = 1 << 22;

/// All lights' tables on a device, a layer each.
#[derive(Debug)]
pub(crate) struct Tables {
    texture: Texture,
    /// All layers, as kernels read them.
    pub(crate) view: wgpu::TextureView,
    /// What each layer was filled for.
    layers: Vec<Layer>,
}

/// A light, and where directions stand in its table.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layer {
    light: Vec3,
    mapping: Mapping,
}

/// Freed when it is dropped, as `Texels` are.
#[derive(Debug)]
struct Texture(wgpu::Texture);

impl Drop for Texture {
    fn drop(&mut self) {
        self.0.destroy();
    }
}

impl UploadedScene {
    /// Which lights have a table, by their places among all, and their positions.
    fn buffered_lights(&self) -> impl Iterator<Item = (u32, Vec3)> + '_ {
        let near = self.variant.shadows == Shadows::FromLight && !self.ids.is_empty();
        let lights = self.point_lights.iter().copied().filter(move |(place, _)| near && *place < 32);
        lights.take(MAX_SHADOW_BUFFERS)
    }

    /// How kernels of a frame read them; `None` where there are none.
    pub(crate) fn shadow_reading(&self, options: &Options) -> Option<Reading> {
        let lights = self.buffered_lights().fold(0, |mask, (place, _)| mask | 1 << place);
        options.shadow_buffer.filter(|_| lights != 0).map(|buffer| Reading::new(buffer.rule, lights))
    }

    fn layers(&self, buffer: &ShadowBuffer) -> Vec<Layer> {
        let mapping = |light| match (buffer.rule, self.bounds) {
            // Planes go on in all directions, and the paper's table is all of them.
            (ShadowRule::Depth { .. } | ShadowRule::Hybrid { .. }, Some(bounds)) if self.variant.planes == 0 => {
                Mapping::around(light, bounds, buffer.rows)
            }
            _ => Mapping::whole(buffer.rows),
        };
        self.buffered_lights().map(|(_, light)| Layer { light, mapping: mapping(light) }).collect()
    }
}

impl Renderer {
    /// The tables that a frame asks, filled as far as they were not; `None` where it asks none.
    pub(crate) async fn shadow_tables(
        &self,
        scene: &UploadedScene,
        options: &Options,
    ) -> Result<Option<(Arc<Tables>, ShadowBufferWork)>, Error> {
        let Some(buffer) = options.shadow_buffer.filter(|_| scene.shadow_reading(options).is_some()) else {
            return Ok(None);
        };
        let size = Tables::size(&self.gpu, &buffer, scene.buffered_lights().count())?;
        let layers = scene.layers(&buffer);
        let mut work = ShadowBufferWork { bytes: Tables::bytes(size), ..Default::default() };
        let is_kept = |kept: &&Arc<Tables>| kept.texture.0.size() == size && kept.layers == layers;
        if let Some(kept) = lock(&scene.shadow_tables).as_ref().filter(is_kept) {
            return Ok(Some((kept.clone(), work)));
        }
        // What another frame still reads is left alone, and what is not filled to the end is not kept.
        let before = lock(&scene.shadow_tables).take().and_then(Arc::into_inner);
        let mut tables = match before.filter(|before| before.texture.0.size() == size) {
            Some(before) => before,
            None => self.gpu.checked(|| Ok(Tables::new(&self.gpu, size))).await?,
        };
        for (index, layer) in
            layers.iter().enumerate().filter(|(index, layer)| tables.layers.get(*index) != Some(layer))
        {
            self.fill(scene, &tables.texture, index as u32, layer, options, &mut work).await?;
        }
        tables.layers = layers;
        let filled = Arc::new(tables);
        *lock(&scene.shadow_tables) = Some(filled.clone());
        Ok(Some((filled, work)))
    }

    /// Fills a layer, some rows a submission.
    async fn fill(
        &self,
        scene: &UploadedScene,
        texture: &Texture,
        index: u32,
        layer: &Layer,
        options: &Options,
        work: &mut ShadowBufferWork,
    ) -> Result<(), Error> {
        let gpu = &self.gpu;
        let with = Variant { close: scene.large.any_close_to(&[layer.light]), ..scene.variant };
        let with = with.counting(options.count, false).of_kernel(&FILL_SHADOW_BUFFER);
        let Mapping { rows, columns, .. } = layer.mapping;
        // A submission's rows: whole workgroups, and no more than a binding holds.
        let whole = WORKGROUP * FILL_SHADOW_BUFFER.block(&with);
        let step = (band_pixels(gpu) / columns).clamp(1, rows).next_multiple_of(whole);
        let per_row = columns.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT / TEXEL as u32);
        let begin = || {
            texture.write_head(gpu, index, &layer.mapping);
            let filled = TEXEL * u64::from(per_row) * u64::from(step);
            Ok([gpu.storage_buffer("counters", layout::COUNTERS as u64 * 4), gpu.storage_buffer("filled", filled)])
        };
        let [counters, filled] = gpu.checked(begin).await?;
        for begin in (0..rows).step_by(step as usize) {
            let filling = filling_of(layer, begin..rows.min(begin + step), per_row);
            let submit = || {
                let mut encoder = self.encode_fill(scene, &filling, with, [&counters, &filled]);
                texture.encode_copy(&mut encoder, index, &filling, &filled);
                gpu.queue.submit([encoder.finish()]);
                Ok(())
            };
            gpu.checked(submit).await?;
        }
        work.filled += u64::from(rows) * u64::from(columns);
        if options.count {
            let words: Vec<u32> = gpu.read(&counters, layout::COUNTERS).await?;
            work.nodes += u64::from(words[layout::NODES_VISITED]);
            work.primitive_tests += u64::from(words[layout::PRIMITIVES_TESTED]);
        }
        [counters, filled].iter().for_each(wgpu::Buffer::destroy);
        Ok(())
    }

    fn encode_fill(
        &self,
        scene: &UploadedScene,
        filling: &layout::Filling,
        with: Variant,
        buffers: [&wgpu::Buffer; 2],
    ) -> wgpu::CommandEncoder {
        let gpu = &self.gpu;
        let pipeline = self.kernels.get(gpu, &FILL_SHADOW_BUFFER, with);
        let uniform = gpu.uniform_buffer("filling", bytemuck::bytes_of(filling));
        let [counters, filled] = buffers;
        let own = [&uniform, counters, filled].map(wgpu::Buffer::as_entire_binding);
        let name = FILL_SHADOW_BUFFER.name;
        let own = bind_group(gpu, name, &pipeline.own, own.into_iter());
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes: None };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(&pipeline.pipeline);
        pass.set_bind_group(0, &scene.geometry, &[]);
        pass.set_bind_group(1, &own, &[]);
        let side = WORKGROUP * FILL_SHADOW_BUFFER.block(&with);
        let rows = filling.row_end - filling.row_begin;
        pass.dispatch_workgroups(filling.columns.div_ceil(side), rows.div_ceil(side), 1);
        drop(pass);
        encoder
    }
}

fn filling_of(layer: &Layer, rows: Range<u32>, per_row: u32) -> layout::Filling {
    let Mapping { axes: [x, y, z], theta, phi, columns, .. } = layer.mapping;
    layout::Filling {
        light: layer.light.to_array(),
        theta_begin: theta[0],
        axis_x: x.to_array(),
        theta_step: theta[1],
        axis_y: y.to_array(),
        phi_begin: phi[0],
        axis_z: z.to_array(),
        phi_step: phi[1],
        row_begin: rows.start,
        row_end: rows.end,
        columns,
        per_row,
    }
}

impl Texture {
    /// All zeros. Not left to wgpu, which clears it at its first use: after a clear Mesa's software driver takes every timestamp too early.
    fn new(gpu: &Gpu, size: wgpu::Extent3d) -> Self {
        use wgpu::TextureUsages as Usages;

        let usage = Usages::TEXTURE_BINDING | Usages::COPY_DST | Usages::COPY_SRC;
        let texture = Self(gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow_buffers"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage,
            view_formats: &[],
        }));
        let row = u64::from(size.width) * TEXEL;
        let rows = (PIECE / row).clamp(1, size.height.into()) as u32;
        let zeros = vec![0; (row * u64::from(rows)) as usize];
        for layer in 0..size.depth_or_array_layers {
            for begin in (0..size.height).step_by(rows as usize) {
                let rows = rows.min(size.height - begin);
                texture.write(gpu, [0, begin, layer], [size.width, rows], &zeros[..(row * u64::from(rows)) as usize]);
            }
        }
        texture
    }

    fn write(&self, gpu: &Gpu, [x, y, z]: [u32; 3], [width, height]: [u32; 2], bytes: &[u8]) {
        let target = wgpu::TexelCopyTextureInfo {
            texture: &self.0,
            mip_level: 0,
            origin: wgpu::Origin3d { x, y, z },
            aspect: wgpu::TextureAspect::All,
        };
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * TEXEL as u32), rows_per_image: None };
        gpu.queue.write_texture(target, bytes, layout, wgpu::Extent3d { width, height, depth_or_array_layers: 1 });
    }

    /// Takes over rows that were filled.
    fn encode_copy(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        layer: u32,
        rows: &layout::Filling,
        filled: &wgpu::Buffer,
    ) {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(rows.per_row * TEXEL as u32),
            rows_per_image: None,
        };
        let to = wgpu::TexelCopyTextureInfo {
            texture: &self.0,
            mip_level: 0,
            origin: wgpu::Origin3d { x: 0, y: rows.row_begin, z: layer },
            aspect: wgpu::TextureAspect::All,
        };
        let (width, height) = (rows.columns, rows.row_end - rows.row_begin);
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        encoder.copy_buffer_to_texture(wgpu::TexelCopyBufferInfo { buffer: filled, layout }, to, size);
    }

    /// Says behind a table where its directions are (`directions_of` of `shaders/shared/shadow_buffer.wgsl`).
    fn write_head(&self, gpu: &Gpu, layer: u32, mapping: &Mapping) {
        let Mapping { axes: [x, _, z], theta, phi, rows, columns } = *mapping;
        let floats = [theta, phi, [x.x, x.y], [x.z, z.x], [z.y, z.z]].map(|two| two.map(f32::to_bits));
        let mut words = vec![columns, rows];
        words.extend(floats.as_flattened());
        let row = self.0.height() - 1;
        self.write(gpu, [0, row, layer], [HEAD, 1], bytemuck::cast_slice(&words));
    }
}

impl Tables {
    /// With nothing filled.
    fn new(gpu: &Gpu, size: wgpu::Extent3d) -> Self {
        let texture = Texture::new(gpu, size);
        let view = texture.0.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Self { texture, view, layers: Vec::new() }
    }

    /// Of a texture for so many lights.
    ///
    /// # Errors
    /// [`Error::Limit`], naming the limit that it does not keep.
    fn size(gpu: &Gpu, buffer: &ShadowBuffer, lights: usize) -> Result<wgpu::Extent3d, Error> {
        let side = gpu.limits.max_texture_dimension_2d;
        let columns = buffer.rows.saturating_mul(2);
        let what = format!("a shadow-buffer of {} rows", buffer.rows);
        let remedy = "ask for fewer rows";
        if columns > side || buffer.rows.saturating_add(1) > side {
            return Err(Error::Limit {
                what,
                needed: format!("{columns} columns"),
                limit: "max_texture_dimension_2d",
                allowed: side.to_string(),
                remedy,
            });
        }
        let (width, height) = (columns.max(HEAD), buffer.rows + 1);
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: lights as u32 };
        // Textures have no limit of their own; what no buffer may hold is too much for a table too.
        let (bytes, allowed) = (Self::bytes(size), gpu.limits.max_buffer_size);
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

    fn bytes(size: wgpu::Extent3d) -> u64 {
        TEXEL * u64::from(size.width) * u64::from(size.height) * u64::from(size.depth_or_array_layers)
    }
}
