//! Layered maps that were written once stay readable, number by number.
//!
//! What the files must hold is computed here, from a pixel's place alone.

use dsm_core::{MapInfo, Rgb, SurfaceHit, Tolerance, Transmittance};
use dsm_io::detail::{KindReader, KindWriter, Level, MapKind, TileId, TileRect};
use dsm_io::{AchievedError, Limits, Metadata, Packing, WriteOptions};
use dsm_tests::golden;
use dsm_trace::detail::Layering;
use mtsm::detail::{DepthLayers, Layer, LayeredPixels, LayeredPixelsBuilder, Layers, Mtsm};
use shadow_maps::detail::{
    Accumulate, Attenuation, AttenuationKeys, Epsilon, Filtering, Fragment, FragmentColumns,
    FragmentKeys, FragmentLists, FragmentTile, Fragments, MediaColumns, MediaKeys, MergedDepth,
    Prefiltered, PrefilteredKeys, PrefilteredTile, ViewTile, Views, ViewsKeys,
};

/// Of level 0, in tiles of 8 × 8: the second row of tiles is one pixel high.
const SIZE: [u32; 2] = [12, 9];
const LAYERING: Layering = Layering { resets: 2, max_layers: 5, light_depth: 0.75 };
const PACKINGS: [(Packing, &str); 2] = [(Packing::Plain, "plain"), (Packing::Zstd, "zstd")];

type TileOf<G, T> = <<G as Golden>::Kind as MapKind>::Tile<T>;
type KeysOf<G> = <<G as Golden>::Kind as MapKind>::Keys;

/// Maps of fragments with media beside them, which have version 2 of the payload.
struct Media;

/// What a golden file of a kind holds.
trait Golden {
    type Kind: MapKind;

    /// What the names of its files begin with.
    const NAME: &'static str;

    fn keys() -> KeysOf<Self>;

    /// What the file says that it keeps.
    const TOLERANCE: f32 = 0.0;

    /// Levels besides the first.
    fn levels() -> Vec<Level> {
        let level = |view, number, size: [u32; 2]| Level {
            view,
            number,
            ..Level::new(size[0], size[1], 8, Self::TOLERANCE)
        };
        vec![level(0, 1, [6, 5]), level(1, 0, [4, 10])]
    }

    /// The tile over these pixels of a level.
    fn tile<T: Transmittance>(level: u32, rect: TileRect) -> TileOf<Self, T>;

    fn assert_same<T: Transmittance>(
        found: &TileOf<Self, T>,
        expected: &TileOf<Self, T>,
        name: &str,
    );
}

/// The pixels of a tile, row by row.
fn places(rect: TileRect) -> impl Iterator<Item = [u32; 2]> {
    (rect.y..rect.y + rect.height)
        .flat_map(move |y| (rect.x..rect.x + rect.width).map(move |x| [x, y]))
}

/// Each channel has half of the one before.
fn halves<T: Transmittance>(value: f32) -> T {
    T::from_channels(|channel| value / (1 << channel) as f32)
}

impl Golden for Mtsm {
    type Kind = Self;
    const NAME: &'static str = <Self as MapKind>::NAME;
    const TOLERANCE: f32 = 0.0625;

    fn keys() -> KeysOf<Self> {
        LAYERING.into()
    }

    fn tile<T: Transmittance>(level: u32, rect: TileRect) -> LayeredPixels<T> {
        let mut pixels = LayeredPixelsBuilder::new(rect.width, rect.height);
        for [x, y] in places(rect) {
            let runs = (x + y + level) % 3;
            for run in 0..runs {
                let depth = 2.0 + run as f32 + x as f32 / 8.0;
                let layer = |depth, visibility, count| Layer { depth, visibility, count };
                let clear = layer(depth, T::CLEAR, 0);
                if run + 1 < runs {
                    pixels.push_run([clear, layer(depth, T::BLOCKED, 1 + x)]).unwrap();
                } else {
                    let (half, quarter) = (halves(0.5), halves(0.25));
                    let more = [layer(depth, half, y + 1), layer(depth + 0.5, quarter, 3)];
                    pixels.push_run([clear].into_iter().chain(more)).unwrap();
                }
            }
            pixels.finish_pixel().unwrap();
        }
        pixels.finish().unwrap()
    }

