//! The compressor of fewest vertices.

use dsm_core::detail::{
    Compressor, MinLinkCompressor, SumVertex, VisibilityDifference, paper_greedy,
};
use dsm_core::{Rgb, Side, Tolerance, Transmittance, Vertex, VisibilityFunction};
use dsm_testkit::{FunctionKind, Random, config, is_long};
use proptest::prelude::*;

use crate::fewest::{GRID, fewest};
use crate::functions::{Recipe, both_sides, largest_difference, recipe};
use crate::{LOOKUP_ROUNDING, epsilon, sums};

fn compressed<T: Transmittance>(
    compressor: &mut MinLinkCompressor<T>,
    vertices: &[SumVertex<T>],
    epsilon: f32,
) -> Vec<Vertex<T>> {
    let mut path = Vec::new();
    let tolerance = Tolerance::new(epsilon).unwrap();
    compressor.compress(tolerance, vertices, &mut |vertex| path.push(vertex));
    path
}

/// A small function with vertices at whole numbers: steps and ramps, of which some
/// fall by nothing and some by about twice the tolerance.
fn small(random: &mut Random, epsilon: f64) -> Vec<SumVertex<f32>> {
    let mut z = random.below(4) as u16;
    let mut value = 1.0_f64;
    let mut vertices = vec![Vertex::new(f32::from(z), [value])];
    for _ in 0..1 + random.below(9) {
        let fall = |random: &mut Random, value: f64| {
            let fall = match random.below(5) {
                0 => 0.0,
                1 => epsilon * 2.0 * random.unit(),
                2 => epsilon * 3.0 * random.unit(),
                _ => 0.25 * random.unit(),
            };
            (value - fall).max(0.0)
        };
        z += 1 + random.below(7) as u16;
        if z > GRID {
            break;
        }
        if random.below(2) == 0 {
            value = fall(random, value);
        }
        vertices.push(Vertex::new(f32::from(z), [value]));
        if random.below(4) > 0 {
            value = fall(random, value);
            vertices.push(Vertex::new(f32::from(z), [value]));
        }
    }
    vertices
}

/// Against every path with vertices at whole numbers, and where that takes more, also
/// at the depths of the path that was found.
#[test]
fn no_path_has_fewer_vertices() {
    let mut random = Random::new(0x0d5e_ed18);
    let mut compressor = MinLinkCompressor::<f32>::new(Side::Both);
    let mut fewer = 0;
    let rounds = if is_long() { 100_000 } else { 10_000 };
    for round in 0..rounds {
        let epsilon = [0.1_f32, 0.05, 0.02][round % 3];
        let vertices = small(&mut random, epsilon.into());
        let path = compressed(&mut compressor, &vertices, epsilon);
        assert!(largest_difference(&vertices, &sums(&path)) <= f64::from(epsilon));
        // A little is kept for rounding.
        let narrower: f64 = f64::from(epsilon) * (1.0 - 1.0 / 128.0);
        let least = fewest(&vertices, narrower, &[]);
        assert!(path.len() <= least, "{} is more than {least}: {vertices:?} {path:?}", path.len());
        if path.len() < least {
            fewer += 1;
            let depths: Vec<f64> = path.iter().map(|vertex| vertex.z.into()).collect();
            let least = fewest(&vertices, epsilon.into(), &depths);
            assert!(least <= path.len(), "{vertices:?} {path:?}");
        }
    }
    assert!(fewer < rounds / 20, "{fewer}");
}

/// Everything that holds of one function, one tolerance and one side.
fn keeps_its_promises<T: Transmittance>(recipe: &Recipe, epsilon: f32, side: Side) {
    let vertices = recipe.vertices::<T>(f64::from(epsilon));
    let mut compressor = MinLinkCompressor::<T>::new(side);
    let path = compressed(&mut compressor, &vertices, epsilon);
    let [least, most] = match side {
        Side::Both => [-f64::from(epsilon), f64::from(epsilon)],
        Side::Lighter => [0.0, f64::from(epsilon)],
        Side::Darker => [-f64::from(epsilon), 0.0],
    };
    let stored = sums(&path);
    for z in vertices.iter().map(|vertex| vertex.z).chain(path.iter().map(|vertex| vertex.z)) {
        for channel in 0..T::CHANNELS {
            let (found, wanted) =
                (both_sides(&stored, channel, z), both_sides(&vertices, channel, z));
            for (found, wanted) in found.iter().zip(wanted) {
                let off = found - wanted;
                // The evaluation itself rounds.
                assert!(
                    (least - 1e-15..=most + 1e-15).contains(&off),
                    "off by {off} at {z}: {vertices:?} {path:?}"
                );
            }
        }
    }
    let function = VisibilityFunction::new(path.iter().copied()).unwrap();
    assert!(path.len() <= vertices.len(), "{vertices:?} {path:?}");
    let end = vertices.last().map_or(T::CLEAR.to_sum(), |last| last.value);
    for channel in 0..T::CHANNELS {
        let (last, end) =
            (f64::from(function.view().last().channel(channel)), end.as_ref()[channel]);
        let off = last - end;
        let unit = 1.0 / f64::from(1 << 24);
        assert!(off.abs() <= unit && least <= off && off <= most, "ends at {last}, not {end}");
        assert!(side != Side::Both || last == f64::from(end as f32));
    }
    let clear = vertices.iter().rev().find(|vertex| vertex.value == T::CLEAR.to_sum());
    let first_fall = clear.map_or(0.0_f32, |clear| clear.z);
    assert!(path.first().is_none_or(|first| first.z >= first_fall), "{vertices:?} {path:?}");
    if let (Some(last), Some(end)) = (path.last(), vertices.last()) {
        assert!(last.z <= end.z);
    }
    if side == Side::Both {
        let off = largest_difference(&vertices, &stored);
        assert!(off <= f64::from(epsilon) - LOOKUP_ROUNDING, "{off}");
    }
    let again = compressed(&mut compressor, &vertices, epsilon);
    assert_eq!(again, path, "what came before matters");
}

