//! Blosc chunks, as OpenVDB writes them: LZ4, with or without shuffled bytes.
//!
//! The layout is that of the Blosc 1 format: a header of 16 bytes, the offset of each
//! block, and blocks of one stream or of one a byte of a value.

use std::borrow::Cow;

use lz4_flex::block::decompress_into;

const HEADER: usize = 16;
const SHUFFLED: u8 = 1;
const COPIED: u8 = 2;
const BIT_SHUFFLED: u8 = 4;
const UNSPLIT: u8 = 16;
/// The format of the streams, in the upper bits of the flags.
const LZ4: u8 = 1;
/// Blocks of values of up to this many bytes, and of this many values at least, have
/// a stream a byte.
const MAX_SPLITS: usize = 16;
const MIN_SPLIT: usize = 128;

/// What is wrong with a chunk.
pub(super) type Fault = Cow<'static, str>;

/// Unpacks a chunk, which has to fill `output`.
pub(super) fn unpack(chunk: &[u8], output: &mut [u8]) -> Result<(), Fault> {
    let wrong = || Fault::from("wrong length of a compressed block");
    let word = |at: usize| -> Option<usize> {
        let bytes = chunk.get(at..at.checked_add(4)?)?.try_into().ok()?;
        usize::try_from(i32::from_le_bytes(bytes)).ok()
    };
    let sizes = (word(4), word(8), word(12));
    let (Some(length), Some(block_size), Some(stored)) = sizes else { return Err(wrong()) };
    if length != output.len() || stored != chunk.len() {
        return Err(wrong());
    }
    let (flags, value_size) = (chunk[2], usize::from(chunk[3]));
    if flags & COPIED != 0 {
        let raw = chunk.get(HEADER..HEADER + length).ok_or_else(wrong)?;
        output.copy_from_slice(raw);
        return Ok(());
    }
    if flags >> 5 != LZ4 {
        return Err(format!("unsupported compression {} in Blosc: only LZ4", flags >> 5).into());
    }
    if flags & BIT_SHUFFLED != 0 {
        return Err("unsupported: bits shuffled in Blosc".into());
    }
    if length == 0 {
        return Ok(());
    }
    // No block is larger than all of them.
    if block_size == 0 || block_size > length {
        return Err(wrong());
    }
    let is_shuffled = flags & SHUFFLED != 0 && value_size > 1;
    let mut shuffled = vec![0; if is_shuffled { block_size } else { 0 }];
    for (index, block) in output.chunks_mut(block_size).enumerate() {
        let whole = block.len() == block_size;
        let is_split = flags & UNSPLIT == 0
            && whole
            && (1..=MAX_SPLITS).contains(&value_size)
            && block_size / value_size >= MIN_SPLIT;
        let streams = if is_split { value_size } else { 1 };
        let mut at = word(HEADER + 4 * index).ok_or_else(wrong)?;
        let unpacked = if is_shuffled { &mut shuffled[..block.len()] } else { &mut *block };
        // What a split leaves over belongs to no stream.
        let part = unpacked.len() / streams;
        if part * streams != unpacked.len() {
            return Err(wrong());
        }
        for stream in unpacked.chunks_mut(part) {
            let size = word(at).ok_or_else(wrong)?;
            let start = at.checked_add(4).ok_or_else(wrong)?;
            at = start.checked_add(size).ok_or_else(wrong)?;
            let packed = chunk.get(start..at).ok_or_else(wrong)?;
            if size == stream.len() {
                stream.copy_from_slice(packed);
            } else if !matches!(decompress_into(packed, stream), Ok(length) if length == stream.len())
            {
                return Err("damaged LZ4 data".into());
            }
        }
        if is_shuffled {
            unshuffle(&shuffled[..block.len()], value_size, block);
        }
    }
    Ok(())
}

/// Puts the bytes of each value together again, of which there is a plane each.
fn unshuffle(planes: &[u8], value_size: usize, values: &mut [u8]) {
    let count = planes.len() / value_size;
    for (byte, plane) in planes.chunks_exact(count.max(1)).take(value_size).enumerate() {
        for (value, &part) in values.chunks_exact_mut(value_size).zip(plane) {
            value[byte] = part;
        }
    }
    let rest = count * value_size;
    values[rest..].copy_from_slice(&planes[rest..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chunk of one block in `value_size` streams, each as it is, shuffled.
    fn chunk(values: &[u8], value_size: usize, is_split: bool) -> Vec<u8> {
        let count = values.len() / value_size;
        let mut planes: Vec<u8> = (0..value_size)
            .flat_map(|byte| (0..count).map(move |value| values[value * value_size + byte]))
            .collect();
        planes.extend(&values[count * value_size..]);
        let flags = (LZ4 << 5) | SHUFFLED | if is_split { 0 } else { UNSPLIT };
        let mut chunk = vec![2, 1, flags, value_size as u8];
        let word = |chunk: &mut Vec<u8>, n: usize| chunk.extend((n as u32).to_le_bytes());
        word(&mut chunk, values.len());
        word(&mut chunk, values.len());
        word(&mut chunk, 0);
        word(&mut chunk, HEADER + 4);
        let streams = if is_split { value_size } else { 1 };
        for stream in planes.chunks(planes.len() / streams) {
            let packed = lz4_flex::block::compress(stream);
            let packed = if packed.len() < stream.len() { &packed } else { stream };
            word(&mut chunk, packed.len());
            chunk.extend(packed);
        }
        let length = (chunk.len() as u32).to_le_bytes();
        chunk[12..16].copy_from_slice(&length);
        chunk
    }

    #[test]
    fn values_come_back_from_each_layout() {
        let values: Vec<u8> = (0..2048_u32).map(|n| (n * n % 251 * (n % 4)) as u8).collect();
        for value_size in [1, 2, 4, 8] {
            for is_split in [false, true] {
                let chunk = chunk(&values, value_size, is_split);
                let mut output = vec![0; values.len()];
                unpack(&chunk, &mut output).unwrap();
                assert_eq!(output, values, "{value_size} {is_split}");
            }
        }
        // A length that is no multiple of the value's.
        let odd = &values[..2047];
        let mut output = vec![0; odd.len()];
        unpack(&chunk(odd, 4, false), &mut output).unwrap();
        assert_eq!(output, odd);
    }

    #[test]
    fn no_length_is_believed() {
        let values: Vec<u8> = (0..2048_u32).map(|n| (n / 7) as u8).collect();
        let chunk = chunk(&values, 4, true);
        let mut output = vec![0; values.len()];
        for length in 0..chunk.len() {
            assert!(unpack(&chunk[..length], &mut output).is_err(), "{length}");
        }
        for at in 0..chunk.len() {
            for flip in [1, 0x80, 0xff] {
                let mut broken = chunk.clone();
                broken[at] ^= flip;
                let _ = unpack(&broken, &mut output);
            }
        }
        let _ = unpack(&chunk, &mut output[..2000]).unwrap_err();
    }
}
