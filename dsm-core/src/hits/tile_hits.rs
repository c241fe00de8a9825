//! Hits of the rays of a block of pixels, in columns.

use glam::Vec3;

use super::hit::{RayHits, SurfaceHit, VolumeSample, VolumeSegment, medium, slab};
use crate::error::{Error, Result};
use crate::transmittance::Transmittance;

/// The hits of the samples of a block of pixels, in any order, as a
/// [`crate::HitSource`] provides them. Every hit is checked on entry.
///
/// A surface takes 8 bytes and its opacity. Surfaces of opacity 0 change
/// nothing and are left out.
///
/// ```
/// use dsm_core::{SurfaceHit, TileHits};
///
/// let mut hits = TileHits::<f32>::new(64);
/// // One at a time, as a ray tracer finds them,
/// hits.push_surface(3, SurfaceHit { depth: 2.0, opacity: 0.5 })?;
/// // or all samples that a primitive covers at once, as a rasteriser does.
/// hits.push_surfaces(&[9, 3, 4], &[1.5, 1.25, 1.75], 0.25)?;
/// assert_eq!(hits.surface_count(), 4);
/// assert!(hits.push_surfaces(&[64], &[1.0], 0.25).is_err());
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct TileHits<T: Transmittance> {
    samples: u32,
    /// Depth bits above the sample: the keys that surfaces are sorted by.
    surfaces: Vec<u64>,
    opacities: Vec<T>,
    /// Normals by surface, in ascending order.
    normals: Vec<(u32, Vec3)>,
    wants_normals: bool,
    wants_media: bool,
    segments: Vec<(u32, VolumeSegment<T>)>,
}

impl<T: Transmittance> TileHits<T> {
    /// No hits yet, of `samples` samples.
    #[must_use]
    pub const fn new(samples: u32) -> Self {
        Self {
            samples,
            surfaces: Vec::new(),
            opacities: Vec::new(),
            normals: Vec::new(),
            wants_normals: false,
            wants_media: true,
            segments: Vec::new(),
        }
    }

    /// Nothing hit so far, in a map that keeps the normals of surfaces.
    #[must_use]
    pub const fn with_normals(samples: u32) -> Self {
        let mut hits = Self::new(samples);
        hits.wants_normals = true;
        hits
    }

    /// The same for a map that takes no media from these samples: those that are added
    /// are checked and left out.
    #[must_use]
    pub fn without_media(self) -> Self {
        Self { wants_media: false, ..self }
    }

    /// Forgets everything, keeps the memory, and expects hits of `samples`
    /// samples.
    pub fn reset(&mut self, samples: u32) {
        self.samples = samples;
        self.surfaces.clear();
        self.opacities.clear();
        self.normals.clear();
        self.segments.clear();
    }

    /// Number of samples: hits name one below it.
    #[must_use]
    pub const fn sample_count(&self) -> u32 {
        self.samples
    }

    /// True if normals are kept; if not, a source needn't compute them.
    #[must_use]
    pub const fn wants_normals(&self) -> bool {
        self.wants_normals
    }

    /// True if media are kept; if not, a source needn't compute them.
    #[must_use]
    pub const fn wants_media(&self) -> bool {
        self.wants_media
    }

    /// Adds a surface hit of `sample`.
    ///
    /// # Errors
    ///
    /// [`Error::Sample`] if no such sample, [`Error::Hit`] as
    /// [`RayHits::push_surface`].
    #[inline]
    pub fn push_surface(&mut self, sample: u32, hit: SurfaceHit<T>) -> Result<()> {
        self.check_sample(sample)?;
        self.push_checked(sample, hit.checked()?);
        Ok(())
    }

    /// Adds a surface hit with its normal: in camera space (right-handed, the
    /// camera looks down −z), of any length, pointing to either side.
    ///
    /// # Errors
    ///
    /// As [`Self::push_surface`].
    pub fn push_surface_with_normal(
        &mut self,
        sample: u32,
        hit: SurfaceHit<T>,
        normal: Vec3,
    ) -> Result<()> {
        self.check_sample(sample)?;
        let surface = self.surfaces.len();
        self.push_checked(sample, hit.checked()?);
        if self.wants_normals && self.surfaces.len() > surface {
            self.normals.push((surface as u32, normal));
        }
        Ok(())
    }

