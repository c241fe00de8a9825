//! Maps of views: `bake --kind views`, and what the other commands do with them.

use std::path::Path;

use serde_json::{Value, json};

use crate::layers::{lights, points, scene};
use crate::maps::Folder;
use crate::run;

/// Bakes a small map; the end of the line adds to what is asked for.
fn bake(scene: &Path, map: &Path, more: &[&str]) -> run::Answer {
    let start = ["bake", scene.to_str().unwrap(), "-o", map.to_str().unwrap(), "--kind", "views"];
    run::run(start.iter().chain(more))
}

#[test]
fn maps_of_views_are_baked_shown_and_traced() {
    let folder = Folder::new();
    let (scene, points, map) = (scene(&folder, "1"), points(&folder), folder.path("map.dsm"));
    let told = bake(&scene, &map, &["--resolution", "128"]).stdout();
    assert!(told.contains("65536 samples met"), "{told}");
    run!("verify", map).stdout();
    let told = run!("inspect", map, "--json").json();
    assert_eq!((&told["kind"], &told["gap"]), (&json!("views"), &json!(4.0)));
    let eyes = told["eyes"].as_array().unwrap();
    // The corners of a light of 1 × 0.5.
    assert_eq!(eyes.len(), 4);
    for eye in eyes {
        let at: Vec<f64> = eye.as_array().unwrap().iter().map(|at| at.as_f64().unwrap()).collect();
        let off = [at[0].abs() - 0.5, at[1].abs() - 0.25, at[2]];
        assert!(off.iter().all(|off| off.abs() < 1e-9), "{eyes:?}");
    }
    // Of the first view.
    assert!(told["contents"]["surfaces"].as_u64().unwrap() > 10_000, "{told}");
    // The pane, 3 units from the light.
    let told = run!("inspect", map, "--json", "--pixel", "64,64").json();
    let depth = told["surfaces"][0][0].as_f64().unwrap();
    assert!((depth - 3.0).abs() < 1e-6, "{told}");
    let found = lights(&run!("lookup", map, "--points", points, "--rays", "64").warned("(NaN)"));
    assert_eq!(found, [0.0, 1.0, 0.0, 1.0, 1.0]);
    // Neither threads nor tiles change an answer.
    let fine = folder.path("fine.dsm");
    let more = [
        "--resolution",
        "128",
        "--tile",
        "16",
        "--block",
        "none",
        "--threads",
        "1",
        "--views",
        "4",
    ];
    bake(&scene, &fine, &more).stdout();
    let edge = folder.write("e.csv", "x,y,z\n0.8,0,0\n0.6,0,0.5\n0,0,0.6\n");
    let [one, other] = [&map, &fine].map(|map| {
        run!("lookup", map, "--points", edge, "--rays", "64", "--threads", "1").stdout()
    });
    assert_eq!(one, other);
    assert!(lights(&one).iter().any(|left| (0.1..0.9).contains(left)), "{one}");
}

#[test]
fn soft_shadows_are_those_of_traced_planes() {
    let folder = Folder::new();
    let scene = scene(&folder, "0.5");
    let (map, planes) = (folder.path("map.dsm"), folder.path("planes.dsm"));
    // A pane that leaves half of the light counts as one that leaves none.
    bake(&scene, &map, &["--resolution", "256"]).stdout();
    let opaque = self::scene_of(&folder, "1");
    run!("bake", opaque, "-o", planes, "--kind", "fragments", "--resolution", "256").stdout();
    let line = |step: u32| format!("{},0,{}\n", f64::from(step) * 0.02 - 1.0, 0.1);
    let rows: String = (0..100).map(line).collect();
    let points = folder.write("line.csv", format!("x,y,z\n{rows}"));
    let [traced, found] = [&planes, &map]
        .map(|map| lights(&run!("lookup", map, "--points", points, "--rays", "1024").stdout()));
    assert!(traced.iter().any(|left| (0.3..0.7).contains(left)), "{traced:?}");
    let squares = found.iter().zip(&traced).map(|(a, b)| (a - b).powi(2));
    let rmse = (squares.sum::<f64>() / traced.len() as f64).sqrt();
    assert!(rmse < 0.02, "{rmse} {found:?} {traced:?}");
    // And one that leaves more is none.
    let thin = self::scene_of(&folder, "0.4");
    bake(&thin, &map, &["--resolution", "64"]).stdout();
    let found = lights(&run!("lookup", map, "--points", points, "--rays", "64").stdout());
    assert_eq!(found, vec![1.0; 100]);
}

fn scene_of(folder: &Folder, opacity: &str) -> std::path::PathBuf {
    let text = std::fs::read_to_string(scene(folder, opacity)).unwrap();
    folder.write(&format!("scene_{opacity}.toml"), text)
}

#[test]
fn switches_of_others_are_refused() {
    let folder = Folder::new();
    let (scene, points, map) = (scene(&folder, "1"), points(&folder), folder.path("map.dsm"));
    for (switch, value, says) in [
        ("--light-samples", "4", "--light-samples is for maps of kind attenuation"),
        ("--layers", "3", "--layers is for"),
        ("--coverage", "4", "--coverage is for"),
        ("--samples", "4", "one sample a pixel"),
        ("--channels", "rgb", "one channel"),
        ("--views", "0", "--views"),
        ("--views", "1025", "--views"),
    ] {
        bake(&scene, &map, &["--resolution", "64", switch, value]).is_wrong_usage(says);
    }
    run!("bake", scene, "-o", map, "--kind", "layers", "--views", "3")
        .is_wrong_usage("--views is for maps of kind views");
    bake(&scene, &map, &["--resolution", "32"]).stdout();
    for method in ["filter", "pcf", "prefilter", "attenuation"] {
        let refused = run!("lookup", map, "--points", points, "--method", method);
        assert!(
            refused.refusal().contains("--method trace or coherence reads them"),
            "{refused:?}"
        );
    }
    for (switch, value) in [("--rule", "ratio"), ("--far-table", "on")] {
        let refused = run!("lookup", map, "--points", points, switch, value);
        assert!(refused.refusal().contains(switch), "{refused:?}");
    }
    let negative = run!("lookup", map, "--points", points, "--bias", "-1");
    assert!(negative.refusal().contains("ray offset"), "{negative:?}");
}

#[test]
fn pictures_have_traced_shadows() {
    let folder = Folder::new();
    let (scene, map) = (scene(&folder, "1"), folder.path("map.dsm"));
    bake(&scene, &map, &["--resolution", "256"]).stdout();
    let (truth, output) = (folder.path("truth.exr"), folder.path("picture.exr"));
    let small = ["--resolution", "48x36", "--samples", "4", "--factor", "--quiet", "--rays", "64"];
    let draw = |method: &str, output: &Path, more: &[&str]| {
        let scene = scene.to_str().unwrap();
        let start = ["render", scene, "-o", output.to_str().unwrap(), "--method", method];
        run::run(start.iter().chain(&small).chain(more)).stdout()
    };
    draw("reference", &truth, &[]);
    let map = map.to_str().unwrap();
    let more = ["--map", map, "--json", "--compare", truth.to_str().unwrap()];
    let told: Value = serde_json::from_str(&draw("trace", &output, &more)).unwrap();
    let rmse = told["compare"]["rmse"].as_f64().unwrap();
    assert!(rmse < 0.04, "{rmse}");
}
