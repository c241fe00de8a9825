//! Layered maps: `bake --kind`, and what the other commands say of them.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::maps::Folder;
use crate::run;

/// A red pane at height 2 over an opaque floor at 0; the light, 1 × 0.5 large,
/// hangs at (0, 5, 0).
const SCENE: &str = r#"
[camera]
eye = [0, 4, 6]
target = [0, 0, 0]
up = [0, 1, 0]
fov = 40.0
resolution = [32, 24]

[light]
eye = [0, 5, 0]
target = [0, 0, 0]
up = [0, 0, 1]
fov = 60.0
shape = "rectangle"
size = [1.0, 0.5]

[[object]]
mesh = "pane.obj"
opacity = OPACITY
transform = { translate = [0, 2, 0] }

[[object]]
mesh = "pane.obj"
transform = { scale = 5.0 }
"#;

pub(crate) fn scene(folder: &Folder, opacity: &str) -> PathBuf {
    folder.write("pane.obj", "v -0.5 0 -0.5\nv 0.5 0 -0.5\nv 0.5 0 0.5\nv -0.5 0 0.5\nf 1 2 3 4\n");
    folder.write("scene.toml", SCENE.replace("OPACITY", opacity))
}

pub(crate) fn points(folder: &Folder) -> PathBuf {
    folder.write("p.csv", "x,y,z\n0,0.5,0\n2,0.5,0\n0,-0.5,0\n0,4.9,0\nnan,0,0\n")
}

/// The lights of an answer of one channel.
pub(crate) fn lights(answer: &str) -> Vec<f64> {
    answer.lines().skip(1).map(|line| line.parse().unwrap()).collect()
}

#[test]
fn layered_maps_are_baked_traced_and_filtered() {
    let folder = Folder::new();
    let (scene, points) = (scene(&folder, "0.75"), points(&folder));
    for kind in ["mtsm", "layers"] {
        let map = folder.path(&format!("{kind}.dsm"));
        let told = run!("bake", scene, "-o", map, "--resolution", "96", "--kind", kind).stdout();
        assert!(told.contains("9216 samples met"), "{told}");
        run!("verify", map).stdout();
        let traced = run!("lookup", map, "--points", points, "--rays", "64").warned("(NaN)");
        // Behind the pane, beside it, under the floor, beside the light.
        assert_eq!(lights(&traced), [0.25, 1.0, 0.0, 1.0, 1.0], "{kind}");
        let filtered = run!("lookup", map, "--points", points, "--method", "pcf").warned("(NaN)");
        assert_eq!(lights(&filtered), [0.25, 1.0, 0.0, 1.0, 1.0], "{kind}");
        let answer = run!("lookup", map, "--points", points, "--rays", "16", "--stats");
        let statistics: Value = serde_json::from_str(&answer.stderr).unwrap();
        assert_eq!(statistics["rays"], 80);
        assert_eq!(statistics["points_behind_light"], 16, "the NaN: {statistics}");
        let threads = ["1", "3"].map(|threads| {
            run!("lookup", map, "--points", points, "--threads", threads).warned("(NaN)")
        });
        assert_eq!(threads[0], threads[1]);
    }
    // The first run as a deep map: the pane's middle covers the light.
    let map = folder.path("mtsm.dsm");
    let looked_up = run!("lookup", map, "--points", points, "--method", "filter")
        .warned("answers the light of a point");
    assert_eq!(lights(&looked_up)[..3], [0.25, 1.0, 0.0]);
    // A point that the pane's edge halves the light for, and one without size.
    let edge = folder.write("e.csv", "x,y,z\n0.8333,0,0\n");
    let bias = ["--bias", "0.2"];
    let soft = run!("lookup", map, "--points", edge, bias[0], bias[1]).stdout();
    assert!((0.5..0.75).contains(&lights(&soft)[0]), "{soft}");
    let hard = run!("lookup", map, "--points", edge, "--light-size", "0", bias[0], bias[1]);
    assert!([0.25, 1.0].contains(&lights(&hard.stdout())[0]));
}