    /// Adds surfaces of one opacity, each a sample and a depth.
    ///
    /// # Errors
    ///
    /// [`Error::Sample`] if one names no sample or the columns' lengths
    /// differ, [`Error::Hit`] as [`RayHits::push_surface`]. Nothing is added
    /// then.
    pub fn push_surfaces(&mut self, samples: &[u32], depths: &[f32], opacity: T) -> Result<()> {
        SurfaceHit { depth: depths.first().copied().unwrap_or(0.0), opacity }.checked()?;
        self.check_columns(samples, depths)?;
        if opacity != T::splat(0.0) {
            self.surfaces.extend(samples.iter().zip(depths).map(|(&sample, &z)| key(z, sample)));
            self.opacities.resize(self.surfaces.len(), opacity);
        }
        Ok(())
    }

    /// Adds surfaces of one opacity and one normal, as a triangle has: camera
    /// space, right-handed, the camera looks down −z, any length, to either
    /// side.
    ///
    /// # Errors
    ///
    /// As [`Self::push_surfaces`].
    pub fn push_surfaces_with_normal(
        &mut self,
        samples: &[u32],
        depths: &[f32],
        opacity: T,
        normal: Vec3,
    ) -> Result<()> {
        let first = self.surfaces.len();
        self.push_surfaces(samples, depths, opacity)?;
        if self.wants_normals {
            // Hits are numbered by u32, as their samples are.
            self.normals.extend((first..self.surfaces.len()).map(|hit| (hit as u32, normal)));
        }
        Ok(())
    }

    /// Adds surfaces, each a sample, a depth and an opacity.
    ///
    /// # Errors
    ///
    /// As [`Self::push_surfaces`].
    pub fn push_surface_columns(
        &mut self,
        samples: &[u32],
        depths: &[f32],
        opacities: &[T],
    ) -> Result<()> {
        self.check_columns(samples, depths)?;
        if opacities.len() != depths.len() {
            return self.refuse(0, COLUMNS_DIFFER);
        }
        let in_range = |value: f32| (0.0..=1.0).contains(&value);
        let fits = |opacity: T| {
            (0..T::CHANNELS).fold(true, |all, channel| all & in_range(opacity.channel(channel)))
        };
        if !opacities.iter().fold(true, |all, &opacity| all & fits(opacity)) {
            for (&depth, &opacity) in depths.iter().zip(opacities) {
                SurfaceHit { depth, opacity }.checked()?;
            }
        }
        let keys = samples.iter().zip(depths).map(|(&sample, &z)| key(z, sample));
        let clear = T::splat(0.0);
        if opacities.contains(&clear) {
            let seen = keys.zip(opacities).filter(|&(_, &opacity)| opacity != clear);
            for (key, &opacity) in seen {
                self.surfaces.push(key);
                self.opacities.push(opacity);
            }
        } else {
            self.surfaces.extend(keys);
            self.opacities.extend_from_slice(opacities);
        }
        Ok(())
    }

    /// Adds a medium on the ray of `sample`; see [`RayHits::push_volume`].
    /// `distance_per_depth` is that of the sample's
    /// [`SamplePoint`](crate::SamplePoint).
    ///
    /// # Errors
    ///
    /// [`Error::Sample`] if no such sample, [`Error::Hit`] as
    /// [`RayHits::push_volume`]. Nothing is added then.
    pub fn push_volume(
        &mut self,
        sample: u32,
        samples: &[VolumeSample<T>],
        distance_per_depth: f64,
    ) -> Result<()> {
        self.check_sample(sample)?;
        let segments = medium(samples, distance_per_depth)?;
        if self.wants_media {
            self.segments.extend(segments.map(|segment| (sample, segment)));
        }
        Ok(())
    }

    /// Adds a medium of constant extinction on the ray of `sample`; see
    /// [`RayHits::push_slab`].
    ///
    /// # Errors
    ///
    /// [`Error::Sample`] if no such sample, [`Error::Hit`] as
    /// [`RayHits::push_slab`].
    pub fn push_slab(&mut self, sample: u32, near: f32, far: f32, opacity: T) -> Result<()> {
        self.check_sample(sample)?;
        let (segment, surface) = slab(near, far, opacity)?;
        if self.wants_media {
            self.segments.push((sample, segment));
        }
        if let Some(surface) = surface {
            self.push_checked(sample, surface);
        }
        Ok(())
    }

