//! Packing the bytes of deep chunks: what `unpack.rs` unpacks.

use miniz_oxide::deflate::core::{
    CompressorOxide, TDEFLFlush, TDEFLStatus, compress, create_comp_flags_from_zip_params,
};

use super::packing::Packing;
use super::zstd::{self, SampleGrid};

/// Deflate's effort, 0 to 10: the default of the format's own library.
const LEVEL: i32 = 4;

/// A positive window asks for a zlib stream.
const ZLIB: i32 = 15;

/// Packs bytes, in buffers that are kept.
pub(crate) struct Packer {
    packing: Packing,
    compressor: Box<CompressorOxide>,
    predicted: Vec<u8>,
    packed: Vec<u8>,
}

impl Packer {
    pub(crate) fn new(packing: Packing) -> Self {
        let flags = create_comp_flags_from_zip_params(LEVEL, ZLIB, 0);
        Self {
            packing,
            compressor: Box::new(CompressorOxide::new(flags)),
            predicted: Vec::new(),
            packed: Vec::new(),
        }
    }

    /// What a file stores for `bytes`, which `grid` tells of: they themselves where
    /// they do not shrink.
    pub(crate) fn pack<'a>(&'a mut self, bytes: &'a [u8], grid: &SampleGrid<'_>) -> &'a [u8] {
        if bytes.is_empty() || self.packing == Packing::None {
            return bytes;
        }
        if self.packing == Packing::Zstd {
            self.packed.clear();
            zstd::pack(bytes, grid, &mut self.packed);
            return if self.packed.len() < bytes.len() { &self.packed } else { bytes };
        }
        predict(bytes, &mut self.predicted);
        self.packed.clear();
        let shrunk = if self.packing == Packing::Rle {
            pack_rle(&self.predicted, &mut self.packed);
            self.packed.len() < bytes.len()
        } else {
            self.deflate(bytes.len())
        };
        if shrunk { &self.packed } else { bytes }
    }

    /// Whether the stream has fewer than `length` bytes.
    fn deflate(&mut self, length: usize) -> bool {
        self.packed.resize(length - 1, 0);
        self.compressor.reset();
        let (status, _, written) =
            compress(&mut self.compressor, &self.predicted, &mut self.packed, TDEFLFlush::Finish);
        self.packed.truncate(written);
        status == TDEFLStatus::Done
    }
}

/// All bytes at even places, then those at odd ones, each less the one before
/// it, plus 128.
fn predict(bytes: &[u8], predicted: &mut Vec<u8>) {
    predicted.clear();
    predicted.extend(bytes.iter().step_by(2));
    predicted.extend(bytes.iter().skip(1).step_by(2));
    let mut before = 128;
    for byte in predicted {
        let value = *byte;
        *byte = value.wrapping_sub(before).wrapping_add(128);
        before = value;
    }
}

/// The longest run of one byte, and of bytes that differ.
const LONGEST_RUN: usize = 128;
const LONGEST_LITERAL: usize = 127;

/// Shorter runs are cheaper among the bytes that differ.
const SHORTEST_RUN: usize = 3;

fn pack_rle(bytes: &[u8], packed: &mut Vec<u8>) {
    let run_at = |start: usize| {
        let same = bytes[start..].iter().take(LONGEST_RUN);
        same.take_while(|&&byte| byte == bytes[start]).count()
    };
    let mut start = 0;
    while start < bytes.len() {
        let run = run_at(start);
        if run >= SHORTEST_RUN {
            packed.extend([(run - 1) as u8, bytes[start]]);
            start += run;
            continue;
        }
        let most = bytes.len().min(start + LONGEST_LITERAL);
        let end = (start + 1..most).find(|&next| run_at(next) >= SHORTEST_RUN).unwrap_or(most);
        packed.push((256 - (end - start)) as u8);
        packed.extend(&bytes[start..end]);
        start = end;
    }
}

#[cfg(test)]
mod tests {
    use super::super::unpack::Unpacker;
    use super::*;

    /// Only ZSTD asks for one.
    const NO_GRID: SampleGrid<'static> = SampleGrid { row_samples: &[], channel_words: &[] };

    /// Runs and noise, of all lengths that the packers treat differently.
    fn samples() -> Vec<Vec<u8>> {
        let mut state = 1_u32;
        let mut noise = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        let mut all = vec![Vec::new(), vec![7; 2], vec![3; 4096]];
        for length in [2, 4, 126, 128, 130, 254, 256, 1024] {
            all.push((0..length).map(|_| noise()).collect());
            all.push((0..length).map(|i| if i % 64 < 40 { 9 } else { noise() }).collect());
            all.push((0..length).map(|i| (i / 2 % 5) as u8).collect());
        }
        all
    }

    #[test]
    fn what_is_packed_is_unpacked() {
        for packing in [Packing::None, Packing::Rle, Packing::Zips, Packing::Zstd] {
            let mut packer = Packer::new(packing);
            let mut unpacker = Unpacker::default();
            for bytes in samples() {
                let rows = [bytes.len() as u32 / 2];
                let grid = SampleGrid { row_samples: &rows, channel_words: &[1] };
                let packed = packer.pack(&bytes, &grid);
                assert!(packed.len() <= bytes.len());
                let words =
                    unpacker.unpack(packing, packed, bytes.len(), bytes.len(), &grid).unwrap();
                let unpacked: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
                assert_eq!(unpacked, bytes, "{packing:?}, {} bytes", bytes.len());
            }
        }
    }

    #[test]
    fn what_is_alike_shrinks_and_noise_stays() {
        let [alike, noise] = [samples().swap_remove(2), samples().swap_remove(24)];
        for (packing, most) in [(Packing::Rle, 80), (Packing::Zips, 40)] {
            let mut packer = Packer::new(packing);
            assert!(packer.pack(&alike, &NO_GRID).len() < most);
            assert_eq!(packer.pack(&noise, &NO_GRID).len(), noise.len());
        }
        assert_eq!(Packer::new(Packing::None).pack(&alike, &NO_GRID), alike);
    }
}
