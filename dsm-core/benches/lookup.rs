//! Filtered lookups in a map in memory: 512² pixels, 8 vertices a pixel.

#![expect(clippy::expect_used, reason = "a benchmark may panic")]

use divan::counter::ItemsCount;
use dsm_core::{
    DeepMap, Filter, FilterShape, Footprint, MapInfo, PixelListsBuilder, Receiver, Vertex,
    VisibilityField, filtered_lookup,
};

const SIZE: u32 = 512;
const QUERIES: u32 = 1 << 16;

fn main() {
    divan::main();
}

/// A hash of `index` in [0, 1).
fn uniform(index: u32) -> f32 {
    let mut bits = index.wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
    for _ in 0..2 {
        bits = (bits ^ (bits >> 15)).wrapping_mul(0x2C1B_3C6D);
    }
    ((bits ^ (bits >> 16)) >> 8) as f32 / (1 << 24) as f32
}

/// 4 to 12 vertices a pixel between depths 1 and 2, falling to a few percent.
fn map() -> DeepMap<f32> {
    let mut pixels = PixelListsBuilder::new(SIZE, SIZE);
    for pixel in 0..SIZE * SIZE {
        let count = 4 + (uniform(pixel) * 9.0) as u32;
        let (mut z, mut value) = (1.0 + 0.2 * uniform(pixel * 3), 1.0);
        for vertex in 0..count {
            pixels.push(Vertex::new(z, value));
            z += (0.05 + uniform(pixel * 77 + vertex)) / count as f32;
            value *= 0.7 + 0.3 * uniform(pixel * 99 + vertex);
        }
        pixels.finish_pixel().expect("the function is valid");
    }
    DeepMap::new(MapInfo::default(), pixels.finish().expect("every pixel was finished"))
}

/// Queries in scanline order, away from the border.
fn receivers() -> Vec<Receiver> {
    let scale = (SIZE - 16) as f32;
    (0..QUERIES)
        .map(|query| {
            let (row, column) = (query / 256, query % 256);
            let along = |step: u32, salt: u32| {
                8.0 + (step as f32 + uniform(query * 2 + salt)) / 256.0 * scale
            };
            Receiver::new([along(column, 0), along(row, 1)], 1.0 + uniform(query + 9))
        })
        .collect()
}

/// Lookups equal the weighted mean of all pixels around them.
fn check(map: &DeepMap<f32>, receivers: &[Receiver], shape: FilterShape, width: u32) {
    let filter = Filter::new(shape, width as f32).expect("wide enough");
    for receiver in receivers.iter().step_by(97) {
        let [x, y] = receiver.position;
        let around = |at: f32| at as u32 - width..at as u32 + width;
        let (mut sum, mut total) = (0.0, 0.0);
        for (row, column) in around(y).flat_map(|row| around(x).map(move |column| (row, column))) {
            let offset = |pixel: u32, at: f32| f64::from(pixel) + 0.5 - f64::from(at);
            let weight = filter.weight(offset(column, x), offset(row, y));
            let Ok(value) = map.evaluate([column, row], receiver.depth);
            sum += weight * f64::from(value);
            total += weight;
        }
        let Ok(found) = filtered_lookup(map, receiver, &Footprint::Isotropic(filter));
        let mean = sum / total;
        assert!((f64::from(found) - mean).abs() < 1e-6, "{found} is not {mean}");
    }
}

fn footprint(shape: FilterShape, width: u32) -> Footprint {
    Footprint::Isotropic(Filter::new(shape, width as f32).expect("wide enough"))
}

fn run(bencher: divan::Bencher, footprint: &Footprint) {
    let (map, receivers) = (map(), receivers());
    bencher.counter(ItemsCount::new(receivers.len())).bench(|| {
        receivers
            .iter()
            .map(|receiver| {
                let Ok(light) = filtered_lookup(&map, receiver, footprint);
                light
            })
            .sum::<f32>()
    });
}

#[divan::bench]
fn point(bencher: divan::Bencher) {
    check(&map(), &receivers(), FilterShape::Box, 1);
    run(bencher, &Footprint::Point);
}

#[divan::bench(args = [3, 5])]
fn box_filter(bencher: divan::Bencher, width: u32) {
    check(&map(), &receivers(), FilterShape::Box, width);
    run(bencher, &footprint(FilterShape::Box, width));
}

#[divan::bench(args = [4])]
fn gaussian(bencher: divan::Bencher, width: u32) {
    check(&map(), &receivers(), FilterShape::Gaussian, width);
    run(bencher, &footprint(FilterShape::Gaussian, width));
}
