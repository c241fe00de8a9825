//! `diff`.

use std::path::{Path, PathBuf};

use dsm_core::MapInfo;
use serde_json::{Value, json};

use crate::maps::{self, Folder, full_info, mono, rgb};
use crate::run;

fn image() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/sample/tuft.exr")
}

#[test]
fn the_worst_pixel_is_named() {
    let folder = Folder::new();
    let a = folder.map("a.dsm", &mono(MapInfo::default()));
    // What falls to 0.1 falls to 0.19 there; the first pixel is (1, 0).
    let b = folder.map("b.dsm", &maps::map(MapInfo::default(), |blocked: f32| 1.0 - 0.9 * blocked));
    let told = run!("diff", a, b, "--json").json();
    let max = told["max"].as_f64().unwrap();
    assert!((max - 0.09).abs() < 1e-7, "{told}");
    assert_eq!(told["worst"], json!({"level": 0, "x": 1, "y": 0, "z": 10.0, "channel": 0}));
    let mean = told["mean"].as_f64().unwrap();
    assert!(mean > 0.01 && mean < max, "{told}");
    let text = run!("diff", a, b).stdout();
    let line = format!("max {max:.9} at pixel (1, 0) of level 0, depth 10, channel 0\n");
    assert_eq!(text, format!("{line}mean {mean:.9}\n"));
    assert_eq!(run!("diff", b, a, "--json", "--threads", "1", "--quiet").json(), told);
}

#[test]
fn equal_maps_have_no_worst_pixel() {
    let folder = Folder::new();
    let a = folder.map("a.dsm", &rgb(full_info()));
    let none = json!({"max": 0.0, "mean": 0.0, "worst": Value::Null});
    assert_eq!(run!("diff", a, a, "--json").json(), none);
    assert_eq!(run!("diff", a, a).stdout(), "no difference\n");
}

#[test]
fn images_are_compared_too() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    run!("convert", image(), map, "--tolerance", "0.01").stdout();
    let told = run!("diff", map, image(), "--json").json();
    let max = told["max"].as_f64().unwrap();
    assert!(max > 0.005 && max < 0.010_001, "{told}");
    assert_eq!(run!("diff", image(), image(), "--json").json()["max"], json!(0.0));
}

#[test]
fn what_cannot_be_compared_is_an_error() {
    let folder = Folder::new();
    let map = folder.map("map.dsm", &mono(MapInfo::default()));
    let coloured = folder.map("coloured.dsm", &rgb(MapInfo::default()));
    let answer = run!("diff", map, image());
    let refusal = answer.refusal();
    let says = "the sizes differ: 7 × 5 and 48 × 48 pixels; bake them with one --resolution";
    assert!(refusal.ends_with(says), "{refusal}");
    assert!(refusal.starts_with(&format!("{} and ", map.display())), "{refusal}");
    assert!(run!("diff", map, coloured).refusal().contains("channels differ: 1 and 3"));
    let missing = run!("diff", map, folder.path("missing.dsm"));
    assert!(missing.refusal().contains("missing.dsm: cannot open"), "{missing:?}");
    let mut bytes = std::fs::read(&map).unwrap();
    bytes[70] ^= 1;
    let damaged = folder.write("damaged.dsm", bytes);
    let damaged = run!("diff", map, damaged);
    assert!(damaged.refusal().contains("damaged.dsm: tile (0, 0)"), "{damaged:?}");
    run!("diff", map).is_wrong_usage("<B>");
    run!("diff", map, map, map).is_wrong_usage("unexpected argument");
}
