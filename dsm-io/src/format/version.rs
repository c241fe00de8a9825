//! Magic numbers and versions of the format.

use crate::error::{Error, Result};

/// A byte no text begins with, the name, and line ends that a transfer in
/// text mode damages (after PNG's signature).
pub(super) const MAGIC: [u8; 8] = [0x89, b'D', b'S', b'M', 0x0D, 0x0A, 0x1A, 0x0A];

/// Files of another major version are refused.
pub(super) const MAJOR: u16 = 1;

/// Files of a newer minor version are read: what they add can be ignored.
pub(super) const MINOR: u16 = 0;

/// The version of the format, major and minor, of the files that are written.
pub const FORMAT_VERSION: [u16; 2] = [MAJOR, MINOR];

/// What else a file may be: its first bytes and its name.
const OTHERS: [(&[u8], &str); 9] = [
    (b"\x89DSM\n\x1A\n", "its line ends were changed, as by a transfer in text mode"),
    (b"\x89DSM\r\r\n", "its line ends were changed, as by a transfer in text mode"),
    (b"\x09DSM", "its high bits were lost, as by a transfer in text mode"),
    (b"II*\0", "this is a TIFF file; other programs use the extension for theirs"),
    (b"MM\0*", "this is a TIFF file; other programs use the extension for theirs"),
    (b"\x76\x2F\x31\x01", "this is an OpenEXR file"),
    (b"\x1F\x8B", "this is a gzip file"),
    (b"\x28\xB5\x2F\xFD", "this is a zstd file"),
    (b"PK\x03\x04", "this is a zip file"),
];

/// Refuses a file that does not begin like one of this format.
pub(super) fn check_magic(file: &[u8]) -> Result<()> {
    if file.starts_with(&MAGIC) {
        return Ok(());
    }
    if file.is_empty() {
        return Err(Error::NotDsm("the file is empty"));
    }
    if MAGIC.starts_with(file) {
        return Err(Error::Truncated { stated: 64, actual: file.len() as u64 });
    }
    let other = OTHERS.iter().find(|(prefix, _)| file.starts_with(prefix));
    Err(Error::NotDsm(other.map_or(
        "its first bytes are unknown; other programs use the same extension for theirs",
        |&(_, name)| name,
    )))
}
