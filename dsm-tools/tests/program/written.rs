//! What commands tell of the files they wrote, as JSON.

use std::path::Path;

use serde_json::{Value, json};

use crate::maps::{Folder, full_info, levels, mono, write_levels};
use crate::run;

/// Runs a command with `--json`, with and without `--quiet`, and holds what every
/// document has to the file. Seconds are left out.
#[track_caller]
fn document(arguments: &[&str], output: &Path, size: [u32; 2], channels: u8) -> Value {
    let answer = |more: &[&str]| {
        let answer = run::run(arguments.iter().chain(more));
        let mut told: Value = serde_json::from_str(&answer.stdout).unwrap();
        // What stderr warns of is in the document.
        let warnings = told["warnings"].as_array().map_or(&[][..], Vec::as_slice);
        let lines = warnings.iter().map(|line| format!("warning: {}\n", line.as_str().unwrap()));
        assert_eq!((answer.code, answer.stderr), (0, lines.collect()));
        let keys = told.as_object_mut().unwrap();
        for time in ["scene_s", "bake_s"] {
            assert!(keys.remove(time).is_none_or(|time| time.as_f64().unwrap() >= 0.0));
        }
        // Of this process, where the system tells.
        let peak = keys.remove("peak_bytes");
        assert!(peak.is_none_or(|peak| peak.is_null() || peak.as_u64().unwrap() > 1 << 20));
        told
    };
    let told = answer(&["--json"]);
    assert_eq!(told["output"], json!(output));
    assert_eq!([&told["width"], &told["height"]], [&json!(size[0]), &json!(size[1])]);
    assert_eq!(told["channels"], json!(channels));
    assert_eq!(told["bytes"], json!(output.metadata().unwrap().len()));
    assert_eq!(answer(&["--json", "--quiet"]), told);
    assert_eq!(run::run(arguments.iter().chain(&["--quiet"])).stdout, "");
    told
}

#[test]
fn a_bake_is_told() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    let bake = |more: &[&str]| {
        let base = ["bake", "builtin:spinning-sphere", "-o", map.to_str().unwrap()];
        let size = ["--resolution", "24x16", "--tile", "16"];
        let call: Vec<_> = base.iter().chain(&size).chain(more).copied().collect();
        document(&call, &map, [24, 16], 1)
    };
    let told = bake(&["--samples", "4", "--tolerance", "0.125"]);
    assert_eq!(told["samples"], json!(24 * 16 * 4));
    assert_eq!((&told["tolerance"], &told["cut_pixels"]), (&json!(0.125), &json!(0)));
    assert!(told["hits"].as_u64().unwrap() > 0);
    assert_eq!(told["notes"], json!([]));
    let cut = bake(&["--kind", "fragments", "--coverage", "1", "--layers", "1"]);
    let pixels = cut["cut_pixels"].as_u64().unwrap();
    assert!(pixels > 0, "{cut}");
    let note = format!("{pixels} pixels have more layers than --layers keeps");
    assert_eq!(cut["notes"].as_array().map(Vec::len), Some(1), "{cut}");
    assert!(cut["notes"][0].as_str().is_some_and(|told| told.starts_with(&note)), "{cut}");
}

#[test]
fn a_conversion_is_told() {
    let folder = Folder::new();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../deep-exr/tests/data");
    let source = source.join("scan_rle_opaque.exr");
    let (map, image) = (folder.path("map.dsm"), folder.path("image.exr"));
    let [from, map_name, image_name] = [&source, &map, &image].map(|path| path.to_str().unwrap());
    let size = dsm_io::MapSource::open(&source, None, &dsm_io::Limits::default()).unwrap().size();
    let told = document(&["convert", from, map_name], &map, size, 1);
    assert!(told["samples"].as_u64().unwrap() > 0);
    assert_eq!(
        told["notes"],
        json!(["lost: channels R", "no alpha channel: every sample is taken as opaque"])
    );
    assert!(told.get("max_samples").is_none());
    let told = document(&["convert", map_name, image_name], &image, size, 1);
    assert!(told["max_samples"].as_u64().unwrap() > 0);
    assert!(told["error"].as_f64().unwrap() <= told["allowed"].as_f64().unwrap());
}

#[test]
fn mips_and_products_are_told() {
    let folder = Folder::new();
    let (map, out) = (folder.path("map.dsm"), folder.path("out.dsm"));
    write_levels(&map, &levels(&mono(full_info())));
    let [map_name, out_name] = [&map, &out].map(|path| path.to_str().unwrap());
    let size = crate::maps::SIZE;
    let told = document(&["mip", map_name, "-o", out_name, "--levels", "2"], &out, size, 1);
    assert_eq!((&told["levels"], &told["notes"]), (&json!(2), &json!([])));
    let told = document(&["merge", map_name, map_name, "-o", out_name], &out, size, 1);
    assert_eq!((&told["operation"], &told["maps"]), (&json!("product"), &json!(2)));
    assert_eq!(told["notes"], json!(["lost: 6 smaller levels"]));
    assert!(told["tolerance"].as_f64().is_some());
}
