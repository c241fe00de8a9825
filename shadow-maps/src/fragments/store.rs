//! Kind `fragments`: maps of fragments in `.dsm` files, as
//! `docs/format/dsm-1.md`, section 13, defines it.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::{HitSource, MapInfo, Progress, Transmittance};
use dsm_io::detail::{
    BakeReport, EncodedTile, KindReader, KindWriter, MapKind, MapTile, PixelValue, Result,
    StoredTile, TileColumn, TileId,
};
use dsm_io::{
    AchievedError, Codec, Error, MapSummary, Metadata, Packing, PixelContents, WriteOptions,
};
use dsm_trace::detail::{Layering, LightFrame};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::builder::{FragmentBuilder, FragmentCounts};
use super::columns::FragmentColumns;
use super::fragment::Fragment;
use super::map::FragmentMap;

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

/// The metadata keys that maps of fragments have besides those of every map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FragmentKeys {
    /// The bound of fragments a pixel, and the depth of the light.
    pub layering: Layering,
    /// Places along a side of a pixel that were looked at: 1, 2, 4 or 8. A file must
    /// have it.
    #[serde(default)]
    pub coverage: u32,
    /// What the bound of fragments changed; None for nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub folded: Option<Folded>,
}

/// What a bound of fragments a pixel changed: the rest are one fragment with the last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Folded {
    /// Pixels with more fragments.
    pub pixels: u64,
    /// The most light that any pixel lets through too much, to some depth between those
    /// that became one, in [0, 1].
    pub max: f32,
    /// The same in the mean over all pixels.
    pub mean: f32,
}

/// The fragments of a tile.
#[derive(Clone, Debug, PartialEq)]
pub struct FragmentTile<T> {
    size: [u32; 2],
    columns: FragmentColumns<T>,
}

impl<T: Transmittance> FragmentTile<T> {
    /// A tile of `size` pixels, whose lists are in `columns`.
    ///
    /// # Errors
    ///
    /// As [`FragmentColumns::check`].
    pub fn new(size: [u32; 2], columns: FragmentColumns<T>) -> dsm_core::detail::Result<Self> {
        columns.check(size)?;
        Ok(Self { size, columns })
    }

    /// All fragments, pixel by pixel.
    #[must_use]
    pub const fn columns(&self) -> &FragmentColumns<T> {
        &self.columns
    }

    /// The fragments of the pixel with row-major index `pixel`, the farthest first.
    ///
    /// # Panics
    ///
    /// If there is no such pixel.
    pub fn fragments(&self, pixel: usize) -> impl DoubleEndedIterator<Item = Fragment<T>> {
        let columns = &self.columns;
        let range = columns.offsets[pixel] as usize..columns.offsets[pixel + 1] as usize;
        range.map(|index| columns.fragment(index))
    }

    /// Least and greatest depth of all that is covered.
    fn range(&self) -> [f32; 2] {
        let fragments = (0..self.columns.w.len()).map(|index| self.columns.fragment(index));
        let depths = fragments.map(|fragment| {
            let [low, high] = fragment.range();
            let depth = |w: f32| if w > 0.0 { w.recip().min(f32::MAX) } else { f32::MAX };
            [depth(high), depth(low)]
        });
        let range = depths.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        range.unwrap_or([0.0; 2])
    }
}

impl<T: Transmittance> MapTile for FragmentTile<T> {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn bytes(&self) -> u64 {
        let columns = &self.columns;
        let words = columns.offsets.len() + columns.facing.len();
        let each = 3 + T::CHANNELS + 2;
        4 * (words + each * columns.w.len()) as u64
    }
}

impl MapKind for Fragments {
    const NAME: &'static str = "fragments";
    const TITLE: &'static str = "a map of fragments";

    type Keys = FragmentKeys;
    type Tile<T: Transmittance> = FragmentTile<T>;

