//! Accessors: typed, strided, sparse views of buffers, read as numbers (glTF 2.0, section 3.6.2). Every range is
//! checked.

use super::schema::Accessor;
use super::zeros::MOST_ZEROS;
use super::{Gltf, GltfError};

/// The type of one number.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// Reads one number from `bytes`. A `normalized` integer stands for [0, 1] or [-1, 1].
    fn float(self, bytes: &[u8], normalized: bool) -> f32 {
        let share = |number: f32, largest: f32| {
            if normalized {
                (number / largest).max(-1.0)
            } else {
                number
            }
        };
        match (self, bytes) {
            (Self::I8, &[a, ..]) => share(f32::from(a as i8), 127.0),
            (Self::U8, &[a, ..]) => share(f32::from(a), 255.0),
            (Self::I16, &[a, b, ..]) => share(f32::from(i16::from_le_bytes([a, b])), 32767.0),
            (Self::U16, &[a, b, ..]) => share(f32::from(u16::from_le_bytes([a, b])), 65535.0),
            (Self::U32, &[a, b, c, d, ..]) => u32::from_le_bytes([a, b, c, d]) as f32,
            (Self::F32, &[a, b, c, d, ..]) => f32::from_le_bytes([a, b, c, d]),
            _ => 0.0,
        }
    }

    /// Reads one index; None for types that cannot be indices.
    fn index(self, bytes: &[u8]) -> Option<u32> {
        match (self, bytes) {
            (Self::U8, &[a, ..]) => Some(a.into()),
            (Self::U16, &[a, b, ..]) => Some(u16::from_le_bytes([a, b]).into()),
            (Self::U32, &[a, b, c, d, ..]) => Some(u32::from_le_bytes([a, b, c, d])),
            _ => None,
        }
    }
}

/// Elements of `size` bytes that are `stride` bytes apart.
#[derive(Clone, Copy)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Strided<'a> {
    /// The bytes of element `i`, which must exist.
    fn element(&self, i: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..i * self.stride + self.size]
    }

    fn elements(self) -> impl Iterator<Item = &'a [u8]> {
        (0..self.count).map(move |i| self.element(i))
    }
}

