//! Conversions of Python values to the library's.

use std::{fmt::Display, str::FromStr};

use numpy::{
    Element, PyArray2, PyArrayDescrMethods, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::{conversion::FromPyObjectOwned, exceptions::PyTypeError, prelude::*};
use stereotrace::{
    Error,
    glam::{DVec3, Vec2, Vec3},
};

use crate::errors::{raised, refused};

/// Three numbers: a tuple, a list or an array.
#[derive(Clone, Copy)]
pub(crate) struct Point(pub(crate) Vec3);

impl<'a, 'py> FromPyObject<'a, 'py> for Point {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match value.extract::<[f32; 3]>() {
            Ok(numbers) => Ok(Self(Vec3::from_array(numbers))),
            Err(_) => Err(PyTypeError::new_err(format!("{} must be three numbers", shown(&value)))),
        }
    }
}

/// Three numbers in double precision: a position in world coordinates.
#[derive(Clone, Copy)]
pub(crate) struct Position(pub(crate) DVec3);

impl<'a, 'py> FromPyObject<'a, 'py> for Position {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match value.extract::<[f64; 3]>() {
            Ok(numbers) => Ok(Self(DVec3::from_array(numbers))),
            Err(_) => Err(PyTypeError::new_err(format!("{} must be three numbers", shown(&value)))),
        }
    }
}

/// A colour: three numbers, or one number for all three channels.
#[derive(Clone, Copy)]
pub(crate) struct Color(pub(crate) Vec3);

impl<'a, 'py> FromPyObject<'a, 'py> for Color {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(grey) = value.extract::<f32>() {
            return Ok(Self(Vec3::splat(grey)));
        }
        match value.extract::<[f32; 3]>() {
            Ok(numbers) => Ok(Self(Vec3::from_array(numbers))),
            Err(_) => Err(PyTypeError::new_err(format!("{} must be a number, or red, green and blue", shown(&value)))),
        }
    }
}

/// Width and height in pixels: a tuple, a list or an array.
#[derive(Clone, Copy)]
pub(crate) struct Size(pub(crate) u32, pub(crate) u32);

impl<'a, 'py> FromPyObject<'a, 'py> for Size {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match value.extract::<[u32; 2]>() {
            Ok([width, height]) => Ok(Self(width, height)),
            Err(_) => Err(PyTypeError::new_err(format!("{} must be width and height", shown(&value)))),
        }
    }
}

/// Extracts the two values of a tuple or a list.
pub(crate) fn two<'py, A: FromPyObjectOwned<'py>, B: FromPyObjectOwned<'py>>(
    value: &Bound<'py, PyAny>,
) -> PyResult<(A, B)> {
    let [first, second]: [Bound<'py, PyAny>; 2] = value.extract()?;
    Ok((first.extract().map_err(Into::into)?, second.extract().map_err(Into::into)?))
}

/// Returns a value as messages show it, at most 80 characters.
pub(crate) fn shown(value: &Bound<'_, PyAny>) -> String {
    let text = value.repr().map_or_else(|_| "?".into(), |text| text.to_string());
    if text.chars().count() <= 80 { text } else { text.chars().take(79).chain(['…']).collect() }
}

/// Parses a name that the library knows.
pub(crate) fn named<T: FromStr<Err = Error>>(name: &str) -> PyResult<T> {
    name.parse().map_err(raised)
}

/// Returns the names of all values.
pub(crate) fn names<T: Display>(all: &[T]) -> Vec<String> {
    all.iter().map(T::to_string).collect()
}

pub(crate) fn tuple(vector: Vec3) -> (f32, f32, f32) {
    vector.into()
}

/// Converts a value to an array by `numpy.asarray`.
fn array<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyUntypedArray>> {
    Ok(value.py().import("numpy")?.call_method1("asarray", (value,))?.cast_into()?)
}

/// Converts an array to another type, in C order and aligned.
fn of_type<'py>(array: &Bound<'py, PyUntypedArray>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    array.py().import("numpy")?.call_method1("require", (array, name, ["C", "ALIGNED"]))
}

fn misshapen(what: &str, expected: &str, found: &[usize]) -> PyErr {
    refused(format!("{what}: their shape must be {expected}, not {found:?}"))
}

fn is_of_kind(array: &Bound<'_, PyUntypedArray>, kinds: &[u8]) -> bool {
    kinds.contains(&array.dtype().kind())
}

