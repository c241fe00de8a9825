//! Real and built-in scenes against traced rays.
//!
//! Queries share rays: so many random pixels that meet anything, each at so many
//! random depths of its own range. A third of the depths is spread evenly over
//! the range, a third lies close to something that is met, and a third, where
//! there are surfaces only, at the very depth of something. The compressed map is
//! the one that the program bakes; that of the map's own rays is traced.

use std::path::Path;

use dsm_core::{
    BakeSettings, DeepMap, Filter, FilterShape, PixelSampling, Rgb, Tolerance, Transmittance,
    VisibilityField,
};
use dsm_scene::Shape;
use dsm_testkit::{Random, is_long};
use rayon::prelude::*;

use crate::rays::{PixelRays, channels};
use crate::support::{Stage, real_file, scene_file};

/// The reference's rays through a pixel's filter, at least.
const REFERENCE_RAYS: u32 = 1024;

/// How much is asked of a scene.
struct Effort {
    side: u32,
    samples: &'static [u32],
    pixels: usize,
    depths: usize,
}

fn effort() -> Effort {
    if is_long() {
        Effort { side: 96, samples: &[16, 256], pixels: 64, depths: 64 }
    } else {
        Effort { side: 24, samples: &[16], pixels: 8, depths: 16 }
    }
}

/// What two maps of a scene, one with the default tolerance and one without,
/// are off by.
#[derive(Default)]
struct Findings {
    /// Against the map's own samples, tolerance 0.
    own: f64,
    /// Over tolerance + 4σ.
    fourfold: Vec<f64>,
    /// Over tolerance + 6σ + 1/N.
    sixfold: f64,
    /// The sum over depths and channels, signed, tolerance 0, pixel by pixel.
    bias: Vec<f64>,
}

/// Compares one pixel of both maps with its own rays and the reference's.
fn compare_pixel<T: Transmittance>(
    stage: &Stage,
    settings: &BakeSettings,
    maps: &[DeepMap<T>; 2],
    pixel: [u32; 2],
    depths: usize,
) -> Option<Findings> {
    let raster = stage.raster(settings.size);
    let own = PixelRays::new(&raster, &settings.sampling, settings.filter, pixel);
    // Rays that a filter weighs little count for less than one.
    let counted = f64::from(REFERENCE_RAYS) / settings.filter.effective_pixels();
    let per_pixel = (1.05 * counted).ceil() as u32;
    let sampling = PixelSampling::new(per_pixel, 0x5EED).unwrap();
    let reference = PixelRays::new(&raster, &sampling, settings.filter, pixel);
    assert!(reference.noise() * f64::from(REFERENCE_RAYS) < 1.0);
    let hits = reference.hits::<T>(&stage.traced);
    let met = hits.depths();
    let mut random = Random::new(u64::from(pixel[0]) << 32 | u64::from(pixel[1]));
    let (&first, &last) = (met.first()?, met.last()?);
    // What the map's own rays meet.
    let own_hits = own.hits::<T>(&stage.traced);
    let exact = own_hits.depths();
    let has_media =
        stage.scene.objects.iter().any(|object| matches!(*object.shape, Shape::Volume(_)));

    let [compressed, uncompressed] = maps;
    let tolerance = f64::from(settings.tolerance().epsilon());
    let sigma = 0.5 * (own.noise() + reference.noise()).sqrt();
    let limits = [tolerance + 4.0 * sigma, tolerance + 6.0 * sigma + own.noise()];
    let mut findings = Findings::default();
    let mut bias = 0.0;
    for query in 0..depths {
        let spread = random.unit() * 1.02 - 0.01;
        let z = match query % 3 {
            0 => first + (last - first) * spread as f32,
            2 if !has_media && !exact.is_empty() => {
                exact[random.below(exact.len() as u64) as usize]
            }
            _ => {
                met[random.below(met.len() as u64) as usize] * (1.0 + 1e-3 * (spread as f32 - 0.5))
            }
        };
        // A depth stands for all t that are rounded to it. Surfaces there are
        // met; in a medium there is some light more and some less.
        let [before, behind] = [z.next_down(), z.next_up()]
            .map(|other| own.traced::<T>(&stage.traced, 0.5 * (f64::from(z) + f64::from(other))));
        let most = if has_media { before } else { behind };
        let met_by_own = own_hits.at(z);
        let mean = hits.at(z);
        let read = |map: &DeepMap<T>| channels(map.evaluate(pixel, z).unwrap());
        let (stored, exact) = (read(compressed), read(uncompressed));
        for channel in 0..T::CHANNELS {
            let below = (exact[channel] - most[channel]).max(behind[channel] - exact[channel]);
            findings.own = findings.own.max(below);
            if has_media {
                findings.own = findings.own.max((exact[channel] - met_by_own[channel]).abs());
            }
            let off = (stored[channel] - mean[channel]).abs();
            findings.fourfold.push(off / limits[0]);
            findings.sixfold = findings.sixfold.max(off / limits[1]);
            bias += (exact[channel] - mean[channel]) / (depths * T::CHANNELS) as f64;
        }
    }
    findings.bias.push(bias);
    Some(findings)
}

