//! Encodes a frame into the caller's command encoder. Its views stay on the device, as textures.

use std::{ops::ControlFlow, sync::Arc};

use super::samples::of_samples;
use crate::{
    Error, GBuffer, Gpu, Options, Renderer, Rig, UploadedScene,
    ask::samples::side_of,
    frame::{
        driver::{Driver, Setting},
        history::Recall,
        plan::Plan,
        show::{SHOW_COLOR, SHOW_DEPTH, SHOW_SAMPLES},
        targets::{MOST_BYTES, Targets, too_large},
        uniforms::uniforms_bytes,
    },
    kernel::Resource,
    shadow_buffer::Tables,
    view::rig::Eyes,
};

/// Views on the device. They are complete once the commands that make them have run.
#[derive(Debug)]
#[non_exhaustive]
pub struct Encoded {
    /// Views, one per eye, in the rig's order.
    pub views: Vec<EncodedView>,
    /// Buffer of four bytes, to be mapped after the commands have run: the number of threads (u32) that the adapter
    /// ended early. If the number is not 0, the pictures are incomplete. Render such frames with
    /// [`FrameBuilder::read`](crate::FrameBuilder::read), which spreads the work over several dispatches.
    pub unfinished: wgpu::Buffer,
    /// Linear colour of each view's samples, if there are several per pixel.
    samples: Vec<wgpu::TextureView>,
    /// Resources that the commands use.
    _targets: Arc<Targets>,
    _upload: wgpu::Buffer,
    _tables: Option<Arc<Tables>>,
}

/// A view on the device: textures that can be sampled and copied.
#[derive(Debug)]
#[non_exhaustive]
pub struct EncodedView {
    /// The picture, sRGB-encoded, alpha 1, `Rgba8Unorm`. [`EncodedView::linear`] views it as linear light.
    pub color: wgpu::Texture,
    /// Depth along the view direction in world units, `R32Float`, 3.4e38 for a miss. `None` if [`Options::g_buffer`] is
    /// [`GBuffer::None`].
    pub depth: Option<wgpu::Texture>,
}

impl EncodedView {
    fn new(gpu: &Gpu, size: [u32; 2], depth: bool) -> Self {
        use wgpu::{TextureFormat as Format, TextureUsages as Usages};

        let usage = Usages::STORAGE_BINDING | Usages::TEXTURE_BINDING | Usages::COPY_SRC;
        Self {
            color: gpu.texture("color", size, Format::Rgba8Unorm, usage, &[Format::Rgba8UnormSrgb]),
            depth: depth.then(|| gpu.texture("depth", size, Format::R32Float, usage, &[])),
        }
    }

    /// Returns a view of the picture for sampling, as `Rgba8UnormSrgb`: samples are linear light. That format allows no
    /// storage binding, so a view of [`EncodedView::color`] that keeps the texture's usages is invalid.
    pub fn linear(&self) -> wgpu::TextureView {
        self.color.create_view(&wgpu::TextureViewDescriptor {
            label: Some("linear colour"),
            format: Some(wgpu::TextureFormat::Rgba8UnormSrgb),
            usage: Some(wgpu::TextureUsages::TEXTURE_BINDING),
            ..Default::default()
        })
    }
}

