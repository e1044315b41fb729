//! Decodes skies from `OpenEXR` files with one part and channels R, G and B.

use std::{
    io::{BufRead, Seek},
    path::Path,
};

use exr::{
    image::read::{read, specific_channels::ReadSpecificChannel},
    math::Vec2,
    meta::header::Header,
    prelude::{ReadChannels, ReadLayers},
};
use glam::Vec3;

use super::check_size;
use crate::{Error, Limits, message::counted};

/// Block size that is always allowed, even if the limit on skies is smaller.
const LEAST_BLOCK_BYTES: u64 = 16 << 20;
/// Largest number of channels. All channels of a block are decompressed, also unused ones.
const MOST_CHANNELS: usize = 128;

/// Decodes a picture. The file's display window is the sky, black where the file has no pixels. Negative light, which
/// filters may produce, becomes 0.
pub(super) fn decode(
    path: &Path,
    mut source: impl BufRead + Seek,
    limits: &Limits,
) -> Result<(u32, u32, Vec<Vec3>), Error> {
    let no_sky = |reason: String| Error::parse(path, None, format!("can't read the sky: {reason}"));
    let said = |error: exr::error::Error| Error::parse_from(path, None, format!("can't read the sky: {error}"), error);
    let reader = exr::block::read(&mut source, false).map_err(said)?;
    // With several parts, each block states its part.
    let [header] = reader.headers() else {
        return Err(no_sky(format!(
            "it has {}; a sky must have one",
            counted(reader.headers().len(), "part", "parts")
        )));
    };
    if header.deep || !has_colors(header) {
        return Err(no_sky("it must have channels R, G and B and no deep data".into()));
    }
    if header.channels.list.len() > MOST_CHANNELS {
        return Err(no_sky(format!("{} channels; the maximum is {MOST_CHANNELS}", header.channels.list.len())));
    }
    let window = header.shared_attributes.display_window;
    let [width, height] = sides(window.size);
    let count = check_size(path, [width, height], limits)?;
    // The data window is decompressed completely. It may be larger than the sky.
    let data = header.layer_size;
    if data.area() as u64 > limits.largest_sky().max(count) {
        return Err(no_sky(format!("its data window has {}x{} pixels, more than a sky may have", data.0, data.1)));
    }
    // A block's buffer has its full size, even if the file contains less.
    let Vec2(columns, rows) = header.max_block_pixel_size();
    let pixels = (columns as u64).saturating_mul(rows as u64);
    let most = limits.largest_sky().saturating_mul(size_of::<Vec3>() as u64).max(LEAST_BLOCK_BYTES);
    if pixels.saturating_mul(header.channels.bytes_per_pixel as u64) > most {
        return Err(no_sky(format!("blocks of {columns}x{rows} pixels; a block can have at most {most} bytes")));
    }
    let Vec2(left, top) = header.own_attributes.layer_position - window.position;
    drop(reader);
    source.rewind().map_err(|error| Error::io(path, error))?;

    let size = [width as usize, height as usize];
    let create = move |_: Vec2<usize>, _: &_| vec![Vec3::ZERO; count as usize];
    let set = move |pixels: &mut Vec<Vec3>, at: Vec2<usize>, (r, g, b): (f32, f32, f32)| {
        let place = |at: usize, offset: i32, side: usize| {
            usize::try_from(at as i64 + i64::from(offset)).ok().filter(|&place| place < side)
        };
        if let (Some(column), Some(row)) = (place(at.0, left, size[0]), place(at.1, top, size[1])) {
            // `max` would turn NaN into 0.
            let color = Vec3::new(r, g, b);
            pixels[row * size[0] + column] = Vec3::select(color.cmplt(Vec3::ZERO), Vec3::ZERO, color);
        }
    };
    let channels = read().no_deep_data().largest_resolution_level().specific_channels();
    let channels = channels.required("R").required("G").required("B").collect_pixels(create, set);
    let image = channels.first_valid_layer().all_attributes().non_parallel().from_buffered(source).map_err(said)?;
    Ok((width, height, image.layer_data.channel_data.pixels))
}

fn has_colors(header: &Header) -> bool {
    ["R", "G", "B"].iter().all(|name| header.channels.list.iter().any(|channel| channel.name == **name))
}

