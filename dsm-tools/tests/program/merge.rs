//! `merge`.

use std::path::Path;

use dsm_core::{MapInfo, PixelListsBuilder, Vertex};
use dsm_io::detail::{Crop, MapWriter, TileId};
use dsm_io::{AchievedError, Metadata, WriteOptions};
use serde_json::{Value, json};

use crate::maps::{Folder, full_info, mono, rgb};
use crate::run;

fn description(map: &Path) -> Value {
    run!("inspect", map, "--json", "--pixel", "6,4").json()
}

#[test]
fn maps_of_the_same_pixels_are_multiplied() {
    let folder = Folder::new();
    let (a, b) = (folder.map("a.dsm", &mono(full_info())), folder.map("b.dsm", &rgb(full_info())));
    let out = folder.path("out.dsm");
    let told = run!("merge", a, b, a, "-o", out).stdout();
    let first = format!("{}: 7 × 5 pixels, RGB, ", out.display());
    assert!(told.starts_with(&first), "{told}");
    assert!(told.ends_with(" bytes\n  the product of 3 maps, within 0.060000\n"), "{told}");
    let merged = description(&out);
    let last = merged["vertices"].as_array().unwrap().last().unwrap()[2].clone();
    let left: Vec<f64> = serde_json::from_value(last).unwrap();
    // 0.1 is left behind the mono map, and a share behind the coloured one.
    for (left, share) in left.iter().zip([0.1, 0.55, 0.91]) {
        assert!((left - 0.01 * share).abs() < 1e-8, "{merged}");
    }
    for field in ["camera", "samples", "filter", "data_window", "attributes", "tile", "block"] {
        assert_eq!(merged[field], description(&a)[field], "{field}");
    }
    run!("verify", out).stdout();

    // The output may be an input, and compression costs what it may.
    run!("merge", out, a, "-o", out, "--tolerance", "0.125", "--quiet").stdout();
    let stated = description(&out)["tolerance"].as_f64().unwrap();
    assert!((stated - 0.205).abs() < 1e-6, "{stated}");
}

fn write_crop(path: &Path, crop: Crop) {
    let whole = Metadata::new(8, 4, 1, MapInfo::default());
    let options = WriteOptions::default().with_tile_size(4);
    let mut writer = MapWriter::create_crop(path, whole, crop, options).unwrap();
    let [columns, _] = writer.levels()[0].tiles();
    for x in 0..columns {
        let mut pixels = PixelListsBuilder::<f32>::new(4, 4);
        for pixel in 0..16_u8 {
            let z = crop.x as f32 + x as f32 * 4.0 + f32::from(pixel) / 16.0;
            pixels.push(Vertex::new(z, 1.0));
            pixels.push(Vertex::new(z, 0.5));
            pixels.finish_pixel().unwrap();
        }
        let pixels = pixels.finish().unwrap();
        writer.write_tile(TileId::new(0, x, 0), pixels.view(), AchievedError::NONE).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn crops_are_put_together() {
    let folder = Folder::new();
    let path = |name: &str| folder.path(name);
    write_crop(&path("whole.dsm"), Crop { x: 0, y: 0, width: 8, height: 4 });
    write_crop(&path("left.dsm"), Crop { x: 0, y: 0, width: 4, height: 4 });
    write_crop(&path("right.dsm"), Crop { x: 4, y: 0, width: 4, height: 4 });
    let out = path("out.dsm");
    let told = run!("merge", path("right.dsm"), path("left.dsm"), "-o", out).stdout();
    assert!(told.contains("8 × 4 pixels, mono, "), "{told}");
    assert!(told.ends_with("\n  put together of 2 crops\n"), "{told}");
    assert!(std::fs::read(&out).unwrap() == std::fs::read(path("whole.dsm")).unwrap());
    // A crop is a map of its own that knows its place.
    let right = run!("inspect", path("right.dsm"), "--json").json();
    assert_eq!(right["data_window"], json!({"min": [4, 0], "max": [7, 3]}));
    run!("verify", path("right.dsm")).stdout();

    let old = std::fs::read(&out).unwrap();
    let left = path("left.dsm");
    let answer = run!("merge", left, path("right.dsm"), "-o", out, "--tolerance", "0.1");
    assert!(answer.refusal().contains("a tolerance has no use"), "{answer:?}");
    let answer = run!("merge", left, path("whole.dsm"), "-o", out);
    let says = "these have 4 × 4 pixels at (0, 0) of 8 × 4, 8 × 4 pixels";
    assert!(answer.refusal().ends_with(says), "{answer:?}");
    assert!(std::fs::read(&out).unwrap() == old);
}

#[test]
fn what_cannot_be_merged_is_an_error() {
    let folder = Folder::new();
    let map = folder.map("map.dsm", &mono(full_info()));
    let out = folder.path("out.dsm");
    let mut moved = full_info();
    moved.camera = moved.camera.map(|mut camera| {
        camera.world_to_ndc = camera.world_to_camera;
        camera
    });
    let moved = folder.map("moved.dsm", &mono(moved));
    let answer = run!("merge", map, moved, "-o", out);
    assert!(answer.refusal().contains("moved.dsm: its camera differs"), "{answer:?}");
    let missing = run!("merge", map, folder.path("missing.dsm"), "-o", out);
    assert!(missing.refusal().contains("missing.dsm: cannot open"), "{missing:?}");
    let mut bytes = std::fs::read(&map).unwrap();
    bytes[70] ^= 1;
    let damaged = folder.write("damaged.dsm", bytes);
    let answer = run!("merge", map, damaged, "-o", out);
    assert!(answer.refusal().contains("damaged.dsm: tile (0, 0)"), "{answer:?}");
    assert!(!out.exists());
    let alone = run!("merge", map, "-o", out);
    assert!(alone.refusal().contains("it needs another one of the same pixels"), "{alone:?}");
    run!("merge", map, map).is_wrong_usage("--output");
    run!("merge", map, map, "-o", "out.exr").is_wrong_usage(".dsm");
    run!("merge", map, map, "-o", out, "--tolerance", "1").is_wrong_usage("--tolerance");
}

#[test]
fn the_help_says_where_products_are_exact() {
    let help = run!("merge", "--help").stdout();
    let words = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("merge is exact where coverage is uncorrelated"), "{words}");
    assert!(
        words.contains("two opaque halves of one pixel multiply to ¼, truth ½ or 0"),
        "{words}"
    );
}
