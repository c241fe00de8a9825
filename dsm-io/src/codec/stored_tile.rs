//! A tile as it lies in a file, before its pixels are decoded.

use std::borrow::Cow;

use crate::error::{Place, Result, check_limit};
use crate::format::container::Container;
use crate::format::directory::TileEntry;
use crate::limits::Limits;
use crate::tile_id::{TileId, TileRect};

/// The payload of a tile that is not empty, its checksum checked, and what the
/// directory says of it.
#[derive(Debug)]
pub struct StoredTile<'a> {
    pub(crate) payload: Cow<'a, [u8]>,
    pub(crate) entry: &'a TileEntry,
    pub(crate) rect: TileRect,
    pub(crate) place: Place,
}

impl<'a> StoredTile<'a> {
    /// A tile, and which pixels it covers; no tile if it is empty. O(bytes).
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchTile`](crate::error::Error::NoSuchTile),
    /// [`Error::Limit`](crate::error::Error::Limit) or
    /// [`Error::Checksum`](crate::error::Error::Checksum).
    pub fn read(
        container: &'a Container,
        id: TileId,
        limits: &Limits,
    ) -> Result<(Option<Self>, TileRect)> {
        let (entry, rect) = container.entry(id)?;
        check_limit("pixels of a tile", rect.pixel_count(), limits.max_pixels)?;
        if entry.is_empty() {
            return Ok((None, rect));
        }
        let length = entry.raw_length.max(entry.stored_length);
        check_limit("bytes of a tile", length, limits.max_chunk_bytes)?;
        let (payload, place) = (container.payload(id)?, entry.place(id));
        Ok((Some(Self { payload, entry, rect, place }), rect))
    }

    /// The tile's entry in the directory.
    #[must_use]
    pub const fn entry(&self) -> &TileEntry {
        self.entry
    }

    /// Width and height in pixels.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        [self.rect.width, self.rect.height]
    }

    /// Number of pixels.
    #[must_use]
    pub const fn pixel_count(&self) -> u64 {
        self.rect.pixel_count()
    }

    /// The tile's place in its file.
    #[must_use]
    pub const fn place(&self) -> Place {
        self.place
    }
}
