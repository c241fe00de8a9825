//! `bake --crop I/N` and `--frame`, `merge` of any kind and `--expect`, `plan` and `step`.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::maps::Folder;
use crate::run;
use crate::run::program;

const KINDS: [&str; 5] = ["deep", "fragments", "layers", "mtsm", "views"];

/// A run of the program in a folder.
fn run_in(folder: &Path, arguments: &[&str]) -> crate::run::Answer {
    program(arguments).current_dir(folder).output().unwrap().into()
}

const SCENE: &str = "[light]\neye = [0, 5, 1]\ntarget = [0, 0, 0]\nshape = \"disk\"\nradius = 0.3\n\
                     [[object]]\nmesh = \"leaf.##.obj\"\nopacity = 0.5\n";

/// A scene file and two frames of its mesh.
fn write_sequence(folder: &Path) {
    fs::write(folder.join("leaf.toml"), SCENE).unwrap();
    for frame in 1..=2 {
        let mesh = format!("v -1 0 -1\nv {frame} 0 -1\nv 0 0.{frame} 1\nf 1 2 3\n");
        fs::write(folder.join(format!("leaf.0{frame}.obj")), mesh).unwrap();
    }
}

#[test]
fn parts_of_any_kind_make_the_whole() {
    let folder = Folder::new();
    for kind in KINDS {
        let bake = |name: &str, crop: &[&str]| {
            let path = folder.path(name);
            let path = path.to_str().unwrap();
            let all =
                ["bake", "builtin:foliage", "-o", path, "--kind", kind, "--resolution", "96x64"];
            let all = [&all[..], &["--tile", "32", "--quiet"], crop].concat();
            crate::run::run(all).stdout();
        };
        bake("whole.dsm", &[]);
        for part in ["1/3", "2/3", "3/3"] {
            bake(&format!("{}.dsm", &part[..1]), &["--crop", part]);
        }
        let out = folder.path("out.dsm");
        let [a, b, c] = ["3.dsm", "1.dsm", "2.dsm"].map(|name| folder.path(name));
        run!("merge", a, b, c, "-o", out, "--quiet").stdout();
        assert!(fs::read(&out).unwrap() == fs::read(folder.path("whole.dsm")).unwrap(), "{kind}");
        run!("verify", out, a).stdout();
        let alone = run!("merge", a, "-o", out);
        assert!(alone.refusal().contains("one crop alone"), "{alone:?}");
        if kind != "deep" {
            let points = folder.path("points.csv");
            fs::write(&points, "x,y,z\n0,0,0\n").unwrap();
            let refused = run!("lookup", a, "--points", points);
            assert!(refused.refusal().contains("`merge` puts the map together"), "{refused:?}");
        }
    }
    let out = folder.path("out.dsm");
    run!("bake", "builtin:foliage", "-o", out, "--crop", "0/3").is_wrong_usage("numbered from 1");
    run!("bake", "builtin:foliage", "-o", out, "--crop", "4/3").is_wrong_usage("numbered from 1");
    run!("bake", "builtin:foliage", "-o", out, "--crop", "1/99").is_wrong_usage("has 64 tiles");
}

#[test]
fn frames_have_files_of_their_own() {
    let folder = Folder::new();
    let root = folder.path("");
    write_sequence(&root);
    let bake = |frame: &str, out: &str| {
        let all =
            ["bake", "leaf.toml", "-o", out, "--resolution", "32", "--frame", frame, "--quiet"];
        run_in(&root, &all).stdout();
    };
    bake("1", "map.###.dsm");
    bake("2", "map.###.dsm");
    let [first, second] =
        ["map.001.dsm", "map.002.dsm"].map(|name| fs::read(root.join(name)).unwrap());
    assert!(first != second);
    let header = run!("inspect", root.join("map.002.dsm"), "--json").json();
    assert_eq!(header["attributes"]["bakeFrame"]["value"], "2");
    let missing = run_in(&root, &["bake", "leaf.toml", "-o", "map.dsm", "--frame", "7"]);
    assert!(missing.refusal().contains("leaf.07.obj"), "{missing:?}");
    let still = run_in(&root, &["bake", "builtin:foliage", "-o", "map.dsm", "--frame", "7"]);
    assert!(still.refusal().contains("has a # for the number"), "{still:?}");
}

