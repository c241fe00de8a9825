//! The runs of multilayer transparent shadow maps.

use dsm_core::detail::Quantization;
use dsm_core::{PixelSampling, Rgb, Tolerance, Transmittance, VisibilityField};
use dsm_testkit::config;
use mtsm::detail::Layer;
use mtsm::{MultilayerBaker, MultilayerMap, MultilayerSettings};
use proptest::prelude::*;

use crate::oracle::{Pixel, Ray, media, sheets};

const TOLERANCES: [f32; 5] = [0.0, 0.005, 0.02, 0.1, 0.3];

fn settings(samples: usize, tolerance: f32, resets: u32) -> MultilayerSettings {
    let mut settings = MultilayerSettings::new([1, 1]).unwrap();
    if samples > 1 {
        settings.bake.sampling = PixelSampling::new(samples as u32, 3).unwrap();
    }
    settings.bake.tolerance = Some(Tolerance::new(tolerance).unwrap());
    settings.resets = resets;
    settings.max_layers = u32::MAX;
    settings
}

fn bake<T: Transmittance>(pixel: &Pixel, settings: &MultilayerSettings) -> MultilayerMap<T> {
    MultilayerBaker::new(pixel.clone(), settings.clone()).unwrap().map().unwrap()
}

/// Where a run that starts behind `start` has no light left, if it ends.
fn run_end<T: Transmittance>(pixel: &Pixel, start: f32, tolerance: f32) -> Option<f32> {
    let mut depths = pixel.falls(T::CHANNELS, start);
    depths.retain(|&z| {
        (0..T::CHANNELS)
            .all(|channel| pixel.visibility(channel, start, z, true) <= f64::from(tolerance) / 8.0)
    });
    depths.first().copied()
}

fn check_sheets<T: Transmittance>(pixel: &Pixel, tolerance: f32, resets: u32) {
    let map = bake::<T>(pixel, &settings(pixel.0.len(), tolerance, resets));
    // What rounding of values to f32 may add, where vertices are copied.
    let bound = f64::from(tolerance) + 2.0_f64.powi(-24);
    let mut start = 0.0_f32;
    let mut runs = map.pixels().runs(0);
    for number in 0..=resets {
        let falls = pixel.falls(T::CHANNELS, start);
        let end = run_end::<T>(pixel, start, tolerance);
        let reach = end.unwrap_or(f32::INFINITY);
        let falls: Vec<f32> = falls.into_iter().filter(|&z| z <= reach).collect();
        let Some(run) = runs.next() else {
            assert!(falls.is_empty(), "run {number} is missing: {falls:?}");
            break;
        };
        for z in pixel.depths().into_iter().filter(|&z| z > start && z <= reach) {
            for channel in 0..T::CHANNELS {
                for (stored, inclusive) in
                    [(run.function().before(z), false), (run.function().at(z), true)]
                {
                    let exact = pixel.visibility(channel, start, z, inclusive);
                    let error = (f64::from(stored.channel(channel)) - exact).abs();
                    assert!(error <= bound, "run {number}, {z}: {stored:?}, not {exact}");
                }
            }
        }
        assert_eq!(run.is_opaque(), end.is_some(), "run {number}");
        let counted: u64 = run.counts().iter().map(|&count| u64::from(count)).sum();
        assert_eq!(counted, falls.len() as u64, "run {number}");
        let mut so_far = 0;
        let layers: Vec<Layer<T>> = run.layers().collect();
        for (index, layer) in layers.iter().enumerate() {
            so_far += layer.count;
            if index > 0 && layers[index - 1].depth == layer.depth {
                let there = falls.iter().filter(|&&z| z == layer.depth).count() as u32;
                // Light that falls by less than a value's rounding ends no layer.
                let faint = if index + 1 == layers.len() { u32::MAX } else { there };
                assert!((there..=faint).contains(&layer.count), "layer {index} of {layers:?}");
            }
            if layers.get(index + 1).is_none_or(|next| next.depth > layer.depth) {
                let before = falls.iter().filter(|&&z| z < layer.depth).count() as u32;
                let up_to = falls.iter().filter(|&&z| z <= layer.depth).count() as u32;
                let last = index + 1 == layers.len();
                assert!(
                    so_far >= before && (so_far <= up_to || last),
                    "layer {index} of {layers:?}"
                );
            }
        }
        match end {
            Some(end) => start = end,
            None => break,
        }
    }
    assert!(runs.next().is_none());
}

fn check_first_run<T: Transmittance>(pixel: &Pixel, tolerance: f32) {
    let map = bake::<T>(pixel, &settings(pixel.0.len(), tolerance, 2));
    let bound = f64::from(tolerance) + Tolerance::CHORD_FLOOR + 2.0_f64.powi(-24);
    let end = map.pixels().first_run(0).filter(|run| run.is_opaque());
    let end = end.map_or(f32::INFINITY, |run| *run.function().depths().last().unwrap());
    for z in pixel.depths() {
        let stored = map.evaluate([0, 0], z).unwrap();
        for channel in 0..T::CHANNELS {
            let exact = pixel.visibility(channel, 0.0, z, true);
            let error = (f64::from(stored.channel(channel)) - exact).abs();
            // Behind its end a run is 0, and so is the light, but for ε.
            assert!(error <= bound, "{z}, before {end}: {stored:?}, not {exact}");
        }
    }
    for run in map.pixels().runs(0).rev().skip(1) {
        assert!(run.is_opaque());
    }
}

