//! Typed views of the buffers of glTF files. Every offset, stride and count is checked, because files
//! come from anywhere.

use super::Gltf;
use super::document::{Accessor, SparsePart};

/// The type of a number in a buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Result<Self, String> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(format!("unknown component type {code}")),
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The integer that stands for 1 if integers are normalized.
    fn largest(self) -> f32 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32_767.0,
            Self::U16 => 65_535.0,
            Self::U32 => 4_294_967_295.0,
            Self::F32 => 1.0,
        }
    }

    /// The number in the first bytes. With `normalized`, integers become fractions of the largest one.
    fn read(self, bytes: &[u8], normalized: bool) -> f32 {
        let number = match self {
            Self::I8 => f32::from(bytes[0] as i8),
            Self::U8 => f32::from(bytes[0]),
            Self::I16 => f32::from(i16::from_le_bytes([bytes[0], bytes[1]])),
            Self::U16 => f32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            Self::U32 => self.index(bytes) as f32,
            Self::F32 => return f32::from_bits(self.index(bytes)),
        };
        let largest = self.largest();
        match normalized {
            // The most negative number counts as the one above it.
            true if number < -largest => -1.0,
            true => number / largest,
            false => number,
        }
    }

    /// The unsigned integer in the first bytes, or the bits of a float.
    fn index(self, bytes: &[u8]) -> u32 {
        match self.size() {
            1 => bytes[0].into(),
            2 => u16::from_le_bytes([bytes[0], bytes[1]]).into(),
            _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        }
    }
}

/// The elements of an accessor or of a part of a sparse one.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    component: Component,
}

impl<'a> Elements<'a> {
    fn get(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..][..self.size]
    }
}

