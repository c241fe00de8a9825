//! `convert`, and `verify --against` what was converted.

use std::path::{Path, PathBuf};

use dsm_core::MapInfo;
use serde_json::{Value, json};

use crate::maps::{self, Folder, full_info, mono, rgb};
use crate::run;

/// 48 × 48 pixels: points and volumes in one tile, and a camera.
fn image() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/sample/tuft.exr")
}

/// One of the small images that the reader's tests have.
fn small(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../deep-exr/tests/data").join(name)
}

fn description(map: &Path) -> Value {
    run!("inspect", map, "--json").json()
}

#[test]
fn images_become_maps_within_the_tolerance() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    for tolerance in ["0", "0.002", "0.01", "0.1"] {
        let told = run!("convert", image(), map, "--tolerance", tolerance).stdout();
        assert!(told.starts_with(&format!("{}: 48 × 48 pixels, mono, ", map.display())), "{told}");
        let stated = description(&map);
        assert_eq!(
            stated["tolerance"].to_string(),
            format!("{:?}", tolerance.parse::<f32>().unwrap())
        );
        assert!(
            stated["levels"][0]["max_error"].as_f64()
                <= stated["tolerance"].as_f64().map(|e| e + 1e-6)
        );
        run!("verify", map, "--against", image()).stdout();
    }
}

#[test]
fn what_the_switches_say_is_in_the_file() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    run!("convert", image(), map).stdout();
    let told = description(&map);
    for (name, value) in [
        ("tile", json!(64)),
        ("block", json!("zstd")),
        ("codec", json!("exact")),
        ("tolerance", json!(0.0)),
    ] {
        assert_eq!(told[name], value, "{name}");
    }
    let packed = map.metadata().unwrap().len();
    run!("convert", image(), map, "--block", "none", "--tile", "5").stdout();
    let told = description(&map);
    assert_eq!((&told["tile"], &told["block"]), (&json!(5), &json!("none")));
    assert!(map.metadata().unwrap().len() > packed);
}

#[test]
fn maps_are_copied_or_compressed_once_more() {
    let folder = Folder::new();
    for (name, source) in [
        ("mono.dsm", folder.map("mono.dsm", &mono(full_info()))),
        ("rgb.dsm", folder.map("rgb.dsm", &rgb(full_info()))),
    ] {
        let pixel = |map: &Path| run!("inspect", map, "--json", "--pixel", "6,4").json();
        let copy = folder.path(&format!("copy of {name}"));
        run!("convert", source, copy, "--tile", "3").stdout();
        let (was, is) = (pixel(&source), pixel(&copy));
        for field in
            ["vertices", "tolerance", "camera", "samples", "filter", "attributes", "data_window"]
        {
            assert_eq!(was[field], is[field], "{field}");
        }
        run!("convert", copy, copy, "--tolerance", "0.01").stdout();
        let told = description(&copy);
        assert!((told["tolerance"].as_f64().unwrap() - 0.03).abs() < 1e-6, "{told}");
        run!("verify", copy, "--against", source).stdout();
    }
}

#[test]
fn threads_change_no_byte() {
    let folder = Folder::new();
    let bytes = |threads| {
        let map = folder.path("map.dsm");
        run!("convert", image(), map, "--tile", "4", "--tolerance", "0.01", "--threads", threads)
            .stdout();
        std::fs::read(map).unwrap()
    };
    assert_eq!(bytes("1"), bytes("3"));
}

#[test]
fn what_is_lost_is_said() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    let told = run!("convert", small("tile_zips_ids.exr"), map).stdout();
    assert!(told.contains("\n  lost: channels "), "{told}");
    let told = run!("convert", small("scan_rle_opaque.exr"), map).stdout();
    assert!(told.contains("\n  no alpha channel: every sample is taken as opaque\n"), "{told}");
    assert_eq!(run!("convert", small("scan_rle_opaque.exr"), map, "--quiet").stdout(), "");
}

#[test]
fn contents_tell_what_a_file_is() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    let odd = folder.write("image.dsm", std::fs::read(image()).unwrap());
    run!("convert", odd, map).stdout();
    run!("verify", map, "--against", image()).stdout();
    run!("convert", small("flat_zip.exr"), map).stdout();
    run!("verify", map, "--against", small("flat_zip.exr")).stdout();
}

#[test]
fn parts_are_chosen_by_name() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    let none = run!("convert", small("parts.exr"), map, "--part", "no such part");
    let refusal = none.refusal();
    assert!(refusal.contains("no part is named 'no such part'"), "{refusal}");
    assert!(!map.exists());
    run!("verify", map, "--part", "left").is_wrong_usage("--against");
    let of_map = folder.map("mono.dsm", &mono(MapInfo::default()));
    let refusal = run!("convert", of_map, map, "--part", "left");
    assert!(refusal.refusal().contains("no parts"), "{refusal:?}");
}

