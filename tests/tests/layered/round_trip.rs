//! What is written comes back.

use std::ops::ControlFlow;

use dsm_core::{AreaLight, LightVisibility, Rgb, Transmittance};
use dsm_io::detail::{MapKind, TileCache};
use dsm_io::{Error, Limits, MapReader, Packing};
use glam::DVec3;
use mtsm::MultilayerMap;
use mtsm::detail::{Layers, Mtsm, MultilayerDepthMap, bake_mtsm};
use shadow_maps::detail::{
    Accumulate, CachedPrefiltered, FragmentMap, FragmentTracer, Fragments, Prefiltered,
    PrefilteredMap, PrefilteredShadow,
};

use crate::examples::{FOGGY, KINDS, baker, file, foggy_map, fragment_map, list_map, open, read};

const PACKINGS: [Packing; 2] = [Packing::Plain, Packing::Zstd];

fn check<T: Transmittance>() {
    let (map, depths) = (baker::<T>().map().unwrap(), baker::<T>().depth_map().unwrap());
    assert!(map.pixels().run_count() > 20 && map.pixels().sample_count() > 30);
    assert!((0..30).any(|pixel| map.pixels().runs(pixel).len() > 1));
    for packing in PACKINGS {
        let reader = read::<Mtsm>(file::<T>(Mtsm::NAME, packing)).unwrap();
        assert_eq!(MultilayerMap::<T>::read(&reader).unwrap(), map);
        assert!(reader.verify().is_empty());
        let summary = reader.summary().unwrap();
        assert_eq!(summary.count("runs"), Some(map.pixels().run_count() as u64));
        assert_eq!(summary.count("layers"), Some(map.pixels().layer_count() as u64));
        assert_eq!(summary.count("samples"), Some(map.pixels().sample_count()));
        // The first runs are a deep map.
        let whole = reader.tile_rect(Default::default()).unwrap();
        let deep = reader.functions::<T>(0, whole).unwrap();
        for (x, y) in (0..whole.height).flat_map(|y| (0..whole.width).map(move |x| (x, y))) {
            let first = map.pixels().first_run((y * 6 + x) as usize);
            let vertices = deep.pixel(x, y).vertices();
            let expected = first.into_iter().flat_map(|run| run.function().vertices());
            assert!(vertices.eq(expected));
        }

        let reader = read::<Layers>(file::<T>(Layers::NAME, packing)).unwrap();
        assert_eq!(MultilayerDepthMap::<T>::read(&reader).unwrap().pixels(), depths.pixels());
        assert!(reader.verify().is_empty());
        let summary = reader.summary().unwrap();
        assert_eq!(summary.count("layers"), Some(depths.pixels().layer_count() as u64));
        assert_eq!(summary.count("max_layers_per_pixel"), Some(5));
        assert!(reader.contents::<T>(0, [6, 0]).is_err());
        assert!(matches!(
            reader.functions::<T>(0, whole),
            Err(Error::File { .. } | Error::Kind { .. })
        ));
    }
}

fn check_fragments<T: Transmittance>(name: &str, map: &FragmentMap<T>) {
    assert!(map.len() > 30);
    for packing in PACKINGS {
        let reader = read::<Fragments>(file::<T>(name, packing)).unwrap();
        assert_eq!(&FragmentMap::<T>::read(&reader).unwrap(), map);
        assert!(reader.verify().is_empty());
        let summary = reader.summary().unwrap();
        assert_eq!(summary.count("fragments"), Some(map.len() as u64));
        let foggy = map.media().map(|media| {
            let lists = media.offsets.windows(2).map(|pair| u64::from(pair[1] - pair[0]));
            lists
                .filter(|&count| count > 0)
                .fold([0, 0], |[pixels, slabs], count| [pixels + 1, slabs + count - 1])
        });
        let counts = ["pixels_with_media", "slabs"].map(|name| summary.count(name));
        assert_eq!(counts, [0, 1].map(|at| foggy.map(|both| both[at])));
        // Traced from the file's tiles, or from the map.
        let light = AreaLight::rectangle(DVec3::ZERO, DVec3::X * 0.2, DVec3::Y * 0.2);
        let tracers =
            [FragmentTracer::new(map.clone()).unwrap(), FragmentTracer::read(&reader).unwrap()];
        let (mut tracers, mut dark) = (tracers, 0);
        for far in [false, true] {
            if far {
                tracers = tracers.map(|tracer| tracer.with_far_table(0.5));
            }
            for at in 0..60_u32 {
                let [x, y] = [at % 10, at / 10].map(|side| f64::from(side) / 4.0 - 1.0);
                let depth = 2.6 + f64::from(at % 7) / 4.0;
                let receiver = DVec3::new(x * depth, y * depth, -depth);
                let [a, b] =
                    tracers.each_ref().map(|tracer| tracer.visibility(receiver, &light, 3));
                assert_eq!(a, b, "{far} {receiver}");
                dark += usize::from(a != Ok(T::CLEAR));
            }
        }
        assert!(dark > 40, "{dark}");
        let kept = |map: FragmentTracer<T>| map.for_light(&light).has_far_table();
        let [a, b] = tracers.map(kept);
        assert_eq!(a, b);
    }
}