    fn check(metadata: &Metadata, keys: &FragmentKeys) -> Result<()> {
        let coverage = (![1, 2, 4, 8].contains(&keys.coverage))
            .then_some("the coverage of fragments must be 1, 2, 4 or 8");
        let tolerance = metadata.info.tolerance;
        match coverage.or(keys.layering.broken_rule_of_exact(tolerance)) {
            Some(rule) => Err(Error::Metadata(rule.to_owned())),
            None => Ok(()),
        }
    }

    fn encode<T: Transmittance>(
        tile: &FragmentTile<T>,
        codec: Codec,
        packing: Packing,
    ) -> Result<EncodedTile> {
        if codec != Codec::Exact {
            return Err(Error::Setting("fragments are stored exactly".into()));
        }
        let FragmentColumns { offsets, w, gradients, facing, opacities, coverage } = &tile.columns;
        if w.is_empty() {
            return Ok(EncodedTile::default());
        }
        let opacities: Vec<f32> = (0..T::CHANNELS)
            .flat_map(|channel| opacities.iter().map(move |value| value.channel(channel)))
            .collect();
        let low: Vec<u32> = coverage.iter().map(|&mask| mask as u32).collect();
        let high: Vec<u32> = coverage.iter().map(|&mask| (mask >> 32) as u32).collect();
        let columns = [
            TileColumn::table(offsets),
            TileColumn::of_floats(w),
            TileColumn::of_floats(&gradients[0]),
            TileColumn::of_floats(&gradients[1]),
            TileColumn::flags(facing),
            TileColumn::of_floats(&opacities),
            TileColumn::of(&low),
            TileColumn::of(&high),
        ];
        EncodedTile::of_columns(&columns, w.len() as u64, tile.range(), packing)
    }

    fn empty<T: Transmittance>(size: [u32; 2], _: &FragmentKeys) -> Result<FragmentTile<T>> {
        let mut columns = FragmentColumns::new();
        columns.offsets = vec![0; size[0] as usize * size[1] as usize + 1];
        Ok(FragmentTile { size, columns })
    }

    fn decode<T: Transmittance>(
        stored: StoredTile<'_>,
        keys: &FragmentKeys,
    ) -> Result<FragmentTile<T>> {
        let (size, pixels) = (stored.size(), stored.pixel_count());
        let mut columns = stored.columns()?;
        let count = columns.entry().vertex_count;
        if count == 0 {
            return Err(columns.refuse("a tile without layers is empty"));
        }
        let offsets = columns.take(pixels + 1)?;
        let w = columns.take_floats(count)?;
        let gradients = [columns.take_floats(count)?, columns.take_floats(count)?];
        let facing = columns.take(count.div_ceil(32))?;
        let values = columns.take_floats(count.saturating_mul(T::CHANNELS as u64))?;
        let [low, high] = [columns.take(count)?, columns.take(count)?];
        let opacity = |at| T::from_channels(|channel| values[channel * w.len() + at]);
        let opacities = (0..w.len()).map(opacity).collect();
        let masks = low.iter().zip(&high);
        let coverage = masks.map(|(&low, &high)| u64::from(high) << 32 | u64::from(low)).collect();
        let read = FragmentColumns { offsets, w, gradients, facing, opacities, coverage };
        let tile = FragmentTile::new(size, read).map_err(|error| columns.refuse_pixel(error))?;
        let lists = tile.columns.offsets.windows(2).map(|pair| pair[1] - pair[0]);
        if lists.max().unwrap_or(0) > keys.layering.max_layers {
            return Err(columns.refuse("a pixel has more layers than the map allows"));
        }
        let range = tile.range();
        columns.finish(range)?;
        Ok(tile)
    }

    fn summarize<T: Transmittance>(tile: &FragmentTile<T>, summary: &mut MapSummary) {
        for pair in tile.columns.offsets.windows(2) {
            let fragments = u64::from(pair[1] - pair[0]);
            summary.add("fragments", fragments);
            summary.max("max_fragments_per_pixel", fragments);
            summary.add("empty_pixels", u64::from(fragments == 0));
        }
        let facing: u64 = tile.columns.facing.iter().map(|word| u64::from(word.count_ones())).sum();
        summary.add("without_plane", facing);
    }