/// Reads rows of `N` floats from an array of shape `(rows, N)`.
pub(crate) fn rows<const N: usize>(what: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[f32; N]>> {
    rows_of(what, value, "float32")
}

/// Reads rows of `N` floats of type `T`, whose `NumPy` name is `name`.
fn rows_of<T: Element + Copy, const N: usize>(
    what: &str,
    value: &Bound<'_, PyAny>,
    name: &str,
) -> PyResult<Vec<[T; N]>> {
    let array = array(value)?;
    if !is_of_kind(&array, b"fiu") {
        return Err(refused(format!("{what}: they are {}, but must be numbers", array.dtype())));
    }
    let found: PyReadonlyArray2<'_, T> = match of_type(&array, name)?.extract() {
        Ok(found) if array.shape().get(1) == Some(&N) => found,
        _ if array.shape().iter().product::<usize>() == 0 => return Ok(Vec::new()),
        _ => return Err(misshapen(what, &format!("(n, {N})"), array.shape())),
    };
    let (all, _) = found.as_slice()?.as_chunks::<N>();
    Ok(all.to_vec())
}

/// Reads positions in world coordinates, `(n, 3)`.
pub(crate) fn world_points(what: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<DVec3>> {
    Ok(rows_of::<f64, 3>(what, value, "float64")?.into_iter().map(DVec3::from_array).collect())
}

/// Reads positions relative to a scene's origin, or directions, `(n, 3)`.
pub(crate) fn points(what: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Vec3>> {
    Ok(rows::<3>(what, value)?.into_iter().map(Vec3::from_array).collect())
}

/// Reads indices of any integer type, `(n, 3)`.
pub(crate) fn faces(value: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 3]>> {
    let array = array(value)?;
    if array.shape().iter().product::<usize>() == 0 {
        return Ok(Vec::new());
    }
    if !is_of_kind(&array, b"iu") {
        return Err(refused(format!("faces: they are {}, but must be whole numbers", array.dtype())));
    }
    let found: Bound<'_, PyArray2<i64>> = match of_type(&array, "int64")?.cast_into() {
        Ok(found) if array.shape().get(1) == Some(&3) => found,
        _ => return Err(misshapen("faces", "(n, 3)", array.shape())),
    };
    let found = found.readonly();
    let all = found.as_slice()?;
    if let Some(wrong) = all.iter().position(|&index| u32::try_from(index).is_err()) {
        return Err(refused(format!("faces: face {} has the corner {}, which is not a vertex", wrong / 3, all[wrong])));
    }
    let (all, _) = all.as_chunks::<3>();
    Ok(all.iter().map(|corners| corners.map(|index| index as u32)).collect())
}

/// Reads one index for each face, or a single index.
pub(crate) fn indices(what: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<u32>> {
    if let Ok(one) = value.extract::<u32>() {
        return Ok(vec![one]);
    }
    value
        .extract::<Vec<u32>>()
        .map_err(|_| refused(format!("{what}: {} must be one id, or a list of them", shown(value))))
}

/// Reads values for each corner of each triangle, from `(faces, 3, N)` or for each vertex from `(vertices, N)`.
pub(crate) fn corners<const N: usize>(
    what: &str,
    value: &Bound<'_, PyAny>,
    vertices: usize,
    faces: &[[u32; 3]],
) -> PyResult<Vec<[[f32; N]; 3]>> {
    let array = array(value)?;
    if array.shape().len() != 3 {
        let of_vertices = rows::<N>(what, value)?;
        if of_vertices.len() != vertices {
            let found = of_vertices.len();
            return Err(refused(format!(
                "{what}: {found} for {vertices} vertices; give one per vertex, or three per face"
            )));
        }
        // `Scene::add_mesh` refuses a corner that is out of range.
        let at = |corner: u32| of_vertices.get(corner as usize).copied().unwrap_or([0.0; N]);
        return Ok(faces.iter().map(|corners| corners.map(at)).collect());
    }
    if array.shape() != [faces.len(), 3, N] {
        let expected = format!("({vertices}, {N}) or ({}, 3, {N})", faces.len());
        return Err(misshapen(what, &expected, array.shape()));
    }
    let found: PyReadonlyArray3<'_, f32> = of_type(&array, "float32")?.extract()?;
    let (rows, _) = found.as_slice()?.as_chunks::<N>();
    let (all, _) = rows.as_chunks::<3>();
    Ok(all.to_vec())
}

/// Reads colours of corners in linear light. Floats are linear, bytes are sRGB. Alpha is ignored.
pub(crate) fn corner_colors(value: &Bound<'_, PyAny>, vertices: usize, faces: &[[u32; 3]]) -> PyResult<Vec<[Vec3; 3]>> {
    let array = array(value)?;
    let is_srgb = array.dtype().kind() == b'u' && array.dtype().itemsize() == 1;
    if !is_srgb && !is_of_kind(&array, b"f") {
        let reason = "must be floats in linear light, or bytes in sRGB";
        return Err(refused(format!("colors: they are {}, but {reason}", array.dtype())));
    }
    let linear = |value: f32| match is_srgb {
        false => value,
        true if value <= 0.04045 * 255.0 => value / 255.0 / 12.92,
        true => ((value / 255.0 + 0.055) / 1.055).powf(2.4),
    };
    let colors = match array.shape().last() {
        Some(4) => corners::<4>("colors", value, vertices, faces)?
            .into_iter()
            .map(|corners| corners.map(|[red, green, blue, _]| [red, green, blue]))
            .collect(),
        _ => corners::<3>("colors", value, vertices, faces)?,
    };
    Ok(colors.into_iter().map(|corners| corners.map(|color| Vec3::from_array(color.map(linear)))).collect())
}

/// Reads texture coordinates of corners.
pub(crate) fn corner_uv(value: &Bound<'_, PyAny>, vertices: usize, faces: &[[u32; 3]]) -> PyResult<Vec<[Vec2; 3]>> {
    let uv = corners::<2>("uv", value, vertices, faces)?;
    Ok(uv.into_iter().map(|corners| corners.map(Vec2::from_array)).collect())
}

/// Reads normals of corners.
pub(crate) fn corner_normals(
    value: &Bound<'_, PyAny>,
    vertices: usize,
    faces: &[[u32; 3]],
) -> PyResult<Vec<[Vec3; 3]>> {
    let normals = corners::<3>("normals", value, vertices, faces)?;
    Ok(normals.into_iter().map(|corners| corners.map(Vec3::from_array)).collect())
}

/// Reads a picture of bytes, `(height, width, 3)` or with alpha `(height, width, 4)`. Returns width, height, pixels.
pub(crate) fn pixels(what: &str, value: &Bound<'_, PyAny>) -> PyResult<(u32, u32, Vec<[u8; 4]>)> {
    let array = array(value)?;
    let is_bytes = array.dtype().kind() == b'u' && array.dtype().itemsize() == 1;
    let (height, width, channels) = match *array.shape() {
        [height, width, channels @ (3 | 4)] if is_bytes => (height, width, channels),
        _ => {
            let (found, shape) = (array.dtype(), array.shape());
            return Err(refused(format!(
                "{what}: it must be uint8 of shape (height, width, 3) or (height, width, 4), not {found} of {shape:?}"
            )));
        }
    };
    let found: PyReadonlyArray3<'_, u8> = of_type(&array, "uint8")?.extract()?;
    let pixels = match channels {
        3 => found.as_slice()?.as_chunks::<3>().0.iter().map(|&[red, green, blue]| [red, green, blue, 255]).collect(),
        _ => found.as_slice()?.as_chunks::<4>().0.to_vec(),
    };
    let side = |length: usize| {
        u32::try_from(length).map_err(|_| refused(format!("{what}: {length} pixels per side are too many")))
    };
    Ok((side(width)?, side(height)?, pixels))
}

/// Reads linear colours, `(height, width, 3)`. Returns width, height and pixels.
pub(crate) fn linear_pixels(what: &str, value: &Bound<'_, PyAny>) -> PyResult<(u32, u32, Vec<Vec3>)> {
    let array = array(value)?;
    let [height, width, 3] = *array.shape() else {
        return Err(misshapen(what, "(height, width, 3)", array.shape()));
    };
    if !is_of_kind(&array, b"f") {
        return Err(refused(format!("{what}: they are {}, but must be floats in linear light", array.dtype())));
    }
    let found: PyReadonlyArray3<'_, f32> = of_type(&array, "float32")?.extract()?;
    let pixels = found.as_slice()?.as_chunks::<3>().0.iter().copied().map(Vec3::from_array).collect();
    let side = |length: usize| {
        u32::try_from(length).map_err(|_| refused(format!("{what}: {length} pixels per side are too many")))
    };
    Ok((side(width)?, side(height)?, pixels))
}
