//! Plain shadow maps: one depth a sample (Williams 1978; the "normal shadow
//! map" of Lokovic & Veach 2000, §2 and §6).

use dsm_core::detail::Result;
use dsm_core::{
    Error, HitSource, PixelSampling, ShadowCamera, TileHits, TileSamples, Transmittance,
};
use rayon::prelude::*;

use super::blocking::{Blocking, NearestDepths};

/// Samples of one block of pixels that are asked at once.
const BLOCK_SAMPLES: u32 = 1 << 16;

/// Pixels along a side of a block at most.
const BLOCK_SIDE: u32 = 64;

/// Settings of sampling a [`DepthMap`].
///
/// ```
/// use shadow_maps::detail::Blocking;
/// use shadow_maps::plain::DepthMapSettings;
///
/// let mut settings = DepthMapSettings::new([256, 256], 16)?;
/// settings.blocking = Blocking::Opaque;
/// assert_eq!(settings.texels()?, [1024, 1024]);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMapSettings {
    /// Width and height in pixels: what raster positions count.
    pub size: [u32; 2],
    /// The sample points of a pixel, a square number of them. A deep map with
    /// the same sampling looks along the same rays.
    pub sampling: PixelSampling,
    /// The occluder of a sample's ray.
    pub blocking: Blocking,
    /// The camera whose NDC \[0, 1\]² covers the map: receivers in the world
    /// need it, and media.
    pub camera: Option<ShadowCamera>,
}

impl DepthMapSettings {
    /// `samples` jittered samples a pixel with seed 0, each stopped by the
    /// first surface at random ([`Blocking::Stochastic`]).
    ///
    /// # Errors
    ///
    /// As [`PixelSampling::new`] and [`Self::texels`].
    pub fn new(size: [u32; 2], samples: u32) -> Result<Self> {
        let sampling = PixelSampling::new(samples, 0)?;
        let settings = Self { size, sampling, blocking: Blocking::default(), camera: None };
        settings.texels().map(|_| settings)
    }

    /// Depths in a row and in a column of the map.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if a size is 0 or the number of samples is no square
    /// number, [`Error::TooLarge`] beyond [`DepthMap::MAX_TEXELS`].
    pub fn texels(&self) -> Result<[u32; 2]> {
        let samples = self.sampling.samples_per_pixel();
        let side = samples.isqrt();
        if side * side != samples {
            let reason = "a depth map takes a square number of them a pixel";
            return Err(Error::Setting { setting: "samples", reason });
        }
        if self.size.contains(&0) {
            let reason = "a depth map has at least one pixel";
            return Err(Error::Setting { setting: "size", reason });
        }
        let [width, height] = self.size.map(|size| u64::from(size) * u64::from(side));
        let count = width.saturating_mul(height);
        if count > DepthMap::MAX_TEXELS {
            let limit = DepthMap::MAX_TEXELS;
            return Err(Error::TooLarge { what: "depths of a map", count, limit });
        }
        // Neither side is 0, so neither is past the product.
        Ok([width as u32, height as u32])
    }
}

/// A shadow map that keeps the nearest depth of every sample.
///
/// The samples of a pixel are n × n texels, each with the depth at a jittered
/// point within it, so that the whole is one image of (width · n) × (height · n)
/// depths: what [`PercentageCloserFilter`](super::pcf::PercentageCloserFilter) draws
/// from.
///
/// ```
/// use dsm_core::{Error, RayHits, RaySource, SamplePoint, SurfaceHit};
/// use shadow_maps::plain::{DepthMap, DepthMapSettings};
///
/// // An opaque half plane.
/// let source = RaySource(|point: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
///     if point.x > 2.0 {
///         ray.push_surface(SurfaceHit { depth: 3.0, opacity: 1.0 })?;
///     }
///     Ok(())
/// });
/// let map = DepthMap::sample(&source, &DepthMapSettings::new([4, 4], 16)?)?;
/// assert_eq!(map.texels(), [16, 16]);
/// assert_eq!(map.depth(7, 3), f32::INFINITY);
/// assert_eq!(map.depth(8, 3), 3.0);
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMap {
    camera: Option<ShadowCamera>,
    size: [u32; 2],
    texels: [u32; 2],
    depths: Vec<f32>,
}

impl DepthMap {
    /// The most depths that a map may have.
    pub const MAX_TEXELS: u64 = (1 << 31) - 1;

