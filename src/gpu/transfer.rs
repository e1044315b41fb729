//! Buffers and textures, their upload and their read-back.

use super::{Gpu, Staging, TEXELS};
use crate::Error;

/// Four words: the result of one texture or storage buffer load.
pub(crate) type Texel = [u32; 4];

/// How kernels read a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Fetch {
    /// Reads textures, which is faster on CPU adapters.
    Texture,
    /// Reads storage buffers.
    Buffer,
}

/// Width of the textures that hold a scene (`shaders/shared/fetch.wgsl`).
pub(crate) const TEXTURE_WIDTH: u32 = 8192;

/// Number of texels per upload: 16 MiB, in whole rows of these textures.
const PIECE: usize = 1 << 20;

impl Gpu {
    pub(crate) fn storage_buffer(&self, label: &str, bytes: u64) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.max(16),
            usage,
            mapped_at_creation: false,
        })
    }

    /// Creates a uniform buffer. It is not mapped at creation, since mapping panics on a lost device.
    pub(crate) fn uniform_buffer(&self, label: &str, contents: &[u8]) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: contents.len() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    /// Returns the number of texels that fit one texture or binding.
    pub(crate) fn texel_capacity(&self, fetch: Fetch) -> u64 {
        match fetch {
            Fetch::Texture => match self.limits.max_texture_dimension_2d {
                side if side < TEXTURE_WIDTH => 0,
                side => u64::from(TEXTURE_WIDTH) * u64::from(side),
            },
            Fetch::Buffer => self.binding_limit() / size_of::<Texel>() as u64,
        }
    }

    /// Returns the maximum number of texels of a scene's shading table, in a texture or in a buffer, whichever holds
    /// more.
    #[cfg(any(feature = "scene-files", feature = "sky", feature = "textures", feature = "json"))]
    pub(crate) fn largest_table(&self) -> u64 {
        self.texel_capacity(Fetch::Texture).max(self.texel_capacity(Fetch::Buffer))
    }

    /// Uploads texels as a texture or a storage buffer.
    ///
    /// # Errors
    /// [`Error::Limit`] if they do not fit one texture or binding, [`Error::OutOfMemory`] and [`Error::DeviceLost`].
    pub(crate) async fn upload(&self, label: &'static str, texels: &[Texel], fetch: Fetch) -> Result<Texels, Error> {
        self.upload_each(label, texels.len(), texels.iter().copied(), fetch).await
    }

    /// Uploads `count` texels from an iterator, without holding all of them at once.
    ///
    /// # Errors
    /// See [`Gpu::upload`].
    pub(crate) async fn upload_each(
        &self,
        label: &'static str,
        count: usize,
        texels: impl Iterator<Item = Texel>,
        fetch: Fetch,
    ) -> Result<Texels, Error> {
        let room = self.room(label, count, fetch).await?;
        self.fill(&room, texels).await?;
        Ok(room)
    }

    /// Creates a texture or a storage buffer for this many texels.
    ///
    /// # Errors
    /// See [`Gpu::upload`].
    pub(crate) async fn room(&self, label: &'static str, count: usize, fetch: Fetch) -> Result<Texels, Error> {
        match fetch {
            Fetch::Texture => {
                if count as u64 > self.texel_capacity(fetch) {
                    return Err(Error::Limit {
                        what: format!("the scene's {label} texture"),
                        needed: format!("{count} texels in rows of {TEXTURE_WIDTH}"),
                        limit: "max_texture_dimension_2d",
                        allowed: self.limits.max_texture_dimension_2d.to_string(),
                        remedy: "use fewer primitives",
                    });
                }
                let make = || Ok(self.rows_of_texels(label, TEXTURE_WIDTH.min(count.max(1) as u32), count));
                Ok(Texels::Texture(self.checked(make).await?))
            }
            Fetch::Buffer => {
                let (what, bytes) = (format!("the scene's {label} buffer"), (count * size_of::<Texel>()) as u64);
                check_bytes(&what, bytes, self.binding_limit(), "use fewer primitives")?;
                Ok(Texels::Buffer(self.checked(|| Ok(self.storage_buffer(label, bytes))).await?))
            }
        }
    }

    /// Writes texels from index 0 on. They must fit.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] and [`Error::DeviceLost`].
    pub(crate) async fn fill(&self, room: &Texels, texels: impl Iterator<Item = Texel>) -> Result<(), Error> {
        self.fill_from(room, 0, texels).await
    }

    /// Writes texels from index `begin` on.
    ///
    /// # Errors
    /// See [`Gpu::fill`].
    pub(crate) async fn fill_from(
        &self,
        room: &Texels,
        begin: usize,
        texels: impl Iterator<Item = Texel>,
    ) -> Result<(), Error> {
        let write = |first: usize, texels: &[Texel]| match room {
            Texels::Texture(view) => self.write_rows(view.texture(), begin + first, texels),
            Texels::Buffer(buffer) => {
                let offset = ((begin + first) * size_of::<Texel>()) as u64;
                self.queue.write_buffer(buffer, offset, bytemuck::cast_slice(texels));
            }
        };
        self.in_pieces(texels, write).await
    }

    /// Writes texels to a texture's rows, from index `begin` on.
    ///
    /// # Errors
    /// See [`Gpu::fill`].
    pub(crate) async fn fill_rows(
        &self,
        texture: &wgpu::Texture,
        begin: usize,
        texels: impl Iterator<Item = Texel>,
    ) -> Result<(), Error> {
        self.in_pieces(texels, |first, texels| self.write_rows(texture, begin + first, texels)).await
    }

    /// Writes texels in pieces; `write` takes the index of a piece's first texel. A driver holds a copy of each piece
    /// until it is uploaded, so each piece is waited for before the next.
    async fn in_pieces(
        &self,
        mut texels: impl Iterator<Item = Texel>,
        write: impl Fn(usize, &[Texel]),
    ) -> Result<(), Error> {
        let mut piece = Vec::new();
        for first in (0..).step_by(PIECE) {
            piece.clear();
            piece.extend(texels.by_ref().take(PIECE));
            let write = || {
                if !piece.is_empty() {
                    write(first, &piece);
                }
                Ok((piece.len() == PIECE).then(|| self.submit([])))
            };
            match self.checked(write).await? {
                Some(submission) => self.finished(submission).await?,
                None => break,
            }
        }
        Ok(())
    }

    /// Creates a texture and fills it with rows of texels. The last row may be partial.
    pub(crate) fn filled_texture(&self, label: &str, width: u32, texels: &[Texel]) -> wgpu::TextureView {
        let view = self.rows_of_texels(label, width, texels.len());
        self.write_rows(view.texture(), 0, texels);
        view
    }

    /// Creates a texture with room for this many texels in rows of `width`.
    pub(crate) fn rows_of_texels(&self, label: &str, width: u32, texels: usize) -> wgpu::TextureView {
        self.texel_rows(label, width, texels).create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// Creates a texture with room for this many texels in rows of `width`.
    fn texel_rows(&self, label: &str, width: u32, texels: usize) -> wgpu::Texture {
        let height = texels.div_ceil(width as usize).max(1) as u32;
        let bound = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
        let copied = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST;
        self.texture(label, [width, height], TEXELS, bound | copied, &[])
    }

    /// Writes texels to a texture's rows, from index `first` on. The first and the last row may be partial.
    fn write_rows(&self, texture: &wgpu::Texture, first: usize, texels: &[Texel]) {
        let write = |at: usize, texels: &[Texel], rows: usize| {
            let (x, y) = (at % texture.width() as usize, at / texture.width() as usize);
            let width = (texels.len() / rows) as u32;
            let target = wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x: x as u32, y: y as u32, z: 0 },
                aspect: wgpu::TextureAspect::All,
            };
            let layout =
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 16), rows_per_image: None };
            let size = wgpu::Extent3d { width, height: rows as u32, depth_or_array_layers: 1 };
            self.queue.write_texture(target, bytemuck::cast_slice(texels), layout, size);
        };
        let width = texture.width() as usize;
        // These texels complete a partial first row.
        let (begun, texels) = texels.split_at(((width - first % width) % width).min(texels.len()));
        let rows = texels.len() / width;
        let (whole, rest) = texels.split_at(rows * width);
        let behind = first + begun.len();
        for (at, texels, rows) in [(first, begun, 1), (behind, whole, rows), (behind + whole.len(), rest, 1)] {
            if !texels.is_empty() {
                write(at, texels, rows);
            }
        }
    }

    /// Reads a buffer back to the host.
    pub(crate) async fn read<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer, count: usize) -> Result<Vec<T>, Error> {
        let bytes = (count * size_of::<T>()) as u64;
        let fill = || {
            let staging = Staging::new(self, bytes.max(4));
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(buffer, 0, staging.buffer(), 0, bytes);
            Ok(staging.fill(self, encoder.finish()))
        };
        let filling = self.checked(fill).await?;
        let values = |range: &[u8]| bytemuck::pod_collect_to_vec(&range[..bytes as usize]);
        filling.read(self, values).await.map(|(values, _)| values)
    }

    /// Creates a texture with one layer, one mip level and one sample.
    pub(crate) fn texture(
        &self,
        label: &str,
        [width, height]: [u32; 2],
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
        view_formats: &[wgpu::TextureFormat],
    ) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats,
        })
    }
}

