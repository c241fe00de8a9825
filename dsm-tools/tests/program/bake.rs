//! `bake`: scenes into maps.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::maps::Folder;
use crate::run;
use crate::run::{Answer, program};

/// A red pane at height 1 over a floor; the light hangs at (0, 5, 0).
const PANE: &str = r#"
[light]
eye = [0, 5, 0]
target = [0, 0, 0]
up = [0, 0, 1]
fov = 40.0
shape = "rectangle"
size = [1.0, 0.5]

[[object]]
mesh = "pane.obj"
opacity = [0.0, 0.75, 1.0]

[[object]]
mesh = "pane.obj"
transform = { translate = [0, -1, 0], scale = 10.0 }
"#;

const OBJ: &str = "v -0.5 1 -0.5\nv 0.5 1 -0.5\nv 0.5 1 0.5\nv -0.5 1 0.5\nf 1 2 3 4\n";

fn pane(folder: &Folder) -> std::path::PathBuf {
    folder.write("pane.obj", OBJ);
    // The second object lies 10 times as high, less 1.
    folder.write("scene.toml", PANE.replace("[0, -1, 0]", "[0, -10, 0]"))
}

#[test]
fn what_a_model_says_that_is_not_understood_is_said() {
    let folder = Folder::new();
    folder.write("a.mtl", "newmtl m\nTr 1.000000\n");
    let model = folder.write("a.obj", format!("mtllib a.mtl\nusemtl m\n{OBJ}"));
    let scene = folder.write("scene.toml", "[[object]]\nmesh = \"a.obj\"\n");
    let (map, picture) = (folder.path("map.dsm"), folder.path("picture.png"));
    let warning = "a.obj: material m: Tr 1 without d makes it invisible";
    for scene in [&model, &scene] {
        let told = run!("bake", scene, "-o", map, "--resolution", "8", "--quiet");
        assert_eq!((told.code, told.stdout.as_str()), (0, ""), "{told:?}");
        assert!(told.stderr.starts_with("warning: ") && told.stderr.contains(warning), "{told:?}");
        // And that there is nothing else.
        assert!(told.stderr.contains("\nwarning: no sample met anything"), "{told:?}");
        assert_eq!(told.stderr.matches('\n').count(), 2, "{told:?}");
    }
    let told = run!("render", model, "-o", picture, "--resolution", "8x8", "--json");
    let document: Value = serde_json::from_str(&told.stdout).unwrap();
    assert!(document["warnings"][0].as_str().unwrap().contains(warning), "{told:?}");
    assert!(told.stderr.starts_with("warning: "), "{told:?}");
    let told = run!("bake", pane(&folder), "-o", map, "--resolution", "8", "--json").json();
    assert_eq!(told["warnings"], json!([]));
}

#[test]
fn a_scene_becomes_a_map_that_knows_where_it_came_from() {
    let folder = Folder::new();
    let (scene, map) = (pane(&folder), folder.path("map.dsm"));
    let told = run!("bake", scene, "-o", map, "--resolution", "48x32", "--samples", "4").stdout();
    assert!(told.contains("48 × 32 pixels, RGB, tolerance 0.125"), "{told}");
    run!("verify", map).stdout();
    let told = run!("inspect", map, "--json").json();
    for (key, value) in [
        ("width", json!(48)),
        ("height", json!(32)),
        ("channels", json!(3)),
        ("samples", json!(4)),
        ("tile", json!(64)),
        ("filter", json!({"shape": "box", "width": 1.0})),
        ("light", json!({"shape": "rectangle", "size": [1.0, 0.5]})),
    ] {
        assert_eq!(told[key], value, "{key}");
    }
    assert!(told["software"].as_str().unwrap().starts_with("dsm-tools "));
    assert_eq!(told["attributes"]["bakeSeed"]["value"], "0");
    assert!(run!("inspect", map).stdout().contains("light       rectangle, 1 × 0.5"));

    // Behind the pane only red is left, beside it everything, under the floor
    // nothing.
    let points = folder.write("p.csv", "x,y,z\n0,0.5,0\n1.2,0.5,0\n0,-0.5,0\n0,2,0\n");
    let light = run!("lookup", map, "--points", points).warned("answers the light of a point");
    assert_eq!(light, "r,g,b\n1,0.25,0\n1,1,1\n0,0,0\n1,1,1\n");

    let mono = ["--channels", "mono", "--tolerance", "0", "--block", "none", "--tile", "16"];
    let arguments = [
        ["bake", scene.to_str().unwrap(), "-o", map.to_str().unwrap()],
        mono[..4].try_into().unwrap(),
    ];
    let answer = crate::run::run(arguments.concat().into_iter().chain(mono[4..].iter().copied()));
    assert!(answer.stdout().contains("512 × 512 pixels, mono, tolerance 0,"));
}

