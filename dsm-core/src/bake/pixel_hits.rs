//! A block's hits, pixel by pixel.

use std::ops::Range;

use crate::hits::hit::{RayHits, SurfaceHit, VolumeSegment};
use crate::hits::tile_hits::TileHits;
use crate::transmittance::Transmittance;

/// The hits of a block of pixels, grouped by pixel; within one they keep the
/// order in which they came. O(hits + pixels).
#[derive(Clone, Debug)]
pub(super) struct PixelHits<T: Transmittance> {
    /// First surface of each pixel, and the end.
    starts: Vec<u32>,
    /// Depth bits above the sample.
    keys: Vec<u64>,
    opacities: Vec<T>,
    /// Segments of media, by sample.
    segments: Vec<(u32, VolumeSegment<T>)>,
    samples_per_pixel: u32,
}

impl<T: Transmittance> Default for PixelHits<T> {
    fn default() -> Self {
        Self {
            starts: Vec::new(),
            keys: Vec::new(),
            opacities: Vec::new(),
            segments: Vec::new(),
            samples_per_pixel: 1,
        }
    }
}

/// The surfaces of one pixel or sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surfaces<'a, T> {
    /// Depth bits above the sample.
    pub(super) keys: &'a [u64],
    pub(super) opacities: &'a [T],
}

impl<T: Transmittance> Surfaces<'_, T> {
    /// Surface number `hit`.
    pub(super) fn hit(&self, hit: usize) -> SurfaceHit<T> {
        let depth = f32::from_bits((self.keys[hit] >> 32) as u32);
        SurfaceHit { depth, opacity: self.opacities[hit] }
    }
}

impl<T: Transmittance> PixelHits<T> {
    /// Replaces everything by `hits`, and takes their memory in exchange for
    /// its own.
    pub(super) fn group(&mut self, hits: &mut TileHits<T>, samples_per_pixel: u32) {
        self.samples_per_pixel = samples_per_pixel;
        hits.swap_segments(&mut self.segments);
        // Ray tracers bring them in order.
        if !self.segments.is_sorted_by_key(|&(sample, _)| sample) {
            self.segments.sort_by_key(|&(sample, _)| sample);
        }
        let pixels = (hits.sample_count() / samples_per_pixel) as usize;
        let pixel_of = Divider::new(samples_per_pixel);
        self.starts.clear();
        self.starts.resize(pixels + 2, 0);
        let mut last = 0;
        let mut grouped = true;
        for &key in hits.surface_keys() {
            let pixel = pixel_of.divide(key as u32);
            self.starts[pixel as usize + 2] += 1;
            grouped &= last <= pixel;
            last = pixel;
        }
        let mut start = 0;
        for next in &mut self.starts {
            start += *next;
            *next = start;
        }
        if grouped {
            hits.swap_surfaces(&mut self.keys, &mut self.opacities);
            // What scattering does on the way.
            self.starts.remove(0);
            return;
        }
        // Now `starts[pixel + 1]` is where the pixel starts; scattering moves
        // it to its end, which is where the next one starts.
        self.keys.resize(hits.surface_count(), 0);
        self.opacities.resize(hits.surface_count(), T::BLOCKED);
        for (&key, &opacity) in hits.surface_keys().iter().zip(hits.opacities()) {
            let place = &mut self.starts[pixel_of.divide(key as u32) as usize + 1];
            self.keys[*place as usize] = key;
            self.opacities[*place as usize] = opacity;
            *place += 1;
        }
        self.starts.pop();
    }

