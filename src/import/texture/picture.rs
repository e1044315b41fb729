//! Decodes texture pictures into sRGB bytes with alpha.

use std::{
    io::{BufRead, Seek},
    path::Path,
};

use image::{ImageDecoder, ImageFormat};

use crate::{Error, Limits, scene::texture::check_size};

/// Memory for decoding in bytes per pixel: RGBA of 16 bits, of 8 bits, and as much again for the decoder.
const DECODING_BYTES: u64 = 24;

/// Formats besides PNG and JPEG.
const MORE: [(ImageFormat, &str); 5] = [
    (ImageFormat::Bmp, "BMP"),
    (ImageFormat::Gif, "GIF"),
    (ImageFormat::Tga, "TGA"),
    (ImageFormat::Tiff, "TIFF"),
    (ImageFormat::WebP, "WebP"),
];

/// Refuses unsupported formats. Other parts of a program may have enabled them in the image crate.
fn check_format(format: Option<ImageFormat>) -> Result<(), String> {
    let has_more = cfg!(feature = "more-textures");
    if matches!(format, Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Ok(());
    }
    match MORE.iter().find(|(more, _)| Some(*more) == format) {
        Some(_) if has_more => Ok(()),
        Some((_, name)) => Err(format!("it is {name}; stereotrace is built without its feature `more-textures`")),
        None if has_more => Err(format!("it is not PNG, JPEG, {}", MORE.map(|(_, name)| name).join(", "))),
        None => Err("it is not PNG or JPEG".into()),
    }
}

/// Decodes a picture of a format that [`check_format`] accepts, or the first of several. Returns its width and height,
/// and its pixels. Messages name `path`. `counted` becomes the number of pixels before they are decoded.
pub(super) fn decode(
    path: &Path,
    source: impl BufRead + Seek,
    limits: &Limits,
    counted: &mut u64,
) -> Result<([u32; 2], Vec<[u8; 4]>), Error> {
    let no_texture = |reason: String| Error::parse(path, None, format!("can't read the texture: {reason}"));
    let said =
        |error: image::ImageError| Error::parse_from(path, None, format!("can't read the texture: {error}"), error);
    let mut reader = image::ImageReader::new(source).with_guessed_format().map_err(|error| Error::io(path, error))?;
    // A TGA file has no signature.
    let is_tga = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("tga"));
    if reader.format().is_none() && is_tga {
        reader.set_format(ImageFormat::Tga);
    }
    check_format(reader.format()).map_err(no_texture)?;
    let within = |pixels: u64| {
        let mut within = image::Limits::default();
        within.max_alloc = Some(pixels.saturating_mul(DECODING_BYTES).saturating_add(1 << 20));
        within
    };
    reader.limits(within(limits.texture_pixels));
    let mut decoder = reader.into_decoder().map_err(said)?;
    let (width, height) = decoder.dimensions();
    check_size(width, height).map_err(no_texture)?;
    let count = u64::from(width) * u64::from(height);
    if count > limits.texture_pixels {
        return Err(Error::TooLarge {
            path: path.into(),
            size: format!("the picture has {width}x{height} pixels, {count} in all"),
            limit: limits.texture_pixels,
            remedy: format!("raise it with {} if the size is intended", limits.texture_option_name),
        });
    }
    *counted = count;
    // A GIF's first picture, and parts of other pictures, may be larger than the whole.
    decoder.set_limits(within(count)).map_err(said)?;
    let picture = image::DynamicImage::from_decoder(decoder).map_err(said)?.into_rgba8();
    // The conversion copies if the buffer's length in memory is not a multiple of four.
    let pixels = bytemuck::try_cast_vec(picture.into_raw()).unwrap_or_else(|(_, bytes)| bytes.as_chunks().0.to_vec());
    Ok(([width, height], pixels))
}

#[cfg(test)]
mod tests {
    use image::{ColorType, DynamicImage};

    use super::*;
    use crate::{
        folder::Folder,
        scene::{Texture, TextureKind},
    };

