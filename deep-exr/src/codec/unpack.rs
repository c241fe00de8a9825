//! Unpacking the bytes of deep chunks.
//!
//! The `exr` crate's own codecs for these are private and allocate on every
//! chunk; the formats are small (OpenEXR file layout, "Predictor", "RLE").

use fdeflate::Decompressor;

use super::packing::Packing;
use super::zstd::{self, SampleGrid};

/// Unpacks into 16-bit words, in buffers that are kept.
#[derive(Default)]
pub(crate) struct Unpacker {
    bytes: Vec<u8>,
    words: Vec<u16>,
}

impl Unpacker {
    /// The words that `packed` stands for. They are `size` bytes, as `grid` has them,
    /// or `whole_size` (some writers store the table of a cut tile whole).
    /// Both are even, and the caller has compared them with the limits.
    pub(crate) fn unpack(
        &mut self,
        packing: Packing,
        packed: &[u8],
        size: usize,
        whole_size: usize,
        grid: &SampleGrid<'_>,
    ) -> Result<&[u16], String> {
        // Chunks that do not shrink are stored as they are.
        if packed.len() == size || packed.len() == whole_size {
            let words = grown(&mut self.words, packed.len() / 2);
            for (word, &pair) in words.iter_mut().zip(packed.as_chunks::<2>().0) {
                *word = u16::from_le_bytes(pair);
            }
            return Ok(words);
        }
        if size as u64 > (packed.len() as u64).saturating_mul(packing.expansion()) {
            return Err(format!("{} bytes cannot stand for {size}", packed.len()));
        }
        if packing == Packing::Zstd {
            if grid.total_words() * 2 != size {
                return Err(format!("{} values, in {size} bytes", grid.total_words()));
            }
            let words = grown(&mut self.words, size / 2);
            zstd::unpack(packed, grid, &mut self.bytes, words)?;
            return Ok(words);
        }
        let whole_size = whole_size.max(size);
        let room = whole_size as u64;
        let room = room.min((packed.len() as u64).saturating_mul(packing.expansion()) + 2) as usize;
        let bytes = grown(&mut self.bytes, room & !1);
        let unpacked = match packing {
            Packing::Rle => unpack_rle(packed, bytes)?,
            Packing::Zips => inflate(packed, bytes)?,
            Packing::None | Packing::Zstd | Packing::Flat(_) => 0,
        };
        if unpacked != size && unpacked != whole_size {
            return Err(format!(
                "{} bytes of {} unpack to {unpacked}, not {size}",
                packed.len(),
                packing.name()
            ));
        }
        let bytes = &mut bytes[..unpacked];
        undo_predictor(bytes);
        let (first, second) = bytes.split_at(unpacked / 2);
        let words = grown(&mut self.words, unpacked / 2);
        for ((word, &low), &high) in words.iter_mut().zip(first).zip(second) {
            *word = u16::from_le_bytes([low, high]);
        }
        Ok(words)
    }
}

/// The first `length` of a buffer that only grows.
fn grown<T: Copy + Default>(buffer: &mut Vec<T>, length: usize) -> &mut [T] {
    if buffer.len() < length {
        buffer.resize(length, T::default());
    }
    &mut buffer[..length]
}

fn inflate(packed: &[u8], bytes: &mut [u8]) -> Result<usize, String> {
    let mut inflater = Decompressor::new();
    let (read, mut unpacked) = inflater
        .read(packed, bytes, 0, true)
        .map_err(|error| format!("malformed zlib stream: {error:?}"))?;
    if !inflater.is_done() && unpacked == bytes.len() {
        // Full to the brim: what follows may only be the end of the stream.
        let more = inflater.read(&packed[read..], bytes, unpacked, true);
        unpacked += more.map_err(|error| format!("malformed zlib stream: {error:?}"))?.1;
    }
    if inflater.is_done() {
        Ok(unpacked)
    } else {
        Err(format!("zlib stream goes on after {unpacked} bytes"))
    }
}

/// A control byte n ≥ 0 repeats the next byte n + 1 times; n < 0 copies the
/// next −n bytes.
fn unpack_rle(mut packed: &[u8], bytes: &mut [u8]) -> Result<usize, String> {
    let mut unpacked = 0;
    while let Some((&control, rest)) = packed.split_first() {
        let literal = control > 127;
        let (taken, length) = if literal {
            let length = 256 - usize::from(control);
            (length, length)
        } else {
            (1, usize::from(control) + 1)
        };
        let (Some(source), Some(target)) =
            (rest.get(..taken), bytes.get_mut(unpacked..unpacked + length))
        else {
            return Err(format!("malformed run after {unpacked} bytes"));
        };
        if literal {
            target.copy_from_slice(source);
        } else {
            target.fill(source[0]);
        }
        unpacked += length;
        packed = &rest[taken..];
    }
    Ok(unpacked)
}

