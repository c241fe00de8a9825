//! What stops the ray of a plain shadow map's sample.

use dsm_core::detail::VolumeSegment;
use dsm_core::random::{mix32, unit32};
use dsm_core::{TileHits, Transmittance};

/// What stops a sample's ray: a plain shadow map keeps one depth of it,
/// whatever it meets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blocking {
    /// Surfaces that let nothing through, in any channel. All others, and
    /// media, cast no shadow.
    Opaque,
    /// The first surface that stops anything, and where the first medium
    /// begins: all of them cast full shadows.
    Any,
    /// Every surface stops a sample's ray with its opacity as probability, and
    /// media stop it after a random free path. The share of samples that are
    /// lit at a depth is then, on average, the transmittance there: of a
    /// coloured one, the mean of its channels. Opaque surfaces stop all rays.
    /// Decided by the sample and the hit alone.
    #[default]
    Stochastic,
}

/// Finds what stops each sample of a block.
pub(crate) struct NearestDepths {
    blocking: Blocking,
    /// A depth a sample; infinite where nothing stops it.
    depths: Vec<f32>,
    /// Random bits of each sample.
    bits: Vec<u32>,
}

impl NearestDepths {
    pub(crate) const fn new(blocking: Blocking) -> Self {
        Self { blocking, depths: Vec::new(), bits: Vec::new() }
    }

    /// The depth at which each sample of the block is stopped; infinite where
    /// nothing stops it.
    pub(crate) fn depths(&self) -> &[f32] {
        &self.depths
    }

    /// Finds them; `texel` tells where in the map a sample lies.
    pub(crate) fn find<T: Transmittance>(
        &mut self,
        hits: &TileHits<T>,
        texel: impl Fn(u32) -> [u32; 2],
    ) {
        self.depths.clear();
        self.depths.resize(hits.sample_count() as usize, f32::INFINITY);
        if self.blocking == Blocking::Stochastic && !hits.is_empty() {
            let bits = (0..hits.sample_count()).map(&texel);
            self.bits.clear();
            self.bits.extend(bits.map(|[x, y]| mix32(x ^ mix32(y))));
        }
        for (sample, hit) in hits.surfaces() {
            let depth = &mut self.depths[sample as usize];
            if hit.depth < *depth && self.stops(sample, hit.depth, hit.opacity) {
                self.depths[sample as usize] = hit.depth;
            }
        }
        for (sample, segment) in hits.segments() {
            if let Some(depth) = self.stops_within(*sample, segment) {
                let nearest = &mut self.depths[*sample as usize];
                *nearest = nearest.min(depth);
            }
        }
    }

    /// Whether a surface stops a sample.
    fn stops<T: Transmittance>(&self, sample: u32, depth: f32, opacity: T) -> bool {
        match self.blocking {
            Blocking::Opaque => opacity == T::splat(1.0),
            Blocking::Any => true,
            Blocking::Stochastic if opacity == T::splat(1.0) => true,
            Blocking::Stochastic => {
                let bits = self.bits[sample as usize];
                let opacity = opacity.channel(bits as usize % T::CHANNELS);
                unit32(mix32(bits ^ mix32(depth.to_bits()))) < f64::from(opacity)
            }
        }
    }

