//! One ray's transmittance function.

use dsm_core::detail::{TransmittanceFunction, VolumeSegment};
use dsm_core::{RayHits, Rgb, SurfaceHit, Tolerance, Transmittance, VolumeSample};
use proptest::prelude::*;

use crate::support::{config, extreme_ray_hits, ray_hits};
use crate::{check_invariant, telling_depths};

/// The optical depth of one segment up to `z`: the integral of a linear
/// function.
fn segment_optical_depth<T: Transmittance>(
    segment: &VolumeSegment<T>,
    channel: usize,
    z: f32,
) -> f64 {
    let (near, far) = (f64::from(segment.near), f64::from(segment.far));
    let share = ((f64::from(z) - near) / (far - near)).clamp(0.0, 1.0);
    let (from, to) =
        (segment.near_extinction.as_ref()[channel], segment.far_extinction.as_ref()[channel]);
    // No order of these factors leaves the range of f64 in every case.
    (share * (far - near)) * (from * (1.0 - 0.5 * share)) + share * share * 0.5 * (far - near) * to
}

/// τ(z), from the definition.
fn exact<T: Transmittance>(hits: &RayHits<T>, channel: usize, z: f32, inclusive: bool) -> f64 {
    let surfaces: f64 = hits
        .surfaces()
        .iter()
        .filter(|surface| surface.depth < z || (inclusive && surface.depth == z))
        .map(|surface| 1.0 - f64::from(surface.opacity.channel(channel)))
        .product();
    let optical_depth: f64 =
        hits.segments().iter().map(|segment| segment_optical_depth(segment, channel, z)).sum();
    surfaces * (-optical_depth).exp()
}

fn depths_of<T: Transmittance>(hits: &RayHits<T>) -> Vec<f32> {
    let surfaces = hits.surfaces().iter().map(|surface| surface.depth);
    surfaces.chain(hits.segments().iter().flat_map(|segment| [segment.near, segment.far])).collect()
}

fn check_against_closed_form<T: Transmittance>(hits: &RayHits<T>, error: f64) {
    let function = TransmittanceFunction::new(hits, error);
    check_invariant::<T>(function.vertices());
    let vertices: Vec<f32> = function.vertices().iter().map(|vertex| vertex.z).collect();
    for &z in &vertices {
        check_at(hits, &function, z, 1e-13);
    }
    // Everything between, too; of functions with many vertices a part.
    let stride = vertices.len() / 200 + 1;
    let some = vertices.into_iter().step_by(stride).chain(depths_of(hits)).collect();
    for z in telling_depths(some) {
        check_at(hits, &function, z, if function.is_curved() { error + 1e-12 } else { 1e-13 });
    }
    for (channel, &last) in function.last().as_ref().iter().enumerate() {
        assert!((last - exact(hits, channel, f32::INFINITY, true)).abs() < 1e-13);
    }
}

fn check_at<T: Transmittance>(
    hits: &RayHits<T>,
    function: &TransmittanceFunction<T>,
    z: f32,
    bound: f64,
) {
    for (inclusive, found) in [(false, function.before(z)), (true, function.at(z))] {
        for (channel, &found) in found.as_ref().iter().enumerate() {
            let exact = exact(hits, channel, z, inclusive);
            assert!((found - exact).abs() <= bound, "at {z}: {found}, not {exact} ± {bound:e}");
            assert!(exact > 0.0 || inclusive || found <= bound);
        }
    }
}

/// Surfaces and segments the other way round.
fn reversed<T: Transmittance>(hits: &RayHits<T>) -> RayHits<T> {
    let mut other = RayHits::default();
    for &surface in hits.surfaces().iter().rev() {
        other.push_surface(surface).unwrap();
    }
    for segment in hits.segments().iter().rev() {
        let sample = |depth, extinction: T::Sum| VolumeSample {
            depth,
            extinction: T::from_channels(|channel| {
                extinction.as_ref()[channel].min(f64::from(f32::MAX)) as f32
            }),
        };
        let samples = [
            sample(segment.near, segment.near_extinction),
            sample(segment.far, segment.far_extinction),
        ];
        other.push_volume(&samples, 1.0).unwrap();
    }
    other
}

fn check_order<T: Transmittance>(hits: &RayHits<T>, error: f64) {
    // Once through `reversed` so that both have the same f32 extinctions.
    let there = reversed(hits);
    let (a, b) = (
        TransmittanceFunction::new(&there, error),
        TransmittanceFunction::new(&reversed(&there), error),
    );
    assert_eq!(a, b);
}

