//! Warnings: lines on stderr, entries of documents, and errors of `--strict`.

use serde_json::Value;

use crate::maps::Folder;
use crate::run;

/// A square of the side 2 at height 1, and one of the side 20 on the ground, under a square light.
const SCENE: &str = r#"
[camera]
eye = [0, 4, 6]
target = [0, 0, 0]
resolution = [8, 6]

[light]
eye = [0, 5, 0]
target = [0, 0, 0]
up = [0, 0, 1]
fov = 40.0
shape = "rectangle"
size = [0.5, 0.5]

[[object]]
mesh = "square.obj"
transform = { translate = [0, 1, 0] }

[[object]]
mesh = "square.obj"
transform = { scale = 10.0 }
"#;

const SQUARE: &str = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 2 3 4\n";
const SMALL: [&str; 4] = ["--resolution", "16", "--samples", "1"];

fn scene(folder: &Folder, name: &str, text: &str) -> std::path::PathBuf {
    folder.write("square.obj", SQUARE);
    folder.write(name, text)
}

#[test]
fn a_bake_that_meets_nothing_says_so() {
    let folder = Folder::new();
    let away = SCENE.replace("target = [0, 0, 0]\nup", "target = [0, 10, 0]\nup");
    let (scene, map) = (scene(&folder, "scene.toml", &away), folder.path("map.dsm"));
    let nothing = "no sample met anything";
    let told = run!("bake", scene, "-o", map, SMALL[0], SMALL[1], "--quiet").warned(nothing);
    assert_eq!(told, "", "a warning is for stderr");
    let told = run!("bake", scene, "-o", map, SMALL[0], SMALL[1], "--json").warned(nothing);
    let told: Value = serde_json::from_str(&told).unwrap();
    assert_eq!(told["warnings"].as_array().unwrap().len(), 1, "{told}");
    let strict = run!("bake", scene, "-o", map, SMALL[0], SMALL[1], "--strict", "--quiet");
    assert!(strict.refusal().contains(nothing) && strict.refusal().ends_with("(--strict)"));
    // Whoever reads it is told, too.
    let holds = "the map holds nothing";
    assert!(run!("verify", map).warned(holds).ends_with(": ok\n"));
    assert!(run!("verify", map, "--strict", "--json").refusal().contains(holds));
    let point = folder.write("p.csv", "x,y,z\n0,12,0\n");
    assert_eq!(run!("lookup", map, "--points", point).warned(holds), "v\n1\n");
    let picture = folder.path("picture.png");
    let told = run!("render", scene, "-o", picture, "--quiet").warned(nothing);
    assert_eq!(told, "");
    run!("render", scene, "-o", picture, "--map", map).warned("holds nothing");
    // Parts of a map are often empty.
    let crop = ["--resolution", "128", "--crop", "0,0,64,64"];
    let part = folder.path("part.dsm");
    run!("bake", scene, "-o", part, crop[0], crop[1], crop[2], crop[3], "--strict").stdout();
    run!("verify", part, "--strict").stdout();
    // What is converted holds nothing either.
    let copy = folder.path("copy.dsm");
    run!("convert", map, copy).warned("no pixel holds anything");
    let strict = run!("convert", map, folder.path("copy.exr"), "--strict");
    assert!(strict.refusal().contains("no pixel holds anything"), "{strict:?}");
}

#[test]
fn points_that_the_map_does_not_show_are_lit_with_a_warning() {
    let folder = Folder::new();
    let (scene, map) = (scene(&folder, "scene.toml", SCENE), folder.path("map.dsm"));
    run!("bake", scene, "-o", map, "--kind", "fragments", SMALL[0], SMALL[1]).stdout();
    let outside = folder.write("outside.csv", "x,y,z\n0,9,0\n50,0,0\n");
    let one_inside = folder.write("inside.csv", "x,y,z\n0,9,0\n50,0,0\n0,0.5,0\n");
    let said = "no point lies in the map";
    assert_eq!(run!("lookup", map, "--points", outside).warned(said), "v\n1\n1\n");
    let strict = run!("lookup", map, "--points", outside, "--strict");
    assert!(strict.refusal().contains(said));
    assert_eq!(strict.stdout, "v\n1\n1\n", "the answers are printed");
    assert_eq!(run!("lookup", map, "--points", one_inside, "--strict").stdout(), "v\n1\n1\n0\n");
    let none = folder.write("none.csv", "x,y,z\n");
    assert_eq!(run!("lookup", map, "--points", none, "--strict").stdout(), "v\n");
    let raster = folder.write("raster.csv", "x,y,z\n-1,3,4\n3,16,4\n");
    run!("lookup", map, "--points", raster, "--space", "raster").warned(said);
    // One line of JSON, and nothing beside it.
    let answer = run!("lookup", map, "--points", outside, "--stats");
    let stats: Value = serde_json::from_str(&answer.stderr).unwrap();
    assert_eq!(stats["warnings"].as_array().unwrap().len(), 1, "{stats}");
}

