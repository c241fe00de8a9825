//! The light past several maps, against the product of their answers.

use dsm_core::detail::{PixelLists, PixelWindow, VisibilityView};
use dsm_core::{
    Filter, FilterShape, MapInfo, Progress, Rgb, ShadowCamera, Tolerance, Transmittance, Vertex,
};
use dsm_io::detail::{AnyDeepMap, MapWriter};
use dsm_io::{
    AchievedError, ConvertOptions, Limits, MapReader, MergeReport, Metadata, Packing, WriteOptions,
    convert,
};
use dsm_testkit::config;
use glam::DMat4;
use proptest::prelude::*;

use super::{image, info, merge, open, refusal, source, write};
use crate::pixels::{build, pixel_lists_of};

/// Both sides of a function at `z` in f64, by looking at every edge.
fn both_sides<T: Transmittance>(
    function: VisibilityView<'_, T>,
    channel: usize,
    z: f32,
) -> [f64; 2] {
    let mut sides = [1.0; 2];
    let value = |index| f64::from(function.value(index).channel(channel));
    for index in 0..function.len() {
        let here = function.depths()[index];
        let next = function.depths().get(index + 1).copied().unwrap_or(f32::INFINITY);
        let on_edge = if next.is_infinite() {
            value(index)
        } else {
            let (near, far) = (f64::from(here), f64::from(next));
            let share = (f64::from(z) - near) / (far - near);
            value(index) + (value(index + 1) - value(index)) * share
        };
        if here < z && z <= next {
            sides[0] = on_edge;
        }
        if here <= z && z < next {
            sides[1] = on_edge;
        }
    }
    sides
}

/// Holds `product` to what its factors answer, within `error`.
fn check_product<T: Transmittance>(
    product: &PixelLists<T>,
    factors: &[&dyn Fn(usize, usize, f32) -> [f64; 2]],
    depths: impl Fn(usize) -> Vec<f32>,
    error: f64,
) {
    for pixel in 0..product.view().pixel_count() {
        let function = product.view().function(pixel);
        let mut all = depths(pixel);
        all.extend(function.depths());
        all.sort_by(f32::total_cmp);
        let between: Vec<_> =
            all.windows(2).map(|pair| pair[0] + (pair[1] - pair[0]) / 2.0).collect();
        for z in all.into_iter().chain(between) {
            for channel in 0..T::CHANNELS {
                let expected = factors.iter().fold([1.0, 1.0], |[a, b], factor| {
                    let [before, at] = factor(pixel, channel, z);
                    [a * before, b * at]
                });
                let found = both_sides(function, channel, z);
                for (found, expected) in found.into_iter().zip(expected) {
                    let off = (found - expected).abs();
                    assert!(off <= error, "pixel {pixel}, depth {z}: {off} > {error}");
                }
            }
        }
    }
}

fn sides_of<T: Transmittance>(
    lists: &PixelLists<T>,
) -> impl Fn(usize, usize, f32) -> [f64; 2] + '_ {
    |pixel, channel, z| both_sides(lists.view().function(pixel), channel.min(T::CHANNELS - 1), z)
}

fn level_0<T: Transmittance>(reader: &MapReader) -> PixelLists<T> {
    reader.read_map::<T>(0).unwrap().pixels().clone()
}

#[derive(Clone, Debug)]
struct Three {
    mono: [PixelLists<f32>; 2],
    coloured: PixelLists<Rgb>,
}

fn three() -> impl Strategy<Value = Three> {
    (1_u32..=9, 1_u32..=9).prop_flat_map(|(width, height)| {
        let mono = [pixel_lists_of::<f32>(width, height), pixel_lists_of(width, height)];
        (mono, pixel_lists_of::<Rgb>(width, height))
            .prop_map(|(mono, coloured)| Three { mono, coloured })
    })
}

