//! `mip`, and `inspect --level` of what it wrote.

use dsm_core::{MapInfo, Tolerance};
use serde_json::{Value, json};

use crate::maps::{Folder, full_info, mono, rgb};
use crate::run;

fn sizes(told: &Value) -> Vec<[u64; 2]> {
    let levels = told["levels"].as_array().unwrap().iter();
    levels.map(|level| ["width", "height"].map(|side| level[side].as_u64().unwrap())).collect()
}

#[test]
fn a_map_gets_all_levels_within_their_tolerances() {
    let folder = Folder::new();
    let path = folder.path("mip.dsm");
    for (map, channels) in [
        (folder.map("mono.dsm", &mono(full_info())), "channels\":1"),
        (folder.map("rgb.dsm", &rgb(full_info())), "channels\":3"),
    ] {
        let told = run!("mip", map, "-o", path).stdout();
        let bytes = path.metadata().unwrap().len();
        let expected = format!("{}: 7 × 5 pixels, 4 levels, {bytes} bytes\n", path.display());
        assert_eq!(told, expected);
        let told = run!("inspect", path, "--json").stdout();
        assert!(told.contains(channels), "{told}");
        let told: Value = serde_json::from_str(&told).unwrap();
        assert_eq!(sizes(&told), [[7, 5], [4, 3], [2, 2], [1, 1]]);
        for (level, tolerance) in told["levels"].as_array().unwrap().iter().zip([0.02, 0.01, 0.005])
        {
            let stated = level["tolerance"].as_f64().unwrap();
            assert!((stated - tolerance).abs() < 1e-8, "{level}");
            assert!(level["max_error"].as_f64().unwrap() <= stated, "{level}");
            assert!(level["vertices"].as_u64() > Some(0) && level["bytes"].as_u64() > Some(0));
        }
        run!("verify", path).stdout();
        run!("verify", path, "--against", map).stdout();
        let text = run!("inspect", path).stdout();
        let lines: Vec<_> = text.lines().filter(|line| line.contains("1 × 1 ")).collect();
        assert!(lines.len() == 1 && lines[0].trim_start().starts_with("3 "), "{text}");
    }
}

#[test]
fn pixels_of_levels_are_shown() {
    let folder = Folder::new();
    let map = folder.map("map.dsm", &mono(MapInfo::default()));
    run!("mip", map, "-o", map, "--quiet").stdout();
    // Level 1, pixel (0, 0): two clear pixels, one with a step at 2 and a ramp
    // to 10, one with a step at 1 and a ramp to 11.
    let told = run!("inspect", map, "--pixel", "0,0", "--level", "1", "--json").json();
    assert_eq!((&told["x"], &told["y"], &told["level"]), (&json!(0), &json!(0), &json!(1)));
    let vertices: Vec<[f64; 3]> = serde_json::from_value(told["vertices"].clone()).unwrap();
    let [[first, before, after], .., [last, _, end]] = vertices[..] else { panic!("{told}") };
    assert_eq!((first, before, last), (1.0, 1.0, 11.0));
    assert!((after - 0.925).abs() < 1e-4 && (end - 0.55).abs() < 1e-6, "{told}");
    let text = run!("inspect", map, "--pixel", "0,0", "--level", "1").stdout();
    assert!(text.contains("\n  pixel (0, 0) of level 1\n"), "{text}");
    for (arguments, refusal) in [
        (
            ["3,3", "1"],
            "pixel (3, 3) lies outside level 1 of 4 × 3 pixels: columns are 0 to 3, rows 0 to 2",
        ),
        (["0,0", "4"], "there is no level 4: the map has 4, counted from 0"),
    ] {
        let [pixel, level] = arguments;
        let refused = run!("inspect", map, "--pixel", pixel, "--level", level);
        assert_eq!(refused.refusal(), refusal);
    }
    run!("inspect", map, "--level", "1").is_wrong_usage("--pixel");
}

#[test]
fn switches_choose_levels_and_tolerances() {
    let folder = Folder::new();
    let info = MapInfo::new().with_tolerance(Tolerance::new(0.2).unwrap());
    let (map, path) = (folder.map("map.dsm", &mono(info)), folder.path("mip.dsm"));
    let told = |arguments: &[&str]| {
        let arguments = ["mip", map.to_str().unwrap(), "--output", path.to_str().unwrap()]
            .into_iter()
            .chain(arguments.iter().copied());
        run::run(arguments).stdout();
        run!("inspect", path, "--json").json()
    };
    assert_eq!(sizes(&told(&["--levels", "2", "--quiet"])), [[7, 5], [4, 3]]);
    assert_eq!(sizes(&told(&["--levels", "1"])), [[7, 5]]);
    assert_eq!(sizes(&told(&["--levels", "64", "--threads", "3"])).len(), 4);
    let scaled = told(&["--tolerance-scale", "1"]);
    assert_eq!(scaled["levels"][3]["tolerance"], scaled["tolerance"]);
    let floor = told(&["--tolerance-scale", "1e-9"]);
    assert_eq!(floor["levels"][1]["tolerance"].as_f64(), Some(1e-4));
}

#[test]
fn wrong_usage_and_inputs_are_told_apart() {
    let folder = Folder::new();
    let map = folder.map("map.dsm", &mono(MapInfo::default()));
    run!("mip", map).is_wrong_usage("--output");
    run!("mip", map, "-o", "map.exr").is_wrong_usage("must end in .dsm");
    for (switch, value) in [
        ("--levels", "0"),
        ("--tolerance-scale", "0"),
        ("--tolerance-scale", "-1"),
        ("--tolerance-scale", "1.5"),
        ("--threads", "0"),
    ] {
        run!("mip", map, "-o", "a.dsm", switch, value).is_wrong_usage(switch);
    }
    let text = folder.write("text.dsm", "not a map");
    let refused = run!("mip", text, "-o", text);
    assert!(refused.refusal().contains("text.dsm"), "{refused:?}");
    assert_eq!(std::fs::read(&text).unwrap(), b"not a map");
    let refused = run!("mip", map, "-o", folder.path("no/folder.dsm"));
    assert!(refused.refusal().contains("folder.dsm"), "{refused:?}");
}