impl Gltf {
    /// Elements as vectors of `N` numbers; `kind` is the required accessor type, such as `VEC3`. `used`: the indices of
    /// the elements to read, in ascending order; None for all.
    pub(super) fn vectors<const N: usize>(
        &self,
        index: usize,
        kind: &str,
        used: Option<&[u32]>,
    ) -> Result<Vec<[f32; N]>, GltfError> {
        let accessor = self.accessor(index)?;
        let component = component(index, accessor.component_type)?;
        if accessor.kind != kind {
            let found = accessor.kind.clone();
            return Err(bad(index, format!("has type {found} where {kind} is expected")));
        }
        let element = |bytes: &[u8]| -> [f32; N] {
            std::array::from_fn(|i| component.float(&bytes[i * component.size()..], accessor.normalized))
        };
        let count = accessor.count;
        if let Some(&last) = used.and_then(<[u32]>::last)
            && last as usize >= count
        {
            return Err(bad(index, format!("has {count} elements, but number {last} is used")));
        }
        let mut result: Vec<[f32; N]> = match accessor.buffer_view {
            Some(view) => {
                let size = N * component.size();
                let place = (view, accessor.byte_offset);
                let all = self.strided(index, place, size, count, true)?;
                match used {
                    Some(used) => used.iter().map(|&i| element(all.element(i as usize))).collect(),
                    None => all.elements().map(element).collect(),
                }
            }
            None if self.zeros.max(count) <= MOST_ZEROS => vec![[0.0; N]; used.map_or(count, <[u32]>::len)],
            None => {
                let zeros = self.zeros.max(count);
                let what = format!("has {count} of {zeros} elements without a buffer, which are too many");
                return Err(bad(index, what));
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let place = (sparse.values.buffer_view, sparse.values.byte_offset);
            let values = self.strided(index, place, N * component.size(), sparse.count, false)?;
            let places = self.sparse_places(index, accessor)?;
            for (place, value) in places.into_iter().zip(values.elements()) {
                if place as usize >= count {
                    return Err(bad(index, format!("replaces element {place} of {count}")));
                }
                let slot = match used {
                    Some(used) => used.binary_search(&place).ok(),
                    None => Some(place as usize),
                };
                if let Some(slot) = slot.and_then(|slot| result.get_mut(slot)) {
                    *slot = element(value);
                }
            }
        }
        Ok(result)
    }

    fn sparse_places(&self, index: usize, accessor: &Accessor) -> Result<Vec<u32>, GltfError> {
        let Some(sparse) = &accessor.sparse else {
            return Ok(Vec::new());
        };
        let component = component(index, sparse.indices.component_type)?;
        let place = (sparse.indices.buffer_view, sparse.indices.byte_offset);
        let indices = self.strided(index, place, component.size(), sparse.count, false)?;
        let whole = |bytes| {
            component
                .index(bytes)
                .ok_or_else(|| bad(index, "has indices that are no whole numbers".into()))
        };
        indices.elements().map(whole).collect()
    }

    /// The elements as vertex indices.
    pub(super) fn indices(&self, index: usize) -> Result<Vec<u32>, GltfError> {
        let accessor = self.accessor(index)?;
        let component = component(index, accessor.component_type)?;
        let (Some(view), "SCALAR", None) = (accessor.buffer_view, accessor.kind.as_str(), &accessor.sparse) else {
            return Err(bad(index, "holds no plain indices".into()));
        };
        let elements = self.strided(
            index,
            (view, accessor.byte_offset),
            component.size(),
            accessor.count,
            true,
        )?;
        let whole = |bytes| {
            component
                .index(bytes)
                .ok_or_else(|| bad(index, "holds indices that are no whole numbers".into()))
        };
        elements.elements().map(whole).collect()
    }

    /// An accessor whose elements can be numbered with 32 bits, as vertex indices require.
    pub(super) fn accessor(&self, index: usize) -> Result<&Accessor, GltfError> {
        let accessor = self.get("accessor", &self.root.accessors, index)?;
        match u32::try_from(accessor.count) {
            Ok(_) => Ok(accessor),
            Err(_) => Err(bad(
                index,
                format!("has {} elements, but at most {} are possible", accessor.count, u32::MAX),
            )),
        }
    }

    /// Finds strided elements. `place` is the buffer view and the offset into it.
    fn strided(
        &self,
        accessor: usize,
        (view, offset): (usize, usize),
        size: usize,
        count: usize,
        may_stride: bool,
    ) -> Result<Strided<'_>, GltfError> {
        let given = self.get("buffer view", &self.root.buffer_views, view)?.byte_stride;
        let stride = given.filter(|_| may_stride).unwrap_or(size);
        // Overlapping elements would make a large mesh from a small file.
        if stride < size && count > 1 {
            return Err(bad(
                accessor,
                format!("has elements of {size} bytes, but they are only {stride} bytes apart"),
            ));
        }
        let bytes = self.view(view)?;
        let length = match count.checked_sub(1) {
            Some(last) => last.checked_mul(stride).and_then(|start| start.checked_add(size)),
            None => Some(0),
        };
        let end = length.and_then(|length| length.checked_add(offset));
        if end.is_none_or(|end| end > bytes.len()) {
            let held = bytes.len();
            return Err(bad(
                accessor,
                format!("has {count} elements of {size} bytes, but its buffer view has {held} bytes"),
            ));
        }
        Ok(Strided {
            bytes: &bytes[offset..],
            stride,
            size,
            count,
        })
    }
}

fn component(accessor: usize, code: u32) -> Result<Component, GltfError> {
    Component::of(code).ok_or_else(|| bad(accessor, format!("has the unknown component type {code}")))
}

fn bad(index: usize, what: String) -> GltfError {
    GltfError::Accessor { index, what }
}