fn side() -> impl Strategy<Value = Side> {
    prop_oneof![Just(Side::Both), Just(Side::Lighter), Just(Side::Darker)]
}

/// Grey functions have the same path as mono ones, three times.
fn equal_channels_agree(recipe: &Recipe, epsilon: f32, side: Side) {
    let mono = recipe.vertices::<f32>(f64::from(epsilon));
    let grey: Vec<SumVertex<Rgb>> =
        mono.iter().map(|vertex| Vertex::new(vertex.z, [vertex.value[0]; 3])).collect();
    let one = compressed(&mut MinLinkCompressor::<f32>::new(side), &mono, epsilon);
    let three = compressed(&mut MinLinkCompressor::<Rgb>::new(side), &grey, epsilon);
    let splat: Vec<_> =
        one.iter().map(|vertex| Vertex::new(vertex.z, Rgb::splat(vertex.value))).collect();
    assert_eq!(three, splat);
}

proptest! {
    #![proptest_config(config(0x0d5e_ed18))]

    #[test]
    fn mono_min_link_keeps_its_promises(
        recipe in recipe(),
        epsilon in epsilon(),
        side in side(),
    ) {
        keeps_its_promises::<f32>(&recipe, epsilon, side);
    }

    #[test]
    fn rgb_min_link_keeps_its_promises(
        recipe in recipe(),
        epsilon in epsilon(),
        side in side(),
    ) {
        keeps_its_promises::<Rgb>(&recipe, epsilon, side);
    }

    #[test]
    fn grey_has_the_path_of_mono(recipe in recipe(), epsilon in epsilon(), side in side()) {
        equal_channels_agree(&recipe, epsilon, side);
    }

    #[test]
    fn an_asymmetric_tube_is_kept(
        recipe in recipe(),
        epsilon in epsilon(),
        below in 0.1_f32..1.0,
    ) {
        let vertices = recipe.vertices::<f32>(f64::from(epsilon));
        let path = compressed(&mut MinLinkCompressor::<f32>::asymmetric(below, 1.0), &vertices, epsilon);
        let stored = sums(&path);
        let lowest = f64::from(below) * f64::from(epsilon.max(1.0 / (1 << 20) as f32));
        for z in vertices.iter().map(|vertex| vertex.z).chain(path.iter().map(|vertex| vertex.z)) {
            let (found, wanted) = (both_sides(&stored, 0, z), both_sides(&vertices, 0, z));
            for (found, wanted) in found.iter().zip(wanted) {
                prop_assert!(found - wanted >= -lowest && found - wanted <= f64::from(epsilon));
            }
        }
    }
}

/// Long functions, where runs are passed as one: fewer vertices than the paper's
/// compressor leaves, in mono and in colour.
#[test]
fn pixels_need_few_vertices() {
    let mut ratios = [0.0; 2];
    let mut count = 0.0;
    for kind in FunctionKind::ALL {
        for samples in [64, 256] {
            let tolerance = Tolerance::for_samples(samples);
            let (mono, colour) =
                (kind.function::<f32>(samples, 3), kind.function::<Rgb>(samples, 3));
            let path = compressed(
                &mut MinLinkCompressor::<f32>::new(Side::Both),
                &mono,
                tolerance.epsilon(),
            );
            let joint = compressed(
                &mut MinLinkCompressor::<Rgb>::new(Side::Both),
                &colour,
                tolerance.epsilon(),
            );
            for off in [
                VisibilityDifference::between(&mono, &sums(&path)).max(),
                VisibilityDifference::between(&colour, &sums(&joint)).max(),
            ] {
                assert!(off <= f64::from(tolerance.epsilon()), "{kind:?} {samples}: {off}");
            }
            let paper = [
                paper_greedy::<f32>(&mono, tolerance).len(),
                paper_greedy::<Rgb>(&colour, tolerance).len(),
            ];
            for (ratio, (few, many)) in
                ratios.iter_mut().zip([path.len(), joint.len()].into_iter().zip(paper))
            {
                *ratio += (few as f64 / many as f64).ln();
            }
            count += 1.0;
        }
    }
    let [mono, colour] = ratios.map(|ratio| (ratio / count).exp());
    assert!(mono < 0.68 && colour < 0.75, "{mono} {colour}");
}

/// A million vertices that fall by less than rounding, one by one, and a million steps.
#[test]
fn a_million_vertices_are_few() {
    let count = 1_000_000_u32;
    let mut random = Random::new(18);
    let mut value = 1.0_f64;
    let mut vertices = vec![Vertex::new(1.0_f32, [value])];
    for index in 0..count {
        let z = (1 << 20) as f32 + index as f32;
        vertices.push(Vertex::new(z, [value]));
        value *= 1.0 - 4e-6 * random.unit();
        vertices.push(Vertex::new(z, [value]));
    }
    for side in [Side::Both, Side::Lighter, Side::Darker] {
        for epsilon in [1e-3_f32, 1e-4] {
            let path = compressed(&mut MinLinkCompressor::<f32>::new(side), &vertices, epsilon);
            let off = VisibilityDifference::between(&vertices, &sums(&path));
            assert!(off.max() <= f64::from(epsilon), "{side:?} {}", off.max());
            // Chords of an exponential: a half over the square root of the tolerance, or so.
            assert!(path.len() < 90, "{side:?} {epsilon}: {}", path.len());
        }
    }
}