/// Returns [`Error::Limit`] if a binding of `bytes` exceeds `allowed`.
pub(crate) fn check_bytes(what: &str, bytes: u64, allowed: u64, remedy: &'static str) -> Result<(), Error> {
    if bytes <= allowed {
        return Ok(());
    }
    let mib = |bytes: u64| format!("{} MiB", bytes.div_ceil(1 << 20));
    Err(Error::Limit {
        what: what.into(),
        needed: mib(bytes),
        limit: "max_storage_buffer_binding_size",
        allowed: mib(allowed),
        remedy,
    })
}

/// A part of a scene on the device, freed when dropped. Otherwise a browser would free it only at garbage collection,
/// which a shortage of device memory does not trigger.
#[derive(Debug)]
pub(crate) enum Texels {
    Texture(wgpu::TextureView),
    Buffer(wgpu::Buffer),
}

impl Texels {
    /// Returns whether kernels read these texels by `fetch`, and whether there is room for `count` texels.
    pub(crate) fn has_room(&self, count: usize, fetch: Fetch) -> bool {
        match (self, fetch) {
            // A texture narrower than `TEXTURE_WIDTH` has a single row.
            (Self::Texture(view), Fetch::Texture) => {
                view.texture().width() as usize * view.texture().height() as usize >= count
            }
            (Self::Buffer(buffer), Fetch::Buffer) => buffer.size() as usize / size_of::<Texel>() >= count,
            _ => false,
        }
    }
}

