//! Maps of views from what points of a light see.

use std::ops::ControlFlow;
use std::path::Path;

use dsm_core::detail::Result as CoreResult;
use dsm_core::{
    AreaLight, Error as CoreError, HitSource, MapInfo, PixelSampling, ShadowCamera, TileHits,
    TileSamples, Transmittance,
};
use dsm_io::detail::{BakeReport, Crop, EncodedTile, KindWriter, Level, MapKind, Result, TileId};
use dsm_io::{AchievedError, Metadata, WriteOptions};
use dsm_trace::detail::LightFrame;
use glam::DVec3;
use rayon::prelude::*;

use super::depth_view::DepthView;
use super::keys::ViewsKeys;
use super::store::Views;
use super::tracer::ViewsTracer;
use super::view_tile::ViewTile;

/// Pixels along the side of what is asked for at once.
const TILE: u32 = 16;

/// Sees through the middles of the pixels of views that look the same way as the light's
/// own.
///
/// A pixel has the depth of the first surface behind which no more than half of the light
/// is left, in the mean over channels.
#[derive(Clone, Debug)]
pub struct ViewsBuilder {
    camera: ShadowCamera,
    frame: LightFrame,
    gap: f64,
    eyes: Vec<[f64; 3]>,
    views: Vec<Vec<f32>>,
    hits: u64,
    crop: Option<Crop>,
    /// First column and row that are looked at, and the size: all that the crop's blocks touch.
    window: [[u32; 2]; 2],
}

/// The points of a light that see for it: its middle; two opposite corners; the corners; of
/// another square number a grid that reaches them; of any other points spread over it; of a
/// light without size its middle, whatever `count`. Of a disk, or the disk that `towards` sees of a sphere, corners are where the light's square
/// is mapped to.
#[must_use]
pub fn view_points(light: &AreaLight, towards: DVec3, count: u32) -> Vec<DVec3> {
    let at = |u: f64, v: f64| light.at(towards, u, v);
    let side = count.isqrt();
    match count {
        _ if light.half_axes() == [DVec3::ZERO; 2] => vec![light.centre()],
        0 | 1 => vec![light.centre()],
        2 => vec![at(0.0, 0.0), at(1.0, 1.0)],
        _ if side * side == count => {
            let share = |step: u32| f64::from(step) / f64::from(side - 1);
            (0..count).map(|index| at(share(index % side), share(index / side))).collect()
        }
        _ => light.samples(towards, count, 0).collect(),
    }
}

impl ViewsBuilder {
    /// For a map of `size` pixels that `camera`'s NDC \[0, 1\]² covers; it stands in the
    /// light's centre.
    ///
    /// # Errors
    ///
    /// As [`LightFrame::new`].
    pub fn new(camera: ShadowCamera, size: [u32; 2]) -> CoreResult<Self> {
        let frame = LightFrame::new(&camera, size, 0.0)?;
        let (eyes, views) = (Vec::new(), Vec::new());
        let (crop, window) = (None, [[0, 0], size]);
        Ok(Self { camera, frame, gap: DepthView::GAP, eyes, views, hits: 0, crop, window })
    }

    /// The same for a crop of the map, before the first view: whole blocks around it are
    /// looked at, so that its pixels are the whole map's. It can be written, not traced.
    #[must_use]
    pub fn with_crop(self, crop: Option<Crop>) -> Self {
        let Some(Crop { x, y, width, height }) = crop else { return self };
        let [right, bottom] = self.frame.size();
        let axis = |first: u32, length: u32, end: u32| {
            let start = first / TILE * TILE;
            [start, (first + length).next_multiple_of(TILE).min(end) - start]
        };
        let ([left, width], [top, height]) = (axis(x, width, right), axis(y, height, bottom));
        Self { crop, window: [[left, top], [width, height]], ..self }
    }

    /// The frame of the map.
    #[must_use]
    pub const fn frame(&self) -> &LightFrame {
        &self.frame
    }

