//! The header of an OpenVDB file, and its grids.

use super::bytes::Bytes;
use crate::error::{Error, Place, Result};

/// "BDV " and four zeros, little endian.
const MAGIC: u64 = 0x5644_4220;
/// Versions whose nodes carry masks and a compression of their own.
const VERSIONS: std::ops::RangeInclusive<u32> = 222..=225;
/// What stands between a grid's name and its number among grids of that name.
const NUMBER_MARK: char = '\u{1e}';

/// A grid as the file's header lists it.
#[derive(Clone, Debug)]
pub(super) struct GridHeader {
    /// The name that the file tells it by, which has a number if another has the
    /// same name.
    unique: String,
    /// The type of the tree, without the mark of half floats.
    pub(super) tree: String,
    /// True if floats are stored as halves.
    pub(super) is_half: bool,
    /// The unique name of the grid whose tree is this one's; empty if it has its own.
    pub(super) parent: String,
    /// The offset of its contents.
    pub(super) contents: u64,
    /// The offset of its leaves' values.
    pub(super) leaves: u64,
}

impl GridHeader {
    /// The name that its author gave it.
    pub(super) fn name(&self) -> &str {
        self.unique.split(NUMBER_MARK).next().unwrap_or_default()
    }

    /// True for the grid that another names as the one whose tree it has.
    pub(super) fn is_called(&self, unique: &str) -> bool {
        self.unique == unique
    }

    /// An error in this grid.
    pub(super) fn refuse(&self, reason: impl Into<std::borrow::Cow<'static, str>>) -> Error {
        Error::malformed(Place::Named(format!("grid `{}`", self.name())), reason)
    }
}

/// The grids of a file, in its order.
pub(super) fn grids(bytes: &[u8]) -> Result<Vec<GridHeader>> {
    let mut file = Bytes::new(bytes);
    let refuse = |reason: String| Err(Error::malformed(Place::Header, reason));
    if bytes.len() < 8 || file.u64()? != MAGIC {
        return refuse("not an OpenVDB file".into());
    }
    let version = file.u32()?;
    if !VERSIONS.contains(&version) {
        let (first, last) = (VERSIONS.start(), VERSIONS.end());
        return refuse(format!("unsupported version {version}: only {first} to {last}"));
    }
    file.take(8)?;
    if file.u8()? != 1 {
        return refuse("unsupported: file without grid offsets".into());
    }
    file.take(36)?;
    skip_metadata(&mut file)?;
    let count = file.u32()?;
    let mut grids: Vec<GridHeader> = Vec::new();
    for _ in 0..count {
        let (unique, kind, parent) = (file.text()?, file.text()?, file.text()?);
        let [contents, leaves, end] = [file.u64()?, file.u64()?, file.u64()?];
        let (tree, is_half) = match kind.strip_suffix("_HalfFloat") {
            Some(tree) => (tree.to_owned(), true),
            None => (kind, false),
        };
        grids.push(GridHeader { unique, tree, is_half, parent, contents, leaves });
        file = file.at(end)?;
    }
    Ok(grids)
}

fn skip_metadata(file: &mut Bytes<'_>) -> Result<()> {
    read_metadata(file, |_, _| {})
}

/// Tells `found` every name and value.
pub(super) fn read_metadata(
    file: &mut Bytes<'_>,
    mut found: impl FnMut(&str, &[u8]),
) -> Result<()> {
    for _ in 0..file.u32()? {
        let (name, _kind) = (file.text()?, file.text()?);
        let length = file.u32()?;
        found(&name, file.take(length as usize)?);
    }
    Ok(())
}