/// Turns differences into values: byte i becomes the sum of the bytes up to
/// it, less 128 i.
///
/// Eight bytes at a time, with the sums of the even and of the odd bytes in
/// 16-bit lanes; less 128 i is a flipped top bit wherever i is odd.
fn undo_predictor(bytes: &mut [u8]) {
    const EVEN: u64 = 0x00ff_00ff_00ff_00ff;
    const ONES: u64 = 0x0001_0001_0001_0001;
    const ODD_TOP_BITS: u64 = 0x8000_8000_8000_8000;
    let mut carry = 0_u64;
    let (words, rest) = bytes.as_chunks_mut::<8>();
    for word in words {
        let value = u64::from_le_bytes(*word);
        let even = (value & EVEN).wrapping_mul(ONES);
        let odd = ((value >> 8) & EVEN).wrapping_mul(ONES);
        let both = even.wrapping_add(odd);
        let carries = carry.wrapping_mul(ONES);
        let at_even = even.wrapping_add(odd << 16).wrapping_add(carries) & EVEN;
        let at_odd = both.wrapping_add(carries) & EVEN;
        *word = ((at_even | (at_odd << 8)) ^ ODD_TOP_BITS).to_le_bytes();
        carry = (carry + (both >> 48)) & 0xff;
    }
    let mut sum = carry as u8;
    for (index, byte) in rest.iter_mut().enumerate() {
        sum = sum.wrapping_add(*byte);
        *byte = if index % 2 == 1 { sum ^ 0x80 } else { sum };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Only ZSTD asks for one.
    const NO_GRID: SampleGrid<'static> = SampleGrid { row_samples: &[], channel_words: &[] };

    fn pseudo_random(length: usize) -> Vec<u8> {
        let mut state = 0x9e37_79b9_u32;
        let next = |_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        (0..length).map(next).collect()
    }

    #[test]
    fn the_predictor_is_a_running_sum() {
        for length in 0..67 {
            let mut bytes = pseudo_random(length);
            let mut expected = bytes.clone();
            for i in 1..length {
                expected[i] = expected[i].wrapping_add(expected[i - 1]).wrapping_sub(128);
            }
            undo_predictor(&mut bytes);
            assert_eq!(bytes, expected, "{length} bytes");
        }
    }

    #[test]
    fn runs_and_literals() {
        let mut bytes = [0; 8];
        assert_eq!(unpack_rle(&[2, 7, 254, 1, 9, 0, 4], &mut bytes), Ok(6));
        assert_eq!(bytes[..6], [7, 7, 7, 1, 9, 4]);
        assert!(unpack_rle(&[8, 7], &mut bytes).is_err(), "longer than the room");
        assert!(unpack_rle(&[254, 7], &mut bytes).is_err(), "literals missing");
        assert!(unpack_rle(&[3], &mut bytes).is_err(), "value missing");
    }

    /// Differences from `values`, low bytes first: what a writer stores.
    fn predicted(values: &[u8]) -> Vec<u8> {
        let split: Vec<u8> =
            values.iter().step_by(2).chain(values.iter().skip(1).step_by(2)).copied().collect();
        let before = std::iter::once(128).chain(split.iter().copied());
        split.iter().zip(before).map(|(&v, b)| v.wrapping_sub(b).wrapping_add(128)).collect()
    }

    #[test]
    fn zips_round_trip_and_size_checks() {
        let values = [pseudo_random(64), vec![3; 936]].concat();
        let packed = fdeflate::compress_to_vec(&predicted(&values));
        let words: Vec<u16> =
            values.chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
        let mut unpacker = Unpacker::default();
        let size = values.len();
        assert_eq!(unpacker.unpack(Packing::Zips, &packed, size, size, &NO_GRID), Ok(&words[..]));
        assert_eq!(unpacker.unpack(Packing::Zips, &packed, 500, size, &NO_GRID), Ok(&words[..]));
        for wrong in [size - 2, size + 2] {
            assert!(
                unpacker.unpack(Packing::Zips, &packed, wrong, wrong, &NO_GRID).is_err(),
                "{wrong}"
            );
        }
        assert!(unpacker.unpack(Packing::Rle, &packed, size, size, &NO_GRID).is_err());
        assert!(unpacker.unpack(Packing::None, &packed, size, size, &NO_GRID).is_err());
        assert_eq!(unpacker.unpack(Packing::None, &values, size, size, &NO_GRID), Ok(&words[..]));
        let cut = &packed[..packed.len() - 5];
        assert!(unpacker.unpack(Packing::Zips, cut, size, size, &NO_GRID).is_err());
    }

    #[test]
    fn sizes_that_cannot_be_are_refused_before_memory_is_taken() {
        let mut unpacker = Unpacker::default();
        let size = 1 << 40;
        assert!(unpacker.unpack(Packing::Zips, &[0x78, 0x9c, 3, 0], size, size, &NO_GRID).is_err());
        assert!(unpacker.bytes.is_empty() && unpacker.words.is_empty());
    }
}
