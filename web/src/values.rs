//! Conversions between JavaScript values and the library's.

use std::{fmt::Display, str::FromStr};

use js_sys::{Float32Array, Object, Uint8ClampedArray, Uint32Array};
use serde::{
    Deserializer, Serialize,
    de::{DeserializeOwned, Error as _, Visitor, value::Error as Silent},
    forward_to_deserialize_any,
};
use stereotrace::{
    Error,
    glam::{Vec2, Vec3},
    output::Picture,
};
use wasm_bindgen::{JsCast, JsValue};
use web_sys::ImageData;

use crate::errors::{raised, refused};

/// Reads a plain object. Error messages call it `what` and name the wrong field.
pub(crate) fn read<T: DeserializeOwned>(what: &str, value: JsValue) -> Result<T, JsValue> {
    check_fields::<T>(what, &value)?;
    let deserializer = serde_wasm_bindgen::Deserializer::from(value);
    serde_path_to_error::deserialize(deserializer).map_err(|error| {
        let path = error.path().to_string();
        let place = if path == "." { String::new() } else { format!(".{path}") };
        let reason = error.inner().to_string();
        refused(&format!("{what}{place}: {}", reason.strip_prefix("Error: ").unwrap_or(&reason)))
    })
}

/// Refuses unknown fields, which serde-wasm-bindgen ignores. Nested objects are not checked here: each is read by
/// itself.
fn check_fields<T: DeserializeOwned>(what: &str, value: &JsValue) -> Result<(), JsValue> {
    let mut fields = Fields(None);
    let _ = T::deserialize(&mut fields);
    let (Some(known), Some(object)) = (fields.0, value.dyn_ref::<Object>()) else { return Ok(()) };
    let keys = Object::keys(object).into_iter().filter_map(|key| key.as_string());
    match keys.into_iter().find(|key| !known.contains(&&**key)) {
        Some(key) => Err(refused(&format!("{what}: unknown field '{key}'; the fields are {}", known.join(", ")))),
        None => Ok(()),
    }
}

/// Deserializer that records the fields of a struct and always fails.
struct Fields(Option<&'static [&'static str]>);

impl<'de> Deserializer<'de> for &mut Fields {
    type Error = Silent;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Silent> {
        Err(Silent::custom("no struct"))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Silent> {
        self.0 = Some(fields);
        Err(Silent::custom("that was all"))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

/// Converts a value to a plain object.
pub(crate) fn written(value: &impl Serialize) -> Result<JsValue, JsValue> {
    // Maps become objects, and `None` becomes undefined.
    Ok(value.serialize(&serde_wasm_bindgen::Serializer::new().serialize_maps_as_objects(true))?)
}

/// Parses a name that the library knows.
pub(crate) fn named<T: FromStr<Err = Error>>(name: &str) -> Result<T, JsValue> {
    name.parse().map_err(raised)
}

/// Returns the names of all values.
pub(crate) fn names<T: Display>(all: &[T]) -> Vec<String> {
    all.iter().map(T::to_string).collect()
}

/// Converts a picture to an `ImageData`.
pub(crate) fn image(picture: &Picture) -> Result<ImageData, JsValue> {
    // The bytes are copied, since an ImageData over a slice would keep showing this module's memory after its reuse.
    let bytes = Uint8ClampedArray::from(picture.rgba8.as_flattened());
    ImageData::new_with_js_u8_clamped_array_and_sh(&bytes, picture.width, picture.height)
}

/// Reads vectors of three numbers, such as positions.
pub(crate) fn points(what: &str, array: &Float32Array) -> Result<Vec<Vec3>, JsValue> {
    Ok(groups(what, &array.to_vec())?.into_iter().map(Vec3::from_array).collect())
}

/// Reads texture coordinates of two numbers.
pub(crate) fn pairs(what: &str, array: &Float32Array) -> Result<Vec<Vec2>, JsValue> {
    Ok(groups(what, &array.to_vec())?.into_iter().map(Vec2::from_array).collect())
}

/// Reads the corners of triangles, three indices each.
pub(crate) fn corners(what: &str, array: &Uint32Array) -> Result<Vec<[u32; 3]>, JsValue> {
    groups(what, &array.to_vec())
}

/// Splits a list into groups of `N` numbers.
fn groups<T: Copy, const N: usize>(what: &str, all: &[T]) -> Result<Vec<[T; N]>, JsValue> {
    match all.as_chunks::<N>() {
        (groups, []) => Ok(groups.to_vec()),
        _ => Err(refused(&format!("{what}: {} numbers are not a multiple of {N}", all.len()))),
    }
}

/// Reads a field that is a typed array. Returns `None` if it is missing.
pub(crate) fn array<T: JsCast>(what: &str, object: &JsValue, field: &str, kind: &str) -> Result<Option<T>, JsValue> {
    let value = js_sys::Reflect::get(object, &field.into())
        .map_err(|_| refused(&format!("{what}: it must be an object with the field {field}")))?;
    if value.is_undefined() || value.is_null() {
        return Ok(None);
    }
    value.dyn_into().map(Some).map_err(|_| refused(&format!("{what}.{field}: it must be a {kind}")))
}
