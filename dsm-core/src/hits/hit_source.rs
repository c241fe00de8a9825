//! The interface by which a renderer provides hits (Lokovic & Veach 2000, §3.2:
//! "the facilities of any standard renderer").

use super::hit::RayHits;
use super::tile_hits::TileHits;
use super::tile_samples::{SamplePoint, TileSamples};
use crate::error::Error;
use crate::transmittance::Transmittance;

/// The scene as a shadow camera sees it: answers a whole block of pixels at once,
/// so that a rasteriser can serve as well as a ray tracer.
///
/// A source is queried for a tile or a part of one, and the border that the pixel
/// filter reaches beyond it; from several threads at once, in any order, and for
/// pixels on a border more than once. To make the same map every time it must
/// answer a sample the same way each time. Hits come in any order: a rasteriser
/// appends primitive by primitive ([`TileHits::push_surfaces`]), a ray tracer
/// sample by sample. Sources that follow one ray at a time are adapted by
/// [`RaySource`].
///
/// Depths are distances from the camera's plane, along the view axis, in scene
/// units. Extinctions count per distance along the ray, which
/// [`SamplePoint::distance_per_depth`] tells.
///
/// ```
/// use dsm_core::{Error, HitSource, PixelSampling, TileHits, TileSamples};
///
/// /// Squares that face the camera, one pixel wide: corner, depth, opacity.
/// struct Squares(Vec<([f64; 2], f32, f32)>);
///
/// impl HitSource<f32> for Squares {
///     type Error = Error;
///
///     fn hits(&self, samples: &TileSamples, hits: &mut TileHits<f32>) -> Result<(), Error> {
///         for &([x, y], depth, opacity) in &self.0 {
///             // A real rasteriser looks only at the pixels that a square covers.
///             let covered: Vec<u32> = (0..samples.len())
///                 .filter(|&sample| {
///                     let point = samples.point(sample);
///                     (x..x + 1.0).contains(&point.x) && (y..y + 1.0).contains(&point.y)
///                 })
///                 .collect();
///             hits.push_surfaces(&covered, &vec![depth; covered.len()], opacity)?;
///         }
///         Ok(())
///     }
/// }
///
/// let squares = Squares(vec![([0.5, 0.0], 2.0, 0.5), ([1.0, 0.0], 1.0, 1.0)]);
/// let samples = TileSamples::new(&PixelSampling::new(16, 0)?, [0, 0], [2, 1], None)?;
/// let mut hits = TileHits::new(samples.len());
/// squares.hits(&samples, &mut hits)?;
/// // Half of each pixel, and all of the second.
/// assert_eq!(hits.surface_count(), 8 + 8 + 16);
/// # Ok::<(), Error>(())
/// ```
pub trait HitSource<T: Transmittance>: Sync {
    /// The error of the source; a hit that was refused is one reason.
    type Error: From<Error> + Send;

    /// Appends the hits of the rays through `samples` to `hits`, which is empty and
    /// expects these samples.
    ///
    /// # Errors
    ///
    /// Any failure of the source. The bake ends then.
    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), Self::Error>;

    /// Whether there may be media: who says that there are none is not asked for them
    /// where a map takes them from other samples than surfaces. Default: there may.
    fn has_media(&self) -> bool {
        true
    }
}

impl<T: Transmittance, S: HitSource<T> + ?Sized> HitSource<T> for &S {
    type Error = S::Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), Self::Error> {
        (**self).hits(samples, hits)
    }

    fn has_media(&self) -> bool {
        (**self).has_media()
    }
}

/// A source that traces one ray at a time: a function of a sample point that adds
/// its ray's hits.
///
/// ```
/// use dsm_core::{
///     Error, HitSource, PixelSampling, RayHits, RaySource, SamplePoint, SurfaceHit,
///     TileHits, TileSamples, VolumeSample,
/// };
///
/// // Fog between depths 1 and 3, and a disk in it that moves to the right.
/// let source = RaySource(|point: SamplePoint, ray: &mut RayHits<f32>| -> Result<(), Error> {
///     let fog = [1.0, 3.0].map(|depth| VolumeSample { depth, extinction: 0.2 });
///     ray.push_volume(&fog, point.distance_per_depth)?;
///     let centre = 4.0 + 2.0 * f64::from(point.time);
///     if (point.x - centre).hypot(point.y - 4.0) < 1.0 {
///         ray.push_surface(SurfaceHit { depth: 2.0, opacity: 1.0 })?;
///     }
///     Ok(())
/// });
///
/// let samples = TileSamples::new(&PixelSampling::new(9, 0)?, [0, 0], [8, 8], None)?;
/// let mut hits = TileHits::new(samples.len());
/// source.hits(&samples, &mut hits)?;
/// assert_eq!(hits.segments().len(), 9 * 64);
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RaySource<F>(pub F);

impl<T, F, E> HitSource<T> for RaySource<F>
where
    T: Transmittance,
    F: Fn(SamplePoint, &mut RayHits<T>) -> Result<(), E> + Sync,
    E: From<Error> + Send,
{
    type Error = E;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), E> {
        let mut ray = RayHits::default();
        for (index, point) in (0..).zip(samples.points()) {
            ray.clear();
            (self.0)(point, &mut ray)?;
            hits.push_ray(index, &ray)?;
        }
        Ok(())
    }
}
