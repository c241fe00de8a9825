//! Columns of words in the payloads of maps of any kind.

use std::borrow::Cow;

use dsm_core::Transmittance;
use dsm_core::detail::{PixelLists, PixelListsView};

use super::packed::{Differences, pack, should_difference, unpack_planes, unshuffle};
use super::stored_tile::StoredTile;
use super::{Codec, EncodedTile, Packing, words};
use crate::error::{Error, Place, Result};
use crate::format::directory::TileEntry;

/// A column of a tile of any kind of map.
#[derive(Clone, Copy, Debug)]
pub struct TileColumn<'a> {
    words: &'a [u32],
    /// Whether a zstd packing stores differences; none: if words repeat.
    differences: Option<bool>,
}

impl<'a> TileColumn<'a> {
    /// A column that rises, of which differences pack better.
    #[must_use]
    pub const fn table(words: &'a [u32]) -> Self {
        Self { words, differences: Some(true) }
    }

    /// A column of bits, of which words pack better.
    #[must_use]
    pub const fn flags(words: &'a [u32]) -> Self {
        Self { words, differences: Some(false) }
    }

    /// A column of anything.
    #[must_use]
    pub const fn of(words: &'a [u32]) -> Self {
        Self { words, differences: None }
    }

    /// A column of `f32`s.
    #[must_use]
    pub fn of_floats(values: &'a [f32]) -> Self {
        Self::of(bytemuck::cast_slice(values))
    }

    /// The five columns of visibility functions, as those of a deep map's tile:
    /// the tables of vertices and of values, mono flags, which `flags` is made to
    /// hold, depths and values.
    pub fn of_functions<T: Transmittance>(
        functions: PixelListsView<'a, T>,
        flags: &'a mut Vec<u32>,
    ) -> [Self; 5] {
        *flags = if T::CHANNELS == 1 { Vec::new() } else { mono_flags(functions) };
        [
            Self::table(functions.starts()),
            Self::table(functions.value_starts()),
            Self::flags(flags),
            Self::of_floats(functions.depths()),
            Self::of_floats(functions.values()),
        ]
    }

    fn stores_differences(&self) -> bool {
        self.differences.unwrap_or_else(|| should_difference(self.words))
    }
}

/// One bit a function, lowest first: set where one channel stands for all.
pub(super) fn mono_flags<T: Transmittance>(functions: PixelListsView<'_, T>) -> Vec<u32> {
    let mut flags = vec![0; functions.pixel_count().div_ceil(32)];
    for (index, function) in functions.functions().enumerate() {
        flags[index / 32] |= u32::from(function.is_mono()) << (index % 32);
    }
    flags
}

impl EncodedTile {
    /// The most columns that a tile may have.
    pub const MAX_COLUMNS: usize = 8;

    /// A tile of these columns, for a map of any kind, with `count` vertices or
    /// what stands for them, between the depths of `range`. Where packing saves
    /// nothing, it is left plain. O(words).
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] for more than [`Self::MAX_COLUMNS`] columns, [`Error::Io`] if the
    /// compressor fails.
    pub fn of_columns(
        columns: &[TileColumn<'_>],
        count: u64,
        range: [f32; 2],
        packing: Packing,
    ) -> Result<Self> {
        if columns.len() > Self::MAX_COLUMNS {
            return Err(Error::setting("a tile has at most 8 columns"));
        }
        let raw_length: usize = columns.iter().map(|column| column.words.len() * 4).sum();
        let bits = (0..).zip(columns);
        let differences: Differences =
            bits.map(|(bit, column)| u8::from(column.stores_differences()) << bit).sum();
        let words = columns.iter().map(|column| column.words);
        let packed = match packing {
            Packing::Plain => None,
            Packing::Zstd | Packing::Entropy => {
                Some(pack(words.clone(), differences).map_err(Error::io("compress a tile"))?)
            }
        };
        let (bytes, packing, differences) = match packed {
            Some(packed) if packed.len() < raw_length => (packed, Packing::Zstd, differences),
            _ => {
                let mut plain = Vec::with_capacity(raw_length);
                words.for_each(|column| words::append(column, &mut plain));
                (plain, Packing::Plain, 0)
            }
        };
        // Not -0, so that one range has one encoding.
        let [z_min, z_max] = range.map(|z| z + 0.0);
        Ok(Self {
            bytes,
            raw_length: raw_length as u64,
            vertex_count: count,
            z_min,
            z_max,
            depth_error: 0.0,
            codec: Codec::Exact.tag(),
            block: packing.tag(),
            differences,
        })
    }
}