    fn assert_same<T: Transmittance>(
        found: &LayeredPixels<T>,
        expected: &LayeredPixels<T>,
        name: &str,
    ) {
        for pixel in 0..expected.pixel_count() {
            let runs = |of: &LayeredPixels<T>| -> Vec<Vec<Layer<T>>> {
                of.runs(pixel).map(|run| run.layers().collect()).collect()
            };
            assert_eq!(runs(found), runs(expected), "{name}, pixel {pixel}");
        }
    }
}

impl Golden for Layers {
    type Kind = Self;
    const NAME: &'static str = <Self as MapKind>::NAME;

    fn keys() -> KeysOf<Self> {
        Layering { resets: 0, ..LAYERING }.into()
    }

    fn tile<T: Transmittance>(level: u32, rect: TileRect) -> DepthLayers<T> {
        let mut pixels = DepthLayers::clear(rect.width, rect.height, LAYERING.max_layers);
        for [x, y] in places(rect) {
            for layer in 0..(x + y + level) % 4 {
                let depth = 1.0 + layer as f32 / 2.0 + x as f32 / 8.0;
                pixels.insert(SurfaceHit { depth, opacity: halves((layer + 1) as f32 / 4.0) });
            }
            pixels.finish_pixel().unwrap();
        }
        pixels
    }

    fn assert_same<T: Transmittance>(
        found: &DepthLayers<T>,
        expected: &DepthLayers<T>,
        name: &str,
    ) {
        for pixel in 0..expected.pixel_count() {
            assert!(found.layers(pixel).eq(expected.layers(pixel)), "{name}, pixel {pixel}");
        }
    }
}

impl Golden for Fragments {
    type Kind = Self;
    const NAME: &'static str = <Self as MapKind>::NAME;

    fn keys() -> KeysOf<Self> {
        let layering = Layering { resets: 0, ..LAYERING };
        FragmentKeys { layering, coverage: 8, ..FragmentKeys::default() }
    }

    fn tile<T: Transmittance>(level: u32, rect: TileRect) -> FragmentTile<T> {
        let mut columns = FragmentColumns::new();
        for [x, y] in places(rect) {
            let fragment = |layer: u32| Fragment {
                w: 0.125 * (layer + 1) as f32 + y as f32 / 64.0,
                // Strands, and what lies flat: both have no gradient.
                gradient: match (x + layer) % 3 {
                    0 => None,
                    1 => Some([0.0; 2]),
                    _ => Some([x as f32 / 256.0, -(y as f32) / 512.0]),
                },
                opacity: halves((layer + 1) as f32 / 4.0),
                coverage: 0x8040_2010_0804_0201_u64.rotate_left(x + layer) | 1 << (y + 32),
            };
            columns.push_pixel((0..(x + 2 * y + level) % 4).map(fragment)).unwrap();
        }
        FragmentTile::new([rect.width, rect.height], columns).unwrap()
    }

    fn assert_same<T: Transmittance>(
        found: &FragmentTile<T>,
        expected: &FragmentTile<T>,
        name: &str,
    ) {
        let pixels = expected.columns().offsets.len() - 1;
        for pixel in 0..pixels {
            assert!(found.fragments(pixel).eq(expected.fragments(pixel)), "{name}, pixel {pixel}");
        }
    }
}

impl Golden for Media {
    type Kind = Fragments;
    const NAME: &'static str = "fragments-with-media";
    const TOLERANCE: f32 = 0.03125;

    fn keys() -> FragmentKeys {
        let media = Some(MediaKeys { max_slabs: 4 });
        FragmentKeys { media, ..<Fragments as Golden>::keys() }
    }

    fn tile<T: Transmittance>(level: u32, rect: TileRect) -> FragmentTile<T> {
        let mut media = MediaColumns::new();
        for [x, y] in places(rect) {
            let slabs = (2 * x + y + level) % 5;
            let depth = |border: u32| 1.25 + border as f32 / 4.0 + x as f32 / 8.0;
            let thickness = |slab: u32| match slab {
                // The last is never clear.
                2 if slabs > 2 => T::splat(0.0),
                _ => halves(slab as f32 / 8.0 + y as f32),
            };
            let first = (slabs > 0).then(|| (depth(0), T::splat(0.0)));
            let more = (1..=slabs).map(|slab| (depth(slab), thickness(slab)));
            media.push_pixel(first.into_iter().chain(more)).unwrap();
        }
        // Pixels of both, of one of them, and of nothing.
        <Fragments as Golden>::tile::<T>(level, rect).with_media(media).unwrap()
    }

