//! Tiles: the same from any thread, in any crop and of any size.

use std::ops::ControlFlow;
use std::sync::Mutex;

use dsm_core::detail::{BakedTile, TransmittanceFunction, VisibilityDifference, VisibilitySweep};
use dsm_core::{
    BakeSettings, Baker, DeepMap, Error, HitSource, PixelSampling, Progress, Rgb, SurfaceHit,
    TileHits, TileSamples, Transmittance,
};
use dsm_testkit::config;
use proptest::prelude::*;

use crate::pixels::{scenes, settings};
use crate::sources::RandomScene;

fn tiles<T: Transmittance>(scene: RandomScene, settings: &BakeSettings) -> Vec<BakedTile<T>> {
    let baker = Baker::new(scene, settings.clone()).unwrap();
    let mut tiles = Vec::new();
    let sink = |tile| {
        tiles.push(tile);
        Ok::<_, Error>(())
    };
    let outcome = baker.run(Ok, sink, |_| ControlFlow::Continue(()));
    assert_eq!(outcome, Ok(ControlFlow::Continue(())));
    tiles
}

fn map<T: Transmittance>(scene: RandomScene, settings: &BakeSettings) -> DeepMap<T> {
    Baker::new(scene, settings.clone()).unwrap().map().unwrap()
}

fn check_crops<T: Transmittance>(scene: RandomScene, settings: &BakeSettings) {
    let whole = tiles::<T>(scene, settings);
    assert!(whole.iter().map(BakedTile::tile).eq(settings.tiles()));
    let tile = settings.tile_size;
    let [width, height] = settings.size;
    let (x, y) = ((width - 1) / tile / 2 * tile, (height - 1) / tile / 2 * tile);
    for crop in [[0, 0, width, (y + tile).min(height)], [x, y, width, height]] {
        let cropped = settings.clone().with_crop(crop);
        let part = tiles::<T>(scene, &cropped);
        assert!(part.iter().map(BakedTile::tile).eq(cropped.tiles()));
        assert!(part.iter().all(|tile| whole.contains(tile)));
        let (part, whole) = (map::<T>(scene, &cropped), map::<T>(scene, settings));
        for y in crop[1]..crop[3] {
            for x in crop[0]..crop[2] {
                let there = part.pixel(x - crop[0], y - crop[1]);
                assert!(there.vertices().eq(whole.pixel(x, y).vertices()));
            }
        }
    }
}

fn check_sizes<T: Transmittance>(scene: RandomScene, settings: &BakeSettings) {
    // Backwards the order of hits depends on how many samples come at once.
    let scene = RandomScene { backwards: false, ..scene };
    let maps = [1, 2, 64].map(|tile_size| {
        map::<T>(scene, &settings.clone().with_tile_size(tile_size)).pixels().clone()
    });
    assert_eq!(maps[0], maps[1]);
    assert_eq!(maps[0], maps[2]);
}

/// The rays of every pixel sum up to its function.
fn check_rays<T: Transmittance>(scene: RandomScene, settings: &BakeSettings) {
    let baker = Baker::<T, _>::new(scene, settings.clone()).unwrap();
    for tile in settings.tiles() {
        let mut exact = Vec::new();
        let exact_hits = baker
            .exact_tile(tile, |pixel| exact.push((pixel.pixel(), pixel.vertices().to_vec())))
            .unwrap();
        let mut exact = exact.into_iter();
        let mut sweep = VisibilitySweep::default();
        let hits = baker.sampled_tile(tile, |pixel| {
            let chord = settings.tolerance().chord();
            let functions: Vec<_> =
                pixel.rays().iter().map(|ray| TransmittanceFunction::new(ray, chord)).collect();
            assert_eq!(pixel.weights().len(), functions.len());
            let functions: Vec<_> = pixel.weights().iter().copied().zip(&functions).collect();
            let mut vertices = Vec::new();
            sweep.over(&functions).run(|vertex| vertices.push(vertex));
            let (place, expected) = exact.next().unwrap();
            assert_eq!(pixel.pixel(), place);
            let difference = VisibilityDifference::between(&vertices, &expected);
            assert!(difference.max() < 1e-12, "{difference:?}");
        });
        assert_eq!(hits, Ok(exact_hits));
        assert!(exact.next().is_none());
    }
}

