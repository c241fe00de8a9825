//! Parts of a map in files of their own, and the whole again.

use std::path::Path;

use dsm_core::detail::{PixelLists, PixelWindow};
use dsm_core::{MapInfo, Progress, Tolerance, Transmittance, Vertex};
use dsm_io::detail::{Container, ContainerWriter, Crop, EncodedTile, Level, MapWriter, TileId};
use dsm_io::{
    AchievedError, Limits, MapReader, MergeReport, Metadata, Packing, PyramidOptions, WriteOptions,
    mip,
};

use super::{info, merge, metadata, open, refusal};
use crate::pixels::build;

const TILE: u32 = 4;

/// 19 × 13 pixels, tiles of 4 × 4; the last column of tiles is empty.
fn pixels() -> PixelLists<f32> {
    build(
        19,
        13,
        (0..13_u8).flat_map(|y| (0..19_u8).map(move |x| (x, y))).map(|(x, y)| {
            let near = 1.0 + f32::from(x);
            let far = vec![Vertex::new(near, 1.0), Vertex::new(near + f32::from(y), 0.3)];
            if x < 16 { far } else { Vec::new() }
        }),
    )
}

/// The pixels of a rectangle.
fn part<T: Transmittance>(
    pixels: &PixelLists<T>,
    [x, y, width, height]: [u32; 4],
) -> PixelLists<T> {
    let all = (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y)));
    build(width, height, all.map(|(x, y)| pixels.view().pixel(x, y).vertices().collect()))
}

/// Writes the tiles of `crop`, each with an error of its own.
fn write_tiles(mut writer: MapWriter, pixels: &PixelLists<f32>, crop: Crop, packing: Packing) {
    let level = writer.levels()[0];
    let [columns, rows] = level.tiles();
    for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
        let rect = level.tile_rect(x, y).unwrap();
        let place = [crop.x + rect.x, crop.y + rect.y];
        let tile = part(pixels, [place[0], place[1], rect.width, rect.height]);
        let error = (place[0] + place[1]) as f32 / 4096.0;
        let error = AchievedError { max: error, mean: error / 4.0 };
        let encoded = EncodedTile::encode(tile.view(), Default::default(), packing).unwrap();
        writer.write_encoded(TileId::new(0, x, y), &encoded, error).unwrap();
    }
    writer.finish().unwrap();
}

fn options() -> WriteOptions {
    WriteOptions::default().with_tile_size(TILE)
}

fn write_crop(path: &Path, whole: &Metadata, crop: Crop, packing: Packing) -> MapReader {
    let writer = MapWriter::create_crop(path, whole.clone(), crop, options()).unwrap();
    write_tiles(writer, &pixels(), crop, packing);
    open(path)
}

fn write_whole(path: &Path, whole: &Metadata, packing: Packing) -> Vec<u8> {
    let writer = MapWriter::create(path, whole.clone(), options()).unwrap();
    let crop = Crop { x: 0, y: 0, width: whole.width, height: whole.height };
    write_tiles(writer, &pixels(), crop, packing);
    open(path);
    std::fs::read(path).unwrap()
}

fn crop(x: u32, y: u32, width: u32, height: u32) -> Crop {
    Crop { x, y, width, height }
}

/// Four parts that meet at tile borders.
const PARTS: [Crop; 4] = [
    Crop { x: 0, y: 0, width: 12, height: 8 },
    Crop { x: 12, y: 0, width: 7, height: 4 },
    Crop { x: 12, y: 4, width: 7, height: 9 },
    Crop { x: 0, y: 8, width: 12, height: 5 },
];

#[test]
fn crops_put_together_are_the_whole_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let known = info(0.0625).with_samples(16);
    for (packing, info) in [(Packing::Plain, info(0.0625)), (Packing::Zstd, known)] {
        let metadata = metadata(&pixels(), info);
        let whole = write_whole(&path("whole.dsm"), &metadata, packing);
        let crops = (0..).zip(PARTS).map(|(index, part): (u8, _)| {
            write_crop(&path(&format!("{index}.dsm")), &metadata, part, packing)
        });
        let mut crops: Vec<_> = crops.collect();
        for _ in 0..crops.len() {
            let report = merge(&crops, &path("merged.dsm"), 0.0);
            assert_eq!(report, MergeReport::Assembled);
            assert!(std::fs::read(path("merged.dsm")).unwrap() == whole, "{packing:?}");
            crops.rotate_left(1);
        }
        assert_eq!(open(&path("merged.dsm")).crop(), None);
    }
}