    /// Rows of blocks of each view.
    #[must_use]
    pub const fn rows(&self) -> u32 {
        self.window[1][1].div_ceil(TILE)
    }

    /// Whether so many views of this size are too many to be traced.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`](CoreError::TooLarge) past [`ViewsKeys::MAX_VIEWS`] or
    /// [`ViewsTracer::MAX_PIXELS`].
    pub fn check_count(&self, count: u64) -> CoreResult<()> {
        let limit = ViewsKeys::MAX_VIEWS as u64;
        if count > limit {
            return Err(CoreError::TooLarge { what: "views", count, limit });
        }
        ViewsTracer::check_pixels(self.frame.size(), count)
    }

    /// Adds a view from `eye`, a point of the world: `source` shows it, through `camera`,
    /// which stands there and looks the same way as the map's. `watch` is told of rows of
    /// 16 pixels and may break it off. In parallel.
    ///
    /// # Errors
    ///
    /// Those of the source and of [`Self::check_count`];
    /// [`Error::Setting`](CoreError::Setting) if it shows media.
    pub fn add_view<T: Transmittance, S: HitSource<T>>(
        &mut self,
        source: &S,
        (eye, camera): (DVec3, &ShadowCamera),
        mut watch: impl FnMut() -> ControlFlow<()>,
    ) -> std::result::Result<ControlFlow<()>, S::Error> {
        self.check_count(self.views.len() as u64 + 1)?;
        let [[left, upper], [width, height]] = self.window;
        let mut w = vec![0.0_f32; width as usize * height as usize];
        for (row, rows) in (0..).zip(w.chunks_mut((TILE * width) as usize)) {
            if watch().is_break() {
                return Ok(ControlFlow::Break(()));
            }
            let top = row * TILE;
            let blocks: std::result::Result<Vec<_>, S::Error> = (0..width.div_ceil(TILE))
                .into_par_iter()
                .map_init(
                    || TileHits::new(0),
                    |hits, column| {
                        let min = [column * TILE, top];
                        let size = [width - min[0], height - min[1]].map(|side| side.min(TILE));
                        self.block(source, camera, ([min[0] + left, min[1] + upper], size), hits)
                    },
                )
                .collect();
            for (column, (block, met)) in (0..).zip(blocks?) {
                self.hits += met;
                let wide = (width - column * TILE).min(TILE) as usize;
                for (own, row) in block.chunks(wide).zip(rows.chunks_mut(width as usize)) {
                    let left = (column * TILE) as usize;
                    row[left..left + wide].copy_from_slice(own);
                }
            }
        }
        let offset = self.frame.basis().transpose() * (eye - self.frame.light_centre());
        // No sign of 0, which headers would keep.
        self.eyes.push(offset.to_array().map(|at| at + 0.0));
        self.views.push(w);
        Ok(ControlFlow::Continue(()))
    }

    fn block<T: Transmittance, S: HitSource<T>>(
        &self,
        source: &S,
        camera: &ShadowCamera,
        (min, size): ([u32; 2], [u32; 2]),
        hits: &mut TileHits<T>,
    ) -> std::result::Result<(Vec<f32>, u64), S::Error> {
        // Maps have at most 2²⁴ pixels a side.
        let corner = min.map(|side| side as i32);
        let camera = Some((camera, self.frame.size()));
        let samples = TileSamples::new(&PixelSampling::centre(), corner, size, camera)?;
        hits.reset(samples.len());
        source.hits(&samples, hits)?;
        if !hits.segments().is_empty() {
            let reason = "a map of views holds surfaces, no media";
            return Err(CoreError::Setting { setting: "scene", reason }.into());
        }
        let mut met: Vec<(u32, f32, T)> =
            hits.surfaces().map(|(sample, hit)| (sample, hit.depth, hit.opacity)).collect();
        met.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut w = vec![0.0; samples.len() as usize];
        let (mut pixel, mut left) = (None, T::CLEAR);
        for &(sample, depth, opacity) in met.iter().filter(|(_, depth, _)| *depth > 0.0) {
            if pixel.replace(sample) != Some(sample) {
                left = T::CLEAR;
            }
            left = T::from_channels(|c| left.channel(c) * (1.0 - opacity.channel(c)));
            let mean = left.to_sum().as_ref().iter().sum::<f64>() / T::CHANNELS as f64;
            let at = &mut w[sample as usize];
            if *at <= 0.0 && mean <= 0.5 {
                *at = depth.recip().min(f32::MAX);
            }
        }
        Ok((w, met.len() as u64))
    }

