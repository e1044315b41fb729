//! JavaScript's values as the library's.

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

/// A plain object. `what` is it in messages, which name the field at fault.
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

/// Refuses fields that a type has not: serde-wasm-bindgen asks objects for those alone that it has. (Of an object
/// within another it says nothing: that is read by itself.)
fn check_fields<T: DeserializeOwned>(what: &str, value: &JsValue) -> Result<(), JsValue> {
    let mut fields = Fields(None);
    let _ = T::deserialize(&mut fields);
    let (Some(known), Some(object)) = (fields.0, value.dyn_ref::<Object>()) else { return Ok(()) };
    let keys = Object::keys(object).into_iter().filter_map(|key| key.as_string());
    match keys.into_iter().find(|key| !known.contains(&&**key)) {
        Some(key) => Err(refused(&format!("{what}: unknown field '{key}'; there are {}", known.join(", ")))),
        None => Ok(()),
    }
}

/// Learns which fields a struct has, and deserializes nothing.
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
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct seq tuple
        tuple_struct map enum identifier ignored_any
    }
}

/// A value as a plain object.
pub(crate) fn written(value: &impl Serialize) -> Result<JsValue, JsValue> {
    // Maps as objects; what is not there as undefined.
    Ok(value.serialize(&serde_wasm_bindgen::Serializer::new().serialize_maps_as_objects(true))?)
}

/// A name that the library knows.
pub(crate) fn named<T: FromStr<Err = Error>>(name: &str) -> Result<T, JsValue> {
    name.parse().map_err(raised)
}

/// All names of a list.
pub(crate) fn names<T: Display>(all: &[T]) -> Vec<String> {
    all.iter().map(T::to_string).collect()
}

/// A picture as canvases take it.
pub(crate) fn image(picture: &Picture) -> Result<ImageData, JsValue> {
    // A copy of its own: an ImageData made of a slice goes on showing this module's memory, whoever has it next.
    let bytes = Uint8ClampedArray::from(picture.rgba8.as_flattened());
    ImageData::new_with_js_u8_clamped_array_and_sh(&bytes, picture.width, picture.height)
}

/// World positions and the like: three numbers each.
pub(crate) fn points(what: &str, array: &Float32Array) -> Result<Vec<Vec3>, JsValue> {
    Ok(groups(what, &array.to_vec())?.into_iter().map(Vec3::from_array).collect())
}

/// Texture coordinates: two numbers each.
pub(crate) fn pairs(what: &str, array: &Float32Array) -> Result<Vec<Vec2>, JsValue> {
    Ok(groups(what, &array.to_vec())?.into_iter().map(Vec2::from_array).collect())
}

/// Corners of triangles as indices: three each.
pub(crate) fn corners(what: &str, array: &Uint32Array) -> Result<Vec<[u32; 3]>, JsValue> {
    groups(what, &array.to_vec())
}

/// So many of a list's numbers each.
fn groups<T: Copy, const N: usize>(what: &str, all: &[T]) -> Result<Vec<[T; N]>, JsValue> {
    match all.as_chunks::<N>() {
        (groups, []) => Ok(groups.to_vec()),
        _ => Err(refused(&format!("{what}: {} numbers, and not {N} each", all.len()))),
    }
}

/// A field of an object that is an array of a type, or nothing.
pub(crate) fn array<T: JsCast>(what: &str, object: &JsValue, field: &str, kind: &str) -> Result<Option<T>, JsValue> {
    let value = js_sys::Reflect::get(object, &field.into())
        .map_err(|_| refused(&format!("{what}: it must be an object with the field {field}")))?;
    if value.is_undefined() || value.is_null() {
        return Ok(None);
    }
    value.dyn_into().map(Some).map_err(|_| refused(&format!("{what}.{field}: it must be a {kind}")))
}
