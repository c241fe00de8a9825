//! Kinds of map as traits.

use std::fmt::Debug;
use std::ops::Range;

use dsm_core::Transmittance;
use dsm_core::detail::{BlockVisitor, VisibilityView};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::map_tiles::MapTiles;
use super::pixel_contents::PixelContents;
use super::summary::MapSummary;
use crate::codec::stored_tile::StoredTile;
use crate::codec::{Codec, Packing};
use crate::error::Result;
use crate::format::encoded_tile::EncodedTile;
use crate::format::level::Level;
use crate::map_tile::MapTile;
use crate::metadata::Metadata;

/// A kind of map, as `docs/format/dsm-1.md`, section 13, registers it: a name, a
/// payload of its own for each tile, and the metadata that it needs.
///
/// A type that stands for a kind has no values that matter. Tiles of one and of
/// three channels share all code through [`Transmittance`]. Everything else about
/// files is the same for all kinds: [`KindReader`](crate::kind::reader::KindReader) and
/// [`KindWriter`](crate::kind::writer::KindWriter) read and write them,
/// [`TileCache`](crate::cache::TileCache) keeps their tiles, and
/// [`Kinds`](crate::kind::kinds::Kinds) opens those whose kind is not known beforehand.
pub trait MapKind: Debug + Send + Sync + Sized + 'static {
    /// The kind's name in the metadata and on the command line.
    const NAME: &'static str;

    /// What messages call such a map, with its article: `a deep shadow map`.
    const TITLE: &'static str;

    /// The newest version of the payload. Files of a later one are refused.
    const VERSION: u32 = 1;

    /// Whether a file may hold a crop of a map.
    const CROPS: bool = false;

    /// The keys of the map that crops with these keys are put together into, whose level 0 has
    /// `pixels` pixels. Crops of a kind whose keys count something know what to add up; of
    /// others all keys are the whole map's.
    ///
    /// # Errors
    ///
    /// In what the crops' keys differ, which are none of one map then.
    fn join_keys(
        crops: &[&Self::Keys],
        _pixels: u64,
    ) -> std::result::Result<Self::Keys, &'static str> {
        match crops {
            [first, others @ ..] if others.iter().all(|other| other == first) => {
                Ok((*first).clone())
            }
            _ => Err("metadata"),
        }
    }

    /// Whether [`Self::function`] tells the visibility function of a pixel.
    const FUNCTIONS: bool = false;

    /// What the metadata say besides what those of every kind do: a structure
    /// whose fields are keys of the JSON object.
    type Keys: Clone + Debug + PartialEq + Serialize + DeserializeOwned + Send + Sync + 'static;

    /// The pixels of a tile.
    type Tile<T: Transmittance>: MapTile;

    /// The version of the payload of a map with these keys, such as the oldest that has all
    /// that it holds. Files that state another one are refused.
    fn version(_keys: &Self::Keys) -> u32 {
        Self::VERSION
    }

    /// Whether maps with these keys may have a tolerance and errors. Of others all are held
    /// to be 0.
    fn has_errors(_keys: &Self::Keys) -> bool {
        true
    }

    /// Holds the metadata to the kind's rules.
    ///
    /// # Errors
    ///
    /// [`Error::Metadata`](crate::error::Error::Metadata) with the rule that is broken.
    fn check(metadata: &Metadata, keys: &Self::Keys) -> Result<()>;

    /// Holds the levels to the kind's rules beside those of the format. Writers of the
    /// kind keep them; readers hold files to them.
    ///
    /// # Errors
    ///
    /// [`Error::Metadata`](crate::error::Error::Metadata) with the rule that is broken.
    fn check_levels(_levels: &[Level], _keys: &Self::Keys) -> Result<()> {
        Ok(())
    }

    /// The payload of a tile, of no bytes if the tile is empty. O(vertices).
    ///
    /// # Errors
    ///
    /// [`Error::Setting`](crate::error::Error::Setting) for what the kind cannot store.
    fn encode<T: Transmittance>(
        tile: &Self::Tile<T>,
        codec: Codec,
        packing: Packing,
    ) -> Result<EncodedTile>;

    /// An empty tile of `size` pixels. What takes memory for each pixel was held
    /// to the reader's limits before.
    ///
    /// # Errors
    ///
    /// Those of the tile's constructors.
    fn empty<T: Transmittance>(size: [u32; 2], keys: &Self::Keys) -> Result<Self::Tile<T>>;

    /// The pixels of a payload, held to all rules of the kind: lookups trust
    /// them. The number of pixels and the lengths that the directory states were
    /// held to the reader's limits before; nothing else was. O(vertices).
    ///
    /// # Errors
    ///
    /// What is wrong with the payload.
    fn decode<T: Transmittance>(stored: StoredTile<'_>, keys: &Self::Keys)
    -> Result<Self::Tile<T>>;

    /// Whether a payload is what [`Self::decode`] takes. Kinds that can tell
    /// without a copy do.
    ///
    /// # Errors
    ///
    /// As [`Self::decode`].
    fn verify<T: Transmittance>(stored: StoredTile<'_>, keys: &Self::Keys) -> Result<()> {
        Self::decode::<T>(stored, keys).map(drop)
    }

    /// Counts a tile of the finest level in.
    fn summarize<T: Transmittance>(tile: &Self::Tile<T>, summary: &mut MapSummary);

    /// What all tiles of the finest level of view 0 hold together. O(vertices);
    /// holds one tile.
    ///
    /// # Errors
    ///
    /// What is wrong with a tile.
    fn summary<T: Transmittance>(map: &impl MapTiles<Tile = Self::Tile<T>>) -> Result<MapSummary> {
        let mut summary = MapSummary::default();
        map.for_each_tile(|_, tile| {
            Self::summarize(&tile, &mut summary);
            Ok(())
        })?;
        Ok(summary)
    }

    /// What is stored of the pixel with row-major index `pixel`.
    fn contents<T: Transmittance>(tile: &Self::Tile<T>, pixel: usize) -> PixelContents;

    /// The visibility function of the pixel with row-major index `pixel`, of
    /// kinds that have such ([`Self::FUNCTIONS`]).
    fn function<T: Transmittance>(
        _tile: &Self::Tile<T>,
        _pixel: usize,
    ) -> Option<VisibilityView<'_, T>> {
        None
    }
}

