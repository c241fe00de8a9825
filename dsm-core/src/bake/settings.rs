//! Settings of a bake.

use crate::camera::shadow_camera::ShadowCamera;
use crate::compress::compressor::Compression;
use crate::compress::quantization::Quantization;
use crate::compress::side::Side;
use crate::error::{Error, Result};
use crate::filter::{Filter, FilterShape};
use crate::hits::sampling::PixelSampling;
use crate::hits::tile_samples::MapCamera;
use crate::tolerance::Tolerance;

/// Resolution, sampling, filter and compression of a map to bake.
///
/// ```
/// use dsm_core::{BakeSettings, Filter, FilterShape};
///
/// let settings = BakeSettings::new([512, 512])?;
/// assert_eq!(settings.tolerance().epsilon(), 0.0625);
/// let settings = settings.with_filter(Filter::new(FilterShape::Box, 2.0)?);
/// assert_eq!(settings.tolerance().epsilon(), 0.03125);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BakeSettings {
    /// Width and height of the whole map in pixels, up to
    /// [`Self::MAX_SIZE`].
    pub size: [u32; 2],
    /// Width and height of a tile in pixels, up to [`Self::MAX_TILE_SIZE`].
    pub tile_size: u32,
    /// The part of the map to bake: x₀, y₀, x₁, y₁, half-open, on borders of
    /// tiles or of the map. Its tiles are those of the whole map.
    pub crop: Option<[u32; 4]>,
    /// The sample points of a pixel.
    pub sampling: PixelSampling,
    /// The pixel filter. Samples beyond the map's edge are requested too.
    pub filter: Filter,
    /// The error bound of every pixel; none: see [`Self::tolerance`].
    pub tolerance: Option<Tolerance>,
    /// The grids that vertices are rounded to; none: depths stay as the source
    /// gave them. Asks for a tolerance of at least
    /// [`Quantization::MIN_TOLERANCE`].
    pub quantization: Option<Quantization>,
    /// The compressor, and the side that it keeps to.
    pub compression: Compression,
    /// The camera whose NDC \[0, 1\]² covers the map. It tells how long rays
    /// are; without one they are as long as their depth.
    pub camera: Option<ShadowCamera>,
    /// Bytes that the depths and values of one tile may take, default 256 MiB: what
    /// readers of `.dsm` files accept. A tile is given up when it has more.
    pub max_tile_bytes: u64,
}

impl BakeSettings {
    /// The largest width or height of a map.
    pub const MAX_SIZE: u32 = 1 << 24;

    /// The largest width and height of a tile.
    pub const MAX_TILE_SIZE: u32 = 4096;

    /// The largest number of samples under the filter of one pixel.
    pub const MAX_SAMPLES_UNDER_FILTER: u64 = 1 << 20;

    /// A whole map of `size` pixels in tiles of 64: 16 samples a pixel with
    /// seed 0, a box filter of one pixel, the tolerance to match.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if a size is 0 or above [`Self::MAX_SIZE`].
    pub fn new(size: [u32; 2]) -> Result<Self> {
        let settings = Self {
            size,
            tile_size: 64,
            crop: None,
            sampling: PixelSampling::new(16, 0)?,
            filter: Filter::new(FilterShape::Box, 1.0)?,
            tolerance: None,
            quantization: None,
            compression: Compression::default(),
            camera: None,
            max_tile_bytes: 1 << 28,
        };
        settings.check().map(|_| settings)
    }

    /// Sets the width and height of a tile in pixels.
    #[must_use]
    pub fn with_tile_size(self, tile_size: u32) -> Self {
        Self { tile_size, ..self }
    }

    /// Sets the part of the map to bake: x₀, y₀, x₁, y₁, half-open; `None` for all.
    #[must_use]
    pub fn with_crop(self, crop: impl Into<Option<[u32; 4]>>) -> Self {
        Self { crop: crop.into(), ..self }
    }

    /// Sets the sample points of a pixel.
    #[must_use]
    pub fn with_sampling(self, sampling: PixelSampling) -> Self {
        Self { sampling, ..self }
    }

    /// Sets the pixel filter.
    #[must_use]
    pub fn with_filter(self, filter: Filter) -> Self {
        Self { filter, ..self }
    }

    /// Sets the error bound; `None` for the one that matches the samples.
    #[must_use]
    pub fn with_tolerance(self, tolerance: impl Into<Option<Tolerance>>) -> Self {
        Self { tolerance: tolerance.into(), ..self }
    }

    /// Sets the grids that vertices are rounded to; `None` for exact depths.
    #[must_use]
    pub fn with_quantization(self, quantization: impl Into<Option<Quantization>>) -> Self {
        Self { quantization: quantization.into(), ..self }
    }

