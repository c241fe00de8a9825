//! Pixels against the oracle.

use dsm_core::detail::{SumVertex, VisibilityDifference};
use dsm_core::{
    BakeSettings, Baker, Filter, FilterShape, PixelSampling, RayHits, RaySource, Rgb, Tolerance,
    Transmittance, Vertex,
};
use dsm_testkit::config;
use proptest::prelude::*;
use proptest::sample::select;

use crate::oracle::Oracle;
use crate::sources::RandomScene;

/// V at both sides of `z`, by linear search.
fn both_sides<T: Transmittance>(vertices: &[SumVertex<T>], z: f32, channel: usize) -> [f64; 2] {
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

/// Holds every pixel of every tile to the oracle, before compression and
/// behind it, and what the tile says of its error to what it is.
fn check<T: Transmittance>(scene: RandomScene, settings: &BakeSettings) {
    let baker = Baker::<T, _>::new(scene, settings.clone()).unwrap();
    let tolerance = settings.tolerance();
    let chord = tolerance.chord();
    let mut pixels_seen = 0;
    for tile in settings.tiles() {
        let mut worst = 0.0_f64;
        let baked = baker.tile(tile).unwrap();
        let min = tile.map(|index| index * settings.tile_size);
        let hits = baker
            .exact_tile(tile, |exact| {
                pixels_seen += 1;
                let [x, y] = exact.pixel();
                let stored = baked.pixels().view().pixel(x - min[0], y - min[1]);
                let stored: Vec<SumVertex<T>> = stored
                    .vertices()
                    .map(|vertex| Vertex::new(vertex.z, vertex.value.to_sum()))
                    .collect();
                let oracle = Oracle::new(settings, [x, y], |point, ray: &mut RayHits<T>| {
                    scene.ray(point, ray)
                });
                assert!(oracle.meets_media() || !exact.is_curved());
                let spent = if exact.is_curved() { chord } else { 0.0 };
                worst = worst
                    .max(spent + VisibilityDifference::between(exact.vertices(), &stored).max());
                for z in oracle.depths() {
                    for channel in 0..T::CHANNELS {
                        let found = both_sides::<T>(exact.vertices(), z, channel);
                        let stored = both_sides::<T>(&stored, z, channel);
                        for side in [0, 1] {
                            let truth = oracle.visibility(channel, z, side == 1);
                            let error = (found[side] - truth).abs();
                            assert!(error <= spent + 1e-12, "{x}, {y} at {z}: {error:e}");
                            let error = (stored[side] - truth).abs();
                            let bound = f64::from(tolerance.epsilon()).max(spent + 1e-7) + 1e-12;
                            assert!(error <= bound, "{x}, {y} at {z}: {error:e}");
                            assert!(truth > 0.0 || found[side] == 0.0, "{x}, {y} at {z}: light");
                            // A channel may end later than it has to, with the last one.
                            let dark = stored[side] == 0.0 || (T::CHANNELS > 1 && z < 20.0);
                            assert!(truth > 0.0 || dark, "{x}, {y} at {z}: light is stored");
                            assert!(z < 20.0 || (stored[side] - truth).abs() <= 1e-7);
                        }
                    }
                }
            })
            .unwrap();
        assert_eq!(hits, baked.hits());
        assert_eq!(worst, baked.max_error());
        assert!(baked.mean_error() <= baked.max_error());
        let bound = f64::from(tolerance.epsilon()).max(Tolerance::CHORD_FLOOR + 1e-7);
        assert!(baked.max_error() <= bound, "{} > {bound}", baked.max_error());
    }
    assert_eq!(pixels_seen, settings.size[0] * settings.size[1]);
}

fn filters() -> impl Strategy<Value = Filter> {
    let boxes = [1.0, 1.5, 2.0, 3.0, 5.0].map(|width| (FilterShape::Box, width));
    let tents = [2.0, 3.5, 5.0].map(|width| (FilterShape::Tent, width));
    let gaussians = [1.0, 2.0, 4.0].map(|width| (FilterShape::Gaussian, width));
    let all: Vec<_> = boxes.into_iter().chain(tents).chain(gaussians).collect();
    // Half of them the filter that has a shorter way.
    prop_oneof![Just((FilterShape::Box, 1.0)), select(all)]
        .prop_map(|(shape, width)| Filter::new(shape, width).unwrap())
}

pub(crate) fn scenes() -> impl Strategy<Value = RandomScene> {
    (any::<u64>(), any::<bool>(), select(vec![0, 1, 40]), any::<bool>()).prop_map(
        |(seed, on_grid, media, backwards)| RandomScene { seed, on_grid, media, backwards },
    )
}

pub(crate) fn settings() -> impl Strategy<Value = BakeSettings> {
    let tolerances = vec![None, Some(0.0), Some(0.003), Some(0.1)];
    (
        [1_u32..5, 1..4],
        select(vec![1, 2, 7, 64]),
        (select(vec![1, 2, 4, 5]), any::<u64>()),
        filters(),
        select(tolerances),
    )
        .prop_map(|(size, tile_size, (samples, seed), filter, tolerance)| {
            let mut settings = BakeSettings::new(size).unwrap();
            settings.tile_size = tile_size;
            settings.sampling = PixelSampling::new(samples, seed).unwrap();
            settings.filter = filter;
            settings.tolerance = tolerance.map(|epsilon| Tolerance::new(epsilon).unwrap());
            settings
        })
}

proptest! {
    #![proptest_config(config(64))]

    #[test]
    fn mono_pixels_match_the_oracle(scene in scenes(), settings in settings()) {
        check::<f32>(scene, &settings);
    }

    #[test]
    fn coloured_pixels_match_the_oracle(scene in scenes(), settings in settings()) {
        check::<Rgb>(scene, &settings);
    }
}

#[test]
fn tolerance_0_keeps_what_the_samples_saw() {
    let scene = RandomScene { seed: 3, on_grid: false, media: 9, backwards: false };
    let mut settings = BakeSettings::new([6, 6]).unwrap();
    settings.tolerance = Some(Tolerance::EXACT);
    settings.sampling = PixelSampling::new(16, 1).unwrap();
    for width in [1.0, 3.0] {
        settings.filter = Filter::new(FilterShape::Box, width).unwrap();
        let map = Baker::<f32, _>::new(
            RaySource(|point, ray: &mut _| scene.ray(point, ray)),
            settings.clone(),
        )
        .unwrap()
        .map()
        .unwrap();
        for pixel in 0..36 {
            let (x, y) = (pixel % 6, pixel / 6);
            let oracle = Oracle::new(&settings, [x, y], |point, ray: &mut RayHits<f32>| {
                scene.ray(point, ray)
            });
            for z in oracle.depths() {
                let (before, at) = (map.pixel(x, y).before(z), map.pixel(x, y).at(z));
                assert!((f64::from(before) - oracle.visibility(0, z, false)).abs() < 1e-5);
                assert!((f64::from(at) - oracle.visibility(0, z, true)).abs() < 1e-5);
            }
        }
    }
}
