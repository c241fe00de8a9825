//! Hits of one ray of a shadow camera (Lokovic & Veach 2000, §3.2).

use crate::error::{Error, Result};
use crate::transmittance::Transmittance;

/// A hit of a surface on a ray.
///
/// ```
/// use dsm_core::SurfaceHit;
///
/// let hit = SurfaceHit { depth: 2.0, opacity: 0.75_f32 };
/// assert_eq!(hit.transmittance(), 0.25);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit<T> {
    /// Depth along the view axis, in scene units, finite and ≥ 0.
    pub depth: f32,
    /// The fraction of light it blocks, in [0, 1] for every channel.
    pub opacity: T,
}

/// A sample of the extinction along the ray. Between two samples the
/// extinction is linear; outside the first and last it is 0.
///
/// ```
/// use dsm_core::{RayHits, VolumeSample};
///
/// // Smoke that gets denser from depth 1 to 2, and thinner from 2 to 3.
/// let smoke = [(1.0, 0.0), (2.0, 0.5), (3.0, 0.0)];
/// let samples = smoke.map(|(depth, extinction)| VolumeSample { depth, extinction });
/// let mut hits = RayHits::<f32>::default();
/// hits.push_volume(&samples, 1.0)?;
/// assert_eq!(hits.segments().len(), 2);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeSample<T> {
    /// Depth along the view axis, in scene units, finite and ≥ 0.
    pub depth: f32,
    /// Extinction per unit of *distance along the ray*, finite and ≥ 0.
    pub extinction: T,
}

/// A stretch of the ray through a medium whose extinction is linear between
/// its ends. Segments may overlap: their extinctions add.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeSegment<T: Transmittance> {
    /// Depth of the near end.
    pub near: f32,
    /// Depth of the far end, greater than `near`.
    pub far: f32,
    /// Extinction per unit of *depth* at the near end, finite and ≥ 0.
    pub near_extinction: T::Sum,
    /// Extinction per unit of *depth* at the far end, finite and ≥ 0.
    pub far_extinction: T::Sum,
}

/// The hits of one ray, in any order.
///
/// ```
/// use dsm_core::{RayHits, SurfaceHit, VolumeSample};
///
/// let mut hits = RayHits::<f32>::default();
/// hits.push_surface(SurfaceHit { depth: 2.0, opacity: 0.5 })?;
/// hits.push_volume(
///     &[
///         VolumeSample { depth: 1.0, extinction: 0.3 },
///         VolumeSample { depth: 4.0, extinction: 0.3 },
///     ],
///     1.0,
/// )?;
/// assert_eq!(hits.surfaces().len(), 1);
/// assert_eq!(hits.segments().len(), 1);
/// # Ok::<(), dsm_core::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct RayHits<T: Transmittance> {
    surfaces: Vec<SurfaceHit<T>>,
    segments: Vec<VolumeSegment<T>>,
}

impl<T: Transmittance> Default for RayHits<T> {
    fn default() -> Self {
        Self { surfaces: Vec::new(), segments: Vec::new() }
    }
}

impl<T: Transmittance> RayHits<T> {
    /// Adds a surface.
    ///
    /// # Errors
    ///
    /// [`Error::Hit`] for a depth that is not finite or negative, or an
    /// opacity outside [0, 1].
    pub fn push_surface(&mut self, hit: SurfaceHit<T>) -> Result<()> {
        self.surfaces.push(hit.checked()?);
        Ok(())
    }

    /// Adds a medium sampled along the ray, front to back. Two samples at one
    /// depth are a jump of the extinction. `distance_per_depth` is the
    /// distance along the ray per unit of depth, ≥ 1: the correction of
    /// footnote 3 (see [`crate::ShadowCamera::distance_per_depth`]).
    ///
    /// # Errors
    ///
    /// [`Error::Hit`] for depths that are not finite, negative or descending,
    /// extinctions that are negative or not finite (also once per unit of
    /// depth), or a factor below 1. Nothing is added then.
    pub fn push_volume(
        &mut self,
        samples: &[VolumeSample<T>],
        distance_per_depth: f64,
    ) -> Result<()> {
        self.segments.extend(medium(samples, distance_per_depth)?);
        Ok(())
    }