    fn pixels(texture: &Texture) -> &[[u8; 4]] {
        match texture.kind() {
            TextureKind::Image { pixels, .. } => pixels,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn every_kind_of_pixel_becomes_8_bits_of_rgba() {
        let folder = Folder::new("texture_kinds");
        // The first pixel of a picture with these samples. Each value is also used for 16 bits.
        let kinds = [
            (ColorType::L8, [51, 51, 51, 255]),
            (ColorType::La8, [51, 51, 51, 102]),
            (ColorType::Rgb8, [51, 102, 153, 255]),
            (ColorType::Rgba8, [51, 102, 153, 204]),
            (ColorType::L16, [51, 51, 51, 255]),
            (ColorType::La16, [51, 51, 51, 102]),
            (ColorType::Rgb16, [51, 102, 153, 255]),
            (ColorType::Rgba16, [51, 102, 153, 204]),
        ];
        for (kind, expected) in kinds {
            let mut picture = DynamicImage::new(3, 2, kind);
            let channels = usize::from(kind.channel_count());
            let samples = [51u8, 102, 153, 204];
            match &mut picture {
                DynamicImage::ImageLuma8(p) => p[(0, 0)].0.copy_from_slice(&samples[..channels]),
                DynamicImage::ImageLumaA8(p) => p[(0, 0)].0.copy_from_slice(&samples[..channels]),
                DynamicImage::ImageRgb8(p) => p[(0, 0)].0.copy_from_slice(&samples[..channels]),
                DynamicImage::ImageRgba8(p) => p[(0, 0)].0.copy_from_slice(&samples[..channels]),
                DynamicImage::ImageLuma16(p) => p[(0, 0)].0 = [257 * 51],
                DynamicImage::ImageLumaA16(p) => p[(0, 0)].0 = [257 * 51, 257 * 102],
                DynamicImage::ImageRgb16(p) => p[(0, 0)].0 = [257 * 51, 257 * 102, 257 * 153],
                DynamicImage::ImageRgba16(p) => p[(0, 0)].0 = [257 * 51, 257 * 102, 257 * 153, 257 * 204],
                _ => unreachable!(),
            }
            let path = folder.file("kind.png");
            picture.save(&path).unwrap();
            let texture = Texture::open(&path).unwrap();
            assert!(matches!(texture.kind(), TextureKind::Image { size: [3, 2], .. }), "{kind:?}");
            assert_eq!((pixels(&texture).len(), pixels(&texture)[0]), (6, expected), "{kind:?}");
        }
    }

    /// Tests a PNG palette of four colours and two opacities.
    #[test]
    fn palettes_and_their_transparency_are_looked_up() {
        let folder = Folder::new("palette");
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 4, 1);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Two);
        encoder.set_palette(vec![255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 8, 7]);
        encoder.set_trns(vec![255, 128]);
        encoder.write_header().unwrap().write_image_data(&[0b_00_01_10_11]).unwrap();
        let texture = Texture::open(folder.write("palette.png", bytes)).unwrap();
        assert_eq!(pixels(&texture), [[255, 0, 0, 255], [0, 255, 0, 128], [0, 0, 255, 255], [9, 8, 7, 255]]);
    }

    #[test]
    fn a_jpeg_is_read_and_what_is_neither_is_named() {
        let folder = Folder::new("texture_jpeg");
        let path = folder.file("grey.jpg");
        DynamicImage::ImageLuma8(image::GrayImage::from_pixel(5, 3, image::Luma([200]))).save(&path).unwrap();
        let texture = Texture::open(&path).unwrap();
        assert!(pixels(&texture).iter().all(|pixel| *pixel == [200, 200, 200, 255]), "{:?}", pixels(&texture));
        let said = |name: &str, bytes: &[u8]| {
            let message = Texture::open(folder.write(name, bytes)).unwrap_err().to_string();
            assert!(message.contains(name), "{message}");
            message
        };
        assert!(said("text.png", b"no picture").contains("it is not PNG"));
        assert!(said("empty.png", b"").contains("it is not PNG"));
        let whole = std::fs::read(&path).unwrap();
        assert!(said("cut.jpg", &whole[..40]).contains("can't read the texture"));
        assert!(Texture::open(folder.path()).unwrap_err().to_string().contains("it is a folder"));
    }