impl Renderer {
    /// Encodes a frame into the given encoder. Without an encoder it makes one command buffer per band of rows.
    pub(super) async fn encode_each(
        &mut self,
        scene: &UploadedScene,
        rig: &Rig,
        options: &Options,
        mut into: Option<&mut wgpu::CommandEncoder>,
    ) -> Result<(Encoded, Vec<wgpu::CommandBuffer>), Error> {
        scene.belongs_to(&self.gpu)?;
        options.check()?;
        options.check_parts(false)?;
        if options.samples_sky() {
            scene.weigh_sky().await?;
        }
        check_options(options)?;
        let side = side_of(options.samples)?;
        let eyes = rig.eyes(scene.origin)?;
        let size = eyes.pose.size;
        let eyes = if side > 1 { eyes.with_samples(side)? } else { eyes };
        let options = &Options { linear: side > 1, ..options.clone() };
        eyes.check(options)?;
        let tables = scene.shadow_tables(&self.kernels, options).await?.map(|(tables, _)| tables);
        let drawn = self.drawn(scene, options);
        let (.., plan) = self.planned(scene, &eyes, options, drawn, Recall::Nothing);
        check(&self.gpu, options, &plan, &eyes).map_err(|error| of_samples(error, options.samples))?;
        let variant = self.variant(scene, &eyes, options, &plan);
        let mut used = plan.uses(&self.kernels, &variant);
        used.places.insert((Resource::Unfinished, 0));
        let targets =
            self.targets(self.shape(scene, &eyes, options, (&plan, eyes.pose.size[1], drawn, &used)), &used).await?;
        let mut go_on = |_| ControlFlow::Continue(());
        let gpu = self.gpu.clone();
        let shared = scene.resources_for(&gpu, &used, tables.as_deref()).await?;
        let model = scene.cost_model(&gpu, self.calibration, options);
        let uniforms = self.uniforms(scene, &eyes, options, (&model, &targets.shape, 0));
        let setting = Setting { eyes: &eyes, variant, targets: &targets, uniforms, shared, history: None };
        let mut driver = Driver::new(self.engine(false), setting, &mut go_on);
        driver.prepare(&plan).await?;
        let depth = options.g_buffer != GBuffer::None;
        let encode = || {
            let views = eyes.sources.iter().map(|_| EncodedView::new(&gpu, size, depth));
            let samples = eyes.sources.iter().filter(|_| side > 1).map(|_| room_of_samples(&gpu, eyes.pose.size));
            let encoded = Encoded::new(&gpu, views.collect(), samples.collect(), (&targets, tables.clone()));
            let mut commands = Vec::new();
            let bands = targets.shape.bands;
            let mut upload: Vec<u8> = bytemuck::cast_slice(&driver.heads(&plan)).to_vec();
            for index in 0..bands.count() {
                let mut own = into.is_none().then(|| driver.encoder());
                let encoder = own.as_mut().or(into.as_deref_mut()).expect("one of the two");
                upload.extend(driver.uniforms_of(&bands.get(index)));
                encoded.encode_band(&mut driver, &plan, encoder, index);
                if index + 1 == bands.count() {
                    encoded.encode_filters(&mut driver, encoder);
                    let unfinished = targets.get(Resource::Unfinished, 0);
                    encoder.copy_buffer_to_buffer(unfinished, 0, &encoded.unfinished, 0, Some(4));
                }
                commands.extend(own.map(wgpu::CommandEncoder::finish));
            }
            gpu.queue.write_buffer(&encoded._upload, 0, &upload);
            Ok((encoded, commands))
        };
        gpu.checked(encode).await
    }
}

impl Encoded {
    fn new(
        gpu: &Gpu,
        views: Vec<EncodedView>,
        samples: Vec<wgpu::TextureView>,
        (targets, tables): (&Arc<Targets>, Option<Arc<Tables>>),
    ) -> Self {
        let buffer = |label, size, usage| {
            let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
            gpu.device.create_buffer(&descriptor)
        };
        let uniforms =
            u64::from(targets.shape.bands.count()) * uniforms_bytes(targets.shape.views, targets.shape.parts);
        let (from, to) = (wgpu::BufferUsages::COPY_SRC, wgpu::BufferUsages::COPY_DST);
        Self {
            views,
            samples,
            unfinished: buffer("unfinished", 4, to | wgpu::BufferUsages::MAP_READ),
            _upload: buffer("uniforms", targets.empty_lists.size() + uniforms, from | to),
            _targets: targets.clone(),
            _tables: tables,
        }
    }