impl Drop for Texels {
    fn drop(&mut self) {
        match self {
            Self::Texture(view) => view.texture().destroy(),
            Self::Buffer(buffer) => buffer.destroy(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_uploaded_in_pieces_arrives_whole() {
        let gpu = Gpu::under_test();
        let texels: Vec<Texel> = (0..2 * PIECE as u32 + 3).map(|index| [index, 1, 2, !index]).collect();
        let there_and_back = async {
            let uploaded = gpu.upload("texels", &texels, Fetch::Buffer).await?;
            let Texels::Buffer(buffer) = &uploaded else { panic!("{uploaded:?}") };
            gpu.read::<Texel>(buffer, texels.len()).await
        };
        assert!(pollster::block_on(there_and_back).unwrap() == texels);
    }

    #[test]
    fn texels_are_freed_when_they_are_dropped_whoever_still_holds_the_buffer() {
        let gpu = Gpu::under_test();
        let freed_then_used = async {
            let texels = gpu.upload("texels", &[[7; 4]; 3], Fetch::Buffer).await?;
            let Texels::Buffer(buffer) = &texels else { panic!("{texels:?}") };
            let buffer = buffer.clone();
            assert_eq!(gpu.read::<u32>(&buffer, 12).await?, [7; 12]);
            drop(texels);
            assert!(gpu.read::<u32>(&buffer, 12).await.is_err());

            let texels = gpu.upload("texels", &[[7; 4]; 3], Fetch::Texture).await?;
            let Texels::Texture(view) = &texels else { panic!("{texels:?}") };
            let texture = view.texture().clone();
            let write = || {
                gpu.write_rows(&texture, 0, &[[8; 4]; 3]);
                Ok(())
            };
            gpu.checked(write).await?;
            drop(texels);
            assert!(gpu.checked(write).await.is_err());
            Ok::<_, Error>(())
        };
        pollster::block_on(freed_then_used).unwrap();
    }

    #[test]
    fn a_binding_over_the_limit_names_sizes_and_limit() {
        assert!(check_bytes("the nodes", 128 << 20, 128 << 20, "shrink").is_ok());
        let message = check_bytes("the nodes", (190 << 20) + 1, 128 << 20, "shrink").unwrap_err().to_string();
        assert!(
            message.starts_with("the nodes needs 191 MiB but this adapter's max_storage_buffer_binding_size is 128")
        );
    }
}
