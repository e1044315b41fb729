//! Checks of JSON values. Each check takes a value and the path of its key, and returns the checked value.

use std::{cell::RefCell, fmt};

use serde::{
    Deserialize, Deserializer,
    de::{Error as _, MapAccess, SeqAccess, Visitor},
};
use serde_json::{Map, Value};

use crate::Error;

/// Maximum number of characters of a value in a message.
const LONGEST: usize = 80;

/// A JSON value whose mappings have each key once.
pub(super) struct Unique(pub(super) Value);

impl<'de> Deserialize<'de> for Unique {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Values;
        impl<'de> Visitor<'de> for Values {
            type Value = Value;

            fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str("a JSON value")
            }

            fn visit_unit<E>(self) -> Result<Value, E> {
                Ok(Value::Null)
            }

            fn visit_bool<E>(self, flag: bool) -> Result<Value, E> {
                Ok(flag.into())
            }

            fn visit_i64<E>(self, number: i64) -> Result<Value, E> {
                Ok(number.into())
            }

            fn visit_u64<E>(self, number: u64) -> Result<Value, E> {
                Ok(number.into())
            }

            fn visit_f64<E>(self, number: f64) -> Result<Value, E> {
                Ok(number.into())
            }

            fn visit_str<E>(self, text: &str) -> Result<Value, E> {
                Ok(text.into())
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
                let mut list = Vec::new();
                while let Some(Unique(item)) = items.next_element()? {
                    list.push(item);
                }
                Ok(list.into())
            }

            fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
                let mut map = Map::new();
                while let Some((key, Unique(value))) = entries.next_entry::<String, _>()? {
                    if map.contains_key(&key) {
                        let key = shown(&key.into());
                        return Err(A::Error::custom(format!("the key {key} occurs twice in one mapping")));
                    }
                    map.insert(key, value);
                }
                Ok(map.into())
            }
        }
        deserializer.deserialize_any(Values).map(Self)
    }
}

/// A mapping, of which each key is read by name. [`Fields::end`] refuses keys that were not read.
pub(super) struct Fields<'a> {
    map: &'a Map<String, Value>,
    at: &'a str,
    known: RefCell<Vec<&'static str>>,
}

impl<'a> Fields<'a> {
    pub(super) fn of(value: &'a Value, at: &'a str) -> Result<Self, Error> {
        match value {
            Value::Object(map) => Ok(Self { map, at, known: RefCell::default() }),
            _ => fault(at, format!("{} must be a mapping of keys to values", shown(value))),
        }
    }

    /// Reads a key's value by a check. Returns `None` for a missing key and for `null`.
    pub(super) fn get<T>(
        &self,
        key: &'static str,
        check: impl FnOnce(&Value, &str) -> Result<T, Error>,
    ) -> Result<Option<T>, Error> {
        self.known.borrow_mut().push(key);
        let value = self.map.get(key).filter(|value| !value.is_null());
        value.map(|value| check(value, &self.path(key))).transpose()
    }

    /// Returns the path of a key.
    pub(super) fn path(&self, key: &str) -> String {
        if self.at.is_empty() { key.to_owned() } else { format!("{}.{key}", self.at) }
    }

    /// Refuses keys that were not read.
    pub(super) fn end(&self) -> Result<(), Error> {
        let known = self.known.borrow();
        match self.map.keys().find(|key| !known.contains(&key.as_str())) {
            Some(key) => {
                let key = shown(&Value::from(key.as_str()));
                fault(self.at, format!("unknown key {key}; the keys are {}", known.join(", ")))
            }
            None => Ok(()),
        }
    }

    /// Returns the value of a key that must exist.
    pub(super) fn needed<T>(&self, key: &str, found: Option<T>) -> Result<T, Error> {
        found.map_or_else(|| fault(&self.path(key), "it is missing"), Ok)
    }
}

/// Returns the error for the value of a key.
pub(super) fn fault<T>(key: &str, reason: impl Into<String>) -> Result<T, Error> {
    Err(Error::Spec { key: key.to_owned(), reason: reason.into() })
}

