//! The weighted sum of many rays.

use dsm_core::detail::{SumVertex, TransmittanceFunction, VisibilitySweep, VisibilityView};
use dsm_core::{RayHits, Rgb, SurfaceHit, Transmittance, Vertex, VolumeSample};
use dsm_testkit::Random;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::support::{config, extreme_ray_hits, ray_hits};
use crate::{check_invariant, telling_depths};

type Weighted<'a, T> = [(f64, &'a TransmittanceFunction<T>)];

/// V at both sides of `z`, by linear search.
pub(crate) fn both_sides<T: Transmittance>(
    vertices: &[SumVertex<T>],
    z: f32,
    channel: usize,
) -> [f64; 2] {
    let value = |vertex: &SumVertex<T>| vertex.value.as_ref()[channel];
    let side = |passed: usize| match (passed.checked_sub(1), vertices.get(passed)) {
        (None, _) => 1.0,
        (Some(near), None) => value(&vertices[near]),
        (_, Some(far)) if far.z == z => value(far),
        (Some(near), Some(far)) => {
            let near = &vertices[near];
            let (z0, z1) = (f64::from(near.z), f64::from(far.z));
            value(near) + (value(far) - value(near)) * ((f64::from(z) - z0) / (z1 - z0))
        }
    };
    let before = vertices.iter().take_while(|vertex| vertex.z < z).count();
    [side(before), side(vertices.iter().take_while(|vertex| vertex.z <= z).count())]
}

/// Equation 1, as it is written.
fn naive<T: Transmittance>(functions: &Weighted<'_, T>, z: f32, channel: usize) -> [f64; 2] {
    let sum = |side: fn(&TransmittanceFunction<T>, f32) -> T::Sum| {
        functions
            .iter()
            .map(|(weight, function)| weight * side(function, z).as_ref()[channel])
            .sum()
    };
    [sum(TransmittanceFunction::before), sum(TransmittanceFunction::at)]
}

fn swept<T: Transmittance>(
    sweep: &mut VisibilitySweep<T>,
    functions: &Weighted<'_, T>,
) -> Vec<SumVertex<T>> {
    let sum = sweep.over(functions);
    let last = sum.final_value();
    let mut vertices = Vec::new();
    sum.run(|vertex| vertices.push(vertex));
    assert_eq!(vertices.last().map_or(T::CLEAR.to_sum(), |vertex| vertex.value), last);
    vertices
}

fn check_sum<T: Transmittance>(
    sweep: &mut VisibilitySweep<T>,
    functions: &Weighted<'_, T>,
    depths: impl IntoIterator<Item = f32>,
) {
    let vertices = swept(sweep, functions);
    check_invariant::<T>(&vertices);
    for z in depths {
        for channel in 0..T::CHANNELS {
            let (found, exact) =
                (both_sides::<T>(&vertices, z, channel), naive(functions, z, channel));
            for (found, exact) in found.into_iter().zip(exact) {
                assert!((found - exact).abs() <= 1e-12, "at {z}: {found}, not {exact}");
                assert!(exact > 0.0 || found == 0.0, "all blocked at {z}, but {found}");
            }
        }
    }
}

/// Rays with unequal weights, one of them 0.
fn check_rays<T: Transmittance>(rays: &[RayHits<T>], error: f64) {
    let functions: Vec<_> =
        rays.iter().map(|hits| TransmittanceFunction::new(hits, error)).collect();
    let total: f64 = (0..rays.len()).map(|index| index as f64).sum();
    let weighted: Vec<_> = functions
        .iter()
        .enumerate()
        .map(|(index, function)| (index as f64 / total.max(1.0), function))
        .collect();
    let depths = functions.iter().flat_map(TransmittanceFunction::vertices).map(|vertex| vertex.z);
    let mut depths: Vec<f32> = depths.collect();
    depths.sort_by(f32::total_cmp);
    depths.dedup();
    let stride = depths.len() / 100 + 1;
    let mut sweep = VisibilitySweep::default();
    let depths = depths.into_iter().step_by(stride).collect();
    if rays.len() > 1 {
        check_sum(&mut sweep, &weighted, telling_depths(depths));
    }
    check_rounding(&mut sweep, &weighted);
    // The same sum again, from used memory.
    assert_eq!(swept(&mut sweep, &weighted), swept(&mut VisibilitySweep::default(), &weighted));
    for function in &functions {
        assert_eq!(swept(&mut sweep, &[(1.0, function)]), function.vertices());
    }
}

