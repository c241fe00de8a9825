//! What maps whose depths were moved state of that, wherever they state an error.

use std::path::Path;

use serde_json::Value;

use crate::maps::Folder;
use crate::run;

fn number(told: &Value, key: &str) -> f64 {
    told[key].as_f64().unwrap_or_else(|| panic!("{key} of {told}"))
}

/// The largest difference at one depth of the maps, as `diff` finds it.
fn difference(one: &Path, other: &Path) -> f64 {
    number(&run!("diff", one, other, "--json").json(), "max")
}

#[test]
fn moved_depths_are_stated_with_what_they_change() {
    let folder = Folder::new();
    let [exact, map, copy] = ["exact.dsm", "map.dsm", "copy.dsm"].map(|name| folder.path(name));
    let scene = "builtin:foliage";
    let few = ["--resolution", "64", "--samples", "4", "--json"];
    run!("bake", scene, "-o", exact, few[0], few[1], few[2], few[3], "--tolerance", "0").stdout();
    let bake = |depth_error: &str| {
        let rounded = ["--tolerance", "0.01", "--codec", "quantized", "--depth-error"];
        let base = ["bake", scene, "-o", map.to_str().unwrap()];
        let all = base.iter().chain(&few).chain(&rounded).chain([&depth_error]);
        run::run(all).json()
    };
    for depth_error in [0.03, 0.001] {
        let told = bake(&depth_error.to_string());
        let moved = number(&told, "depth_error");
        assert!(0.25 * depth_error < moved && moved <= depth_error, "{told}");
        let (beside, at_depth) = (number(&told, "max_error"), number(&told, "error_at_depth"));
        assert!(beside <= 0.01 && at_depth > 0.2, "{told}");
        let found = difference(&map, &exact);
        assert!(beside < found && found <= at_depth, "{found} {told}");
        // The same numbers wherever errors are stated.
        let same = |other: &Value| {
            ["max_error", "mean_error", "depth_error", "error_at_depth"]
                .iter()
                .all(|key| other[key] == told[key])
        };
        assert!(same(&run!("inspect", map, "--json").json()["levels"][0]), "{told}");
        assert!(same(&run!("verify", map, "--json").json()["files"][0]["stated"][0]), "{told}");
        let sentence = format!("depths up to {moved:.3e} farther from the light: off by");
        assert!(run!("verify", map).stdout().contains(&sentence));
        assert!(run!("inspect", map).stdout().contains(&format!("{moved:.2e}")));

        // A map of it has its own move as well, a copy none.
        let told = run!("convert", map, copy, "--json").json();
        assert_eq!(number(&told, "depth_error"), moved, "{told}");
        let more = ["--tolerance", "0.01", "--codec", "quantized", "--depth-error", "0.5"];
        let [a, b, c, d, e, f] = more;
        let told = run!("convert", map, copy, a, b, c, d, e, f, "--json").json();
        assert!(number(&told, "depth_error") > 0.1 + moved, "{told}");
        let found = difference(&copy, &exact);
        assert!(found <= number(&told, "error_at_depth"), "{found} {told}");
        let told = run!("convert", map, copy, a, b, c, d, e, f).stdout();
        assert!(told.contains("farther from the light: off by"), "{told}");
    }
    run!("convert", exact, copy, "--codec", "quantized").is_wrong_usage("--tolerance");
}

#[test]
fn exact_depths_are_not_spoken_of() {
    let folder = Folder::new();
    let map = folder.path("map.dsm");
    let told = run!("bake", "builtin:foliage", "-o", map, "--resolution", "16").stdout();
    assert!(!told.contains("farther"), "{told}");
    assert!(!run!("verify", map).stdout().contains("farther"));
    let level = run!("inspect", map, "--json").json()["levels"][0].clone();
    assert_eq!((level["depth_error"].as_f64(), level["max_error"].is_number()), (Some(0.0), true));
    assert_eq!(level["max_error"], level["error_at_depth"]);
    run!("bake", "a.obj", "-o", map, "--depth-error", "0.1").is_wrong_usage("--codec quantized");
    run!("bake", "a.obj", "-o", map, "--kind", "mtsm", "--depth-error", "0.1")
        .is_wrong_usage("--depth-error is for maps of kind deep");
}

