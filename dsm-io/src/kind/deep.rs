//! Deep shadow maps as a kind.

use std::hint::black_box;
use std::ops::Range;

use dsm_core::Transmittance;
use dsm_core::detail::{BlockVisitor, PixelLists, PixelListsView, VisibilityView};
use serde::{Deserialize, Serialize};

use super::map_kind::{FieldKind, MapKind};
use super::map_tiles::MapTiles;
use super::pixel_contents::{PixelContents, PixelValue};
use super::summary::MapSummary;
use crate::codec::stored_tile::StoredTile;
use crate::codec::{Codec, Packing, exact, quantized};
use crate::error::{Error, Result};
use crate::format::encoded_tile::EncodedTile;
use crate::metadata::Metadata;
use crate::tile::Tile;

/// The kind `deep`: a visibility function in every pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Deep;

/// The keys that only deep maps have in their metadata: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeepKeys {}

impl Deep {
    /// The pixels of a tile, in place where they can be used as they lie.
    pub(crate) fn decode_in_place<T: Transmittance>(stored: StoredTile<'_>) -> Result<Tile<'_, T>> {
        match Codec::from_tag(stored.entry.codec) {
            Some(Codec::Exact) => exact::decode(stored),
            Some(Codec::Quantized) => quantized::decode(stored),
            None => {
                let (place, what) = (stored.place, format!("codec {}", stored.entry.codec));
                Err(Error::Unsupported { place, what })
            }
        }
    }
}

impl MapKind for Deep {
    const NAME: &'static str = "deep";
    const TITLE: &'static str = "a deep shadow map";
    const CROPS: bool = true;
    const FUNCTIONS: bool = true;

    type Keys = DeepKeys;
    type Tile<T: Transmittance> = PixelLists<T>;

    fn check(_: &Metadata, _: &DeepKeys) -> Result<()> {
        Ok(())
    }

    fn encode<T: Transmittance>(
        tile: &PixelLists<T>,
        codec: Codec,
        packing: Packing,
    ) -> Result<EncodedTile> {
        EncodedTile::encode(tile.view(), codec, packing)
    }

    fn empty<T: Transmittance>([width, height]: [u32; 2], _: &DeepKeys) -> Result<PixelLists<T>> {
        Ok(PixelLists::clear(width, height))
    }

    fn decode<T: Transmittance>(stored: StoredTile<'_>, _: &DeepKeys) -> Result<PixelLists<T>> {
        Ok(Self::decode_in_place(stored)?.into_lists())
    }

    fn verify<T: Transmittance>(stored: StoredTile<'_>, _: &DeepKeys) -> Result<()> {
        Self::decode_in_place::<T>(stored).map(drop)
    }

    fn summarize<T: Transmittance>(tile: &PixelLists<T>, summary: &mut MapSummary) {
        summary.add("vertices", tile.view().vertex_count() as u64);
    }

    /// What the directory says: no tile is read. O(tiles).
    fn summary<T: Transmittance>(map: &impl MapTiles<Tile = PixelLists<T>>) -> Result<MapSummary> {
        let mut summary = MapSummary::default();
        for (_, entry) in map.directory()?.iter() {
            summary.add("vertices", entry.vertex_count);
        }
        Ok(summary)
    }

    /// Depth, V just before it, and V at it: a step is one row.
    fn contents<T: Transmittance>(tile: &PixelLists<T>, pixel: usize) -> PixelContents {
        let mut contents =
            PixelContents::new("vertices", &["depth", "V before", "V at and behind"]);
        let function = tile.view().function(pixel);
        let mut vertices = function.vertices().peekable();
        while let Some(vertex) = vertices.next() {
            let at = vertices.next_if(|next| next.z == vertex.z).unwrap_or(vertex);
            contents.push([
                PixelValue::Number(vertex.z),
                PixelValue::light(vertex.value),
                PixelValue::light(at.value),
            ]);
        }
        contents
    }

    fn function<T: Transmittance>(
        tile: &PixelLists<T>,
        pixel: usize,
    ) -> Option<VisibilityView<'_, T>> {
        Some(tile.view().function(pixel))
    }
}

/// Vertices of the rows that are prefetched: more would fill the nearest cache,
/// and rows that long are streams which the processor sees by itself.
const MOST_PREFETCHED: usize = 1 << 14;

impl FieldKind for Deep {
    type View<'t, T: Transmittance> = PixelListsView<'t, T>;
    const HAS_RUNS: bool = true;

    #[inline(always)]
    fn view<T: Transmittance>(tile: &PixelLists<T>) -> PixelListsView<'_, T> {
        tile.view()
    }

    #[inline(always)]
    fn evaluate<T: Transmittance>(view: PixelListsView<'_, T>, pixel: usize, depth: f32) -> T {
        view.function(pixel).at(depth)
    }

    #[inline(always)]
    fn evaluate_run<T: Transmittance>(
        view: PixelListsView<'_, T>,
        columns: Range<u32>,
        first: usize,
        visitor: &mut impl BlockVisitor<T>,
    ) -> u64 {
        visitor.take_run(columns, view, first)
    }

    /// A word of every cache line, none waiting for another, so that they come
    /// together and not one after the other. O(vertices / 16).
    fn prefetch<T: Transmittance>(tile: &PixelLists<T>, rows: Range<u32>) {
        let view = tile.view();
        let width = view.width() as usize;
        let pixels = rows.start as usize * width..rows.end as usize * width;
        let of = |starts: &[u32]| starts[pixels.start] as usize..starts[pixels.end] as usize;
        let depths = of(view.starts());
        if depths.len() <= MOST_PREFETCHED {
            touch(&view.starts()[pixels.clone()], |&start| start);
            touch(&view.depths()[depths.clone()], |depth| depth.to_bits());
            let values = if T::CHANNELS == 1 {
                depths
            } else {
                touch(&view.value_starts()[pixels.clone()], |&start| start);
                of(view.value_starts())
            };
            touch(&view.values()[values], |value| value.to_bits());
        }
    }
}

/// Reads a word of every cache line.
#[inline(always)]
fn touch<V>(column: &[V], bits: impl Fn(&V) -> u32) {
    let words = column.iter().step_by(16).chain(column.last());
    black_box(words.fold(0, |sum, word| sum ^ bits(word)));
}