    /// Sets the compressor.
    #[must_use]
    pub fn with_compression(self, compression: Compression) -> Self {
        Self { compression, ..self }
    }

    /// Sets the camera whose NDC \[0, 1\]² covers the map.
    #[must_use]
    pub fn with_camera(self, camera: impl Into<Option<ShadowCamera>>) -> Self {
        Self { camera: camera.into(), ..self }
    }

    /// The tolerance: as it was set, or 0.25/√N, where N is the number of
    /// evenly weighted samples that are as noisy as those under the filter
    /// (Lokovic & Veach 2000, §4).
    #[must_use]
    pub fn tolerance(&self) -> Tolerance {
        let samples = f64::from(self.sampling.samples_per_pixel());
        let auto = || Tolerance::for_effective_samples(samples * self.filter.effective_pixels());
        self.tolerance.unwrap_or_else(auto)
    }

    /// Number of pixels beyond a pixel that the filter reaches.
    pub(super) fn border(&self) -> u32 {
        // Saturates, and `check` refuses that.
        self.filter.border() as u32
    }

    /// Checks the settings, and makes the rays of the camera.
    pub(super) fn check(&self) -> Result<Option<MapCamera>> {
        let refuse = |setting, reason| Err(Error::Setting { setting, reason });
        if !self.size.iter().all(|size| (1..=Self::MAX_SIZE).contains(size)) {
            return refuse("size", "must be 1 to 2²⁴ pixels per side");
        }
        if !(1..=Self::MAX_TILE_SIZE).contains(&self.tile_size) {
            return refuse("tile size", "must be 1 to 4096 pixels per side");
        }
        let side = 2 * u64::from(self.border().min(Self::MAX_TILE_SIZE)) + 1;
        let samples = side * side * u64::from(self.sampling.samples_per_pixel());
        if samples > Self::MAX_SAMPLES_UNDER_FILTER {
            return refuse("filter", "must cover at most 2²⁰ samples");
        }
        let min = Quantization::MIN_TOLERANCE;
        self.compression.check()?;
        if self.quantization.is_some() && self.compression.side == Side::Darker {
            return refuse("side", "depths on grids lie behind, where V is lighter");
        }
        if self.quantization.is_some() && self.tolerance().epsilon() < min {
            return refuse("quantization", "needs a tolerance of at least 2⁻¹⁶");
        }
        let [left, top, right, bottom] = self.window();
        for (start, end, size) in [(left, right, self.size[0]), (top, bottom, self.size[1])] {
            if start >= end || end > size {
                return refuse("crop", "must be a non-empty part of the map");
            }
            let on_border = |edge: u32| edge.is_multiple_of(self.tile_size) || edge == size;
            if !(on_border(start) && on_border(end)) {
                return refuse("crop", "edges must lie on tile borders");
            }
        }
        self.camera.as_ref().map(|camera| MapCamera::new(camera, self.size)).transpose()
    }

    /// The part of the map to bake: x₀, y₀, x₁, y₁.
    #[must_use]
    pub fn window(&self) -> [u32; 4] {
        self.crop.unwrap_or([0, 0, self.size[0], self.size[1]])
    }

    /// The tiles to bake, row by row: column and row among those of the whole
    /// map.
    pub fn tiles(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let (columns, rows) = self.tile_ranges();
        rows.flat_map(move |row| columns.clone().map(move |column| [column, row]))
    }

    /// Number of tiles to bake.
    #[must_use]
    pub fn tile_count(&self) -> u64 {
        let (columns, rows) = self.tile_ranges();
        columns.len() as u64 * rows.len() as u64
    }

    /// The tile that is number `index` of [`Self::tiles`].
    pub(super) fn tile(&self, index: u64) -> [u32; 2] {
        let (columns, rows) = self.tile_ranges();
        let width = columns.len() as u64;
        [columns.start + (index % width) as u32, rows.start + (index / width) as u32]
    }

    fn tile_ranges(&self) -> (std::ops::Range<u32>, std::ops::Range<u32>) {
        let tile = self.tile_size.max(1);
        let [left, top, right, bottom] = self.window();
        (left / tile..right.div_ceil(tile), top / tile..bottom.div_ceil(tile))
    }

    /// The pixels of a tile.
    pub(super) fn tile_pixels(&self, tile: [u32; 2]) -> Block {
        let min = tile.map(|index| index.saturating_mul(self.tile_size));
        let size = [0, 1].map(|axis| self.size[axis].saturating_sub(min[axis]).min(self.tile_size));
        Block { min, size }
    }
}

/// A rectangle of pixels: a tile or a part of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Block {
    pub(super) min: [u32; 2],
    pub(super) size: [u32; 2],
}

