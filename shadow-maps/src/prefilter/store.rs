//! Kind `prefiltered`: prefiltered maps in `.dsm` files, as `docs/format/dsm-1.md`,
//! section 13, defines it.

use dsm_core::Transmittance;
use dsm_io::detail::{
    ColumnReader, EncodedTile, FieldKind, Level, MapKind, PixelValue, Place, Result, StoredTile,
    TileColumn,
};
use dsm_io::{Codec, Error, MapSummary, Metadata, Packing, PixelContents};

use super::keys::PrefilteredKeys;
use super::lists::{FragmentLists, ListWords};
use super::tile::PrefilteredTile;

/// The kind `prefiltered`: fragments a texel, and levels of them merged by wider and
/// wider filters.
///
/// ```no_run
/// use dsm_io::Limits;
/// use dsm_io::detail::KindReader;
/// use shadow_maps::detail::Prefiltered;
///
/// let reader = KindReader::<Prefiltered>::open("leaves.dsm", &Limits::default())?;
/// println!("{} levels, {:?}", reader.levels().len(), reader.keys().filtering.epsilon);
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Prefiltered;

impl MapKind for Prefiltered {
    const NAME: &'static str = "prefiltered";
    const TITLE: &'static str = "a prefiltered map";

    type Keys = PrefilteredKeys;
    type Tile<T: Transmittance> = PrefilteredTile<T>;

    fn has_errors(_: &PrefilteredKeys) -> bool {
        false
    }

    fn check(metadata: &Metadata, keys: &PrefilteredKeys) -> Result<()> {
        let cut = keys.left_out.and_then(|cut| cut.broken_rule());
        let epsilon = keys.filtering.epsilon.broken_rule();
        let layering = keys.layering.broken_rule_of_exact(metadata.info.tolerance);
        match layering.or(cut).or(epsilon) {
            Some(rule) => Err(Error::Metadata(rule.to_owned())),
            None => Ok(()),
        }
    }

    fn check_levels(levels: &[Level], keys: &PrefilteredKeys) -> Result<()> {
        let broken = keys.filtering.geometry(levels).err();
        broken.map_or(Ok(()), |rule| Err(Error::Metadata(rule.to_owned())))
    }

    fn encode<T: Transmittance>(
        tile: &PrefilteredTile<T>,
        codec: Codec,
        packing: Packing,
    ) -> Result<EncodedTile> {
        if codec != Codec::Exact {
            return Err(Error::Setting("prefiltered maps are stored exactly".into()));
        }
        encode(tile.lists(), packing)
    }

    fn empty<T: Transmittance>(size: [u32; 2], _: &PrefilteredKeys) -> Result<PrefilteredTile<T>> {
        Ok(PrefilteredTile::new(FragmentLists::empty(size)))
    }

    fn decode<T: Transmittance>(
        stored: StoredTile<'_>,
        keys: &PrefilteredKeys,
    ) -> Result<PrefilteredTile<T>> {
        let place = stored.place();
        let is_finest = matches!(place, Place::Tile { id, .. } if id.level == 0);
        let lists = lists(stored, &ListWords::FRAGMENTS)?;
        let lengths = lists.starts().windows(2).map(|pair| pair[1] - pair[0]);
        if is_finest && lengths.max().unwrap_or(0) > keys.layering.max_layers {
            let reason = "a texel has more fragments than the map allows";
            return Err(Error::Invalid { place, reason: reason.into() });
        }
        Ok(PrefilteredTile::new(lists))
    }

    fn verify<T: Transmittance>(stored: StoredTile<'_>, keys: &PrefilteredKeys) -> Result<()> {
        Self::decode::<T>(stored, keys).map(drop)
    }

    fn summarize<T: Transmittance>(tile: &PrefilteredTile<T>, summary: &mut MapSummary) {
        let lengths = tile.lists().starts().windows(2).map(|pair| u64::from(pair[1] - pair[0]));
        let empty = summary.add_lists("fragments", "max_fragments_per_pixel", lengths);
        summary.add("empty_pixels", empty);
    }

    fn contents<T: Transmittance>(tile: &PrefilteredTile<T>, pixel: usize) -> PixelContents {
        let mut contents = PixelContents::new("fragments", &["depth", "opacity"]);
        let list = tile.lists().list(pixel);
        for (&w, &opacity) in list.w.iter().zip(list.opacities) {
            let depth = w.recip().min(f32::MAX);
            contents.push([PixelValue::Number(depth), PixelValue::light(opacity)]);
        }
        contents
    }
}

/// What the fragments of a texel up to a depth let through together.
impl FieldKind for Prefiltered {
    type View<'t, T: Transmittance> = &'t PrefilteredTile<T>;

    fn view<T: Transmittance>(tile: &PrefilteredTile<T>) -> &PrefilteredTile<T> {
        tile
    }

    fn evaluate<T: Transmittance>(view: &PrefilteredTile<T>, pixel: usize, depth: f32) -> T {
        let list = view.lists().list(pixel);
        let mut left = T::CLEAR;
        let reached = list.w.iter().take_while(|w| depth > 0.0 && w.recip() <= depth);
        for (_, opacity) in reached.zip(list.opacities) {
            left = T::from_channels(|c| left.channel(c) * (1.0 - opacity.channel(c)));
        }
        left
    }
}

/// The payload of lists.
pub(crate) fn encode<T: Transmittance>(
    lists: &FragmentLists<T>,
    packing: Packing,
) -> Result<EncodedTile> {
    let Some(range) = lists.depth_range() else { return Ok(EncodedTile::default()) };
    let opacities: Vec<f32> = (0..T::CHANNELS)
        .flat_map(|channel| lists.opacities().iter().map(move |value| value.channel(channel)))
        .collect();
    let columns = [
        TileColumn::table(lists.starts()),
        TileColumn::of_floats(lists.w()),
        TileColumn::of_floats(&opacities),
    ];
    EncodedTile::of_columns(&columns, lists.len() as u64, range, packing)
}

/// The lists of a payload, held to all rules.
pub(crate) fn lists<T: Transmittance>(
    stored: StoredTile<'_>,
    words: &ListWords,
) -> Result<FragmentLists<T>> {
    let (size, texels) = (stored.size(), stored.pixel_count());
    let mut columns: ColumnReader<'_> = stored.columns()?;
    let count = columns.entry().vertex_count;
    if count == 0 {
        return Err(columns.refuse("a tile without layers is empty"));
    }
    let starts = columns.take(texels + 1)?;
    let w = columns.take_floats(count)?;
    let values = columns.take_floats(count.saturating_mul(T::CHANNELS as u64))?;
    let opacity = |at| T::from_channels(|channel| values[channel * w.len() + at]);
    let opacities = (0..w.len()).map(opacity).collect();
    let lists = FragmentLists::of_named_columns(size, (starts, w, opacities), words)
        .map_err(|error| columns.refuse_pixel(error))?;
    let range = lists.depth_range().unwrap_or_default();
    columns.finish(range)?;
    Ok(lists)
}
