//! Block 1: columns whose bytes are sorted by significance, in a zstd frame.
//!
//! Neighbours in a column have similar high bytes, so a column is stored as
//! four planes, lowest bytes first. A column may be stored as differences to
//! the word before, modulo 2³²; the word before the first is 0.

use std::cell::RefCell;

use zstd::bulk::{Compressor, Decompressor};

/// Level 3 makes maps of hair 1 to 4 % smaller and takes three times as long.
const LEVEL: i32 = 1;

/// Which columns of a block are stored as differences: bit i for column i.
pub(super) type Differences = u8;

/// Whether differences pack better than words. They do where many words
/// repeat the one before: the depths of steps (two vertices each) and the
/// values between them. Elsewhere they spread the bits of rounded floats.
pub(super) fn should_difference(column: &[u32]) -> bool {
    let repeated = column.windows(2).filter(|pair| pair[0] == pair[1]).count();
    repeated * 4 >= column.len()
}

const fn is_difference(differences: Differences, column: usize) -> bool {
    differences >> column & 1 == 1
}

/// Packs columns one after the other.
pub(super) fn pack<'a>(
    columns: impl Iterator<Item = &'a [u32]> + Clone,
    differences: Differences,
) -> std::io::Result<Vec<u8>> {
    let words: usize = columns.clone().map(<[u32]>::len).sum();
    let mut planes = vec![0; words * 4];
    let mut rest = planes.as_mut_slice();
    for (index, column) in columns.enumerate() {
        let (this, after) = rest.split_at_mut(column.len() * 4);
        rest = after;
        if is_difference(differences, index) {
            let before = std::iter::once(&0).chain(column);
            shuffle(
                column.iter().zip(before).map(|(word, before)| word.wrapping_sub(*before)),
                this,
            );
        } else {
            shuffle(column.iter().copied(), this);
        }
    }
    // A new one for every tile: what it packed before must not show in the
    // bytes, whichever thread packs which tile.
    Compressor::new(LEVEL)?.compress(&planes)
}

thread_local! {
    /// A decompressor's tables are large next to a tile: each thread keeps one.
    static DECOMPRESSOR: RefCell<Option<Decompressor<'static>>> = const { RefCell::new(None) };
}

/// Unpacks columns of these lengths in words; why not, if the bytes are not
/// one frame that holds exactly them.
pub(super) fn unpack<const N: usize>(
    packed: &[u8],
    lengths: [usize; N],
    differences: Differences,
) -> Result<[Vec<u32>; N], &'static str> {
    if differences >> N != 0 {
        return Err("there are fewer columns than stored as differences");
    }
    let planes = unpack_planes(packed, lengths.iter().sum::<usize>() * 4)?;
    let mut rest = planes.as_slice();
    let mut index = 0;
    Ok(lengths.map(|length| {
        let (this, after) = rest.split_at(length * 4);
        rest = after;
        index += 1;
        unshuffle(this, is_difference(differences, index - 1))
    }))
}

/// Unpacks the planes of all columns, `length` bytes; why not, if the bytes are
/// not one frame that holds exactly them.
pub(super) fn unpack_planes(packed: &[u8], length: usize) -> Result<Vec<u8>, &'static str> {
    if zstd::zstd_safe::find_frame_compressed_size(packed) != Ok(packed.len()) {
        return Err("it is not exactly one zstd frame");
    }
    let mut planes = Vec::new();
    planes.try_reserve_exact(length).map_err(|_| "there is no memory for it")?;
    let unpacked = DECOMPRESSOR.with_borrow_mut(|slot| {
        let decompressor = match slot {
            Some(decompressor) => decompressor,
            None => slot.insert(Decompressor::new()?),
        };
        decompressor.decompress_to_buffer(packed, &mut planes)
    });
    if unpacked.map_err(|_| "its zstd frame is damaged or larger than stated")? != length {
        return Err("its zstd frame is smaller than stated");
    }
    Ok(planes)
}

fn shuffle(words: impl Iterator<Item = u32>, planes: &mut [u8]) {
    let length = planes.len() / 4;
    let (low, high) = planes.split_at_mut(length * 2);
    let (first, second) = low.split_at_mut(length);
    let (third, fourth) = high.split_at_mut(length);
    for ((((word, a), b), c), d) in words.zip(first).zip(second).zip(third).zip(fourth) {
        [*a, *b, *c, *d] = word.to_le_bytes();
    }
}

/// The words of a column from its planes.
pub(super) fn unshuffle(planes: &[u8], is_difference: bool) -> Vec<u32> {
    let length = planes.len() / 4;
    let (low, high) = planes.split_at(length * 2);
    let (first, second) = low.split_at(length);
    let (third, fourth) = high.split_at(length);
    let bytes = first.iter().zip(second).zip(third).zip(fourth);
    let words = bytes.map(|(((&a, &b), &c), &d)| u32::from_le_bytes([a, b, c, d]));
    let mut column: Vec<u32> = words.collect();
    if is_difference {
        let mut sum = 0_u32;
        column.iter_mut().for_each(|word| {
            sum = sum.wrapping_add(*word);
            *word = sum;
        });
    }
    column
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns of a length that no vector width divides.
    fn columns() -> [Vec<u32>; 3] {
        let noise = |index: u32| index.wrapping_mul(0x9e37_79b9).rotate_left(index);
        [
            (0..1003).map(|index| index * 7).collect(),
            (0..517).map(noise).collect(),
            vec![0xffff_fff0, 3, 3],
        ]
    }

    #[test]
    fn columns_come_back_whichever_are_differences() {
        let columns = columns();
        let lengths = columns.each_ref().map(Vec::len);
        for differences in 0..8 {
            let packed = pack(columns.iter().map(Vec::as_slice), differences).unwrap();
            assert_eq!(unpack(&packed, lengths, differences).unwrap(), columns, "{differences:b}");
        }
        assert!(unpack(&[], lengths, 8).is_err());
    }

    #[test]
    fn planes_are_as_the_format_says() {
        let packed = pack([&[0x0403_0201, 0x0807_0605][..], &[], &[]].into_iter(), 1).unwrap();
        let planes = zstd::bulk::decompress(&packed, 8).unwrap();
        assert_eq!(planes, [1, 4, 2, 4, 3, 4, 4, 4]);
    }

    #[test]
    fn only_one_frame_of_the_stated_length_is_taken() {
        let packed = pack([[7; 100].as_slice()].into_iter(), 0).unwrap();
        assert!(unpack(&packed, [100], 0).is_ok());
        assert!(unpack(&packed, [99], 0).is_err());
        assert!(unpack(&packed, [101], 0).is_err());
        let [first, second] = [60, 40].map(|length| {
            let column = vec![7; length];
            pack([column.as_slice()].into_iter(), 0).unwrap()
        });
        assert!(unpack(&[first, second].concat(), [100], 0).is_err());
        // A skippable frame before it.
        let hidden = [b"\x50\x2a\x4d\x18\x01\0\0\0!".as_slice(), &packed].concat();
        assert!(unpack(&hidden, [100], 0).is_err());
    }

    #[test]
    fn steps_are_worth_differences() {
        assert!(should_difference(&[1, 1, 2, 2, 3, 3, 4, 4]));
        assert!(!should_difference(&[1, 2, 2, 3, 4, 5, 6, 7]));
    }
}