#[test]
fn rounded_maps_are_smaller_and_say_what_they_are() {
    let folder = Folder::new();
    let (scene, map) = (pane(&folder), folder.path("map.dsm"));
    run!("bake", scene, "-o", map, "--resolution", "64", "--block", "none").stdout();
    let exact = std::fs::metadata(&map).unwrap().len();
    run!("bake", scene, "-o", map, "--resolution", "64", "--codec", "quantized").stdout();
    assert!(2 * std::fs::metadata(&map).unwrap().len() < exact);
    run!("verify", map).stdout();
    assert_eq!(run!("inspect", map, "--json").json()["codec"], "quantized");
    run!("mip", map, "-o", map).stdout();
    run!("verify", map).stdout();
    run!("bake", scene, "-o", map, "--resolution", "64", "--codec", "quantized", "--mip").stdout();
    run!("verify", map).stdout();
    let told = run!("inspect", map, "--json").json();
    assert_eq!(
        (&told["codec"], told["levels"].as_array().unwrap().len()),
        (&"quantized".into(), 7)
    );
}

#[test]
fn threads_change_no_byte_and_seeds_do() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    let bake = |more: &[&str]| {
        let base = ["bake", "builtin:spinning-sphere", "--quiet", "-o", map.to_str().unwrap()];
        let size = ["--resolution", "40", "--samples", "5", "--tile", "16", "--filter", "tent"];
        let arguments = base.iter().chain(&size).chain(more);
        assert_eq!(crate::run::run(arguments).stdout(), "");
        fs::read(&map).unwrap()
    };
    let one = bake(&["--threads", "1"]);
    assert!(one == bake(&["--threads", "4"]));
    assert!(one != bake(&["--seed", "1"]));
    let levels = bake(&["--mip", "--threads", "1"]);
    assert!(levels == bake(&["--mip", "--threads", "4"]));
    run!("verify", map).stdout();
    let told: Value = run!("inspect", map, "--json").json();
    let levels = told["levels"].as_array().unwrap();
    assert_eq!(levels.len(), 7);
    for level in levels {
        assert!(level["max_error"].as_f64() <= level["tolerance"].as_f64(), "{level}");
    }
}

#[test]
fn crops_merge_into_the_whole() {
    let folder = Folder::new();
    let bake = |name: &str, more: &[&str]| {
        let path = folder.path(name);
        let base = ["bake", "builtin:spinning-sphere", "--quiet", "-o", path.to_str().unwrap()];
        let size = ["--resolution", "40x33", "--samples", "3", "--tile", "16"];
        let filter = ["--filter", "gaussian", "--filter-width", "3"];
        crate::run::run(base.iter().chain(&size).chain(&filter).chain(more)).stdout();
        path
    };
    let whole = bake("whole.dsm", &[]);
    let left = bake("left.dsm", &["--crop", "0,0,16,33"]);
    let right = bake("right.dsm", &["--crop", "16,0,40,33"]);
    let merged = folder.path("merged.dsm");
    run!("merge", right, left, "-o", merged).stdout();
    assert!(fs::read(whole).unwrap() == fs::read(merged).unwrap());
}

