//! Skies from pictures.

use std::sync::Arc;

use glam::Vec3;

use crate::Error;
#[cfg(feature = "sky")]
use crate::{Limits, input};

/// An equirectangular picture of everything around: the top row is straight up, the middle column towards -z, and columns
/// go round to the right. Linear RGB, sampled bilinearly, across the seam and the poles too. Cloning shares the pixels.
#[derive(Clone, PartialEq)]
pub struct SkyMap {
    width: u32,
    height: u32,
    /// Not `Arc<[Vec3]>`: making one of a list copies it.
    pixels: Arc<Vec<Vec3>>,
}

impl std::fmt::Debug for SkyMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "SkyMap {}x{}", self.width, self.height)
    }
}

/// Widest sky that [`SkyMap::procedural`] makes: 1.6 GB.
const MAX_PROCEDURAL_WIDTH: u32 = 16_384;

impl SkyMap {
    /// A picture of `width * height` colours, row-major, linear RGB.
    ///
    /// # Errors
    /// [`Error::Scene`] if their number is another, the width is odd (a pole's opposite column is half a width away) or a
    /// colour is negative or not finite.
    pub fn new(width: u32, height: u32, pixels: Vec<Vec3>) -> Result<Self, Error> {
        let fault = |reason| Err(Error::Scene { element: "sky".into(), reason });
        if !is_map(width, height) || pixels.len() as u64 != u64::from(width) * u64::from(height) {
            return fault(format!(
                "{} colours do not make a map of {width}x{height}, with an even width",
                pixels.len()
            ));
        }
        if let Some(index) = pixels.iter().position(|color| !color.is_finite() || color.min_element() < 0.0) {
            let (row, column) = (index / width as usize, index % width as usize);
            return fault(format!("the colour in row {row}, column {column} is {}", pixels[index]));
        }
        Ok(Self { width, height, pixels: Arc::new(pixels) })
    }

    /// A sky with a sun and streaks of cloud over a plain, `width` pixels wide and half as high.
    ///
    /// # Errors
    /// [`Error::Scene`] for a width that is odd, zero or over 16,384.
    pub fn procedural(width: u32) -> Result<Self, Error> {
        if width > MAX_PROCEDURAL_WIDTH {
            let reason = format!("a procedural one of width {width}; it can be at most {MAX_PROCEDURAL_WIDTH} wide");
            return Err(Error::Scene { element: "sky".into(), reason });
        }
        let height = width / 2;
        let sun = Vec3::new(0.5, 0.45, -0.75).normalize();
        let color = |index: u32| {
            let d = direction(width, height, index % width, index / width);
            if d.y < 0.0 {
                return Vec3::new(0.16, 0.14, 0.11).lerp(Vec3::new(0.3, 0.3, 0.3), (1.0 + 6.0 * d.y).max(0.0));
            }
            let clear = Vec3::new(0.62, 0.72, 0.85).lerp(Vec3::new(0.12, 0.27, 0.6), d.y.sqrt());
            // Where a ray through the layer of cloud meets it; far off the streaks fade into haze.
            let (x, z) = (d.x / (d.y + 0.15), d.z / (d.y + 0.15));
            let streaks =
                (2.1 * x + (1.3 * z).sin()).sin() * (1.7 * z + (0.9 * x).cos()).sin() + 0.4 * (5.3 * x - 4.1 * z).sin();
            let cloud = (0.5 * streaks).clamp(0.0, 0.7);
            let glow = d.dot(sun).max(0.0).powi(400) * 0.9 + d.dot(sun).max(0.0).powi(12) * 0.2;
            clear.lerp(Vec3::splat(0.85), cloud) + Vec3::new(1.0, 0.9, 0.7) * glow
        };
        Self::new(width, height, (0..width * height).map(color).collect())
    }

    /// Reads a picture: PNG or JPEG (taken as sRGB), or Radiance HDR (taken as linear). Its size is checked before it is
    /// decoded; decoding takes 12 bytes a pixel, beside what the format itself needs.
    ///
    /// # Errors
    /// [`Error::Io`] if the file can't be read, [`Error::File`] if it is no such picture or no sky, no regular file, or
    /// larger than [`Limits`] says, as a file or in pixels.
    #[cfg(feature = "sky")]
    pub fn open(path: impl AsRef<std::path::Path>) -> Result<Self, Error> {
        Self::open_within(path, &Limits::default())
    }

