//! Support and weights of the pixel filter (Lokovic & Veach 2000, §3.2, equation
//! 1).

use super::pixel_hits::PixelHits;
use super::settings::BakeSettings;
use crate::curve::surface_sweep::PixelSurfaces;
use crate::filter::{Filter, normalize};
use crate::hits::tile_samples::TileSamples;
use crate::transmittance::Transmittance;

/// The pixels under the filter, their samples' weights and their surfaces.
/// Pixels are numbered as in the block with its border.
#[derive(Debug)]
pub(super) struct Footprint<T: Transmittance> {
    filter: Filter,
    border: u32,
    /// The weights of all samples under the filter, pixel by pixel.
    weights: Vec<f64>,
    /// The surfaces under a filter wider than a pixel.
    keys: Vec<u64>,
    opacities: Vec<T>,
}

impl<T: Transmittance> Footprint<T> {
    pub(super) fn new(settings: &BakeSettings) -> Self {
        let samples = settings.sampling.samples_per_pixel();
        let weights = if settings.filter.is_pixel() {
            vec![f64::from(samples).recip(); samples as usize]
        } else {
            Vec::new()
        };
        let border = settings.border();
        let filter = settings.filter;
        Self { filter, border, weights, keys: Vec::new(), opacities: Vec::new() }
    }

    /// Number of pixels beyond a pixel that the filter reaches.
    pub(super) const fn border(&self) -> u32 {
        self.border
    }

    /// The numbers of the pixels under the filter of the block's `pixel`.
    pub(super) fn pixels(
        &self,
        [x, y]: [u32; 2],
        samples: &TileSamples,
    ) -> impl Iterator<Item = u32> + use<T> {
        let (side, columns) = (2 * self.border + 1, samples.size()[0]);
        (y..y + side).flat_map(move |row| (x..x + side).map(move |column| row * columns + column))
    }

    /// Weighs all samples under the filter of the block's `pixel`.
    pub(super) fn weigh(&mut self, pixel: [u32; 2], samples: &TileSamples) {
        if self.filter.is_pixel() {
            return;
        }
        let centre = [0, 1].map(|axis| {
            f64::from(samples.min()[axis]) + f64::from(pixel[axis] + self.border) + 0.5
        });
        let per_pixel = samples.samples_per_pixel() as usize;
        self.weights.clear();
        for under in self.pixels(pixel, samples) {
            let range = under as usize * per_pixel..(under as usize + 1) * per_pixel;
            let places = samples.x()[range.clone()].iter().zip(&samples.y()[range]);
            let weight = |(x, y)| self.filter.weight(x - centre[0], y - centre[1]);
            self.weights.extend(places.map(weight));
        }
        normalize(&mut self.weights);
    }

    /// The weights of the samples under the filter, pixel by pixel.
    pub(super) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The surfaces under the filter of the block's `pixel`; none if there is
    /// nothing.
    pub(super) fn surfaces<'a>(
        &'a mut self,
        pixel: [u32; 2],
        samples: &TileSamples,
        hits: &'a PixelHits<T>,
    ) -> Option<PixelSurfaces<'a, T>> {
        let per_pixel = samples.samples_per_pixel();
        if self.filter.is_pixel() {
            let under = pixel[1] * samples.size()[0] + pixel[0];
            let met = hits.surfaces(under);
            return (!met.keys.is_empty()).then_some(PixelSurfaces {
                keys: met.keys,
                opacities: met.opacities,
                first: under * per_pixel,
                weights: &self.weights,
            });
        }
        if self.pixels(pixel, samples).all(|under| hits.surfaces(under).keys.is_empty()) {
            return None;
        }
        self.weigh(pixel, samples);
        self.keys.clear();
        self.opacities.clear();
        for (place, under) in (0..).zip(self.pixels(pixel, samples)) {
            let met = hits.surfaces(under);
            for (&key, &opacity) in met.keys.iter().zip(met.opacities) {
                // Numbered from the first sample under the filter on.
                let sample = key as u32 - under * per_pixel + place * per_pixel;
                if self.weights[sample as usize] > 0.0 {
                    self.keys.push((key >> 32) << 32 | u64::from(sample));
                    self.opacities.push(opacity);
                }
            }
        }
        Some(PixelSurfaces {
            keys: &self.keys,
            opacities: &self.opacities,
            first: 0,
            weights: &self.weights,
        })
    }
}