#[test]
fn what_cannot_be_baked_leaves_no_file() {
    let folder = Folder::new();
    let map = folder.write("map.dsm", "old");
    let key = folder.write("key.toml", "[light]\neye = [0, 1, 0]\ntarget = [0, 0, 0]\nwatts = 3\n");
    let cut = folder.write("cut.obj", "v 0 0 0\nf 1 2 3\n");
    for (scene, more, reason) in [
        ("builtin:moss", ["--samples", "1"], "moss"),
        ("missing.toml", ["--samples", "1"], "missing.toml"),
        (key.to_str().unwrap(), ["--samples", "1"], "watts"),
        (cut.to_str().unwrap(), ["--samples", "1"], "cut.obj"),
    ] {
        let answer = run!("bake", scene, "-o", map, "--resolution", "32", more[0], more[1]);
        assert!(answer.refusal().contains(reason), "{answer:?}");
        assert_eq!(fs::read(&map).unwrap(), b"old");
    }
    for wrong in [
        ["--kind", "view"],
        ["--resolution", "0x"],
        ["--samples", "0"],
        ["--tolerance", "1"],
        ["--filter-width", "0.5"],
        ["--crop", "1,2,3"],
        ["--crop", "0,0,0,64"],
        ["--crop", "0,0,1024,64"],
        ["--tile", "0"],
    ] {
        run!("bake", "builtin:smoke", "-o", map, wrong[0], wrong[1]).is_wrong_usage("");
    }
    for edge in ["5,0,512,64", "0,5,512,64", "0,0,5,64", "0,0,512,5"] {
        run!("bake", "builtin:smoke", "-o", map, "--crop", edge, "--resolution", "512x256")
            .is_wrong_usage(
                "multiples of 64, the width of a --tile, or edges of the map of 512 × 256",
            );
    }
    run!("bake", "builtin:smoke", "-o", "map.exr").is_wrong_usage(".dsm");
    run!("bake", "builtin:smoke", "-o", map, "--mip", "--crop", "0,0,64,64")
        .is_wrong_usage("--mip");
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_no_file() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    let started = Instant::now();
    // More than an hour of work.
    let size = ["--resolution", "16384", "--samples", "1024", "--quiet"];
    let base = ["bake", "builtin:spinning-sphere", "-o", map.to_str().unwrap()];
    let child = program(base.iter().chain(&size))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let partial = || fs::read_dir(folder.path(".")).unwrap().count() > 0;
    // The check of the output's name makes a file too, for a moment.
    let stays = || {
        partial() && {
            std::thread::sleep(Duration::from_millis(50));
            partial()
        }
    };
    while !stays() {
        assert!(started.elapsed() < Duration::from_secs(60), "it never began to write");
        std::thread::sleep(Duration::from_millis(20));
    }
    std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let answer: Answer = child.wait_with_output().unwrap().into();
    assert!(answer.refusal().ends_with("interrupted"), "{answer:?}");
    assert!(!partial(), "{:?}", fs::read_dir(folder.path(".")).unwrap().collect::<Vec<_>>());
}

#[cfg(unix)]
#[test]
fn an_interrupt_of_fragments_is_an_error_line() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    // Many minutes of work, which writes at its end.
    let switches = ["--kind", "fragments", "--resolution", "16384", "--quiet"];
    let base = ["bake", "builtin:spinning-sphere", "-o", map.to_str().unwrap()];
    let child = program(base.iter().chain(&switches))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(2));
    std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let answer: Answer = child.wait_with_output().unwrap().into();
    assert!(answer.refusal().ends_with("interrupted"), "{answer:?}");
    assert_eq!(fs::read_dir(folder.path(".")).unwrap().count(), 0);
}

#[test]
fn a_grid_of_a_volume_is_chosen() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    let volumes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../dsm-scene/tests/data/volumes");
    let several = volumes.join("several.vdb");
    let bake = |grid: &str| {
        run!("bake", several, "-o", map, "--resolution", "8", "--samples", "1", "--grid", grid)
    };
    let bytes = |grid: &str| {
        bake(grid).stdout();
        fs::read(&map).unwrap()
    };
    assert_ne!(bytes("density:0"), bytes("density:1"));
    let refusal = bake("density");
    assert!(refusal.refusal().contains("density:0, flame, density:1"), "{refusal:?}");
    let refusal = bake("smoke");
    assert!(refusal.refusal().contains("no grid is smoke"), "{refusal:?}");
    bake(":1").is_wrong_usage("NAME:N");
    let picture = folder.path("picture.png");
    let scene = pane(&folder);
    let refusal = run!("render", scene, "-o", picture, "--grid", "density");
    assert!(refusal.refusal().contains("only a volume's file"), "{refusal:?}");
}
