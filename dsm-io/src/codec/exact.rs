//! Codec 0: depths and values as they are in memory.
//!
//! Columns, in words: the pixel table (where each pixel's vertices start, and
//! the end); for coloured maps where each pixel's values start, and one bit a
//! pixel whether it has one channel only; the depths; the values.

use std::borrow::Cow;

use dsm_core::Transmittance;
use dsm_core::detail::{PixelLists, PixelListsView};

use super::packed::unpack;
use super::stored_tile::StoredTile;
use super::tile_columns::{TileColumn, mono_flags};
use super::{EncodedTile, Packing, words};
use crate::error::{Error, Result};
use crate::tile::Tile;

const COLUMNS: usize = 5;

pub(super) fn encode<T: Transmittance>(
    pixels: PixelListsView<'_, T>,
    packing: Packing,
) -> Result<EncodedTile> {
    if pixels.vertex_count() == 0 {
        return Ok(EncodedTile::default());
    }
    let mut flags = Vec::new();
    let columns = TileColumn::of_functions(pixels, &mut flags);
    let count = pixels.vertex_count() as u64;
    EncodedTile::of_columns(&columns, count, depth_range(pixels), packing)
}

/// The smallest and the largest depth. Each pixel's are sorted.
pub(super) fn depth_range<T: Transmittance>(pixels: PixelListsView<'_, T>) -> [f32; 2] {
    let mut range = [f32::INFINITY, 0.0_f32];
    for function in pixels.functions() {
        if let [first, .., last] | [first @ last] = function.depths() {
            range = [range[0].min(*first), range[1].max(*last)];
        }
    }
    // Not -0, so that one range has one encoding.
    range.map(|z| z + 0.0)
}

/// Lengths of the columns, in words.
pub(super) fn column_lengths(
    stored: &StoredTile<'_>,
    raw_length: u64,
    channels: usize,
) -> Result<[usize; COLUMNS]> {
    let refuse = |reason| Err(Error::invalid(stored.place, reason));
    let coloured = u64::from(channels > 1);
    let pixels = stored.pixel_count();
    let starts = pixels + 1;
    let flags = coloured * pixels.div_ceil(32);
    let table = starts * (1 + coloured) + flags;
    if !raw_length.is_multiple_of(4) {
        return refuse("its length is not a multiple of 4");
    }
    let vertices = stored.entry.vertex_count;
    let values = (raw_length / 4).checked_sub(table).and_then(|n| n.checked_sub(vertices));
    let Some(values) = values else {
        return refuse("its length has no room for its pixels and vertices");
    };
    let most = vertices.saturating_mul(channels as u64).min(u32::MAX.into());
    if vertices == 0 || !(vertices..=most).contains(&values) {
        return refuse("its length does not fit its number of vertices");
    }
    // All are below the length, which a limit holds to a machine's size.
    Ok([starts, coloured * starts, flags, vertices, values].map(|length| length as usize))
}

/// Decodes a payload whose checksum was found right, in place if it can.
pub(crate) fn decode<T: Transmittance>(stored: StoredTile<'_>) -> Result<Tile<'_, T>> {
    let lengths = column_lengths(&stored, stored.entry.raw_length, T::CHANNELS)?;
    let StoredTile { payload, entry, rect, place, .. } = stored;
    let size = (rect.width, rect.height);
    let not_valid = |error| Error::Function { place, error };
    let refuse = |reason: &'static str| Error::invalid(place, reason);
    let (tile, flags) = match Packing::from_tag(entry.block) {
        Some(Packing::Plain) => {
            if payload.len() as u64 != entry.raw_length || entry.differences != 0 {
                return Err(refuse("a plain tile is as long as its columns and stores words"));
            }
            match words::from_payload(payload) {
                Cow::Borrowed(words) => {
                    let [starts, value_starts, flags, z, values] = split(words, lengths);
                    let (z, values) = (bytemuck::cast_slice(z), bytemuck::cast_slice(values));
                    let pixels = PixelListsView::new(size, starts, value_starts, z, values);
                    (Tile::Borrowed(pixels.map_err(not_valid)?), flags.to_vec())
                }
                Cow::Owned(words) => {
                    let columns = split(&words, lengths).map(<[u32]>::to_vec);
                    own(size, columns).map_err(not_valid)?
                }
            }
        }
        Some(Packing::Zstd) => {
            let columns = unpack(&payload, lengths, entry.differences).map_err(refuse)?;
            own(size, columns).map_err(not_valid)?
        }
        Some(Packing::Entropy) | None => {
            return Err(Error::Unsupported { place, what: format!("block {}", entry.block) });
        }
    };
    let pixels = tile.view();
    if T::CHANNELS > 1 && mono_flags(pixels) != flags {
        return Err(refuse("its mono flags do not fit its pixel tables"));
    }
    if depth_range(pixels) != [entry.z_min, entry.z_max] {
        return Err(refuse("its depths are not the range that its directory entry states"));
    }
    Ok(tile)
}

/// The columns of these lengths, which are as long as `words` together.
pub(super) fn split<const N: usize>(mut words: &[u32], lengths: [usize; N]) -> [&[u32]; N] {
    lengths.map(|length| {
        let (column, rest) = words.split_at(length);
        words = rest;
        column
    })
}

type Owned<T> = (Tile<'static, T>, Vec<u32>);

fn own<T: Transmittance>(
    size: (u32, u32),
    [starts, value_starts, flags, z, values]: [Vec<u32>; COLUMNS],
) -> dsm_core::detail::Result<Owned<T>> {
    let [z, values] = [z, values].map(|bits| bits.into_iter().map(f32::from_bits).collect());
    let pixels = PixelLists::new(size, starts, value_starts, z, values)?;
    Ok((Tile::Owned(pixels), flags))
}
