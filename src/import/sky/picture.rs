//! Decodes sky pictures into linear colours.

#[cfg(feature = "exr")]
mod open_exr;

use std::{
    io::{BufRead, Seek},
    path::Path,
};

use glam::Vec3;

use crate::{
    Error, Limits,
    message::counted,
    scene::{linear, sky::is_map},
};

/// Reader of an HDR file for the image crate.
struct HdrBytes<R> {
    inner: R,
    /// Number of consecutive repeat codes.
    marks: u32,
}

impl<R: std::io::Read> std::io::Read for HdrBytes<R> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        self.inner.read(bytes)
    }

    /// Reads bytes and counts repeat codes, which may replace pixels. Each consecutive code multiplies the run by 256.
    /// The crate panics when a `usize` overflows: at the eighth code with 64 bits, at the fourth with 32 bits.
    fn read_exact(&mut self, bytes: &mut [u8]) -> std::io::Result<()> {
        self.inner.read_exact(bytes)?;
        self.marks = if matches!(bytes, [1, 1, 1, _]) { self.marks + 1 } else { 0 };
        match self.marks {
            0..=3 => Ok(()),
            _ => Err(std::io::Error::other(
                "a run of pixels has more than three repeat codes in a row, so it has over 16 million pixels",
            )),
        }
    }
}

/// Decodes a picture into linear colours.
pub(super) fn decode(
    path: &Path,
    source: impl BufRead + Seek,
    limits: &Limits,
) -> Result<(u32, u32, Vec<Vec3>), Error> {
    let mut reader = image::ImageReader::new(source).with_guessed_format().map_err(|error| Error::io(path, error))?;
    match reader.format() {
        None | Some(image::ImageFormat::Png | image::ImageFormat::Jpeg) => {}
        Some(image::ImageFormat::Hdr) => {
            let bytes = HdrBytes { inner: reader.into_inner(), marks: 0 };
            return colors(path, image::codecs::hdr::HdrDecoder::new(bytes), limits);
        }
        #[cfg(feature = "exr")]
        Some(image::ImageFormat::OpenExr) => return open_exr::decode(path, reader.into_inner(), limits),
        #[cfg(not(feature = "exr"))]
        Some(image::ImageFormat::OpenExr) => {
            let reason = "can't read the sky: it is OpenEXR; stereotrace is built without its feature `exr`";
            return Err(Error::parse(path, None, reason));
        }
        _ => return Err(Error::parse(path, None, "can't read the sky: it is not PNG, JPEG, HDR or OpenEXR")),
    }
    let mut format_limits = image::Limits::default();
    format_limits.max_alloc = Some(limits.largest_sky().saturating_mul(size_of::<Vec3>() as u64));
    reader.limits(format_limits);
    colors(path, reader.into_decoder(), limits)
}

/// Returns the number of pixels. Refuses sizes that can't be a map or exceed the limit.
fn check_size(path: &Path, [width, height]: [u32; 2], limits: &Limits) -> Result<u64, Error> {
    let count = u64::from(width) * u64::from(height);
    if !is_map(width, height) {
        let reason = format!("can't read the sky: {width}x{height} pixels; a sky map must have an even width");
        return Err(Error::parse(path, None, reason));
    }
    if count > limits.largest_sky() {
        return Err(Error::TooLarge {
            path: path.into(),
            size: format!("the picture has {width}x{height} pixels, {count} in all"),
            limit: limits.largest_sky(),
            remedy: format!("raise it with {}, up to the adapter's limit", limits.option_names[1]),
        });
    }
    Ok(count)
}

/// Returns a decoder's picture in linear colours. Samples are never larger than colours. They are read into the list of
/// colours itself and converted in place.
fn colors(
    path: &Path,
    decoder: image::ImageResult<impl image::ImageDecoder>,
    limits: &Limits,
) -> Result<(u32, u32, Vec<Vec3>), Error> {
    let no_sky = |reason: String| Error::parse(path, None, format!("can't read the sky: {reason}"));
    let said = |error: image::ImageError| Error::parse_from(path, None, format!("can't read the sky: {error}"), error);
    let decoder = decoder.map_err(said)?;
    let (width, height) = decoder.dimensions();
    let count = check_size(path, [width, height], limits)?;
    let kind = decoder.color_type();
    let sample = usize::from(kind.bytes_per_pixel());
    if sample > size_of::<Vec3>() {
        return Err(no_sky(format!("pixels of {} are not supported", counted(sample, "byte", "bytes"))));
    }
    // Zeroed pages take memory only when written: for the samples first, for the rest after the decoder is freed.
    let mut pixels: Vec<Vec3> = bytemuck::zeroed_vec(count as usize);
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut pixels);
    decoder.read_image(&mut bytes[..count as usize * sample]).map_err(said)?;
    // Conversion runs backwards, so no colour overwrites a sample that is still to be read.
    for index in (0..pixels.len()).rev() {
        let bytes: &[u8] = bytemuck::cast_slice(&pixels);
        pixels[index] = linear_color(kind, &bytes[index * sample..][..sample]).map_err(no_sky)?;
    }
    Ok((width, height, pixels))
}

/// Converts a pixel in the file's format to a linear colour. Alpha is ignored.
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
        other => return Err(format!("pixels of type {other:?} are not supported")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gpu, SkyMap};

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
        // The image crate may support these formats for other parts of a program.
        let other = SkyMap::from_bytes("sky.gif", b"GIF89a", &Limits::default()).unwrap_err().to_string();
        assert!(other.contains("sky.gif: can't read the sky: it is not PNG, JPEG, HDR or OpenEXR"), "{other}");
        assert!(odd.contains("3x2") && broken.contains("can't read the sky"), "{odd} {broken}");
    }

    /// Tests runs: bytes (1, 1, 1, n) repeat the previous pixel n times, the next such mark 256 n times, and so on.
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
            assert!(message.contains("runs.hdr: can't read the sky: a run of pixels has more than three"), "{message}");
        }
    }

    /// Writes a picture to a file, reads it as a sky, and removes it.
    fn through_file(name: &str, picture: &image::DynamicImage, limits: &Limits) -> Result<SkyMap, Error> {
        let path = std::env::temp_dir().join(format!("stereotrace_{}_{name}", std::process::id()));
        picture.save(&path).unwrap();
        let sky = SkyMap::open_within(&path, limits);
        std::fs::remove_file(&path).unwrap();
        sky
    }

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
            // Noise reveals a sample that is overwritten before it is read.
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
                // HDR represents values with a common power of two exactly.
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

    #[test]
    fn a_sky_over_the_limit_is_refused_before_it_is_decoded() {
        let picture = image::DynamicImage::new(64, 32, image::ColorType::L8);
        let read = |pixels| through_file("limit.png", &picture, &Limits::default().sky_pixels(pixels));
        assert_eq!(read(2048).unwrap().size(), [64, 32]);
        let message = read(2047).unwrap_err().to_string();
        assert!(message.contains("64x32 pixels, 2048 in all, over the limit of 2047"), "{message}");
        // The adapter's own limit; lavapipe's is 2048 times 16384 texels.
        let gpu = Gpu::under_test();
        let most = Limits::default().gpu(&gpu).sky_pixels(u64::MAX).largest_sky();
        assert!(most < u64::MAX && most >= Limits::default().largest_sky(), "{most}");
        assert_eq!(Limits::default().sky_pixels(9).gpu(&gpu).largest_sky(), 9);
    }
}
