//! The numbers that a glTF file's accessors stand for.

use super::buffers::{Buffers, Bytes};
use super::json::Accessor;
use crate::error::{Error, Place, Result};

/// An accessor without data is all zeros; no more than these.
const MAX_ZEROS: usize = 1 << 20;

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Kind {
    fn of(code: usize) -> Result<Self> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(wrong_type()),
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number that `bytes` are, of its size.
    fn decode(self, bytes: &[u8], normalized: bool) -> f32 {
        let bits = unsigned(bytes);
        let (value, largest) = match self {
            Self::F32 => return f32::from_bits(bits),
            Self::I8 => (f32::from((bits as u8).cast_signed()), 127.0),
            Self::U8 => (bits as f32, 255.0),
            Self::I16 => (f32::from((bits as u16).cast_signed()), 32767.0),
            Self::U16 => (bits as f32, 65535.0),
            Self::U32 => (bits as f32, 4_294_967_295.0),
        };
        if normalized { (value / largest).max(-1.0) } else { value }
    }
}

fn wrong_type() -> Error {
    Error::malformed(Place::Whole, "an accessor has the wrong type")
}

impl<'a> Buffers<'a> {
    fn accessor(&self, index: usize) -> Result<&'a Accessor> {
        let missing = || Error::malformed(Place::Whole, format!("no accessor {index}"));
        self.root.accessors.get(index).ok_or_else(missing)
    }

    /// The number of elements that an accessor states.
    pub(super) fn count(&self, index: usize) -> Result<usize> {
        Ok(self.accessor(index)?.count.0)
    }

    /// The number of numbers in an element: 3 of a `VEC3`.
    pub(super) fn width(&self, index: usize) -> Result<usize> {
        width(self.accessor(index)?)
    }

    /// The elements of an accessor of `N` numbers each: floats, or integers that are
    /// normalised where the accessor says so.
    pub(super) fn floats<const N: usize>(&self, index: usize) -> Result<Vec<[f32; N]>> {
        self.floats_of(index, |accessor| accessor.normalized)
    }

    /// As [`Self::floats`], with integers that are always normalised.
    pub(super) fn fractions<const N: usize>(&self, index: usize) -> Result<Vec<[f32; N]>> {
        self.floats_of(index, |_| true)
    }

    fn floats_of<const N: usize>(
        &self,
        index: usize,
        normalized: impl Fn(&Accessor) -> bool,
    ) -> Result<Vec<[f32; N]>> {
        let accessor = self.accessor(index)?;
        if width(accessor)? != N {
            return Err(Error::malformed(Place::Whole, "an accessor has the wrong dimension"));
        }
        let kind = Kind::of(accessor.component_type.0)?;
        if kind == Kind::U32 {
            return Err(wrong_type());
        }
        let (size, normalized) = (kind.size(), normalized(accessor));
        self.values(accessor, N * size, [0.0; N], |bytes| {
            std::array::from_fn(|at| kind.decode(&bytes[at * size..(at + 1) * size], normalized))
        })
    }

    /// The elements of an accessor of `N` whole numbers each.
    pub(super) fn integers<const N: usize>(&self, index: usize) -> Result<Vec<[u32; N]>> {
        let accessor = self.accessor(index)?;
        let kind = Kind::of(accessor.component_type.0)?;
        if width(accessor)? != N || !matches!(kind, Kind::U8 | Kind::U16 | Kind::U32) {
            return Err(Error::malformed(Place::Whole, "indices must be whole numbers"));
        }
        let size = kind.size();
        self.values(accessor, N * size, [0; N], |bytes| {
            std::array::from_fn(|at| unsigned(&bytes[at * size..(at + 1) * size]))
        })
    }

    /// The elements of an accessor with its sparse ones in place, each of `size` bytes
    /// as `decode` reads them.
    fn values<T: Clone>(
        &self,
        accessor: &Accessor,
        size: usize,
        zero: T,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>> {
        let count = accessor.count.0;
        let mut values: Vec<T> = match accessor.buffer_view {
            Some(view) => {
                let elements = self.elements(view.0, accessor.byte_offset.0, size, count)?;
                elements.iter().map(&decode).collect()
            }
            None if count <= MAX_ZEROS => vec![zero; count],
            None => {
                let limit = MAX_ZEROS as u64;
                return Err(Error::TooLarge { what: "zeros", count: count as u64, limit });
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let (indices, replaced, count) = (&sparse.indices, &sparse.values, sparse.count.0);
            let kind = Kind::of(indices.component_type.0)?;
            if !matches!(kind, Kind::U8 | Kind::U16 | Kind::U32) {
                return Err(wrong_type());
            }
            let places =
                self.elements(indices.buffer_view.0, indices.byte_offset.0, kind.size(), count)?;
            let replaced =
                self.elements(replaced.buffer_view.0, replaced.byte_offset.0, size, count)?;
            for (place, value) in places.iter().zip(replaced.iter()) {
                let Some(target) = values.get_mut(unsigned(place) as usize) else {
                    let reason = "a sparse accessor's index is out of range";
                    return Err(Error::malformed(Place::Whole, reason));
                };
                *target = decode(value);
            }
        }
        Ok(values)
    }

    /// `count` elements of a view, of `size` bytes each.
    fn elements(&self, view: usize, offset: usize, size: usize, count: usize) -> Result<Elements> {
        let (bytes, stride) = self.view(view)?;
        let stride = stride.filter(|&stride| stride != 0).unwrap_or(size);
        let last = count.saturating_sub(1).checked_mul(stride);
        let end = last.and_then(|last| last.checked_add(size)?.checked_add(offset));
        if stride < size || (count > 0 && end.is_none_or(|end| end > bytes.len())) {
            let reason = "an accessor reaches over its buffer view's end";
            return Err(Error::malformed(Place::Whole, reason));
        }
        Ok(Elements { bytes, offset, stride, size, count })
    }
}

/// Elements that lie in their view.
struct Elements {
    bytes: Bytes,
    offset: usize,
    stride: usize,
    size: usize,
    count: usize,
}

impl Elements {
    fn iter(&self) -> impl Iterator<Item = &[u8]> {
        let begin = |index| self.offset + index * self.stride;
        (0..self.count).map(move |index| &self.bytes[begin(index)..][..self.size])
    }
}

fn width(accessor: &Accessor) -> Result<usize> {
    Ok(match accessor.dimensions.as_str() {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        // Of floats, whose columns need no padding.
        "MAT4" => 16,
        _ => return Err(wrong_type()),
    })
}

/// A number of up to four bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}
