//! From the hits of a pixel's rays to the vertices of their weighted sum.
//!
//! Items are hits (steps) or vertices of the transmittance functions
//! (volumes). Each case first compares its answer to equation 1.

#![expect(clippy::expect_used, reason = "a benchmark may panic")]

use std::hint::black_box;

use divan::Bencher;
use divan::counter::ItemsCount;
use dsm_core::detail::{TransmittanceBuilder, TransmittanceFunction, VisibilitySweep};
use dsm_core::{RayHits, Rgb, SurfaceHit, Transmittance, VolumeSample};

fn main() {
    divan::main();
}

/// Pseudo-random numbers in [0, 1).
fn uniform(state: &mut u64) -> f32 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 40) as f32 / 16_777_216.0
}

/// Rays through hair: surfaces only, not yet sorted.
fn hair<T: Transmittance>(rays: usize, hits_per_ray: usize) -> Vec<RayHits<T>> {
    let mut state = 7;
    let ray = |_| {
        let mut hits = RayHits::default();
        for _ in 0..hits_per_ray {
            let depth = 3.0 + 2.0 * uniform(&mut state);
            let opacity = T::from_channels(|_| 0.2 + 0.3 * uniform(&mut state));
            hits.push_surface(SurfaceHit { depth, opacity }).expect("a valid hit");
        }
        hits
    };
    (0..rays).map(ray).collect()
}

/// Rays through smoke, each with its own samples, and a surface inside.
fn smoke<T: Transmittance>(rays: usize, samples: u16) -> Vec<RayHits<T>> {
    let mut state = 11;
    let ray = |_| {
        let mut hits = RayHits::default();
        let samples: Vec<_> = (0..samples)
            .map(|index| VolumeSample {
                depth: 3.0 + 2.0 * (f32::from(index) + uniform(&mut state)) / f32::from(samples),
                extinction: T::from_channels(|_| 2.0 * uniform(&mut state)),
            })
            .collect();
        hits.push_volume(&samples, 1.1).expect("a valid medium");
        let surface = SurfaceHit { depth: 4.0, opacity: T::splat(0.5) };
        hits.push_surface(surface).expect("a valid hit");
        hits
    };
    (0..rays).map(ray).collect()
}

fn functions<T: Transmittance>(rays: &[RayHits<T>]) -> Vec<TransmittanceFunction<T>> {
    rays.iter().map(|hits| TransmittanceFunction::new(hits, 0.005)).collect()
}

fn evenly<T: Transmittance>(
    functions: &[TransmittanceFunction<T>],
) -> Vec<(f64, &TransmittanceFunction<T>)> {
    functions.iter().map(|function| ((functions.len() as f64).recip(), function)).collect()
}

/// Compares the sum behind each of its vertices to equation 1.
fn check<T: Transmittance>(weighted: &[(f64, &TransmittanceFunction<T>)]) {
    VisibilitySweep::default().over(weighted).run(|vertex| {
        for channel in 0..T::CHANNELS {
            let sum = |side: fn(&TransmittanceFunction<T>, f32) -> T::Sum| -> f64 {
                let values = weighted
                    .iter()
                    .map(|(weight, function)| weight * side(function, vertex.z).as_ref()[channel]);
                values.sum()
            };
            let value = vertex.value.as_ref()[channel];
            let before = sum(TransmittanceFunction::before);
            let after = sum(TransmittanceFunction::at);
            let error = (value - before).abs().min((value - after).abs());
            assert!(error < 1e-12, "{value} at {}, not {before} or {after}", vertex.z);
        }
    });
}

/// How many pixels a round takes, so that branches cannot be learnt by heart.
const PIXELS: usize = 64;

/// Hits, or vertices where there are media.
fn items<T: Transmittance>(functions: &[TransmittanceFunction<T>]) -> ItemsCount {
    let vertices: usize = functions.iter().map(|function| function.vertices().len()).sum();
    let curved = functions.iter().any(TransmittanceFunction::is_curved);
    ItemsCount::new(if curved { vertices } else { vertices / 2 })
}

/// The sums of pixels of `rays_per_pixel` of these rays.
fn bench_sweep<T: Transmittance>(
    bencher: Bencher<'_, '_>,
    rays_per_pixel: usize,
    rays: &[RayHits<T>],
) {
    let functions = functions(rays);
    let pixels: Vec<_> = functions.chunks(rays_per_pixel).map(evenly).collect();
    pixels.iter().for_each(|weighted| check(weighted));
    let mut sweep = VisibilitySweep::default();
    bencher.counter(items(&functions)).bench_local(|| {
        let mut sum = 0.0;
        for weighted in black_box(&pixels) {
            sweep.over(weighted).run(|vertex| sum += vertex.value.as_ref()[0]);
        }
        sum
    });
}

fn bench_build<T: Transmittance>(bencher: Bencher<'_, '_>, rays: &[RayHits<T>]) {
    let mut functions = functions(rays);
    functions.chunks(16).for_each(|some| check(&evenly(some)));
    let mut builder = TransmittanceBuilder::new(0.005);
    bencher.counter(items(&functions)).bench_local(|| {
        for (hits, function) in black_box(rays).iter().zip(&mut functions) {
            builder.build(hits, function);
        }
    });
}

/// (rays, hits a ray)
const HAIR: [(usize, usize); 3] = [(16, 12), (64, 14), (256, 9)];

#[divan::bench(args = HAIR)]
fn build_steps(bencher: Bencher<'_, '_>, (rays, hits): (usize, usize)) {
    bench_build(bencher, &hair::<f32>(PIXELS * rays, hits));
}

#[divan::bench(args = HAIR)]
fn sweep_steps(bencher: Bencher<'_, '_>, (rays, hits): (usize, usize)) {
    bench_sweep(bencher, rays, &hair::<f32>(PIXELS * rays, hits));
}

#[divan::bench(args = HAIR)]
fn sweep_coloured_steps(bencher: Bencher<'_, '_>, (rays, hits): (usize, usize)) {
    bench_sweep(bencher, rays, &hair::<Rgb>(PIXELS * rays, hits));
}

#[divan::bench]
fn build_smoke(bencher: Bencher<'_, '_>) {
    bench_build(bencher, &smoke::<f32>(PIXELS, 64));
}

#[divan::bench]
fn sweep_smoke(bencher: Bencher<'_, '_>) {
    bench_sweep(bencher, 16, &smoke::<f32>(PIXELS * 16, 64));
}

#[divan::bench]
fn sweep_coloured_smoke(bencher: Bencher<'_, '_>) {
    bench_sweep(bencher, 16, &smoke::<Rgb>(PIXELS * 16, 64));
}
