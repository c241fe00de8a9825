//! From hits to compressed tiles: what a map of hair costs behind its
//! rasteriser. Items are hits. Each case first compares pixels of its answer to
//! equation 1.

#![expect(clippy::expect_used, reason = "a benchmark may panic")]

use std::collections::BTreeMap;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use dsm_core::detail::BakedTile;
use dsm_core::{
    BakeSettings, Baker, Error, Filter, FilterShape, HitSource, PixelSampling, Rgb, TileHits,
    TileSamples, Transmittance,
};

fn main() {
    divan::main();
}

/// A hash of `index` in [0, 1).
fn uniform(index: u64) -> f32 {
    let bits = (index + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let bits = (bits ^ (bits >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    ((bits ^ (bits >> 29)) >> 40) as f32 / 16_777_216.0
}

/// Hits that were found before, as a rasteriser of hair finds them: strand by
/// strand, each over a few samples of some pixels.
struct Hair<T> {
    samples: Vec<u32>,
    depths: Vec<f32>,
    opacities: Vec<T>,
}

/// Samples that a strand covers in a pixel, of sixteen.
const COVERED: u64 = 5;

impl<T: Transmittance> Hair<T> {
    /// As many hits a ray, over `pixels` of `samples` samples each.
    fn new(pixels: u32, samples: u32, hits_per_ray: u32) -> Self {
        let (mut hair, mut place) = (Self::empty(), 0);
        let count = u64::from(pixels * samples * hits_per_ray);
        for touch in 0.. {
            if hair.samples.len() as u64 >= count {
                break;
            }
            // A strand runs through a row of pixels.
            if touch % 24 == 0 {
                place = (uniform(touch * 3) * pixels as f32) as u32;
            }
            place = (place + 1) % pixels;
            let depth = 3.0 + 2.0 * uniform(touch * 3 + 1);
            let opacity = T::from_channels(|channel| {
                0.2 + 0.3 * uniform(touch / 24 * 3 + 2 + channel as u64)
            });
            for covered in 0..COVERED * u64::from(samples) / 16 {
                let sample = (uniform(touch * 64 + covered) * samples as f32) as u32;
                hair.samples.push(place * samples + sample);
                hair.depths.push(depth + 1e-4 * covered as f32);
                hair.opacities.push(opacity);
            }
        }
        hair
    }

    const fn empty() -> Self {
        Self { samples: Vec::new(), depths: Vec::new(), opacities: Vec::new() }
    }
}

impl<T: Transmittance> HitSource<T> for Hair<T> {
    type Error = Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), Error> {
        let fits = self.samples.iter().all(|&sample| sample < samples.len());
        assert!(fits, "the hits were made for these samples");
        hits.push_surface_columns(&self.samples, &self.depths, &self.opacities)
    }
}

/// Compares some pixels, at all their depths, to equation 1. Only for filters
/// of one pixel.
fn check<T: Transmittance>(hair: &Hair<T>, samples: u32, tile: &BakedTile<T>, epsilon: f32) {
    assert!(tile.max_error() <= f64::from(epsilon), "{}", tile.max_error());
    assert!(tile.pixels().view().vertex_count() > 0);
    for pixel in (0..tile.pixels().view().pixel_count()).step_by(97) {
        let first = pixel as u32 * samples;
        let mut rays = BTreeMap::<u32, Vec<(f32, T)>>::new();
        let hits = hair.samples.iter().zip(hair.depths.iter().zip(&hair.opacities));
        for (&sample, (&z, &opacity)) in hits {
            if (first..first + samples).contains(&sample) {
                rays.entry(sample).or_default().push((z, opacity));
            }
        }
        let function = tile.pixels().view().function(pixel);
        for &(z, _) in rays.values().flatten() {
            let blocked: f64 = rays
                .values()
                .map(|hits| {
                    let before = hits.iter().filter(|hit| hit.0 <= z);
                    let left = |hit: &(f32, T)| 1.0 - f64::from(hit.1.channel(0));
                    1.0 - before.map(left).product::<f64>()
                })
                .sum();
            let exact = 1.0 - blocked / f64::from(samples);
            let error = (f64::from(function.at(z).channel(0)) - exact).abs();
            assert!(error <= f64::from(epsilon) + 1e-7, "pixel {pixel} at {z}: {error}");
        }
    }
}

/// Bakes a tile of as many pixels a side as make about 50,000 hits.
fn bench_tile<T: Transmittance>(bencher: Bencher<'_, '_>, (side, samples, hits): (u32, u32, u32)) {
    let hair = Hair::<T>::new(side * side, samples, hits);
    let count = hair.samples.len();
    let mut settings = BakeSettings::new([side, side]).expect("valid settings");
    settings.sampling = PixelSampling::new(samples, 0).expect("valid settings");
    let epsilon = settings.tolerance().epsilon();
    let baker = Baker::new(&hair, settings).expect("valid settings");
    check(&hair, samples, &baker.tile([0, 0]).expect("a tile"), epsilon);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| black_box(&baker).tile([0, 0]).expect("a tile"));
}

/// (pixels a side, samples a pixel, hits a ray)
const TILES: [(u32, u32, u32); 3] = [(16, 16, 12), (8, 64, 14), (4, 256, 9)];

#[divan::bench(args = TILES)]
fn tile(bencher: Bencher<'_, '_>, case: (u32, u32, u32)) {
    bench_tile::<f32>(bencher, case);
}

#[divan::bench(args = TILES)]
fn coloured_tile(bencher: Bencher<'_, '_>, case: (u32, u32, u32)) {
    bench_tile::<Rgb>(bencher, case);
}

/// As many samples as come at once.
#[divan::bench]
fn large_tile(bencher: Bencher<'_, '_>) {
    bench_tile::<f32>(bencher, (32, 16, 12));
}

/// The same hits under filters that reach over the tile's border.
#[divan::bench(args = [3.0, 5.0])]
fn filtered_tile(bencher: Bencher<'_, '_>, width: f32) {
    let (side, samples) = (16, 16);
    let mut settings = BakeSettings::new([side, side]).expect("valid settings");
    settings.filter = Filter::new(FilterShape::Gaussian, width).expect("a filter");
    let with_border = (side + 2 * (0.5 * width - 0.5).ceil() as u32).pow(2);
    let hair = Hair::<f32>::new(with_border, samples, 12);
    let epsilon = f64::from(settings.tolerance().epsilon());
    let baker = Baker::new(&hair, settings).expect("valid settings");
    assert!(baker.tile([0, 0]).expect("a tile").max_error() <= epsilon);
    bencher
        .counter(ItemsCount::new(hair.samples.len()))
        .bench_local(|| black_box(&baker).tile([0, 0]).expect("a tile"));
}
