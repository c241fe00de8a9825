//! Occluders of a plain shadow map's samples.

use dsm_core::detail::VolumeSegment;
use dsm_core::detail::random::{mix32, unit32};
use dsm_core::{TileHits, Transmittance};

/// The occluder of a sample's ray: a plain shadow map keeps one depth of it,
/// whatever it meets.
///
/// ```
/// use shadow_maps::detail::Blocking;
/// use shadow_maps::plain::DepthMapSettings;
///
/// let mut settings = DepthMapSettings::new([512, 512], 16)?;
/// assert_eq!(settings.blocking, Blocking::Stochastic);
/// settings.blocking = Blocking::Opaque;
/// # Ok::<(), dsm_core::Error>(())
/// ```
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
    /// Decided by the sample, and by how many such surfaces or stretches lie before:
    /// by no depth, which another unit would change.
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
    /// What lets light through: its sample, its depth's bits above those of the opacity
    /// in the sample's channel.
    chances: Vec<(u32, u64)>,
    /// The same of one sample after the other, and where those of each end.
    sorted: Vec<u64>,
    ends: Vec<u32>,
    /// Sample and depth of stretches of media, and which they are.
    stretches: Vec<(u64, u32)>,
}

impl NearestDepths {
    pub(crate) const fn new(blocking: Blocking) -> Self {
        Self {
            blocking,
            depths: Vec::new(),
            bits: Vec::new(),
            chances: Vec::new(),
            sorted: Vec::new(),
            ends: Vec::new(),
            stretches: Vec::new(),
        }
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
        self.chances.clear();
        for (sample, hit) in hits.surfaces() {
            let stops = match self.blocking {
                Blocking::Any => true,
                Blocking::Opaque | Blocking::Stochastic => hit.opacity == T::splat(1.0),
            };
            let depth = &mut self.depths[sample as usize];
            if stops {
                *depth = depth.min(hit.depth);
            } else if self.blocking == Blocking::Stochastic && hit.depth < *depth {
                let channel = self.bits[sample as usize] as usize % T::CHANNELS;
                let opacity = hit.opacity.channel(channel).to_bits();
                self.chances.push((sample, key(hit.depth.to_bits(), opacity)));
            }
        }
        self.take_chances();
        match self.blocking {
            Blocking::Opaque => {}
            Blocking::Any => {
                for (sample, segment) in hits.segments() {
                    let ends = [segment.near_extinction, segment.far_extinction];
                    if ends.iter().any(|end| end.as_ref().iter().any(|&value| value > 0.0)) {
                        let depth = &mut self.depths[*sample as usize];
                        *depth = depth.min(segment.near);
                    }
                }
            }
            Blocking::Stochastic => self.take_free_paths(hits.segments()),
        }
    }

    /// Lets every surface that lets light through stop its sample by chance, the nearest
    /// first.
    fn take_chances(&mut self) {
        let Self { chances, sorted, ends, depths, bits, .. } = self;
        if chances.is_empty() {
            return;
        }
        // By counting; where those of a sample start becomes where they end.
        ends.clear();
        ends.resize(depths.len() + 1, 0);
        chances.iter().for_each(|(sample, _)| ends[*sample as usize + 1] += 1);
        for sample in 1..ends.len() {
            ends[sample] += ends[sample - 1];
        }
        sorted.clear();
        sorted.resize(chances.len(), 0);
        for &(sample, chance) in chances.iter() {
            let end = &mut ends[sample as usize];
            sorted[*end as usize] = chance;
            *end += 1;
        }
        let mut start = 0;
        for ((depth, &bits), &end) in depths.iter_mut().zip(bits.iter()).zip(ends.iter()) {
            let own = &mut sorted[start..end as usize];
            start = end as usize;
            own.sort_unstable();
            let stops = |&(rank, chance): &(u32, u64)| {
                unit32(mix32(bits ^ mix32(rank))) < f64::from(f32::from_bits(chance as u32))
            };
            let nearest = (0..).zip(own.iter().copied()).find(stops);
            if let Some((_, chance)) = nearest {
                *depth = depth.min(f32::from_bits((chance >> 32) as u32));
            }
        }
    }