    fn assert_same<T: Transmittance>(
        found: &FragmentTile<T>,
        expected: &FragmentTile<T>,
        name: &str,
    ) {
        <Fragments as Golden>::assert_same(found, expected, name);
        assert!(found.media().is_some() && found.media() == expected.media(), "{name}");
    }
}

impl Golden for Prefiltered {
    type Kind = Self;
    const NAME: &'static str = <Self as MapKind>::NAME;

    fn keys() -> KeysOf<Self> {
        let filtering = Filtering {
            stack_from: Some(1),
            subsampled: 0,
            joined: false,
            epsilon: Epsilon::Widths(2.0),
            accumulate: Accumulate::Add,
            depth: MergedDepth::Mean,
        };
        let layering = Layering { resets: 0, ..LAYERING };
        PrefilteredKeys { layering, filtering, left_out: None }
    }

    /// A MIP level, and a stack whose second level reaches out of the map.
    fn levels() -> Vec<Level> {
        let level = |number, size: [u32; 2], origin: i32| Level {
            number,
            x: origin,
            y: origin,
            ..Level::new(size[0], size[1], 8, 0.0)
        };
        vec![level(1, [6, 5], 0), level(2, [7, 6], 0), level(3, [9, 8], -1), level(4, [7, 6], 0)]
    }

    fn tile<T: Transmittance>(level: u32, rect: TileRect) -> PrefilteredTile<T> {
        let mut lists = FragmentLists::new([rect.width, rect.height]);
        for [x, y] in places(rect) {
            for layer in 0..(2 * x + y + level) % 4 {
                let w = 2.0 / (2.0 + layer as f32 + x as f32 / 16.0);
                lists.push(w, halves((layer + 1 + level % 2) as f32 / 8.0));
            }
            lists.finish_texel().unwrap();
        }
        PrefilteredTile::new(lists)
    }

    fn assert_same<T: Transmittance>(
        found: &PrefilteredTile<T>,
        expected: &PrefilteredTile<T>,
        name: &str,
    ) {
        assert_eq!(found, expected, "{name}");
    }
}

impl Golden for Attenuation {
    type Kind = Self;
    const NAME: &'static str = <Self as MapKind>::NAME;

    fn keys() -> KeysOf<Self> {
        AttenuationKeys { light_samples: 8, depth_tolerance: 1.5 }
    }

    /// There are none.
    fn levels() -> Vec<Level> {
        Vec::new()
    }

    fn tile<T: Transmittance>(_: u32, rect: TileRect) -> FragmentLists<T> {
        let mut lists = FragmentLists::new([rect.width, rect.height]);
        for [x, y] in places(rect) {
            for layer in 0..(3 * x + y) % 4 {
                let w = 2.0 / (2.0 + layer as f32 + y as f32 / 16.0);
                lists.push(w, halves((8 - layer - x % 2) as f32 / 8.0));
            }
            lists.finish_texel().unwrap();
        }
        lists
    }

    fn assert_same<T: Transmittance>(
        found: &FragmentLists<T>,
        expected: &FragmentLists<T>,
        name: &str,
    ) {
        assert_eq!(found, expected, "{name}");
    }
}

impl Golden for Views {
    type Kind = Self;
    const NAME: &'static str = <Self as MapKind>::NAME;

    fn keys() -> KeysOf<Self> {
        ViewsKeys { eyes: vec![[-0.5, 0.25, 0.0], [0.5, 0.25, 0.125]], gap: 3.0 }
    }

    /// The second view.
    fn levels() -> Vec<Level> {
        vec![Level { view: 1, ..Level::new(SIZE[0], SIZE[1], 8, 0.0) }]
    }