#[test]
fn a_map_of_something_else_breaks_its_bound() {
    let folder = Folder::new();
    let map = folder.map("map.dsm", &mono(MapInfo::default()));
    let darker = maps::map(MapInfo::default(), |blocked: f32| 1.0 - 1.1 * blocked);
    let darker = folder.map("darker.dsm", &darker);
    let answer = run!("verify", map, "--against", darker, "--json");
    let refusal = answer.refusal();
    assert!(
        refusal.starts_with("1 of 1 files failed: against ") && refusal.contains("off by 0.09"),
        "{refusal}"
    );
    let told: Value = serde_json::from_str(&answer.stdout).unwrap();
    assert_eq!((&told["ok"], &told["files"][0]["ok"]), (&json!(false), &json!(false)));
    let size = run!("verify", map, "--against", image());
    assert!(size.refusal().contains("the sizes differ"), "{size:?}");
    let channels = folder.map("rgb.dsm", &rgb(MapInfo::default()));
    let channels = run!("verify", map, "--against", channels);
    assert!(channels.refusal().contains("channels differ"), "{channels:?}");
    let missing = run!("verify", map, "--against", folder.path("missing.exr"));
    assert!(missing.refusal().contains("missing.exr: cannot open"), "{missing:?}");
}

#[test]
fn a_failure_leaves_what_was_there() {
    let folder = Folder::new();
    let old = folder.write("map.dsm", "old");
    let mut cut = std::fs::read(image()).unwrap();
    cut.truncate(cut.len() - 100);
    let cut = folder.write("cut.exr", cut);
    let answer = run!("convert", cut, old);
    assert!(answer.refusal().contains("cut.exr"), "{answer:?}");
    assert_eq!(std::fs::read(&old).unwrap(), b"old");
    let nowhere = run!("convert", image(), folder.path("no/map.dsm"));
    assert!(nowhere.refusal().contains("map.dsm"), "{nowhere:?}");
    let text = folder.write("text.exr", "no image");
    assert!(run!("convert", text, old).refusal().contains("text.exr: not a .dsm"));
    let left: Vec<_> = std::fs::read_dir(folder.path("")).unwrap().collect();
    assert_eq!(left.len(), 3, "{left:?}");
}

#[test]
fn outputs_are_maps_or_images() {
    let folder = Folder::new();
    let answer = run!("convert", image(), folder.path("out.exr"));
    assert!(answer.refusal().ends_with("make a .dsm of it first"), "{answer:?}");
    assert!(!folder.path("out.exr").exists());
    run!("convert", "a.exr", "a.tif").is_wrong_usage(".dsm or .exr");
    run!("convert", "a.exr").is_wrong_usage("OUT");
    for (switch, value) in [
        ("--tolerance", "1"),
        ("--tolerance", "-0.1"),
        ("--tile", "0"),
        ("--tile", "5000"),
        ("--block", "gzip"),
        ("--codec", "quantized"),
        ("--codec", "half"),
        ("--depth-error", "0.1"),
        ("--depth-error", "0"),
        ("--exr-layout", "scanline"),
        ("--exr-type", "float"),
        ("--exr-compression", "none"),
    ] {
        run!("convert", "a.exr", "a.dsm", switch, value).is_wrong_usage(switch);
    }
    for (switch, value) in [
        ("--tolerance", "0.0000005"),
        ("--tile", "16"),
        ("--block", "zstd"),
        ("--codec", "exact"),
        ("--depth-error", "0.1"),
        ("--exr-layout", "rows"),
        ("--exr-type", "uint"),
        ("--exr-compression", "zip"),
    ] {
        run!("convert", "a.dsm", "a.EXR", switch, value).is_wrong_usage(switch);
    }
    for switch in ["--method", "--side", "--target-size"] {
        run!("convert", "a.exr", "a.dsm", switch, "exact").is_wrong_usage(switch);
    }
}

#[test]
fn maps_become_images_that_let_the_same_light_through() {
    let folder = Folder::new();
    let (map, out) = (folder.path("map.dsm"), folder.path("out.exr"));
    run!("convert", image(), map).stdout();
    let told = run!("convert", map, out).stdout();
    assert!(told.starts_with(&format!("{}: 48 × 48 pixels, mono, ", out.display())), "{told}");
    assert!(told.contains(" samples, at most ") && told.contains("1e-5 allowed"), "{told}");
    run!("verify", map, "--against", out).stdout();
    let mut sizes = Vec::new();
    for switches in [
        ["--exr-layout", "tiled", "--tile", "16", "--exr-compression", "none"],
        ["--exr-layout", "scanline", "--exr-type", "float", "--exr-compression", "rle"],
        ["--exr-layout", "scanline", "--exr-type", "half", "--exr-compression", "zips"],
        ["--exr-layout", "scanline", "--exr-type", "half", "--exr-compression", "zstd"],
    ] {
        let arguments = [map.as_os_str(), out.as_os_str()].map(ToOwned::to_owned);
        let switches = switches.map(Into::into);
        let all = ["convert".into()].into_iter().chain(arguments).chain(switches);
        let told = run::run(all.collect::<Vec<std::ffi::OsString>>()).stdout();
        assert!(told.contains(" samples, at most "), "{told}");
        sizes.push(out.metadata().unwrap().len());
    }
    assert!(sizes[0] > sizes[1] && sizes[1] > sizes[2], "{sizes:?}");
    assert_eq!(run!("convert", map, out, "--quiet").stdout(), "");
}