impl Gltf<'_> {
    fn accessor(&self, index: usize) -> Result<&Accessor, String> {
        self.document.accessors.get(index).ok_or_else(|| format!("unknown accessor {index}"))
    }

    /// The bytes of a buffer view, and its stride.
    pub(crate) fn view(&self, index: usize) -> Result<(&[u8], Option<u64>), String> {
        let view = self.document.buffer_views.get(index);
        let view = view.ok_or_else(|| format!("unknown buffer view {index}"))?;
        if let Some(bytes) = self.decoded.get(&index) {
            return Ok((bytes, view.byte_stride));
        }
        let bytes = self.bytes(view.buffer, view.byte_offset, view.byte_length)?;
        let bytes = bytes.ok_or_else(|| format!("the buffer view {index} exceeds its buffer"))?;
        Ok((bytes, view.byte_stride))
    }

    /// A range of a buffer; `None` if it exceeds the buffer.
    pub(crate) fn bytes(
        &self,
        buffer: usize,
        offset: u64,
        length: u64,
    ) -> Result<Option<&[u8]>, String> {
        let bytes = self.buffers.get(buffer);
        let bytes = bytes.ok_or_else(|| format!("unknown buffer {buffer}"))?;
        let end = offset.checked_add(length).and_then(|end| usize::try_from(end).ok());
        Ok(end.and_then(|end| bytes.get(usize::try_from(offset).ok()?..end)))
    }

    /// The factor that makes fractions of the normalized integers of an accessor.
    pub(crate) fn scale(&self, index: usize) -> Result<f32, String> {
        let accessor = self.accessor(index)?;
        let component = Component::of(accessor.component_type)?;
        Ok(if accessor.normalized { 1.0 / component.largest() } else { 1.0 })
    }

    /// `count` elements of `parts` numbers in a buffer view.
    fn elements(
        &self,
        view: usize,
        offset: u64,
        component: Component,
        parts: usize,
        count: u64,
    ) -> Result<Elements<'_>, String> {
        let (bytes, stride) = self.view(view)?;
        let size = parts * component.size();
        let stride = stride.unwrap_or(size as u64);
        let exceeds = || format!("an accessor exceeds the buffer view {view}");
        if stride < size as u64 {
            return Err(format!("the stride of the buffer view {view} is less than an element"));
        }
        let bytes = usize::try_from(offset).ok().and_then(|offset| bytes.get(offset..));
        let bytes = bytes.ok_or_else(exceeds)?;
        let needed = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride).and_then(|before| before.checked_add(size as u64)),
        };
        match needed {
            Some(needed) if needed <= bytes.len() as u64 => {
                Ok(Elements { bytes, stride: stride as usize, size, component })
            }
            _ => Err(exceeds()),
        }
    }

    /// The elements of an accessor, each mapped from its bytes by `read`; elements without data have
    /// the value `zero`.
    fn read_elements<T: Copy>(
        &self,
        index: usize,
        parts: usize,
        zero: T,
        read: impl Fn(Component, &[u8], bool) -> T,
    ) -> Result<Vec<T>, String> {
        let accessor = self.accessor(index)?;
        let component = Component::of(accessor.component_type)?;
        let &Accessor { count, normalized, .. } = accessor;
        self.budget.hold(count.saturating_mul(size_of::<T>() as u64))?;
        let read = |bytes: &[u8]| read(component, bytes, normalized);
        let mut all = match accessor.buffer_view {
            None => vec![zero; usize::try_from(count).map_err(|_| "too many elements")?],
            Some(view) => {
                let elements =
                    self.elements(view, accessor.byte_offset, component, parts, count)?;
                (0..count as usize).map(|i| read(elements.get(i))).collect()
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let SparsePart { buffer_view, byte_offset, component_type } = sparse.indices;
            let kind = Component::of(component_type)?;
            let indices = self.elements(buffer_view, byte_offset, kind, 1, sparse.count)?;
            let SparsePart { buffer_view, byte_offset, .. } = sparse.values;
            let values = self.elements(buffer_view, byte_offset, component, parts, sparse.count)?;
            for i in 0..sparse.count as usize {
                let at = indices.component.index(indices.get(i)) as usize;
                let place = all.get_mut(at);
                *place.ok_or("a sparse accessor has an index beyond its end")? =
                    read(values.get(i));
            }
        }
        Ok(all)
    }

    /// The first N numbers of each vector of an accessor, which must be finite.
    pub(crate) fn vectors<const N: usize>(&self, index: usize) -> Result<Vec<[f32; N]>, String> {
        let kind = &*self.accessor(index)?.kind;
        let parts = parts(kind)?;
        if parts < N {
            return Err(format!(
                "the accessor {index} is of the type {kind}, but {N} numbers are needed"
            ));
        }
        let vectors =
            self.read_elements(index, parts, [0.0; N], |component, bytes, normalized| {
                let size = component.size();
                std::array::from_fn(|i| component.read(&bytes[i * size..], normalized))
            })?;
        match vectors.iter().position(|vector| vector.iter().any(|number| !number.is_finite())) {
            Some(at) => Err(format!("the element {at} of the accessor {index} is not finite")),
            None => Ok(vectors),
        }
    }

    /// The unsigned integers of an accessor, N each.
    pub(crate) fn integers<const N: usize>(&self, index: usize) -> Result<Vec<[u32; N]>, String> {
        let accessor = self.accessor(index)?;
        let parts = parts(&accessor.kind)?;
        let component = Component::of(accessor.component_type)?;
        if parts != N || !matches!(component, Component::U8 | Component::U16 | Component::U32) {
            return Err(format!("the accessor {index} must be {N} unsigned integers"));
        }
        self.read_elements(index, N, [0; N], |component, bytes, _| {
            let size = component.size();
            std::array::from_fn(|i| component.index(&bytes[i * size..]))
        })
    }
}

/// Number of numbers in an element.
fn parts(kind: &str) -> Result<usize, String> {
    Ok(match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        "MAT4" => 16,
        _ => return Err(format!("elements of the type {kind} are not supported")),
    })
}