proptest! {
    #![proptest_config(config(0x0d5_f11e))]

    #[test]
    fn products_are_what_the_factors_let_through(
        Three { mono: [a, b], coloured } in three(),
        epsilon in prop_oneof![Just(0.0_f32), Just(0.01), Just(0.2)],
        tiles in [1_u32..6, 1_u32..6],
        with_colour in any::<bool>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = |name| folder.path().join(name);
        let [first, second] = tiles.map(|tile| WriteOptions::default().with_tile_size(tile));
        let (merged, of_a) = (path("merged.dsm"), sides_of(&a));
        let a_map = write(&path("a.dsm"), &a, info(0.0), first);
        let own = f64::from(epsilon).max(Tolerance::CHORD_FLOOR) + 1e-7;
        let depths = |pixel| a.view().function(pixel).depths().to_vec();
        let reader = if with_colour {
            let c_map = write(&path("c.dsm"), &coloured, info(0.03), second);
            merge(&[a_map, c_map], &merged, epsilon);
            let of_c = sides_of(&coloured);
            let depths = |pixel| {
                [depths(pixel), coloured.view().function(pixel).depths().to_vec()].concat()
            };
            let product = open(&merged);
            check_product(&level_0::<Rgb>(&product), &[&of_a, &of_c], depths, own);
            product
        } else {
            let b_map = write(&path("b.dsm"), &b, info(0.03), second.with_packing(Packing::Zstd));
            merge(&[a_map, b_map], &merged, epsilon);
            let of_b = sides_of(&b);
            let depths =
                |pixel| [depths(pixel), b.view().function(pixel).depths().to_vec()].concat();
            let product = open(&merged);
            check_product(&level_0::<f32>(&product), &[&of_a, &of_b], depths, own);
            product
        };
        let level = reader.levels()[0];
        prop_assert_eq!((level.tolerance, level.tile_width), (0.03 + epsilon, tiles[0]));
        // The sources' error is half of what they state; the product adds its
        // own.
        prop_assert!(f64::from(level.error.max) <= 0.015 + own);
    }
}

fn step<T: Transmittance>(z: f32, to: T) -> Vec<Vertex<T>> {
    vec![Vertex::new(z, T::CLEAR), Vertex::new(z, to)]
}

/// 11 × 9 pixels with steps in the upper left and ramps everywhere else but in
/// the last columns.
fn scene(shift: f32) -> PixelLists<f32> {
    build(
        11,
        9,
        (0..9_u8).flat_map(|y| (0..11_u8).map(move |x| (x, y))).map(|(x, y)| {
            let near = 1.0 + shift + f32::from(x) / 8.0;
            match (x, y) {
                (8.., _) => Vec::new(),
                (..4, ..4) => step(near, 0.5),
                _ => vec![Vertex::new(near, 1.0), Vertex::new(near + f32::from(y) + 1.0, 0.25)],
            }
        }),
    )
}

#[test]
fn steps_multiply_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let options = WriteOptions::default().with_tile_size(4);
    let pixels = |z, to| build(1, 1, [step(z, to)]);
    let maps: Vec<_> = [(1.0, 0.3_f32), (2.0, 0.7), (3.0, 0.9)]
        .map(|(z, to)| {
            write(&folder.path().join(format!("{z}.dsm")), &pixels(z, to), info(0.0), options)
        })
        .into();
    let path = folder.path().join("merged.dsm");
    let report = merge(&maps, &path, 0.0);
    assert!(matches!(report, MergeReport::Multiplied { lost_levels: 0, tolerance, .. }
        if tolerance == Tolerance::EXACT));
    let map = level_0::<f32>(&open(&path));
    let found: Vec<_> = map.view().pixel(0, 0).vertices().map(|v| (v.z, v.value)).collect();
    let two = (f64::from(0.3_f32) * f64::from(0.7_f32)) as f32;
    let three = (f64::from(0.3_f32) * f64::from(0.7_f32) * f64::from(0.9_f32)) as f32;
    let steps = [(1.0, 1.0), (1.0, 0.3), (2.0, 0.3), (2.0, two), (3.0, two), (3.0, three)];
    assert_eq!(found, steps);
}