    /// [`SkyMap::open`] with other limits than the usual ones: [`Limits::within`] knows an adapter's.
    ///
    /// # Errors
    /// Those of [`SkyMap::open`].
    #[cfg(feature = "sky")]
    pub fn open_within(path: impl AsRef<std::path::Path>, limits: &Limits) -> Result<Self, Error> {
        let path = path.as_ref();
        let (file, _) = input::open(path, limits.file_bytes, limits.raised_by[0])?;
        let (width, height, pixels) =
            decode(file, limits).map_err(|reason| Error::file(path, None, format!("no picture of a sky: {reason}")))?;
        Self::new(width, height, pixels).map_err(|error| Error::file(path, None, error.to_string()))
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    pub(crate) fn pixels(&self) -> &[Vec3] {
        &self.pixels
    }
}

/// Whether a picture of this size can be a map: its halves are equal, so that a column has an opposite one.
fn is_map(width: u32, height: u32) -> bool {
    width > 0 && height > 0 && width.is_multiple_of(2)
}

/// Bytes of an HDR file, as the image crate asks for them.
#[cfg(feature = "sky")]
struct HdrBytes<R> {
    inner: R,
    /// Marks in a row.
    marks: u32,
}

#[cfg(feature = "sky")]
impl<R: std::io::Read> std::io::Read for HdrBytes<R> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        self.inner.read(bytes)
    }

    /// Runs of pixels may be told by marks that stand in the place of pixels. The crate multiplies by 256 for each mark
    /// that follows another, and panics where a `usize` overflows: at the eighth, with 32 bits at the fourth.
    fn read_exact(&mut self, bytes: &mut [u8]) -> std::io::Result<()> {
        self.inner.read_exact(bytes)?;
        self.marks = if matches!(bytes, [1, 1, 1, _]) { self.marks + 1 } else { 0 };
        match self.marks {
            0..=3 => Ok(()),
            _ => Err(std::io::Error::other("a run of pixels has over three marks, which stand for 16 million pixels")),
        }
    }
}

/// Reads a picture into linear colours.
#[cfg(feature = "sky")]
fn decode(file: std::fs::File, limits: &Limits) -> Result<(u32, u32, Vec<Vec3>), String> {
    let mut reader = image::ImageReader::new(std::io::BufReader::new(file))
        .with_guessed_format()
        .map_err(|error| error.to_string())?;
    if reader.format() == Some(image::ImageFormat::Hdr) {
        let bytes = HdrBytes { inner: reader.into_inner(), marks: 0 };
        return colors(image::codecs::hdr::HdrDecoder::new(bytes), limits);
    }
    let mut format_limits = image::Limits::default();
    format_limits.max_alloc = Some(limits.sky_pixels.saturating_mul(size_of::<Vec3>() as u64));
    reader.limits(format_limits);
    colors(reader.into_decoder(), limits)
}

/// A decoder's picture in linear colours. Its samples, which are never larger than those, are read into the list of
/// colours itself and spread out there.
#[cfg(feature = "sky")]
fn colors(
    decoder: image::ImageResult<impl image::ImageDecoder>,
    limits: &Limits,
) -> Result<(u32, u32, Vec<Vec3>), String> {
    let said = |error: image::ImageError| error.to_string();
    let decoder = decoder.map_err(said)?;
    let (width, height) = decoder.dimensions();
    let count = u64::from(width) * u64::from(height);
    if !is_map(width, height) {
        return Err(format!("{width}x{height} pixels make no map, which has an even width"));
    }
    if count > limits.sky_pixels {
        let (limit, [_, raised_by]) = (limits.sky_pixels, limits.raised_by);
        return Err(format!(
            "it has {width}x{height} pixels, {count} in all and over the limit of {limit}; raise it by {raised_by}, up to what the adapter holds"
        ));
    }
    let kind = decoder.color_type();
    let sample = usize::from(kind.bytes_per_pixel());
    if sample > size_of::<Vec3>() {
        return Err(format!("pixels of {sample} bytes"));
    }
    // The system's own zeros, which take memory as they are written to: the samples first, the rest once the decoder is gone.
    let mut pixels: Vec<Vec3> = bytemuck::zeroed_vec(count as usize);
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut pixels);
    decoder.read_image(&mut bytes[..count as usize * sample]).map_err(said)?;
    // From the last pixel on, whose place no sample but its own reaches into that is still to be read.
    for index in (0..pixels.len()).rev() {
        let bytes: &[u8] = bytemuck::cast_slice(&pixels);
        pixels[index] = linear_color(kind, &bytes[index * sample..][..sample])?;
    }
    Ok((width, height, pixels))
}

