//! Codec 1: depths and values that lie on grids, as small numbers.
//!
//! Nothing is rounded here: whoever compressed the functions did that. Depths
//! are written by the bits of their `f32` that are not zero in all of them,
//! values as multiples of a power of two; each as the change from the vertex
//! before, which is never negative within a pixel. What lies on no grid is left
//! to codec 0.

use dsm_core::Transmittance;
use dsm_core::detail::{PixelLists, PixelListsView};

use super::exact::{column_lengths, depth_range};
use super::packed::unpack;
use super::stored_tile::StoredTile;
use super::tile_columns::{TileColumn, mono_flags};
use super::{Codec, Packing, exact, words};
use crate::error::{Error, Result};
use crate::format::encoded_tile::EncodedTile;
use crate::tile::Tile;

/// The most bits behind the point that a value may have: an `f32` in (½, 1]
/// has no more.
const MOST_VALUE_BITS: u32 = 24;

/// The most bits of a depth that may be zero: the mantissa's.
const MOST_DEPTH_ZEROS: u32 = 23;

/// The grids of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Grids {
    /// Low bits of a depth that are zero.
    depth_zeros: u32,
    /// Bits of a value behind the point.
    value_bits: u32,
}

impl Grids {
    /// The coarsest grids on which all vertices lie; none if values are finer
    /// than any.
    fn of<T: Transmittance>(pixels: PixelListsView<'_, T>) -> Option<Self> {
        let depths = pixels.depths().iter().fold(0, |all, z| all | z.to_bits());
        let scale = f32::from_bits((127 + MOST_VALUE_BITS) << 23);
        let mut multiples = 1 << MOST_VALUE_BITS;
        for value in pixels.values() {
            let multiple = value * scale;
            if multiple.fract() != 0.0 {
                return None;
            }
            multiples |= multiple as u32;
        }
        Some(Self {
            depth_zeros: depths.trailing_zeros().min(MOST_DEPTH_ZEROS),
            value_bits: MOST_VALUE_BITS - multiples.trailing_zeros(),
        })
    }

    const fn header(self) -> u32 {
        self.depth_zeros | self.value_bits << 8
    }

    const fn from_header(word: u32) -> Option<Self> {
        let (depth_zeros, value_bits) = (word & 0xff, word >> 8);
        if depth_zeros <= MOST_DEPTH_ZEROS && value_bits <= MOST_VALUE_BITS {
            Some(Self { depth_zeros, value_bits })
        } else {
            None
        }
    }

    /// The value 1.
    const fn one(self) -> u32 {
        1 << self.value_bits
    }

    fn value_code(self, value: f32) -> u32 {
        (value * self.one() as f32) as u32
    }

    fn value(self, code: u32) -> f32 {
        // At most 24 bits over a power of two.
        code as f32 / self.one() as f32
    }
}

/// Numbers of either sign as small ones: 0, −1, 1, −2, 2 …
const fn zigzag(change: u32) -> u32 {
    let change = change.cast_signed();
    ((change << 1) ^ (change >> 31)).cast_unsigned()
}

const fn from_zigzag(code: u32) -> u32 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}

/// Hands the values of each pixel's each channel to `run`.
fn value_runs(starts: &[u32], value_starts: &[u32], mut run: impl FnMut(std::ops::Range<usize>)) {
    for (index, pair) in starts.windows(2).enumerate() {
        let vertices = pair[1].saturating_sub(pair[0]) as usize;
        if vertices == 0 {
            continue;
        }
        let (first, last) = if value_starts.is_empty() {
            (pair[0] as usize, pair[1] as usize)
        } else {
            (value_starts[index] as usize, value_starts[index + 1] as usize)
        };
        (first..last).step_by(vertices).for_each(|at| run(at..(at + vertices).min(last)));
    }
}

pub(super) fn encode<T: Transmittance>(
    pixels: PixelListsView<'_, T>,
    packing: Packing,
) -> Result<EncodedTile> {
    if pixels.vertex_count() == 0 {
        return Ok(EncodedTile::default());
    }
    let Some(grids) = Grids::of(pixels) else { return exact::encode(pixels, packing) };
    let mut depths = Vec::with_capacity(pixels.depths().len());
    let mut first_before = 0_u32;
    for pair in pixels.starts().windows(2) {
        let mut before = None;
        for z in &pixels.depths()[pair[0] as usize..pair[1] as usize] {
            // −0 counts as 0.
            let code = (z + 0.0).to_bits() >> grids.depth_zeros;
            depths.push(match before.replace(code) {
                Some(before) => code - before,
                None => zigzag(code.wrapping_sub(std::mem::replace(&mut first_before, code))),
            });
        }
    }
    let mut values = vec![0; pixels.values().len()];
    value_runs(pixels.starts(), pixels.value_starts(), |run| {
        let mut before = grids.one();
        for (code, &value) in values[run.clone()].iter_mut().zip(&pixels.values()[run]) {
            let value = grids.value_code(value);
            *code = before - value;
            before = value;
        }
    });
    let header = [grids.header()];
    let mut flags = Vec::new();
    let [starts, value_starts, flags, ..] = TileColumn::of_functions(pixels, &mut flags);
    // Differences already, and small.
    let words = TileColumn::flags;
    let columns = [words(&header), starts, value_starts, flags, words(&depths), words(&values)];
    let count = pixels.vertex_count() as u64;
    let tile = EncodedTile::of_columns(&columns, count, depth_range(pixels), packing)?;
    Ok(EncodedTile { codec: Codec::Quantized.tag(), ..tile })
}

