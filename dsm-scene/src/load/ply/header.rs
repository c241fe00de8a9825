//! The header of a PLY file.

use super::values::{Encoding, Kind};
use crate::error::{Error, Place, Result};
use crate::load::warnings::one_line;

/// What the rows of the file hold, in their order.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Bytes up to the first row.
    pub(super) length: usize,
}

/// One kind of rows.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

/// One value of each row, or a list of them.
#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// The kind of the length, if it is a list.
    pub(super) length: Option<Kind>,
}

impl Property {
    /// True for the corners of a polygon or strip.
    pub(super) fn is_corners(&self) -> bool {
        matches!(self.name.as_str(), "vertex_indices" | "vertex_index")
    }
}

impl Header {
    pub(super) fn read(bytes: &[u8]) -> Result<Self> {
        let malformed = |reason: String| Error::malformed(Place::Header, reason);
        let (mut at, mut number) = (0, 0);
        let (mut encoding, mut elements) = (None, Vec::<Element>::new());
        loop {
            let rest = &bytes[at..];
            let Some(end) = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')) else {
                return Err(malformed("it has no end_header".to_owned()));
            };
            let both = rest[end..].starts_with(b"\r\n");
            at += end + 1 + usize::from(both);
            let text = String::from_utf8_lossy(&rest[..end]);
            let words: Vec<&str> = text.split_whitespace().collect();
            number += 1;
            let odd = || malformed(format!("line {number} is odd: {}", one_line(&text)));
            match words.as_slice() {
                ["ply"] if number == 1 => {}
                _ if number == 1 => return Err(malformed("must begin with ply".to_owned())),
                ["format", name, _version] => {
                    encoding = Some(Encoding::named(name).ok_or_else(odd)?);
                }
                ["element", name, count] => elements.push(Element {
                    name: (*name).to_owned(),
                    count: count.parse().map_err(|_| odd())?,
                    properties: Vec::new(),
                }),
                ["property", words @ ..] => {
                    let (kind, length, name) = match words {
                        ["list", length, kind, name] => (kind, Some(length), name),
                        [kind, name] => (kind, None, name),
                        _ => return Err(odd()),
                    };
                    let kind = Kind::named(kind).ok_or_else(odd)?;
                    let length = length.map(|length| Kind::named(length).ok_or_else(odd));
                    let property =
                        Property { name: (*name).to_owned(), kind, length: length.transpose()? };
                    elements.last_mut().ok_or_else(odd)?.properties.push(property);
                }
                ["end_header"] => break,
                [] | ["comment" | "obj_info", ..] => {}
                _ => return Err(odd()),
            }
        }
        let Some(encoding) = encoding else {
            return Err(malformed("it has no format".to_owned()));
        };
        for element in &elements {
            element.check((bytes.len() - at) as u64)?;
        }
        Ok(Self { encoding, elements, length: at })
    }
}

impl Element {
    /// Refuses rows that are more than the bytes that are `left` can hold, or that
    /// take none: those would never end.
    fn check(&self, left: u64) -> Result<()> {
        let malformed = |reason: String| {
            Err(Error::malformed(Place::Named(format!("element {}", self.name)), reason))
        };
        if self.properties.is_empty() {
            return malformed("it has no properties".to_owned());
        }
        // Every property takes a byte at least: a list its length.
        let smallest = self.properties.len() as u64;
        if self.count.saturating_mul(smallest) > left {
            return malformed(format!("{} of them do not fit into {left} bytes", self.count));
        }
        for property in &self.properties {
            if property.length.is_some_and(|length| !length.is_whole()) {
                return malformed(format!("the length of {} is no whole number", property.name));
            }
        }
        Ok(())
    }

    /// The property of the corners of each row.
    pub(super) fn corners(&self) -> Result<usize> {
        let malformed = |reason: String| {
            Err(Error::malformed(Place::Named(format!("element {}", self.name)), reason))
        };
        let Some(at) = self.properties.iter().position(Property::is_corners) else {
            return malformed("it has no vertex_indices".to_owned());
        };
        let property = &self.properties[at];
        if property.length.is_none() || !property.kind.is_whole() {
            return malformed(format!("{} is not a list of whole numbers", property.name));
        }
        Ok(at)
    }
}