    /// Lets every stretch of a medium stop its sample after a random free path. A ray meets
    /// the stretches of one medium one after the other, each with a free path of its own.
    fn take_free_paths<T: Transmittance>(&mut self, segments: &[(u32, VolumeSegment<T>)]) {
        let Self { stretches, depths, bits, .. } = self;
        stretches.clear();
        let numbered = (0..).zip(segments);
        stretches.extend(
            numbered
                .map(|(index, (sample, segment))| (key(*sample, segment.near.to_bits()), index)),
        );
        let segment = |index: u32| &segments[index as usize].1;
        stretches.sort_unstable_by(|a, b| {
            a.0.cmp(&b.0).then_with(|| segment(a.1).far.total_cmp(&segment(b.1).far))
        });
        let mut ranks = Ranks::default();
        for &(key, index) in stretches.iter() {
            let (sample, near) = ((key >> 32) as usize, f32::from_bits(key as u32));
            // Other numbers than those of surfaces.
            let rank = !ranks.next(sample);
            if near < depths[sample] {
                let free_path = -unit32(mix32(bits[sample] ^ mix32(rank))).ln();
                let channel = bits[sample] as usize % T::CHANNELS;
                if let Some(depth) = end_of_path(segment(index), channel, free_path) {
                    depths[sample] = depths[sample].min(depth);
                }
            }
        }
    }
}

/// Where in a stretch of a medium a free path ends, an optical depth, if it does.
fn end_of_path<T: Transmittance>(
    segment: &VolumeSegment<T>,
    channel: usize,
    free_path: f64,
) -> Option<f32> {
    let ends = [segment.near_extinction, segment.far_extinction];
    let [near, far] = ends.map(|end| end.as_ref()[channel]);
    let length = f64::from(segment.far) - f64::from(segment.near);
    let slope = (far - near) / length;
    // The root of near · t + slope · t²/2 = free path, as it is stable for a slope of 0.
    let square = near * near + 2.0 * slope * free_path;
    let along = 2.0 * free_path / (near + square.sqrt());
    (square >= 0.0 && along <= length).then(|| (f64::from(segment.near) + along) as f32)
}

/// What is sorted by one word, then by another.
fn key(first: u32, then: u32) -> u64 {
    u64::from(first) << 32 | u64::from(then)
}

/// Counts what comes in the order of samples, for each from 0.
#[derive(Default)]
struct Ranks {
    sample: usize,
    count: u32,
}

impl Ranks {
    fn next(&mut self, sample: usize) -> u32 {
        if sample != self.sample {
            *self = Self { sample, count: 0 };
        }
        self.count += 1;
        self.count - 1
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
    fn no_chance_depends_on_the_unit() {
        let stopped = |scale: f32| {
            let mut hits = surfaces(
                4096,
                &[(1.1, 0.25), (1.3, 0.5), (1.7, 0.75)]
                    .map(|(depth, opacity)| (depth * scale, opacity)),
            );
            let fog = [1.2, 2.9]
                .map(|depth: f32| VolumeSample { depth: depth * scale, extinction: 0.5 / scale });
            (0..4096).for_each(|sample| hits.push_volume(sample, &fog, 1.0).unwrap());
            let mut nearest = NearestDepths::new(Blocking::Stochastic);
            nearest.find(&hits, |sample| [sample % 64, sample / 64]);
            nearest.depths().iter().map(|depth| depth / scale).collect::<Vec<_>>()
        };
        let here = stopped(1.0);
        assert!(here.iter().any(|depth| depth.is_infinite()));
        for there in [1e-4, 0.7, 3e3].map(stopped) {
            let alike = |(a, b): (&f32, &f32)| a == b || (a / b - 1.0).abs() < 1e-6;
            assert!(here.iter().zip(&there).all(alike));
        }
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