/// Returns a value as messages show it.
pub(super) fn shown(value: &Value) -> String {
    let text = match value {
        Value::String(text) => format!("'{text}'"),
        _ => value.to_string(),
    };
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

pub(super) fn text(value: &Value, at: &str) -> Result<String, Error> {
    match value {
        Value::String(text) => Ok(text.clone()),
        _ => fault(at, format!("{} must be text", shown(value))),
    }
}

pub(super) fn flag(value: &Value, at: &str) -> Result<bool, Error> {
    value.as_bool().map_or_else(|| fault(at, format!("{} must be true or false", shown(value))), Ok)
}

/// Reads a number, or infinity. The value may be a string, since YAML 1.1 loaders read `1e-3` as text.
pub(super) fn number(value: &Value, at: &str) -> Result<f64, Error> {
    let number = match value {
        Value::String(text) => text.parse().ok(),
        _ => value.as_f64(),
    };
    match number {
        Some(number) if !number.is_nan() => Ok(number),
        _ => fault(at, format!("{} must be a number", shown(value))),
    }
}

pub(super) fn finite(value: &Value, at: &str) -> Result<f64, Error> {
    match number(value, at)? {
        number if number.is_finite() => Ok(number),
        _ => fault(at, format!("{} must be finite", shown(value))),
    }
}

/// Returns a check for whole numbers from `low` to `high`.
pub(super) fn whole(low: u32, high: u32) -> impl Fn(&Value, &str) -> Result<u32, Error> {
    move |value, at| match value.as_u64() {
        Some(number) if (u64::from(low)..=u64::from(high)).contains(&number) => Ok(number as u32),
        _ => fault(at, format!("{} must be a whole number, {low} to {high}", shown(value))),
    }
}

/// Returns a check for numbers from `low` to `high`.
pub(super) fn within(low: f64, high: f64) -> impl Fn(&Value, &str) -> Result<f64, Error> {
    move |value, at| match finite(value, at)? {
        number if (low..=high).contains(&number) => Ok(number),
        _ if high.is_infinite() => fault(at, format!("{} must be {low} or more", shown(value))),
        _ => fault(at, format!("{} must be {low} to {high}", shown(value))),
    }
}

/// Returns a check for numbers of 0 or more.
pub(super) fn from_zero() -> impl Fn(&Value, &str) -> Result<f64, Error> {
    within(0.0, f64::INFINITY)
}

/// Returns a check for numbers above 0 and below `high`.
pub(super) fn above_zero(high: f64) -> impl Fn(&Value, &str) -> Result<f64, Error> {
    move |value, at| match finite(value, at)? {
        number if number > 0.0 && number < high => Ok(number),
        _ if high.is_infinite() => fault(at, format!("{} must be above 0", shown(value))),
        _ => fault(at, format!("{} must be above 0 and below {high}", shown(value))),
    }
}

/// Returns a check for one of several names.
pub(super) fn one_of<T: Copy>(known: Vec<(&'static str, T)>) -> impl Fn(&Value, &str) -> Result<T, Error> {
    move |value, at| match known.iter().find(|(name, _)| value.as_str() == Some(name)) {
        Some((_, found)) => Ok(*found),
        None => {
            let names: Vec<_> = known.iter().map(|(name, _)| *name).collect();
            fault(at, format!("unknown {}; use one of {}", shown(value), names.join(", ")))
        }
    }
}

pub(super) fn list<T>(of: impl Fn(&Value, &str) -> Result<T, Error>) -> impl Fn(&Value, &str) -> Result<Vec<T>, Error> {
    move |value, at| match value {
        Value::Array(items) => {
            items.iter().enumerate().map(|(index, item)| of(item, &format!("{at}[{index}]"))).collect()
        }
        _ => fault(at, format!("{} must be a list", shown(value))),
    }
}

/// Returns a check for lists of `N` items.
pub(super) fn array<const N: usize, T>(
    of: impl Fn(&Value, &str) -> Result<T, Error>,
) -> impl Fn(&Value, &str) -> Result<[T; N], Error> {
    move |value, at| {
        let wrong = || fault(at, format!("{} must be a list of {N}", shown(value)));
        if value.as_array().is_none_or(|items| items.len() != N) {
            return wrong();
        }
        list(&of)(value, at)?.try_into().or_else(|_| wrong())
    }
}

/// Reads three coordinates.
pub(super) fn point(value: &Value, at: &str) -> Result<[f64; 3], Error> {
    array(finite)(value, at)
}

/// Reads a colour: three channels, or one number for all.
pub(super) fn color(value: &Value, at: &str) -> Result<[f64; 3], Error> {
    match value {
        Value::Number(_) | Value::String(_) => Ok([from_zero()(value, at)?; 3]),
        _ => array(from_zero())(value, at),
    }
}
