//! What files of layered maps hold and say of themselves.

use std::ops::ControlFlow;

use dsm_core::{
    Error, HitSource, Rgb, SurfaceHit, TileHits, TileSamples, Tolerance, Transmittance,
};
use dsm_io::{Block, Container, ContainerWriter, Level, Limits, Memory};
use glam::Vec3;
use mtsm::{
    LayeredKind, LayeredReader, LayeredReport, MultilayerBaker, bake_fragments, bake_layers,
    bake_mtsm,
};
use shadow_maps::fragments::FragmentMap;

use crate::examples::{baker, file, fragment_map, fragments, open, settings, source};

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
    for block in [Block::Plain, Block::Zstd] {
        bake_fragments::<T, _>(&builder, &Panes, &path, (4, block), |_| {}).unwrap();
        let reader = LayeredReader::open(&path, &Limits::default()).unwrap();
        assert_eq!(reader.fragment_map::<T>().unwrap(), map);
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

/// What is left behind each of these opacities.
fn left<T: Transmittance>(opacities: impl Iterator<Item = T>) -> Vec<T> {
    let mut left = T::CLEAR;
    let behind = |opacity: T| {
        left = T::from_channels(|channel| left.channel(channel) * (1.0 - opacity.channel(channel)));
        left
    };
    opacities.map(behind).collect()
}

fn pixels<T: Transmittance>() {
    let depths = baker::<T>().depth_map().unwrap();
    let planes = fragment_map::<T>();
    let layers = open(file::<T>(LayeredKind::Layers, Block::Zstd)).unwrap();
    let fragments = open(file::<T>(LayeredKind::Fragments, Block::Zstd)).unwrap();
    let (mut occupied, mut most) = (0, 0);
    for (x, y) in (0..5).flat_map(|y| (0..6).map(move |x| (x, y))) {
        let hits: Vec<_> = depths.pixels().layers((y * 6 + x) as usize).collect();
        let shown = layers.pixel_runs::<T>([x, y]).unwrap().concat();
        let values = left(hits.iter().map(|hit| hit.opacity));
        assert!(shown.iter().map(|layer| layer.visibility).eq(values));
        assert!(shown.iter().map(|layer| layer.depth).eq(hits.iter().map(|hit| hit.depth)));
        // The nearest first.
        let mut nearest: Vec<_> = planes.pixel(x, y).collect();
        nearest.reverse();
        let shown = fragments.pixel_runs::<T>([x, y]).unwrap().concat();
        let values = left(nearest.iter().map(|one| one.opacity));
        assert!(shown.iter().map(|layer| layer.visibility).eq(values));
        assert!(shown.iter().map(|layer| layer.depth).eq(nearest.iter().map(|one| one.w.recip())));
        assert!(shown.iter().all(|layer| layer.count == 1));
        occupied += u64::from(!nearest.is_empty());
        most = most.max(nearest.len() as u64);
    }
    let summary = fragments.summary().unwrap();
    assert_eq!((summary.runs, summary.most_runs), (occupied, 1));
    assert_eq!((summary.samples, summary.most_layers), (planes.len() as u64, most));
    assert_eq!(summary.empty_pixels, 30 - occupied);
    assert!(most > 2 && occupied < 30);
}

#[test]
fn pixels_are_shown_as_they_are() {
    pixels::<f32>();
    pixels::<Rgb>();
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
    let depths = bake_layers(&few(2), &path, Block::Zstd, |_| {}, go_on).unwrap();
    assert_eq!(depths.cut_pixels, cut);
    let all = bake_layers(&few(32), &path, Block::Zstd, |_| {}, go_on).unwrap();
    assert_eq!((all.cut_pixels, all.hits), (0, depths.hits));
    assert!(all.hits >= (0..30).map(count).sum());
    let reader = LayeredReader::open(&path, &Limits::default()).unwrap();
    assert_eq!(reader.metadata().info.tolerance, Tolerance::EXACT);
    assert_eq!((reader.layering().resets, reader.layering().max_layers), (0, 32));
    let [runs, cut_runs] =
        [32, 1].map(|layers| bake_mtsm(&few(layers), &path, Block::Zstd, |_| {}, go_on).unwrap());
    assert_eq!((runs.hits, runs.cut_pixels), (all.hits, 0));
    assert!(cut_runs.cut_pixels > cut);
    let [planes, cut_planes] = [32, 2].map(|layers| {
        let builder = fragments().with_layers(layers).unwrap();
        bake_fragments::<f32, _>(&builder, &source(), &path, (4, Block::Zstd), |_| {})
    });
    let LayeredReport { hits, cut_pixels, .. } = planes.unwrap();
    assert!(hits > fragment_map::<f32>().len() as u64 && cut_pixels == 0);
    assert_eq!(cut_planes.unwrap().cut_pixels, cut);
}

#[test]
fn crops_levels_and_what_is_too_large_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let go_on = |_| ControlFlow::Continue(());
    let mut crop = settings();
    crop.bake.crop = Some([0, 0, 4, 4]);
    let baker = MultilayerBaker::<f32, _>::new(source(), crop).unwrap();
    let refused = bake_mtsm(&baker, &path, Block::Zstd, |_| {}, go_on).unwrap_err();
    assert!(refused.to_string().contains("baked whole"), "{refused}");
    assert!(!path.exists());

    let bytes = file::<f32>(LayeredKind::Mtsm, Block::Plain);
    let whole = open(bytes.clone()).unwrap();
    let mut writer = ContainerWriter::create(&path).unwrap();
    writer.add_level(Level::new(6, 5, 4, 0.02)).unwrap();
    writer.add_level(Level { number: 1, ..Level::new(3, 3, 4, 0.02) }).unwrap();
    writer.finish(whole.container().metadata().unwrap()).unwrap();
    let refused = LayeredReader::open(&path, &Limits::default()).unwrap_err();
    assert!(refused.to_string().contains("a layered map has one level"), "{refused}");

    let within = |change: fn(&mut Limits)| {
        let mut limits = Limits::default();
        change(&mut limits);
        let container = Container::from_source(Memory::from(bytes.clone()), &Limits::default());
        let reader = LayeredReader::new(container.unwrap(), &limits).unwrap();
        reader.multilayer_map::<f32>().map(drop).map_err(|error| error.to_string())
    };
    assert_eq!(within(|limits| limits.max_pixels = 30), Ok(()));
    assert!(within(|limits| limits.max_pixels = 29).unwrap_err().contains("pixels"));
    let refused = within(|limits| limits.max_in_memory_bytes = 64).unwrap_err();
    assert!(refused.contains("bytes of a map in memory"), "{refused}");
}
