//! Kind `fragments`: maps of fragments in `.dsm` files, as
//! `docs/format/dsm-1.md`, section 13, defines it.

use dsm_core::{Tolerance, Transmittance};
use dsm_io::detail::{
    EncodedTile, KindReader, MapKind, PixelValue, Result, StoredTile, TileColumn,
};
use dsm_io::{Codec, Error, MapSummary, Metadata, Packing, PixelContents};
use dsm_trace::detail::LightFrame;

use super::columns::FragmentColumns;
use super::keys::FragmentKeys;
use super::map::FragmentMap;
use super::media::columns::MediaColumns;
use super::tile::FragmentTile;

/// The kind `fragments`: planes with coverage masks, a [`FragmentMap`].
///
/// ```no_run
/// use dsm_io::detail::KindReader;
/// use dsm_io::Limits;
/// use shadow_maps::detail::{FragmentMap, Fragments};
///
/// let reader = KindReader::<Fragments>::open("leaves.dsm", &Limits::default())?;
/// let map = FragmentMap::<f32>::read(&reader)?;
/// println!("{} fragments", map.len());
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fragments;

impl MapKind for Fragments {
    const NAME: &'static str = "fragments";
    const TITLE: &'static str = "a map of fragments";
    const VERSION: u32 = 2;

    const CROPS: bool = true;

    type Keys = FragmentKeys;
    type Tile<T: Transmittance> = FragmentTile<T>;

    fn version(keys: &FragmentKeys) -> u32 {
        if keys.media.is_some() { 2 } else { 1 }
    }

    /// Of media.
    fn has_errors(keys: &FragmentKeys) -> bool {
        keys.media.is_some()
    }

    fn check(metadata: &Metadata, keys: &FragmentKeys) -> Result<()> {
        let coverage = (![1, 2, 4, 8].contains(&keys.coverage))
            .then_some("the coverage of fragments must be 1, 2, 4 or 8");
        let no_slabs = keys.media.is_some_and(|media| media.max_slabs == 0);
        let no_slabs = no_slabs.then_some("the bound of slabs of media must be 1 or more");
        // Of media alone.
        let of_media = keys.media.is_some();
        let tolerance = if of_media { Tolerance::EXACT } else { metadata.info.tolerance };
        let folded = keys.folded.and_then(|cut| cut.broken_rule());
        match coverage.or(no_slabs).or(folded).or(keys.layering.broken_rule_of_exact(tolerance)) {
            Some(rule) => Err(Error::Metadata(rule.to_owned())),
            None => Ok(()),
        }
    }