    /// The surfaces of `pixel`.
    pub(super) fn surfaces(&self, pixel: u32) -> Surfaces<'_, T> {
        let pixel = pixel as usize;
        let range = self.starts[pixel] as usize..self.starts[pixel + 1] as usize;
        Surfaces { keys: &self.keys[range.clone()], opacities: &self.opacities[range] }
    }

    /// True if any sample hits a medium.
    pub(super) const fn has_media(&self) -> bool {
        !self.segments.is_empty()
    }

    /// The stretches of media in the way of these samples, by sample.
    pub(super) fn segments(&self, samples: Range<u32>) -> &[(u32, VolumeSegment<T>)] {
        let before = |end: u32| self.segments.partition_point(|&(sample, _)| sample < end);
        let start = before(samples.start);
        &self.segments[start..][..before(samples.end) - start]
    }

    /// Passes the hits of each of a pixel's samples to `visit`, one after the
    /// other. `order` is scratch memory.
    pub(super) fn for_each_ray(
        &self,
        pixel: u32,
        order: &mut Vec<u32>,
        mut visit: impl FnMut(&mut RayHits<T>),
    ) {
        let surfaces = self.surfaces(pixel);
        // Hits of one sample may stand anywhere among the pixel's.
        order.clear();
        order.extend(0..surfaces.keys.len() as u32);
        order.sort_by_key(|&hit| surfaces.keys[hit as usize] as u32);
        let mut order = order.iter().peekable();
        let mut ray = RayHits::default();
        let first = pixel * self.samples_per_pixel;
        for sample in first..first + self.samples_per_pixel {
            ray.clear();
            let is_met = |hit: &&u32| surfaces.keys[**hit as usize] as u32 == sample;
            while let Some(&hit) = order.next_if(is_met) {
                ray.push_checked(surfaces.hit(hit as usize));
            }
            for &(_, segment) in self.segments(sample..sample + 1) {
                ray.push_checked_segment(segment);
            }
            visit(&mut ray);
        }
    }

    /// The stretches of media in the way of a pixel's samples.
    pub(super) fn pixel_segments(&self, pixel: u32) -> &[(u32, VolumeSegment<T>)] {
        let first = pixel * self.samples_per_pixel;
        self.segments(first..first + self.samples_per_pixel)
    }
}

/// Divides by a number up to 4096 without a division.
#[derive(Clone, Copy, Debug)]
struct Divider {
    inverse: u64,
}

impl Divider {
    const SHIFT: u32 = 44;

    const fn new(divisor: u32) -> Self {
        // Rounded up by less than 1, which 2³² times is below 2⁴⁴ / 4096.
        Self { inverse: (1_u64 << Self::SHIFT).div_ceil(divisor as u64) }
    }

    const fn divide(self, dividend: u32) -> u32 {
        ((dividend as u128 * self.inverse as u128) >> Self::SHIFT) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiplication_divides() {
        for divisor in [1, 2, 3, 5, 7, 16, 250, 1000, 4095, 4096] {
            let divider = Divider::new(divisor);
            for multiple in [0, 1, 2, 17, 4095, 65_535, u32::MAX / divisor] {
                let dividend = multiple * divisor;
                for dividend in
                    [dividend.saturating_sub(1), dividend, dividend.saturating_add(divisor - 1)]
                {
                    assert_eq!(divider.divide(dividend), dividend / divisor);
                }
            }
            assert_eq!(divider.divide(u32::MAX), u32::MAX / divisor);
        }
    }

    /// Hits of 4 pixels of 3 samples: sample and depth.
    fn grouped(order: &[(u32, f32)]) -> Vec<Vec<(u32, f32)>> {
        let mut hits = TileHits::new(12);
        for &(sample, depth) in order {
            let hit = SurfaceHit { depth, opacity: depth / 100.0 };
            hits.push_surface(sample, hit).unwrap();
            hits.push_slab(sample, depth, depth + 1.0, 0.5).unwrap();
        }
        let mut pixels = PixelHits::default();
        // What stood there before leaves no trace.
        pixels.group(&mut hits.clone(), 1);
        pixels.group(&mut hits, 3);
        let pixel = |pixel: u32| -> Vec<(u32, f32)> {
            let surfaces = pixels.surfaces(pixel);
            let surfaces = surfaces.keys.iter().zip(surfaces.opacities);
            let surfaces: Vec<_> = surfaces
                .map(|(&key, &opacity)| {
                    let depth = f32::from_bits((key >> 32) as u32);
                    assert_eq!(opacity, depth / 100.0);
                    (key as u32, depth)
                })
                .collect();
            let segments = pixels.pixel_segments(pixel);
            assert!(segments.is_sorted_by_key(|&(sample, _)| sample));
            assert_eq!(segments.len(), surfaces.len());
            surfaces
        };
        (0..4).map(pixel).collect()
    }

    #[test]
    fn hits_in_any_order_come_out_by_pixel() {
        let expected =
            [vec![(2, 5.0), (0, 1.0), (2, 3.0)], vec![], vec![(8, 9.0), (6, 1.0)], vec![(9, 4.0)]];
        let rasterised = [(8, 9.0), (2, 5.0), (9, 4.0), (0, 1.0), (6, 1.0), (2, 3.0)];
        assert_eq!(grouped(&rasterised), expected);
        assert_eq!(grouped(&expected.concat()), expected);
        assert_eq!(grouped(&[]), [vec![], vec![], vec![], vec![]]);
    }
}
