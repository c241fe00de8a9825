//! From a ball of hair over a floor to all hits of a shadow camera's rays.
//!
//! Items are hits. First, the hits of some pixels are compared to those of a
//! naive search in `f64`.

#![expect(clippy::expect_used, reason = "a benchmark may panic")]

mod hair;

use std::hint::black_box;

use divan::Bencher;
use divan::counter::ItemsCount;
use dsm_core::{HitSource, TileHits, TileSamples};
use dsm_scene::detail::Rasterizer;
use glam::{DVec2, DVec3, Vec3};
use hair::{SIZE, blocks, build, segments};

fn main() {
    divan::main();
}

/// The depths that a ray meets by a search of all segments in `f64`.
fn naive(x: f64, y: f64) -> Vec<f32> {
    let focal = 0.5 / 15_f64.to_radians().tan();
    let ray = (DVec2::new(x, SIZE as f64 - y) / f64::from(SIZE) - 0.5) / focal;
    let ray = ray.extend(-1.0).normalize();
    let mut depths = Vec::new();
    for segment in segments() {
        let [a, b] = segment.ends.map(Vec3::as_dvec3);
        let across = |point: DVec3| point - ray * point.dot(ray);
        let (first, along) = (across(a), across(b - a));
        let approach = (-first.dot(along) / along.length_squared()).max(0.0);
        let nearest = approach.min(1.0);
        let radius = f64::from(segment.radii[0]);
        let goes_on = (first + along).length() < radius;
        let began_before = segment.is_joined && first.length() < radius;
        if !began_before && (goes_on || (first + along * nearest).length() < radius) {
            let beyond = if goes_on { (approach - nearest) * (b - a).dot(ray) } else { 0.0 };
            let t = (a + (b - a) * nearest).dot(ray) + beyond.clamp(-radius, radius);
            depths.push((-ray.z * t) as f32);
        }
    }
    depths.sort_by(f32::total_cmp);
    depths
}

/// Compares every 4099th sample's hits of the hair.
fn check(rasterizer: &Rasterizer<f32>, blocks: &[TileSamples]) {
    let mut hits = TileHits::new(0);
    let (mut compared, mut differ) = (0, 0);
    for samples in blocks {
        hits.reset(samples.len());
        rasterizer.hits(samples, &mut hits).expect("hits");
        for sample in (17..samples.len()).step_by(16_384) {
            let mut found: Vec<f32> = hits
                .surfaces()
                .filter(|(of, hit)| *of == sample && hit.opacity < 1.0)
                .map(|(_, hit)| hit.depth)
                .collect();
            found.sort_by(f32::total_cmp);
            let point = samples.point(sample);
            let expected = naive(point.x, point.y);
            compared += expected.len();
            if found.len() != expected.len() {
                differ += 1;
                continue;
            }
            assert!(found.iter().zip(&expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-5));
        }
    }
    assert!(compared > 1000 && differ <= 1, "{differ} rays differ, {compared} hits compared");
}

fn all_hits(
    rasterizer: &Rasterizer<f32>,
    blocks: &[TileSamples],
    hits: &mut TileHits<f32>,
) -> usize {
    let block = |samples: &TileSamples| {
        hits.reset(samples.len());
        rasterizer.hits(samples, hits).expect("hits");
        black_box(&*hits).surface_count()
    };
    blocks.iter().map(block).sum()
}

/// Finding the squares of pixels that each primitive touches.
#[divan::bench(sample_count = 10)]
fn binning(bencher: Bencher<'_, '_>) {
    segments();
    bencher.bench_local(build);
}

/// All hits, unsorted, block by block.
#[divan::bench(sample_count = 10)]
fn hits(bencher: Bencher<'_, '_>) {
    let (rasterizer, blocks) = (build(), blocks());
    check(&rasterizer, &blocks);
    let mut hits = TileHits::new(0);
    let count = all_hits(&rasterizer, &blocks, &mut hits);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| all_hits(&rasterizer, &blocks, &mut hits));
}