#[test]
fn fragments_are_baked_traced_and_shown() {
    let folder = Folder::new();
    let (scene, points, map) = (scene(&folder, "0.75"), points(&folder), folder.path("f.dsm"));
    let told = run!("bake", scene, "-o", map, "--kind", "fragments", "--resolution", "64").stdout();
    // 64 places a pixel, 378 × 378 of them on the floor, 114 × 114 on the pane.
    assert!(told.contains("262144 samples met 155880 surfaces"), "{told}");
    assert!(told.contains("mono, tolerance 0, "), "{told}");
    run!("verify", map).stdout();
    let traced = run!("lookup", map, "--points", points, "--rays", "64").warned("(NaN)");
    assert_eq!(lights(&traced), [0.25, 1.0, 0.0, 1.0, 1.0]);
    let told = run!("inspect", map, "--json", "--pixel", "32,32").json();
    assert_eq!((&told["kind"], &told["samples"]), (&json!("fragments"), &json!(64)));
    assert_eq!(told["fragments"].as_array().unwrap().len(), 2);
    assert_eq!(told["contents"]["max_fragments_per_pixel"], 2);
    assert_eq!(told["coverage"], 8);
    let image = folder.path("i.png");
    run!(
        "render",
        scene,
        "-o",
        image,
        "--method",
        "trace",
        "--map",
        map,
        "--samples",
        "1",
        "--quiet"
    )
    .stdout();
    let refused = run!("lookup", map, "--points", points, "--method", "pcf");
    assert!(refused.refusal().contains("fragments are traced"));
    for kind in ["deep", "layers", "mtsm"] {
        run!("bake", scene, "-o", map, "--kind", kind, "--coverage", "1")
            .is_wrong_usage("--coverage is for maps of kind fragments");
    }
    let fragments = ["bake", scene.to_str().unwrap(), "-o", map.to_str().unwrap(), "--kind"];
    let asked = |more: &[&str]| {
        crate::run::run(fragments.iter().chain(&["fragments", "--resolution", "16"]).chain(more))
    };
    asked(&["--coverage", "3"]).is_wrong_usage("1, 2, 4");
    // No more times than places of a pixel.
    asked(&["--samples", "65"]).is_wrong_usage("times that the places of a pixel");
    // One place a pixel is fragments still.
    assert!(asked(&["--coverage", "1"]).stdout().contains("256 samples met"));
    let told = run!("inspect", map, "--json").json();
    assert_eq!((&told["kind"], &told["samples"]), (&json!("fragments"), &json!(1)));
}

#[test]
fn the_far_table_is_a_switch_of_traced_fragments() {
    let folder = Folder::new();
    let (scene, points, map) = (scene(&folder, "0.75"), points(&folder), folder.path("f.dsm"));
    run!("bake", scene, "-o", map, "--kind", "fragments", "--resolution", "32").stdout();
    let used = |value: &str| {
        let answer = run!("lookup", map, "--points", points, "--far-table", value, "--stats");
        let statistics: Value = serde_json::from_str(&answer.stderr).unwrap();
        statistics["far_table"].as_bool()
    };
    // Panes and floors are traced at any distance: a table would stand for nothing.
    assert_eq!(["on", "off", "auto"].map(used), [Some(false); 3]);
    let picture = folder.path("p.exr");
    let trace =
        ["--method", "trace", "--resolution", "32", "--samples", "1", "--rays", "4", "--far-table"];
    let drawn = |scene: &str, value: &str, map: &PathBuf| {
        let call = ["render", scene, "-o", picture.to_str().unwrap(), "--map"];
        let map = map.to_str().unwrap();
        let answer = crate::run::run(call.iter().chain([&map]).chain(&trace).chain([&value]));
        (answer, std::fs::read(&picture).ok())
    };
    let hair = folder.path("hair.dsm");
    let few = ["--kind", "fragments", "--resolution", "128", "--coverage", "2"];
    run!("bake", "builtin:hairball", "-o", hair, few[0], few[1], few[2], few[3], few[4], few[5])
        .stdout();
    let pictures = ["on", "off"].map(|value| {
        let (answer, picture) = drawn("builtin:hairball", value, &hair);
        answer.stdout();
        picture
    });
    assert!(pictures[0].is_some() && pictures[0] != pictures[1]);
    run!("lookup", map, "--points", points, "--method", "filter", "--far-table", "on")
        .is_wrong_usage("--far-table is for --method trace");
    for kind in ["layers", "mtsm"] {
        run!("bake", scene, "-o", map, "--kind", kind, "--resolution", "16").stdout();
        let refused = run!("lookup", map, "--points", points, "--far-table", "off");
        assert!(refused.refusal().contains("--far-table is for maps of kind fragments"));
        let (refused, _) = drawn(scene.to_str().unwrap(), "on", &map);
        assert!(refused.refusal().contains("--far-table is for maps of kind fragments"));
    }
    let call = ["render", "builtin:smoke", "-o", picture.to_str().unwrap()];
    let refused = crate::run::run(call.iter().chain(&trace).chain(&["auto", "--rule", "ratio"]));
    assert!(refused.refusal().contains("this picture needs kind mtsm"));
}