    /// Adds a medium of constant extinction over [`near`, `far`) that blocks
    /// the fraction `opacity` of the light, like a volumetric sample of a deep
    /// OpenEXR. An opacity of 1 leaves nothing behind the near end: the step
    /// stands at the next `f32` behind `near`, in the channels that have it.
    ///
    /// # Errors
    ///
    /// [`Error::Hit`] for depths that are not finite, negative or not in
    /// order, or an opacity outside [0, 1].
    pub fn push_slab(&mut self, near: f32, far: f32, opacity: T) -> Result<()> {
        let (segment, surface) = slab(near, far, opacity)?;
        self.segments.push(segment);
        self.surfaces.extend(surface);
        Ok(())
    }

    /// Adds a surface that was checked before.
    pub(crate) fn push_checked(&mut self, hit: SurfaceHit<T>) {
        self.surfaces.push(hit);
    }

    /// Adds a segment that was checked before.
    pub(crate) fn push_checked_segment(&mut self, segment: VolumeSegment<T>) {
        self.segments.push(segment);
    }

    /// Removes the hits at depths up to `depth`: surfaces there and before it, and
    /// the part of every medium before it. The rest is what a ray hits that starts
    /// just behind `depth`, as the next run of a multilayer map does.
    ///
    /// ```
    /// use dsm_core::{RayHits, SurfaceHit};
    ///
    /// let mut hits = RayHits::<f32>::default();
    /// for depth in [1.0, 2.0, 3.0] {
    ///     hits.push_surface(SurfaceHit { depth, opacity: 0.5 })?;
    /// }
    /// hits.push_slab(1.0, 5.0, 0.5)?;
    /// hits.keep_behind(2.0);
    /// assert_eq!(hits.surfaces(), [SurfaceHit { depth: 3.0, opacity: 0.5 }]);
    /// assert_eq!(hits.segments()[0].near, 2.0);
    /// # Ok::<(), dsm_core::Error>(())
    /// ```
    pub fn keep_behind(&mut self, depth: f32) {
        if depth.is_nan() {
            return;
        }
        self.surfaces.retain(|surface| surface.depth > depth);
        self.segments.retain_mut(|segment| match segment.behind(depth) {
            Some(rest) => {
                *segment = rest;
                true
            }
            None => false,
        });
    }

    /// The surfaces, in the order they were added.
    #[must_use]
    pub fn surfaces(&self) -> &[SurfaceHit<T>] {
        &self.surfaces
    }

    /// The segments of media, in the order they were added.
    #[must_use]
    pub fn segments(&self) -> &[VolumeSegment<T>] {
        &self.segments
    }

    /// True if the ray hits nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.surfaces.is_empty() && self.segments.is_empty()
    }

    /// Forgets everything and keeps the memory.
    pub fn clear(&mut self) {
        self.surfaces.clear();
        self.segments.clear();
    }
}

impl<T: Transmittance> VolumeSegment<T> {
    /// The part of it behind `depth`; None if there is none.
    pub(crate) fn behind(self, depth: f32) -> Option<Self> {
        if self.far <= depth {
            None
        } else if self.near < depth {
            Some(Self { near: depth, near_extinction: self.extinction(depth), ..self })
        } else {
            Some(self)
        }
    }

    /// The extinction at `depth`, which lies between the ends.
    fn extinction(&self, depth: f32) -> T::Sum {
        let (near, far) = (f64::from(self.near), f64::from(self.far));
        let share = (f64::from(depth) - near) / (far - near);
        T::sum_from_channels(|channel| {
            let near = self.near_extinction.as_ref()[channel];
            near + share * (self.far_extinction.as_ref()[channel] - near)
        })
    }
}

impl<T: Transmittance> SurfaceHit<T> {
    /// The transmittance of the surface: 1 − opacity.
    #[must_use]
    pub fn transmittance(&self) -> T {
        T::from_channels(|channel| 1.0 - self.opacity.channel(channel))
    }