    fn join_keys(
        crops: &[&FragmentKeys],
        pixels: u64,
    ) -> std::result::Result<FragmentKeys, &'static str> {
        FragmentKeys::join(crops, pixels)
    }

    fn encode<T: Transmittance>(
        tile: &FragmentTile<T>,
        codec: Codec,
        packing: Packing,
    ) -> Result<EncodedTile> {
        if codec != Codec::Exact {
            return Err(Error::Setting("fragments are stored exactly".into()));
        }
        if tile.count() == 0 {
            return Ok(EncodedTile::default());
        }
        let FragmentColumns { offsets, w, gradients, facing, opacities, coverage } = tile.columns();
        let opacities = by_channel(opacities);
        let low: Vec<u32> = coverage.iter().map(|&mask| mask as u32).collect();
        let high: Vec<u32> = coverage.iter().map(|&mask| (mask >> 32) as u32).collect();
        let encode = |columns: &[TileColumn<'_>]| {
            EncodedTile::of_columns(columns, tile.count(), tile.range(), packing)
        };
        let Some(media) = tile.media() else {
            return encode(&[
                TileColumn::table(offsets),
                TileColumn::of_floats(w),
                TileColumn::of_floats(&gradients[0]),
                TileColumn::of_floats(&gradients[1]),
                TileColumn::flags(facing),
                TileColumn::of_floats(&opacities),
                TileColumn::of(&low),
                TileColumn::of(&high),
            ]);
        };
        // As many columns as there may be, two of which hold two.
        let [offsets, masks] =
            [[offsets, &media.offsets], [&low, &high]].map(|two| two.map(|one| &one[..]).concat());
        encode(&[
            TileColumn::table(&offsets),
            TileColumn::of_floats(w),
            TileColumn::of_floats(&gradients.concat()),
            TileColumn::flags(facing),
            TileColumn::of_floats(&opacities),
            TileColumn::of(&masks),
            TileColumn::of_floats(&media.depths),
            TileColumn::of_floats(&by_channel(&media.thickness)),
        ])
    }

    fn empty<T: Transmittance>(size: [u32; 2], keys: &FragmentKeys) -> Result<FragmentTile<T>> {
        let pixels = size[0] as usize * size[1] as usize;
        let mut columns = FragmentColumns::new();
        columns.offsets = vec![0; pixels + 1];
        let tile = FragmentTile::new(size, columns)?;
        Ok(if keys.media.is_some() { tile.with_media(MediaColumns::clear(pixels))? } else { tile })
    }

    fn decode<T: Transmittance>(
        stored: StoredTile<'_>,
        keys: &FragmentKeys,
    ) -> Result<FragmentTile<T>> {
        let (size, pixels) = (stored.size(), stored.pixel_count());
        let mut columns = stored.columns()?;
        let all = columns.entry().vertex_count;
        if all == 0 {
            return Err(columns.refuse("a tile without layers is empty"));
        }
        let has_media = keys.media.is_some();
        let mut offsets = columns.take((pixels + 1) * (1 + u64::from(has_media)))?;
        let of_media = has_media.then(|| offsets.split_off(pixels as usize + 1));
        let borders = of_media.as_ref().map_or(0, |table| table[pixels as usize].into());
        let Some(count) = all.checked_sub(borders) else {
            return Err(columns.refuse("it has more borders of media than it states"));
        };
        let w = columns.take_floats(count)?;
        let gradients = if has_media {
            halves(columns.take_floats(count.saturating_mul(2))?)
        } else {
            [columns.take_floats(count)?, columns.take_floats(count)?]
        };
        let facing = columns.take(count.div_ceil(32))?;
        let opacities = values(columns.take_floats(count.saturating_mul(T::CHANNELS as u64))?);
        let [low, high] = if has_media {
            halves(columns.take(count.saturating_mul(2))?)
        } else {
            [columns.take(count)?, columns.take(count)?]
        };
        let masks = low.iter().zip(&high);
        let coverage = masks.map(|(&low, &high)| u64::from(high) << 32 | u64::from(low)).collect();
        let read = FragmentColumns { offsets, w, gradients, facing, opacities, coverage };
        let mut tile =
            FragmentTile::new(size, read).map_err(|error| columns.refuse_pixel(error))?;
        if let Some((offsets, keys)) = of_media.zip(keys.media) {
            let depths = columns.take_floats(borders)?;
            let channels = borders.saturating_mul(T::CHANNELS as u64);
            let thickness = values(columns.take_floats(channels)?);
            let media = MediaColumns { offsets, depths, thickness };
            tile = tile.with_media(media).map_err(|error| columns.refuse_pixel(error))?;
            let borders = tile.media().map_or(0, |media| longest(&media.offsets));
            if borders.saturating_sub(1) > keys.max_slabs {
                return Err(columns.refuse("a pixel has more slabs of media than the map allows"));
            }
        }
        if longest(&tile.columns().offsets) > keys.layering.max_layers {
            return Err(columns.refuse("a pixel has more layers than the map allows"));
        }
        let range = tile.range();
        let entry = columns.entry();
        // What this writes, told quickly.
        if range == [entry.z_min, entry.z_max] {
            columns.finish(range)?;
        } else {
            columns.finish_around(tile.covered())?;
        }
        Ok(tile)
    }

    fn summarize<T: Transmittance>(tile: &FragmentTile<T>, summary: &mut MapSummary) {
        fn lengths(offsets: &[u32]) -> impl Iterator<Item = u64> {
            offsets.windows(2).map(|pair| u64::from(pair[1] - pair[0]))
        }
        let columns = tile.columns();
        let (sum, most) = ("fragments", "max_fragments_per_pixel");
        let without_fragments = summary.add_lists(sum, most, lengths(&columns.offsets));
        let empty = match tile.media() {
            None => without_fragments,
            Some(media) => {
                let both = lengths(&columns.offsets).zip(lengths(&media.offsets));
                both.filter(|&pair| pair == (0, 0)).count() as u64
            }
        };
        summary.add("empty_pixels", empty);
        let facing: u64 = columns.facing.iter().map(|word| u64::from(word.count_ones())).sum();
        summary.add("without_plane", facing);
        if let Some(media) = tile.media() {
            let slabs = lengths(&media.offsets).map(|borders| borders.saturating_sub(1));
            let without = summary.add_lists("slabs", "max_slabs_per_pixel", slabs);
            let pixels = media.offsets.len() as u64 - 1;
            summary.add("pixels_with_media", pixels - without);
        }
    }

    /// The nearest first. In maps with media each row has the depth that it ends at, too, and
    /// slabs stand among the fragments: as opaque as they are to a ray that goes one unit far
    /// for each unit of depth.
    fn contents<T: Transmittance>(tile: &FragmentTile<T>, pixel: usize) -> PixelContents {
        let fragments = tile.fragments(pixel).rev().map(|fragment| {
            let depth = fragment.w.recip();
            ([depth; 2], fragment.opacity, fragment.coverage)
        });
        let numbers = |opacity, mask: u64| {
            let covered = PixelValue::Count(mask.count_ones());
            [PixelValue::light(opacity), covered, PixelValue::Mask(mask)]
        };
        let Some(media) = tile.media() else {
            let columns = &["depth", "opacity", "covered 64ths", "mask"];
            let mut contents = PixelContents::new("fragments", columns);
            for ([depth, _], opacity, mask) in fragments {
                let depth = [PixelValue::Number(depth)];
                contents.push(depth.into_iter().chain(numbers(opacity, mask)));
            }
            return contents;
        };
        let borders = media.pixel(pixel).zip(media.pixel(pixel).skip(1));
        let slabs = borders.map(|((near, _), (far, thickness))| {
            let opacity = T::from_channels(|channel| -(-thickness.channel(channel)).exp_m1());
            ([near, far], opacity, u64::MAX)
        });
        let slabs = slabs.filter(|&(_, opacity, _)| opacity != T::splat(0.0));
        let mut rows: Vec<_> = fragments.chain(slabs).collect();
        rows.sort_by(|(a, ..), (b, ..)| a[0].total_cmp(&b[0]));
        let columns = &["depth", "to depth", "opacity", "covered 64ths", "mask"];
        let mut contents = PixelContents::new("fragments", columns);
        for (depths, opacity, mask) in rows {
            let depths = depths.map(PixelValue::Number);
            contents.push(depths.into_iter().chain(numbers(opacity, mask)));
        }
        contents
    }
}