#[test]
fn inspect_shows_layers_runs_counts_and_the_pyramid() {
    let folder = Folder::new();
    let (scene, map) = (scene(&folder, "1.0"), folder.path("map.dsm"));
    run!("bake", scene, "-o", map, "--kind", "mtsm", "--resolution", "32").stdout();
    let told = run!("inspect", map, "--json", "--pixel", "16,16").json();
    assert_eq!((&told["kind"], &told["samples"]), (&json!("mtsm"), &json!(1)));
    assert_eq!(told["layering"]["max_layers"], 32);
    assert_eq!(told["layering"]["resets"], 4);
    assert_eq!(told["contents"]["max_runs_per_pixel"], 2);
    assert_eq!(told["contents"]["max_layers_per_pixel"], 4);
    let empty = told["contents"]["empty_nodes"].as_array().unwrap();
    assert_eq!((empty.len(), &empty[5]), (6, &json!(0)));
    // The camera stands 0.5 / tan 30° behind the light.
    let back = 0.5 / 30.0_f64.to_radians().tan();
    let depth = |index: usize| told["runs"][index][1][0].as_f64().unwrap();
    assert!((told["layering"]["light_depth"].as_f64().unwrap() - back).abs() < 1e-6);
    assert!((depth(0) - 3.0 - back).abs() < 1e-5 && (depth(1) - 5.0 - back).abs() < 1e-5);
    assert_eq!(told["runs"][0][1][2], 1);
    let text = run!("inspect", map, "--pixel", "16,16").stdout();
    assert!(text.contains("kind        mtsm") && text.contains("runs 1"), "{text}");
    run!("inspect", map, "--slice", "inf", "--image", folder.path("s.png")).stdout();
    run!("inspect", map, "--pixel", "16,16", "--plot", folder.path("p.svg")).stdout();
    assert!(
        run!("inspect", map, "--pixel", "32,0").refusal().contains("pixel (32, 0) lies outside")
    );
}

