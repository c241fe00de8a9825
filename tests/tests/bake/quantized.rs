//! Maps whose vertices are rounded, in files.

use std::ops::ControlFlow;

use dsm_core::detail::Quantization;
use dsm_core::{Progress, Rgb, Tolerance, Transmittance};
use dsm_io::detail::{BakeOptions, bake};
use dsm_io::{Codec, ConvertOptions, MapReader, MapSource, PyramidOptions, convert, merge, mip};

use crate::support::{Stage, open};

const SIZE: [u32; 2] = [44, 36];

fn check<T: Transmittance>(stage: &Stage) {
    let folder = tempfile::tempdir().unwrap();
    let [exact, rounded] = ["exact", "rounded"].map(|name| folder.path().join(name));
    let settings = stage.settings(SIZE).with_tile_size(16);
    let quantized = settings.clone().with_quantization(Quantization::default());
    let options = BakeOptions::default();
    let before = stage.bake_as::<T>(&settings, &options, &exact);
    let after = stage.bake_as::<T>(&quantized, &options.with_codec(Codec::Quantized), &rounded);
    assert!(2 * after.bytes < before.bytes + 4096, "{} of {}", after.bytes, before.bytes);

    let reader = open(&rounded);
    for (_, entry) in reader.directory(0).unwrap().iter().filter(|(_, entry)| !entry.is_empty()) {
        assert_eq!(Codec::from_tag(entry.codec), Some(Codec::Quantized));
        assert!(entry.depth_error > 0.0 && entry.depth_error <= entry.z_max / 16384.0);
    }
    // What is read is what was baked, to the last bit.
    let map = reader.read_map::<T>(0).unwrap();
    let baked = stage.baker::<T>(&quantized).map().unwrap();
    for (x, y) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))) {
        assert!(map.pixel(x, y).vertices().eq(baked.pixel(x, y).vertices()), "{x}, {y}");
    }

    // Levels that are added leave it as it is.
    let levels = folder.path().join("levels");
    mip(&reader, &levels, &PyramidOptions::default(), Progress::ignore).unwrap();
    let with_levels = open(&levels);
    assert_eq!(with_levels.levels().len(), 7);
    assert_eq!(with_levels.directory(0).unwrap().get(1, 1).unwrap().codec, 1);
    assert!(with_levels.read_map::<T>(0).unwrap().pixels() == map.pixels());

    // Levels that are baked with it neither, and they are not rounded.
    let [plain, baked] = ["plain", "baked"].map(|name| folder.path().join(name));
    let pyramid = options.with_pyramid(Some(PyramidOptions::default()));
    let unrounded = stage.bake_as::<T>(&settings, &pyramid, &plain);
    let both = stage.bake_as::<T>(&quantized, &pyramid.with_codec(Codec::Quantized), &baked);
    assert_eq!(both.hits, unrounded.hits);
    let (plain, baked) = (open(&plain), open(&baked));
    assert!(baked.verify().is_empty());
    assert!(baked.read_map::<T>(0).unwrap().pixels() == map.pixels());
    for (id, entry) in reader.directory(0).unwrap().iter() {
        assert_eq!(baked.directory(0).unwrap().get(id.x, id.y).unwrap().crc, entry.crc);
    }
    for level in 1..7 {
        let of = |map: &MapReader| map.read_map::<T>(level).unwrap().pixels().clone();
        assert!(of(&baked) == of(&plain), "{level}");
        let entries = baked.directory(level).unwrap().iter();
        assert!({ entries }.all(|(_, entry)| entry.depth_error == 0.0), "{level}");
    }

    // Whatever is made of it inherits what its depths are off.
    let moved = |map: &MapReader, level: u32| {
        let entries = map.directory(level).unwrap().iter();
        entries.map(|(_, entry)| entry.depth_error).fold(0.0, f32::max)
    };
    let most = moved(&reader, 0);
    assert!((0..7).all(|level| moved(&with_levels, level) == most));
    let [converted, merged] = ["converted", "merged"].map(|name| folder.path().join(name));
    let options = ConvertOptions { tolerance: Tolerance::EXACT, ..ConvertOptions::default() };
    convert(&mut MapSource::Map(Box::new(open(&rounded))), &converted, &options, Progress::ignore)
        .unwrap();
    assert_eq!(moved(&open(&converted), 0), most);
    merge(&[open(&exact), open(&rounded)], &merged, None, Progress::ignore).unwrap();
    assert_eq!(moved(&open(&merged), 0), most);
}

#[test]
fn of_hair() {
    check::<f32>(&Stage::builtin("hairball"));
}

#[test]
fn of_media() {
    check::<f32>(&Stage::builtin("pipes"));
}

#[test]
fn of_coloured_surfaces() {
    check::<Rgb>(&Stage::builtin("stained-glass"));
}

#[test]
fn a_hairs_width_is_kept() {
    let stage = Stage::builtin("hairball");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let width = stage.scene.finest_strand().unwrap();
    let moved = |depth_error| {
        let mut settings = deepshadow::Bake::new([48, 48]).unwrap();
        settings.codec = Codec::Quantized;
        settings.depth_error = depth_error;
        let never = |_| ControlFlow::Continue(());
        deepshadow::bake(&stage.scene, &stage.scene.light, &settings, &path, never).unwrap();
        let map = deepshadow::ShadowMap::open(&path).unwrap();
        f64::from(map.stated_errors().unwrap()[0].depth)
    };
    let usual = moved(None);
    assert!(usual > 0.0 && usual < 0.25 * width, "{usual} of {width}");
    // By more where that is asked for.
    let coarse = moved(Some(8.0 * width));
    assert!(coarse > width && coarse < 8.0 * width, "{coarse} of {width}");
}

#[test]
fn rounding_and_its_codec_go_together() {
    let stage = Stage::builtin("stained-glass");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let never = |_| ControlFlow::Continue(());
    let settings = stage.settings([8, 8]);
    let rounded = settings.clone().with_quantization(Quantization::default());
    let plain = BakeOptions::default();
    let quantized = plain.with_codec(Codec::Quantized);
    for (settings, options) in [(&settings, quantized), (&rounded, plain)] {
        let baker = stage.baker::<Rgb>(settings);
        assert!(bake(&baker, &path, &options, |_| (), never).is_err(), "{options:?}");
        assert!(!path.exists());
    }
}