    #[cfg(feature = "more-textures")]
    #[test]
    fn other_formats_are_read_too_and_their_sizes_checked_before_they_are_decoded() {
        let folder = Folder::new("texture_formats");
        let colors = [[9, 8, 7, 255], [255, 0, 0, 255], [0, 200, 0, 255], [3, 2, 1, 255], [0, 0, 250, 255], [255; 4]];
        let picture = image::RgbaImage::from_fn(3, 2, |x, y| image::Rgba(colors[(3 * y + x) as usize]));
        for (format, name) in MORE {
            let path = folder.file(&format!("picture.{}", format.extensions_str()[0]));
            picture.save_with_format(&path, format).unwrap();
            let texture = Texture::open(&path).unwrap();
            assert_eq!(pixels(&texture), colors, "{name}");
            // Only TGA is recognised by its extension alone.
            let bytes = std::fs::read(&path).unwrap();
            let renamed = Texture::from_bytes("a.png", &bytes, &Limits::default());
            match format {
                ImageFormat::Tga => assert!(renamed.unwrap_err().to_string().contains("it is not PNG, JPEG, BMP, GIF")),
                _ => assert_eq!(renamed.unwrap(), texture, "{name}"),
            }
            // All formats except TIFF have the size in front, so no pixel is read.
            let start = if format == ImageFormat::Tiff { bytes.len() } else { bytes.len() - 2 };
            let limits = Limits::default().texture_pixels(5);
            let message = Texture::from_bytes(&path, &bytes[..start], &limits).unwrap_err().to_string();
            assert!(message.contains("3x2 pixels, 6 in all, over the limit of 5"), "{name}: {message}");
            for end in 0..bytes.len() {
                let _ = Texture::from_bytes(&path, &bytes[..end], &Limits::default());
            }
        }
        // Offset and length of the picture's width in the header.
        for (name, at, bytes) in [("bmp", 18, 4), ("gif", 6, 2), ("tga", 12, 2)] {
            let path = folder.file(&format!("picture.{name}"));
            let mut wide = std::fs::read(&path).unwrap();
            for width in [8193u32, 65535] {
                wide[at..at + bytes].copy_from_slice(&width.to_le_bytes()[..bytes]);
                let message = Texture::from_bytes(&path, &wide, &Limits::default()).unwrap_err().to_string();
                assert!(message.contains(&format!("{width}x2 pixels; each side can have 1 to 8192")), "{message}");
            }
        }
    }

    #[cfg(feature = "more-textures")]
    #[test]
    fn of_several_pictures_the_first_is_read_and_none_larger_than_the_file_says() {
        use image::{Delay, Frame, codecs::gif::GifEncoder};

        let mut bytes = Vec::new();
        let mut encoder = GifEncoder::new(&mut bytes);
        for color in [[255, 0, 0, 255], [0, 0, 255, 255]] {
            let picture = image::RgbaImage::from_pixel(2, 1, image::Rgba(color));
            encoder.encode_frame(Frame::from_parts(picture, 0, 0, Delay::from_numer_denom_ms(1, 1))).unwrap();
        }
        drop(encoder);
        let texture = Texture::from_bytes("a.gif", &bytes, &Limits::default()).unwrap();
        assert_eq!(pixels(&texture), [[255, 0, 0, 255]; 2]);
        // A screen of one pixel, two colours, and a picture of 8192x8192 on it: 256 MiB.
        let mut bytes = b"GIF89a\x01\0\x01\0\x80\0\0\0\0\0\xff\xff\xff".to_vec();
        bytes.extend(b"\x2c\0\0\0\0\0\x20\0\x20\0\x02\x02\x4c\x01\0\x3b");
        let message = Texture::from_bytes("a.gif", &bytes, &Limits::default()).unwrap_err().to_string();
        assert!(message.contains("a.gif: can't read the texture: ") && message.contains("limit"), "{message}");
    }

    #[cfg(not(feature = "more-textures"))]
    #[test]
    fn formats_of_the_feature_are_named_without_it() {
        let message = Texture::from_bytes("a.png", b"GIF89a", &Limits::default()).unwrap_err().to_string();
        assert!(message.contains("it is GIF; stereotrace is built without its feature `more-textures`"), "{message}");
    }

    /// Returns a PNG header with this size and no pixels.
    fn header(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Sixteen);
        encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &[]).unwrap();
        bytes
    }

    #[test]
    fn sizes_over_the_limits_are_refused_before_anything_is_decoded() {
        let folder = Folder::new("texture_limits");
        for (width, height) in [(100_000, 100_000), (1, 8193), (8193, 1)] {
            let message = Texture::open(folder.write("huge.png", header(width, height))).unwrap_err().to_string();
            assert!(message.contains(&format!("{width}x{height} pixels; each side can have 1 to 8192")), "{message}");
        }
        // This is PNG's largest size; the decoder itself refuses it.
        let message =
            Texture::open(folder.write("huge.png", header(0x7fff_ffff, 0x7fff_ffff))).unwrap_err().to_string();
        assert!(message.contains("huge.png: can't read the texture"), "{message}");
        let path = folder.write("large.png", header(64, 32));
        let limits = Limits::default().texture_pixels(2047);
        let message = Texture::open_within(&path, &limits).unwrap_err().to_string();
        assert!(
            message.contains("64x32 pixels, 2048 in all, over the limit of 2047; raise it with Limits"),
            "{message}"
        );
        let named = limits.texture_option_name("--max-textures");
        assert!(Texture::open_within(&path, &named).unwrap_err().to_string().contains("raise it with --max-textures"));
        // Within the limit, the error is about the missing pixels.
        let message = Texture::open_within(&path, &limits.texture_pixels(2048)).unwrap_err().to_string();
        assert!(message.contains("large.png: can't read the texture"), "{message}");
    }
}