#[test]
fn a_map_of_another_light_is_no_map_of_the_scene() {
    let folder = Folder::new();
    let here = scene(&folder, "scene.toml", SCENE);
    let there = SCENE.replace("eye = [0, 5, 0]", "eye = [0.001, 5, 0]");
    let there = scene(&folder, "there.toml", &there);
    let (map, picture) = (folder.path("map.dsm"), folder.path("picture.png"));
    for kind in ["deep", "fragments", "mtsm"] {
        run!("bake", here, "-o", map, "--kind", kind, SMALL[0], SMALL[1]).stdout();
        let method = if kind == "deep" { "filter" } else { "trace" };
        let render = |scene: &std::path::Path, more: &[&str]| {
            let mut arguments: Vec<std::ffi::OsString> = vec!["render".into(), scene.into()];
            arguments.extend(["-o".into(), (&picture).into(), "--map".into(), (&map).into()]);
            arguments.extend(["--method", method].iter().chain(more).map(Into::into));
            crate::run::run(arguments)
        };
        let told = render(&there, &["--json"]).warned("no map of the scene's light");
        let told: Value = serde_json::from_str(&told).unwrap();
        assert!(told["warnings"][0].as_str().unwrap().contains("seen from elsewhere"), "{told}");
        assert!(render(&there, &["--strict"]).refusal().contains("no map of the scene's light"));
        if kind == "deep" {
            // Its own map; but what reads it knows no size of a light.
            render(&here, &[]).warned("filter answers the light of a point");
        } else {
            render(&here, &["--strict"]).stdout();
        }
    }
}

#[test]
fn a_large_light_is_no_point() {
    let folder = Folder::new();
    let (scene, map) = (scene(&folder, "scene.toml", SCENE), folder.path("map.dsm"));
    let (points, picture) = (folder.write("p.csv", "x,y,z\n0,0.5,0\n"), folder.path("p.png"));
    let said = "answers the light of a point, and the light is 0.5 × 0.5";
    run!("bake", scene, "-o", map, SMALL[0], SMALL[1]).stdout();
    assert_eq!(run!("lookup", map, "--points", points, "--quiet").warned(said), "v\n0\n");
    for method in ["filter", "pcf"] {
        let answer = run!("render", scene, "-o", picture, "--method", method, "--quiet");
        assert_eq!(answer.warned(said), "");
    }
    run!("render", scene, "-o", picture, "--method", "trace", "--strict").stdout();
    run!("render", scene, "-o", picture, "--light-size", "0", "--strict").stdout();
    // Smaller than a pixel: no map of this size could tell.
    let small = SCENE.replace("[0.5, 0.5]", "[0.05, 0.05]");
    let small = folder.write("small.toml", small);
    run!("bake", small, "-o", map, SMALL[0], SMALL[1]).stdout();
    run!("lookup", map, "--points", points, "--strict").stdout();
}

#[test]
fn what_moves_is_taken_at_mid_shutter_in_layered_maps() {
    let folder = Folder::new();
    let moving = SCENE.replace(
        "transform = { translate = [0, 1, 0] }",
        "transform = { translate = [0, 1, 0] }\ntransform_end = { translate = [1, 1, 0] }",
    );
    let (scene, map) = (scene(&folder, "scene.toml", &moving), folder.path("map.dsm"));
    for kind in ["fragments", "layers", "mtsm"] {
        let bake = run!("bake", scene, "-o", map, "--kind", kind, SMALL[0], SMALL[1], "--quiet");
        bake.warned(&format!("of kind {kind} as it is at mid-shutter"));
    }
    let layered = [["--kind", "mtsm"], ["--kind", "layers"], ["--kind", "fragments"]];
    for more in [["--kind", "deep"]].into_iter().chain(layered) {
        let samples = ["--samples", "4", "--strict"];
        run!("bake", scene, "-o", map, more[0], more[1], samples[0], samples[1], samples[2])
            .stdout();
    }
}