    /// The hit itself, if a ray can have it, with −0 turned into 0.
    #[inline]
    pub(crate) fn checked(self) -> Result<Self> {
        Ok(Self {
            depth: check_depth(self.depth)?,
            opacity: check_opacity(self.depth, self.opacity)?,
        })
    }
}

/// The segments of a medium sampled along a ray; see [`RayHits::push_volume`].
pub(crate) fn medium<T: Transmittance>(
    samples: &[VolumeSample<T>],
    distance_per_depth: f64,
) -> Result<impl Iterator<Item = VolumeSegment<T>> + '_> {
    let refuse = |depth, reason| Err(Error::Hit { depth, reason });
    if !(1.0..f64::INFINITY).contains(&distance_per_depth) {
        let depth = samples.first().map_or(0.0, |sample| sample.depth);
        return refuse(depth, "the distance per depth must be finite and at least 1");
    }
    let per_depth = move |sample: &VolumeSample<T>| {
        T::sum_from_channels(|channel| {
            f64::from(sample.extinction.channel(channel)) * distance_per_depth
        })
    };
    for sample in samples {
        check_depth(sample.depth)?;
        let valid = |value: f32| (0.0..f32::INFINITY).contains(&value);
        if !(0..T::CHANNELS).all(|channel| valid(sample.extinction.channel(channel))) {
            return refuse(sample.depth, "extinction must be finite and at least 0");
        }
        if per_depth(sample).as_ref().contains(&f64::INFINITY) {
            return refuse(sample.depth, "extinction per depth must be finite");
        }
    }
    if let Some(back) = samples.windows(2).find(|pair| pair[0].depth > pair[1].depth) {
        return refuse(back[1].depth, "volume samples must go front to back");
    }
    Ok(samples.windows(2).filter(|pair| pair[0].depth < pair[1].depth).map(move |pair| {
        VolumeSegment {
            near: pair[0].depth + 0.0,
            far: pair[1].depth,
            near_extinction: per_depth(&pair[0]),
            far_extinction: per_depth(&pair[1]),
        }
    }))
}

/// The segment and, if any channel is opaque, the surface of a slab; see
/// [`RayHits::push_slab`].
pub(crate) fn slab<T: Transmittance>(
    near: f32,
    far: f32,
    opacity: T,
) -> Result<(VolumeSegment<T>, Option<SurfaceHit<T>>)> {
    let (near, far) = (check_depth(near)?, check_depth(far)?);
    if near >= far {
        let reason = "a slab's far end must lie behind its near end";
        return Err(Error::Hit { depth: near, reason });
    }
    let opacity = check_opacity(near, opacity)?;
    let length = f64::from(far) - f64::from(near);
    let extinction = T::sum_from_channels(|channel| match opacity.channel(channel) {
        1.0 => 0.0,
        opacity => -f64::ln_1p(-f64::from(opacity)) / length,
    });
    let segment =
        VolumeSegment { near, far, near_extinction: extinction, far_extinction: extinction };
    let blocked = T::from_channels(|channel| f32::from(opacity.channel(channel) == 1.0));
    let surface = (blocked != T::splat(0.0))
        .then_some(SurfaceHit { depth: near.next_up(), opacity: blocked });
    Ok((segment, surface))
}

/// The depth itself, with −0 turned into 0 so that bit patterns sort by depth.
#[inline]
fn check_depth(depth: f32) -> Result<f32> {
    if (0.0..f32::INFINITY).contains(&depth) {
        Ok(depth + 0.0)
    } else {
        Err(Error::Hit { depth, reason: "depth must be finite and at least 0" })
    }
}

