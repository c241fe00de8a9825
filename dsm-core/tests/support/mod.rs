//! What property tests share: their configuration, and rays that try to break
//! things.

use dsm_core::{RayHits, SurfaceHit, Transmittance, VolumeSample};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

pub(crate) use dsm_testkit::config;

/// Where the numbers of a ray come from.
#[derive(Clone)]
struct Numbers {
    depth: BoxedStrategy<f32>,
    opacity: BoxedStrategy<f32>,
    extinction: BoxedStrategy<f32>,
    distance_per_depth: BoxedStrategy<f64>,
}

impl Numbers {
    /// Few values, so that depths and opacities meet their like.
    fn grid() -> Self {
        let whole = (0_u8..9).prop_map(f32::from);
        let depth = prop_oneof![
            4 => whole.clone(),
            1 => whole.clone().prop_map(f32::next_up),
            1 => whole.prop_map(|z| z.next_down().max(0.0)),
        ];
        let faint = 2.0_f32.powi(-24);
        Self {
            depth: depth.boxed(),
            opacity: select(vec![0.0, faint, 0.5, 1.0 - faint, 1.0]).boxed(),
            extinction: select(vec![0.0, 1e-6, 0.25, 1.0, 30.0, 1e6]).boxed(),
            distance_per_depth: select(vec![1.0, 1.25]).boxed(),
        }
    }

    /// Any value a scene could have.
    fn random() -> Self {
        Self {
            depth: (0.0_f32..16.0).boxed(),
            opacity: (0.0_f32..=1.0).boxed(),
            extinction: (0.0_f32..3.0).boxed(),
            distance_per_depth: (1.0_f64..2.0).boxed(),
        }
    }

    /// The ends of every range.
    fn extreme() -> Self {
        let tiny = f32::from_bits(1);
        let depths =
            vec![0.0, tiny, tiny.next_up(), 1e-30, 1.0, 1e30, f32::MAX.next_down(), f32::MAX];
        Self {
            depth: select(depths).boxed(),
            opacity: select(vec![0.0, tiny, 0.5, 1.0_f32.next_down(), 1.0]).boxed(),
            extinction: select(vec![0.0, tiny, 1e-30, 1.0, 1e20, f32::MAX]).boxed(),
            distance_per_depth: select(vec![1.0, 1e3, 1e200]).boxed(),
        }
    }

    /// One number a channel, and often the same for all.
    fn channels<T: Transmittance>(of: &BoxedStrategy<f32>) -> BoxedStrategy<T> {
        (vec(of.clone(), T::CHANNELS), prop::bool::ANY)
            .prop_map(|(values, grey)| {
                T::from_channels(|channel| values[if grey { 0 } else { channel }])
            })
            .boxed()
    }

    /// Up to `most` surfaces, slabs and sampled media each, in any order.
    fn hits<T: Transmittance>(&self, most: usize) -> BoxedStrategy<RayHits<T>> {
        let opacity = Self::channels::<T>(&self.opacity);
        let surface = (self.depth.clone(), opacity.clone());
        let slab = (self.depth.clone(), self.depth.clone(), opacity);
        let sample = (self.depth.clone(), Self::channels::<T>(&self.extinction));
        let medium = (vec(sample, 2..5), self.distance_per_depth.clone());
        let half = most.div_ceil(2);
        // Every other ray has surfaces only.
        let media = prop_oneof![
            Just((0, 0)).prop_map(|_| (Vec::new(), Vec::new())),
            (vec(slab, 0..=half), vec(medium, 0..=half)),
        ];
        (vec(surface, 0..=most), media)
            .prop_map(|(surfaces, (slabs, media))| {
                let mut hits = RayHits::default();
                for (depth, opacity) in surfaces {
                    hits.push_surface(SurfaceHit { depth, opacity }).unwrap();
                }
                for (a, b, opacity) in slabs {
                    if a != b {
                        hits.push_slab(a.min(b), a.max(b), opacity).unwrap();
                    }
                }
                for (mut samples, factor) in media {
                    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
                    let samples: Vec<_> = samples
                        .into_iter()
                        .map(|(depth, extinction)| VolumeSample { depth, extinction })
                        .collect();
                    hits.push_volume(&samples, factor).unwrap();
                }
                hits
            })
            .boxed()
    }
}

/// A ray that meets up to `most` surfaces and as many slabs and media, half of
/// the time on a grid of depths with equal and neighbouring ones.
pub(crate) fn ray_hits<T: Transmittance>(most: usize) -> BoxedStrategy<RayHits<T>> {
    prop_oneof![Numbers::grid().hits(most), Numbers::random().hits(most)].boxed()
}

/// A ray whose depths, opacities and extinctions lie at the ends of their
/// ranges.
pub(crate) fn extreme_ray_hits<T: Transmittance>(most: usize) -> BoxedStrategy<RayHits<T>> {
    Numbers::extreme().hits(most)
}