/// Reads the columns of a tile of any kind of map, one after the other
/// ([`StoredTile::columns`]). What is asked for is compared with what the tile holds before memory is taken.
#[derive(Debug)]
pub struct ColumnReader<'a> {
    /// What is left of the unpacked payload.
    rest: Cow<'a, [u8]>,
    at: usize,
    is_packed: bool,
    differences: Differences,
    entry: TileEntry,
    place: Place,
}

impl<'a> ColumnReader<'a> {
    /// The columns of a tile of codec 0, unpacked.
    pub(crate) fn new(stored: StoredTile<'a>) -> Result<Self> {
        let StoredTile { payload, entry, place, .. } = stored;
        let refuse = |reason: &'static str| Error::invalid(place, reason);
        if !entry.raw_length.is_multiple_of(4) {
            return Err(refuse("its length is not a multiple of 4"));
        }
        if entry.depth_error != 0.0 {
            return Err(refuse("exact depths are stated to have an error"));
        }
        let (rest, is_packed) = match Packing::from_tag(entry.block) {
            Some(Packing::Plain) => {
                if payload.len() as u64 != entry.raw_length || entry.differences != 0 {
                    let reason = "a plain tile is as long as its columns and stores words";
                    return Err(refuse(reason));
                }
                (payload, false)
            }
            Some(Packing::Zstd) => {
                // The limit holds it to a machine's size.
                let planes = unpack_planes(&payload, entry.raw_length as usize).map_err(refuse)?;
                (Cow::Owned(planes), true)
            }
            Some(Packing::Entropy) | None => {
                return Err(Error::Unsupported { place, what: format!("block {}", entry.block) });
            }
        };
        let (entry, differences) = (*entry, entry.differences);
        Ok(Self { rest, at: 0, is_packed, differences, entry, place })
    }

    /// The tile's entry in the directory.
    #[must_use]
    pub const fn entry(&self) -> &TileEntry {
        &self.entry
    }

    /// The tile's place in its file.
    #[must_use]
    pub const fn place(&self) -> Place {
        self.place
    }

    /// Number of words not read yet.
    #[must_use]
    pub fn words_left(&self) -> u64 {
        (self.rest.len() - self.at) as u64 / 4
    }

    /// The next column, which has so many words.
    ///
    /// # Errors
    ///
    /// [`Error::Invalid`] if there are not as many.
    pub fn take(&mut self, words: u64) -> Result<Vec<u32>> {
        if words > self.words_left() {
            return Err(self.refuse("its length has no room for its columns"));
        }
        // Not more than there are bytes.
        let bytes = &self.rest[self.at..][..words as usize * 4];
        let column = if self.is_packed {
            unshuffle(bytes, self.differences & 1 == 1)
        } else {
            words::from_bytes(bytes).into_owned()
        };
        self.at += bytes.len();
        self.differences >>= 1;
        Ok(column)
    }

    /// The next column, as `f32`s.
    ///
    /// # Errors
    ///
    /// As [`Self::take`].
    pub fn take_floats(&mut self, words: u64) -> Result<Vec<f32>> {
        Ok(self.take(words)?.into_iter().map(f32::from_bits).collect())
    }