#[test]
fn plans_are_done_once_and_hold_files_to_what_they_say() {
    let folder = Folder::new();
    let root = folder.path("");
    write_sequence(&root);
    let plan = |name: &str| {
        let all =
            ["plan", "leaf.toml", "-o", name, "--frames", "1-2", "--crops", "3", "--trial", "0"];
        let files = ["--slurm", "submit.sh", "--openjd", "job.json", "--", "--kind", "layers"];
        let size = ["--resolution", "64", "--tile", "16"];
        run_in(&root, &[&all[..], &files, &size].concat()).stdout()
    };
    let told = plan("plan.json");
    assert!(told.contains("bake: 6 tasks") && told.contains("verify: 2 tasks"), "{told}");
    plan("again.json");
    let [text, again] =
        ["plan.json", "again.json"].map(|name| fs::read_to_string(root.join(name)).unwrap());
    assert_eq!(text, again);
    let job: Value = serde_json::from_slice(&fs::read(root.join("job.json")).unwrap()).unwrap();
    assert_eq!(job["steps"][0]["parameterSpace"]["taskParameterDefinitions"][0]["range"], "0-5");

    let step = |arguments: &[&str]| run_in(&root, &[&["step", "plan.json"], arguments].concat());
    assert!(step(&["bake", "4"]).stdout().ends_with("leaf.toml in frame 2, part 2: done\n"));
    assert!(step(&["bake", "4"]).stdout().ends_with("part 2: there already\n"));
    let missing = step(&["merge", "1"]);
    assert!(missing.refusal().contains("missing: 1/3 (0,0,"), "{missing:?}");
    assert!(step(&["bake", "6"]).refusal().contains("6 bakes, numbered from 0"));
    assert!(step(&["mip"]).refusal().contains("no smaller levels"));
    let all = step(&[]).stdout();
    assert_eq!(all.matches("there already").count(), 1, "{all}");
    let whole = ["bake", "leaf.toml", "-o", "whole.dsm", "--kind", "layers", "--resolution", "64"];
    let whole = [&whole[..], &["--tile", "16", "--frame", "2", "--quiet"]].concat();
    run_in(&root, &whole).stdout();
    let map = root.join("maps/leaf.0002.dsm");
    assert!(fs::read(&map).unwrap() == fs::read(root.join("whole.dsm")).unwrap());
    // What is done stays; what was changed is made again.
    assert!(!step(&[]).stdout().contains(": done"));
    fs::write(&map, b"").unwrap();
    // Three parts and the merge, whose map is again the one that was verified.
    assert_eq!(step(&[]).stdout().matches(": done").count(), 4);
    let left: Vec<_> = fs::read_dir(root.join("maps")).unwrap().collect();
    assert_eq!(left.len(), 4, "{left:?}");

    // Files that are, and are not, the plan's.
    for (part, frame) in [("1", "1"), ("2", "1"), ("3", "1"), ("3", "2")] {
        let (out, crop) = (format!("{part}.{frame}.dsm"), format!("{part}/3"));
        let all = ["bake", "leaf.toml", "-o", &out, "--kind", "layers", "--resolution", "64"];
        let all =
            [&all[..], &["--tile", "16", "--frame", frame, "--crop", &crop, "--quiet"]].concat();
        run_in(&root, &all).stdout();
    }
    let merge = |parts: &[&str]| {
        run_in(&root, &[&["merge", "-o", "out.dsm", "--expect", "plan.json"], parts].concat())
    };
    let foreign = merge(&["1.1.dsm", "2.1.dsm", "3.2.dsm"]);
    let reason = foreign.refusal();
    assert!(
        reason.contains("missing: 3/3") && reason.contains("foreign: 3.2.dsm is of frame 2"),
        "{reason}"
    );
    fs::copy(root.join("1.1.dsm"), root.join("1.copy.dsm")).unwrap();
    let doubled = merge(&["1.1.dsm", "2.1.dsm", "3.1.dsm", "1.copy.dsm"]);
    assert!(doubled.refusal().contains("in 1.1.dsm and 1.copy.dsm"), "{doubled:?}");
    merge(&["1.1.dsm", "2.1.dsm", "3.1.dsm"]).stdout();

    fs::write(root.join("leaf.toml"), SCENE.replace("0.5", "0.6")).unwrap();
    let changed = step(&["bake", "0"]);
    assert!(changed.refusal().contains("leaf.toml has changed"), "{changed:?}");
    fs::write(root.join("plan.json"), text.replace("\"version\": 1", "\"version\": 2")).unwrap();
    assert!(step(&[]).refusal().contains("is no plan of this program"));
}

#[test]
fn trials_tell_what_steps_take() {
    let folder = Folder::new();
    let root = folder.path("");
    let plan = |more: &[&str]| {
        let all = ["plan", "builtin:hairball", "-o", "plan.json", "--trial", "2", "--mip"];
        let switches = ["--", "--resolution", "512", "--samples", "4"];
        run_in(&root, &[&all[..], more, &switches].concat())
    };
    plan(&["--time", "60"]).stdout();
    let planned: Value =
        serde_json::from_slice(&fs::read(root.join("plan.json")).unwrap()).unwrap();
    for step in ["bake", "merge", "mip", "verify"] {
        assert!(planned["cost"][step]["seconds"].as_u64() > Some(0), "{step}");
        assert!(planned["cost"][step]["memory"].as_u64() > Some(1 << 20), "{step}");
    }
    plan(&["--time", "0.001"]).refusal();
    assert!(plan(&["--memory", "1M"]).refusal().contains("of which most is the scene"));
    let wrong = ["plan", "builtin:smoke", "-o", "plan.json", "--", "--crop", "1/2"];
    run_in(&root, &wrong).is_wrong_usage("what the plan decides");
    let unknown =
        ["plan", "builtin:smoke", "-o", "plan.json", "--trial", "0", "--", "--samples", "x"];
    assert!(run_in(&root, &unknown).refusal().starts_with("behind --: invalid value 'x'"));
    let none =
        ["plan", "builtin:smoke", "-o", "plan.json", "--crops", "2", "--", "--kind", "attenuation"];
    assert!(run_in(&root, &none).refusal().contains("bake it whole"));
}