proptest! {
    #![proptest_config(config(65))]

    #[test]
    fn rays_sum_up_to_functions(scene in scenes(), settings in settings()) {
        check_rays::<f32>(scene, &settings);
        check_rays::<Rgb>(scene, &settings);
    }

    #[test]
    fn crops_have_the_tiles_of_the_whole(scene in scenes(), settings in settings()) {
        check_crops::<f32>(scene, &settings);
        check_crops::<Rgb>(scene, &settings);
    }

    #[test]
    fn the_size_of_tiles_does_not_matter(scene in scenes(), settings in settings()) {
        check_sizes::<f32>(scene, &settings);
        check_sizes::<Rgb>(scene, &settings);
    }
}

const SCENE: RandomScene = RandomScene { seed: 7, on_grid: false, media: 5, backwards: false };

/// 20 × 15 tiles.
fn many_tiles() -> BakeSettings {
    let mut settings = BakeSettings::new([40, 30]).unwrap();
    settings.tile_size = 2;
    settings
}

#[test]
fn threads_do_not_matter() {
    let settings = many_tiles();
    let bake = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tiles::<f32>(SCENE, &settings))
    };
    let one = bake(1);
    assert_eq!(one.len(), 300);
    assert!(one.iter().map(BakedTile::tile).eq(settings.tiles()));
    for threads in [2, 5] {
        assert_eq!(bake(threads), one);
    }
}

#[test]
fn a_block_of_many_samples_is_cut_up() {
    let mut settings = BakeSettings::new([9, 5]).unwrap();
    settings.sampling = PixelSampling::new(4096, 5).unwrap();
    let whole = map::<f32>(SCENE, &settings).pixels().clone();
    settings.tile_size = 1;
    assert_eq!(map::<f32>(SCENE, &settings).pixels(), &whole);
    assert!(whole.view().vertex_count() > 45);
}

#[test]
fn a_bake_can_be_watched_and_broken_off() {
    let baker = Baker::<f32, _>::new(SCENE, many_tiles()).unwrap();
    let mut handed_over = 0;
    let most = Mutex::new(0);
    let sink = |_| {
        handed_over += 1;
        Ok::<_, Error>(())
    };
    let outcome = baker.run(Ok, sink, |Progress { done, total: tiles, .. }| {
        assert_eq!(tiles, 300);
        let mut most = most.lock().unwrap();
        *most = done.max(*most);
        if done < 20 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    assert_eq!(outcome, Ok(ControlFlow::Break(())));
    assert!((20..300).contains(&handed_over), "{handed_over}");
    assert!((20..=handed_over).contains(&*most.lock().unwrap()));
}

#[derive(Debug, PartialEq)]
enum Failure {
    Source(i32),
    Hit(Error),
    Encode,
    Sink,
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Hit(error)
    }
}

/// Fails right of a column, and sees what cannot be below a row.
struct Broken {
    column: i32,
    row: i32,
}

impl HitSource<f32> for Broken {
    type Error = Failure;

    fn hits(&self, samples: &TileSamples, hits: &mut TileHits<f32>) -> Result<(), Failure> {
        let [x, y] = samples.min();
        if x >= self.column {
            return Err(Failure::Source(y));
        }
        let depth = if y >= self.row { -1.0 } else { 1.0 };
        Ok(hits.push_surface(0, SurfaceHit { depth, opacity: 0.5 })?)
    }
}

#[test]
fn the_first_error_in_order_ends_it() {
    let run = |column, row, encode_fails: u32, sink_fails: u32| {
        let baker = Baker::new(Broken { column, row }, many_tiles()).unwrap();
        let number = |tile: &BakedTile<f32>| tile.tile()[1] * 20 + tile.tile()[0];
        let mut handed_over = 0;
        let outcome = baker.run(
            |tile| if number(&tile) == encode_fails { Err(Failure::Encode) } else { Ok(tile) },
            |tile| {
                assert_eq!(number(&tile), handed_over);
                handed_over += 1;
                if handed_over == sink_fails { Err(Failure::Sink) } else { Ok(()) }
            },
            |_| ControlFlow::Continue(()),
        );
        (outcome.unwrap_err(), handed_over)
    };
    assert_eq!(run(38, 99, 999, 999), (Failure::Source(0), 19));
    let (error, handed_over) = run(99, 4, 999, 999);
    assert!(matches!(error, Failure::Hit(Error::Hit { depth: -1.0, .. })), "{error:?}");
    assert_eq!(handed_over, 40);
    assert_eq!(run(38, 4, 7, 999), (Failure::Encode, 7));
    assert_eq!(run(38, 4, 7, 3), (Failure::Sink, 3));
    let baker = Baker::new(Broken { column: 9, row: 9 }, many_tiles()).unwrap();
    assert!(matches!(baker.tile([20, 0]), Err(Failure::Hit(Error::Setting { .. }))));
}
