//! A tile on its way into a file or out of one.

use super::directory::TileEntry;

/// A tile ready to be written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EncodedTile {
    /// The payload; none if the tile is empty.
    pub bytes: Vec<u8>,
    /// Length of the payload once unpacked, in bytes.
    pub raw_length: u64,
    /// Number of vertices in all pixels.
    pub vertex_count: u64,
    /// The smallest depth of all vertices.
    pub z_min: f32,
    /// The largest depth of all vertices.
    pub z_max: f32,
    /// The maximum shift of depths away from the light.
    pub depth_error: f32,
    /// The codec's number in the file.
    pub codec: u8,
    /// The block's number in the file.
    pub block: u8,
    /// The columns that are stored as differences: bit i for column i.
    pub differences: u8,
}

impl EncodedTile {
    /// The tile that the directory says this of.
    pub(crate) const fn of_entry(entry: &TileEntry, bytes: Vec<u8>) -> Self {
        Self {
            bytes,
            raw_length: entry.raw_length,
            vertex_count: entry.vertex_count,
            z_min: entry.z_min,
            z_max: entry.z_max,
            depth_error: entry.depth_error,
            codec: entry.codec,
            block: entry.block,
            differences: entry.differences,
        }
    }

    /// The same tile of functions whose depths were moved away from the light
    /// by up to `depth_error` before.
    #[must_use]
    pub(crate) fn with_depth_error(mut self, depth_error: f32) -> Self {
        if self.vertex_count > 0 {
            self.depth_error = self.depth_error.max(depth_error);
        }
        self
    }

    /// The same tile of functions whose depths had been moved away from the light by up
    /// to `depth_error` before they were moved again.
    #[must_use]
    pub(crate) fn moved_on(mut self, depth_error: f32) -> Self {
        if self.vertex_count > 0 && depth_error > 0.0 {
            let sum = f64::from(self.depth_error) + f64::from(depth_error);
            let nearest = sum as f32;
            self.depth_error = if f64::from(nearest) < sum { nearest.next_up() } else { nearest };
        }
        self
    }

    /// What the directory says of the tile, wherever it will stand.
    pub(crate) fn entry(&self) -> TileEntry {
        TileEntry {
            raw_length: self.raw_length,
            vertex_count: self.vertex_count,
            z_min: self.z_min,
            z_max: self.z_max,
            depth_error: self.depth_error,
            codec: self.codec,
            block: self.block,
            differences: self.differences,
            ..TileEntry::default()
        }
    }
}