#[test]
fn a_crop_is_a_map_of_its_own_that_knows_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("crop.dsm");
    let window = |min, max| Some(PixelWindow { min, max });
    let place = crop(12, 4, 7, 9);
    for (data, display, then_display) in [
        (None, None, window([0, 0], [18, 12])),
        (window([-5, 2], [13, 14]), None, window([-5, 2], [13, 14])),
        (window([-5, 2], [13, 14]), window([0, 0], [99, 49]), window([0, 0], [99, 49])),
    ] {
        let mut info = info(0.0625);
        (info.data_window, info.display_window) = (data, display);
        let whole = metadata(&pixels(), info);
        let reader = write_crop(&path, &whole, place, Packing::Plain);
        assert_eq!((reader.crop(), reader.whole_metadata()), (Some(place), &whole));
        let own = reader.metadata();
        assert_eq!([own.width, own.height], [7, 9]);
        let corner = data.map_or([0, 0], |window| window.min);
        let min = [corner[0] + 12, corner[1] + 4];
        assert_eq!(own.info.data_window, window(min, [min[0] + 6, min[1] + 8]));
        assert_eq!(own.info.display_window, then_display);
        let map = reader.read_map::<f32>(0).unwrap();
        assert_eq!(map.pixels(), &part(&pixels(), [12, 4, 7, 9]));
        assert_eq!(map.info(), &own.info);
    }
    let far = PixelWindow { min: [i32::MAX - 12, 0], max: [i32::MAX, 12] };
    let far = info(0.0).with_data_window(far);
    let writer = MapWriter::create_crop(&path, metadata(&pixels(), far), place, options()).unwrap();
    writer.finish().unwrap();
    let refused = MapReader::open(&path, &Limits::default()).unwrap_err().to_string();
    assert!(refused.contains("reaches past 2³¹"), "{refused}");
}

#[test]
fn a_part_of_a_map_has_no_pyramid() {
    let folder = tempfile::tempdir().unwrap();
    let metadata = metadata(&pixels(), info(0.0625));
    // The first begins where the map does.
    for part in PARTS {
        let map = write_crop(&folder.path().join("crop.dsm"), &metadata, part, Packing::Plain);
        let output = folder.path().join("mip.dsm");
        let refused = mip(&map, &output, &PyramidOptions::default(), Progress::ignore).unwrap_err();
        assert!(refused.to_string().contains("crop.dsm: it is a part of a map"), "{refused}");
        assert!(!output.exists());
    }
}

#[test]
fn crops_end_on_tiles_or_at_the_edge() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("crop.dsm");
    let whole = metadata(&pixels(), info(0.0));
    let created = |crop| MapWriter::create_crop(&path, whole.clone(), crop, options());
    for good in [crop(0, 0, 4, 4), crop(16, 12, 3, 1), crop(4, 0, 15, 13), crop(0, 0, 19, 13)] {
        let mut writer = created(good).unwrap();
        let second = writer.add_level(Level { number: 1, ..Level::new(1, 1, 1, 0.0) });
        assert_eq!(second.is_ok(), good == crop(0, 0, 19, 13), "{good:?}");
    }
    for wrong in [
        crop(1, 0, 4, 4),
        crop(0, 2, 4, 4),
        crop(0, 0, 5, 4),
        crop(0, 0, 4, 12 + 2),
        crop(16, 0, 4, 4),
        crop(20, 0, 4, 4),
        crop(0, 0, 0, 4),
        crop(u32::MAX - 3, 0, 4, 4),
        crop(4, 0, u32::MAX - 3, 4),
    ] {
        assert!(created(wrong).is_err(), "{wrong:?}");
    }
    assert!(!path.exists());
}