    /// Samples the nearest depth of every sample of `source`, in parallel on the
    /// current rayon pool. The answer depends on the source and the settings
    /// alone. O(h), or O(h log h) where matter lets light through, for h hits; 4 bytes a sample, and the hits of one block of
    /// up to 2¹⁶ samples a thread.
    ///
    /// # Errors
    ///
    /// The first error of the source, those of
    /// [`DepthMapSettings::texels`], and [`Error::Camera`] for a camera without
    /// a matrix.
    pub fn sample<T: Transmittance, S: HitSource<T>>(
        source: &S,
        settings: &DepthMapSettings,
    ) -> std::result::Result<Self, S::Error> {
        let texels = settings.texels()?;
        let side = settings.sampling.samples_per_pixel().isqrt();
        let count = texels[0] as usize * texels[1] as usize;
        let mut depths = Vec::new();
        let too_large = |_| Error::TooLarge {
            what: "depths that there is memory for",
            count: count as u64,
            limit: 0,
        };
        depths.try_reserve_exact(count).map_err(too_large)?;
        depths.resize(count, f32::INFINITY);
        let block = BLOCK_SAMPLES.isqrt().div_euclid(side).clamp(1, BLOCK_SIDE);
        let band = (block * side) as usize * texels[0] as usize;
        (0..)
            .zip(depths.chunks_mut(band))
            .collect::<Vec<(u32, _)>>()
            .into_par_iter()
            .try_for_each(|(index, rows)| {
                let rows = Band { first: index * block, texels: rows, width: texels[0] };
                rows.fill(source, settings, block)
            })?;
        Ok(Self { camera: settings.camera, size: settings.size, texels, depths })
    }

    /// A map of `size` pixels from its texels: `texels` of them in each
    /// direction, row by row, infinite where nothing is.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] unless there are as many depths as texels, a whole
    /// number to each pixel and as many across as down;
    /// [`Error::Hit`] for a depth that is negative or NaN.
    pub fn new(
        size: [u32; 2],
        texels: [u32; 2],
        depths: Vec<f32>,
        camera: Option<ShadowCamera>,
    ) -> Result<Self> {
        let count = u64::from(texels[0]) * u64::from(texels[1]);
        let even = (0..2).all(|axis| size[axis] > 0 && texels[axis].is_multiple_of(size[axis]));
        let square = || texels[0] / size[0] == texels[1] / size[1];
        if count != depths.len() as u64 || count == 0 || !even || !square() {
            let reason = "they must be n × n for each pixel";
            return Err(Error::Setting { setting: "texels", reason });
        }
        if count > Self::MAX_TEXELS {
            let limit = Self::MAX_TEXELS;
            return Err(Error::TooLarge { what: "depths of a map", count, limit });
        }
        match depths.iter().find(|&&depth| depth.is_nan() || depth < 0.0) {
            Some(&depth) => {
                let reason = "a depth map's depths are 0 or more, and infinite at most";
                Err(Error::Hit { depth, reason })
            }
            None => Ok(Self { camera, size, texels, depths }),
        }
    }

    /// The camera whose NDC \[0, 1\]² covers the map, if it is known.
    #[must_use]
    pub const fn camera(&self) -> Option<&ShadowCamera> {
        self.camera.as_ref()
    }

    /// Width and height in pixels.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Width and height in texels, of which every pixel has n × n.
    #[must_use]
    pub const fn texels(&self) -> [u32; 2] {
        self.texels
    }

    /// Texels along the side of a pixel.
    #[must_use]
    pub const fn texels_per_side(&self) -> u32 {
        self.texels[0] / self.size[0]
    }

    /// All depths, row by row, in scene units: infinite where nothing is.
    #[must_use]
    pub fn depths(&self) -> &[f32] {
        &self.depths
    }

    /// The depth of the texel in column `x` and row `y`.
    ///
    /// # Panics
    ///
    /// If the texel lies outside the map.
    #[must_use]
    pub fn depth(&self, x: u32, y: u32) -> f32 {
        assert!(x < self.texels[0], "column {x} of {}", self.texels[0]);
        self.depths[y as usize * self.texels[0] as usize + x as usize]
    }
}

/// The texels of some rows of pixels.
struct Band<'a> {
    /// The first row of pixels.
    first: u32,
    texels: &'a mut [f32],
    /// Texels in a row.
    width: u32,
}

