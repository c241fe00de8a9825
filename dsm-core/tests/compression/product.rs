//! Products of functions, against the product of their values in f64.

use dsm_core::detail::{End, SumVertex, VisibilityDifference, VisibilityProduct};
use dsm_core::{Rgb, Tolerance, Transmittance, Vertex};
use dsm_testkit::config;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::functions::{Recipe, both_sides, recipe};
use crate::{epsilon, run};

/// The vertices of stored functions: `f32` values that don't rise.
fn stored<T: Transmittance>(recipe: &Recipe) -> Vec<SumVertex<T>> {
    let vertices = recipe.vertices::<T>(0.02).into_iter();
    vertices.map(|vertex| Vertex::new(vertex.z, T::from_sum(vertex.value).to_sum())).collect()
}

/// Every vertex's depth, its neighbours, and what lies between.
fn depths<'a, S: 'a>(functions: impl IntoIterator<Item = &'a Vec<Vertex<S>>>) -> Vec<f32> {
    let vertices = functions.into_iter().flatten();
    let mut all: Vec<f32> = vertices.map(|vertex| vertex.z).collect();
    all.sort_by(f32::total_cmp);
    all.dedup();
    let between = all
        .windows(2)
        .flat_map(|pair| [0.03, 0.25, 0.5, 0.8].map(|share| pair[0] + (pair[1] - pair[0]) * share));
    let neighbours = all.iter().flat_map(|z| [z.next_up(), z.next_down()]);
    let mut telling: Vec<f32> = all.iter().copied().chain(between).chain(neighbours).collect();
    telling.retain(|z| *z >= 0.0 && z.is_finite());
    telling
}

fn check<T: Transmittance>(recipes: &[Recipe], asked: f32, compressed_to: f32) {
    let functions: Vec<Vec<SumVertex<T>>> = recipes.iter().map(stored::<T>).collect();
    let mut product = VisibilityProduct::<T>::default();
    product.multiply(&functions, asked.into());
    let vertices = product.vertices().to_vec();
    let chords = product.chord_error();
    assert!(chords <= f64::from(asked).max(Tolerance::CHORD_FLOOR));
    let naive = |channel: usize, z: f32| {
        let sides = functions.iter().map(|function| both_sides(function, channel, z));
        sides.fold([1.0, 1.0], |[a, b], [before, at]| [a * before, b * at])
    };

    for pair in vertices.windows(2) {
        assert!(pair[0].z <= pair[1].z, "{pair:?}");
        let mut both = pair[0].value.as_ref().iter().zip(pair[1].value.as_ref());
        assert!(both.all(|(near, far)| near >= far), "{pair:?}");
    }
    assert!(vertices.windows(3).all(|three| three[0].z < three[2].z));
    assert!(vertices.first().is_none_or(|first| first.value == T::CLEAR.to_sum()));

    for z in depths(functions.iter().chain([&vertices])) {
        for channel in 0..T::CHANNELS {
            let both = both_sides(&vertices, channel, z).into_iter().zip(naive(channel, z));
            for (drawn, true_value) in both {
                let above = drawn - true_value;
                assert!((-1e-12..=chords + 1e-12).contains(&above), "{above} at {z}");
            }
        }
    }
    let last = vertices.last().map_or(T::CLEAR.to_sum(), |vertex| vertex.value);
    for channel in 0..T::CHANNELS {
        let ends = functions.iter().filter_map(|function| function.last());
        let end: f64 = ends.map(|vertex| vertex.value.as_ref()[channel]).product();
        assert_eq!(last.as_ref()[channel], end, "the end");
    }

    let tolerance = Tolerance::new(compressed_to).unwrap();
    let kept = run::<T>(&vertices, tolerance, End::Known(last));
    let kept: Vec<_> = kept.iter().map(|v| Vertex::new(v.z, v.value.to_sum())).collect();
    let off = VisibilityDifference::between(&vertices, &kept).max();
    // Copying rounds to the nearest f32.
    assert!(off <= f64::from(compressed_to).max(3e-8), "{off}");
    let last = T::from_sum(last);
    assert_eq!(kept.last().map_or(T::CLEAR.to_sum(), |v| v.value), last.to_sum());
}

proptest! {
    #![proptest_config(config(0x0d5e_ed01))]

    #[test]
    fn mono_products(functions in vec(recipe(), 0..5), asked in epsilon(), kept in epsilon()) {
        check::<f32>(&functions, asked, kept);
    }

    #[test]
    fn coloured_products(functions in vec(recipe(), 0..4), asked in epsilon(), kept in epsilon()) {
        check::<Rgb>(&functions, asked, kept);
    }

    #[test]
    fn products_as_exact_as_can_be(functions in vec(recipe(), 2..4)) {
        check::<f32>(&functions, 0.0, 0.0);
    }
}

/// Chords cost vertices only where two factors bend, and not many.
#[test]
fn as_few_chords_as_the_error_asks_for() {
    let ramp = |to: f64| vec![Vertex::new(1.0, [1.0]), Vertex::new(9.0, [to])];
    let mut product = VisibilityProduct::<f32>::default();
    for (functions, error, most) in [
        (vec![ramp(0.0), ramp(0.0)], 1e-4, 52),
        (vec![ramp(0.5), ramp(0.5)], 1e-4, 27),
        (vec![ramp(0.0); 8], 1e-4, 72),
        (vec![ramp(0.0), ramp(1.0)], 1e-4, 2),
        (vec![ramp(0.0), ramp(0.0)], 0.0, 710),
    ] {
        product.multiply(&functions, error);
        let count = product.vertices().len();
        assert!((most * 3 / 4..=most).contains(&count), "{count} of {most}");
    }
}