/// A pixel as the format has it, as a linear colour. Alpha is left out.
#[cfg(feature = "sky")]
fn linear_color(kind: image::ColorType, pixel: &[u8]) -> Result<Vec3, String> {
    use image::ColorType;

    let byte = |channel: usize| linear(f32::from(pixel[channel]) / 255.0);
    let word = |channel: usize| {
        let word = u16::from_ne_bytes([pixel[2 * channel], pixel[2 * channel + 1]]);
        linear(f32::from(word) / 65535.0)
    };
    Ok(match kind {
        ColorType::L8 | ColorType::La8 => Vec3::splat(byte(0)),
        ColorType::Rgb8 | ColorType::Rgba8 => Vec3::new(byte(0), byte(1), byte(2)),
        ColorType::L16 | ColorType::La16 => Vec3::splat(word(0)),
        ColorType::Rgb16 | ColorType::Rgba16 => Vec3::new(word(0), word(1), word(2)),
        ColorType::Rgb32F => bytemuck::pod_read_unaligned(pixel),
        other => return Err(format!("pixels of the kind {other:?}")),
    })
}

/// The light of an sRGB value (IEC 61966-2-1).
#[cfg(feature = "sky")]
fn linear(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// The direction of a pixel's centre.
fn direction(width: u32, height: u32, column: u32, row: u32) -> Vec3 {
    use std::f32::consts::{PI, TAU};
    let around = ((column as f32 + 0.5) / width as f32 - 0.5) * TAU;
    let down = (row as f32 + 0.5) / height as f32 * PI;
    Vec3::new(down.sin() * around.sin(), down.cos(), -down.sin() * around.cos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Fetch, Gpu, Method, Options, Renderer, Scene, Sky, StereoCamera, Traversal, UploadedScene, cpu};

    /// A sky whose colour is its direction.
    fn compass(width: u32) -> SkyMap {
        let color = |index| 0.5 + 0.5 * direction(width, width / 2, index % width, index / width);
        SkyMap::new(width, width / 2, (0..width * width / 2).map(color).collect()).unwrap()
    }

    #[test]
    fn every_direction_has_its_colour_poles_and_seam_included() {
        let wanted = std::env::var(crate::gpu::ADAPTER_VARIABLE).unwrap_or_else(|_| "software".into());
        let gpu = Gpu::open(&wanted).unwrap();
        // The larger one is uploaded in pieces.
        for (width, fetch) in [(256, Fetch::Texture), (2048, Fetch::Texture), (2048, Fetch::Buffer)] {
            let mut renderer = Renderer::with_traversal(gpu.clone(), Traversal { fetch, ..Traversal::of(&gpu) });
            let mut scene = Scene::new();
            scene.sky = Sky::Map(compass(width));
            let uploaded = renderer.upload(&scene).unwrap();
            for target in [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::Y, -Vec3::Y, Vec3::new(0.01, -0.3, 1.0)] {
                assert_colours_are_directions(&mut renderer, &uploaded, target);
            }
        }
    }

    fn assert_colours_are_directions(renderer: &mut Renderer, uploaded: &UploadedScene, target: Vec3) {
        let up = if target.y.abs() > 0.9 { Vec3::Z } else { Vec3::Y };
        let camera = StereoCamera::look_at(Vec3::ZERO, target).up(up).size(65, 33).vertical_fov_degrees(60.0);
        let pair = renderer.render(uploaded, &camera, &Options::new(Method::Naive)).unwrap();
        let frame = cpu::Frame::new(&pair.pose);
        for (index, color) in pair.left.linear.iter().enumerate() {
            let d = frame.direction(cpu::Eye::Left, index % 65, index / 65).normalize();
            let found = Vec3::new(color[0], color[1], color[2]);
            // Between pixels 1.4 degrees apart a chord is 7.5e-5 short of its arc, in both directions; twice that.
            assert!((found - (0.5 + 0.5 * d)).abs().max_element() < 3e-4, "{target} {index}: {found} {d}");
        }
    }

    #[test]
    fn maps_that_are_none_are_refused() {
        for (width, height, count) in [(4, 2, 7), (3, 2, 6), (0, 2, 0)] {
            let message = SkyMap::new(width, height, vec![Vec3::ONE; count]).unwrap_err().to_string();
            assert!(message.contains(&format!("{count} colours do not make a map of {width}x{height}")), "{message}");
        }
        let mut pixels = vec![Vec3::ONE; 8];
        pixels[6].y = f32::NAN;
        let message = SkyMap::new(4, 2, pixels).unwrap_err().to_string();
        assert!(message.contains("row 1, column 2"), "{message}");
    }

    #[test]
    fn the_procedural_sky_has_a_bright_sun_and_no_seam() {
        let sky = SkyMap::procedural(128).unwrap();
        let row = |row: usize| &sky.pixels()[row * 128..(row + 1) * 128];
        for y in 0..64 {
            let step = |a: Vec3, b: Vec3| (a - b).abs().max_element();
            let widest = row(y).windows(2).map(|pair| step(pair[0], pair[1])).fold(0.0, f32::max);
            assert!(step(row(y)[127], row(y)[0]) <= widest.max(0.02), "row {y}");
        }
        assert!(sky.pixels().iter().any(|color| color.min_element() > 1.0));
        for width in [0, 1, 7, 100_000, u32::MAX] {
            let message = SkyMap::procedural(width).unwrap_err().to_string();
            assert!(message.contains("sky") && message.contains(&width.to_string()), "{message}");
        }
    }

    #[cfg(feature = "sky")]
    #[test]
    fn a_sky_is_read_from_png_and_a_broken_file_is_named() {
        let folder = crate::folder::Folder::new("sky");
        let path = folder.file("sky.png");
        let mut picture = image::RgbImage::new(4, 2);
        picture.put_pixel(1, 0, image::Rgb([255, 188, 0]));
        picture.save(&path).unwrap();
        let sky = SkyMap::open(&path).unwrap();
        assert_eq!(sky.size(), [4, 2]);
        assert!((sky.pixels()[1] - Vec3::new(1.0, 0.5029, 0.0)).abs().max_element() < 1e-3, "{}", sky.pixels()[1]);
        let odd = image::RgbImage::new(3, 2);
        odd.save(&path).unwrap();
        let odd = SkyMap::open(&path).unwrap_err().to_string();
        std::fs::write(&path, b"no picture at all").unwrap();
        let broken = SkyMap::open(&path).unwrap_err().to_string();
        std::fs::remove_file(&path).unwrap();
        let missing = SkyMap::open(&path).unwrap_err().to_string();
        assert!(
            [&odd, &broken, &missing].iter().all(|message| message.contains("sky.png")),
            "{odd} {broken} {missing}"
        );
        assert!(odd.contains("3x2") && broken.contains("no picture of a sky"), "{odd} {broken}");
    }

    /// Bytes (1, 1, 1, n) stand for n more of the pixel before them, those behind them for 256 n more, and so on.
    #[cfg(feature = "sky")]
    #[test]
    fn runs_of_an_hdr_file_are_read_up_to_those_that_no_number_can_hold() {
        let folder = crate::folder::Folder::new("runs");
        let path = folder.file("runs.hdr");
        let read = |width: usize, marks: &[u8]| {
            let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X {width}\n").into_bytes();
            bytes.extend([128, 64, 32, 129]);
            marks.iter().for_each(|&count| bytes.extend([1, 1, 1, count]));
            std::fs::write(&path, bytes).unwrap();
            SkyMap::open(&path)
        };
        let sky = read(66_052, &[3, 2, 1]).unwrap();
        assert!(sky.pixels().iter().all(|&color| color == Vec3::new(1.0, 0.5, 0.25)));
        for marks in [4, 9, 20] {
            let message = read(8, &vec![0; marks]).unwrap_err().to_string();
            assert!(message.contains("runs.hdr: no picture of a sky: a run of pixels has over three"), "{message}");
        }
    }

    /// Writes a picture, reads it as a sky, and takes it away again.
    #[cfg(feature = "sky")]
    fn through_file(name: &str, picture: &image::DynamicImage, limits: &Limits) -> Result<SkyMap, Error> {
        let path = std::env::temp_dir().join(format!("stereotrace_{}_{name}", std::process::id()));
        picture.save(&path).unwrap();
        let sky = SkyMap::open_within(&path, limits);
        std::fs::remove_file(&path).unwrap();
        sky
    }

    #[cfg(feature = "sky")]
    #[test]
    fn every_kind_of_pixel_is_read_as_the_image_crate_converts_it() {
        use image::{ColorType, DynamicImage};
        let kinds = [
            ("l8.png", ColorType::L8),
            ("la8.png", ColorType::La8),
            ("rgb8.png", ColorType::Rgb8),
            ("rgba8.png", ColorType::Rgba8),
            ("l16.png", ColorType::L16),
            ("la16.png", ColorType::La16),
            ("rgb16.png", ColorType::Rgb16),
            ("rgba16.png", ColorType::Rgba16),
            ("rgb32f.hdr", ColorType::Rgb32F),
        ];
        for (name, kind) in kinds {
            let mut picture = DynamicImage::new(6, 3, kind);
            // Bytes without order, so that a sample that is overwritten before it is read shows.
            let mut noise = (0..).map(|index: u32| (index.wrapping_mul(2_654_435_761) >> 24) as u8);
            match &mut picture {
                DynamicImage::ImageLuma8(p) => p.fill_with(|| noise.next().unwrap()),
                DynamicImage::ImageLumaA8(p) => p.fill_with(|| noise.next().unwrap()),
                DynamicImage::ImageRgb8(p) => p.fill_with(|| noise.next().unwrap()),
                DynamicImage::ImageRgba8(p) => p.fill_with(|| noise.next().unwrap()),
                DynamicImage::ImageLuma16(p) => p.fill_with(|| 257 * u16::from(noise.next().unwrap()) + 1),
                DynamicImage::ImageLumaA16(p) => p.fill_with(|| 255 * u16::from(noise.next().unwrap())),
                DynamicImage::ImageRgb16(p) => p.fill_with(|| 255 * u16::from(noise.next().unwrap())),
                DynamicImage::ImageRgba16(p) => p.fill_with(|| 255 * u16::from(noise.next().unwrap())),
                // Of one exponent, a power of two: what HDR keeps exactly.
                DynamicImage::ImageRgb32F(p) => p.fill_with(|| 0.5 + f32::from(noise.next().unwrap() >> 1) / 256.0),
                _ => unreachable!(),
            }
            let sky = through_file(name, &picture, &Limits::default()).unwrap();
            let reference = picture.into_rgb32f();
            for (index, (found, expected)) in sky.pixels().iter().zip(reference.pixels()).enumerate() {
                let expected = Vec3::from_array(expected.0);
                let expected = if kind == ColorType::Rgb32F { expected } else { expected.map(linear) };
                assert!((*found - expected).abs().max_element() < 1e-6, "{name} {index}: {found} {expected}");
            }
        }
    }

    #[cfg(feature = "sky")]
    #[test]
    fn a_sky_over_the_limit_is_refused_before_it_is_decoded() {
        let picture = image::DynamicImage::new(64, 32, image::ColorType::L8);
        let read = |pixels| through_file("limit.png", &picture, &Limits::default().sky_pixels(pixels));
        assert_eq!(read(2048).unwrap().size(), [64, 32]);
        let message = read(2047).unwrap_err().to_string();
        assert!(message.contains("64x32 pixels, 2048 in all and over the limit of 2047"), "{message}");
        // An adapter's own limit, which lavapipe has at 2048 times 16384 texels.
        let wanted = std::env::var(crate::gpu::ADAPTER_VARIABLE).unwrap_or_else(|_| "software".into());
        let gpu = Gpu::open(&wanted).unwrap();
        let most = Limits::default().sky_pixels(u64::MAX).within(&gpu).sky_pixels;
        assert!(most < u64::MAX && most >= Limits::default().sky_pixels, "{most}");
        assert_eq!(Limits::default().sky_pixels(9).within(&gpu).sky_pixels, 9);
    }
}