proptest! {
    #![proptest_config(config(71))]

    #[test]
    fn runs_keep_their_bound_and_their_samples(
        pixel in prop_oneof![sheets(1), sheets(4), sheets(7)],
        tolerance in proptest::sample::select(&TOLERANCES[..]), resets in 0_u32..5,
    ) {
        check_sheets::<f32>(&pixel, tolerance, resets);
        check_sheets::<Rgb>(&pixel, tolerance, resets);
    }

    #[test]
    fn the_first_run_is_a_deep_map_of_media_too(
        pixel in prop_oneof![media(1), media(4)],
        tolerance in proptest::sample::select(&TOLERANCES[..]),
    ) {
        check_first_run::<f32>(&pixel, tolerance);
        check_first_run::<Rgb>(&pixel, tolerance);
    }
}

fn one_ray(sheets: &[(f32, f32)], slabs: &[(f32, f32, f32)]) -> Pixel {
    Pixel(vec![Ray { sheets: sheets.to_vec(), slabs: slabs.to_vec() }])
}

#[test]
fn a_medium_starts_again_where_it_has_swallowed_all() {
    // Optical depth 40: light falls under ε/8 = e⁻⁶ every 6 units.
    let pixel = one_ray(&[], &[(1.0, 40.0, 1.0)]);
    let tolerance = 8.0 * (-6.0_f32).exp();
    let map = bake::<f32>(&pixel, &settings(1, tolerance, 3));
    let runs: Vec<_> = map.pixels().runs(0).collect();
    assert_eq!(runs.len(), 4);
    for (start, run) in [1.0, 7.0, 13.0, 19.0].into_iter().zip(runs) {
        let depths = run.function().depths();
        // Chords end where they like, somewhat behind the threshold.
        let (first, last) = (depths[0], depths[depths.len() - 1]);
        assert!((first - start).abs() < 0.4 * start, "{depths:?}");
        assert!(last - first > 3.0 && last - first < 10.0, "{depths:?}");
        assert!(run.is_opaque() && run.counts().iter().sum::<u32>() > 3);
    }
}

#[test]
fn layers_above_the_most_are_left_out() {
    let sheets: Vec<_> =
        (1..=6_u8).map(|z| (f32::from(z), if z == 3 { 1.0 } else { 0.5 })).collect();
    let pixel = one_ray(&sheets, &[]);
    let falling = |map: &MultilayerMap<f32>| -> Vec<f32> {
        let runs = map.pixels().runs(0);
        runs.flat_map(|run| run.layers().filter(|layer| layer.count > 0).map(|layer| layer.depth))
            .collect()
    };
    for most in 1..=8 {
        let settings = MultilayerSettings { max_layers: most, ..settings(1, 0.0, 4) };
        let baker = MultilayerBaker::<f32, _>::new(pixel.clone(), settings).unwrap();
        let expected: Vec<f32> = sheets.iter().map(|sheet| sheet.0).take(most as usize).collect();
        assert_eq!(falling(&baker.map().unwrap()), expected);
        let tile = baker.tile([0, 0]).unwrap();
        assert_eq!(tile.cut_pixels, u64::from(most < 6));
        // What is left behind the last layer of the run, less what the whole run leaves.
        let gained = [0.5, 0.25, 0.875, 0.375, 0.125, 0.0, 0.0, 0.0][most as usize - 1];
        assert_eq!([tile.most_gained, tile.sum_gained], [gained; 2], "{most}");
    }
}

#[test]
fn what_lies_before_the_light_is_dropped() {
    let pixel = one_ray(&[(1.0, 0.5), (2.0, 1.0), (3.0, 0.25)], &[]);
    let settings = MultilayerSettings { light_depth: 2.0, ..settings(1, 0.0, 4) };
    let map = bake::<f32>(&pixel, &settings);
    assert_eq!(map.evaluate([0, 0], 9.0), Ok(0.75));
    assert_eq!(map.pixels().sample_count(), 1);
    assert_eq!(map.info().layering.light_depth, 2.0);
}

#[test]
fn settings_out_of_range_are_refused() {
    let pixel = one_ray(&[], &[]);
    let good = settings(1, 0.0, 0);
    for settings in [
        MultilayerSettings { max_layers: 0, ..good.clone() },
        MultilayerSettings { light_depth: -1.0, ..good.clone() },
        MultilayerSettings { light_depth: f32::NAN, ..good.clone() },
        MultilayerSettings {
            bake: good.bake.clone().with_quantization(Quantization::default()),
            ..good.clone()
        },
    ] {
        assert!(MultilayerBaker::<f32, _>::new(pixel.clone(), settings).is_err());
    }
    assert!(MultilayerBaker::<f32, _>::new(pixel, good).is_ok());
}