/// Returns the sides of a size; too large ones saturate and exceed every limit.
fn sides(size: Vec2<usize>) -> [u32; 2] {
    [size.0, size.1].map(|side| u32::try_from(side).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    use exr::{
        image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer, write::WritableImage},
        math::Vec2,
        meta::{
            attribute::IntegerBounds,
            header::{ImageAttributes, LayerAttributes},
        },
    };

    use super::*;
    use crate::SkyMap;

    const ROWS: Encoding = Encoding::SMALL_LOSSLESS;
    const TILES: Encoding = Encoding { blocks: Blocks::Tiles(Vec2(4, 4)), ..Encoding::SMALL_LOSSLESS };

    /// Encodes a file with these channels and `value` of each channel and pixel. Its data window lies within a display
    /// window.
    fn file(
        names: &[&str],
        place: [i32; 2],
        size: [usize; 2],
        display: [usize; 2],
        value: impl Fn(usize, usize) -> f32,
    ) -> Vec<u8> {
        encoded(ROWS, names, place, size, display, value)
    }

    fn encoded(
        encoding: Encoding,
        names: &[&str],
        [left, top]: [i32; 2],
        [width, height]: [usize; 2],
        display: [usize; 2],
        value: impl Fn(usize, usize) -> f32,
    ) -> Vec<u8> {
        let channels = names.iter().enumerate().map(|(channel, name)| {
            let values = (0..width * height).map(|pixel| value(channel, pixel)).collect();
            AnyChannel::new(*name, FlatSamples::F32(values))
        });
        let layer = LayerAttributes { layer_position: Vec2(left, top), ..LayerAttributes::named("sky") };
        let channels = AnyChannels::sort(channels.collect());
        let layer = Layer::new((width, height), layer, encoding, channels);
        let window = IntegerBounds::new((0, 0), (display[0], display[1]));
        let mut bytes = std::io::Cursor::new(Vec::new());
        let image = Image::from_layers(ImageAttributes::new(window), vec![layer]);
        image.write().non_parallel().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    fn read(bytes: &[u8]) -> Result<SkyMap, Error> {
        SkyMap::from_bytes("sky.exr", bytes, &Limits::default())
    }

    #[test]
    fn a_sky_is_read_with_its_windows_and_light_below_zero_is_none() {
        let value = |channel: usize, pixel: usize| (100 * channel + pixel) as f32 - 101.0;
        let sky = read(&file(&["R", "G", "B", "A"], [0, 0], [4, 2], [4, 2], value)).unwrap();
        assert_eq!(sky.size(), [4, 2]);
        assert_eq!(sky.pixels()[0], Vec3::new(0.0, 0.0, 99.0));
        assert_eq!(sky.pixels()[6], Vec3::new(0.0, 5.0, 105.0));
        // Two columns reach beyond the left edge, and one row of two beyond the lower one.
        let value = |channel: usize, pixel: usize| (10 * channel + pixel) as f32;
        let sky = read(&file(&["R", "G", "B"], [-1, 1], [2, 2], [4, 2], value)).unwrap();
        let mut expected = vec![Vec3::ZERO; 8];
        expected[4] = Vec3::new(1.0, 11.0, 21.0);
        assert_eq!(sky.pixels(), expected);
        let message = read(&file(&["R", "G", "B"], [0, 0], [4, 2], [4, 2], |_, _| f32::NAN)).unwrap_err().to_string();
        assert!(message.contains("sky.exr: ") && message.contains("row 0, column 0"), "{message}");
    }

    #[test]
    fn files_that_are_no_sky_or_too_large_are_refused_before_anything_is_decompressed() {
        let zero = |_: usize, _: usize| 0.0;
        let said = |bytes: &[u8], limits: &Limits| SkyMap::from_bytes("a.exr", bytes, limits).unwrap_err().to_string();
        let usual = Limits::default();
        let whole = file(&["R", "G", "B"], [0, 0], [64, 32], [64, 32], zero);
        // Without pixels, the error is about the limit.
        let start = &whole[..whole.len() - 8];
        let message = said(start, &usual.sky_pixels(2047));
        assert!(message.contains("64x32 pixels, 2048 in all, over the limit of 2047; raise it with"), "{message}");
        assert!(said(start, &usual).contains("a.exr: can't read the sky"));
        assert!(
            said(&file(&["R", "G", "B"], [0, 0], [3, 2], [3, 2], zero), &usual)
                .contains("3x2 pixels; a sky map must have an even width")
        );
        assert!(said(&file(&["Y"], [0, 0], [4, 2], [4, 2], zero), &usual).contains("it must have channels R, G and B"));
        let message = said(&file(&["R", "G", "B"], [0, 0], [64, 32], [4, 2], zero), &usual.sky_pixels(8));
        assert!(message.contains("its data window has 64x32 pixels"), "{message}");
        let names: Vec<String> = (0..126).map(|index| format!("c{index}")).collect();
        let names: Vec<&str> = names.iter().map(|name| &**name).chain(["R", "G", "B"]).collect();
        let message = said(&file(&names, [0, 0], [4, 2], [4, 2], zero), &usual);
        assert!(message.contains("129 channels; the maximum is 128"), "{message}");
    }

    /// Tests windows with sides of up to 2^31 in a changed header.
    #[test]
    fn a_header_that_promises_much_takes_no_memory() {
        let bytes = file(&["R", "G", "B"], [0, 0], [4, 2], [4, 2], |_, _| 0.5);
        for name in ["dataWindow", "displayWindow"] {
            let name = format!("{name}\0box2i\0").into_bytes();
            let at = bytes.windows(name.len()).position(|part| part == name).unwrap() + name.len() + 4;
            for [right, bottom] in
                [[i32::MAX - 1; 2], [i32::MAX - 2, 1], [3, i32::MAX - 2], [-5, -5], [1 << 20; 2], [(1 << 22) - 1, 1]]
            {
                let mut changed = bytes.clone();
                changed[at + 8..][..4].copy_from_slice(&right.to_le_bytes());
                changed[at + 12..][..4].copy_from_slice(&bottom.to_le_bytes());
                // Reversed bounds are swapped, and a display window at the limit is a valid sky.
                match read(&changed) {
                    Ok(sky) => assert!(matches!(sky.size(), [6, 6] | [0x40_0000, 2]), "{sky:?}"),
                    Err(error) => assert!(error.to_string().contains("sky.exr: "), "{error}"),
                }
            }
        }
        // A tile is read whole. The changed files claim larger tiles than the limit.
        let bytes = encoded(TILES, &["R", "G", "B"], [0, 0], [4, 2], [4, 2], |_, _| 0.5);
        assert_eq!(read(&bytes).unwrap().size(), [4, 2]);
        let name = b"tiles\0tiledesc\0";
        let at = bytes.windows(name.len()).position(|part| part == name).unwrap() + name.len() + 4;
        for sides in [[1 << 29; 2], [1 << 22, 4]] {
            let mut changed = bytes.clone();
            changed[at..][..8].copy_from_slice(bytemuck::cast_slice(&sides.map(i32::to_le)));
            let message = read(&changed).unwrap_err().to_string();
            assert!(
                message.contains(&format!("blocks of {}x{} pixels; a block can have at most", sides[0], sides[1])),
                "{message}"
            );
        }
    }

    /// Tests that randomly changed bytes give a sky or an error.
    #[test]
    fn damaged_files_do_no_harm() {
        let of = |encoding: Encoding| {
            encoded(encoding, &["R", "G", "B"], [0, 0], [16, 8], [16, 8], |channel, pixel| (channel * pixel) as f32)
        };
        let whole = [of(ROWS), of(TILES)];
        let mut state = 1u64;
        let mut random = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        let rounds = std::env::var("STEREOTRACE_EXR_ROUNDS").ok().and_then(|text| text.parse().ok()).unwrap_or(2000);
        for _ in 0..rounds {
            let mut changed = whole[random(2)].clone();
            for _ in 0..=random(3) {
                let at = random(changed.len());
                changed[at] = [0, 1, 0x7f, 0x80, 0xff, random(256) as u8][random(6)];
            }
            changed.truncate(if random(4) == 0 { random(changed.len()) } else { changed.len() });
            let _ = read(&changed);
        }
    }
}
