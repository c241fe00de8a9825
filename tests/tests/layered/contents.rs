//! What files of layered maps hold and say of themselves.

use std::ops::ControlFlow;

use dsm_core::{
    Error, HitSource, Progress, RayHits, RaySource, Rgb, SamplePoint, SurfaceHit, TileHits,
    TileSamples, Tolerance, Transmittance, VisibilityField, VolumeSample,
};
use dsm_io::detail::{
    BakeReport, Container, KindReader, KindWriter, Level, MapKind, Memory, PixelValue, TileCache,
    TileId,
};
use dsm_io::{AchievedError, Error as FileError, Limits, Packing, WriteOptions};
use glam::Vec3;
use mtsm::detail::{Layers, Mtsm, bake_layers, bake_mtsm};
use mtsm::{MultilayerBaker, MultilayerMap};
use shadow_maps::detail::{FragmentMap, Fragments, bake_fragments};

use crate::examples::{
    FOGGY, baker, file, foggy_map, fragment_map, fragments, read, settings, source,
};

/// Slanted panes, of which each pixel has its own part, and strands.
struct Panes;

impl<T: Transmittance> HitSource<T> for Panes {
    type Error = Error;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<T>) -> Result<(), Error> {
        for sample in 0..samples.len() {
            let [x, y] = [samples.x(), samples.y()].map(|column| column[sample as usize]);
            let opacity = T::from_channels(|channel| 0.25 + 0.25 * channel as f32);
            if x + 0.3 * y > 2.0 && x + y < 7.0 {
                let depth = (2.0 + 0.11 * x - 0.07 * y) as f32;
                let normal = Vec3::new(0.4, 0.3, 1.0);
                hits.push_surface_with_normal(sample, SurfaceHit { depth, opacity }, normal)?;
            }
            if (x * 3.0).fract() < 0.4 {
                hits.push_surface(sample, SurfaceHit { depth: 3.5, opacity: T::splat(0.5) })?;
            }
        }
        Ok(())
    }
}

fn planes_and_masks<T: Transmittance>() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let builder = fragments().with_coverage(8).unwrap();
    let map: FragmentMap<T> = builder.build(&Panes).unwrap();
    for packing in [Packing::Plain, Packing::Zstd] {
        bake_fragments::<T, _>(
            &builder,
            &Panes,
            (&path, None),
            packed(packing),
            |_| {},
            Progress::ignore,
        )
        .unwrap();
        let reader = KindReader::<Fragments>::open(&path, &Limits::default()).unwrap();
        assert_eq!(FragmentMap::<T>::read(&reader).unwrap(), map);
        assert!(reader.verify().is_empty());
        assert_eq!(reader.metadata().info.samples, Some(64));
        // Every tile says between which depths all that is covered lies.
        for (id, entry) in reader.container().directory(0).unwrap().iter() {
            let columns = (id.x * 4..id.x * 4 + 4).filter(|&x| x < 6);
            for (x, y) in
                columns.flat_map(|x| (id.y * 4..(id.y * 4 + 4).min(5)).map(move |y| (x, y)))
            {
                for fragment in map.pixel(x, y) {
                    let [low, high] = fragment.range();
                    assert!(entry.z_min <= high.recip() && low.recip() <= entry.z_max);
                }
            }
        }
    }
    let all = || (0..30).flat_map(|pixel| map.pixel(pixel % 6, pixel / 6));
    assert!(all().any(|one| one.coverage as u32 != (one.coverage >> 32) as u32));
    assert!(all().any(|one| one.gradient.is_some_and(|[x, y]| x != y)));
    assert!(all().any(|one| one.is_facing()));
}

#[test]
fn planes_and_masks_come_back() {
    planes_and_masks::<f32>();
    planes_and_masks::<Rgb>();
}

