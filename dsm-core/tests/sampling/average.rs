//! The average of visibility functions: pixels of coarser mip levels.

use dsm_core::detail::{Polyline, SumVertex, TransmittanceFunction, VisibilitySweep, compress};
use dsm_core::{RayHits, Rgb, Tolerance, Transmittance, Vertex, VisibilityFunction};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::support::{config, extreme_ray_hits, ray_hits};
use crate::sweep::both_sides;
use crate::{check_invariant, telling_depths};

/// What a pixel is made of.
#[derive(Clone, Debug)]
struct Pixel<T: Transmittance> {
    hits: RayHits<T>,
    /// Compression turns staircases into ramps.
    epsilon: f32,
    /// How much of the map it covers.
    area: u8,
}

fn pixels<T: Transmittance>(
    hits: impl Strategy<Value = RayHits<T>>,
) -> impl Strategy<Value = Vec<Pixel<T>>> {
    let epsilon = prop_oneof![Just(0.0), Just(0.02), Just(0.3)];
    let pixel = (hits, epsilon, prop_oneof![Just(1_u8), 0_u8..4])
        .prop_map(|(hits, epsilon, area)| Pixel { hits, epsilon, area });
    vec(pixel, 1..10)
}

fn function<T: Transmittance>(pixel: &Pixel<T>) -> VisibilityFunction<T> {
    let ray = TransmittanceFunction::new(&pixel.hits, 0.01);
    let rounded = VisibilitySweep::default().over(&[(1.0, &ray)]).visibility_function();
    compress(rounded.view(), Tolerance::new(pixel.epsilon).unwrap())
}

fn vertices<T: Transmittance>(function: &VisibilityFunction<T>) -> Vec<SumVertex<T>> {
    (0..function.vertex_count()).map(|vertex| function.sum_vertex(vertex)).collect()
}

/// Holds the average to the sum of the functions' values, each found by linear
/// search, at both sides of every depth that tells on it.
fn check_average<T: Transmittance>(pixels: &[Pixel<T>]) {
    let functions: Vec<_> = pixels.iter().map(function).collect();
    let whole: f64 = pixels.iter().map(|pixel| f64::from(pixel.area)).sum();
    let weights: Vec<_> =
        pixels.iter().map(|pixel| f64::from(pixel.area) / whole.max(1.0)).collect();
    if whole == 0.0 {
        return;
    }
    let weighted: Vec<_> = weights.iter().copied().zip(&functions).collect();
    let mut sweep = VisibilitySweep::<T>::default();
    let sum = sweep.average(&weighted);
    let last = sum.final_value();
    let mut average = Vec::new();
    sum.run(|vertex| average.push(vertex));
    assert_eq!(average.last().map_or(T::CLEAR.to_sum(), |vertex| vertex.value), last);
    if weights.iter().filter(|&&weight| weight > 0.0).count() > 1 {
        check_invariant::<T>(&average);
    }

    let parts: Vec<_> = functions.iter().map(vertices).collect();
    let mut depths: Vec<f32> = parts.iter().flatten().map(|vertex| vertex.z).collect();
    depths.sort_by(f32::total_cmp);
    depths.dedup();
    let stride = depths.len() / 100 + 1;
    for z in telling_depths(depths.into_iter().step_by(stride).collect()) {
        for channel in 0..T::CHANNELS {
            let found = both_sides::<T>(&average, z, channel);
            for (side, found) in found.into_iter().enumerate() {
                let terms = weights.iter().zip(&parts);
                let exact: f64 = terms
                    .map(|(weight, part)| weight * both_sides::<T>(part, z, channel)[side])
                    .sum();
                assert!((found - exact).abs() <= 1e-12, "at {z}: {found}, not {exact}");
                assert!(exact > 0.0 || found == 0.0, "all blocked at {z}, but {found}");
            }
        }
    }
}

proptest! {
    #![proptest_config(config(0x51_9a1e))]

    #[test]
    fn mono_averages_are_the_sums_of_their_parts(pixels in pixels(ray_hits::<f32>(6))) {
        check_average(&pixels);
    }

    #[test]
    fn coloured_averages_are_the_sums_of_their_parts(pixels in pixels(ray_hits::<Rgb>(4))) {
        check_average(&pixels);
    }

    #[test]
    fn averages_bear_depths_and_opacities_at_the_ends(
        pixels in pixels(extreme_ray_hits::<f32>(4)),
    ) {
        check_average(&pixels);
    }
}

#[test]
fn a_depth_of_minus_zero_comes_first() {
    let step =
        |z: f32| VisibilityFunction::new([Vertex::new(z, 1.0_f32), Vertex::new(z, 0.5)]).unwrap();
    // Few and many are sorted by other means.
    for count in [2_u8, 40] {
        let steps: Vec<_> = (1..count).map(f32::from).chain([-0.0]).map(step).collect();
        let weighted: Vec<_> = steps.iter().map(|step| (1.0 / f64::from(count), step)).collect();
        let mut depths = Vec::new();
        VisibilitySweep::<f32>::default().average(&weighted).run(|vertex| depths.push(vertex.z));
        let expected: Vec<_> = (0..count).map(f32::from).flat_map(|z| [z, z]).collect();
        assert_eq!(depths, expected);
    }
}

#[test]
fn pairs_that_are_no_staircase_are_ramps() {
    let function = |vertices: &[(f32, f32)]| {
        VisibilityFunction::new(vertices.iter().map(|&(z, value)| Vertex::new(z, value))).unwrap()
    };
    for (vertices, has_ramps) in [
        (&[][..], false),
        (&[(1.0, 1.0), (1.0, 0.5), (2.0, 0.5), (2.0, 0.0)], false),
        (&[(1.0, 1.0), (1.0, 0.5), (2.0, 0.4), (2.0, 0.0)], true),
        (&[(1.0, 1.0), (2.0, 0.5)], true),
        (&[(1.0, 1.0), (1.0, 0.5), (2.0, 0.5)], true),
    ] {
        assert_eq!(function(vertices).has_ramps(), has_ramps, "{vertices:?}");
    }
}
