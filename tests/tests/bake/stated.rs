//! What maps state about their errors, held against random queries: no answer is off
//! from what the map's own rays met by more than the level states, δ included.

use std::path::Path;

use deepshadow::ShadowMap;
use deepshadow::detail::StatedError;
use dsm_core::detail::Quantization;
use dsm_core::{DeepMap, Progress, Rgb, Tolerance, Transmittance, VisibilityField};
use dsm_io::detail::{AnyDeepMap, BakeOptions, PixelValue, TileRect};
use dsm_io::{Codec, ConvertOptions, MapSource, Packing, PyramidOptions, WriteOptions};
use dsm_io::{convert, merge, mip};
use dsm_scene::detail::SceneHitSource;
use dsm_testkit::{Random, is_long};
use mtsm::detail::{bake_layers, bake_mtsm};
use mtsm::{MultilayerBaker, MultilayerSettings};
use rayon::prelude::*;

use crate::rays::{Channels, PixelHits, PixelRays, channels};
use crate::support::{Stage, open};

const SIZE: [u32; 2] = [44, 36];

/// The rounding of values to `f32`, and the chords of media at the least.
const SLACK: f64 = 1e-6;

/// Queries of the finest level of a map: 10⁶ in the long mode. Of a smaller level as many
/// fewer as it has pixels, so that all levels take about as long.
fn queries(level: u32) -> u64 {
    let finest = if is_long() { 1_000_000 } else { 4_000 };
    (finest >> (2 * level)).max(100)
}

/// Reads one number of channels of a map.
trait Numbers: Transmittance {
    fn of(map: AnyDeepMap) -> Option<DeepMap<Self>>;
}

impl Numbers for f32 {
    fn of(map: AnyDeepMap) -> Option<DeepMap<Self>> {
        if let AnyDeepMap::Mono(map) = map { Some(map) } else { None }
    }
}

impl Numbers for Rgb {
    fn of(map: AnyDeepMap) -> Option<DeepMap<Self>> {
        if let AnyDeepMap::Rgb(map) = map { Some(map) } else { None }
    }
}

/// The exact function of one pixel of the finest level.
struct Exact<'a> {
    /// Depths where something is, ascending.
    depths: Vec<f32>,
    at: Box<dyn Fn(f32) -> Channels + Sync + 'a>,
}

/// What the pixel's own rays meet.
fn met<T: Transmittance>(hits: &PixelHits<T>) -> Exact<'_> {
    Exact { depths: hits.depths(), at: Box::new(|z| hits.at(z)) }
}

/// What of a map's finest level its smaller ones were made of.
fn stored<T: Transmittance>(map: &DeepMap<T>, [x, y]: [u32; 2]) -> Exact<'_> {
    let depths = map.pixel(x, y).vertices().map(|vertex| vertex.z).collect();
    Exact { depths, at: Box::new(move |z| channels(map.pixel(x, y).at(z))) }
}

/// The light that is left by the same in the way twice.
fn squared<'a>(pixel: &'a Exact<'a>) -> Exact<'a> {
    let at = |z| (pixel.at)(z).map(|value| value * value);
    Exact { depths: pixel.depths.clone(), at: Box::new(at) }
}

/// All pixels, row by row.
fn each_pixel() -> Vec<[u32; 2]> {
    (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y])).collect()
}

/// What all pixels' own rays meet, row by row.
fn pixels<T: Transmittance>(stage: &Stage, settings: &dsm_core::BakeSettings) -> Vec<PixelHits<T>> {
    let raster = stage.raster(SIZE);
    let rays = |&pixel| PixelRays::new(&raster, &settings.sampling, settings.filter, pixel);
    each_pixel().par_iter().map(|pixel| rays(pixel).hits(&stage.traced)).collect()
}

/// A depth to ask for: anywhere, beside something, at it, or within δ behind it.
fn depth(random: &mut Random, met: &[f32], moved: f32) -> f32 {
    let (Some(&first), Some(&last)) = (met.first(), met.last()) else {
        return 10.0 * random.unit() as f32;
    };
    let near = met[random.below(met.len() as u64) as usize];
    let unit = random.unit() as f32;
    match random.below(6) {
        0 => 0.9 * first + (1.1 * last - 0.9 * first) * unit,
        1 => near * (0.999 + 0.002 * unit),
        2 => near,
        3 => near.next_up(),
        4 => near.next_down(),
        _ => near + moved * 1.5 * unit,
    }
}