    /// Encodes one band: the upload of its uniforms, its passes, and the copy of its rows into the textures.
    fn encode_band(&self, driver: &mut Driver<'_>, plan: &Plan, encoder: &mut wgpu::CommandEncoder, index: u32) {
        let targets = &self._targets;
        let uniforms = uniforms_bytes(targets.shape.views, targets.shape.parts);
        let begin = targets.empty_lists.size() + u64::from(index) * uniforms;
        encoder.copy_buffer_to_buffer(&self._upload, begin, &targets.uniforms, 0, Some(uniforms));
        if index == 0 {
            encoder.copy_buffer_to_buffer(&self._upload, 0, &targets.empty_lists, 0, Some(targets.empty_lists.size()));
            encoder.clear_buffer(targets.get(Resource::Unfinished, 0), 0, None);
        }
        driver.encode_band(encoder, plan);
        for (index, view) in self.views.iter().enumerate() {
            match self.samples.get(index) {
                Some(samples) => driver.encode_shown(encoder, &SHOW_SAMPLES, index, samples),
                None => driver.encode_shown(encoder, &SHOW_COLOR, index, &whole(&view.color)),
            }
            if let Some(depth) = &view.depth {
                driver.encode_shown(encoder, &SHOW_DEPTH, index, &whole(depth));
            }
        }
    }

    /// Encodes the filters of all views' samples, once all bands are encoded.
    fn encode_filters(&self, driver: &mut Driver<'_>, encoder: &mut wgpu::CommandEncoder) {
        for (index, (samples, view)) in self.samples.iter().zip(&self.views).enumerate() {
            let size = [view.color.width(), view.color.height()];
            driver.encode_filtered(encoder, index, samples, (&whole(&view.color), size));
        }
    }
}

fn whole(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Creates a texture for the linear colour of a view's samples.
fn room_of_samples(gpu: &Gpu, size: [u32; 2]) -> wgpu::TextureView {
    let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
    whole(&gpu.texture("samples", size, wgpu::TextureFormat::Rgba16Float, usage, &[]))
}

/// # Errors
/// [`Error::Encoding`] if the result of an option must be read back.
fn check_options(options: &Options) -> Result<(), Error> {
    let depth_of_samples = options.samples > 1 && options.g_buffer != GBuffer::None;
    let read_back = [
        (options.adaptive.is_some(), "adaptive sampling"),
        (depth_of_samples, "the depth of several samples per pixel (GBuffer::None asks for none)"),
        (options.linear, "linear colour"),
        (options.cost_map, "a cost map"),
        (options.count, "counting"),
    ];
    let Some((_, what)) = read_back.into_iter().find(|(wanted, _)| *wanted) else { return Ok(()) };
    Err(Error::Encoding { what: what.into(), reason: "it is available only for results that are read back" })
}

/// # Errors
/// [`Error::Encoding`] if the frame needs work on the host; [`Error::Limit`] if the picture exceeds the texture size
/// limit.
fn check(gpu: &Gpu, options: &Options, plan: &Plan, eyes: &Eyes) -> Result<(), Error> {
    if plan.needs_host() {
        let what = options.method.to_string();
        return Err(Error::Encoding { what, reason: "a part of it runs on the host" });
    }
    let [width, height] = eyes.pose.size.map(u64::from);
    let needed = if options.samples > 1 { 8 * width * height * eyes.sources.len() as u64 } else { 0 };
    if needed > MOST_BYTES {
        return Err(too_large("the samples of all views in textures".into(), needed, "use fewer samples or pixels"));
    }
    let ([width, height], side) = (eyes.pose.size, gpu.limits.max_texture_dimension_2d);
    if width.max(height) > side {
        return Err(Error::Limit {
            what: format!("a {width}x{height} picture in a texture"),
            needed: format!("a side of {}", width.max(height)),
            limit: "max_texture_dimension_2d",
            allowed: side.to_string(),
            remedy: "encode a smaller picture, or receive rows as they finish (FrameBuilder::rows)",
        });
    }
    Ok(())
}