#[test]
fn one_colour_makes_all_coloured_and_grey_stays_stored_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name| folder.path().join(name);
    let options = WriteOptions::default();
    let grey = build(2, 1, [step(1.0, 0.5_f32), step(1.0, 0.5)]);
    let colour = build(2, 1, [step(2.0, Rgb::new(0.5, 0.25, 1.0)), Vec::new()]);
    let maps = [
        write(&path("grey.dsm"), &grey, info(0.0), options),
        write(&path("colour.dsm"), &colour, info(0.0), options),
    ];
    merge(&maps, &path("merged.dsm"), 0.0);
    let AnyDeepMap::Rgb(map) = AnyDeepMap::read(&open(&path("merged.dsm")), 0).unwrap() else {
        unreachable!("a product with a coloured map is coloured")
    };
    assert_eq!(map.pixel(0, 0).last(), Rgb::new(0.25, 0.125, 0.5));
    assert!(map.pixel(1, 0).is_mono());
    assert_eq!(map.pixel(1, 0).columns(), [1.0, 0.5]);
}

#[test]
fn threads_and_the_inputs_tiles_change_no_function() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let bytes = |threads: usize, tile: u32| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let of = WriteOptions::default();
        let maps = [
            write(&path("a.dsm"), &scene(0.0), info(0.0), of.with_tile_size(2)),
            write(&path("b.dsm"), &scene(0.5), info(0.0), of.with_tile_size(tile)),
        ];
        pool.install(|| merge(&maps, &path("merged.dsm"), 0.01));
        std::fs::read(path("merged.dsm")).unwrap()
    };
    let whole = bytes(1, 2);
    assert!(whole == bytes(5, 2));
    assert!(bytes(1, 5) == bytes(5, 5));
    let functions = |bytes: Vec<u8>| {
        let reader = MapReader::from_bytes(bytes, &Limits::default()).unwrap();
        assert!(reader.verify().is_empty());
        level_0::<f32>(&reader)
    };
    assert_eq!(functions(whole), functions(bytes(3, 5)));
    assert_eq!(functions(bytes(1, 100)), functions(bytes(1, 1)));
}

#[test]
fn the_output_may_be_an_input() {
    let folder = tempfile::tempdir().unwrap();
    let (path, options) = (folder.path().join("map.dsm"), WriteOptions::default());
    let map = write(&path, &build(1, 1, [step(1.0, 0.5_f32)]), info(0.0), options);
    merge(&[open(&path), map], &path, 0.0);
    assert_eq!(level_0::<f32>(&open(&path)).view().pixel(0, 0).last(), 0.25);
}

/// Volumes use the slack that a tolerance has; several of them more than that.
#[test]
fn what_the_chords_of_many_volumes_cost_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.dsm");
    let sample = image("docs/sample/tuft.exr");
    convert(&mut source(&sample), &path, &ConvertOptions::default(), Progress::ignore).unwrap();
    let maps: Vec<_> = (0..4).map(|_| open(&path)).collect();
    assert!(maps[0].levels()[0].error.max > 4e-7, "the sample has no volumes");
    let merged = folder.path().join("merged.dsm");
    merge(&maps, &merged, 0.0);
    let level = open(&merged).levels()[0];
    assert!(level.error.max > 4.0 * 4e-7 && level.tolerance < 3e-6, "{level:?}");
    // Two of them leave little to add.
    merge(&maps[..2], &merged, 0.01);
    let stated = open(&merged).levels()[0].tolerance;
    assert!((0.01..0.010_000_3).contains(&stated), "{stated}");
}

#[test]
fn empty_tiles_cost_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let size = 1 << 30;
    let map = |name: &str| {
        let path = folder.path().join(name);
        let options = WriteOptions::default().with_tile_size(1 << 22);
        let metadata = Metadata::new(size, size, 3, MapInfo::default());
        MapWriter::create(&path, metadata, options).unwrap().finish().unwrap();
        MapReader::open(&path, &Limits::default()).unwrap()
    };
    let path = folder.path().join("merged.dsm");
    merge(&[map("a.dsm"), map("b.dsm")], &path, 0.01);
    let merged = MapReader::open(&path, &Limits::default()).unwrap();
    assert!(merged.directory(0).unwrap().iter().all(|(_, entry)| entry.is_empty()));
    assert_eq!([merged.metadata().width, merged.metadata().height], [size; 2]);
}