impl Block {
    /// Samples that a block holds at most, unless one pixel needs more: they
    /// and their hits should fit a core's cache.
    const SAMPLES: u64 = 1 << 14;

    /// Samples that a block holds at most where a filter reaches over the border,
    /// so that the part that is sampled twice stays small.
    const SAMPLES_WITH_BORDER: u64 = 1 << 18;

    /// Columns and rows within the block, row by row.
    pub(super) fn places(self) -> impl Iterator<Item = [u32; 2]> {
        let [width, height] = self.size;
        (0..height).flat_map(move |row| (0..width).map(move |column| [column, row]))
    }

    /// Cuts the block in halves until they are small enough, and hands them to
    /// `visit`.
    pub(super) fn split<E>(
        self,
        settings: &BakeSettings,
        visit: &mut impl FnMut(Self) -> std::result::Result<(), E>,
    ) -> std::result::Result<(), E> {
        let border = settings.border();
        let limit = if border == 0 { Self::SAMPLES } else { Self::SAMPLES_WITH_BORDER };
        let [width, height] = self.size.map(|size| u64::from(size + 2 * border));
        let samples = width * height * u64::from(settings.sampling.samples_per_pixel());
        let axis = usize::from(self.size[1] >= self.size[0]);
        if samples <= limit || self.size[axis] == 1 {
            return visit(self);
        }
        let near = self.size[axis].div_ceil(2);
        let (mut first, mut second) = (self, self);
        first.size[axis] = near;
        second.min[axis] += near;
        second.size[axis] -= near;
        first.split(settings, visit)?;
        second.split(settings, visit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> BakeSettings {
        BakeSettings::new([100, 70]).unwrap()
    }

    #[test]
    fn impossible_settings_are_refused() {
        assert!(BakeSettings::new([0, 1]).is_err());
        assert!(BakeSettings::new([1, (1 << 24) + 1]).is_err());
        let wide = Filter::new(FilterShape::Box, 3e9).unwrap();
        let huge = Filter::new(FilterShape::Box, 257.0).unwrap();
        let half = ShadowCamera::default();
        let changes: [fn(&mut BakeSettings); 6] = [
            |settings| settings.tile_size = 0,
            |settings| settings.tile_size = 5000,
            |settings| settings.crop = Some([0, 0, 0, 64]),
            |settings| settings.crop = Some([64, 0, 128, 64]),
            |settings| settings.crop = Some([0, 0, 65, 64]),
            |settings| settings.crop = Some([1, 0, 64, 64]),
        ];
        for change in changes {
            let mut settings = settings();
            change(&mut settings);
            assert!(settings.check().is_err(), "{settings:?}");
        }
        assert!(BakeSettings { filter: wide, ..settings() }.check().is_err());
        assert!(BakeSettings { filter: huge, ..settings() }.check().is_err());
        assert!(BakeSettings { camera: Some(half), ..settings() }.check().is_err());
        assert!(settings().check().is_ok());
    }

    #[test]
    fn a_crop_has_the_tiles_of_the_whole() {
        let mut settings = settings();
        assert!(settings.tiles().eq([[0, 0], [1, 0], [0, 1], [1, 1]]));
        settings.crop = Some([64, 0, 100, 70]);
        assert!(settings.check().is_ok());
        assert!(settings.tiles().eq([[1, 0], [1, 1]]));
        assert_eq!(settings.tile_count(), 2);
        assert_eq!(settings.tile(1), [1, 1]);
        assert_eq!(settings.tile_pixels([1, 1]), Block { min: [64, 64], size: [36, 6] });
    }

    #[test]
    fn blocks_cover_a_tile_once() {
        for (samples, width, limit) in
            [(16, 1.0, 1 << 14), (250, 1.0, 1 << 14), (4096, 2.0, 1 << 18)]
        {
            let mut settings = settings();
            settings.sampling = PixelSampling::new(samples, 0).unwrap();
            settings.filter = Filter::new(FilterShape::Box, width).unwrap();
            let mut covered = vec![0; 100 * 70];
            let tile = settings.tile_pixels([0, 0]);
            let split = tile.split::<()>(&settings, &mut |block: Block| {
                let [width, height] = block.size.map(|size| size + 2 * settings.border());
                assert!(width * height * samples <= limit, "{block:?}");
                for y in block.min[1]..block.min[1] + block.size[1] {
                    for x in block.min[0]..block.min[0] + block.size[0] {
                        covered[(y * 100 + x) as usize] += 1;
                    }
                }
                Ok(())
            });
            assert!(split.is_ok());
            let inside = |(pixel, count): (usize, &i32)| {
                *count == i32::from(pixel % 100 < 64 && pixel / 100 < 64)
            };
            assert!(covered.iter().enumerate().all(inside));
        }
    }
}
