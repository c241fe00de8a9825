//! Compressed columns: LZ4 blocks, and integers as differences in few bits.

use super::cursor::Cursor;
use crate::error::Result;

/// No LZ4 block grows by more.
const MOST_GROWTH: u64 = 255;

/// Unpacks chunks of LZ4 blocks into `size` bytes at most.
pub(super) fn unpack(cursor: &mut Cursor<'_>, packed: u64, size: u64) -> Result<Vec<u8>> {
    let start = *cursor;
    let bytes = cursor.take(packed)?;
    let size = size.min(packed.saturating_mul(MOST_GROWTH)) as usize;
    let broken = || start.error("a compressed block is broken");
    let (&chunks, mut rest) = bytes.split_first().ok_or_else(broken)?;
    let mut unpacked = vec![0; size];
    let mut filled = 0;
    if chunks == 0 {
        filled = lz4_flex::block::decompress_into(rest, &mut unpacked).map_err(|_| broken())?;
    }
    for _ in 0..chunks {
        let (length, after) = rest.split_first_chunk::<4>().ok_or_else(broken)?;
        let length = u32::from_le_bytes(*length) as usize;
        let (chunk, after) = after.split_at_checked(length).ok_or_else(broken)?;
        let room = &mut unpacked[filled..];
        filled += lz4_flex::block::decompress_into(chunk, room).map_err(|_| broken())?;
        rest = after;
    }
    unpacked.truncate(filled);
    Ok(unpacked)
}

/// The width of an integer in bytes, 4 or 8.
pub(super) type Width = usize;

/// `count` integers: a commonest difference, two bits a difference that say how many
/// bytes it has, and those. Numbers of 4 bytes wrap around as such.
pub(super) fn integers(cursor: &mut Cursor<'_>, count: u64, width: Width) -> Result<Vec<i64>> {
    let packed = cursor.u64()?;
    let start = *cursor;
    let broken = || start.error("compressed integers are broken");
    // Four differences a byte of codes, that of LZ4 at best.
    if count > packed.saturating_mul(4 * MOST_GROWTH) {
        return Err(broken());
    }
    let size = count.saturating_mul(width as u64 + 1).saturating_add(width as u64 + 1);
    let bytes = unpack(cursor, packed, size)?;
    let count = count as usize;
    let (common, rest) = bytes.split_at_checked(width).ok_or_else(broken)?;
    let (codes, mut rest) = rest.split_at_checked(count.div_ceil(4)).ok_or_else(broken)?;
    let common = signed(common);
    let mut all = Vec::with_capacity(count);
    let mut value = 0_i64;
    for index in 0..count {
        let code = codes[index / 4] >> (index % 4 * 2) & 3;
        let difference = if code == 0 {
            common
        } else {
            let size = (width / 4) << (code - 1);
            let (number, after) = rest.split_at_checked(size).ok_or_else(broken)?;
            rest = after;
            signed(number)
        };
        value = value.wrapping_add(difference);
        if width == 4 {
            value = i64::from(value as i32);
        }
        all.push(value);
    }
    Ok(all)
}

/// A signed integer of 1, 2, 4 or 8 bytes.
fn signed(bytes: &[u8]) -> i64 {
    let mut whole = [0; 8];
    whole[8 - bytes.len()..].copy_from_slice(bytes);
    i64::from_le_bytes(whole) >> (64 - 8 * bytes.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(integers: &[u8]) -> Vec<u8> {
        let mut block = vec![0];
        block.extend(lz4_flex::block::compress(integers));
        let mut file = (block.len() as u64).to_le_bytes().to_vec();
        file.extend(block);
        file
    }

    #[test]
    fn differences_have_as_many_bytes_as_they_need() {
        // 123, then steps 1, 1, -100000 (the commonest is 1).
        let mut raw = 1_i32.to_le_bytes().to_vec();
        raw.push(0b11_00_00_01);
        raw.extend(123_i8.to_le_bytes());
        raw.extend((-100_000_i32).to_le_bytes());
        let bytes = file(&raw);
        let mut cursor = Cursor::new(&bytes, 0).unwrap();
        assert_eq!(integers(&mut cursor, 4, 4).unwrap(), [123, 124, 125, -99_875]);
        assert_eq!(cursor.left(), 0);
        for length in 0..bytes.len() {
            assert!(integers(&mut Cursor::new(&bytes[..length], 0).unwrap(), 4, 4).is_err());
        }
        let mut wide = 7_i64.to_le_bytes().to_vec();
        wide.push(0b11_01);
        wide.extend((-2_i16).to_le_bytes());
        wide.extend((1_i64 << 40).to_le_bytes());
        let bytes = file(&wide);
        let found = integers(&mut Cursor::new(&bytes, 0).unwrap(), 2, 8).unwrap();
        assert_eq!(found, [-2, (1 << 40) - 2]);
    }

    #[test]
    fn no_count_takes_memory_that_the_file_has_not() {
        let bytes = file(&[0; 64]);
        for count in [1 << 20, 1 << 40, u64::MAX] {
            assert!(integers(&mut Cursor::new(&bytes, 0).unwrap(), count, 4).is_err());
        }
    }
}