#[test]
fn what_all_maps_know_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let camera = ShadowCamera { world_to_camera: Some(DMat4::IDENTITY), world_to_ndc: None };
    let window = PixelWindow { min: [3, 2], max: [13, 10] };
    let known = info(0.01)
        .with_camera(camera)
        .with_samples(16)
        .with_filter(Filter::new(FilterShape::Tent, 2.0).unwrap())
        .with_data_window(window);
    let map = |name, info| write(&path(name), &scene(0.0), info, WriteOptions::default());
    let merged = |infos: [MapInfo; 2]| {
        merge(&[map("a.dsm", infos[0]), map("b.dsm", infos[1])], &path("merged.dsm"), 0.0);
        open(&path("merged.dsm")).metadata().info
    };
    let mut sum = known.with_tolerance(Tolerance::new(0.02).unwrap());
    assert_eq!(merged([known, known]), sum);
    let mut unknown = known.with_samples(4);
    (unknown.camera, unknown.data_window) = (None, None);
    sum.samples = None;
    assert_eq!(merged([unknown, known]), sum);
}

#[test]
fn what_does_not_fit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let options = WriteOptions::default();
    let of = |name, info| write(&path(name), &scene(0.0), info, options);
    let small = write(&path("small.dsm"), &build(1, 1, [step(1.0, 0.5_f32)]), info(0.0), options);
    assert!(refusal(&[], None).contains("nothing to merge"));
    assert!(refusal(&[of("a.dsm", info(0.0))], None).contains("one map alone"));
    let sizes = refusal(&[of("a.dsm", info(0.0)), small], None);
    assert!(sizes.ends_with("these have 11 × 9 pixels, 1 × 1 pixels"), "{sizes}");
    let camera = |x: f64| ShadowCamera {
        world_to_camera: Some(DMat4::from_translation([x, 0.0, 0.0].into())),
        world_to_ndc: None,
    };
    let seen = |x| info(0.0).with_camera(camera(x));
    let cameras = refusal(&[of("a.dsm", seen(0.0)), of("b.dsm", seen(1.0))], None);
    assert!(cameras.ends_with("b.dsm: its camera differs from an earlier map's"), "{cameras}");
    let window = |x| info(0.0).with_data_window(PixelWindow { min: [x, 0], max: [x + 10, 8] });
    let windows = refusal(&[of("a.dsm", window(0)), of("b.dsm", window(1))], None);
    assert!(windows.contains("its data window differs"), "{windows}");
    let loose = || of("a.dsm", info(0.4));
    let sum = refusal(&[loose(), loose()], Some(Tolerance::new(0.3).unwrap()));
    assert!(sum.contains("come to 1.1"), "{sum}");
}

/// A product has the error of every factor, of its own tile.
#[test]
fn errors_of_the_factors_add_up() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let tile = |error: f32| AchievedError { max: error, mean: error / 2.0 };
    let map = |name: &str, errors: [f32; 2]| {
        let metadata = Metadata::new(4, 2, 1, info(0.25));
        let options = WriteOptions::default().with_tile_size(2);
        let mut writer = MapWriter::create(path(name), metadata, options).unwrap();
        for (x, error) in (0..).zip(errors) {
            let pixels = build(2, 2, (0..4).map(|_| step(1.0, 0.5_f32)));
            let id = dsm_io::detail::TileId::new(0, x, 0);
            writer.write_tile(id, pixels.view(), tile(error)).unwrap();
        }
        writer.finish().unwrap();
        open(&path(name))
    };
    merge(&[map("a.dsm", [0.125, 0.0]), map("b.dsm", [0.0625, 0.25])], &path("c.dsm"), 0.0);
    let merged = open(&path("c.dsm"));
    let errors: Vec<_> =
        merged.directory(0).unwrap().iter().map(|(_, entry)| entry.error).collect();
    assert_eq!(errors, [tile(0.1875), tile(0.25)]);
}