/// Eight panes that let half the light through, over a floor, under a point light.
fn panes(folder: &Folder) -> std::path::PathBuf {
    folder.write("pane.obj", "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 2 3 4\n");
    let mut scene = "[camera]\neye = [0, 4, 6]\ntarget = [0, 0, 0]\nresolution = [8, 6]\n\
        [light]\neye = [0, 5, 0]\ntarget = [0, 0, 0]\nup = [0, 0, 1]\n"
        .to_owned();
    for index in 1..=8 {
        scene += &format!(
            "[[object]]\nmesh = \"pane.obj\"\nopacity = 0.5\n\
             transform = {{ translate = [0, {}, 0] }}\n",
            0.25 * f64::from(index)
        );
    }
    folder.write("panes.toml", scene)
}

#[test]
fn light_that_a_bound_of_layers_lets_through_is_stated_wherever_the_map_is_read() {
    let folder = Folder::new();
    let (scene, map) = (panes(&folder), folder.path("map.dsm"));
    let (point, picture) = (folder.write("p.csv", "x,y,z\n0,0.1,0\n"), folder.path("p.png"));
    for (kind, key, most) in [
        // The last three stand for six: between them only the light of the first is right.
        ("fragments", "folded", 0.25 - 0.5_f64.powi(7)),
        ("layers", "left_out", 0.125 - 0.5_f64.powi(8)),
        ("mtsm", "left_out", 0.125 - 0.5_f64.powi(8)),
    ] {
        let base = ["bake", scene.to_str().unwrap(), "-o", map.to_str().unwrap(), "--kind", kind];
        let more = ["--resolution", "32", "--layers", "3", "--json"];
        let told = run::run(base.iter().chain(&more)).json();
        let gained = told["gained"][0].as_f64().unwrap();
        // A compressed run is off by its tolerance.
        assert!((gained - most).abs() < if kind == "mtsm" { 0.02 } else { 1e-6 }, "{told}");
        let mean = told["gained"][1].as_f64().unwrap();
        assert!(0.0 < mean && mean < gained, "{told}");
        let note = told["notes"][0].as_str().unwrap();
        assert!(note.contains(&format!("up to {gained:.4} of the light is too much")), "{note}");

        let stated = &run!("inspect", map, "--json").json()[key];
        assert_eq!((&stated["pixels"], &stated["max"]), (&told["cut_pixels"], &told["gained"][0]));
        assert!(run!("verify", map).stdout().contains(note), "{note}");
        assert_eq!(run!("verify", map, "--json").json()["files"][0]["notes"][0], note);
        let render = |more: &[&str]| {
            let base = ["render", scene.to_str().unwrap(), "-o", picture.to_str().unwrap()];
            let map = ["--method", "trace", "--map", map.to_str().unwrap()];
            run::run(base.iter().chain(&map).chain(more)).stdout()
        };
        assert!(render(&[]).contains(note), "{note}");
        let document: Value = serde_json::from_str(&render(&["--json"])).unwrap();
        assert_eq!(document["notes"][0], note);

        // What is stated is what comes through too much.
        if kind != "fragments" {
            let found: f64 =
                run!("lookup", map, "--points", point).stdout()[2..].trim().parse().unwrap();
            assert!((found - 0.5_f64.powi(8) - gained).abs() < 0.02, "{kind}: {found} {gained}");
        }

        let whole = run::run(base.iter().chain(&["--resolution", "32", "--json"])).json();
        assert_eq!((&whole["cut_pixels"], &whole["gained"][0]), (&0.into(), &0.0.into()));
        assert!(run!("inspect", map, "--json").json().get(key).is_none());
        assert_eq!(
            run!("verify", map, "--json").json()["files"][0]["notes"],
            serde_json::json!([])
        );
    }
}