/// What another program may have written.
#[test]
fn readers_refuse_parts_that_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("crop.dsm");
    let whole = Metadata::new(8, 8, 1, MapInfo::default());
    let base = Level { x: 4, ..Level::new(4, 8, TILE, 0.0) };
    let second = Level { number: 1, ..Level::new(2, 4, TILE, 0.0) };
    for (levels, says) in [
        (vec![base], ""),
        (vec![Level { x: -4, ..base }], "not those of a map"),
        (vec![Level { x: 8, ..base }], "not those of a map"),
        (vec![Level { x: 2, ..base }], "does not end on a tile's border"),
        (vec![Level { x: 0, width: 3, ..base }], "does not end on a tile's border"),
        (vec![base, second], "a part of a map has one level"),
    ] {
        let mut writer = ContainerWriter::create(&path).unwrap();
        for level in &levels {
            writer.add_level(*level).unwrap();
        }
        writer.finish(&whole.to_json().unwrap()).unwrap();
        let container = Container::open(&path, &Limits::default()).unwrap();
        match MapReader::new(container, &Limits::default()) {
            Ok(_) => assert_eq!(says, "", "{levels:?}"),
            Err(error) => {
                let error = error.to_string();
                assert!(!says.is_empty() && error.contains(says), "{error}");
            }
        }
    }
}

#[test]
fn crops_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let whole = metadata(&pixels(), info(0.0625));
    let of = |name: &str, crop| write_crop(&path(name), &whole, crop, Packing::Plain);
    let [first, second, third, fourth] = PARTS;
    let all = || {
        [("a", first), ("b", second), ("c", third), ("d", fourth)]
            .map(|(name, part)| of(&format!("{name}.dsm"), part))
    };
    let missing = refusal(&all()[..3], None);
    assert!(missing.ends_with("no crop holds the pixels from (0, 8) on"), "{missing}");
    let mut twice: Vec<_> = all().into();
    twice.push(of("e.dsm", crop(8, 4, 8, 4)));
    let twice = refusal(&twice, None);
    assert!(twice.contains("e.dsm: it holds pixels that another crop holds"), "{twice}");
    let tolerance = refusal(&all(), Some(Tolerance::EXACT));
    assert!(tolerance.contains("a tolerance has no use"), "{tolerance}");

    let mut other: Vec<_> = all().into();
    let of_another = metadata(&pixels(), info(0.0625).with_samples(2));
    other[2] = write_crop(&path("f.dsm"), &of_another, third, Packing::Plain);
    let other = refusal(&other, None);
    assert!(other.contains("f.dsm: its metadata differ from another map's"), "{other}");
    let mut other: Vec<_> = all().into();
    let options = WriteOptions::default().with_tile_size(1);
    let writer = MapWriter::create_crop(path("g.dsm"), whole.clone(), third, options);
    writer.unwrap().finish().unwrap();
    other[2] = open(&path("g.dsm"));
    let other = refusal(&other, None);
    assert!(other.contains("g.dsm: its tile sizes differ"), "{other}");

    let map = MapWriter::create(path("h.dsm"), whole.clone(), self::options()).unwrap();
    map.finish().unwrap();
    let mixed = refusal(&[of("a.dsm", first), open(&path("h.dsm"))], None);
    let says = "these have 12 × 8 pixels at (0, 0) of 19 × 13, 19 × 13 pixels";
    assert!(mixed.ends_with(says), "{mixed}");
}

/// Crops of two maps multiply to crops of the product.
#[test]
fn a_product_of_crops_is_a_crop_of_the_product() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: String| folder.path().join(name);
    let whole = metadata(&pixels(), info(0.0625));
    write_whole(&path("whole.dsm".into()), &whole, Packing::Zstd);
    let maps = [open(&path("whole.dsm".into())), open(&path("whole.dsm".into()))];
    merge(&maps, &path("product.dsm".into()), 0.01);
    let crops: Vec<_> = (0..)
        .zip(PARTS)
        .map(|(index, part): (u8, _)| {
            let name = path(format!("{index}.dsm"));
            let twice = [(); 2].map(|()| write_crop(&name, &whole, part, Packing::Zstd));
            merge(&twice, &name, 0.01);
            let product = open(&name);
            assert_eq!(product.crop(), Some(part));
            product
        })
        .collect();
    merge(&crops, &path("assembled.dsm".into()), 0.0);
    let [product, assembled] =
        ["product.dsm", "assembled.dsm"].map(|name| std::fs::read(path(name.into())).unwrap());
    assert!(product == assembled);
}