/// The values of each channel, one after the other.
fn by_channel<T: Transmittance>(values: &[T]) -> Vec<f32> {
    let of = |channel| values.iter().map(move |value| value.channel(channel));
    (0..T::CHANNELS).flat_map(of).collect()
}

/// The values of these channels.
fn values<T: Transmittance>(channels: Vec<f32>) -> Vec<T> {
    let count = channels.len() / T::CHANNELS;
    let value = |at| T::from_channels(|channel| channels[channel * count + at]);
    (0..count).map(value).collect()
}

/// The two halves of a column.
fn halves<V: Clone>(mut both: Vec<V>) -> [Vec<V>; 2] {
    let second = both.split_off(both.len() / 2);
    [both, second]
}

/// The length of the longest list.
fn longest(offsets: &[u32]) -> u32 {
    offsets.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0)
}

/// The frame of the light of a file's map.
pub(super) fn frame_of(reader: &KindReader<Fragments>) -> dsm_core::detail::Result<LightFrame> {
    let metadata = reader.metadata();
    let camera = metadata.info.camera.unwrap_or_default();
    let light_depth = reader.keys().layering.light_depth.into();
    LightFrame::new(&camera, [metadata.width, metadata.height], light_depth)
}

impl<T: Transmittance> FragmentMap<T> {
    /// Reads a whole map, its finest level, row by row of tiles. O(fragments).
    ///
    /// # Errors
    ///
    /// [`Error::Channels`] for a map of another number of channels,
    /// [`Error::Limit`] for one that is too large, or what is wrong with a tile.
    pub fn read(reader: &KindReader<Fragments>) -> Result<Self> {
        reader.check_in_memory(0)?;
        let mut columns = FragmentColumns::new();
        let mut media = MediaColumns::new();
        reader.for_each_pixel::<T>(0, |tile, pixel| {
            columns.push_pixel(tile.fragments(pixel))?;
            if let Some(of_tile) = tile.media() {
                media.push_pixel(of_tile.pixel(pixel))?;
            }
            Ok(())
        })?;
        let map = frame_of(reader).and_then(|frame| Self::new(frame, columns));
        let has_media = reader.keys().media.is_some();
        let map = if has_media { map.and_then(|map| map.with_media(media)) } else { map };
        reader.container().in_file(map.map_err(Error::from))
    }
}
