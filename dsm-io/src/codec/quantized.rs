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
use super::grids::{Grids, from_zigzag, zigzag};
use super::packed::unpack;
use super::stations::{self, Columns};
use super::stored_tile::StoredTile;
use super::tile_columns::{TileColumn, mono_flags};
use super::{Codec, Packing, exact, words};
use crate::error::{Error, Place, Result};
use crate::format::directory::TileEntry;
use crate::format::encoded_tile::EncodedTile;
use crate::tile::Tile;

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
    let plain = encode_columns(pixels, grids, Packing::Plain)?;
    if packing != Packing::Plain {
        let bytes = stations::encode(pixels, grids);
        if bytes.len() < plain.bytes.len() {
            return Ok(EncodedTile { bytes, block: Packing::Entropy.tag(), ..plain });
        }
    }
    Ok(plain)
}

/// The words of the columns, as block 0 and 1 have them.
fn encode_columns<T: Transmittance>(
    pixels: PixelListsView<'_, T>,
    grids: Grids,
    packing: Packing,
) -> Result<EncodedTile> {
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
    let size = (rect.width, rect.height);
    let columns = match Packing::from_tag(entry.block) {
        Some(Packing::Entropy) => {
            if entry.differences != 0 {
                return Err(refuse("coded numbers are no differences of columns"));
            }
            let columns = stations::decode(&payload, size.into(), T::CHANNELS, [depths, values]);
            let Columns { starts, value_starts, depths, values } = columns.map_err(refuse)?;
            let pixels = PixelLists::new(size, starts, value_starts, depths, values);
            let pixels = pixels.map_err(|error| Error::Function { place, error })?;
            return within_range(pixels, entry, place);
        }
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
    let pixels = PixelLists::new(size, starts, value_starts, real(depths), real(values))
        .map_err(|error| Error::Function { place, error })?;
    if T::CHANNELS > 1 && mono_flags(pixels.view()) != flags {
        return Err(refuse("its mono flags do not fit its pixel tables"));
    }
    within_range(pixels, entry, place)
}

/// The tile, if its depths are those that its directory entry states.
fn within_range<T: Transmittance>(
    pixels: PixelLists<T>,
    entry: &TileEntry,
    place: Place,
) -> Result<Tile<'static, T>> {
    if depth_range(pixels.view()) != [entry.z_min, entry.z_max] {
        let reason = "its depths are not the range that its directory entry states";
        return Err(Error::invalid(place, reason));
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

    fn check<T: Transmittance>(pixels: &PixelLists<T>, packing: Packing) -> Packing {
        let grids = Grids::of(pixels.view()).unwrap();
        let encoded = match packing {
            Packing::Entropy => encode(pixels.view(), packing),
            _ => encode_columns(pixels.view(), grids, packing),
        };
        let encoded = encoded.unwrap();
        assert_eq!(encoded.codec, Codec::Quantized.tag());
        let tile: Tile<'_, T> = decode_again(&encoded, pixels.view().width()).unwrap();
        assert_same(tile.view(), pixels.view());
        Packing::from_tag(encoded.block).unwrap()
    }

    #[test]
    fn what_lies_on_grids_comes_back() {
        for packing in [Packing::Plain, Packing::Zstd, Packing::Entropy] {
            check(&mono(), packing);
            check(&coloured(), packing);
        }
        // The frequencies of few numbers would take more room than they save.
        assert_eq!(check(&mono(), Packing::Entropy), Packing::Entropy);
        let one = tile(&[&[(1.0, 1.0)]]);
        assert_eq!(check(&one, Packing::Entropy), Packing::Plain);
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