/// A kind of map whose pixels have a transmittance at every depth, so that its
/// cursors are fields of filtered lookups.
pub trait FieldKind: MapKind {
    /// What the pixels of a tile are asked through: the tile itself, or slices of
    /// its columns, which are found once for many pixels.
    type View<'t, T: Transmittance>: Copy;
    /// Whether [`Self::evaluate_run`] hands over pixel lists; see
    /// [`VisibilityField::HAS_RUNS`](dsm_core::VisibilityField::HAS_RUNS).
    const HAS_RUNS: bool = false;

    /// The view of a tile. O(1).
    fn view<T: Transmittance>(tile: &Self::Tile<T>) -> Self::View<'_, T>;

    /// V(`depth`) of the pixel with row-major index `pixel` of a tile.
    fn evaluate<T: Transmittance>(view: Self::View<'_, T>, pixel: usize, depth: f32) -> T;

    /// Asks `visitor` for the depths of `columns` of a row of a block and hands
    /// it the values of the pixels from row-major index `first` on. Tells how many
    /// pixels were asked.
    #[inline(always)]
    fn evaluate_run<T: Transmittance>(
        view: Self::View<'_, T>,
        columns: Range<u32>,
        first: usize,
        visitor: &mut impl BlockVisitor<T>,
    ) -> u64 {
        let mut asked = 0;
        for (column, pixel) in columns.zip(first..) {
            if let Some(depth) = visitor.depth(column) {
                visitor.take(Self::evaluate(view, pixel, depth));
                asked += 1;
            }
        }
        asked
    }

    /// Asks memory for what lookups read of these rows of a tile, where that is
    /// worth it.
    fn prefetch<T: Transmittance>(_tile: &Self::Tile<T>, _rows: Range<u32>) {}
}
