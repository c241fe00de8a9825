//! What a compressor promises, for every function that satisfies its
//! precondition, in one channel and in three.

#![expect(clippy::unwrap_used, reason = "a test may stop where a value is refused")]

mod cases;
mod fewest;
mod functions;
mod min_link;
mod product;

use dsm_core::detail::{
    End, GreedyCompressor, SumVertex, VisibilityDifference, compress, paper_greedy,
};
use dsm_core::{Rgb, Tolerance, Transmittance, Vertex, VisibilityFunction};
use dsm_testkit::config;
use functions::{Recipe, both_sides, largest_difference, recipe};
use proptest::prelude::*;

/// What rounding at a lookup may add to a compressed function.
const LOOKUP_ROUNDING: f64 = 1.0 / (1 << 24) as f64;

fn epsilon() -> impl Strategy<Value = f32> {
    prop_oneof![
        Just(0.1),
        Just(0.0625),
        Just(0.02),
        Just(0.005),
        Just(1e-4),
        Just(GreedyCompressor::<f32>::COPY_BELOW),
        Just(0.999),
        1e-6_f32..0.5,
    ]
}

fn run<T: Transmittance>(
    vertices: &[SumVertex<T>],
    tolerance: Tolerance,
    end: End<T>,
) -> Vec<Vertex<T>> {
    let mut compressed = Vec::new();
    let mut compressor = GreedyCompressor::new(tolerance, end);
    compressor.push_all(vertices, &mut |vertex| compressed.push(vertex));
    compressor.finish(&mut |vertex| compressed.push(vertex));
    compressed
}

fn end_of<T: Transmittance>(vertices: &[SumVertex<T>], know: bool) -> End<T> {
    if !know {
        return End::Unknown;
    }
    End::Known(vertices.last().map_or(T::CLEAR.to_sum(), |last| last.value))
}

fn sums<T: Transmittance>(vertices: &[Vertex<T>]) -> Vec<SumVertex<T>> {
    vertices.iter().map(|vertex| Vertex::new(vertex.z, vertex.value.to_sum())).collect()
}

/// Everything that holds of one function, one tolerance and one end.
fn keeps_its_promises<T: Transmittance>(recipe: &Recipe, epsilon: f32, know: bool) {
    let vertices = recipe.vertices::<T>(f64::from(epsilon));
    let tolerance = Tolerance::new(epsilon).unwrap();
    let compressed = run::<T>(&vertices, tolerance, end_of(&vertices, know));

    let difference = largest_difference(&vertices, &sums(&compressed));
    assert!(difference <= f64::from(epsilon) - LOOKUP_ROUNDING, "{difference} > {epsilon}");
    let walked = VisibilityDifference::between(&vertices, &sums(&compressed)).max();
    assert!((walked - difference).abs() <= 1e-13, "{walked} is not {difference}");

    let function = VisibilityFunction::new(compressed.iter().copied()).unwrap();
    assert!(compressed.len() <= vertices.len());
    let mut depths = vertices.iter().map(|vertex| vertex.z);
    assert!(compressed.iter().all(|vertex| depths.any(|z| z == vertex.z)), "not a subset");
    let last = vertices.last().map_or(T::CLEAR, |last| T::from_sum(last.value));
    assert_eq!(function.view().last(), last, "the end");
    if vertices.iter().all(|vertex| vertex.value == T::CLEAR.to_sum()) {
        assert!(compressed.is_empty(), "it never falls");
    }

    for vertex in &vertices {
        let (before, at) = (function.view().before(vertex.z), function.view().at(vertex.z));
        for channel in 0..T::CHANNELS {
            let sides = both_sides(&vertices, channel, vertex.z);
            for (found, wanted) in [before, at].iter().zip(sides) {
                let off = (f64::from(found.channel(channel)) - wanted).abs();
                assert!(off <= f64::from(epsilon), "looked up at {}: off by {off}", vertex.z);
            }
        }
    }

    let mut streamed = Vec::new();
    let mut compressor = GreedyCompressor::new(tolerance, end_of(&vertices, know));
    for round in 0..2 {
        streamed.clear();
        if round > 0 {
            compressor.restart(end_of(&vertices, know));
        }
        for &vertex in &vertices {
            compressor.push(vertex, &mut |vertex| streamed.push(vertex));
        }
        compressor.finish(&mut |vertex| streamed.push(vertex));
        assert_eq!(streamed, compressed, "streamed, round {round}");
    }
}