fn check<T: Transmittance>(name: &str, stage: &Stage, filter: Filter) {
    let effort = effort();
    for &samples in effort.samples {
        let sampling = PixelSampling::new(samples, 0).unwrap();
        let settings = stage.settings([effort.side; 2]);
        // A tile of media at tolerance 0 must stay below the reader's limit.
        let settings = settings.with_sampling(sampling).with_filter(filter).with_tile_size(8);
        let exact = settings.clone().with_tolerance(Tolerance::EXACT);
        let maps = [stage.rasterized::<T>(&settings), stage.bake::<T>(&exact)];

        let mut random = Random::new(u64::from(samples));
        let side = u64::from(effort.side);
        let mut findings = Findings::default();
        let mut tried = 0;
        // Pixels that meet nothing are compared too, but not counted.
        while findings.bias.len() < effort.pixels {
            let pixels: Vec<[u32; 2]> = (findings.bias.len()..effort.pixels)
                .map(|_| [random.below(side) as u32, random.below(side) as u32])
                .collect();
            let found: Vec<_> = pixels
                .par_iter()
                .map(|&pixel| compare_pixel(stage, &settings, &maps, pixel, effort.depths))
                .collect();
            for (found, pixel) in found.into_iter().zip(pixels) {
                match found {
                    Some(found) => {
                        findings.own = findings.own.max(found.own);
                        findings.fourfold.extend(found.fourfold);
                        findings.sixfold = findings.sixfold.max(found.sixfold);
                        findings.bias.extend(found.bias);
                    }
                    None => assert_eq!(maps[1].evaluate(pixel, f32::MAX), Ok(T::CLEAR), "{name}"),
                }
            }
            tried += 1;
            assert!(tried < 1000, "{name}: nothing is met");
        }

        let Findings { own, mut fourfold, sixfold, bias } = findings;
        fourfold.sort_by(f64::total_cmp);
        let beyond = fourfold.iter().filter(|&&ratio| ratio > 1.0).count();
        let pixels = bias.len() as f64;
        let bias = bias.iter().sum::<f64>() / pixels;
        let worst = fourfold[fourfold.len() - 1];
        println!(
            "{name:16} {:8} {samples:4} {:6} own {own:.1e}  4σ {worst:.3}  6σ {sixfold:.3}  beyond \
             4σ {beyond}  bias {bias:+.4}",
            filter.shape().name(),
            fourfold.len(),
        );
        assert!(own <= 1e-5, "{name}: off by {own} from the mean of the map's own rays");
        assert!(beyond * 1000 <= fourfold.len(), "{name}: {beyond} of {}", fourfold.len());
        assert!(sixfold <= 1.0, "{name}: {sixfold}");
        // Pixels are independent: their mean is less noisy than each.
        let noise = 0.5 * (1.0 / f64::from(samples) + 1.0 / f64::from(REFERENCE_RAYS)).sqrt();
        assert!(bias.abs() <= 1e-5 + 6.0 * noise / pixels.sqrt(), "{name}: off by {bias} in all");
    }
}

fn pixel_filter() -> Filter {
    Filter::new(FilterShape::Box, 1.0).unwrap()
}

fn check_builtin(name: &str) {
    let stage = Stage::builtin(name);
    if stage.scene.is_coloured() {
        check::<Rgb>(name, &stage, pixel_filter());
    } else {
        check::<f32>(name, &stage, pixel_filter());
    }
}

/// A scene file of these models, each with more keys, in the standard light.
fn check_models(name: &str, models: &[(&str, &str, &str)]) {
    let mut text = String::new();
    for (kind, model, keys) in models {
        let Some(path) = real_file(model) else { return };
        let path: &Path = &path;
        text += &format!("[[object]]\n{kind} = '{}'\n{keys}\n", path.display());
    }
    let folder = tempfile::tempdir().unwrap();
    check::<f32>(name, &scene_file(folder.path(), &text), pixel_filter());
}

#[test]
fn ponytail() {
    let keys = "opacity = 0.4\nthickness = 0.4";
    check_models(
        "ponytail",
        &[("curves", "hair/ponytail.hair", keys), ("mesh", "hair/ponytail_head.obj", "")],
    );
}

#[test]
fn sintel() {
    let keys = "opacity = 0.5\nthickness = 0.0006";
    check_models(
        "sintel",
        &[("curves", "hair/sintel.hair", keys), ("mesh", "hair/sintel_head.obj", "")],
    );
}

#[test]
fn oak() {
    check_models("oak", &[("mesh", "mesh/eztree_oak_medium.glb", "")]);
}

#[test]
fn smoke_of_a_file() {
    check_models("smoke.vdb", &[("volume", "volume/smoke.vdb", "density = 0.05")]);
}

#[test]
fn hairball() {
    check_builtin("hairball");
}

#[test]
fn fur_plane() {
    check_builtin("fur-plane");
}

#[test]
fn foliage() {
    check_builtin("foliage");
}

#[test]
fn smoke() {
    check_builtin("smoke");
}

#[test]
fn pipes() {
    check_builtin("pipes");
}

#[test]
fn spinning_sphere() {
    check_builtin("spinning-sphere");
}

#[test]
fn stained_glass() {
    check_builtin("stained-glass");
}

#[test]
fn wide_filters() {
    for (shape, width) in [(FilterShape::Gaussian, 3.0), (FilterShape::Tent, 2.0)] {
        let filter = Filter::new(shape, width).unwrap();
        check::<f32>("spinning-sphere", &Stage::builtin("spinning-sphere"), filter);
        check::<f32>("pipes", &Stage::builtin("pipes"), filter);
    }
}
