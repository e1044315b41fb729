//! Reads numbers from buffers.

use gltf_json::{
    Accessor, Index,
    accessor::{ComponentType, Type},
    buffer::View,
    validation::Checked,
};

use super::document::Document;
use crate::{Error, message::counted};

/// An accessor and the layout of its elements.
struct Elements<'a> {
    accessor: &'a Accessor,
    name: String,
    component: ComponentType,
    /// Numbers per element.
    width: usize,
}

impl Document<'_> {
    /// Reads elements of up to N numbers each. Components that the accessor's type lacks are `fill`.
    pub(super) fn floats<const N: usize>(
        &self,
        index: Index<Accessor>,
        types: &[Type],
        fill: f32,
        by: &str,
    ) -> Result<Vec<[f32; N]>, Error> {
        let elements = self.elements(index, types, by)?;
        let (component, width) = (elements.component, elements.width.min(N));
        let scale = if elements.accessor.normalized { 1.0 / largest(component) } else { 1.0 };
        let mut zero = [fill; N];
        zero[..width].fill(0.0);
        let values = self.values(&elements, zero, |bytes| {
            let mut value = [fill; N];
            for (place, bytes) in value[..width].iter_mut().zip(bytes.chunks_exact(component.size())) {
                *place = match component {
                    ComponentType::F32 => number(component, bytes) as f32,
                    // The least signed integer is one step below minus the largest, so it is clamped.
                    _ if elements.accessor.normalized => (number(component, bytes) * scale).max(-1.0) as f32,
                    _ => number(component, bytes) as f32,
                };
            }
            value
        })?;
        match values.iter().position(|value| value.iter().any(|number| !number.is_finite())) {
            None => Ok(values),
            Some(at) => {
                let value = &values[at];
                Err(self.fault(format!("{}: element {at} is {value:?}; its numbers must be finite", elements.name)))
            }
        }
    }

    /// Reads unsigned integers, one per element.
    pub(super) fn indices(&self, index: Index<Accessor>, by: &str) -> Result<Vec<u32>, Error> {
        let elements = self.elements(index, &[Type::Scalar], by)?;
        let component = elements.component;
        if !matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(
                self.fault(format!("{}: indices of type {component:?}; they must be unsigned integers", elements.name))
            );
        }
        self.values(&elements, 0, |bytes| number(component, bytes) as u32)
    }

    /// Returns an accessor's number of elements, if a mesh may have that many.
    pub(super) fn element_count(&self, index: Index<Accessor>, by: &str) -> Result<usize, Error> {
        let accessor = self.item(("accessors", &self.root.accessors), index.value(), by)?;
        let (name, count) = (format!("accessors[{}]", index.value()), accessor.count.0);
        self.check_size(&name, "elements", count, 3)?;
        // Elements without bytes are zeros, so a short file could declare millions of them.
        let bytes = self.bytes_read();
        if accessor.buffer_view.is_none() && count > bytes {
            let reason = "elements without a bufferView; the maximum is the files' size in bytes,";
            return Err(self.fault(format!("{name}: {count} {reason} {bytes}")));
        }
        Ok(accessor.count.0 as usize)
    }

    /// Refuses counts over `factor` times the limit on triangles.
    pub(super) fn check_size(&self, name: &str, what: &str, count: u64, factor: u64) -> Result<(), Error> {
        self.limits.check_triangles(self.path, (name, what), count, factor)
    }

    fn elements(&self, index: Index<Accessor>, types: &[Type], by: &str) -> Result<Elements<'_>, Error> {
        self.element_count(index, by)?;
        let accessor = self.item(("accessors", &self.root.accessors), index.value(), by)?;
        let name = format!("accessors[{}]", index.value());
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_) else {
            return Err(self.fault(format!("{name}: its type or componentType is unknown")));
        };
        if !types.contains(&kind) {
            return Err(self.fault(format!("{name}: it is {kind:?}, but {by} needs {types:?}")));
        }
        Ok(Elements { accessor, name, component: component.0, width: kind.multiplicity() })
    }

    /// Reads all elements and applies a sparse accessor's replacements.
    fn values<T: Copy>(
        &self,
        Elements { accessor, name, component, width }: &Elements,
        zero: T,
        parse: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, Error> {
        let (count, size) = (accessor.count.0 as usize, component.size() * width);
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let mut values = match accessor.buffer_view {
            Some(view) => self.slices(view, offset, count, size, name)?.map(&parse).collect(),
            None if accessor.sparse.is_some() => vec![zero; count],
            // By the specification these are zeros, for extensions to fill.
            None => return Err(self.fault(format!("{name}: it has no bufferView"))),
        };
        if let Some(sparse) = &accessor.sparse {
            let sparse_count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
            let Checked::Valid(kind) = sparse.indices.component_type else {
                return Err(self.fault(format!("{name}, sparse.indices: its componentType is unknown")));
            };
            let (from, at) = (&sparse.values, &sparse.indices);
            let [by_indices, by_values] = ["indices", "values"].map(|part| format!("{name}, sparse.{part}"));
            let places = self.slices(at.buffer_view, at.byte_offset.0, sparse_count, kind.0.size(), &by_indices)?;
            let replacements = self.slices(from.buffer_view, from.byte_offset.0, sparse_count, size, &by_values)?;
            for (place, replacement) in places.zip(replacements) {
                let place = number(kind.0, place);
                let value = if place >= 0.0 { values.get_mut(place as usize) } else { None };
                let elements = counted(count, "element", "elements");
                *value.ok_or_else(|| {
                    self.fault(format!("{name}, sparse.indices: {place} is out of range for {elements}"))
                })? = parse(replacement);
            }
        }
        Ok(values)
    }

    /// Returns `count` pieces of a view, starting at an offset.
    fn slices(
        &self,
        view: Index<View>,
        offset: u64,
        count: usize,
        size: usize,
        by: &str,
    ) -> Result<impl Iterator<Item = &[u8]>, Error> {
        let (description, bytes) = self.view(view, by)?;
        let stride = description.byte_stride.map(|stride| stride.0).filter(|&stride| stride > 0).unwrap_or(size);
        if stride < size {
            let reason = format!("{by}: a byteStride of {stride} is too small for elements of {size} bytes");
            return Err(self.fault(reason));
        }
        let needed = count.checked_sub(1).map_or(Some(0), |steps| steps.checked_mul(stride)?.checked_add(size));
        let bytes = usize::try_from(offset).ok().and_then(|offset| bytes.get(offset..));
        let bytes = bytes.filter(|bytes| needed.is_some_and(|needed| needed <= bytes.len()));
        let bytes = bytes.ok_or_else(|| {
            let what = counted(count, "element", "elements");
            let length = description.byte_length.0;
            let view = view.value();
            self.fault(format!(
                "{by}: bufferViews[{view}] of {length} bytes is too small for {what} of {size} bytes from byte \
                 {offset} on"
            ))
        })?;
        Ok(bytes.chunks(stride).take(count).map(move |chunk| &chunk[..size]))
    }
}

/// Returns the largest value of a normalised component.
fn largest(component: ComponentType) -> f64 {
    match component {
        ComponentType::I8 => i8::MAX.into(),
        ComponentType::U8 => u8::MAX.into(),
        ComponentType::I16 => i16::MAX.into(),
        ComponentType::U16 => u16::MAX.into(),
        ComponentType::U32 => u32::MAX.into(),
        ComponentType::F32 => 1.0,
    }
}

/// Converts the bytes of a component to a number.
fn number(component: ComponentType, bytes: &[u8]) -> f64 {
    let mut word = [0; 4];
    word[..bytes.len()].copy_from_slice(bytes);
    let bits = u32::from_le_bytes(word);
    match component {
        ComponentType::I8 => (bits as i8).into(),
        ComponentType::I16 => (bits as i16).into(),
        ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => bits.into(),
        ComponentType::F32 => f32::from_bits(bits).into(),
    }
}