    /// Where a stretch of a medium stops a sample, if it does.
    fn stops_within<T: Transmittance>(
        &self,
        sample: u32,
        segment: &VolumeSegment<T>,
    ) -> Option<f32> {
        let ends = [segment.near_extinction, segment.far_extinction];
        match self.blocking {
            Blocking::Opaque => None,
            Blocking::Any => {
                let is_there = ends.iter().any(|end| end.as_ref().iter().any(|&value| value > 0.0));
                is_there.then_some(segment.near)
            }
            Blocking::Stochastic => {
                let bits = self.bits[sample as usize];
                let channel = bits as usize % T::CHANNELS;
                let [near, far] = ends.map(|end| end.as_ref()[channel]);
                // A ray meets the stretches of one medium one after the other,
                // each with a free path of its own.
                let place = mix32(
                    segment.near.to_bits() ^ mix32(segment.far.to_bits() ^ near.to_bits() as u32),
                );
                let free_path = -unit32(mix32(bits ^ place)).ln();
                let length = f64::from(segment.far) - f64::from(segment.near);
                let slope = (far - near) / length;
                // The root of near · t + slope · t²/2 = free path, as it is
                // stable for a slope of 0.
                let square = near * near + 2.0 * slope * free_path;
                let along = 2.0 * free_path / (near + square.sqrt());
                (square >= 0.0 && along <= length).then(|| (f64::from(segment.near) + along) as f32)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dsm_core::{Rgb, SurfaceHit, VolumeSample};

    /// The share of samples that are lit behind each depth, and the number of
    /// samples.
    fn lit<T: Transmittance>(hits: &TileHits<T>, blocking: Blocking, behind: &[f32]) -> Vec<f64> {
        let mut nearest = NearestDepths::new(blocking);
        nearest.find(hits, |sample| [sample % 256, sample / 256]);
        let count = f64::from(hits.sample_count());
        let share = |z: f32| nearest.depths().iter().filter(|&&depth| depth > z).count() as f64;
        behind.iter().map(|&z| share(z) / count).collect()
    }

    fn surfaces<T: Transmittance>(samples: u32, surfaces: &[(f32, T)]) -> TileHits<T> {
        let mut hits = TileHits::new(samples);
        for sample in 0..samples {
            // Not in the order of depths.
            for &(depth, opacity) in surfaces.iter().rev() {
                hits.push_surface(sample, SurfaceHit { depth, opacity }).unwrap();
            }
        }
        hits
    }

    #[test]
    fn opaque_and_any_are_decided_by_opacity() {
        let hits = surfaces(4, &[(1.0, 0.5), (2.0, 1.0), (3.0, 1.0)]);
        assert_eq!(lit(&hits, Blocking::Any, &[0.5, 1.0, 2.0]), [1.0, 0.0, 0.0]);
        assert_eq!(lit(&hits, Blocking::Opaque, &[0.5, 1.0, 2.0]), [1.0, 1.0, 0.0]);
        assert_eq!(lit(&hits, Blocking::Stochastic, &[0.5, 2.0]), [1.0, 0.0]);
        let glass = Rgb::new(1.0, 0.5, 1.0);
        let hits = surfaces(4, &[(1.0, glass)]);
        assert_eq!(lit(&hits, Blocking::Opaque, &[1.0]), [1.0]);
    }

    #[test]
    fn chance_keeps_transmittance() {
        let samples = 1 << 16;
        // Four standard deviations of a share of one half.
        let noise = 2.0 / f64::from(samples).sqrt();
        let hits = surfaces(samples, &[(1.0, 0.25), (2.0, 0.5), (3.0, 0.125)]);
        let shares = lit(&hits, Blocking::Stochastic, &[1.0, 2.0, 3.0]);
        for (share, expected) in shares.into_iter().zip([0.75, 0.375, 0.328_125]) {
            assert!((share - expected).abs() < noise, "{share} {expected}");
        }
        let coloured = surfaces(samples, &[(1.0, Rgb::new(0.0, 0.25, 1.0))]);
        let share = lit(&coloured, Blocking::Stochastic, &[1.0])[0];
        assert!((share - 1.75 / 3.0).abs() < noise, "{share}");
    }

    #[test]
    fn media_end_free_paths() {
        let samples = 1 << 16;
        let mut hits = TileHits::new(samples);
        // Rises from 0 to 1 over [1, 3], then falls to 0.5 at 4.
        let medium = [(1.0, 0.0), (3.0, 1.0), (4.0, 0.5)]
            .map(|(depth, extinction)| VolumeSample { depth, extinction });
        for sample in 0..samples {
            hits.push_volume(sample, &medium, 1.0).unwrap();
        }
        let shares = lit(&hits, Blocking::Stochastic, &[1.0, 2.0, 3.0, 4.0]);
        let noise = 2.0 / f64::from(samples).sqrt();
        for (share, depth) in shares.into_iter().zip([0.0_f64, 0.25, 1.0, 1.75]) {
            assert!((share - (-depth).exp()).abs() < noise, "{share} {depth}");
        }
        assert_eq!(lit(&hits, Blocking::Any, &[0.9, 1.0]), [1.0, 0.0]);
        assert_eq!(lit(&hits, Blocking::Opaque, &[5.0]), [1.0]);
    }
}
