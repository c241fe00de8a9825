//! What turns chunks into columns.

use super::chunk::{ChunkTable, DeepChunk};
use super::readable_part::ReadablePart;
use super::source::ByteSource;
use crate::codec::unpack::Unpacker;
use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::rows::DeepRows;

/// What turns chunks into columns.
pub(super) struct Decoder {
    pub(super) source: ByteSource,
    pub(super) part: ReadablePart,
    pub(super) table: ChunkTable,
    pub(super) limits: Limits,
    pub(super) unpacker: Unpacker,
    pub(super) chunks: Vec<DeepChunk>,
}

impl Decoder {
    /// Compares what an answer will take with the limit.
    pub(super) fn check_answer(
        &self,
        out: &DeepRows,
        more_pixels: usize,
        more_samples: u64,
    ) -> Result<()> {
        let pixels = (out.pixel_count() + more_pixels) as u64;
        let samples = out.sample_count() as u64 + more_samples;
        let bytes = 4 * pixels + samples * out.sample_bytes();
        if bytes <= self.limits.max_answer_bytes {
            return Ok(());
        }
        Err(Error::LimitExceeded {
            place: format!("{pixels} pixels with {samples} samples"),
            what: "length of one answer in bytes (ask for fewer rows)",
            value: bytes,
            limit: self.limits.max_answer_bytes,
        })
    }
}