/// The rounded function keeps the invariant and follows the sum.
fn check_rounding<T: Transmittance>(sweep: &mut VisibilitySweep<T>, functions: &Weighted<'_, T>) {
    let vertices = swept(sweep, functions);
    let rounded = sweep.over(functions).visibility_function();
    let view = rounded.view();
    assert!(VisibilityView::<T>::new(view.depths(), view.columns()).is_ok());
    for vertex in vertices.iter().step_by(vertices.len() / 100 + 1) {
        let expected = both_sides::<T>(&vertices, vertex.z, 0);
        for (found, expected) in
            [view.before(vertex.z), view.at(vertex.z)].into_iter().zip(expected)
        {
            assert!((f64::from(found.channel(0)) - expected).abs() < 1e-7);
        }
    }
}

fn chord_error() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.9), Just(0.005), Just(1e-4)]
}

proptest! {
    #![proptest_config(config(51))]

    #[test]
    fn mono_matches_naive_sums(rays in vec(ray_hits::<f32>(5), 1..9), error in chord_error()) {
        check_rays(&rays, error);
    }

    #[test]
    fn colour_matches_naive_sums(rays in vec(ray_hits::<Rgb>(5), 1..9), error in chord_error()) {
        check_rays(&rays, error);
    }

    #[test]
    fn extremes_match_naive_sums(
        mono in vec(extreme_ray_hits::<f32>(5), 1..6),
        colour in vec(extreme_ray_hits::<Rgb>(5), 1..6),
        error in chord_error(),
    ) {
        check_rays(&mono, error);
        check_rays(&colour, error);
    }
}

#[test]
fn a_hundred_thousand_vertices_do_not_drift() {
    let mut random = Random::new(1);
    let functions: Vec<TransmittanceFunction<f32>> = (0..64)
        .map(|_| {
            let mut hits = RayHits::default();
            for _ in 0..600 {
                let (depth, opacity) = (100.0 * random.unit() as f32, 0.01 * random.unit() as f32);
                hits.push_surface(SurfaceHit { depth, opacity }).unwrap();
            }
            let samples: Vec<_> = (0..800_u16)
                .map(|index| VolumeSample {
                    depth: (f32::from(index) + random.unit() as f32) * 0.125,
                    extinction: 0.04 * random.unit() as f32,
                })
                .collect();
            hits.push_volume(&samples, 1.0).unwrap();
            TransmittanceFunction::new(&hits, 1e-4)
        })
        .collect();
    let count: usize = functions.iter().map(|function| function.vertices().len()).sum();
    assert!(count > 100_000, "{count}");
    let weighted: Vec<_> = functions.iter().map(|function| (1.0 / 64.0, function)).collect();
    let depths = (0..400_u16).map(|index| f32::from(index) * 0.26);
    let own = functions.iter().map(|function| function.vertices()[1000].z);
    check_sum(&mut VisibilitySweep::default(), &weighted, depths.chain(own));
}

#[test]
fn a_third_each_reaches_its_ends_exactly() {
    let functions: Vec<_> = [1.0, 2.0, 3.0]
        .into_iter()
        .map(|depth| {
            let mut hits = RayHits::default();
            hits.push_surface(SurfaceHit { depth, opacity: Rgb::new(1.0, 0.5, 0.0) }).unwrap();
            TransmittanceFunction::new(&hits, 0.01)
        })
        .collect();
    let weighted: Vec<_> = functions.iter().map(|function| (1.0 / 3.0, function)).collect();
    let vertices = swept(&mut VisibilitySweep::default(), &weighted);
    assert_eq!(vertices[0], Vertex::new(1.0, [1.0; 3]));
    assert_eq!(vertices.len(), 6);
    let last = vertices[5].value;
    assert_eq!((last[0], last[2]), (0.0, 1.0));
    assert!((last[1] - 0.5).abs() < 1e-15);
}