fn pixels<T: Transmittance>() {
    let (runs, depths) = (baker::<T>().map().unwrap(), baker::<T>().depth_map().unwrap());
    let planes = fragment_map::<T>();
    let mtsm = read::<Mtsm>(file::<T>(Mtsm::NAME, Packing::Zstd)).unwrap();
    let layers = read::<Layers>(file::<T>(Layers::NAME, Packing::Zstd)).unwrap();
    let fragments = read::<Fragments>(file::<T>(Fragments::NAME, Packing::Zstd)).unwrap();
    let number = PixelValue::Number;
    let (mut occupied, mut most) = (0, 0);
    for (x, y) in (0..5).flat_map(|y| (0..6).map(move |x| (x, y))) {
        let pixel = (y * 6 + x) as usize;
        let shown = mtsm.contents::<T>(0, [x, y]).unwrap();
        let expected = runs.pixels().runs(pixel).map(|run| {
            let row = |layer: mtsm::detail::Layer<T>| {
                vec![
                    number(layer.depth),
                    PixelValue::light(layer.visibility),
                    PixelValue::Count(layer.count),
                ]
            };
            run.layers().map(row).collect::<Vec<_>>()
        });
        assert!(shown.lists().map(<[_]>::to_vec).eq(expected), "({x}, {y})");
        let shown = layers.contents::<T>(0, [x, y]).unwrap();
        let expected = depths.pixels().layers(pixel);
        let expected = expected.map(|hit| vec![number(hit.depth), PixelValue::light(hit.opacity)]);
        assert!(shown.rows().iter().cloned().eq(expected), "({x}, {y})");
        // The nearest first.
        let mut nearest: Vec<_> = planes.pixel(x, y).collect();
        nearest.reverse();
        let shown = fragments.contents::<T>(0, [x, y]).unwrap();
        let expected = nearest.iter().map(|one| {
            let covered = PixelValue::Count(one.coverage.count_ones());
            let mask = PixelValue::Mask(one.coverage);
            vec![number(one.w.recip()), PixelValue::light(one.opacity), covered, mask]
        });
        assert!(shown.rows().iter().cloned().eq(expected), "({x}, {y})");
        occupied += u64::from(!nearest.is_empty());
        most = most.max(nearest.len() as u64);
    }
    let summary = fragments.summary().unwrap();
    assert_eq!(summary.count("fragments"), Some(planes.len() as u64));
    assert_eq!(summary.count("max_fragments_per_pixel"), Some(most));
    assert_eq!(summary.count("empty_pixels"), Some(30 - occupied));
    assert!(most > 2 && occupied < 30);
}

#[test]
fn pixels_are_shown_as_they_are() {
    pixels::<f32>();
    pixels::<Rgb>();
}

#[test]
fn slabs_are_shown_among_fragments() {
    let map = foggy_map::<Rgb>();
    let reader = read::<Fragments>(file::<Rgb>(FOGGY, Packing::Zstd)).unwrap();
    let (mut slabs, mut both) = (0, 0);
    for (x, y) in (0..5).flat_map(|y| (0..6).map(move |x| (x, y))) {
        let shown = reader.contents::<Rgb>(0, [x, y]).unwrap();
        assert_eq!(shown.columns(), ["depth", "to depth", "opacity", "covered 64ths", "mask"]);
        let number = |value: &PixelValue| match value {
            PixelValue::Number(number) => *number,
            other => panic!("{other:?}"),
        };
        let ranges: Vec<_> =
            shown.rows().iter().map(|row| [number(&row[0]), number(&row[1])]).collect();
        assert!(ranges.is_sorted_by(|a, b| a[0] <= b[0]), "{ranges:?}");
        let borders: Vec<_> = map.media().unwrap().pixel((y * 6 + x) as usize).collect();
        let own = ranges.iter().filter(|range| range[0] < range[1]).count();
        let expected = borders.iter().filter(|(_, thickness)| *thickness != Rgb::splat(0.0));
        assert_eq!(own, expected.count());
        assert_eq!(ranges.len() - own, map.pixel(x, y).len());
        if let Some(&(depth, thickness)) = borders.get(1) {
            let row = ranges.iter().position(|&range| range == [borders[0].0, depth]).unwrap();
            let opacity = [0, 1, 2].map(|channel| -(-thickness.channel(channel)).exp_m1());
            assert_eq!(shown.rows()[row][2], PixelValue::Rgb(opacity));
            both += usize::from(own < ranges.len());
        }
        slabs += own;
    }
    assert!(slabs > 30 && both > 5, "{slabs} {both}");
}

