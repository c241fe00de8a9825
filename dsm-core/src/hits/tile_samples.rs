//! The sample points of a block of pixels, in columns.

use std::ops::Range;

use super::sampling::PixelSampling;
use crate::camera::shadow_camera::{RayDirections, ShadowCamera};
use crate::error::{Error, Result};

/// A point of the image plane at a time: one ray of the shadow camera.
///
/// ```
/// use dsm_core::{PixelSampling, TileSamples};
///
/// let samples = TileSamples::new(&PixelSampling::centre(), [3, 1], [1, 1], None)?;
/// let point = samples.point(0);
/// assert_eq!([point.x, point.y], [3.5, 1.5]);
/// assert_eq!(point.distance_per_depth, 1.0);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplePoint {
    /// Raster position in pixels, x right, from the left edge of the map's
    /// first pixel. Filters that reach over the map's edge ask for points
    /// beyond it.
    pub x: f64,
    /// Raster position in pixels, y down.
    pub y: f64,
    /// Time in [0, 1]: 0 where the shutter opens, 1 where it closes.
    pub time: f32,
    /// Distance along this ray per unit of depth, ≥ 1: an argument of
    /// [`crate::RayHits::push_volume`] and [`crate::TileHits::push_volume`]
    /// (Lokovic & Veach 2000, footnote 3). 1 without a camera.
    pub distance_per_depth: f64,
}

/// The sample points of a rectangle of pixels: those of pixel (column, row) are
/// numbers (row · width + column) · N to (… + 1) · N for N samples a pixel.
/// Positions and times are columns.
///
/// ```
/// use dsm_core::{PixelSampling, TileSamples};
///
/// // 4 samples in each of 2 × 1 pixels.
/// let samples = TileSamples::new(&PixelSampling::new(4, 0)?, [0, 0], [2, 1], None)?;
/// assert_eq!(samples.len(), 8);
/// assert_eq!(samples.pixel(1, 0), 4..8);
/// assert!(samples.x()[4..8].iter().all(|&x| (1.0..2.0).contains(&x)));
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct TileSamples {
    min: [i32; 2],
    size: [u32; 2],
    per_pixel: u32,
    x: Vec<f64>,
    y: Vec<f64>,
    times: Vec<f32>,
    camera: Option<MapCamera>,
}

/// The rays of a camera whose NDC [0, 1]² covers a map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MapCamera {
    directions: RayDirections,
    per_pixel: [f64; 2],
}

impl MapCamera {
    /// The rays through a map of `size` pixels.
    pub(crate) fn new(camera: &ShadowCamera, size: [u32; 2]) -> Result<Self> {
        let directions = RayDirections::new(camera)?;
        Ok(Self { directions, per_pixel: size.map(|count| f64::from(count).recip()) })
    }

    fn distance_per_depth(&self, x: f64, y: f64) -> f64 {
        self.directions.distance_per_depth(x * self.per_pixel[0], y * self.per_pixel[1])
    }
}

impl TileSamples {
    /// The samples of the pixels from `min` on, `size` of them. `camera`, with
    /// the size of the whole map that its NDC [0, 1]² covers, tells
    /// [`SamplePoint::distance_per_depth`]; without one it is 1.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] if there are 2³² samples or more or the pixels
    /// leave the range of `i32`, [`Error::Camera`] if a matrix of the camera
    /// is unknown.
    pub fn new(
        sampling: &PixelSampling,
        min: [i32; 2],
        size: [u32; 2],
        camera: Option<(&ShadowCamera, [u32; 2])>,
    ) -> Result<Self> {
        let camera = camera.map(|(camera, size)| MapCamera::new(camera, size)).transpose()?;
        let mut samples = Self::empty(camera);
        samples.fill(sampling, min, size)?;
        Ok(samples)
    }

    /// No samples, along the rays of `camera`.
    pub(crate) const fn empty(camera: Option<MapCamera>) -> Self {
        Self {
            min: [0; 2],
            size: [0; 2],
            per_pixel: 1,
            x: Vec::new(),
            y: Vec::new(),
            times: Vec::new(),
            camera,
        }
    }