    /// The nearest first.
    fn contents<T: Transmittance>(tile: &FragmentTile<T>, pixel: usize) -> PixelContents {
        let mut contents = PixelContents::new("fragments", &["depth", "opacity", "covered 64ths"]);
        for fragment in tile.fragments(pixel).rev() {
            contents.push([
                PixelValue::Number(fragment.w.recip()),
                PixelValue::light(fragment.opacity),
                PixelValue::Count(fragment.coverage.count_ones()),
            ]);
        }
        contents
    }
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
        reader
            .for_each_pixel::<T>(0, |tile, pixel| Ok(columns.push_pixel(tile.fragments(pixel))?))?;
        let map = frame_of(reader).and_then(|frame| Self::new(frame, columns));
        reader.container().in_file(map.map_err(Error::from))
    }
}

/// Bakes a map of fragments into a file that replaces `output`, if there is one,
/// in tiles as `options` say. `describe` may add to what the map says of itself;
/// `watch` is told of rows of pixels before each, and may break it off. Holds the map.
///
/// # Errors
///
/// [`Error::HitSource`] with what the source says, [`Error::Interrupted`] if `watch`
/// broke it off, else what keeps the file from being written.
pub fn bake_fragments<T: Transmittance, S: HitSource<T>>(
    builder: &FragmentBuilder,
    source: &S,
    output: &Path,
    options: WriteOptions,
    describe: impl FnOnce(&mut Metadata),
    watch: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<BakeReport>
where
    S::Error: std::error::Error + Send + Sync + 'static,
{
    let built = builder.build_counted::<T, S>(source, watch);
    let built = built.map_err(|error| Error::HitSource(Box::new(error)))?;
    let (map, counts) = built.ok_or(Error::Interrupted)?;
    let [width, height] = map.size();
    let coverage = builder.coverage();
    let info = MapInfo::new().with_camera(*builder.camera()).with_samples(coverage * coverage);
    let mut metadata = Metadata::new(width, height, T::CHANNELS as u8, info);
    describe(&mut metadata);
    let layering = Layering {
        resets: 0,
        max_layers: builder.layers(),
        // The header keeps an f32; the camera was moved back by one.
        light_depth: builder.frame().light_depth() as f32,
    };
    let FragmentCounts { hits, cut_pixels, most_gained, mean_gained } = counts;
    let folded = Folded { pixels: cut_pixels, max: most_gained as f32, mean: mean_gained as f32 };
    let folded = (cut_pixels > 0).then_some(folded);
    let keys = FragmentKeys { layering, coverage, folded };
    let mut writer = KindWriter::<Fragments>::create(output, metadata, &keys, options)?;
    let level = writer.levels()[0];
    let [columns, rows] = level.tiles();
    for y in 0..rows {
        let encode = |x: u32| {
            let rect = level.tile_rect(x, y)?;
            let mut lists = FragmentColumns::new();
            let columns = rect.x..rect.x + rect.width;
            let mut places = (rect.y..rect.y + rect.height)
                .flat_map(|row| columns.clone().map(move |column| (column, row)));
            let pushed = places.try_for_each(|(x, y)| lists.push_pixel(map.pixel(x, y)));
            let tile = FragmentTile { size: [rect.width, rect.height], columns: lists };
            let encode = |()| Fragments::encode(&tile, Codec::Exact, options.packing);
            Some(pushed.map_err(Error::from).and_then(encode))
        };
        let tiles: Vec<_> = (0..columns).into_par_iter().map(encode).collect();
        for (x, encoded) in (0..columns).zip(tiles) {
            if let Some(encoded) = encoded {
                writer.write_encoded(TileId::new(0, x, y), &encoded?, AchievedError::NONE)?;
            }
        }
    }
    let gained = [most_gained, mean_gained].map(|gained| gained as f32);
    let bytes = writer.finish()?;
    Ok(BakeReport { hits, cut_pixels, gained, bytes, ..BakeReport::default() })
}
