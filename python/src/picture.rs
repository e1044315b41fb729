//! Pictures as arrays and PNG files.

use numpy::{IntoPyArray, PyArray3, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray3, ndarray::Array3};
use pyo3::{prelude::*, types::PyBytes};
use stereotrace::output::Picture;

use crate::errors::refused;

/// Returns a picture's colours as an array, `(height, width, 3)`.
pub(crate) fn rgb<'py>(py: Python<'py>, [width, height]: [u32; 2], rgba8: &[[u8; 4]]) -> Bound<'py, PyArray3<u8>> {
    let rgb: Vec<[u8; 3]> = rgba8.iter().map(|&[red, green, blue, _]| [red, green, blue]).collect();
    shaped(py, [width, height], rgb)
}

/// Returns `N` values per pixel as an array, `(height, width, N)`.
pub(crate) fn shaped<T: numpy::Element, const N: usize>(
    py: Python<'_>,
    [width, height]: [u32; 2],
    values: Vec<[T; N]>,
) -> Bound<'_, PyArray3<T>> {
    let shape = (height as usize, width as usize, N);
    match Array3::from_shape_vec(shape, values.into_flattened()) {
        Ok(array) => array.into_pyarray(py),
        Err(_) => unreachable!("a view has as many pixels as its size says"),
    }
}

/// Returns a picture as an array, `(height, width, 3)`.
pub(crate) fn array<'py>(py: Python<'py>, picture: &Picture) -> Bound<'py, PyArray3<u8>> {
    rgb(py, [picture.width, picture.height], &picture.rgba8)
}

/// Encodes pixels as a PNG file.
pub(crate) fn encoded(
    [width, height]: [usize; 2],
    color: png::ColorType,
    depth: png::BitDepth,
    bytes: &[u8],
) -> Result<Vec<u8>, String> {
    let side = |length: usize| u32::try_from(length).map_err(|_| format!("{length} pixels per side are too many"));
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, side(width)?, side(height)?);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_compression(png::Compression::Fast);
    if color == png::ColorType::Rgb {
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    }
    let mut writer = encoder.write_header().map_err(|error| error.to_string())?;
    writer.write_image_data(bytes).map_err(|error| error.to_string())?;
    writer.finish().map_err(|error| error.to_string())?;
    Ok(file)
}

/// Decodes a PNG file. Returns an array, top row first: uint8 or uint16, ``(height, width)`` for grey, and
/// ``(height, width, channels)`` for colours. Raises ``ValueError`` for a broken file, one with a palette or fewer than
/// 8 bits, and one of over 2**28 pixels.
#[pyfunction]
pub(crate) fn decode_png<'py>(py: Python<'py>, file: &[u8]) -> PyResult<Bound<'py, PyAny>> {
    let (info, bytes) = py.detach(|| decoded(file)).map_err(refused)?;
    let [width, height] = [info.width, info.height].map(|side| side as usize);
    let channels = info.color_type.samples();
    let shape = if channels == 1 { vec![height, width] } else { vec![height, width, channels] };
    Ok(match info.bit_depth {
        png::BitDepth::Sixteen => {
            let samples = bytes.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
            Vec::from_iter(samples).into_pyarray(py).reshape(shape)?.into_any()
        }
        _ => bytes.into_pyarray(py).reshape(shape)?.into_any(),
    })
}

/// Maximum number of pixels of a PNG file that is decoded.
const MOST_PIXELS: u64 = 1 << 28;

fn decoded(file: &[u8]) -> Result<(png::OutputInfo, Vec<u8>), String> {
    let text = |error: png::DecodingError| error.to_string();
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().map_err(text)?;
    let info = reader.info();
    let small = matches!(info.bit_depth, png::BitDepth::One | png::BitDepth::Two | png::BitDepth::Four);
    if small || info.color_type == png::ColorType::Indexed {
        return Err("it has a palette or fewer than 8 bits".into());
    }
    if u64::from(info.width) * u64::from(info.height) > MOST_PIXELS {
        return Err(format!("{}x{} pixels are over 2^28", info.width, info.height));
    }
    let size = reader.output_buffer_size().ok_or("it is too large")?;
    let mut bytes = vec![0; size];
    let info = reader.next_frame(&mut bytes).map_err(text)?;
    reader.finish().map_err(text)?;
    Ok((info, bytes))
}

/// Encodes a picture as a PNG file and returns its bytes.
///
/// ``picture`` is an array, top row first. Colours are sRGB, uint8, ``(height, width, 3)`` or with alpha
/// ``(height, width, 4)``. Grey is uint8 or uint16, ``(height, width)``. Raises ``ValueError`` for another shape or
/// dtype, and for a picture without pixels.
#[pyfunction]
pub(crate) fn encode_png<'py>(py: Python<'py>, picture: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyBytes>> {
    let fault = |reason: String| refused(format!("picture: {reason}"));
    let picture = &py.import("numpy")?.call_method1("require", (picture, py.None(), ["ALIGNED"]))?;
    let file = if let Ok(rgb) = picture.extract::<PyReadonlyArray3<'_, u8>>() {
        let rgb = rgb.as_array();
        let (height, width, channels) = rgb.dim();
        let color = match channels {
            3 => png::ColorType::Rgb,
            4 => png::ColorType::Rgba,
            _ => return Err(fault(format!("{channels} channels; there must be 3 or 4"))),
        };
        let bytes: Vec<u8> = rgb.iter().copied().collect();
        py.detach(|| encoded([width, height], color, png::BitDepth::Eight, &bytes))
    } else if let Ok(grey) = picture.extract::<PyReadonlyArray2<'_, u8>>() {
        let grey = grey.as_array();
        let (height, width) = grey.dim();
        let bytes: Vec<u8> = grey.iter().copied().collect();
        py.detach(|| encoded([width, height], png::ColorType::Grayscale, png::BitDepth::Eight, &bytes))
    } else if let Ok(grey) = picture.extract::<PyReadonlyArray2<'_, u16>>() {
        let grey = grey.as_array();
        let (height, width) = grey.dim();
        let bytes: Vec<u8> = grey.iter().flat_map(|value| value.to_be_bytes()).collect();
        py.detach(|| encoded([width, height], png::ColorType::Grayscale, png::BitDepth::Sixteen, &bytes))
    } else {
        return Err(fault("it must be uint8 or uint16 of (height, width), or uint8 with 3 or 4 channels".into()));
    };
    Ok(PyBytes::new(py, &file.map_err(fault)?))
}
