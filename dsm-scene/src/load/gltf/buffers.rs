//! The bytes that a glTF file's accessors, views and URIs stand for.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, Document};

use super::at_place;
use crate::error::{Error, Place, Result};
use crate::load::read_file;

/// An accessor without data is all zeros; no more than these.
const MAX_ZEROS: usize = 1 << 24;

/// The buffers of a file.
pub(super) struct Buffers(Vec<Vec<u8>>);

impl Buffers {
    /// Loads all buffers; `blob` is the bytes in a GLB file.
    pub(super) fn load(gltf: &Document, blob: Option<&[u8]>, folder: &Path) -> Result<Self> {
        let load = |buffer: gltf::Buffer<'_>| {
            let bytes = match buffer.source() {
                // One chunk of bytes, for the first buffer: copies of it could be many.
                gltf::buffer::Source::Bin => blob
                    .filter(|_| buffer.index() == 0)
                    .map(<[u8]>::to_vec)
                    .ok_or_else(|| Error::malformed(Place::Whole, "has no bytes in the file"))?,
                gltf::buffer::Source::Uri(uri) => load_uri(uri, folder)?,
            };
            if bytes.len() < buffer.length() {
                let reason = format!("truncated: {} of {} bytes", bytes.len(), buffer.length());
                return Err(Error::malformed(Place::Whole, reason));
            }
            Ok(bytes)
        };
        gltf.buffers()
            .map(|buffer| {
                let place = format!("buffer {}", buffer.index());
                load(buffer).map_err(|error| at_place(error, &place))
            })
            .collect::<Result<_>>()
            .map(Self)
    }

    /// The bytes of a view.
    pub(super) fn view(&self, view: &gltf::buffer::View<'_>) -> Result<&[u8]> {
        let buffer = self.0.get(view.buffer().index());
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| buffer?.get(view.offset()..end)).ok_or_else(|| {
            Error::malformed(Place::Whole, "a buffer view reaches over its buffer's end")
        })
    }

    /// The bytes of every element: `count` of them, `size` bytes each.
    fn elements<'s>(
        &'s self,
        view: &gltf::buffer::View<'_>,
        offset: usize,
        size: usize,
        count: usize,
    ) -> Result<impl Iterator<Item = &'s [u8]> + use<'s>> {
        let bytes = self.view(view)?;
        let stride = view.stride().unwrap_or(size);
        let last = count.saturating_sub(1).checked_mul(stride);
        let end = last.and_then(|last| last.checked_add(size)?.checked_add(offset));
        if stride < size || (count > 0 && end.is_none_or(|end| end > bytes.len())) {
            let reason = "an accessor reaches over its buffer view's end";
            return Err(Error::malformed(Place::Whole, reason));
        }
        Ok((0..count).map(move |index| &bytes[offset + index * stride..][..size]))
    }

    /// The elements of an accessor with its sparse ones in place, each as
    /// `decode` reads it.
    fn values<T: Clone + Default>(
        &self,
        accessor: &Accessor<'_>,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>> {
        let (count, size) = (accessor.count(), accessor.size());
        let mut values: Vec<T> = match accessor.view() {
            Some(view) => {
                self.elements(&view, accessor.offset(), size, count)?.map(&decode).collect()
            }
            None if count <= MAX_ZEROS => vec![T::default(); count],
            None => {
                let limit = MAX_ZEROS as u64;
                return Err(Error::TooLarge { what: "zeros", count: count as u64, limit });
            }
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, count) = (sparse.indices(), sparse.count());
            let size_of_index = indices.index_type().size();
            let places = self.elements(&indices.view(), indices.offset(), size_of_index, count)?;
            let replaced = sparse.values();
            let replaced = self.elements(&replaced.view(), replaced.offset(), size, count)?;
            for (place, value) in places.zip(replaced) {
                let Some(target) = values.get_mut(unsigned(place) as usize) else {
                    let reason = "a sparse accessor's index is out of range";
                    return Err(Error::malformed(Place::Whole, reason));
                };
                *target = decode(value);
            }
        }
        Ok(values)
    }

    /// The elements of an accessor of `N` floats each.
    pub(super) fn floats<const N: usize>(&self, accessor: &Accessor<'_>) -> Result<Vec<[f32; N]>> {
        let dimensions = if N == 3 { Dimensions::Vec3 } else { Dimensions::Vec2 };
        if accessor.dimensions() != dimensions {
            return Err(Error::malformed(Place::Whole, "an accessor has the wrong dimension"));
        }
        let (size, part) = match accessor.data_type() {
            DataType::F32 => (4, 1.0),
            DataType::U8 if accessor.normalized() => (1, 1.0 / 255.0),
            DataType::U16 if accessor.normalized() => (2, 1.0 / 65535.0),
            _ => return Err(Error::malformed(Place::Whole, "an accessor has the wrong type")),
        };
        let float = |bytes: &[u8]| match bytes {
            &[a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
            bytes => unsigned(bytes) as f32 * part,
        };
        let decode =
            |bytes: &[u8]| std::array::from_fn(|at| float(&bytes[at * size..(at + 1) * size]));
        // Arrays have a default up to a length only.
        let values = self.values(accessor, |bytes| Some(decode(bytes)))?;
        Ok(values.into_iter().map(|value| value.unwrap_or([0.0; N])).collect())
    }

    /// The elements of an accessor of whole numbers.
    pub(super) fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>> {
        let integer = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if accessor.dimensions() != Dimensions::Scalar || !integer {
            return Err(Error::malformed(Place::Whole, "indices must be integers"));
        }
        self.values(accessor, unsigned)
    }
}

/// A number of any number of bytes.
pub(super) fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}

/// The bytes that a URI stands for: data in base 64, or a file beside this one.
pub(super) fn load_uri(uri: &str, folder: &Path) -> Result<Vec<u8>> {
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, text)) = data.split_once(";base64,") else {
            return Err(Error::malformed(Place::Whole, "a data URI must be in base64"));
        };
        return STANDARD
            .decode(text)
            .map_err(|error| Error::malformed(Place::Whole, format!("base64: {error}")));
    }
    if uri.contains("://") {
        let reason = format!("{uri} is not a file next to this one");
        return Err(Error::malformed(Place::Whole, reason));
    }
    let path = folder.join(percent_decoded(uri));
    read_file(&path).map_err(|error| error.in_file(&path))
}

/// %20 and its like as what they stand for.
fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let digits = tail.get(..2).and_then(|digits| std::str::from_utf8(digits).ok());
        let escaped = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match escaped.filter(|_| *first == b'%') {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
