//! The header of a PLY file.

use std::collections::HashSet;

use super::Fault;

/// Longest line of a header. A binary file with a broken header may have no line end for long.
const LONGEST_LINE: usize = 1 << 16;

/// Encoding of numbers.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Returns the size in bytes in binary files.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// Returns the largest integer of the type, or infinity for floats.
    pub(super) fn largest(self) -> f64 {
        match self {
            Self::I8 => i8::MAX.into(),
            Self::U8 => u8::MAX.into(),
            Self::I16 => i16::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::I32 => i32::MAX.into(),
            Self::U32 => u32::MAX.into(),
            Self::F32 | Self::F64 => f64::INFINITY,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) line: usize,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    pub(super) line: usize,
}

pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Number of lines in the header.
    pub(super) lines: usize,
    /// Line of a comment that names a texture.
    pub(super) texture_file: Option<usize>,
}

/// Reads a header. Returns it and the rest of the file.
pub(super) fn read(bytes: &[u8]) -> Result<(Header, &[u8]), Fault> {
    let mut rest = bytes;
    let first = next_line(&mut rest, false).filter(|line| line.trim_ascii() == b"ply");
    first.ok_or_else(|| (Some(1), "it is not a PLY file: its first line is not `ply`".into()))?;
    // If a lone carriage return ends the first line, it ends all lines.
    let by_return = bytes.get(3) == Some(&b'\r') && bytes.get(4) != Some(&b'\n');
    let (mut encoding, mut elements, mut texture_file) = (None, Vec::new(), None);
    // Names of all elements, and of the last one's properties. Sets make lookups fast, since there may be hundreds of
    // thousands.
    let (mut element_names, mut property_names) = (HashSet::new(), HashSet::new());
    for line in 2.. {
        let text = next_line(&mut rest, by_return);
        let text = text.ok_or_else(|| (Some(line), "the header has no end_header".to_owned()))?;
        let text = String::from_utf8_lossy(text);
        let words: Vec<&str> = text.split_whitespace().collect();
        let fault = |reason: String| (Some(line), reason);
        match *words.as_slice() {
            ["end_header"] => {
                let encoding = encoding.ok_or_else(|| fault("the header has no format".into()))?;
                return Ok((Header { encoding, elements, lines: line, texture_file }, rest));
            }
            ["format", name, "1.0"] => encoding = Some(encoding_named(name).map_err(fault)?),
            ["format", ..] => {
                return Err(fault(format!("'{}' is not supported; the format must have version 1.0", text.trim())));
            }
            ["comment", "TextureFile", ..] => texture_file = texture_file.or(Some(line)),
            ["comment" | "obj_info", ..] | [] => {}
            ["element", name, count] => {
                elements.push(element(name, count, line, &mut element_names).map_err(fault)?);
                property_names.clear();
            }
            ["property", ref words @ ..] => {
                let element = elements.last_mut().ok_or_else(|| fault("a property before the first element".into()))?;
                let property = property(words, line, &element.name, &mut property_names);
                element.properties.push(property.map_err(fault)?);
            }
            _ => return Err(fault(format!("'{}' is not a header line", text.trim()))),
        }
    }
    unreachable!("lines end before their numbers do")
}

/// Returns the next line without its end.
fn next_line<'a>(rest: &mut &'a [u8], by_return: bool) -> Option<&'a [u8]> {
    let within = &rest[..rest.len().min(LONGEST_LINE)];
    let is_end = |&byte: &u8| byte == b'\n' || byte == b'\r';
    let end = within.iter().position(is_end)?;
    // With lone carriage returns as line ends, a following newline is not part of the end.
    let is_pair = !by_return && rest[end] == b'\r' && rest.get(end + 1) == Some(&b'\n');
    let (line, after) = (&rest[..end], &rest[end + 1 + usize::from(is_pair)..]);
    *rest = after;
    Some(line)
}

fn encoding_named(name: &str) -> Result<Encoding, String> {
    match name {
        "ascii" => Ok(Encoding::Text),
        "binary_little_endian" => Ok(Encoding::Little),
        "binary_big_endian" => Ok(Encoding::Big),
        _ => Err(format!("unknown format '{name}'; use ascii, binary_little_endian or binary_big_endian")),
    }
}

fn element(name: &str, count: &str, line: usize, names: &mut HashSet<String>) -> Result<Element, String> {
    let count = count.parse().map_err(|_| format!("element {name}: '{count}' is not a count"))?;
    match names.insert(name.into()) {
        false => Err(format!("there are two elements {name}")),
        true => Ok(Element { name: name.into(), count, properties: Vec::new(), line }),
    }
}

fn property(words: &[&str], line: usize, element: &str, names: &mut HashSet<String>) -> Result<Property, String> {
    let scalar = |name: &str| Scalar::named(name).ok_or_else(|| format!("'{name}' is not a property type"));
    let (kind, name) = match *words {
        ["list", count, item, name] => {
            let count = scalar(count)?;
            if count.is_float() {
                return Err(format!("property {name}: a list's count must have an integer type"));
            }
            (Kind::List { count, item: scalar(item)? }, name)
        }
        [kind, name] => (Kind::Scalar(scalar(kind)?), name),
        _ => return Err("a property must have a type and a name, or `list`, two types and a name".into()),
    };
    match names.insert(name.into()) {
        false => Err(format!("element {element} has two properties {name}")),
        true => Ok(Property { name: name.into(), kind, line }),
    }
}