fn check_prefiltered<T: Transmittance>() {
    let map = list_map::<T>();
    for packing in PACKINGS {
        let reader = read::<Prefiltered>(file::<T>(Prefiltered::NAME, packing)).unwrap();
        assert!(reader.verify().is_empty());
        let found = PrefilteredMap::<T>::read(&reader).unwrap();
        assert!(found.levels().eq(map.levels()));
        let fragments = map.levels().next().unwrap().0.len() as u64;
        assert_eq!(reader.summary().unwrap().count("fragments"), Some(fragments));
        // Looked up through tiles, or in the map: the same bits.
        let light = AreaLight::rectangle(DVec3::NEG_Z / 4.0, DVec3::X * 0.3, DVec3::Y * 0.2);
        let cached = TileCache::new(1 << 20).insert::<T, _>(reader).unwrap();
        let cached = CachedPrefiltered::new(cached).unwrap();
        let mut dark = 0;
        for mode in Accumulate::ALL {
            let in_memory = PrefilteredShadow::new(&map).with_accumulate(mode);
            let in_file = PrefilteredShadow::new(&cached).with_accumulate(mode);
            for at in 0..60_u32 {
                let [x, y] = [at % 10, at / 10].map(|side| f64::from(side) / 4.0 - 1.0);
                let depth = 2.1 + f64::from(at % 7) / 4.0;
                let receiver = DVec3::new(x * depth, y * depth, -depth);
                let Ok(expected) = in_memory.visibility(receiver, &light, 0);
                assert_eq!(in_file.visibility(receiver, &light, 0).unwrap(), expected);
                dark += usize::from(expected != T::CLEAR);
            }
        }
        assert!(dark > 15, "{dark}");
    }
}

#[test]
fn prefiltered_maps_come_back() {
    check_prefiltered::<f32>();
    check_prefiltered::<Rgb>();
}

#[test]
fn fragments_come_back() {
    check_fragments::<f32>(Fragments::NAME, &fragment_map());
    check_fragments::<Rgb>(Fragments::NAME, &fragment_map());
    assert!(foggy_map::<f32>().media().is_some_and(|media| media.depths.len() > 40));
    check_fragments::<f32>(FOGGY, &foggy_map());
    check_fragments::<Rgb>(FOGGY, &foggy_map());
}

#[test]
fn mono_maps_come_back() {
    check::<f32>();
}

#[test]
fn coloured_maps_come_back() {
    check::<Rgb>();
    let reader = read::<Mtsm>(file::<Rgb>(Mtsm::NAME, Packing::Zstd)).unwrap();
    assert!(matches!(MultilayerMap::<f32>::read(&reader), Err(Error::Channels { .. })));
}

#[test]
fn threads_do_not_change_the_bytes() {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    for kind in KINDS {
        let files =
            [1, 4].map(|threads| pool(threads).install(|| file::<f32>(kind, Packing::Zstd)));
        assert_eq!(files[0], files[1]);
    }
}

#[test]
fn other_kinds_name_themselves() {
    let bytes = file::<f32>(Mtsm::NAME, Packing::Plain);
    let refused = MapReader::from_bytes(bytes, &Limits::default()).unwrap_err();
    assert_eq!(refused.to_string(), "a map of kind \"mtsm\", not a deep shadow map");
    for kind in KINDS {
        let map = open(file::<f32>(kind, Packing::Plain)).unwrap();
        let kind = if kind == FOGGY { Fragments::NAME } else { kind };
        assert_eq!(map.kind(), kind);
        assert!(map.downcast_ref::<Layers>().is_some() == (kind == Layers::NAME));
        let refused = map.downcast::<dsm_io::detail::Deep>().unwrap_err();
        assert!(matches!(refused, Error::Kind { found, .. } if found == kind));
    }
}

#[test]
fn a_bake_that_is_broken_off_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    std::fs::write(&path, b"old").unwrap();
    let broken_off = |_| ControlFlow::Break(());
    let refused = bake_mtsm(&baker::<f32>(), &path, Packing::Zstd, |_| {}, broken_off);
    assert!(matches!(refused, Err(Error::Interrupted)));
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(folder.path().read_dir().unwrap().count(), 1);
}