impl Band<'_> {
    /// Asks for the samples of the band, `block` columns of pixels at a time.
    fn fill<T: Transmittance, S: HitSource<T>>(
        self,
        source: &S,
        settings: &DepthMapSettings,
        block: u32,
    ) -> std::result::Result<(), S::Error> {
        let side = settings.sampling.samples_per_pixel().isqrt();
        let rows = block.min(settings.size[1] - self.first);
        let camera = settings.camera.as_ref().map(|camera| (camera, settings.size));
        let mut hits = TileHits::new(0);
        let mut nearest = NearestDepths::new(settings.blocking);
        for column in (0..settings.size[0]).step_by(block as usize) {
            let columns = block.min(settings.size[0] - column);
            // Sizes lie below 2³¹.
            let min = [column as i32, self.first as i32];
            let samples = TileSamples::new(&settings.sampling, min, [columns, rows], camera)?;
            hits.reset(samples.len());
            source.hits(&samples, &mut hits)?;
            nearest.find(&hits, |sample| {
                let pixel = sample / (side * side);
                let x = column + pixel % columns;
                let y = self.first + pixel / columns;
                let within = sample % (side * side);
                [x * side + within % side, y * side + within / side]
            });
            for (sample, &depth) in (0..).zip(nearest.depths()) {
                if depth < f32::INFINITY {
                    let (pixel, within) = (sample / (side * side), sample % (side * side));
                    let x = (column + pixel % columns) * side + within % side;
                    let y = pixel / columns * side + within / side;
                    self.texels[y as usize * self.width as usize + x as usize] = depth;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dsm_core::{RayHits, RaySource, SamplePoint, SurfaceHit};

    /// Meets a surface whose depth tells where the ray goes.
    fn source() -> impl HitSource<f32, Error = Error> {
        RaySource(|point: SamplePoint, ray: &mut RayHits<f32>| -> Result<()> {
            let depth = (point.y * 1000.0 + point.x) as f32;
            if point.x > 3.0 {
                ray.push_surface(SurfaceHit { depth, opacity: 1.0 })?;
            }
            Ok(())
        })
    }

    #[test]
    fn texels_are_the_samples_of_pixels() {
        for (size, samples) in [([150, 70], 1), ([9, 70], 4), ([5, 3], 1024)] {
            let settings = DepthMapSettings::new(size, samples).unwrap();
            let map = DepthMap::sample(&source(), &settings).unwrap();
            let side = samples.isqrt();
            assert_eq!(map.texels(), size.map(|size| size * side));
            let points = TileSamples::new(&settings.sampling, [0, 0], size, None).unwrap();
            for y in 0..size[1] {
                for x in 0..size[0] {
                    for (index, sample) in (0..).zip(points.pixel(x, y)) {
                        let point = points.point(sample);
                        let texel = [x * side + index % side, y * side + index / side];
                        // The sample lies in its texel.
                        assert_eq!((point.x * f64::from(side)) as u32, texel[0]);
                        assert_eq!((point.y * f64::from(side)) as u32, texel[1]);
                        let depth = (point.y * 1000.0 + point.x) as f32;
                        let expected = if point.x > 3.0 { depth } else { f32::INFINITY };
                        assert_eq!(map.depth(texel[0], texel[1]), expected);
                    }
                }
            }
            let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
            let other = pool.install(|| DepthMap::sample(&source(), &settings)).unwrap();
            assert_eq!(map, other);
        }
    }

    #[test]
    fn what_is_no_map_is_refused() {
        assert!(DepthMapSettings::new([4, 4], 5).is_err());
        assert!(DepthMapSettings::new([0, 4], 4).is_err());
        assert!(DepthMapSettings::new([1 << 24, 1 << 24], 4096).is_err());
        assert!(DepthMapSettings::new([u32::MAX, u32::MAX], 4).is_err());
        let map = |size, texels, depths| DepthMap::new(size, texels, depths, None);
        assert!(map([2, 1], [4, 2], vec![1.0; 8]).is_ok());
        assert!(map([2, 1], [4, 2], vec![1.0; 7]).is_err());
        assert!(map([2, 1], [4, 1], vec![1.0; 4]).is_err());
        assert!(map([2, 1], [3, 1], vec![1.0; 3]).is_err());
        assert!(map([2, 0], [2, 0], vec![]).is_err());
        assert!(map([0, 0], [0, 0], vec![]).is_err());
        for depth in [-1.0, f32::NAN] {
            assert!(map([1, 1], [1, 1], vec![depth]).is_err());
        }
    }
}
