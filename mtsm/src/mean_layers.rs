//! The mean of what several rays of a pixel meet, as layers.

use dsm_core::{SurfaceHit, Transmittance};

/// Makes layers of the surfaces that a pixel's rays meet: behind each depth the layers let
/// through the mean of what the rays have left there. Keeps its memory from pixel to pixel.
///
/// Where nothing is left of any ray all start again, as behind the end of a run of a
/// transparent map (Xie, Tabellion & Pearce 2007, §5.1): rays of a light from elsewhere
/// get there. So rays that all meet the same make the layers that one of them makes.
#[derive(Clone, Debug)]
pub(crate) struct MeanLayers<T: Transmittance> {
    /// The ray of each surface, and what it meets.
    met: Vec<(u32, SurfaceHit<T>)>,
    /// What is left of each ray.
    left: Vec<T::Sum>,
}

impl<T: Transmittance> MeanLayers<T> {
    pub(crate) const fn new() -> Self {
        Self { met: Vec::new(), left: Vec::new() }
    }

    /// Appends the layers of these rays, front to back. O(h log h) for h surfaces.
    pub(crate) fn append<'a>(
        &mut self,
        rays: impl ExactSizeIterator<Item = impl Iterator<Item = &'a SurfaceHit<T>>>,
        layers: &mut Vec<SurfaceHit<T>>,
    ) {
        let Self { met, left } = self;
        met.clear();
        left.clear();
        left.resize(rays.len(), T::CLEAR.to_sum());
        for (ray, hits) in (0..).zip(rays) {
            met.extend(hits.map(|&hit| (ray, hit)));
        }
        // Stable: surfaces of one ray at one depth stay in order.
        met.sort_by(|(_, a), (_, b)| a.depth.total_cmp(&b.depth));
        let mut before = sum::<T>(left);
        for here in met.chunk_by(|(_, a), (_, b)| a.depth == b.depth) {
            let mut after = before;
            for &(ray, hit) in here {
                let left = left[ray as usize].as_mut();
                for (channel, (left, after)) in left.iter_mut().zip(after.as_mut()).enumerate() {
                    let stopped = *left * f64::from(hit.opacity.channel(channel));
                    *left -= stopped;
                    *after -= stopped;
                }
            }
            // What rounding has left of a sum that few of many rays still add to.
            let is_least = |after: &f64| *after < 1e-9 * left.len() as f64;
            if after.as_ref().iter().any(is_least) {
                after = sum::<T>(left);
            }
            let opacity = T::from_channels(|channel| {
                let [before, after] = [before, after].map(|sum| sum.as_ref()[channel]);
                let share = if before > 0.0 { 1.0 - after / before } else { 1.0 };
                share.clamp(0.0, 1.0) as f32
            });
            if (0..T::CHANNELS).any(|channel| opacity.channel(channel) > 0.0) {
                layers.push(SurfaceHit { depth: here[0].1.depth, opacity });
            }
            before = after;
            if before.as_ref().iter().all(|&sum| sum == 0.0) {
                left.fill(T::CLEAR.to_sum());
                before = sum::<T>(left);
            }
        }
    }
}

fn sum<T: Transmittance>(left: &[T::Sum]) -> T::Sum {
    let mut sum = T::BLOCKED.to_sum();
    for left in left {
        sum.as_mut().iter_mut().zip(left.as_ref()).for_each(|(sum, left)| *sum += left);
    }
    sum
}

#[cfg(test)]
mod tests {
    use dsm_core::Rgb;
    use dsm_testkit::Random;

    use super::*;

    fn layers<T: Transmittance>(rays: &[Vec<SurfaceHit<T>>]) -> Vec<SurfaceHit<T>> {
        let mut layers = Vec::new();
        MeanLayers::new().append(rays.iter().map(|ray| ray.iter()), &mut layers);
        layers
    }

    /// What layers or a ray leave behind a depth.
    fn past<T: Transmittance>(hits: &[SurfaceHit<T>], depth: f32, channel: usize) -> f64 {
        let passed = hits.iter().filter(|hit| hit.depth <= depth);
        passed.map(|hit| 1.0 - f64::from(hit.opacity.channel(channel))).product()
    }

    fn check<T: Transmittance>(opacity: impl Fn(&mut Random) -> T) {
        let mut random = Random::new(5);
        for count in [1, 2, 3, 16, 64] {
            for _ in 0..50 {
                let rays: Vec<Vec<_>> = (0..count)
                    .map(|_| {
                        let hits = (0..random.below(9)).map(|_| SurfaceHit {
                            depth: 1.0 + random.below(12) as f32,
                            opacity: opacity(&mut random),
                        });
                        hits.collect()
                    })
                    .collect();
                let found = layers(&rays);
                assert!(found.is_sorted_by(|a, b| a.depth < b.depth));
                for depth in 0_u8..15 {
                    let depth = f32::from(depth);
                    for channel in 0..T::CHANNELS {
                        let mean = rays.iter().map(|ray| past(ray, depth, channel)).sum::<f64>();
                        let mean = mean / f64::from(count);
                        let found = past(&found, depth, channel);
                        assert!((found - mean).abs() < 1e-6, "{count} {depth}: {found} {mean}");
                    }
                }
            }
        }
    }

    #[test]
    fn behind_every_depth_layers_leave_the_mean_of_what_rays_have_left() {
        check(|random| if random.below(3) == 0 { 1.0_f32 } else { random.unit() as f32 });
        check(|random| {
            Rgb::from_channels(|_| if random.below(3) == 0 { 1.0 } else { random.unit() as f32 })
        });
    }

    #[test]
    fn rays_that_meet_the_same_make_the_layers_of_one() {
        let opacities = [0.3, 1.0, 0.7, 1e-3, 1.0, 0.999, 0.25];
        let one: Vec<_> = (1_u8..)
            .zip(opacities)
            .map(|(depth, opacity)| SurfaceHit { depth: f32::from(depth), opacity })
            .collect();
        for count in [1, 2, 7, 16, 1000] {
            assert_eq!(layers(&vec![one.clone(); count]), one, "{count}");
        }
    }
}
