//! What is written comes back.

use std::ops::ControlFlow;

use dsm_core::{Rgb, Transmittance};
use dsm_io::{Block, Error, Limits, MapReader};
use mtsm::{LayeredKind, bake_mtsm};

use crate::examples::{baker, file, fragment_map, open};

const BLOCKS: [Block; 2] = [Block::Plain, Block::Zstd];

fn check<T: Transmittance>() {
    let (map, depths) = (baker::<T>().map().unwrap(), baker::<T>().depth_map().unwrap());
    assert!(map.pixels().run_count() > 20 && map.pixels().sample_count() > 30);
    assert!((0..30).any(|pixel| map.pixels().runs(pixel).len() > 1));
    for block in BLOCKS {
        let reader = open(file::<T>(LayeredKind::Mtsm, block)).unwrap();
        assert_eq!(reader.multilayer_map::<T>().unwrap(), map);
        assert!(reader.verify().is_empty());
        let summary = reader.summary().unwrap();
        assert_eq!(summary.runs, map.pixels().run_count() as u64);
        assert_eq!(summary.layers, map.pixels().layer_count() as u64);
        assert_eq!(summary.samples, map.pixels().sample_count());
        for pixel in 0..30_u32 {
            let runs = reader.pixel_runs::<T>([pixel % 6, pixel / 6]).unwrap();
            let expected = map.pixels().runs(pixel as usize);
            assert!(runs.into_iter().eq(expected.map(|run| run.layers().collect::<Vec<_>>())));
        }
        assert!(matches!(reader.multilayer_depth_map::<T>(), Err(Error::Kind { .. })));

        let reader = open(file::<T>(LayeredKind::Layers, block)).unwrap();
        assert_eq!(reader.multilayer_depth_map::<T>().unwrap().pixels(), depths.pixels());
        assert!(reader.verify().is_empty());
        let summary = reader.summary().unwrap();
        assert_eq!(summary.layers, depths.pixels().layer_count() as u64);
        assert_eq!((summary.most_runs, summary.most_layers), (1, 5));
        assert!(reader.pixel_runs::<T>([6, 0]).is_err());
        assert!(matches!(reader.multilayer_map::<T>(), Err(Error::Kind { .. })));
    }
}

fn check_fragments<T: Transmittance>() {
    let map = fragment_map::<T>();
    assert!(map.len() > 30);
    for block in BLOCKS {
        let reader = open(file::<T>(LayeredKind::Fragments, block)).unwrap();
        assert_eq!(reader.kind(), LayeredKind::Fragments);
        assert_eq!(reader.fragment_map::<T>().unwrap(), map);
        assert!(reader.verify().is_empty());
        assert_eq!(reader.summary().unwrap().layers, map.len() as u64);
        assert_eq!(reader.pixel_runs::<T>([1, 0]).unwrap().len(), 1);
        assert!(matches!(reader.multilayer_depth_map::<T>(), Err(Error::Kind { .. })));
    }
}

#[test]
fn fragments_come_back() {
    check_fragments::<f32>();
    check_fragments::<Rgb>();
}

#[test]
fn mono_maps_come_back() {
    check::<f32>();
}

#[test]
fn coloured_maps_come_back() {
    check::<Rgb>();
    let reader = open(file::<Rgb>(LayeredKind::Mtsm, Block::Zstd)).unwrap();
    assert!(matches!(reader.multilayer_map::<f32>(), Err(Error::Channels { .. })));
}

#[test]
fn threads_do_not_change_the_bytes() {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    for kind in [LayeredKind::Mtsm, LayeredKind::Layers, LayeredKind::Fragments] {
        let files = [1, 4].map(|threads| pool(threads).install(|| file::<f32>(kind, Block::Zstd)));
        assert_eq!(files[0], files[1]);
    }
}

#[test]
fn other_kinds_name_themselves() {
    let bytes = file::<f32>(LayeredKind::Mtsm, Block::Plain);
    let refused = MapReader::from_bytes(bytes, &Limits::default()).unwrap_err();
    assert_eq!(refused.to_string(), "a map of kind \"mtsm\", not a deep shadow map");
}

#[test]
fn a_bake_that_is_broken_off_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    std::fs::write(&path, b"old").unwrap();
    let broken_off = |_| ControlFlow::Break(());
    let refused = bake_mtsm(&baker::<f32>(), &path, Block::Zstd, |_| {}, broken_off);
    assert!(matches!(refused, Err(Error::Interrupted)));
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(folder.path().read_dir().unwrap().count(), 1);
}