    /// The next five columns: `count` visibility functions of `vertices`
    /// vertices, in one row ([`TileColumn::of_functions`]). Of the words that are
    /// left, `after` belong to later columns, and all others are theirs.
    ///
    /// # Errors
    ///
    /// [`Error::Invalid`] if the columns do not fit, [`Error::Function`] for
    /// what is no visibility function.
    pub fn take_functions<T: Transmittance>(
        &mut self,
        count: u32,
        vertices: u64,
        after: u64,
    ) -> Result<PixelLists<T>> {
        let starts = u64::from(count) + 1;
        let coloured = u64::from(T::CHANNELS > 1);
        let flags = coloured * u64::from(count).div_ceil(32);
        let others = [starts * (1 + coloured), flags, vertices, after];
        let others = others.into_iter().fold(0, u64::saturating_add);
        let most = vertices.saturating_mul(T::CHANNELS as u64).min(u32::MAX.into());
        let values = self.words_left().checked_sub(others);
        let Some(values) = values.filter(|values| (vertices..=most).contains(values)) else {
            return Err(self.refuse("its length does not fit its number of vertices"));
        };
        let starts = [self.take(starts)?, self.take(coloured * starts)?];
        let flags = self.take(flags)?;
        let depths = self.take_floats(vertices)?;
        let values = self.take_floats(values)?;
        let [starts, value_starts] = starts;
        let functions = PixelLists::new((count, 1), starts, value_starts, depths, values)
            .map_err(|error| self.refuse_pixel(error))?;
        if T::CHANNELS > 1 && mono_flags(functions.view()) != flags {
            return Err(self.refuse("its mono flags do not fit its pixel tables"));
        }
        Ok(functions)
    }

    /// Checks that nothing is left, and that the depths are those that the
    /// directory states.
    ///
    /// # Errors
    ///
    /// [`Error::Invalid`] if not.
    pub fn finish(self, range: [f32; 2]) -> Result<()> {
        self.finish_where(|stated| range == stated)
    }

    /// Checks that nothing is left, and that the depths that the directory states hold
    /// `covered`, but for a relative 10⁻⁶: they may be wider.
    ///
    /// # Errors
    ///
    /// [`Error::Invalid`] if not.
    pub fn finish_around(self, covered: [f64; 2]) -> Result<()> {
        const ROUNDING: f64 = 1e-6;
        let [near, far] = covered;
        self.finish_where(|stated| {
            let [low, high] = stated.map(f64::from);
            low <= near * (1.0 + ROUNDING) && high >= far * (1.0 - ROUNDING)
        })
    }

    fn finish_where(self, fits: impl FnOnce([f32; 2]) -> bool) -> Result<()> {
        if self.words_left() > 0 {
            return Err(self.refuse("its length is more than its columns have"));
        }
        if self.differences != 0 {
            return Err(self.refuse("there are fewer columns than stored as differences"));
        }
        if !fits([self.entry.z_min, self.entry.z_max]) {
            let reason = "its depths are not the range that its directory entry states";
            return Err(self.refuse(reason));
        }
        Ok(())
    }

    /// The error of a tile that breaks a rule.
    #[must_use]
    pub fn refuse(&self, reason: &'static str) -> Error {
        Error::invalid(self.place, reason)
    }

    /// The error of the tile's pixels.
    #[must_use]
    pub const fn refuse_pixel(&self, error: dsm_core::Error) -> Error {
        Error::Function { place: self.place, error }
    }
}

impl<'a> StoredTile<'a> {
    /// The columns of a tile of codec 0, unpacked.
    ///
    /// # Errors
    ///
    /// [`Error::Unsupported`] for another codec or an unknown packing, or what is
    /// wrong with the payload.
    pub fn columns(self) -> Result<ColumnReader<'a>> {
        let place = self.place;
        if Codec::from_tag(self.entry.codec) != Some(Codec::Exact) {
            let what = format!("codec {}", self.entry.codec);
            return Err(Error::Unsupported { place, what });
        }
        ColumnReader::new(self)
    }
}