    /// The tracer of all views so far. Copies them. O(pixels · log side).
    ///
    /// # Errors
    ///
    /// As [`DepthView::new`] and [`ViewsTracer::new`]; [`Error::Setting`](CoreError::Setting)
    /// for a crop.
    pub fn tracer(&self) -> CoreResult<ViewsTracer> {
        if self.crop.is_some() {
            let reason = "a part of a map cannot be traced";
            return Err(CoreError::Setting { setting: "crop", reason });
        }
        let views = self.eyes.iter().zip(&self.views);
        let view = |(&eye, w): (&[f64; 3], &Vec<f32>)| {
            DepthView::new(self.frame.moved(DVec3::from(eye)), w.clone(), self.gap)
        };
        let views = views.map(view).collect::<CoreResult<_>>()?;
        Ok(ViewsTracer::new(views)?.with_frame(self.frame))
    }

    /// Writes all views into a file that replaces `output`, if there is one, in tiles as
    /// `options` say. `describe` may add to what the map says of itself, such as its light.
    ///
    /// # Errors
    ///
    /// What keeps the file from being written.
    pub fn write(
        &self,
        output: &Path,
        options: WriteOptions,
        describe: impl FnOnce(&mut Metadata),
    ) -> Result<BakeReport> {
        let [width, height] = self.frame.size();
        let info = MapInfo::new().with_camera(self.camera).with_samples(1);
        let mut metadata = Metadata::new(width, height, 1, info);
        describe(&mut metadata);
        let keys = ViewsKeys { eyes: self.eyes.clone(), gap: self.gap as f32 };
        let mut writer =
            KindWriter::<Views>::create_part(output, metadata, self.crop, &keys, options)?;
        let finest = writer.levels()[0];
        for view in 1..self.views.len() as u32 {
            writer.add_level(Level { view, number: 0, ..finest })?;
        }
        let [origin, [stride, _]] = self.window;
        let corner = self.crop.map_or([0, 0], |crop| [crop.x, crop.y]);
        let inset = [0, 1].map(|axis| corner[axis] - origin[axis]);
        for (index, w) in (0..).zip(&self.views) {
            let level = writer.levels()[index as usize];
            let [columns, rows] = level.tiles();
            for y in 0..rows {
                let encoded = |x: u32| -> Result<EncodedTile> {
                    let Some(rect) = level.tile_rect(x, y) else {
                        return Ok(EncodedTile::default());
                    };
                    let mut tile = ViewTile::empty([rect.width, rect.height]);
                    let lines = tile.w.chunks_mut(rect.width as usize);
                    for (row, line) in (rect.y..).zip(lines) {
                        let row = (row + inset[1]) as usize;
                        let start = row * stride as usize + (rect.x + inset[0]) as usize;
                        line.copy_from_slice(&w[start..start + rect.width as usize]);
                    }
                    Views::encode::<f32>(&tile, options.codec, options.packing)
                };
                let tiles: Vec<_> = (0..columns).into_par_iter().map(encoded).collect();
                for (x, tile) in (0..columns).zip(tiles) {
                    writer.write_encoded(TileId::new(index, x, y), &tile?, AchievedError::NONE)?;
                }
            }
        }
        let bytes = writer.finish()?;
        Ok(BakeReport { hits: self.hits, bytes, ..BakeReport::default() })
    }
}
