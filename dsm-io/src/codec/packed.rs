//! Block 1: columns whose bytes are sorted by significance, in a zstd frame.
//!
//! Neighbours in a column have similar high bytes, so a column is stored as
//! four planes, lowest bytes first. Rising columns (pixel tables) are stored
//! as differences to the word before, modulo 2³².

use std::cell::RefCell;

use zstd::bulk::{Compressor, Decompressor};

/// What to do with a column before its bytes are sorted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Prediction {
    /// Store the words.
    None,
    /// Store differences, modulo 2³²; the word before the first is 0.
    Difference,
}

/// zstd's own default; see docs/format for what others gain.
const LEVEL: i32 = 3;

/// Packs columns one after the other.
pub(super) fn pack(columns: &[(&[u32], Prediction)]) -> std::io::Result<Vec<u8>> {
    let words: usize = columns.iter().map(|(column, _)| column.len()).sum();
    let mut planes = vec![0; words * 4];
    let mut rest = planes.as_mut_slice();
    for &(column, prediction) in columns {
        let (this, after) = rest.split_at_mut(column.len() * 4);
        match prediction {
            Prediction::None => shuffle(column.iter().copied(), this),
            Prediction::Difference => {
                let mut before = 0_u32;
                let differences = column
                    .iter()
                    .map(|&word| word.wrapping_sub(std::mem::replace(&mut before, word)));
                shuffle(differences, this);
            }
        }
        rest = after;
    }
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
    columns: [(usize, Prediction); N],
) -> Result<[Vec<u32>; N], &'static str> {
    let length = columns.iter().map(|(length, _)| length * 4).sum();
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
    let mut rest = planes.as_slice();
    Ok(columns.map(|(length, prediction)| {
        let (this, after) = rest.split_at(length * 4);
        rest = after;
        let mut column = unshuffle(this);
        if prediction == Prediction::Difference {
            let mut sum = 0_u32;
            column.iter_mut().for_each(|word| {
                sum = sum.wrapping_add(*word);
                *word = sum;
            });
        }
        column
    }))
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

fn unshuffle(planes: &[u8]) -> Vec<u32> {
    let length = planes.len() / 4;
    let (low, high) = planes.split_at(length * 2);
    let (first, second) = low.split_at(length);
    let (third, fourth) = high.split_at(length);
    let bytes = first.iter().zip(second).zip(third).zip(fourth);
    bytes.map(|(((&a, &b), &c), &d)| u32::from_le_bytes([a, b, c, d])).collect()
}