    fn tile<T: Transmittance>(level: u32, rect: TileRect) -> ViewTile {
        let w = places(rect).map(|[x, y]| match (x + 2 * y + level) % 5 {
            0 => 0.0,
            step => 1.0 / (2.0 + step as f32 + y as f32 / 16.0),
        });
        ViewTile::new([rect.width, rect.height], w.collect()).unwrap()
    }

    fn assert_same<T: Transmittance>(found: &ViewTile, expected: &ViewTile, name: &str) {
        assert_eq!(found, expected, "{name}");
    }
}

/// A whole file: of these levels, or of level 0 alone.
fn write<G: Golden, T: Transmittance>(packing: Packing, levels: &[Level]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("golden.dsm");
    let info = MapInfo::new().with_tolerance(Tolerance::new(G::TOLERANCE).unwrap());
    let mut metadata = Metadata::new(SIZE[0], SIZE[1], T::CHANNELS as u8, info);
    metadata.software = "golden 1.0".to_owned();
    let options = WriteOptions::default().with_tile_size(8).with_packing(packing);
    let mut writer = KindWriter::<G::Kind>::create(&path, metadata, &G::keys(), options).unwrap();
    for level in levels {
        writer.add_level(*level).unwrap();
    }
    for (index, level) in (0..).zip(writer.levels().to_vec()) {
        let [columns, rows] = level.tiles();
        for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
            let tile = G::tile::<T>(index, level.tile_rect(x, y).unwrap());
            writer.write_tile(TileId::new(index, x, y), &tile, AchievedError::NONE).unwrap();
        }
    }
    writer.finish().unwrap();
    std::fs::read(path).unwrap()
}

fn check<G: Golden, T: Transmittance>(name: &str, packing: Packing, levels: &[Level]) {
    let name = format!("golden/{name}.dsm");
    let bytes = golden::file(&name, || write::<G, T>(packing, levels));
    let reader = KindReader::<G::Kind>::from_bytes(bytes, &Limits::default()).unwrap();
    assert!(reader.verify().is_empty(), "{name}: {:?}", reader.verify());
    assert_eq!(reader.container().version(), [1, 0], "{name}");
    assert_eq!(reader.keys(), &G::keys(), "{name}");
    let metadata = reader.metadata();
    assert_eq!([metadata.width, metadata.height], SIZE, "{name}");
    assert_eq!(metadata.software, "golden 1.0", "{name}");
    assert_eq!(metadata.info.tolerance.epsilon(), G::TOLERANCE, "{name}");
    assert_eq!(reader.levels().len(), 1 + levels.len(), "{name}");
    let mut packed = 0;
    for (index, level) in (0..).zip(reader.levels()) {
        for (id, entry) in reader.directory(index).unwrap().iter() {
            let expected = G::tile::<T>(index, level.tile_rect(id.x, id.y).unwrap());
            G::assert_same(&reader.decode_tile::<T>(id).unwrap(), &expected, &name);
            packed += usize::from(entry.block == 1);
        }
    }
    assert_eq!(packed > 0, packing == Packing::Zstd, "{name}: {packed} packed tiles");
}

fn every_file<G: Golden>() {
    for (packing, of) in PACKINGS {
        check::<G, f32>(&format!("{}_{of}_mono", G::NAME), packing, &[]);
        check::<G, Rgb>(&format!("{}_{of}_rgb", G::NAME), packing, &[]);
    }
    let levels = G::levels();
    if !levels.is_empty() {
        check::<G, f32>(&format!("{}_levels", G::NAME), Packing::Plain, &levels);
    }
}

#[test]
fn multilayer_maps_of_version_1() {
    every_file::<Mtsm>();
}

#[test]
fn multilayer_depth_maps_of_version_1() {
    every_file::<Layers>();
}

#[test]
fn maps_of_views_of_version_1() {
    for (packing, of) in PACKINGS {
        check::<Views, f32>(&format!("views_{of}_mono"), packing, &Views::levels());
    }
}

#[test]
fn attenuation_maps_of_version_1() {
    every_file::<Attenuation>();
}

#[test]
fn prefiltered_maps_of_version_1() {
    every_file::<Prefiltered>();
}

#[test]
fn maps_of_fragments_of_version_1() {
    every_file::<Fragments>();
}

#[test]
fn maps_of_fragments_of_version_2() {
    every_file::<Media>();
}