fn copies<T: Transmittance>(recipe: &Recipe, epsilon: f32, know: bool) {
    let vertices = recipe.vertices::<T>(0.01);
    let compressed = run::<T>(&vertices, Tolerance::new(epsilon).unwrap(), end_of(&vertices, know));
    let rounded: Vec<_> =
        vertices.iter().map(|vertex| Vertex::new(vertex.z, T::from_sum(vertex.value))).collect();
    assert_eq!(compressed, rounded);
    let function = VisibilityFunction::new(compressed).unwrap();
    assert_eq!(compress(function.view(), Tolerance::EXACT), function);
}

/// Sums may be off in their last bits.
fn bears_rounding<T: Transmittance>(recipe: &Recipe, epsilon: f32, know: bool) {
    let mut vertices = recipe.vertices::<T>(f64::from(epsilon));
    for (index, vertex) in vertices.iter_mut().enumerate().skip(1) {
        let by = [1e-15, -1e-15, 0.0, 4e-13, -4e-13][index % 5];
        vertex.value.as_mut().iter_mut().for_each(|value| *value += by);
    }
    let compressed = run::<T>(&vertices, Tolerance::new(epsilon).unwrap(), end_of(&vertices, know));
    let function = VisibilityFunction::new(compressed.iter().copied()).unwrap();
    assert!(compressed.len() <= vertices.len());
    let difference = largest_difference(&vertices, &sums(&compressed));
    let bound = f64::from(epsilon.max(GreedyCompressor::<T>::COPY_BELOW)) - LOOKUP_ROUNDING;
    assert!(difference <= bound, "{difference} > {bound}");
    let last = vertices.last().unwrap().value;
    for channel in 0..T::CHANNELS {
        let (last, wanted) = (function.view().last().channel(channel), last.as_ref()[channel]);
        assert!((f64::from(last) - wanted).abs() <= LOOKUP_ROUNDING, "ends at {last}");
    }
}

fn passes_add_up<T: Transmittance>(recipe: &Recipe, epsilon: f32) {
    let vertices = recipe.vertices::<T>(f64::from(epsilon));
    let tolerance = Tolerance::new(epsilon).unwrap();
    let mut function =
        VisibilityFunction::new(run::<T>(&vertices, tolerance, end_of(&vertices, true))).unwrap();
    for pass in 2..6 {
        let next = compress(function.view(), tolerance);
        assert!(next.view().len() <= function.view().len());
        assert_eq!(next.view().last(), function.view().last());
        function = next;
        let stored: Vec<_> = function.view().vertices().collect();
        let difference = largest_difference(&vertices, &sums(&stored));
        assert!(difference <= f64::from(pass) * f64::from(epsilon), "pass {pass}: {difference}");
    }
}

fn paper_keeps_its_bound<T: Transmittance>(recipe: &Recipe, epsilon: f32) {
    let vertices = recipe.vertices::<T>(f64::from(epsilon));
    let compressed = paper_greedy::<T>(&vertices, Tolerance::new(epsilon).unwrap());
    // Where a step is bridged by one vertex, that vertex is within ε of both
    // of its sides; the function is compared at the vertices only, because
    // the last one may end above or below V(∞).
    let mut worst = 0.0_f64;
    for z in vertices.iter().map(|vertex| vertex.z) {
        for channel in 0..T::CHANNELS {
            let wanted = both_sides(&vertices, channel, z);
            let found = both_sides(&compressed, channel, z);
            for (wanted, found) in wanted.iter().zip(found) {
                worst = worst.max((wanted - found).abs());
            }
        }
    }
    assert!(worst <= f64::from(epsilon) * (1.0 + 1e-6), "{worst} > {epsilon}");
}