/// Decodes a payload whose checksum was found right.
pub(crate) fn decode<T: Transmittance>(stored: StoredTile<'_>) -> Result<Tile<'static, T>> {
    let place = stored.place;
    let refuse = |reason: &'static str| Error::invalid(place, reason);
    let others = stored.entry.raw_length.checked_sub(4);
    let others = others.ok_or_else(|| refuse("it has no header"))?;
    let [starts, value_starts, flags, depths, values] =
        column_lengths(&stored, others, T::CHANNELS)?;
    let StoredTile { payload, entry, rect, .. } = stored;
    let lengths = [1, starts, value_starts, flags, depths, values];
    let columns = match Packing::from_tag(entry.block) {
        Some(Packing::Plain) => {
            if payload.len() as u64 != entry.raw_length || entry.differences != 0 {
                return Err(refuse("a plain tile is as long as its columns and stores words"));
            }
            exact::split(&words::from_bytes(&payload), lengths).map(<[u32]>::to_vec)
        }
        Some(Packing::Zstd) => unpack(&payload, lengths, entry.differences).map_err(refuse)?,
        None => {
            return Err(Error::Unsupported { place, what: format!("block {}", entry.block) });
        }
    };
    let [header, starts, value_starts, flags, mut depths, mut values] = columns;
    let grids = header.first().copied().and_then(Grids::from_header);
    let grids = grids.ok_or_else(|| refuse("its header names no grids"))?;
    let covers = |starts: &[u32], column: &[u32]| {
        let ordered = starts.is_sorted() && starts.first() == Some(&0);
        ordered && starts.last().map(|&last| last as usize) == Some(column.len())
    };
    if !covers(&starts, &depths) || T::CHANNELS > 1 && !covers(&value_starts, &values) {
        return Err(refuse("its pixel tables do not cover its columns"));
    }
    restore_depths(grids, &starts, &mut depths).map_err(refuse)?;
    let mut below = false;
    value_runs(&starts, &value_starts, |run| {
        let mut value = grids.one();
        for code in &mut values[run] {
            below |= *code > value;
            value = value.wrapping_sub(*code);
            *code = grids.value(value).to_bits();
        }
    });
    if below {
        return Err(refuse("a value falls below 0"));
    }
    let real = |bits: Vec<u32>| bits.into_iter().map(f32::from_bits).collect();
    let size = (rect.width, rect.height);
    let pixels = PixelLists::new(size, starts, value_starts, real(depths), real(values))
        .map_err(|error| Error::Function { place, error })?;
    if T::CHANNELS > 1 && mono_flags(pixels.view()) != flags {
        return Err(refuse("its mono flags do not fit its pixel tables"));
    }
    if depth_range(pixels.view()) != [entry.z_min, entry.z_max] {
        return Err(refuse("its depths are not the range that its directory entry states"));
    }
    Ok(Tile::Owned(pixels))
}

/// Turns changes of depth into the bits of depths.
fn restore_depths(
    grids: Grids,
    starts: &[u32],
    depths: &mut [u32],
) -> std::result::Result<(), &'static str> {
    let most = f32::MAX.to_bits() >> grids.depth_zeros;
    let mut first_before = 0_u32;
    let mut outside = false;
    for pair in starts.windows(2) {
        let mut before = None;
        for word in &mut depths[pair[0] as usize..pair[1] as usize] {
            let code = match before {
                // Saturates past the largest.
                Some(before) => word.saturating_add(before),
                None => {
                    first_before = first_before.wrapping_add(from_zigzag(*word));
                    first_before
                }
            };
            outside |= code > most;
            before = Some(code);
            *word = code.min(most) << grids.depth_zeros;
        }
    }
    if outside { Err("a depth is none that a vertex can have") } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::*;
    use crate::error::Place;
    use crate::tile_id::TileRect;
    use dsm_core::{PixelListsBuilder, Rgb, Vertex};

    fn rect(width: u32) -> TileRect {
        TileRect { x: 0, y: 0, width, height: 1 }
    }

    fn tile<T: Transmittance>(pixels: &[&[(f32, T)]]) -> PixelLists<T> {
        let mut builder = PixelListsBuilder::new(pixels.len() as u32, 1);
        for pixel in pixels {
            pixel.iter().for_each(|&(z, value)| builder.push(Vertex::new(z, value)));
            builder.finish_pixel().unwrap();
        }
        builder.finish().unwrap()
    }

    fn mono() -> PixelLists<f32> {
        tile(&[
            &[(4.0, 1.0), (4.0, 0.5), (4.25, 0.375), (7.0, 0.0)],
            &[],
            &[(3.5, 1.0), (3.5, 0.0)],
            &[(0.0, 1.0), (3e38, 0.9375)],
        ])
    }

    fn coloured() -> PixelLists<Rgb> {
        let blue = Rgb::new(0.5, 0.25, 1.0);
        let dark = Rgb::new(0.0, 0.125, 0.5);
        let grey = Rgb::splat(0.75);
        tile(&[
            &[(1.5, Rgb::CLEAR), (2.0, blue), (2.5, dark)],
            &[],
            &[(1.0, Rgb::CLEAR), (1.0, grey)],
        ])
    }

    fn decode_again<T: Transmittance>(
        encoded: &EncodedTile,
        width: u32,
    ) -> Result<Tile<'static, T>> {
        let (payload, entry) = (Cow::Borrowed(encoded.bytes.as_slice()), encoded.entry());
        let (rect, place) = (rect(width), Place::Prologue);
        decode(StoredTile { payload, entry: &entry, rect, place })
    }

    fn assert_same<T: Transmittance>(a: PixelListsView<'_, T>, b: PixelListsView<'_, T>) {
        assert_eq!((a.starts(), a.value_starts()), (b.starts(), b.value_starts()));
        assert_eq!((a.depths(), a.values()), (b.depths(), b.values()));
    }

    #[test]
    fn what_lies_on_grids_comes_back() {
        for packing in [Packing::Plain, Packing::Zstd] {
            let encoded = encode(mono().view(), packing).unwrap();
            assert_eq!(encoded.codec, Codec::Quantized.tag());
            let tile: Tile<'_, f32> = decode_again(&encoded, 4).unwrap();
            assert_same(tile.view(), mono().view());
            let encoded = encode(coloured().view(), packing).unwrap();
            let tile: Tile<'_, Rgb> = decode_again(&encoded, 3).unwrap();
            assert_same(tile.view(), coloured().view());
        }
    }

    #[test]
    fn grids_are_as_coarse_as_they_can_be() {
        assert_eq!(Grids::of(mono().view()).map(|grids| grids.value_bits), Some(4));
        let fine = tile(&[&[(1.0, 1.0), (1.5, 1.0 - 0.5_f32.powi(24))]]);
        let expected = Grids { depth_zeros: 22, value_bits: 24 };
        assert_eq!(Grids::of(fine.view()), Some(expected));
        let tiny = tile(&[&[(1.0, 1.0), (1.5, 1e-9)]]);
        assert_eq!(Grids::of(tiny.view()), None);
        assert_eq!(encode(tiny.view(), Packing::Zstd).unwrap().codec, Codec::Exact.tag());
        let zero = tile(&[&[(0.0, 1.0), (0.0, 0.0)]]);
        assert_eq!(Grids::of(zero.view()), Some(Grids { depth_zeros: 23, value_bits: 0 }));
    }

    #[test]
    fn numbers_of_either_sign_come_back() {
        for change in [0, 1, u32::MAX, 5, 5_u32.wrapping_neg(), 1 << 31, i32::MAX.cast_unsigned()] {
            assert_eq!(from_zigzag(zigzag(change)), change);
        }
        assert_eq!([0, u32::MAX, 1].map(zigzag), [0, 1, 2]);
    }

    #[test]
    fn words_that_are_no_tile_are_refused() {
        let good = encode(mono().view(), Packing::Plain).unwrap();
        // Header, 5 starts, 8 depths, 8 values.
        let with = |word: usize, value: u32| {
            let mut bad = good.clone();
            bad.bytes[word * 4..word * 4 + 4].copy_from_slice(&value.to_le_bytes());
            decode_again::<f32>(&bad, 4).map(drop).map_err(|error| error.to_string())
        };
        assert!(with(0, good.bytes[0].into()).is_err());
        for (word, value, reason) in [
            (0, 24 | 4 << 8, "grids"),
            (0, 25 << 8, "grids"),
            (1, 1, "tables"),
            (2, 9, "tables"),
            (5, 7, "tables"),
            (6, u32::MAX, "depth"),
            (9, u32::MAX, "depth"),
            (15, 17, "below 0"),
            (14, 1, ""),
        ] {
            let error = with(word, value).unwrap_err();
            assert!(error.contains(reason), "{word} {value}: {error}");
        }
        let mut short = good.clone();
        short.raw_length = 0;
        assert!(decode_again::<f32>(&short, 4).is_err());
        let moved = EncodedTile { z_max: 8.0, ..good };
        assert!(decode_again::<f32>(&moved, 4).is_err());
    }
}