/// Asks a level at random; no answer may be off by more than it states.
fn check_level<T: Numbers>(
    map: &ShadowMap,
    index: u32,
    stated: &StatedError,
    exact: &[Exact<'_>],
    what: &str,
) {
    let level = map.levels()[index as usize];
    let rect = TileRect { x: 0, y: 0, width: level.width, height: level.height };
    let stored = T::of(map.functions(index, rect).unwrap().unwrap()).unwrap();
    let per_task = queries(index).min(1000);
    let tasks = queries(index).div_ceil(per_task);
    let worst = (0..tasks).into_par_iter().map(|task| {
        let mut random = Random::new((task << 8) | u64::from(index));
        let mut worst = [0.0_f64; 2];
        for _ in 0..per_task {
            let [x, y] = [level.width, level.height].map(|side| random.below(side.into()) as u32);
            let reach = |first: u32, end: u32| (first << index)..((first + 1) << index).min(end);
            let (across, down) = (reach(x, SIZE[0]), reach(y, SIZE[1]));
            let parts: Vec<_> = down
                .flat_map(|y| across.clone().map(move |x| (y * SIZE[0] + x) as usize))
                .map(|pixel| &exact[pixel])
                .collect();
            let some = parts[random.below(parts.len() as u64) as usize];
            let z = depth(&mut random, &some.depths, stated.depth).max(0.0);
            let mean = |z: f32| {
                let sum = parts.iter().map(|part| (part.at)(z)).fold([0.0; 3], |sum, value| {
                    [0, 1, 2].map(|channel| sum[channel] + value[channel])
                });
                sum.map(|sum| sum / parts.len() as f64)
            };
            let (here, before) = (mean(z), mean((z - stated.depth).next_down()));
            let found = channels(stored.evaluate([x, y], z).unwrap());
            for channel in 0..3 {
                let [found, here, before] = [found, here, before].map(|value| value[channel]);
                worst[0] = worst[0].max((found - here).abs());
                worst[1] = worst[1].max(here - found).max(found - before);
            }
        }
        worst
    });
    let larger = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
    let [at_depth, beside] = worst.reduce(|| [0.0; 2], larger);
    let count = tasks * per_task;
    println!(
        "{what}, level {index}: {count} queries, {at_depth:.6} of {:.6} at a depth, {beside:.6} \
         of {:.6} beside δ = {:.2e}",
        stated.at_depth, stated.max, stated.depth
    );
    assert!(at_depth <= f64::from(stated.at_depth) + SLACK, "{what}, level {index}");
    assert!(beside <= f64::from(stated.max) + SLACK, "{what}, level {index}");
    assert!(stated.max <= stated.at_depth && stated.max <= stated.tolerance + 1e-6);
}

fn check_map<T: Numbers>(path: &Path, exact: &[Exact<'_>], what: &str) -> Vec<StatedError> {
    let map = ShadowMap::open(path).unwrap();
    assert!(map.verify().is_empty(), "{what}");
    let stated = map.stated_errors().unwrap();
    assert_eq!(stated.len(), map.levels().len());
    for (index, stated) in (0..).zip(&stated) {
        check_level::<T>(&map, index, stated, exact, what);
    }
    stated
}

fn check_deep<T: Numbers>(name: &str, tolerance: f32) {
    let stage = Stage::builtin(name);
    let folder = tempfile::tempdir().unwrap();
    let settings = stage.settings(SIZE).with_tile_size(16);
    let settings = settings.with_tolerance(Tolerance::new(tolerance).unwrap());
    let hits = pixels::<T>(&stage, &settings);
    let exact: Vec<_> = hits.iter().map(met).collect();
    let products: Vec<_> = exact.iter().map(squared).collect();
    let pyramid = BakeOptions::default().with_pyramid(Some(PyramidOptions::default()));
    let within = |error| Some(Quantization::within(error).unwrap());
    let [path, copy, levels, product] =
        ["map", "copy", "levels", "product"].map(|name| folder.path().join(name));
    for (codec, quantization, most) in [
        ("exact", None, 0.0),
        ("quantized", Some(Quantization::default()), f32::MAX),
        ("quantized within 1e-5", within(1e-5), 1e-5),
        ("quantized within 0.05", within(0.05), 0.05),
    ] {
        let with = if quantization.is_some() { Codec::Quantized } else { Codec::Exact };
        let settings = settings.clone().with_quantization(quantization);
        stage.bake_as::<T>(&settings, &pyramid.with_codec(with), &path);
        let what = format!("{name}, {codec}");
        let stated = check_map::<T>(&path, &exact, &what)[0];
        let moved = stated.depth;
        assert!(moved <= most && (moved > 0.0) == quantization.is_some(), "{what}: {moved}");
        assert!(moved > 0.0 || stated.max == stated.at_depth, "{what}");

        // What is made of it states both errors, and both moves.
        let options = ConvertOptions {
            tolerance: Tolerance::new(0.01).unwrap(),
            write: WriteOptions::default().with_tile_size(16).with_codec(Codec::Quantized),
            quantization: within(0.01),
            ..ConvertOptions::default()
        };
        convert(&mut MapSource::Map(Box::new(open(&path))), &copy, &options, Progress::ignore)
            .unwrap();
        let copied = check_map::<T>(&copy, &exact, &format!("{what}, converted"))[0];
        assert!(copied.depth >= moved && copied.depth <= moved + 0.01, "{copied:?}");
        assert!(copied.max >= stated.max);
        let added = Tolerance::new(0.01).unwrap();
        merge(&[open(&path), open(&copy)], &product, Some(added), Progress::ignore).unwrap();
        check_map::<T>(&product, &products, &format!("{what}, merged"));

        // Levels that are made of a file state how far they are off from its finest.
        mip(&open(&path), &levels, &PyramidOptions::default(), Progress::ignore).unwrap();
        let finest = open(&path).read_map::<T>(0).unwrap();
        let stored: Vec<_> = each_pixel().into_iter().map(|pixel| stored(&finest, pixel)).collect();
        let map = ShadowMap::open(&levels).unwrap();
        for (index, stated) in (0..).zip(map.stated_errors().unwrap()).skip(1) {
            let what = format!("{what}, mip");
            check_level::<T>(&map, index, &stated, &stored, &what);
        }
    }
}

#[test]
fn deep_maps_of_hair_are_off_by_no_more_than_they_state() {
    check_deep::<f32>("hairball", 0.0625);
}

#[test]
fn deep_maps_of_media_are_off_by_no_more_than_they_state() {
    check_deep::<f32>("pipes", 0.02);
}

#[test]
fn deep_maps_of_colours_are_off_by_no_more_than_they_state() {
    check_deep::<Rgb>("stained-glass", 0.01);
}

/// The layers of a pixel as a file holds them: depths and opacities.
fn layers(map: &ShadowMap, pixel: [u32; 2]) -> Vec<(f64, f64)> {
    let contents = map.contents(0, pixel).unwrap();
    assert_eq!(contents.columns()[..2], ["depth", "opacity"]);
    // Anything else than a number is no light.
    let number = |value: &PixelValue| match value {
        PixelValue::Number(number) => f64::from(*number),
        _ => f64::INFINITY,
    };
    contents.rows().iter().map(|row| (number(&row[0]), number(&row[1]))).collect()
}

#[test]
fn layered_maps_are_off_by_no_more_than_they_state() {
    for name in ["hairball", "foliage"] {
        let stage = Stage::builtin(name);
        let folder = tempfile::tempdir().unwrap();
        let camera = Some(stage.raster(SIZE).shadow_camera());
        let mut settings = MultilayerSettings::new(SIZE).unwrap();
        settings.bake = settings.bake.with_camera(camera).with_tile_size(16);
        settings.max_layers = 1 << 16;
        let hits = pixels::<f32>(&stage, &settings.bake);
        let exact: Vec<_> = hits.iter().map(met).collect();
        let path = folder.path().join("map.dsm");
        let baker = || {
            let source = SceneHitSource::new(stage.traced.clone(), stage.raster(SIZE));
            MultilayerBaker::<f32, _>::new(source, settings.clone()).unwrap()
        };
        bake_mtsm(&baker(), &path, Packing::Zstd, |_| (), Progress::ignore).unwrap();
        check_map::<f32>(&path, &exact, &format!("{name}, mtsm"));

        // Layers have no functions; what they hold lets through what is stated.
        bake_layers(&baker(), &path, Packing::Zstd, |_| (), Progress::ignore).unwrap();
        let map = ShadowMap::open(&path).unwrap();
        let stated = map.stated_errors().unwrap()[0];
        let mut random = Random::new(7);
        let mut worst = 0.0_f64;
        for (exact, pixel) in exact.iter().zip(each_pixel()) {
            let layers = layers(&map, pixel);
            for _ in 0..queries(0).div_ceil(1000) {
                let z = depth(&mut random, &exact.depths, 0.0).max(0.0);
                let passed = layers.iter().filter(|layer| layer.0 <= f64::from(z));
                let found: f64 = passed.map(|layer| 1.0 - layer.1).product();
                worst = worst.max((found - (exact.at)(z)[0]).abs());
            }
        }
        println!("{name}, layers: {worst:.2e} of {:.2e}", stated.max);
        assert!(worst <= f64::from(stated.at_depth) + SLACK, "{worst}");
    }
}
