//! Attributes of headers.

use std::borrow::Cow;

use crate::error::{Error, Result};

/// The longest attribute, type or channel name (OpenEXR file layout, "long
/// names").
pub(crate) const LONGEST_NAME: usize = 255;

/// Attributes that describe how the file is built, and those with a field of
/// their own.
pub(crate) const STRUCTURE: [&str; 14] = [
    "channels",
    "chunkCount",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "maxSamplesPerPixel",
    "name",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "tiles",
    "type",
    "version",
];

/// Attributes of [`STRUCTURE`] that the caller of a writer may set, and their
/// types.
const SETTABLE: [(&str, &str); 4] = [
    ("name", "string"),
    ("pixelAspectRatio", "float"),
    ("screenWindowCenter", "v2f"),
    ("screenWindowWidth", "float"),
];

/// One attribute of a header, byte for byte.
///
/// ```
/// use deep_exr::Attribute;
///
/// let owner = Attribute::string("owner", "lighting");
/// assert_eq!((owner.name_text(), &owner.value[..]), ("owner".into(), &b"lighting"[..]));
/// let frame = Attribute::new("frame", "int", 101_i32.to_le_bytes());
/// assert_eq!(frame.value, [101, 0, 0, 0]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attribute {
    /// Its name, usually ASCII.
    pub name: Vec<u8>,
    /// The name of its type, such as `string` or `m44f`.
    pub type_name: Vec<u8>,
    /// Its value, little endian.
    pub value: Vec<u8>,
}

impl Attribute {
    /// An attribute with the bytes that the file stores, little endian.
    #[must_use]
    pub fn new(
        name: impl Into<Vec<u8>>,
        type_name: impl Into<Vec<u8>>,
        value: impl Into<Vec<u8>>,
    ) -> Self {
        Self { name: name.into(), type_name: type_name.into(), value: value.into() }
    }

    /// An attribute that holds text.
    #[must_use]
    pub fn string(name: impl Into<Vec<u8>>, text: &str) -> Self {
        Self::new(name, "string", text)
    }

    /// An attribute made of 32-bit floats, such as `v2f` or `m44f`.
    #[must_use]
    pub fn floats(name: impl Into<Vec<u8>>, type_name: impl Into<Vec<u8>>, values: &[f32]) -> Self {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        Self::new(name, type_name, bytes)
    }

    /// The name as text, for messages.
    #[must_use]
    pub fn name_text(&self) -> Cow<'_, str> {
        String::from_utf8_lossy(&self.name)
    }

    /// Refuses what no header can hold, and what the writer says itself.
    pub(crate) fn check_writable(&self) -> Result<()> {
        let nameable = |text: &[u8]| (1..=LONGEST_NAME).contains(&text.len()) && !text.contains(&0);
        let name = self.name_text();
        let settable = SETTABLE.iter().find(|(settable, _)| *settable == name);
        let reason = if !nameable(&self.name) || !nameable(&self.type_name) {
            "names must have 1 to 255 bytes, none of them 0"
        } else if settable.is_some_and(|(_, wanted)| wanted.as_bytes() != self.type_name) {
            "is not of the type that it must have"
        } else if settable.is_none() && STRUCTURE.contains(&&*name) {
            "says how the file is built, which the writer does"
        } else if i32::try_from(self.value.len()).is_err() {
            "has 2 GiB or more"
        } else if value_length(&self.type_name).is_some_and(|length| length != self.value.len()) {
            "is not as long as values of its type"
        } else {
            return Ok(());
        };
        Err(Error::Attribute { name: name.into_owned(), reason })
    }
}

/// Bytes of a value of this type, of the types of fixed length.
fn value_length(type_name: &[u8]) -> Option<usize> {
    Some(match type_name {
        b"int" | b"float" => 4,
        b"v2i" | b"v2f" | b"double" | b"rational" | b"timecode" => 8,
        b"v3i" | b"v3f" => 12,
        b"box2i" | b"box2f" | b"v2d" => 16,
        b"v3d" => 24,
        b"keycode" => 28,
        b"chromaticities" => 32,
        b"m33f" => 36,
        b"m44f" => 64,
        b"m33d" => 72,
        b"m44d" => 128,
        b"compression" | b"lineOrder" | b"envmap" | b"deepImageState" => 1,
        _ => return None,
    })
}