#[test]
fn scenes_are_rendered_with_traced_shadows() {
    let folder = Folder::new();
    let (scene, map) = (scene(&folder, "[0.0, 0.75, 1.0]"), folder.path("map.dsm"));
    run!("bake", scene, "-o", map, "--kind", "mtsm", "--resolution", "128", "--quiet").stdout();
    let (traced, reference) = (folder.path("t.exr"), folder.path("r.exr"));
    let few = ["--samples", "4", "--factor", "--quiet", "--rays", "64"];
    run!(
        "render",
        scene,
        "-o",
        reference,
        "--method",
        "reference",
        few[0],
        few[1],
        few[2],
        few[3],
        few[4],
        few[5]
    )
    .stdout();
    for (method, least, most) in [("trace", 0.0, 0.03), ("pcf", 0.0, 0.2)] {
        let told = run!(
            "render",
            scene,
            "-o",
            traced,
            "--method",
            method,
            "--map",
            map,
            few[0],
            few[1],
            few[2],
            few[3],
            few[4],
            few[5],
            "--compare",
            reference,
            "--json"
        )
        .json();
        assert_eq!(told["method"], method);
        let error = told["compare"]["mean_absolute"].as_f64().unwrap();
        assert!((least..most).contains(&error), "{method}: {told}");
    }
    // Bakes a map first.
    run!("render", scene, "-o", traced, "--method", "trace", "--samples", "1", "--quiet").stdout();
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let folder = Folder::new();
    let (scene, map) = (scene(&folder, "1.0"), folder.path("map.dsm"));
    let points = points(&folder);
    for (arguments, says) in [
        (["--layers", "3"], "--layers is for maps of kind fragments, layers, mtsm or prefiltered"),
        (["--resets", "3"], "--resets is for maps of kind mtsm"),
        (["--layers", "0"], "--layers"),
    ] {
        let [switch, value] = arguments;
        run!("bake", scene, "-o", map, switch, value).is_wrong_usage(says);
    }
    for (kind, switch, value, says) in [
        ("layers", "--resets", "3", "--resets is for maps of kind mtsm"),
        ("fragments", "--resets", "3", "--resets is for maps of kind mtsm"),
        ("fragments", "--samples", "65", "1 to as many as those"),
        ("layers", "--tolerance", "0.1", "--tolerance is for maps of kind deep, fragments or mtsm"),
        ("mtsm", "--crop", "0,0,5,64", "multiples of 64"),
        ("mtsm", "--codec", "quantized", "--codec quantized is for maps of kind deep"),
    ] {
        run!("bake", scene, "-o", map, "--kind", kind, switch, value).is_wrong_usage(says);
    }
    run!("bake", scene, "-o", map, "--kind", "mtsm", "--resolution", "16", "--quiet").stdout();
    let lookup = |switch: &str, value: &str| run!("lookup", map, "--points", points, switch, value);
    assert!(lookup("--filter", "box").refusal().contains("for --method filter"));
    assert!(lookup("--light-size", "-1").code == 2);
    lookup("--rays", "0").is_wrong_usage("--rays");
    run!("lookup", map, "--points", points, "--method", "trace", "--bias", "-1")
        .is_wrong_usage("a ray offset is not negative");
    run!("lookup", map, "--points", points, "--method", "filter", "--rays", "4")
        .is_wrong_usage("--rays and --light-size");
    let deep = folder.path("deep.dsm");
    run!("bake", scene, "-o", deep, "--resolution", "16", "--quiet").stdout();
    let refused = run!("lookup", deep, "--points", points, "--method", "trace");
    assert!(refused.refusal().contains("no layers to trace"));
    let refused = run!("lookup", deep, "--points", points, "--rays", "4");
    assert!(refused.refusal().contains("--rays and --light-size are for --method trace"));
    let image = folder.path("i.png");
    let refused = run!("render", scene, "-o", image, "--method", "trace", "--map", deep);
    assert!(refused.refusal().contains("no layers"));
    assert!(run!("mip", map, "-o", deep).refusal().contains("kind \"mtsm\""));
}

#[test]
fn the_resolution_of_fragments_follows_the_scene() {
    let folder = Folder::new();
    let (mesh, map) = (folder.path("card.obj"), folder.path("map.dsm"));
    std::fs::write(&mesh, "v -1 0 -1\nv 1 0 -1\nv 0 0 1\nf 1 2 3\n").unwrap();
    // A strand that is several pixels wide at 1024, and one that isn't.
    let strand = |width: f32| {
        let path = folder.path(&format!("strand {width}.usda"));
        let text = format!(
            "#usda 1.0\ndef BasisCurves \"a\" {{\n uniform token type = \"linear\"\n int[] \
             curveVertexCounts = [3]\n point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 1)]\n \
             float[] widths = [{width}, {width}, {width}]\n}}\n"
        );
        std::fs::write(&path, text).unwrap();
        path
    };
    let sides = |scene: &Path| {
        run!("bake", scene, "-o", map, "--kind", "fragments", "--coverage", "1", "--quiet")
            .stdout();
        let told = run!("inspect", map, "--json").json();
        [&told["width"], &told["height"]].map(|side| side.as_u64().unwrap())
    };
    assert_eq!(sides(&mesh), [1024, 1024]);
    assert_eq!(sides(&strand(0.02)), [512, 512]);
    assert_eq!(sides(&strand(0.0002)), [1024, 1024]);
    run!("bake", mesh, "-o", map, "--kind", "fragments", "--crop", "0,0,512,512")
        .is_wrong_usage("needs a --resolution");
    run!("bake", mesh, "-o", map, "--kind", "layers", "--quiet").stdout();
    assert_eq!(run!("inspect", map, "--json").json()["width"], 512);
}