#[test]
fn a_map_states_what_its_media_keep() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    // An exponential that 256 slabs cannot follow.
    let steep = RaySource(|_: SamplePoint, hits: &mut RayHits<f32>| -> Result<(), Error> {
        let samples = (0..2000_u16).map(|at| VolumeSample {
            depth: 1.0 + f32::from(at) / 500.0,
            extinction: if at % 2 == 0 { 200.0 } else { 0.0 },
        });
        hits.push_volume(&samples.collect::<Vec<_>>(), 1.0)
    });
    let mut kept = Vec::new();
    for asked in [0.3, 1e-4] {
        let asked = Tolerance::new(asked).unwrap();
        let builder = fragments().with_tolerance(asked);
        let write = packed(Packing::Zstd);
        let (_, told) =
            bake_fragments(&builder, &steep, (&path, None), write, |_| {}, Progress::ignore)
                .unwrap();
        let reader = KindReader::<Fragments>::open(&path, &Limits::default()).unwrap();
        assert!(reader.verify().is_empty());
        assert_eq!(reader.metadata().info.tolerance, told);
        assert!(reader.levels()[0].error.max <= told.epsilon());
        assert!(reader.summary().unwrap().count("max_slabs_per_pixel").unwrap() <= 256);
        kept.push([asked, told]);
    }
    assert_eq!(kept[0][0], kept[0][1]);
    assert!(kept[1][0] < kept[1][1], "{kept:?}");
}

#[test]
fn bakes_count_hits_and_what_was_cut() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let go_on = |_| ControlFlow::Continue(());
    let few = |max_layers| {
        let mut settings = settings();
        settings.max_layers = max_layers;
        MultilayerBaker::<f32, _>::new(source(), settings).unwrap()
    };
    let whole = few(32).depth_map().unwrap();
    let count = |pixel: usize| whole.pixels().layers(pixel).len() as u64;
    let cut = (0..30).filter(|&pixel| count(pixel) > 2).count() as u64;
    assert!(cut > 3);
    let depths = bake_layers(&few(2), &path, Packing::Zstd, |_| {}, go_on).unwrap();
    assert_eq!(depths.cut_pixels, cut);
    let all = bake_layers(&few(32), &path, Packing::Zstd, |_| {}, go_on).unwrap();
    assert_eq!((all.cut_pixels, all.hits), (0, depths.hits));
    assert!(all.hits >= (0..30).map(count).sum());
    let reader = KindReader::<Layers>::open(&path, &Limits::default()).unwrap();
    assert_eq!(reader.metadata().info.tolerance, Tolerance::EXACT);
    let layering = reader.keys().layering;
    assert_eq!((layering.resets, layering.max_layers), (0, 32));
    let [runs, cut_runs] =
        [32, 1].map(|layers| bake_mtsm(&few(layers), &path, Packing::Zstd, |_| {}, go_on).unwrap());
    assert_eq!((runs.hits, runs.cut_pixels), (all.hits, 0));
    assert!(cut_runs.cut_pixels > cut);
    let [planes, cut_planes] = [32, 2].map(|layers| {
        let builder = fragments().with_layers(layers).unwrap();
        bake_fragments::<f32, _>(
            &builder,
            &source(),
            (&path, None),
            packed(Packing::Zstd),
            |_| {},
            Progress::ignore,
        )
    });
    let (BakeReport { hits, cut_pixels, .. }, _) = planes.unwrap();
    assert!(hits > fragment_map::<f32>().len() as u64 && cut_pixels == 0);
    assert_eq!(cut_planes.unwrap().0.cut_pixels, cut);
}