    /// Replaces the samples by those of other pixels; keeps the memory.
    pub(crate) fn fill(
        &mut self,
        sampling: &PixelSampling,
        min: [i32; 2],
        size: [u32; 2],
    ) -> Result<()> {
        let per_pixel = sampling.samples_per_pixel();
        let count = u64::from(size[0]).saturating_mul(size[1].into());
        let count = count.saturating_mul(per_pixel.into());
        let limit = u64::from(u32::MAX);
        if count > limit {
            return Err(Error::TooLarge { what: "samples in one block of pixels", count, limit });
        }
        for axis in 0..2 {
            if min[axis].checked_add_unsigned(size[axis]).is_none() {
                let count = size[axis].into();
                return Err(Error::TooLarge { what: "pixels of a map", count, limit: 1 << 31 });
            }
        }
        (self.min, self.size, self.per_pixel) = (min, size, per_pixel);
        let Self { x: xs, y: ys, times, .. } = self;
        xs.clear();
        ys.clear();
        times.clear();
        let count = count as usize;
        xs.reserve(count);
        ys.reserve(count);
        times.reserve(count);
        let mut order = Vec::new();
        for row in (min[1]..).take(size[1] as usize) {
            for column in (min[0]..).take(size[0] as usize) {
                sampling.sample([column, row], &mut order, |x, y, time| {
                    xs.push(f64::from(column) + x);
                    ys.push(f64::from(row) + y);
                    times.push(time);
                });
            }
        }
        Ok(())
    }

    /// The upper left pixel.
    #[must_use]
    pub const fn min(&self) -> [i32; 2] {
        self.min
    }

    /// Width and height in pixels.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Samples a pixel.
    #[must_use]
    pub const fn samples_per_pixel(&self) -> u32 {
        self.per_pixel
    }

    /// Number of samples.
    #[must_use]
    pub const fn len(&self) -> u32 {
        // `fill` keeps it below 2³².
        self.x.len() as u32
    }

    /// True if there is no sample.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Horizontal raster positions.
    #[must_use]
    pub fn x(&self) -> &[f64] {
        &self.x
    }

    /// Vertical raster positions.
    #[must_use]
    pub fn y(&self) -> &[f64] {
        &self.y
    }

    /// Times.
    #[must_use]
    pub fn times(&self) -> &[f32] {
        &self.times
    }

    /// The samples of the pixel in column `x` and row `y` from [`Self::min`]
    /// on.
    #[must_use]
    pub const fn pixel(&self, x: u32, y: u32) -> Range<u32> {
        let first = (y * self.size[0] + x) * self.per_pixel;
        first..first + self.per_pixel
    }

    /// Sample number `index`.
    ///
    /// # Panics
    ///
    /// If `index` is not below [`Self::len`].
    #[must_use]
    pub fn point(&self, index: u32) -> SamplePoint {
        let index = index as usize;
        let (x, y, time) = (self.x[index], self.y[index], self.times[index]);
        let camera = self.camera.as_ref();
        let distance_per_depth = camera.map_or(1.0, |camera| camera.distance_per_depth(x, y));
        SamplePoint { x, y, time, distance_per_depth }
    }

    /// All samples, in order.
    pub fn points(&self) -> impl ExactSizeIterator<Item = SamplePoint> + '_ {
        (0..self.len()).map(|index| self.point(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat4, DVec4};

    #[test]
    fn pixels_stand_row_by_row() {
        let sampling = PixelSampling::new(3, 0).unwrap();
        let samples = TileSamples::new(&sampling, [-2, 10], [3, 2], None).unwrap();
        assert_eq!((samples.len(), samples.pixel(2, 1)), (18, 15..18));
        for index in samples.pixel(2, 1) {
            let point = samples.point(index);
            assert_eq!((point.x.floor(), point.y.floor()), (0.0, 11.0));
            assert_eq!(point.distance_per_depth, 1.0);
        }
    }

    #[test]
    fn a_perspective_camera_lengthens_rays() {
        let projection = DMat4::from_rows(
            DVec4::new(0.5, 0.0, -0.5, 0.0),
            DVec4::new(0.0, -0.5, -0.5, 0.0),
            DVec4::Z,
            DVec4::new(0.0, 0.0, -1.0, 0.0),
        );
        let camera =
            ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: Some(projection) };
        let sampling = PixelSampling::centre();
        let samples = TileSamples::new(&sampling, [0, 0], [5, 3], Some((&camera, [5, 3]))).unwrap();
        assert_eq!(samples.point(7).distance_per_depth, 1.0);
        // NDC 0.1 of a view of 90 degrees: 0.8 sideways per unit of depth.
        assert!((samples.point(5).distance_per_depth - 1.64_f64.sqrt()).abs() < 1e-7);
        let half = ShadowCamera { world_to_ndc: None, ..camera };
        assert!(TileSamples::new(&sampling, [0, 0], [1, 1], Some((&half, [1, 1]))).is_err());
    }

    #[test]
    fn too_many_samples_are_refused_before_they_take_memory() {
        let sampling = PixelSampling::new(4096, 0).unwrap();
        assert!(TileSamples::new(&sampling, [0, 0], [1 << 10, 1 << 10], None).is_err());
        assert!(TileSamples::new(&sampling, [0, 0], [u32::MAX, u32::MAX], None).is_err());
        let centre = PixelSampling::centre();
        assert!(TileSamples::new(&centre, [i32::MAX - 1, 0], [2, 1], None).is_err());
    }
}
