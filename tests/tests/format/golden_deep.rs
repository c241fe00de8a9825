//! Deep maps of every codec and packing that were written once stay readable, number
//! by number, with their levels, and so does a crop.
//!
//! What the files must hold is computed here, from a pixel's place alone.

use dsm_core::detail::PixelLists;
use dsm_core::{MapInfo, Rgb, Transmittance, Vertex};
use dsm_io::detail::{Crop, Level, MapWriter, TileId, TileRect};
use dsm_io::{AchievedError, Codec, Limits, MapReader, Metadata, Packing, WriteOptions};
use dsm_tests::golden;

use crate::pixels::build;

/// Of level 0, in tiles of 8 × 8: the second row of tiles is one pixel high.
const SIZE: [u32; 2] = [12, 9];

/// Steps and ramps on grids, so that both codecs keep them as they are.
fn pixel<T: Transmittance>(level: u32, [x, y]: [u32; 2]) -> Vec<Vertex<T>> {
    let mut vertices = Vec::new();
    let mut before = T::CLEAR;
    for step in 0..(x + 2 * y + level) % 4 {
        let z = 1.0 + step as f32 / 2.0 + x as f32 / 8.0;
        let shade = |channel: usize| (step + 1) * (x + 2 + channel as u32 * (y % 2));
        let after = T::from_channels(|channel| 1.0 - shade(channel) as f32 / 128.0);
        vertices.push(Vertex::new(z, before));
        vertices.push(Vertex::new(z + if step % 2 == 0 { 0.0 } else { 0.25 }, after));
        before = after;
    }
    vertices
}

fn tile<T: Transmittance>(level: u32, rect: TileRect, first: [u32; 2]) -> PixelLists<T> {
    let places = (rect.y..rect.y + rect.height)
        .flat_map(|y| (rect.x..rect.x + rect.width).map(move |x| [x + first[0], y + first[1]]));
    build(rect.width, rect.height, places.map(|place| pixel(level, place)))
}

/// A file of level 0, or of a crop, and of more levels.
fn write<T: Transmittance>(
    (codec, packing): (Codec, Packing),
    crop: Option<Crop>,
    levels: &[Level],
) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("golden.dsm");
    let mut metadata = Metadata::new(SIZE[0], SIZE[1], T::CHANNELS as u8, MapInfo::default());
    metadata.software = "golden 1.0".to_owned();
    let options = WriteOptions::default().with_tile_size(8).with_codec(codec).with_packing(packing);
    let mut writer = match crop {
        None => MapWriter::create(&path, metadata, options).unwrap(),
        Some(crop) => MapWriter::create_crop(&path, metadata, crop, options).unwrap(),
    };
    for level in levels {
        writer.add_level(*level).unwrap();
    }
    let first = crop.map_or([0; 2], |crop| [crop.x, crop.y]);
    for (index, level) in (0..).zip(writer.levels().to_vec()) {
        let [columns, rows] = level.tiles();
        for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
            let pixels = tile::<T>(index, level.tile_rect(x, y).unwrap(), first);
            let id = TileId::new(index, x, y);
            writer.write_tile(id, pixels.view(), AchievedError::NONE).unwrap();
        }
    }
    writer.finish().unwrap();
    std::fs::read(path).unwrap()
}

fn check<T: Transmittance>(
    name: &str,
    (codec, packing): (Codec, Packing),
    crop: Option<Crop>,
    levels: &[Level],
) {
    let name = format!("golden/{name}.dsm");
    let bytes = golden::file(&name, || write::<T>((codec, packing), crop, levels));
    let reader = MapReader::from_bytes(bytes, &Limits::default()).unwrap();
    assert!(reader.verify().is_empty(), "{name}: {:?}", reader.verify());
    assert_eq!(reader.container().version(), [1, 0], "{name}");
    let whole = reader.whole_metadata();
    assert_eq!([whole.width, whole.height], SIZE, "{name}");
    assert_eq!(whole.software, "golden 1.0", "{name}");
    assert_eq!(reader.crop(), crop, "{name}");
    let first = crop.map_or([0; 2], |crop| [crop.x, crop.y]);
    let (mut packed, mut coded, mut quantized) = (0, 0, 0);
    for (index, level) in (0..).zip(reader.levels()) {
        let map = reader.read_map::<T>(index).unwrap();
        for (x, y) in (0..level.height).flat_map(|y| (0..level.width).map(move |x| (x, y))) {
            let expected = pixel::<T>(index, [x + first[0], y + first[1]]);
            let found: Vec<_> = map.pixel(x, y).vertices().collect();
            assert_eq!(found, expected, "{name}, level {index}, pixel ({x}, {y})");
        }
        for (_, entry) in reader.directory(index).unwrap().iter() {
            packed += usize::from(entry.block == 1);
            coded += usize::from(entry.block == 2);
            quantized += usize::from(entry.codec == 1);
        }
    }
    assert_eq!(packed > 0, packing == Packing::Zstd, "{name}: {packed} packed tiles");
    assert_eq!(coded > 0, packing == Packing::Entropy, "{name}: {coded} coded tiles");
    assert_eq!(quantized > 0, codec == Codec::Quantized, "{name}: {quantized} quantized tiles");
}

#[test]
fn deep_maps_of_version_1() {
    for codec in [Codec::Exact, Codec::Quantized] {
        for (packing, of) in [(Packing::Plain, "plain"), (Packing::Zstd, "zstd")] {
            let name = format!("deep_{}_{of}", codec.name());
            check::<f32>(&format!("{name}_mono"), (codec, packing), None, &[]);
            check::<Rgb>(&format!("{name}_rgb"), (codec, packing), None, &[]);
        }
    }
}

#[test]
fn coded_numbers_of_version_1() {
    let coded = (Codec::Quantized, Packing::Entropy);
    check::<f32>("deep_quantized_entropy_mono", coded, None, &[]);
    check::<Rgb>("deep_quantized_entropy_rgb", coded, None, &[]);
}

#[test]
fn levels_views_and_crops_of_version_1() {
    let level = |view, number, size: [u32; 2]| Level {
        view,
        number,
        ..Level::new(size[0], size[1], 8, 0.0)
    };
    let levels = [level(0, 1, [6, 5]), level(0, 2, [3, 3]), level(1, 0, [4, 10])];
    let plain = (Codec::Exact, Packing::Plain);
    check::<f32>("deep_levels_mono", plain, None, &levels);
    check::<Rgb>("deep_levels_rgb", plain, None, &levels);
    let crop = Crop { x: 8, y: 0, width: 4, height: 9 };
    check::<f32>("deep_crop_mono", plain, Some(crop), &[]);
}
