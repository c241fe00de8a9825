//! The bytes that a glTF file's buffers, views and URIs stand for.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};

use super::at_place;
use super::json::{Meshopt, Root};
use super::meshopt;
use crate::error::{Error, Place, Result};
use crate::load::read_file;

/// The usual alphabet, with or without padding.
const BASE_64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The buffers of a file, each read when it is first needed.
pub(super) struct Buffers<'a> {
    pub(super) root: &'a Root,
    blob: Option<&'a [u8]>,
    folder: &'a Path,
    read: RefCell<HashMap<Source<'a>, Rc<[u8]>>>,
}

/// What was read: a buffer in the file, a file beside it, an unpacked view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Source<'a> {
    Buffer(usize),
    Uri(&'a str),
    View(usize),
}

/// A part of a buffer.
#[derive(Clone)]
pub(super) struct Bytes {
    buffer: Rc<[u8]>,
    begin: usize,
    end: usize,
}

impl std::ops::Deref for Bytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.buffer[self.begin..self.end]
    }
}

impl<'a> Buffers<'a> {
    /// `blob` is the bytes in a GLB file.
    pub(super) fn new(root: &'a Root, blob: Option<&'a [u8]>, folder: &'a Path) -> Self {
        Self { root, blob, folder, read: RefCell::default() }
    }

    /// What a source holds: read once.
    fn once(&self, source: Source<'a>, read: impl FnOnce() -> Result<Vec<u8>>) -> Result<Rc<[u8]>> {
        if let Some(bytes) = self.read.borrow().get(&source) {
            return Ok(Rc::clone(bytes));
        }
        let bytes: Rc<[u8]> = read()?.into();
        self.read.borrow_mut().insert(source, Rc::clone(&bytes));
        Ok(bytes)
    }

    /// A part of a buffer.
    fn part(&self, index: usize, offset: usize, length: usize) -> Result<Bytes> {
        let malformed = |reason: String| Error::malformed(Place::Whole, reason);
        let Some(buffer) = self.root.buffers.get(index) else {
            return Err(malformed(format!("no buffer {index}")));
        };
        let read = || match buffer.uri.as_deref() {
            Some(uri) if uri.starts_with("data:") => {
                self.once(Source::Buffer(index), || load_uri(uri, self.folder))
            }
            Some(uri) => self.once(Source::Uri(uri), || load_uri(uri, self.folder)),
            None => self.once(Source::Buffer(index), || {
                let blob = self.blob.filter(|_| index == 0);
                blob.map(<[u8]>::to_vec)
                    .ok_or_else(|| malformed("has no bytes in the file".to_owned()))
            }),
        };
        let bytes = read().map_err(|error| at_place(error, &format!("buffer {index}")))?;
        let stated = buffer.byte_length.0;
        if bytes.len() < stated {
            let reason = format!("buffer {index} is truncated: {} of {stated} bytes", bytes.len());
            return Err(malformed(reason));
        }
        match offset.checked_add(length) {
            Some(end) if end <= bytes.len() => Ok(Bytes { buffer: bytes, begin: offset, end }),
            _ => Err(malformed("a buffer view reaches over its buffer's end".to_owned())),
        }
    }

    /// The bytes of a view, unpacked, and the stride if the view has one.
    pub(super) fn view(&self, index: usize) -> Result<(Bytes, Option<usize>)> {
        let Some(view) = self.root.buffer_views.get(index) else {
            return Err(Error::malformed(Place::Whole, format!("no buffer view {index}")));
        };
        let stride = view.byte_stride.map(|stride| stride.0);
        let bytes = match &view.extensions.meshopt {
            None => self.part(view.buffer.0, view.byte_offset.0, view.byte_length.0)?,
            Some(packed) => {
                let unpacked = self.once(Source::View(index), || {
                    self.unpacked(packed)
                        .map_err(|error| at_place(error, &format!("buffer view {index}")))
                })?;
                let end = unpacked.len();
                Bytes { buffer: unpacked, begin: 0, end }
            }
        };
        Ok((bytes, stride))
    }

    fn unpacked(&self, packed: &Meshopt) -> Result<Vec<u8>> {
        let bytes = self.part(packed.buffer.0, packed.byte_offset.0, packed.byte_length.0)?;
        let (count, stride) = (packed.count.0, packed.byte_stride.0);
        meshopt::decode(&bytes, count, stride, &packed.mode, packed.filter.as_deref())
            .map_err(|reason| Error::malformed(Place::Whole, reason))
    }
}

/// The bytes that a URI stands for: data in base 64, or a file beside this one.
pub(super) fn load_uri(uri: &str, folder: &Path) -> Result<Vec<u8>> {
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, text)) = data.split_once(";base64,") else {
            return Err(Error::malformed(Place::Whole, "a data URI must be in base64"));
        };
        return BASE_64
            .decode(text)
            .map_err(|error| Error::malformed(Place::Whole, format!("base64: {error}")));
    }
    if uri.contains("://") {
        let reason = format!("{uri:.100} is not a file next to this one");
        return Err(Error::malformed(Place::Whole, reason));
    }
    let path = folder.join(percent_decoded(uri));
    read_file(&path).map_err(|error| error.in_file(&path))
}

/// %20 and its like as what they stand for.
pub(super) fn percent_decoded(uri: &str) -> String {
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