fn walk_agrees<T: Transmittance>(a: &Recipe, b: &Recipe) {
    let (a, b) = (a.vertices::<T>(0.1), b.vertices::<T>(0.02));
    let walked = VisibilityDifference::between(&a, &b);
    assert!((walked.max() - largest_difference(&a, &b)).abs() <= 1e-13);
    let [a_sides, b_sides] =
        [&a, &b].map(|function| both_sides(function, walked.channel(), walked.depth()));
    let there = (a_sides[0] - b_sides[0]).abs().max((a_sides[1] - b_sides[1]).abs());
    assert!((there - walked.max()).abs() <= 1e-13, "not at {}", walked.depth());

    let swapped = VisibilityDifference::between(&b, &a);
    assert_eq!((swapped.max(), swapped.depth()), (walked.max(), walked.depth()));
    assert_eq!(VisibilityDifference::between(&a, &a), VisibilityDifference::default());

    // Both are linear between their vertices, so a split at every crossing
    // makes the trapezium rule exact.
    let mut knots: Vec<f32> = a.iter().chain(&b).map(|vertex| vertex.z).collect();
    knots.sort_by(f32::total_cmp);
    knots.dedup();
    let length = f64::from(knots[knots.len() - 1]) - f64::from(knots[0]);
    let mut total = 0.0;
    for channel in 0..T::CHANNELS {
        let difference =
            |z, side: usize| both_sides(&a, channel, z)[side] - both_sides(&b, channel, z)[side];
        if length == 0.0 {
            total += (difference(knots[0], 0).abs() + difference(knots[0], 1).abs()) / 2.0;
        }
        for pair in knots.windows(2) {
            let share = (f64::from(pair[1]) - f64::from(pair[0])) / length;
            let (from, to) = (difference(pair[0], 1), difference(pair[1], 0));
            let crossing = if from * to < 0.0 { from / (from - to) } else { 0.5 };
            let middle = from + (to - from) * crossing;
            total += share
                * (crossing * (from.abs() + middle.abs())
                    + (1.0 - crossing) * (middle.abs() + to.abs()))
                / 2.0;
        }
    }
    let mean = total / T::CHANNELS as f64;
    assert!((walked.mean() - mean).abs() <= 1e-12, "{} is not {mean}", walked.mean());
}

proptest! {
    #![proptest_config(config(0x0d5e_ed01))]

    #[test]
    fn mono_keeps_its_promises(recipe in recipe(), epsilon in epsilon(), know: bool) {
        keeps_its_promises::<f32>(&recipe, epsilon, know);
    }

    #[test]
    fn rgb_keeps_its_promises(recipe in recipe(), epsilon in epsilon(), know: bool) {
        keeps_its_promises::<Rgb>(&recipe, epsilon, know);
    }

    #[test]
    fn tiny_tolerances_copy(
        recipe in recipe(),
        epsilon in prop_oneof![Just(0.0), Just(1e-9), Just(9e-7_f32)],
        know: bool,
    ) {
        copies::<f32>(&recipe, epsilon, know);
        copies::<Rgb>(&recipe, epsilon, know);
    }

    #[test]
    fn last_bits_do_no_harm(
        recipe in recipe(),
        epsilon in prop_oneof![Just(0.0), epsilon()],
        know: bool,
    ) {
        bears_rounding::<f32>(&recipe, epsilon, know);
        bears_rounding::<Rgb>(&recipe, epsilon, know);
    }

    #[test]
    fn errors_of_passes_add_up(recipe in recipe(), epsilon in epsilon()) {
        passes_add_up::<f32>(&recipe, epsilon);
        passes_add_up::<Rgb>(&recipe, epsilon);
    }

    #[test]
    fn the_paper_keeps_its_bound(recipe in recipe(), epsilon in epsilon()) {
        paper_keeps_its_bound::<f32>(&recipe, epsilon);
        paper_keeps_its_bound::<Rgb>(&recipe, epsilon);
    }

    #[test]
    fn equal_channels_compress_like_one(recipe in recipe(), epsilon in epsilon(), know: bool) {
        let mono = recipe.vertices::<f32>(f64::from(epsilon));
        let grey: Vec<SumVertex<Rgb>> =
            mono.iter().map(|vertex| Vertex::new(vertex.z, [vertex.value[0]; 3])).collect();
        let tolerance = Tolerance::new(epsilon).unwrap();
        let one = run::<f32>(&mono, tolerance, end_of(&mono, know));
        let three = run::<Rgb>(&grey, tolerance, end_of(&grey, know));
        let splat: Vec<_> =
            one.iter().map(|vertex| Vertex::new(vertex.z, Rgb::splat(vertex.value))).collect();
        prop_assert_eq!(three, splat);
    }

    #[test]
    fn the_walk_agrees_with_looking_everywhere(a in recipe(), b in recipe()) {
        walk_agrees::<f32>(&a, &b);
        walk_agrees::<Rgb>(&a, &b);
    }
}