    /// Adds all hits of the ray of `sample`.
    ///
    /// # Errors
    ///
    /// [`Error::Sample`] if no such sample.
    pub fn push_ray(&mut self, sample: u32, ray: &RayHits<T>) -> Result<()> {
        self.check_sample(sample)?;
        ray.surfaces().iter().for_each(|&surface| self.push_checked(sample, surface));
        if self.wants_media {
            self.segments.extend(ray.segments().iter().map(|&segment| (sample, segment)));
        }
        Ok(())
    }

    /// Number of surfaces.
    #[must_use]
    pub const fn surface_count(&self) -> usize {
        self.surfaces.len()
    }

    /// The surfaces and their samples, in the order they were added.
    pub fn surfaces(&self) -> impl ExactSizeIterator<Item = (u32, SurfaceHit<T>)> + '_ {
        self.surfaces.iter().zip(&self.opacities).map(|(&key, &opacity)| {
            (key as u32, SurfaceHit { depth: f32::from_bits((key >> 32) as u32), opacity })
        })
    }

    /// The surfaces that have a normal, by their number in [`Self::surfaces`],
    /// ascending.
    #[must_use]
    pub fn normals(&self) -> &[(u32, Vec3)] {
        &self.normals
    }

    /// The segments of media and their samples, in the order they were added.
    #[must_use]
    pub fn segments(&self) -> &[(u32, VolumeSegment<T>)] {
        &self.segments
    }

    /// True if no sample hits anything.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.surfaces.is_empty() && self.segments.is_empty()
    }

    /// Depth bits above the sample, of all surfaces.
    pub(crate) fn surface_keys(&self) -> &[u64] {
        &self.surfaces
    }

    /// The opacities of all surfaces.
    pub(crate) fn opacities(&self) -> &[T] {
        &self.opacities
    }

    /// Exchanges the columns of the surfaces for others, which are emptied.
    pub(crate) fn swap_surfaces(&mut self, keys: &mut Vec<u64>, opacities: &mut Vec<T>) {
        keys.clear();
        opacities.clear();
        std::mem::swap(keys, &mut self.surfaces);
        std::mem::swap(opacities, &mut self.opacities);
    }

    /// Exchanges the segments for others, which are emptied.
    pub(crate) fn swap_segments(&mut self, segments: &mut Vec<(u32, VolumeSegment<T>)>) {
        segments.clear();
        std::mem::swap(segments, &mut self.segments);
    }

    #[inline]
    fn push_checked(&mut self, sample: u32, hit: SurfaceHit<T>) {
        if hit.opacity != T::splat(0.0) {
            self.surfaces.push(key(hit.depth, sample));
            self.opacities.push(hit.opacity);
        }
    }

    #[inline]
    fn check_sample(&self, sample: u32) -> Result<()> {
        if sample < self.samples { Ok(()) } else { self.refuse(sample, NO_SAMPLE) }
    }

    /// Checks samples and depths without a branch for each.
    fn check_columns(&self, samples: &[u32], depths: &[f32]) -> Result<()> {
        if samples.len() != depths.len() {
            return self.refuse(0, COLUMNS_DIFFER);
        }
        let highest = samples.iter().fold(0, |highest, &sample| highest.max(sample));
        if highest >= self.samples && !samples.is_empty() {
            return self.refuse(highest, NO_SAMPLE);
        }
        let in_range = |depth: f32| (0.0..f32::INFINITY).contains(&depth);
        if depths.iter().fold(true, |all, &depth| all & in_range(depth)) {
            return Ok(());
        }
        for &depth in depths {
            SurfaceHit { depth, opacity: T::BLOCKED }.checked()?;
        }
        Ok(())
    }

    #[cold]
    fn refuse(&self, sample: u32, reason: &'static str) -> Result<()> {
        Err(Error::Sample { sample, samples: self.samples, reason })
    }
}

const NO_SAMPLE: &str = "no such sample";

const COLUMNS_DIFFER: &str = "the columns' lengths differ";

