//! Box lookups of 3 × 3 and 5 × 5 pixels, in scan order and shuffled, through a
//! tile cache that holds the whole map, beside the same map in memory. Before
//! the benchmarks, rounds of both in turn give the ratio of their medians.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark, which prints")]

use std::hint::black_box;
use std::time::Instant;

use divan::Bencher;
use divan::counter::ItemsCount;
use dsm_core::{
    DeepMap, Filter, FilterShape, Footprint, MapInfo, PixelListsBuilder, Receiver, Vertex,
    VisibilityField, filtered_lookup,
};
use dsm_io::detail::{CachedMap, TileCache};
use dsm_io::{AchievedError, Limits, MapReader, Metadata, WriteOptions, write_map};

const SIZES: [u32; 2] = [512, 1024];
const LOOKUPS: u32 = 1 << 17;
const WIDTHS: [u32; 2] = [3, 5];
const ORDERS: [Order; 2] = [Order::Scan, Order::Shuffled];
const ROUNDS: usize = 41;

fn main() {
    let rounds = if std::env::args().any(|argument| argument == "--test") { 1 } else { ROUNDS };
    for size in SIZES {
        let (map, cached) = maps(size);
        for (order, width) in ORDERS.into_iter().flat_map(|order| WIDTHS.map(|w| (order, w))) {
            ratio(&map, &cached, (order, width), rounds);
        }
    }
    divan::main();
}

#[derive(Clone, Copy, Debug)]
enum Order {
    Scan,
    Shuffled,
}

/// A hash of `index` in [0, 1).
fn uniform(index: u32) -> f32 {
    let mut bits = index.wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
    for _ in 0..2 {
        bits = (bits ^ (bits >> 15)).wrapping_mul(0x2C1B_3C6D);
    }
    ((bits ^ (bits >> 16)) >> 8) as f32 / (1 << 24) as f32
}

/// 4 to 12 vertices a pixel between depths 1 and 2, in memory and in a file
/// behind a cache that has room for all of it.
fn maps(size: u32) -> (DeepMap<f32>, CachedMap<f32>) {
    let mut pixels = PixelListsBuilder::new(size, size);
    for pixel in 0..size * size {
        let count = 4 + (uniform(pixel) * 9.0) as u32;
        let (mut z, mut value) = (1.0 + 0.2 * uniform(pixel * 3), 1.0);
        for vertex in 0..count {
            pixels.push(Vertex::new(z, value));
            z += (0.05 + uniform(pixel * 77 + vertex)) / count as f32;
            value *= 0.7 + 0.3 * uniform(pixel * 99 + vertex);
        }
        pixels.finish_pixel().unwrap();
    }
    let map = DeepMap::new(MapInfo::default(), pixels.finish().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let metadata = Metadata::new(size, size, 1, *map.info());
    write_map(&path, metadata, &map, AchievedError::NONE, WriteOptions::default()).unwrap();
    let reader = MapReader::open_in_memory(&path, &Limits::default()).unwrap();
    let cached = TileCache::new(1 << 30).insert(reader).unwrap();
    (map, cached)
}

fn receivers(size: u32, order: Order) -> Vec<Receiver> {
    let side = LOOKUPS.isqrt();
    let scale = size as f32 / side as f32;
    (0..LOOKUPS)
        .map(|lookup| {
            let position = match order {
                Order::Scan => [lookup % side, lookup / side % side]
                    .map(|step| (step as f32 + uniform(2 * lookup + step)) * scale),
                Order::Shuffled => [0, 1].map(|axis| uniform(2 * lookup + axis) * size as f32),
            };
            let inside = position.map(|at| at.min(size as f32 - 0.5));
            Receiver::new(inside, 1.0 + uniform(lookup + 9))
        })
        .collect()
}

fn footprint(width: u32) -> Footprint {
    Footprint::Isotropic(Filter::new(FilterShape::Box, width as f32).unwrap())
}

fn sum<F: VisibilityField<Value = f32>>(
    field: &F,
    receivers: &[Receiver],
    footprint: &Footprint,
) -> f64
where
    F::Error: std::fmt::Debug,
{
    let light = |receiver| filtered_lookup(field, receiver, footprint).unwrap();
    receivers.iter().map(|receiver| f64::from(light(receiver))).sum()
}

/// Both take turns, so that what else the machine does meets both.
fn ratio(map: &DeepMap<f32>, cached: &CachedMap<f32>, (order, width): (Order, u32), rounds: usize) {
    let (receivers, footprint) = (&receivers(map.size()[0], order), &footprint(width));
    let cursor = cached.cursor();
    for receiver in receivers {
        let Ok(expected) = filtered_lookup(map, receiver, footprint);
        let found = filtered_lookup(&cursor, receiver, footprint).unwrap();
        assert_eq!(found.to_bits(), expected.to_bits(), "at {receiver:?}");
    }
    let mut nanoseconds = [Vec::new(), Vec::new()];
    let time = |run: &dyn Fn() -> f64| {
        let start = Instant::now();
        black_box(run());
        start.elapsed().as_secs_f64() * 1e9 / receivers.len() as f64
    };
    for _ in 0..rounds {
        nanoseconds[0].push(time(&|| sum(map, receivers, footprint)));
        nanoseconds[1].push(time(&|| sum(&cursor, receivers, footprint)));
    }
    let mut ratios: Vec<_> =
        nanoseconds[1].iter().zip(&nanoseconds[0]).map(|(c, m)| c / m).collect();
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let [in_memory, through_cache] = nanoseconds.each_mut().map(median);
    let least = nanoseconds.map(|values| values[0]);
    println!(
        "{}², {order:?}, {width} × {width}: in memory {in_memory:.1} ns, cached {through_cache:.1} ns a lookup; \
         ratio of medians {:.3}, median of ratios {:.3}, ratio of minima {:.3}",
        map.size()[0],
        through_cache / in_memory,
        median(&mut ratios),
        least[1] / least[0],
    );
}

#[divan::bench(args = [Order::Scan, Order::Shuffled], consts = SIZES)]
fn in_memory<const SIZE: u32>(bencher: Bencher<'_, '_>, order: Order) {
    let ((map, _), receivers) = (maps(SIZE), receivers(SIZE, order));
    bencher
        .counter(ItemsCount::new(receivers.len()))
        .bench_local(|| sum(&map, &receivers, &footprint(3)));
}

#[divan::bench(args = [Order::Scan, Order::Shuffled], consts = SIZES)]
fn cached<const SIZE: u32>(bencher: Bencher<'_, '_>, order: Order) {
    let ((_, cached), receivers) = (maps(SIZE), receivers(SIZE, order));
    let cursor = cached.cursor();
    bencher
        .counter(ItemsCount::new(receivers.len()))
        .bench_local(|| sum(&cursor, &receivers, &footprint(3)));
}
