//! Kind `views`: depth images from several points of a light in `.dsm` files, as
//! `docs/format/dsm-1.md`, section 13, defines it.

use dsm_core::Transmittance;
use dsm_io::detail::{
    ColumnReader, EncodedTile, KindReader, Level, MapKind, PixelValue, Result, StoredTile,
    TileColumn,
};
use dsm_io::{Codec, Error, MapSummary, Metadata, Packing, PixelContents};
use dsm_trace::detail::LightFrame;
use glam::DVec3;

use super::depth_view::DepthView;
use super::keys::ViewsKeys;
use super::tracer::ViewsTracer;
use super::view_tile::ViewTile;

/// The kind `views`: the nearest surfaces that several points of a light see, a level each.
///
/// ```no_run
/// use dsm_io::Limits;
/// use dsm_io::detail::KindReader;
/// use shadow_maps::detail::{Views, ViewsTracer};
///
/// let reader = KindReader::<Views>::open("leaves.dsm", &Limits::default())?;
/// let tracer = ViewsTracer::read(&reader)?.with_rays(256);
/// # Ok::<(), dsm_io::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Views;

impl MapKind for Views {
    const NAME: &'static str = "views";
    const TITLE: &'static str = "a map of views";

    const CROPS: bool = true;

    type Keys = ViewsKeys;
    type Tile<T: Transmittance> = ViewTile;

    fn has_errors(_: &ViewsKeys) -> bool {
        false
    }

    fn check(metadata: &Metadata, keys: &ViewsKeys) -> Result<()> {
        let is_exact = metadata.info.tolerance.epsilon() <= 0.0 && metadata.channels == 1;
        let inexact = "maps of this kind have a tolerance of 0 and one channel";
        match keys.broken_rule().or((!is_exact).then_some(inexact)) {
            Some(rule) => Err(Error::Metadata(rule.to_owned())),
            None => Ok(()),
        }
    }

    fn check_levels(levels: &[Level], keys: &ViewsKeys) -> Result<()> {
        let broken = keys.broken_rule_of_levels(levels);
        broken.map_or(Ok(()), |rule| Err(Error::Metadata(rule.to_owned())))
    }

    fn encode<T: Transmittance>(
        tile: &ViewTile,
        codec: Codec,
        packing: Packing,
    ) -> Result<EncodedTile> {
        if codec != Codec::Exact {
            return Err(Error::Setting("maps of views are stored exactly".into()));
        }
        let (count, range) = tile.seen();
        if count == 0 {
            return Ok(EncodedTile::default());
        }
        EncodedTile::of_columns(&[TileColumn::of_floats(tile.w())], count, range, packing)
    }

    fn empty<T: Transmittance>(size: [u32; 2], _: &ViewsKeys) -> Result<ViewTile> {
        Ok(ViewTile::empty(size))
    }

    fn decode<T: Transmittance>(stored: StoredTile<'_>, _: &ViewsKeys) -> Result<ViewTile> {
        let (size, pixels) = (stored.size(), stored.pixel_count());
        let mut columns: ColumnReader<'_> = stored.columns()?;
        let tile = ViewTile { size, w: columns.take_floats(pixels)? };
        if !tile.w.iter().all(|w| (0.0..f32::INFINITY).contains(w)) {
            return Err(columns.refuse("1 / depth must be finite and not negative"));
        }
        let (count, range) = tile.seen();
        if count == 0 || count != columns.entry().vertex_count {
            return Err(columns.refuse("it does not see as many surfaces as it says"));
        }
        columns.finish(range)?;
        Ok(tile)
    }

    fn summarize<T: Transmittance>(tile: &ViewTile, summary: &mut MapSummary) {
        let (count, _) = tile.seen();
        summary.add("surfaces", count);
        summary.add("empty_pixels", tile.w.len() as u64 - count);
    }

    fn contents<T: Transmittance>(tile: &ViewTile, pixel: usize) -> PixelContents {
        let mut contents = PixelContents::new("surfaces", &["depth"]);
        let w = tile.w[pixel];
        if w > 0.0 {
            contents.push([PixelValue::Number(w.recip().min(f32::MAX))]);
        }
        contents
    }
}

impl ViewsTracer {
    /// The tracer of a file's views. Reads all of them. O(pixels · log side).
    ///
    /// # Errors
    ///
    /// [`Error::Limit`] for a map that is too large, [`Error::Core`] for more than
    /// [`Self::MAX_PIXELS`] or a camera that is no perspective one, or what is wrong with a
    /// tile.
    pub fn read(reader: &KindReader<Views>) -> Result<Self> {
        let metadata = reader.metadata();
        let camera = metadata.info.camera.unwrap_or_default();
        let frame = LightFrame::new(&camera, [metadata.width, metadata.height], 0.0);
        let frame = reader.container().in_file(frame.map_err(Error::from))?;
        let size = [metadata.width, metadata.height];
        let eyes = reader.keys().eyes.len() as u64;
        reader.container().in_file(Self::check_pixels(size, eyes).map_err(Error::from))?;
        let mut views = Vec::new();
        for (level, &eye) in (0..).zip(&reader.keys().eyes) {
            reader.check_in_memory(level)?;
            let mut w = Vec::new();
            reader.for_each_pixel::<f32>(level, |tile, pixel| {
                w.push(tile.w()[pixel]);
                Ok(())
            })?;
            let gap = f64::from(reader.keys().gap);
            views.push(DepthView::new(frame.moved(DVec3::from(eye)), w, gap)?);
        }
        Ok(Self::new(views)?.with_frame(frame))
    }
}