/// The opacity of something at `depth`, if it is one.
#[inline]
fn check_opacity<T: Transmittance>(depth: f32, opacity: T) -> Result<T> {
    if (0..T::CHANNELS).all(|channel| (0.0..=1.0).contains(&opacity.channel(channel))) {
        Ok(opacity)
    } else {
        Err(Error::Hit { depth, reason: "opacity must lie in [0, 1]" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::transmittance_function::TransmittanceFunction;
    use crate::transmittance::Rgb;

    #[test]
    fn hits_no_ray_can_have_are_refused() {
        let mut hits = RayHits::<f32>::default();
        for (depth, opacity) in [(-1.0, 0.5), (f32::NAN, 0.5), (f32::INFINITY, 0.5), (1.0, 1.5)] {
            assert!(hits.push_surface(SurfaceHit { depth, opacity }).is_err());
        }
        let sample = |depth, extinction| VolumeSample { depth, extinction };
        for samples in [
            [sample(2.0, 1.0), sample(1.0, 1.0)],
            [sample(1.0, -1.0), sample(2.0, 1.0)],
            [sample(1.0, 1.0), sample(2.0, f32::INFINITY)],
            [sample(1.0, 1.0), sample(f32::NAN, 1.0)],
        ] {
            assert!(hits.push_volume(&samples, 1.0).is_err(), "{samples:?}");
        }
        assert!(hits.push_volume(&[sample(1.0, 1.0)], 0.5).is_err());
        assert!(hits.push_volume(&[sample(1.0, 9.0)], f64::MAX).is_err());
        assert!(hits.push_slab(2.0, 2.0, 0.5).is_err());
        assert!(hits.push_slab(1.0, 2.0, f32::NAN).is_err());
        assert!(hits.is_empty());
    }

    #[test]
    fn a_later_start_takes_what_lies_before_it_away() {
        let whole = || {
            let mut hits = RayHits::<f32>::default();
            for depth in [1.0, 2.0, 3.0] {
                hits.push_surface(SurfaceHit { depth, opacity: 0.25 }).unwrap();
            }
            let samples = [(0.5, 0.2), (4.5, 1.0)];
            let medium = samples.map(|(depth, extinction)| VolumeSample { depth, extinction });
            hits.push_volume(&medium, 1.0).unwrap();
            hits
        };
        let light = |hits: &RayHits<f32>, z| TransmittanceFunction::new(hits, 1e-6).at(z)[0];
        for start in [0.0, 0.5, 1.0, 1.5, 3.0, 4.5, 9.0] {
            let mut behind = whole();
            behind.keep_behind(start);
            for z in [1.5, 3.0, 4.0, 9.0] {
                let expected =
                    if z > start { light(&whole(), z) / light(&whole(), start) } else { 1.0 };
                assert!((light(&behind, z) - expected).abs() < 1e-5, "{start} {z}");
            }
        }
        let mut all = whole();
        all.keep_behind(f32::NAN);
        assert_eq!(all.surfaces().len(), 3);
    }

    #[test]
    fn an_opaque_slab_blocks_just_behind_its_near_end() {
        let mut hits = RayHits::default();
        hits.push_slab(1.0, 2.0, Rgb::new(1.0, 0.5, 0.0)).unwrap();
        let surface = hits.surfaces()[0];
        assert_eq!((surface.depth, surface.opacity), (1.0_f32.next_up(), Rgb::new(1.0, 0.0, 0.0)));
        let extinction = hits.segments()[0].near_extinction;
        assert_eq!((extinction[0], extinction[2]), (0.0, 0.0));
        assert!((extinction[1] - std::f64::consts::LN_2).abs() < 1e-15);
    }

    #[test]
    fn negative_zero_is_zero() {
        let mut hits = RayHits::default();
        hits.push_surface(SurfaceHit { depth: -0.0, opacity: 0.5 }).unwrap();
        hits.push_slab(-0.0, 1.0, 0.5).unwrap();
        let sample = |depth| VolumeSample { depth, extinction: 1.0 };
        hits.push_volume(&[sample(-0.0), sample(1.0)], 1.0).unwrap();
        assert!(hits.surfaces()[0].depth.is_sign_positive());
        assert!(hits.segments().iter().all(|segment| segment.near.is_sign_positive()));
    }

    #[test]
    fn a_jump_of_the_extinction_is_no_segment() {
        let mut hits = RayHits::<f32>::default();
        let sample = |depth, extinction| VolumeSample { depth, extinction };
        let samples = [sample(1.0, 1.0), sample(2.0, 1.0), sample(2.0, 3.0), sample(3.0, 3.0)];
        hits.push_volume(&samples, 2.0).unwrap();
        assert_eq!(hits.segments().len(), 2);
        assert_eq!(hits.segments()[1].near_extinction, [6.0]);
    }
}
