//! The parts of a file: the document, and the bytes that a GLB carries.

use super::json::Root;
use crate::error::{Error, Place, Result};
use crate::load::warnings::one_line;

const JSON: &[u8] = b"JSON";
const BYTES: &[u8] = b"BIN\0";

/// The document, and the bytes of the first buffer if they are in the file.
pub(super) fn open(bytes: &[u8]) -> Result<(Root, Option<&[u8]>)> {
    let (json, blob) = if bytes.starts_with(b"glTF") { chunks(bytes)? } else { (bytes, None) };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let root: Root = serde_json::from_slice(json)
        .map_err(|error| Error::malformed(Place::Whole, one_line(&error.to_string())))?;
    let major = |version: &str| version.split('.').next().unwrap_or_default().to_owned();
    let needed = root.asset.min_version.as_deref().unwrap_or(&root.asset.version);
    let version = [&root.asset.version, needed].map(major);
    if version != ["2", "2"] || root.asset.min_version.as_deref().is_some_and(|min| min != "2.0") {
        let reason = format!("glTF version {needed:.10} is not supported: 2.0 is");
        return Err(Error::malformed(Place::Header, reason));
    }
    Ok((root, blob))
}

/// The first chunk, which is the document, and the second if that is bytes.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>)> {
    let malformed = |reason: String| Error::malformed(Place::Header, reason);
    let number = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    let stated = number(8).unwrap_or(0);
    if stated < 20 || u64::from(stated) > bytes.len() as u64 {
        return Err(malformed(format!("truncated: {} of {stated} bytes", bytes.len())));
    }
    let version = number(4).unwrap_or(0);
    if version != 2 {
        return Err(malformed(format!("GLB version {version} is not supported: 2 is")));
    }
    let bytes = &bytes[..stated as usize];
    let chunk = |at: usize| {
        let length = number(at)? as usize;
        let kind = bytes.get(at + 4..at + 8)?;
        Some((kind, bytes.get(at + 8..)?.get(..length)?))
    };
    let Some((JSON, json)) = chunk(12) else {
        return Err(malformed("its first chunk is not a whole document".to_owned()));
    };
    let second = 20 + json.len().next_multiple_of(4);
    let blob = match chunk(second) {
        Some((BYTES, blob)) => Some(blob),
        _ => None,
    };
    Ok((json, blob))
}
