//! Mip levels that are baked: averages of the functions before compression.

use dsm_core::{BakeSettings, Rgb, Transmittance, VisibilityField};
use dsm_io::detail::BakeOptions;
use dsm_io::{MapReader, PyramidOptions};
use dsm_testkit::Random;

use crate::naive::{Plain, check_levels, stored};
use crate::rays::{PixelHits, PixelRays, channels};
use crate::support::{Stage, open};

const SIZE: [u32; 2] = [37, 22];

/// What every pixel's own rays meet, row by row.
fn pixels<T: Transmittance>(stage: &Stage, settings: &BakeSettings) -> Vec<PixelHits<T>> {
    let raster = stage.raster(settings.size);
    let [width, height] = settings.size;
    let all = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    all.map(|pixel| {
        PixelRays::new(&raster, &settings.sampling, settings.filter, pixel).hits(&stage.traced)
    })
    .collect()
}

/// The function of a pixel that meets surfaces only: a step at each.
fn steps<T: Transmittance>(pixel: &PixelHits<T>) -> Plain {
    let (mut z, mut values) = (Vec::new(), vec![Vec::new(); T::CHANNELS]);
    let mut before = [1.0; 3];
    for depth in pixel.depths() {
        let after = pixel.at(depth);
        z.extend([depth; 2]);
        for (channel, values) in values.iter_mut().enumerate() {
            values.extend([before[channel], after[channel]]);
        }
        before = after;
    }
    Plain { z, values }
}

/// Bakes with and without levels: level 0 has the same tiles. The map with
/// levels.
fn bake<T: Transmittance>(stage: &Stage, settings: &BakeSettings) -> MapReader {
    let folder = tempfile::tempdir().unwrap();
    let [flat, levels] = ["flat.dsm", "levels.dsm"].map(|name| folder.path().join(name));
    stage.bake_as::<T>(settings, &BakeOptions::default(), &flat);
    let pyramid = BakeOptions::default().with_pyramid(Some(PyramidOptions::default()));
    stage.bake_as::<T>(settings, &pyramid, &levels);
    // Both stay readable when the folder is gone.
    let [flat, levels] = [flat, levels].map(|path| open(&path));
    assert_eq!((flat.levels().len(), levels.levels().len()), (1, 7));
    for (id, _) in flat.directory(0).unwrap().iter() {
        assert_eq!(flat.encoded_tile(id).unwrap(), levels.encoded_tile(id).unwrap(), "{id}");
    }
    levels
}

fn check_surfaces<T: Transmittance>(name: &str) {
    let stage = Stage::builtin(name);
    let settings = stage.settings(SIZE).with_tile_size(8);
    let reader = bake::<T>(&stage, &settings);
    let exact: Vec<_> = pixels::<T>(&stage, &settings).iter().map(steps).collect();
    let errors = check_levels::<T>(&reader, &exact, 0, name, true);
    println!("{name}: errors of the levels {errors:.4?}");
    let vertices = |functions: &[Plain]| functions.iter().map(|f| f.z.len()).sum::<usize>();
    let (kept, all) = (vertices(&stored::<T>(&reader)), vertices(&exact));
    assert!(kept > 0 && kept < all, "level 0 is compressed: {kept} of {all} vertices");
}

#[test]
fn levels_of_moving_surfaces_average_what_was_not_compressed() {
    check_surfaces::<f32>("spinning-sphere");
}

#[test]
fn levels_of_coloured_surfaces_average_what_was_not_compressed() {
    check_surfaces::<Rgb>("stained-glass");
}

#[test]
fn levels_of_media_keep_their_tolerances() {
    let stage = Stage::builtin("pipes");
    let settings = stage.settings(SIZE).with_tile_size(8);
    let reader = bake::<f32>(&stage, &settings);
    let exact = pixels::<f32>(&stage, &settings);
    let mut random = Random::new(5);
    for (index, level) in (0..).zip(reader.levels()) {
        let map = reader.read_map::<f32>(index).unwrap();
        let mut worst = 0.0_f64;
        for (y, x) in (0..level.height).flat_map(|y| (0..level.width).map(move |x| (y, x))) {
            let reach = |first: u32, end: u32| (first << index)..((first + 1) << index).min(end);
            let (across, down) = (reach(x, SIZE[0]), reach(y, SIZE[1]));
            let pixels = down.flat_map(|y| across.clone().map(move |x| (x, y)));
            let parts: Vec<_> = pixels.map(|(x, y)| &exact[(y * SIZE[0] + x) as usize]).collect();
            let depths = map.pixels().view().pixel(x, y).depths();
            let (Some(first), Some(last)) = (depths.first(), depths.last()) else { continue };
            for query in 0..6 {
                // Close to a vertex, or anywhere.
                let z = match query % 2 {
                    0 => {
                        depths[random.below(depths.len() as u64) as usize]
                            * (0.999 + 0.002 * random.unit() as f32)
                    }
                    _ => first + (last - first) * random.unit() as f32,
                };
                let sum: f64 = parts.iter().map(|part| part.at(z)[0]).sum();
                let [value, ..] = channels(map.evaluate([x, y], z).unwrap());
                worst = worst.max((value - sum / parts.len() as f64).abs());
            }
        }
        let (tolerance, stated) = (f64::from(level.tolerance), f64::from(level.error.max));
        println!(
            "pipes, level {index}: off by {worst:.2e}, states {stated:.2e} of {tolerance:.2e}"
        );
        // What depths in f32 may move a medium by comes on top.
        assert!(worst <= stated + 2e-6 && stated <= tolerance, "level {index}: {worst}");
        assert!(worst > 0.0);
    }
}