#[test]
fn half_opacities_say_how_far_they_are_off() {
    let folder = Folder::new();
    let (map, out) = (folder.path("map.dsm"), folder.path("out.exr"));
    run!("convert", image(), map, "--tolerance", "0.01").stdout();
    let told = run!("convert", map, out, "--exr-type", "half").stdout();
    assert!(told.contains("\n  more than allowed: half opacities are too coarse"), "{told}");
    let told = run!("convert", map, out, "--exr-type", "half", "--tolerance", "0.001").stdout();
    assert!(!told.contains("more than allowed"), "{told}");
    let stated = description(&map)["tolerance"].as_f64().unwrap();
    assert!(told.contains(&format!("; {:.6} in all", stated + 0.001)), "{told}");
}

/// An image from beside the project, or `None` and a message.
fn given(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/cases/deep").join(name);
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}

#[test]
fn channels_in_layers_are_found_and_said() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    // Whether there are opacities, and whether any of them lets some of the light through.
    for (name, line, has_alpha, lets_some_through) in [
        (
            "layer_prefix.exr",
            "depth from 'beauty.Z', back depth from 'beauty.ZBack', opacity from 'beauty.A'",
            true,
            true,
        ),
        ("dot_prefix.exr", "depth from '.Z', opacity from '.A'", true, true),
        ("layer_prefix_alpha_only.exr", "opacity from 'RGBA.A'", true, true),
        (
            "flat_blender_multilayer.exr",
            "depth from 'ViewLayer.Depth.Z', opacity from 'ViewLayer.Combined.A'",
            true,
            false,
        ),
        ("flat_blender_V.exr", "depth from 'V'", false, false),
    ] {
        let Some(image) = given(name) else { return };
        let told = run!("convert", image, map, "--tolerance", "0").stdout();
        assert!(told.contains(&format!("\n  {line}\n")), "{name}: {told}");
        assert_eq!(told.contains("no alpha channel"), !has_alpha, "{name}: {told}");
        run!("verify", map, "--against", image).stdout();
        let steps: Vec<f64> = (0..9)
            .flat_map(|x| {
                let told = run!("inspect", map, "--json", "--pixel", format!("{x},4")).json();
                let vertices = told["vertices"].as_array().cloned().unwrap_or_default();
                // Each is a depth, and the light before and behind it.
                vertices.into_iter().filter_map(|vertex| vertex[2].as_f64())
            })
            .collect();
        let is_partial = steps.iter().any(|&left| left > 0.0 && left < 1.0);
        assert_eq!(is_partial, lets_some_through, "{name}: {steps:?}");
    }
}

#[test]
fn a_layer_or_channels_are_chosen() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    let Some(image) = given("layer_prefix.exr") else { return };
    let plain = run!("convert", image, map).stdout();
    let chosen = run!("convert", image, map, "--layer", "beauty").stdout();
    assert_eq!(plain, chosen);
    let refusal = run!("convert", image, map, "--layer", "specular");
    let refusal = refusal.refusal();
    assert!(refusal.contains("'specular' has no depth") && refusal.contains("beauty.A beauty.Z"));
    let told = run!("convert", image, map, "--channels", "Z=beauty.ZBack,A=").stdout();
    assert!(told.contains("depth from 'beauty.ZBack'") && told.contains("no alpha"), "{told}");
    assert!(told.contains("lost: channels beauty.A, beauty.Z\n"), "{told}");
    run!("verify", map, "--against", image, "--channels", "Z=beauty.ZBack,A=").stdout();
    let wrong = run!("verify", map, "--against", image);
    assert!(wrong.refusal().contains("against"), "{wrong:?}");
    run!("verify", map, "--layer", "beauty").is_wrong_usage("--against");
    run!("convert", image, map, "--channels", "Q=beauty.Z").is_wrong_usage("none of Z, ZBack");
    let of_map = folder.map("mono.dsm", &mono(MapInfo::default()));
    let refusal = run!("convert", of_map, map, "--layer", "left");
    assert!(refusal.refusal().contains("no parts, layers or channels"), "{refusal:?}");
}