/// The sort key of a surface; −0 counts as 0.
#[inline]
fn key(z: f32, sample: u32) -> u64 {
    u64::from((z + 0.0).to_bits()) << 32 | u64::from(sample)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transmittance::Rgb;

    #[test]
    fn every_door_checks() {
        let mut hits = TileHits::<f32>::new(2);
        let hit = SurfaceHit { depth: 1.0, opacity: 0.5 };
        for (sample, hit) in [
            (2, hit),
            (0, SurfaceHit { depth: -1.0, ..hit }),
            (0, SurfaceHit { opacity: f32::NAN, ..hit }),
        ] {
            assert!(hits.push_surface(sample, hit).is_err(), "{sample} {hit:?}");
            assert!(hits.push_surface_with_normal(sample, hit, Vec3::Z).is_err());
            let (samples, depths) = ([1, sample], [2.0, hit.depth]);
            assert!(hits.push_surfaces(&samples, &depths, hit.opacity).is_err());
            let with_normal =
                hits.push_surfaces_with_normal(&samples, &depths, hit.opacity, Vec3::Z);
            assert!(with_normal.is_err());
            assert!(hits.push_surface_columns(&samples, &depths, &[0.5, hit.opacity]).is_err());
        }
        assert!(hits.push_surfaces(&[0, 1], &[1.0, f32::NAN], 0.5).is_err());
        assert!(hits.push_surfaces(&[0, 1], &[1.0], 0.5).is_err());
        assert!(hits.push_surface_columns(&[0], &[1.0], &[]).is_err());
        let medium = [1.0, 2.0].map(|depth| VolumeSample { depth, extinction: 1.0 });
        assert!(hits.push_volume(2, &medium, 1.0).is_err());
        assert!(hits.push_volume(0, &medium, 0.5).is_err());
        assert!(hits.push_slab(2, 1.0, 2.0, 0.5).is_err());
        assert!(hits.push_slab(0, 2.0, 1.0, 0.5).is_err());
        assert!(hits.push_ray(2, &RayHits::default()).is_err());
        assert!(hits.is_empty());
    }

    #[test]
    fn every_door_leads_to_the_same_columns() {
        let opacity = Rgb::new(0.5, 0.25, 1.0);
        let expected = [(1, -0.0), (0, 3.0), (1, 2.0)]
            .map(|(sample, depth)| (sample, SurfaceHit { depth, opacity }));
        let (samples, depths) = ([1, 0, 1], [-0.0, 3.0, 2.0]);
        let mut columns = [const { TileHits::new(2) }; 4];
        let clear = SurfaceHit { depth: 1.0, opacity: Rgb::splat(0.0) };
        for (sample, hit) in expected {
            columns[0].push_surface(sample, hit).unwrap();
            columns[0].push_surface(sample, clear).unwrap();
            let mut ray = RayHits::default();
            ray.push_surface(hit).unwrap();
            columns[1].push_ray(sample, &ray).unwrap();
        }
        columns[2].push_surfaces(&samples, &depths, opacity).unwrap();
        columns[2].push_surfaces(&samples, &depths, clear.opacity).unwrap();
        columns[3].push_surface_columns(&samples[..1], &depths[..1], &[opacity]).unwrap();
        columns[3]
            .push_surface_columns(&[0, 0, 1], &[1.0, 3.0, 2.0], &[clear.opacity, opacity, opacity])
            .unwrap();
        for hits in &columns {
            assert!(hits.surfaces().eq(expected), "{hits:?}");
            assert!(hits.surfaces().all(|(_, hit)| hit.depth.is_sign_positive()));
        }
    }

    #[test]
    fn normals_are_kept_where_they_are_wanted() {
        let hit = SurfaceHit { depth: 1.0, opacity: 0.5 };
        let clear = SurfaceHit { opacity: 0.0, ..hit };
        let mut hits = TileHits::with_normals(1);
        hits.push_surface(0, hit).unwrap();
        hits.push_surface_with_normal(0, clear, Vec3::X).unwrap();
        hits.push_surface_with_normal(0, hit, Vec3::Z).unwrap();
        assert_eq!(hits.normals(), [(1, Vec3::Z)]);
        hits.push_surfaces_with_normal(&[0], &[2.0], 0.0, Vec3::X).unwrap();
        hits.push_surfaces_with_normal(&[0, 0], &[2.0, 3.0], 0.5, Vec3::Y).unwrap();
        assert_eq!(hits.normals(), [(1, Vec3::Z), (2, Vec3::Y), (3, Vec3::Y)]);
        hits.reset(1);
        assert!(hits.is_empty() && hits.normals().is_empty() && hits.wants_normals());
        let mut hits = TileHits::new(1);
        hits.push_surface_with_normal(0, hit, Vec3::Z).unwrap();
        assert!(hits.normals().is_empty() && hits.surface_count() == 1);
    }
}