/// The bound that `TransmittanceBuilder` states.
fn max_vertices<T: Transmittance>(hits: &RayHits<T>, error: f64) -> f64 {
    let error = error.max(Tolerance::CHORD_FLOOR);
    let count = (hits.surfaces().len() + hits.segments().len()) as f64;
    let channels = T::CHANNELS as f64;
    4.0 * count + channels * (3.0 * (count / error).sqrt() + 3.0 / error.sqrt())
}

fn check_extremes<T: Transmittance>(hits: &RayHits<T>, error: f64) {
    let function = TransmittanceFunction::new(hits, error);
    check_invariant::<T>(function.vertices());
    assert!((function.vertices().len() as f64) <= max_vertices(hits, error));
    for z in telling_depths(depths_of(hits)) {
        check_at(hits, &function, z, error.max(Tolerance::CHORD_FLOOR) + 1e-12);
    }
}

fn chord_error() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(Tolerance::CHORD_FLOOR),
        Just(0.005),
        (-6.0..-0.5).prop_map(|e| 10_f64.powf(e))
    ]
}

proptest! {
    #![proptest_config(config(32))]

    #[test]
    fn mono_matches_the_closed_form(hits in ray_hits::<f32>(6), error in chord_error()) {
        check_against_closed_form(&hits, error);
    }

    #[test]
    fn colour_matches_the_closed_form(hits in ray_hits::<Rgb>(6), error in chord_error()) {
        check_against_closed_form(&hits, error);
    }

    #[test]
    fn order_does_not_matter(
        mono in ray_hits::<f32>(6),
        colour in ray_hits::<Rgb>(6),
        error in chord_error(),
    ) {
        check_order(&mono, error);
        check_order(&colour, error);
    }

    #[test]
    fn extremes_stay_finite_and_exact(
        mono in extreme_ray_hits::<f32>(6),
        colour in extreme_ray_hits::<Rgb>(6),
        error in prop_oneof![chord_error(), Just(0.0), Just(f64::NAN)],
    ) {
        check_extremes(&mono, error);
        check_extremes(&colour, error);
    }
}

/// Many overlapping segments, zigzags of the extinction, surfaces in between.
fn crowded_ray(count: u16, scale: f32) -> RayHits<f32> {
    let mut hits = RayHits::default();
    for index in 0..count {
        let z = f32::from(index.wrapping_mul(40_503)) * (1.0 / 65_536.0);
        let (near, far) = (z, z + 0.25 + f32::from(index % 7));
        let samples = [
            VolumeSample { depth: near, extinction: scale * f32::from(index % 3) },
            VolumeSample { depth: 0.5 * (near + far), extinction: scale * f32::from(index % 5) },
            VolumeSample { depth: far, extinction: 0.0 },
        ];
        hits.push_volume(&samples, 1.0 + f64::from(index % 2)).unwrap();
        hits.push_surface(SurfaceHit { depth: z, opacity: 1e-6 }).unwrap();
    }
    hits
}

#[test]
fn a_hundred_thousand_segments_are_no_trouble() {
    let hits = crowded_ray(50_000, 2e-6);
    assert_eq!(hits.segments().len(), 100_000);
    let error = Tolerance::CHORD_FLOOR;
    let function = TransmittanceFunction::new(&hits, error);
    check_invariant::<f32>(function.vertices());
    assert!((function.vertices().len() as f64) <= max_vertices(&hits, error));
    assert!(function.last()[0] > 0.1);
    for vertex in function.vertices().iter().step_by(997) {
        check_at(&hits, &function, vertex.z, 1e-13);
        check_at(&hits, &function, vertex.z + 1e-6, error + 1e-12);
    }
}

#[test]
fn zigzags_need_no_more_vertices_than_promised() {
    for (count, scale) in [(10, 1.0), (100, 0.1), (1_000, 0.01), (10_000, 1e-3), (1_000, 1e6)] {
        let hits = crowded_ray(count, scale);
        for error in [Tolerance::CHORD_FLOOR, 1e-4, 1e-2] {
            let found = TransmittanceFunction::new(&hits, error).vertices().len() as f64;
            assert!(found <= max_vertices(&hits, error), "{count} × {scale}, {error}: {found}");
        }
    }
}
