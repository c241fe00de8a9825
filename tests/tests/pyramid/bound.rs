//! The stated errors and tolerances of all levels, for maps of all shapes.

use dsm_core::{PixelListsBuilder, Rgb, Transmittance, Vertex};
use dsm_io::{Packing, PyramidOptions};
use dsm_testkit::config;
use proptest::prelude::*;
use proptest::sample::select;

use crate::maps::{Content, Shape, pixels, with_pyramid};
use crate::naive::{check_levels, stored};

fn check<T: Transmittance>(shape: &Shape, content: Content) -> Vec<f64> {
    let folder = tempfile::tempdir().unwrap();
    let pixels = pixels::<T>(shape.size, content);
    let reader = with_pyramid(folder.path(), shape, &pixels);
    let what = format!("{shape:?}, {content:?}");
    assert!(reader.verify().is_empty(), "{what}: {:?}", reader.verify());
    let levels = reader.levels();
    let last = levels[levels.len() - 1];
    let is_whole = [last.width, last.height] == [1, 1];
    assert!(is_whole || levels.len() == shape.options.levels as usize, "{what}");
    for (number, level) in (0..).zip(levels) {
        let scaled = shape.epsilon * shape.options.tolerance_scale.powi(number);
        let expected = if number == 0 { shape.epsilon } else { scaled.max(1e-4) };
        assert!((level.tolerance - expected).abs() <= 1e-6 * expected, "{what}: {level:?}");
        assert_eq!([level.view, level.number], [0, number as u32], "{what}");
        assert_eq!([level.tile_width, level.tile_height], [shape.tile; 2], "{what}");
    }
    let exact = stored::<T>(&reader);
    assert!(
        exact.iter().map(|function| function.z.len()).sum::<usize>()
            == pixels.view().vertex_count()
    );
    check_levels::<T>(&reader, &exact, 1, &what, true)
}

/// The shapes that are asked for by name: odd sizes, lines, a point, and tiles
/// that divide them or not.
#[test]
fn every_level_keeps_its_bound_in_maps_of_odd_sizes() {
    let content = Content { seed: 5, on_grid: true, empty: 4 };
    for (size, tiles) in [
        ([1, 1], &[1, 64][..]),
        ([1, 37], &[1, 8, 64]),
        ([53, 1], &[4, 5, 64]),
        ([31, 17], &[1, 2, 3, 7, 16, 48, 64]),
        ([32, 32], &[8, 12, 64]),
        ([257, 3], &[16, 64, 300]),
        ([65, 130], &[32, 64]),
    ] {
        for (&tile, epsilon) in tiles.iter().flat_map(|tile| [(tile, 0.0), (tile, 0.02)]) {
            let errors = check::<f32>(&Shape::new(size, tile, epsilon), content);
            let spent = errors.iter().any(|&error| error > 1e-5);
            assert!(spent || size == [1, 1], "{size:?}: nothing was compressed: {errors:?}");
        }
    }
}

#[test]
fn every_level_of_coloured_maps_keeps_its_bound() {
    for (size, tile) in [([1, 9], 4), ([21, 34], 8), ([21, 34], 6), ([33, 33], 64)] {
        for (epsilon, on_grid) in [(0.0, true), (0.02, false)] {
            let content = Content { seed: 11, on_grid, empty: 6 };
            check::<Rgb>(&Shape::new(size, tile, epsilon), content);
        }
    }
}

/// What is left may round to 1, and the pixel to one without vertices. Then it
/// is still not what the average was.
#[test]
fn light_that_rounds_to_all_of_it_counts_as_an_error() {
    let folder = tempfile::tempdir().unwrap();
    for tile in [1, 4, 6, 16] {
        let mut lists = PixelListsBuilder::new(12, 12);
        for pixel in 0..144 {
            if pixel % 5 == 0 {
                lists.push(Vertex::new(2.0, 1.0_f32));
                lists.push(Vertex::new(2.0, 1.0_f32.next_down()));
            }
            lists.finish_pixel().unwrap();
        }
        let shape = Shape::new([12, 12], tile, 0.0);
        let reader = with_pyramid(folder.path(), &shape, &lists.finish().unwrap());
        let errors = check_levels::<f32>(&reader, &stored::<f32>(&reader), 1, "nearly clear", true);
        assert!(errors.iter().all(|&error| error > 1e-9), "{errors:?}");
        let vertices: u64 = (1..5)
            .flat_map(|level| reader.directory(level).unwrap().iter())
            .map(|(_, entry)| entry.vertex_count)
            .sum();
        assert_eq!(vertices, 0);
    }
}

#[test]
fn large_tolerances_are_spent_and_kept() {
    let content = Content { seed: 3, on_grid: false, empty: 0 };
    for scale in [0.5, 1.0] {
        let mut shape = Shape::new([24, 24], 4, 0.25);
        shape.options = shape.options.with_tolerance_scale(scale);
        let errors = check::<f32>(&shape, content);
        assert!(errors[0] > 0.02, "{errors:?}");
    }
}

fn shape() -> impl Strategy<Value = Shape> {
    let size = (1_u32..=20, 1_u32..=20);
    let tile = select(vec![1, 2, 3, 4, 5, 6, 8, 12, 16, 64]);
    let options = (prop_oneof![Just(u32::MAX), 1_u32..5], select(vec![0.5_f32, 1.0, 0.1]));
    let packing = select(vec![Packing::Plain, Packing::Zstd]);
    let epsilon = select(vec![0.0_f32, 1e-5, 0.02, 0.25, 0.9]);
    (size, tile, epsilon, packing, options).prop_map(|(size, tile, epsilon, packing, options)| {
        Shape {
            size: size.into(),
            tile,
            epsilon,
            packing,
            options: PyramidOptions::default()
                .with_levels(options.0)
                .with_tolerance_scale(options.1),
        }
    })
}

fn content() -> impl Strategy<Value = Content> {
    (any::<u64>(), any::<bool>(), select(vec![0, 8, 15, 16]))
        .prop_map(|(seed, on_grid, empty)| Content { seed, on_grid, empty })
}

proptest! {
    #![proptest_config(config(0x0a11_1e5e))]

    #[test]
    fn any_map_keeps_what_its_levels_state(
        shape in shape(), content in content(), coloured in any::<bool>(),
    ) {
        if coloured {
            check::<Rgb>(&shape, content);
        } else {
            check::<f32>(&shape, content);
        }
    }
}
