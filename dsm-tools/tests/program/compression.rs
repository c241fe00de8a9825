//! Compressors and sides of `bake`, `convert`, `mip` and `merge`.

use serde_json::{Value, json};

use crate::maps::Folder;
use crate::run;

/// What `inspect` tells of a map.
fn inspected(map: &std::path::Path) -> Value {
    run!("inspect", map, "--json").json()
}

#[test]
fn fewest_vertices_are_within_the_tolerance_and_stated() {
    let folder = Folder::new();
    let [exact, greedy, fewest] = ["exact", "greedy", "fewest"].map(|name| folder.path(name));
    let bake = ["--resolution", "48", "--samples", "64", "--quiet"];
    let [exact, greedy, fewest] = [exact, greedy, fewest].map(|path| path.with_extension("dsm"));
    for (map, switches) in [
        (&exact, vec!["--tolerance", "0"]),
        (&greedy, vec!["--method", "greedy"]),
        (&fewest, vec!["--method", "min-link"]),
    ] {
        let mut arguments = vec!["bake".into(), "builtin:hairball".into(), "-o".into()];
        arguments.push(map.clone().into_os_string());
        arguments.extend(bake.iter().chain(&switches).map(std::ffi::OsString::from));
        crate::run::run(arguments).stdout();
    }
    let vertices = |map| inspected(map)["contents"]["vertices"].as_u64().unwrap();
    let [few, many] = [&fewest, &greedy].map(|map| vertices(map));
    assert!(few * 100 < many * 80, "{few} of {many}");
    assert_eq!(inspected(&fewest)["compression"], json!({"method": "min-link", "side": "both"}));
    assert_eq!(inspected(&greedy)["compression"], Value::Null);
    for map in [&fewest, &greedy] {
        run!("verify", map, "--against", exact, "--quiet").stdout();
    }

    // Levels, and products, are compressed the same way.
    let both = folder.path("both.dsm");
    run!("mip", fewest, "-o", both, "--quiet").stdout();
    assert_eq!(inspected(&both)["compression"]["method"], "min-link");
    run!("verify", both, "--quiet").stdout();
    run!("merge", fewest, fewest, "-o", both, "--quiet").stdout();
    assert_eq!(inspected(&both)["compression"]["method"], "min-link");
    run!("merge", fewest, greedy, "-o", both, "--quiet").stdout();
    assert_eq!(inspected(&both)["compression"], Value::Null);
}

#[test]
fn a_side_is_kept_and_stated() {
    let folder = Folder::new();
    let [exact, map] = ["exact.dsm", "map.dsm"].map(|name| folder.path(name));
    let scene = "builtin:foliage";
    run!("bake", scene, "-o", exact, "--resolution", "32", "--tolerance", "0", "--quiet").stdout();
    let pixel = |map: &std::path::Path, x: u32| -> Vec<[f64; 3]> {
        let at = format!("{x},16");
        let told = run!("inspect", map, "--pixel", at, "--json").json();
        serde_json::from_value(told["vertices"].clone()).unwrap()
    };
    // The light left behind a depth.
    let behind = |vertices: &[[f64; 3]], z: f64| {
        let next = vertices.iter().position(|vertex| vertex[0] > z).unwrap_or(vertices.len());
        match (next.checked_sub(1).map(|near| vertices[near]), vertices.get(next)) {
            (None, _) => 1.0,
            (Some(near), None) => near[2],
            (Some(near), Some(far)) => {
                near[2] + (far[1] - near[2]) * (z - near[0]) / (far[0] - near[0])
            }
        }
    };
    for (side, sign) in [("lighter", 1.0), ("darker", -1.0)] {
        run!("convert", exact, map, "--tolerance", "0.2", "--side", side, "--quiet").stdout();
        assert_eq!(inspected(&map)["compression"], json!({"method": "min-link", "side": side}));
        let mut most = 0.0_f64;
        for x in 0..32 {
            let (exact, stored) = (pixel(&exact, x), pixel(&map, x));
            for z in exact.iter().chain(&stored).map(|vertex| vertex[0]) {
                let off = sign * (behind(&stored, z) - behind(&exact, z));
                assert!((-1e-7..=0.2 + 1e-6).contains(&off), "{side} {x} {z}: {off}");
                most = most.max(off);
            }
        }
        assert!(most > 0.1, "{side} uses its tolerance: {most}");
    }
}

#[test]
fn what_does_not_go_together_is_wrong_usage() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    let scene = "builtin:smoke";
    let bake = |a: &str, b: &str, c: &str, d: &str| run!("bake", scene, "-o", map, a, b, c, d);
    bake("--method", "greedy", "--side", "lighter").is_wrong_usage("--method min-link");
    bake("--codec", "quantized", "--side", "darker").is_wrong_usage("--side darker");
    bake("--kind", "fragments", "--method", "min-link").is_wrong_usage("kind deep");
    let image = folder.path("map.exr");
    run!("convert", map, image, "--side", "lighter").is_wrong_usage("--side is for .dsm outputs");
}

#[test]
fn a_tolerance_is_found_for_a_size() {
    let folder = Folder::new();
    let [exact, usual, map] = ["exact.dsm", "usual.dsm", "map.dsm"].map(|name| folder.path(name));
    let bake = |map: &std::path::Path, more: &[&str]| {
        let mut arguments = vec!["bake".into(), "builtin:hairball".into(), "-o".into()];
        arguments.push(map.as_os_str().to_owned());
        let always = ["--resolution", "48", "--codec", "quantized"];
        arguments.extend(always.iter().chain(more).map(std::ffi::OsString::from));
        crate::run::run(arguments)
    };
    let length = |map: &std::path::Path| std::fs::metadata(map).unwrap().len();
    bake(&usual, &["--quiet"]).stdout();
    let most = length(&usual) * 2 / 3;
    let size = most.to_string();
    bake(&map, &["--target-size", &size, "--quiet"]).stdout();
    assert!(length(&map) <= most && length(&map) * 10 > most * 8, "{} {most}", length(&map));
    let tolerance = inspected(&map)["tolerance"].as_f64().unwrap();
    assert!(tolerance > 0.0625 && tolerance < 0.5, "{tolerance}");
    // It keeps to what it states.
    run!(
        "bake",
        "builtin:hairball",
        "-o",
        exact,
        "--resolution",
        "48",
        "--tolerance",
        "0",
        "--quiet"
    )
    .stdout();
    run!("verify", map, "--against", exact, "--quiet").stdout();
    let told = run!("convert", exact, map, "--target-size", size).stdout();
    assert!(told.contains("tolerance ") && length(&map) <= most, "{told}");
    // What is small enough already is as precise as it was asked to be.
    bake(&map, &["--target-size", "100000000", "--quiet"]).stdout();
    assert!((inspected(&map)["tolerance"].as_f64().unwrap() - 0.0625).abs() < 1e-6);
    let before = std::fs::read(&map).unwrap();
    let failed = bake(&map, &["--target-size", "1000", "--quiet"]);
    assert!(failed.refusal().contains("a map of 1000 bytes cannot be made"));
    assert_eq!(std::fs::read(&map).unwrap(), before);
    bake(&map, &["--target-size", "1000", "--mip"]).is_wrong_usage("--target-size");
}