#[test]
fn what_is_too_large_is_refused() {
    let bytes = file::<f32>(Mtsm::NAME, Packing::Plain);
    let within = |change: fn(&mut Limits)| {
        let mut limits = Limits::default();
        change(&mut limits);
        let container = Container::from_source(Memory::from(bytes.clone()), &Limits::default());
        let reader = KindReader::<Mtsm>::new(container.unwrap(), &limits).unwrap();
        MultilayerMap::<f32>::read(&reader).map(drop).map_err(|error| error.to_string())
    };
    assert_eq!(within(|limits| limits.max_pixels = 30), Ok(()));
    assert!(within(|limits| limits.max_pixels = 29).unwrap_err().contains("pixels"));
    let refused = within(|limits| limits.max_in_memory_bytes = 64).unwrap_err();
    assert!(refused.contains("bytes of a map in memory"), "{refused}");
    let refused = within(|limits| limits.max_chunk_bytes = 64).unwrap_err();
    assert!(refused.contains("bytes of a tile"), "{refused}");
}

/// Levels and views of any kind are written, found by view and number, and read.
#[test]
fn levels_and_views_have_tiles_of_the_kind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let whole = read::<Mtsm>(file::<f32>(Mtsm::NAME, Packing::Plain)).unwrap();
    let (keys, options) = (*whole.keys(), WriteOptions::default().with_tile_size(4));
    let metadata = whole.metadata().clone();
    let mut writer = KindWriter::<Mtsm>::create(&path, metadata, &keys, options).unwrap();
    let level = |view, number, size: [u32; 2]| Level {
        view,
        number,
        ..Level::new(size[0], size[1], 4, 0.02)
    };
    assert_eq!(writer.add_level(level(0, 1, [3, 3])).unwrap(), 1);
    assert_eq!(writer.add_level(level(1, 0, [4, 4])).unwrap(), 2);
    assert!(writer.add_level(level(3, 0, [4, 4])).is_err(), "views count from 0");
    let tile = whole.decode_tile::<f32>(TileId::new(0, 0, 0)).unwrap();
    for view in [0, 2] {
        writer.write_tile(TileId::new(view, 0, 0), &tile, AchievedError::NONE).unwrap();
    }
    let wrong = writer.write_tile(TileId::new(1, 0, 0), &tile, AchievedError::NONE);
    assert!(wrong.unwrap_err().to_string().contains("has 3 × 3 pixels, not 4 × 4"));
    writer.finish().unwrap();
    let reader = KindReader::<Mtsm>::open(&path, &Limits::default()).unwrap();
    assert_eq!(reader.verify().len(), 0);
    let container = reader.container();
    assert_eq!(container.view_count(), 2);
    assert_eq!(container.level_of_view(0, 1).unwrap(), 1);
    assert_eq!(container.level_of_view(1, 0).unwrap(), 2);
    assert!(matches!(container.level_of_view(1, 1), Err(FileError::NoSuchLevel(1))));
    assert_eq!(container.view(0).map(|(index, _)| index).collect::<Vec<_>>(), [0, 1]);
    assert_eq!(container.view(7).len(), 0);
    assert_eq!(reader.decode_tile::<f32>(TileId::new(2, 0, 0)).unwrap(), tile);
    assert_eq!(
        reader.contents::<f32>(2, [1, 0]).unwrap(),
        whole.contents::<f32>(0, [1, 0]).unwrap()
    );
    // The other views have cursors of their own.
    let map = TileCache::new(1 << 20).insert::<f32, _>(reader).unwrap();
    let cursor = map.level_cursor(2).unwrap();
    assert_eq!(cursor.evaluate([1, 0], 9.0).unwrap(), map.cursor().evaluate([1, 0], 9.0).unwrap());
    assert_eq!(map.view_pyramid(1).unwrap().levels().len(), 1);
    assert!(map.view_pyramid(2).is_err());
}

/// Tiles of 4 pixels packed so.
fn packed(packing: Packing) -> WriteOptions {
    WriteOptions::default().with_tile_size(4).with_packing(packing)
}
