//! Columns of 32-bit words, little endian in the file.

use std::borrow::Cow;

/// The words in these bytes, whose length is a multiple of four: in place
/// where the processor's order and the alignment allow, else copied.
pub(super) fn from_bytes(bytes: &[u8]) -> Cow<'_, [u32]> {
    if cfg!(target_endian = "little")
        && let Ok(words) = bytemuck::try_cast_slice(bytes)
    {
        return Cow::Borrowed(words);
    }
    let words = bytes
        .chunks_exact(4)
        .map(|word| u32::from_le_bytes(std::array::from_fn(|index| word[index])));
    Cow::Owned(words.collect())
}

/// The words of a payload, in place where they lie in memory that stays.
pub(super) fn from_payload(payload: Cow<'_, [u8]>) -> Cow<'_, [u32]> {
    match payload {
        Cow::Borrowed(bytes) => from_bytes(bytes),
        Cow::Owned(bytes) => Cow::Owned(from_bytes(&bytes).into_owned()),
    }
}

/// Appends the words of a column.
pub(super) fn append(column: &[u32], bytes: &mut Vec<u8>) {
    if cfg!(target_endian = "little") {
        bytes.extend_from_slice(bytemuck::cast_slice(column));
    } else {
        bytes.extend(column.iter().flat_map(|word| word.to_le_bytes()));
    }
}
